//! A flat skin in z = 0 under a finger that goes anywhere: whatever the triangles, the sizes and the choices, the
//! frictionless foot is straight above the finger, so every tick has a closed form.

use super::drive::{DT_S, Drive, length, pressed, scene, stream};
use super::row::{Case, Ended, Size};
use crate::contact::{ForceModel, Friction, Shading, Stiffness, Touch, TouchScene, published};
use crate::geom::Vec3;
use crate::servo::Limits;
use crate::surface::RawMesh;
use crate::surface::torture::{grid, steps};
use std::sync::Arc;

const DOOR: &str = "servo::tick";

/// A walk over a plate, and what differs from the ordinary.
struct Plate {
    mesh: RawMesh,
    /// The finger stays within this of the middle, mm, and this deep, mm.
    reach_mm: f64,
    deep_mm: f64,
    /// Way from one tick to the next, mm; anywhere where infinite.
    step_mm: f64,
    dt_s: f64,
    stiffness: Stiffness,
    friction: Option<Friction>,
    model: ForceModel,
    pad_mm: f64,
    limits: Limits,
    adjust: fn(&mut TouchScene),
    /// Lengths off by this share of the reach are rounding.
    allowed: f64,
}

impl Default for Plate {
    fn default() -> Self {
        Self {
            mesh: ordinary(50.0),
            reach_mm: 45.0,
            deep_mm: 20.0,
            step_mm: f64::INFINITY,
            dt_s: DT_S,
            stiffness: Stiffness::Uniform(1.0),
            friction: None,
            model: ForceModel::Linear,
            pad_mm: 0.0,
            limits: Limits::default(),
            adjust: |_| {},
            allowed: 1.0e-12,
        }
    }
}

/// A square plate of half the given width, of ordinary triangles.
fn ordinary(half_mm: f64) -> RawMesh {
    let s = steps(-half_mm, half_mm, 8);
    grid(&s, &s, |_, _| 0.0)
}

/// A plate with columns of triangles as long as it and as narrow as `aspect` says, between ordinary ones.
fn needles(aspect: f64) -> RawMesh {
    let (half, narrow) = (50.0, 100.0 / aspect);
    let mut xs = vec![-half];
    for middle in [-30.0, -7.0, 0.0, 11.0, 33.0] {
        xs.extend((0..5).map(|i| middle + f64::from(i) * narrow));
    }
    xs.push(half);
    grid(&xs, &[-half, half], |_, _| 0.0)
}

/// Triangles whose tip lies in a fan of needles about one vertex.
fn fan(aspect: f64) -> RawMesh {
    let mut mesh = ordinary(50.0);
    // Split the triangle that holds (7, 11) by a vertex a needle's breadth from an edge.
    let n = mesh.positions.len() as u32;
    let t = mesh.triangles.len() / 2;
    let [a, b, c] = mesh.triangles.swap_remove(t);
    let [pa, pb, pc] = [a, b, c].map(|v| mesh.positions[v as usize]);
    let inner = (pa + pb) / 2.0 + ((pc - pa) + (pc - pb)) / aspect;
    mesh.positions.push(inner);
    mesh.triangles.extend([[a, b, n], [b, c, n], [c, a, n]]);
    mesh
}

impl Plate {
    fn case(name: &str, done: &str, make: impl Fn() -> Self + 'static) -> Case {
        let named = name.to_owned();
        Case::new(name, DOOR, done, move |size| make().walk(&named, size))
    }

