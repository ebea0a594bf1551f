//! What the passivity controller does: how stiff a skin may be with it, what energy it holds back, and what it costs in feel.

use super::closed_loop::{Bench, Class, Loop, Moment, Outcome, UNLIMITED};
use super::devices::{Haptic, LINEAR};
use super::plant::Hand;
use super::search::{Border, Fineness, Tally, on_all_processors, tap_border};
use super::theory::passive_stiffness_n_per_mm;
use crate::figure::{LinePlot, Mark, Scale, Series};
use crate::lab::{Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use crate::servo::Limits;
use serde::{Deserialize, Serialize};

/// The passivity controller beside none.
pub struct StabilityController;

/// A loop without its stiffness and the controller.
#[derive(Clone, Copy)]
struct Case {
    device: Haptic,
    hand: Hand,
    rate_hz: f64,
    delay_ticks: f64,
}

impl Case {
    fn at(&self, stiffness_n_per_mm: f64, controlled: bool) -> Loop {
        Loop {
            plant: self.device.held_by(&self.hand),
            stiffness_n_per_mm,
            rate_hz: self.rate_hz,
            delay_ticks: self.delay_ticks,
            quantum_mm: self.device.quantum_mm,
            limits: Limits {
                passivity: controlled,
                ..UNLIMITED
            },
        }
    }

    /// Prompt and without encoder steps: what the observer counts is what happens.
    fn is_seen(&self) -> bool {
        self.delay_ticks == 0.0 && self.device.quantum_mm == 0.0
    }
}

/// A case with and without the controller.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Found {
    borders: [Border; 2],
    /// On a skin twice as stiff as the loop bears without.
    twice: Option<[Outcome; 2]>,
}

/// Without the controller, and with it.
const BOTH: [bool; 2] = [false, true];
/// How far figures with it may fall behind those without, a factor: the resolution of the search.
const SLACK: f64 = 1.08;
/// Colours of the runs without and with it.
const WITHOUT: [u8; 3] = [196, 124, 20];
const WITH: [u8; 3] = [24, 26, 30];
/// How long the drawn run is, s.
const DRAWN_S: f64 = 0.6;

impl Experiment for StabilityController {
    fn name(&self) -> &'static str {
        "stability-controller"
    }

    fn about(&self) -> &'static str {
        "The loop with and without the passivity controller: largest stiffness, energy, cost in feel"
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let bench = Bench::new()?;
        let mut report = Report::default();
        report.set(
            "skin",
            "flat, uniform stiffness, production contact engine, the servo's own tick",
        );
        report.set(
            "device",
            format!(
                "{} g, {} N·s/mm",
                LINEAR.mass_kg * 1e3,
                LINEAR.damping_n_s_per_mm
            ),
        );
        let mut tally = Tally::default();
        tally += borders(&bench, setup, &mut report, &mut watch.part(0.0, 0.8))?;
        watch.at("energy over time", 0.8)?;
        tally += energy(&bench, &mut report);
        watch.at("what it feels like", 0.9)?;
        felt(&bench, setup, &mut report);
        report.verdicts.push(Verdict::must(
            "values that are not finite, and forces that pull, over all trials",
            format!(
                "{} in {} ticks",
                tally.not_finite + tally.over_limit,
                tally.ticks
            ),
            "0",
            tally.not_finite + tally.over_limit == 0,
        ));
        report.note(
            "The controller counts the force it sent against the way the finger went (Hannaford & Ryu 2002), less what the \
             skin stores, and damps at most by kT/2, which is what sampling and holding costs. With a delay it counts the \
             force of now for the way of now while the force of a tick ago acted: there it helps little. With encoder steps \
             it trades a swing that is seen for a buzz of some µm, so that the border of a perfect rest may even fall: see the \
             amplitudes.",
        );
        Ok(report)
    }
}

fn cases(quick: bool) -> Vec<Case> {
    let rates: &[f64] = if quick {
        &[1000.0]
    } else {
        &[100.0, 300.0, 1000.0, 10_000.0]
    };
    let stepped = Haptic {
        quantum_mm: 0.03,
        coulomb_n: 0.1,
        ..LINEAR
    };
    let mut cases = Vec::new();
    for hand in [Hand::NONE, Hand::middle()] {
        for &rate_hz in rates {
            for (device, delay_ticks) in
                [(LINEAR, 0.0), (LINEAR, 0.5), (LINEAR, 1.0), (stepped, 0.0)]
            {
                cases.push(Case {
                    device,
                    hand,
                    rate_hz,
                    delay_ticks,
                });
            }
        }
    }
    cases
}

