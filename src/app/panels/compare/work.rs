//! What is known of the recordings that are compared: each is analysed once, each pair set side by side once for each way to do
//! so, on a thread of their own.

use crate::app::bench::Wake;
use crate::app::bench::job::{Job, Progress};
use crate::app::state::{BuildStatus, Compared};
use crate::session::Session;
use crate::study::compare::{CompareOptions, Comparison, Trace, compare, traces};
use crate::study::index::Labels;
use crate::study::{self, Analysis, Options};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

/// What one recording told.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Measures, phases, presses, dwell, events.
    pub analysis: Analysis,
    /// Each finger over time.
    pub traces: Vec<Trace>,
    /// Its tags when it was read.
    pub tags: Vec<String>,
}

/// Size and time of change: another one, and the recording is read again.
type Stamp = (u64, Option<SystemTime>);

/// A recording, and what it told or why it did not.
struct Known {
    path: PathBuf,
    stamp: Stamp,
    told: Result<Arc<Told>, String>,
}

/// Two recordings, and how far they are apart or why that cannot be told.
struct Pair {
    paths: [PathBuf; 2],
    options: CompareOptions,
    found: Result<Arc<Comparison>, String>,
}

enum Found {
    Known(Known),
    Pair(Pair),
}

/// All of them.
#[derive(Default)]
pub struct Work {
    known: Vec<Known>,
    pairs: Vec<Pair>,
    /// What the thread has found.
    found: Arc<Mutex<Vec<Found>>>,
    job: Option<Job<()>>,
    stopped: bool,
    /// Counts what was found.
    number: u64,
    /// Recordings that were read since that was asked for.
    read: Vec<PathBuf>,
}

impl Work {
    /// What `path` told; `None` while it is not read.
    pub fn of(&self, path: &Path) -> Option<&Result<Arc<Told>, String>> {
        let known = self.known.iter().find(|k| k.path == path)?;
        Some(&known.told)
    }

    /// How far two recordings are apart; `None` while that is not known.
    pub fn pair(
        &self,
        a: &Path,
        b: &Path,
        options: &CompareOptions,
    ) -> Option<&Result<Arc<Comparison>, String>> {
        let is = |p: &&Pair| p.paths[0] == a && p.paths[1] == b && p.options == *options;
        Some(&self.pairs.iter().find(is)?.found)
    }

    /// The recordings that were read since that was asked for last, with their tags.
    pub fn take_read(&mut self) -> Vec<Compared> {
        let read = std::mem::take(&mut self.read);
        let tagged = |path: PathBuf| {
            let tags = self.of(&path)?.as_ref().ok()?.tags.clone();
            Some(Compared { path, tags })
        };
        read.into_iter().filter_map(tagged).collect()
    }

    /// Changes whenever more is known.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// How far the reading is.
    pub fn progress(&self) -> Option<BuildStatus> {
        self.job.as_ref().map(Job::status)
    }

    /// Ends the reading; what is known stays.
    pub fn stop(&mut self) {
        self.stopped = true;
        if let Some(job) = &self.job {
            job.cancel();
        }
    }

    /// Whether it was ended before all was read.
    pub fn is_stopped(&self) -> bool {
        self.stopped
    }

    /// Goes on after [`Self::stop`].
    pub fn resume(&mut self) {
        self.stopped = false;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let told = self.known.iter().filter_map(|k| k.told.as_ref().ok());
        let of = |told: &Arc<Told>| {
            let samples: usize = told.traces.iter().map(Trace::len).sum();
            samples * 20 + told.analysis.dwell.seconds.len() * 4
        };
        let pairs = self.pairs.iter().filter_map(|p| p.found.as_ref().ok());
        let series = |c: &Arc<Comparison>| c.series.time_s.len() * 56 + c.warp_s.len() * 16;
        told.map(of).sum::<usize>() + pairs.map(series).sum::<usize>()
    }

