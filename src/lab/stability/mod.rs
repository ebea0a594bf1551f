//! Where loops of hand, device and skin stay at rest, and what numbers at the edge do.
//!
//! | file | answers |
//! |---|---|
//! | [`border`] | how stiff a skin may be, beside both theories: maps and tables |
//! | [`closed_loop`] | whether the loop with the real tick comes to rest |
//! | [`controller`] | what the passivity controller does to it |
//! | [`devices`] | which devices are held against the limits |
//! | [`extremes`] | what extreme cases do at every public door |
//! | [`integrators`] | how long a step each integrator bears |
//! | [`plant`] | how a hand that holds a device moves |
//! | [`search`] | where, going up in stiffness, a loop no longer rests |
//! | [`theory`] | how stiff a skin may be, says theory |

pub mod border;
pub mod closed_loop;
pub mod controller;
pub mod devices;
pub mod extremes;
pub mod integrators;
pub mod plant;
pub mod search;
pub mod theory;

pub use border::StabilityBorder;
pub use controller::StabilityController;
pub use extremes::Extremes;
pub use integrators::Integrators;
