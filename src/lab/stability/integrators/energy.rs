//! Energy over time, on both sides of the limit.

use super::{coloured, omega_per_s, single};
use crate::figure::{LinePlot, Scale, Series};
use crate::reference::springs::motion::Motion;

/// Energy of one spring over time, explicit just below and just above the limit, and without a limit.
pub(super) fn energies(quick: bool) -> Vec<LinePlot> {
    let lattice = single();
    let omega = omega_per_s();
    let limit_s = 2.0 / omega;
    let many = if quick { 60 } else { 400 };
    let start = |share: f64| {
        let mut motion = Motion::new(&lattice, 0.0);
        motion.at_mm[1].x += 1.0;
        (motion, share * limit_s)
    };
    let mut explicit = Vec::new();
    for share in [0.99, 0.999, 1.0001, 1.001, 1.01] {
        let (mut motion, dt_s) = start(share);
        let points = (0..many).map(|i| {
            let now = [f64::from(i) * dt_s, motion.energy_n_mm().max(1.0e-12)];
            motion.step_explicit(&[], dt_s);
            now
        });
        explicit.push(Series {
            name: format!("{share} of the limit"),
            points: points.take_while(|p| p[1] < 1.0e9).collect(),
            ..Series::default()
        });
    }
    let mut always = Vec::new();
    for share in [0.05, 0.2, 1.001] {
        let (mut motion, dt_s) = start(share);
        let points = (0..many).map(|i| {
            let now = [f64::from(i) * dt_s, motion.energy_n_mm()];
            let _ = motion.step_implicit(&[], dt_s);
            now
        });
        always.push(Series {
            name: format!("implicit, {share} of the explicit limit"),
            points: points.take_while(|p| p[1] > 1.0e-9).collect(),
            ..Series::default()
        });
    }
    let plot = |title: &str, series: Vec<Series>| LinePlot {
        title: title.to_owned(),
        x_label: "time (s)".to_owned(),
        y_label: "energy (N·mm)".to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Logarithmic,
        series: coloured(series),
    };
    vec![
        plot("Explicit steps just below and just above ω h = 2", explicit),
        plot("Implicit steps damp the more, the longer they are", always),
    ]
}
