//! Presses and strokes: when a finger bears down and lets go.
//!
//! Counted by force along the normal with a hysteresis that follows the hand. A press begins where the force has risen by
//! [`PressRule::rise_n`] above its least since the last press or since contact, and counts from where it left that least. It
//! ends where the force falls below [`PressRule::release_share`] of the press's own peak, or below
//! [`PressRule::release_n`], or the finger leaves the skin. Pressing rhythmically without letting go so counts each time, and
//! a tremble at the top of a press does not. A press whose finger got farther than [`PressRule::stroke_mm`] from where it
//! began is a stroke. A light stroke that ends in a press is both: the stroke ends where the force exceeds its mean by
//! [`PressRule::rise_n`] and by the factor 1 ⁄ [`PressRule::release_share`], and the press begins there.

use super::frame::Felt;
use super::options::PressRule;
use crate::geom::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Most presses of a finger that are listed.
pub const MOST_PRESSES: usize = 100_000;

/// Whether it stayed in place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PressKind {
    /// It did.
    Press,
    /// It moved over the skin.
    Stroke,
}

/// Once down and up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Press {
    /// Whether it stayed in place.
    pub kind: PressKind,
    /// From the first tick of the session, s.
    pub start_s: f64,
    /// Likewise.
    pub end_s: f64,
    /// Time of the largest force, s.
    pub peak_s: f64,
    /// Where on the map plane the largest force was, mm.
    pub at_mm: [f64; 2],
    /// Largest force along the normal, N.
    pub peak_force_n: f64,
    /// Mean of the force along the normal, N.
    pub mean_force_n: f64,
    /// Greatest depth, mm.
    pub peak_depth_mm: f64,
    /// Farthest that the finger got over the skin from where it began, mm.
    pub travel_mm: f64,
    /// Slope of the force along the normal over depth, by least squares over the ticks of the press, N/mm; absent where the
    /// depth went over less than [`LEAST_DEPTH_MM`] or in fewer than [`LEAST_TICKS`] ticks.
    pub slope_n_per_mm: Option<f64>,
    /// Ticks.
    pub ticks: u32,
    /// Sums of squares about the means: depth (mm²), force (N²), and of their product (N·mm).
    pub squares: [f64; 3],
}

/// Less depth gives no slope, mm.
pub const LEAST_DEPTH_MM: f64 = 1.0;
/// Fewer ticks give no slope.
pub const LEAST_TICKS: u32 = 10;
/// As a share of the rise: a force so near its least has not left it.
const AT_REST: f64 = 0.2;

impl Press {
    /// How long it took, s.
    pub fn seconds(&self) -> f64 {
        self.end_s - self.start_s
    }
}

/// A press, or what may become one.
#[derive(Clone, Debug)]
struct Building {
    start_tick: u64,
    start_mm: Vec3,
    peak_tick: u64,
    peak_mm: Vec2,
    peak_n: f64,
    depth_range_mm: [f64; 2],
    travel_sq: f64,
    n: u32,
    mean: [f64; 2],
    squares: [f64; 3],
}

impl Building {
    fn new(tick: u64, felt: &Felt) -> Self {
        Self {
            start_tick: tick,
            start_mm: felt.at_mm,
            peak_tick: tick,
            peak_mm: felt.at_mm.truncate(),
            peak_n: 0.0,
            depth_range_mm: [f64::INFINITY, f64::NEG_INFINITY],
            travel_sq: 0.0,
            n: 0,
            mean: [0.0; 2],
            squares: [0.0; 3],
        }
    }

    fn add(&mut self, tick: u64, felt: &Felt, force_n: f64) {
        if force_n > self.peak_n {
            (self.peak_n, self.peak_tick) = (force_n, tick);
            self.peak_mm = felt.at_mm.truncate();
        }
        let depth_mm = felt.depth_mm;
        let [least, most] = self.depth_range_mm;
        self.depth_range_mm = [least.min(depth_mm), most.max(depth_mm)];
        self.travel_sq = self
            .travel_sq
            .max(felt.at_mm.distance_squared(self.start_mm));
        // Welford (1962): a sum of squares less the square of a sum loses its digits.
        self.n += 1;
        let off = [depth_mm - self.mean[0], force_n - self.mean[1]];
        for (mean, off) in self.mean.iter_mut().zip(off) {
            *mean += off / f64::from(self.n);
        }
        let new = [depth_mm - self.mean[0], force_n - self.mean[1]];
        self.squares[0] += off[0] * new[0];
        self.squares[1] += off[1] * new[1];
        self.squares[2] += off[0] * new[1];
    }

