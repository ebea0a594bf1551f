//! Measures of a session, a finger or a phase, and the one list that all tables go by.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Measures. What does not exist, such as a mean over nothing, is absent.
///
/// Force is that of the skin on the finger before a device limits it: a mouse presses too. A frame is 10 ms (a tick where
/// ticks are rarer); speed and the way of the HIP go by the mean position of each frame, so that the tremor of a sensor is
/// not counted as way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metrics {
    /// Recorded time, s.
    pub duration_s: f64,
    /// Time on the skin, s.
    pub contact_s: f64,
    /// Way of the HIP, mm.
    pub path_hip_mm: f64,
    /// Way of the HIP while on the skin, mm.
    pub path_hip_contact_mm: f64,
    /// Way of the proxy over the skin, tick by tick, mm.
    pub path_skin_mm: f64,
    /// Area of the cells touched, mm² on the map plane.
    pub coverage_mm2: f64,
    /// Share of the cells of the back that were touched, percent; absent where the surface is not at hand.
    pub coverage_percent: Option<f64>,
    /// Largest force, N.
    pub peak_force_n: f64,
    /// Mean over the time on the skin, N.
    pub mean_force_n: Option<f64>,
    /// Force times time, N·s.
    pub impulse_n_s: f64,
    /// Greatest depth, mm.
    pub peak_depth_mm: f64,
    /// Mean depth over the time on the skin, mm.
    pub mean_depth_mm: Option<f64>,
    /// Time on the skin in each band of force, from the lowest, s.
    pub band_s: Vec<f64>,
    /// Mean speed of the HIP, mm/s.
    pub mean_speed_mm_s: Option<f64>,
    /// Mean speed of the HIP while on the skin, mm/s.
    pub contact_speed_mm_s: Option<f64>,
    /// Largest speed of the HIP from frame to frame, mm/s.
    pub peak_speed_mm_s: f64,
    /// Spectral arc length; see [`super::smooth`].
    pub sparc: Option<f64>,
    /// Log dimensionless jerk; see [`super::smooth`].
    pub log_jerk: Option<f64>,
    /// Presses that stayed in place.
    pub presses: u32,
    /// Presses that moved over the skin.
    pub strokes: u32,
    /// Mean duration of a press, s; strokes are left out here and below.
    pub press_s: Option<f64>,
    /// Mean of the presses' largest forces, N.
    pub press_peak_n: Option<f64>,
    /// Mean of the presses' greatest depths, mm.
    pub press_depth_mm: Option<f64>,
    /// How often a tender place was pressed beyond what it bears; absent where the scenario cannot be read.
    pub tender_presses: Option<u32>,
    /// For how long, s.
    pub tender_s: Option<f64>,
    /// Ticks in which a limit changed the force.
    pub limited_ticks: u64,
    /// Ticks that came too late.
    pub late_ticks: u64,
    /// Ticks that are missing.
    pub lost_ticks: u64,
}

/// One measure.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Name in files; tells the unit.
    pub key: &'static str,
    /// Name for people; of a band of force with the bounds that hold unless others are stated.
    pub title: &'static str,
    /// Unit; empty for counts and pure numbers.
    pub unit: &'static str,
    /// What it is, in a sentence.
    pub about: &'static str,
    /// Reads it.
    pub get: fn(&Metrics) -> Option<f64>,
}

impl Metric {
    /// Name for people where the bands of force have these edges, N: such as "Force 0.5–2 N".
    pub fn title_at(&self, edges_n: &[f64]) -> Cow<'static, str> {
        let named = self.band().and_then(|i| {
            let above = i.checked_sub(1).map(|i| edges_n.get(i));
            Some(match (above, edges_n.get(i)) {
                (None, Some(to)) => format!("Force below {to} N"),
                (Some(Some(from)), Some(to)) => format!("Force {from}–{to} N"),
                (Some(Some(from)), None) => format!("Force {from} N and more"),
                (None | Some(None), None) | (Some(None), Some(_)) => return None,
            })
        });
        named.map_or(Cow::Borrowed(self.title), Cow::Owned)
    }

    /// Such as "Path length (mm)".
    pub fn heading_at(&self, edges_n: &[f64]) -> String {
        with_unit(&self.title_at(edges_n), self.unit)
    }

    /// Such as "path length (mm)", for an axis.
    pub fn axis_at(&self, edges_n: &[f64]) -> String {
        with_unit(&lowered(&self.title_at(edges_n)), self.unit)
    }

    /// Which band of force it is the time in, from 0.
    fn band(&self) -> Option<usize> {
        let number = self.key.strip_prefix("band_")?.strip_suffix("_s")?;
        number.parse::<usize>().ok()?.checked_sub(1)
    }
}

fn with_unit(text: &str, unit: &str) -> String {
    match unit {
        "" => text.to_owned(),
        unit => format!("{text} ({unit})"),
    }
}

/// A text that begins small.
fn lowered(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next();
    first
        .into_iter()
        .flat_map(char::to_lowercase)
        .chain(letters)
        .collect()
}

/// The measure with this key.
pub fn by_key(key: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|m| m.key == key)
}

const fn metric(
    key: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    get: fn(&Metrics) -> Option<f64>,
) -> Metric {
    Metric {
        key,
        title,
        unit,
        about,
        get,
    }
}

