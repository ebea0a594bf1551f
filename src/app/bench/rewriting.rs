//! Files written anew beside the window: what is left of a damaged recording, and finished ones compressed.

use super::job::{Job, Progress};
use super::{Bench, Wake, file_name};
use crate::app::messages::Level;
use crate::app::state::BuildStatus;
use crate::app::widgets::bytes;
use crate::session::{RecoverOptions, compress, recover};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// What is to be written anew.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Wish {
    Recover(PathBuf),
    Compress(PathBuf),
}

/// One after the other.
#[derive(Default)]
pub struct Rewriting {
    /// Whether recordings are compressed when they are finished.
    pub compresses: bool,
    waiting: VecDeque<Wish>,
    job: Option<Job<Result<String, String>>>,
}

impl Rewriting {
    /// How far the file under way is.
    pub fn status(&self) -> Option<BuildStatus> {
        self.job.as_ref().map(Job::status)
    }

    /// Ends the one under way; those that wait are forgotten.
    pub fn cancel(&mut self) {
        self.waiting.clear();
        if let Some(job) = &self.job {
            job.cancel();
        }
    }

    fn start(&mut self, wake: &Wake) -> std::io::Result<()> {
        let Some(wish) = self.waiting.pop_front() else {
            return Ok(());
        };
        let (path, part) = match &wish {
            Wish::Recover(path) => (path, "recovering"),
            Wish::Compress(path) => (path, "compressing"),
        };
        let status = BuildStatus {
            scenario: file_name(path),
            part: part.into(),
            fraction: 0.0,
        };
        let work = move |progress: Progress<'_>| {
            let mut watch = |share: f64| progress(part, share);
            match wish {
                Wish::Recover(path) => recovered(&path, &mut watch),
                Wish::Compress(path) => compressed(&path, &mut watch),
            }
        };
        self.job = Some(Job::start("rewriting", status, wake.clone(), work)?);
        Ok(())
    }
}

fn recovered(broken: &Path, watch: &mut dyn FnMut(f64) -> bool) -> Result<String, String> {
    let out = free_name(broken);
    let report = recover(broken, &out, &RecoverOptions::default(), watch);
    let report = report.map_err(|e| e.to_string())?;
    let loss = if report.is_whole() {
        "nothing was lost".to_owned()
    } else {
        report.lost()
    };
    let (ticks, seconds) = (report.ticks, report.seconds);
    let out = report.out.display();
    Ok(format!(
        "Saved {ticks} ticks, {seconds:.1} s, to {out}: {loss}"
    ))
}

fn compressed(path: &Path, watch: &mut dyn FnMut(f64) -> bool) -> Result<String, String> {
    let done = compress(path, watch).map_err(|e| e.to_string())?;
    let (before, after) = (bytes(done.before), bytes(done.after));
    Ok(format!(
        "Compressed {}: {before} became {after}",
        path.display()
    ))
}

/// A name beside `broken` that is not taken.
fn free_name(broken: &Path) -> PathBuf {
    let stem = broken.file_stem().unwrap_or_default().to_string_lossy();
    let name = |n: u32| match n {
        1 => format!("{stem}_recovered.mcap"),
        n => format!("{stem}_recovered-{n}.mcap"),
    };
    (1..1000)
        .map(|n| broken.with_file_name(name(n)))
        .find(|path| !path.exists())
        .unwrap_or_else(|| broken.with_file_name(name(1000)))
}

impl Bench {
    /// Writes what can be read of a damaged recording to a new file beside it.
    pub fn recover_recording(&mut self, path: PathBuf) {
        self.rewrite(Wish::Recover(path));
    }

    /// Compresses a recording that was finished, where that is asked for.
    pub(super) fn compress_finished(&mut self, path: PathBuf) {
        if self.rewriting.compresses {
            self.rewrite(Wish::Compress(path));
        }
    }

    /// Whether recordings are compressed when they are finished.
    pub fn set_compresses(&mut self, on: bool) {
        self.rewriting.compresses = on;
    }

    fn rewrite(&mut self, wish: Wish) {
        if !self.rewriting.waiting.contains(&wish) {
            self.rewriting.waiting.push_back(wish);
        }
    }

    /// Goes on with what is to be written anew; answers whether anything is new.
    pub(super) fn poll_rewriting(&mut self) -> bool {
        let lost = || Err("the file could not be written anew".to_owned());
        let done = self.rewriting.job.as_ref().and_then(|job| job.poll(lost));
        let is_done = done.is_some();
        if let Some(outcome) = done {
            self.rewriting.job = None;
            self.recordings.list_again();
            match outcome {
                Ok(text) => self.tell(Level::Info, text),
                Err(e) => self.tell(Level::Error, e),
            }
        }
        if self.rewriting.job.is_none()
            && let Err(e) = self.rewriting.start(&self.wake)
        {
            self.tell(Level::Error, format!("nothing can be written anew: {e}"));
        }
        is_done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_recovered_takes_no_name_that_is_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let broken = folder.path().join("a.mcap");
        let first = free_name(&broken);
        assert!(first.ends_with("a_recovered.mcap"));
        std::fs::write(&first, b"").expect("writes");
        assert!(free_name(&broken).ends_with("a_recovered-2.mcap"));
    }
}
