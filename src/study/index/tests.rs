use super::*;
use crate::geom::Vec3;
use crate::session::{Header, IfExists, SessionWriter};
use crate::study::Dwell;
use crate::study::tests::{header, pressed};
use crate::training::journal::{Changes, Header as JournalHeader, Journal};
use crate::training::trial::TrialRecord;
use std::fs;

fn recorded(path: &Path, header: &Header, ticks: u64) {
    let mut writer = SessionWriter::create(path, header, IfExists::Refuse).expect("created");
    for tick in 0..ticks {
        let at = Vec3::new(30.0, 100.0, -2.0);
        writer.write(&pressed(tick, 0, at)).expect("written");
    }
    writer.finish().expect("finished");
}

/// Three recordings, one of them sealed, and one file that is none.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let below = folder.path().join("exercise");
    fs::create_dir(&below).expect("made");
    let plain = header(1, "no scenario");
    let later = Header {
        started_utc: "2031-05-18T10:00:00Z".into(),
        ..plain.clone()
    };
    let sealed = Header {
        sealed: true,
        participant: Some("SECRET".into()),
        ..header(1, "blind")
    };
    recorded(&folder.path().join("a.mcap"), &plain, 300);
    recorded(&below.join("trial_001.mcap"), &later, 200);
    recorded(&below.join("trial_002.mcap"), &sealed, 100);
    fs::write(folder.path().join("broken.mcap"), "no session").expect("written");
    let journal = JournalHeader {
        format: 1,
        program: "test".into(),
        scenario: "locate.toml".into(),
        blind_toml: String::new(),
        changes: Changes::default(),
        participant: Some("P07".into()),
        seed: None,
        observer: None,
        started_utc: "2031-05-18T10:00:00Z".into(),
    };
    let mut journal = Journal::create(&below, &journal).expect("created");
    let mut trial = TrialRecord {
        trial: 1,
        task: "locate".into(),
        ..TrialRecord::default()
    };
    trial.errors.mm = Some(34.4);
    journal.settle(&trial).expect("settled");
    folder
}

fn refreshed(folder: &Path) -> Index {
    let mut index = Index::open(folder);
    let mut shares = Vec::new();
    index
        .refresh(2, &Options::default(), &mut |share, _| {
            shares.push(share);
            true
        })
        .expect("not stopped");
    assert!(shares.is_sorted());
    index
}

#[test]
fn recordings_tell_what_they_are_and_sealed_ones_nothing() {
    let folder = folder();
    let first = Index::open(folder.path());
    assert_eq!(first.waiting().len(), 4);
    let index = refreshed(folder.path());
    let names: Vec<&str> = index.recorded().map(|r| r.name.as_str()).collect();
    let expected = [
        "a.mcap",
        "broken.mcap",
        "exercise/trial_001.mcap",
        "exercise/trial_002.mcap",
    ];
    assert_eq!(names, expected);
    let told = index.get("a.mcap").and_then(Recorded::told).expect("told");
    assert_eq!(told.about.ticks, 300);
    assert_eq!(told.about.participant.as_deref(), Some("P07"));
    let shade = &told.dwell.shade;
    assert_eq!(shade.iter().filter(|s| **s == 255).count(), 1);
    assert!(
        (told.dwell.most_s - 0.3).abs() < 1e-6,
        "{}",
        told.dwell.most_s
    );
    assert!(
        matches!(&index.get("broken.mcap").expect("there").known, Known::Unreadable(why) if why.contains("broken.mcap"))
    );
    let score = index
        .get(expected[2])
        .and_then(|r| r.score.clone())
        .expect("a score");
    assert_eq!(
        (score.text().as_str(), score.exercise_trials),
        ("wrong by 34 mm", 1)
    );
    let sealed = index.get(expected[3]).expect("there");
    assert_eq!((&sealed.known, &sealed.score), (&Known::Sealed, &None));
    let cache = fs::read_to_string(folder.path().join(CACHE_FOLDER).join(CACHE_FILE));
    assert!(!cache.expect("written").contains("SECRET"));
}

#[test]
fn only_what_changed_is_read_again() {
    let folder = folder();
    let before = refreshed(folder.path());
    let again = Index::open(folder.path());
    assert!(again.waiting().is_empty());
    assert_eq!(again, before, "the cache tells the same");
    fs::remove_file(folder.path().join("broken.mcap")).expect("removed");
    let path = folder.path().join("exercise/trial_002.mcap");
    fs::remove_file(&path).expect("removed");
    recorded(&path, &header(1, "no scenario"), 150);
    let mut index = Index::open(folder.path());
    assert_eq!(index.waiting(), ["exercise/trial_002.mcap"]);
    index
        .refresh(1, &Options::default(), &mut |_, _| true)
        .expect("not stopped");
    assert_eq!(index.recorded().len(), 3);
    let told = index
        .get("exercise/trial_002.mcap")
        .and_then(Recorded::told);
    assert_eq!(told.expect("told").about.ticks, 150);
}

