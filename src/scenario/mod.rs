//! Scenarios: what a scene is made of, and what of it must be built.
//!
//! A scenario is a TOML file ([`Scenario`]); [`Needs`] says which parts a scene requires; [`build`] makes exactly those and
//! keeps the [`Ledger`] of what was built and what was left out.

mod build;
mod check;
mod deformation;
pub mod dysfunction;
pub mod edit;
pub mod exercise;
mod feel;
mod felt;
mod file;
mod library;
mod maps;
mod measure;
mod needs;
mod stiffest;

pub use build::{BuildError, Scene, build, changes_surface, rebuild};
pub use deformation::{BonesChoice, CURVE_SAMPLES};
pub use dysfunction::{
    Change, Dysfunction, Kind, Patch, Place, RandomSpec, Side, Site, Target, Tender,
    VertebralLevel, random, sites,
};
pub use exercise::Exercise;
pub use file::{FORMAT, Scenario, ScenarioError, SurfaceChoice};
pub use library::{Example, default_example, examples};
pub use needs::{Item, Ledger, LedgerRow, Needs, Use, Verdict};
