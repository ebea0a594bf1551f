//! How the drawn skin moves under the fingers. Never felt: forces come from the static surface (Ji 2008, 2.3).
//!
//! A [`Model`] turns presses into a [`Displacement`] of the vertices from rest. Its parts each answer one question and know
//! nothing of the others: [`footprint`] how far out a point lies (the ratio q), [`curve`] how much is left there (M(q)),
//! [`RingSearch`] which vertices hang together with the finger.

pub mod footprint;
pub mod models;
mod patches;
mod ring;
mod shading;

use crate::contact::{Contact, Touch};
use crate::geom::Vec3;
use crate::surface::Surface;

pub use crate::geom::curve;
pub use patches::Patches;
pub use ring::RingSearch;

/// One finger's press on the skin, as every deformation model sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Press {
    /// Centre of the dent: where friction holds the skin, mm (METHOD's A).
    pub anchor_mm: Vec3,
    /// The HIP's foot on the tangent plane, mm (METHOD's P). `foot − anchor` is the tangential pull.
    pub foot_mm: Vec3,
    /// Outward unit normal at the anchor.
    pub normal: Vec3,
    /// Penetration depth, mm, ≥ 0.
    pub depth_mm: f64,
    /// Triangle under the anchor: where the ring search starts.
    pub triangle: u32,
}

impl Press {
    /// The press of one finger, a pad where `pad_mm` is its radius, or `None` when it does not touch. Under a pad the
    /// skin lands at its underside.
    pub fn of(contact: &Contact, pad_mm: Option<f64>) -> Option<Self> {
        let down = contact.normal * -pad_mm.unwrap_or(0.0);
        (contact.touch != Touch::Free && contact.depth_mm > 0.0).then_some(Self {
            anchor_mm: contact.anchor_mm + down,
            foot_mm: contact.foot_mm + down,
            normal: contact.normal,
            depth_mm: contact.depth_mm,
            triangle: contact.triangle,
        })
    }
}

/// The drawn skin's offset from the rest surface.
///
/// `moved` lists the vertices with a non-zero offset; `touched` those whose position or normal changed since the last
/// update, that is all that must be drawn anew.
#[derive(Clone, Debug, Default)]
pub struct Displacement {
    /// Offset of every vertex from rest, mm.
    pub offsets_mm: Vec<Vec3>,
    /// Unit normal of every vertex of the deformed surface.
    pub normals: Vec<Vec3>,
    /// Vertices with a non-zero offset, in no particular order but the same one every time.
    pub moved: Vec<u32>,
    /// Vertices whose offset or normal changed in the last update.
    pub touched: Vec<u32>,
}

impl Displacement {
    /// The surface at rest.
    pub fn at_rest(surface: &Surface) -> Self {
        Self {
            offsets_mm: vec![Vec3::ZERO; surface.positions().len()],
            normals: surface.normals().to_vec(),
            moved: Vec::new(),
            touched: Vec::new(),
        }
    }

    /// Position of a vertex of the deformed surface, mm.
    pub fn position(&self, surface: &Surface, vertex: u32) -> Vec3 {
        surface.positions()[vertex as usize] + self.offsets_mm[vertex as usize]
    }

    /// Where a point of the rest surface on triangle `t`, mm, has gone on the deformed one: the place to draw a finger at,
    /// given the triangle and anchor of its contact.
    ///
    /// The point is first brought to the closest point of the triangle. A triangle that does not exist, or a point that is
    /// not finite, gives the point back.
    pub fn carried_point(&self, surface: &Surface, t: u32, point_mm: Vec3) -> Vec3 {
        if (t as usize) < surface.triangles().len() && point_mm.is_finite() {
            let at = surface.triangle(t).closest_point(point_mm);
            self.carried(surface, t, at.barycentric)
        } else {
            point_mm
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        24 * (self.offsets_mm.capacity() + self.normals.capacity())
            + 4 * (self.moved.capacity() + self.touched.capacity())
    }

    /// A point of triangle `t` carried along with the deformed surface, mm; `barycentric` weighs its corners.
    pub fn carried(&self, surface: &Surface, t: u32, barycentric: [f64; 3]) -> Vec3 {
        let corners = surface.triangles()[t as usize];
        (0..3)
            .map(|i| self.position(surface, corners[i]) * barycentric[i])
            .sum()
    }
}

/// A deformation model: from presses to offsets.
pub trait Model: Send {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// Builds what the model keeps about a surface, so that the first update on it is as fast as the others. Optional.
    fn prepare(&mut self, _surface: &Surface) {}

    /// Brings `out` from whatever it held after the last call to the shape under `presses`.
    ///
    /// `out` must have been made for `surface` and only ever changed by this model. Offsets and normals are finite
    /// whatever the presses hold; a press that is not finite is left out.
    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement);
}

/// A model's name and how it is made with its defaults.
pub type Named = (&'static str, fn() -> Box<dyn Model>);

/// Every model, by name.
pub fn all() -> &'static [Named] {
    &[("fsmd", || {
        Box::new(models::fsmd::Fsmd::new(models::fsmd::Settings::default()))
    })]
}
