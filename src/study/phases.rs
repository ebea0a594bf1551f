//! Search and palpation: what a finger is about, from how it moves and presses.
//!
//! A finger on the skin **searches** while it moves lightly: faster than [`PhaseRule::slow_mm_s`] and pressing less than
//! [`PhaseRule::firm_n`]. It **palpates** while it presses at least so hard, however fast it moves, or dwells in a place.
//! Off the skin it is **away**. How fast it gets on is the straight way that its mean place on the skin makes in 100 ms,
//! 50 ms to either side: a tremor is not motion. Both bounds have a hysteresis, and a phase begins only once its like has
//! held for [`PhaseRule::least_s`]; what is shorter belongs to the phase before it. The division is made on frames of 10 ms.

use super::frame::Frame;
use super::metrics::Metrics;
use super::options::PhaseRule;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// What a finger is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PhaseKind {
    /// Off the skin.
    Away,
    /// Moving lightly over the skin.
    Search,
    /// Pressing, or dwelling in a place.
    Palpation,
}

impl PhaseKind {
    /// Name for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Away => "off the skin",
            Self::Search => "search",
            Self::Palpation => "palpation",
        }
    }
}

/// A stretch of time of one sort.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phase {
    /// Which sort.
    pub kind: PhaseKind,
    /// From the first tick of the session, s.
    pub start_s: f64,
    /// Likewise.
    pub end_s: f64,
}

impl Phase {
    /// How long it is, s.
    pub fn seconds(&self) -> f64 {
        self.end_s - self.start_s
    }
}

/// The phase at a time; `None` outside of all.
pub fn at(phases: &[Phase], time_s: f64) -> Option<PhaseKind> {
    let after = phases.partition_point(|p| p.start_s <= time_s);
    let phase = phases.get(after.checked_sub(1)?)?;
    (time_s <= phase.end_s).then_some(phase.kind)
}

/// The measures of search or palpation of a finger.
pub fn metrics_of(finger: &super::FingerAnalysis, kind: PhaseKind) -> Option<&Metrics> {
    match kind {
        PhaseKind::Away => None,
        PhaseKind::Search => Some(&finger.search),
        PhaseKind::Palpation => Some(&finger.palpation),
    }
}

/// Frames to either side that the speed over the skin is told from.
const REACH: usize = 5;

/// Divides frames into phases as they come.
pub(super) struct Segmenter {
    rule: PhaseRule,
    frame_s: f64,
    least: usize,
    /// Frames whose sort is not known yet, and those just before them.
    near: VecDeque<Frame>,
    /// How many of `near` are known.
    known: usize,
    /// What the bounds say of the last frame.
    raw: Option<PhaseKind>,
    current: Option<PhaseKind>,
    /// Frames of another sort than the current one, and since when they have been of one sort.
    pending: Vec<(Frame, PhaseKind)>,
    since: usize,
}

impl Segmenter {
    pub(super) fn new(rule: &PhaseRule, frame_s: f64) -> Self {
        Self {
            rule: rule.clone(),
            frame_s,
            least: (libm::ceil(rule.least_s / frame_s - 1e-9) as usize).max(1),
            near: VecDeque::new(),
            known: 0,
            raw: None,
            current: None,
            pending: Vec::new(),
            since: 0,
        }
    }

    /// The next frame; `out` gets those whose phase is now known.
    pub(super) fn push(&mut self, frame: Frame, out: &mut dyn FnMut(Frame, PhaseKind)) {
        if frame.after_gap {
            self.finish(out);
        }
        self.near.push_back(frame);
        if self.near.len() > self.known + REACH {
            self.classify(out);
        }
    }

    /// Ends the phase, as a gap or the end of the recording does.
    pub(super) fn finish(&mut self, out: &mut dyn FnMut(Frame, PhaseKind)) {
        while self.known < self.near.len() {
            self.classify(out);
        }
        let current = self.current;
        for (frame, raw) in self.pending.drain(..) {
            out(frame, current.unwrap_or(raw));
        }
        self.near.clear();
        (self.known, self.since) = (0, 0);
        (self.raw, self.current) = (None, None);
    }

    /// Finds the sort of the first frame that has none.
    fn classify(&mut self, out: &mut dyn FnMut(Frame, PhaseKind)) {
        let (first, last) = (
            self.known.saturating_sub(REACH),
            (self.known + REACH).min(self.near.len() - 1),
        );
        let raw = self.sort(first, last);
        self.raw = Some(raw);
        let frame = self.near[self.known].clone();
        self.known += 1;
        if self.known > REACH {
            self.near.pop_front();
            self.known -= 1;
        }
        self.settle(frame, raw, out);
    }

    fn sort(&self, first: usize, last: usize) -> PhaseKind {
        let frame = &self.near[self.known];
        if frame.skin_mm.is_none() {
            return PhaseKind::Away;
        }
        // The part of the neighbourhood without a lift.
        let on_skin = |i: &usize| self.near[*i].skin_mm.is_some();
        let from = (first..=self.known).rev().take_while(on_skin).last();
        let to = (self.known..=last).take_while(on_skin).last();
        let speed = match (from, to) {
            (Some(from), Some(to)) if to > from => {
                let ends = [from, to].map(|i| self.near[i].skin_mm.unwrap_or_default());
                ends[0].distance(ends[1]) / ((to - from) as f64 * self.frame_s)
            }
            _ => 0.0,
        };
        let lean = match self.raw {
            Some(PhaseKind::Palpation) => self.rule.hysteresis,
            Some(PhaseKind::Search) => -self.rule.hysteresis,
            _ => 0.0,
        };
        let firm = frame.force_n() >= self.rule.firm_n * (1.0 - lean);
        let slow = speed < self.rule.slow_mm_s * (1.0 + lean);
        if firm || slow {
            PhaseKind::Palpation
        } else {
            PhaseKind::Search
        }
    }

    /// Holds back what may be too short.
    fn settle(&mut self, frame: Frame, raw: PhaseKind, out: &mut dyn FnMut(Frame, PhaseKind)) {
        if self.current == Some(raw) {
            for (frame, _) in self.pending.drain(..) {
                out(frame, raw);
            }
            self.since = 0;
            out(frame, raw);
            return;
        }
        if self.pending.last().is_none_or(|(_, before)| *before != raw) {
            // What was pending before is too short for a phase of its own.
            if let Some(current) = self.current {
                for (frame, _) in self.pending.drain(..) {
                    out(frame, current);
                }
            }
            self.since = self.pending.len();
        }
        self.pending.push((frame, raw));
        if self.pending.len() - self.since >= self.least {
            // At the start of a recording what is too short joins the first phase there is.
            self.current = Some(raw);
            self.since = 0;
            for (frame, _) in self.pending.drain(..) {
                out(frame, raw);
            }
        }
    }
}

/// Joins frames to phases.
#[derive(Default)]
pub(super) struct Joiner {
    pub phases: Vec<Phase>,
}

impl Joiner {
    pub(super) fn add(&mut self, frame: &Frame, kind: PhaseKind, dt_s: f64) {
        let start_s = frame.start_tick as f64 * dt_s;
        let end_s = frame.end_tick as f64 * dt_s;
        match self.phases.last_mut() {
            Some(last) if last.kind == kind && !frame.after_gap => last.end_s = end_s,
            _ => self.phases.push(Phase {
                kind,
                start_s,
                end_s,
            }),
        }
    }
}
