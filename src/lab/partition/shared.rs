//! What the experiments on partitions share: the surface, where to ask, structures and their colours.

use crate::geom::Vec3;
use crate::lab::{LabError, Report, Setup, Stopped, Watch};
use crate::partition::Structure;
use crate::partition::tree::{Case, Options};
use crate::surface::{Surface, back};
use std::sync::Arc;

/// Triangles of the model that tables 3.2 and B were measured on.
pub(super) const PRINTED_TRIANGLES: usize = 41_582;

/// A kind of tree with its choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind {
    /// Name in tables and legends.
    pub label: &'static str,
    /// Name of the structure.
    pub name: &'static str,
    /// What becomes of triangles on a plane.
    pub case: Case,
    /// sRGB colour in plots; none is a finger's.
    pub colour: [u8; 3],
}

/// No tree at all.
pub(super) const BRUTE: Kind = kind("brute", "brute", Case::C, [120, 124, 130]);
/// The production structure.
pub(super) const BVH: Kind = kind("bvh", "bvh", Case::C, [24, 26, 30]);
/// The published binary space partition as the publication chose it.
pub(super) const BSP: Kind = kind("bsp c", "bsp", Case::C, [214, 122, 0]);
/// The published octree.
pub(super) const OCTREE: Kind = kind("octree", "octree", Case::C, [0, 140, 104]);
/// The octree over one list.
pub(super) const HYBRID: Kind = kind("hybrid", "hybrid", Case::C, [136, 72, 168]);
/// Every tree of cells, every case.
pub(super) const TREES: [Kind; 5] = [
    kind("bsp a", "bsp", Case::A, [124, 84, 28]),
    kind("bsp b", "bsp", Case::B, [176, 150, 60]),
    BSP,
    OCTREE,
    HYBRID,
];

const fn kind(label: &'static str, name: &'static str, case: Case, colour: [u8; 3]) -> Kind {
    Kind {
        label,
        name,
        case,
        colour,
    }
}

impl Kind {
    /// Builds it over a surface.
    pub fn build(
        &self,
        surface: &Surface,
        threshold: usize,
        watch: &mut Watch<'_>,
        share: f64,
    ) -> Result<Structure, LabError> {
        let options = Options {
            threshold,
            case: self.case,
        };
        let what = format!("building {}", self.label);
        let mut going = |_: f64| watch.at(&what, share).is_ok();
        Structure::build(self.name, surface, &options, &mut going)
            .map_err(|e| LabError::Input(e.to_string()))?
            .ok_or_else(|| Stopped.into())
    }
}

/// The built-in back.
pub(super) fn back_of(triangles: usize) -> Result<Arc<Surface>, LabError> {
    let raw = back::make(&back::BackOptions::with_triangles(triangles));
    match Surface::new(raw) {
        Ok((surface, _)) => Ok(Arc::new(surface)),
        Err(e) => Err(LabError::Input(format!("the built-in back: {e}"))),
    }
}

/// The surface asked for, or the built-in back with as many triangles as in print; named in the report.
pub(super) fn surface(setup: &Setup, report: &mut Report) -> Result<Arc<Surface>, LabError> {
    let (name, surface) = match &setup.mesh {
        Some(mesh) => (mesh.name.as_str(), mesh.surface.clone()),
        None => ("built-in back", back_of(PRINTED_TRIANGLES)?),
    };
    let size = surface.bounds().size();
    report.set(
        "mesh",
        format_args!(
            "{name}, {} triangles, {:.0} × {:.0} × {:.0} mm",
            surface.triangles().len(),
            size.x,
            size.y,
            size.z
        ),
    );
    Ok(surface)
}

/// `n` places on the surface, mm, spread evenly over its triangles: where a proxy may rest.
pub(super) fn places(surface: &Surface, n: usize) -> Vec<Vec3> {
    let triangles = surface.triangles().len() as u64;
    // The fractions of multiples of the golden ratio fill an interval evenly, however many are taken.
    let step = 0x9e37_79b9_7f4a_7c15_u64;
    (1..=n as u64)
        .map(|i| {
            let share = u128::from(i.wrapping_mul(step));
            let t = (share * u128::from(triangles)) >> 64;
            surface.triangle(t as u32).centroid()
        })
        .collect()
}
