//! Devices fed with what no hand does, and their readings ticked.

use super::drive::{DT_S, Drive, scene, stream};
use super::readings::ODD;
use super::row::{Case, Ended, Size, Tally};
use crate::contact::{Friction, Stiffness, TouchScene};
use crate::device::mouse::{Hand, Mouse};
use crate::device::replay::Replay;
use crate::device::scripted::{Script, Scripted, Trajectory, Waypoint};
use crate::device::{Capabilities, Device, Reading};
use crate::geom::Vec3;
use crate::servo::{Limits, TickInput};
use crate::surface::torture::{grid, steps};

/// Scripts, files of trajectories, mouse and replay.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![
        Case::new(
            "waypoints that are none",
            "Trajectory::new",
            "NaN, ±∞, 1e308 as time and as coordinate; times that fall or stand; speeds beyond number",
            |_| bad_waypoints(),
        ),
        Case::new(
            "numbers of a trajectory file",
            "Trajectory::parse_csv",
            "nan, inf, 1e400, −1e400, words and fingers of 1e9",
            |_| bad_csv(),
        ),
        Case::new(
            "trajectories at the edge of what is allowed",
            "Scripted::read, servo::tick",
            "1e7 mm within 1e-2 s; steps of 0, NaN, ∞ and 1e300 s",
            fast_script,
        ),
        Case::new(
            "scripts at odd places, depths and steps",
            "Script::trajectory",
            "every script at NaN, ±∞, 1e308",
            odd_scripts,
        ),
        Case::new(
            "mouse sent anywhere",
            "MouseHandle::set, servo::tick",
            "targets of NaN, ±∞, 1e308, 1e-320 among ordinary ones, force fed back",
            |size| mouse(size, Hand::default(), "anywhere", true),
        ),
        Case::new(
            "mouse finger beyond 1000 km and back",
            "MouseHandle::set, servo::tick",
            "targets of 1e308, then 2 s at the skin",
            far_and_back,
        ),
        Case::new(
            "replay of odd readings",
            "device::replay, servo::tick",
            "readings of NaN, ±∞, 1e308",
            replayed,
        ),
    ];
    for (name, hand) in hands() {
        cases.push(Case::new(
            format!("hand of {name}"),
            "Mouse::new, servo::tick",
            "an ordinary walk, force fed back",
            move |size| mouse(size, hand, name, false),
        ));
    }
    cases
}

fn hands() -> Vec<(&'static str, Hand)> {
    let hand = |mass_kg, stiffness_n_per_mm, damping_n_s_per_mm| Hand {
        mass_kg,
        stiffness_n_per_mm,
        damping_n_s_per_mm,
    };
    vec![
        ("no mass", hand(0.0, 1.5, 0.01)),
        ("nothing at all", hand(0.0, 0.0, 0.0)),
        ("the least mass", hand(5.0e-324, 1.5, 0.01)),
        ("1e-300 kg", hand(1.0e-300, 1.0e300, 0.0)),
        ("1e300 kg", hand(1.0e300, 1.5, 0.01)),
        ("1e12 N/mm", hand(0.15, 1.0e12, 0.0)),
        ("a negative mass", hand(-1.0, 1.5, 0.01)),
        ("negative damping", hand(0.15, 1.5, -1.0)),
        ("NaN", hand(f64::NAN, f64::NAN, f64::NAN)),
        ("infinite mass", hand(f64::INFINITY, 1.5, 0.01)),
        ("infinite stiffness", hand(0.15, f64::INFINITY, 0.01)),
        ("infinite damping", hand(0.15, 1.5, f64::INFINITY)),
    ]
}

fn plate() -> TouchScene {
    let s = steps(-60.0, 60.0, 8);
    let made = scene(grid(&s, &s, |_, _| 0.0), Stiffness::Uniform(1.0));
    let mut scene = made.unwrap_or_else(|_| unreachable!());
    scene.friction = Some(Friction {
        static_coefficient: 0.46,
        dynamic_coefficient: 0.44,
        skin_looseness: 1.0,
    });
    scene
}

fn slippery() -> TouchScene {
    TouchScene {
        friction: None,
        ..plate()
    }
}

fn at(time_s: f64, position_mm: Vec3) -> Waypoint {
    Waypoint {
        time_s,
        position_mm,
    }
}

