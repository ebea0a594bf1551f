//! Convex and concave edges, creases, needles and thin sheets at speeds that no hand has: nothing may pass through.

use super::drive::{DT_S, Drive, scene, stream};
use super::row::{Case, Ended, Size};
use crate::contact::{Friction, Stiffness, Touch};
use crate::geom::Vec3;
use crate::partition::Sides;
use crate::surface::torture::{self, Truth, closest_in};
use std::sync::{Arc, Mutex, PoisonError};

const DOOR: &str = "servo::tick";

/// How the finger meets the surface.
#[derive(Clone, Copy)]
struct Finger {
    name: &'static str,
    friction: Option<f64>,
    pad_mm: f64,
    sides: Sides,
}

const FINGERS: [Finger; 4] = [
    Finger {
        name: "point",
        friction: None,
        pad_mm: 0.0,
        sides: Sides::Front,
    },
    Finger {
        name: "point, both sides",
        friction: None,
        pad_mm: 0.0,
        sides: Sides::Both,
    },
    Finger {
        name: "point, friction 1000",
        friction: Some(1.0e3),
        pad_mm: 0.0,
        sides: Sides::Front,
    },
    Finger {
        name: "pad of up to 0.5 mm",
        friction: Some(0.46),
        pad_mm: 0.5,
        sides: Sides::Front,
    },
];

/// Way in a tick of 1 ms at 100 m/s, mm: more than any of the surfaces is wide.
const STEPS_MM: [f64; 3] = [1.0, 10.0, 100.0];

/// Every awkward surface under every finger, at 1, 10 and 100 m/s.
pub fn cases() -> Vec<Case> {
    let names: Vec<&'static str> = surfaces(0).iter().map(|c| c.name).collect();
    let mut cases = Vec::new();
    for (number, name) in names.into_iter().enumerate() {
        for finger in FINGERS {
            cases.push(Case::new(
                format!("{name}, {}", finger.name),
                DOOR,
                "at 1, 10 and 100 m/s, through vertices and edges",
                move |size| walk(number, finger, size),
            ));
        }
    }
    cases
}

/// The surfaces with their paths for a seed: made once for all fingers.
fn surfaces(seed: u64) -> Arc<Vec<torture::Case>> {
    type Made = Option<(u64, Arc<Vec<torture::Case>>)>;
    static MADE: Mutex<Made> = Mutex::new(None);
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    match &*made {
        Some((of, all)) if *of == seed => Arc::clone(all),
        _ => {
            let all = Arc::new(torture::all(seed.wrapping_add(1)));
            *made = Some((seed, Arc::clone(&all)));
            all
        }
    }
}

fn walk(number: usize, finger: Finger, size: &Size) -> Ended {
    let all = surfaces(size.seed);
    let Some(case) = all.get(number) else {
        return Ended::wrong("no such surface");
    };
    let mut scene = match scene(case.mesh.clone(), Stiffness::Uniform(1.0)) {
        Ok(scene) => scene,
        Err(why) => return Ended::wrong(why.to_string()),
    };
    scene.friction = finger.friction.map(|mu| Friction {
        static_coefficient: mu,
        dynamic_coefficient: 0.95 * mu,
        skin_looseness: 1.0,
    });
    // A pad starts clear of the skin, in a slot too.
    let room_mm = -0.5 * case.truth.depth_mm(case.path[0]);
    scene.choices.finger_radius_mm = finger.pad_mm.min(room_mm.max(0.01));
    scene.choices.sides = finger.sides;
    let mut drive = Drive::new(scene, DT_S);
    let mut stream = stream(size.seed, case.name);
    let inside = &case.path[1..];
    let low = inside.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = inside.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let free = case.path[0];
    let (mut at, mut goal, mut n) = (free, free, 0);
    drive.put(at, Vec3::ZERO);
    let slack_mm = 1.0e-9 * case.truth.steepness();
    let mut step = STEPS_MM[0];
    for i in 1..size.ticks {
        if at == goal {
            n += 1;
            step = STEPS_MM[n % STEPS_MM.len()];
            goal = match n % 5 {
                0 => free,
                1 => case.path[n % case.path.len()],
                _ => (low + high) / 2.0 + stream.vector() * (high - low) / 2.0,
            };
        }
        let before = at;
        let way = goal - at;
        at = if way.length() <= step {
            goal
        } else {
            at + way * (step / way.length())
        };
        let c = drive.put(at, (at - before) / DT_S).contact;
        let depth_mm = case.truth.depth_mm(c.anchor_mm);
        drive.must(depth_mm <= slack_mm, || {
            format!("{depth_mm} mm through, from {before} to {at}")
        });
        // The closest point of a cell is dear: now and then.
        let plain = finger.friction.is_none() && finger.pad_mm == 0.0;
        if plain
            && i % 16 == 0
            && let Truth::Cell(cell) = &case.truth
        {
            let off = closest_in(cell, at).distance(c.anchor_mm);
            drive.expect(off, 0.0, 2.0e-9, "way to the closest point");
            let free = c.touch == Touch::Free;
            drive.must(!free || off == 0.0, || "free inside".to_owned());
        }
    }
    let check = match &case.truth {
        Truth::Cell(_) => "never through; frictionless at the closest point",
        Truth::Plate { .. } => "finite; a plate has no inside",
        _ => "never through",
    };
    Ended::checked(drive.tally, check, drive.fault)
}
