//! The built-in back in other sizes: nothing but the unit of length may change.

use super::drive::{DT_S, Drive, pressed, scene, stream};
use super::row::{Case, Ended, Size};
use crate::contact::{Friction, Shading, Stiffness, Touch, TouchScene};
use crate::deform::models::fsmd::{Fsmd, Settings};
use crate::deform::{Displacement, Model as _, Press};
use crate::geom::{Vec2, Vec3};
use crate::partition::{Partition as _, Sides};
use crate::servo::Limits;
use crate::surface::RawMesh;
use crate::surface::back::{BackOptions, make};
use std::sync::OnceLock;

const TRIANGLES: usize = 900;

/// Every size under every finger.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for power in -6..=6 {
        for (name, friction, pad_mm, shaded) in [
            ("point", false, 0.0, false),
            ("shaded point", false, 0.0, true),
            ("friction", true, 0.0, false),
            ("pad of 6 mm", false, 6.0, false),
        ] {
            if power == 0 {
                continue;
            }
            // Where a pad waits for the next tick hangs on its last bits: powers of two leave them as they are.
            let binary = (f64::from(power) * std::f64::consts::LOG2_10).round() as i32;
            let (scale, told) = if pad_mm > 0.0 {
                (2_f64.powi(binary), format!("2^{binary}"))
            } else {
                (10_f64.powi(power), format!("1e{power}"))
            };
            cases.push(Case::new(
                format!("back × {told}, {name}"),
                "servo::tick",
                "the same walk in both sizes, at 5 m/s times the scale",
                move |size| lockstep(scale, friction, pad_mm, shaded, size),
            ));
        }
        if power != 0 {
            cases.push(Case::new(
                format!("back × 1e{power}, drawn dent"),
                "deform::Model::update",
                "the same presses in both sizes",
                move |size| drawn(10_f64.powi(power), size),
            ));
        }
    }
    cases
}

/// The built-in back of few triangles, made once.
pub fn small_back() -> &'static RawMesh {
    static MADE: OnceLock<RawMesh> = OnceLock::new();
    MADE.get_or_init(|| make(&BackOptions::with_triangles(TRIANGLES)))
}

fn back(scale: f64) -> Result<TouchScene, crate::surface::MeshError> {
    let mut raw = small_back().clone();
    raw.positions.iter_mut().for_each(|p| *p *= scale);
    scene(raw, Stiffness::Uniform(0.5))
}

/// Both backs in step; lengths and forces over the scale must agree.
fn lockstep(scale: f64, friction: bool, pad_mm: f64, shaded: bool, size: &Size) -> Ended {
    let make = |scale: f64| {
        let mut scene = back(scale)?;
        scene.friction = friction.then_some(Friction {
            static_coefficient: 0.46,
            dynamic_coefficient: 0.44,
            skin_looseness: 1.0,
        });
        scene.choices.finger_radius_mm = pad_mm * scale;
        if shaded {
            scene.shading = Some(Shading::of(&scene.surface));
        }
        let limits = Limits {
            rated_force_n: 22.0 * scale,
            rise_n_per_s: 4400.0 * scale,
            ..Limits::default()
        };
        Ok::<_, crate::surface::MeshError>(Drive::with_limits(scene, limits, DT_S))
    };
    let (mut one, mut other) = match (make(1.0), make(scale)) {
        (Ok(one), Ok(other)) => (one, other),
        (_, Err(why)) | (Err(why), _) => return Ended::refused(why),
    };
    let mut stream = stream(size.seed, "scale");
    let mut at = Vec3::new(20.0, 200.0, 300.0);
    let mut goal = at;
    let mut differ = 0_u64;
    for _ in 0..size.ticks / 2 {
        if at == goal {
            let there = stream.vector() * Vec3::new(100.0, 160.0, 0.0);
            let over = there + Vec3::new(0.0, 230.0, 500.0);
            let under = Vec3::new(over.x, over.y, -500.0);
            let surface = &one.rig.scene.surface;
            let hit = (one.rig.scene.search).sweep(surface, over, under, Sides::Front);
            let skin = hit.map_or(over, |h| h.point);
            goal = skin + Vec3::Z * (pad_mm + 25.0 * pressed(&mut stream).z);
        }
        at += (goal - at).clamp_length_max(5.0);
        if at.distance(goal) < 1.0e-9 {
            at = goal;
        }
        let a = one.put(at, Vec3::ZERO);
        let b = other.put(at * scale, Vec3::ZERO);
        let off = [
            (a.contact.anchor_mm, b.contact.anchor_mm),
            (a.contact.foot_mm, b.contact.foot_mm),
            (a.contact.force_n, b.contact.force_n),
            (a.sent_force_n, b.sent_force_n),
        ]
        .map(|(p, q)| p.distance(q / scale));
        let off = off.into_iter().fold(0.0, f64::max);
        // On the border between two triangles, rounding may choose either.
        let same = (a.contact.touch == Touch::Free) == (b.contact.touch == Touch::Free);
        one.must(same, || format!("free in one size only, at {at}"));
        one.off = one.off.max(off);
        differ += u64::from(off > 1.0e-9);
    }
    let mut tally = one.tally;
    tally.add(&other.tally);
    if let Some(fault) = one.fault.or(other.fault) {
        return Ended::checked(tally, "", Some(fault));
    }
    let mut ended = Ended::held(tally, "scale 1, mm and N over the scale", one.off, 1.0e-7);
    if differ > 0 {
        ended.says += &format!("; beyond 1e-9 in {differ} ticks");
    }
    ended
}

