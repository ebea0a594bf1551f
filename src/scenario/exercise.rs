//! `[exercise]`: what is asked of whom palpates, what is hidden, and how its strength goes from trial to trial.

use super::ScenarioError;
use super::check::Check;
use super::dysfunction::{self, Change, Site, sites};

use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

/// What can be asked, by the names that a file states.
pub const TASKS: [&str; 6] = [
    "locate",
    "same-different",
    "compare",
    "level",
    "severity",
    "search",
];

/// Rules by which the strength goes from trial to trial, by the names that a file states.
pub const RULES: [&str; 9] = [
    "1-up-2-down",
    "1-up-3-down",
    "1-up-4-down",
    "1-up-2-down-equal",
    "1-up-3-down-equal",
    "1-up-4-down-equal",
    "weighted-up-down",
    "psi",
    "constant",
];

/// An exercise, as a scenario states it.
#[derive(Clone, Debug, PartialEq)]
pub struct Exercise {
    /// What is asked: one of [`TASKS`].
    pub task: &'static str,
    /// Where it may be, or what may be pointed at; at least one, none twice.
    pub candidates: Vec<Site>,
    /// What is hidden.
    pub hides: Hides,
    /// Scored trials.
    pub trials: u32,
    /// Trials before them that are not scored.
    pub practice: u32,
    /// Longest time to palpate in one trial, s; then it must be answered.
    pub trial_limit_s: Option<f64>,
    /// Longest time for all scored trials, pauses left out, s.
    pub limit_s: Option<f64>,
    /// What is told after an answer.
    pub feedback: Feedback,
    /// Whether the trainee says how sure the answer is.
    pub asks_confidence: bool,
    /// Whether the kind is asked for beside the place.
    pub asks_kind: bool,
    /// Whether the severity is asked for beside the place.
    pub asks_severity: bool,
    /// All stiffness of a trial is multiplied by a factor drawn evenly on a logarithmic scale from 1/(1 + v/100) to
    /// 1 + v/100, v being this, so that no force or depth at the end of a press tells by itself which site is changed.
    pub vary_stiffness_percent: f64,
    /// A place marked within this distance of a hidden one has found it, mm.
    pub tolerance_mm: f64,
    /// Where chance starts; drawn anew for every run where it is not stated.
    pub seed: Option<u64>,
    /// How the strength goes from trial to trial; absent: it stays as stated.
    pub staircase: Option<Staircase>,
}

/// What an exercise hides.
#[derive(Clone, Debug, PartialEq)]
pub enum Hides {
    /// A dysfunction drawn anew in every trial; those that the scenario states are felt and shown.
    Drawn {
        /// Its kind, by the name that a `[[dysfunction]]` states.
        kind: &'static str,
        /// Its strength without a staircase; with one, the side it goes to: harder or softer.
        change: Change,
        /// How many there are at most in one trial of a free search.
        most: usize,
    },
    /// The dysfunctions that the scenario itself states, the same in every trial.
    Stated,
}

/// What is told after an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Feedback {
    /// Nothing.
    None,
    /// Whether it was right.
    Right,
    /// Also what would have been right, with a chance to feel it again.
    #[default]
    Truth,
}

impl Feedback {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Right => "right",
            Self::Truth => "truth",
        }
    }

    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Right, Self::Truth];
}

/// Of what a percentage is stated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Of the compliance, mm/N: 14 % less compliance are 16.3 % more stiffness.
    Compliance,
    /// Of the stiffness, N/mm.
    Stiffness,
}

impl Measure {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Compliance => "compliance",
            Self::Stiffness => "stiffness",
        }
    }

    /// Both.
    pub const ALL: [Self; 2] = [Self::Compliance, Self::Stiffness];
}

