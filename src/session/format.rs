//! The layout of a session file.
//!
//! # Container
//! A session is an [MCAP](https://mcap.dev/spec) file, profile `dorsum`, with chunks of about 256 KiB, uncompressed while it is
//! recorded; a finished one may be compressed with zstd ([`compress`](super::compress)). Every chunk carries a CRC. While a recording runs, a chunk is closed and handed to the system at least twice a second. A file
//! whose recording was killed has no summary at its end; all its closed chunks can be read.
//!
//! ```text
//! magic, header
//! metadata "dorsum.host"         facts of the machine (below)
//! metadata "dorsum.calibration"  how the devices were calibrated, where they say so
//! attachment "mesh"              the mesh file, whole, of a surface that is not built in
//! metadata "dorsum"              what the run was (below)
//! attachment "scenario.toml"     the scenario file, whole
//! chunk                          schemas and channels, no messages
//! metadata "dorsum", attachment "scenario.toml"      again, for when the first are damaged; not in older files
//! chunk …                        messages, each chunk followed by its message indexes
//! data end (CRC), summary (schemas, channels, statistics, chunk, attachment and metadata indexes), footer (CRC), magic
//! ```
//!
//! A session holds one surface: whoever opens another scene finishes the file and begins another. The maps of the scene may
//! be edited while it runs, see *Edits*.
//!
//! # Channels
//! | topic | id | schema | one message per |
//! |---|---|---|---|
//! | `/finger/0` … `/finger/3` | 1 … 4 | `dorsum.FingerTick` | tick |
//! | `/events` | 100 | `dorsum.Event` | event |
//! | `/edits` | 101 | `dorsum.Edit` | edit of the scene |
//!
//! Ids are fixed, so that a file with a damaged first chunk can still be read. Messages are protobuf (proto2); each schema
//! record holds the whole `FileDescriptorSet`. Every field is written every time, zeros too: `double` fields keep their
//! bits, the sign of zero included.
//!
//! # Time
//! `log_time` and `publish_time` are UTC in nanoseconds: the start (`started_utc`) plus the time since the first recorded
//! tick. `sequence` is the low 32 bits of the tick number. `time_ns` inside the messages is the monotonic clock of the
//! servo; replay uses tick numbers only.
//!
//! # `dorsum.FingerTick`
//! Lengths in mm, forces in N, frame of the subject: x right, y to the head, z out of the back. A message holds the inputs
//! of a tick, its outcome and thereby the state that the next tick starts from: every message is a restart point.
//!
//! | no. | field | type | role | meaning |
//! |---|---|---|---|---|
//! | 1 | `tick` | uint64 | key | Tick number; strictly increasing, a gap is a lost tick or a restarted servo |
//! | 2 | `finger` | uint32 | key | Finger, from 0 |
//! | 3 | `time_ns` | uint64 | measured | Monotonic time, ns |
//! | 4 | `position_mm` | Vec3 | input | HIP, mm |
//! | 5 | `velocity_mm_s` | Vec3 | input | Velocity of the HIP, mm/s |
//! | 6 | `buttons` | uint32 | input | Pressed buttons, bit by bit |
//! | 7 | `connected` | bool | input | The device answered |
//! | 8 | `late` | bool | input | The tick came later than the watchdog allows |
//! | 9 | `force_enabled` | bool | input | Force output was wanted |
//! | 10 | `placed_anew` | bool | input | The proxy was placed anew: another device or another scene |
//! | 11 | `touch` | Touch | outcome | FREE, FRICTIONLESS, STICK or SLIP |
//! | 12 | `triangle` | uint32 | outcome | Triangle the proxy is on; 0 when free |
//! | 13 | `anchor_mm` | Vec3 | outcome | Proxy, mm |
//! | 14 | `foot_mm` | Vec3 | outcome | Foot of the HIP on the tangent plane, mm |
//! | 15 | `normal` | Vec3 | outcome | Outward unit normal; zero when free |
//! | 16 | `depth_mm` | double | outcome | Penetration depth, mm |
//! | 17 | `stiffness_n_per_mm` | double | outcome | Stiffness at the proxy, N/mm |
//! | 18 | `force_n` | Vec3 | outcome | Force before any limit, N |
//! | 19 | `sent_force_n` | Vec3 | outcome | Force sent to the device, N |
//! | 20 | `limits` | uint32 | outcome | Limits that acted: 1 not finite, 2 rated, 4 rise, 8 disabled, 16 late, 32 disconnected, 64 passivity controller, 128 skin rendered softer than it is |
//! | 21 | `duration_us` | float | measured | Duration of the whole tick, µs |
//! | 22 | `behind` | bool | outcome | The proxy is on the back of its triangle; absent in older files, where it never is |
//! | 23 | `felt_depth_mm` | double | outcome | Depth the force answers to, mm; where absent, `depth_mm` |
//! | 24 | `credit_mj` | double | outcome | Balance of force shading, mJ; where absent, 0 |
//! | 25 | `edit` | uint32 | input | Number of the edit that made the scene what it is; where absent, 0 |
//! | 26 | `fade` | double | outcome | Share of that edit that is felt, 0 to 1; where absent, 1 |
//! | 27 | `passivity_energy_n_mm` | double | outcome | With the passivity controller 0, or below it what the skin has given out beyond what was put in, N·mm; where absent, 0 |
//!
//! Numbers from 32 on are free for later fields; readers skip what they do not know.
//!
//! # `dorsum.Event`
//! `tick` (1, uint64), `time_ns` (2, uint64), `kind` (3, string), `text` (4, string). Kinds the recorder writes itself:
//! `lost` (ticks that never reached it), `restart` (the servo was started anew, or a recording that was held went on; tick
//! numbers go on after a gap), `fault` (a device stops or begins again to answer, a tick comes later than the watchdog allows,
//! a force was not finite: told at the onset, not more than once in 1000 ticks, with the number left out) and `pop` (a finger
//! that was pressed in loses the skin without having come out; told as seldom). All others come from the program or the user,
//! such as `mark`. `recovered` stands at the end of a file that was saved from a damaged one.
//!
//! # Edits
//! An edit is the whole text of the scenario as edited. `dorsum.Edit`: `number` (1, uint32), `tick` (2, uint64) and `time_ns`
//! (3, uint64) of the newest tick when it was handed to the servo, `scenario` (4, string). Edits are numbered one by one; the
//! attached scenario is that of the number in the metadata. An edit stands before the first tick that feels it, so that a
//! killed recording has the text of every edit that its ticks name.
//!
//! From edit n − 1 to edit n the stiffness of the scene goes over in shares: a tick with `edit` = n and `fade` = s feels
//! (1 − s) of the stiffness before and s of the new one, at each place. The tick chooses s, by rules that depend on nothing
//! but its state and inputs; s grows to 1 before edit n + 1 begins. A tick with `fade` below 1 so is a restart point for
//! whoever has the texts of both edits. An edit changes no surface, friction, force model or engine.
//!
//! # Sealed sessions
//! A trial whose scene is hidden from the trainee is recorded sealed: metadata and attachment at the start hold the scene as the
//! trainee sees it, and `sealed` = `on`. Once the trial is answered, both are written a second time behind the ticks, for the
//! scene that was felt and without `sealed`; a reader takes the last. A session that stayed sealed can be read, but not
//! repeated.
//!
//! # Metadata `dorsum`
//! `format` = `1`, `scenario_name`, `mesh_hash` (SHA-256, hexadecimal), `mesh_origin`, `mesh_triangles`, `rate_hz` (the time
//! step is its reciprocal), `build`, `started_utc`, `participant` (a pseudonym; absent when none), `fingers` (their number),
//! `edit` (the number of the edit that the attached scenario is; absent: 0), `sealed` (absent: `off`), and for each finger `finger.N.device`,
//! `finger.N.rated_force_n`, `finger.N.rise_n_per_s`, `finger.N.passivity` (`on` with the passivity controller; absent: off), and
//! where the skin was rendered softer than it is either `finger.N.stiffness_scale` (what every force of contact was multiplied by,
//! above 0, at most 1) or `finger.N.stiffness_clamp_n_per_mm` (the steepest slope of force over depth, above 0); neither: as stiff as
//! the scene has it. `contact` fields of a tick are those of the scene all the same; `sent_force_n` is what was rendered. `checksum` is the
//! CRC-32, hexadecimal, of all other entries in the order of their keys, each key and value with a zero byte behind (absent in older
//! files). Numbers are written so that they read back to the same bits.
//!
//! # Other metadata
//! `dorsum.host`: `clock` that `time_ns` is read from, `clock_step_ns` its least step seen, `os`, `arch`, `cores`.
//! `dorsum.calibration`: `finger.N.calibration`, in the device's own words. `dorsum.recovered`, in a file saved from a damaged one:
//! `file`, `recovered_utc`, `build`, what was skipped (`chunks`, `messages`, `bytes`, `unfinished`, `first`) and for each finger
//! what its tick numbers lack (`finger.N.missing`, `finger.N.gaps`).
//!
//! # Orientation
//! Devices with three degrees of freedom have none, and no field is written for it; a device that tells one gets a field of its own.

