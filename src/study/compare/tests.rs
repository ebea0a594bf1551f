//! Recordings that differ in a known way.

use super::*;
use crate::geom::Vec3;
use crate::session::Session;
use crate::study::tests::{header, pressed, told, written};
use crate::study::{Options, StudyError};
use std::path::Path;

/// Three presses of 2 s at rising places, from `start` on; before, between and after them off the skin.
fn motion(t: f64, start: f64, deeper: f64) -> Vec3 {
    let x = t - start;
    let wave = libm::sin(std::f64::consts::PI * x / 2.0);
    let z = if x > 0.0 && x < 10.5 && wave > 0.0 {
        -(4.0 + deeper) * wave
    } else {
        3.0
    };
    Vec3::new(10.0 * libm::floor((x / 4.0).clamp(0.0, 2.0)), 50.0, z)
}

fn recorded(name: &str, start: f64, deeper: f64) -> (tempfile::TempDir, std::path::PathBuf) {
    let at = |tick: u64| motion(tick as f64 / 1000.0, start, deeper);
    written(
        name,
        &header(1, "none"),
        (0..16_000).map(|t| pressed(t, 0, at(t))),
    )
}

fn compared(a: &Path, b: &Path, align: Align) -> Result<Comparison, StudyError> {
    let sessions = [a, b].map(|p| Session::open(p).expect("opened"));
    let told = [a, b].map(|p| told(p, &Options::default()));
    let options = CompareOptions {
        align,
        ..CompareOptions::default()
    };
    compare(
        [&sessions[0], &sessions[1]],
        [&told[0], &told[1]],
        &options,
        &mut |_| true,
    )
}

#[test]
fn a_repetition_is_the_same_tick_by_tick() {
    let (_a, a) = recorded("a.mcap", 1.0, 0.0);
    let (_b, b) = recorded("b.mcap", 1.0, 0.0);
    for align in [Align::Time, Align::Event(Anchor::FirstContact)] {
        let same = compared(&a, &b, align).expect("compared");
        assert_eq!(
            (same.pairs, same.identical, same.shift_s),
            (16_000, Some(16_000), 0.0)
        );
        assert_eq!(
            [same.position_mm.rms, same.force_n.max, same.depth_mm.mean],
            [0.0; 3]
        );
        assert!(
            same.series.time_s.len() <= 2000 && same.series.force_max_n.iter().all(|f| *f == 0.0)
        );
        assert_eq!(same.force_agreement.expect("agreement").rmse, 0.0);
    }
}

#[test]
fn a_later_and_firmer_run_differs_by_what_it_was_made_to() {
    let (_a, a) = recorded("a.mcap", 1.0, 0.0);
    let (_b, b) = recorded("b.mcap", 2.5, 2.0);
    let event = compared(&a, &b, Align::Event(Anchor::Press(2))).expect("compared");
    assert!((event.shift_s - 1.5).abs() < 0.03, "{}", event.shift_s);
    let contact = compared(&a, &b, Align::Event(Anchor::FirstContact)).expect("compared");
    assert!((contact.shift_s - 1.5).abs() < 1e-9);
    // Depths 4 and 6 mm, forces half of them: apart by 2 and 1 at the peaks.
    assert!((contact.depth_mm.max - 2.0).abs() < 1e-4 && (contact.force_n.max - 1.0).abs() < 1e-4);
    let at = contact.force_n.max_at_s - 1.0;
    assert!(((at - 1.0).rem_euclid(4.0)).abs() < 0.01, "{at}");
    assert!(
        (contact.overlap_s - 14.499).abs() < 1e-9,
        "{}",
        contact.overlap_s
    );
    assert_eq!(contact.first_time_s(4.0), 2.5);
    assert!(contact.identical.is_some_and(|n| n < contact.pairs));
    // Unaligned they are further apart; warped they are not.
    let time = compared(&a, &b, Align::Time).expect("compared");
    let warped = compared(&a, &b, Align::Dtw).expect("compared");
    assert!(
        time.force_n.rms > 1.3 * contact.force_n.rms,
        "{} {}",
        time.force_n.rms,
        contact.force_n.rms
    );
    assert!(
        warped.force_n.rms < 1.2 * contact.force_n.rms,
        "{} {}",
        warped.force_n.rms,
        contact.force_n.rms
    );
    assert!(
        (warped.first_time_s(6.5 + 1.0) - 6.0).abs() < 0.15,
        "{}",
        warped.first_time_s(7.5)
    );
    assert!(warped.identical.is_none() && warped.warp_cost.is_some());
}

#[test]
fn what_cannot_be_aligned_is_told() {
    let (_a, a) = recorded("a.mcap", 1.0, 0.0);
    let (_b, b) = recorded("b.mcap", 100.0, 0.0);
    for align in [
        Align::Event(Anchor::FirstContact),
        Align::Event(Anchor::Event {
            kind: "mark".into(),
            nth: 1,
        }),
    ] {
        let error = compared(&a, &b, align)
            .expect_err("nothing to align by")
            .to_string();
        assert!(error.contains("to align by"), "{error}");
    }
    assert_eq!(
        Anchor::parse("mark:2"),
        Ok(Anchor::Event {
            kind: "mark".into(),
            nth: 2
        })
    );
    assert_eq!(Anchor::parse("contact"), Ok(Anchor::FirstContact));
    assert_eq!(Anchor::parse("press:3"), Ok(Anchor::Press(3)));
    for text in ["", ":2", "mark:0", "press:x"] {
        assert!(Anchor::parse(text).is_err(), "{text}");
    }
}

#[test]
fn a_trace_is_the_mean_of_its_ticks_and_is_held_over_gaps() {
    let at = |tick: u64| Vec3::new(tick as f64, 0.0, -2.0);
    let ticks = (0..1000_u64).filter(|t| !(200..400).contains(t));
    let (_folder, path) = written(
        "t.mcap",
        &header(1, "none"),
        ticks.map(|t| pressed(t, 0, at(t))),
    );
    let session = Session::open(&path).expect("opened");
    let all = traces(&session, 800, &mut |_| true).expect("traces");
    let trace = &all[0];
    assert_eq!((trace.len(), trace.rate_hz), (50, 50.0));
    assert_eq!(trace.position_mm[3][0], 69.5);
    assert_eq!(trace.position_mm[15][0], trace.position_mm[9][0]);
    assert_eq!((trace.force_n[7], trace.depth_mm[7]), (1.0, 2.0));
    assert_eq!((trace.at(0.5), trace.at(1e9), trace.at(-1.0)), (25, 49, 0));
    assert_eq!(trace.thinned(10).len(), 10);
}
