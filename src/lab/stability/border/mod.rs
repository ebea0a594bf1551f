//! The measured border of stability beside both theories.
//!
//! | file | answers |
//! |---|---|
//! | `maps` | what becomes of a tap, by stiffness and damping |
//! | `tables` | how stiff a skin may be, by rate, delay, encoder step, hand and device |

mod maps;
mod tables;

use super::closed_loop::{Bench, UNFELT_MM};
use super::search::{Fineness, Tally};
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Verdict, Watch};

/// The border of stability.
pub struct StabilityBorder;

/// How far a measured border may lie beyond a limit of theory, a factor: the resolution of the search, and what a trial
/// cannot tell within its few seconds from swings that keep up.
#[derive(Clone, Copy, Debug)]
struct Slack {
    fineness: Fineness,
    allowed: f64,
}

impl Slack {
    fn of(setup: &Setup) -> Self {
        if setup.quick {
            Self {
                fineness: Fineness {
                    stride: 4.0,
                    resolution: 1.05,
                },
                allowed: 1.08,
            }
        } else {
            Self {
                fineness: Fineness {
                    stride: 1.5,
                    resolution: 1.01,
                },
                allowed: 1.03,
            }
        }
    }
}

impl Experiment for StabilityBorder {
    fn name(&self) -> &'static str {
        "stability-border"
    }

    fn about(&self) -> &'static str {
        "How stiff a skin may be before hand, device and tick no longer rest, beside both theories"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Seed]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let bench = Bench::new()?;
        let slack = Slack::of(setup);
        let mut report = Report::default();
        report.set(
            "skin",
            "flat, uniform stiffness, production contact engine, the servo's own tick",
        );
        report.set("tap", "from 2 mm above at 100 mm/s, pushed on by a hand that wants to be 5 mm within, or by 1 N");
        report.set(
            "rests",
            format!("swings below {} µm, or shrinking", 1e3 * UNFELT_MM),
        );
        report.set("seed of the hands", setup.seed);
        report.set(
            "resolution",
            format!(
                "{:.0} % in stiffness",
                100.0 * (slack.fineness.resolution - 1.0)
            ),
        );
        let mut tally = Tally::default();
        tally += maps::draw(&bench, setup, &mut report, &mut watch.part(0.0, 0.4))?;
        tally += tables::linear(
            &bench,
            setup,
            slack,
            &mut report,
            &mut watch.part(0.4, 0.65),
        )?;
        tally += tables::quantised(
            &bench,
            setup,
            slack,
            &mut report,
            &mut watch.part(0.65, 0.8),
        )?;
        tally += tables::hands(&bench, setup, slack, &mut report, &mut watch.part(0.8, 0.9))?;
        tally += tables::devices(&bench, setup, slack, &mut report, &mut watch.part(0.9, 1.0))?;
        report.verdicts.push(Verdict::must(
            "values that are not finite, over all trials",
            format!("{} in {} ticks", tally.not_finite, tally.ticks),
            "0",
            tally.not_finite == 0,
        ));
        report.verdicts.push(Verdict::must(
            "forces above the limit, or that pull, over all trials",
            format!("{} in {} ticks", tally.over_limit, tally.ticks),
            "0",
            tally.over_limit == 0,
        ));
        report.note(
            "A skin only pushes; the spring of coupled stability pulls too. So two trials: a tap enters, bounces and rests \
             or not, and is what passivity (proved for the skin that only pushes) bounds from below; a press starts at rest \
             within the skin, is disturbed by a millionth of its depth, and has to grow or die as the spring's eigenvalues \
             say. A tap cannot rest where a press grows, so its border lies between the two theories.",
        );
        report.note(
            "Hands are masses, dampings and stiffnesses drawn apart from rounded ranges (Hajian & Howe 1997; Kuchenbecker, \
             Park & Niemeyer 2003; Speich, Shao & Goldfarb 2005), held rigidly: the softness of the finger pad, which helps, \
             is left out.",
        );
        Ok(report)
    }
}
