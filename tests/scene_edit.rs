//! Edits of the scene under the finger: the force does not jump, the new one is reached, the record tells it all and replays
//! bit for bit.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Choices, ForceModel, Friction, Shading, Stiffness, Touch, TouchScene};
use dorsum::device::Reading;
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::servo::{
    self, Command, Limits, MOST_SHARE, MOST_STEP_N, Retired, Rig, ServoConfig, TickInput,
    TickRecord, tick,
};
use dorsum::session::{
    DeviceInfo, Edit, Entry, Header, IfExists, MeshSource, Rebuild, RecorderThread, Session,
    SessionError, SessionWriter, Strictness, check_edited,
};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const DT_S: f64 = 1.0 / 1000.0;
/// Most that a recorded force may change from one tick to the next while the hand holds still, N.
const NO_JUMP_N: f64 = 0.05;
const SOON: Duration = Duration::from_secs(20);

/// A bowl of 20 × 20 squares of 5 mm, so shallow that all of it can be pressed.
fn surface() -> Arc<Surface> {
    let n = 20u32;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (5.0 * f64::from(i) - 50.0, 5.0 * f64::from(j) - 50.0);
            mesh.positions.push(Vec3::new(x, y, 1e-3 * (x * x + y * y)));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    Arc::new(Surface::new(mesh).unwrap().0)
}

fn scene(stiffness_n_per_mm: f64) -> TouchScene {
    let surface = surface();
    let search = Arc::new(Bvh::new(&surface));
    TouchScene::new(surface, search, Stiffness::Uniform(stiffness_n_per_mm))
}

const FRICTION: Friction = Friction {
    static_coefficient: 0.46,
    dynamic_coefficient: 0.44,
    skin_looseness: 1.0,
};

/// `scene` with another stiffness: uneven, around this value.
fn edited(scene: &TouchScene, stiffness_n_per_mm: f64) -> TouchScene {
    let uneven = |p: &Vec3| stiffness_n_per_mm * (1.0 + 0.1 * libm::sin(0.3 * p.x + 0.2 * p.y));
    let values = scene.surface.positions().iter().map(uneven).collect();
    TouchScene {
        stiffness: Stiffness::PerVertex(values),
        ..scene.clone()
    }
}

fn uniform(scene: &TouchScene, stiffness_n_per_mm: f64) -> TouchScene {
    TouchScene {
        stiffness: Stiffness::Uniform(stiffness_n_per_mm),
        ..scene.clone()
    }
}

fn rig(scene: &TouchScene) -> Rig {
    Rig::new(Box::new(scene.clone()), Default::default())
}

/// Inputs that hold each finger at its place.
fn at(places_mm: &[Vec3]) -> TickInput {
    let mut input = TickInput {
        n_fingers: places_mm.len(),
        force_enabled: true,
        ..TickInput::default()
    };
    for (reading, place) in input.readings.iter_mut().zip(places_mm) {
        *reading = Reading {
            position_mm: *place,
            connected: true,
            ..Reading::default()
        };
    }
    input
}

/// Comes down from 12 mm above the middle, 0.1 mm a tick, and holds `depth_mm` deep.
fn held(number: u64, depth_mm: f64) -> Vec3 {
    Vec3::new(0.4, 0.3, (12.0 - 0.1 * number as f64).max(-depth_mm))
}

/// The ticks of a rig, with an edit before some of them.
fn run(
    rig: &mut Rig,
    ticks: u64,
    input: impl Fn(u64) -> TickInput,
    mut edit: impl FnMut(u64, &Rig) -> Option<TouchScene>,
) -> Vec<TickRecord> {
    (0..ticks)
        .map(|i| {
            if let Some(scene) = edit(i, rig) {
                drop(rig.edit_scene(rig.edit + 1, Box::new(scene)));
            }
            tick(rig, &input(i), DT_S)
        })
        .collect()
}

fn once(at: u64, scene: TouchScene) -> impl FnMut(u64, &Rig) -> Option<TouchScene> {
    move |i, _| (i == at).then(|| scene.clone())
}

