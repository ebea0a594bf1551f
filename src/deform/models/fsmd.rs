//! Functional shape matched deformation (Ji 2008, chapter 4).
//!
//! A vertex J is moved from its *rest* position by
//!
//! ```text
//! normal part      −N · min(d, max_normal) · M(q_n)
//! tangential part  (P − A) cut to max_tangential · M(q_t)
//! ```
//!
//! with A, P, N, d of the [`Press`], M the [`Curve`], q_t the location ratio of J in the tangential footprint round A and
//! q_n that in the normal one, which is the same ellipse scaled by s(d) = s0 + (s1 − s0) · min(d, max) / max. A vertex at the
//! anchor so lands on the HIP while both are below their caps. Both parts move only what hangs together with the finger
//! inside their own footprint.
//!
//! Several fingers: normal parts add as vectors, tangential parts add as vectors, then each of the two sums is cut to its
//! cap in length, its direction kept, and the two are added. So for one finger the caps are the published ones, the order of
//! caps and sums does not depend on a frame, and two fingers side by side do not dig twice as deep as one may.

use crate::deform::curve::Curve;
use crate::deform::footprint::Ellipse;
use crate::deform::ring::RingSearch;
use crate::deform::{Displacement, Model, Press};
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;

/// No coordinate of a press may be larger, mm: a kilometre off is no place on a body, and squares stay finite.
const FARTHEST_MM: f64 = 1.0e6;

/// What a scenario may choose. Lengths mm, angles rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Half the major axis of the tangential footprint, mm.
    pub half_major_mm: f64,
    /// Half the minor axis, mm; equal to the major one for the basic circle.
    pub half_minor_mm: f64,
    /// Direction of the major axis on the map plane from x, rad; axial.
    pub angle_rad: f64,
    /// Scale of the normal footprint against the tangential one at zero depth (METHOD 3, s0).
    pub normal_scale_shallow: f64,
    /// The same at the depth cap (METHOD 3, s1).
    pub normal_scale_deep: f64,
    /// Cap of the drawn normal displacement, mm (Ji 2008, eq. 4.16).
    pub max_normal_mm: f64,
    /// Cap of the drawn tangential displacement, mm (Ji 2008, eq. 4.18).
    pub max_tangential_mm: f64,
    /// Whether the tangential field is computed at all; off in a frictionless scene.
    pub tangential: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            half_major_mm: 140.0,
            half_minor_mm: 140.0,
            angle_rad: std::f64::consts::FRAC_PI_2,
            normal_scale_shallow: 0.10,
            normal_scale_deep: 0.40,
            max_normal_mm: 10.0,
            max_tangential_mm: 20.0,
            tangential: true,
        }
    }
}

impl Settings {
    /// Scale of the normal footprint at a depth, mm.
    fn normal_scale(&self, depth_mm: f64) -> f64 {
        let share = (depth_mm / self.max_normal_mm).clamp(0.0, 1.0);
        self.normal_scale_shallow + (self.normal_scale_deep - self.normal_scale_shallow) * share
    }
}

/// The model with its scratch memory.
///
/// An update costs what the footprints hold, not what the surface holds; only the first one on a surface of another size
/// allocates per vertex. A footprint or cap that is not positive and finite moves nothing.
#[derive(Clone, Debug)]
pub struct Fsmd {
    settings: Settings,
    curve: Curve,
    search: RingSearch,
    field: Field,
    changed: Vec<u32>,
}

impl Fsmd {
    /// A model with the given settings and the default curve.
    pub fn new(settings: Settings) -> Self {
        Self::with_curve(settings, Curve::gaussian())
    }

    /// A model with the given settings and curve.
    pub fn with_curve(settings: Settings, curve: Curve) -> Self {
        Self {
            settings,
            curve,
            search: RingSearch::default(),
            field: Field::default(),
            changed: Vec::new(),
        }
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The curve in use.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// Scratch memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.search.bytes() + self.field.bytes() + 4 * self.changed.capacity()
    }

    /// Adds what one press moves to the field.
    fn add(&mut self, surface: &Surface, press: &Press) {
        let s = &self.settings;
        let Some(footprint) = Ellipse::new(
            press.anchor_mm,
            press.normal,
            s.half_major_mm,
            s.half_minor_mm,
            s.angle_rad,
        ) else {
            return;
        };
        let pull = cut(press.foot_mm - press.anchor_mm, s.max_tangential_mm);
        if s.tangential && pull != Vec3::ZERO {
            self.search.search(surface, &footprint, press.triangle);
            for (&v, &q) in self.search.inside().iter().zip(self.search.ratios()) {
                self.field.at(v).tangential_mm += pull * self.curve.at(q);
            }
        }
        let dent = -press.normal * press.depth_mm.min(s.max_normal_mm);
        let scaled = footprint.scaled(s.normal_scale(press.depth_mm));
        if let Some(footprint) = scaled.filter(|_| dent != Vec3::ZERO) {
            self.search.search(surface, &footprint, press.triangle);
            for (&v, &q) in self.search.inside().iter().zip(self.search.ratios()) {
                self.field.at(v).normal_mm += dent * self.curve.at(q);
            }
        }
    }
}

impl Model for Fsmd {
    fn name(&self) -> &'static str {
        "fsmd"
    }

    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        self.displace(surface, presses, out);
        self.shade(surface, out);
    }
}

