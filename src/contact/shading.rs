//! Force shading: the force of the smooth surface that a mesh stands for, from its vertex normals.
//!
//! On a mesh the force turns with every facet. Here each facet carries a quadratic bulge b that bends as the vertex
//! normals do: along an edge e it is c λᵢλⱼ with c = (Nⱼ − Nᵢ)·e / 2, the same for both facets. The depth felt, D, is that
//! below the bulged surface, and the force has the size of the scene's model at D and the direction of −∇D: not
//! an interpolated normal with a depth of its own (Morgenbesser & Srinivasan 1996), whose work over a closed path need not
//! vanish, but one that follows from the other.
//!
//! Frictionless, the nearest point of the bulged surface is not over the foot p on the facet: D = d + w(d) · min over x of
//! b(x) + |x − p|²/2d, in closed form since b is quadratic. With friction the proxy is where it is held and D is the depth
//! below the bulge's tangent plane there. w(d) = d/(d + ramp) lets force and depth vanish together.
//!
//! Where facets meet, the pieces of D fit to third order in the angle between them, not exactly; [`Guard`] keeps a balance
//! so that not even that gives energy from nothing.

use super::ForceModel;
use super::face::Face;
use super::walk::Rest;
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;

/// Steepest bulge over its facet: beyond it the normals tell of a crease, not of a smooth surface.
const STEEPEST: f64 = 0.35;
/// How much of the focal depth of a convex bulge counts: nearer to it the nearest point is no longer one.
const FOCAL_SHARE: f64 = 0.5;
/// Depth at which half of the bulge is felt, in highest bulges.
const RAMP: f64 = 4.0;

/// What shading needs to know of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    ramp_mm: f64,
}

impl Shading {
    /// The shading of a surface by its vertex normals.
    pub fn of(surface: &Surface) -> Self {
        let mut highest: f64 = 0.0;
        for t in 0..surface.triangles().len() as u32 {
            if let Some(face) = Face::of(surface, t) {
                let c = bulge(surface, &face);
                highest = highest.max((c[0].abs() + c[1].abs() + c[2].abs()) / 9.0);
            }
        }
        Self {
            ramp_mm: (RAMP * highest).max(f64::MIN_POSITIVE),
        }
    }

    /// The depth felt and −∇D for a point finger that rests as told. From behind a sheet, and on a triangle without a plane,
    /// nothing is shaded.
    pub(super) fn smooth(&self, surface: &Surface, rest: &Rest, hip: Vec3, held: bool) -> Smooth {
        let plain = Smooth {
            depth: rest.depth,
            direction: rest.normal,
        };
        let face = Face::of(surface, rest.triangle);
        let Some(face) = face.filter(|f| f.normal.dot(rest.normal) > 0.0) else {
            return plain;
        };
        let d = rest.depth;
        let ramp = d + self.ramp_mm;
        let (w, w_slope) = (d / ramp, self.ramp_mm / (ramp * ramp));
        let smooth = if rest.normal.distance_squared(face.normal) < 1e-18 {
            let bend = Bend::of(surface, &face, rest.proxy);
            if held {
                let b = bend.height + bend.slope.dot(rest.foot - rest.proxy);
                Smooth {
                    depth: d + w * b,
                    direction: face.normal * (1.0 + w_slope * b) - bend.slope * w,
                }
            } else {
                let (b, b_by_depth, slope) = bend.nearest(d);
                Smooth {
                    depth: d + w * b,
                    direction: face.normal * (1.0 + w_slope * b + w * b_by_depth) - slope * w,
                }
            }
        } else {
            // On a concave edge or corner, where the facets' bulges meet in one normal: the distance to the hollow that goes
            // on with the bulge's curvature from there.
            let weights = surface
                .triangle(rest.triangle)
                .closest_point(rest.proxy)
                .barycentric;
            let normals = face.vertices.map(|v| surface.normals()[v as usize]);
            let mean = normals[0] * weights[0] + normals[1] * weights[1] + normals[2] * weights[2];
            let direction = unit_or(mean, rest.normal);
            let bend = Bend::of(surface, &face, rest.proxy);
            let below = (rest.proxy - hip).dot(direction);
            if held || below <= 0.0 {
                return plain;
            }
            let lean = rest.normal - direction;
            let hollow = bend.curvature_along(lean).max(0.0);
            let share = d * hollow / (1.0 + d * hollow);
            let b = bend.height + 0.5 * d * share * lean.length_squared();
            Smooth {
                depth: d + w * (below - d + b),
                direction: rest.normal * (1.0 - w) + (direction + lean * share) * w,
            }
        };
        if smooth.depth.is_finite() && smooth.direction.is_finite() {
            Smooth {
                depth: smooth.depth.max(0.0),
                ..smooth
            }
        } else {
            plain
        }
    }
}

/// The depth below the smooth surface, mm, and how it falls with the HIP.
#[derive(Clone, Copy, Debug)]
pub(super) struct Smooth {
    pub(super) depth: f64,
    pub(super) direction: Vec3,
}

