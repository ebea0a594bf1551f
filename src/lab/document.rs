//! All that one run of the lab found, and its files.

use super::{Drawing, Report};
use crate::figure::{self, write_files};
use serde::{Deserialize, Serialize};
use std::io::{Error, Result};
use std::path::{Path, PathBuf};

/// What one run found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// Version of the program.
    pub dorsum: String,
    /// Where it ran: what the times are worth.
    pub machine: Machine,
    /// Whether it was a quick look.
    pub quick: bool,
    /// Whether all holds that must.
    pub holds: bool,
    /// One for each experiment.
    pub experiments: Vec<Report>,
}

impl Document {
    /// With this machine and this program filled in.
    pub fn new(quick: bool, experiments: Vec<Report>) -> Self {
        Self {
            dorsum: env!("CARGO_PKG_VERSION").to_owned(),
            machine: Machine::here(),
            quick,
            holds: experiments.iter().all(Report::holds),
            experiments,
        }
    }
}

/// Where times were measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the processor, where the system tells it.
    pub processor: Option<String>,
    /// Threads that can run at once.
    pub threads: usize,
    /// Operating system and processor family.
    pub system: String,
    /// Whether the program was built for speed: times of one that was not are worth little.
    pub optimised: bool,
}

impl Machine {
    /// The machine at hand.
    pub fn here() -> Self {
        let processor = std::fs::read_to_string("/proc/cpuinfo")
            .ok()
            .and_then(|text| {
                let line = text.lines().find(|l| l.starts_with("model name"))?;
                Some(line.split_once(':')?.1.trim().to_owned())
            });
        Self {
            processor,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            optimised: !cfg!(debug_assertions),
        }
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let processor = self.processor.as_deref().unwrap_or("unknown processor");
        let slow = if self.optimised {
            ""
        } else {
            ", built without optimisation: times are worth little"
        };
        write!(
            f,
            "{processor}, {} threads, {}{slow}",
            self.threads, self.system
        )
    }
}

/// Writes a document into `folder`, which must exist, and tells which files: `name.json` with everything, `name.txt` for
/// reading, `EXPERIMENT.TABLE.csv` and `EXPERIMENT.FIGURE.svg`. All are written beside their places before the first is
/// put there, so that a fault on the way leaves what was there before.
///
/// # Errors
/// Those of the file system.
pub fn write(document: &Document, name: &str, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let json = serde_json::to_vec_pretty(document).map_err(Error::other)?;
    files.push((folder.join(format!("{name}.json")), json));
    let mut text = format!("Measured on {}\n", document.machine);
    for report in &document.experiments {
        text += &format!("\n\n{report}\n");
        let path =
            |part: &str, ending| folder.join(format!("{}.{part}.{ending}", report.experiment));
        for table in &report.tables {
            files.push((path(&table.name, "csv"), table.csv()?));
        }
        for drawing in &report.figures {
            let svg = match &drawing.drawing {
                Drawing::Plots(plots) => figure::plot::svg(plots)?,
                Drawing::Map(map) => figure::cells::svg(map)?,
            };
            files.push((path(&drawing.name, "svg"), svg.into_bytes()));
        }
    }
    files.push((folder.join(format!("{name}.txt")), text.into_bytes()));
    write_files(&files)?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}