use crate::contact::{Contact, Touch};
use crate::device::Reading;
use crate::geom::Vec3;
use crate::servo::{FingerRecord, LimitFlags};
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet,
};
use std::sync::Arc;

/// Version of the layout.
pub const FORMAT: u32 = 1;
/// MCAP profile.
pub const PROFILE: &str = "dorsum";
/// Name of the metadata record.
pub const METADATA: &str = "dorsum";
/// Name of the attachment that holds the scenario.
pub const SCENARIO: &str = "scenario.toml";
/// Name of the attachment that holds the mesh file of a surface that is not built in.
pub const MESH: &str = "mesh";
/// Name of the metadata that hold facts of the machine.
pub const HOST_METADATA: &str = "dorsum.host";
/// Name of the metadata that hold the calibrations of the devices.
pub const CALIBRATION_METADATA: &str = "dorsum.calibration";
/// Name of the metadata that say what is missing since the file was saved from a damaged one.
pub const RECOVERED_METADATA: &str = "dorsum.recovered";
/// Kind of the event that says so.
pub const RECOVERED: &str = "recovered";
/// Kind of the events that tell of a fault.
pub const FAULT: &str = "fault";
/// Kind of the events that tell of a pop.
pub const POP: &str = "pop";
/// Topic of the events.
pub const EVENTS_TOPIC: &str = "/events";
/// Channel of the events.
pub const EVENTS_CHANNEL: u16 = 100;
/// Topic of the edits.
pub const EDITS_TOPIC: &str = "/edits";
/// Channel of the edits.
pub const EDITS_CHANNEL: u16 = 101;
/// Schema of a finger's ticks.
pub const TICK_SCHEMA: &str = "dorsum.FingerTick";
/// Schema of an event.
pub const EVENT_SCHEMA: &str = "dorsum.Event";
/// Schema of an edit.
pub const EDIT_SCHEMA: &str = "dorsum.Edit";

