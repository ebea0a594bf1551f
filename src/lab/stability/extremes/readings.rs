//! What a device may report in its worst hour, and records read back that hold what no tick wrote.

use super::drive::{DT_S, Drive, length, pressed, scene, stream};
use super::row::{Case, Ended, Size};
use crate::contact::{Contact, Friction, Shading, Stiffness, Touch, TouchScene};
use crate::device::{MAX_FINGERS, Reading};
use crate::geom::Vec3;
use crate::servo::{FingerRecord, LimitFlags, TickInput, TickRecord};
use crate::session::format::{decode_tick, encode_tick};
use crate::surface::torture::{Stream, grid, steps};

/// Numbers that are none, or that no place has.
pub const ODD: [f64; 10] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    -1.0e308,
    1.0e160,
    1.0e10,
    f64::MIN_POSITIVE,
    5.0e-324,
    -0.0,
];

fn plate() -> TouchScene {
    let s = steps(-60.0, 60.0, 8);
    let made = scene(grid(&s, &s, |_, _| 0.0), Stiffness::Uniform(1.0));
    // A plate of ordinary triangles is always let in.
    made.unwrap_or_else(|_| unreachable!())
}

/// Bad readings and records.
pub fn cases() -> Vec<Case> {
    type Adjust = fn(&mut TouchScene);
    let scenes: [(&str, Adjust); 5] = [
        ("point", |_| {}),
        ("friction", |s| {
            s.friction = Some(Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            });
        }),
        ("pad of 5 mm", |s| s.choices.finger_radius_mm = 5.0),
        ("shading", |s| s.shading = Some(Shading::of(&s.surface))),
        ("every force model", |s| {
            s.choices.force = crate::contact::ForceModel::HuntCrossley {
                damping_s_per_mm: 0.002,
                exponent: 1.5,
            };
        }),
    ];
    let mut cases = Vec::new();
    for (name, adjust) in scenes {
        cases.push(Case::new(
            format!("readings that are none, {name}"),
            "servo::tick",
            "every second reading odd: NaN, ±∞, 1e308, beyond 1000 km, lost, late, switched off, placed anew",
            move |size| wild(size, adjust),
        ));
        cases.push(Case::new(
            format!("records that hold what is none, {name}"),
            "session::decode_tick, Rig::resume_from",
            "every field of a record odd, written, read, taken over and ticked on",
            move |size| resumed(size, adjust),
        ));
    }
    cases.push(Case::new(
        "readings that are none, held against what a plate does",
        "servo::tick",
        "as above, on and in a plate",
        told,
    ));
    cases.push(Case::new(
        "more fingers than there are",
        "servo::tick",
        "n_fingers of 5 … usize::MAX",
        too_many,
    ));
    cases.push(Case::new(
        "a rig at its last tick",
        "servo::tick",
        "next_tick of u64::MAX",
        |size| {
            let mut drive = Drive::new(plate(), DT_S);
            drive.rig.next_tick = u64::MAX;
            for _ in 0..size.ticks.min(100) {
                drive.put(-Vec3::Z, Vec3::ZERO);
            }
            let last = drive.rig.next_tick == u64::MAX;
            let fault = (!last).then(|| "the count ran over".to_owned());
            Ended::checked(drive.tally, "the count stays at its end", fault)
        },
    ));
    cases
}

fn odd(stream: &mut Stream) -> f64 {
    ODD[(stream.unit().abs() * ODD.len() as f64) as usize % ODD.len()]
}

fn odd_vector(stream: &mut Stream) -> Vec3 {
    let mut v = pressed(stream) * Vec3::new(30.0, 30.0, 15.0);
    for i in 0..3 {
        if stream.unit() > 0.0 {
            v[i] = odd(stream);
        }
    }
    v
}

