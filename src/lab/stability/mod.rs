//! Where loops of hand, device and skin stay at rest, and what numbers at the edge do.
//!
//! | file | answers |
//! |---|---|
//! | [`plant`] | how a hand that holds a device moves |
//! | [`theory`] | how stiff a wall may be, says theory |

pub mod plant;
pub mod theory;
