use super::*;
use crate::contact::{Contact, Touch};
use crate::geom::Vec3;
use crate::servo::FingerRecord;
use crate::training::trial::{Answer, Mark};

use crate::scenario::exercise::TASKS;
use crate::scenario::sites;

fn scenario(exercise: &str) -> Scenario {
    let text = format!(
        "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nstiffness.constant_n_per_mm = 0.5\n[exercise]\n{exercise}"
    );
    Scenario::parse(&text, "a.toml", None).expect("a scenario")
}

fn run(exercise: &str, seed: u64) -> Run {
    Run::new(&scenario(exercise), Seed::Secret(seed)).expect("a run")
}

/// Answers right or wrong, from the start of a trial into the next.
fn answer(run: &mut Run, right: bool, now_s: &mut f64) -> TrialRecord {
    *now_s += 1.0;
    run.take(Input::Start, *now_s).expect("ready");
    *now_s += 2.0;
    let truth = run.current.draw.right.clone();
    let others = run.shown().choices;
    let wrong = others.into_iter().map(|c| c.answer).find(|a| *a != truth);
    let said = if right {
        truth
    } else {
        wrong.unwrap_or(Answer::Marks(vec![Mark {
            at_mm: Vec2::new(500.0, 500.0),
            kind: None,
            severity: None,
        }]))
    };
    let record = run
        .take(Input::Answer(said.into()), *now_s)
        .expect("allowed");
    let record = record.expect("settled").clone();
    assert_eq!(record.right, right, "{record:?}");
    run.take(Input::Next, *now_s).expect("next");
    record
}

#[test]
fn every_task_goes_from_ready_to_ready_and_ends() {
    for task in TASKS {
        let mut run = run(&format!("task = \"{task}\"\ntrials = 3\npractice = 1"), 1);
        let mut now_s = 100.0;
        assert_eq!((run.shown().phase, run.felt()), (Phase::Ready, Felt::Blind));
        assert!(run.shown().practice && run.shown().of == 1);
        let practised = answer(&mut run, true, &mut now_s);
        assert!(practised.practice && practised.trial == 1);
        for i in 1..=3 {
            assert_eq!((run.shown().practice, run.shown().trial), (false, i));
            let record = answer(&mut run, i != 2, &mut now_s);
            assert_eq!((record.trial, record.task.as_str()), (i, task));
            assert!((record.search_s - 2.0).abs() < 1e-12, "{record:?}");
        }
        assert_eq!(run.shown().phase, Phase::Done(Why::AllDone));
        assert_eq!(run.shown().right_so_far, Some((2, 3)));
        assert!(run.take(Input::Start, now_s).is_err());
        assert_eq!(run.felt(), Felt::Blind);
    }
}

#[test]
fn what_is_shown_before_the_answer_is_the_same_whatever_is_hidden() {
    for task in ["locate", "severity", "search"] {
        let text = format!("task = \"{task}\"\ncandidates = \"T5 both\"");
        let mut seen: Vec<(String, String)> = Vec::new();
        let mut hidden = Vec::new();
        for seed in 0..40 {
            let mut run = run(&text, seed);
            let mut look = vec![format!("{:?}{run:?}", run.shown())];
            run.take(Input::Start, 1.0).expect("ready");
            look.push(format!("{:?}{run:?}", run.shown()));
            run.take(Input::Enough, 3.0).expect("palpating");
            look.push(format!("{:?}{run:?}", run.shown()));
            // Where the task points at one of the two candidates, that differs and no more.
            let pointed = format!("{:?}", run.shown().pointed);
            let look = look.join("\n").replace(&pointed, "");
            seen.push((look, run.blind_scenario().source.clone()));
            hidden.push(run.current.draw.right.to_string());
        }
        assert!(seen.windows(2).all(|w| w[0] == w[1]), "{task}");
        hidden.sort();
        hidden.dedup();
        assert!(hidden.len() > 1, "{task} always hides the same");
    }
}

