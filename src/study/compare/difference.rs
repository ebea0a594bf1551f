//! How far two recordings are apart, tick by tick and over time.

use super::super::frame::Felt;
use super::super::stats::{BlandAltman, bland_altman};
use super::super::{Analysis, StudyError};
use super::align::Align;
use super::dtw::{MOST_WARPED, warp};
use super::trace::{Trace, traces};
use crate::geom::Vec3;
use crate::session::{Entry, Records, Session, Strictness};
use serde::{Deserialize, Serialize};

/// How two recordings are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompareOptions {
    /// What goes with what.
    pub align: Align,
    /// Which finger, from 0.
    pub finger: u8,
    /// Half width of the band of warping, a share of the longer recording.
    pub band: f64,
}

impl Default for CompareOptions {
    /// Finger 0 by time; a band of a tenth.
    fn default() -> Self {
        Self {
            align: Align::Time,
            finger: 0,
            band: 0.1,
        }
    }
}

/// How far two series are apart; differences are second less first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Root of the mean square.
    pub rms: f64,
    /// Mean: of signed differences, and of positions the mean distance.
    pub mean: f64,
    /// Greatest size.
    pub max: f64,
    /// When, s of the first recording.
    pub max_at_s: f64,
}

/// Differences over time, in at most `MOST_BINS` equal bins of the first recording's time; bins without a pair are left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Middle of each bin, s of the first recording.
    pub time_s: Vec<f64>,
    /// Mean distance of the HIPs, mm.
    pub position_mm: Vec<f64>,
    /// Mean difference of the forces, N.
    pub force_n: Vec<f64>,
    /// Mean difference of the depths, mm.
    pub depth_mm: Vec<f64>,
    /// Greatest distance, mm.
    pub position_max_mm: Vec<f64>,
    /// Greatest size of the difference of the forces, N.
    pub force_max_n: Vec<f64>,
    /// Likewise of the depths, mm.
    pub depth_max_mm: Vec<f64>,
}

/// Most bins of a series.
pub const MOST_BINS: usize = 2000;
/// Length of the windows whose mean forces are compared for agreement, s.
const WINDOW_S: f64 = 1.0;

/// Two recordings beside each other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Names of the two.
    pub names: [String; 2],
    /// Which finger.
    pub finger: u8,
    /// How they are aligned, in words.
    pub aligned: String,
    /// Time in the second less time in the first of what goes together, s; with warping that of the start.
    pub shift_s: f64,
    /// Pairs of ticks, or of samples with warping.
    pub pairs: u64,
    /// Of them alike in every bit of position, force and depth; not counted with warping.
    pub identical: Option<u64>,
    /// From the first pair to the last, s of the first recording.
    pub overlap_s: f64,
    /// Distance of the HIPs, mm.
    pub position_mm: Spread,
    /// Difference of the forces of the skin, N.
    pub force_n: Spread,
    /// Difference of the depths, mm.
    pub depth_mm: Spread,
    /// All three over time.
    pub series: Series,
    /// Agreement of the mean forces in windows of a second, N. Windows that follow each other are not independent: the
    /// intervals of bias and limits are too narrow where motion is slow.
    pub force_agreement: Option<BlandAltman>,
    /// With warping: times that go together, s of the first and the second; empty otherwise.
    pub warp_s: Vec<[f64; 2]>,
    /// Mean distance of the warped samples, in standard deviations.
    pub warp_cost: Option<f64>,
}

impl Comparison {
    /// The time of the first recording that goes with a time of the second, s.
    pub fn first_time_s(&self, second_s: f64) -> f64 {
        let Some(last) = self.warp_s.len().checked_sub(1) else {
            return second_s - self.shift_s;
        };
        let after = self.warp_s.partition_point(|w| w[1] < second_s);
        self.warp_s[after.min(last)][0]
    }
}

