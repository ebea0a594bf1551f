//! A session opened by its index shows at every instant what the whole of it in memory shows, damaged or not.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/sessions.rs"]
mod sessions;

use dorsum::servo::FingerRecord;
use dorsum::session::{IfExists, Session, SessionWriter, Source, Strictness, Timeline};
use proptest::prelude::*;
use sessions::{header, run, temporary};
use std::path::Path;
use std::sync::Arc;

/// What happens to a file before it is opened.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Whole,
    Cut(f64),
    Flipped(f64, u8),
}

fn fates() -> impl Strategy<Value = Fate> {
    prop_oneof![
        Just(Fate::Whole),
        (0.05..1.0).prop_map(Fate::Cut),
        ((0.05..1.0), 1u8..=255).prop_map(|(at, bits)| Fate::Flipped(at, bits)),
    ]
}

/// Records with some fingers left out in places, in chunks that end where they may.
fn write(path: &Path, records: &[FingerRecord], flush_every: usize, left_out: (usize, usize)) {
    let mut writer = SessionWriter::create(path, &header(2), IfExists::Refuse).unwrap();
    writer.event("mark", "before").unwrap();
    for (i, r) in records.iter().enumerate() {
        if !(left_out.0..left_out.1).contains(&i) || r.finger == 0 && i % 2 == 0 && i % 3 > 0 {
            writer.write(r).unwrap();
        }
        if i % flush_every == flush_every - 1 {
            writer.flush().unwrap();
        }
        if i % 701 == 0 {
            writer.event("mark", &i.to_string()).unwrap();
        }
        if i == records.len() / 2 {
            writer.edit(1, &Arc::from("edited")).unwrap();
            writer.restarted();
        }
    }
    writer.finish().unwrap();
}

fn suffer(path: &Path, fate: Fate) {
    let mut bytes = std::fs::read(path).unwrap();
    let place = |share: f64| (share * (bytes.len() - 1) as f64) as usize;
    match fate {
        Fate::Whole => return,
        Fate::Cut(share) => {
            let n = place(share);
            bytes.truncate(n);
        }
        Fate::Flipped(share, bits) => {
            let at = place(share);
            bytes[at] ^= bits;
        }
    }
    std::fs::write(path, bytes).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn it_shows_what_the_whole_in_memory_shows(
        n in 500u64..3000,
        flush_every in 20usize..900,
        left_out in (0usize..900, 0usize..1400),
        fate in fates(),
        instants in prop::collection::vec((0.0..1.02f64, -3000i64..3000), 60),
    ) {
        let (_folder, path) = temporary();
        write(&path, &run(n, 2), flush_every, left_out);
        suffer(&path, fate);
        let Ok(session) = Session::open(&path) else {
            prop_assert!(Timeline::open(&path).is_err());
            return Ok(());
        };
        let all = session.load(Strictness::Lenient).unwrap();
        let timeline = Timeline::open(&path).unwrap();
        prop_assert_eq!(timeline.header(), &all.header);
        prop_assert_eq!(timeline.events(), &all.events[..]);
        prop_assert_eq!(timeline.edits(), &all.edits[..]);
        prop_assert_eq!(timeline.span_ns(), all.span_ns());
        if matches!(fate, Fate::Whole) {
            let most = all.fingers.iter().map(Vec::len).max().unwrap();
            prop_assert_eq!(timeline.n_ticks(), most as u64);
            prop_assert!(timeline.damage().is_none());
        }
        let (first, last) = all.span_ns();
        let length = (last - first) as f64;
        for (share, ticks) in instants {
            let at = first + (share * length) as u64;
            prop_assert_eq!(timeline.at_ns(at), all.at_ns(at));
            // A damaged chunk that was never looked at counts with the ticks it had.
            if !matches!(fate, Fate::Flipped(..)) {
                prop_assert_eq!(timeline.step_ns(at, ticks), all.step_ns(at, ticks));
            }
            prop_assert_eq!(timeline.step_ns(at, ticks.signum()), all.step_ns(at, ticks.signum()));
        }
        for at in [0, first, first.saturating_sub(1), last, u64::MAX] {
            prop_assert_eq!(timeline.at_ns(at), all.at_ns(at));
            for ticks in [i64::MIN, -1, 0, 1, i64::MAX] {
                prop_assert_eq!(timeline.step_ns(at, ticks), all.step_ns(at, ticks));
            }
        }
    }
}

#[test]
fn a_finished_file_is_indexed_as_its_scan_would_index_it() {
    let (_folder, path) = temporary();
    write(&path, &run(5000, 2), 400, (100, 300));
    let by_summary = Timeline::open(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let cut = path.with_extension("cut");
    std::fs::write(&cut, &bytes[..bytes.len() - 20]).unwrap();
    let scanned = Timeline::open(&cut).unwrap();
    assert!(by_summary.damage().is_none() && scanned.damage().unfinished);
    assert_eq!(by_summary.span_ns(), scanned.span_ns());
    assert_eq!(by_summary.n_ticks(), scanned.n_ticks());
    assert_eq!(by_summary.events(), scanned.events());
    assert_eq!(by_summary.scenario_after(1), Some("edited"));
    assert_eq!(scanned.scenario_after(1), Some("edited"));
    assert_eq!(scanned.scenario_after(2), None);
}

#[test]
fn what_can_no_longer_be_read_leaves_the_last_good_instant() {
    let (_folder, path) = temporary();
    write(&path, &run(5000, 2), 200, (0, 0));
    let timeline = Timeline::open(&path).unwrap();
    let (first, last) = timeline.span_ns();
    let shown = timeline.at_ns(first);
    assert_eq!(shown.n_fingers, 2);
    // Cut behind its back: chunks further on are gone.
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len(40_000).unwrap();
    let then = timeline.at_ns(first + (last - first) / 2);
    assert!(
        then.n_fingers == 2 && then.fingers[0].tick < 300,
        "{then:?}"
    );
    assert!(timeline.step_ns(first, 1).is_some());
}

#[test]
fn a_session_without_ticks_has_nothing_to_show() {
    let (_folder, path) = temporary();
    write(&path, &[], 10, (0, 0));
    let timeline = Timeline::open(&path).unwrap();
    assert_eq!((timeline.n_ticks(), timeline.span_ns()), (0, (0, 0)));
    assert_eq!(timeline.at_ns(5).fingers(), [FingerRecord::default(); 2]);
    assert_eq!(timeline.step_ns(0, 1), None);
    assert_eq!(timeline.duration_s(), 0.0);
}