impl Fsmd {
    /// The first half of [`Model::update`]: brings the offsets to the shape under `presses`.
    pub fn displace(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        let n_vertices = surface.positions().len();
        if out.offsets_mm.len() != n_vertices || out.normals.len() != n_vertices {
            *out = Displacement::at_rest(surface);
        }
        self.field.begin(n_vertices);
        for press in presses {
            if let Some(press) = sound(press, surface) {
                self.add(surface, &press);
            }
        }
        self.changed.clear();
        for &v in &out.moved {
            if !self.field.holds(v) {
                out.offsets_mm[v as usize] = Vec3::ZERO;
                self.changed.push(v);
            }
        }
        out.moved.clear();
        let (max_n, max_t) = (self.settings.max_normal_mm, self.settings.max_tangential_mm);
        for (&v, parts) in self.field.vertices.iter().zip(&self.field.parts) {
            let offset = cut(parts.normal_mm, max_n) + cut(parts.tangential_mm, max_t);
            if offset != Vec3::ZERO {
                out.moved.push(v);
            }
            let held = &mut out.offsets_mm[v as usize];
            if *held != offset {
                *held = offset;
                self.changed.push(v);
            }
        }
    }

    /// The second half: recomputes the normals of the vertices displaced and of those next to them, and lists what is to be
    /// drawn anew.
    pub fn shade(&mut self, surface: &Surface, out: &mut Displacement) {
        out.touched.clear();
        self.field.begin(surface.positions().len());
        for &v in &self.changed {
            self.field.mark(v);
            out.normals[v as usize] = normal_at(surface, &out.offsets_mm, v);
            out.touched.push(v);
        }
        for &v in &self.changed {
            for &n in surface.topology().neighbours(v) {
                if self.field.mark(n) {
                    let normal = normal_at(surface, &out.offsets_mm, n);
                    let held = &mut out.normals[n as usize];
                    if *held != normal {
                        *held = normal;
                        out.touched.push(n);
                    }
                }
            }
        }
    }
}

/// The two parts of a vertex's displacement, mm, each summed over the fingers.
#[derive(Clone, Copy, Debug, Default)]
struct Parts {
    normal_mm: Vec3,
    tangential_mm: Vec3,
}

/// A sparse field over the vertices, emptied in no time.
#[derive(Clone, Debug, Default)]
struct Field {
    seen: Vec<u32>,
    slot: Vec<u32>,
    generation: u32,
    vertices: Vec<u32>,
    parts: Vec<Parts>,
}

impl Field {
    fn begin(&mut self, n_vertices: usize) {
        if self.seen.len() != n_vertices || self.generation == u32::MAX {
            self.seen.clear();
            self.seen.resize(n_vertices, 0);
            self.slot.resize(n_vertices, 0);
            self.generation = 0;
        }
        self.generation += 1;
        self.vertices.clear();
        self.parts.clear();
    }

    /// Whether the field has a value at `v`.
    fn holds(&self, v: u32) -> bool {
        self.seen[v as usize] == self.generation
    }

    /// Marks `v`; false when it was marked before.
    fn mark(&mut self, v: u32) -> bool {
        let seen = &mut self.seen[v as usize];
        let new = *seen != self.generation;
        *seen = self.generation;
        new
    }

    fn at(&mut self, v: u32) -> &mut Parts {
        if self.mark(v) {
            self.slot[v as usize] = self.parts.len() as u32;
            self.vertices.push(v);
            self.parts.push(Parts::default());
        }
        &mut self.parts[self.slot[v as usize] as usize]
    }

    fn bytes(&self) -> usize {
        4 * (self.seen.capacity() + self.slot.capacity() + self.vertices.capacity())
            + size_of::<Parts>() * self.parts.capacity()
    }
}

/// The press with a normal of length 1, or nothing when a part of it is no number, out of reach or no triangle.
fn sound(press: &Press, surface: &Surface) -> Option<Press> {
    let near = |p: Vec3| p.abs().max_element() <= FARTHEST_MM && p.is_finite();
    let normal = unit_or(press.normal, Vec3::ZERO);
    let sound = near(press.anchor_mm)
        && near(press.foot_mm)
        && normal != Vec3::ZERO
        && press.depth_mm >= 0.0
        && press.depth_mm.is_finite()
        && (press.triangle as usize) < surface.triangles().len();
    sound.then_some(Press { normal, ..*press })
}

/// `v` shortened to `max_mm` where it is longer; nothing for a cap that is not positive.
fn cut(v: Vec3, max_mm: f64) -> Vec3 {
    let length_sq = v.length_squared();
    if length_sq <= max_mm * max_mm && max_mm > 0.0 {
        v
    } else if max_mm > 0.0 {
        v * (max_mm / length_sq.sqrt())
    } else {
        Vec3::ZERO
    }
}

/// Unit normal of the deformed surface at `v`.
///
/// n = unit(n₀ |S₀| + S − S₀) with S and S₀ the sums of the area normals of its triangles, deformed and at rest, and n₀ its
/// normal at rest. So it leaves the normal at rest, which is weighted by angles, without a jump, and follows the area
/// normals from there on. Where no triangle of it moved, exactly n₀.
fn normal_at(surface: &Surface, offsets_mm: &[Vec3], v: u32) -> Vec3 {
    let (mut at_rest, mut now, mut moved) = (Vec3::ZERO, Vec3::ZERO, false);
    for &t in surface.topology().triangles_of(v) {
        let corners = surface.triangles()[t as usize].map(|c| c as usize);
        let [a, b, c] = corners.map(|c| surface.positions()[c]);
        let [da, db, dc] = corners.map(|c| offsets_mm[c]);
        moved |= da != Vec3::ZERO || db != Vec3::ZERO || dc != Vec3::ZERO;
        let (e, f) = (b - a, c - a);
        at_rest += e.cross(f);
        now += (e + (db - da)).cross(f + (dc - da));
    }
    let normal_at_rest = surface.normals()[v as usize];
    if moved {
        unit_or(
            normal_at_rest * at_rest.length() + (now - at_rest),
            normal_at_rest,
        )
    } else {
        normal_at_rest
    }
}
