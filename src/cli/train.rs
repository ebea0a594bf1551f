//! `dorsum train`: an exercise done by a simulated observer, its journal, its score sheet and its fit.

use super::common::{load_scenario, progress_bar};
use super::{CliError, Outcome, print, print_json};
use crate::scenario::exercise::{Measure, RULES};
use crate::training::analysis::{self, Analysis, Fitted, Options};
use crate::training::journal::{Changes, Header};
use crate::training::level::{compliance_percent, stiffness_percent};
use crate::training::observer::{Hand, Observer, Pressing, Reading};
use crate::training::psychometric::{Family, Point};
use crate::training::random::Random;
use crate::training::sheet::{self, Done};
use crate::training::shown::Phase;
use crate::training::sitting::{journals, pseudonym};
use crate::training::{Begun, Ground, Sitting, journal};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Which exercise, who does it, what becomes of it.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct TrainArgs {
    /// Scenario file with an [exercise], or the name of an example, such as locate.toml.
    #[arg(required_unless_present = "resume", conflicts_with = "resume")]
    scenario: Option<String>,
    /// Go on with the exercise in this folder, at the trial after the last one that was settled.
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// Who does it: a simulated observer, as in d-prime=10,lapse=0.02. d-prime is for each unit of the logarithm of the ratio
    /// of stiffness; also bias, false-alarms, policy=press or read.
    #[arg(long, value_name = "KEY=VALUE,…", conflicts_with = "resume")]
    observer: Option<Observer>,
    /// Scored trials; as many as the exercise says without it.
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    trials: Option<u32>,
    /// Where chance starts; the same seed gives the same trials. Without it nobody knows them beforehand.
    #[arg(long, value_name = "N", conflicts_with = "resume")]
    seed: Option<u64>,
    /// Pseudonym of who does it.
    #[arg(long, value_name = "NAME", conflicts_with = "resume", value_parser = participant)]
    participant: Option<String>,
    /// Rule by which the strength goes from trial to trial.
    #[arg(long, value_name = "NAME", conflicts_with = "resume", value_parser = rule)]
    staircase: Option<String>,
    /// Folder of the journal and the score sheet; must not hold an exercise yet.
    #[arg(
        long,
        value_name = "DIR",
        required_unless_present = "resume",
        conflicts_with = "resume"
    )]
    out: Option<PathBuf>,
    /// Rest for so long after each trial, s.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = pace_s)]
    pace: f64,
    #[command(subcommand)]
    command: Option<TrainCommand>,
}

#[derive(Debug, clap::Subcommand)]
enum TrainCommand {
    /// Write the score sheet of an exercise, or of all exercises in the folders of a folder.
    Sheet {
        /// Folder with a journal, or with folders that have one.
        folder: PathBuf,
        /// Where to write it; beside the journals without it.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        #[command(flatten)]
        fit: FitArgs,
    },
    /// Fit a psychometric function to answers in a CSV file with the columns x_percent, trials, right.
    Fit {
        /// The file; also a trials.csv of a score sheet.
        file: PathBuf,
        /// Share of right answers by guessing, 0 to 0.9; as the file says without it, or else 1/2.
        #[arg(long, value_name = "SHARE", value_parser = chance)]
        chance: Option<f64>,
        #[command(flatten)]
        fit: FitArgs,
    },
}

#[derive(Debug, clap::Args)]
struct FitArgs {
    /// weibull, logistic, normal or detection.
    #[arg(long, value_name = "NAME", default_value = "weibull", value_parser = family)]
    family: Family,
    /// Share of right answers at the threshold, percent; half the way from chance to certainty without it.
    #[arg(long, value_name = "PERCENT", value_parser = target)]
    at: Option<f64>,
    /// Samples of the bootstrap.
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    samples: u32,
}

impl FitArgs {
    fn options(&self) -> Options {
        Options {
            family: self.family,
            target: self.at,
            samples: self.samples,
        }
    }
}

fn participant(name: &str) -> Result<String, String> {
    pseudonym(name).map_err(|e| e.0)?;
    Ok(name.to_owned())
}

fn rule(name: &str) -> Result<String, String> {
    let known = RULES.contains(&name);
    known
        .then(|| name.to_owned())
        .ok_or_else(|| format!("allowed are {}", RULES.join(", ")))
}

fn family(name: &str) -> Result<Family, String> {
    let names = Family::ALL.map(Family::name).join(", ");
    Family::by_name(name).ok_or_else(|| format!("allowed are {names}"))
}

fn number_in(text: &str, low: f64, high: f64) -> Result<f64, String> {
    let read = text.parse().ok().filter(|x| (low..=high).contains(x));
    read.ok_or_else(|| format!("{low} to {high} is allowed"))
}

fn pace_s(text: &str) -> Result<f64, String> {
    number_in(text, 0.0, 60.0)
}

