//! Maps of thousands of keys, of keys that contradict, and asked at no place; curves; outlines of extreme ratio.

use super::drive::stream;
use super::readings::ODD;
use super::row::{Case, Ended, Size, Tally};
use crate::deform::footprint::{Ellipse, Outline, Polar, PrintedEllipse};
use crate::geom::curve::{Curve, Lookup};
use crate::geom::law::Law;
use crate::geom::{Monotone, Vec2, Vec3};
use crate::maps::{
    AngleRule, BoneKey, BoneMap, EllipseKey, EllipseMap, EllipseSettings, Fit, Form, Level,
    MapError, StiffnessKey, StiffnessMap, Stroke,
};
use crate::surface::torture::Stream;

/// Maps, curves and outlines.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for fit in Fit::all() {
        for (n, quick) in [(3000, 150), (20_000, 300)] {
            cases.push(Case::new(
                format!("{n} keys, fit {}", fit.name()),
                "StiffnessMap::new, at",
                "stiffness 1e-3 … 1e3 N/mm, in any order; asked at the keys and anywhere",
                move |size| many_keys(size, *fit, if size.quick { quick } else { n }),
            ));
        }
        cases.push(Case::new(
            format!("contrast of 1e6 between neighbours, fit {}", fit.name()),
            "StiffnessMap::new, at",
            "a grid of 1e-3 and 1e3 N/mm in turn, 10 mm apart",
            move |size| contrast(size, *fit),
        ));
        cases.push(Case::new(
            format!("keys 1e-5 mm apart, fit {}", fit.name()),
            "StiffnessMap::new, at",
            "1 and 2 N/mm",
            move |_| close_keys(*fit),
        ));
    }
    cases.push(Case::new(
        "stiffness keys that are none",
        "StiffnessMap::new",
        "NaN, ±∞, 0, negative, 1e308 as value and place; no key; two values at one place",
        |_| bad_stiffness(),
    ));
    cases.push(Case::new(
        "bone keys that are none",
        "BoneMap::new",
        "NaN, ±∞, 0, negative, 1e308 as depth and place; two depths at one place",
        |_| bad_bones(),
    ));
    cases.push(Case::new(
        "strokes that are none",
        "StiffnessMap::with_strokes",
        "NaN, ±∞, 0 as radius, change and place; no point; 10001 points",
        |_| bad_strokes(),
    ));
    cases.push(Case::new(
        "10 000 strokes of 1000 % at one place",
        "StiffnessMap::with_strokes, at",
        "asked there and anywhere",
        many_strokes,
    ));
    for form in Form::all() {
        for angle in AngleRule::all() {
            cases.push(Case::new(
                format!("5000 ellipse keys, {}, {}", form.name(), angle.name()),
                "EllipseMap::new, at",
                "half axes 1 … 1000 mm, effect radius 10 m: all weigh everywhere",
                move |size| many_ellipses(size, *form, *angle),
            ));
        }
    }
    cases.push(Case::new(
        "ellipse keys that are none",
        "EllipseMap::new",
        "NaN, ±∞, 0, negative, 1e308 in every value; ratio 1e6; two ellipses at one place",
        |_| bad_ellipses(),
    ));
    for power in 0..=6 {
        let ratio = 10_f64.powi(power);
        cases.push(Case::new(
            format!("ellipse of ratio 1e{power}"),
            "footprint::Ellipse",
            "q of points in and out of it, against (u/a)² + (v/b)²",
            move |size| outline(size, ratio),
        ));
    }
    cases.push(Case::new(
        "outlines of no extent or place",
        "footprint::{Ellipse, PrintedEllipse, Polar}",
        "axes, radii, centre and normal NaN, ±∞, 0, negative, 1e308, 5e-324",
        |_| odd_outlines(),
    ));
    cases.push(Case::new(
        "curves asked at no place",
        "Curve::at, exact, Law::at, Monotone::at",
        "every curve and law at NaN, ±∞, negative, 1e308, 5e-324",
        |_| odd_curves(),
    ));
    cases.push(Case::new(
        "curves through points that are none",
        "Curve::through, Curve::new, Monotone::new",
        "NaN, ±∞, 2 as value and place; places that fall; no points",
        |_| bad_curves(),
    ));
    cases
}