    fn walk(self, name: &str, size: &Size) -> Ended {
        let mut scene = match scene(self.mesh.clone(), self.stiffness.clone()) {
            Ok(scene) => scene,
            Err(why) => return Ended::refused(why),
        };
        scene.friction = self.friction;
        scene.choices.force = self.model;
        scene.choices.finger_radius_mm = self.pad_mm;
        (self.adjust)(&mut scene);
        let pad_mm = scene.choices.pad_mm().unwrap_or(0.0);
        let mut drive = Drive::with_limits(scene, self.limits, self.dt_s);
        let mut stream = stream(size.seed, name);
        let scale = Vec3::new(self.reach_mm, self.reach_mm, self.deep_mm);
        let mut at = Vec3::Z * (self.deep_mm + pad_mm * (1.0 + 1.0e-9));
        drive.put(at, Vec3::ZERO);
        for _ in 1..size.ticks {
            let before = at;
            let goal = pressed(&mut stream) * scale + Vec3::Z * pad_mm;
            at += (goal - at).clamp_length_max(self.step_mm);
            self.look(&mut drive, before, at, pad_mm);
        }
        let check = if self.friction.is_some() {
            "foot, depth and cone in closed form"
        } else {
            "foot, depth and force in closed form"
        };
        match drive.fault {
            Some(fault) => Ended::checked(drive.tally, "", Some(fault)),
            None => Ended::held(drive.tally, check, drive.off * self.allowed, self.allowed),
        }
    }

    /// One tick held against what a plane does.
    fn look(&self, drive: &mut Drive, before: Vec3, at: Vec3, pad_mm: f64) {
        let sent_before_n = length(drive.rig.last_force_n[0]);
        let velocity = (at - before) / DT_S;
        let r = drive.put(at, velocity);
        let c = &r.contact;
        let depth_mm = (pad_mm - at.z).max(0.0);
        let allowed_mm = self.allowed * (self.reach_mm + self.deep_mm + pad_mm);
        drive.expect(c.depth_mm, depth_mm, allowed_mm, "depth");
        if depth_mm <= allowed_mm {
            return;
        }
        drive.must(c.touch != Touch::Free, || "nothing is felt".to_owned());
        let foot = Vec3::new(at.x, at.y, pad_mm);
        // A pad leaves up to two thousandths of its radius of its way to the next tick.
        let left_mm = 2.0e-3 * pad_mm;
        let beside_mm = (c.foot_mm.distance(foot) - left_mm).max(0.0);
        drive.expect(beside_mm, 0.0, allowed_mm, "way to the foot");
        // The normal of a pad is told by its centre and foot.
        let turn = 1.0e-9 + 8.0 * f64::EPSILON * (self.reach_mm + pad_mm) / depth_mm;
        drive.expect(c.normal.distance(Vec3::Z), 0.0, turn, "turn of the normal");
        let secant = self
            .model
            .secant_n_per_mm(c.stiffness_n_per_mm, depth_mm, -velocity.z);
        let normal_n = secant * depth_mm;
        let slack_n = 4.0 * self.allowed * (normal_n + secant * (self.reach_mm + pad_mm))
            + 4.0 * f64::MIN_POSITIVE;
        match self.friction {
            None => {
                let off = c.force_n.distance(Vec3::Z * normal_n);
                drive.expect(off, 0.0, slack_n * 4.0, "force beside the closed form");
            }
            Some(friction) => {
                let good = |x: f64, or: f64| if x > 0.0 && x.is_finite() { x } else { or };
                let loose = good(friction.skin_looseness, 1.0);
                let moving = good(friction.dynamic_coefficient, 0.0) * loose;
                let starting = (good(friction.static_coefficient, 0.0) * loose).max(moving);
                let most = if c.touch == Touch::Slip {
                    moving
                } else {
                    starting
                };
                let pull = c.foot_mm.distance(c.anchor_mm);
                let over = (pull - most * depth_mm - left_mm).max(0.0);
                drive.expect(over, 0.0, allowed_mm * 1.0e3, "pull beyond the cone");
                let lean_n = left_mm * secant / loose;
                drive.expect(
                    c.force_n.z,
                    normal_n,
                    slack_n * 4.0 + lean_n,
                    "normal force",
                );
            }
        }
        // What the limits leave of it.
        let bound = |x: f64| if x > 0.0 { x } else { 0.0 };
        let rise_n = sent_before_n + bound(self.limits.rise_n_per_s * self.dt_s);
        let most_n = bound(self.limits.rated_force_n).min(rise_n);
        let wanted_n = length(c.force_n).min(most_n);
        // Squares of a force below 1e-154 N are nothing: it then rises no further.
        let slack_n = 1.0e-9 * wanted_n + 1.0e-150;
        drive.expect(length(r.sent_force_n), wanted_n, slack_n, "force sent");
    }
}