/// Topic of a finger's ticks.
pub fn finger_topic(finger: usize) -> String {
    format!("/finger/{finger}")
}

/// Channel of a finger's ticks.
pub fn finger_channel(finger: u8) -> u16 {
    u16::from(finger) + 1
}

/// What happened at a tick.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Event {
    /// Tick it happened at: the newest one when it was reported.
    pub tick: u64,
    /// Monotonic time of that tick, ns.
    pub time_ns: u64,
    /// What sort of event, one word.
    pub kind: String,
    /// What it says.
    pub text: String,
}

/// An edit of the scene while it was felt.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edit {
    /// Its number, as [`FingerRecord::edit`] names it.
    pub number: u32,
    /// The newest tick when it was handed to the servo.
    pub tick: u64,
    /// Monotonic time of that tick, ns.
    pub time_ns: u64,
    /// The scenario as edited, whole.
    pub scenario_toml: Arc<str>,
}

/// What a field of a tick is to a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Names the record.
    Key,
    /// Given to the tick from outside.
    Input,
    /// Follows from inputs and earlier state.
    Outcome,
    /// Measured beside the run; never the same twice.
    Measured,
}

/// One field's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// Three doubles.
    Vec3(Vec3),
    /// A double.
    F64(f64),
    /// A float.
    F32(f32),
    /// uint64.
    U64(u64),
    /// uint32.
    U32(u32),
    /// bool.
    Bool(bool),
    /// How the proxy meets the surface.
    Touch(Touch),
}

