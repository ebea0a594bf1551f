//! The models of the drawn skin that run, each at several settings.

use super::bench::Bench;
use crate::deform::Model;
use crate::deform::curve::{Curve, Lookup};
use crate::deform::footprint::Kind;
use crate::deform::models::fsmd::{Fsmd, Settings};
use crate::lab::{LabError, Watch};
use crate::reference::continuum::Continuum;
use crate::reference::fem::linear::SolveError;
use crate::reference::patch::Patch;
use crate::reference::slab::lattice::Stepping;
use crate::reference::slab::{Body, SlabModel, elements, lattice};
use crate::reference::{Dent, half_space, layer, membrane};
use std::sync::Arc;

/// A model that runs.
pub enum Subject {
    /// One that tells its force at a depth, mm to N.
    Told(Box<dyn Model>, Box<dyn Fn(f64) -> f64>),
    /// One whose force is that of its last press.
    Slab(Box<SlabModel>),
}

impl Subject {
    /// The model.
    pub fn model(&mut self) -> &mut dyn Model {
        match self {
            Self::Told(model, _) => &mut **model,
            Self::Slab(slab) => &mut **slab,
        }
    }

    /// The force of a press `depth_mm` deep, which was the last one, N; nothing where no answer was found.
    pub fn force_n(&self, depth_mm: f64) -> Option<f64> {
        match self {
            Self::Told(_, force_n) => Some(force_n(depth_mm)),
            Self::Slab(slab) => Some(slab.force_n()).filter(|f| *f > 0.0),
        }
    }
}

/// Makes one.
pub type Make<'a> = dyn Fn(&Bench, &mut Watch<'_>) -> Result<Subject, LabError> + 'a;

/// One that runs.
pub struct Candidate {
    pub family: &'static str,
    pub setting: String,
    pub make: Box<Make<'static>>,
}

/// Every kind with its sRGB colour in plots, in the order of the legend. None is a finger's.
pub const FAMILIES: [(&str, [u8; 3]); 10] = [
    ("fsmd", [214, 122, 0]),
    ("closed form", [0, 140, 104]),
    ("fem-linear", [24, 26, 30]),
    ("fem-condensed", [120, 124, 130]),
    ("fem-pressed", [0, 150, 170]),
    ("fem-corotated", [136, 72, 168]),
    ("springs-rest", [176, 150, 60]),
    ("springs-explicit", [124, 84, 28]),
    ("springs-implicit", [90, 120, 60]),
    ("xpbd", [200, 90, 140]),
];

/// How far closed forms are followed, mm.
const REACH_MM: f64 = 90.0;

/// Every candidate; fewer and smaller ones for a quick look.
pub fn all(quick: bool) -> Vec<Candidate> {
    let mut found = Vec::new();
    fsmd(&mut found);
    closed_forms(&mut found);
    slabs(quick, &mut found);
    found
}

fn fsmd(found: &mut Vec<Candidate>) {
    let mut push = |setting: String, settings: Box<dyn Fn(&Bench) -> Settings>| {
        found.push(Candidate {
            family: "fsmd",
            setting,
            make: Box::new(move |bench, _| {
                // What is felt: the stiffness map, whatever is drawn.
                let felt = bench.felt_n / bench.depth_mm();
                let model = Box::new(Fsmd::new(settings(bench)));
                Ok(Subject::Told(
                    model,
                    Box::new(move |depth_mm| felt * depth_mm),
                ))
            }),
        });
    };
    push(
        "as the scene has it".to_owned(),
        Box::new(|bench| bench.scene.deform.clone()),
    );
    for (kind, word) in [
        (Kind::Circle, "circle"),
        (Kind::EllipsePrinted, "ellipse as printed (4.13)"),
    ] {
        let settings = move |bench: &Bench| Settings {
            footprint: kind,
            normal_scale_shallow: 1.0,
            normal_scale_deep: 1.0,
            ..bench.scene.deform.clone()
        };
        push(format!("one wide footprint, {word}"), Box::new(settings));
    }
    for name in ["gaussian", "cosine", "gaussian-sharp", "logarithmic"] {
        let fit = move |bench: &Bench| fitted(bench, Curve::named(name, 700, Lookup::Linear));
        push(format!("fitted circle, {name}"), Box::new(fit));
    }
    for (samples, lookup, word) in [
        (20, Lookup::Nearest, "nearest"),
        (20, Lookup::Linear, "linear"),
        (130, Lookup::Nearest, "nearest"),
        (700, Lookup::Nearest, "nearest"),
        (700, Lookup::Exact, "exact"),
    ] {
        let fit = move |bench: &Bench| fitted(bench, Curve::named("gaussian", samples, lookup));
        push(
            format!("fitted circle, array of {samples}, {word}"),
            Box::new(fit),
        );
    }
}

