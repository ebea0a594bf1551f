//! Where the proxy is and what force the finger feels. Pure functions and values: no clock, allocation, lock or I/O.
//!
//! One finger is a *HIP* (haptic interface point: where the device is) and a *proxy* (god object: where it would be had
//! the surface stopped it). Fingers do not know of each other: the haptic surface never deforms.

mod crease;
mod face;
mod force;
mod friction;
mod pad;
mod proxy;
pub mod published;
mod shading;
mod walk;

use crate::geom::Vec3;
use crate::partition::{Partition, Sides, bvh::Bvh};
use crate::surface::Surface;
use std::sync::Arc;

pub use force::ForceModel;
pub use friction::anchor_from;
pub use proxy::FARTHEST_MM;
use published::Published;
pub use shading::{Guard, Shading};

/// Smallest finger pad, mm.
const LEAST_PAD_MM: f64 = 1.0e-6;

/// Everything the servo needs to know of a scene to feel it. Immutable while in use.
#[derive(Clone, Debug)]
pub struct TouchScene {
    /// The static haptic surface.
    pub surface: Arc<Surface>,
    /// Its search structure.
    pub search: Arc<Bvh>,
    /// How stiff it is.
    pub stiffness: Stiffness,
    /// Present in a scene that came by an edit: the stiffness it came from, and how far it has got.
    pub fading: Option<Fading>,
    /// Absent: frictionless, and nothing tangential is computed.
    pub friction: Option<Friction>,
    /// Skin drag: a factor on both friction coefficients per vertex; absent: 1 everywhere, and nothing is computed. Means
    /// nothing without friction.
    pub drag: Option<Arc<[f64]>>,
    /// How the finger meets the surface, by name.
    pub choices: Choices,
    /// Present: the force is that of the smooth surface the mesh stands for. A pad rounds by itself and does without.
    pub shading: Option<Shading>,
    /// Present: this pass feels the surface in place of the production engine.
    pub published: Option<Arc<Published>>,
}

/// The named choices of how the finger meets the surface. Each has a default that costs nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Choices {
    /// How the force grows with depth.
    pub force: ForceModel,
    /// Radius of the finger pad, mm; 0, or what is not a length: the finger is a point.
    pub finger_radius_mm: f64,
    /// From which sides the surface stops the finger. From the back only an open sheet is meant to be felt; a finger that
    /// starts inside a closed body is then kept in. A pad and the published pass feel the front only.
    pub sides: Sides,
    /// Whether [`TouchScene::shading`] is wanted.
    pub shaded: bool,
}

impl Choices {
    /// Radius of the finger pad, mm, where the finger is not a point. Below a nanometre a pad is one: no step of it, which
    /// is shorter than its radius, would lead anywhere.
    pub fn pad_mm(&self) -> Option<f64> {
        let r = self.finger_radius_mm;
        (LEAST_PAD_MM..=FARTHEST_MM).contains(&r).then_some(r)
    }
}

/// Where the finger is, and how it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hip {
    /// The haptic interface point, mm.
    pub position_mm: Vec3,
    /// Its velocity, mm/s. One that is not finite counts as none.
    pub velocity_mm_s: Vec3,
}

/// A HIP at rest.
impl From<Vec3> for Hip {
    fn from(position_mm: Vec3) -> Self {
        Self {
            position_mm,
            velocity_mm_s: Vec3::ZERO,
        }
    }
}

impl Hip {
    /// How fast the depth below a plane with this outward normal grows, mm/s; finite.
    pub fn depth_rate_mm_s(&self, normal: Vec3) -> f64 {
        let rate = -self.velocity_mm_s.dot(normal);
        if rate.is_finite() { rate } else { 0.0 }
    }
}

