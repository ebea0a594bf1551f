//! Contact engines: where they put the proxy on surfaces that break them, and what that costs.

mod torture;
mod trial;

pub use torture::Torture;
pub use trial::{
    ENGINES, Energy, Engine, Findings, PLACES, Place, SPEEDS_M_PER_S, Trial, closed_path_energy,
};
