//! What sessions of known motion tell.

use super::*;
use crate::contact::{Contact, Touch};
use crate::device::Reading;
use crate::geom::Vec3;
use crate::servo::FingerRecord;
use crate::session::{DeviceInfo, Header, IfExists, MeshSource, Session, SessionWriter};
use std::path::{Path, PathBuf};

const K: f64 = 0.5;

pub(crate) fn header(fingers: usize, scenario_toml: &str) -> Header {
    Header {
        scenario_toml: scenario_toml.to_owned(),
        scenario_name: "made".into(),
        mesh: MeshSource {
            hash: "ab".repeat(32),
            origin: "builtin:back".into(),
            triangles: 2962,
        },
        devices: vec![DeviceInfo::new("Scripted", &crate::servo::Limits::default()); fingers],
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: "2031-05-17T09:30:00Z".into(),
        participant: Some("P07".into()),
        edit: 0,
        sealed: false,
    }
}

/// A finger on a level skin at height 0 that answers with 0.5 N/mm.
pub(crate) fn pressed(tick: u64, finger: u8, hip_mm: Vec3) -> FingerRecord {
    let depth_mm = -hip_mm.z;
    let contact = if depth_mm > 0.0 {
        Contact {
            touch: Touch::Frictionless,
            foot_mm: hip_mm.with_z(0.0),
            anchor_mm: hip_mm.with_z(0.0),
            normal: Vec3::Z,
            depth_mm,
            felt_depth_mm: depth_mm,
            stiffness_n_per_mm: K,
            force_n: Vec3::Z * (K * depth_mm),
            ..Contact::default()
        }
    } else {
        Contact::default()
    };
    FingerRecord {
        tick: tick + 5,
        finger,
        time_ns: tick * 1_000_000,
        reading: Reading {
            position_mm: hip_mm,
            connected: true,
            ..Reading::default()
        },
        contact,
        ..FingerRecord::default()
    }
}

pub(crate) fn written(
    name: &str,
    header: &Header,
    records: impl Iterator<Item = FingerRecord>,
) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    let mut writer = SessionWriter::create(&path, header, IfExists::Refuse).expect("created");
    for record in records {
        writer.write(&record).expect("written");
    }
    writer.finish().expect("finished");
    (folder, path)
}

pub(crate) fn told(path: &Path, options: &Options) -> Analysis {
    let session = Session::open(path).expect("opened");
    analyse(&session, options, &mut |_| true).expect("analysed")
}

/// Five presses of a second each, 8 mm deep, at (27, 100), a second apart.
fn presses(tick: u64) -> Vec3 {
    let t = tick as f64 / 1000.0;
    let up = libm::sin(std::f64::consts::PI * t);
    Vec3::new(
        27.0,
        100.0,
        if (t as u64).is_multiple_of(2) {
            -8.0 * up
        } else {
            5.0
        },
    )
}

