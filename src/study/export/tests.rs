use super::*;
use crate::geom::Vec3;
use crate::session::format::{FIELDS, Value};
use crate::session::{Entry, IfExists, SessionWriter, Strictness};
use crate::study::tests::{header, pressed};
use crate::study::{METRICS, analyse};
use crate::table::Head;
use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
use ::parquet::record::{Field as Read, Row};
use std::collections::BTreeMap;
use std::fs;

/// Two fingers press and slide for `ticks` ticks; numbers have all their digits.
fn recorded(folder: &Path, name: &str, participant: Option<&str>, ticks: u64) -> PathBuf {
    let path = folder.join(name);
    let header = crate::session::Header {
        participant: participant.map(str::to_owned),
        ..header(2, "no scenario")
    };
    let mut writer = SessionWriter::create(&path, &header, IfExists::Refuse).expect("created");
    for tick in 0..ticks {
        for finger in 0..2 {
            let t = tick as f64 / 1000.0 + 0.1 * f64::from(finger);
            let z = -3.0 * libm::sin(7.0 * t);
            let at = Vec3::new(30.0 * libm::sin(t) - 0.0, 100.0 + t / 3.0, z);
            let mut record = pressed(tick, finger, at);
            record.duration_us = 0.1 * tick as f32;
            record.sent_force_n = record.contact.force_n * -0.0;
            writer.write(&record).expect("written");
        }
        if tick == 10 {
            writer
                .event("mark", "here, \"this\"\tone")
                .expect("written");
        }
    }
    writer.finish().expect("finished");
    path
}

fn settings(format: Format, folder: &Path) -> Settings {
    Settings {
        format,
        folder: folder.to_owned(),
        force: false,
        options: Options::default(),
    }
}

fn exported(path: &Path, settings: &Settings) -> Exported {
    session(path, settings, &mut |_| true).expect("exported")
}

fn rows(path: &Path) -> (Vec<String>, Vec<Row>) {
    let file = fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let reader = SerializedFileReader::new(file).expect("a Parquet file");
    let schema = reader.metadata().file_metadata().schema();
    let names = schema.get_fields().iter().map(|f| f.name().to_owned());
    let names = names.collect();
    let rows = reader.get_row_iter(None).expect("rows");
    (names, rows.map(|r| r.expect("a row")).collect())
}

/// All files below a folder with their bytes.
fn tree(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(top: &Path, folder: &Path, files: &mut BTreeMap<String, Vec<u8>>) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                walk(top, &path, files);
            } else {
                let name = path.strip_prefix(top).expect("below");
                let name = name.to_string_lossy().into_owned();
                files.insert(name, fs::read(&path).expect("read"));
            }
        }
    }
    let mut files = BTreeMap::new();
    walk(folder, folder, &mut files);
    files
}

#[test]
fn ticks_come_back_bit_for_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), "a b.mcap", Some("P07"), 500);
    let out = folder.path().join("out");
    let told = exported(&path, &settings(Format::Parquet, &out));
    assert_eq!((told.rows, told.left_out, told.skipped), (1000, 0, false));
    let place = "participant=P07/session=20310517T093000Z-a%20b/part-0.parquet";
    let (names, rows) = rows(&out.join("ticks").join(place));
    assert_eq!(
        names.len(),
        FIELDS.len() + 2 * 7,
        "seven fields are vectors"
    );
    let session = Session::open(&path).expect("opened");
    let entries = session.entries(Strictness::Strict).expect("entries");
    let mut n = 0;
    for entry in entries {
        let Entry::Tick(record) = entry.expect("an entry") else {
            continue;
        };
        let row: BTreeMap<&String, &Read> = rows[n].get_column_iter().collect();
        let double = |name: &str| match row[&name.to_owned()] {
            Read::Double(x) => x.to_bits(),
            other => panic!("{name}: {other:?}"),
        };
        for field in FIELDS {
            let name = field.name;
            match (field.get)(&record) {
                Value::Vec3(v) => {
                    for (axis, x) in ["x", "y", "z"].iter().zip(v.to_array()) {
                        assert_eq!(double(&format!("{name}_{axis}")), x.to_bits(), "{name}");
                    }
                }
                Value::F64(x) => assert_eq!(double(name), x.to_bits(), "{name}"),
                Value::F32(x) => assert_eq!(row[&name.to_owned()], &Read::Float(x)),
                Value::U64(x) => assert_eq!(row[&name.to_owned()], &Read::Long(x as i64)),
                Value::U32(x) => assert_eq!(row[&name.to_owned()], &Read::Long(x.into())),
                Value::Bool(x) => assert_eq!(row[&name.to_owned()], &Read::Bool(x)),
                Value::Touch(x) => {
                    let text = crate::session::format::touch_name(x).to_owned();
                    assert_eq!(row[&name.to_owned()], &Read::Str(text));
                }
            }
        }
        n += 1;
    }
    assert_eq!(n, rows.len());
}