fn look(bench: &Bench, fineness: Fineness, case: &Case) -> Found {
    let borders = BOTH.map(|on| tap_border(bench, fineness, |k| case.at(k, on)));
    let twice = borders[0].stiffness_n_per_mm;
    Found {
        borders,
        twice: twice.map(|k| BOTH.map(|on| bench.tap(&case.at(2.0 * k, on)))),
    }
}

fn borders(
    bench: &Bench,
    setup: &Setup,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let fineness = if setup.quick {
        Fineness {
            stride: 4.0,
            resolution: 1.08,
        }
    } else {
        Fineness {
            stride: 1.3,
            resolution: 1.02,
        }
    };
    let cases = cases(setup.quick);
    let mut table = Table::new(
        "largest-stiffness",
        "Stiffest skin on which a tap rests, and what a skin twice as stiff as without the controller does",
        &[
            "hand",
            "rate (Hz)",
            "delay (ticks)",
            "step (mm)",
            "friction (N)",
            "passive limit (N/mm)",
            "without (N/mm)",
            "with (N/mm)",
            "with / without",
            "twice: without",
            "twice: with",
            "amplitude without (mm)",
            "amplitude with (mm)",
            "given out without (mJ)",
            "given out with (mJ)",
        ],
    );
    let mut tally = Tally::default();
    let (mut least, mut most_given) = (f64::INFINITY, 0.0_f64);
    let mut seen = Vec::new();
    for (i, some) in cases.chunks(4).enumerate() {
        let share = 4.0 * i as f64 / cases.len() as f64;
        watch.at(&format!("borders at {} Hz", some[0].rate_hz), share)?;
        let hand = if some[0].hand == Hand::NONE {
            "none"
        } else {
            "middle"
        };
        let key = format!("controller {hand} {} Hz", some[0].rate_hz);
        let found: Vec<Found> = setup.shelf.part(&key, || {
            Ok(on_all_processors(some, |c| look(bench, fineness, c)))
        })?;
        for (case, found) in some.iter().zip(found) {
            for border in &found.borders {
                tally += border.tally;
            }
            for outcome in found.twice.iter().flatten() {
                tally += Tally::from(outcome);
            }
            let [without, with] = found.borders.map(|b| b.stiffness_n_per_mm);
            let or_infinite = |k: Option<f64>| k.unwrap_or(f64::INFINITY);
            let factor = or_infinite(with) / or_infinite(without);
            if case.is_seen() && without.is_some() {
                least = least.min(factor);
                seen.push(factor);
                if let Some([without, with]) = found.twice {
                    most_given = most_given.max(with.given_mj / without.given_mj);
                }
            }
            let period_s = 1.0 / case.rate_hz;
            let b = case.device.damping_n_s_per_mm;
            let twice = |on: usize| found.twice.map(|o| o[on]);
            let amplitude = |on: usize| {
                let swings = twice(on).filter(|o| o.class == Class::LimitCycle);
                swings.map(|o| o.amplitude_mm)
            };
            table.push([
                hand.into(),
                case.rate_hz.into(),
                case.delay_ticks.into(),
                case.device.quantum_mm.into(),
                case.device.coulomb_n.into(),
                passive_stiffness_n_per_mm(b, period_s, case.delay_ticks * period_s, 0.0).into(),
                without.into(),
                with.into(),
                factor.into(),
                twice(0).map(|o| o.class.name()).into(),
                twice(1).map(|o| o.class.name()).into(),
                amplitude(0).into(),
                amplitude(1).into(),
                twice(0).map(|o| o.given_mj).into(),
                twice(1).map(|o| o.given_mj).into(),
            ]);
        }
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::must(
        "prompt forces, no encoder steps: stiffness it bears with over without, least",
        format!("{least:.2}"),
        format!("1 or more, to {:.0} %", 100.0 * (SLACK - 1.0)),
        least >= 1.0 / SLACK,
    ));
    let what = "the same, on a skin twice as stiff as it bears without: energy given out with over without, most";
    let measured = format!("{most_given:.3}");
    report.verdicts.push(Verdict::must(
        what,
        &measured,
        "less than 1",
        most_given < 1.0,
    ));
    report.verdicts.push(Verdict::told(
        what,
        &measured,
        "0.5 or less",
        most_given <= 0.5,
    ));
    seen.sort_by(f64::total_cmp);
    let middle = seen.get(seen.len() / 2).copied().unwrap_or(1.0);
    report.verdicts.push(Verdict::told(
        "the same: stiffness it bears with over without, median",
        format!("{middle:.1}"),
        "2 or more",
        middle >= 2.0,
    ));
    Ok(tally)
}