#[test]
fn presses_are_counted_and_have_the_measures_of_their_formula() {
    let header = header(1, "no scenario");
    let (_folder, path) = written(
        "p.mcap",
        &header,
        (0..10_000).map(|t| pressed(t, 0, presses(t))),
    );
    let place = NamedPlace {
        name: "here".into(),
        at_mm: [27.0, 100.0],
    };
    let options = Options {
        sites: vec![place],
        ..Options::default()
    };
    let analysis = told(&path, &options);
    let m = &analysis.whole;
    assert_eq!((m.presses, m.strokes, m.lost_ticks), (5, 0, 0));
    assert_eq!(
        (analysis.about.ticks, analysis.about.seconds),
        (10_000, 10.0)
    );
    let near = |a: f64, b: f64, by: f64| assert!((a - b).abs() <= by, "{a} {b}");
    near(m.contact_s, 5.0, 0.006);
    near(m.peak_force_n, 4.0, 1e-4);
    near(m.peak_depth_mm, 8.0, 1e-4);
    // The mean of a half wave is 2 ⁄ π of its peak.
    near(
        m.mean_force_n.expect("mean"),
        4.0 * 2.0 / std::f64::consts::PI,
        0.003,
    );
    near(m.impulse_n_s, 5.0 * 4.0 * 2.0 / std::f64::consts::PI, 0.001);
    // Below 0.5 N while the sine is below 1 ⁄ 8, and so on; each of ten crossings is told to a tick.
    let below = |n: f64| 5.0 * 2.0 * libm::asin(n / 4.0) / std::f64::consts::PI;
    near(m.band_s[0], below(0.5), 0.011);
    near(m.band_s[1], below(2.0) - below(0.5), 0.011);
    near(m.band_s[2], 5.0 - below(2.0), 0.011);
    assert_eq!((m.band_s.len(), m.band_s[4]), (5, 0.0));
    assert_eq!((m.coverage_percent, m.tender_presses), (None, None));
    assert_eq!((m.coverage_mm2, m.path_skin_mm), (25.0, 0.0));
    let press = &analysis.fingers[0].presses[2];
    near(press.peak_s, 4.5, 1e-9);
    near(press.slope_n_per_mm.expect("slope"), K, 1e-12);
    // From a tenth of a newton until it is below two fifths of the peak again.
    let ends = [0.1 / 4.0, 0.4].map(|share| libm::asin(share) / std::f64::consts::PI);
    near(press.seconds(), 1.0 - ends[0] - ends[1], 0.003);
    let felt = &analysis.felt[0];
    assert_eq!((felt.presses, felt.site.as_str()), (5, "here"));
    near(felt.slope_n_per_mm, K, 1e-12);
    near(felt.r_squared.expect("R²"), 1.0, 1e-12);
    let [low, high] = felt.interval_n_per_mm.expect("interval");
    near(low, K, 1e-9);
    near(high, K, 1e-9);
    let dwell = &analysis.dwell;
    assert_eq!(
        (dwell.columns, dwell.rows, dwell.origin_mm),
        (1, 1, [25.0, 100.0])
    );
    near(dwell.total_s(), m.contact_s, 1e-6);
    // Serialised and back it is the same.
    let text = serde_json::to_string(&analysis).expect("JSON");
    assert_eq!(
        serde_json::from_str::<Analysis>(&text).expect("read"),
        analysis
    );
}

/// Three seconds of a light glide at 60 mm/s, two of pressing in place, two off the skin, three of a firm glide.
fn errand(tick: u64) -> Vec3 {
    let t = tick as f64 / 1000.0;
    match t {
        ..3.0 => Vec3::new(60.0 * t, 0.0, -2.0),
        3.0..5.0 => Vec3::new(
            180.0,
            0.0,
            -2.0 - 6.0 * libm::sin(std::f64::consts::PI * (t - 3.0) / 2.0),
        ),
        5.0..7.0 => Vec3::new(180.0, 0.0, 4.0),
        _ => Vec3::new(180.0 - 60.0 * (t - 7.0), 0.0, -6.0),
    }
}

#[test]
fn search_and_palpation_are_told_apart() {
    let header = header(2, "no scenario");
    let both = (0..10_000).flat_map(|t| [pressed(t, 0, errand(t)), pressed(t, 1, errand(0))]);
    let (_folder, path) = written("e.mcap", &header, both);
    let analysis = told(&path, &Options::default());
    let first = &analysis.fingers[0];
    let kinds: Vec<_> = first.phases.iter().map(|p| p.kind).collect();
    use PhaseKind::{Away, Palpation, Search};
    assert_eq!(kinds, [Search, Palpation, Away, Palpation]);
    for (phase, end_s) in first.phases.iter().zip([3.0, 5.0, 7.0, 10.0]) {
        // Speed is told from 50 ms to either side.
        assert!((phase.end_s - end_s).abs() < 0.06, "{phase:?}");
    }
    assert_eq!(first.phases[3].end_s, 10.0);
    assert!((first.search.path_skin_mm - 180.0).abs() < 4.0);
    assert!((first.search.mean_force_n.expect("force") - 1.0).abs() < 0.02);
    assert!((first.palpation.path_skin_mm - 180.0).abs() < 4.0);
    assert_eq!(
        (first.whole.presses, first.whole.strokes),
        (1, 2),
        "{:?}",
        first.presses
    );
    assert!((first.search.contact_speed_mm_s.expect("speed") - 60.0).abs() < 0.5);
    assert!((first.whole.duration_s - 10.0).abs() < 1e-9);
    let sum = first.search.duration_s + first.palpation.duration_s;
    assert!((first.whole.duration_s - sum - 2.0).abs() < 0.02);
    // The other finger rests on one place.
    let rest = &analysis.fingers[1];
    assert_eq!(rest.phases.len(), 1);
    assert_eq!(
        (rest.phases[0].kind, rest.search.duration_s),
        (Palpation, 0.0)
    );
    assert_eq!(
        analysis.whole.contact_s,
        first.whole.contact_s + rest.whole.contact_s
    );
    // Places that both touched count once for both.
    assert!(analysis.whole.coverage_mm2 < first.whole.coverage_mm2 + rest.whole.coverage_mm2);
}