/// Triangles of every shape and size.
pub fn shapes() -> Vec<Case> {
    let mut cases = Vec::new();
    for power in 6..=9 {
        let aspect = 10_f64.powi(power);
        cases.push(Plate::case(
            &format!("needle triangles, aspect 1e{power}"),
            "anywhere on and in a plate of strips of needles",
            move || Plate {
                mesh: needles(aspect),
                ..Plate::default()
            },
        ));
        cases.push(Plate::case(
            &format!("needle beside an edge, aspect 1e{power}"),
            "anywhere on and in a plate with a fan of needles",
            move || Plate {
                mesh: fan(aspect),
                ..Plate::default()
            },
        ));
    }
    for (half_mm, name) in [(1.0e6, "1 km"), (1.0e7, "10 km"), (2.0e7, "20 km")] {
        cases.push(Plate::case(
            &format!("triangles of a plate of ± {name}"),
            "anywhere on and in the plate",
            move || Plate {
                mesh: ordinary(half_mm),
                reach_mm: 0.9 * half_mm,
                ..Plate::default()
            },
        ));
    }
    cases.push(Plate::case(
        "a triangle of 1 nm² among some of 1 km²",
        "anywhere near the small one",
        || Plate {
            mesh: mixed(),
            reach_mm: 0.01,
            deep_mm: 0.01,
            // Coordinates of 1 km are rounded to 1e-10 mm.
            allowed: 1.0e-6,
            ..Plate::default()
        },
    ));
    for power in -6..=6 {
        let scale = 10_f64.powi(power);
        cases.push(Plate::case(
            &format!("plate × 1e{power}"),
            "anywhere on and in the plate",
            move || Plate {
                mesh: ordinary(50.0 * scale),
                reach_mm: 45.0 * scale,
                deep_mm: 20.0 * scale,
                ..Plate::default()
            },
        ));
    }
    cases
}

/// A triangle with edges of 1e-6 mm in a plate of a kilometre.
fn mixed() -> RawMesh {
    let xs = [-1.0e6, -1.0, -1.0e-6, 0.0, 1.0e-6, 1.0, 1.0e6];
    grid(&xs, &xs, |_, _| 0.0)
}

/// Depth, speed, rate and limits.
pub fn motions() -> Vec<Case> {
    let mut cases = Vec::new();
    for (deep_mm, name) in [(1.0e3, "1 m"), (1.0e4, "10 m"), (1.0e6, "1 km")] {
        cases.push(Plate::case(
            &format!("pressed in by {name}"),
            "anywhere down to there",
            move || Plate {
                deep_mm,
                ..Plate::default()
            },
        ));
    }
    for speed in [1.0, 10.0, 100.0, 1000.0] {
        cases.push(Plate::case(
            &format!("{speed} m/s"),
            "through the skin and back at 1 kHz",
            move || Plate {
                step_mm: speed,
                ..Plate::default()
            },
        ));
    }
    for (rate_hz, name) in [(100.0, "100 Hz"), (1.0e3, "1 kHz"), (1.0e4, "10 kHz")] {
        cases.push(Plate::case(
            &format!("servo at {name}"),
            "at 1 m/s; the force rises no faster than allowed",
            move || Plate {
                dt_s: 1.0 / rate_hz,
                step_mm: 1.0e3 / rate_hz,
                ..Plate::default()
            },
        ));
    }
    for (dt_s, name) in [
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (-1.0, "negative"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "infinite"),
    ] {
        cases.push(Plate::case(
            &format!("time step {name}"),
            "anywhere on and in the plate",
            move || Plate {
                dt_s,
                ..Plate::default()
            },
        ));
    }
    let bounds = [
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (1.0e-300, "1e-300"),
        (1.0e300, "1e300"),
        (-1.0, "negative"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "infinite"),
        (f64::NEG_INFINITY, "−infinite"),
    ];
    for (value, name) in bounds {
        cases.push(Plate::case(
            &format!("rated force {name}"),
            "anywhere on and in the plate",
            move || Plate {
                limits: Limits {
                    rated_force_n: value,
                    ..Limits::default()
                },
                ..Plate::default()
            },
        ));
        cases.push(Plate::case(
            &format!("rise of force {name}"),
            "anywhere on and in the plate",
            move || Plate {
                limits: Limits {
                    rise_n_per_s: value,
                    ..Limits::default()
                },
                ..Plate::default()
            },
        ));
    }
    cases
}