/// Coefficients of a facet's bulge, mm: of λ₀λ₁, λ₁λ₂ and λ₂λ₀. Flattened as a whole where it is too steep.
fn bulge(surface: &Surface, face: &Face) -> [f64; 3] {
    let normals = face.vertices.map(|v| surface.normals()[v as usize]);
    let c = [0, 1, 2].map(|i| (normals[(i + 1) % 3] - normals[i]).dot(face.edges[i]) / 2.0);
    let rise = face.weight_slopes();
    // The slope is linear in the weights: greatest at a corner.
    let steepest = (0..3)
        .map(|i| (rise[(i + 1) % 3] * c[i] + rise[(i + 2) % 3] * c[(i + 2) % 3]).length())
        .fold(0.0, f64::max);
    let share = (STEEPEST / steepest).min(1.0);
    c.map(|c| if share.is_finite() { c * share } else { 0.0 })
}

/// A facet's bulge about one of its points.
struct Bend {
    height: f64,
    slope: Vec3,
    /// Curvatures, 1/mm, along two directions in the facet at right angles; negative where convex.
    curvature: [f64; 2],
    along: [Vec3; 2],
}

impl Bend {
    fn of(surface: &Surface, face: &Face, p: Vec3) -> Self {
        let c = bulge(surface, face);
        let l = face.weights(p);
        let rise = face.weight_slopes();
        let height = c[0] * l[0] * l[1] + c[1] * l[1] * l[2] + c[2] * l[2] * l[0];
        let slope = rise[0] * (c[0] * l[1] + c[2] * l[2])
            + rise[1] * (c[0] * l[0] + c[1] * l[2])
            + rise[2] * (c[1] * l[1] + c[2] * l[0]);
        let u = unit_or(face.edges[0], Vec3::X);
        let v = face.normal.cross(u);
        let second = |a: Vec3, b: Vec3| {
            (0..3)
                .map(|i| {
                    let (m, n) = (rise[i], rise[(i + 1) % 3]);
                    c[i] * (m.dot(a) * n.dot(b) + m.dot(b) * n.dot(a))
                })
                .sum::<f64>()
        };
        let (uu, uv, vv) = (second(u, u), second(u, v), second(v, v));
        let half = (uu - vv) / 2.0;
        let root = libm::hypot(half, uv);
        let mean = (uu + vv) / 2.0;
        let turned = if half >= 0.0 {
            u * (root + half) + v * uv
        } else {
            u * uv + v * (root - half)
        };
        let first = unit_or(turned, u);
        Self {
            height,
            slope,
            curvature: [mean + root, mean - root],
            along: [first, face.normal.cross(first)],
        }
    }

    /// Curvature in the direction of `way`, 1/mm; 0 for one across the facet.
    fn curvature_along(&self, way: Vec3) -> f64 {
        let parts = self.along.map(|v| way.dot(v) * way.dot(v));
        let sum = parts[0] + parts[1];
        if sum > 0.0 {
            (parts[0] * self.curvature[0] + parts[1] * self.curvature[1]) / sum
        } else {
            0.0
        }
    }

    /// At depth `d`: min over x of b(x) + |x − p|²/2d, its derivative by d, and its slope by p. Toward a focus the depth is
    /// held where the minimum is still one.
    fn nearest(&self, d: f64) -> (f64, f64, Vec3) {
        let (mut b, mut by_depth, mut slope) = (self.height, 0.0, Vec3::ZERO);
        for (h, v) in self.curvature.iter().zip(self.along) {
            let g = self.slope.dot(v);
            let most = if *h < 0.0 {
                FOCAL_SHARE / -h
            } else {
                f64::INFINITY
            };
            let deep = d.min(most);
            let stretch = 1.0 / (1.0 + deep * h);
            b -= 0.5 * deep * stretch * g * g;
            if d < most {
                by_depth -= 0.5 * (stretch * g) * (stretch * g);
            }
            slope += v * (stretch * g);
        }
        (b, by_depth, slope)
    }
}

/// The balance of a shaded contact: what the finger has put in beyond what is stored. It is never negative, since the
/// depth felt is held back where it would be (a passivity observer, Hannaford & Ryu 2002).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guard {
    /// HIP of the tick before, mm.
    pub hip_mm: Vec3,
    /// Force of the tick before, N.
    pub force_n: Vec3,
    /// Depth felt in the tick before, mm.
    pub felt_depth_mm: f64,
    /// What was put in and neither given back nor stored, mJ.
    pub credit_mj: f64,
}

impl Guard {
    /// The part of the depth felt that the balance allows at the stiffness `k`, and the credit that is left.
    ///
    /// What is stored is counted at one stiffness before and after: what a stiffness map gives or takes along the skin is
    /// the map's, and not held back.
    pub(super) fn allow(
        &self,
        model: &ForceModel,
        k: f64,
        hip: Vec3,
        force: Vec3,
        depth: f64,
    ) -> (f64, f64) {
        let put_in = -0.5 * (self.force_n + force).dot(hip - self.hip_mm);
        let stored = model.energy_mj(k, depth);
        let credit = self.credit_mj + put_in - (stored - model.energy_mj(k, self.felt_depth_mm));
        // A record that holds what is none must not be carried on for ever.
        if !credit.is_finite() {
            return (1.0, 0.0);
        }
        if credit >= 0.0 {
            return (1.0, credit);
        }
        if stored <= 0.0 {
            return (1.0, 0.0);
        }
        // F(d)/d does not fall with depth in any model, so energy grows at least as the square.
        (((stored + credit).max(0.0) / stored).sqrt(), 0.0)
    }
}