/// A circle whose radius makes the smallest RMS error at this press, by golden section on its logarithm.
fn fitted(bench: &Bench, curve: Option<Curve>) -> Settings {
    let curve = curve.unwrap_or_else(Curve::gaussian);
    let settings = |log_radius: f64| Settings {
        footprint: Kind::Circle,
        half_major_mm: libm::exp(log_radius),
        half_minor_mm: libm::exp(log_radius),
        normal_scale_shallow: 1.0,
        normal_scale_deep: 1.0,
        tangential: false,
        curve: curve.clone(),
        bones: None,
        ..Settings::default()
    };
    let error = |log_radius: f64| bench.rms_mm(&mut Fsmd::new(settings(log_radius)));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (libm::log(4.0), libm::log(120.0));
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (error(a), error(b));
    for _ in 0..if bench.quick { 8 } else { 20 } {
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
    settings(0.5 * (low + high))
}

fn closed_forms(found: &mut Vec<Candidate>) {
    type Of = fn(&Bench) -> Arc<dyn Dent>;
    let forms: [(&str, Of); 5] = [
        ("layer on bone", |b| {
            let t = b.tissue;
            Arc::new(layer::Bonded::new(
                t.material,
                t.deviation_mm,
                t.thickness_mm,
            ))
        }),
        ("half-space, Gaussian pressure", |b| {
            Arc::new(half_space::Gaussian::new(
                b.tissue.material,
                b.tissue.deviation_mm,
            ))
        }),
        ("half-space, even pressure", |b| {
            Arc::new(half_space::Disc::new(
                b.tissue.material,
                2.0 * b.tissue.deviation_mm,
            ))
        }),
        ("half-space, rigid ball (Hertz)", |b| {
            Arc::new(half_space::Sphere::new(b.tissue.material, 8.0))
        }),
        ("membrane on springs", |b| {
            Arc::new(membrane::Tensed::new(
                5.0,
                2.0 * b.tissue.deviation_mm,
                0.002,
            ))
        }),
    ];
    for (setting, of) in forms {
        found.push(Candidate {
            family: "closed form",
            setting: setting.to_owned(),
            make: Box::new(move |bench, _| {
                let dent = of(bench);
                let model = Box::new(Continuum::new(Arc::clone(&dent), None, REACH_MM));
                Ok(Subject::Told(
                    model,
                    Box::new(move |depth_mm| dent.force_n(depth_mm)),
                ))
            }),
        });
    }
}

/// Bricks along half the width, from skin to bone, and how they grow outward.
#[derive(Clone, Copy)]
struct Cut(usize, usize, f64);

impl Cut {
    fn bricks(self) -> usize {
        4 * self.0 * self.0 * self.1
    }

    fn skin_nodes(self) -> usize {
        (2 * self.0 + 1) * (2 * self.0 + 1)
    }
}

type MakeBody = dyn Fn(&Bench, &Patch, &mut Watch<'_>) -> Result<Box<dyn Body>, LabError>;

fn slab(family: &'static str, setting: String, cut: Cut, body: Box<MakeBody>) -> Candidate {
    let make = move |bench: &Bench, watch: &mut Watch<'_>| {
        let patch = bench.patch(cut.0, cut.1, cut.2)?;
        let deviation_mm = bench.tissue.deviation_mm;
        let body = body(bench, &patch, watch)?;
        Ok(Subject::Slab(Box::new(SlabModel::new(
            patch,
            body,
            deviation_mm,
        ))))
    };
    Candidate {
        family,
        setting,
        make: Box::new(make),
    }
}

fn unsolved(e: SolveError) -> LabError {
    LabError::Input(e.to_string())
}

fn slabs(quick: bool, found: &mut Vec<Candidate>) {
    let sizes: &[Cut] = if quick {
        &[Cut(4, 2, 5.0), Cut(6, 3, 5.0)]
    } else {
        &[
            Cut(6, 3, 5.0),
            Cut(10, 5, 5.0),
            Cut(14, 7, 5.0),
            Cut(18, 8, 5.0),
        ]
    };
    for &cut in sizes {
        let body = |b: &Bench, p: &Patch, _: &mut Watch<'_>| {
            elements::linear(p, b.tissue.material).map_err(unsolved)
        };
        found.push(slab(
            "fem-linear",
            format!("{} bricks", cut.bricks()),
            cut,
            Box::new(body),
        ));
    }
    let condense = |family: &'static str, cut: Cut, pressed: bool| {
        let body = move |b: &Bench, p: &Patch, watch: &mut Watch<'_>| {
            let mut go_on = |share| watch.at("condensing the slab to its skin", share).is_ok();
            let (material, s) = (b.tissue.material, b.tissue.deviation_mm);
            let made = if pressed {
                elements::pressed(p, material, s, &mut go_on)
            } else {
                elements::condensed(p, material, &mut go_on)
            };
            made.map_err(unsolved)?.ok_or(LabError::Stopped)
        };
        slab(
            family,
            format!("{} skin nodes", cut.skin_nodes()),
            cut,
            Box::new(body),
        )
    };
    for &cut in &sizes[..sizes.len() - 1] {
        found.push(condense("fem-condensed", cut, false));
    }
    for &cut in &sizes[..sizes.len() - 1] {
        found.push(condense("fem-pressed", cut, true));
    }
    if !quick {
        // 5,041 nodes.
        found.push(condense("fem-pressed", Cut(35, 4, 5.0), true));
    }
    let turning = if quick {
        Cut(3, 2, 5.0)
    } else {
        Cut(8, 4, 5.0)
    };
    let tolerances: &[f64] = if quick {
        &[1.0e-2]
    } else {
        &[1.0e-2, 1.0e-4, 1.0e-8]
    };
    for &tolerance in tolerances {
        let body = move |b: &Bench, p: &Patch, _: &mut Watch<'_>| {
            elements::corotated(p, b.tissue.material, tolerance).map_err(unsolved)
        };
        let setting = format!("{} bricks, to {tolerance:e}", turning.bricks());
        found.push(slab("fem-corotated", setting, turning, Box::new(body)));
    }
    // Springs are at their best as cubes: a grid that is nearly even.
    let even = if quick {
        Cut(4, 2, 2.0)
    } else {
        Cut(6, 3, 2.0)
    };
    let steppings: &[(&'static str, Stepping, &str)] = &[
        ("springs-rest", Stepping::Rest, "Newton's method"),
        ("springs-explicit", Stepping::Explicit(200), "200 steps"),
        ("springs-explicit", Stepping::Explicit(800), "800 steps"),
        ("springs-explicit", Stepping::Explicit(3200), "3,200 steps"),
        ("springs-implicit", Stepping::Implicit(2), "2 frames"),
        ("springs-implicit", Stepping::Implicit(8), "8 frames"),
        ("springs-implicit", Stepping::Implicit(30), "30 frames"),
        (
            "xpbd",
            Stepping::Position(30, 1, 20),
            "30 frames of 20 sweeps",
        ),
        ("xpbd", Stepping::Position(4, 20, 1), "4 frames of 20 steps"),
        (
            "xpbd",
            Stepping::Position(30, 20, 1),
            "30 frames of 20 steps",
        ),
        (
            "xpbd",
            Stepping::Position(30, 80, 1),
            "30 frames of 80 steps",
        ),
    ];
    // Without Newton's method, which takes longest.
    let few = if quick { 1..2 } else { 0..steppings.len() };
    for &(name, stepping, word) in &steppings[few] {
        let body = move |b: &Bench, p: &Patch, _: &mut Watch<'_>| {
            lattice::springs(p, b.tissue.material, stepping)
                .map_err(|e| LabError::Input(e.to_string()))
        };
        found.push(slab(name, word.to_owned(), even, Box::new(body)));
    }
}
