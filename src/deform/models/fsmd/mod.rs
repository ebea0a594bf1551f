//! Functional shape matched deformation (Ji 2008, chapter 4).
//!
//! A vertex J is moved from its *rest* position by
//!
//! ```text
//! normal part      −N · min(d, max_normal) · M(q_n)
//! tangential part  (P − A) cut to max_tangential · M(q_t)
//! ```
//!
//! with A, P, N, d of the [`Press`], M the [`Curve`](crate::geom::curve::Curve), q_t the location ratio of J in the tangential footprint round A and
//! q_n that in the normal one, which is the same ellipse scaled by s(d) = s0 + (s1 − s0) · min(d, max) / max. A vertex at the
//! anchor so lands on the HIP while both are below their caps. Both parts move only what hangs together with the finger
//! inside their own footprint.
//!
//! Several fingers: normal parts add as vectors, tangential parts add as vectors, then each of the two sums is cut to its
//! cap in length, its direction kept, and the two are added. So for one finger the caps are the published ones, the order of
//! caps and sums does not depend on a frame, and two fingers side by side do not dig twice as deep as one may. Where there
//! are [`bones`](crate::deform::bones), they narrow normal footprints, and limit the normal sum after its cap.

mod field;
mod outline;
mod settings;

use crate::deform::blocks::{BLOCK, Block, Row, bits, put, put_each, vertex};
use crate::deform::patches::Patches;
use crate::deform::shading::Shading;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press, RingSearch};
use crate::geom::{Vec3, unit_or};
use crate::surface::Surface;
use field::{Field, Footprint};
use std::sync::Arc;

pub use settings::Settings;

/// No coordinate of a press may be larger, mm: ten times as far as a surface may reach, and squares stay finite.
const FARTHEST_MM: f64 = 10.0 * crate::surface::MAX_COORDINATE_MM;

/// The model with its scratch memory.
///
/// An update costs what the footprints hold, not what the surface holds; only the first one on another surface looks at all
/// of it (see [`Model::prepare`]). A footprint or cap that is not positive and finite moves nothing.
#[derive(Clone, Debug)]
pub struct Fsmd {
    settings: Settings,
    patches: Arc<Patches>,
    /// Fields of this update, in the order of the presses, each with a search of its own below.
    fields: Vec<Field>,
    searches: Vec<RingSearch>,
    /// Patches that a field or the last update moves.
    affected: Vec<u32>,
    affected_in: Vec<u32>,
    generation: u32,
    shading: Shading,
}