/// Largest change of the force sent to any finger between two ticks from `from` on, N.
fn largest_step_n(run: &[TickRecord], from: usize) -> f64 {
    let step = |w: &[TickRecord]| {
        let fingers = w[0].fingers().iter().zip(w[1].fingers());
        fingers
            .map(|(a, b)| a.sent_force_n.distance(b.sent_force_n))
            .fold(0.0, f64::max)
    };
    run[from..].windows(2).map(step).fold(0.0, f64::max)
}

#[test]
fn an_edit_under_a_held_finger_makes_no_jump_and_is_reached() {
    let before = scene(0.35);
    let mut rig = rig(&before);
    let hold = |i| at(&[held(i, 4.0)]);
    let run = run(&mut rig, 700, hold, once(300, uniform(&before, 1.5)));
    let force_n = |i: usize| run[i].fingers[0].sent_force_n.length();
    assert!((force_n(299) - 0.35 * 4.0).abs() < 0.05, "{}", force_n(299));
    assert!((force_n(699) / force_n(299) - 1.5 / 0.35).abs() < 1e-9);
    let step_n = largest_step_n(&run, 250);
    assert!(step_n <= NO_JUMP_N, "{step_n} N");
    assert!(
        step_n >= 0.9 * MOST_STEP_N,
        "slower than need be: {step_n} N"
    );
    // The first tick that may feel it does.
    let felt = &run[300].fingers[0];
    assert!(felt.edit == 1 && felt.fade > 0.0 && felt.fade < 1.0);
    assert!(force_n(300) > force_n(299));
    let whole = run
        .iter()
        .position(|t| t.fingers[0].edit == 1 && t.fingers[0].fade == 1.0);
    let needed = ((force_n(699) - force_n(299)) / MOST_STEP_N).ceil() as usize;
    assert!(whole.unwrap() <= 300 + needed, "{whole:?}, {needed}");
    // And back again.
    let down = run_back(&mut rig, uniform(&before, 0.35));
    assert!(largest_step_n(&down, 0) <= NO_JUMP_N);
    assert!((down[399].fingers[0].sent_force_n.length() - force_n(299)).abs() < 1e-9);
}

fn run_back(rig: &mut Rig, scene: TouchScene) -> Vec<TickRecord> {
    run(rig, 400, |_| at(&[held(1000, 4.0)]), once(0, scene))
}

#[test]
fn a_small_edit_takes_its_least_time_and_a_free_finger_does_not_delay_it() {
    let least = (1.0 / MOST_SHARE) as u64;
    for (depth_mm, stiffness) in [(4.0, 0.36), (-5.0, 1.5)] {
        let before = scene(0.35);
        let mut rig = rig(&before);
        let hold = |i| at(&[held(i, depth_mm)]);
        run(
            &mut rig,
            200 + least - 1,
            hold,
            once(200, uniform(&before, stiffness)),
        );
        assert!(rig.is_fading());
        tick(&mut rig, &hold(1000), DT_S);
        assert!(!rig.is_fading() && rig.scene.share() == 1.0);
    }
}

#[test]
fn the_finger_that_feels_most_sets_the_pace_for_two() {
    let before = scene(0.35);
    let two = |i: u64| at(&[held(i, 4.0), held(i, 1.0) + Vec3::X * 30.0]);
    let mut rig = rig(&before);
    let run = run(&mut rig, 900, two, once(300, edited(&before, 1.5)));
    assert!(
        run[800]
            .fingers()
            .iter()
            .all(|f| f.contact.touch != Touch::Free)
    );
    assert!(
        run[300..]
            .iter()
            .all(|t| t.fingers[0].fade == t.fingers[1].fade)
    );
    assert!(largest_step_n(&run, 250) <= NO_JUMP_N);

    let k = |f: usize| run[899].fingers[f].contact.stiffness_n_per_mm;
    assert_ne!(k(0), k(1));
    assert_eq!(run[899].fingers[0].fade, 1.0);
}

