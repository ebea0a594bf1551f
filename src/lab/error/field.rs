//! The models that run, each at several settings.

use super::bench::{Bench, DEVIATION_MM, MATERIAL, THICKNESS_MM};
use crate::deform::Model;
use crate::deform::curve::{Curve, Lookup};
use crate::deform::models::fsmd::{Fsmd, Settings};
use crate::lab::{LabError, Watch};
use crate::reference::continuum::Continuum;
use crate::reference::patch::{Patch, PatchOptions};
use crate::reference::slab::{self, Body, SlabModel, Stepping};
use crate::reference::{Dent, half_space, layer, membrane};
use std::sync::Arc;

/// Models of one kind.
#[derive(Debug)]
pub struct Family {
    pub name: &'static str,
    /// sRGB in plots; none is a finger's.
    pub colour: [u8; 3],
}

/// Every kind, in the order of the legend.
pub static FAMILIES: [Family; 9] = [
    family("fsmd", [214, 122, 0]),
    family("closed form", [0, 140, 104]),
    family("fem-linear", [24, 26, 30]),
    family("fem-condensed", [120, 124, 130]),
    family("fem-corotated", [136, 72, 168]),
    family("springs-rest", [176, 150, 60]),
    family("springs-explicit", [124, 84, 28]),
    family("springs-implicit", [90, 120, 60]),
    family("xpbd", [200, 90, 140]),
];

const fn family(name: &'static str, colour: [u8; 3]) -> Family {
    Family { name, colour }
}

fn of(name: &str) -> &'static Family {
    FAMILIES
        .iter()
        .find(|f| f.name == name)
        .unwrap_or(&FAMILIES[0])
}

/// One that runs.
pub struct Candidate {
    pub family: &'static Family,
    pub setting: String,
    pub model: Box<dyn Model>,
    /// The force that the model has at a depth, N, where it has one.
    pub force_n: Option<Box<dyn Fn(f64) -> f64>>,
}

/// Every candidate.
pub fn all(bench: &Bench, quick: bool, watch: &mut Watch<'_>) -> Result<Vec<Candidate>, LabError> {
    let mut found = Vec::new();
    watch.at("FSMD, fitted", 0.0)?;
    fsmd(bench, &mut found);
    watch.at("closed forms", 0.2)?;
    closed_forms(&mut found);
    slabs(bench, quick, &mut watch.part(0.3, 1.0), &mut found)?;
    Ok(found)
}

fn fsmd(bench: &Bench, found: &mut Vec<Candidate>) {
    let mut push = |setting: String, settings: Settings| {
        found.push(Candidate {
            family: of("fsmd"),
            setting,
            model: Box::new(Fsmd::new(settings)),
            force_n: None,
        });
    };
    let printed = Settings {
        tangential: false,
        ..Settings::default()
    };
    push(
        "printed footprint, default curve".to_owned(),
        printed.clone(),
    );
    push(
        "printed footprint as wide as the drag".to_owned(),
        Settings {
            normal_scale_shallow: 1.0,
            normal_scale_deep: 1.0,
            ..printed.clone()
        },
    );
    for name in ["gaussian", "cosine", "gaussian-sharp", "logarithmic"] {
        let Some(curve) = Curve::named(name, 700, Lookup::Linear) else {
            continue;
        };
        let (radius_mm, settings) = fitted(bench, curve);
        push(format!("{name} fitted, {radius_mm:.1} mm"), settings);
    }
    for (samples, lookup, word) in [
        (20, Lookup::Nearest, "nearest"),
        (20, Lookup::Linear, "linear"),
        (130, Lookup::Nearest, "nearest"),
        (700, Lookup::Nearest, "nearest"),
    ] {
        let Some(curve) = Curve::named("gaussian", samples, lookup) else {
            continue;
        };
        let (radius_mm, settings) = fitted(bench, curve);
        push(
            format!("gaussian fitted, {radius_mm:.1} mm, {samples} samples {word}"),
            settings,
        );
    }
}

/// A circle whose radius makes the smallest RMS error at this press (golden section on its logarithm), and that radius, mm.
fn fitted(bench: &Bench, curve: Curve) -> (f64, Settings) {
    let settings = |radius_mm: f64| Settings {
        half_major_mm: radius_mm,
        half_minor_mm: radius_mm,
        normal_scale_shallow: 1.0,
        normal_scale_deep: 1.0,
        tangential: false,
        curve: curve.clone(),
        ..Settings::default()
    };
    let error = |log_radius: f64| bench.rms_mm(&mut Fsmd::new(settings(log_radius.exp())));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (4.0_f64.ln(), 120.0_f64.ln());
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (error(a), error(b));
    for _ in 0..24 {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - golden * (high - low);
            at_a = error(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + golden * (high - low);
            at_b = error(b);
        }
    }
    let radius_mm = (0.5 * (low + high)).exp();
    (radius_mm, settings(radius_mm))
}