/// Moves the proxy of one finger after the HIP and returns what the finger feels.
///
/// A HIP that is not finite, or beyond [`FARTHEST_MM`], leaves the state as it was and feels nothing.
pub fn advance(scene: &TouchScene, state: &mut ContactState, hip: impl Into<Hip>) -> Contact {
    match &scene.published {
        None => proxy::advance(scene, state, hip.into()),
        Some(published) => published::advance(scene, published, state, hip.into()),
    }
}

impl TouchScene {
    /// A frictionless scene with every choice at its default.
    pub fn new(surface: Arc<Surface>, search: Arc<Bvh>, stiffness: Stiffness) -> Self {
        Self {
            surface,
            search,
            stiffness,
            fading: None,
            friction: None,
            drag: None,
            choices: Choices::default(),
            shading: None,
            published: None,
        }
    }

    /// Stiffness that is felt at a point of a triangle with the given corners, N/mm: on the way from the one before an edit
    /// to the one after it, both in their shares. What is no stiffness counts as 0, what is absurdly stiff as 1e9 N/mm.
    pub fn stiffness_at(&self, corners: [u32; 3], barycentric: [f64; 3]) -> f64 {
        let after = force::sound_stiffness(self.stiffness.at(corners, barycentric));
        match &self.fading {
            Some(Fading { from, share, .. }) if *share < 1.0 => {
                let before = force::sound_stiffness(from.at(corners, barycentric));
                before * (1.0 - share) + after * share
            }
            _ => after,
        }
    }

    /// Whether skin drag is anything but 1 everywhere.
    fn has_drag(&self) -> bool {
        self.drag.is_some() || (self.fading.as_ref()).is_some_and(|f| f.from_drag.is_some())
    }

    /// What both friction coefficients are multiplied by at a point of a triangle with the given corners: on its way as
    /// [`TouchScene::stiffness_at`] is. A vertex without a value counts as 1; so does what is no factor.
    pub fn drag_at(&self, corners: [u32; 3], barycentric: [f64; 3]) -> f64 {
        let at = |values: &Option<Arc<[f64]>>| {
            let Some(values) = values else { return 1.0 };
            // From the first corner, so that the same drag at all three is exactly that.
            let [a, b, c] = corners.map(|v| *values.get(v as usize).unwrap_or(&1.0));
            let drag = a + (b - a) * barycentric[1] + (c - a) * barycentric[2];
            if drag.is_finite() && drag >= 0.0 {
                drag
            } else {
                1.0
            }
        };
        let after = at(&self.drag);
        match &self.fading {
            Some(fading) if fading.share < 1.0 => {
                at(&fading.from_drag) * (1.0 - fading.share) + after * fading.share
            }
            _ => after,
        }
    }

    /// Share of its own stiffness that is felt, 0 … 1: 1 unless it came by an edit and is not wholly there.
    pub fn share(&self) -> f64 {
        self.fading.as_ref().map_or(1.0, |f| f.share)
    }

    /// Memory held by the search structures and the stiffness values, bytes; the surface is counted by itself.
    pub fn bytes(&self) -> usize {
        self.search.bytes()
            + self.stiffness.bytes()
            + self.drag.as_ref().map_or(0, |drag| size_of_val(&drag[..]))
            + self.published.as_ref().map_or(0, |p| p.bytes())
    }
}

/// Stiffness on the surface, N/mm.
#[derive(Clone, Debug)]
pub enum Stiffness {
    /// The same everywhere; nothing is stored per vertex.
    Uniform(f64),
    /// One value per vertex, barycentric in between (ours; Ji 2008, 5.2 takes the nearest vertex).
    PerVertex(Arc<[f64]>),
}

impl Stiffness {
    /// Memory held per surface, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Uniform(_) => 0,
            Self::PerVertex(values) => size_of_val(&values[..]),
        }
    }

    /// Value at a point of a triangle with the given corners, N/mm. A vertex without a value counts as 0.
    pub fn at(&self, corners: [u32; 3], barycentric: [f64; 3]) -> f64 {
        match self {
            Self::Uniform(k) => *k,
            Self::PerVertex(values) => (0..3)
                .map(|i| values.get(corners[i] as usize).unwrap_or(&0.0) * barycentric[i])
                .sum(),
        }
    }
}

