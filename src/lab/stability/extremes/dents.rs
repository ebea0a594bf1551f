//! Every deformation model under presses that no finger makes, and with settings that no skin has.

use super::drive::stream;
use super::elastic::dent;
use super::readings::ODD;
use super::row::{Case, Ended, Size, Tally};
use crate::deform::bones::{BoneSettings, Bones};
use crate::deform::footprint::Kind;
use crate::deform::models::fsmd::{Fsmd, Settings};
use crate::deform::strain::Strain;
use crate::deform::{self, Displacement, Model, Press};
use crate::geom::Vec3;
use crate::maps::bone::assumed_back_keys;
use crate::maps::{BoneMap, Oval};
use crate::partition::bvh::Bvh;
use crate::reference::continuum::Continuum;
use crate::reference::patch::{Patch, PatchOptions};
use crate::reference::slab::lattice::Stepping;
use crate::reference::slab::{SlabModel, elements, lattice};
use crate::reference::{self, Elastic, traction};
use crate::surface::Surface;
use crate::surface::torture::{Stream, grid, steps};
use std::slice::from_ref;
use std::sync::Arc;

const DOOR: &str = "deform::Model::update";

/// Every model and every setting of it.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, make) in deform::all() {
        cases.push(pressed(name, |_, _| Some(make())));
    }
    for kind in Kind::all() {
        cases.push(pressed(kind.name(), |_, _| {
            let own = Settings::default();
            Some(Box::new(Fsmd::new(Settings {
                footprint: *kind,
                half_minor_mm: 0.5 * own.half_major_mm,
                ..own
            })))
        }));
    }
    cases.push(pressed("fsmd over bones", |surface, _| {
        let map = BoneMap::new(assumed_back_keys()).ok()?;
        let bones = Bones::new(&map, surface, BoneSettings::default());
        Some(Box::new(Fsmd::new(Settings {
            bones: Some(Arc::new(bones)),
            ..Settings::default()
        })))
    }));
    for (name, make) in reference::all() {
        cases.push(pressed(name, |_, _| {
            let drag = traction::Gaussian::new(Elastic::MUSCLE, 3.5);
            Some(Box::new(Continuum::new(
                dent(name, *make),
                Some(drag),
                60.0,
            )))
        }));
    }
    for name in BODIES {
        cases.push(pressed(name, |surface, size| body(name, surface, size)));
    }
    for power in 0..=6 {
        let ratio = 10_f64.powi(power);
        cases.push(Case::new(
            format!("dent of ratio 1e{power}"),
            DOOR,
            "map ellipses of 1000 mm by that, presses anywhere",
            move |size| slender(size, ratio),
        ));
    }
    for (what, change) in SETTINGS {
        cases.push(Case::new(
            format!("settings: {what}"),
            "fsmd::Settings",
            "NaN, ±∞, 0, negative, 1e308, 5e-324",
            move |_| odd_settings(*change),
        ));
    }
    cases.push(Case::new(
        "needles and creases under a dent",
        DOOR,
        "a skin of needles of 1e9 and folds of 90°, presses anywhere",
        rough,
    ));
    cases.push(Case::new(
        "bones that are none",
        "Bones::new, limited, narrowing",
        "shares and depths NaN, ±∞, 0, negative; vertices that are none",
        |_| odd_bones(),
    ));
    cases
}

const BODIES: &[&str] = &[
    "fem-linear",
    "fem-condensed",
    "fem-pressed",
    "fem-corotated",
    "springs-rest",
    "springs-explicit",
    "springs-implicit",
    "xpbd",
];

