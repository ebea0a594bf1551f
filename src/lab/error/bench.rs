//! One press on the built-in back, and what finely cut tissue does under it.

use super::super::{LabError, Report, Samples, Setup, Stopwatch, Watch};
use super::field::Candidate;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Press};
use crate::geom::{Vec2, Vec3};
use crate::partition::bvh::Bvh;
use crate::partition::{Partition as _, Sides};
use crate::reference::Elastic;
use crate::reference::patch::{Patch, PatchOptions};
use crate::reference::slab::{self, SlabModel};
use crate::surface::Surface;
use crate::surface::back::{self, BackOptions};
use std::sync::Arc;

/// Where the press is: over the erector muscle, right of T9.
const PLACE_MM: Vec2 = Vec2::new(35.0, 235.0);
/// Depth of the press, mm.
const DEPTH_MM: f64 = 5.0;
/// Shapes are compared this far from the press along both axes of its plane, mm.
const COMPARED_MM: f64 = 45.0;
/// The tissue: muscle on bone 20 mm below, pressed by a fingertip.
pub const THICKNESS_MM: f64 = 20.0;
/// Spread of the fingertip's pressure, mm.
pub const DEVIATION_MM: f64 = 3.5;
/// The material.
pub const MATERIAL: Elastic = Elastic::MUSCLE;

/// The press, the skin and the truth.
pub struct Bench {
    pub surface: Arc<Surface>,
    pub search: Bvh,
    pub press: Press,
    pub depth_mm: f64,
    /// Force of the truth, N.
    pub force_n: f64,
    pub quick: bool,
    /// Vertices compared, with where they truly go, mm.
    truth: Vec<(u32, Vec3)>,
    true_strain: Vec<f64>,
    unknowns: usize,
}

/// What a model did.
pub struct Found {
    pub median_us: f64,
    pub p99_us: f64,
    pub rms_mm: f64,
    pub max_mm: f64,
    /// L2 of the error over L2 of the truth.
    pub relative: f64,
    pub force_n: Option<f64>,
    /// Largest difference in strain.
    pub strain_off: f64,
    pub finite: bool,
}

impl Bench {
    pub fn new(setup: &Setup, watch: &mut Watch<'_>) -> Result<Self, LabError> {
        watch.at("the back", 0.0)?;
        let triangles =
            setup
                .triangles
                .first()
                .copied()
                .unwrap_or(if setup.quick { 2_962 } else { 20_389 });
        let raw = back::make(&BackOptions::with_triangles(triangles));
        let (surface, _) = Surface::new(raw).map_err(|e| LabError::Input(e.to_string()))?;
        let search = Bvh::new(&surface);
        let over = PLACE_MM.extend(surface.bounds().max.z + 10.0);
        let hit = search
            .sweep(&surface, over, over - Vec3::Z * 1000.0, Sides::Front)
            .ok_or_else(|| LabError::Input("there is no skin where the lab presses".to_owned()))?;
        let press = Press {
            anchor_mm: hit.point,
            foot_mm: hit.point,
            normal: surface.triangle(hit.triangle).normal(),
            depth_mm: DEPTH_MM,
            triangle: hit.triangle,
            ..Press::default()
        };
        watch.at("a fine slab of tissue", 0.2)?;
        let options = PatchOptions {
            n_half: if setup.quick { 12 } else { 22 },
            layers: if setup.quick { 6 } else { 10 },
            thickness_mm: THICKNESS_MM,
            growth: 6.0,
            ..PatchOptions::default()
        };
        let patch = Patch::new(&surface, &search, press.anchor_mm, press.normal, options)
            .map_err(|e| LabError::Input(e.to_string()))?;
        let plane = patch.plane;
        let unknowns = 3 * patch.slab.nodes_mm().len();
        let body = slab::linear(&patch, MATERIAL).map_err(|e| LabError::Input(e.to_string()))?;
        let mut model = SlabModel::new(patch, body, DEVIATION_MM);
        let mut shape = Displacement::at_rest(&surface);
        crate::deform::Model::update(
            &mut model,
            &surface,
            std::slice::from_ref(&press),
            &mut shape,
        );
        let strain = Strain::new(&surface, &shape);
        let compared = |v: &u32| {
            let at = surface.positions()[*v as usize];
            let flat = plane.place_mm(at).abs().max_element() <= COMPARED_MM;
            flat && surface.normals()[*v as usize].dot(plane.normal) > 0.3
                && (at - press.anchor_mm).length() < 2.0 * COMPARED_MM
        };
        let truth: Vec<(u32, Vec3)> = (0..surface.positions().len() as u32)
            .filter(compared)
            .map(|v| (v, shape.offset_mm(v)))
            .collect();
        let true_strain = truth
            .iter()
            .map(|(v, _)| strain.values()[*v as usize])
            .collect();
        Ok(Self {
            surface: Arc::new(surface),
            search,
            press,
            depth_mm: DEPTH_MM,
            force_n: model.force_n(),
            quick: setup.quick,
            truth,
            true_strain,
            unknowns,
        })
    }