fn place(stream: &mut Stream) -> Vec2 {
    Vec2::new(stream.unit(), stream.unit()) * 300.0
}

/// Places that are none, or far away.
fn odd_places() -> impl Iterator<Item = Vec2> {
    ODD.into_iter()
        .flat_map(|x| [Vec2::new(x, 1.0), Vec2::new(1.0, x), Vec2::splat(x)])
}

fn stiffness(at: Vec2, stiffness_n_per_mm: f64) -> StiffnessKey {
    StiffnessKey {
        at,
        stiffness_n_per_mm,
    }
}

/// At the keys their values, everywhere within the range of the keys (twice that for rbf).
fn held_to_keys(size: &Size, keys: Vec<StiffnessKey>, fit: Fit) -> Ended {
    let map = match StiffnessMap::new(keys.clone(), fit) {
        Ok(map) => map,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, fit.name());
    let values = keys.iter().map(|k| k.stiffness_n_per_mm);
    let (least, most) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), k| (a.min(k), b.max(k)));
    let beyond = if fit == Fit::Rbf { 2.0 } else { 1.0 + 1.0e-12 };
    let mut fault = None;
    let mut off = 0.0_f64;
    let mut reader = map.reader();
    for i in 0..(size.questions / 10).max(30) {
        let key = keys[(i * 37) % keys.len()];
        if fit != Fit::Constant {
            let k = reader(key.at);
            off = off.max((k / key.stiffness_n_per_mm - 1.0).abs());
            tally.numbers([k]);
        }
        let k = reader(place(&mut stream));
        tally.numbers([k]);
        if !(k >= least / beyond && k <= most * beyond) {
            fault.get_or_insert(format!("{k} N/mm, keys have {least} to {most}"));
        }
    }
    for p in odd_places() {
        let k = reader(p);
        tally.numbers([k]);
        if !(k >= least / beyond && k <= most * beyond) {
            fault.get_or_insert(format!("{k} N/mm at {p}"));
        }
    }
    match fault {
        None => Ended::held(tally, "the keys' own values, as shares", off, 1.0e-6),
        fault => Ended::checked(tally, "", fault),
    }
}

fn many_keys(size: &Size, fit: Fit, n: usize) -> Ended {
    let mut stream = stream(size.seed, "many keys");
    let keys = (0..n)
        .map(|_| {
            let k = libm::exp10(3.0 * stream.unit());
            stiffness(place(&mut stream), k)
        })
        .collect();
    held_to_keys(size, keys, fit)
}

fn contrast(size: &Size, fit: Fit) -> Ended {
    let keys = (0..144)
        .map(|i| {
            let (x, y) = (i % 12, i / 12);
            let k = if (x + y) % 2 == 0 { 1.0e-3 } else { 1.0e3 };
            stiffness(Vec2::new(f64::from(x), f64::from(y)) * 10.0, k)
        })
        .collect();
    held_to_keys(size, keys, fit)
}

