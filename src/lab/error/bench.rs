//! One press on the skin of a scene, and what finely cut tissue does under it.

use super::subject::Make;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press};
use crate::geom::{Vec2, Vec3};
use crate::lab::{LabError, Report, Samples, Setup, Stopwatch, Watch};
use crate::partition::{Partition as _, Sides};
use crate::reference::fem::linear::SolveError;
use crate::reference::models::Tissue;
use crate::reference::patch::{Patch, PatchOptions};
use crate::reference::slab::{SlabModel, elements};
use crate::scenario::Scene;
use serde::{Deserialize, Serialize};

/// Depth of the press, mm.
const DEPTH_MM: f64 = 5.0;
/// Shapes are compared this far from the press along both axes of its plane, mm.
const COMPARED_MM: f64 = 45.0;
/// A vertex that faces away from the press more than this is not compared: cosine.
const FACING: f64 = 0.3;

/// The press, the skin and the truth.
pub struct Bench {
    pub scene: Scene,
    /// With the footprint that the scene's maps have there.
    pub press: Press,
    pub tissue: Tissue,
    /// Force that the scene makes felt at this depth, N.
    pub felt_n: f64,
    pub quick: bool,
    truth: Truth,
}

/// What the fine slab does.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Truth {
    force_n: f64,
    unknowns: usize,
    /// Vertices compared, where they go, mm, and their strain.
    vertices: Vec<u32>,
    offsets_mm: Vec<[f64; 3]>,
    strain: Vec<f64>,
}

/// What a model did.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Found {
    pub median_us: f64,
    pub p99_us: f64,
    pub rms_mm: f64,
    pub max_mm: f64,
    /// L2 of the error over L2 of the truth.
    pub relative: f64,
    /// The same of what lies along the normal of the press alone.
    pub dent_relative: f64,
    pub force_n: Option<f64>,
    /// Largest difference in strain.
    pub strain_off: f64,
    pub finite: bool,
}

/// How far a shape is off.
struct Errors {
    rms_mm: f64,
    max_mm: f64,
    relative: f64,
    dent_relative: f64,
}

impl Errors {
    const NONE_FINITE: Self = Self {
        rms_mm: f64::INFINITY,
        max_mm: f64::INFINITY,
        relative: f64::INFINITY,
        dent_relative: f64::INFINITY,
    };
}

impl Bench {
    /// A press of its own, or the dent of `press`: what drags along the skin is left out.
    pub fn new(
        scene: Scene,
        press: Option<Press>,
        setup: &Setup,
        watch: &mut Watch<'_>,
    ) -> Result<Self, LabError> {
        let surface = &*scene.surface;
        let press = match press {
            Some(press) => Press {
                foot_mm: press.anchor_mm,
                ..press
            },
            None => in_the_middle(&scene)?,
        };
        let at = (surface.triangle(press.triangle)).closest_point(press.anchor_mm);
        let corners = surface.triangles()[press.triangle as usize];
        let felt_n = press.depth_mm * scene.touch.stiffness_at(corners, at.barycentric);
        watch.at("a fine slab of tissue under the skin", 0.3)?;
        let tissue = Tissue::default();
        let truth = (setup.shelf).part("truth", || truth(&scene, &press, tissue, setup.quick))?;
        Ok(Self {
            scene,
            press,
            tissue,
            felt_n,
            quick: setup.quick,
            truth,
        })
    }

    /// Tells the circumstances.
    pub fn describe(&self, report: &mut Report) {
        let (t, at) = (self.tissue, self.press.anchor_mm);
        let triangles = self.scene.surface.triangles().len();
        report.set(
            "scene",
            format!("{}, {triangles} triangles", self.scene.scenario.name),
        );
        report.set(
            "press",
            format!(
                "{:.1} mm deep at ({:.0}, {:.0}) mm, pressure with s = {} mm",
                self.press.depth_mm, at.x, at.y, t.deviation_mm
            ),
        );
        let e_kpa = 1000.0 * t.material.e_n_per_mm2();
        report.set(
            "tissue",
            format!(
                "E = {e_kpa:.0} kPa, ν = {}, {} mm over bone",
                t.material.nu(),
                t.thickness_mm
            ),
        );
        report.set(
            "truth",
            format!(
                "finite elements, {} unknowns; {:.3} N",
                self.truth.unknowns, self.truth.force_n
            ),
        );
        report.set(
            "compared",
            format!(
                "{} vertices within {COMPARED_MM} mm",
                self.truth.vertices.len()
            ),
        );
    }