/// One field of `dorsum.FingerTick`.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Field number.
    pub number: i32,
    /// Name in file, tables and messages; tells the unit.
    pub name: &'static str,
    /// What it is to a replay.
    pub role: Role,
    /// Reads it from a record.
    pub get: fn(&FingerRecord) -> Value,
}

const fn field(
    number: i32,
    name: &'static str,
    role: Role,
    get: fn(&FingerRecord) -> Value,
) -> Field {
    Field {
        number,
        name,
        role,
        get,
    }
}

/// The fields of `dorsum.FingerTick`, the one table that schema, comparison and tables are made from.
pub static FIELDS: &[Field] = &[
    field(1, "tick", Role::Key, |r| Value::U64(r.tick)),
    field(2, "finger", Role::Key, |r| Value::U32(r.finger.into())),
    field(3, "time_ns", Role::Measured, |r| Value::U64(r.time_ns)),
    field(4, "position_mm", Role::Input, |r| {
        Value::Vec3(r.reading.position_mm)
    }),
    field(5, "velocity_mm_s", Role::Input, |r| {
        Value::Vec3(r.reading.velocity_mm_s)
    }),
    field(6, "buttons", Role::Input, |r| Value::U32(r.reading.buttons)),
    field(7, "connected", Role::Input, |r| {
        Value::Bool(r.reading.connected)
    }),
    field(8, "late", Role::Input, |r| Value::Bool(r.late)),
    field(9, "force_enabled", Role::Input, |r| {
        Value::Bool(r.force_enabled)
    }),
    field(10, "placed_anew", Role::Input, |r| {
        Value::Bool(r.placed_anew)
    }),
    field(11, "touch", Role::Outcome, |r| {
        Value::Touch(r.contact.touch)
    }),
    field(12, "triangle", Role::Outcome, |r| {
        Value::U32(r.contact.triangle)
    }),
    field(13, "anchor_mm", Role::Outcome, |r| {
        Value::Vec3(r.contact.anchor_mm)
    }),
    field(14, "foot_mm", Role::Outcome, |r| {
        Value::Vec3(r.contact.foot_mm)
    }),
    field(15, "normal", Role::Outcome, |r| {
        Value::Vec3(r.contact.normal)
    }),
    field(16, "depth_mm", Role::Outcome, |r| {
        Value::F64(r.contact.depth_mm)
    }),
    field(17, "stiffness_n_per_mm", Role::Outcome, |r| {
        Value::F64(r.contact.stiffness_n_per_mm)
    }),
    field(18, "force_n", Role::Outcome, |r| {
        Value::Vec3(r.contact.force_n)
    }),
    field(19, "sent_force_n", Role::Outcome, |r| {
        Value::Vec3(r.sent_force_n)
    }),
    field(20, "limits", Role::Outcome, |r| Value::U32(r.limits.0)),
    field(21, "duration_us", Role::Measured, |r| {
        Value::F32(r.duration_us)
    }),
    field(22, "behind", Role::Outcome, |r| {
        Value::Bool(r.contact.behind)
    }),
    field(23, "felt_depth_mm", Role::Outcome, |r| {
        Value::F64(r.contact.felt_depth_mm)
    }),
    field(24, "credit_mj", Role::Outcome, |r| {
        Value::F64(r.contact.credit_mj)
    }),
    field(25, "edit", Role::Input, |r| Value::U32(r.edit)),
    field(26, "fade", Role::Outcome, |r| Value::F64(r.fade)),
    field(27, "passivity_energy_n_mm", Role::Outcome, |r| {
        Value::F64(r.passivity_energy_n_mm)
    }),
];

/// The fields of `dorsum.Event`.
const EVENT_FIELDS: [(i32, &str, Type); 4] = [
    (1, "tick", Type::Uint64),
    (2, "time_ns", Type::Uint64),
    (3, "kind", Type::String),
    (4, "text", Type::String),
];

/// The fields of `dorsum.Edit`.
const EDIT_FIELDS: [(i32, &str, Type); 4] = [
    (1, "number", Type::Uint32),
    (2, "tick", Type::Uint64),
    (3, "time_ns", Type::Uint64),
    (4, "scenario", Type::String),
];