/// Stiffness, force models, friction, pads.
pub fn materials() -> Vec<Case> {
    let mut cases = Vec::new();
    for power in [-6, -3, 0, 3, 6] {
        let k = 10_f64.powi(power);
        cases.push(Plate::case(
            &format!("stiffness 1e{power} N/mm"),
            "anywhere on and in the plate",
            move || Plate {
                stiffness: Stiffness::Uniform(k),
                ..Plate::default()
            },
        ));
    }
    for (k, name) in [
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (-1.0, "negative"),
        (1.0e300, "1e300"),
        (f64::INFINITY, "infinite"),
        (f64::NAN, "NaN"),
    ] {
        cases.push(Case::new(
            format!("stiffness {name}"),
            DOOR,
            "anywhere on and in the plate",
            move |size| loose(size, |s| s.stiffness = Stiffness::Uniform(k)),
        ));
    }
    for contrast in [1.0e3, 1.0e6] {
        cases.push(Case::new(
            format!("stiffness contrast of {contrast:.0e} between neighbours"),
            DOOR,
            "anywhere on and in a plate of soft and hard vertices in turn",
            move |size| chequered(size, contrast),
        ));
    }
    for (model, name) in extreme_models() {
        cases.push(Plate::case(
            &format!("{} {name}", model.name()),
            "anywhere on and in the plate; force by the model alone",
            move || Plate {
                model,
                ..Plate::default()
            },
        ));
    }
    let coefficients = [
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (1.0e-3, "1e-3"),
        (1.0, "1"),
        (1.0e3, "1e3"),
        (1.0e300, "1e300"),
        (-1.0, "negative"),
        (f64::INFINITY, "infinite"),
        (f64::NAN, "NaN"),
    ];
    for (mu, name) in coefficients {
        for (pad_mm, finger) in [(0.0, "point"), (5.0, "pad of 5 mm")] {
            cases.push(Plate::case(
                &format!("friction {name}, {finger}"),
                "at 20 m/s on and in the plate",
                move || Plate {
                    friction: Some(Friction {
                        static_coefficient: mu,
                        dynamic_coefficient: 0.9 * mu,
                        skin_looseness: 1.0,
                    }),
                    step_mm: 20.0,
                    pad_mm,
                    mesh: ordinary(200.0),
                    ..Plate::default()
                },
            ));
        }
    }
    for (looseness, name) in coefficients {
        cases.push(Plate::case(
            &format!("skin looseness {name}"),
            "at 20 m/s on and in the plate",
            move || Plate {
                friction: Some(Friction {
                    static_coefficient: 0.46,
                    dynamic_coefficient: 0.44,
                    skin_looseness: looseness,
                }),
                step_mm: 20.0,
                mesh: ordinary(200.0),
                ..Plate::default()
            },
        ));
    }
    for (radius, name) in [
        (1.0e-6, "1e-6 mm"),
        (1.0e-3, "1e-3 mm"),
        (1.0, "1 mm"),
        (1.0e-9, "1e-9 mm, a point"),
        (1.0e3, "1 m"),
        (1.0e6, "1 km"),
        (1.0e9, "1000 km"),
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (-1.0, "negative"),
        (f64::INFINITY, "infinite"),
        (f64::NAN, "NaN"),
    ] {
        cases.push(Plate::case(
            &format!("pad radius {name}"),
            "anywhere within 20 radii on and in the plate",
            move || {
                let most = if (1.0e-6..2.0).contains(&radius) {
                    // In a tick a pad comes no farther than 64 radii.
                    20.0 * radius
                } else {
                    45.0
                };
                Plate {
                    pad_mm: radius,
                    reach_mm: most,
                    deep_mm: 0.5 * most,
                    ..Plate::default()
                }
            },
        ));
    }
    cases.push(Plate::case(
        "force shading of a flat skin",
        "anywhere on and in the plate: nothing to shade",
        || Plate {
            adjust: |scene| scene.shading = Some(Shading::of(&scene.surface)),
            ..Plate::default()
        },
    ));
    cases.push(Case::new(
        "edits of the stiffness by 1e6 while pressed",
        "servo::Rig::edit_scene",
        "from 1 N/mm to 1e6 and back, 3 mm deep; no step of force beyond 0.04 N",
        edited,
    ));
    cases
}

