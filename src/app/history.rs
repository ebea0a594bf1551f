//! The plotted past, in bounded memory.
//!
//! Each channel of each finger is a pyramid: level 0 keeps every tick of the last minute, each level above keeps the
//! smallest and largest value of [`FACTOR`] bins below it and so reaches [`FACTOR`] times further back. Drawing an hour
//! costs as much as drawing a second.

use crate::contact::Touch;
use crate::device::MAX_FINGERS;
use crate::servo::FingerRecord;
use crate::units::s_from_ns;
use std::collections::VecDeque;

/// Bins of one level that make one bin of the next.
pub const FACTOR: u64 = 8;
/// Levels; at 1 kHz the last one reaches back three days.
pub const LEVELS: usize = 5;
/// Bins kept per level: 65 s of ticks at 1 kHz on level 0, 70 minutes on level 2.
pub const CAPACITY: usize = 1 << 16;

/// Longest time without a tick that a line bridges, in ticks: jitter and single lost ticks do not break it.
const BRIDGED: u64 = 50;

/// What is plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Force on the finger along the surface normal, N.
    NormalForce,
    /// Force on the finger across the surface normal, N.
    TangentialForce,
    /// Depth of the finger below the skin, mm.
    Depth,
}

impl Channel {
    /// All channels, in the order of the plots.
    pub const ALL: [Self; 3] = [Self::NormalForce, Self::TangentialForce, Self::Depth];

    /// Its value in `record`.
    pub fn of(self, record: &FingerRecord) -> f64 {
        let contact = &record.contact;
        if contact.touch == Touch::Free {
            return 0.0;
        }
        let force_n = record.sent_force_n;
        let normal_n = force_n.dot(contact.normal);
        match self {
            Self::NormalForce => normal_n,
            Self::TangentialForce => (force_n - contact.normal * normal_n).length(),
            Self::Depth => contact.depth_mm,
        }
    }

    /// Name with unit, as an axis label.
    pub fn label(self) -> &'static str {
        match self {
            Self::NormalForce => "Normal force (N)",
            Self::TangentialForce => "Tangential force (N)",
            Self::Depth => "Penetration (mm)",
        }
    }

    /// The unit alone.
    pub fn unit(self) -> &'static str {
        match self {
            Self::NormalForce | Self::TangentialForce => "N",
            Self::Depth => "mm",
        }
    }
}

/// Smallest and largest value in a bin; `min > max` when nothing fell into it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Band {
    const EMPTY: Self = Self {
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
    };

    fn add(&mut self, value: f64) {
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    fn is_empty(&self) -> bool {
        self.min > self.max
    }
}

/// One resolution: consecutive bins of `ticks_per_bin` ticks, oldest first.
#[derive(Clone, Debug)]
struct Level {
    ticks_per_bin: u64,
    first_bin: u64,
    bins: VecDeque<Band>,
}

impl Level {
    fn new(ticks_per_bin: u64) -> Self {
        Self {
            ticks_per_bin,
            first_bin: 0,
            bins: VecDeque::new(),
        }
    }

    fn end_bin(&self) -> u64 {
        self.first_bin + self.bins.len() as u64
    }

    fn add(&mut self, tick: u64, value: f64) {
        let bin = tick / self.ticks_per_bin;
        if self.bins.is_empty() || bin >= self.end_bin().saturating_add(CAPACITY as u64) {
            self.bins.clear();
            self.first_bin = bin;
        }
        while self.end_bin() <= bin {
            if self.bins.len() == CAPACITY {
                self.bins.pop_front();
                self.first_bin += 1;
            }
            self.bins.push_back(Band::EMPTY);
        }
        if let Some(index) = bin.checked_sub(self.first_bin)
            && let Some(band) = self.bins.get_mut(index as usize)
        {
            band.add(value);
        }
    }

    fn get(&self, bin: u64) -> Option<Band> {
        let index = bin.checked_sub(self.first_bin)?;
        self.bins
            .get(usize::try_from(index).ok()?)
            .copied()
            .filter(|b| !b.is_empty())
    }
}