fn chance(text: &str) -> Result<f64, String> {
    number_in(text, 0.0, 0.9)
}

fn target(text: &str) -> Result<f64, String> {
    Ok(number_in(text, 1.0, 99.0)? / 100.0)
}

/// Does what is asked.
///
/// # Errors
/// The scenario has no exercise, the folder cannot be used, a file cannot be read.
pub fn run(args: &TrainArgs, json: bool) -> Result<Outcome, CliError> {
    match &args.command {
        Some(TrainCommand::Sheet { folder, out, fit }) => write_sheet(
            folder,
            out.as_deref().unwrap_or(folder),
            &fit.options(),
            json,
        ),
        Some(TrainCommand::Fit { file, chance, fit }) => {
            fit_file(file, *chance, &fit.options(), json)
        }
        None => train(args, json),
    }
}

#[derive(serde::Serialize)]
struct Printed {
    scenario: String,
    participant: Option<String>,
    observer: String,
    settled_before: u32,
    trials: u32,
    ended: Option<String>,
    staircase: Option<Staircase>,
    analysis: Analysis,
    true_threshold_percent: Option<f64>,
    journal: PathBuf,
    sheet: Vec<PathBuf>,
}

#[derive(serde::Serialize)]
struct Staircase {
    reversals: usize,
    target: f64,
    threshold_percent: f64,
    /// The strengths one standard error below and above.
    between_percent: Option<[f64; 2]>,
    true_threshold_percent: Option<f64>,
}

fn train(args: &TrainArgs, json: bool) -> Result<Outcome, CliError> {
    let (folder, mut sitting) = begin(args)?;
    let observer = (sitting.header().observer.as_ref())
        .ok_or_else(|| {
            CliError::input(
                "the exercise is a person's: do it in the workbench (dorsum); here a simulated --observer trains",
            )
        })?
        .parse::<Observer>()
        .map_err(CliError::input)?;
    let settled_before = sitting.run().n_scored();
    let blind = sitting.run().blind_scenario().clone();
    let mut hand: Box<dyn Hand> = if observer.felt {
        let hand = Pressing::new(blind).map_err(CliError::input)?;
        sitting.set_ground(Ground::of(hand.scene(), sitting.run().candidates_mm()));
        Box::new(hand)
    } else {
        Box::new(Reading::new(blind))
    };
    let of = sitting.run().shown().of;
    let bar = progress_bar(u64::from(of), "{msg:12} {bar:40} {pos}/{len}  {eta}");
    let mut now_s = 0.0;
    loop {
        let shown = sitting.run().shown();
        if matches!(shown.phase, Phase::Done(_)) {
            break;
        }
        // Each trial has a chance of its own, so that a resumed observer goes on as it would have.
        let number = u64::from(shown.trial) << 1 | u64::from(shown.practice);
        let seed = sitting.header().seed.unwrap_or(0);
        let mut random = Random::new(Random::new(seed ^ 0x0b5e_77e7).bits() ^ number);
        observer
            .do_trial(&mut sitting, hand.as_mut(), &mut random, &mut now_s)
            .map_err(CliError::input)?;
        bar.set_position(u64::from(sitting.run().n_scored()));
        if args.pace > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(args.pace));
        }
    }
    bar.finish_and_clear();
    let staircase = staircase(&sitting, &observer);
    let target = staircase.as_ref().map(|s| s.target);
    let exercise = sitting.run().exercise().clone();
    drop(sitting);

    let options = Options {
        target,
        ..Options::default()
    };
    let done = Done::new(journal::read(&folder).map_err(CliError::input)?, &options);
    let sheet = sheet::write(&folder, std::slice::from_ref(&done)).map_err(CliError::input)?;
    let analysis = done.analysis.clone();
    let truth = analysis.fit.as_ref().and_then(|fit| {
        let ratio = observer.threshold(&exercise, fit.target)?;
        Some(percent_of(ratio, &fit.measure, softer(&exercise)))
    });
    let header = &done.read.header;
    let printed = Printed {
        scenario: header.scenario.clone(),
        participant: header.participant.clone(),
        observer: observer.to_string(),
        settled_before,
        trials: analysis.score.trials,
        ended: done.read.ended.clone(),
        staircase,
        analysis,
        true_threshold_percent: truth,
        journal: folder.join(journal::FILE),
        sheet,
    };
    if json {
        print_json(&printed)?;
    } else {
        tell(&printed);
    }
    Ok(Outcome::Done)
}