fn close_keys(fit: Fit) -> Ended {
    let keys = vec![
        stiffness(Vec2::ZERO, 1.0),
        stiffness(Vec2::new(1.0e-5, 0.0), 2.0),
        stiffness(Vec2::new(100.0, 50.0), 1.5),
    ];
    let map = match StiffnessMap::new(keys.clone(), fit) {
        Ok(map) => map,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    for x in [-1.0, 0.0, 5.0e-6, 1.0e-5, 1.0, 100.0] {
        tally.numbers([map.at(Vec2::new(x, 0.0))]);
    }
    if fit != Fit::Constant {
        for key in &keys {
            off = off.max((map.at(key.at) / key.stiffness_n_per_mm - 1.0).abs());
        }
    }
    Ended::held(tally, "the keys' own values, as shares", off, 1.0e-6)
}

fn bad_stiffness() -> Ended {
    let mut tried: Vec<(String, Result<(), MapError>)> = Vec::new();
    let new = |keys| StiffnessMap::new(keys, Fit::Natural).map(|_| ());
    tried.push(("no key".into(), new(Vec::new())));
    for x in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -1.0,
        1.0e308,
    ] {
        let value = new(vec![stiffness(Vec2::ZERO, x)]);
        tried.push((format!("stiffness {x}"), value));
        tried.push((
            format!("constant {x}"),
            StiffnessMap::constant(x).map(|_| ()),
        ));
    }
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0e308, 1.0e7] {
        for at in [Vec2::new(x, 0.0), Vec2::new(0.0, x)] {
            tried.push((format!("at {at}"), new(vec![stiffness(at, 1.0)])));
        }
    }
    for fit in Fit::all() {
        let keys = vec![stiffness(Vec2::ONE, 1.0), stiffness(Vec2::ONE, 1.0e6)];
        let twice = StiffnessMap::new(keys, *fit).map(|_| ());
        tried.push((format!("two at one place, {}", fit.name()), twice));
    }
    Ended::all_refused(tried)
}

fn bad_bones() -> Ended {
    let key = |at, depth_mm| BoneKey { at, depth_mm };
    let mut tried = vec![("no key".to_owned(), BoneMap::new(Vec::new()).map(|_| ()))];
    for x in [f64::NAN, f64::INFINITY, 0.0, -1.0, 5.0e-324, 1.0e308] {
        let made = BoneMap::new(vec![key(Vec2::ZERO, x)]).map(|_| ());
        tried.push((format!("depth {x}"), made));
    }
    for x in [f64::NAN, f64::INFINITY, 1.0e308] {
        let made = BoneMap::new(vec![key(Vec2::new(x, 0.0), 9.0)]).map(|_| ());
        tried.push((format!("x {x}"), made));
    }
    let twice = vec![key(Vec2::ONE, 9.0), key(Vec2::ONE, 10.0)];
    tried.push(("two at one place".into(), BoneMap::new(twice).map(|_| ())));
    Ended::all_refused(tried)
}

fn stroke(path: Vec<Vec2>, radius_mm: f64, change: f64) -> Stroke {
    Stroke {
        path,
        radius_mm,
        change,
        falloff: "gaussian".into(),
    }
}

fn brushed(strokes: Vec<Stroke>) -> Result<StiffnessMap, MapError> {
    StiffnessMap::constant(1.0)?.with_strokes(strokes)
}

fn bad_strokes() -> Ended {
    let mut tried = Vec::new();
    let mut refuse = |what: String, one: Stroke| {
        tried.push((what, brushed(vec![one]).map(|_| ())));
    };
    refuse("no point".into(), stroke(Vec::new(), 5.0, 0.5));
    refuse(
        "10001 points".into(),
        stroke(vec![Vec2::ZERO; 10_001], 5.0, 0.5),
    );
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.0e308] {
        refuse(
            format!("point {x}"),
            stroke(vec![Vec2::new(0.0, x)], 5.0, 0.5),
        );
        refuse(format!("radius {x}"), stroke(vec![Vec2::ZERO], x, 0.5));
        refuse(format!("change {x}"), stroke(vec![Vec2::ZERO], 5.0, x));
    }
    for x in [0.0, -1.0, 5.0e-324] {
        refuse(format!("radius {x}"), stroke(vec![Vec2::ZERO], x, 0.5));
    }
    refuse("change −1".into(), stroke(vec![Vec2::ZERO], 5.0, -1.0));
    let mut other = stroke(vec![Vec2::ZERO], 5.0, 0.5);
    other.falloff = "NaN".into();
    refuse("falloff NaN".into(), other);
    Ended::all_refused(tried)
}