/// Every measure, in the order of tables.
#[rustfmt::skip]
pub static METRICS: &[Metric] = &[
    metric("duration_s", "Finger time", "s", "Recorded time; of all fingers together, the sum of theirs.", |m| Some(m.duration_s)),
    metric("contact_s", "Contact time", "s", "Time on the skin.", |m| Some(m.contact_s)),
    metric("path_hip_mm", "Path of the finger", "mm", "Way of the HIP, on the skin and off it, by its mean positions in frames of 10 ms.", |m| Some(m.path_hip_mm)),
    metric("path_hip_contact_mm", "Path in contact", "mm", "Way of the HIP while on the skin.", |m| Some(m.path_hip_contact_mm)),
    metric("path_skin_mm", "Path on the skin", "mm", "Way of the proxy over the skin, tick by tick.", |m| Some(m.path_skin_mm)),
    metric("coverage_mm2", "Area covered", "mm²", "Area of the cells touched, on the map plane.", |m| Some(m.coverage_mm2)),
    metric("coverage_percent", "Coverage", "%", "Share of the cells of the back that were touched.", |m| m.coverage_percent),
    metric("peak_force_n", "Peak force", "N", "Largest force of the skin on the finger.", |m| Some(m.peak_force_n)),
    metric("mean_force_n", "Mean force", "N", "Mean over the time on the skin.", |m| m.mean_force_n),
    metric("impulse_n_s", "Impulse", "N·s", "Force times time.", |m| Some(m.impulse_n_s)),
    metric("peak_depth_mm", "Peak depth", "mm", "Greatest depth of the HIP below the skin.", |m| Some(m.peak_depth_mm)),
    metric("mean_depth_mm", "Mean depth", "mm", "Mean over the time on the skin.", |m| m.mean_depth_mm),
    metric("band_1_s", "Force below 0.5 N", "s", "Time on the skin below the first edge, 0.5 N unless stated.", |m| m.band_s.first().copied()),
    metric("band_2_s", "Force 0.5–2 N", "s", "Time between the first and the second edge, 0.5 to 2 N unless stated.", |m| m.band_s.get(1).copied()),
    metric("band_3_s", "Force 2–4 N", "s", "Time in the third band, 2 to 4 N unless stated.", |m| m.band_s.get(2).copied()),
    metric("band_4_s", "Force 4–8 N", "s", "Time in the fourth band, 4 to 8 N unless stated.", |m| m.band_s.get(3).copied()),
    metric("band_5_s", "Force 8 N and more", "s", "Time in the fifth band, 8 N and more unless stated.", |m| m.band_s.get(4).copied()),
    metric("mean_speed_mm_s", "Mean speed", "mm/s", "Mean speed of the HIP.", |m| m.mean_speed_mm_s),
    metric("contact_speed_mm_s", "Speed in contact", "mm/s", "Mean speed of the HIP while on the skin.", |m| m.contact_speed_mm_s),
    metric("peak_speed_mm_s", "Peak speed", "mm/s", "Largest speed of the HIP from frame to frame.", |m| Some(m.peak_speed_mm_s)),
    metric("sparc", "Smoothness (SPARC)", "", "Spectral arc length of the speed; nearer to 0 is smoother.", |m| m.sparc),
    metric("log_jerk", "Smoothness (LDLJ)", "", "Log dimensionless jerk of the speed; nearer to 0 is smoother.", |m| m.log_jerk),
    metric("presses", "Presses", "", "Presses that stayed in place.", |m| Some(f64::from(m.presses))),
    metric("strokes", "Strokes", "", "Presses that moved over the skin.", |m| Some(f64::from(m.strokes))),
    metric("press_s", "Press duration", "s", "Mean over the presses.", |m| m.press_s),
    metric("press_peak_n", "Press force", "N", "Mean of the presses' largest forces.", |m| m.press_peak_n),
    metric("press_depth_mm", "Press depth", "mm", "Mean of the presses' greatest depths.", |m| m.press_depth_mm),
    metric("tender_presses", "Tenderness exceeded", "", "How often a tender place was pressed beyond what it bears.", |m| m.tender_presses.map(f64::from)),
    metric("tender_s", "Time beyond tenderness", "s", "For how long.", |m| m.tender_s),
    metric("limited_ticks", "Limited ticks", "", "Ticks in which a limit changed the force.", |m| Some(m.limited_ticks as f64)),
    metric("late_ticks", "Late ticks", "", "Ticks that came later than the watchdog allows.", |m| Some(m.late_ticks as f64)),
    metric("lost_ticks", "Lost ticks", "", "Ticks that are missing.", |m| Some(m.lost_ticks as f64)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_single_and_a_measure_of_nothing_is_finite_or_absent() {
        let blank = Metrics::default();
        for (i, metric) in METRICS.iter().enumerate() {
            assert!(
                METRICS[..i].iter().all(|m| m.key != metric.key),
                "{}",
                metric.key
            );
            assert!((metric.get)(&blank).is_none_or(f64::is_finite));
            assert!(metric.about.ends_with('.') && !metric.title.is_empty());
        }
        assert_eq!(by_key("sparc").map(|m| m.title), Some("Smoothness (SPARC)"));
    }

    #[test]
    fn a_band_of_force_tells_its_bounds() {
        let usual = crate::study::Options::default().force_bands_n;
        for metric in METRICS {
            assert_eq!(metric.title_at(&usual), metric.title, "{}", metric.key);
        }
        let title = |key: &str, edges: &[f64]| by_key(key).map(|m| m.heading_at(edges));
        assert_eq!(
            title("band_1_s", &[1.0, 3.5]).as_deref(),
            Some("Force below 1 N (s)")
        );
        assert_eq!(
            title("band_2_s", &[1.0, 3.5]).as_deref(),
            Some("Force 1–3.5 N (s)")
        );
        assert_eq!(
            title("band_3_s", &[1.0, 3.5]).as_deref(),
            Some("Force 3.5 N and more (s)")
        );
        let sparc = by_key("sparc").map(|m| m.axis_at(&usual));
        assert_eq!(sparc.as_deref(), Some("smoothness (SPARC)"));
    }
}
