//! What a published pass is made of: a structure and a box.

use crate::geom::{Aabb, Vec3};
use crate::partition::hdb::{EDGE_PART, Gathered, Query};
use crate::partition::structure::{Structure, UnknownKind};
use crate::partition::tree;
use crate::surface::Surface;
use std::fmt;

/// Structures that a pass can gather with, by name.
pub const KINDS: [&str; 4] = ["brute", "bsp", "octree", "hybrid"];

/// Choices of a published pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The structure, one of [`KINDS`]. `brute` is no structure: every triangle is asked.
    pub partition: &'static str,
    /// How it is grown.
    pub tree: tree::Options,
    /// Edge of the haptic detecting box over the longest edge of the surface's box.
    pub hdb_part: f64,
    /// Which triangles it gathers.
    pub query: Query,
}

impl Default for Options {
    /// The published choice.
    fn default() -> Self {
        Self {
            partition: "octree",
            tree: tree::Options::default(),
            hdb_part: EDGE_PART,
            query: Query::Published,
        }
    }
}

/// The choices, for people.
impl fmt::Display for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.partition)?;
        if self.partition == "bsp" {
            write!(f, ", case {:?}", self.tree.case)?;
        }
        if self.partition != "brute" {
            write!(f, ", threshold {}", self.tree.threshold)?;
        }
        if self.partition != "brute" || self.query == Query::Complete {
            write!(f, ", box {} of the surface", self.hdb_part)?;
        }
        match self.query {
            Query::Published => Ok(()),
            Query::Complete => f.write_str(", complete query"),
        }
    }
}

/// The structure over one surface, and the box. Immutable while in use.
#[derive(Clone, Debug)]
pub struct Published {
    structure: Structure,
    options: Options,
    edge_mm: f64,
}

impl Published {
    /// Builds the structure. `progress` hears the share done, 0…1; when it answers `false` there is none.
    ///
    /// # Errors
    /// There is no structure of the name in `options`.
    pub fn build(
        surface: &Surface,
        options: &Options,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Option<Self>, UnknownKind> {
        let built = Structure::build(options.partition, surface, &options.tree, progress)?;
        Ok(built.map(|structure| Self::of(structure, surface, options)))
    }

    /// A pass with a structure that was built before; `options` says what of.
    pub fn of(structure: Structure, surface: &Surface, options: &Options) -> Self {
        Self {
            structure,
            options: *options,
            edge_mm: surface.bounds().size().max_element() * options.hdb_part,
        }
    }

    /// What it was built from.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The structure.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// The haptic detecting box about a proxy, mm.
    pub fn region(&self, proxy_mm: Vec3) -> Aabb {
        Aabb::cube(proxy_mm, self.edge_mm)
    }

    /// Appends the triangles gathered for `region`, in rising order.
    pub fn gather(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>) -> Gathered {
        let query = self.options.query;
        tree::in_rising_order(out, |out| {
            (self.structure).each(surface, region, query, |t| out.push(t))
        })
    }

    /// Names them in no order, as often as leaves list them. Allocates nothing.
    pub(super) fn each(&self, surface: &Surface, region: &Aabb, name: impl FnMut(u32)) -> Gathered {
        (self.structure).each(surface, region, self.options.query, name)
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.structure.partition().bytes()
    }
}