fn many_strokes(size: &Size) -> Ended {
    let n = if size.quick { 500 } else { 10_000 };
    let one = stroke(vec![Vec2::ZERO, Vec2::ZERO], 50.0, 9.0);
    let map = match brushed(vec![one; n]) {
        Ok(map) => map,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, "strokes");
    let mut off = (map.at(Vec2::ZERO) - 1.0e4).abs();
    tally.numbers([map.at(Vec2::ZERO)]);
    for p in odd_places().chain((0..200).map(|_| place(&mut stream))) {
        let k = map.at(p);
        tally.numbers([k]);
        let out = p.length().is_finite() && p.length() > 50.0;
        off = off.max(if out { (k - 1.0).abs() } else { 0.0 });
    }
    Ended::held(tally, "1e4 N/mm there, 1 N/mm outside", off, 1.0e-9)
}

fn ellipse(at: Vec2, major: f64, minor: f64, angle_rad: f64) -> EllipseKey {
    EllipseKey {
        name: String::new(),
        at,
        half_major_mm: major,
        half_minor_mm: minor,
        angle_rad,
        boundary_mm: None,
    }
}

fn many_ellipses(size: &Size, form: Form, angle: AngleRule) -> Ended {
    let n = if size.quick { 200 } else { 5000 };
    let mut stream = stream(size.seed, "ellipses");
    let keys: Vec<EllipseKey> = (0..n)
        .map(|_| {
            let major = 1.0 + 999.0 * stream.unit().abs();
            let minor = 1.0 + (major - 1.0) * stream.unit().abs();
            let turn = std::f64::consts::PI * stream.unit();
            ellipse(place(&mut stream), major, minor, turn)
        })
        .collect();
    let settings = EllipseSettings {
        effect_radius_mm: 10_000.0,
        form,
        angle,
        level: Level::default(),
        ..EllipseSettings::default()
    };
    let map = match EllipseMap::new(keys.clone(), settings) {
        Ok(map) => map,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    let mut off = 0.0_f64;
    let mut fault = None;
    let random: Vec<Vec2> = (0..size.questions / 50)
        .map(|_| place(&mut stream))
        .collect();
    for p in odd_places().chain(random) {
        let o = map.at(p);
        tally.lengths([o.half_major_mm, o.half_minor_mm]);
        tally.numbers([o.angle_rad]);
        let range = 1.0 - 1.0e-9..=1000.0 + 1.0e-6;
        if !range.contains(&o.half_major_mm) || o.half_minor_mm.is_nan() || o.half_minor_mm <= 0.0 {
            fault.get_or_insert(format!("{o:?} at {p}"));
        }
    }
    for key in keys.iter().take(200) {
        let o = map.at(key.at);
        off = off.max((o.half_major_mm - key.half_major_mm).abs());
        off = off.max((o.half_minor_mm - key.half_minor_mm).abs());
        tally.lengths([o.half_major_mm, o.half_minor_mm]);
    }
    match (fault, form) {
        (None, Form::Published) => Ended::bounded(
            tally,
            format!("within the keys; as published it misses them, by up to {off:.0} mm"),
        ),
        (None, _) => Ended::held(tally, "the keys' own half axes, mm", off, 1.0e-9),
        (fault, _) => Ended::checked(tally, "", fault),
    }
}

fn bad_ellipses() -> Ended {
    let mut tried: Vec<(String, Result<(), MapError>)> = Vec::new();
    let settings = EllipseSettings::default();
    let mut refuse = |what: String, keys: Vec<EllipseKey>, settings: EllipseSettings| {
        tried.push((what, EllipseMap::new(keys, settings).map(|_| ())));
    };
    let o = Vec2::ZERO;
    for x in [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -1.0,
        5.0e-324,
        1.0e308,
    ] {
        refuse(
            format!("major {x}"),
            vec![ellipse(o, x, 5.0, 0.0)],
            settings,
        );
        refuse(
            format!("minor {x}"),
            vec![ellipse(o, 5.0, x, 0.0)],
            settings,
        );
        let basic = EllipseSettings {
            basic_radius_mm: x,
            ..settings
        };
        refuse(format!("basic radius {x}"), Vec::new(), basic);
        let effect = EllipseSettings {
            effect_radius_mm: x,
            ..settings
        };
        refuse(format!("effect radius {x}"), Vec::new(), effect);
        let boundary = EllipseKey {
            boundary_mm: Some(vec![x; 8]),
            ..ellipse(o, 5.0, 4.0, 0.0)
        };
        refuse(format!("boundary of {x}"), vec![boundary], settings);
    }
    for x in [f64::NAN, f64::INFINITY, 1.0e308, 7.0] {
        refuse(
            format!("angle {x}"),
            vec![ellipse(o, 5.0, 4.0, x)],
            settings,
        );
    }
    for x in [f64::NAN, f64::INFINITY, 1.0e308] {
        let at = Vec2::new(x, 0.0);
        refuse(format!("x {x}"), vec![ellipse(at, 5.0, 4.0, 0.0)], settings);
    }
    refuse(
        "ratio 1e6".into(),
        vec![ellipse(o, 1.0e6, 1.0, 0.0)],
        settings,
    );
    refuse(
        "two at one place".into(),
        vec![ellipse(o, 6.0, 4.0, 0.0), ellipse(o, 5.0, 4.0, 0.0)],
        settings,
    );
    Ended::all_refused(tried)
}

/// The ratio q in an ellipse in the map plane, against its definition.
fn outline(size: &Size, ratio: f64) -> Ended {
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, "outline");
    let mut off = 0.0_f64;
    for (major, minor) in [
        (ratio, 1.0),
        (100.0, 100.0 / ratio),
        (1.0e-3, 1.0e-3 / ratio),
    ] {
        for turn in [0.0, 0.3, 2.0] {
            let made = Ellipse::new(Vec3::ZERO, Vec3::Z, major, minor, turn);
            let Some(ellipse) = made else {
                return Ended::wrong(format!("no ellipse {major} × {minor} mm"));
            };
            let (sin, cos) = libm::sincos(turn);
            for _ in 0..size.questions / 20 {
                let (u, v) = (2.0 * stream.unit(), 2.0 * stream.unit());
                let (x, y) = (u * major, v * minor);
                let p = Vec3::new(x * cos - y * sin, x * sin + y * cos, stream.unit());
                let q = ellipse.ratio(p);
                tally.numbers([q]);
                // Coordinates of p are rounded to the major axis, which counts by the ratio.
                let rounding = 1.0 + f64::EPSILON * ratio * 4.0 / 1.0e-12;
                off = off.max((q - libm::hypot(u, v)).abs() / rounding);
            }
        }
    }
    Ended::held(tally, "√((u/a)² + (v/b)²)", off, 1.0e-12)
}

