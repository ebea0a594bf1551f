//! One finger of a session, resampled: what alignment by warping, plots and panels go by.

use super::super::StudyError;
use super::super::frame::Felt;
use crate::geom::Vec3;
use crate::session::{Entry, Session, Strictness};
use serde::{Deserialize, Serialize};

/// A finger over time at equal steps: each sample the mean over the ticks of its step; where a step has no tick, the sample
/// before it is held.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// Samples per second.
    pub rate_hz: f64,
    /// Place of the HIP, mm.
    pub position_mm: Vec<[f32; 3]>,
    /// Force of the skin on the finger, N.
    pub force_n: Vec<f32>,
    /// Depth, mm; 0 off the skin.
    pub depth_mm: Vec<f32>,
}

impl Trace {
    /// How many samples.
    pub fn len(&self) -> usize {
        self.force_n.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.force_n.is_empty()
    }

    /// Middle of a sample from the first tick of the session, s.
    pub fn time_s(&self, i: usize) -> f64 {
        (i as f64 + 0.5) / self.rate_hz
    }

    /// Number of the sample at a time, at either end the last there is.
    pub fn at(&self, time_s: f64) -> usize {
        // A cast of what is negative or no number is 0.
        ((time_s * self.rate_hz) as usize).min(self.len().saturating_sub(1))
    }

    /// About `most` samples by leaving out those between.
    #[must_use]
    pub fn thinned(&self, most: usize) -> Self {
        let step = self.len().div_ceil(most.max(1)).max(1);
        let every = |i: &usize| i.is_multiple_of(step);
        let kept: Vec<usize> = (0..self.len()).filter(every).collect();
        Self {
            rate_hz: self.rate_hz / step as f64,
            position_mm: kept.iter().map(|i| self.position_mm[*i]).collect(),
            force_n: kept.iter().map(|i| self.force_n[*i]).collect(),
            depth_mm: kept.iter().map(|i| self.depth_mm[*i]).collect(),
        }
    }
}

/// Samples per second where a session is short enough.
pub const TRACE_HZ: f64 = 50.0;
/// Most samples of a trace: a longer session has fewer per second.
pub const MOST_SAMPLES: u64 = 1 << 17;

struct Sums {
    position: Vec3,
    n_position: u32,
    force: f64,
    depth: f64,
    n: u32,
}

const NOTHING: Sums = Sums {
    position: Vec3::ZERO,
    n_position: 0,
    force: 0.0,
    depth: 0.0,
    n: 0,
};

/// Traces of every finger of a session of `ticks` ticks, in one pass: at 50 Hz, or fewer where there would be more than
/// [`MOST_SAMPLES`]. A finger without a tick has an empty one.
///
/// # Errors
/// The file cannot be read, stays sealed, or `progress` said stop.
pub fn traces(
    session: &Session,
    ticks: u64,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Trace>, StudyError> {
    let header = session.header();
    if header.sealed {
        return Err(StudyError::Sealed {
            path: session.path().to_owned(),
        });
    }
    let wanted = (libm::round(header.rate_hz / TRACE_HZ) as u64).max(1);
    let mut step = wanted.max(ticks.div_ceil(MOST_SAMPLES));
    let n = header.n_fingers();
    let mut out = vec![Trace::default(); n];
    let mut sums: Vec<(u64, Sums)> = (0..n).map(|_| (0, NOTHING)).collect();
    let mut first = None;
    let mut entries = session.entries(Strictness::Lenient)?;
    let mut read = 0_u64;
    while let Some(entry) = entries.next() {
        let Entry::Tick(record) = entry? else {
            continue;
        };
        let number = usize::from(record.finger);
        let from = *first.get_or_insert(record.tick);
        let tick = record.tick.saturating_sub(from);
        // Gaps make a session longer than it has ticks.
        while tick / step >= 2 * MOST_SAMPLES {
            step *= 2;
            for ((index, _), trace) in sums.iter_mut().zip(&mut out) {
                *index /= 2;
                halve(trace);
            }
        }
        let (index, sum) = &mut sums[number];
        let trace = &mut out[number];
        if tick / step != *index {
            put(trace, sum, *index);
            (*index, *sum) = (tick / step, NOTHING);
        }
        sum.n += 1;
        if record.reading.is_usable() {
            sum.position += record.reading.position_mm;
            sum.n_position += 1;
        }
        if let Some(felt) = Felt::of(&record) {
            sum.force += felt.force_n;
            sum.depth += felt.depth_mm;
        }
        read += 1;
        if read.is_multiple_of(8192) && !progress(entries.progress()) {
            return Err(StudyError::Stopped);
        }
    }
    for ((index, sum), trace) in sums.iter().zip(&mut out) {
        put(trace, sum, *index);
        trace.rate_hz = header.rate_hz / step as f64;
    }
    Ok(out)
}

/// Every second sample falls away.
fn halve(trace: &mut Trace) {
    fn every_second<T: Copy>(values: &mut Vec<T>) {
        *values = values.iter().copied().step_by(2).collect();
    }
    every_second(&mut trace.position_mm);
    every_second(&mut trace.force_n);
    every_second(&mut trace.depth_mm);
}

/// Writes the sample with number `index`, and holds the last one up to it.
fn put(trace: &mut Trace, sum: &Sums, index: u64) {
    if sum.n == 0 {
        return;
    }
    let n = f64::from(sum.n);
    let last = trace.position_mm.last().copied().unwrap_or_default();
    let position_mm = match sum.n_position {
        0 => last,
        n => (sum.position / f64::from(n)).to_array().map(|x| x as f32),
    };
    let (force_n, depth_mm) = ((sum.force / n) as f32, (sum.depth / n) as f32);
    let index = index as usize;
    if trace.is_empty() {
        // Fingers begin together, but where the first chunk is damaged.
        trace.position_mm.resize(index, position_mm);
        trace.force_n.resize(index, 0.0);
        trace.depth_mm.resize(index, 0.0);
    } else if trace.len() < index {
        let (force, depth) = (
            trace.force_n[trace.len() - 1],
            trace.depth_mm[trace.len() - 1],
        );
        trace.position_mm.resize(index, last);
        trace.force_n.resize(index, force);
        trace.depth_mm.resize(index, depth);
    }
    trace.position_mm.truncate(index);
    trace.force_n.truncate(index);
    trace.depth_mm.truncate(index);
    trace.position_mm.push(position_mm);
    trace.force_n.push(force_n);
    trace.depth_mm.push(depth_mm);
}