#[test]
fn the_servo_alone_gets_what_is_hidden_and_only_while_it_is_felt() {
    let mut run = run("task = \"locate\"\nvary_stiffness_percent = 20", 5);
    let truth = run.current.draw.site().expect("one site");
    let (blind, hidden) = (run.blind_scenario().clone(), run.hidden_scenario().clone());
    assert!(blind.dysfunctions.is_empty());
    assert_eq!(hidden.dysfunctions[0].place, truth.into());
    let gain = hidden.stiffness_keys[0].stiffness_n_per_mm / 0.5;
    assert!(gain != 1.0 && (1.0 / 1.2..=1.2).contains(&gain), "{gain}");
    run.take(Input::Start, 0.0).expect("ready");
    assert_eq!(run.felt(), Felt::Hidden);
    run.take(Input::Pause(true), 1.0).expect("running");
    assert_eq!(run.felt(), Felt::Blind);
    assert!(run.take(Input::Enough, 1.0).is_err());
    run.take(Input::Pause(false), 2.0).expect("paused");
    run.take(Input::Answer(Answer::Here(truth.at_mm()).into()), 3.0)
        .expect("allowed");
    let record = run.settled().last().expect("settled");
    assert!(record.right && record.errors.mm == Some(0.0));
    assert_eq!(record.stiffness_gain, gain);
    assert!(
        (record.search_s - 2.0).abs() < 1e-12,
        "a pause counts for nothing"
    );
    assert_eq!(run.felt(), Felt::Blind);
    run.take(Input::FeelAgain(true), 4.0).expect("feedback");
    assert_eq!(run.felt(), Felt::Hidden);
    let told = run.shown().feedback.expect("told");
    assert!(told.right && told.can_feel_again && told.truth_mm == [truth.at_mm()]);
    run.take(Input::Next, 5.0).expect("next");
    assert_eq!((run.felt(), run.shown().feedback), (Felt::Blind, None));
}

#[test]
fn feedback_tells_no_more_than_it_is_asked_to() {
    for (feedback, tells, truth) in [
        ("none", false, false),
        ("right", true, false),
        ("truth", true, true),
    ] {
        let mut run = run(&format!("task = \"locate\"\nfeedback = \"{feedback}\""), 8);
        run.take(Input::Start, 0.0).expect("ready");
        let choices = run.shown().choices;
        let wrong = choices
            .into_iter()
            .find(|c| c.answer != run.current.draw.right);
        run.take(Input::Answer(wrong.expect("another").answer.into()), 1.0)
            .expect("allowed");
        let shown = run.shown();
        assert_eq!(shown.feedback.is_some(), tells);
        assert_eq!(shown.right_so_far.is_some(), tells);
        let told = shown
            .feedback
            .map(|t| (t.text.contains("It was at"), !t.truth.is_empty()));
        assert_eq!(told.unwrap_or_default(), (truth, truth));
        assert_eq!(run.take(Input::FeelAgain(true), 2.0).is_ok(), truth);
    }
}

#[test]
fn time_limits_end_palpation_and_the_exercise() {
    let mut run = run("task = \"compare\"\ntrial_limit_s = 10\nlimit_s = 25", 2);
    run.advance(50.0);
    assert_eq!(run.shown().exercise_left_s, Some(25.0), "it has not begun");
    run.take(Input::Start, 60.0).expect("ready");
    run.advance(64.0);
    run.advance(f64::NAN);
    run.advance(20.0);
    assert_eq!(run.shown().trial_left_s, Some(6.0));
    run.advance(71.0);
    assert_eq!(
        (run.shown().phase, run.felt()),
        (Phase::Answering, Felt::Blind)
    );
    run.take(Input::Answer(Answer::Stiffer(0).into()), 73.0)
        .expect("allowed");
    let record = run.settled()[0].clone();
    assert_eq!((record.ended, record.search_s), (Ended::OutOfTime, 10.0));
    run.take(Input::Next, 74.0).expect("next");
    run.advance(200.0);
    assert_eq!(
        run.shown().phase,
        Phase::Ready,
        "between trials the clock stands"
    );
    run.take(Input::Start, 200.0).expect("ready");
    run.advance(211.5);
    assert_eq!(run.shown().phase, Phase::Done(Why::OutOfTime));
    assert_eq!(run.n_scored(), 1, "the running trial is not scored");
}