/// A pad, every force model, shading, friction: no jump with any of them.
#[test]
fn whatever_the_finger_and_the_force_are_like_nothing_jumps() {
    let mut scenes = vec![];
    for force in ForceModel::all() {
        for (radius, shaded) in [(0.0, false), (5.0, false), (0.0, true)] {
            for friction in [None, Some(FRICTION)] {
                let plain = scene(0.35);
                let shading = shaded.then(|| Shading::of(&plain.surface));
                scenes.push(TouchScene {
                    choices: Choices {
                        force: *force,
                        finger_radius_mm: radius,
                        shaded,
                        ..Choices::default()
                    },
                    friction,
                    shading,
                    ..plain
                });
            }
        }
    }
    for before in scenes {
        let radius = before.choices.pad_mm().unwrap_or(0.0);
        let hold = |i: u64| at(&[held(i, 4.0 - radius)]);
        for after in [1.5, 0.1] {
            let mut rig = rig(&before);
            let run = run(&mut rig, 1500, hold, once(300, edited(&before, after)));
            let step_n = largest_step_n(&run, 250);
            assert!(step_n <= NO_JUMP_N, "{step_n} N with {:?}", before.choices);
            let last = &run[1499].fingers[0];
            assert!(last.fade == 1.0 && last.sent_force_n.length() > 0.0);
            // Reached: what a finger feels that pressed into the edited scene from the start.
            let mut fresh = self::rig(&edited(&before, after));
            let anew = self::run(&mut fresh, 1500, hold, |_, _| None);
            let (a, b) = (last.sent_force_n, anew[1499].fingers[0].sent_force_n);
            assert!(a.distance(b) < 1e-9, "{a} {b} with {:?}", before.choices);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// However a finger moves: it is where it would be without the edit, and the force is the mixture of both scenes'. Of the
    /// change from tick to tick the edit's part is the share that came in times the distance of the two forces.
    #[test]
    fn the_part_of_an_edit_in_a_sliding_force_is_bounded(
        from in 0.05..3.0_f64, to in 0.05..3.0_f64, depth_mm in 0.5..6.0_f64, speed in 1.0..12.0_f64, pull in 0.0..1.0_f64,
    ) {
        let friction = Friction { skin_looseness: 0.7 + 0.6 * pull, ..FRICTION };
        let before = TouchScene { friction: Some(friction), ..scene(from) };
        let after = edited(&before, to);
        let slide = |i: u64| {
            let t = i as f64 * DT_S * speed;
            let place = Vec3::new(25.0 * libm::sin(t), 20.0 * libm::cos(0.7 * t) - 10.0, 0.0);
            let skin = 1e-3 * (place.x * place.x + place.y * place.y);
            at(&[place + Vec3::Z * (skin - depth_mm * (0.2 * i as f64).min(1.0))])
        };
        let only = |scene: &TouchScene| run(&mut rig(scene), 900, slide, |_, _| None);
        let (old, new) = (only(&before), only(&after));
        let mixed = run(&mut rig(&before), 900, slide, once(100, after));
        let mut last = 0.0;
        for i in 100..900 {
            let (a, b, c) = (&old[i].fingers[0], &new[i].fingers[0], &mixed[i].fingers[0]);
            prop_assert_eq!(a.contact.anchor_mm, c.contact.anchor_mm);
            let wanted = a.contact.force_n * (1.0 - c.fade) + b.contact.force_n * c.fade;
            prop_assert!(wanted.distance(c.contact.force_n) < 1e-9);
            let part_n = (c.fade - last) * a.contact.force_n.distance(b.contact.force_n);
            prop_assert!(part_n <= MOST_STEP_N * (1.0 + 1e-6), "{} N at {}", part_n, i);
            last = c.fade;
        }
        prop_assert_eq!(last, 1.0);
    }
}

#[test]
fn an_absurd_stiffness_comes_and_goes_within_what_the_device_can_do() {
    let before = scene(0.35);
    let hold = |i| at(&[held(i, 4.0)]);
    let mut rig = rig(&before);
    let up = run(&mut rig, 1200, hold, once(300, uniform(&before, 9_000.0)));
    assert!(largest_step_n(&up, 250) <= NO_JUMP_N);
    assert_eq!(up[1199].fingers[0].fade, 1.0);
    let rated_n = Limits::default().rated_force_n;
    assert!((up[1199].fingers[0].sent_force_n.length() - rated_n).abs() < 1e-9);
    let down = run(
        &mut rig,
        1200,
        |_| at(&[held(1000, 4.0)]),
        once(0, uniform(&before, 0.35)),
    );
    assert!(largest_step_n(&down, 0) <= NO_JUMP_N);
    assert_eq!(down[1199].fingers[0].fade, 1.0);
}

/// The stiffness of edit `number` of the streams below.
fn streamed(number: u32) -> f64 {
    0.35 + 0.6 * f64::from(number % 5) + 0.01 * f64::from(number)
}

/// Edits at 30 Hz for three seconds under two fingers that move and let go, handed over as a bench does: the newest, once the
/// one before is wholly felt.
fn stream(before: &TouchScene) -> (Vec<TickRecord>, Vec<Edit>) {
    let mut texts = Vec::new();
    let mut rig = rig(before);
    let records = run(&mut rig, 3000, moving, |i, rig| {
        (i % 33 == 0 && i > 150 && !rig.is_fading()).then(|| {
            let number = rig.edit + 1;
            texts.push(Edit {
                number,
                tick: i,
                time_ns: i * 1_000_000,
                scenario_toml: streamed(number).to_string().into(),
            });
            edited(before, streamed(number))
        })
    });
    (records, texts)
}

fn moving(i: u64) -> TickInput {
    let t = i as f64 * DT_S;
    let mut input = at(&[
        Vec3::new(
            20.0 * libm::sin(2.0 * t),
            3.0,
            1.5 - 4.0 * libm::sin(3.0 * t),
        ),
        Vec3::new(-20.0, 15.0 * libm::cos(t), -2.0),
    ]);
    input.readings[1].connected = !(1200..1230).contains(&i);
    input.late = i == 777;
    input
}

#[test]
fn edits_at_30_hz_never_jump() {
    let before = scene(0.35);
    let hold = |i: u64| at(&[held(i, 4.0), held(i, 2.0) + Vec3::new(12.0, 9.0, 0.5)]);
    let mut rig = rig(&before);
    let records = run(&mut rig, 4000, hold, |i, rig| {
        let due = i % 33 == 0 && i > 300 && !rig.is_fading();
        due.then(|| edited(&before, streamed(rig.edit + 1)))
    });
    assert!(rig.edit > 20, "{} edits were felt", rig.edit);
    assert!(largest_step_n(&records, 290) <= NO_JUMP_N);
}

fn header(scene: &TouchScene, fingers: usize) -> Header {
    Header {
        scenario_toml: "0.35".into(),
        scenario_name: "Bowl".into(),
        mesh: MeshSource::new(&scene.surface, "bowl"),
        devices: vec![DeviceInfo::new("Scripted", &Limits::default()); fingers],
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: "2031-05-17T09:30:00Z".into(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}

/// As the recorder writes: every edit before the first tick that feels it.
fn write(path: &Path, header: &Header, records: &[TickRecord], edits: &[Edit]) {
    let mut writer = SessionWriter::create(path, header, IfExists::Refuse).unwrap();
    let mut told = header.edit;
    for record in records {
        let newest = record.fingers[0].edit;
        for edit in edits {
            if edit.number > told && edit.number <= newest {
                writer.edit(edit.number, &edit.scenario_toml).unwrap();
                told = edit.number;
            }
        }
        for finger in record.fingers() {
            writer.write(finger).unwrap();
        }
    }
    let summary = writer.finish().unwrap();
    assert_eq!(summary.edits, u64::from(told - header.edit));
}

fn file() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("edited.mcap");
    (folder, path)
}

/// Makes the scene of an edit from its "scenario": a number.
fn rebuild(before: &TouchScene) -> Rebuild<'_> {
    Box::new(|edit| {
        let k = edit.scenario_toml.parse::<f64>();
        Ok(edited(before, k.map_err(|e| e.to_string())?))
    })
}

#[test]
fn a_run_with_many_edits_replays_bit_for_bit() {
    let before = TouchScene {
        friction: Some(FRICTION),
        ..scene(0.35)
    };
    let (records, edits) = stream(&before);
    assert!(edits.len() > 15, "{}", edits.len());
    let (_folder, path) = file();
    write(&path, &header(&before, 2), &records, &edits);
    let session = Session::open(&path).unwrap();
    let report = check_edited(
        &session,
        rig(&before),
        rebuild(&before),
        Strictness::Strict,
        |_, _| (),
    );
    let report = report.unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert_eq!((report.ticks, report.compared), (3000, 2999));
    assert_eq!(report.passed.edits, edits.len() as u64);
    // A wrong text is found.
    let wrong: Rebuild<'_> = Box::new(|edit| Ok(edited(&before, 0.1 * f64::from(edit.number))));
    let report = check_edited(&session, rig(&before), wrong, Strictness::Strict, |_, _| ());
    assert!(!report.unwrap().is_bit_exact());
}

#[test]
fn a_replay_begins_in_the_middle_of_an_edit_and_goes_on_behind_a_gap_in_one() {
    let before = TouchScene {
        friction: Some(FRICTION),
        ..scene(0.35)
    };
    let (records, edits) = stream(&before);
    let fading = |t: &TickRecord| t.fingers[0].fade < 1.0 && t.fingers[0].edit > 2;
    let middles: Vec<usize> = (0..records.len())
        .filter(|&i| fading(&records[i]))
        .collect();
    for start in middles.iter().step_by(middles.len() / 12) {
        let (_folder, path) = file();
        let first = records[*start].fingers[0];
        // As a bench begins a recording: the header has the newest edit that is wholly felt.
        let settled = first.edit - 1;
        let header = Header {
            edit: settled,
            scenario_toml: streamed(settled).to_string(),
            ..header(&before, 2)
        };
        // With a gap some way on.
        let kept = |t: &&TickRecord| !(300..395).contains(&(t.fingers[0].tick as usize - start));
        let records: Vec<TickRecord> = records[*start..].iter().filter(kept).copied().collect();
        write(&path, &header, &records, &edits);
        let session = Session::open(&path).unwrap();
        let rig = rig(&edited(&before, streamed(settled)));
        let report = check_edited(
            &session,
            rig,
            rebuild(&before),
            Strictness::Strict,
            |_, _| (),
        );
        let report = report.unwrap();
        assert!(
            report.is_bit_exact(),
            "from {start}: {:?}",
            report.first_difference
        );
        assert_eq!(report.passed.gaps, u64::from(records.len() > 300));
        assert_eq!(report.passed.unrepeated, 0);
    }
}

#[test]
fn an_edit_whose_text_is_missing_is_told_and_the_rest_is_replayed() {
    let before = scene(0.35);
    let (records, mut edits) = stream(&before);
    let lost = edits.remove(4).number;
    let (_folder, path) = file();
    // A file as no recorder writes it: one text is not there.
    let mut writer = SessionWriter::create(&path, &header(&before, 2), IfExists::Refuse).unwrap();
    for edit in &edits {
        writer.edit(edit.number, &edit.scenario_toml).unwrap();
    }
    for finger in records.iter().flat_map(TickRecord::fingers) {
        writer.write(finger).unwrap();
    }
    writer.finish().unwrap();
    let session = Session::open(&path).unwrap();
    let check = |strictness| {
        check_edited(
            &session,
            rig(&before),
            rebuild(&before),
            strictness,
            |_, _| (),
        )
    };
    let error = check(Strictness::Strict).unwrap_err();
    assert!(
        matches!(error, SessionError::Edit { edit, .. } if edit == lost),
        "{error}"
    );
    assert!(!error.to_string().contains('\n'));
    let report = check(Strictness::Lenient).unwrap();
    assert!(report.first_difference.is_none() && !report.is_bit_exact());
    // Those that feel it, and those of the next that still feel it.
    let needs = |t: &&TickRecord| {
        let f = &t.fingers[0];
        f.edit == lost || f.edit == lost + 1 && f.fade < 1.0
    };
    let n = records.iter().filter(needs).count() as u64;
    assert_eq!(report.passed.unrepeated, n);
    assert_eq!(
        report.compared,
        3000 - 1 - n - 1,
        "all others but the one that begins anew"
    );
    let told = &report.passed.first_unrepeated;
    assert!(
        told.contains(&format!("edit {lost}")) && told.contains("edited.mcap"),
        "{told}"
    );
}

#[test]
fn a_session_without_edits_says_so_and_reads_as_before() {
    let before = scene(0.35);
    let records = run(&mut rig(&before), 300, moving, |_, _| None);
    assert!(
        records
            .iter()
            .all(|t| t.fingers[0].edit == 0 && t.fingers[0].fade == 1.0)
    );
    let (_folder, path) = file();
    write(&path, &header(&before, 2), &records, &[]);
    let recording = Session::open(&path)
        .unwrap()
        .load(Strictness::Strict)
        .unwrap();
    assert!(recording.edits.is_empty());
    assert_eq!(recording.scenario_after(0), Some("0.35"));
    assert_eq!(recording.scenario_after(1), None);
}

/// A device that is where it was told to be.
struct Held(dorsum::device::null::Null, Vec3);

impl Held {
    fn over(place: Vec3) -> Box<dyn dorsum::device::Device> {
        Box::new(Self(dorsum::device::null::Null::new(Vec3::ZERO), place))
    }
}

impl dorsum::device::Device for Held {
    fn capabilities(&self) -> &dorsum::device::Capabilities {
        self.0.capabilities()
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        // From above into the skin, at 60 mm/s.
        self.1.z = (self.1.z - 0.06).max(-4.0);
        Reading {
            position_mm: self.1,
            connected: true,
            ..Reading::default()
        }
    }

    fn write(&mut self, _force_n: Vec3) {}

    fn close(&mut self) {}
}

#[test]
fn a_live_recording_holds_every_edit_before_it_is_felt_and_replays_bit_for_bit() {
    let before = scene(0.35);
    let device = || Held::over(Vec3::new(0.4, 0.3, 5.0));
    let (servo, mut lines) =
        servo::start(ServoConfig::default(), rig(&before), vec![device()]).unwrap();
    let recorder = RecorderThread::spawn(lines.records, None).unwrap();
    let wait = |what: &str, mut holds: Box<dyn FnMut() -> bool + '_>| {
        let until = Instant::now() + SOON;
        while !holds() {
            assert!(Instant::now() < until, "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    let (_folder, path) = file();
    for number in 1..=8 {
        // Begins in the middle of the fourth.
        if number == 5 {
            let header = Header {
                edit: 3,
                scenario_toml: streamed(3).to_string(),
                ..header(&before, 1)
            };
            recorder.start(&path, header).unwrap();
        }
        let snapshot = &mut lines.snapshot;
        wait(
            "the edit before",
            Box::new(|| snapshot.read().fade == 1.0 && snapshot.read().edit == number - 1),
        );
        assert!(recorder.edit(number, streamed(number).to_string().into()));
        let scene = Box::new(edited(&before, streamed(number)));
        assert!(
            lines
                .commands
                .push(Command::EditScene { number, scene })
                .is_ok()
        );
        // One that comes too early is handed back.
        if number == 6 {
            let scene = Box::new(edited(&before, 77.0));
            assert!(
                lines
                    .commands
                    .push(Command::EditScene { number: 99, scene })
                    .is_ok()
            );
        }
        if number == 4 {
            wait("the fourth", Box::new(|| snapshot.read().edit == 4));
        }
    }
    let snapshot = &mut lines.snapshot;
    wait(
        "the last edit",
        Box::new(|| snapshot.read().fade == 1.0 && snapshot.read().edit == 8),
    );
    drop(servo);
    let summary = recorder.stop().unwrap();
    assert_eq!((summary.edits, summary.lost), (5, 0));
    let mut back = Vec::new();
    while let Ok(Retired::Scene(scene)) = lines.retired.pop() {
        back.push(scene);
    }
    assert_eq!(back.len(), 9);

    let session = Session::open(&path).unwrap();
    let mut known = session.header().edit;
    for entry in session.entries(Strictness::Strict).unwrap() {
        match entry.unwrap() {
            Entry::Edit(edit) => known = edit.number,
            Entry::Tick(record) => assert!(record.edit <= known),
            Entry::Event(_) => {}
        }
    }
    let rig = rig(&edited(&before, streamed(3)));
    let report = check_edited(
        &session,
        rig,
        rebuild(&before),
        Strictness::Strict,
        |_, _| (),
    );
    let report = report.unwrap();
    assert!(report.is_bit_exact(), "{:?}", report.first_difference);
    assert!(report.passed.edits >= 4, "{report:?}");
    let recording = session.load(Strictness::Strict).unwrap();
    let steps = recording.fingers[0]
        .windows(2)
        .map(|w| w[0].contact.force_n.distance(w[1].contact.force_n));
    // Before the limits: a busy machine makes late ticks, in which nothing is sent.
    let step_n = steps.fold(0.0, f64::max);
    assert!(step_n <= NO_JUMP_N, "{step_n} N");
}
