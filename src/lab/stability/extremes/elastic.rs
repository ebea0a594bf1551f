//! Yardsticks of elasticity at the edge of their materials: nearly incompressible, very soft, very hard, very far, folded.

use super::readings::ODD;
use super::row::{Case, Ended, Size, Tally};
use crate::geom::{Vec2, Vec3};
use crate::partition::bvh::Bvh;
use crate::reference::fem::linear::{Fixed, Linear, SolveError, skin_forces};
use crate::reference::fem::mesh::Slab;
use crate::reference::fem::{Corotated, graded};
use crate::reference::half_space::{Disc, Gaussian, Sphere};
use crate::reference::layer::Bonded;
use crate::reference::membrane::Tensed;
use crate::reference::patch::{Patch, PatchOptions};
use crate::reference::springs::Lattice;
use crate::reference::springs::motion::Motion;
use crate::reference::springs::rest::rest;
use crate::reference::springs::xpbd::Xpbd;
use crate::reference::{self, Dent, Elastic, traction};
use crate::surface::Surface;
use crate::surface::torture::{grid, steps};
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

/// Poisson's ratios up to incompressible.
const RATIOS: [f64; 6] = [0.0, 0.45, 0.49, 0.499, 0.4999, 0.5];

/// Closed forms, finite elements, springs.
pub fn cases() -> Vec<Case> {
    let mut cases = vec![Case::new(
        "materials that are none",
        "Elastic::new",
        "E of NaN, ±∞, 0, negative, 1e308; ν of NaN, ±∞, −0.1, 0.5000001, 1",
        |_| bad_materials(),
    )];
    for (name, make) in reference::all() {
        cases.push(Case::new(
            format!("{name} at no depth and no place"),
            "Dent::at_mm, force_n",
            "NaN, ±∞, 0, negative, 1e308, 5e-324 as depth and distance",
            move |_| odd_dent(&[&*dent(name, *make)]),
        ));
    }
    cases.push(Case::new(
        "loads and layers of no size",
        "half_space, layer, membrane, traction",
        "NaN, ±∞, 0, negative, 1e308, 5e-324 as size; E of 1e-300 and 1e9 kPa",
        odd_sizes,
    ));
    type Make = fn(Elastic) -> Box<dyn Dent>;
    let far: [(&str, Make); 3] = [
        ("Gaussian", |m| Box::new(Gaussian::new(m, 3.5))),
        ("disc", |m| Box::new(Disc::new(m, 7.0))),
        ("sphere", |m| Box::new(Sphere::new(m, 8.0))),
    ];
    for (name, make) in far {
        cases.push(Case::new(
            format!("half-space, {name}, up to 1000 km away"),
            "Dent::at_mm",
            "depths 1e-9 … 1e3 mm, distances up to 1e9 mm",
            move |_| far_field(&*make(Elastic::MUSCLE)),
        ));
        for nu in RATIOS {
            cases.push(Case::new(
                format!("half-space, {name}, ν = {nu}"),
                "Dent::force_n",
                "force over E* against ν = 0",
                move |_| half_space(make, nu),
            ));
        }
    }
    for nu in RATIOS {
        cases.push(Case::new(
            format!("bonded layer, ν = {nu}"),
            "layer::Bonded",
            "stiffness of layers of 5, 20 and 40 mm",
            move |size| layer(size, nu),
        ));
        cases.push(Case::new(
            format!("finite elements, ν = {nu}"),
            "fem::Linear, fem::Corotated",
            "a Gaussian press on a layer of 20 mm",
            move |size| elements(size, nu),
        ));
    }
    for power in [-300, -6, 6, 9] {
        cases.push(Case::new(
            format!("finite elements, E = 1e{power} kPa"),
            "fem::Linear",
            "displacement times E against muscle",
            move |_| other_modulus(10_f64.powi(power)),
        ));
    }
    cases.push(Case::new(
        "slabs that are none",
        "Slab::flat, Linear::new",
        "NaN, ±∞, 0, negative as thickness and as a line; 1 × 1 points; 1e9 points",
        |_| bad_slabs(),
    ));
    cases.push(Case::new(
        "patches that are none",
        "Patch::new",
        "NaN, ±∞, 0, negative as width, thickness, place and normal",
        |_| bad_patches(),
    ));
    cases.push(Case::new(
        "springs of 1e-6 … 1e6 N/mm side by side",
        "Motion::step_implicit, Xpbd::step, springs::rest",
        "in turn over a lattice, 0.1 N on its middle, steps of 1e-6 … 10 s",
        stiff_lattice,
    ));
    cases.push(Case::new(
        "springs of no length, points of no mass",
        "Motion, Xpbd, springs::rest",
        "two points in one place, mass 0, steps of 0, NaN, ∞ and negative",
        |_| odd_lattice(),
    ));
    cases
}

