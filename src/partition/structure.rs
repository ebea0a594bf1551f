//! One structure of any kind, chosen by name, with what only some kinds can tell.

use super::brute::Brute;
use super::bsp::Bsp;
use super::bvh::Bvh;
use super::hdb::{Gathered, Query};
use super::hybrid::Hybrid;
use super::octree::Octree;
use super::tree::{Options, Statistics, Tree};
use super::{Partition, all};
use crate::geom::Aabb;
use crate::surface::Surface;

/// One structure of those in [`all`], of a kind that is known only at run time.
#[derive(Clone, Debug)]
pub enum Structure {
    /// No structure: every triangle is asked.
    Brute(Brute),
    /// The production structure.
    Bvh(Bvh),
    /// The published binary space partition.
    Bsp(Bsp),
    /// The published octree.
    Octree(Octree),
    /// The octree over one list.
    Hybrid(Hybrid),
}

/// Names of the structures that are trees of cells: they have a threshold, statistics and a published query.
pub const TREES: [&str; 3] = ["bsp", "octree", "hybrid"];

impl Structure {
    /// Builds the structure called `kind`; of the options `brute` and `bvh` heed none, octrees only the threshold.
    /// `progress` hears the share done, 0…1; when it answers `false` there is no structure.
    ///
    /// # Errors
    /// `kind` is none of [`all`].
    pub fn build(
        kind: &str,
        surface: &Surface,
        options: &Options,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<Self>, UnknownKind> {
        Ok(match kind {
            "brute" => Some(Self::Brute(Brute)),
            "bvh" => Some(Self::Bvh(Bvh::new(surface))),
            "bsp" => Bsp::with_progress(surface, options, progress).map(Self::Bsp),
            "octree" => Octree::with_progress(surface, options, progress).map(Self::Octree),
            "hybrid" => Hybrid::with_progress(surface, options, progress).map(Self::Hybrid),
            _ => return Err(UnknownKind(kind.to_owned())),
        })
    }

    /// What every structure answers.
    pub fn partition(&self) -> &dyn Partition {
        match self {
            Self::Brute(p) => p,
            Self::Bvh(p) => p,
            Self::Bsp(p) => p,
            Self::Octree(p) => p,
            Self::Hybrid(p) => p,
        }
    }

    /// The nodes, where it is a tree of cells.
    pub fn tree(&self) -> Option<&Tree> {
        match self {
            Self::Brute(_) | Self::Bvh(_) => None,
            Self::Bsp(p) => Some(p.tree()),
            Self::Octree(p) => Some(p.tree()),
            Self::Hybrid(p) => Some(p.tree()),
        }
    }

    /// Counts over the tree, where there is one.
    pub fn statistics(&self, surface: &Surface) -> Option<Statistics> {
        match self {
            Self::Brute(_) | Self::Bvh(_) => None,
            Self::Bsp(p) => Some(p.statistics(surface)),
            Self::Octree(p) => Some(p.statistics(surface)),
            Self::Hybrid(p) => Some(p.statistics(surface)),
        }
    }

    /// The complete query: appends every triangle whose box overlaps `region`, in rising order. Nodes are counted where
    /// there is a tree of cells.
    pub fn gather(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) -> Option<Gathered> {
        match self.tree() {
            Some(tree) => Some(tree.gather(surface, region, out)),
            None => {
                self.partition().in_box(surface, region, out);
                None
            }
        }
    }

    /// The published query (half-spaces for a BSP, cells for octrees): appends, in rising order, all that the leaves it
    /// finds list. `None`, and nothing appended, where there is no tree of cells.
    pub fn gather_as_published(&self, region: &Aabb, out: &mut Vec<u32>) -> Option<Gathered> {
        match self {
            Self::Brute(_) | Self::Bvh(_) => None,
            Self::Bsp(p) => Some(p.gather_by_half_spaces(region, out)),
            Self::Octree(p) => Some(p.gather_by_cells(region, out)),
            Self::Hybrid(p) => Some(p.gather_by_cells(region, out)),
        }
    }

    /// Names the triangles that `query` finds for `region`, in no order and as often as leaves list them, and tells the
    /// cost. Allocates nothing. Structures that are no trees of cells ask every triangle.
    pub fn each(
        &self,
        surface: &Surface,
        region: &Aabb,
        query: Query,
        mut name: impl FnMut(u32),
    ) -> Gathered {
        match (self, query) {
            (Self::Bsp(p), Query::Published) => p.each_by_half_spaces(region, name),
            (Self::Octree(p), Query::Published) => p.tree().each_by_cells(region, name),
            (Self::Hybrid(p), Query::Published) => p.tree().each_by_cells(region, name),
            (Self::Bsp(p), Query::Complete) => p.tree().each_in(surface, region, name),
            (Self::Octree(p), Query::Complete) => p.tree().each_in(surface, region, name),
            (Self::Hybrid(p), Query::Complete) => p.tree().each_in(surface, region, name),
            (Self::Brute(_) | Self::Bvh(_), _) => {
                let all = 0..surface.triangles().len() as u32;
                let mut named = 0;
                for t in all.filter(|&t| {
                    query == Query::Published || surface.triangle(t).aabb().overlaps(region)
                }) {
                    name(t);
                    named += 1;
                }
                Gathered {
                    triangles: named,
                    ..Gathered::default()
                }
            }
        }
    }
}

/// No structure has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no structure is called \"{0}\"; allowed are {allowed}", allowed = names().join(", "))]
pub struct UnknownKind(pub String);

fn names() -> Vec<&'static str> {
    all().iter().map(|(name, _)| *name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::primitives::bench_patch;

    #[test]
    fn every_listed_structure_can_be_built_by_name_and_gathers_alike() {
        let surface = Surface::new(bench_patch(600)).unwrap().0;
        let region = Aabb::cube(surface.bounds().centre(), 150.0);
        let options = Options {
            threshold: 16,
            ..Options::default()
        };
        let mut expected = Vec::new();
        Brute.in_box(&surface, &region, &mut expected);
        assert!(expected.len() > 20);
        for name in names() {
            let built = Structure::build(name, &surface, &options, &mut |_| true);
            let built = built.unwrap().unwrap();
            assert_eq!(built.partition().name(), name);
            let mut found = Vec::new();
            let cost = built.gather(&surface, &region, &mut found);
            assert_eq!(found, expected, "{name}");
            let is_tree = TREES.contains(&name);
            assert_eq!(cost.is_some(), is_tree);
            assert_eq!(built.tree().is_some(), is_tree);
            assert_eq!(built.statistics(&surface).is_some(), is_tree);
            let published = built.gather_as_published(&region, &mut found);
            assert_eq!(published.is_some(), is_tree);
        }
        let unknown = Structure::build("kd", &surface, &options, &mut |_| true).unwrap_err();
        assert!(unknown.to_string().contains("brute, bvh, bsp"), "{unknown}");
    }
}