#[test]
fn what_cannot_be_done_now_is_refused_and_changes_nothing() {
    let mut run = run(
        "task = \"locate\"\nasks = [\"confidence\"]\ncandidates = \"T5 both\"",
        4,
    );
    let site = run.exercise().candidates[0];
    let reply = |confidence_percent| Reply {
        confidence_percent,
        ..Answer::Site(site).into()
    };
    for input in [
        Input::Enough,
        Input::Next,
        Input::FeelAgain(true),
        Input::Answer(reply(Some(50))),
    ] {
        assert!(run.take(input.clone(), 0.0).is_err(), "{input:?}");
    }
    run.take(Input::Start, 0.0).expect("ready");
    assert!(run.take(Input::Start, 0.0).is_err());
    let elsewhere = sites("L4 left").expect("a site")[0];
    for reply in [
        reply(None),
        reply(Some(101)),
        Reply {
            severity: Some(4),
            ..reply(Some(50))
        },
        Reply {
            confidence_percent: Some(50),
            ..Answer::Site(elsewhere).into()
        },
        Reply {
            confidence_percent: Some(50),
            ..Answer::Same(true).into()
        },
        Reply {
            confidence_percent: Some(50),
            ..Answer::Here(Vec2::NAN).into()
        },
    ] {
        let error = run
            .take(Input::Answer(reply.clone()), 1.0)
            .expect_err("refused");
        assert!(!error.0.contains('\n'), "{reply:?}: {error}");
    }
    assert!(run.settled().is_empty());
    run.take(Input::Answer(reply(Some(0))), 1.0)
        .expect("allowed");
    run.take(Input::Abort, 1.0).expect("at any time");
    assert_eq!(run.shown().phase, Phase::Done(Why::Aborted));
}

#[test]
fn a_resumed_run_is_where_the_first_one_was() {
    let text = "task = \"locate\"\ntrials = 60\npractice = 2\n[exercise.staircase]\nrule = \"1-up-3-down\"";
    for cut in [0, 1, 2, 3, 20, 41] {
        let mut whole = run(text, 11);
        let mut now_s = 0.0;
        let mut right = super::super::random::Random::new(99);
        let mut pattern: Vec<bool> = (0..45).map(|_| right.below(3) > 0).collect();
        for &right in &pattern[..cut] {
            answer(&mut whole, right, &mut now_s);
        }
        // Through the text of a journal, and with another secret seed.
        let kept: Vec<TrialRecord> = whole
            .settled()
            .iter()
            .map(|t| serde_json::from_str(&serde_json::to_string(t).expect("text")).expect("read"))
            .collect();
        assert_eq!(kept, whole.settled());
        let mut again = Run::resume(&scenario(text), Seed::Secret(12), kept).expect("resumed");
        for &right in &pattern.split_off(cut) {
            assert_eq!(whole.current.level, again.current.level);
            assert_eq!(whole.shown().trial, again.shown().trial);
            answer(&mut whole, right, &mut now_s);
            answer(&mut again, right, &mut now_s);
        }
        assert_eq!(whole.reversals(), again.reversals());
        assert_eq!(whole.estimate().map(|e| e.0), again.estimate().map(|e| e.0));
        assert_eq!(whole.n_scored(), 43);
    }
}