/// A yardstick by name. The layer is tabulated when made, so it is made once.
pub fn dent(name: &str, make: fn() -> Box<dyn Dent>) -> Arc<dyn Dent> {
    static LAYER: OnceLock<Arc<dyn Dent>> = OnceLock::new();
    if name == "layer" {
        Arc::clone(LAYER.get_or_init(|| Arc::from(make())))
    } else {
        Arc::from(make())
    }
}

fn material(nu: f64) -> Elastic {
    Elastic::new(25.0, nu).unwrap_or(Elastic::MUSCLE)
}

fn bad_materials() -> Ended {
    let mut tried = Vec::new();
    for e in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -1.0,
        1.0e308,
    ] {
        tried.push((format!("E = {e}"), Elastic::new(e, 0.45).map(|_| ())));
    }
    for nu in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        -0.1,
        0.500_000_1,
        1.0,
    ] {
        tried.push((format!("ν = {nu}"), Elastic::new(25.0, nu).map(|_| ())));
    }
    Ended::all_refused(tried)
}

fn odd_dent(dents: &[&dyn Dent]) -> Ended {
    let mut tally = Tally::default();
    let mut fault = None;
    let mut say = |words: String| {
        fault.get_or_insert(words);
    };
    for dent in dents {
        let name = dent.name();
        let odd = || ODD.into_iter().chain([0.0, -1.0, 1.0e-300, 1.0e300]);
        for depth_mm in odd().chain([1.0e-9, 1.0, 1.0e3]) {
            // A force of 1e308 mm runs over; a skin does not go there.
            let force_n = dent.force_n(depth_mm);
            if depth_mm.is_nan() || depth_mm.abs() < 1.0e150 {
                tally.numbers([force_n]);
            }
            let none = !(depth_mm > 0.0 && depth_mm.is_finite());
            if none && force_n != 0.0 {
                say(format!(
                    "{name}: {force_n:e} N at a depth of {depth_mm:e} mm"
                ));
            }
            for r_mm in odd().chain([1.0, 50.0, 1.0e6]) {
                let u = dent.at_mm(depth_mm, r_mm);
                tally.lengths([u]);
                if none && u != 0.0 {
                    say(format!("{name}: {u:e} mm at a depth of {depth_mm:e} mm"));
                }
                // No closed form here rises above its middle; a bonded layer bulges by a few percent.
                let most = depth_mm.max(0.0) * (1.0 + 1.0e-9) + 1.0e-300;
                if u.abs() > most || u < -0.05 * most {
                    say(format!(
                        "{name}: {u:e} mm at {r_mm:e} mm for {depth_mm:e} mm"
                    ));
                }
            }
        }
    }
    Ended::checked(
        tally,
        "nothing where there is none, never deeper than in the middle",
        fault,
    )
}

