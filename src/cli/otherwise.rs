//! A session felt otherwise than it was recorded: what `dorsum replay` is told of it, and what that comes to.

use super::common::progress_bar;
use super::{CliError, print};
use crate::session::{Divergence, Off, Otherwise, Session, SessionError, Strictness, diverge};
use crate::study::otherwise;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What is to be other.
#[derive(Debug, Default, clap::Args)]
pub struct OtherwiseArgs {
    /// Repeat it at this servo rate: positions and velocities between the recorded ticks are interpolated linearly.
    #[arg(long, value_name = "HZ", value_parser = rate_hz, conflicts_with = "check")]
    rate: Option<f64>,
    /// Repeat it with another contact engine: production, published, or a partition of the published one (brute, bsp, octree,
    /// hybrid).
    #[arg(long, value_name = "NAME", conflicts_with = "check")]
    engine: Option<String>,
    /// Repeat it with another force model, as [force] model names it, with its default settings.
    #[arg(long, value_name = "NAME", conflicts_with = "check")]
    force_model: Option<String>,
    /// Write how far each recorded tick is off into this table, and tell root mean squares and maxima.
    #[arg(long, value_name = "OUT.csv")]
    difference: Option<PathBuf>,
    /// Replace the table if it is there.
    #[arg(long, requires = "difference")]
    force: bool,
    /// Fingers in table and figures, from 0; all without it.
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    fingers: Vec<u8>,
}

fn rate_hz(text: &str) -> Result<f64, String> {
    let allowed = "10 to 100000 Hz is allowed".to_owned();
    text.parse()
        .ok()
        .filter(|rate| otherwise::RATES_HZ.contains(rate))
        .ok_or(allowed)
}

impl OtherwiseArgs {
    /// Whether differences are wanted.
    pub fn is_wanted(&self) -> bool {
        self.is_other() || self.difference.is_some()
    }

    /// Whether anything is to be other than in the scenario.
    pub fn is_other(&self) -> bool {
        self.rate.is_some() || self.engine.is_some() || self.force_model.is_some()
    }

    /// Refuses what cannot be done before anything is done.
    ///
    /// # Errors
    /// The table is there already, or a finger is not in the session.
    pub fn check(&self, n_fingers: usize) -> Result<(), CliError> {
        let taken = self
            .difference
            .as_deref()
            .filter(|p| !self.force && p.exists());
        if let Some(path) = taken {
            let what = "is already there; choose another name or add --force";
            return Err(CliError::input(format_args!("{}: {what}", path.display())));
        }
        match self.fingers.iter().find(|f| usize::from(**f) >= n_fingers) {
            Some(finger) => Err(CliError::input(format_args!(
                "--fingers {finger}: the session has {n_fingers}, counted from 0"
            ))),
            None => Ok(()),
        }
    }

    /// A scenario's text with engine and force model as told.
    ///
    /// # Errors
    /// The text is no TOML.
    pub fn varied(&self, text: &str) -> Result<String, String> {
        otherwise::varied(text, self.engine.as_deref(), self.force_model.as_deref())
    }

    /// Repeats the session otherwise and writes the table.
    ///
    /// # Errors
    /// The session cannot be read or the table not be written.
    pub fn run(
        &self,
        session: &Session,
        rig: crate::servo::Rig,
        rebuild: Option<crate::session::Rebuild<'_>>,
    ) -> Result<Divergence, CliError> {
        let mut table = self.difference.as_deref().map(Rows::begin).transpose()?;
        let bar = progress_bar(1000, "repeating    {bar:40} {percent:>3} %  {eta}");
        let otherwise = Otherwise {
            rate_hz: self.rate,
            rebuild,
        };
        let (mut seen, mut failed) = (0_u64, None);
        let wanted = |finger: u8| self.fingers.is_empty() || self.fingers.contains(&finger);
        let found = diverge(session, rig, otherwise, Strictness::Lenient, |off, done| {
            seen += 1;
            if seen.is_multiple_of(1024) {
                bar.set_position((done * 1000.0) as u64);
            }
            if let Some(table) = table.as_mut().filter(|_| wanted(off.finger)) {
                failed = table.put(off).err();
            }
            failed.is_none()
        });
        bar.finish_and_clear();
        let mut found = match (found, failed) {
            (Err(SessionError::Stopped), Some(e)) => return Err(e),
            (found, _) => found.map_err(CliError::input)?,
        };
        found.fingers.retain(|f| wanted(f.finger));
        if let Some(table) = table {
            table.finish(self.force)?;
        }
        Ok(found)
    }

    /// Says what it came to.
    pub fn tell(&self, found: &Divergence) {
        print(format_args!(
            "otherwise     {:>8} recorded ticks compared, {} computed, begun anew {} times",
            found.compared, found.computed, found.gaps
        ));
        for f in &found.fingers {
            for (what, spread, unit) in [
                ("proxy", &f.proxy_mm, "mm"),
                ("force", &f.force_n, "N"),
                ("sent force", &f.sent_force_n, "N"),
                ("depth", &f.depth_mm, "mm"),
            ] {
                let (rms, max, tick) = (spread.rms, spread.max, spread.max_tick);
                print(format_args!(
                    "  finger {} {what:<11} off by {rms:.6} {unit} (root mean square), at most {max:.6} {unit}, at tick {tick}",
                    f.finger
                ));
            }
        }
        if let Some(path) = &self.difference {
            print(format_args!("written to {}", path.display()));
        }
    }
}

/// The table of differences on its way to disk.
struct Rows {
    path: PathBuf,
    file: std::io::BufWriter<tempfile::NamedTempFile>,
}

const HEAD: &str = "tick,time_s,finger,proxy_x_mm,proxy_y_mm,proxy_z_mm,force_x_n,force_y_n,force_z_n,\
                    sent_force_x_n,sent_force_y_n,sent_force_z_n,depth_mm";

impl Rows {
    fn begin(path: &Path) -> Result<Self, CliError> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
        let file = tempfile::NamedTempFile::new_in(folder.unwrap_or(Path::new(".")));
        let mut rows = Self {
            path: path.to_owned(),
            file: std::io::BufWriter::new(file.map_err(|e| failed(path, &e))?),
        };
        rows.line(format_args!("{HEAD}"))?;
        Ok(rows)
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) -> Result<(), CliError> {
        writeln!(self.file, "{line}").map_err(|e| failed(&self.path, &e))
    }

    fn put(&mut self, off: &Off) -> Result<(), CliError> {
        let (p, f, s) = (off.proxy_mm, off.force_n, off.sent_force_n);
        let (tick, time_s, finger, depth_mm) = (off.tick, off.time_s, off.finger, off.depth_mm);
        self.line(format_args!(
            "{tick},{time_s},{finger},{},{},{},{},{},{},{},{},{},{depth_mm}",
            p.x, p.y, p.z, f.x, f.y, f.z, s.x, s.y, s.z
        ))
    }

    fn finish(self, replace: bool) -> Result<(), CliError> {
        let path = self.path;
        let file = self.file.into_inner();
        let file = file.map_err(|e| failed(&path, e.error()))?;
        let placed = match replace {
            true => file.persist(&path),
            false => file.persist_noclobber(&path),
        };
        placed.map_err(|e| failed(&path, &e.error)).map(drop)
    }
}

fn failed(path: &Path, error: &std::io::Error) -> CliError {
    CliError::input(format_args!("{}: {error}", path.display()))
}
