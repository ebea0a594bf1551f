//! Tables of borders: by rate, delay and hand for the linear device, with encoder steps, over hands, and over devices.

use super::Slack;
use crate::lab::stability::closed_loop::{Bench, Class, Loop, UNLIMITED};
use crate::lab::stability::devices::{DEVICES, Haptic, LINEAR};
use crate::lab::stability::plant::Hand;
use crate::lab::stability::search::{Border, Tally, on_all_processors, press_border, tap_border};
use crate::lab::stability::theory::{
    LinearLoop, passive_quantised_n_per_mm, passive_stiffness_n_per_mm,
};
use crate::lab::{LabError, Report, Setup, Table, Value, Verdict, Watch};

/// The stiffest skin of the default back, N/mm (METHOD 7): what a device should bear.
const STIFFEST_N_PER_MM: f64 = 1.5;

/// One loop but for its stiffness.
#[derive(Clone, Copy)]
struct Case {
    device: Haptic,
    hand: Hand,
    rate_hz: f64,
    delay_ticks: f64,
}

impl Case {
    fn at(&self, stiffness_n_per_mm: f64) -> Loop {
        Loop {
            plant: self.device.held_by(&self.hand),
            stiffness_n_per_mm,
            rate_hz: self.rate_hz,
            delay_ticks: self.delay_ticks,
            quantum_mm: self.device.quantum_mm,
            limits: UNLIMITED,
        }
    }

    fn passive(&self) -> f64 {
        let period_s = 1.0 / self.rate_hz;
        let b = self.device.damping_n_s_per_mm;
        passive_stiffness_n_per_mm(b, period_s, self.delay_ticks * period_s, 0.0)
    }

    /// Friction helps and encoder steps do not: without them.
    fn coupled(&self) -> f64 {
        let plant = self.at(1.0).plant;
        LinearLoop::new(&plant, 1.0 / self.rate_hz, self.delay_ticks)
            .stable_stiffness_n_per_mm(0.9 * self.passive())
    }
}

fn hand_name(hand: &Hand) -> &'static str {
    if *hand == Hand::NONE {
        "none"
    } else {
        "middle"
    }
}

/// Both measured borders of linear cases, a part of the shelf for each rate.
fn both(bench: &Bench, slack: Slack, cases: &[Case]) -> Vec<[Border; 2]> {
    on_all_processors(cases, |c| {
        let at = |k: f64| c.at(k);
        [
            tap_border(bench, slack.fineness, at),
            press_border(bench, slack.fineness, at),
        ]
    })
}

/// How measured borders of linear loops lie to their limits: the worst of each comparison, as factors.
struct Between {
    /// Least of tap over passive.
    tap_over_passive: f64,
    /// Most of tap over coupled.
    tap_over_coupled: f64,
    /// Press over coupled, farthest from 1 both ways.
    press_over_coupled: [f64; 2],
}

impl Default for Between {
    fn default() -> Self {
        Self {
            tap_over_passive: f64::INFINITY,
            tap_over_coupled: 0.0,
            press_over_coupled: [f64::INFINITY, 0.0],
        }
    }
}

impl Between {
    fn add(&mut self, case: &Case, [tap, press]: &[Border; 2]) {
        let (passive, coupled) = (case.passive(), case.coupled());
        let or_infinite = |b: &Border| b.stiffness_n_per_mm.unwrap_or(f64::INFINITY);
        let (tap, press) = (or_infinite(tap), or_infinite(press));
        self.tap_over_passive = self.tap_over_passive.min(tap / passive);
        self.tap_over_coupled = self.tap_over_coupled.max(tap / coupled);
        let [low, high] = &mut self.press_over_coupled;
        *low = low.min(press / coupled);
        *high = high.max(press / coupled);
    }

    fn judge(&self, what: &str, slack: Slack, report: &mut Report) {
        let percent = 100.0 * (slack.allowed - 1.0);
        report.verdicts.push(Verdict::must(
            format!("{what}: measured border (tap) over the passive limit, least"),
            format!("{:.3}", self.tap_over_passive),
            format!("1 or more, to {percent:.0} %"),
            self.tap_over_passive >= 1.0 / slack.allowed,
        ));
        report.verdicts.push(Verdict::must(
            format!("{what}: measured border (tap) over the coupled limit, most"),
            format!("{:.3}", self.tap_over_coupled),
            format!("1 or less, to {percent:.0} %"),
            self.tap_over_coupled <= slack.allowed,
        ));
        let [low, high] = self.press_over_coupled;
        report.verdicts.push(Verdict::must(
            format!("{what}: measured border (press) over the coupled limit"),
            format!("{low:.3} to {high:.3}"),
            format!("1, to {percent:.0} %"),
            low >= 1.0 / slack.allowed && high <= slack.allowed,
        ));
    }
}