/// What is changed of the settings, and how.
type Change = (&'static str, fn(&mut Settings, f64));

const SETTINGS: &[Change] = &[
    ("half_major_mm", |s, x| s.half_major_mm = x),
    ("half_minor_mm", |s, x| s.half_minor_mm = x),
    ("angle_rad", |s, x| s.angle_rad = x),
    ("normal_scale_shallow", |s, x| s.normal_scale_shallow = x),
    ("normal_scale_deep", |s, x| s.normal_scale_deep = x),
    ("max_normal_mm", |s, x| s.max_normal_mm = x),
    ("max_tangential_mm", |s, x| s.max_tangential_mm = x),
    ("all", |s, x| {
        (s.half_major_mm, s.half_minor_mm, s.angle_rad) = (x, x, x);
        (s.normal_scale_shallow, s.normal_scale_deep) = (x, x);
        (s.max_normal_mm, s.max_tangential_mm) = (x, x);
    }),
];

fn back() -> Surface {
    let made = Surface::new(super::scales::small_back().clone());
    made.unwrap_or_else(|_| unreachable!()).0
}

/// A flat skin, on which a slab can lie.
fn flat() -> Surface {
    let s = steps(-80.0, 80.0, 16);
    let made = Surface::new(grid(&s, &s, |_, _| 0.0));
    made.unwrap_or_else(|_| unreachable!()).0
}

fn body(name: &str, surface: &Surface, size: &Size) -> Option<Box<dyn Model>> {
    let options = PatchOptions {
        half_width_mm: 40.0,
        n_half: if size.quick { 1 } else { 3 },
        layers: 2,
        ..PatchOptions::default()
    };
    let search = Bvh::new(surface);
    let patch = Patch::new(surface, &search, Vec3::ZERO, Vec3::Z, options).ok()?;
    let m = Elastic::MUSCLE;
    let sprung = |stepping| lattice::springs(&patch, m, stepping).ok();
    let body = match name {
        "fem-linear" => elements::linear(&patch, m).ok(),
        "fem-condensed" => elements::condensed(&patch, m, &mut |_| true).ok().flatten(),
        "fem-pressed" => elements::pressed(&patch, m, 3.5, &mut |_| true)
            .ok()
            .flatten(),
        "fem-corotated" => elements::corotated(&patch, m, 1.0e-8).ok(),
        "springs-rest" => sprung(Stepping::Rest),
        "springs-explicit" => sprung(Stepping::Explicit(40)),
        "springs-implicit" => sprung(Stepping::Implicit(10)),
        _ => sprung(Stepping::Position(10, 1, 10)),
    };
    Some(Box::new(SlabModel::new(patch, body?, 3.5)))
}

/// An ordinary press somewhere.
fn press(surface: &Surface, stream: &mut Stream) -> Press {
    let n = surface.triangles().len();
    let triangle = (stream.unit().abs() * n as f64) as usize % n;
    let shape = surface.triangle(triangle as u32);
    let normal = shape.normal();
    let drag = stream.vector() * 4.0;
    let anchor_mm = shape.centroid();
    Press {
        anchor_mm,
        foot_mm: anchor_mm + drag - normal * drag.dot(normal),
        normal,
        depth_mm: 2.0 + 1.9 * stream.unit(),
        triangle: triangle as u32,
        oval: None,
        boundary_mm: None,
    }
}

/// A part of a press replaced.
type Spoil = fn(&mut Press, f64);

const SPOILS: [(&str, Spoil); 12] = [
    ("anchor x", |p, x| p.anchor_mm.x = x),
    ("anchor", |p, x| p.anchor_mm = Vec3::splat(x)),
    ("foot z", |p, x| p.foot_mm.z = x),
    ("foot", |p, x| p.foot_mm = Vec3::splat(x)),
    ("normal y", |p, x| p.normal.y = x),
    ("normal", |p, x| p.normal = Vec3::splat(x)),
    ("depth", |p, x| p.depth_mm = x),
    ("triangle", |p, x| p.triangle = x as u32),
    ("half major", |p, x| {
        p.oval = Some(Oval {
            half_major_mm: x,
            half_minor_mm: 5.0,
            angle_rad: 0.0,
        });
    }),
    ("half minor", |p, x| {
        p.oval = Some(Oval {
            half_major_mm: 50.0,
            half_minor_mm: x,
            angle_rad: 0.0,
        });
    }),
    ("angle", |p, x| {
        p.oval = Some(Oval {
            half_major_mm: 50.0,
            half_minor_mm: 20.0,
            angle_rad: x,
        });
    }),
    ("boundary", |p, x| {
        p.boundary_mm = Some(Arc::from(vec![x; 16]))
    }),
];

fn count(surface: &Surface, shape: &Displacement, tally: &mut Tally) -> f64 {
    let mut largest = 0.0_f64;
    for v in 0..surface.positions().len() as u32 {
        let offset = shape.offset_mm(v);
        tally.lengths(offset.to_array());
        tally.numbers(shape.normal(v).to_array());
        largest = largest.max(offset.length());
    }
    largest
}

/// A model and how it is made for a surface.
fn pressed(
    name: &'static str,
    make: impl Fn(&Surface, &Size) -> Option<Box<dyn Model>> + 'static,
) -> Case {
    Case::new(
        format!("{name} under presses that are none"),
        DOOR,
        "every part of a press NaN, ±∞, 1e308, 5e-324; 1 m and 1 km deep; alone and beside a sound one",
        move |size| {
            // A slab lies under a flat skin.
            let slab = BODIES.contains(&name);
            spoilt(size, if slab { flat() } else { back() }, &make)
        },
    )
}

fn spoilt(
    size: &Size,
    surface: Surface,
    make: &impl Fn(&Surface, &Size) -> Option<Box<dyn Model>>,
) -> Ended {
    let Some(mut model) = make(&surface, size) else {
        return Ended::wrong("the model is not made");
    };
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, model.name());
    let mut shape = Displacement::at_rest(&surface);
    let mut strain = Strain::new(&surface, &shape);
    // A nonlinear slab takes its time.
    let dear = [
        "fem-corotated",
        "springs-rest",
        "springs-implicit",
        "xpbd",
        "layer",
    ];
    let dear = dear.contains(&model.name());
    let odd: &[f64] = match (size.quick, dear) {
        (true, true) => &ODD[..1],
        (true, false) => &ODD[..3],
        (false, true) => &ODD[..4],
        (false, false) => &ODD,
    };
    let mut fault = None;
    for (what, spoil) in SPOILS {
        for x in odd {
            let sound = press(&surface, &mut stream);
            let mut bad = sound.clone();
            spoil(&mut bad, *x);
            model.update_strained(&surface, from_ref(&bad), &mut shape, &mut strain);
            let alone = count(&surface, &shape, &mut tally);
            tally.numbers(strain.values().iter().copied());
            // What is no place, depth or direction moves nothing.
            let vital =
                !what.starts_with("half") && !["angle", "boundary", "triangle"].contains(&what);
            if vital && !x.is_finite() && alone > 0.0 {
                fault.get_or_insert(format!("{what} of {x} moves the skin by {alone} mm"));
            }
            if what != "triangle" && !dear {
                model.update(&surface, &[bad, sound.clone()], &mut shape);
                count(&surface, &shape, &mut tally);
            }
        }
    }
    // Whatever was there before, a sound press alone is what it is on a fresh skin.
    let sound = press(&surface, &mut stream);
    model.update(&surface, from_ref(&sound), &mut shape);
    let Some(mut fresh) = make(&surface, size) else {
        return Ended::wrong("the model is not made twice");
    };
    let mut other = Displacement::at_rest(&surface);
    fresh.update(&surface, &[sound], &mut other);
    let mut off = 0.0_f64;
    for v in 0..surface.positions().len() as u32 {
        off = off.max(shape.offset_mm(v).distance(other.offset_mm(v)));
    }
    match fault {
        None => Ended::held(
            tally,
            "a sound press after them, against a fresh skin, mm",
            off,
            0.0,
        ),
        fault => Ended::checked(tally, "", fault),
    }
}