/// One run that does not rest without it: height and energy over time.
fn energy(bench: &Bench, report: &mut Report) -> Tally {
    let case = Case {
        device: LINEAR,
        hand: Hand::NONE,
        rate_hz: 1000.0,
        delay_ticks: 0.0,
    };
    let k = 2.0 * passive_stiffness_n_per_mm(LINEAR.damping_n_s_per_mm, 1e-3, 0.0, 0.0);
    let mut tally = Tally::default();
    let mut runs = BOTH.map(|on| {
        let mut moments: Vec<Moment> = Vec::new();
        let outcome = bench.tap_with(&case.at(k, on), |m| {
            if m.time_s <= DRAWN_S {
                moments.push(*m);
            }
        });
        tally += Tally::from(&outcome);
        (moments, outcome)
    });
    let line = |runs: &[(Vec<Moment>, Outcome); 2], y: &dyn Fn(&Moment) -> f64| {
        let names = ["without the controller", "with it"];
        let of = |i: usize, colour| Series {
            name: names[i].to_owned(),
            colour,
            mark: Mark::Line,
            points: runs[i].0.iter().map(|m| [m.time_s, y(m)]).collect(),
        };
        vec![of(0, WITHOUT), of(1, WITH)]
    };
    let plot = |title: String, y_label: &str, series| LinePlot {
        title,
        x_label: "time (s)".to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Linear,
        y_scale: Scale::Linear,
        series,
    };
    let heights = line(&runs, &|m| m.z_mm);
    let given = line(&runs, &|m| m.given_mj);
    report.draw(
        "energy-over-time",
        vec![
            plot(
                format!("A tap on {k} N/mm at 1 kHz, twice the passive limit, no hand"),
                "height above the skin (mm)",
                heights,
            ),
            plot(
                "What the skin has given out; a passive one stays at or below 0".to_owned(),
                "energy (mJ)",
                given,
            ),
        ],
    );
    let [without, with] = [runs[0].1, runs[1].1];
    runs[0].0.clear();
    report.verdicts.push(Verdict::must(
        "the drawn run: it does not rest without the controller, and rests with it",
        format!("{}; {}", without.class.name(), with.class.name()),
        "limit cycle or unstable; stable",
        without.class != Class::Stable && with.class == Class::Stable,
    ));
    tally
}

/// A press that goes in and out at a speed whatever the force: stiffness and loss that a finger would feel.
fn felt(bench: &Bench, setup: &Setup, report: &mut Report) {
    let speeds: &[f64] = if setup.quick {
        &[20.0, 200.0]
    } else {
        &[5.0, 20.0, 60.0, 200.0]
    };
    let stiffnesses: &[f64] = if setup.quick {
        &[1.0]
    } else {
        &[0.5, 1.5, 5.0]
    };
    let mut table = Table::new(
        "felt",
        "What a finger feels that is moved in and out of the skin by 4 mm, at 1 kHz: slope of force over depth, and energy lost in a press",
        &[
            "stiffness (N/mm)",
            "step (mm)",
            "highest speed (mm/s)",
            "slope without (N/mm)",
            "slope with (N/mm)",
            "change (%)",
            "lost without (mJ)",
            "lost with (mJ)",
            "roughest step without (N)",
            "roughest step with (N)",
        ],
    );
    let mut slow_change = 0.0_f64;
    for &k in stiffnesses {
        for quantum_mm in [0.0, 0.03] {
            for &speed in speeds {
                let [without, with] = BOTH.map(|on| bench.guided(k, quantum_mm, speed, on));
                let change = 100.0 * (with.slope_n_per_mm / without.slope_n_per_mm - 1.0);
                if speed <= 20.0 {
                    slow_change = slow_change.max(change.abs());
                }
                table.push([
                    k.into(),
                    quantum_mm.into(),
                    speed.into(),
                    without.slope_n_per_mm.into(),
                    with.slope_n_per_mm.into(),
                    change.into(),
                    without.lost_mj.into(),
                    with.lost_mj.into(),
                    without.roughest_n.into(),
                    with.roughest_n.into(),
                ]);
            }
        }
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::must(
        "change of the felt stiffness at up to 20 mm/s, most",
        format!("{slow_change:.2} %"),
        "1 % or less; a hand tells 14 % at best (METHOD 7)",
        slow_change <= 1.0,
    ));
}