#[test]
fn a_gap_is_lost_time_and_no_way() {
    let header = header(1, "no scenario");
    let path_mm = |t: u64| Vec3::new(0.05 * t as f64, 0.0, -2.0);
    let held = (0..4000)
        .filter(|t| !(1500..2500).contains(t))
        .map(|t| pressed(t, 0, path_mm(t)));
    let (_folder, path) = written("g.mcap", &header, held);
    let analysis = told(&path, &Options::default());
    let m = &analysis.whole;
    assert_eq!(
        (m.lost_ticks, analysis.about.lost, analysis.about.ticks),
        (1000, 1000, 3000)
    );
    assert!((m.path_skin_mm - 0.05 * 2998.0).abs() < 1e-9);
    assert_eq!(analysis.fingers[0].phases.len(), 2);
    assert_eq!(m.strokes, 2);
}

#[test]
fn tenderness_and_coverage_come_from_the_scenario_in_the_file() {
    let scenario = "format = 1\nname = \"t\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\nkey = [{ x = 0, y = 0, \
                    stiffness_n_per_mm = 0.5 }]\n[[dysfunction]]\nkind = \"tender\"\nat_mm = [27.0, 100.0]\n\
                    radius_mm = [10, 10]\ntender_above_n = 3.0\n";
    let (_folder, path) = written(
        "t.mcap",
        &header(1, scenario),
        (0..10_000).map(|t| pressed(t, 0, presses(t))),
    );
    let m = told(&path, &Options::default()).whole;
    assert_eq!(m.tender_presses, Some(5));
    let beyond_s = 5.0 * (1.0 - 2.0 * libm::asin(0.75) / std::f64::consts::PI);
    assert!((m.tender_s.expect("time") - beyond_s).abs() < 0.006);
    let percent = m.coverage_percent.expect("coverage");
    // One cell of a back of about 0.15 m².
    assert!(percent > 0.01 && percent < 0.04, "{percent}");
}

#[test]
fn a_sealed_session_and_wrong_options_are_refused() {
    let sealed = Header {
        sealed: true,
        ..header(1, "hidden")
    };
    let (_folder, path) = written(
        "s.mcap",
        &sealed,
        (0..100).map(|t| pressed(t, 0, presses(t))),
    );
    let session = Session::open(&path).expect("opened");
    let refused = analyse(&session, &Options::default(), &mut |_| true);
    assert!(matches!(refused, Err(StudyError::Sealed { .. })));
    assert!(About::of(&session).sealed);
    for options in [
        Options {
            cell_mm: 0.0,
            ..Options::default()
        },
        Options {
            cell_mm: f64::NAN,
            ..Options::default()
        },
        Options {
            force_bands_n: vec![2.0, 1.0],
            ..Options::default()
        },
        Options {
            force_bands_n: vec![1.0; 9],
            ..Options::default()
        },
    ] {
        assert!(matches!(options.check(), Err(StudyError::Option { .. })));
    }
}