/// The linear device by rate, delay and hand.
pub(super) fn linear(
    bench: &Bench,
    setup: &Setup,
    slack: Slack,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let rates: &[f64] = if setup.quick {
        &[300.0, 1000.0]
    } else {
        &[100.0, 300.0, 1000.0, 3000.0, 10_000.0]
    };
    let delays: &[f64] = if setup.quick {
        &[0.0, 1.0]
    } else {
        &[0.0, 0.5, 1.0, 2.0, 5.0]
    };
    let mut table = Table::new(
        "linear-device",
        format!(
            "Linear device of {} g and {} N·s/mm: stiffest skin on which it rests, measured and by both theories",
            LINEAR.mass_kg * 1e3,
            LINEAR.damping_n_s_per_mm
        ),
        &[
            "hand",
            "rate (Hz)",
            "delay (ticks)",
            "passive limit (N/mm)",
            "measured, tap (N/mm)",
            "measured, press (N/mm)",
            "coupled limit (N/mm)",
            "tap / passive",
            "press / coupled",
            "beyond it",
            "amplitude beyond (mm)",
            "frequency beyond (Hz)",
            "given out beyond (mJ)",
        ],
    );
    let mut tally = Tally::default();
    let mut between = Between::default();
    let hands = [Hand::NONE, Hand::middle()];
    for (i, hand) in hands.iter().enumerate() {
        for (j, &rate_hz) in rates.iter().enumerate() {
            let share = (i * rates.len() + j) as f64 / (hands.len() * rates.len()) as f64;
            watch.at(&format!("borders at {rate_hz} Hz"), share)?;
            let cases: Vec<Case> = delays
                .iter()
                .map(|&delay_ticks| Case {
                    device: LINEAR,
                    hand: *hand,
                    rate_hz,
                    delay_ticks,
                })
                .collect();
            let key = format!("linear {} {rate_hz} Hz", hand_name(hand));
            let found = setup.shelf.part(&key, || Ok(both(bench, slack, &cases)))?;
            for (case, borders) in cases.iter().zip(&found) {
                between.add(case, borders);
                for border in borders {
                    tally += border.tally;
                }
                let [tap, press] = borders.map(|b| b.stiffness_n_per_mm);
                let (passive, coupled) = (case.passive(), case.coupled());
                // Twice as stiff as it bears.
                let beyond = tap.map(|k| bench.tap(&case.at(2.0 * k)));
                tally += beyond.as_ref().map_or(Tally::default(), Tally::from);
                let swings = beyond.filter(|o| o.class == Class::LimitCycle);
                table.push([
                    hand_name(hand).into(),
                    rate_hz.into(),
                    case.delay_ticks.into(),
                    passive.into(),
                    tap.into(),
                    press.into(),
                    coupled.into(),
                    tap.map(|k| k / passive).into(),
                    press.map(|k| k / coupled).into(),
                    beyond.map(|o| o.class.name()).into(),
                    swings.map(|o| o.amplitude_mm).into(),
                    swings.map(|o| o.frequency_hz).into(),
                    beyond.map(|o| o.given_mj).into(),
                ]);
            }
        }
    }
    report.tables.push(table);
    report.note(
        "In the table of the linear device, beyond means a skin twice as stiff as the tap bears.",
    );
    between.judge("linear device", slack, report);
    Ok(tally)
}