/// One channel of one finger.
#[derive(Clone, Debug)]
struct Pyramid {
    levels: [Level; LEVELS],
}

impl Default for Pyramid {
    fn default() -> Self {
        Self {
            levels: std::array::from_fn(|k| Level::new(FACTOR.pow(k as u32))),
        }
    }
}

/// What was felt, per finger, over the last hours.
#[derive(Clone, Debug)]
pub struct History {
    rate_hz: f64,
    pyramids: Vec<[Pyramid; Channel::ALL.len()]>,
    first_tick: Option<u64>,
    last_tick: u64,
    /// A stretch of the same past that is kept tick by tick where this one is coarse by now.
    near: Option<Box<History>>,
}

impl Default for History {
    /// An empty history at 1 kHz.
    fn default() -> Self {
        Self::new(1000.0)
    }
}

impl History {
    /// An empty history of ticks that come at `rate_hz`; a rate that is not positive counts as 1 kHz.
    pub fn new(rate_hz: f64) -> Self {
        let rate_hz = if rate_hz.is_finite() && rate_hz > 0.0 {
            rate_hz
        } else {
            1000.0
        };
        Self {
            rate_hz,
            pyramids: Vec::new(),
            first_tick: None,
            last_tick: 0,
            near: None,
        }
    }

    /// Shows a stretch in finer detail from now on: `near` is of the same recording and the same times.
    pub fn set_near(&mut self, near: Self) {
        self.near = Some(Box::new(near));
    }

    /// The past to read between two times (s): the detail where it has all of it.
    fn of(&self, from_s: f64, to_s: f64) -> &Self {
        let covers = |near: &Self| {
            let slack_s = BRIDGED as f64 / self.rate_hz;
            let (first_s, last_s) =
                near.span_s()
                    .zip(self.span_s())
                    .map_or((f64::NAN, f64::NAN), |(near, whole)| {
                        // Beyond its own ends the whole past has nothing either.
                        let first_s = if near.0 <= whole.0 + slack_s {
                            f64::MIN
                        } else {
                            near.0
                        };
                        let last_s = if near.1 >= whole.1 - slack_s {
                            f64::MAX
                        } else {
                            near.1
                        };
                        (first_s, last_s)
                    });
            first_s <= from_s && to_s <= last_s
        };
        self.near
            .as_deref()
            .filter(|near| covers(near))
            .unwrap_or(self)
    }

    /// Adds a tick of a finger at its time since the start. Values that are not finite leave a gap.
    pub fn push(&mut self, record: &FingerRecord) {
        let finger = usize::from(record.finger);
        if finger >= MAX_FINGERS {
            return;
        }
        while self.pyramids.len() <= finger {
            self.pyramids.push(Default::default());
        }
        // By time, not by number: a late servo skips no number.
        let tick = (s_from_ns(record.time_ns) * self.rate_hz).round() as u64;
        for (channel, pyramid) in Channel::ALL.iter().zip(&mut self.pyramids[finger]) {
            let value = channel.of(record);
            if value.is_finite() {
                for level in &mut pyramid.levels {
                    level.add(tick, value);
                }
            }
        }
        self.first_tick.get_or_insert(tick);
        self.last_tick = self.last_tick.max(tick);
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        *self = Self::new(self.rate_hz);
    }

    /// Number of fingers seen.
    pub fn n_fingers(&self) -> usize {
        self.pyramids.len()
    }

    /// Time of the first and the last tick, s; `None` when empty.
    pub fn span_s(&self) -> Option<(f64, f64)> {
        let first = self.first_tick?;
        Some((
            first as f64 / self.rate_hz,
            self.last_tick as f64 / self.rate_hz,
        ))
    }

