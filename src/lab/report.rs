//! What an experiment answers.

use super::Table;
use crate::figure::{self, CellMap, LinePlot, Series};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Tables, plots and what they say.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Name of the experiment; filled in by [`run`](super::run).
    pub experiment: String,
    /// What it answers; filled in by [`run`](super::run).
    pub about: String,
    /// When it was made, UTC, ISO 8601; filled in by [`run`](super::run).
    #[serde(default)]
    pub measured: String,
    /// Under which circumstances.
    pub settings: Vec<Setting>,
    /// The figures.
    pub tables: Vec<Table>,
    /// The plots.
    pub figures: Vec<Figure>,
    /// What holds and what does not.
    pub verdicts: Vec<Verdict>,
    /// What a reader should know, a sentence or two each.
    pub notes: Vec<String>,
}

impl Report {
    /// Adds a circumstance.
    pub fn set(&mut self, name: &str, value: impl fmt::Display) {
        self.settings.push(Setting {
            name: name.to_owned(),
            value: value.to_string(),
        });
    }

    /// Adds a remark.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Adds plots that are drawn one above the other. Points that are not finite are left out.
    pub fn draw(&mut self, name: &str, mut plots: Vec<LinePlot>) {
        let series = plots.iter_mut().flat_map(|p| &mut p.series);
        series.for_each(keep_finite);
        self.figures.push(Figure {
            name: name.to_owned(),
            drawing: Drawing::Plots(plots),
        });
    }

    /// Adds a map of cells. Points of its curves that are not finite are left out.
    pub fn draw_map(&mut self, name: &str, mut map: CellMap) {
        map.series.iter_mut().for_each(keep_finite);
        self.figures.push(Figure {
            name: name.to_owned(),
            drawing: Drawing::Map(map),
        });
    }

    /// Whether all holds that must.
    pub fn holds(&self) -> bool {
        self.verdicts.iter().all(|v| v.holds || !v.required)
    }
}

fn keep_finite(series: &mut Series) {
    series.points.retain(|p| p.iter().all(|c| c.is_finite()));
}

/// One circumstance of an experiment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Setting {
    /// What.
    pub name: String,
    /// Its value, with its unit.
    pub value: String,
}

/// One drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Name in file names: lower case and hyphens.
    pub name: String,
    /// What is drawn. Not part of JSON: the tables hold the figures.
    #[serde(skip)]
    pub drawing: Drawing,
}

/// What a figure shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Drawing {
    /// Curves, from top to bottom, over a common x axis.
    Plots(Vec<LinePlot>),
    /// Cells of classes, with curves over them.
    Map(CellMap),
}

impl Drawing {
    /// As SVG, with `caption` below it.
    ///
    /// # Errors
    /// None that is known: those of the drawing library, which writes to memory here.
    pub fn svg(&self, caption: &str) -> std::io::Result<String> {
        match self {
            Self::Plots(plots) => figure::plot::svg(plots, caption),
            Self::Map(map) => figure::cells::svg(map, caption),
        }
    }
}

impl Default for Drawing {
    fn default() -> Self {
        Self::Plots(Vec::new())
    }
}

/// Whether something holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Verdict {
    /// What was asked.
    pub what: String,
    /// What was found, with its unit.
    pub measured: String,
    /// What was wanted, with its unit.
    pub goal: String,
    /// Whether the one meets the other.
    pub holds: bool,
    /// Whether the program is wrong where it does not: `false` for times and for what the publication gets wrong, which
    /// are told and no more.
    pub required: bool,
}

impl Verdict {
    /// Something that must hold on any machine.
    pub fn must(
        what: impl Into<String>,
        measured: impl fmt::Display,
        goal: impl fmt::Display,
        holds: bool,
    ) -> Self {
        Self {
            what: what.into(),
            measured: measured.to_string(),
            goal: goal.to_string(),
            holds,
            required: true,
        }
    }

    /// Something that is good to know: a goal for a time, or a claim of the publication.
    pub fn told(
        what: impl Into<String>,
        measured: impl fmt::Display,
        goal: impl fmt::Display,
        holds: bool,
    ) -> Self {
        Self {
            required: false,
            ..Self::must(what, measured, goal, holds)
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match (self.holds, self.required) {
            (true, _) => "holds",
            (false, true) => "DOES NOT HOLD",
            (false, false) => "does not hold",
        };
        write!(
            f,
            "{word}: {}: {} (goal: {})",
            self.what, self.measured, self.goal
        )
    }
}

impl fmt::Display for Report {
    /// For people: tables, verdicts and notes. Ends without a line break.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n{}", self.experiment, self.about)?;
        if !self.measured.is_empty() {
            writeln!(f, "  measured {}", self.measured)?;
        }
        let width = self
            .settings
            .iter()
            .map(|s| s.name.chars().count())
            .max()
            .unwrap_or(0);
        for s in &self.settings {
            writeln!(f, "  {:<width$}  {}", s.name, s.value)?;
        }
        for table in &self.tables {
            write!(f, "\n{}\n{table}", table.title)?;
        }
        if !self.verdicts.is_empty() {
            writeln!(f)?;
        }
        for verdict in &self.verdicts {
            writeln!(f, "{verdict}")?;
        }
        for note in &self.notes {
            write!(f, "\n{note}")?;
        }
        Ok(())
    }
}
