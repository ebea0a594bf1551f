//! All that one run of the lab found, and its files.

use super::{Report, Setup, build, html};
use crate::figure::write_files;
use serde::{Deserialize, Serialize};
use std::io::{Error, Result};
use std::path::{Path, PathBuf};

/// What one run found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Document {
    /// Version of the program.
    pub dorsum: String,
    /// First digits of the SHA-256 of the program; nothing where it could not be read.
    #[serde(default)]
    pub build: Option<String>,
    /// Where it ran: what the times are worth.
    pub machine: Machine,
    /// Whether it was a quick look.
    pub quick: bool,
    /// Where chance started.
    #[serde(default)]
    pub seed: u64,
    /// Whether all holds that must.
    pub holds: bool,
    /// One for each experiment.
    pub experiments: Vec<Report>,
}

impl Document {
    /// With this machine and this program filled in.
    pub fn new(setup: &Setup, experiments: Vec<Report>) -> Self {
        Self {
            dorsum: env!("CARGO_PKG_VERSION").to_owned(),
            build: build().map(str::to_owned),
            machine: Machine::here(),
            quick: setup.quick,
            seed: setup.seed,
            holds: experiments.iter().all(Report::holds),
            experiments,
        }
    }

    /// By which program, from which seed and on which machine, in two lines.
    pub fn origin(&self) -> String {
        format!("{}\nMeasured on {}", self.program(), self.machine)
    }

    /// The same in one line, to stand below a figure.
    pub fn caption(&self) -> String {
        format!("{}; {}", self.program(), self.machine)
    }

    fn program(&self) -> String {
        let build = self.build.as_deref().unwrap_or("unknown");
        let quick = if self.quick { ", quick look" } else { "" };
        format!(
            "Dorsum {}, build {build}, seed {}{quick}",
            self.dorsum, self.seed
        )
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

/// Writes a document into `folder`, which must exist, and tells which files: `name.html` and `name.txt` for reading,
/// `name.json` with everything, `EXPERIMENT.TABLE.csv` and `EXPERIMENT.FIGURE.svg`. All are written beside their places before the first is
/// put there, so that a fault on the way leaves what was there before.
///
/// # Errors
/// Those of the file system.
pub fn write(document: &Document, name: &str, folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let json = serde_json::to_vec_pretty(document).map_err(Error::other)?;
    files.push((folder.join(format!("{name}.json")), json));
    let page = html::page(document, name)?;
    files.push((folder.join(format!("{name}.html")), page.into_bytes()));
    let caption = document.caption();
    let mut text = format!("{}\n", document.origin());
    for report in &document.experiments {
        text += &format!("\n\n{report}\n");
        let path =
            |part: &str, ending| folder.join(format!("{}.{part}.{ending}", report.experiment));
        for table in &report.tables {
            files.push((path(&table.name, "csv"), table.csv()?));
        }
        for drawing in &report.figures {
            let svg = drawing.drawing.svg(&caption)?;
            files.push((path(&drawing.name, "svg"), svg.into_bytes()));
        }
    }
    files.push((folder.join(format!("{name}.txt")), text.into_bytes()));
    write_files(&files)?;
    Ok(files.into_iter().map(|(path, _)| path).collect())
}