fn wild(size: &Size, adjust: fn(&mut TouchScene)) -> Ended {
    let mut scene = plate();
    adjust(&mut scene);
    let mut drive = Drive::new(scene, DT_S);
    let mut stream = stream(size.seed, "wild");
    for _ in 0..size.ticks {
        let mut input = TickInput {
            n_fingers: 2,
            force_enabled: stream.unit() < 0.9,
            late: stream.unit() > 0.95,
            ..TickInput::default()
        };
        for i in 0..2 {
            let is_odd = stream.unit() > 0.0;
            input.readings[i] = Reading {
                position_mm: if is_odd {
                    odd_vector(&mut stream)
                } else {
                    pressed(&mut stream) * Vec3::new(30.0, 30.0, 15.0)
                },
                velocity_mm_s: odd_vector(&mut stream),
                buttons: u32::MAX,
                connected: stream.unit() < 0.9,
            };
            input.place_anew[i] = stream.unit() > 0.98;
        }
        let record = drive.tick(&input);
        silent_where_it_must(&mut drive, &input, &record);
    }
    let check = "no force without a reading, when late or switched off; all else finite";
    Ended::checked(drive.tally, check, drive.fault)
}

fn silent_where_it_must(drive: &mut Drive, input: &TickInput, record: &TickRecord) {
    for (i, r) in record.fingers().iter().enumerate() {
        let silent = !input.readings[i].is_usable() || input.late || !input.force_enabled;
        drive.must(!silent || r.sent_force_n == Vec3::ZERO, || {
            format!("{} N sent", r.sent_force_n)
        });
        let lost = r.limits.has(LimitFlags::DISCONNECTED);
        drive.must(lost != input.readings[i].is_usable(), || {
            "a lost device is not told".to_owned()
        });
    }
}

/// What the contact of a frictionless point finger knows.
#[derive(Clone, Copy, PartialEq)]
enum Knows {
    /// Nothing: placed where the next reading is.
    Nothing,
    /// It was placed inside and has not been out.
    Inside,
    /// It was outside.
    Skin,
}

fn told(size: &Size) -> Ended {
    let mut drive = Drive::new(plate(), DT_S);
    let mut stream = stream(size.seed, "told");
    let mut knows = Knows::Nothing;
    for _ in 0..size.ticks {
        let mut position_mm = pressed(&mut stream) * Vec3::new(30.0, 30.0, 15.0);
        let kind = stream.unit();
        let (mut usable, mut far) = (true, false);
        if kind > 0.7 {
            let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            position_mm[(kind * 100.0) as usize % 3] = bad[(kind * 1000.0) as usize % 3];
            usable = false;
        } else if kind > 0.5 {
            // Finite, but nowhere.
            position_mm.x = 1.0e9 * (1.0 + 1.0e3 * kind);
            far = true;
        }
        let connected = stream.unit() < 0.9;
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        input.place_anew[0] = stream.unit() > 0.95;
        input.readings[0] = Reading {
            position_mm,
            velocity_mm_s: odd_vector(&mut stream),
            buttons: 0,
            connected,
        };
        if input.place_anew[0] || !(usable && connected) {
            knows = Knows::Nothing;
        }
        let c = drive.tick(&input).fingers[0].contact;
        if !(usable && connected) {
            drive.must(c == Contact::default(), || {
                "felt without a reading".to_owned()
            });
            continue;
        }
        if far {
            drive.must(c.force_n == Vec3::ZERO, || "felt at 1000 km".to_owned());
            if knows == Knows::Nothing {
                // Placed out there, from where the way back leads through anything.
                input.readings[0].connected = false;
                drive.tick(&input);
            }
            continue;
        }
        let inside = position_mm.z < 0.0;
        knows = match (knows, inside) {
            (Knows::Nothing | Knows::Inside, true) => Knows::Inside,
            _ => Knows::Skin,
        };
        let depth_mm = if knows == Knows::Skin && inside {
            -position_mm.z
        } else {
            0.0
        };
        drive.expect(c.depth_mm, depth_mm, 1.0e-10, "depth");
        drive.expect(c.force_n.z, depth_mm, 1.0e-10, "force");
        drive.must((c.touch == Touch::Free) == (depth_mm == 0.0), || {
            format!("{:?} at {depth_mm} mm", c.touch)
        });
    }
    match drive.fault {
        None => Ended::held(
            drive.tally,
            "depth and force after every fault, mm and N",
            drive.off * 1.0e-10,
            1.0e-10,
        ),
        fault => Ended::checked(drive.tally, "", fault),
    }
}

