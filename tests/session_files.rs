//! Session files: what is written is what is read, by us, by the schema in the file and by Python.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/sessions.rs"]
mod sessions;

use dorsum::contact::{Contact, Touch};
use dorsum::device::Reading;
use dorsum::geom::Vec3;
use dorsum::servo::{FingerRecord, LimitFlags};
use dorsum::session::format::{self, FIELDS, Value};
use dorsum::session::{Entry, Event, IfExists, Session, SessionError, SessionWriter, Strictness};
use proptest::prelude::*;
use prost_reflect::{DescriptorPool, DynamicMessage, Value as Reflected};
use sessions::{header, load, run, temporary, write};
use std::path::Path;

/// Any bits but NaN, which never occurs.
fn double() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>()
            .prop_map(f64::from_bits)
            .prop_filter("NaN never occurs", |v| !v.is_nan()),
        prop::sample::select(vec![
            0.0,
            -0.0,
            f64::MIN_POSITIVE / 4.0,
            f64::MAX,
            f64::NEG_INFINITY
        ]),
    ]
}

fn vec3() -> impl Strategy<Value = Vec3> {
    [double(), double(), double()].prop_map(Vec3::from)
}

fn record() -> impl Strategy<Value = FingerRecord> {
    let touch = prop::sample::select(vec![
        Touch::Free,
        Touch::Frictionless,
        Touch::Stick,
        Touch::Slip,
    ]);
    let reading = (vec3(), vec3(), any::<u32>(), any::<bool>());
    let points = (vec3(), vec3(), vec3(), vec3(), vec3());
    let numbers = (double(), double(), any::<u32>(), any::<u32>(), any::<u64>());
    let rest = (any::<bool>(), any::<bool>(), 0.0f32..1.0e9, any::<bool>());
    (touch, reading, points, numbers, rest).prop_map(|(touch, r, p, n, rest)| FingerRecord {
        tick: 0,
        finger: 0,
        time_ns: n.4,
        reading: Reading {
            position_mm: r.0,
            velocity_mm_s: r.1,
            buttons: r.2,
            connected: r.3,
        },
        late: rest.0,
        force_enabled: rest.1,
        placed_anew: rest.3,
        edit: n.3 ^ n.2,
        fade: n.0,
        contact: Contact {
            touch,
            triangle: n.2,
            behind: n.2 % 2 == 1,
            anchor_mm: p.0,
            foot_mm: p.1,
            normal: p.2,
            depth_mm: n.0,
            stiffness_n_per_mm: n.1,
            felt_depth_mm: n.1,
            credit_mj: n.0,
            force_n: p.3,
        },
        sent_force_n: p.4,
        limits: LimitFlags(n.3),
        passivity_energy_n_mm: n.1,
        duration_us: rest.2,
    })
}

/// Every field of both by its bits.
fn assert_same(a: &FingerRecord, b: &FingerRecord) {
    for field in FIELDS {
        assert_eq!(bits((field.get)(a)), bits((field.get)(b)), "{}", field.name);
    }
    assert!(a.same_outcome(b));
}