    /// The line of a channel between two times (s), as runs of `[time_s, value]` broken where ticks are missing.
    ///
    /// Uses the finest level that needs at most `max_bins` bins and still reaches back to `from_s`; every extreme in the
    /// range is on the line. At most `2 * max_bins + 4` points, however long the time.
    pub fn line(
        &self,
        finger: usize,
        channel: Channel,
        from_s: f64,
        to_s: f64,
        max_bins: usize,
    ) -> Vec<Vec<[f64; 2]>> {
        let mut runs = Vec::new();
        let past = self.of(from_s, to_s);
        let Some(level) = past.level(finger, channel, from_s, to_s, max_bins) else {
            return runs;
        };
        let bin_s = level.ticks_per_bin as f64 / self.rate_hz;
        let (first, last) = past.bins_between(level, from_s, to_s);
        let mut run: Vec<[f64; 2]> = Vec::new();
        let mut empty_ticks = 0;
        for bin in first..last {
            let Some(band) = level.get(bin) else {
                empty_ticks += level.ticks_per_bin;
                if empty_ticks > BRIDGED && !run.is_empty() {
                    runs.push(std::mem::take(&mut run));
                }
                continue;
            };
            empty_ticks = 0;
            let mid = if level.ticks_per_bin == 1 { 0.0 } else { 0.5 };
            let time_s = (bin as f64 + mid) * bin_s;
            // The nearer end first, so that the line zigzags through the band without crossing it twice.
            let rising = run
                .last()
                .is_none_or(|p| (p[1] - band.min).abs() <= (p[1] - band.max).abs());
            let (a, b) = if rising {
                (band.min, band.max)
            } else {
                (band.max, band.min)
            };
            run.push([time_s, a]);
            if a != b {
                run.push([time_s, b]);
            }
        }
        if !run.is_empty() {
            runs.push(run);
        }
        runs
    }

    /// Smallest and largest value of a channel at a time (s), at the finest resolution still kept.
    pub fn at(&self, finger: usize, channel: Channel, time_s: f64) -> Option<Band> {
        if !time_s.is_finite() || time_s < 0.0 {
            return None;
        }
        let tick = (time_s * self.rate_hz).round() as u64;
        self.of(time_s, time_s)
            .pyramid(finger, channel)?
            .levels
            .iter()
            .find_map(|level| {
                let bin = tick / level.ticks_per_bin;
                let earliest = bin.saturating_sub(BRIDGED / level.ticks_per_bin);
                (earliest..=bin).rev().find_map(|bin| level.get(bin))
            })
    }

    /// Largest value of a channel over all fingers between two times (s); zero when there is none.
    pub fn largest(&self, channel: Channel, from_s: f64, to_s: f64) -> f64 {
        let mut largest: f64 = 0.0;
        let past = self.of(from_s, to_s);
        for finger in 0..past.pyramids.len() {
            let Some(level) = past.level(finger, channel, from_s, to_s, 4096) else {
                continue;
            };
            let (first, last) = past.bins_between(level, from_s, to_s);
            for band in (first..last).filter_map(|bin| level.get(bin)) {
                largest = largest.max(band.max);
            }
        }
        largest
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let near = self.near.as_ref().map_or(0, |near| near.bytes());
        let own: usize = self
            .pyramids
            .iter()
            .flatten()
            .flat_map(|p| &p.levels)
            .map(|l| l.bins.capacity() * size_of::<Band>())
            .sum();
        own + near
    }

    fn pyramid(&self, finger: usize, channel: Channel) -> Option<&Pyramid> {
        self.pyramids.get(finger).map(|p| &p[channel as usize])
    }

    fn level(
        &self,
        finger: usize,
        channel: Channel,
        from_s: f64,
        to_s: f64,
        max_bins: usize,
    ) -> Option<&Level> {
        let pyramid = self.pyramid(finger, channel)?;
        let (start_s, end_s) = self.span_s()?;
        let from_s = from_s.max(start_s);
        let ticks = (to_s.min(end_s) - from_s).max(0.0) * self.rate_hz;
        let fits = |l: &&Level| {
            ticks / l.ticks_per_bin as f64 <= max_bins as f64
                && l.first_bin * l.ticks_per_bin <= (from_s * self.rate_hz).ceil() as u64
        };
        pyramid
            .levels
            .iter()
            .find(fits)
            .or(pyramid.levels.last())
            .filter(|l| !l.bins.is_empty())
    }