fn bad_waypoints() -> Ended {
    let mut tried = Vec::new();
    let mut refuse = |what: String, waypoints: Vec<Waypoint>| {
        tried.push((what, Trajectory::new(waypoints).map(|_| ())));
    };
    refuse("nothing".into(), Vec::new());
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0e308, -1.0e8] {
        refuse(format!("x = {x}"), vec![at(0.0, Vec3::X * x)]);
        refuse(
            format!("z = {x}"),
            vec![at(0.0, Vec3::ZERO), at(1.0, Vec3::Z * x)],
        );
    }
    for t in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        refuse(format!("t = {t}"), vec![at(t, Vec3::ZERO)]);
    }
    for (a, b) in [(1.0, 1.0), (1.0, 0.5), (0.0, -0.0)] {
        refuse(
            format!("t = {a}, then {b}"),
            vec![at(a, Vec3::ZERO), at(b, Vec3::X)],
        );
    }
    refuse(
        "1 mm within the least time".into(),
        vec![at(0.0, Vec3::ZERO), at(5.0e-324, Vec3::X)],
    );
    Ended::all_refused(tried)
}

fn bad_csv() -> Ended {
    let mut tried = Vec::new();
    for bad in [
        "nan", "NaN", "inf", "-inf", "infinity", "1e400", "-1e400", "1e8", "", "x", "0x10", "1,5",
    ] {
        for row in [
            format!("{bad},0,0,0"),
            format!("0,{bad},0,0"),
            format!("0,0,{bad},0"),
            format!("0,0,0,{bad}"),
        ] {
            let text = format!("t,x,y,z\n{row}\n");
            tried.push((row, Trajectory::parse_csv(&text, "t.csv").map(|_| ())));
        }
    }
    for finger in ["1e9", "-1", "0.5", "nan", "4"] {
        let text = format!("t,x,y,z,finger\n0,0,0,0,{finger}\n");
        tried.push((
            text.clone(),
            Trajectory::parse_csv(&text, "t.csv").map(|_| ()),
        ));
    }
    Ended::all_refused(tried)
}

/// One finger's reading through the tick, and the force back.
fn turn(drive: &mut Drive, device: &mut dyn Device, dt_s: f64) -> Reading {
    let reading = device.read(dt_s);
    let mut input = TickInput {
        n_fingers: 1,
        force_enabled: true,
        ..TickInput::default()
    };
    input.readings[0] = reading;
    let sent_n = drive.tick(&input).fingers[0].sent_force_n;
    device.write(sent_n);
    reading
}

/// What a device that is connected reports must be a place.
fn look(drive: &mut Drive, reading: &Reading) {
    let places = [reading.position_mm, reading.velocity_mm_s];
    if !reading.connected {
        return;
    }
    drive.tally.not_finite += places
        .iter()
        .flat_map(|v| v.to_array())
        .filter(|x| !x.is_finite())
        .count() as u64;
}

fn fast_script(size: &Size) -> Ended {
    let mut stream = stream(size.seed, "fast script");
    let mut drive = Drive::new(plate(), DT_S);
    while drive.tally.ticks < size.ticks {
        let waypoints = (0..40)
            .map(|i| {
                let far = stream.unit() > 0.8;
                let p = stream.vector() * if far { 1.0e7 } else { 50.0 };
                at(0.01 * f64::from(i), p)
            })
            .collect();
        let trajectory = match Trajectory::new(waypoints) {
            Ok(trajectory) => trajectory,
            Err(why) => return Ended::wrong(why.to_string()),
        };
        for dt_s in [DT_S, 0.0, f64::NAN, f64::INFINITY, 1.0e300, -1.0, 5.0e-324] {
            let mut device = Scripted::new(trajectory.clone());
            for _ in 0..(size.ticks / 70).clamp(5, 400) {
                let reading = turn(&mut drive, &mut device, dt_s);
                look(&mut drive, &reading);
            }
        }
    }
    Ended::bounded(
        drive.tally,
        "readings and forces finite and within the limits",
    )
}