/// How strengths go from trial to trial, as a scenario states it. Percentages are sizes of the change of
/// [`Staircase::measure`]; whether it is harder or softer is said by the change that is hidden.
#[derive(Clone, Debug, PartialEq)]
pub struct Staircase {
    /// One of [`RULES`].
    pub rule: &'static str,
    /// Of what the percentages are.
    pub measure: Measure,
    /// Steps up.
    pub step: Step,
    /// Strength of the first trial.
    pub start_percent: f64,
    /// Weakest.
    pub least_percent: f64,
    /// Strongest.
    pub most_percent: f64,
    /// Share of right answers that `weighted-up-down` goes to, 0 … 1.
    pub target: f64,
    /// The exercise ends after as many reversals; `None`: after its trials.
    pub reversals: Option<u32>,
    /// First reversals that the estimate leaves out.
    pub skipped_reversals: u32,
    /// Strengths of `constant`.
    pub constant_percent: Vec<f64>,
}

/// How far a staircase goes up at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Points of percent.
    Percent(f64),
    /// On a logarithmic scale of the percentage: 20 dB are a factor of 10.
    Decibel(f64),
}

impl Default for Staircase {
    /// 1-up 3-down in steps of 2 dB of compliance, from 40 %.
    fn default() -> Self {
        Self {
            rule: "1-up-3-down",
            measure: Measure::Compliance,
            step: Step::Decibel(2.0),
            start_percent: 40.0,
            least_percent: 1.0,
            most_percent: 75.0,
            target: 0.75,
            reversals: None,
            skipped_reversals: 4,
            constant_percent: vec![5.0, 10.0, 15.0, 20.0, 30.0, 40.0],
        }
    }
}

impl Default for Exercise {
    /// One hypertonic site among T1 to T12 on both sides, 50 trials of the same strength.
    fn default() -> Self {
        Self {
            task: TASKS[0],
            candidates: sites(DEFAULT_CANDIDATES).unwrap_or_default(),
            hides: Hides::Drawn {
                kind: DEFAULT_KIND,
                change: Change::CompliancePercent(-28.0),
                most: 1,
            },
            trials: 50,
            practice: 0,
            trial_limit_s: None,
            limit_s: None,
            feedback: Feedback::default(),
            asks_confidence: false,
            asks_kind: false,
            asks_severity: false,
            vary_stiffness_percent: 15.0,
            tolerance_mm: 25.0,
            seed: None,
            staircase: None,
        }
    }
}

const DEFAULT_CANDIDATES: &str = "T1-T12 both sides";
const DEFAULT_KIND: &str = "hypertonic";

