//! The half-spaces a pad's centre may move in, and the place in all of them that is nearest to the HIP.

use crate::geom::Vec3;

/// Most half-spaces at once.
const MOST_PLANES: usize = 24;
/// Two planes whose normals differ by less than this sine count as one direction.
const PARALLEL_SINE_SQ: f64 = 1e-18;
/// What rounding makes of a projection onto nearly dependent planes, as a share of its length.
const DEPENDENT: f64 = 1e-10;
/// Most planes taken in turn into the three that hold: each brings the answer strictly farther from the HIP.
const MAX_TURNS: usize = 64;

/// The centres `x` with `normal · (x − c) ≥ −gap`, seen from the centre `c`: all of them are at least a radius away from
/// the triangle that it stands for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Plane {
    pub(super) normal: Vec3,
    /// How far the centre may go against the normal, mm.
    pub(super) gap: f64,
    /// How far the triangle itself is from touching, mm; at least `gap`.
    pub(super) slack: f64,
    pub(super) triangle: u32,
}

/// The half-spaces about one centre.
pub(super) struct Planes {
    all: [Plane; MOST_PLANES],
    len: usize,
}

/// The place nearest to the HIP and up to three planes that hold it there, the one with the greatest share first.
#[derive(Clone, Copy)]
pub(super) struct Held {
    /// Seen from the centre, mm.
    pub(super) goal: Vec3,
    pub(super) active: [usize; 3],
    pub(super) n_active: usize,
}

impl Planes {
    pub(super) fn new() -> Self {
        Self {
            all: [Plane::default(); MOST_PLANES],
            len: 0,
        }
    }

    pub(super) fn as_slice(&self) -> &[Plane] {
        &self.all[..self.len]
    }

    /// Whether the half-space of triangle `t` is among them.
    pub(super) fn has(&self, t: u32) -> bool {
        self.as_slice().iter().any(|p| p.triangle == t)
    }

    /// Adds a half-space; whether there was a place for it.
    pub(super) fn push(&mut self, plane: Plane) -> bool {
        let fits = self.len < MOST_PLANES;
        if fits {
            self.all[self.len] = plane;
            self.len += 1;
        }
        fits
    }

    /// As much of `way` as all half-spaces allow.
    pub(super) fn allowed(&self, way: Vec3, rounding: f64) -> Vec3 {
        let mut part: f64 = 1.0;
        for p in self.as_slice() {
            let closing = -p.normal.dot(way);
            let room = p.gap.max(0.0);
            if closing > room + rounding {
                part = part.min(room / closing);
            }
        }
        way * part
    }

    /// The point nearest to `hip`, seen from the centre like it, of all half-spaces whose triangles are `within` this of
    /// touching: the projection onto a convex polyhedron, by a dual active set of at most three planes (Goldfarb & Idnani
    /// 1983, in three dimensions by trying the at most seven subsets). Where the planes are too nearly dependent to tell,
    /// as far on the way there as all of them allow.
    pub(super) fn nearest_to(&self, hip: Vec3, within: f64, rounding: f64) -> Held {
        let mut held = Held {
            goal: hip,
            active: [0; 3],
            n_active: 0,
        };
        for _ in 0..MAX_TURNS {
            let mut worst = None;
            let mut most = rounding;
            for (i, p) in self.as_slice().iter().enumerate() {
                let beyond = -(p.normal.dot(held.goal) + p.gap);
                if beyond > most && p.slack <= within && !held.active[..held.n_active].contains(&i)
                {
                    (worst, most) = (Some(i), beyond);
                }
            }
            let Some(new) = worst else { return held };
            match self.with(new, &held, hip, rounding) {
                Some(next) => held = next,
                None => break,
            }
        }
        Held {
            goal: self.allowed(held.goal, rounding),
            ..held
        }
    }

    /// The nearest point once plane `new` must hold as well.
    fn with(&self, new: usize, held: &Held, hip: Vec3, rounding: f64) -> Option<Held> {
        let old = &held.active[..held.n_active];
        let rounding = rounding.max(DEPENDENT * hip.length());
        let mut best: Option<(f64, Held)> = None;
        let mut offer = |subset: &[usize]| {
            let Some((goal, shares)) = self.project(subset, hip) else {
                return;
            };
            let holds = |&i: &usize| self.all[i].normal.dot(goal) + self.all[i].gap >= -rounding;
            if shares[..subset.len()].iter().any(|&s| s < 0.0) || !old.iter().all(holds) {
                return;
            }
            let distance_sq = goal.distance_squared(hip);
            if best
                .as_ref()
                .is_some_and(|(least, _)| distance_sq >= *least)
            {
                return;
            }
            let mut order = [0, 1, 2];
            order[..subset.len()].sort_unstable_by(|&i, &j| shares[j].total_cmp(&shares[i]));
            let mut active = [0; 3];
            for (slot, &i) in active.iter_mut().zip(&order[..subset.len()]) {
                *slot = subset[i];
            }
            let n_active = subset.len();
            best = Some((
                distance_sq,
                Held {
                    goal,
                    active,
                    n_active,
                },
            ));
        };
        offer(&[new]);
        for (i, &a) in old.iter().enumerate() {
            offer(&[new, a]);
            for &b in &old[i + 1..] {
                offer(&[new, a, b]);
            }
        }
        best.map(|(_, held)| held)
    }

    /// `hip` projected onto where the planes of `subset` meet, and the share of each in the way there; `None` where two
    /// are parallel or three have a line in common.
    fn project(&self, subset: &[usize], hip: Vec3) -> Option<(Vec3, [f64; 3])> {
        let plane = |i: usize| &self.all[subset[i]];
        let lack = |i: usize| -(plane(i).normal.dot(hip) + plane(i).gap);
        let shares = match subset.len() {
            1 => [lack(0), 0.0, 0.0],
            2 => {
                let cosine = plane(0).normal.dot(plane(1).normal);
                let det = plane(0).normal.cross(plane(1).normal).length_squared();
                if det < PARALLEL_SINE_SQ {
                    return None;
                }
                let (a, b) = (lack(0), lack(1));
                [(a - cosine * b) / det, (b - cosine * a) / det, 0.0]
            }
            _ => {
                let n = [0, 1, 2].map(|i| plane(i).normal);
                let across = [n[1].cross(n[2]), n[2].cross(n[0]), n[0].cross(n[1])];
                let det = n[0].dot(across[0]);
                if det * det < PARALLEL_SINE_SQ {
                    return None;
                }
                let step = (across[0] * lack(0) + across[1] * lack(1) + across[2] * lack(2)) / det;
                return Some((hip + step, across.map(|a| step.dot(a) / det)));
            }
        };
        let mut goal = hip;
        for (&i, share) in subset.iter().zip(shares) {
            goal += self.all[i].normal * share;
        }
        goal.is_finite().then_some((goal, shares))
    }
}
