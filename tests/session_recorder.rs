//! The recorder beside a running servo: everything is written, what cannot be is told, and a kill costs a second at most.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::servo::FingerRecord;
use dorsum::session::writer::Store;
use dorsum::session::{
    DeviceInfo, Header, MeshSource, RecorderHandle, RecorderState, RecorderThread, Session,
    SessionError, SessionWriter, Strictness, utc_now,
};
use rtrb::{Producer, RingBuffer};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

fn header(n_fingers: usize) -> Header {
    let device = DeviceInfo {
        name: "Scripted".into(),
        rated_force_n: 22.0,
        rise_n_per_s: 4400.0,
        passivity: false,
        stiffness: Default::default(),
    };
    Header {
        scenario_toml: "format = 1\n".into(),
        scenario_name: "Test".into(),
        mesh: MeshSource {
            hash: "00".into(),
            origin: "builtin:back".into(),
            triangles: 2962,
        },
        devices: vec![device; n_fingers],
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}

fn record(tick: u64, finger: u8) -> FingerRecord {
    FingerRecord {
        tick,
        finger,
        time_ns: tick * 1_000_000,
        ..FingerRecord::default()
    }
}

/// Pushes whole ticks of two fingers, waiting for room.
fn push(ring: &mut Producer<FingerRecord>, ticks: std::ops::Range<u64>) {
    for tick in ticks {
        for finger in 0..2 {
            while ring.push(record(tick, finger)).is_err() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_secs(20);
    while !holds() {
        assert!(Instant::now() < until, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

struct Bench {
    folder: tempfile::TempDir,
    ring: Producer<FingerRecord>,
    recorder: RecorderHandle,
    tapped: Arc<Mutex<Vec<u64>>>,
}

impl Bench {
    fn new() -> Self {
        let (ring, records) = RingBuffer::new(4096);
        let tapped = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&tapped);
        let tap = move |records: &[FingerRecord]| {
            into.lock().unwrap().extend(records.iter().map(|r| r.tick));
        };
        Self {
            folder: tempfile::tempdir().unwrap(),
            ring,
            recorder: RecorderThread::spawn(records, Some(Box::new(tap))).unwrap(),
            tapped,
        }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("a.mcap")
    }

    fn push(&mut self, ticks: std::ops::Range<u64>) {
        push(&mut self.ring, ticks);
    }

    fn wait_for_tap(&self, n: usize) {
        wait_until("the tap", || self.tapped.lock().unwrap().len() >= n);
    }
}

fn ticks_in(path: &Path) -> Vec<u64> {
    let recording = Session::open(path)
        .unwrap()
        .load(Strictness::Strict)
        .unwrap();
    assert_eq!(recording.fingers[0].len(), recording.fingers[1].len());
    recording.fingers[0].iter().map(|r| r.tick).collect()
}

#[test]
fn every_tick_between_start_and_stop_is_written_and_all_are_tapped() {
    let mut bench = Bench::new();
    bench.push(0..500);
    bench.wait_for_tap(1000);
    assert_eq!(bench.recorder.status().state, RecorderState::Idle);
    bench.recorder.start(&bench.path(), header(2)).unwrap();
    let path = bench.path();
    assert!(path.exists());
    assert_eq!(
        bench.recorder.status().state,
        RecorderState::Recording { path: path.clone() }
    );
    bench.push(500..4500);
    assert!(bench.recorder.mark("mark", "here"));
    let summary = bench.recorder.stop().unwrap();
    assert_eq!((summary.ticks, summary.lost, summary.events), (4000, 0, 1));
    assert!((summary.seconds - 3.999).abs() < 1.0e-9);
    bench.push(4500..4600);
    bench.wait_for_tap(9200);
    assert_eq!(ticks_in(&path), (500..4500).collect::<Vec<_>>());
    assert_eq!(bench.recorder.status().state, RecorderState::Idle);
    assert_eq!(
        bench.recorder.status().bytes,
        std::fs::metadata(&path).unwrap().len()
    );
    let tapped = bench.tapped.lock().unwrap();
    assert!(tapped.chunks(2).map(|c| c[0]).eq(0..4600));
}

#[test]
fn what_the_ring_lost_is_counted_while_recording() {
    let mut bench = Bench::new();
    bench.recorder.start(&bench.path(), header(2)).unwrap();
    bench.push(0..100);
    bench.push(130..200);
    wait_until("the status", || bench.recorder.status().ticks == 170);
    assert_eq!(bench.recorder.status().lost, 60);
    assert_eq!(bench.recorder.stop().unwrap().lost, 60);
}

#[test]
fn orders_that_make_no_sense_are_refused_and_change_nothing() {
    let mut bench = Bench::new();
    let path = bench.path();
    assert!(bench.recorder.stop().is_err());
    let missing = bench.folder.path().join("missing/a.mcap");
    assert!(bench.recorder.start(&missing, header(2)).is_err());
    let mut bad = header(2);
    bad.rate_hz = -1.0;
    let refused = bench.recorder.start(&path, bad);
    assert!(matches!(refused, Err(SessionError::Header { .. })));
    assert!(!path.exists());
    bench.recorder.start(&path, header(2)).unwrap();
    let again = bench
        .recorder
        .start(&bench.folder.path().join("b.mcap"), header(2));
    assert!(again.unwrap_err().to_string().contains("already"));
    bench.push(0..10);
    bench.recorder.stop().unwrap();
    assert!(bench.recorder.start(&path, header(2)).is_err());
    assert_eq!(ticks_in(&path), (0..10).collect::<Vec<_>>());
    bench.recorder.start_replacing(&path, header(2)).unwrap();
    bench.recorder.stop().unwrap();
    assert_eq!(ticks_in(&path), Vec::<u64>::new());
}

#[test]
fn another_ring_goes_on_behind_a_gap() {
    let mut bench = Bench::new();
    let path = bench.path();
    bench.recorder.start(&path, header(2)).unwrap();
    bench.push(0..100);
    let (mut ring, records) = RingBuffer::new(4096);
    bench.recorder.swap_records(records).unwrap();
    push(&mut ring, 40..90);
    wait_until("the new ring", || bench.recorder.status().ticks == 150);
    assert_eq!(bench.recorder.stop().unwrap().lost, 0);
    assert_eq!(
        ticks_in(&path),
        (0..100).chain(101..151).collect::<Vec<_>>()
    );
}

#[test]
fn dropping_the_handle_finishes_the_file() {
    let mut bench = Bench::new();
    let path = bench.path();
    bench.recorder.start(&path, header(2)).unwrap();
    bench.push(0..100);
    drop(bench.recorder);
    assert_eq!(ticks_in(&path), (0..100).collect::<Vec<_>>());
}

#[cfg(unix)]
#[test]
fn a_removed_folder_fails_the_recording_and_it_stays_failed() {
    let mut bench = Bench::new();
    let folder = bench.folder.path().join("gone");
    std::fs::create_dir(&folder).unwrap();
    bench
        .recorder
        .start(&folder.join("a.mcap"), header(2))
        .unwrap();
    bench.push(0..10);
    std::fs::remove_dir_all(&folder).unwrap();
    let failed = |status| matches!(status, RecorderState::Failed { .. });
    wait_until("the failure", || failed(bench.recorder.status().state));
    let error = bench.recorder.stop().unwrap_err().to_string();
    assert!(
        error.contains("removed") && error.contains("a.mcap"),
        "{error}"
    );
    bench.push(10..20);
    bench.wait_for_tap(40);
    assert!(failed(bench.recorder.status().state));
    bench.recorder.start(&bench.path(), header(2)).unwrap();
    bench.push(20..30);
    bench.recorder.stop().unwrap();
    assert_eq!(ticks_in(&bench.path()), (20..30).collect::<Vec<_>>());
}

#[test]
fn a_finger_that_the_header_does_not_name_fails_the_recording() {
    let mut bench = Bench::new();
    bench.recorder.start(&bench.path(), header(1)).unwrap();
    bench.push(0..10);
    let error = bench.recorder.stop().unwrap_err().to_string();
    assert!(error.contains("finger 1"), "{error}");
}

/// A disk with room for so many bytes.
struct SmallDisk {
    path: PathBuf,
    room: AtomicUsize,
}

impl Store for SmallDisk {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        let room = self.room.load(Ordering::Relaxed);
        let n = bytes.len().min(room);
        self.room.store(room - n, Ordering::Relaxed);
        let mut file = std::fs::OpenOptions::new()
            .create(true)
            .append(true)
            .open(&self.path)?;
        file.write_all(&bytes[..n])?;
        if n < bytes.len() {
            return Err(io::ErrorKind::StorageFull.into());
        }
        Ok(())
    }

    fn keep(&self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_told_and_what_was_written_stays_readable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let disk = SmallDisk {
        path: path.clone(),
        room: AtomicUsize::new(900_000),
    };
    let mut writer = SessionWriter::on(disk, &path, &header(2)).unwrap();
    let records = (0..20_000).flat_map(|tick| [record(tick, 0), record(tick, 1)]);
    let mut written = 0;
    let first = records
        .map(|r| writer.write(&r))
        .inspect(|outcome| written += usize::from(outcome.is_ok()))
        .find_map(Result::err)
        .unwrap()
        .to_string();
    assert!(first.contains("a.mcap"), "{first}");
    assert_eq!(writer.write(&record(1, 0)).unwrap_err().to_string(), first);
    assert_eq!(writer.flush().unwrap_err().to_string(), first);
    assert_eq!(writer.finish().unwrap_err().to_string(), first);
    let read = Session::open(&path)
        .unwrap()
        .load(Strictness::Lenient)
        .unwrap();
    let n = read.fingers[0].len() + read.fingers[1].len();
    assert!(
        n > 1000 && n < written && read.damage.unfinished,
        "{n} of {written}"
    );
}

#[test]
fn what_a_trial_hides_is_in_its_file_only_once_it_is_revealed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trial.mcap");
    let (mut ring, records) = RingBuffer::new(4096);
    let recorder = RecorderThread::spawn(records, None).unwrap();
    let shown = Header {
        sealed: true,
        ..header(2)
    };
    let felt = Header {
        scenario_toml: "format = 1\nname = \"Shown\"\n# the hidden place\n".into(),
        mesh: MeshSource {
            hash: "beef".into(),
            ..shown.mesh.clone()
        },
        sealed: false,
        ..shown.clone()
    };
    recorder.start(&path, shown.clone()).unwrap();
    push(&mut ring, 0..2000);
    std::thread::sleep(Duration::from_millis(600));
    let before = std::fs::read(&path).unwrap();
    let hidden = |bytes: &[u8]| bytes.windows(10).all(|w| w != b"the hidden");
    assert!(hidden(&before) && before.len() > 100_000);
    let sealed = Session::open(&path).unwrap();
    assert_eq!(sealed.header(), &shown);
    assert!(recorder.reveal(shown.clone()).is_err(), "nothing to reveal");
    recorder.reveal(felt.clone()).unwrap();
    recorder.stop().unwrap();
    let session = Session::open(&path).unwrap();
    assert_eq!(session.header(), &felt);
    let read = session.load(Strictness::Strict).unwrap();
    assert_eq!(read.fingers[1].len(), 2000);
    // Cut off before it was revealed: readable, and sealed still.
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &before).unwrap();
    let cut = Session::open(&cut).unwrap();
    assert!(cut.header().sealed);
    assert!(cut.load(Strictness::Lenient).unwrap().fingers[0].len() > 500);
}

#[test]
fn what_is_felt_while_a_recording_is_held_is_not_in_it() {
    let mut rig = Bench::new();
    let path = rig.path();
    rig.recorder.start(&path, header(2)).unwrap();
    rig.push(0..500);
    rig.wait_for_tap(1000);
    rig.recorder.hold(true).unwrap();
    rig.push(500..800);
    rig.wait_for_tap(1600);
    rig.recorder.hold(false).unwrap();
    rig.push(800..1000);
    rig.wait_for_tap(2000);
    rig.recorder.stop().unwrap();
    let read = Session::open(&path)
        .unwrap()
        .load(Strictness::Strict)
        .unwrap();
    // The times tell which ticks these are: their numbers go on behind the gap.
    assert_eq!(read.fingers[0].len(), 700);
    let kinds: Vec<_> = read.events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds, ["restart"], "a gap, and nothing lost");
}

/// A disk that takes its time for everything.
struct SlowDisk(std::fs::File);

impl Store for SlowDisk {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        std::thread::sleep(Duration::from_millis(150));
        self.0.append(bytes)
    }

    fn keep(&self) -> io::Result<()> {
        std::thread::sleep(Duration::from_millis(400));
        self.0.keep()
    }
}

#[test]
fn a_slow_disk_costs_no_tick_and_the_status_does_not_wait_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("slow.mcap");
    let (mut ring, records) = RingBuffer::new(16 * 1024);
    let recorder = RecorderThread::spawn(records, None).unwrap();
    let disk = SlowDisk(std::fs::File::create(&path).unwrap());
    recorder.start_on(Box::new(disk), &path, header(2)).unwrap();
    let started = Instant::now();
    let mut tick = 0;
    let mut waited = Duration::ZERO;
    while tick < 3000 {
        let due = (started.elapsed().as_millis() as u64).min(3000);
        for t in tick..due {
            for finger in 0..2 {
                assert!(ring.push(record(t, finger)).is_ok(), "lost at {t}");
            }
        }
        tick = due;
        let asked = Instant::now();
        assert!(!matches!(
            recorder.status().state,
            RecorderState::Failed { .. }
        ));
        waited = waited.max(asked.elapsed());
        std::thread::sleep(Duration::from_millis(2));
    }
    let summary = recorder.stop().unwrap();
    assert_eq!((summary.ticks, summary.lost), (3000, 0));
    assert_eq!(ticks_in(&path), (0..3000).collect::<Vec<_>>());
    assert!(waited < Duration::from_millis(400), "{waited:?}");
}

