//! Writing a session anew: compressed it holds the same, and of a damaged one all that is left is saved and what is not is counted.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/sessions.rs"]
mod sessions;

use dorsum::session::{
    Extras, IfExists, RecoverOptions, RecoverReport, Session, SessionError, SessionWriter,
    Strictness, Timeline, compress, recover,
};
use sessions::{header, load, run, temporary, write};
use std::path::Path;
use std::sync::Arc;

fn saved(broken: &Path, out: &Path, compress: bool) -> Result<RecoverReport, SessionError> {
    let options = RecoverOptions {
        compress,
        if_exists: IfExists::Refuse,
    };
    recover(broken, out, &options, &mut |_| true)
}

fn names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = files
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_compressed_session_is_smaller_and_holds_the_same() {
    let (folder, path) = temporary();
    write(&path, 2, &run(4000, 2));
    let before = load(&path, Strictness::Strict).unwrap();
    let plain = Timeline::open(&path).unwrap();
    let made = compress(&path, &mut |_| true).unwrap();
    assert!(made.after * 2 < made.before, "{made:?}");
    assert_eq!(made.after, std::fs::metadata(&path).unwrap().len());
    assert_eq!(names(folder.path()), ["a.mcap"]);
    let after = load(&path, Strictness::Strict).unwrap();
    assert_eq!(after.header, before.header);
    assert_eq!(
        (after.fingers, after.events),
        (before.fingers, before.events)
    );
    let packed = Timeline::open(&path).unwrap();
    assert_eq!(packed.span_ns(), plain.span_ns());
    assert_eq!(packed.n_ticks(), 4000);
    let (first, last) = plain.span_ns();
    for at in (first..=last).step_by(77_777_777) {
        assert_eq!(packed.at_ns(at), plain.at_ns(at));
        assert_eq!(packed.step_ns(at, 300), plain.step_ns(at, 300));
    }
    // A second time there is nothing to do.
    let again = compress(&path, &mut |_| true).unwrap();
    assert_eq!((again.before, again.after), (made.after, made.after));
}

#[test]
fn a_compressed_session_with_a_flipped_byte_loses_a_chunk_at_most() {
    let (_folder, path) = temporary();
    write(&path, 2, &run(4000, 2));
    compress(&path, &mut |_| true).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    for i in 0..120 {
        let mut damaged = bytes.clone();
        damaged[i * (bytes.len() - 1) / 119] ^= 1 << (i % 8);
        std::fs::write(&path, damaged).unwrap();
        let read = load(&path, Strictness::Lenient).unwrap();
        assert!(read.fingers[0].len() > 3400, "{i}: {:?}", read.damage);
        let timeline = Timeline::open(&path).unwrap();
        let at = read.fingers[1][1234].time_ns;
        assert_eq!(timeline.at_ns(at).fingers[1].time_ns, at);
    }
}

#[test]
fn compressing_stops_when_told_and_refuses_what_is_damaged() {
    let (folder, path) = temporary();
    write(&path, 2, &run(9000, 2));
    let bytes = std::fs::read(&path).unwrap();
    for stop_at in [1, 2, 5] {
        let mut heard = 0;
        let stopped = compress(&path, &mut |_| {
            heard += 1;
            heard < stop_at
        });
        assert!(matches!(stopped, Err(SessionError::Stopped)));
        assert_eq!(std::fs::read(&path).unwrap(), bytes);
    }
    let cut = &bytes[..bytes.len() / 2];
    std::fs::write(&path, cut).unwrap();
    assert!(compress(&path, &mut |_| true).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), cut);
    assert_eq!(names(folder.path()), ["a.mcap"]);
}

#[test]
fn what_is_left_of_a_cut_file_is_saved_whole_and_says_so() {
    let (folder, path) = temporary();
    let out = folder.path().join("out.mcap");
    write(&path, 2, &run(4000, 2));
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() * 2 / 3]).unwrap();
    let left = load(&path, Strictness::Lenient).unwrap();
    let report = saved(&path, &out, false).unwrap();
    assert!(!report.is_whole() && report.damage.unfinished);
    assert_eq!(report.bytes, std::fs::metadata(&out).unwrap().len());
    let read = load(&out, Strictness::Strict).unwrap();
    assert_eq!(read.fingers, left.fingers);
    assert_eq!(report.ticks, read.fingers[0].len() as u64);
    let event = read.events.last().unwrap();
    assert_eq!(event.kind, "recovered");
    assert!(event.text.contains("no end"), "{}", event.text);
    assert_eq!(event.tick, read.fingers[1].last().unwrap().tick);
    assert_eq!(names(folder.path()), ["a.mcap", "out.mcap"]);
    // It has its index: it opens without being read through.
    assert!(Timeline::open(&out).unwrap().damage().is_none());
    let mapped = std::fs::read(&out).unwrap();
    let summary = mcap::Summary::read(&mapped).unwrap().unwrap();
    let names: Vec<_> = summary.metadata_indexes.iter().map(|m| &m.name).collect();
    assert!(names.iter().any(|n| *n == "dorsum.recovered"), "{names:?}");
}