/// The drawn dent in both sizes.
fn drawn(scale: f64, size: &Size) -> Ended {
    let (one, other) = match (back(1.0), back(scale)) {
        (Ok(one), Ok(other)) => (one, other),
        (_, Err(why)) | (Err(why), _) => return Ended::refused(why),
    };
    let settings = |scale: f64| {
        let own = Settings::default();
        Settings {
            half_major_mm: own.half_major_mm * scale,
            half_minor_mm: 0.7 * own.half_minor_mm * scale,
            max_normal_mm: own.max_normal_mm * scale,
            max_tangential_mm: own.max_tangential_mm * scale,
            ..own
        }
    };
    let mut models = [1.0, scale].map(|s| Fsmd::new(settings(s)));
    let mut shapes = [&one, &other].map(|s| Displacement::at_rest(&s.surface));
    let mut tally = super::row::Tally::default();
    let mut stream = stream(size.seed, "drawn");
    let mut off = 0.0_f64;
    // Vertices and triangles are numbered along a curve whose cells rounding may shift.
    let [at_one, at_other] = [&one, &other].map(|s| s.surface.positions());
    let twins: Vec<u32> = (at_one.iter())
        .map(|p| {
            let to = |q: &Vec3| q.distance_squared(*p * scale);
            let order = |a: &usize, b: &usize| to(&at_other[*a]).total_cmp(&to(&at_other[*b]));
            (0..at_other.len()).min_by(order).unwrap_or(0) as u32
        })
        .collect();
    let same = |corners: [u32; 3]| {
        let mut sorted = corners;
        sorted.sort_unstable();
        sorted
    };
    let twin_of = |t: u32| {
        let corners = same(one.surface.triangles()[t as usize].map(|v| twins[v as usize]));
        let all = other.surface.triangles();
        all.iter().position(|t| same(*t) == corners)
    };
    for _ in 0..(size.questions / 200).max(5) {
        let at = Vec2::new(80.0 * stream.unit(), 230.0 + 150.0 * stream.unit());
        let (over, under) = (at.extend(500.0), at.extend(-500.0));
        let Some(hit) = one.search.sweep(&one.surface, over, under, Sides::Front) else {
            continue;
        };
        let normal = one.surface.triangle(hit.triangle).normal();
        let depth_mm = 8.0 + 7.0 * stream.unit();
        let drag = stream.vector() * 5.0;
        let Some(twin) = twin_of(hit.triangle) else {
            return Ended::wrong("a triangle is missing in the other size");
        };
        let press = |scale: f64, triangle: u32| Press {
            anchor_mm: hit.point * scale,
            foot_mm: (hit.point + drag - normal * drag.dot(normal)) * scale,
            normal,
            depth_mm: depth_mm * scale,
            triangle,
            ..Press::default()
        };
        for ((model, shape), (scene, s, t)) in models
            .iter_mut()
            .zip(&mut shapes)
            .zip([(&one, 1.0, hit.triangle), (&other, scale, twin as u32)])
        {
            model.update(&scene.surface, &[press(s, t)], shape);
        }
        let [a, b] = &shapes;
        for (v, &twin) in twins.iter().enumerate() {
            let (p, q) = (a.offset_mm(v as u32), b.offset_mm(twin) / scale);
            // A vertex on the rim may be inside in one size only; there the offset is nearly nothing.
            off = off.max(p.distance(q));
            tally.lengths(q.to_array());
            tally.numbers(b.normal(twin).to_array());
        }
    }
    Ended::held(tally, "scale 1, mm over the scale", off, 1.0e-9)
}