#[test]
fn a_damaged_cache_is_rebuilt_and_labels_stay() {
    let folder = folder();
    let mut index = refreshed(folder.path());
    let label = Label {
        tags: vec![
            " good ".into(),
            "expert".into(),
            "good".into(),
            String::new(),
        ],
        note: " look here ".into(),
    };
    index.set_label("a.mcap", label.clone()).expect("written");
    assert_eq!(index.tags(), ["expert", "good"]);
    let cache = folder.path().join(CACHE_FOLDER).join(CACHE_FILE);
    let whole = fs::read(&cache).expect("read");
    for damaged in [
        &b"{"[..],
        b"",
        b"[]",
        &whole[..whole.len() / 2],
        b"\xff\xfe",
    ] {
        fs::write(&cache, damaged).expect("written");
        assert_eq!(Index::open(folder.path()).waiting().len(), 4);
        let again = refreshed(folder.path());
        assert_eq!(again.get("a.mcap"), index.get("a.mcap"));
        assert_eq!(fs::read(&cache).expect("read"), whole);
    }
    // Under another name it is still the same recording; a copy of that name is not.
    fs::rename(folder.path().join("a.mcap"), folder.path().join("z.mcap")).expect("renamed");
    let moved = refreshed(folder.path());
    assert_eq!(
        moved.get("z.mcap").map(|r| r.label.clone()),
        Some(label.tidy())
    );
}

#[test]
fn damaged_labels_are_set_aside_and_never_written_over() {
    let folder = folder();
    let kept = folder.path().join(CACHE_FOLDER);
    fs::create_dir(&kept).expect("made");
    for n in 1..=2 {
        fs::write(kept.join("labels.json"), format!("{{ damaged {n}")).expect("written");
        let mut index = Index::open(folder.path());
        let fault = index.fault.clone().expect("told");
        assert!(fault.contains("set aside as"), "{fault}");
        let label = Label {
            tags: vec!["new".into()],
            ..Label::default()
        };
        index.set_label("a.mcap", label).expect("written");
        for i in 1..=n {
            let aside = fs::read_to_string(kept.join(format!("labels.damaged-{i}.json")));
            assert_eq!(aside.expect("there"), format!("{{ damaged {i}"));
        }
    }
}

#[test]
fn a_refresh_that_is_stopped_keeps_what_it_read() {
    let folder = folder();
    let mut index = Index::open(folder.path());
    let stopped = index.refresh(1, &Options::default(), &mut |_, index| {
        index.waiting().len() == 4
    });
    assert!(matches!(stopped, Err(StudyError::Stopped)));
    let left = Index::open(folder.path()).waiting().len();
    assert_eq!(left, index.waiting().len());
    assert!((1..4).contains(&left), "{left}");
}

#[test]
fn a_folder_that_is_not_there_is_empty() {
    let folder = tempfile::tempdir().expect("a folder");
    let gone = folder.path().join("gone");
    let mut index = Index::open(&gone);
    let refreshed = index.refresh(1, &Options::default(), &mut |_, _| true);
    assert!(refreshed.is_ok() && index.recorded().len() == 0);
    assert_eq!(index.fault, None);
    assert!(!gone.exists());
}

#[test]
fn the_thread_hands_on_what_it_read_and_keeps_what_is_said_meanwhile() {
    let folder = folder();
    let mut thread = IndexThread::open(folder.path());
    let (tell, told) = std::sync::mpsc::sync_channel(1024);
    let label = Label {
        tags: vec!["now".into()],
        ..Label::default()
    };
    thread.set_label("a.mcap", label.clone()).expect("written");
    thread
        .refresh(move || tell.send(()).unwrap_or_default())
        .expect("a thread");
    while told.recv().is_ok() {}
    let state = thread.state();
    assert_eq!(state.progress, None);
    assert!(state.index.waiting().is_empty());
    assert_eq!(state.index.get("a.mcap").map(|r| &r.label), Some(&label));
    assert!(state.version > 2);
}

#[test]
fn a_thumbnail_is_small_and_loses_no_time() {
    for (columns, rows) in [(1, 1), (48, 64), (49, 64), (97, 40), (300, 500), (0, 0)] {
        let seconds: Vec<f32> = (0..columns * rows).map(|i| (i % 7) as f32).collect();
        let dwell = Dwell {
            cell_mm: 5.0,
            columns,
            rows,
            seconds,
            ..Dwell::default()
        };
        let small = Thumbnail::of(&dwell);
        assert!(small.columns <= 48 && small.rows <= 64);
        assert_eq!(small.shade.len(), small.columns * small.rows);
        let text = serde_json::to_string(&small).expect("written");
        assert_eq!(
            serde_json::from_str::<Thumbnail>(&text).expect("read"),
            small
        );
        if columns == 97 {
            // Three by three cells together: their sum, and its root as a share of the greatest.
            assert_eq!(small.cell_mm, 15.0);
            let sum = |x: usize, y: usize| -> f64 {
                let cells = (0..9).map(|i| (3 * x + i % 3, 3 * y + i / 3));
                let inside = cells.filter(|(x, y)| *x < columns && *y < rows);
                inside
                    .map(|(x, y)| f64::from(dwell.seconds[y * columns + x]))
                    .sum()
            };
            let most = (0..33 * 14)
                .map(|i| sum(i % 33, i / 33))
                .fold(0.0, f64::max);
            assert_eq!(small.most_s, most);
            let shade = |x, y| (255.0 * (sum(x, y) / most).sqrt()).round() as u8;
            assert!((0..33 * 14).all(|i| small.shade[i] == shade(i % 33, i / 33).max(1)));
        }
    }
    let text = "{\"origin_mm\":[0,0],\"cell_mm\":5,\"columns\":1,\"rows\":1,\"most_s\":1,\"shade\":\"xß\"}";
    assert!(serde_json::from_str::<Thumbnail>(text).is_err());
}