/// What an edit of the stiffness and the skin drag leads away from, and how far it has got.
#[derive(Clone, Debug)]
pub struct Fading {
    /// Stiffness before the edit. Never itself a mixture: an edit begins when the one before it is wholly there.
    pub from: Stiffness,
    /// Skin drag before the edit.
    pub from_drag: Option<Arc<[f64]>>,
    /// Share of the new stiffness and skin drag that is felt, 0 … 1.
    pub share: f64,
}

/// Coulomb friction with a static and a dynamic coefficient (Zhang & Mak 1999: 0.46, split 0.46 / 0.44 by Ji 2008, 2.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Coefficient while the proxy sticks.
    pub static_coefficient: f64,
    /// Coefficient while it slips; at most the static one.
    pub dynamic_coefficient: f64,
    /// f_adj of Ji 2008, 4.6: 0.7 tight, 1.0 normal, 1.3 loose skin. Tangential stiffness is k / f_adj, so slip starts
    /// at |P − A| = μ · f_adj · depth.
    pub skin_looseness: f64,
}

/// How the proxy meets the surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Touch {
    /// Not at all: the proxy is at the HIP.
    #[default]
    Free = 0,
    /// On the surface, frictionless.
    Frictionless = 1,
    /// On the surface, held by static friction.
    Stick = 2,
    /// On the surface, slipping against dynamic friction.
    Slip = 3,
}

/// What one tick leaves behind for the next. Every field is part of the record, so any record is a restart point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactState {
    /// How the proxy meets the surface.
    pub touch: Touch,
    /// The proxy, mm.
    pub proxy_mm: Vec3,
    /// Triangle the proxy is on; 0 when free.
    pub triangle: u32,
    /// The proxy is on the back of its triangle.
    pub behind: bool,
    /// The energy balance of force shading; at rest without it.
    pub guard: Guard,
}

impl ContactState {
    /// What `contact` of a HIP at `hip_mm` leaves behind.
    pub fn after(hip_mm: Vec3, contact: &Contact) -> Self {
        Self {
            touch: contact.touch,
            proxy_mm: contact.anchor_mm,
            triangle: contact.triangle,
            behind: contact.behind,
            guard: Guard {
                hip_mm,
                force_n: contact.force_n,
                felt_depth_mm: contact.felt_depth_mm,
                credit_mj: contact.credit_mj,
            },
        }
    }
}

/// The outcome of one tick for one finger. All finite. When free: normal, depth, stiffness and force are zero and all
/// points are at the HIP. Of a finger pad, points and depth are those of its centre; the skin is a radius below.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// How the proxy meets the surface.
    pub touch: Touch,
    /// Triangle the proxy is on; 0 when free.
    pub triangle: u32,
    /// The proxy is on the back of its triangle, and the normal points out of that; only where both sides are felt.
    pub behind: bool,
    /// Where friction holds the skin: the proxy. Without friction the same as `foot_mm`. METHOD's A.
    pub anchor_mm: Vec3,
    /// The HIP's foot on the tangent plane at the proxy. METHOD's P.
    pub foot_mm: Vec3,
    /// Outward unit normal of the tangent plane.
    pub normal: Vec3,
    /// Penetration depth of the HIP below the tangent plane, mm, ≥ 0.
    pub depth_mm: f64,
    /// Stiffness at the proxy, N/mm.
    pub stiffness_n_per_mm: f64,
    /// Force on the finger before any device limit, N.
    pub force_n: Vec3,
    /// Depth that the force answers to, mm: `depth_mm`, or with force shading that below the smooth surface.
    pub felt_depth_mm: f64,
    /// With force shading, what the finger has put in and neither got back nor left stored, mJ, ≥ 0; else 0.
    pub credit_mj: f64,
}
