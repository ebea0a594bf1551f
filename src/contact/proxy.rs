//! The constraint-based proxy (Zilles & Salisbury 1995; Ruspini 1997).

use super::{Contact, ContactState, TouchScene};
use crate::geom::Vec3;

/// Moves the proxy of one finger after the HIP and returns what the finger feels.
///
/// A HIP that is not finite leaves the state as it was and feels nothing.
pub fn advance(_scene: &TouchScene, state: &mut ContactState, hip_mm: Vec3) -> Contact {
    if !hip_mm.is_finite() {
        return Contact {
            anchor_mm: state.proxy_mm,
            foot_mm: state.proxy_mm,
            ..Contact::default()
        };
    }
    state.proxy_mm = hip_mm;
    Contact {
        anchor_mm: hip_mm,
        foot_mm: hip_mm,
        ..Contact::default()
    }
}