fn odd_outlines() -> Ended {
    let mut tally = Tally::default();
    let mut fault = None;
    let (o, n) = (Vec3::ZERO, Vec3::Z);
    let mut check = |what: String, outline: Option<&dyn Outline>, sound: bool| {
        tally.answers += 1;
        let Some(outline) = outline else { return };
        if !sound {
            fault.get_or_insert(format!("{what} has an outline"));
        }
        for p in [o, Vec3::X, Vec3::new(1.0, 2.0, 3.0)] {
            let q = outline.ratio(p);
            // Infinitely far out is outside.
            if q.is_nan() || q < 0.0 {
                fault.get_or_insert(format!("{what}: q = {q} at {p}"));
            }
        }
    };
    for x in ODD.into_iter().chain([0.0, -1.0]) {
        let sound = x > 0.0 && x.is_finite();
        for (major, minor) in [(x, 5.0), (5.0, x), (x, x)] {
            let what = format!("{major} × {minor} mm");
            let e = Ellipse::new(o, n, major, minor, 0.5);
            check(what.clone(), e.as_ref().map(|e| e as _), sound);
            let scaled = e.and_then(|e| e.scaled(1.0e-3));
            check(what.clone(), scaled.as_ref().map(|e| e as _), sound);
            let p = PrintedEllipse::new(o, n, major, minor, 0.5);
            check(what, p.as_ref().map(|e| e as _), sound);
        }
        let mut radii = [20.0; 12];
        radii[3] = x;
        let p = Polar::new(o, n, &radii);
        check(
            format!("a radius of {x}"),
            p.as_ref().map(|e| e as _),
            sound,
        );
        let e = Ellipse::new(o, n, 5.0, 4.0, x);
        check(
            format!("angle {x}"),
            e.as_ref().map(|e| e as _),
            x.is_finite(),
        );
        for place in [Vec3::new(x, 0.0, 0.0), Vec3::splat(x)] {
            let fine = place.is_finite();
            let e = Ellipse::new(place, n, 5.0, 4.0, 0.5);
            check(format!("at {place}"), e.as_ref().map(|e| e as _), fine);
            let p = Polar::new(place, n, &[5.0; 8]);
            check(format!("at {place}"), p.as_ref().map(|e| e as _), fine);
            let e = Ellipse::new(o, place, 5.0, 4.0, 0.5);
            check(format!("normal {place}"), e.as_ref().map(|e| e as _), fine);
        }
    }
    Ended::checked(tally, "none, or a ratio ≥ 0 everywhere", fault)
}