impl Fsmd {
    /// A model with the given settings.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            patches: Arc::default(),
            fields: Vec::new(),
            searches: Vec::new(),
            affected: Vec::new(),
            affected_in: Vec::new(),
            generation: 0,
            shading: Shading::default(),
        }
    }

    /// The settings in use.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Memory held beside the displacement, bytes.
    pub fn bytes(&self) -> usize {
        self.patches.bytes()
            + size_of::<Field>() * self.fields.capacity()
            + size_of::<RingSearch>() * self.searches.capacity()
            + self.searches.iter().map(RingSearch::bytes).sum::<usize>()
            + 4 * (self.affected.capacity() + self.affected_in.capacity())
            + self.shading.bytes()
    }

    /// The first half of [`Model::update`]: brings the offsets to the shape under `presses`.
    pub fn displace(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        let updates = out.updates + 1;
        let n_vertices = surface.positions().len();
        if out.n_vertices() != n_vertices {
            *out = Displacement::at_rest(surface);
        }
        out.updates = updates;
        self.prepare(surface);
        if !out
            .patches
            .as_ref()
            .is_some_and(|p| Arc::ptr_eq(p, &self.patches))
        {
            out.patches = Some(Arc::clone(&self.patches));
        }
        self.fields.clear();
        for press in presses {
            if let Some(press) = sound(press, surface) {
                self.add(surface, &press);
            }
        }
        self.gather_affected(&out.moved_in);
        out.moved_in.clear();
        self.shading.begin(&self.patches);
        for i in 0..self.affected.len() {
            let p = self.affected[i];
            let displaced = self.displace_patch(p, out);
            self.shading.note(p, displaced);
            if out.moved[p as usize] != 0 {
                out.moved_in.push(p);
            }
        }
    }

    /// The second half: recomputes the normals of the vertices displaced and of those next to them, and lists what is to be
    /// drawn anew.
    pub fn shade(&mut self, surface: &Surface, out: &mut Displacement) {
        self.shading.renew(surface, &self.patches, out, None);
    }

    /// The second half of [`Model::update_strained`]: as [`Fsmd::shade`], with the strain in the same pass.
    pub fn shade_strained(
        &mut self,
        surface: &Surface,
        out: &mut Displacement,
        strain: &mut Strain,
    ) {
        self.shading
            .renew(surface, &self.patches, out, Some(strain));
    }

    /// Adds the fields of one press and finds what they move.
    fn add(&mut self, surface: &Surface, press: &Press) {
        let s = &self.settings;
        let [wide, narrow] = s.footprints_at(surface, press);
        let pull = cut(press.foot_mm - press.anchor_mm, s.max_tangential_mm);
        let dent = -press.normal * press.depth_mm.min(s.max_normal_mm.max(0.0));
        let narrow = narrow.filter(|_| dent != Vec3::ZERO && dent.is_finite());
        let wide = wide.filter(|_| s.tangential && pull != Vec3::ZERO);
        let halves = [(wide, pull, true), (narrow, dent, false)];
        for (outline, centre_mm, tangential) in halves {
            let Some(outline) = outline else { continue };
            if self.searches.len() == self.fields.len() {
                self.searches.push(RingSearch::default());
            }
            let search = &mut self.searches[self.fields.len()];
            outline.search(search, surface, &self.patches, press.triangle);
            self.fields.push(Field {
                centre_mm,
                footprint: outline,
                tangential,
            });
        }
    }

    /// Lists the patches that a field moves or that the last update did.
    fn gather_affected(&mut self, moved_before: &[u32]) {
        if self.affected_in.len() != self.patches.len() || self.generation == u32::MAX {
            self.affected_in.clear();
            self.affected_in.resize(self.patches.len(), 0);
            self.generation = 0;
        }
        self.generation += 1;
        self.affected.clear();
        let searches = &self.searches[..self.fields.len()];
        let now = searches.iter().flat_map(|s| s.found().iter().copied());
        for p in now.chain(moved_before.iter().copied()) {
            let seen = &mut self.affected_in[p as usize];
            if *seen != self.generation {
                *seen = self.generation;
                self.affected.push(p);
            }
        }
        // In the order of memory, and of the surface whatever the search met first.
        self.affected.sort_unstable();
    }

    /// Brings the offsets of one patch up to date; answers with the bits of the vertices whose offset changed.
    fn displace_patch(&self, p: u32, out: &mut Displacement) -> u64 {
        let moved = &mut out.moved[p as usize];
        let held = &mut out.offsets_mm[p as usize];
        let searches = self.fields.iter().zip(&self.searches);
        let mut fields = searches.filter(|(_, search)| search.inside(p) != 0);
        let Some(first) = fields.next() else {
            *moved = 0;
            return put(held, &Block::ZERO).0;
        };
        let second = fields.next();
        let changed;
        if let (None, true) = (second, first.0.tangential || self.settings.bones.is_none()) {
            // The usual case, one field. It was cut at its centre already.
            let shares = self.shares(p, first);
            (changed, *moved) = put_shares(held, first.0.centre_mm, &shares);
            return changed;
        }
        let (mut normal, mut tangential) = (Block::ZERO, Block::ZERO);
        let (mut n_normal, mut n_tangential) = (0, 0);
        for field in std::iter::once(first).chain(second).chain(fields) {
            let (sums, n) = if field.0.tangential {
                (&mut tangential, &mut n_tangential)
            } else {
                (&mut normal, &mut n_normal)
            };
            add(sums, field.0.centre_mm, &self.shares(p, field));
            *n += 1;
        }
        if n_normal > 1 {
            cut_all(&mut normal, self.settings.max_normal_mm);
        }
        if n_tangential > 1 {
            cut_all(&mut tangential, self.settings.max_tangential_mm);
        }
        if let (Some(bones), 1..) = (&self.settings.bones, n_normal) {
            for i in 0..BLOCK {
                normal.set(i, bones.limited(vertex(p, i), normal.get(i)));
            }
        }
        for i in 0..BLOCK {
            normal.x[i] += tangential.x[i];
            normal.y[i] += tangential.y[i];
            normal.z[i] += tangential.z[i];
        }
        (changed, *moved) = put(held, &normal);
        changed
    }

    /// The share that each vertex of a patch has in a field.
    #[inline]
    fn shares(&self, p: u32, (field, search): (&Field, &RingSearch)) -> Row {
        let positions = self.patches.positions(p);
        let mut shares = field.footprint.shares(&self.settings.curve, positions);
        // What is outside has none; what is within and not found does not hang together with the finger.
        for i in bits(search.within(p) & !search.inside(p)) {
            shares[i] = 0.0;
        }
        shares
    }
}

/// Adds the share of a vector that each vertex has.
#[inline]
fn add(sums: &mut Block, centre: Vec3, shares: &Row) {
    for (i, share) in shares.iter().enumerate() {
        sums.x[i] += centre.x * share;
        sums.y[i] += centre.y * share;
        sums.z[i] += centre.z * share;
    }
}

fn cut_all(sums: &mut Block, max_mm: f64) {
    for i in 0..BLOCK {
        sums.set(i, cut(sums.get(i), max_mm));
    }
}

fn put_shares(held: &mut Block, centre: Vec3, shares: &Row) -> (u64, u64) {
    put_each(held, |i| {
        [
            centre.x * shares[i],
            centre.y * shares[i],
            centre.z * shares[i],
        ]
    })
}

impl Model for Fsmd {
    fn name(&self) -> &'static str {
        "fsmd"
    }

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn prepare(&mut self, surface: &Surface) {
        if !self.patches.are_of(surface) {
            self.patches = Arc::new(Patches::new(surface));
            self.shading.prepare(surface, &self.patches);
        }
    }

    fn update(&mut self, surface: &Surface, presses: &[Press], out: &mut Displacement) {
        self.displace(surface, presses, out);
        self.shade(surface, out);
    }

    fn update_strained(
        &mut self,
        surface: &Surface,
        presses: &[Press],
        out: &mut Displacement,
        strain: &mut Strain,
    ) {
        self.displace(surface, presses, out);
        self.shade_strained(surface, out, strain);
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
    sound.then_some(Press {
        normal,
        ..press.clone()
    })
}

/// `v` shortened to `max_mm` where it is longer; nothing for a cap that is not positive.
fn cut(v: Vec3, max_mm: f64) -> Vec3 {
    let length_sq = v.length_squared();
    // What has been cut once is not cut again.
    if length_sq <= max_mm * max_mm * (1.0 + 1e-15) && max_mm > 0.0 {
        v
    } else if max_mm > 0.0 {
        v * (max_mm / length_sq.sqrt())
    } else {
        Vec3::ZERO
    }
}