    /// The bins of `level` from one before `from_s` to one after `to_s`, as far as they are kept.
    fn bins_between(&self, level: &Level, from_s: f64, to_s: f64) -> (u64, u64) {
        let bin_of = |s: f64| (s.max(0.0) * self.rate_hz / level.ticks_per_bin as f64) as u64;
        let first = bin_of(from_s).saturating_sub(1).max(level.first_bin);
        let last = bin_of(to_s).saturating_add(2).min(level.end_bin());
        (first, last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;

    fn record(tick: u64, finger: u8, normal_n: f64) -> FingerRecord {
        let mut r = FingerRecord {
            tick,
            finger,
            time_ns: tick.saturating_mul(1_000_000),
            ..FingerRecord::default()
        };
        r.contact.touch = Touch::Stick;
        r.contact.normal = Vec3::Z;
        r.contact.depth_mm = normal_n * 2.0;
        r.sent_force_n = Vec3::new(3.0, 4.0, normal_n);
        r
    }

    fn extremes(runs: &[Vec<[f64; 2]>]) -> (f64, f64) {
        runs.iter()
            .flatten()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), p| {
                (lo.min(p[1]), hi.max(p[1]))
            })
    }

    #[test]
    fn force_splits_into_normal_and_tangential() {
        let r = record(0, 0, 7.0);
        assert_eq!(Channel::NormalForce.of(&r), 7.0);
        assert_eq!(Channel::TangentialForce.of(&r), 5.0);
        assert_eq!(Channel::Depth.of(&r), 14.0);
        let free = FingerRecord::default();
        assert!(Channel::ALL.iter().all(|c| c.of(&free) == 0.0));
    }

    #[test]
    fn short_past_is_kept_tick_by_tick() {
        let mut history = History::new(1000.0);
        for tick in 0..500 {
            history.push(&record(tick, 0, tick as f64));
        }
        let runs = history.line(0, Channel::NormalForce, 0.1, 0.2, 1000);
        assert_eq!(runs.len(), 1);
        assert!(runs[0].contains(&[0.15, 150.0]));
        assert_eq!(history.span_s(), Some((0.0, 0.499)));
        let at = history.at(0, Channel::NormalForce, 0.3).expect("kept");
        assert_eq!((at.min, at.max), (300.0, 300.0));
    }

    #[test]
    fn a_single_spike_an_hour_ago_is_still_drawn_with_few_points() {
        let mut history = History::new(1000.0);
        let hour = 3_600_000;
        for tick in 0..hour {
            let value = if tick == 1234 { 9.0 } else { 1.0 };
            history.push(&record(tick, 0, value));
        }
        let runs = history.line(0, Channel::NormalForce, 0.0, 3600.0, 2000);
        assert_eq!(extremes(&runs), (1.0, 9.0));
        let points: usize = runs.iter().map(Vec::len).sum();
        assert!(points <= 2 * 2000 + 4, "{points} points");
        assert_eq!(history.largest(Channel::NormalForce, 0.0, 3600.0), 9.0);
        assert!(
            history.bytes() <= 3 * LEVELS * 2 * CAPACITY * size_of::<Band>(),
            "{} bytes",
            history.bytes()
        );
    }