#[test]
fn faults_are_told_by_the_recorder_and_what_it_carries_is_in_every_file() {
    let mut bench = Bench::new();
    let path = bench.path();
    let carried = dorsum::session::Extras {
        calibrations: vec!["zeroed".into(), String::new()],
        ..dorsum::session::Extras::of_this_machine()
    };
    bench.recorder.carry(carried.clone());
    bench.recorder.start(&path, header(2)).unwrap();
    for tick in 0..300 {
        for finger in 0..2 {
            let mut r = record(tick, finger);
            r.reading.connected = finger == 0 || !(100..200).contains(&tick);
            r.late = tick == 50;
            bench.ring.push(r).unwrap();
        }
    }
    bench.recorder.stop().unwrap();
    let session = Session::open(&path).unwrap();
    assert_eq!(session.extras().unwrap(), carried);
    let read = session.load(Strictness::Strict).unwrap();
    let told: Vec<_> = read.events.iter().map(|e| (e.tick, &*e.kind)).collect();
    assert_eq!(told, [(50, "fault"), (100, "fault"), (200, "fault")]);
    assert!(
        read.events[1].text.contains("finger 1"),
        "{:?}",
        read.events
    );
}

const KILLED: &str = "DORSUM_TEST_RECORD_UNTIL_KILLED";