#[test]
fn the_same_seed_gives_the_same_trials() {
    let text = "task = \"search\"\nmost = 4\ntrials = 20";
    let truths = |seed| {
        let mut run = run(text, seed);
        let mut now_s = 0.0;
        let truth = |run: &Run| {
            (
                run.current.draw.right.to_string(),
                run.current.gain.to_bits(),
            )
        };
        (0..20)
            .map(|_| {
                let drawn = truth(&run);
                answer(&mut run, true, &mut now_s);
                drawn
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(truths(3), truths(3));
    assert_ne!(truths(3), truths(4));
}

#[test]
fn what_the_scenario_states_can_be_hidden_and_searched_for() {
    let text = "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nstiffness.constant_n_per_mm = 0.5\n\
        [exercise]\ntask = \"search\"\nhides = \"stated\"\nvary_stiffness_percent = 0\nasks = [\"kind\"]\n\
        [[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\n";
    let scenario = Scenario::parse(text, "a.toml", None).expect("a scenario");
    let mut run = Run::new(&scenario, Seed::fresh()).expect("a run");
    assert!(run.blind_scenario().dysfunctions.is_empty());
    assert!(!run.blind_scenario().source.contains("T5"));
    assert_eq!(run.hidden_scenario().dysfunctions, scenario.dysfunctions);
    run.take(Input::Start, 0.0).expect("ready");
    let at_mm = sites("T5 right").expect("a site")[0].at_mm();
    let mark = |at_mm| Mark {
        at_mm,
        kind: Some("hypertonic".into()),
        severity: Some(3),
    };
    let marks = vec![
        mark(at_mm + Vec2::new(6.0, 8.0)),
        mark(Vec2::new(0.0, 100.0)),
    ];
    run.take(Input::Answer(Answer::Marks(marks).into()), 9.0)
        .expect("allowed");
    let record = &run.settled()[0];
    let errors = &record.errors;
    assert!(!record.right);
    assert_eq!(
        (errors.found, errors.missed, errors.false_positives),
        (Some(1), Some(0), Some(1))
    );
    assert!((errors.mm.expect("found one") - 10.0).abs() < 1e-9);
    assert_eq!((errors.kind_right, errors.severity), (Some(true), Some(1)));
    // What cannot be done is told.
    let none = Run::new(run.blind_scenario(), Seed::fresh());
    assert!(none.is_err_and(|e| e.0.contains("no [[dysfunction]]")));
}

#[test]
fn exercises_that_cannot_be_done_are_refused_in_one_line() {
    for (text, told) in [
        (
            "task = \"locate\"\ncandidates = \"T5 left\"",
            "1 candidates; at least 2",
        ),
        ("task = \"compare\"\ncandidates = \"T5 left\"", "at least 2"),
        (
            "task = \"level\"\ncandidates = \"T5 both\"",
            "at least 2 levels",
        ),
        ("task = \"level\"\nstaircase = {}", "no strength"),
        (
            "task = \"locate\"\ndysfunction = \"tender\"\nstaircase = {}",
            "leaves the stiffness as it is",
        ),
    ] {
        let error = Run::new(&scenario(text), Seed::fresh()).expect_err(text);
        assert!(error.0.contains(told) && !error.0.contains('\n'), "{error}");
    }
    let free =
        "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nstiffness.constant_n_per_mm = 0.5";
    let free = Scenario::parse(free, "a.toml", None).expect("a scenario");
    assert!(Run::new(&free, Seed::fresh()).is_err_and(|e| e.0.contains("no [exercise]")));
}

#[test]
fn palpation_counts_only_while_the_trainee_palpates() {
    let mut run = run("task = \"locate\"", 6);
    let site = run.exercise().candidates[3];
    let corners = [Vec2::new(-100.0, 0.0), Vec2::new(100.0, 500.0)];
    run.set_ground(Ground::new(corners, run.candidates_mm(), |_| true));
    let pressed = TickRecord {
        n_fingers: 1,
        fingers: std::array::from_fn(|_| FingerRecord {
            contact: Contact {
                touch: Touch::Stick,
                foot_mm: site.at_mm().extend(0.0),
                force_n: Vec3::Z * 3.0,
                ..Contact::default()
            },
            ..FingerRecord::default()
        }),
    };
    run.feel(&pressed, 0.5);
    run.take(Input::Start, 0.0).expect("ready");
    run.feel(&pressed, 0.001);
    run.take(Input::Enough, 1.0).expect("palpating");
    run.feel(&pressed, 0.5);
    let reply = run.current.draw.right.clone().into();
    let record = run
        .take(Input::Answer(reply), 2.0)
        .expect("allowed")
        .expect("settled");
    let facts = &record.palpation;
    assert_eq!(
        (facts.contact_s, facts.presses, facts.peak_force_n),
        (0.001, 1, 3.0)
    );
    assert_eq!(facts.visits, [3]);
}
