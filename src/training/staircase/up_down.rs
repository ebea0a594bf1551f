//! Up-down staircases: down after right answers in a row, up after each wrong one.

use super::{Estimate, Rule, Settings, Staircase};
use crate::training::random::Random;

/// One up after a wrong answer, one down after `n_down` right ones in a row.
#[derive(Clone, Copy, Debug)]
pub struct UpDown {
    key: &'static str,
    title: &'static str,
    about: &'static str,
    n_down: u32,
    steps: Steps,
}

/// How far it goes down where it goes up by one step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Steps {
    /// As many steps.
    Ratio(f64),
    /// As many as make the share of right answers the target of the settings (Kaernbach 1991).
    Weighted,
}

/// Levitt 1971 with the steps of García-Pérez 1998: to 80.35 %.
pub const ONE_UP_TWO_DOWN: UpDown = UpDown {
    key: "1-up-2-down",
    title: "1-up 2-down",
    about: "Down after two right answers by 0.5488 of the step up: 80.35 % (García-Pérez 1998)",
    n_down: 2,
    steps: Steps::Ratio(0.5488),
};

/// Levitt 1971 with the steps of García-Pérez 1998: to 83.15 %.
pub const ONE_UP_THREE_DOWN: UpDown = UpDown {
    key: "1-up-3-down",
    title: "1-up 3-down",
    about: "Down after three right answers by 0.7393 of the step up: 83.15 % (García-Pérez 1998)",
    n_down: 3,
    steps: Steps::Ratio(0.7393),
};

/// Levitt 1971 with the steps of García-Pérez 1998: to 85.84 %.
pub const ONE_UP_FOUR_DOWN: UpDown = UpDown {
    key: "1-up-4-down",
    title: "1-up 4-down",
    about: "Down after four right answers by 0.8415 of the step up: 85.84 % (García-Pérez 1998)",
    n_down: 4,
    steps: Steps::Ratio(0.8415),
};

/// Levitt 1971: to 70.7 %.
pub const ONE_UP_TWO_DOWN_EQUAL: UpDown = UpDown {
    key: "1-up-2-down-equal",
    title: "1-up 2-down, equal steps",
    about: "Down after two right answers, steps alike: 70.7 % (Levitt 1971)",
    n_down: 2,
    steps: Steps::Ratio(1.0),
};

/// Levitt 1971: to 79.4 %.
pub const ONE_UP_THREE_DOWN_EQUAL: UpDown = UpDown {
    key: "1-up-3-down-equal",
    title: "1-up 3-down, equal steps",
    about: "Down after three right answers, steps alike: 79.4 % (Levitt 1971)",
    n_down: 3,
    steps: Steps::Ratio(1.0),
};

/// Levitt 1971: to 84.1 %.
pub const ONE_UP_FOUR_DOWN_EQUAL: UpDown = UpDown {
    key: "1-up-4-down-equal",
    title: "1-up 4-down, equal steps",
    about: "Down after four right answers, steps alike: 84.1 % (Levitt 1971)",
    n_down: 4,
    steps: Steps::Ratio(1.0),
};

/// Kaernbach 1991: to any share.
pub const WEIGHTED: UpDown = UpDown {
    key: "weighted-up-down",
    title: "Weighted up-down",
    about: "Down after each right answer by (1 − p)/p of the step up: to the share p that is stated (Kaernbach 1991)",
    n_down: 1,
    steps: Steps::Weighted,
};

impl UpDown {
    fn down_per_up(&self, settings: &Settings) -> f64 {
        match self.steps {
            Steps::Ratio(ratio) => ratio,
            Steps::Weighted => {
                let p = settings.target.clamp(0.01, 0.99);
                (1.0 - p) / p
            }
        }
    }
}

impl Rule for UpDown {
    fn key(&self) -> &'static str {
        self.key
    }

    fn title(&self) -> &'static str {
        self.title
    }

    fn about(&self) -> &'static str {
        self.about
    }

    /// Where it drifts neither up nor down: n right answers in a row, each with p, take it down by r steps as often as it
    /// goes up by one, so that p^n = 1/(1 + r).
    fn target(&self, settings: &Settings) -> Option<f64> {
        let stays = 1.0 / (1.0 + self.down_per_up(settings));
        Some(libm::pow(stays, 1.0 / f64::from(self.n_down)))
    }

    fn start(&self, settings: &Settings) -> Box<dyn Staircase> {
        Box::new(Walk {
            n_down: self.n_down,
            up: settings.step,
            down: settings.step * self.down_per_up(settings),
            target: self.target(settings).unwrap_or(settings.target),
            least: settings.least,
            most: settings.most,
            level: settings.start,
            in_a_row: 0,
            last_went_up: None,
            reversals: Vec::new(),
            skipped: settings.skipped_reversals as usize,
            wanted: settings.reversals.map(|n| n as usize),
        })
    }
}

struct Walk {
    n_down: u32,
    up: f64,
    down: f64,
    target: f64,
    least: f64,
    most: f64,
    level: f64,
    in_a_row: u32,
    last_went_up: Option<bool>,
    reversals: Vec<f64>,
    skipped: usize,
    wanted: Option<usize>,
}

/// Until it has turned once it goes this many steps at a time: the start is a guess.
const STEPS_AT_FIRST: f64 = 2.0;

impl Walk {
    fn turn(&mut self, up: bool, from: f64) {
        if self.last_went_up.is_some_and(|last| last != up) {
            self.reversals.push(from);
        }
        self.last_went_up = Some(up);
        let at_first = if self.reversals.is_empty() {
            STEPS_AT_FIRST
        } else {
            1.0
        };
        let by = at_first * if up { self.up } else { -self.down };
        self.level = (from + by).clamp(self.least, self.most);
        self.in_a_row = 0;
    }
}

impl Staircase for Walk {
    fn level(&mut self, _: &mut Random) -> f64 {
        self.level
    }

    fn answered(&mut self, level: f64, right: bool) {
        if !right {
            self.turn(true, level);
            return;
        }
        self.in_a_row += 1;
        if self.in_a_row >= self.n_down {
            self.turn(false, level);
        }
    }

    fn is_done(&self) -> bool {
        self.wanted.is_some_and(|n| self.reversals.len() >= n)
    }

    fn reversals(&self) -> &[f64] {
        &self.reversals
    }

    /// The mean of the middles between each peak and the valley after it (Wetherill & Levitt 1965), an even number of
    /// reversals, and the standard error of that mean.
    fn estimate(&self) -> Option<Estimate> {
        let kept = self.reversals.get(self.skipped..)?;
        // The last ones count: what is left over of a pair is the first.
        let middles: Vec<f64> = kept[kept.len() % 2..]
            .chunks_exact(2)
            .map(|pair| 0.5 * (pair[0] + pair[1]))
            .collect();
        if middles.is_empty() {
            return None;
        }
        let n = middles.len() as f64;
        let mean = middles.iter().sum::<f64>() / n;
        let squares: f64 = middles.iter().map(|m| (m - mean) * (m - mean)).sum();
        Some(Estimate {
            level: mean,
            standard_error: (middles.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt()),
            target: self.target,
        })
    }
}