/// Presses with ellipses from round to a line.
fn slender(size: &Size, ratio: f64) -> Ended {
    let surface = back();
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, "slender");
    let mut fault = None;
    for kind in [Kind::Ellipse, Kind::EllipsePrinted] {
        let own = Settings {
            footprint: kind,
            ..Settings::default()
        };
        let most_mm = own.max_normal_mm + own.max_tangential_mm;
        let mut model = Fsmd::new(own);
        let mut shape = Displacement::at_rest(&surface);
        for _ in 0..(size.questions / 400).max(3) {
            let mut press = press(&surface, &mut stream);
            // At a corner, which is in every footprint.
            press.anchor_mm = surface.triangle(press.triangle).a;
            press.foot_mm = press.anchor_mm;
            press.oval = Some(Oval {
                half_major_mm: 1000.0,
                half_minor_mm: 1000.0 / ratio,
                angle_rad: 3.0 * stream.unit(),
            });
            let depth_mm = press.depth_mm;
            model.update(&surface, &[press], &mut shape);
            let largest = count(&surface, &shape, &mut tally);
            if (largest - depth_mm).abs() > 1.0e-9 || largest > most_mm {
                fault.get_or_insert(format!("{largest} mm under a press of {depth_mm} mm"));
            }
        }
    }
    Ended::checked(
        tally,
        "as deep as pressed under the finger, nowhere deeper",
        fault,
    )
}