    #[test]
    fn detail_is_read_where_it_covers_what_is_asked_for() {
        let mut history = History::new(1000.0);
        for tick in 0..600_000 {
            history.push(&record(tick, 0, (tick % 2) as f64));
        }
        let mut near = History::new(1000.0);
        for tick in 100_000..160_000 {
            near.push(&record(tick, 0, (tick % 2) as f64));
        }
        let points = |h: &History, from_s, to_s| -> usize {
            h.line(0, Channel::NormalForce, from_s, to_s, 4000)
                .iter()
                .map(Vec::len)
                .sum()
        };
        let coarse = points(&history, 120.0, 121.0);
        history.set_near(near);
        // Both ends of each bin of the next level, and a bin more at either end.
        let bins = 1000 / FACTOR as usize;
        assert!((2 * bins..=2 * bins + 6).contains(&coarse), "{coarse}");
        assert!(points(&history, 120.0, 121.0) >= 1000);
        // Half of it lies outside: all of it is coarse, with the same extremes.
        let outside = points(&history, 99.5, 100.5);
        assert!((2 * bins..=2 * bins + 6).contains(&outside), "{outside}");
        let at = history.at(0, Channel::NormalForce, 120.001).expect("kept");
        assert_eq!((at.min, at.max), (1.0, 1.0));
        assert_eq!(history.largest(Channel::NormalForce, 0.0, 600.0), 1.0);
    }

    #[test]
    fn missing_ticks_break_the_line() {
        let mut history = History::new(1000.0);
        for tick in (0..100).chain(200..300) {
            history.push(&record(tick, 0, 1.0));
        }
        assert_eq!(
            history
                .line(0, Channel::Depth, 0.0, 1.0, 1000)
                .iter()
                .map(Vec::len)
                .collect::<Vec<_>>(),
            [100, 100]
        );
    }

    #[test]
    fn a_late_tick_neither_shifts_nor_breaks_the_line() {
        let mut history = History::new(1000.0);
        for tick in 0..100 {
            let mut r = record(tick, 0, tick as f64);
            // From the 50th on everything is 20.4 ms late, with some jitter.
            if tick >= 50 {
                r.time_ns += 20_400_000 + (tick % 3) * 300_000;
            }
            history.push(&r);
        }
        let runs = history.line(0, Channel::NormalForce, 0.0, 1.0, 1000);
        assert_eq!(runs.len(), 1);
        assert_eq!(extremes(&runs), (0.0, 99.0));
        assert_eq!(history.span_s(), Some((0.0, 0.119)));
        let at = history.at(0, Channel::NormalForce, 0.06).expect("bridged");
        assert_eq!(at.max, 49.0);
    }

    #[test]
    fn a_jump_of_years_neither_fills_memory_nor_panics() {
        let mut history = History::new(1000.0);
        history.push(&record(5, 1, 1.0));
        history.push(&record(u64::MAX - 1, 1, 2.0));
        assert!(history.bytes() < 3 * 2 * LEVELS * 2 * CAPACITY * size_of::<Band>());
        assert_eq!(history.n_fingers(), 2);
    }

    #[test]
    fn nothing_and_nonsense_give_no_line() {
        let mut history = History::new(f64::NAN);
        assert!(history.line(0, Channel::Depth, 0.0, 1.0, 100).is_empty());
        history.push(&record(0, 0, f64::NAN));
        history.push(&record(1, 200, 1.0));
        assert!(
            history
                .line(0, Channel::NormalForce, 0.0, 1.0, 100)
                .is_empty()
        );
        assert!(
            history
                .line(3, Channel::NormalForce, f64::NAN, 1.0, 0)
                .is_empty()
        );
        assert_eq!(history.at(0, Channel::Depth, -1.0), None);
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(24))]
        #[test]
        fn every_level_shows_the_same_extremes(
            values in proptest::collection::vec(-5.0..5.0f64, 1..3000),
            max_bins in 1usize..4000,
        ) {
            let mut history = History::new(1000.0);
            for (tick, v) in values.iter().enumerate() {
                history.push(&record(tick as u64, 0, *v));
            }
            let runs = history.line(0, Channel::NormalForce, 0.0, values.len() as f64, max_bins);
            let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
            let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            proptest::prop_assert_eq!(extremes(&runs), (lo, hi));
        }
    }
}
