//! Recordings overlaid on the one that is replayed: each moves with its time.

use super::job::Job;
use super::past::Past;
use super::{Wake, file_name};
use crate::app::state::{Alignment, BuildStatus, GhostView, Trail};
use crate::contact::Touch;
use crate::geom::Vec3;
use crate::servo::{FingerRecord, TickRecord};
use crate::session::Timeline;
use crate::units::NS_PER_S;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most ghosts at once: more could not be told apart.
pub const MOST: usize = 6;
/// How long a trail reaches back, s.
const TRAIL_S: f64 = 1.0;
/// Places of a trail.
const TRAIL_PLACES: usize = 40;

/// A recording that is overlaid.
struct Ghost {
    path: PathBuf,
    /// Which of the legend's colours it wears.
    colour: usize,
    timeline: Timeline,
    past: Past,
    /// How much later than the replayed recording it is shown, s, beside what aligning asks for.
    offset_s: f64,
    /// Its own time on show, s, and what is seen then.
    shown: Option<(f64, Arc<[Trail]>)>,
}

/// A ghost that is being opened.
type Opening = (PathBuf, Job<Result<Timeline, String>>);

/// All of them.
#[derive(Default)]
pub struct Ghosts {
    list: Vec<Ghost>,
    opening: Vec<Opening>,
    alignment: Alignment,
    first_contact_s: Option<f64>,
}

impl Ghosts {
    /// Starts opening `path`; one that is there already stays as it is.
    ///
    /// # Errors
    /// In words, when there are too many or the system refuses another thread.
    pub fn add(&mut self, path: PathBuf, wake: &Wake) -> Result<(), String> {
        let there = self.list.iter().any(|g| g.path == path);
        if there || self.opening.iter().any(|(p, _)| *p == path) {
            return Ok(());
        }
        if self.list.len() + self.opening.len() >= MOST {
            return Err(format!("at most {MOST} recordings can be overlaid"));
        }
        let own = path.clone();
        let work = move |progress: super::job::Progress<'_>| {
            let mut watch = |share: f64| progress("ghost", share);
            let timeline = Timeline::open_watched(&own, &mut watch).map_err(|e| e.to_string())?;
            if timeline.header().sealed {
                let what = "a trial that was not answered: it cannot be overlaid";
                return Err(format!("{}: {what}", own.display()));
            }
            if timeline.n_ticks() == 0 {
                return Err(format!("{}: the recording holds no tick", own.display()));
            }
            Ok(timeline)
        };
        let job = Job::start("ghost", BuildStatus::default(), wake.clone(), work);
        let job = job.map_err(|e| format!("the reader cannot start: {e}"))?;
        self.opening.push((path, job));
        Ok(())
    }

    /// Takes one away.
    pub fn remove(&mut self, path: &Path) {
        self.list.retain(|g| g.path != path);
        self.opening.retain(|(p, _)| p != path);
    }

    /// Takes all away.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty() && self.opening.is_empty()
    }

    /// Shows one later by `offset_s` than aligning alone would.
    pub fn set_offset(&mut self, path: &Path, offset_s: f64) {
        for ghost in self.list.iter_mut().filter(|g| g.path == path) {
            if offset_s.is_finite() {
                ghost.offset_s = offset_s;
            }
        }
    }

    /// Aligns them all.
    pub fn align(&mut self, alignment: Alignment) {
        self.alignment = alignment;
    }

    /// What was opened since the last call, or why it could not be.
    pub fn poll(&mut self, wake: &Wake) -> Vec<Result<String, String>> {
        let mut told = Vec::new();
        let mut i = 0;
        while i < self.opening.len() {
            let lost = || Err("the recording could not be read".to_owned());
            let Some(opened) = self.opening[i].1.poll(lost) else {
                i += 1;
                continue;
            };
            let (path, _) = self.opening.remove(i);
            told.push(opened.map(|timeline| {
                let taken = |c: &usize| self.list.iter().any(|g| g.colour == *c);
                let colour = (0..MOST).find(|c| !taken(c)).unwrap_or(0);
                let name = file_name(&path);
                self.list.push(Ghost {
                    past: Past::of(&timeline, wake),
                    path,
                    colour,
                    timeline,
                    offset_s: 0.0,
                    shown: None,
                });
                name
            }));
        }
        told
    }

    /// Goes to the time of the replayed recording, whose first contact was at `first_s`. Answers whether anything changed.
    pub fn follow(&mut self, at_s: f64, first_s: Option<f64>) -> bool {
        self.first_contact_s = first_s;
        let alignment = self.alignment;
        let mut changed = false;
        for ghost in &mut self.list {
            let own_s = at_s - ghost.shift_s(alignment, first_s);
            changed |= ghost
                .past
                .follow(own_s.clamp(0.0, ghost.timeline.duration_s()));
            if ghost.shown.as_ref().is_none_or(|(s, _)| *s != own_s) {
                ghost.shown = Some((own_s, ghost.trails(own_s)));
                changed = true;
            }
        }
        changed
    }

    /// For the window.
    pub fn view(&self) -> Vec<GhostView> {
        let view = |ghost: &Ghost| GhostView {
            path: ghost.path.clone(),
            name: name_of(ghost),
            colour: ghost.colour,
            offset_s: ghost.offset_s,
            shift_s: ghost.shift_s(self.alignment, self.first_contact_s),
            trails: ghost
                .shown
                .as_ref()
                .map(|(_, t)| t.clone())
                .unwrap_or_default(),
            history: ghost.past.history().clone(),
            plotted: ghost.past.progress(),
        };
        self.list.iter().map(view).collect()
    }

    /// How they are aligned.
    pub fn alignment(&self) -> Alignment {
        self.alignment
    }

    /// How far the opening of one is.
    pub fn opening(&self) -> Option<BuildStatus> {
        let (path, job) = self.opening.first()?;
        Some(BuildStatus {
            scenario: file_name(path),
            ..job.status()
        })
    }
}