#[test]
fn missing_ticks_are_counted_for_each_finger_and_explained_gaps_are_not() {
    let (folder, path) = temporary();
    let mut writer = SessionWriter::create(&path, &header(2), IfExists::Refuse).unwrap();
    let mut ends = Vec::new();
    for (i, r) in run(4000, 2).iter().enumerate() {
        let lost = r.finger == 1 && (1000..1010).contains(&r.tick);
        if !lost {
            writer.write(r).unwrap();
        }
        if r.tick == 3000 && r.finger == 1 {
            writer.restarted();
        }
        if i % 500 == 499 {
            writer.flush().unwrap();
            ends.push(writer.summary().bytes);
        }
    }
    writer.finish().unwrap();
    let intact = saved(&path, &folder.path().join("whole.mcap"), true).unwrap();
    assert!(intact.is_whole(), "{intact:?}");
    assert_eq!(intact.fingers[1].lost_live, 10);
    let whole = load(&folder.path().join("whole.mcap"), Strictness::Strict).unwrap();
    assert!(whole.events.iter().all(|e| e.kind != "recovered"));
    let mut bytes = std::fs::read(&path).unwrap();
    // In the sixth chunk: ticks 1250 to 1499 behind the first, which is 7.
    bytes[(ends[4] + 5000) as usize] ^= 4;
    std::fs::write(&path, &bytes).unwrap();
    let out = folder.path().join("out.mcap");
    let report = saved(&path, &out, true).unwrap();
    assert_eq!(report.damage.chunks, 1);
    let lost: Vec<_> = report.fingers.iter().map(|f| (f.gaps, f.missing)).collect();
    assert_eq!(lost, [(1, 250), (1, 250)]);
    assert!(report.lost().contains("finger 1 lacks 250 ticks in 1 gap"));
    assert_eq!(
        load(&out, Strictness::Strict).unwrap().fingers[0].len(),
        3750
    );
}

#[test]
fn nothing_is_overwritten_by_accident() {
    let (folder, path) = temporary();
    write(&path, 2, &run(100, 2));
    let out = folder.path().join("out.mcap");
    std::fs::write(&out, "mine").unwrap();
    let error = saved(&path, &out, false).unwrap_err().to_string();
    assert!(error.contains("already there"), "{error}");
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
    let force = RecoverOptions {
        if_exists: IfExists::Replace,
        ..RecoverOptions::default()
    };
    assert!(recover(&path, &path, &force, &mut |_| true).is_err());
    recover(&path, &out, &force, &mut |_| true).unwrap();
    assert_eq!(
        load(&out, Strictness::Strict).unwrap().fingers[1].len(),
        100
    );
    assert!(recover(&out, &folder.path().join("no/where"), &force, &mut |_| true).is_err());
}

#[test]
fn mesh_and_calibration_travel_along_and_are_stepped_over() {
    let (folder, path) = temporary();
    let mesh: Arc<[u8]> = (0..3_000_000u32).map(|i| (i % 251) as u8).collect();
    let extras = Extras {
        mesh: Some(Arc::clone(&mesh)),
        calibrations: vec![String::new(), "zero at 12 mm".into()],
        ..Extras::of_this_machine()
    };
    let mut scanned = header(2);
    scanned.mesh.origin = "scans/back.ply".into();
    let mut writer =
        SessionWriter::create_with(&path, &scanned, &extras, IfExists::Refuse).unwrap();
    for r in run(500, 2) {
        writer.write(&r).unwrap();
    }
    writer.finish().unwrap();
    let session = Session::open(&path).unwrap();
    assert_eq!(session.extras().unwrap(), extras);
    for strictness in [Strictness::Strict, Strictness::Lenient] {
        let read = session.load(strictness).unwrap();
        assert_eq!(read.fingers[0].len(), 500);
        assert!(read.damage.is_none(), "{:?}", read.damage);
    }
    let out = folder.path().join("out.mcap");
    saved(&path, &out, true).unwrap();
    assert_eq!(Session::open(&out).unwrap().extras().unwrap(), extras);
    // The scenario finds it where it was, or unpacked where it is gone or another one.
    let beside = folder.path().join("scans/back.ply");
    let unpacked = session.folder().unwrap();
    assert_ne!(unpacked.path(), folder.path());
    let file = unpacked.path().join("scans/back.ply");
    assert_eq!(std::fs::read(&file).unwrap(), &*mesh);
    drop(unpacked);
    assert!(!file.exists());
    std::fs::create_dir(folder.path().join("scans")).unwrap();
    std::fs::write(&beside, "another").unwrap();
    assert_ne!(session.folder().unwrap().path(), folder.path());
    std::fs::write(&beside, &*mesh).unwrap();
    assert_eq!(session.folder().unwrap().path(), folder.path());
    // A length that would hide the ticks is found out.
    let bytes = std::fs::read(&path).unwrap();
    let at = bytes
        .windows(12)
        .position(|w| w == b"\x04\x00\x00\x00mesh\x18\0\0\0")
        .unwrap();
    for bit in 0..24 {
        let mut damaged = bytes.clone();
        damaged[at - 24 + bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&path, damaged).unwrap();
        let read = load(&path, Strictness::Lenient).unwrap();
        assert_eq!(read.fingers[1].len(), 500, "bit {bit}");
    }
}
