//! Whether the loop with a device holds: a servo without a scene.

use super::guard::Condition;
use super::vitals::Counts;
use crate::device::{Device, Reading};
use crate::geom::Vec3;
use std::time::{Duration, Instant};

/// How the loop is tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// How long, s.
    pub seconds: f64,
    /// Ticks in a second.
    pub rate_hz: f64,
    /// Stiffness of a plane of skin through the middle of the workspace, N/mm; 0: force stays off, nothing moves.
    pub skin_n_per_mm: f64,
}

/// What the loop came to.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Checked {
    /// How long it ran, s.
    pub seconds: f64,
    /// Ticks.
    pub ticks: u64,
    /// Ticks without a connected device, after the first with one.
    pub ticks_without: u64,
    /// How the device is at the end; absent for one without a link.
    pub condition: Option<Condition>,
    /// What its link counted.
    pub counts: Option<Counts>,
    /// Reports in a second, Hz.
    pub report_rate_hz: f64,
    /// Median time between reports, µs, to the upper edge of a bin of 100.
    pub interval_median_us: Option<f64>,
    /// What 99 % of these times do not pass, µs.
    pub interval_p99_us: Option<f64>,
    /// Median time from a report to the currents that answer it, µs.
    pub latency_median_us: Option<f64>,
    /// What 99 % of these times do not pass, µs.
    pub latency_p99_us: Option<f64>,
    /// Where the device is at the end, mm.
    pub position_mm: [f64; 3],
    /// Force sent at the end, N.
    pub force_n: [f64; 3],
}

impl Checked {
    /// What does not hold, if anything: it answers in nine of ten ticks, reports at half of `nominal_hz` at least, and loses one
    /// in a thousand at most. A device that speaks only when moved states 0 Hz and is not held to a rate.
    pub fn fault(&self, nominal_hz: f64) -> Option<String> {
        let condition = self.condition.unwrap_or_default();
        let never = condition == Condition::Waiting && nominal_hz > 0.0;
        if never || condition.is_latched() || condition.is_final() {
            return Some(condition.title().into());
        }
        if self.ticks_without * 10 > self.ticks {
            let (without, ticks) = (self.ticks_without, self.ticks);
            return Some(format!("no answer in {without} of {ticks} ticks"));
        }
        if self.report_rate_hz < 0.5 * nominal_hz {
            return Some(format!(
                "{:.0} reports a second; {nominal_hz:.0} are expected",
                self.report_rate_hz
            ));
        }
        let counts = self.counts?;
        (counts.lost * 1000 > counts.reports)
            .then(|| format!("{} of {} reports lost", counts.lost, counts.reports))
    }
}

/// Runs the loop until its time is over or `each`, which is told the share done, answers `false`. The device is not closed.
pub fn run(
    device: &mut dyn Device,
    trial: &Trial,
    mut each: impl FnMut(f64, &Reading) -> bool,
) -> Checked {
    let period = Duration::from_secs_f64(1.0 / trial.rate_hz.clamp(100.0, 10_000.0));
    let rated_n = device.capabilities().rated_force_n;
    device.enable(trial.skin_n_per_mm > 0.0);
    let started = Instant::now();
    let mut due = started;
    let (mut ticks, mut without, mut heard) = (0, 0, false);
    let (mut reading, mut force_n) = (Reading::default(), Vec3::ZERO);
    // As the tick has it: who comes back inside the skin feels nothing until he was outside.
    let mut was_outside = false;
    loop {
        let done = started.elapsed().as_secs_f64() / trial.seconds.max(1.0e-3);
        reading = if done < 1.0 && each(done, &reading) {
            device.read(period.as_secs_f64())
        } else {
            break;
        };
        ticks += 1;
        heard |= reading.connected;
        without += u64::from(heard && !reading.connected);
        force_n = Vec3::ZERO;
        was_outside = reading.is_usable() && (was_outside || reading.position_mm.z > 0.0);
        if was_outside && trial.skin_n_per_mm > 0.0 {
            let push_n = trial.skin_n_per_mm * (-reading.position_mm.z).max(0.0);
            force_n = Vec3::Z * push_n.min(rated_n);
        }
        device.write(force_n);
        due = (due + period).max(Instant::now() - period);
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
    let seconds = started.elapsed().as_secs_f64();
    let vitals = device.vitals();
    let counts = vitals.as_ref().map(|v| v.counts());
    let interval = |share| vitals.as_ref().and_then(|v| v.interval.quantile_us(share));
    let latency = |share| vitals.as_ref().and_then(|v| v.latency.quantile_us(share));
    Checked {
        seconds,
        ticks,
        ticks_without: without,
        condition: vitals.as_ref().map(|v| v.condition()),
        counts,
        report_rate_hz: counts.map_or(0.0, |c| c.reports as f64 / seconds),
        interval_median_us: interval(0.5),
        interval_p99_us: interval(0.99),
        latency_median_us: latency(0.5),
        latency_p99_us: latency(0.99),
        position_mm: reading.position_mm.to_array(),
        force_n: force_n.to_array(),
    }
}
