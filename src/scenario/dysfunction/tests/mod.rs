//! Dysfunctions through the file and back, their faults, and what they make of the maps.

mod faults;
mod kinds;
mod round_trip;
mod sites;

use super::*;
use crate::scenario::Scenario;

const HEAD: &str = "# A comment on top.\nformat = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\n\
                    [stiffness]\nconstant_n_per_mm = 0.5\n[friction]\nstatic = 0.46\ndynamic = 0.44\n";

fn parse(tables: &str) -> Result<Scenario, crate::scenario::ScenarioError> {
    Scenario::parse(&format!("{HEAD}{tables}"), "a.toml", None)
}

fn site(text: &str) -> Site {
    sites(text).expect(text)[0]
}