    /// Depth of the press, mm.
    pub fn depth_mm(&self) -> f64 {
        self.press.depth_mm
    }

    /// Force of the truth, N.
    pub fn force_n(&self) -> f64 {
        self.truth.force_n
    }

    /// RMS error of a model at this press, mm; infinite for a shape that is not finite.
    pub fn rms_mm(&self, model: &mut dyn Model) -> f64 {
        self.errors(&self.shape(model)).rms_mm
    }

    /// A slab under the press.
    pub fn patch(&self, n_half: usize, layers: usize, growth: f64) -> Result<Patch, LabError> {
        patch(
            &self.scene,
            &self.press,
            self.tissue,
            n_half,
            layers,
            growth,
        )
    }

    fn shape(&self, model: &mut dyn Model) -> Displacement {
        let mut shape = Displacement::at_rest(&self.scene.surface);
        model.update(
            &self.scene.surface,
            std::slice::from_ref(&self.press),
            &mut shape,
        );
        shape
    }

    fn errors(&self, shape: &Displacement) -> Errors {
        let (mut sum, mut most_mm, mut whole) = (0.0, 0.0_f64, 0.0);
        let (mut along_sum, mut along_whole) = (0.0, 0.0);
        for (v, truth) in self.truth.vertices.iter().zip(&self.truth.offsets_mm) {
            let truth = Vec3::from(*truth);
            let off = shape.offset_mm(*v) - truth;
            let [off_along, truth_along] = [off, truth].map(|u| u.dot(self.press.normal));
            sum += off.length_squared();
            most_mm = most_mm.max(off.length());
            whole += truth.length_squared();
            along_sum += off_along * off_along;
            along_whole += truth_along * truth_along;
        }
        let n = self.truth.vertices.len().max(1) as f64;
        let share = |part: f64, whole: f64| (part / whole.max(f64::MIN_POSITIVE)).sqrt();
        let found = Errors {
            rms_mm: (sum / n).sqrt(),
            max_mm: most_mm,
            relative: share(sum, whole),
            dent_relative: share(along_sum, along_whole),
        };
        if sum.is_finite() {
            found
        } else {
            Errors::NONE_FINITE
        }
    }

    /// Makes a model and runs it on the press, over and over, each time a little deeper or less deep, so that nothing can be
    /// left as it was.
    pub fn measure(&self, make: &Make<'_>, watch: &mut Watch<'_>) -> Result<Found, LabError> {
        let mut subject = make(self, watch)?;
        let (surface, stopwatch) = (&*self.scene.surface, Stopwatch::new());
        let mut shape = Displacement::at_rest(surface);
        subject.model().prepare(surface);
        let budget_us = if self.quick { 2.0e4 } else { 6.0e5 };
        let mut samples = Samples::default();
        let mut spent_us = 0.0;
        while samples.is_empty() || (spent_us < budget_us && samples.len() < 1000) {
            let deeper = if samples.len().is_multiple_of(2) {
                1.0
            } else {
                0.999
            };
            let press = Press {
                depth_mm: self.press.depth_mm * deeper,
                ..self.press.clone()
            };
            let presses = std::slice::from_ref(&press);
            let model = subject.model();
            let ((), took_us) = stopwatch.time(|| model.update(surface, presses, &mut shape));
            samples.push(took_us);
            spent_us += took_us;
        }
        if samples.len() > 1 {
            shape = self.shape(subject.model());
        }
        let errors = self.errors(&shape);
        let strain = Strain::new(surface, &shape);
        let both = self.truth.vertices.iter().zip(&self.truth.strain);
        let strain_off = both.map(|(v, truth)| (strain.values()[*v as usize] - truth).abs());
        let n = surface.positions().len() as u32;
        Ok(Found {
            median_us: samples.median(),
            p99_us: samples.quantile(0.99),
            rms_mm: errors.rms_mm,
            max_mm: errors.max_mm,
            relative: errors.relative,
            dent_relative: errors.dent_relative,
            force_n: subject.force_n(self.depth_mm()),
            strain_off: strain_off.fold(0.0, f64::max),
            finite: (0..n).all(|v| shape.offset_mm(v).is_finite() && shape.normal(v).is_finite()),
        })
    }
}