/// Encoder steps and Coulomb friction.
pub(super) fn quantised(
    bench: &Bench,
    setup: &Setup,
    slack: Slack,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let rates: &[f64] = if setup.quick {
        &[1000.0]
    } else {
        &[300.0, 1000.0, 10_000.0]
    };
    // Encoder step, mm, and friction, N.
    let pairs: &[[f64; 2]] = if setup.quick {
        &[[0.03, 0.1]]
    } else {
        &[
            [0.03, 0.0],
            [0.03, 0.04],
            [0.01, 0.1],
            [0.03, 0.1],
            [0.1, 0.1],
            [0.055, 0.26],
        ]
    };
    let mut table = Table::new(
        "encoder-steps",
        "The same device with encoder steps and Coulomb friction: stiffest skin on which a tap rests",
        &[
            "hand",
            "rate (Hz)",
            "step (mm)",
            "friction (N)",
            "2b/T (N/mm)",
            "2f/step (N/mm)",
            "passive limit (N/mm)",
            "measured, tap (N/mm)",
            "tap / passive",
        ],
    );
    let mut tally = Tally::default();
    let mut least = f64::INFINITY;
    let hands = [Hand::NONE, Hand::middle()];
    for (i, hand) in hands.iter().enumerate() {
        for (j, &rate_hz) in rates.iter().enumerate() {
            let share = (i * rates.len() + j) as f64 / (hands.len() * rates.len()) as f64;
            watch.at(&format!("encoder steps at {rate_hz} Hz"), share)?;
            let cases: Vec<Case> = pairs
                .iter()
                .map(|&[quantum_mm, coulomb_n]| Case {
                    device: Haptic {
                        quantum_mm,
                        coulomb_n,
                        ..LINEAR
                    },
                    hand: *hand,
                    rate_hz,
                    delay_ticks: 0.0,
                })
                .collect();
            let key = format!("steps {} {rate_hz} Hz", hand_name(hand));
            let found: Vec<Border> = setup.shelf.part(&key, || {
                let border = |c: &Case| tap_border(bench, slack.fineness, |k| c.at(k));
                Ok(on_all_processors(&cases, border))
            })?;
            for (case, border) in cases.iter().zip(&found) {
                tally += border.tally;
                let Haptic {
                    quantum_mm,
                    coulomb_n,
                    damping_n_s_per_mm,
                    ..
                } = case.device;
                let passive = passive_quantised_n_per_mm(
                    damping_n_s_per_mm,
                    1.0 / rate_hz,
                    coulomb_n,
                    quantum_mm,
                );
                let tap = border.stiffness_n_per_mm;
                let ratio = tap.map(|k| k / passive).filter(|r| r.is_finite());
                least = least.min(ratio.unwrap_or(f64::INFINITY));
                table.push([
                    hand_name(hand).into(),
                    rate_hz.into(),
                    quantum_mm.into(),
                    coulomb_n.into(),
                    (2.0 * damping_n_s_per_mm * rate_hz).into(),
                    (2.0 * coulomb_n / quantum_mm).into(),
                    passive.into(),
                    tap.into(),
                    ratio.into(),
                ]);
            }
        }
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::must(
        "encoder steps and friction: measured border (tap) over min(2b/T, 2f/step), least",
        format!("{least:.3}"),
        format!("1 or more, to {:.0} %", 100.0 * (slack.allowed - 1.0)),
        least >= 1.0 / slack.allowed,
    ));
    Ok(tally)
}

/// The linear device in many hands.
pub(super) fn hands(
    bench: &Bench,
    setup: &Setup,
    slack: Slack,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let n = if setup.quick { 2 } else { 24 };
    let cases: Vec<Case> = (0..n)
        .map(|i| Case {
            device: LINEAR,
            hand: Hand::drawn(setup.seed, i),
            rate_hz: 1000.0,
            delay_ticks: 0.0,
        })
        .collect();
    watch.at("hands", 0.0)?;
    let key = format!("{n} hands of seed {}", setup.seed);
    let found = setup.shelf.part(&key, || Ok(both(bench, slack, &cases)))?;
    let mut table = Table::new(
        "hands",
        "The linear device at 1 kHz in hands of the population",
        &[
            "hand",
            "mass (g)",
            "damping (N·s/mm)",
            "stiffness (N/mm)",
            "passive limit (N/mm)",
            "measured, tap (N/mm)",
            "measured, press (N/mm)",
            "coupled limit (N/mm)",
        ],
    );
    let mut tally = Tally::default();
    let mut between = Between::default();
    for (i, (case, borders)) in cases.iter().zip(&found).enumerate() {
        between.add(case, borders);
        for border in borders {
            tally += border.tally;
        }
        table.push([
            i.into(),
            (1e3 * case.hand.mass_kg).into(),
            case.hand.damping_n_s_per_mm.into(),
            case.hand.stiffness_n_per_mm.into(),
            case.passive().into(),
            borders[0].stiffness_n_per_mm.into(),
            borders[1].stiffness_n_per_mm.into(),
            case.coupled().into(),
        ]);
    }
    report.tables.push(table);
    between.judge("hands", slack, report);
    Ok(tally)
}