    /// Tells the circumstances.
    pub fn describe(&self, report: &mut Report) {
        report.set(
            "skin",
            format!(
                "built-in back, {} triangles",
                self.surface.triangles().len()
            ),
        );
        report.set(
            "press",
            format!(
                "{DEPTH_MM} mm deep at ({}, {}) mm, pressure with s = {DEVIATION_MM} mm",
                PLACE_MM.x, PLACE_MM.y
            ),
        );
        report.set(
            "tissue",
            format!("E = 25 kPa, ν = 0.45, {THICKNESS_MM} mm over bone"),
        );
        report.set(
            "truth",
            format!(
                "finite elements, {} unknowns; {:.3} N",
                self.unknowns, self.force_n
            ),
        );
        report.set(
            "compared",
            format!("{} vertices within {COMPARED_MM} mm", self.truth.len()),
        );
    }

    /// RMS error of a model at this press, mm; infinite for a shape that is not finite.
    pub fn rms_mm(&self, model: &mut dyn crate::deform::Model) -> f64 {
        let mut shape = Displacement::at_rest(&self.surface);
        model.update(&self.surface, std::slice::from_ref(&self.press), &mut shape);
        self.errors(&shape).0
    }

    /// RMS, largest and relative error.
    fn errors(&self, shape: &Displacement) -> (f64, f64, f64) {
        let (mut sum, mut most, mut whole) = (0.0, 0.0_f64, 0.0);
        for (v, truth) in &self.truth {
            let off = shape.offset_mm(*v) - *truth;
            if !off.is_finite() {
                return (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            }
            sum += off.length_squared();
            most = most.max(off.length());
            whole += truth.length_squared();
        }
        (
            (sum / self.truth.len().max(1) as f64).sqrt(),
            most,
            (sum / whole).sqrt(),
        )
    }

    /// Runs a model on the press, over and over, each time a little deeper or less deep so that nothing can be left as it was.
    pub fn measure(&self, candidate: &mut Candidate) -> Found {
        let stopwatch = Stopwatch::new();
        let mut shape = Displacement::at_rest(&self.surface);
        let model = candidate.model.as_mut();
        model.prepare(&self.surface);
        let budget_us = if self.quick { 5.0e4 } else { 4.0e5 };
        let mut samples = Samples::default();
        let mut spent_us = 0.0;
        while samples.len() < 5 || (spent_us < budget_us && samples.len() < 400) {
            let deeper = if samples.len().is_multiple_of(2) {
                1.0
            } else {
                0.999
            };
            let press = Press {
                depth_mm: self.depth_mm * deeper,
                ..self.press.clone()
            };
            let ((), took_us) =
                stopwatch.time(|| model.update(&self.surface, &[press], &mut shape));
            samples.push(took_us);
            spent_us += took_us;
            if took_us > 2.0e6 {
                break;
            }
        }
        model.update(&self.surface, std::slice::from_ref(&self.press), &mut shape);
        let (rms_mm, max_mm, relative) = self.errors(&shape);
        let strain = Strain::new(&self.surface, &shape);
        let both = self.truth.iter().zip(&self.true_strain);
        let strain_off = both
            .map(|((v, _), truth)| (strain.values()[*v as usize] - truth).abs())
            .fold(0.0, f64::max);
        let n = self.surface.positions().len() as u32;
        Found {
            median_us: samples.median(),
            p99_us: samples.quantile(0.99),
            rms_mm,
            max_mm,
            relative,
            force_n: candidate.force_n.as_ref().map(|f| f(self.depth_mm)),
            strain_off,
            finite: (0..n).all(|v| shape.offset_mm(v).is_finite() && shape.normal(v).is_finite()),
        }
    }
}
