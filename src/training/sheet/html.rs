//! The sheet as one page to read and to print.

use super::{Done, plots};
use crate::figure::Page;
use crate::figure::plot::svg;
use crate::scenario::exercise::TASKS;
use crate::training::analysis::Fitted;
use crate::training::exercise;
use crate::training::trial::TrialRecord;
use maud::{Markup, PreEscaped, html};
use std::collections::BTreeMap;
use std::io::Result;

/// The page of some exercises: participants one after the other, their exercises in the order of time.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn page(done: &[Done]) -> Result<String> {
    let mut people: BTreeMap<&str, Vec<&Done>> = BTreeMap::new();
    for one in done {
        people.entry(one.participant()).or_default().push(one);
    }
    for exercises in people.values_mut() {
        exercises.sort_by(|a, b| a.read.header.started_utc.cmp(&b.read.header.started_utc));
    }
    let parts = people
        .iter()
        .map(|(name, exercises)| person(name, exercises));
    let parts: Vec<Markup> = parts.collect::<Result<_>>()?;
    let title = match &people.keys().collect::<Vec<_>>()[..] {
        [one] if **one != "–" => format!("Score sheet of {one}"),
        _ => "Score sheet".to_owned(),
    };
    let page = Page {
        kind: "Dorsum training",
        title: &title,
        style: "",
        body: html! { @for part in &parts { (part) } },
        footer: html! {
            "Thresholds are the strengths at which the stated share of answers is right for one who never lapses, from a \
             function fitted by maximum likelihood with the guess rate fixed at chance; their 95 % intervals \
             are of likelihood ratios, judged by a parametric bootstrap. A compliance 14 % lower is a stiffness 16.3 % higher."
        },
    };
    Ok(page.document())
}

fn person(name: &str, exercises: &[&Done]) -> Result<Markup> {
    let sections = exercises
        .iter()
        .map(|d| section(d))
        .collect::<Result<Vec<_>>>()?;
    let learning = match exercises.len() {
        0 | 1 => None,
        _ => Some(svg(&plots::learning(exercises), "")?),
    };
    Ok(html! {
        @if let Some(svg) = learning {
            section {
                h2 { "Participant " (name) ", " (exercises.len()) " exercises" }
                h3 { "Learning curve" }
                figure aria-label="Learning curve" { (PreEscaped(svg)) }
            }
        }
        @for section in &sections { (section) }
    })
}

fn section(done: &Done) -> Result<Markup> {
    let header = &done.read.header;
    let task = done.read.trials.first().map(|t| t.task.as_str());
    let task = task
        .filter(|t| TASKS.contains(t))
        .and_then(exercise::by_key);
    let when: String = header
        .started_utc
        .chars()
        .take(16)
        .collect::<String>()
        .replace('T', " ");
    let mut drawn: Vec<String> = Vec::new();
    if done.analysis.score.trials > 0 {
        let mut over_trials = vec![plots::accuracy(done)];
        over_trials.extend(plots::staircase(done));
        drawn.push(svg(&over_trials, "")?);
    }
    if let Some(fit) = &done.analysis.fit {
        drawn.push(svg(&[plots::psychometric(fit)], &caption(fit))?);
    }
    Ok(html! {
        section {
            h2 { (task.map_or("Exercise", |t| t.title())) }
            p.about { (task.map_or("", |t| t.about())) }
            p {
                "Participant " b { (done.participant()) } " · " (header.scenario) " · " (when) " UTC"
                @if let Some(observer) = &header.observer { " · simulated observer " (observer) }
                @if let Some(seed) = header.seed { " · seed " (seed) }
            }
            p { (done.read.ended.as_deref().unwrap_or("Not finished: it goes on where it was left.")) }
            (figures(done))
            @for svg in &drawn { figure { (PreEscaped(svg)) } }
            @if !done.read.trials.is_empty() {
                h3 { "Trials" }
                (trials(&done.read.trials))
            }
        }
    })
}

fn caption(fit: &Fitted) -> String {
    let told = match (fit.at_bound, fit.fit_share < 0.05) {
        (true, _) => "; the answers do not tell threshold or slope",
        (false, true) => "; the function does not suit the answers well",
        (false, false) => "",
    };
    format!(
        "{} fit: threshold {:.1} % ({:.1} to {:.1}) at {:.1} % right, slope {:.2}, lapse rate {:.1} %, guess rate {:.1} %, deviance {:.1} (p = {:.2}){told}.",
        fit.family,
        fit.threshold_percent,
        fit.threshold_interval_percent[0],
        fit.threshold_interval_percent[1],
        100.0 * fit.target,
        fit.beta,
        100.0 * fit.lapse,
        100.0 * fit.guess,
        fit.deviance,
        fit.fit_share
    )
}