/// Not a test of its own: what [`a_killed_program_loses_a_second_at_most`] runs in a process to be killed.
#[test]
fn record_until_killed() {
    let Some(path) = std::env::var_os(KILLED) else {
        return;
    };
    let (mut ring, records) = RingBuffer::new(4096);
    let recorder = RecorderThread::spawn(records, None).unwrap();
    recorder.start(Path::new(&path), header(2)).unwrap();
    let started = Instant::now();
    let mut tick = 0;
    loop {
        let due = started.elapsed().as_millis() as u64;
        push(&mut ring, tick..due.max(tick));
        tick = due.max(tick);
        println!("\npushed {tick}");
        std::thread::sleep(Duration::from_millis(3));
    }
}

#[test]
fn a_killed_program_loses_a_second_at_most() {
    let folder = tempfile::tempdir().unwrap();
    for (i, life_ms) in [150, 700, 1130].into_iter().enumerate() {
        let path = folder.path().join(format!("{i}.mcap"));
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args([
                "record_until_killed",
                "--exact",
                "--nocapture",
                "--test-threads=1",
            ])
            .env(KILLED, &path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut pushed = 0;
        for line in lines.map(Result::unwrap) {
            if let Some(n) = line.strip_prefix("pushed ") {
                pushed = n.parse().unwrap();
            }
            if pushed >= life_ms {
                child.kill().unwrap();
                break;
            }
        }
        child.wait().unwrap();
        let session = Session::open(&path).unwrap();
        let read = session.load(Strictness::Lenient).unwrap();
        assert!(read.damage.unfinished);
        let kept = read.fingers[1].len() as u64;
        assert!(kept + 1000 >= pushed, "{kept} of {pushed} ticks kept");
        assert!(
            read.fingers[0]
                .iter()
                .map(|r| r.tick)
                .eq(0..read.fingers[0].len() as u64)
        );
    }
}