fn odd_sizes(size: &Size) -> Ended {
    let sizes: Vec<f64> = ODD.into_iter().chain([0.0, -1.0]).collect();
    let mut dents: Vec<Box<dyn Dent>> = Vec::new();
    let mut tally = Tally::default();
    for e_kpa in [1.0e-300, 25.0, 1.0e9] {
        let Ok(m) = Elastic::new(e_kpa, 0.4999) else {
            return Ended::wrong(format!("E = {e_kpa} kPa is refused"));
        };
        for (i, x) in sizes.iter().enumerate() {
            dents.push(Box::new(Gaussian::new(m, *x)));
            dents.push(Box::new(Disc::new(m, *x)));
            dents.push(Box::new(Sphere::new(m, *x)));
            dents.push(Box::new(Tensed::new(*x, 7.0, 0.002)));
            dents.push(Box::new(Tensed::new(5.0, *x, *x)));
            // A layer is tabulated when made: dear.
            if e_kpa == 25.0 && i < 2 && !size.quick {
                dents.push(Box::new(Bonded::new(m, *x, 20.0)));
                dents.push(Box::new(Bonded::new(m, 3.5, *x)));
            }
            let drag = traction::Gaussian::new(m, *x);
            for y in &sizes {
                let moved = drag.at_mm(Vec2::new(*y, 1.0), Vec2::new(1.0, *y));
                if y.is_nan() || y.abs() < 1.0e150 {
                    tally.lengths(moved.to_array());
                }
            }
        }
    }
    let dents: Vec<&dyn Dent> = dents.iter().map(|d| &**d).collect();
    let mut ended = odd_dent(&dents);
    ended.tally.add(&tally);
    ended
}

/// Far from its load every dent of a half-space is that of a point force, F/(π E* r).
fn far_field(dent: &dyn Dent) -> Ended {
    let e = Elastic::MUSCLE.plane_strain_n_per_mm2();
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    let mut where_off = [0.0; 2];
    for depth_power in -9..=3 {
        let depth_mm = 10_f64.powi(depth_power);
        let point = dent.force_n(depth_mm) / (PI * e);
        for r_power in 3..=9 {
            let r_mm = 10_f64.powi(r_power);
            let u = dent.at_mm(depth_mm, r_mm);
            tally.lengths([u]);
            // What is left of the load's breadth: at most (8000/r²) of a sphere a metre deep.
            let breadth = 1.0e4 / (r_mm * r_mm);
            let wrong = ((u * r_mm / point - 1.0).abs() - breadth).max(0.0);
            if wrong > off || wrong.is_nan() {
                off = if wrong.is_nan() { f64::INFINITY } else { wrong };
                where_off = [depth_mm, r_mm];
            }
        }
    }
    let mut ended = Ended::held(tally, "a point force, as a share", off, 1.0e-9);
    if off > 1.0e-9 {
        ended.says += &format!(" at {} mm from {} mm", where_off[1], where_off[0]);
    }
    ended
}

fn half_space(make: fn(Elastic) -> Box<dyn Dent>, nu: f64) -> Ended {
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    for depth_mm in [0.1, 2.0, 10.0] {
        let [a, b] = [0.0, nu].map(|nu| make(material(nu)).force_n(depth_mm));
        tally.numbers([a, b]);
        off = off.max((b * (1.0 - nu * nu) / a - 1.0).abs());
    }
    Ended::held(tally, "F (1 − ν²) as at ν = 0, as a share", off, 1.0e-12)
}

