//! Sums over frames, and the measures they come to.

use super::frame::{Frame, Sums};
use super::metrics::Metrics;
use super::presses::{Press, PressKind};
use super::smooth::{Smoothness, Windows};

/// What frames of one finger, or of one sort, add up to.
#[derive(Clone, Debug, Default)]
pub(super) struct Total {
    sums: Sums,
    windows: Windows,
    /// Number of the last frame: the next one follows on it, or the movement is cut.
    last: Option<u64>,
}

/// Cells touched, and what they are of.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Covered {
    pub cells: u64,
    /// Of them on the skin of the scene.
    pub skin: u64,
}

/// What measures need beside sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub dt_s: f64,
    pub cell_mm: f64,
    pub bands: usize,
    /// Area of the back on the map plane; `None` where the surface is not at hand.
    pub skin_mm2: Option<f64>,
}

impl Total {
    pub(super) fn add(&mut self, frame: &Frame, rate_hz: f64, with: &mut Smoothness) {
        if self.last.is_some_and(|last| last + 1 != frame.index) {
            self.windows.end(rate_hz, with);
        }
        self.last = Some(frame.index);
        self.sums.add(&frame.sums);
        self.windows.push(frame.speed_mm_s, rate_hz, with);
    }

    pub(super) fn finish(&mut self, rate_hz: f64, with: &mut Smoothness) {
        self.windows.end(rate_hz, with);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        self.sums.add(&other.sums);
        self.windows.merge(&other.windows);
    }

    pub(super) fn metrics<'a>(
        &self,
        scale: &Scale,
        covered: Covered,
        presses: impl Iterator<Item = &'a Press>,
    ) -> Metrics {
        let s = &self.sums;
        let mean = |sum: f64, n: f64| (n > 0.0).then(|| sum / n);
        let cell_mm2 = scale.cell_mm * scale.cell_mm;
        let contact = s.contact_ticks as f64;
        let seconds = |ticks: u64| ticks as f64 * scale.dt_s;
        let (mut n, mut strokes) = (0_u32, 0_u32);
        let mut press_sums = [0.0; 3];
        for press in presses {
            if press.kind == PressKind::Stroke {
                strokes += 1;
                continue;
            }
            n += 1;
            let of = [press.seconds(), press.peak_force_n, press.peak_depth_mm];
            for (sum, value) in press_sums.iter_mut().zip(of) {
                *sum += value;
            }
        }
        let [press_s, press_peak_n, press_depth_mm] = press_sums.map(|sum| mean(sum, n.into()));
        Metrics {
            duration_s: seconds(s.ticks),
            contact_s: seconds(s.contact_ticks),
            path_hip_mm: s.path_hip_mm,
            path_hip_contact_mm: s.path_hip_contact_mm,
            path_skin_mm: s.path_skin_mm,
            coverage_mm2: covered.cells as f64 * cell_mm2,
            coverage_percent: (scale.skin_mm2.filter(|back| *back > 0.0))
                .map(|back| (100.0 * covered.skin as f64 * cell_mm2 / back).min(100.0)),
            peak_force_n: s.peak_force_n,
            mean_force_n: mean(s.force_sum_n, contact),
            impulse_n_s: s.force_sum_n * scale.dt_s,
            peak_depth_mm: s.peak_depth_mm,
            mean_depth_mm: mean(s.depth_sum_mm, contact),
            band_s: s
                .band_ticks
                .iter()
                .take(scale.bands)
                .map(|t| seconds(*t))
                .collect(),
            mean_speed_mm_s: mean(s.path_hip_mm, s.moved_s),
            contact_speed_mm_s: mean(s.path_hip_contact_mm, s.moved_contact_s),
            peak_speed_mm_s: s.peak_speed_mm_s,
            sparc: self.windows.sparc(),
            log_jerk: self.windows.log_jerk(),
            presses: n,
            strokes,
            press_s,
            press_peak_n,
            press_depth_mm,
            tender_presses: s.tender_known.then_some(s.tender_presses),
            tender_s: s.tender_known.then(|| seconds(s.tender_ticks)),
            limited_ticks: s.limited,
            late_ticks: s.late,
            lost_ticks: s.lost,
        }
    }
}
