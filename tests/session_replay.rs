//! Replays: the recorded inputs through the same tick give the same bits, and where they do not, the report says so.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Friction, Stiffness, Touch, TouchScene};
use dorsum::device::scripted::{Script, Scripted};
use dorsum::device::{Device, Reading};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::servo::{
    self, Command, FingerRecord, LimitFlags, Limits, Rig, ServoConfig, StiffnessBound, TickInput,
    TickRecord, tick,
};
use dorsum::session::{
    DeviceInfo, Header, IfExists, MeshSource, Playback, RecorderThread, Session, SessionError,
    SessionWriter, Strictness, check, resimulate,
};
use dorsum::surface::{RawMesh, Surface};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const DT_S: f64 = 1.0 / 1000.0;
const LIMITS: Limits = Limits {
    rated_force_n: 9.0,
    rise_n_per_s: 2000.0,
    passivity: false,
    stiffness: StiffnessBound::AsIs,
};
/// The second finger's passivity controller is on.
const PASSIVE: Limits = Limits {
    passivity: true,
    ..LIMITS
};

/// A sheet of 20 × 20 squares of 5 mm, tilted, with stiffness that rises along x.
fn scene(tilt: f64) -> TouchScene {
    let n = 20u32;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (5.0 * f64::from(i) - 50.0, 5.0 * f64::from(j) - 50.0);
            mesh.positions.push(Vec3::new(x, y, tilt * x));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let (surface, _) = Surface::new(mesh).unwrap();
    let stiffness = surface
        .positions()
        .iter()
        .map(|p| 0.5 + 0.004 * p.x)
        .collect();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene {
        friction: Some(Friction {
            static_coefficient: 0.46,
            dynamic_coefficient: 0.44,
            skin_looseness: 1.0,
        }),
        ..TouchScene::new(Arc::new(surface), search, Stiffness::PerVertex(stiffness))
    }
}

fn rig(tilt: f64) -> Rig {
    Rig::new(Box::new(scene(tilt)), header().limits())
}

/// Two fingers press, slide and let go; the run is late now and then, once without force, a device drops out, another is
/// swapped in.
fn input(number: u64) -> TickInput {
    let t = number as f64 * DT_S;
    let mut input = TickInput {
        n_fingers: 2,
        late: number % 97 == 50,
        force_enabled: !(400..450).contains(&number),
        ..TickInput::default()
    };
    for (finger, reading) in input.readings.iter_mut().enumerate().take(2) {
        let phase = t * 3.0 + finger as f64;
        *reading = Reading {
            position_mm: Vec3::new(
                20.0 * libm::sin(phase),
                15.0 * libm::cos(phase * 0.7),
                6.0 * libm::cos(phase * 2.0),
            ),
            velocity_mm_s: Vec3::new(t, -t, 0.0),
            buttons: (number / 100) as u32,
            connected: !(finger == 1 && (600..620).contains(&number)),
        };
    }
    input.place_anew[0] = number == 500;
    if number == 700 {
        input.readings[0].position_mm.x = f64::NAN;
    }
    input
}

fn ticks(n: u64) -> Vec<TickRecord> {
    let mut rig = rig(0.2);
    (0..n).map(|i| tick(&mut rig, &input(i), DT_S)).collect()
}