    /// Takes over what was found, and reads what is missing of `wanted`; sets all side by side with the first as `options` say.
    pub fn follow(&mut self, wanted: &[Compared], options: &CompareOptions, wake: &Wake) {
        self.take(wanted);
        if self.job.is_some() || self.stopped {
            return;
        }
        let missing: Vec<PathBuf> = (wanted.iter())
            .filter(|w| self.of(&w.path).is_none())
            .map(|w| w.path.clone())
            .collect();
        let good = |w: &&Compared| matches!(self.of(&w.path), Some(Ok(_)));
        let mut told = wanted.iter().filter(good);
        let first = told.next().map(|w| w.path.clone());
        let pairs: Vec<[PathBuf; 2]> = (first.iter())
            .flat_map(|a| told.clone().map(|b| [a.clone(), b.path.clone()]))
            .filter(|[a, b]| self.pair(a, b, options).is_none())
            .collect();
        if missing.is_empty() && pairs.is_empty() {
            return;
        }
        let analysis = |path: &Path| self.of(path)?.as_ref().ok().cloned();
        let pairs: Vec<_> = pairs
            .into_iter()
            .filter_map(|[a, b]| {
                let told = [analysis(&a)?, analysis(&b)?];
                Some(([a, b], told))
            })
            .collect();
        let (found, options) = (self.found.clone(), options.clone());
        let work = move |progress: Progress<'_>| {
            // What is read first is set side by side next.
            if missing.is_empty() {
                compare_all(&pairs, &options, &found, progress);
            } else {
                read_all(&missing, &found, progress);
            }
        };
        match Job::start("comparison", BuildStatus::default(), wake.clone(), work) {
            Ok(job) => self.job = Some(job),
            // Asked again with the next frame.
            Err(e) => log::warn!("the comparison cannot start: {e}"),
        }
    }

    fn take(&mut self, wanted: &[Compared]) {
        if self
            .job
            .as_ref()
            .is_some_and(|job| job.poll(|| ()).is_some())
        {
            self.job = None;
        }
        let found: Vec<Found> = {
            let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
            found.drain(..).collect()
        };
        for found in found {
            self.number += 1;
            match found {
                Found::Known(known) => {
                    self.known.retain(|k| k.path != known.path);
                    self.pairs.retain(|p| !p.paths.contains(&known.path));
                    self.read.push(known.path.clone());
                    self.known.push(known);
                }
                Found::Pair(pair) => self.pairs.push(pair),
            }
        }
        let before = self.known.len();
        let is_wanted = |path: &PathBuf| wanted.iter().any(|w| w.path == *path);
        self.known.retain(|k| is_wanted(&k.path));
        self.pairs.retain(|p| p.paths.iter().all(is_wanted));
        self.number += u64::from(self.known.len() != before);
    }

    /// Reads again those that changed on the disk.
    pub fn renew(&mut self) {
        self.known.retain(|k| k.stamp == stamp(&k.path));
        let there = |path: &PathBuf| self.known.iter().any(|k| k.path == *path);
        self.pairs.retain(|p| p.paths.iter().all(there));
        self.number += 1;
        self.stopped = false;
    }
}

fn stamp(path: &Path) -> Stamp {
    let meta = std::fs::metadata(path).ok();
    let size = meta.as_ref().map_or(0, std::fs::Metadata::len);
    (size, meta.and_then(|m| m.modified().ok()))
}

fn put(all: &Mutex<Vec<Found>>, found: Found) {
    all.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .push(found);
}

fn read_all(paths: &[PathBuf], all: &Mutex<Vec<Found>>, progress: Progress<'_>) {
    let n = paths.len() as f64;
    for (i, path) in paths.iter().enumerate() {
        let stamp = stamp(path);
        let name = crate::app::bench::file_name(path);
        let mut going = true;
        let told = read(path, &mut |share| {
            going = progress(&name, (i as f64 + share) / n);
            going
        });
        if !going {
            return;
        }
        let known = Known {
            path: path.clone(),
            stamp,
            told: told.map(Arc::new),
        };
        put(all, Found::Known(known));
    }
}

/// Reads one: half of `progress` is the analysis, half the traces.
fn read(path: &Path, progress: &mut dyn FnMut(f64) -> bool) -> Result<Told, String> {
    let session = Session::open(path).map_err(|e| e.to_string())?;
    let analysis = study::analyse(&session, &Options::default(), &mut |s| progress(0.5 * s));
    let analysis = analysis.map_err(|e| e.to_string())?;
    let mut second = |s: f64| progress(0.5 + 0.5 * s);
    let traces = traces(&session, analysis.about.ticks, &mut second);
    let traces = traces.map_err(|e| e.to_string())?;
    let tags = tags_of(&session);
    Ok(Told {
        analysis,
        traces,
        tags,
    })
}

/// What the user wrote on a recording; nothing where that cannot be read, which the Sessions panel says.
fn tags_of(session: &Session) -> Vec<String> {
    let path = session.path();
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let started = &session.header().started_utc;
    let labels = Labels::read(folder).unwrap_or_default();
    let label = labels.get(&name, Some(started), folder);
    label.map(|l| l.tags.clone()).unwrap_or_default()
}

/// Two files, and what each told.
type Two = ([PathBuf; 2], [Arc<Told>; 2]);

fn compare_all(
    pairs: &[Two],
    options: &CompareOptions,
    all: &Mutex<Vec<Found>>,
    progress: Progress<'_>,
) {
    let n = pairs.len() as f64;
    for (i, (paths, told)) in pairs.iter().enumerate() {
        let name = crate::app::bench::file_name(&paths[1]);
        let mut going = true;
        let found = beside(paths, told, options, &mut |share| {
            going = progress(&name, (i as f64 + share) / n);
            going
        });
        if !going {
            return;
        }
        let pair = Pair {
            paths: paths.clone(),
            options: options.clone(),
            found: found.map(Arc::new),
        };
        put(all, Found::Pair(pair));
    }
}

fn beside(
    paths: &[PathBuf; 2],
    told: &[Arc<Told>; 2],
    options: &CompareOptions,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Comparison, String> {
    let open = |path: &Path| Session::open(path).map_err(|e| e.to_string());
    let (a, b) = (open(&paths[0])?, open(&paths[1])?);
    let told = [&told[0].analysis, &told[1].analysis];
    compare([&a, &b], told, options, progress).map_err(|e| e.to_string())
}
