use super::*;
use crate::scenario::Scenario;
use crate::training::journal::Changes;
use crate::training::sitting::Begun;
use crate::training::trial::TrialRecord;
use std::path::Path;

fn scenario(exercise: &str) -> Scenario {
    let text = format!(
        "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nsurface.triangles = 20389\nstiffness.constant_n_per_mm = 0.5\n[exercise]\n{exercise}"
    );
    Scenario::parse(&text, "a.toml", None).expect("a scenario")
}

fn begun(seed: u64) -> Begun {
    Begun {
        scenario: "a.toml".into(),
        participant: None,
        changes: Changes::default(),
        seed: Some(seed),
        observer: None,
    }
}

fn trained(observer: &Observer, folder: &Path, exercise: &str, trials: u32) -> Vec<TrialRecord> {
    let mut sitting = Sitting::begin(folder, &scenario(exercise), &begun(1)).expect("begun");
    let blind = sitting.run().blind_scenario().clone();
    let mut hand: Box<dyn Hand> = match observer.felt {
        true => Box::new(Pressing::new(blind).expect("built")),
        false => Box::new(Reading::new(blind)),
    };
    let (mut random, mut now_s) = (Random::new(3), 0.0);
    for _ in 0..trials {
        observer
            .do_trial(&mut sitting, hand.as_mut(), &mut random, &mut now_s)
            .expect("done");
    }
    sitting.run().settled().to_vec()
}

#[test]
fn an_observer_is_read_as_it_is_shown() {
    let text = "d-prime=8.5,lapse=0.02,bias=-0.5,false-alarms=0.3,policy=read";
    let observer: Observer = text.parse().expect("read");
    assert_eq!(observer.to_string(), text);
    assert_eq!("".parse(), Ok(Observer::default()));
    for (wrong, told) in [
        ("d-prime", "key=value"),
        ("d-prime=x", "0 to 1000"),
        ("lapse=1.1", "0 to 1"),
        ("lapse=NaN", "0 to 1"),
        ("policy=kick", "press, read"),
        ("eyes=2", "allowed are d-prime"),
    ] {
        let error = wrong.parse::<Observer>().expect_err(wrong);
        assert!(error.contains(told), "{wrong}: {error}");
    }
}

#[test]
fn pressing_feels_what_the_map_says_and_a_common_factor_tells_nothing() {
    let scenario = scenario("task = \"locate\"\nvary_stiffness_percent = 30");
    let folder = tempfile::tempdir().expect("a folder");
    let sitting = Sitting::begin(folder.path(), &scenario, &begun(5)).expect("begun");
    let blind = sitting.run().blind_scenario().clone();
    let hidden = sitting.run().hidden_scenario().clone();
    let places = places(&sitting.run().shown());
    assert_eq!(places.len(), 24);
    let mut n_ticks = 0;
    let mut pressing = Pressing::new(blind.clone()).expect("built");
    let pressed = pressing
        .feel(&hidden, &places, &mut |_, _| n_ticks += 1)
        .expect("felt");
    let read = Reading::new(blind)
        .feel(&hidden, &places, &mut |_, _| {})
        .expect("read");
    // The mesh carries the map from vertex to vertex: a peak between them is a little lower.
    for (pressed, read) in pressed.log_ratios.iter().zip(&read.log_ratios) {
        assert!(
            (pressed - read).abs() < 0.05,
            "{pressed} pressed, {read} read"
        );
    }
    let usual = middle(&read.log_ratios);
    let off = read
        .log_ratios
        .iter()
        .filter(|x| (*x - usual).abs() > 0.05)
        .count();
    assert!(
        usual.abs() > 0.01 && off <= 2,
        "a factor for all, and one that stands out"
    );
    assert!((pressed.seconds - f64::from(n_ticks) * 0.001).abs() < 1e-9 && n_ticks == 24 * 320);
}

#[test]
fn a_keen_observer_is_right_in_every_task_and_a_numb_one_guesses() {
    for task in ["locate", "compare", "same-different", "severity", "search"] {
        let text = format!("task = \"{task}\"\nchange = {{ compliance_percent = -30 }}");
        let run = |d_prime: f64| {
            let folder = tempfile::tempdir().expect("a folder");
            let observer = Observer {
                d_prime,
                felt: false,
                false_alarms: 0.002,
                ..Observer::default()
            };
            let trials = trained(&observer, folder.path(), &text, 40);
            trials.iter().filter(|t| t.right).count()
        };
        assert!(run(60.0) >= 39, "{task}: {}", run(60.0));
        assert!(run(0.0) <= 30, "{task}: {}", run(0.0));
    }
}

#[test]
fn shares_of_right_answers_are_those_foretold() {
    let text = "task = \"locate\"\nchange = { compliance_percent = -18 }\ntrials = 400";
    let folder = tempfile::tempdir().expect("a folder");
    let observer = Observer {
        lapse: 0.1,
        felt: false,
        ..Observer::default()
    };
    let trials = trained(&observer, folder.path(), text, 400);
    let exercise = scenario(text).exercise.expect("stated");
    let log_ratio = -libm::log(1.0 - 0.18);
    let share = observer.right_share(&exercise, log_ratio).expect("a share");
    let right = trials.iter().filter(|t| t.right).count() as f64;
    let error = (400.0 * share * (1.0 - share)).sqrt();
    assert!(
        (right - 400.0 * share).abs() < 3.5 * error,
        "{right} of 400, foretold {share}"
    );
    let threshold = observer.threshold(&exercise, 0.6430).expect("a threshold");
    let d_prime = ForcedChoice::new(24).d_prime(0.6430);
    assert!((observer.d_prime * threshold - d_prime).abs() < 1e-6);
}

#[test]
fn a_pressed_trial_tells_how_it_was_palpated() {
    let text = "task = \"compare\"\nasks = [\"confidence\"]";
    let folder = tempfile::tempdir().expect("a folder");
    let mut sitting = Sitting::begin(folder.path(), &scenario(text), &begun(2)).expect("begun");
    let mut hand = Pressing::new(sitting.run().blind_scenario().clone()).expect("built");
    let candidates = sitting.run().candidates_mm();
    sitting.set_ground(crate::training::Ground::of(hand.scene(), candidates));
    let (mut random, mut now_s) = (Random::new(1), 0.0);
    let observer = Observer::default();
    let record = observer
        .do_trial(&mut sitting, &mut hand, &mut random, &mut now_s)
        .expect("done");
    let facts = &record.palpation;
    assert_eq!((facts.presses, facts.n_visits), (2, 2), "{facts:?}");
    assert!(
        facts.peak_force_n > 1.0
            && facts.mean_force_n > 0.5
            && facts.mean_force_n < facts.peak_force_n
    );
    assert!(facts.coverage > 0.0 && facts.coverage < 0.01, "{facts:?}");
    assert!((record.search_s - 0.64).abs() < 1e-9 && record.confidence_percent.is_some());
}