/// Over the muscle beside the spine of the built-in back; some way off the middle of any other surface.
fn in_the_middle(scene: &Scene) -> Result<Press, LabError> {
    let surface = &*scene.surface;
    let bounds = surface.bounds();
    let place = bounds.centre().truncate() + Vec2::X * (0.08 * bounds.size().x);
    let over = place.extend(bounds.max.z + 1.0);
    let under = place.extend(bounds.min.z - 1.0);
    let hit = scene.touch.search.sweep(surface, over, under, Sides::Front);
    let why = "there is no skin in the middle to press on";
    let hit = hit.ok_or_else(|| LabError::Input(why.to_owned()))?;
    let press = Press {
        anchor_mm: hit.point,
        foot_mm: hit.point,
        normal: surface.triangle(hit.triangle).normal(),
        depth_mm: DEPTH_MM,
        triangle: hit.triangle,
        ..Press::default()
    };
    Ok(match (&scene.ellipse, &scene.ellipse_field) {
        (Some(map), Some(field)) => press.on_map(surface, map, field),
        _ => press,
    })
}

fn patch(
    scene: &Scene,
    press: &Press,
    tissue: Tissue,
    n_half: usize,
    layers: usize,
    growth: f64,
) -> Result<Patch, LabError> {
    let options = PatchOptions {
        n_half,
        layers,
        growth,
        thickness_mm: tissue.thickness_mm,
        ..PatchOptions::default()
    };
    let (surface, search) = (&scene.surface, &*scene.touch.search);
    Patch::new(surface, search, press.anchor_mm, press.normal, options)
        .map_err(|e| LabError::Input(e.to_string()))
}

fn truth(scene: &Scene, press: &Press, tissue: Tissue, quick: bool) -> Result<Truth, LabError> {
    let (n_half, layers) = if quick { (8, 4) } else { (22, 10) };
    let patch = patch(scene, press, tissue, n_half, layers, 6.0)?;
    let unsolved = |e: SolveError| LabError::Input(e.to_string());
    let (plane, unknowns) = (patch.plane, 3 * patch.slab.nodes_mm().len());
    let body = elements::linear(&patch, tissue.material).map_err(unsolved)?;
    let mut model = SlabModel::new(patch, body, tissue.deviation_mm);
    let surface = &*scene.surface;
    let mut shape = Displacement::at_rest(surface);
    model.update(surface, std::slice::from_ref(press), &mut shape);
    let strain = Strain::new(surface, &shape);
    let compared = |v: &u32| {
        let at = surface.positions()[*v as usize];
        plane.place_mm(at).abs().max_element() <= COMPARED_MM
            && surface.normals()[*v as usize].dot(plane.normal) > FACING
            && at.distance(press.anchor_mm) < 2.0 * COMPARED_MM
    };
    let vertices: Vec<u32> = (0..surface.positions().len() as u32)
        .filter(compared)
        .collect();
    Ok(Truth {
        force_n: model.force_n(),
        unknowns,
        offsets_mm: vertices
            .iter()
            .map(|v| shape.offset_mm(*v).to_array())
            .collect(),
        strain: vertices
            .iter()
            .map(|v| strain.values()[*v as usize])
            .collect(),
        vertices,
    })
}