/// Compares one finger of two sessions. `told` is what [`analyse`](super::super::analyse()) tells of each.
///
/// By time or event every tick of the first is paired with the nearest of the second, and nothing is resampled; with warping,
/// traces at 50 Hz, or fewer where either would have more than 6000 samples, are. Memory does not grow with the length.
///
/// # Errors
/// A file cannot be read or stays sealed, the event is in one of them missing, they do not overlap, or `progress` said stop.
pub fn compare(
    sessions: [&Session; 2],
    told: [&Analysis; 2],
    options: &CompareOptions,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Comparison, StudyError> {
    for session in sessions {
        if session.header().sealed {
            return Err(StudyError::Sealed {
                path: session.path().to_owned(),
            });
        }
        if usize::from(options.finger) >= session.header().n_fingers() {
            let (file, finger) = (session.path().display(), options.finger);
            let n = session.header().n_fingers();
            return Err(StudyError::TooLittle(format!(
                "{file}: finger {finger} is wanted, and there are {n}, counted from 0"
            )));
        }
    }
    let (shift_s, aligned) = match &options.align {
        Align::Time => (0.0, "by time".to_owned()),
        Align::Dtw => (0.0, "by dynamic time warping".to_owned()),
        Align::Event(anchor) => {
            let [a, b] = told.map(|t| anchor.time_s(t, options.finger));
            (b? - a?, format!("by {anchor}"))
        }
    };
    let mut comparison = Comparison {
        names: told.map(|t| t.about.name()),
        finger: options.finger,
        aligned,
        shift_s,
        ..Comparison::default()
    };
    // Bins go over the whole of the first recording, gaps included.
    let whole_s = told[0]
        .fingers
        .iter()
        .filter_map(|f| Some(f.phases.last()?.end_s));
    let mut gathered = Gathered::new(whole_s.fold(told[0].about.seconds, f64::max));
    if options.align == Align::Dtw {
        warped(
            sessions,
            told,
            options,
            &mut comparison,
            &mut gathered,
            progress,
        )?;
    } else {
        comparison.identical = Some(tick_by_tick(
            sessions,
            options.finger,
            shift_s,
            &mut gathered,
            progress,
        )?);
    }
    if gathered.n == 0 {
        let [a, b] = sessions.map(|s| s.path().display());
        return Err(StudyError::TooLittle(format!(
            "{a} and {b}: aligned {}, no tick of finger {} falls together",
            comparison.aligned, options.finger
        )));
    }
    gathered.tell(&mut comparison);
    progress(1.0);
    Ok(comparison)
}

/// What of a tick is compared.
#[derive(Clone, Copy)]
struct Point {
    position_mm: Vec3,
    force_n: f64,
    depth_mm: f64,
}

/// One finger's ticks that have a place, numbered from the session's first.
struct Ticks {
    entries: Records,
    finger: u8,
    first: Option<u64>,
    read: u64,
}

impl Ticks {
    fn new(session: &Session, finger: u8) -> Result<Self, StudyError> {
        Ok(Self {
            entries: session.entries(Strictness::Lenient)?,
            finger,
            first: None,
            read: 0,
        })
    }

    fn next(&mut self) -> Result<Option<(u64, Point)>, StudyError> {
        for entry in self.entries.by_ref() {
            let Entry::Tick(record) = entry? else {
                continue;
            };
            let first = *self.first.get_or_insert(record.tick);
            self.read += 1;
            let position_mm = record.reading.position_mm;
            if record.finger != self.finger || !record.reading.is_usable() {
                continue;
            }
            let felt = Felt::of(&record);
            let point = Point {
                position_mm,
                force_n: felt.map_or(0.0, |f| f.force_n),
                depth_mm: felt.map_or(0.0, |f| f.depth_mm),
            };
            return Ok(Some((record.tick.saturating_sub(first), point)));
        }
        Ok(None)
    }
}

/// Pairs the ticks of two sessions; gives back how many pairs are alike bit for bit.
fn tick_by_tick(
    sessions: [&Session; 2],
    finger: u8,
    shift_s: f64,
    gathered: &mut Gathered,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<u64, StudyError> {
    let [dt_a, dt_b] = sessions.map(|s| s.header().dt_s());
    let (mut a, mut b) = (
        Ticks::new(sessions[0], finger)?,
        Ticks::new(sessions[1], finger)?,
    );
    let mut newest = b.next()?;
    let mut identical = 0;
    while let Some((tick, first)) = a.next()? {
        if a.read.is_multiple_of(4096) && !progress(a.entries.progress()) {
            return Err(StudyError::Stopped);
        }
        let time_s = tick as f64 * dt_a;
        // The tick of the second nearest in time.
        let wanted = libm::round((time_s + shift_s) / dt_b);
        if wanted < 0.0 {
            continue;
        }
        let wanted = wanted as u64;
        while let Some((number, _)) = newest
            && number < wanted
        {
            newest = b.next()?;
        }
        match newest {
            None => break,
            Some((number, second)) if number == wanted => {
                gathered.add(time_s, first, second);
                let bits = |p: &Point| {
                    let [x, y, z] = p.position_mm.to_array();
                    [x, y, z, p.force_n, p.depth_mm].map(f64::to_bits)
                };
                identical += u64::from(bits(&first) == bits(&second));
            }
            Some(_) => {}
        }
    }
    Ok(identical)
}

fn warped(
    sessions: [&Session; 2],
    told: [&Analysis; 2],
    options: &CompareOptions,
    comparison: &mut Comparison,
    gathered: &mut Gathered,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<(), StudyError> {
    let finger = usize::from(options.finger);
    let mut read = |i: usize| -> Result<Trace, StudyError> {
        let half = 0.4 * i as f64;
        let mut all = traces(sessions[i], told[i].about.ticks, &mut |done| {
            progress(half + 0.4 * done)
        })?;
        Ok(all.swap_remove(finger).thinned(MOST_WARPED))
    };
    let (a, b) = (read(0)?, read(1)?);
    let found = warp(&a, &b, options.band).ok_or_else(|| {
        let [a, b] = sessions.map(|s| s.path().display());
        StudyError::TooLittle(format!(
            "{a} and {b}: one has no tick of finger {finger} to warp"
        ))
    })?;
    let point = |trace: &Trace, i: u32| {
        let i = i as usize;
        Point {
            position_mm: Vec3::from_array(trace.position_mm[i].map(f64::from)),
            force_n: trace.force_n[i].into(),
            depth_mm: trace.depth_mm[i].into(),
        }
    };
    for [i, j] in &found.pairs {
        gathered.add(a.time_s(*i as usize), point(&a, *i), point(&b, *j));
    }
    let times = found.pairs.iter();
    comparison.warp_s = times
        .map(|[i, j]| [a.time_s(*i as usize), b.time_s(*j as usize)])
        .collect();
    comparison.warp_cost = Some(found.cost / found.pairs.len().max(1) as f64);
    Ok(())
}

/// One quantity's differences.
#[derive(Clone, Copy, Default)]
struct Sum {
    squares: f64,
    sum: f64,
    max: f64,
    max_at_s: f64,
}

impl Sum {
    fn add(&mut self, time_s: f64, difference: f64) {
        self.squares += difference * difference;
        self.sum += difference;
        if difference.abs() > self.max {
            (self.max, self.max_at_s) = (difference.abs(), time_s);
        }
    }

    fn spread(&self, n: u64) -> Spread {
        let n = n.max(1) as f64;
        Spread {
            rms: (self.squares / n).sqrt(),
            mean: self.sum / n,
            max: self.max,
            max_at_s: self.max_at_s,
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Bin {
    n: u64,
    sums: [Sum; 3],
}

struct Gathered {
    n: u64,
    first_s: f64,
    last_s: f64,
    bin_s: f64,
    sums: [Sum; 3],
    bins: Vec<Bin>,
    /// Mean forces of the window that is open: its number, pairs, sums of both.
    window: (u64, u64, [f64; 2]),
    windows: Vec<[f64; 2]>,
}

impl Gathered {
    fn new(seconds: f64) -> Self {
        let seconds = if seconds.is_finite() {
            seconds.max(1e-3)
        } else {
            1e-3
        };
        Self {
            n: 0,
            first_s: 0.0,
            last_s: 0.0,
            bin_s: (seconds / MOST_BINS as f64).max(1e-3),
            sums: Default::default(),
            bins: vec![Bin::default(); MOST_BINS],
            window: (0, 0, [0.0; 2]),
            windows: Vec::new(),
        }
    }

    fn add(&mut self, time_s: f64, first: Point, second: Point) {
        if self.n == 0 {
            self.first_s = time_s;
        }
        self.last_s = time_s;
        self.n += 1;
        let bin = ((time_s / self.bin_s) as usize).min(MOST_BINS - 1);
        let bin = &mut self.bins[bin];
        bin.n += 1;
        let differences = [
            first.position_mm.distance(second.position_mm),
            second.force_n - first.force_n,
            second.depth_mm - first.depth_mm,
        ];
        for (i, difference) in differences.into_iter().enumerate() {
            self.sums[i].add(time_s, difference);
            bin.sums[i].add(time_s, difference);
        }
        let number = (time_s / WINDOW_S) as u64;
        if number != self.window.0 {
            self.end_window();
            self.window.0 = number;
        }
        self.window.1 += 1;
        self.window.2[0] += first.force_n;
        self.window.2[1] += second.force_n;
    }

    fn end_window(&mut self) {
        let (_, n, sums) = self.window;
        if n > 0 {
            self.windows.push(sums.map(|sum| sum / n as f64));
        }
        self.window = (0, 0, [0.0; 2]);
    }

    fn tell(mut self, into: &mut Comparison) {
        self.end_window();
        into.pairs = self.n;
        into.overlap_s = self.last_s - self.first_s;
        [into.position_mm, into.force_n, into.depth_mm] = self.sums.map(|s| s.spread(self.n));
        let series = &mut into.series;
        for (i, bin) in self.bins.iter().enumerate().filter(|(_, b)| b.n > 0) {
            let [position, force, depth] = bin.sums.map(|s| s.spread(bin.n));
            series.time_s.push((i as f64 + 0.5) * self.bin_s);
            series.position_mm.push(position.mean);
            series.force_n.push(force.mean);
            series.depth_mm.push(depth.mean);
            series.position_max_mm.push(position.max);
            series.force_max_n.push(force.max);
            series.depth_max_mm.push(depth.max);
        }
        into.force_agreement = bland_altman(self.windows);
    }
}
