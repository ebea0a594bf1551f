//! What the tests of sessions share.

#![allow(dead_code, reason = "each test uses its part")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::device::Reading;
use dorsum::geom::Vec3;
use dorsum::servo::FingerRecord;
use dorsum::session::{
    DeviceInfo, Header, IfExists, MeshSource, Recording, Session, SessionError, SessionWriter,
    Strictness,
};
use std::path::{Path, PathBuf};

pub fn header(n_fingers: usize) -> Header {
    let device = DeviceInfo {
        name: "Scripted".into(),
        rated_force_n: 22.0,
        rise_n_per_s: 4400.0,
        passivity: false,
        stiffness: Default::default(),
    };
    Header {
        scenario_toml: "format = 1\nname = \"Rücken\"\n".into(),
        scenario_name: "Rücken".into(),
        mesh: MeshSource {
            hash: "ab".repeat(32),
            origin: "builtin:back".into(),
            triangles: 2962,
        },
        devices: vec![device; n_fingers],
        rate_hz: 1000.0,
        build: "test".into(),
        started_utc: "2031-05-17T09:30:00Z".into(),
        participant: Some("P07".into()),
        edit: 0,
        sealed: false,
    }
}
/// Records of a smooth run: for each tick one per finger.
pub fn run(n_ticks: u64, n_fingers: u8) -> Vec<FingerRecord> {
    let ticks = (0..n_ticks).flat_map(|tick| (0..n_fingers).map(move |finger| (tick, finger)));
    let record = |(tick, finger): (u64, u8)| {
        let x = tick as f64 * 0.1 + f64::from(finger);
        FingerRecord {
            tick: tick + 7,
            finger,
            time_ns: tick * 1_000_000 + 123,
            reading: Reading {
                position_mm: Vec3::new(x, -x, x / 3.0),
                connected: true,
                ..Reading::default()
            },
            sent_force_n: Vec3::new(0.0, -0.0, x),
            ..FingerRecord::default()
        }
    };
    ticks.map(record).collect()
}

pub fn write(path: &Path, n_fingers: usize, records: &[FingerRecord]) {
    let mut writer = SessionWriter::create(path, &header(n_fingers), IfExists::Refuse).unwrap();
    for (i, r) in records.iter().enumerate() {
        writer.write(r).unwrap();
        if i == records.len() / 2 {
            writer.event("mark", "halfway").unwrap();
        }
    }
    let summary = writer.finish().unwrap();
    assert_eq!(summary.lost, 0);
    assert_eq!(summary.bytes, std::fs::metadata(path).unwrap().len());
}

pub fn load(path: &Path, strictness: Strictness) -> Result<Recording, SessionError> {
    Session::open(path)?.load(strictness)
}

pub fn temporary() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    (folder, path)
}
