//! Finite elements: a slab of soft tissue bonded to rigid bone, under the skin of the back or flat.
//!
//! | file | holds |
//! |---|---|
//! | [`hex`] | one element: the trilinear brick with averaged dilatation |
//! | [`mesh`] | the slab cut into bricks |
//! | [`linear`] | small strains: assemble, factor once, solve for any load |
//! | [`compliance`] | the slab condensed to its skin: a press at the price of a few columns |
//! | [`corotated`] | large strains: bricks that turn |

pub mod compliance;
pub mod corotated;
pub mod hex;
pub mod linear;
pub mod mesh;

pub use compliance::Compliance;
pub use corotated::Corotated;
pub use linear::{Fixed, Linear};
pub use mesh::{Slab, SlabError, graded};