fn too_many(size: &Size) -> Ended {
    let mut drive = Drive::new(plate(), DT_S);
    for n_fingers in [MAX_FINGERS, MAX_FINGERS + 1, 1_000_000, usize::MAX] {
        for _ in 0..size.ticks.min(100) {
            let input = TickInput {
                readings: [Reading {
                    connected: true,
                    position_mm: -Vec3::Z,
                    ..Reading::default()
                }; MAX_FINGERS],
                n_fingers,
                force_enabled: true,
                ..TickInput::default()
            };
            let record = drive.tick(&input);
            drive.must(record.n_fingers == MAX_FINGERS, || {
                format!("{} fingers", record.n_fingers)
            });
        }
    }
    Ended::checked(drive.tally, "as many as there can be", drive.fault)
}

/// A number of a record to be replaced.
type Place = fn(&mut FingerRecord) -> &mut f64;

/// Every number of a record that the next tick starts from.
const PLACES: [Place; 21] = [
    |r| &mut r.reading.position_mm.x,
    |r| &mut r.reading.position_mm.z,
    |r| &mut r.reading.velocity_mm_s.y,
    |r| &mut r.contact.anchor_mm.x,
    |r| &mut r.contact.anchor_mm.y,
    |r| &mut r.contact.anchor_mm.z,
    |r| &mut r.contact.foot_mm.x,
    |r| &mut r.contact.foot_mm.z,
    |r| &mut r.contact.normal.x,
    |r| &mut r.contact.normal.z,
    |r| &mut r.contact.force_n.x,
    |r| &mut r.contact.force_n.y,
    |r| &mut r.contact.force_n.z,
    |r| &mut r.contact.depth_mm,
    |r| &mut r.contact.stiffness_n_per_mm,
    |r| &mut r.contact.felt_depth_mm,
    |r| &mut r.contact.credit_mj,
    |r| &mut r.sent_force_n.x,
    |r| &mut r.sent_force_n.y,
    |r| &mut r.sent_force_n.z,
    |r| &mut r.fade,
];

fn resumed(size: &Size, adjust: fn(&mut TouchScene)) -> Ended {
    let mut scene = plate();
    adjust(&mut scene);
    let mut drive = Drive::new(scene, DT_S);
    let mut stream = stream(size.seed, "resumed");
    let mut last = drive.put(Vec3::Z, Vec3::ZERO);
    let mut bytes = Vec::new();
    let mut number = 0;
    while drive.tally.ticks < size.ticks {
        for _ in 0..8 {
            let at = pressed(&mut stream) * Vec3::new(30.0, 30.0, 15.0);
            last = drive.put(at, stream.vector() * 100.0);
        }
        let mut record = last;
        *PLACES[number % PLACES.len()](&mut record) = ODD[number / PLACES.len() % ODD.len()];
        if stream.unit() > 0.7 {
            *PLACES[(number * 7) % PLACES.len()](&mut record) = odd(&mut stream);
        }
        record.contact.triangle = match number % 4 {
            0 => u32::MAX,
            _ => record.contact.triangle,
        };
        record.finger = [0, 0, 0, 200][number % 4];
        number += 1;
        encode_tick(&record, &mut bytes);
        let Ok(read) = decode_tick(&bytes) else {
            return Ended::wrong("a record that was written is not read");
        };
        let mut tick = TickRecord {
            n_fingers: 1,
            ..TickRecord::default()
        };
        tick.fingers[0] = read;
        drive.rig.resume_from(&tick);
        drive.tally.answers += 1;
        let sent_n = drive
            .put(pressed(&mut stream) * 15.0, Vec3::ZERO)
            .sent_force_n;
        let felt_n = length(sent_n);
        drive.must(felt_n.is_finite(), || format!("{sent_n} N after it"));
    }
    Ended::checked(
        drive.tally,
        "finite and within the limits from any record on",
        drive.fault,
    )
}