fn closed_forms(found: &mut Vec<Candidate>) {
    let mut push = |setting: String, dent: Arc<dyn Dent>| {
        let felt = Arc::clone(&dent);
        found.push(Candidate {
            family: of("closed form"),
            setting,
            model: Box::new(Continuum::new(dent, None, 90.0)),
            force_n: Some(Box::new(move |depth_mm| felt.force_n(depth_mm))),
        });
    };
    let layer = layer::Bonded::new(MATERIAL, DEVIATION_MM, THICKNESS_MM);
    push(format!("layer of {THICKNESS_MM} mm"), Arc::new(layer));
    push(
        "half-space".to_owned(),
        Arc::new(half_space::Gaussian::new(MATERIAL, DEVIATION_MM)),
    );
    push(
        "sphere on a half-space (Hertz)".to_owned(),
        Arc::new(half_space::Sphere::new(MATERIAL, 8.0)),
    );
    push(
        "membrane on springs, λ = 5 mm".to_owned(),
        Arc::new(membrane::Tensed::new(5.0, 7.0, 0.002)),
    );
}

fn slabs(
    bench: &Bench,
    quick: bool,
    watch: &mut Watch<'_>,
    found: &mut Vec<Candidate>,
) -> Result<(), LabError> {
    let input = |e: &dyn std::fmt::Display| LabError::Input(e.to_string());
    let patch = |n_half: usize, layers: usize, growth: f64| {
        let options = PatchOptions {
            n_half,
            layers,
            growth,
            thickness_mm: THICKNESS_MM,
            ..PatchOptions::default()
        };
        let press = &bench.press;
        Patch::new(
            &bench.surface,
            &bench.search,
            press.anchor_mm,
            press.normal,
            options,
        )
    };
    let mut push = |name: &str, setting: String, patch: Patch, body: Box<dyn Body>| {
        let mut felt = SlabModel::new(patch, body, DEVIATION_MM);
        // The force is told by the run itself.
        let (_, force_n) = felt.dent(crate::geom::Vec2::ZERO, bench.depth_mm);
        found.push(Candidate {
            family: of(name),
            setting,
            model: Box::new(felt),
            force_n: (force_n > 0.0).then(|| Box::new(move |_| force_n) as Box<dyn Fn(f64) -> f64>),
        });
    };
    let sizes: &[(usize, usize)] = if quick {
        &[(6, 3), (8, 4)]
    } else {
        &[(6, 3), (10, 5), (14, 7), (18, 8)]
    };
    for (i, &(n_half, layers)) in sizes.iter().enumerate() {
        watch.at("finite elements", 0.3 * i as f64 / sizes.len() as f64)?;
        let patch = patch(n_half, layers, 5.0).map_err(|e| input(&e))?;
        let setting = format!("{} bricks", 4 * n_half * n_half * layers);
        let body = slab::linear(&patch, MATERIAL).map_err(|e| input(&e))?;
        push("fem-linear", setting, patch, body);
    }
    for (i, &(n_half, layers)) in sizes.iter().take(3).enumerate() {
        let patch = patch(n_half, layers, 5.0).map_err(|e| input(&e))?;
        let mut part = watch.part(0.3 + 0.1 * i as f64, 0.4 + 0.1 * i as f64);
        let nodes = patch.slab.skin_mm().len();
        let mut stopped = false;
        let body = slab::condensed(&patch, MATERIAL, &mut |share| {
            stopped = part.at("condensing", share).is_err();
            !stopped
        });
        match body.map_err(|e| input(&e))? {
            Some(body) => push("fem-condensed", format!("{nodes} skin nodes"), patch, body),
            None if stopped => return Err(LabError::Stopped),
            None => {}
        }
    }
    let (n_half, layers) = sizes[usize::from(!quick)];
    watch.at("large strains", 0.6)?;
    let turning = patch(n_half.min(8), layers.min(4), 5.0).map_err(|e| input(&e))?;
    let body = slab::corotated(&turning, MATERIAL).map_err(|e| input(&e))?;
    push(
        "fem-corotated",
        format!(
            "{} bricks",
            4 * n_half.min(8) * n_half.min(8) * layers.min(4)
        ),
        turning,
        body,
    );
    let settings: &[(&str, Stepping, &str)] = &[
        ("springs-rest", Stepping::Rest, "Newton"),
        ("springs-explicit", Stepping::Explicit(400), "400 steps"),
        (
            "springs-implicit",
            Stepping::Implicit(8),
            "8 steps of 1/60 s",
        ),
        (
            "springs-implicit",
            Stepping::Implicit(2),
            "2 steps of 1/60 s",
        ),
        ("xpbd", Stepping::Position(8), "8 frames, 10 sweeps"),
        ("xpbd", Stepping::Position(30), "30 frames, 10 sweeps"),
    ];
    for (i, (name, stepping, word)) in settings.iter().enumerate() {
        watch.at(name, 0.7 + 0.3 * i as f64 / settings.len() as f64)?;
        // Springs are best as cubes.
        let patch = patch(8, 4, 2.0).map_err(|e| input(&e))?;
        let body = slab::springs(&patch, MATERIAL, *stepping).map_err(|e| input(&e))?;
        push(name, (*word).to_owned(), patch, body);
    }
    Ok(())
}