#[test]
fn csv_and_parquet_hold_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let paths = [
        recorded(folder.path(), "a.mcap", Some("P/7"), 300),
        recorded(folder.path(), "b.mcap", None, 100),
    ];
    let [parquet, csv] = [("p", Format::Parquet), ("c", Format::Csv)].map(|(name, format)| {
        let settings = settings(format, &folder.path().join(name));
        for path in &paths {
            exported(path, &settings);
        }
        finish(&settings).expect("gathered");
        settings.folder
    });
    let mut compared = 0;
    for name in tree(&parquet).keys() {
        let (names, rows) = rows(&parquet.join(name));
        let other = csv.join(name.replace(".parquet", ".csv"));
        let mut reader = csv::Reader::from_path(&other).expect("there");
        assert_eq!(
            reader.headers().expect("names").iter().collect::<Vec<_>>(),
            names
        );
        let lines: Vec<_> = reader.records().map(|l| l.expect("a line")).collect();
        assert_eq!(lines.len(), rows.len(), "{name}");
        for (row, line) in rows.iter().zip(&lines) {
            for ((key, field), text) in row.get_column_iter().zip(line) {
                let same = match field {
                    Read::Null => text.is_empty(),
                    Read::Double(x) => text
                        .parse::<f64>()
                        .is_ok_and(|y| y.to_bits() == x.to_bits()),
                    Read::Float(x) => text.parse() == Ok(*x),
                    Read::Long(n) => text.parse() == Ok(*n),
                    Read::Bool(yes) => text.parse() == Ok(*yes),
                    Read::Str(expected) => text == expected,
                    _ => false,
                };
                assert!(same, "{name}, {key}: {field:?} is {text:?}");
            }
            compared += 1;
        }
    }
    assert!(compared > 800, "{compared}");
    let (_, sessions) = rows(&parquet.join("sessions.parquet"));
    let named: Vec<String> = sessions
        .iter()
        .map(|r| {
            r.get_column_iter()
                .take(3)
                .map(|(_, f)| f.to_string() + ";")
                .collect()
        })
        .collect();
    assert_eq!(
        named,
        [
            "\"P/7\";\"20310517T093000Z-a\";\"P/7\";",
            "\"unknown\";\"20310517T093000Z-b\";null;"
        ]
    );
}

#[test]
fn the_row_of_a_session_holds_every_measure_of_its_analysis() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), "a.mcap", Some("P07"), 2000);
    let out = folder.path().join("out");
    exported(&path, &settings(Format::Parquet, &out));
    let opened = Session::open(&path).expect("opened");
    let analysis = analyse(&opened, &Options::default(), &mut |_| true).expect("analysed");
    let place = Key::of(&opened).place();
    let (_, rows_of_session) = rows(&out.join("sessions").join(&place).join("part-0.parquet"));
    assert_eq!(rows_of_session.len(), 1);
    let (_, measures) = rows(&out.join("measures").join(&place).join("part-0.parquet"));
    assert_eq!(measures.len(), 9, "three parts of both fingers and of each");
    let value = |row: &Row, key: &str| match row.get_column_iter().find(|(k, _)| *k == key) {
        Some((_, Read::Double(x))) => Some(*x),
        Some((_, Read::Null)) => None,
        other => panic!("{other:?}"),
    };
    let of_rows = [
        (&rows_of_session[0], &analysis.whole),
        (&measures[0], &analysis.whole),
        (&measures[2], &analysis.palpation),
        (&measures[3], &analysis.fingers[0].whole),
        (&measures[7], &analysis.fingers[1].search),
    ];
    for (row, metrics) in of_rows {
        for metric in METRICS {
            assert_eq!(
                value(row, metric.key),
                (metric.get)(metrics),
                "{}",
                metric.key
            );
        }
    }
}

#[test]
fn no_two_columns_share_a_name() {
    let mut tables: Vec<Vec<Head>> = TABLES.iter().map(|t| (t.heads)()).collect();
    tables.push(tables::tick_heads());
    for heads in tables {
        for (i, head) in heads.iter().enumerate() {
            assert!(
                heads[..i].iter().all(|h| h.name != head.name),
                "{}",
                head.name
            );
            assert!(!["participant", "session"].contains(&&*head.name));
        }
    }
}

#[test]
fn what_is_there_is_skipped_and_replaced_by_force_to_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), "a.mcap", Some("P07"), 200);
    for format in [Format::Parquet, Format::Csv, Format::Bids] {
        let out = folder.path().join(format!("{format:?}"));
        let mut settings = settings(format, &out);
        assert!(!exported(&path, &settings).skipped);
        finish(&settings).expect("finished");
        let before = tree(&out);
        assert!(exported(&path, &settings).skipped);
        assert_eq!(tree(&out), before);
        settings.force = true;
        assert!(!exported(&path, &settings).skipped);
        finish(&settings).expect("finished");
        assert!(
            tree(&out) == before,
            "{format:?} differs when it is written again"
        );
        assert!(before.keys().all(|name| !name.contains(".partial")));
    }
}