/// The layer's integral by another way: Simpson's rule, hyperbolic functions as printed.
fn layer_stiffness(m: Elastic, s: f64, h: f64) -> f64 {
    let kappa = 3.0 - 4.0 * m.nu();
    let integrand = |k: f64| {
        let w = k * h;
        let g = if w < 1.0e-9 {
            0.0
        } else if w > 300.0 {
            1.0
        } else {
            let over = 2.0 * kappa * libm::sinh(2.0 * w) - 4.0 * w;
            let under = 2.0 * kappa * libm::cosh(2.0 * w) + 1.0 + kappa * kappa + 4.0 * w * w;
            over / under
        };
        libm::exp(-0.5 * k * k * s * s) * g
    };
    let (n, end) = (40_000, 9.0 / s);
    let step = end / f64::from(n);
    let sum: f64 = (0..=n)
        .map(|i| {
            let weight = match i {
                0 => 1.0,
                _ if i == n => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * integrand(step * f64::from(i))
        })
        .sum();
    m.plane_strain_n_per_mm2() * PI / (sum * step / 3.0)
}

fn layer(size: &Size, nu: f64) -> Ended {
    let m = material(nu);
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    let all = [5.0, 20.0, 40.0];
    for h in &all[..if size.quick { 1 } else { 3 }] {
        let h = *h;
        let found = Bonded::new(m, 3.5, h).force_n(1.0);
        tally.numbers([found]);
        off = off.max((found / layer_stiffness(m, 3.5, h) - 1.0).abs());
    }
    Ended::held(
        tally,
        "Simpson's rule on the printed form, as a share",
        off,
        1.0e-9,
    )
}

/// A quarter of a layer, finer under the press.
fn quarter(size: &Size) -> Option<Slab> {
    let n = if size.quick { 5 } else { 12 };
    let thick_mm = thick_mm(size);
    let lines = graded(n, 4.0 * thick_mm, 12.0);
    let m = if size.quick { 3 } else { 8 };
    let depths: Vec<f64> = (0..=m).map(|i| f64::from(i) / f64::from(m)).collect();
    Slab::flat(&lines, &lines, &depths, thick_mm).ok()
}

/// Thickness of the layer, mm: the closed form of a thin one is quickly tabulated.
fn thick_mm(size: &Size) -> f64 {
    if size.quick { 6.0 } else { 20.0 }
}

const QUARTER: [Fixed; 4] = [Fixed::Mirror, Fixed::Held, Fixed::Mirror, Fixed::Held];
const PRESS_SD_MM: f64 = 6.0;

fn gaussian_press(slab: &Slab) -> Vec<(usize, Vec3)> {
    let unit = 1.0 / (2.0 * PI * PRESS_SD_MM * PRESS_SD_MM);
    skin_forces(slab, |at: Vec3| {
        let r_sq = at.x * at.x + at.y * at.y;
        Vec3::NEG_Z * (unit * libm::exp(-r_sq / (2.0 * PRESS_SD_MM * PRESS_SD_MM)))
    })
}

fn elements(size: &Size, nu: f64) -> Ended {
    let Some(slab) = quarter(size) else {
        return Ended::wrong("no slab");
    };
    let solved = |nu: f64| -> Result<f64, SolveError> {
        let linear = Linear::new(slab.clone(), material(nu), QUARTER)?;
        Ok(-linear.displacements_mm(&gaussian_press(&slab))[0].z)
    };
    let closed =
        |nu: f64| 1.0 / Bonded::new(material(nu), PRESS_SD_MM, thick_mm(size)).force_n(1.0);
    let (at, usual) = match (solved(nu), solved(0.3)) {
        (Ok(at), Ok(usual)) => (at, usual),
        (Err(why), _) | (_, Err(why)) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    tally.lengths([at, usual]);
    let [off, off_usual] = [at / closed(nu) - 1.0, usual / closed(0.3) - 1.0];
    // Bricks this coarse are some percent off. A locking one would be several times as stiff.
    if let Err(wrong) = turned_agree(size, &slab, nu, at, &mut tally) {
        return wrong;
    }
    let says = format!(
        "the layer's closed form: off by {:.1} %, {:.1} % at ν = 0.3 with the same bricks",
        100.0 * off,
        100.0 * off_usual
    );
    if off.abs() <= 2.0 * off_usual.abs() + 0.05 {
        Ended::checked(tally, &says, None)
    } else {
        Ended::wrong(says)
    }
}

/// Bricks that turn, under a load too small to turn them, against those that do not. Dear: not in a quick look.
fn turned_agree(
    size: &Size,
    slab: &Slab,
    nu: f64,
    at_mm: f64,
    tally: &mut Tally,
) -> Result<(), Ended> {
    if size.quick {
        return Ok(());
    }
    let share = 1.0e-3;
    let small: Vec<(usize, Vec3)> = gaussian_press(slab)
        .into_iter()
        .map(|(i, f)| (i, f * share))
        .collect();
    let turned = Corotated::new(slab.clone(), material(nu), QUARTER);
    let found = turned.and_then(|mut turned| turned.solve(&small, 1, 1.0e-9));
    let found = found.map_err(Ended::refused)?;
    let depth_mm = -found.displacements_mm[0].z;
    tally.lengths([depth_mm]);
    let off = depth_mm / (at_mm * share) - 1.0;
    if off.abs() > 1.0e-3 || found.residual > 1.0e-6 {
        return Err(Ended::wrong(format!("corotated off by {off} at 1 mN")));
    }
    Ok(())
}

fn other_modulus(e_kpa: f64) -> Ended {
    let look = Size {
        ticks: 0,
        questions: 0,
        quick: true,
        seed: 0,
    };
    let Some(slab) = quarter(&look) else {
        return Ended::wrong("no slab");
    };
    let Ok(m) = Elastic::new(e_kpa, 0.45) else {
        return Ended::wrong(format!("E = {e_kpa} kPa is refused"));
    };
    let solved = |m: Elastic| {
        let linear = Linear::new(slab.clone(), m, QUARTER)?;
        Ok::<_, SolveError>(linear.displacements_mm(&gaussian_press(&slab)))
    };
    let (a, b) = match (solved(Elastic::MUSCLE), solved(m)) {
        (Ok(a), Ok(b)) => (a, b),
        (_, Err(why)) | (Err(why), _) => return Ended::refused(why),
    };
    let scale = m.e_n_per_mm2() / Elastic::MUSCLE.e_n_per_mm2();
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    for (a, b) in a.iter().zip(&b) {
        tally.numbers(b.to_array());
        off = off.max((*b * scale).distance(*a));
    }
    Ended::held(tally, "u E as in muscle, mm at 1 N", off, 1.0e-7)
}

fn bad_slabs() -> Ended {
    let mut tried: Vec<(String, Result<(), String>)> = Vec::new();
    let solve = |slab: Slab| Linear::new(slab, Elastic::MUSCLE, [Fixed::Held; 4]).map(|_| ());
    let lines = [0.0, 1.0, 2.0];
    for x in [f64::NAN, f64::INFINITY, 0.0, -1.0, 5.0e-324] {
        let made = Slab::flat(&lines, &lines, &[0.0, 1.0], x);
        let result = made.map_err(|e| e.to_string());
        let result = result.and_then(|s| solve(s).map_err(|e| e.to_string()));
        tried.push((format!("thickness {x}"), result));
    }
    for x in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let made = Slab::flat(&[0.0, x, 2.0], &lines, &[0.0, 1.0], 5.0);
        let result = made.map_err(|e| e.to_string());
        let result = result.and_then(|s| solve(s).map_err(|e| e.to_string()));
        tried.push((format!("a line at {x}"), result));
    }
    for (columns, rows) in [(1, 1), (0, 0), (1_000_000_000, 3), (usize::MAX, usize::MAX)] {
        let made = Slab::new(columns, rows, &[], &[], &[0.0, 1.0]).map(|_| ());
        tried.push((
            format!("{columns} × {rows} points"),
            made.map_err(|e| e.to_string()),
        ));
    }
    Ended::all_refused(tried)
}

fn bad_patches() -> Ended {
    let s = steps(-80.0, 80.0, 8);
    let Ok((surface, _)) = Surface::new(grid(&s, &s, |_, _| 0.0)) else {
        return Ended::wrong("no plate");
    };
    let search = Bvh::new(&surface);
    let mut tried: Vec<(String, Result<(), String>)> = Vec::new();
    let mut refuse = |what: String, at: Vec3, normal: Vec3, options: PatchOptions| {
        let patch = Patch::new(&surface, &search, at, normal, options);
        let result = patch.map_err(|e| e.to_string()).and_then(|patch| {
            let linear = Linear::new(patch.slab, Elastic::MUSCLE, [Fixed::Held; 4]);
            linear.map(|_| ()).map_err(|e| e.to_string())
        });
        tried.push((what, result));
    };
    let small = PatchOptions {
        half_width_mm: 40.0,
        n_half: 2,
        layers: 1,
        ..PatchOptions::default()
    };
    for x in [f64::NAN, f64::INFINITY, 0.0, -1.0] {
        let mut options = small;
        options.half_width_mm = x;
        refuse(format!("half width {x}"), Vec3::ZERO, Vec3::Z, options);
        let mut options = small;
        options.thickness_mm = x;
        refuse(format!("thickness {x}"), Vec3::ZERO, Vec3::Z, options);
        if !x.is_finite() {
            refuse(format!("place {x}"), Vec3::X * x, Vec3::Z, small);
            refuse(format!("normal {x}"), Vec3::ZERO, Vec3::X * x, small);
        }
    }
    for (n_half, layers) in [(2, 0), (0, 0), (2, 100_000)] {
        let options = PatchOptions {
            n_half,
            layers,
            ..small
        };
        let what = format!("{n_half} bricks, {layers} layers");
        refuse(what, Vec3::ZERO, Vec3::Z, options);
    }
    Ended::all_refused(tried)
}

fn lattice() -> Option<Lattice> {
    let lines = steps(0.0, 20.0, 4);
    let slab = Slab::flat(&lines, &lines, &[0.0, 0.5, 1.0], 10.0).ok()?;
    Lattice::new(&slab, Elastic::MUSCLE, [Fixed::Held; 4]).ok()
}

fn stiff_lattice(_: &Size) -> Ended {
    let Some(mut lattice) = lattice() else {
        return Ended::wrong("no lattice");
    };
    for (i, spring) in lattice.springs.iter_mut().enumerate() {
        spring.stiffness_n_per_mm = [1.0e-6, 1.0, 1.0e6][i % 3];
    }
    let load = [(12, Vec3::NEG_Z * 0.1)];
    let mut tally = Tally::default();
    for power in -6..=1 {
        let dt_s = 10_f64.powi(power);
        let mut motion = Motion::new(&lattice, 60.0);
        let mut games = Xpbd::new(&lattice, 60.0);
        for _ in 0..20 {
            if let Err(why) = motion.step_implicit(&load, dt_s) {
                return Ended::wrong(why.to_string());
            }
            games.step(&load, dt_s, 10);
        }
        for at in motion.at_mm.iter().chain(&games.at_mm) {
            tally.lengths(at.to_array());
        }
    }
    match rest(&lattice, &load) {
        Ok(found) => {
            for u in &found.displacements_mm {
                tally.lengths(u.to_array());
            }
            let says = format!("finite; at rest to {:.0e} of the load", found.residual);
            Ended::bounded(tally, says)
        }
        Err(why) => Ended::refused(why),
    }
}

fn odd_lattice() -> Ended {
    let Some(plain) = lattice() else {
        return Ended::wrong("no lattice");
    };
    let load = [(12, Vec3::NEG_Z * 0.1), (usize::MAX, Vec3::ONE)];
    let mut tally = Tally::default();
    for kind in 0..3 {
        let mut lattice = plain.clone();
        match kind {
            0 => lattice.rest_mm[7] = lattice.rest_mm[8],
            1 => lattice.mass_kg.iter_mut().for_each(|m| *m = 0.0),
            _ => lattice.springs[3].length_mm = 0.0,
        }
        for dt_s in [1.0e-3, 0.0, -1.0, 5.0e-324, f64::NAN, f64::INFINITY] {
            let mut games = Xpbd::new(&lattice, 60.0);
            let mut motion = Motion::new(&lattice, 60.0);
            let mut explicit = Motion::new(&lattice, 60.0);
            for _ in 0..3 {
                games.step(&load, dt_s, 5);
                // What cannot be solved says so, and nothing moves.
                let _ = motion.step_implicit(&load, dt_s);
                explicit.step_explicit(&load, dt_s.min(1.0e-6));
            }
            let all = games.at_mm.iter().chain(&motion.at_mm);
            for at in all.chain(&explicit.at_mm) {
                tally.lengths(at.to_array());
            }
            let speeds = games.velocity_mm_s.iter().chain(&motion.velocity_mm_s);
            for v in speeds.chain(&explicit.velocity_mm_s) {
                tally.numbers(v.to_array());
            }
        }
    }
    Ended::bounded(tally, "places and speeds finite")
}