const TOUCHES: [(Touch, &str); 4] = [
    (Touch::Free, "FREE"),
    (Touch::Frictionless, "FRICTIONLESS"),
    (Touch::Stick, "STICK"),
    (Touch::Slip, "SLIP"),
];

/// How the proxy meets the surface, as files and tables name it.
pub fn touch_name(touch: Touch) -> &'static str {
    TOUCHES[touch as usize].1
}

/// The schema of all messages: a serialised `FileDescriptorSet`, the same for every channel.
pub fn file_descriptor_set() -> Vec<u8> {
    let blank = FingerRecord::default();
    let tick_fields = FIELDS.iter().map(|f| match (f.get)(&blank) {
        Value::Vec3(_) => described(f.number, f.name, Type::Message, Some(".dorsum.Vec3")),
        Value::Touch(_) => described(f.number, f.name, Type::Enum, Some(".dorsum.Touch")),
        Value::F64(_) => described(f.number, f.name, Type::Double, None),
        Value::F32(_) => described(f.number, f.name, Type::Float, None),
        Value::U64(_) => described(f.number, f.name, Type::Uint64, None),
        Value::U32(_) => described(f.number, f.name, Type::Uint32, None),
        Value::Bool(_) => described(f.number, f.name, Type::Bool, None),
    });
    let axes = ["x", "y", "z"].into_iter().zip(1..);
    let axes = axes.map(|(axis, number)| described(number, axis, Type::Double, None));
    let plain = |fields: [(i32, &str, Type); 4]| {
        let fields = fields.into_iter();
        fields
            .map(|(number, name, kind)| described(number, name, kind, None))
            .collect()
    };
    let touch = EnumDescriptorProto {
        name: Some("Touch".into()),
        value: TOUCHES
            .into_iter()
            .map(|(touch, name)| EnumValueDescriptorProto {
                name: Some(name.into()),
                number: Some(touch as i32),
                options: None,
            })
            .collect(),
        ..EnumDescriptorProto::default()
    };
    let file = FileDescriptorProto {
        name: Some("dorsum.proto".into()),
        package: Some("dorsum".into()),
        message_type: vec![
            message("Vec3", axes.collect()),
            message("FingerTick", tick_fields.collect()),
            message("Event", plain(EVENT_FIELDS)),
            message("Edit", plain(EDIT_FIELDS)),
        ],
        enum_type: vec![touch],
        syntax: Some("proto2".into()),
        ..FileDescriptorProto::default()
    };
    FileDescriptorSet { file: vec![file] }.encode_to_vec()
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto {
        name: Some(name.into()),
        field,
        ..DescriptorProto::default()
    }
}

fn described(number: i32, name: &str, kind: Type, type_name: Option<&str>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: type_name.map(str::to_owned),
        ..FieldDescriptorProto::default()
    }
}

// `required` makes prost write a field whatever its value: a plain proto3 field would drop zeros and turn -0 into 0.

#[derive(Clone, Copy, PartialEq, Message)]
struct Vec3Message {
    #[prost(double, required, tag = "1")]
    x: f64,
    #[prost(double, required, tag = "2")]
    y: f64,
    #[prost(double, required, tag = "3")]
    z: f64,
}

#[derive(Clone, Copy, PartialEq, Message)]
struct FingerTickMessage {
    #[prost(uint64, required, tag = "1")]
    tick: u64,
    #[prost(uint32, required, tag = "2")]
    finger: u32,
    #[prost(uint64, required, tag = "3")]
    time_ns: u64,
    #[prost(message, required, tag = "4")]
    position_mm: Vec3Message,
    #[prost(message, required, tag = "5")]
    velocity_mm_s: Vec3Message,
    #[prost(uint32, required, tag = "6")]
    buttons: u32,
    #[prost(bool, required, tag = "7")]
    connected: bool,
    #[prost(bool, required, tag = "8")]
    late: bool,
    #[prost(bool, required, tag = "9")]
    force_enabled: bool,
    #[prost(bool, required, tag = "10")]
    placed_anew: bool,
    #[prost(int32, required, tag = "11")]
    touch: i32,
    #[prost(uint32, required, tag = "12")]
    triangle: u32,
    #[prost(message, required, tag = "13")]
    anchor_mm: Vec3Message,
    #[prost(message, required, tag = "14")]
    foot_mm: Vec3Message,
    #[prost(message, required, tag = "15")]
    normal: Vec3Message,
    #[prost(double, required, tag = "16")]
    depth_mm: f64,
    #[prost(double, required, tag = "17")]
    stiffness_n_per_mm: f64,
    #[prost(message, required, tag = "18")]
    force_n: Vec3Message,
    #[prost(message, required, tag = "19")]
    sent_force_n: Vec3Message,
    #[prost(uint32, required, tag = "20")]
    limits: u32,
    #[prost(float, required, tag = "21")]
    duration_us: f32,
    #[prost(bool, optional, tag = "22")]
    behind: Option<bool>,
    #[prost(double, optional, tag = "23")]
    felt_depth_mm: Option<f64>,
    #[prost(double, optional, tag = "24")]
    credit_mj: Option<f64>,
    #[prost(uint32, optional, tag = "25")]
    edit: Option<u32>,
    #[prost(double, optional, tag = "26")]
    fade: Option<f64>,
    #[prost(double, optional, tag = "27")]
    passivity_energy_n_mm: Option<f64>,
}

