//! Slabs as models of the drawn skin: a fingertip's pressure is put on, as strong as it takes to reach the depth.
//!
//! | file | holds |
//! |---|---|
//! | [`elements`] | finite elements, full, condensed to the skin, and turning |
//! | [`lattice`] | springs at rest, in explicit and implicit steps, and position-based |

pub mod elements;
pub mod lattice;

use super::fem::linear::Fixed;
use super::patch::Patch;
use super::plane::Plane;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press, Spread};
use crate::geom::{Vec2, Vec3};
use crate::surface::Surface;

/// What answers a load on the skin of a slab.
pub trait Body: Send {
    /// Name in files, tables and the command line.
    fn name(&self) -> &'static str;

    /// Writes how far the nodes of the skin move under a load, mm, into `moved`; leaves it empty where it finds no answer.
    fn respond(&mut self, load: &Load<'_>, moved: &mut Vec<Vec3>);

    /// Whether twice the force moves everything twice as far.
    fn is_linear(&self) -> bool {
        true
    }
}

/// A fingertip's pressure on a slab: a Gaussian on its tangent plane, along its normal.
#[derive(Clone, Copy, Debug)]
pub struct Load<'a> {
    /// The slab.
    pub patch: &'a Patch,
    /// Middle of the pressure on the plane, mm.
    pub place_mm: Vec2,
    /// Standard deviation, mm, > 0.
    pub deviation_mm: f64,
    /// Whole force, N.
    pub force_n: f64,
}

impl Load<'_> {
    /// Forces on the nodes of the skin, N, which add up to the whole.
    pub fn forces_n(&self) -> Vec<(usize, Vec3)> {
        let push = self.patch.plane.normal * -self.force_n;
        let shares = self.patch.shares(self.place_mm, self.deviation_mm);
        shares
            .into_iter()
            .map(|(node, share)| (node, push * share))
            .collect()
    }
}

/// A slab under the skin as a model of the drawn skin.
///
/// Of several presses the slab answers each by itself, and they add up. A press beside the slab moves nothing.
pub struct SlabModel {
    patch: Patch,
    body: Box<dyn Body>,
    deviation_mm: f64,
    spread: Spread,
    force_n: f64,
    moved_mm: Vec<Vec3>,
}

/// Forces tried for one that reaches a depth.
const MOST_STEPS: usize = 16;
/// Share of the depth by which it may be missed.
const DEPTH_TOLERANCE: f64 = 1.0e-3;
/// The first of them, well below what any tissue takes.
const FIRST_N_PER_MM: f64 = 0.02;

impl SlabModel {
    /// A model of `body` on `patch`; the pressure has standard deviation `deviation_mm` > 0.
    pub fn new(patch: Patch, body: Box<dyn Body>, deviation_mm: f64) -> Self {
        Self {
            patch,
            body,
            deviation_mm,
            spread: Spread::default(),
            force_n: 0.0,
            moved_mm: Vec::new(),
        }
    }

    /// The force of the last press answered, N; 0 where no answer was found.
    pub fn force_n(&self) -> f64 {
        self.force_n
    }

    /// Finds where the skin's nodes go for a press `depth_mm` deep at a place of the patch's plane, and the force.
    ///
    /// A body that is not linear is asked again and again, by the secant within what is known to be too little and too
    /// much; where it has no answer the force was too much. What came nearest counts.
    fn dent(&mut self, place_mm: Vec2, depth_mm: f64) {
        let (patch, moved) = (&self.patch, &mut self.moved_mm);
        let is_linear = self.body.is_linear();
        let mut respond = |force_n: f64, moved: &mut Vec<Vec3>| {
            let load = Load {
                patch,
                place_mm,
                deviation_mm: self.deviation_mm,
                force_n,
            };
            self.body.respond(&load, moved);
            let reached = patch.between(place_mm, moved)?;
            Some(-reached.dot(patch.plane.normal)).filter(|d| d.is_finite())
        };
        self.force_n = 0.0;
        let first_n = FIRST_N_PER_MM * depth_mm;
        let Some(first_mm) = respond(first_n, moved).filter(|d| *d > 0.0) else {
            moved.clear();
            return;
        };
        let linear_n = first_n * depth_mm / first_mm;
        if is_linear {
            moved.iter_mut().for_each(|u| *u *= linear_n / first_n);
            self.force_n = linear_n;
            return;
        }
        let (mut low, mut high) = ((0.0, 0.0), None);
        let (mut force_n, mut reached) = (first_n, Some(first_mm));
        let mut best = (f64::INFINITY, Vec::new());
        for _ in 0..MOST_STEPS {
            if let Some(now) = reached {
                let off = (now - depth_mm).abs();
                if off < best.0 {
                    best = (off, moved.clone());
                    self.force_n = force_n;
                }
                if off <= DEPTH_TOLERANCE * depth_mm {
                    break;
                }
            }
            match reached {
                Some(now) if now < depth_mm && now > low.1 => low = (force_n, now),
                Some(now) if now < depth_mm => {}
                over => high = Some((force_n, over)),
            }
            let from_low =
                |(f, d): (f64, f64)| low.0 + (f - low.0) * (depth_mm - low.1) / (d - low.1);
            force_n = match high {
                None => (low.0 * depth_mm / low.1).min(3.0 * low.0),
                Some((f, Some(d))) if d > low.1 => {
                    // Never so near to an end that the other one stays where it is.
                    let margin = 0.1 * (f - low.0);
                    from_low((f, d)).clamp(low.0 + margin, f - margin)
                }
                Some((f, _)) => 0.5 * (low.0 + f),
            };
            reached = respond(force_n, moved);
        }
        *moved = best.1;
    }

    fn gather(&mut self, surface: &Surface, presses: &[Press]) {
        self.spread.begin(surface);
        self.force_n = 0.0;
        for press in presses {
            let deep = press.depth_mm > 0.0 && press.depth_mm.is_finite();
            if Plane::of(press, surface).is_none() || !deep {
                continue;
            }
            self.dent(self.patch.plane.place_mm(press.anchor_mm), press.depth_mm);
            let (patch, moved) = (&self.patch, &self.moved_mm);
            self.spread.around(surface, press.triangle, |at| {
                patch.between(patch.plane.place_mm(at), moved)
            });
        }
    }
}

impl Model for SlabModel {
    fn name(&self) -> &'static str {
        self.body.name()
    }

    fn prepare(&mut self, surface: &Surface) {
        self.spread.prepare(surface);
    }

    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        self.gather(surface, presses);
        self.spread.write(surface, out, None);
    }

    fn update_strained(
        &mut self,
        surface: &Surface,
        presses: &[Press],
        out: &mut Displacement,
        strain: &mut Strain,
    ) {
        self.gather(surface, presses);
        self.spread.write(surface, out, Some(strain));
    }
}

/// Sides of a patch: held.
const SIDES: [Fixed; 4] = [Fixed::Held; 4];