fn odd_scripts(_: &Size) -> Ended {
    let mut tally = Tally::default();
    for script in Script::ALL {
        for x in ODD {
            for (centre, depth_mm, height_mm) in [
                ((x, 1.0), 5.0, 2.0),
                ((1.0, x), 5.0, 2.0),
                ((1.0, 2.0), x, 2.0),
                ((1.0, 2.0), 5.0, x),
            ] {
                let made = script.trajectory(centre, depth_mm, |_, _| Some(height_mm));
                for t in [0.0, 0.5, x] {
                    let (p, v) = made.at(t);
                    tally.lengths(p.to_array());
                    tally.numbers(v.to_array());
                }
            }
        }
    }
    Ended::bounded(tally, "places and speeds finite")
}

fn mouse(size: &Size, hand: Hand, name: &str, odd: bool) -> Ended {
    let start = Vec3::Z * 10.0;
    let (mut device, handle) = Mouse::new(start, hand);
    let limits = Limits::of(device.capabilities());
    let mut drive = Drive::with_limits(plate(), limits, DT_S);
    let mut stream = stream(size.seed, name);
    for i in 0..size.ticks {
        if i % 50 == 0 {
            let mut target = stream.vector() * Vec3::new(40.0, 40.0, 15.0);
            if odd && stream.unit() > 0.0 {
                let bad = (stream.unit().abs() * ODD.len() as f64) as usize % ODD.len();
                target[i as usize / 50 % 3] = ODD[bad];
            }
            handle.set(target);
        }
        let reading = turn(&mut drive, &mut device, DT_S);
        look(&mut drive, &reading);
    }
    Ended::bounded(
        drive.tally,
        "readings and forces finite and within the limits",
    )
}

/// Out of reach and back the hand must come to rest where an ordinary one does.
fn far_and_back(size: &Size) -> Ended {
    let start = Vec3::Z * 10.0;
    let (mut device, handle) = Mouse::new(start, Hand::default());
    let (mut plain, plain_handle) = Mouse::new(start, Hand::default());
    let limits = Limits::of(device.capabilities());
    let mut drive = Drive::with_limits(slippery(), limits, DT_S);
    for round in 0..3 {
        handle.set(Vec3::splat(if round == 1 { -1.0e308 } else { 1.0e308 }));
        for _ in 0..size.ticks.min(1000) {
            let reading = turn(&mut drive, &mut device, DT_S);
            look(&mut drive, &reading);
        }
        for (z, ticks) in [(10.0, 3000), (-3.0, 3000)] {
            handle.set(Vec3::new(1.0, 2.0, z));
            plain_handle.set(Vec3::new(1.0, 2.0, z));
            for _ in 0..ticks {
                let reading = turn(&mut drive, &mut device, DT_S);
                look(&mut drive, &reading);
            }
        }
    }
    let mut ordinary = Drive::with_limits(slippery(), limits, DT_S);
    for _ in 0..3000 {
        turn(&mut ordinary, &mut plain, DT_S);
    }
    let there = |d: &Drive| {
        let contact = d.rig.contacts[0];
        contact.map_or(Vec3::NAN, |c| c.proxy_mm)
    };
    let off = there(&drive).distance(there(&ordinary));
    let mut tally = drive.tally;
    tally.add(&ordinary.tally);
    Ended::held(
        tally,
        "rests where one that was never away does, mm",
        off,
        1.0e-3,
    )
}

fn replayed(size: &Size) -> Ended {
    let mut s = stream(size.seed, "replayed");
    let mut odd = || ODD[(s.unit().abs() * ODD.len() as f64) as usize % ODD.len()];
    let readings: Vec<Reading> = (0..size.ticks)
        .map(|i| Reading {
            position_mm: Vec3::new(odd(), odd(), if i % 2 == 0 { odd() } else { -3.0 }),
            velocity_mm_s: Vec3::new(odd(), odd(), odd()),
            buttons: 0,
            connected: i % 3 != 0,
        })
        .collect();
    let capabilities = Capabilities {
        name: "odd".into(),
        rated_force_n: f64::NAN,
        max_stiffness_n_per_mm: f64::NAN,
        workspace_radius_mm: f64::NAN,
        ..Capabilities::default()
    };
    let limits = Limits::of(&capabilities);
    let mut drive = Drive::with_limits(slippery(), limits, DT_S);
    let mut device = Replay::new(capabilities, readings.into_iter());
    for _ in 0..size.ticks {
        turn(&mut drive, &mut device, DT_S);
    }
    let none = drive.tally.largest_n == 0.0;
    let fault = (!none).then(|| "force from a device that states none".to_owned());
    Ended::checked(drive.tally, "no force for a rated force of NaN", fault)
}