fn begin(args: &TrainArgs) -> Result<(PathBuf, Sitting), CliError> {
    if let Some(folder) = &args.resume {
        let (sitting, cut_off) = Sitting::resume(folder, |header: &Header| {
            load_scenario(&header.scenario).map_err(|e| e.to_string())
        })
        .map_err(CliError::input)?;
        if let Some(cut_off) = cut_off {
            eprintln!("dorsum: {}: {cut_off}", folder.display());
        }
        return Ok((folder.clone(), sitting));
    }
    let (Some(name), Some(folder)) = (&args.scenario, &args.out) else {
        return Err(CliError::input(
            "a scenario and --out DIR are needed, or --resume DIR",
        ));
    };
    let observer = args.observer.ok_or_else(|| {
        CliError::input(
            "--observer is needed, as in --observer d-prime=10; people train in the workbench (dorsum)",
        )
    })?;
    let scenario = load_scenario(name)?;
    if scenario.exercise.is_none() {
        return Err(CliError::input(format_args!(
            "{name} has no [exercise]; add one, or take an example that has, such as locate.toml"
        )));
    }
    let begun = Begun {
        scenario: name.clone(),
        participant: args.participant.clone(),
        changes: Changes {
            trials: args.trials,
            staircase: args.staircase.clone(),
        },
        seed: args.seed,
        observer: Some(observer.to_string()),
    };
    let sitting = Sitting::begin(folder, &scenario, &begun).map_err(CliError::input)?;
    Ok((folder.clone(), sitting))
}

fn softer(exercise: &crate::scenario::Exercise) -> bool {
    use crate::scenario::exercise::Hides;
    matches!(exercise.hides, Hides::Drawn { change, .. } if change.factor() < 1.0)
}

/// A size of a change, stated as the logarithm of the ratio of stiffness, in percent.
fn percent_of(log_ratio: f64, measure: &str, softer: bool) -> f64 {
    let factor = libm::exp(if softer { -log_ratio } else { log_ratio });
    let percent = if measure == Measure::Stiffness.name() {
        stiffness_percent(factor)
    } else {
        compliance_percent(factor)
    };
    percent.abs()
}

fn staircase(sitting: &Sitting, observer: &Observer) -> Option<Staircase> {
    let run = sitting.run();
    let (estimate, settings) = run.estimate()?;
    let percent = |level: f64| settings.scale.percent(level);
    let truth = observer.threshold(run.exercise(), estimate.target);
    let scale = settings.scale;
    Some(Staircase {
        reversals: run.reversals().len(),
        target: estimate.target,
        threshold_percent: percent(estimate.level),
        between_percent: (estimate.standard_error)
            .map(|e| [percent(estimate.level - e), percent(estimate.level + e)]),
        true_threshold_percent: truth
            .map(|ratio| percent_of(ratio, scale.measure.name(), scale.softer)),
    })
}

fn tell(printed: &Printed) {
    let score = &printed.analysis.score;
    print(format_args!("{} · {}", printed.scenario, printed.observer));
    if printed.settled_before > 0 {
        print(format_args!(
            "resumed       {} trials were settled before",
            printed.settled_before
        ));
    }
    let share = 100.0 * score.right_share.unwrap_or(0.0);
    let chance = 100.0 * score.chance.unwrap_or(0.0);
    print(format_args!(
        "trials        {}, {} right: {share:.1} % (chance {chance:.1} %)",
        score.trials, score.right
    ));
    if let Some(s) = &printed.staircase {
        let error = s.between_percent.map_or(String::new(), |[a, b]| {
            format!(" ({a:.2} to {b:.2} % within one standard error)")
        });
        let truth = s.true_threshold_percent.map_or(String::new(), |t| {
            format!("; the observer's own is {t:.2} %")
        });
        print(format_args!(
            "staircase     {:.2} %{error} at {:.2} % right, {} reversals{truth}",
            s.threshold_percent,
            100.0 * s.target,
            s.reversals
        ));
    }
    if let Some(fit) = &printed.analysis.fit {
        tell_fit(fit, printed.true_threshold_percent);
    }
    if let Some(d) = &printed.analysis.d_prime {
        let per = d.per_log_ratio.map_or(String::new(), |s| {
            let error = d.standard_error.unwrap_or(0.0);
            format!("; {s:.2} ± {error:.2} for each unit of the logarithm of the ratio")
        });
        print(format_args!(
            "d′            {:.2} over all ({}){per}",
            d.over_all, d.model
        ));
    }
    if let Some(peak_n) = score.peak_force_n.filter(|n| *n > 0.0) {
        print(format_args!(
            "palpation     {:.1} s a trial, peak {peak_n:.2} N, mean {:.2} N",
            score.search_s.unwrap_or(0.0),
            score.mean_force_n.unwrap_or(0.0)
        ));
    }
    print(format_args!("journal       {}", printed.journal.display()));
    if let Some(page) = printed.sheet.first() {
        print(format_args!("score sheet   {}", page.display()));
    }
}