/// The figures of an exercise, those that it has.
fn figures(done: &Done) -> Markup {
    let (score, analysis) = (&done.analysis.score, &done.analysis);
    let mut all: Vec<(String, String)> = Vec::new();
    let mut add = |value: Option<String>, name: &str| {
        all.extend(value.map(|value| (value, name.to_owned())));
    };
    let percent = |share: Option<f64>| share.map(|s| format!("{:.0} %", 100.0 * s));
    let some = |n: u32, wanted: bool| wanted.then(|| n.to_string());
    let chance = score
        .chance
        .map_or(String::new(), |c| format!(", chance {:.0} %", 100.0 * c));
    add(
        Some(format!("{} of {}", score.right, score.trials)),
        "answers right",
    );
    add(percent(score.right_share), &format!("right{chance}"));
    if let Some(fit) = &analysis.fit {
        add(
            Some(format!("{:.1} %", fit.threshold_percent)),
            &format!("smallest change of {} found", fit.measure),
        );
        add(Some(format!("{:.3}", fit.weber_fraction)), "Weber fraction");
    }
    if let Some(d) = &analysis.d_prime {
        add(Some(format!("{:.2}", d.over_all)), "d′ over all trials");
        let per = d.per_log_ratio.map(|s| format!("{s:.1}"));
        add(per, "d′ per log ratio of stiffness");
    }
    add(
        score.levels.map(|n| format!("{n:.1}")),
        "mean error, levels",
    );
    add(percent(score.side_wrong_share), "wrong side");
    add(score.mm.map(|mm| format!("{mm:.0} mm")), "mean error");
    add(percent(score.kind_right_share), "kind right");
    add(
        score.severity.map(|n| format!("{n:.1}")),
        "mean error, grades",
    );
    let searched = score.found + score.missed + score.false_positives > 0;
    add(
        searched.then(|| format!("{} of {}", score.found, score.found + score.missed)),
        "places found",
    );
    add(some(score.false_positives, searched), "false positives");
    add(
        score.confidence_right_percent.map(|c| format!("{c:.0} %")),
        "sure where right",
    );
    add(
        score.confidence_wrong_percent.map(|c| format!("{c:.0} %")),
        "sure where wrong",
    );
    add(
        score.search_s.map(|s| format!("{s:.1} s")),
        "median time to palpate",
    );
    let felt = score.peak_force_n.is_some_and(|f| f > 0.0);
    let if_felt = |value: Option<String>| value.filter(|_| felt);
    add(
        if_felt(score.path_mm.map(|mm| format!("{mm:.0} mm"))),
        "mean search path",
    );
    add(
        if_felt(score.coverage.map(|c| format!("{:.1} %", 100.0 * c))),
        "mean coverage of the back",
    );
    add(
        if_felt(score.peak_force_n.map(|n| format!("{n:.1} N"))),
        "peak force",
    );
    add(
        if_felt(score.mean_force_n.map(|n| format!("{n:.1} N"))),
        "mean force",
    );
    add(
        some(score.tender_presses, score.tender_presses > 0),
        "pressed beyond tenderness",
    );
    html! {
        ul.figures { @for (value, name) in &all { li { b { (value) } span { (name) } } } }
    }
}

fn trials(trials: &[TrialRecord]) -> Markup {
    let number =
        |x: Option<f64>, digits: usize| x.map_or("–".to_owned(), |x| format!("{x:.digits$}"));
    let has = |is: fn(&TrialRecord) -> bool| trials.iter().any(is);
    let (strong, sure) = (
        has(|t| t.strength_percent.is_some()),
        has(|t| t.confidence_percent.is_some()),
    );
    let (far, felt) = (
        has(|t| t.errors.mm.is_some()),
        has(|t| t.palpation.contact_s > 0.0),
    );
    let graded = has(|t| t.errors.severity.is_some());
    let marked = has(|t| t.errors.found.is_some());
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        th { "Trial" }
                        @if strong { th { "Change (%)" } }
                        th.text { "Truth" }
                        th.text { "Answer" }
                        th.text { "" }
                        @if sure { th { "Sure (%)" } }
                        @if far { th { "Error (mm)" } }
                        @if graded { th { "Grades off" } }
                        @if marked { th { "Found, missed, false" } }
                        th { "Palpated (s)" }
                        @if felt { th { "Path (mm)" } th { "Coverage (%)" } th { "Peak, mean (N)" } }
                    }
                }
                tbody {
                    @for t in trials {
                        tr {
                            td { @if t.practice { "practice " } (t.trial) }
                            @if strong { td { (number(t.strength_percent, 1)) } }
                            td.text { (t.truth) }
                            td.text { (t.answer) }
                            td.text {
                                @if t.right { span.badge.right { "right" } } @else { span.badge.wrong { "wrong" } }
                            }
                            @if sure { td { (number(t.confidence_percent.map(f64::from), 0)) } }
                            @if far { td { (number(t.errors.mm, 0)) } }
                            @if graded { td { (t.errors.severity.map_or("–".to_owned(), |n| format!("{n:+}"))) } }
                            @if marked {
                                td {
                                    (t.errors.found.unwrap_or(0)) ", " (t.errors.missed.unwrap_or(0)) ", "
                                    (t.errors.false_positives.unwrap_or(0))
                                }
                            }
                            td { (number(Some(t.search_s), 1)) }
                            @if felt {
                                td { (number(Some(t.palpation.path_mm), 0)) }
                                td { (number(Some(100.0 * t.palpation.coverage), 1)) }
                                td {
                                    (number(Some(t.palpation.peak_force_n), 1)) ", "
                                    (number(Some(t.palpation.mean_force_n), 1))
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
