//! How the drawn skin moves under the fingers. Never felt: forces come from the static surface (Ji 2008, 2.3).
//!
//! A [`Model`] turns presses into a [`Displacement`] of the vertices from rest. Its parts each answer one question and know
//! nothing of the others: [`footprint`] how far out a point lies (the ratio q), [`curve`] how much is left there (M(q)),
//! [`RingSearch`] which vertices hang together with the finger, [`strain`] how far the skin is drawn out. What they do for
//! many vertices they do for [`Patches`] of 64. A model that has a field of its own puts it on the skin by [`Spread`].

mod blocks;
pub mod bones;
mod displacement;
pub mod footprint;
mod marks;
pub mod models;
mod nearby;
mod pairs;
mod patches;
mod ring;
mod shading;
mod spread;
pub mod strain;

use crate::contact::{Contact, Touch};
use crate::geom::Vec3;
use crate::maps::{EllipseField, EllipseMap, Oval};
use crate::surface::Surface;
use std::sync::Arc;
use strain::Strain;

pub use crate::geom::curve;
pub use displacement::Displacement;
pub use patches::Patches;
pub use ring::RingSearch;
pub use spread::Spread;

/// One finger's press on the skin, as every deformation model sees it.
#[derive(Clone, Debug, Default, PartialEq)]
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
    /// The ellipse that a map has here; else the model's own.
    pub oval: Option<Oval>,
    /// The irregular boundary that a map has here: radii, mm on the skin, at equal angles from the map's x direction,
    /// counter-clockwise.
    pub boundary_mm: Option<Arc<[f64]>>,
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
            oval: None,
            boundary_mm: None,
        })
    }

    /// The same press with the ellipse, and the irregular boundary where there is one, that a map has at its anchor.
    /// `field` is the map at the vertices of `surface`.
    pub fn on_map(self, surface: &Surface, map: &EllipseMap, field: &EllipseField) -> Self {
        if self.triangle as usize >= surface.triangles().len() || !self.anchor_mm.is_finite() {
            return self;
        }
        let at = surface
            .triangle(self.triangle)
            .closest_point(self.anchor_mm);
        Self {
            oval: Some(field.at(surface, self.triangle, at.barycentric)),
            boundary_mm: map.boundary_at(at.point.truncate()).map(Arc::from),
            ..self
        }
    }
}

/// A deformation model: from presses to offsets.
pub trait Model: Send {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// Memory held beside the displacement, bytes; 0 for a model that does not tell.
    fn bytes(&self) -> usize {
        0
    }

    /// Builds what the model keeps about a surface, so that the first update on it is as fast as the others. Optional.
    fn prepare(&mut self, _surface: &Surface) {}

    /// Brings `out` from whatever it held after the last call to the shape under `presses`.
    ///
    /// `out` must have been made for `surface` and only ever changed by this model. Offsets and normals are finite
    /// whatever the presses hold; a press that is not finite is left out.
    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement);

    /// The same, and brings `strain` from the shape before to the new one; a model may do so in the same pass.
    fn update_strained(
        &mut self,
        surface: &Surface,
        presses: &[Press],
        out: &mut Displacement,
        strain: &mut Strain,
    ) {
        self.update(surface, presses, out);
        strain.update(surface, out);
    }
}

/// A model's name and how it is made with its defaults.
pub type Named = (&'static str, fn() -> Box<dyn Model>);

/// Every model, by name.
pub fn all() -> &'static [Named] {
    &[("fsmd", || {
        Box::new(models::fsmd::Fsmd::new(models::fsmd::Settings::default()))
    })]
}
