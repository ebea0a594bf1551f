//! What recording, reading and re-simulating two fingers on the built-in back cost: `cargo bench --bench session`.
//!
//! The run is two spirals, felt with friction at 1 kHz. Recording is measured beside a servo that pushes in real time.

use dorsum::contact::{Friction, Stiffness, TouchScene};
use dorsum::device::Device;
use dorsum::device::scripted::{Script, Scripted};
use dorsum::geom::Vec3;
use dorsum::partition::bvh::Bvh;
use dorsum::partition::{Partition as _, Sides};
use dorsum::servo::{FingerRecord, Limits, MAX_FINGERS, Rig, run_offline};
use dorsum::session::{
    DeviceInfo, Header, IfExists, MeshSource, RecorderThread, Session, SessionError, SessionWriter,
    Strictness, build_id, check, utc_now,
};
use dorsum::surface::back::{self, BackOptions};
use dorsum::surface::{MeshError, Surface};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

const TICKS: usize = 120_000;
const DT_S: f64 = 0.001;
const LIVE: Duration = Duration::from_secs(10);

#[derive(Debug, thiserror::Error)]
#[error(transparent)]
enum Failed {
    Mesh(#[from] MeshError),
    Session(#[from] SessionError),
    Io(#[from] std::io::Error),
}

fn main() -> Result<(), Failed> {
    let (surface, _) = Surface::new(back::make(&BackOptions::with_triangles(20_389)))?;
    let search = Arc::new(Bvh::new(&surface));
    let scene = TouchScene {
        friction: Some(Friction {
            static_coefficient: 0.46,
            dynamic_coefficient: 0.44,
            skin_looseness: 1.0,
        }),
        ..TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(0.6))
    };
    let header = Header {
        scenario_toml: String::new(),
        scenario_name: "bench".into(),
        mesh: MeshSource::new(&scene.surface, "builtin:back"),
        devices: vec![DeviceInfo::new("Scripted", &Limits::default()); 2],
        rate_hz: 1.0 / DT_S,
        build: build_id(),
        started_utc: utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    };
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("bench.mcap");
    let records = run(&scene);

    let took = write(&path, &header, &records)?;
    let bytes = std::fs::metadata(&path)?.len() as f64;
    let per_record_us = took * 1.0e6 / records.len() as f64;
    println!("write           {per_record_us:>8.2} µs per finger and tick");
    let per_record = bytes / records.len() as f64;
    let per_hour = per_record * 2.0 * 3600.0 / DT_S / 1.0e9;
    println!(
        "size            {per_record:>8.0} bytes per finger and tick, {per_hour:.2} GB per hour of two"
    );

    let (session, took) = timed(|| Session::open(&path))?;
    println!("open            {:>8.2} ms", took * 1.0e3);
    let (ticks, took) = timed(|| Ok(session.ticks(Strictness::Strict)?.count()))?;
    println!(
        "read            {:>8.0} × real time",
        ticks as f64 * DT_S / took
    );
    let rig = Rig::new(Box::new(scene), [Limits::default(); MAX_FINGERS]);
    let (report, took) = timed(|| check(&session, rig, Strictness::Strict))?;
    let exact = if report.is_bit_exact() {
        "bit-exact"
    } else {
        "NOT bit-exact"
    };
    println!(
        "re-simulate     {:>8.0} × real time, {exact}",
        report.ticks as f64 * DT_S / took
    );
    live(folder.path(), header, &records)
}

fn timed<T>(act: impl FnOnce() -> Result<T, SessionError>) -> Result<(T, f64), SessionError> {
    let began = Instant::now();
    let done = act()?;
    Ok((done, began.elapsed().as_secs_f64()))
}

fn run(scene: &TouchScene) -> Vec<FingerRecord> {
    let top_mm = scene.surface.bounds().max.z + 1.0;
    let height_mm = |x: f64, y: f64| {
        let (from, to) = (Vec3::new(x, y, top_mm), Vec3::new(x, y, -1.0e3));
        let hit = scene.search.sweep(&scene.surface, from, to, Sides::Front);
        hit.map(|h| h.point.z)
    };
    let middle = scene.surface.bounds().centre();
    let device = |x: f64| {
        let script = Script::Spiral.trajectory((middle.x + x, middle.y), 6.0, height_mm);
        Box::new(Scripted::new(script)) as Box<dyn Device>
    };
    let mut records = Vec::with_capacity(2 * TICKS);
    while records.len() < 2 * TICKS {
        let mut rig = Rig::new(Box::new(scene.clone()), [Limits::default(); MAX_FINGERS]);
        rig.next_tick = records.len() as u64 / 2;
        let until = (rig.next_tick + 6000).min(TICKS as u64);
        run_offline(&mut rig, vec![device(-50.0), device(50.0)], DT_S, |tick| {
            records.extend_from_slice(tick.fingers());
            tick.fingers[0].tick + 1 < until
        });
    }
    records
}

fn write(path: &Path, header: &Header, records: &[FingerRecord]) -> Result<f64, SessionError> {
    let began = Instant::now();
    let mut writer = SessionWriter::create(path, header, IfExists::Refuse)?;
    for record in records {
        writer.write(record)?;
    }
    writer.finish()?;
    Ok(began.elapsed().as_secs_f64())
}

/// Pushes in real time and tells what share of a core the recorder takes.
fn live(folder: &Path, header: Header, records: &[FingerRecord]) -> Result<(), Failed> {
    let (mut ring, consumer) = rtrb::RingBuffer::new(16 * 1024);
    let recorder = RecorderThread::spawn(consumer, None)?;
    recorder.start(&folder.join("live.mcap"), header)?;
    let (began, busy) = (Instant::now(), recorder_ns());
    let mut pushed = 0;
    while began.elapsed() < LIVE {
        let due = began.elapsed().as_millis() as usize * 2;
        while pushed < due.min(records.len()) {
            let _ = ring.push(records[pushed]);
            pushed += 1;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    if let (Some(before), Some(after)) = (busy, recorder_ns()) {
        let share = (after - before) as f64 / began.elapsed().as_nanos() as f64;
        println!("record live     {:>8.2} % of a core", share * 100.0);
    }
    println!("lost            {:>8}", recorder.stop()?.lost);
    Ok(())
}

/// Time the recorder's thread has run, ns, where the system tells (Linux).
fn recorder_ns() -> Option<u64> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let thread = threads.flatten().map(|t| t.path()).find(|t| {
        let name = std::fs::read_to_string(t.join("comm"));
        name.is_ok_and(|n| n.trim() == "recorder")
    })?;
    let times = std::fs::read_to_string(thread.join("schedstat")).ok()?;
    times.split_whitespace().next()?.parse().ok()
}