/// Devices of the field, as they are assumed to be.
pub(super) fn devices(
    bench: &Bench,
    setup: &Setup,
    slack: Slack,
    report: &mut Report,
    watch: &mut Watch<'_>,
) -> Result<Tally, LabError> {
    let some = if setup.quick { 2 } else { DEVICES.len() };
    let devices = &DEVICES[DEVICES.len() - some..];
    watch.at("devices", 0.0)?;
    let at = |device: &Haptic, hand: Hand, k: f64| Loop {
        limits: device.limits(),
        ..case(device, hand).at(k)
    };
    let found: Vec<[Border; 2]> = setup.shelf.part("devices", || {
        let of = |device: &Haptic| {
            [Hand::NONE, Hand::middle()]
                .map(|hand| tap_border(bench, slack.fineness, |k| at(device, hand, k)))
        };
        Ok(on_all_processors(devices, of))
    })?;
    let mut table = Table::new(
        "devices",
        "Devices at 1 kHz, no delay: maker's stiffness beside the limits (mass, damping, friction and step are assumed)",
        &[
            "device",
            "mass (g)",
            "damping (N·s/mm)",
            "friction (N)",
            "step (mm)",
            "force (N)",
            "maker (N/mm)",
            "2b/T (N/mm)",
            "2f/step (N/mm)",
            "measured alone (N/mm)",
            "measured in hand (N/mm)",
            "coupled limit in hand (N/mm)",
            "bears the default back",
        ],
    );
    let mut tally = Tally::default();
    let mut bear = 0;
    for (device, borders) in devices.iter().zip(&found) {
        for border in borders {
            tally += border.tally;
        }
        let [alone, held] = borders.map(|b| b.stiffness_n_per_mm);
        let bears = held.is_none_or(|k| k >= STIFFEST_N_PER_MM);
        bear += usize::from(bears);
        let held_case = case(device, Hand::middle());
        table.push([
            device.name.into(),
            (1e3 * device.mass_kg).into(),
            device.damping_n_s_per_mm.into(),
            device.coulomb_n.into(),
            device.quantum_mm.into(),
            device.rated_force_n.into(),
            device.stiffness_n_per_mm.into(),
            held_case.passive().into(),
            (2.0 * device.coulomb_n / device.quantum_mm).into(),
            alone.into(),
            held.into(),
            held_case.coupled().into(),
            Value::from(if bears { "yes" } else { "no" }),
        ]);
    }
    report.tables.push(table);
    report.verdicts.push(Verdict::told(
        format!("devices that rest in the middle hand on {STIFFEST_N_PER_MM} N/mm, the stiffest skin of the default back"),
        format!("{bear} of {}", devices.len()),
        "all",
        bear == devices.len(),
    ));
    Ok(tally)
}

fn case(device: &Haptic, hand: Hand) -> Case {
    Case {
        device: *device,
        hand,
        rate_hz: 1000.0,
        delay_ticks: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the verdicts hold that compare the borders of one loop with the theory of another.
    fn holds(measured: Case, told: Case) -> bool {
        let bench = Bench::new().expect("a plate");
        let setup = Setup {
            quick: true,
            ..Setup::default()
        };
        let slack = Slack::of(&setup);
        let mut between = Between::default();
        between.add(&told, &both(&bench, slack, &[measured])[0]);
        let mut report = Report::default();
        between.judge("loop", slack, &mut report);
        report.holds()
    }

    #[test]
    fn the_verdicts_find_a_loop_that_is_not_the_one_it_is_said_to_be() {
        let right = case(&LINEAR, Hand::NONE);
        assert!(holds(right, right));
        let wrong = [
            // The force comes a quarter of a tick late.
            Case {
                delay_ticks: 0.25,
                ..right
            },
            // It comes too often or too seldom.
            Case {
                rate_hz: 1200.0,
                ..right
            },
            Case {
                rate_hz: 800.0,
                ..right
            },
            // Something else brakes.
            Case {
                device: Haptic {
                    damping_n_s_per_mm: 2.4e-3,
                    ..LINEAR
                },
                ..right
            },
        ];
        for wrong in wrong {
            assert!(!holds(wrong, right));
        }
    }
}