#[test]
fn an_export_that_is_stopped_leaves_no_session_that_looks_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), "a.mcap", Some("P07"), 6000);
    for format in [Format::Parquet, Format::Csv, Format::Bids] {
        let out = folder.path().join(format!("{format:?}"));
        let settings = settings(format, &out);
        let stopped = session(&path, &settings, &mut |_| false);
        assert!(matches!(stopped, Err(StudyError::Stopped)), "{stopped:?}");
        assert!(tree(&out).is_empty(), "{:?}", tree(&out).keys());
        finish(&settings).expect("finished");
        assert!(!exported(&path, &settings).skipped);
    }
}

#[test]
fn a_sealed_session_is_refused_and_a_cut_one_is_handed_on_with_what_is_missing() {
    let folder = tempfile::tempdir().expect("a folder");
    let sealed = folder.path().join("s.mcap");
    let seen = crate::session::Header {
        sealed: true,
        ..header(1, "blind")
    };
    let mut writer = SessionWriter::create(&sealed, &seen, IfExists::Refuse).expect("created");
    for tick in 0..50 {
        let record = pressed(tick, 0, Vec3::new(0.0, 0.0, -1.0));
        writer.write(&record).expect("written");
    }
    writer.finish().expect("finished");
    let whole = recorded(folder.path(), "a.mcap", Some("P07"), 9000);
    let cut = folder.path().join("b.mcap");
    let bytes = fs::read(&whole).expect("read");
    fs::write(&cut, &bytes[..bytes.len() / 2]).expect("written");
    for format in [Format::Parquet, Format::Csv, Format::Bids] {
        let out = folder.path().join(format!("{format:?}"));
        let settings = settings(format, &out);
        let refused = session(&sealed, &settings, &mut |_| true);
        assert!(matches!(refused, Err(StudyError::Sealed { .. })));
        assert!(!out.exists());
        let told = exported(&cut, &settings);
        assert!(told.damage.unfinished && told.rows > 1000, "{told:?}");
    }
}

#[test]
fn of_two_files_that_are_one_session_the_first_is_taken_and_the_others_go_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let below = folder.path().join("below");
    fs::create_dir(&below).expect("made");
    let broken = folder.path().join("broken.mcap");
    fs::write(&broken, "no session").expect("written");
    let files = [
        recorded(folder.path(), "a.mcap", Some("P07"), 20),
        broken,
        recorded(&below, "a.mcap", Some("P07"), 20),
        recorded(&below, "b.mcap", Some("P07"), 20),
    ];
    let settings = settings(Format::Parquet, &folder.path().join("out"));
    let mut told = Vec::new();
    let mut each = |i, result: Result<Exported, StudyError>| {
        told.push((i, result.map_err(|e| e.to_string()).err()));
    };
    cohort(&files, 3, &settings, &mut |_| true, &mut each).expect("not stopped");
    assert_eq!((told[0].clone(), told[3].clone()), ((0, None), (3, None)));
    let error = |i: usize| told[i].1.clone().expect("an error");
    assert!(error(1).contains("broken.mcap"));
    assert!(error(2).contains("the same session as"), "{}", error(2));
}

#[test]
fn a_bids_sample_has_a_value_for_each_channel() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = recorded(folder.path(), "run.mcap", Some("P-07"), 100);
    let out = folder.path().join("bids");
    let settings = settings(Format::Bids, &out);
    assert_eq!(exported(&path, &settings).rows, 100);
    finish(&settings).expect("finished");
    let files = tree(&out);
    let of = |ending: &str| {
        let found = files.iter().find(|(name, _)| name.ends_with(ending));
        let (_, bytes) = found.unwrap_or_else(|| panic!("{ending} in {:?}", files.keys()));
        String::from_utf8(bytes.clone()).expect("UTF-8")
    };
    let channels = of("_channels.tsv");
    let samples = of("_motion.tsv");
    let n = channels.lines().count() - 1;
    assert_eq!((n, samples.lines().count()), (1 + 2 * 18, 100));
    assert!(samples.lines().all(|l| l.split('\t').count() == n));
    assert!(samples.starts_with("0\t0.0\t") && samples.contains("\n0.099\t"));
    let sidecar: serde_json::Value = serde_json::from_str(&of("_motion.json")).expect("JSON");
    assert_eq!(sidecar["MotionChannelCount"], n);
    assert_eq!(sidecar["TrackedPointsCount"], 4);
    assert_eq!(sidecar["SamplingFrequency"], 1000.0);
    let events = of("_events.tsv");
    assert_eq!(
        events.lines().nth(1),
        Some("0.01\t0\tmark\t15\there, \"this\" one")
    );
    let people = of("participants.tsv");
    let label = Key::new(Some("P-07"), "", "").bids_subject();
    assert_eq!(
        people,
        format!("participant_id\tpseudonym\nsub-{label}\tP-07\n")
    );
}
