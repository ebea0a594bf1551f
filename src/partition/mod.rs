//! Search structures over a surface: which triangle is nearest, which does a motion cross, which lie in a box.
//!
//! All structures answer the same trait; [`brute`] is the yardstick the others are tested against.

pub mod brute;
pub mod bsp;
pub mod bvh;
pub mod hdb;
pub mod hybrid;
pub mod octree;
pub mod structure;
pub mod tree;

use crate::geom::{Aabb, Vec3};
use crate::surface::Surface;

pub use structure::Structure;

/// The closest point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Triangle that holds it. Of several at one distance, the lowest index.
    pub triangle: u32,
    /// The point, mm.
    pub point: Vec3,
    /// Squared distance from the query, mm².
    pub distance_sq: f64,
}

/// Where a motion first crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Triangle crossed. Of several at one fraction, the lowest index.
    pub triangle: u32,
    /// Fraction of the motion, 0…1.
    pub t: f64,
    /// The point, mm.
    pub point: Vec3,
    /// Whether the motion goes from outside to inside.
    pub inward: bool,
}

/// Which crossings stop a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// Only from outside to inside: what comes up from below passes.
    #[default]
    Front,
    /// Both.
    Both,
}

impl Sides {
    /// Every choice.
    pub fn all() -> &'static [Self] {
        &[Self::Front, Self::Both]
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Both => "both",
        }
    }
}

/// One search structure over one surface. The surface is passed to each query and must be the one it was built from.
pub trait Partition: Send + Sync {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// The closest point within `max_mm` of `p`; `None` when there is none or `p` is not finite.
    fn nearest(&self, surface: &Surface, p: Vec3, max_mm: f64) -> Option<Nearest>;

    /// The first crossing of the segment from `from` to `to`; `None` when there is none or an end is not finite.
    fn sweep(&self, surface: &Surface, from: Vec3, to: Vec3, sides: Sides) -> Option<Hit>;

    /// Appends to `out` every triangle whose box overlaps `region`, in rising order. Triangles may be listed that only
    /// come near it; none that intersects it is left out.
    fn in_box(&self, surface: &Surface, region: &Aabb, out: &mut Vec<u32>);

    /// Memory held, bytes.
    fn bytes(&self) -> usize;

    /// Whether the structure is well formed; says what is wrong where it is not.
    ///
    /// # Errors
    /// The first fault found, in words.
    fn validate(&self, surface: &Surface) -> Result<(), String>;
}

/// Builds one structure over a surface.
pub type Builder = fn(&Surface) -> Box<dyn Partition>;

/// Every structure, by name, with its builder.
pub fn all() -> &'static [(&'static str, Builder)] {
    &[
        ("brute", |_| Box::new(brute::Brute)),
        ("bvh", |surface| Box::new(bvh::Bvh::new(surface))),
        ("bsp", |surface| {
            Box::new(bsp::Bsp::new(surface, &Default::default()))
        }),
        ("octree", |surface| {
            Box::new(octree::Octree::new(surface, &Default::default()))
        }),
        ("hybrid", |surface| {
            Box::new(hybrid::Hybrid::new(surface, &Default::default()))
        }),
    ]
}