/// Strengths that a staircase may reach, percent: a compliance cannot fall by all of it.
pub const STAIRCASE_PERCENT: RangeInclusive<f64> = 0.1..=90.0;
/// Trials of an exercise.
pub const TRIALS: RangeInclusive<i64> = 1..=10_000;
/// Most candidates.
pub const MOST_CANDIDATES: usize = 200;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExerciseTable {
    task: Spanned<String>,
    candidates: Option<Spanned<String>>,
    hides: Option<Spanned<String>>,
    dysfunction: Option<Spanned<String>>,
    change: Option<Spanned<ChangeTable>>,
    most: Option<Spanned<i64>>,
    trials: Option<Spanned<i64>>,
    practice: Option<Spanned<i64>>,
    trial_limit_s: Option<Spanned<f64>>,
    limit_s: Option<Spanned<f64>>,
    feedback: Option<Spanned<String>>,
    #[serde(default)]
    asks: Vec<Spanned<String>>,
    vary_stiffness_percent: Option<Spanned<f64>>,
    tolerance_mm: Option<Spanned<f64>>,
    seed: Option<Spanned<i64>>,
    staircase: Option<Spanned<StaircaseTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChangeTable {
    compliance_percent: Option<Spanned<f64>>,
    stiffness_percent: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StaircaseTable {
    rule: Option<Spanned<String>>,
    measure: Option<Spanned<String>>,
    step_percent: Option<Spanned<f64>>,
    step_db: Option<Spanned<f64>>,
    start_percent: Option<Spanned<f64>>,
    least_percent: Option<Spanned<f64>>,
    most_percent: Option<Spanned<f64>>,
    target_percent: Option<Spanned<f64>>,
    reversals: Option<Spanned<i64>>,
    skipped_reversals: Option<Spanned<i64>>,
    constant_percent: Option<Vec<Spanned<f64>>>,
}

impl Check<'_> {
    /// `[exercise]`; the sites of the built-in back are there where `on_back`.
    pub(super) fn exercise(
        &self,
        t: &ExerciseTable,
        on_back: bool,
    ) -> Result<Exercise, ScenarioError> {
        let default = Exercise::default();
        let task = self.choice("task", &t.task, &TASKS.map(|name| (name, name)))?;
        let hides = self.hides(t)?;
        let needs_sites = hides != Hides::Stated;
        if needs_sites && !on_back {
            let what =
                "sites belong to builtin = \"back\"; on a mesh hides = \"stated\" is allowed";
            return Err(self.fail(&t.task.span(), what));
        }
        let candidates = match &t.candidates {
            None if needs_sites => default.candidates,
            None => Vec::new(),
            Some(text) => self.candidates(text)?,
        };
        let feedback = match &t.feedback {
            None => default.feedback,
            Some(name) => self.choice("feedback", name, &Feedback::ALL.map(|f| (f.name(), f)))?,
        };
        let mut asks = [false; 3];
        for name in &t.asks {
            let which = [("confidence", 0), ("kind", 1), ("severity", 2)];
            asks[self.choice("asks", name, &which)?] = true;
        }
        let whole = |key, value: &Option<Spanned<i64>>, allowed, or: u32| {
            value
                .as_ref()
                .map_or(Ok(or), |v| self.whole(key, v, allowed))
        };
        let limit = |key, value: &Option<Spanned<f64>>, allowed| {
            let given = value.as_ref();
            given.map(|v| self.number(key, v, allowed)).transpose()
        };
        Ok(Exercise {
            task,
            candidates,
            trials: whole("trials", &t.trials, TRIALS, default.trials)?,
            practice: whole("practice", &t.practice, 0..=1000, default.practice)?,
            trial_limit_s: limit("trial_limit_s", &t.trial_limit_s, 1.0..=3600.0)?,
            limit_s: limit("limit_s", &t.limit_s, 1.0..=86_400.0)?,
            feedback,
            asks_confidence: asks[0],
            asks_kind: asks[1],
            asks_severity: asks[2],
            vary_stiffness_percent: self.number_or(
                "vary_stiffness_percent",
                t.vary_stiffness_percent.as_ref(),
                0.0..=100.0,
                default.vary_stiffness_percent,
            )?,
            tolerance_mm: self.number_or(
                "tolerance_mm",
                t.tolerance_mm.as_ref(),
                1.0..=200.0,
                default.tolerance_mm,
            )?,
            seed: match &t.seed {
                None => None,
                Some(v) => Some(self.seed(v)?),
            },
            staircase: match &t.staircase {
                None => None,
                Some(s) => Some(self.staircase(s.get_ref())?),
            },
            hides,
        })
    }

    fn hides(&self, t: &ExerciseTable) -> Result<Hides, ScenarioError> {
        let stated = match &t.hides {
            None => false,
            Some(name) => self.choice("hides", name, &[("drawn", false), ("stated", true)])?,
        };
        if stated {
            let no_place = |key: &str, span| {
                let what = format!("{key} belongs to hides = \"drawn\"");
                Err(self.fail(&span, what))
            };
            if let Some(kind) = &t.dysfunction {
                return no_place("dysfunction", kind.span());
            }
            if let Some(change) = &t.change {
                return no_place("change", change.span());
            }
            if let Some(most) = &t.most {
                return no_place("most", most.span());
            }
            return Ok(Hides::Stated);
        }
        let kinds: Vec<(&str, &'static str)> = (dysfunction::all().iter())
            .map(|kind| (kind.key(), kind.key()))
            .collect();
        let kind = match &t.dysfunction {
            None => DEFAULT_KIND,
            Some(name) => self.choice("dysfunction", name, &kinds)?,
        };
        let change = match &t.change {
            None => Change::CompliancePercent(-28.0),
            Some(change) => self.exercise_change(change)?,
        };
        let most = match &t.most {
            None => 1,
            Some(v) => self.whole("most", v, 1..=20)? as usize,
        };
        Ok(Hides::Drawn { kind, change, most })
    }

    fn exercise_change(&self, t: &Spanned<ChangeTable>) -> Result<Change, ScenarioError> {
        let change = match (
            &t.get_ref().compliance_percent,
            &t.get_ref().stiffness_percent,
        ) {
            (Some(p), None) => {
                Change::CompliancePercent(self.number("compliance_percent", p, -90.0..=900.0)?)
            }
            (None, Some(p)) => {
                Change::StiffnessPercent(self.number("stiffness_percent", p, -90.0..=900.0)?)
            }
            _ => {
                let what = "change needs either compliance_percent or stiffness_percent";
                return Err(self.fail(&t.span(), what));
            }
        };
        if change.factor() == 1.0 {
            return Err(self.fail(&t.span(), "change = 0 %; what is hidden must be felt"));
        }
        Ok(change)
    }

    fn candidates(&self, text: &Spanned<String>) -> Result<Vec<Site>, ScenarioError> {
        let found = sites(text.get_ref())
            .map_err(|e| self.fail(&text.span(), format!("candidates = {e}")))?;
        if found.len() > MOST_CANDIDATES {
            let n = found.len();
            let what = format!("candidates are {n} sites; at most {MOST_CANDIDATES} are allowed");
            return Err(self.fail(&text.span(), what));
        }
        Ok(found)
    }

    fn whole(
        &self,
        key: &str,
        value: &Spanned<i64>,
        allowed: RangeInclusive<i64>,
    ) -> Result<u32, ScenarioError> {
        let n = *value.get_ref();
        if allowed.contains(&n) {
            return Ok(u32::try_from(n).unwrap_or(u32::MAX));
        }
        let what = format!(
            "{key} = {n}; {} to {} is allowed",
            allowed.start(),
            allowed.end()
        );
        Err(self.fail(&value.span(), what))
    }

    fn seed(&self, value: &Spanned<i64>) -> Result<u64, ScenarioError> {
        u64::try_from(*value.get_ref()).map_err(|_| {
            let what = format!("seed = {}; 0 and above is allowed", value.get_ref());
            self.fail(&value.span(), what)
        })
    }

    fn staircase(&self, t: &StaircaseTable) -> Result<Staircase, ScenarioError> {
        let default = Staircase::default();
        let rule = match &t.rule {
            None => default.rule,
            Some(name) => self.choice("rule", name, &RULES.map(|rule| (rule, rule)))?,
        };
        let measure = match &t.measure {
            None => default.measure,
            Some(name) => self.choice("measure", name, &Measure::ALL.map(|m| (m.name(), m)))?,
        };
        let step = match (&t.step_percent, &t.step_db) {
            (None, None) => default.step,
            (Some(v), None) => Step::Percent(self.number("step_percent", v, 0.01..=50.0)?),
            (None, Some(v)) => Step::Decibel(self.number("step_db", v, 0.01..=20.0)?),
            (Some(_), Some(v)) => {
                let what = "step_db beside step_percent; only one of them is allowed";
                return Err(self.fail(&v.span(), what));
            }
        };
        // A compliance cannot fall by all of it; a stiffness may rise by more than all of it.
        let most = match measure {
            Measure::Compliance => *STAIRCASE_PERCENT.end(),
            Measure::Stiffness => 900.0,
        };
        let percent = |key, value: &Option<Spanned<f64>>, or: f64| {
            let allowed = *STAIRCASE_PERCENT.start()..=most;
            self.number_or(key, value.as_ref(), allowed, or)
        };
        let least_percent = percent("least_percent", &t.least_percent, default.least_percent)?;
        let most_percent = percent("most_percent", &t.most_percent, default.most_percent)?;
        if most_percent <= least_percent {
            let span = t.most_percent.as_ref().or(t.least_percent.as_ref());
            let what = format!(
                "most_percent = {most_percent}; above least_percent = {least_percent} is allowed"
            );
            return Err(self.fail(&span.map_or(0..0, Spanned::span), what));
        }
        let between = least_percent..=most_percent;
        let start_percent = match &t.start_percent {
            None => default.start_percent.clamp(least_percent, most_percent),
            Some(v) => self.number("start_percent", v, between.clone())?,
        };
        let constant_percent = match &t.constant_percent {
            None => default.constant_percent,
            Some(all) => all
                .iter()
                .map(|v| self.number("constant_percent", v, between.clone()))
                .collect::<Result<_, _>>()?,
        };
        let whole = |key, value: &Option<Spanned<i64>>, allowed| {
            let given = value.as_ref();
            given.map(|v| self.whole(key, v, allowed)).transpose()
        };
        Ok(Staircase {
            rule,
            measure,
            step,
            start_percent,
            least_percent,
            most_percent,
            target: self.number_or(
                "target_percent",
                t.target_percent.as_ref(),
                10.0..=99.0,
                100.0 * default.target,
            )? / 100.0,
            reversals: whole("reversals", &t.reversals, 2..=1000)?,
            skipped_reversals: whole("skipped_reversals", &t.skipped_reversals, 0..=100)?
                .unwrap_or(default.skipped_reversals),
            constant_percent,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use proptest::prelude::*;

    const HEAD: &str = "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nstiffness.constant_n_per_mm = 1\n[exercise]\n";

    fn parse(table: &str) -> Result<Exercise, ScenarioError> {
        let scenario = Scenario::parse(&format!("{HEAD}{table}"), "a.toml", None)?;
        Ok(scenario.exercise.expect("stated"))
    }

    #[test]
    fn what_is_left_out_has_its_default() {
        for task in TASKS {
            let found = parse(&format!("task = {task:?}")).expect(task);
            assert_eq!(
                found,
                Exercise {
                    task,
                    ..Exercise::default()
                }
            );
        }
        assert_eq!(Exercise::default().candidates.len(), 24);
        let staircase = parse("task = \"locate\"\nstaircase = {}")
            .expect("good")
            .staircase;
        assert_eq!(staircase, Some(Staircase::default()));
    }

    #[test]
    fn what_is_stated_is_what_is_asked() {
        let found = parse(
            "task = \"compare\"\ncandidates = \"T3-T4 both sides\"\ndysfunction = \"texture\"\n\
             change = { stiffness_percent = -20 }\nmost = 3\ntrials = 7\npractice = 2\ntrial_limit_s = 30\nlimit_s = 600\n\
             feedback = \"right\"\nasks = [\"kind\", \"severity\"]\nvary_stiffness_percent = 0\ntolerance_mm = 9\nseed = 5\n\
             [exercise.staircase]\nrule = \"weighted-up-down\"\nmeasure = \"stiffness\"\nstep_percent = 4\nstart_percent = 60\n\
             least_percent = 5\nmost_percent = 200\ntarget_percent = 80\nreversals = 9\nskipped_reversals = 1\n\
             constant_percent = [5, 60]",
        )
        .expect("good");
        let change = Change::StiffnessPercent(-20.0);
        assert_eq!(
            found.hides,
            Hides::Drawn {
                kind: "texture",
                change,
                most: 3
            }
        );
        assert_eq!(
            (found.candidates.len(), found.trials, found.practice),
            (4, 7, 2)
        );
        assert_eq!(
            (found.trial_limit_s, found.limit_s, found.seed),
            (Some(30.0), Some(600.0), Some(5))
        );
        assert_eq!(
            [found.asks_confidence, found.asks_kind, found.asks_severity],
            [false, true, true]
        );
        assert_eq!(found.feedback, Feedback::Right);
        let expected = Staircase {
            rule: "weighted-up-down",
            measure: Measure::Stiffness,
            step: Step::Percent(4.0),
            start_percent: 60.0,
            least_percent: 5.0,
            most_percent: 200.0,
            target: 0.8,
            reversals: Some(9),
            skipped_reversals: 1,
            constant_percent: vec![5.0, 60.0],
        };
        assert_eq!(found.staircase, Some(expected));
    }

    #[test]
    fn each_fault_is_told_with_line_key_value_and_what_is_allowed() {
        for (table, told) in [
            (
                "task = \"guess\"",
                "line 6: task = \"guess\"; allowed are \"locate\"",
            ),
            ("trials = 3", "missing key `task`"),
            (
                "task = \"locate\"\ntrials = 0",
                "line 7: trials = 0; 1 to 10000 is allowed",
            ),
            (
                "task = \"locate\"\ncandidates = \"T13\"",
                "line 7: candidates = \"T13\"",
            ),
            (
                "task = \"locate\"\ndysfunction = \"bad\"",
                "line 7: dysfunction = \"bad\"; allowed are",
            ),
            (
                "task = \"locate\"\nchange = {}",
                "line 7: change needs either",
            ),
            (
                "task = \"locate\"\nchange = { compliance_percent = 0 }",
                "line 7: change = 0 %",
            ),
            (
                "task = \"locate\"\nchange = { compliance_percent = -100 }",
                "-90 to 900 is allowed",
            ),
            (
                "task = \"locate\"\nfeedback = \"all\"",
                "line 7: feedback = \"all\"",
            ),
            (
                "task = \"locate\"\nasks = [\"name\"]",
                "line 7: asks = \"name\"",
            ),
            (
                "task = \"locate\"\nseed = -1",
                "line 7: seed = -1; 0 and above",
            ),
            ("task = \"locate\"\nlimit_s = nan", "line 7: limit_s = NaN"),
            (
                "task = \"locate\"\nhides = \"stated\"\nmost = 2",
                "line 8: most belongs to hides = \"drawn\"",
            ),
            (
                "task = \"locate\"\nhints = true",
                "line 7: unknown key `hints`",
            ),
            (
                "task = \"locate\"\nstaircase = { rule = \"up\" }",
                "line 7: rule = \"up\"",
            ),
            (
                "task = \"locate\"\nstaircase = { step_db = 1, step_percent = 1 }",
                "only one of them",
            ),
            (
                "task = \"locate\"\nstaircase = { start_percent = 95 }",
                "start_percent = 95; 1 to 75",
            ),
            (
                "task = \"locate\"\nstaircase = { least_percent = 50, most_percent = 40 }",
                "most_percent = 40; above",
            ),
            (
                "task = \"locate\"\nstaircase = { constant_percent = [80] }",
                "constant_percent = 80",
            ),
        ] {
            let error = parse(table).expect_err(table).to_string();
            assert!(
                error.contains(told) && !error.contains('\n'),
                "{table:?} gave {error:?}"
            );
        }
        let mesh = HEAD.replace("surface.builtin = \"back\"", "surface.mesh = \"a.obj\"");
        let error = Scenario::parse(&format!("{mesh}task = \"locate\""), "a.toml", None);
        assert!(error.is_err_and(|e| e.0.contains("line 6: sites belong to builtin")));
    }

    proptest! {
        #[test]
        fn no_number_makes_it_fail_otherwise_than_in_one_line(x in any::<f64>(), n in any::<i64>(), key in 0..8_usize) {
            let keys = ["trials", "seed", "limit_s", "tolerance_mm", "vary_stiffness_percent", "most", "practice", "trial_limit_s"];
            for value in [format!("{n}"), format!("{x:e}")] {
                if let Err(e) = parse(&format!("task = \"locate\"\n{} = {value}", keys[key])) {
                    prop_assert!(e.0.starts_with("a.toml: line ") && !e.0.contains('\n'), "{}", e.0);
                }
            }
        }
    }
}
