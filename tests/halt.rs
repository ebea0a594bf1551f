//! Signals, panics and unplugging, tried on real processes: force ends at zero, recordings are whole, the exit code says why.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::{Stiffness, TouchScene};
use dorsum::device::{Capabilities, Device, Reading};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::servo::{self, Halt, Rig, ServoConfig};
use dorsum::session::{Session, Strictness};
use dorsum::surface::{RawMesh, Surface};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const EXAMPLE: &str = "t5_right.toml";

fn dorsum(words: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_dorsum"))
        .args(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !holds() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Starts a run that records into `file`, lets it record a good while, sends `signal`; what it said.
fn halted_by(signal: Signal, file: &Path, how: &[&str]) -> Output {
    let file_name = file.to_str().unwrap();
    let common = ["run", EXAMPLE, "--json", "--record", file_name];
    let child = dorsum(&[&common, how].concat());
    let size = || std::fs::metadata(file).map_or(0, |m| m.len());
    until("nothing was recorded", || size() > 300_000);
    kill(Pid::from_raw(child.id() as i32), signal).unwrap();
    child.wait_with_output().unwrap()
}

fn json(output: &Output) -> Value {
    let error = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {error}"))
}

/// Opens a recording strictly, and repeats it bit for bit.
fn is_whole(file: &Path) -> u64 {
    let session = Session::open(file).unwrap();
    let load = session.load(Strictness::Strict).unwrap();
    assert!(!load.fingers[0].is_empty());
    let output = dorsum(&["replay", file.to_str().unwrap(), "--check", "--json"]);
    let output = output.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    load.fingers[0].len() as u64
}

#[test]
fn a_run_that_is_told_to_end_zeroes_the_device_closes_its_recording_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ended.mcap");
    let emulated = ["--emulator", "woodenhaptics", "--seconds", "600"];
    let clamped = ["--passivity", "--stiffness", "clamp"];
    let output = halted_by(Signal::SIGTERM, &file, &[&emulated[..], &clamped].concat());
    assert_eq!(output.status.code(), Some(143));
    let said = json(&output);
    assert_eq!(said["ended_early"], Halt::Terminated.title());
    let truth = &said["hands"][0]["truth"];
    assert_eq!(truth["ended_at_zero"], true, "{truth}");
    assert!(truth["highest_n"].as_f64().unwrap() > 0.0, "{truth}");
    assert!(is_whole(&file) > 500);
}

#[test]
fn each_signal_has_its_own_exit_code() {
    for (signal, code) in [(Signal::SIGINT, 130), (Signal::SIGHUP, 129)] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ended.mcap");
        // A long path, so that it is still on its way.
        let path = folder.path().join("rest.csv");
        std::fs::write(&path, "t,x,y,z\n0,0,250,90\n600,1,250,90\n").unwrap();
        let output = halted_by(signal, &file, &["--path", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(code));
        is_whole(&file);
    }
}

#[test]
fn a_device_that_is_pulled_out_ends_the_run_with_a_whole_recording() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("unplugged.mcap");
    let words = ["run", EXAMPLE, "--json", "--emulator", "woodenhaptics"];
    let fault = ["--fault", "unplugged", "--seconds", "30"];
    let record = ["--record", file.to_str().unwrap()];
    let output = dorsum(&[&words[..], &fault, &record].concat());
    let output = output.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = json(&output);
    assert_eq!(said["ended_early"], "WoodenHaptics: unplugged");
    assert_eq!(said["hands"][0]["truth"]["ended_at_zero"], true);
    is_whole(&file);
    let load = Session::open(&file)
        .unwrap()
        .load(Strictness::Strict)
        .unwrap();
    let last = load.fingers[0].last().unwrap();
    assert!(!last.reading.connected && last.sent_force_n == Vec3::ZERO);
}

#[test]
fn a_device_that_is_not_there_is_one_line() {
    for (words, told) in [
        (["--device", "theremin"], "there are woodenhaptics"),
        (["--emulator", "theremin"], "no emulator for"),
    ] {
        let output = dorsum(&[&["run", EXAMPLE][..], &words].concat());
        let output = output.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains(told) && said.trim().lines().count() == 1,
            "{said}"
        );
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Call {
    Write(Vec3),
    Enable(bool),
    Close,
}

/// Keeps what it is asked.
struct Spy(Capabilities, Arc<Mutex<Vec<Call>>>);

impl Device for Spy {
    fn capabilities(&self) -> &Capabilities {
        &self.0
    }
    fn read(&mut self, _dt_s: f64) -> Reading {
        Reading {
            position_mm: Vec3::new(0.2, 0.2, 5.0),
            connected: true,
            ..Reading::default()
        }
    }
    fn write(&mut self, force_n: Vec3) {
        self.1.lock().unwrap().push(Call::Write(force_n));
    }
    fn enable(&mut self, on: bool) {
        self.1.lock().unwrap().push(Call::Enable(on));
    }
    fn close(&mut self) {
        self.1.lock().unwrap().push(Call::Close);
    }
}

/// The one test here that halts this process: the others start their own.
#[test]
fn a_panic_on_any_thread_ends_every_servo_and_a_tolerated_one_does_not() {
    servo::halt_on_panic();
    let mesh = RawMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
    };
    let surface = Arc::new(Surface::new(mesh).unwrap().0);
    let search = Arc::new(Bvh::new(&surface));
    let scene = TouchScene::new(surface, search, Stiffness::Uniform(1.0));
    let calls = Arc::new(Mutex::new(Vec::new()));
    let device = Spy(Capabilities::ideal("Spy", 5.0), calls.clone());
    let rig = Rig::new(Box::new(scene), Default::default());
    let config = ServoConfig {
        force_enabled: false,
        ..ServoConfig::default()
    };
    let (servo, mut lines) = servo::start(config, rig, vec![Box::new(device)]).unwrap();
    until("never ticked", || calls.lock().unwrap().len() > 3);
    assert_eq!(
        calls.lock().unwrap()[0],
        Call::Enable(false),
        "before the first tick"
    );
    let enable = |on| servo::Command::EnableForce(on);
    for on in [true, false, true] {
        assert!(lines.commands.push(enable(on)).is_ok());
        until("never told", || {
            let calls = calls.lock().unwrap();
            calls.iter().rfind(|c| matches!(c, Call::Enable(_))) == Some(&Call::Enable(on))
        });
    }
    let panics = || -> () { panic!("a test panics on purpose") };
    let named = || std::thread::Builder::new().name("panics".into());
    let tolerated = named().spawn(move || servo::tolerate(panics)).unwrap();
    assert!(tolerated.join().is_err());
    assert_eq!(servo::halted(), None);
    assert!(named().spawn(panics).unwrap().join().is_err());
    assert_eq!(servo::halted(), Some(Halt::Panicked));
    until("never ended", || servo.has_ended());
    {
        let calls = calls.lock().unwrap();
        let n = calls.len();
        assert_eq!(
            calls[n - 3..],
            [Call::Write(Vec3::ZERO), Call::Enable(false), Call::Close]
        );
    }
    assert!(servo::resume(), "somebody looked at it");
    servo::halt(Halt::Terminated);
    assert!(!servo::resume(), "a signal stays");
}