#[derive(Clone, PartialEq, Message)]
struct EventMessage {
    #[prost(uint64, required, tag = "1")]
    tick: u64,
    #[prost(uint64, required, tag = "2")]
    time_ns: u64,
    #[prost(string, required, tag = "3")]
    kind: String,
    #[prost(string, required, tag = "4")]
    text: String,
}

#[derive(Clone, PartialEq, Message)]
struct EditMessage {
    #[prost(uint32, required, tag = "1")]
    number: u32,
    #[prost(uint64, required, tag = "2")]
    tick: u64,
    #[prost(uint64, required, tag = "3")]
    time_ns: u64,
    #[prost(string, required, tag = "4")]
    scenario: String,
}

impl From<Vec3> for Vec3Message {
    fn from(v: Vec3) -> Self {
        let [x, y, z] = v.to_array();
        Self { x, y, z }
    }
}

impl From<Vec3Message> for Vec3 {
    fn from(v: Vec3Message) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

/// Replaces what is in `out` by the message of `record`.
pub fn encode_tick(record: &FingerRecord, out: &mut Vec<u8>) {
    let contact = &record.contact;
    let message = FingerTickMessage {
        tick: record.tick,
        finger: record.finger.into(),
        time_ns: record.time_ns,
        position_mm: record.reading.position_mm.into(),
        velocity_mm_s: record.reading.velocity_mm_s.into(),
        buttons: record.reading.buttons,
        connected: record.reading.connected,
        late: record.late,
        force_enabled: record.force_enabled,
        placed_anew: record.placed_anew,
        touch: contact.touch as i32,
        triangle: contact.triangle,
        anchor_mm: contact.anchor_mm.into(),
        foot_mm: contact.foot_mm.into(),
        normal: contact.normal.into(),
        depth_mm: contact.depth_mm,
        stiffness_n_per_mm: contact.stiffness_n_per_mm,
        force_n: contact.force_n.into(),
        sent_force_n: record.sent_force_n.into(),
        limits: record.limits.0,
        duration_us: record.duration_us,
        behind: Some(contact.behind),
        felt_depth_mm: Some(contact.felt_depth_mm),
        credit_mj: Some(contact.credit_mj),
        edit: Some(record.edit),
        fade: Some(record.fade),
        passivity_energy_n_mm: Some(record.passivity_energy_n_mm),
    };
    out.clear();
    // A Vec always has room.
    let _ = message.encode(out);
}

/// The record of a message. Fields that are absent are what the table says.
///
/// # Errors
/// What is wrong with the message.
pub fn decode_tick(data: &[u8]) -> Result<FingerRecord, String> {
    let m = FingerTickMessage::decode(data).map_err(|e| e.to_string())?;
    let touch = TOUCHES.iter().find(|(touch, _)| *touch as i32 == m.touch);
    let Some(&(touch, _)) = touch else {
        return Err(format!("touch is {}; allowed: 0 to 3", m.touch));
    };
    let Ok(finger) = u8::try_from(m.finger) else {
        return Err(format!("finger is {}; allowed: 0 to 3", m.finger));
    };
    Ok(FingerRecord {
        tick: m.tick,
        finger,
        time_ns: m.time_ns,
        reading: Reading {
            position_mm: m.position_mm.into(),
            velocity_mm_s: m.velocity_mm_s.into(),
            buttons: m.buttons,
            connected: m.connected,
        },
        late: m.late,
        force_enabled: m.force_enabled,
        placed_anew: m.placed_anew,
        edit: m.edit.unwrap_or(0),
        fade: m.fade.unwrap_or(1.0),
        contact: Contact {
            touch,
            triangle: m.triangle,
            behind: m.behind.unwrap_or(false),
            anchor_mm: m.anchor_mm.into(),
            foot_mm: m.foot_mm.into(),
            normal: m.normal.into(),
            depth_mm: m.depth_mm,
            stiffness_n_per_mm: m.stiffness_n_per_mm,
            felt_depth_mm: m.felt_depth_mm.unwrap_or(m.depth_mm),
            credit_mj: m.credit_mj.unwrap_or(0.0),
            force_n: m.force_n.into(),
        },
        sent_force_n: m.sent_force_n.into(),
        limits: LimitFlags(m.limits),
        passivity_energy_n_mm: m.passivity_energy_n_mm.unwrap_or(0.0),
        duration_us: m.duration_us,
    })
}

/// The message of an event.
pub fn encode_event(event: &Event) -> Vec<u8> {
    let message = EventMessage {
        tick: event.tick,
        time_ns: event.time_ns,
        kind: event.kind.clone(),
        text: event.text.clone(),
    };
    message.encode_to_vec()
}

/// The event of a message.
///
/// # Errors
/// What is wrong with the message.
pub fn decode_event(data: &[u8]) -> Result<Event, String> {
    let m = EventMessage::decode(data).map_err(|e| e.to_string())?;
    Ok(Event {
        tick: m.tick,
        time_ns: m.time_ns,
        kind: m.kind,
        text: m.text,
    })
}

/// The message of an edit.
pub fn encode_edit(edit: &Edit) -> Vec<u8> {
    let message = EditMessage {
        number: edit.number,
        tick: edit.tick,
        time_ns: edit.time_ns,
        scenario: edit.scenario_toml.to_string(),
    };
    message.encode_to_vec()
}

/// The edit of a message.
///
/// # Errors
/// What is wrong with the message.
pub fn decode_edit(data: &[u8]) -> Result<Edit, String> {
    let m = EditMessage::decode(data).map_err(|e| e.to_string())?;
    Ok(Edit {
        number: m.number,
        tick: m.tick,
        time_ns: m.time_ns,
        scenario_toml: m.scenario.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_written_layout_is_the_table() {
        let text = include_str!("format.rs");
        let blank = FingerRecord::default();
        for (field, number) in FIELDS.iter().zip(1..) {
            assert_eq!(field.number, number, "{}", field.name);
            let kind = match (field.get)(&blank) {
                Value::Vec3(_) => "Vec3",
                Value::F64(_) => "double",
                Value::F32(_) => "float",
                Value::U64(_) => "uint64",
                Value::U32(_) => "uint32",
                Value::Bool(_) => "bool",
                Value::Touch(_) => "Touch",
            };
            let role = format!("{:?}", field.role).to_lowercase();
            let row = format!("//! | {number} | `{}` | {kind} | {role} |", field.name);
            assert!(text.contains(&row), "the specification lacks {row}");
        }
    }

    #[test]
    fn touches_are_listed_by_their_number() {
        for (i, (touch, _)) in TOUCHES.iter().enumerate() {
            assert_eq!(*touch as usize, i);
        }
    }

    #[test]
    fn messages_with_impossible_values_are_refused() {
        let mut message = Vec::new();
        encode_tick(&FingerRecord::default(), &mut message);
        let broken: [(&str, &[u8]); 2] =
            [("finger", &[2 << 3, 0xac, 0x02]), ("touch", &[11 << 3, 9])];
        for (word, addition) in broken {
            // Protobuf: the last of several values of one field counts.
            let broken = [message.as_slice(), addition].concat();
            let error = decode_tick(&broken).expect_err(word);
            assert!(error.starts_with(word), "{error}");
        }
        assert!(decode_tick(&message[..message.len() - 1]).is_err());
    }
}
