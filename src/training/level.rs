//! From the level of a staircase to the strength of a dysfunction and back.

use crate::scenario::Change;
use crate::scenario::exercise::{Measure, Step};

/// The axis on which a staircase steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Of what the percentage is.
    pub measure: Measure,
    /// Whether levels are 20 lg of the percentage, dB, or the percentage itself.
    pub decibel: bool,
    /// Whether the change makes it softer: more compliance, less stiffness.
    pub softer: bool,
}

/// Smallest percentage that has a level, percent: a logarithm needs one.
const LEAST_PERCENT: f64 = 1.0e-3;

impl Scale {
    /// The scale of a staircase that goes to the side of `change`.
    pub fn new(measure: Measure, step: Step, change: Change) -> Self {
        Self {
            measure,
            decibel: matches!(step, Step::Decibel(_)),
            softer: change.factor() < 1.0,
        }
    }

    /// Level of a percentage; one that is not above 0 counts as 0.001 %.
    pub fn level(&self, percent: f64) -> f64 {
        let percent = percent.max(LEAST_PERCENT);
        if self.decibel {
            20.0 * libm::log10(percent)
        } else {
            percent
        }
    }

    /// Percentage of a level, ≥ 0.
    pub fn percent(&self, level: f64) -> f64 {
        if self.decibel {
            libm::pow(10.0, level / 20.0)
        } else {
            level.max(0.0)
        }
    }

    /// The change at a level.
    pub fn change(&self, level: f64) -> Change {
        let percent = self.percent(level);
        match self.measure {
            Measure::Compliance if self.softer => Change::CompliancePercent(percent),
            Measure::Compliance => Change::CompliancePercent(-percent),
            Measure::Stiffness if self.softer => Change::StiffnessPercent(-percent),
            Measure::Stiffness => Change::StiffnessPercent(percent),
        }
    }

    /// What of a level is called, as "20 % less compliance".
    pub fn words(&self, level: f64) -> String {
        let less = (self.measure == Measure::Compliance) != self.softer;
        format!(
            "{:.1} % {} {}",
            self.percent(level),
            if less { "less" } else { "more" },
            self.measure.name()
        )
    }
}

/// Change of stiffness in percent of what it was.
pub fn stiffness_percent(factor: f64) -> f64 {
    100.0 * (factor - 1.0)
}

/// Change of compliance in percent of what it was, for a factor of the stiffness above 0.
pub fn compliance_percent(factor: f64) -> f64 {
    100.0 * (1.0 / factor - 1.0)
}

/// Size of a change as the logarithm of the ratio of stiffness, which is that of compliances too: ≥ 0.
pub fn log_ratio(change: Change) -> f64 {
    libm::log(change.factor()).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compliance_and_stiffness_are_what_the_publications_make_of_each_other() {
        // Howell et al. 2008: 14 % less compliance, 16.3 % more stiffness; 40 % and 66.7 %.
        for (compliance, stiffness) in [(-14.0, 16.279), (-40.0, 66.667)] {
            let factor = Change::CompliancePercent(compliance).factor();
            assert!((stiffness_percent(factor) - stiffness).abs() < 1e-3);
            assert!((compliance_percent(factor) - compliance).abs() < 1e-9);
        }
    }

    #[test]
    fn a_level_is_a_percentage_there_and_back_on_every_scale() {
        for measure in Measure::ALL {
            for decibel in [false, true] {
                for softer in [false, true] {
                    let scale = Scale {
                        measure,
                        decibel,
                        softer,
                    };
                    for percent in [0.5, 1.0, 14.0, 40.0, 89.0] {
                        let level = scale.level(percent);
                        assert!((scale.percent(level) - percent).abs() < 1e-12 * percent);
                        let change = scale.change(level);
                        assert_eq!(change.factor() < 1.0, softer);
                        let told = match measure {
                            Measure::Compliance => compliance_percent(change.factor()),
                            Measure::Stiffness => stiffness_percent(change.factor()),
                        };
                        assert!((told.abs() - percent).abs() < 1e-9);
                    }
                    assert!(scale.level(f64::NAN).is_finite() && scale.level(-1.0).is_finite());
                }
            }
        }
        let harder = Scale {
            measure: Measure::Compliance,
            decibel: true,
            softer: false,
        };
        assert!((harder.level(14.0) - harder.level(1.4) - 20.0).abs() < 1e-12);
        assert_eq!(harder.words(20.0), "10.0 % less compliance");
    }

    #[test]
    fn the_size_of_a_change_is_the_same_either_way() {
        let hard = log_ratio(Change::StiffnessPercent(25.0));
        let soft = log_ratio(Change::CompliancePercent(25.0));
        assert!((hard - soft).abs() < 1e-15 && hard > 0.0);
    }
}