/// A walk for a scene whose force has no closed form, or needs none.
fn loose(size: &Size, adjust: impl Fn(&mut TouchScene)) -> Ended {
    let mut scene = match scene(ordinary(50.0), Stiffness::Uniform(1.0)) {
        Ok(scene) => scene,
        Err(why) => return Ended::wrong(why.to_string()),
    };
    adjust(&mut scene);
    let mut drive = Drive::new(scene, DT_S);
    let mut stream = stream(size.seed, "loose");
    drive.put(Vec3::Z * 20.0, Vec3::ZERO);
    for _ in 1..size.ticks {
        let at = pressed(&mut stream) * Vec3::new(45.0, 45.0, 20.0);
        let c = drive.put(at, stream.vector() * 1.0e5).contact;
        drive.expect(c.depth_mm, (-at.z).max(0.0), 1.0e-10, "depth");
    }
    match drive.fault {
        None => Ended::bounded(drive.tally, "the foot is right; the force is finite"),
        fault => Ended::checked(drive.tally, "", fault),
    }
}

/// Soft and hard vertices in turn: between them the stiffness is barycentric.
fn chequered(size: &Size, contrast: f64) -> Ended {
    let cell = 12.5;
    let at_vertex = move |i: i64, j: i64| {
        if (i + j).rem_euclid(2) == 0 {
            1.0
        } else {
            1.0 / contrast
        }
    };
    let mut scene = match scene(ordinary(50.0), Stiffness::Uniform(1.0)) {
        Ok(scene) => scene,
        Err(why) => return Ended::wrong(why.to_string()),
    };
    let nearest = |x: f64| (x / cell).round() as i64;
    let values: Vec<f64> = (scene.surface.positions().iter())
        .map(|p| at_vertex(nearest(p.x), nearest(p.y)))
        .collect();
    scene.stiffness = Stiffness::PerVertex(Arc::from(values));
    let mut drive = Drive::new(scene, DT_S);
    let mut stream = stream(size.seed, "chequered");
    drive.put(Vec3::Z * 20.0, Vec3::ZERO);
    for _ in 1..size.ticks {
        let at = pressed(&mut stream) * Vec3::new(45.0, 45.0, 20.0);
        let c = drive.put(at, Vec3::ZERO).contact;
        if at.z >= 0.0 {
            continue;
        }
        // The cell's triangles are (a, b, c) below its diagonal and (a, c, d) above.
        let (x, y) = (at.x / cell, at.y / cell);
        let (i, j) = (x.floor(), y.floor());
        let (u, v) = (x - i, y - j);
        let (i, j) = (i as i64, j as i64);
        let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(p, q)| at_vertex(i + p, j + q));
        let k = if u >= v {
            corners[0] * (1.0 - u) + corners[1] * (u - v) + corners[2] * v
        } else {
            corners[0] * (1.0 - v) + corners[3] * (v - u) + corners[2] * u
        };
        drive.expect(c.stiffness_n_per_mm, k, 1.0e-12, "stiffness");
        drive.expect(c.force_n.z, k * -at.z, 1.0e-10, "force");
    }
    match drive.fault {
        None => Ended::held(
            drive.tally,
            "barycentric stiffness in closed form, N/mm",
            drive.off * 1.0e-12,
            1.0e-12,
        ),
        fault => Ended::checked(drive.tally, "", fault),
    }
}

