//! Scenarios: what a scene is made of, and what of it must be built.
//!
//! A scenario is a TOML file ([`file`]); [`needs`] derives which parts a scene requires; [`build`] makes exactly those.

mod build;
mod file;
mod library;
mod needs;

pub use build::{BuildError, Scene, build};
pub use file::{Scenario, ScenarioError, SurfaceChoice};
pub use library::{Example, default_example, examples};
pub use needs::{Item, Ledger, LedgerRow, Needs, Use};
