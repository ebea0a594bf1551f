//! Quantities of the deformed skin: brought up to date for what each frame changes, never for all of it.

use crate::deform::Displacement;
use crate::deform::strain::Strain;
use crate::surface::Surface;

/// A quantity that follows the deformation.
pub trait PerFrame: Send {
    /// Follows one update of `displacement` at the cost of what that touched.
    fn follow(&mut self, surface: &Surface, displacement: &Displacement);

    /// Calls `each` with every vertex whose value may have changed in the last update; right after it was made, with every
    /// one whose value is not 0.
    fn changed(&self, displacement: &Displacement, each: &mut dyn FnMut(u32));

    /// The value at a vertex.
    fn value(&self, displacement: &Displacement, vertex: u32) -> f64;

    /// The strain, if it is that: a model may bring it along while it deforms.
    fn strain(&mut self) -> Option<&mut Strain> {
        None
    }

    /// Memory held beside the displacement, bytes.
    fn bytes(&self) -> usize {
        0
    }
}

/// Length of the offset from rest, mm.
pub fn displacement(_surface: &Surface, _displacement: &Displacement) -> Box<dyn PerFrame> {
    Box::new(Offset::default())
}

#[derive(Default)]
struct Offset {
    followed: bool,
}

impl PerFrame for Offset {
    fn follow(&mut self, _surface: &Surface, _displacement: &Displacement) {
        self.followed = true;
    }

    fn changed(&self, displacement: &Displacement, each: &mut dyn FnMut(u32)) {
        if self.followed {
            displacement.touched().for_each(each);
        } else {
            displacement.moved().for_each(each);
        }
    }

    fn value(&self, displacement: &Displacement, vertex: u32) -> f64 {
        displacement.offset_mm(vertex).length()
    }
}

/// Strain in per cent: the mean over the edges at a vertex of their change in length (Ji 2008, eqs. 4.19, 4.20).
pub fn strain(surface: &Surface, displacement: &Displacement) -> Box<dyn PerFrame> {
    Box::new(Strain::new(surface, displacement))
}

impl PerFrame for Strain {
    fn follow(&mut self, surface: &Surface, displacement: &Displacement) {
        self.update(surface, displacement);
    }

    fn changed(&self, _displacement: &Displacement, each: &mut dyn FnMut(u32)) {
        self.touched().for_each(each);
    }

    fn value(&self, _displacement: &Displacement, vertex: u32) -> f64 {
        self.values()
            .get(vertex as usize)
            .map_or(0.0, |strain| 100.0 * strain)
    }

    fn strain(&mut self) -> Option<&mut Strain> {
        Some(self)
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }
}