fn tell_fit(fit: &Fitted, truth: Option<f64>) {
    let [low, high] = fit.threshold_interval_percent;
    let truth = truth.map_or(String::new(), |t| {
        format!("; the observer's own is {t:.2} %")
    });
    print(format_args!(
        "fit           {:.2} % ({low:.2} to {high:.2} with 95 %) at {:.2} % right{truth}",
        fit.threshold_percent,
        100.0 * fit.target
    ));
    print(format_args!(
        "              {}: α {:.2} %, β {:.2} ({:.2} to {:.2}), λ {:.3}, γ {:.4}; Weber fraction {:.3}",
        fit.family,
        fit.alpha_percent,
        fit.beta,
        fit.beta_interval[0],
        fit.beta_interval[1],
        fit.lapse,
        fit.guess,
        fit.weber_fraction
    ));
    let told = if fit.at_bound {
        "; the answers do not tell threshold or slope"
    } else {
        ""
    };
    print(format_args!(
        "              deviance {:.2}, as large or larger in {:.1} % of simulated runs{told}",
        fit.deviance,
        100.0 * fit.fit_share
    ));
}

fn write_sheet(
    folder: &Path,
    out: &Path,
    options: &Options,
    json: bool,
) -> Result<Outcome, CliError> {
    let read = journals(folder).map_err(CliError::input)?;
    for read in &read {
        if let Some(cut_off) = &read.cut_off {
            eprintln!("dorsum: {}: {cut_off}", read.header.scenario);
        }
    }
    let done: Vec<Done> = read.into_iter().map(|r| Done::new(r, options)).collect();
    std::fs::create_dir_all(out)
        .map_err(|e| CliError::input(format_args!("{}: {e}", out.display())))?;
    let files = sheet::write(out, &done).map_err(CliError::input)?;
    if json {
        let analyses: Vec<&Analysis> = done.iter().map(|d| &d.analysis).collect();
        print_json(&serde_json::json!({ "exercises": analyses, "files": files }))?;
        return Ok(Outcome::Done);
    }
    for one in &done {
        let score = &one.analysis.score;
        print(format_args!(
            "{:<12} {:<16} {:>4} trials, {:>5.1} % right",
            one.participant(),
            one.read.trials.first().map_or("–", |t| &t.task),
            score.trials,
            100.0 * score.right_share.unwrap_or(0.0)
        ));
    }
    for file in &files {
        print(file.display());
    }
    Ok(Outcome::Done)
}

#[derive(serde::Deserialize)]
struct Row {
    #[serde(alias = "strength_percent")]
    x_percent: Option<f64>,
    trials: Option<u32>,
    right: String,
    chance: Option<f64>,
    practice: Option<bool>,
}

fn fit_file(
    file: &Path,
    chance: Option<f64>,
    options: &Options,
    json: bool,
) -> Result<Outcome, CliError> {
    let failed = |what: String| CliError::input(format_args!("{}: {what}", file.display()));
    let mut reader = csv::Reader::from_path(file).map_err(|e| failed(e.to_string()))?;
    let mut answers: Vec<Point> = Vec::new();
    let mut told_chance = None;
    for (i, row) in reader.deserialize::<Row>().enumerate() {
        let line = i + 2;
        let row = row.map_err(|e| failed(e.to_string()))?;
        told_chance = told_chance.or(row.chance);
        let Some(x) = row.x_percent.filter(|_| row.practice != Some(true)) else {
            continue;
        };
        if !(0.0..=1.0e6).contains(&x) {
            return Err(failed(format!(
                "line {line}: x_percent = {x}; 0 to 1000000 is allowed"
            )));
        }
        let n = row.trials.unwrap_or(1);
        let right = match row.right.as_str() {
            "true" => n,
            "false" => 0,
            text => text.parse().ok().filter(|k| *k <= n).ok_or_else(|| {
                failed(format!(
                    "line {line}: right = {text:?}; 0 to {n}, true or false is allowed"
                ))
            })?,
        };
        answers.push(Point { x, n, right });
    }
    let answers = gathered(answers);
    let chance = chance.or(told_chance).unwrap_or(0.5);
    let fit = analysis::fit_points(&answers, chance, options).ok_or_else(|| {
        failed("answers at two or more strengths above 0 are needed, in columns x_percent, trials, right".into())
    })?;
    if json {
        print_json(&fit)?;
    } else {
        tell_fit(&fit, None);
    }
    Ok(Outcome::Done)
}

/// Rows of one strength as one.
fn gathered(mut rows: Vec<Point>) -> Vec<Point> {
    rows.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mut out: Vec<Point> = Vec::new();
    for row in rows {
        match out.last_mut() {
            Some(last) if row.x - last.x <= 1.0e-9 * row.x => {
                last.n = last.n.saturating_add(row.n);
                last.right = last.right.saturating_add(row.right);
            }
            _ => out.push(row),
        }
    }
    out
}