fn odd_curves() -> Ended {
    let mut tally = Tally::default();
    let mut fault = None;
    let mut curves: Vec<Curve> = Vec::new();
    for law in Law::all() {
        for lookup in Lookup::all() {
            curves.extend([0, 2, 700].map(|n| Curve::of(*law, n, *lookup)));
        }
    }
    let monotone = Monotone::new(&[(0.0, 1.0), (0.5, 0.2), (1.0, 0.0)]);
    for x in ODD.into_iter().chain([-1.0, 1.0 + f64::EPSILON, 1.0e308]) {
        for curve in &curves {
            for m in [curve.at(x), curve.exact(x)] {
                tally.numbers([m]);
                if !(-1.0..=1.0).contains(&m) {
                    fault.get_or_insert(format!("{} is {m} at {x}", curve.name()));
                }
            }
            let mut shares = [x; 4];
            curve.apply(&mut shares);
            tally.numbers(shares);
        }
        for law in Law::all() {
            tally.numbers([law.at(x), law.slope(x), law.curvature(x)]);
        }
        if let Some(m) = &monotone {
            tally.numbers([m.at(x), m.slope(x), m.curvature(x)]);
        }
    }
    Ended::checked(tally, "a share −1 … 1", fault)
}

fn bad_curves() -> Ended {
    let mut tried = Vec::new();
    let mut through = |what: String, points: &[(f64, f64)]| {
        let made = Curve::through(points, 100, Lookup::Linear).map(|_| ());
        tried.push((what, made.map_err(|e| e.to_string())));
    };
    through("no points".into(), &[]);
    through("one point".into(), &[(0.0, 1.0)]);
    through(
        "falling".into(),
        &[(0.0, 1.0), (0.6, 0.4), (0.5, 0.3), (1.0, 0.0)],
    );
    through(
        "one place twice".into(),
        &[(0.0, 1.0), (0.5, 0.4), (0.5, 0.3), (1.0, 0.0)],
    );
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0, -1.5] {
        through(format!("M = {x}"), &[(0.0, 1.0), (0.5, x), (1.0, 0.0)]);
        through(format!("q = {x}"), &[(0.0, 1.0), (x, 0.5), (1.0, 0.0)]);
    }
    for x in [f64::NAN, f64::INFINITY, 1.5] {
        let made = Curve::new("x", vec![1.0, x, 0.0], Lookup::Linear).map(|_| ());
        tried.push((format!("sample {x}"), made.map_err(|e| e.to_string())));
        let none = Monotone::new(&[(0.0, 1.0), (x, 0.5), (1.0, 0.0)]).is_none();
        let told = "no curve through what is no place".to_owned();
        tried.push((
            format!("monotone {x}"),
            if none { Err(told) } else { Ok(()) },
        ));
    }
    Ended::all_refused(tried)
}