fn odd_settings(change: fn(&mut Settings, f64)) -> Ended {
    let surface = back();
    let mut tally = Tally::default();
    let mut stream = stream(0, "settings");
    let mut fault = None;
    for x in ODD.into_iter().chain([0.0, -1.0]) {
        for kind in Kind::all() {
            let mut settings = Settings {
                footprint: *kind,
                ..Settings::default()
            };
            change(&mut settings, x);
            let caps = settings.max_normal_mm.max(0.0) + settings.max_tangential_mm.max(0.0);
            let mut model = Fsmd::new(settings.clone());
            let mut shape = Displacement::at_rest(&surface);
            for _ in 0..2 {
                let mut press = press(&surface, &mut stream);
                press.depth_mm = 30.0;
                press.foot_mm = press.anchor_mm + press.normal.any_orthogonal_vector() * 60.0;
                let [wide, narrow] = settings.outlines(&surface, &press, 16);
                tally.numbers(wide.iter().chain(&narrow).flat_map(|p| p.to_array()));
                model.update(&surface, &[press], &mut shape);
                let largest = count(&surface, &shape, &mut tally);
                if largest > caps * (1.0 + 1.0e-12) {
                    fault.get_or_insert(format!("{largest} mm, caps of {caps} mm"));
                }
            }
        }
    }
    Ended::checked(
        tally,
        "within the caps; what is no cap moves nothing",
        fault,
    )
}

fn rough(size: &Size) -> Ended {
    let mut xs = vec![-60.0];
    for middle in [-30.0, 0.0, 30.0] {
        xs.extend((0..4).map(|i| middle + f64::from(i) * 1.2e-7));
    }
    xs.push(60.0);
    let made = Surface::new(grid(&xs, &steps(-60.0, 60.0, 6), |x, _| x.abs()));
    let surface = match made {
        Ok((surface, _)) => surface,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, "rough");
    let mut model = Fsmd::new(Settings::default());
    let mut shape = Displacement::at_rest(&surface);
    let mut strain = Strain::new(&surface, &shape);
    let mut fault = None;
    for _ in 0..(size.questions / 100).max(10) {
        let press = press(&surface, &mut stream);
        model.update_strained(&surface, &[press], &mut shape, &mut strain);
        let largest = count(&surface, &shape, &mut tally);
        tally.numbers(strain.values().iter().copied());
        if largest > 30.0 {
            fault.get_or_insert(format!("{largest} mm, caps of 30 mm"));
        }
    }
    match fault {
        None => Ended::bounded(tally, "offsets within the caps; normals and strains finite"),
        fault => Ended::checked(tally, "", fault),
    }
}

fn odd_bones() -> Ended {
    let surface = back();
    let Ok(map) = BoneMap::new(assumed_back_keys()) else {
        return Ended::wrong("no bones");
    };
    let mut tally = Tally::default();
    let mut fault = None;
    for x in ODD.into_iter().chain([0.0, -1.0]) {
        let settings = BoneSettings {
            dent_share: x,
            reference_depth_mm: x,
        };
        let bones = Bones::new(&map, &surface, settings);
        for v in [0, 5, u32::MAX] {
            for length in [0.0, 5.0, 1.0e3] {
                tally.lengths(bones.limited(v, Vec3::Z * -length).to_array());
            }
        }
        for at in [Vec3::splat(x), surface.positions()[3]] {
            for t in [0, u32::MAX] {
                let share = bones.narrowing(&surface, t, at);
                tally.numbers([share]);
                if !(0.3 - 1.0e-12..=1.0).contains(&share) {
                    fault.get_or_insert(format!("narrowed to {share}"));
                }
            }
        }
    }
    Ended::checked(
        tally,
        "limits finite, a footprint narrowed to 0.3 … 1",
        fault,
    )
}
