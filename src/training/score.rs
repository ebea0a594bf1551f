//! By how much an answer is wrong, and what many answers come to.

use super::trial::{Answer, Draw, Mark, Reply, TrialRecord};
use crate::geom::Vec2;
use crate::scenario::{Exercise, Site};
use serde::{Deserialize, Serialize};

/// By how much an answer is wrong. What is not asked is absent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Errors {
    /// Levels that the answer lies below the truth; negative above.
    pub levels: Option<i32>,
    /// Whether the side is right.
    pub side_right: Option<bool>,
    /// Distance on the map plane, mm; in a free search the mean over what was found.
    pub mm: Option<f64>,
    /// Whether the kind is right; in a free search that of all that were found.
    pub kind_right: Option<bool>,
    /// Grades that the answer lies above the truth; negative below. In a free search the sum over what was found.
    pub severity: Option<i32>,
    /// Hidden places that were found.
    pub found: Option<u32>,
    /// Hidden places that were not.
    pub missed: Option<u32>,
    /// Marks where nothing is hidden.
    pub false_positives: Option<u32>,
}

/// How far `reply` is from the truth.
pub fn errors(exercise: &Exercise, draw: &Draw, reply: &Reply) -> Errors {
    let mut errors = match (&draw.right, &reply.answer) {
        (Answer::Site(truth), Answer::Site(said)) => placed(*truth, *said, said.at_mm()),
        (Answer::Site(truth), Answer::Here(at)) => {
            let distance = |s: &&Site| s.at_mm().distance_squared(*at);
            let nearest =
                (exercise.candidates.iter()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            placed(*truth, nearest.copied().unwrap_or(*truth), *at)
        }
        (Answer::Level(truth), Answer::Level(said)) => Errors {
            levels: Some(truth.levels_down_to(*said)),
            ..Errors::default()
        },
        (Answer::Severity(truth), Answer::Severity(said)) => Errors {
            severity: Some(i32::from(*said) - i32::from(*truth)),
            ..Errors::default()
        },
        (Answer::Marks(truth), Answer::Marks(said)) => {
            return marked(truth, said, exercise.tolerance_mm);
        }
        _ => Errors::default(),
    };
    if let [hidden] = &draw.hidden[..] {
        if exercise.asks_kind {
            errors.kind_right = reply.kind.as_ref().map(|kind| kind == hidden.kind);
        }
        if exercise.asks_severity && errors.severity.is_none() {
            let said = reply.severity;
            errors.severity = said.map(|said| i32::from(said) - i32::from(hidden.severity));
        }
    }
    errors
}

fn placed(truth: Site, said: Site, said_mm: Vec2) -> Errors {
    Errors {
        levels: Some(truth.level.levels_down_to(said.level)),
        side_right: Some(truth.side == said.side),
        mm: Some(truth.at_mm().distance(said_mm)),
        ..Errors::default()
    }
}

/// Marks against hidden places: the nearest pair within the tolerance first, each of either used once.
fn marked(truth: &[Mark], said: &[Mark], tolerance_mm: f64) -> Errors {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, hidden) in truth.iter().enumerate() {
        for (j, mark) in said.iter().enumerate() {
            let distance_mm = hidden.at_mm.distance(mark.at_mm);
            if distance_mm <= tolerance_mm {
                pairs.push((distance_mm, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut used, mut found) = (vec![false; said.len()], vec![None; truth.len()]);
    for (distance_mm, i, j) in pairs {
        if found[i].is_none() && !used[j] {
            found[i] = Some((distance_mm, j));
            used[j] = true;
        }
    }
    let hits: Vec<(&Mark, &Mark, f64)> = found
        .iter()
        .enumerate()
        .filter_map(|(i, hit)| hit.map(|(distance_mm, j)| (&truth[i], &said[j], distance_mm)))
        .collect();
    let n = hits.len();
    let any = |all: Vec<bool>| (!all.is_empty()).then(|| all.iter().all(|&right| right));
    let kinds = hits.iter().filter(|(_, said, _)| said.kind.is_some());
    let severities: Vec<i32> = hits
        .iter()
        .filter_map(|(truth, said, _)| Some(i32::from(said.severity?) - i32::from(truth.severity?)))
        .collect();
    Errors {
        mm: (n > 0).then(|| hits.iter().map(|hit| hit.2).sum::<f64>() / n as f64),
        kind_right: any(kinds
            .map(|(truth, said, _)| truth.kind == said.kind)
            .collect()),
        severity: (!severities.is_empty()).then(|| severities.iter().sum()),
        found: Some(n as u32),
        missed: Some((truth.len() - n) as u32),
        false_positives: Some((said.len() - n) as u32),
        ..Errors::default()
    }
}

/// What the scored trials of an exercise come to. Means are over the trials that have the figure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Scored trials.
    pub trials: u32,
    /// Right ones.
    pub right: u32,
    /// Their share, 0 … 1.
    pub right_share: Option<f64>,
    /// Share of right answers by guessing.
    pub chance: Option<f64>,
    /// Mean size of the error in levels.
    pub levels: Option<f64>,
    /// Share of answers on the wrong side.
    pub side_wrong_share: Option<f64>,
    /// Mean distance from the truth, mm.
    pub mm: Option<f64>,
    /// Share of answers of the right kind.
    pub kind_right_share: Option<f64>,
    /// Mean size of the error in grades.
    pub severity: Option<f64>,
    /// Hidden places found, all in all.
    pub found: u32,
    /// Hidden places not found.
    pub missed: u32,
    /// Marks where nothing was hidden.
    pub false_positives: u32,
    /// Mean of how sure the right answers were, percent.
    pub confidence_right_percent: Option<f64>,
    /// Mean of how sure the wrong answers were, percent.
    pub confidence_wrong_percent: Option<f64>,
    /// Median time spent palpating, s.
    pub search_s: Option<f64>,
    /// Mean way of the fingers, mm.
    pub path_mm: Option<f64>,
    /// Mean share of the skin touched.
    pub coverage: Option<f64>,
    /// Largest force, N.
    pub peak_force_n: Option<f64>,
    /// Mean of the mean forces, N.
    pub mean_force_n: Option<f64>,
    /// Presses of tender places beyond what they bear, all in all.
    pub tender_presses: u32,
}

impl Score {
    /// Of the scored trials among `trials`.
    pub fn of<'a>(trials: impl IntoIterator<Item = &'a TrialRecord>) -> Self {
        let trials: Vec<&TrialRecord> = trials.into_iter().filter(|t| !t.practice).collect();
        let mean = |value: &dyn Fn(&TrialRecord) -> Option<f64>| {
            let values: Vec<f64> = trials.iter().filter_map(|t| value(t)).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let total = |value: &dyn Fn(&TrialRecord) -> u32| {
            trials.iter().map(|t| value(t)).fold(0, u32::saturating_add)
        };
        let share = |is: bool| f64::from(u8::from(is));
        let confident = |right: bool| {
            mean(&|t| {
                let said = t.confidence_percent.filter(|_| t.right == right);
                said.map(f64::from)
            })
        };
        let right = trials.iter().filter(|t| t.right).count() as u32;
        Self {
            trials: trials.len() as u32,
            right,
            right_share: mean(&|t| Some(share(t.right))),
            chance: mean(&|t| Some(t.chance)),
            levels: mean(&|t| t.errors.levels.map(|n| f64::from(n.abs()))),
            side_wrong_share: mean(&|t| t.errors.side_right.map(|right| share(!right))),
            mm: mean(&|t| t.errors.mm),
            kind_right_share: mean(&|t| t.errors.kind_right.map(share)),
            severity: mean(&|t| t.errors.severity.map(|n| f64::from(n.abs()))),
            found: total(&|t| t.errors.found.unwrap_or(0)),
            missed: total(&|t| t.errors.missed.unwrap_or(0)),
            false_positives: total(&|t| t.errors.false_positives.unwrap_or(0)),
            confidence_right_percent: confident(true),
            confidence_wrong_percent: confident(false),
            search_s: median(trials.iter().map(|t| t.search_s).collect()),
            path_mm: mean(&|t| Some(t.palpation.path_mm)),
            coverage: mean(&|t| Some(t.palpation.coverage)),
            peak_force_n: (trials.iter().map(|t| t.palpation.peak_force_n)).reduce(f64::max),
            mean_force_n: mean(&|t| {
                Some(t.palpation.mean_force_n).filter(|_| t.palpation.contact_s > 0.0)
            }),
            tender_presses: total(&|t| t.palpation.tender_presses),
        }
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let upper = values.get(n / 2)?;
    Some(if n % 2 == 1 {
        *upper
    } else {
        0.5 * (values[n / 2 - 1] + upper)
    })
}