fn bits(value: Value) -> Vec<u64> {
    match value {
        Value::Vec3(v) => v.to_array().map(f64::to_bits).to_vec(),
        Value::F64(v) => vec![v.to_bits()],
        Value::F32(v) => vec![v.to_bits().into()],
        Value::U64(v) => vec![v],
        Value::U32(v) => vec![v.into()],
        Value::Bool(v) => vec![v.into()],
        Value::Touch(v) => vec![v as u64],
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_record_is_read_as_it_was_written(records in prop::collection::vec(record(), 2..40)) {
        let (_folder, path) = temporary();
        let n = records.len() as u64;
        // Ticks and times increase; all else is anything.
        let numbered = |(i, r): (usize, &FingerRecord)| FingerRecord {
            tick: u64::MAX - n + i as u64,
            time_ns: r.time_ns / 2,
            ..*r
        };
        let records: Vec<_> = records.iter().enumerate().map(numbered).collect();
        write(&path, 1, &records);
        let read = load(&path, Strictness::Strict).unwrap();
        prop_assert_eq!(read.fingers[0].len(), records.len());
        for (a, b) in records.iter().zip(&read.fingers[0]) {
            assert_same(a, b);
        }
    }

    #[test]
    fn the_schema_in_the_file_says_what_the_messages_hold(record in record(), finger in 0u8..4) {
        let record = FingerRecord { finger, tick: record.time_ns ^ 1, ..record };
        let pool = DescriptorPool::decode(format::file_descriptor_set().as_slice()).unwrap();
        let schema = pool.get_message_by_name(format::TICK_SCHEMA).unwrap();
        let mut message = Vec::new();
        format::encode_tick(&record, &mut message);
        let message = DynamicMessage::decode(schema.clone(), message.as_slice()).unwrap();
        prop_assert_eq!(message.unknown_fields().count(), 0);
        prop_assert_eq!(schema.fields().count(), FIELDS.len());
        for field in FIELDS {
            prop_assert!(message.has_field_by_name(field.name), "{} is absent", field.name);
            let number = schema.get_field_by_name(field.name).unwrap().number();
            prop_assert_eq!(number, field.number as u32);
            let reflected = message.get_field_by_name(field.name).unwrap();
            prop_assert_eq!(reflected_bits(&reflected), bits((field.get)(&record)), "{}", field.name);
        }
    }
}

fn reflected_bits(value: &Reflected) -> Vec<u64> {
    match value {
        Reflected::Message(v) => ["x", "y", "z"]
            .iter()
            .flat_map(|axis| reflected_bits(&v.get_field_by_name(axis).unwrap()))
            .collect(),
        Reflected::F64(v) => vec![v.to_bits()],
        Reflected::F32(v) => vec![v.to_bits().into()],
        Reflected::U64(v) => vec![*v],
        Reflected::U32(v) => vec![(*v).into()],
        Reflected::Bool(v) => vec![(*v).into()],
        Reflected::EnumNumber(v) => vec![*v as u64],
        other => panic!("unexpected {other:?}"),
    }
}

#[test]
fn the_event_schema_says_what_events_hold() {
    let event = Event {
        tick: 0,
        time_ns: u64::MAX,
        kind: "mark".into(),
        text: "here, größer".into(),
    };
    let pool = DescriptorPool::decode(format::file_descriptor_set().as_slice()).unwrap();
    let schema = pool.get_message_by_name(format::EVENT_SCHEMA).unwrap();
    let bytes = format::encode_event(&event);
    let message = DynamicMessage::decode(schema, bytes.as_slice()).unwrap();
    assert_eq!(message.unknown_fields().count(), 0);
    let get = |name: &str| message.get_field_by_name(name).unwrap().into_owned();
    assert_eq!(get("tick"), Reflected::U64(event.tick));
    assert_eq!(get("time_ns"), Reflected::U64(event.time_ns));
    assert_eq!(get("kind"), Reflected::String(event.kind.clone()));
    assert_eq!(get("text"), Reflected::String(event.text.clone()));
    assert_eq!(format::decode_event(&bytes).unwrap(), event);
}

#[test]
fn header_fingers_and_events_come_back_whole() {
    let (_folder, path) = temporary();
    let records = run(3000, 2);
    write(&path, 2, &records);
    let session = Session::open(&path).unwrap();
    assert_eq!(*session.header(), header(2));
    let read = session.load(Strictness::Strict).unwrap();
    assert!(read.damage.is_none());
    assert_eq!(
        (
            read.fingers.len(),
            read.fingers[0].len(),
            read.fingers[1].len()
        ),
        (2, 3000, 3000)
    );
    for (i, expected) in records.iter().enumerate() {
        assert_same(expected, &read.fingers[i % 2][i / 2]);
    }
    assert_eq!(read.events.len(), 1);
    assert_eq!(
        (read.events[0].kind.as_str(), read.events[0].tick),
        ("mark", 1500 + 7)
    );
    let ticks: Vec<_> = session
        .ticks(Strictness::Strict)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    assert_eq!(ticks.len(), 3000);
    assert_eq!(ticks[2999].fingers()[1], records[5999]);
}

#[test]
fn the_container_is_one_that_other_readers_index() {
    let (_folder, path) = temporary();
    write(&path, 2, &run(3000, 2));
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let stats = summary.stats.unwrap();
    assert_eq!(stats.message_count, 6001);
    assert_eq!((stats.attachment_count, stats.metadata_count), (2, 3));
    let topics: Vec<_> = summary
        .channels
        .values()
        .map(|c| c.topic.as_str())
        .collect();
    assert!(
        ["/finger/0", "/finger/1", "/events"]
            .iter()
            .all(|t| topics.contains(t))
    );
    let start = humantime::parse_rfc3339("2031-05-17T09:30:00Z").unwrap();
    let start = start
        .duration_since(std::time::UNIX_EPOCH)
        .unwrap()
        .as_nanos() as u64;
    assert_eq!(stats.message_start_time, start);
    assert_eq!(stats.message_end_time, start + 2_999_000_000);
    let largest = summary
        .chunk_indexes
        .iter()
        .map(|c| c.uncompressed_size)
        .max()
        .unwrap();
    assert!(largest < 300_000, "{largest}");
    assert!(
        summary
            .chunk_indexes
            .iter()
            .all(|c| c.compression.is_empty())
    );
}

#[test]
fn an_existing_file_is_not_overwritten_unless_told() {
    let (_folder, path) = temporary();
    write(&path, 1, &run(3, 1));
    let before = std::fs::read(&path).unwrap();
    let refused = SessionWriter::create(&path, &header(1), IfExists::Refuse);
    assert!(matches!(refused, Err(SessionError::Io { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), before);
    let replacing = SessionWriter::create(&path, &header(1), IfExists::Replace).unwrap();
    replacing.finish().unwrap();
    assert_eq!(load(&path, Strictness::Strict).unwrap().fingers[0].len(), 0);
}

#[test]
fn lost_ticks_are_counted_and_told_where() {
    let (_folder, path) = temporary();
    let mut records = run(100, 2);
    records.retain(|r| !(30..35).contains(&r.tick) && (r.tick, r.finger) != (60, 1));
    let mut writer = SessionWriter::create(&path, &header(2), IfExists::Refuse).unwrap();
    records.iter().for_each(|r| writer.write(r).unwrap());
    let summary = writer.finish().unwrap();
    assert_eq!((summary.lost, summary.ticks), (11, 95));
    let read = load(&path, Strictness::Strict).unwrap();
    let lost: Vec<_> = read
        .events
        .iter()
        .map(|e| (e.kind.as_str(), e.text.as_str()))
        .collect();
    assert_eq!(
        lost,
        [
            ("lost", "5 of finger 0 before tick 35"),
            ("lost", "5 of finger 1 before tick 35"),
            ("lost", "1 of finger 1 before tick 61"),
        ]
    );
    let session = Session::open(&path).unwrap();
    let mut ticks = session.ticks(Strictness::Strict).unwrap();
    assert_eq!(ticks.by_ref().count(), 94);
    assert_eq!(ticks.incomplete(), 1);
}

#[test]
fn a_restarted_servo_goes_on_behind_a_gap() {
    let (_folder, path) = temporary();
    let mut writer = SessionWriter::create(&path, &header(2), IfExists::Refuse).unwrap();
    run(50, 2).iter().for_each(|r| writer.write(r).unwrap());
    writer.restarted();
    run(50, 2).iter().for_each(|r| writer.write(r).unwrap());
    // Unannounced, and starting at finger 0 of tick 7 again.
    run(50, 2).iter().for_each(|r| writer.write(r).unwrap());
    assert_eq!(writer.finish().unwrap().lost, 0);
    let read = load(&path, Strictness::Strict).unwrap();
    for finger in &read.fingers {
        assert_eq!(finger.len(), 150);
        let steps = finger.windows(2).map(|w| w[1].tick - w[0].tick);
        assert_eq!(steps.filter(|s| *s == 2).count(), 2);
        assert!(finger.windows(2).all(|w| w[1].time_ns > w[0].time_ns));
    }
    let kinds: Vec<_> = read.events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds, ["restart", "restart"]);
}

#[test]
fn a_recording_starts_with_a_whole_tick() {
    let (_folder, path) = temporary();
    let mut writer = SessionWriter::create(&path, &header(2), IfExists::Refuse).unwrap();
    run(10, 2)[1..]
        .iter()
        .for_each(|r| writer.write(r).unwrap());
    assert_eq!(writer.finish().unwrap().lost, 0);
    let read = load(&path, Strictness::Strict).unwrap();
    assert_eq!((read.fingers[0][0].tick, read.fingers[1][0].tick), (8, 8));
}

#[test]
fn entries_stream_in_the_order_written() {
    let (_folder, path) = temporary();
    write(&path, 1, &run(5, 1));
    let session = Session::open(&path).unwrap();
    let entries = session.entries(Strictness::Strict).unwrap();
    let kinds = entries
        .map(|e| matches!(e.unwrap(), Entry::Tick(_)))
        .collect::<Vec<_>>();
    assert_eq!(kinds, [true, true, true, false, true, true]);
}

/// `DORSUM_PYTHON` names an interpreter that has `mcap` and `mcap-protobuf-support`; `tests/run.sh` sets it.
#[test]
fn python_reads_the_same_values() {
    let Some(python) = std::env::var_os("DORSUM_PYTHON") else {
        eprintln!("skipped: DORSUM_PYTHON is not set (tests/run.sh sets it)");
        return;
    };
    let (_folder, path) = temporary();
    let records = run(500, 2);
    write(&path, 2, &records);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/read_session.py");
    let output = std::process::Command::new(python)
        .arg(script)
        .arg(&path)
        .output()
        .unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{error}");
    let read: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(read["profile"], "dorsum");
    assert_eq!(read["metadata"]["participant"], "P07");
    assert_eq!(read["scenario"], header(2).scenario_toml);
    assert_eq!(read["events"][0]["text"], "halfway");
    for (i, expected) in records.iter().enumerate() {
        let message = &read["fingers"][i % 2][i / 2];
        for field in FIELDS {
            let value = &message[field.name];
            let expected = (field.get)(expected);
            match expected {
                Value::Vec3(v) => {
                    let read = ["x", "y", "z"].map(|axis| value[axis].as_f64().unwrap());
                    assert_eq!(
                        bits(Value::Vec3(read.into())),
                        bits(expected),
                        "{}",
                        field.name
                    );
                    assert_eq!(read, v.to_array());
                }
                Value::F64(v) => assert_eq!(value.as_f64(), Some(v)),
                Value::F32(v) => assert_eq!(value.as_f64(), Some(v.into())),
                Value::U64(v) => assert_eq!(value.as_u64(), Some(v)),
                Value::U32(v) => assert_eq!(value.as_u64(), Some(v.into())),
                Value::Bool(v) => assert_eq!(value.as_bool(), Some(v)),
                Value::Touch(v) => assert_eq!(value, format::touch_name(v)),
            }
        }
    }
}