    fn end(self, tick: u64, first_tick: u64, dt_s: f64, rule: &PressRule) -> Option<Press> {
        let time = |tick: u64| tick.saturating_sub(first_tick) as f64 * dt_s;
        let (start_s, end_s) = (time(self.start_tick), time(tick));
        if end_s - start_s < rule.least_s {
            return None;
        }
        let [least, most] = self.depth_range_mm;
        let steep = most - least >= LEAST_DEPTH_MM && self.n >= LEAST_TICKS;
        let travel_mm = self.travel_sq.sqrt();
        Some(Press {
            kind: if travel_mm > rule.stroke_mm {
                PressKind::Stroke
            } else {
                PressKind::Press
            },
            start_s,
            end_s,
            peak_s: time(self.peak_tick),
            at_mm: self.peak_mm.to_array(),
            peak_force_n: self.peak_n,
            mean_force_n: self.mean[1],
            peak_depth_mm: most,
            travel_mm,
            slope_n_per_mm: steep.then(|| self.squares[2] / self.squares[0]),
            ticks: self.n,
            squares: self.squares,
        })
    }
}

/// Finds presses in the ticks of a finger.
pub(super) struct Detector {
    rule: PressRule,
    first_tick: u64,
    dt_s: f64,
    least_n: f64,
    building: Option<Building>,
    pressing: bool,
    next_tick: u64,
    /// The first [`MOST_PRESSES`].
    pub presses: Vec<Press>,
}

impl Detector {
    pub(super) fn new(rule: &PressRule, first_tick: u64, dt_s: f64) -> Self {
        Self {
            rule: rule.clone(),
            first_tick,
            dt_s,
            least_n: 0.0,
            building: None,
            pressing: false,
            next_tick: 0,
            presses: Vec::new(),
        }
    }

    /// A tick; `None` off the skin.
    pub(super) fn add(&mut self, tick: u64, felt: Option<Felt>) {
        if tick != self.next_tick {
            self.finish();
        }
        self.next_tick = tick.saturating_add(1);
        let Some(felt) = felt else {
            self.end(tick);
            self.least_n = 0.0;
            return;
        };
        let force_n = felt.normal_force_n.max(0.0);
        if self.pressing {
            let peak_n = self.building.as_ref().map_or(0.0, |b| b.peak_n);
            if force_n < (self.rule.release_share * peak_n).max(self.rule.release_n) {
                self.end(tick);
                self.least_n = force_n;
            } else if let Some(mean_n) = self.stroke_mean_n()
                && force_n >= mean_n + self.rule.rise_n
                && force_n * self.rule.release_share >= mean_n
            {
                self.end(tick);
                self.least_n = mean_n;
            }
        } else {
            self.least_n = self.least_n.min(force_n);
            if force_n <= self.least_n + AT_REST * self.rule.rise_n {
                self.building = None;
            }
        }
        let building = self
            .building
            .get_or_insert_with(|| Building::new(tick, &felt));
        building.add(tick, &felt, force_n);
        self.pressing |= force_n >= self.least_n + self.rule.rise_n;
    }

    /// Mean force of the stroke that is going on, N.
    fn stroke_mean_n(&self) -> Option<f64> {
        let reach = self.rule.stroke_mm;
        let building = self
            .building
            .as_ref()
            .filter(|b| b.travel_sq > reach * reach)?;
        Some(building.mean[1])
    }

    /// Ends what is going on, as a gap or the end of the recording does.
    pub(super) fn finish(&mut self) {
        self.end(self.next_tick);
        self.least_n = 0.0;
    }

    fn end(&mut self, tick: u64) {
        let building = self.building.take();
        if std::mem::take(&mut self.pressing)
            && let Some(press) =
                building.and_then(|b| b.end(tick, self.first_tick, self.dt_s, &self.rule))
            && self.presses.len() < MOST_PRESSES
        {
            self.presses.push(press);
        }
    }
}