/// Whose it is, as far as it says so, and its file.
fn name_of(ghost: &Ghost) -> String {
    let header = ghost.timeline.header();
    match &header.participant {
        Some(participant) => format!("{participant}, {}", header.scenario_name),
        None => header.scenario_name.clone(),
    }
}

impl Ghost {
    /// How much later it is shown than it was recorded, both from the start, s.
    fn shift_s(&self, alignment: Alignment, first_s: Option<f64>) -> f64 {
        let aligned_s = match (alignment, first_s, self.past.first_contact_s()) {
            (Alignment::FirstContact, Some(theirs), Some(own)) => theirs - own,
            _ => 0.0,
        };
        aligned_s + self.offset_s
    }

    /// Where its fingers are at its own time `own_s`, and were within the last second. Before its start and after its end there
    /// is none.
    fn trails(&self, own_s: f64) -> Arc<[Trail]> {
        if !(0.0..=self.timeline.duration_s()).contains(&own_s) {
            return Arc::default();
        }
        let start_ns = self.timeline.span_ns().0;
        let at = |s: f64| {
            let ns = start_ns.saturating_add((s.max(0.0) * NS_PER_S).round() as u64);
            self.timeline.at_ns(ns)
        };
        let step_s = TRAIL_S / TRAIL_PLACES as f64;
        // On a lattice of time: a trail does not crawl while it is looked at.
        let first = ((own_s - TRAIL_S).max(0.0) / step_s).ceil() as u64;
        let last = (own_s / step_s).floor() as u64;
        let mut past: Vec<TickRecord> = (first..=last).map(|i| at(i as f64 * step_s)).collect();
        past.push(at(own_s));
        let n_fingers = past.last().map_or(0, |t| t.n_fingers);
        let trail = |finger: usize| Trail {
            now: past.last().map(|t| t.fingers[finger]).unwrap_or_default(),
            places_mm: past.iter().map(|t| place_mm(&t.fingers[finger])).collect(),
        };
        (0..n_fingers).map(trail).collect()
    }
}

/// Where a finger is seen: on the skin it touches, or where the device is.
fn place_mm(record: &FingerRecord) -> Vec3 {
    if record.contact.touch == Touch::Free {
        record.reading.position_mm
    } else {
        record.contact.anchor_mm
    }
}