fn header() -> Header {
    let scene = scene(0.2);
    Header {
        scenario_toml: "format = 1\n".into(),
        scenario_name: "Sheet".into(),
        mesh: MeshSource::new(&scene.surface, "sheet"),
        devices: [LIMITS, PASSIVE]
            .map(|l| DeviceInfo::new("Scripted", &l))
            .to_vec(),
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: "2031-05-17T09:30:00Z".into(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}

struct File {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

impl File {
    fn session(&self) -> Session {
        Session::open(&self.path).unwrap()
    }
}

fn recorded(records: impl IntoIterator<Item = TickRecord>) -> File {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    write(&path, records);
    File {
        _folder: folder,
        path,
    }
}

fn write(path: &Path, records: impl IntoIterator<Item = TickRecord>) {
    let mut writer = SessionWriter::create(path, &header(), IfExists::Refuse).unwrap();
    for record in records {
        for finger in record.fingers() {
            writer.write(finger).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_run_replays_bit_for_bit() {
    let run = ticks(1500);
    for touch in [Touch::Free, Touch::Stick, Touch::Slip] {
        let any = |t: &TickRecord| t.fingers().iter().any(|r| r.contact.touch == touch);
        assert!(run.iter().any(any), "the run has no {touch:?}");
    }
    let file = recorded(run);
    let report = check(&file.session(), rig(0.2), Strictness::Strict).unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert_eq!(
        (report.ticks, report.compared, report.fingers),
        (1500, 1499, 2)
    );
    assert_eq!((report.passed.gaps, report.passed.missing), (0, 0));
}

#[test]
fn the_passivity_controller_acts_where_it_is_on_and_its_balance_is_recorded() {
    let run = ticks(1500);
    let damped = |finger: usize| {
        let records = run.iter().map(|t| t.fingers[finger]);
        records
            .filter(|r| r.limits.has(LimitFlags::PASSIVITY))
            .count()
    };
    assert_eq!(damped(0), 0);
    assert!(damped(1) > 100, "{}", damped(1));
    assert!(
        run.iter()
            .all(|t| t.fingers[0].passivity_energy_n_mm == 0.0)
    );
    let owed = run
        .iter()
        .filter(|t| t.fingers[1].passivity_energy_n_mm < 0.0);
    assert!(owed.count() > 100);
    for t in &run {
        let sent = t.fingers[1].sent_force_n;
        assert!(sent.is_finite() && sent.length() <= LIMITS.rated_force_n * (1.0 + 1e-12));
    }
    let file = recorded(run);
    let limits = file.session().header().limits();
    assert_eq!(limits.map(|l| l.passivity), [false, true, false, false]);
    // Repeated without it the run is another.
    let mut without = rig(0.2);
    without.limits[1] = LIMITS;
    let report = check(&file.session(), without, Strictness::Strict).unwrap();
    assert_eq!(report.first_difference.unwrap().finger, 1);
}

/// The stiffness of the sheet rises along x, so that the clamp acts here and there; once more with the passivity controller.
#[test]
fn a_run_rendered_softer_than_it_is_replays_bit_for_bit_and_tells_when() {
    for base in [LIMITS, PASSIVE] {
        let limits = [
            StiffnessBound::scaled(2.0, 1.2),
            StiffnessBound::clamped(SOFT),
        ]
        .map(|stiffness| Limits { stiffness, ..base });
        let header = Header {
            devices: limits.map(|l| DeviceInfo::new("Scripted", &l)).to_vec(),
            ..header()
        };
        let softer = |header: &Header| Rig::new(Box::new(scene(0.2)), header.limits());
        let mut rig = softer(&header);
        let run: Vec<_> = (0..1500).map(|i| tick(&mut rig, &input(i), DT_S)).collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("soft.mcap");
        let mut writer = SessionWriter::create(&path, &header, IfExists::Refuse).unwrap();
        for finger in run.iter().flat_map(TickRecord::fingers) {
            writer.write(finger).unwrap();
        }
        writer.finish().unwrap();
        let session = Session::open(&path).unwrap();
        assert_eq!(session.header().limits(), header.limits());
        let report = check(&session, softer(session.header()), Strictness::Strict).unwrap();
        assert!(report.is_bit_exact(), "{:?}", report.first_difference);
        // As it is, it is another run.
        let stiff = Rig::new(Box::new(scene(0.2)), [base; 4]);
        let report = check(&session, stiff, Strictness::Strict).unwrap();
        assert!(!report.is_bit_exact());
        let seen = softened(&run);
        if !base.passivity {
            assert!(seen.iter().all(|n| *n > 50), "{seen:?}");
        }
    }
}

/// Clamp of the right finger, N/mm: within what it touches.
const SOFT: f64 = 0.423;

/// Holds a run to F = factor k d and F = min(k, k_max) d; in how many ticks of each finger nothing else acted.
fn softened(run: &[TickRecord]) -> [usize; 2] {
    let mut seen = [0; 2];
    for r in run.iter().flat_map(TickRecord::fingers) {
        let k = r.contact.stiffness_n_per_mm;
        let touching = r.contact.touch != Touch::Free;
        let softer = if r.finger == 0 {
            0.6
        } else {
            (SOFT / k).min(1.0)
        };
        let acts = touching && softer < 1.0;
        assert_eq!(r.limits.has(LimitFlags::STIFFNESS), acts, "tick {}", r.tick);
        if r.limits == LimitFlags::STIFFNESS {
            let expected = r.contact.force_n * softer;
            assert!((r.sent_force_n - expected).length() < 1e-12);
            seen[usize::from(r.finger)] += 1;
        }
    }
    seen
}

#[test]
fn a_recording_that_starts_in_the_middle_replays_from_there() {
    for start in [1, 333, 500, 605, 701, 1200] {
        let file = recorded(ticks(1400).split_off(start));
        let report = check(&file.session(), rig(0.2), Strictness::Strict).unwrap();
        assert!(
            report.is_bit_exact(),
            "from {start}: {:?}",
            report.first_difference
        );
    }
}

#[test]
fn a_gap_starts_anew_behind_it_and_is_counted() {
    let mut ticks = ticks(1200);
    ticks.retain(|t| !(300..340).contains(&t.fingers[0].tick) && t.fingers[0].tick != 900);
    let file = recorded(ticks);
    let report = check(&file.session(), rig(0.2), Strictness::Strict).unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert_eq!((report.passed.gaps, report.passed.missing), (2, 41));
    assert_eq!((report.ticks, report.compared), (1159, 1156));
}

#[test]
fn a_changed_reading_is_found_at_its_tick() {
    let mut changed = ticks(1000);
    let position = &mut changed[777].fingers[1].reading.position_mm;
    position.z = f64::from_bits(position.z.to_bits() ^ 1 << 30);
    let file = recorded(changed);
    let report = check(&file.session(), rig(0.2), Strictness::Strict).unwrap();
    let first = report.first_difference.unwrap();
    assert_eq!((first.tick, first.finger), (777, 1));
    assert_ne!(first.recorded, first.got);
    assert!(!report.differences.is_empty());
}

#[test]
fn one_changed_bit_of_an_outcome_is_found_with_its_field() {
    type Change = fn(&mut FingerRecord);
    let changes: [(&str, Change); 8] = [
        ("fade", |r| r.fade = next(r.fade)),
        ("anchor_mm.y", |r| {
            r.contact.anchor_mm.y = next(r.contact.anchor_mm.y)
        }),
        ("depth_mm", |r| {
            r.contact.depth_mm = next(r.contact.depth_mm)
        }),
        ("stiffness_n_per_mm", |r| {
            r.contact.stiffness_n_per_mm = next(r.contact.stiffness_n_per_mm);
        }),
        ("credit_mj", |r| {
            r.contact.credit_mj = next(r.contact.credit_mj);
        }),
        ("sent_force_n.z", |r| {
            r.sent_force_n.z = next(r.sent_force_n.z)
        }),
        ("limits", |r| r.limits.0 ^= 1),
        ("passivity_energy_n_mm", |r| {
            r.passivity_energy_n_mm = next(r.passivity_energy_n_mm);
        }),
    ];
    for (field, change) in changes {
        let mut changed = ticks(900);
        change(&mut changed[800].fingers[0]);
        let file = recorded(changed);
        let report = check(&file.session(), rig(0.2), Strictness::Strict).unwrap();
        let first = report.first_difference.unwrap();
        assert_eq!(
            (first.tick, first.finger, first.field.as_str()),
            (800, 0, field)
        );
        assert_eq!(report.differences.len(), 1);
        assert!(report.differences[0].max > 0.0 && report.differences[0].records == 1);
    }
}

#[test]
fn a_changed_stiffness_is_found_at_the_first_touch() {
    let run = ticks(900);
    let mut rig = rig(0.2);
    let Stiffness::PerVertex(values) = &rig.scene.stiffness else {
        panic!("the sheet has one value per vertex");
    };
    let changed = values
        .iter()
        .map(|k| f64::from_bits(k.to_bits() ^ (1 << 20)));
    rig.scene.stiffness = Stiffness::PerVertex(changed.collect());
    let report = check(&recorded(run.clone()).session(), rig, Strictness::Strict).unwrap();
    let first = report.first_difference.unwrap();
    // The first tick of a file is where a replay starts from; it is not repeated.
    let touching = |t: &&TickRecord| t.fingers().iter().any(|r| r.contact.touch != Touch::Free);
    let touch = run.iter().skip(1).find(touching).unwrap();
    assert_eq!(first.tick, touch.fingers[0].tick);
    assert_eq!(first.field, "stiffness_n_per_mm");
    let fields: Vec<_> = report.differences.iter().map(|d| d.field).collect();
    assert!(
        fields.contains(&"force_n") && fields.contains(&"sent_force_n"),
        "{fields:?}"
    );
}

fn next(v: f64) -> f64 {
    f64::from_bits(v.to_bits() ^ 1)
}

#[test]
fn another_surface_is_refused_in_one_line() {
    let file = recorded(ticks(10));
    let error = check(&file.session(), rig(0.3), Strictness::Strict).unwrap_err();
    assert!(matches!(error, SessionError::OtherSurface { .. }));
    let text = error.to_string();
    assert!(text.contains("scenario") && !text.contains('\n'), "{text}");
}

#[test]
fn an_unfinished_file_replays_as_far_as_it_goes() {
    let file = recorded(ticks(4000));
    let bytes = std::fs::read(&file.path).unwrap();
    std::fs::write(&file.path, &bytes[..bytes.len() * 2 / 3]).unwrap();
    assert!(check(&file.session(), rig(0.2), Strictness::Strict).is_err());
    let report = check(&file.session(), rig(0.2), Strictness::Lenient).unwrap();
    assert!(report.is_bit_exact() && report.damage.unfinished);
    assert!((1500..2667).contains(&report.ticks), "{}", report.ticks);
}

#[test]
fn re_simulation_shows_recorded_and_repeated_side_by_side() {
    let run = ticks(50);
    let file = recorded(run.clone());
    let pairs = resimulate(&file.session(), rig(0.2), Strictness::Strict).unwrap();
    let pairs: Vec<_> = pairs.map(Result::unwrap).collect();
    assert!(pairs[0].got.is_none());
    for (pair, tick) in pairs.iter().zip(&run) {
        assert!(pair.recorded.fingers()[1].same_outcome(&tick.fingers()[1]));
    }
}

#[test]
fn playback_shows_the_recorded_records() {
    let run = ticks(300);
    let file = recorded(run.clone());
    let recording = file.session().load(Strictness::Strict).unwrap();
    let mut playback = Playback::new(Arc::new(recording));
    playback.play();
    let mut seen = Vec::new();
    while playback.is_playing() {
        seen.push(playback.at());
        let _ = playback.advance(0.0004);
    }
    seen.dedup_by_key(|t| t.fingers[0].tick);
    for (shown, recorded) in seen.iter().zip(&run) {
        for (a, b) in shown.fingers().iter().zip(recorded.fingers()) {
            assert!(a.same_outcome(b));
        }
    }
    assert!(seen.len() >= 299);
}

fn otherwise(
    file: &File,
    rig: Rig,
    rate_hz: Option<f64>,
) -> (dorsum::session::Divergence, Vec<dorsum::session::Off>) {
    let how = dorsum::session::Otherwise {
        rate_hz,
        rebuild: None,
    };
    let mut offs = Vec::new();
    let found =
        dorsum::session::diverge(&file.session(), rig, how, Strictness::Strict, |off, _| {
            offs.push(*off);
            true
        });
    (found.unwrap(), offs)
}

#[test]
fn felt_the_same_it_is_off_by_nothing() {
    let mut ticks = ticks(1200);
    ticks.retain(|t| !(300..340).contains(&t.fingers[0].tick));
    let file = recorded(ticks);
    for rate_hz in [None, Some(1000.0)] {
        let (found, offs) = otherwise(&file, rig(0.2), rate_hz);
        assert_eq!((found.compared, found.gaps), (1158, 1));
        assert_eq!(offs.len(), 2 * 1158);
        assert!(
            offs.iter()
                .all(|o| o.proxy_mm == Vec3::ZERO && o.sent_force_n == Vec3::ZERO)
        );
        assert!(found.fingers.iter().all(|f| f.depth_mm.max == 0.0));
    }
}

#[test]
fn twice_the_stiffness_is_off_by_the_force_itself() {
    let run = ticks(900);
    let file = recorded(run.clone());
    let mut rig = rig(0.2);
    let Stiffness::PerVertex(values) = &rig.scene.stiffness else {
        panic!("the sheet has one value per vertex");
    };
    let twice = values.iter().map(|k| 2.0 * k).collect();
    rig.scene.stiffness = Stiffness::PerVertex(twice);
    rig.scene.friction = None;
    // Without friction on either side: the recorded one is computed again.
    let mut plain = self::rig(0.2);
    plain.scene.friction = None;
    let run: Vec<_> = run
        .iter()
        .map(|t| tick(&mut plain, &dorsum::session::input_of(t), DT_S))
        .collect();
    let plain = recorded(run.clone());
    let (found, offs) = otherwise(&plain, rig, None);
    let mut touched = 0;
    for off in offs.iter().filter(|o| o.finger == 0) {
        let was = &run[off.tick as usize].fingers[0];
        let apart = (off.force_n - was.contact.force_n).length();
        assert!(
            apart <= 1e-9 * was.contact.force_n.length(),
            "tick {}",
            off.tick
        );
        touched += usize::from(off.force_n != Vec3::ZERO);
    }
    assert!(touched > 50);
    let greatest = offs
        .iter()
        .filter(|o| o.finger == 0)
        .map(|o| o.force_n.length())
        .fold(0.0, f64::max);
    assert_eq!(found.fingers[0].force_n.max, greatest);
    drop(file);
}

#[test]
fn at_a_higher_rate_a_smooth_motion_is_felt_nearly_the_same_and_at_a_lower_one_held() {
    let smooth = |n: u64| {
        let mut rig = rig(0.2);
        rig.scene.friction = None;
        let mut run = Vec::new();
        for i in 0..n {
            let mut given = input(i);
            given.late = false;
            given.force_enabled = true;
            given.n_fingers = 1;
            given.place_anew = Default::default();
            given.readings[0].connected = true;
            let t = i as f64 * DT_S;
            given.readings[0].position_mm = Vec3::new(5.0, 5.0, 3.0 * libm::cos(4.0 * t));
            run.push(tick(&mut rig, &given, DT_S));
        }
        run
    };
    let mut run = smooth(2000);
    // The header names two fingers.
    for t in &mut run {
        t.n_fingers = 2;
        t.fingers[1] = FingerRecord {
            finger: 1,
            tick: t.fingers[0].tick,
            ..FingerRecord::default()
        };
    }
    let file = recorded(run);
    let without_friction = || {
        let mut rig = rig(0.2);
        rig.scene.friction = None;
        rig
    };
    let (fine, _) = otherwise(&file, without_friction(), Some(4000.0));
    assert_eq!((fine.compared, fine.computed), (1999, 4 * 1999));
    assert!(fine.fingers[0].proxy_mm.max < 1e-9, "{fine:?}");
    let (coarse, offs) = otherwise(&file, without_friction(), Some(100.0));
    assert_eq!((coarse.compared, coarse.computed), (1999, 199));
    // The newest tick is up to 9 ms old: so long the finger has moved on, at most 12 mm/s.
    let depth = coarse.fingers[0].depth_mm;
    assert!(
        depth.max > 0.01 && depth.max < 0.012 * 9.0 + 0.05,
        "{depth:?}"
    );
    let at_ticks = offs.iter().filter(|o| o.finger == 0 && o.tick % 10 == 0);
    assert!(at_ticks.clone().count() > 100);
    assert!(at_ticks.into_iter().all(|o| o.depth_mm.abs() < 1e-9));
    // A rate that is no multiple ends where it must.
    let (odd, _) = otherwise(&file, without_friction(), Some(333.0));
    assert!((665..=666).contains(&odd.computed), "{}", odd.computed);
}

fn scripted(x: f64) -> Box<dyn Device> {
    let script = Script::Tap.trajectory((x, 0.0), 4.0, |x, _| Some(0.2 * x));
    Box::new(Scripted::new(script))
}

#[test]
fn a_live_run_replays_bit_for_bit_through_a_stop_and_a_change_of_device() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("live.mcap");
    let devices = vec![scripted(-10.0), scripted(15.0)];
    let (servo, mut lines) = servo::start(ServoConfig::default(), rig(0.2), devices).unwrap();
    let recorder = RecorderThread::spawn(lines.records, None).unwrap();
    recorder.start(&path, header()).unwrap();
    let wait_for = |ticks: u64| {
        let until = Instant::now() + Duration::from_secs(20);
        while recorder.status().ticks < ticks {
            assert!(Instant::now() < until, "{:?}", recorder.status());
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    let orders = [
        Command::EnableForce(false),
        Command::SetDevice(1, scripted(5.0)),
        Command::EnableForce(true),
    ];
    for (order, ticks) in orders.into_iter().zip([300, 400, 500]) {
        wait_for(ticks);
        assert!(lines.commands.push(order).is_ok());
    }
    wait_for(900);
    drop(servo);
    let summary = recorder.stop().unwrap();
    assert_eq!(summary.lost, 0);
    let session = Session::open(&path).unwrap();
    let report = check(&session, rig(0.2), Strictness::Strict).unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert_eq!((report.ticks, report.passed.gaps), (summary.ticks, 0));
    let recording = session.load(Strictness::Strict).unwrap();
    let second = &recording.fingers[1];
    assert_eq!(second.iter().filter(|r| r.placed_anew).count(), 1);
    assert!(second.iter().any(|r| !r.force_enabled));
}