/// Every force model with numbers that no skin has.
fn extreme_models() -> Vec<(ForceModel, &'static str)> {
    let numbers = [
        (0.0, "0"),
        (f64::from_bits(1), "the least number"),
        (1.0e-9, "1e-9"),
        (1.0e9, "1e9"),
        (1.0e300, "1e300"),
        (-1.0, "negative"),
        (f64::INFINITY, "infinite"),
        (f64::NAN, "NaN"),
    ];
    let mut models = vec![(ForceModel::Linear, "")];
    for (x, name) in numbers {
        models.extend([
            (
                ForceModel::Nonlinear {
                    start_share: x,
                    trend_mm: x,
                },
                name,
            ),
            (ForceModel::Exponential { growth_per_mm: x }, name),
            (
                ForceModel::HuntCrossley {
                    damping_s_per_mm: x,
                    exponent: x,
                },
                name,
            ),
        ]);
    }
    models
}

/// Edits of the stiffness under a finger at rest.
fn edited(size: &Size) -> Ended {
    let made = scene(ordinary(50.0), Stiffness::Uniform(1.0));
    let first = match made {
        Ok(scene) => scene,
        Err(why) => return Ended::wrong(why.to_string()),
    };
    let mut drive = Drive::new(first.clone(), DT_S);
    let at = Vec3::new(3.0, 4.0, -3.0);
    drive.put(Vec3::Z * 20.0, Vec3::ZERO);
    let mut last_n = Vec3::ZERO;
    let mut largest_n = 0.0_f64;
    let mut settled = 0;
    for i in 1..size.ticks {
        // The first ticks bring the force up from nothing.
        if i > 20 && !drive.rig.is_fading() {
            settled += 1;
            let k = if settled % 2 == 0 { 1.0 } else { 1.0e6 };
            let scene = TouchScene {
                stiffness: Stiffness::Uniform(k),
                fading: None,
                ..first.clone()
            };
            drive.rig.edit_scene(settled, Box::new(scene));
        }
        let sent_n = drive.put(at, Vec3::ZERO).sent_force_n;
        if i > 20 {
            largest_n = largest_n.max(sent_n.distance(last_n));
        }
        last_n = sent_n;
    }
    Ended::held(
        drive.tally,
        "largest step of force, N",
        largest_n,
        crate::servo::MOST_STEP_N * (1.0 + 1.0e-9),
    )
}

/// The published engine, told apart: its faults are the publication's, but it must stay finite.
pub fn published_engine() -> Vec<Case> {
    let engine = |name: &str, mesh: fn() -> RawMesh, deep_mm: f64| {
        let seeded = name.to_owned();
        Case::new(
            format!("published engine, {name}"),
            DOOR,
            "anywhere on and in the plate",
            move |size| {
                let mut scene = match scene(mesh(), Stiffness::Uniform(1.0)) {
                    Ok(scene) => scene,
                    Err(why) => return Ended::refused(why),
                };
                let options = published::Options::default();
                let built = published::Published::build(&scene.surface, &options, &mut |_| true);
                scene.published = built.ok().flatten().map(Arc::new);
                let mut drive = Drive::new(scene, DT_S);
                let mut stream = stream(size.seed, &seeded);
                for _ in 0..size.ticks {
                    let at = pressed(&mut stream) * Vec3::new(45.0, 45.0, deep_mm);
                    drive.put(at, stream.vector() * 1.0e5);
                }
                Ended::bounded(drive.tally, "finite; its pop-throughs are told elsewhere")
            },
        )
    };
    vec![
        engine("needles of 1e9", || needles(1.0e9), 20.0),
        engine("1 m deep", || ordinary(50.0), 1.0e3),
    ]
}
