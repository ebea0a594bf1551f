//! One engine on one awkward surface: its path followed tick by tick and held against the truth.

use crate::contact::{
    Contact, ContactState, Friction, Stiffness, Touch, TouchScene, advance, published,
};
use crate::geom::{Vec3, unit_or};
use crate::partition::{Sides, bvh::Bvh};
use crate::surface::torture::{Case, Truth, closest_in};
use crate::surface::{RawMesh, Surface};
use std::sync::Arc;

/// A contact engine: the choices of a scene that make it.
#[derive(Clone, Copy, Debug)]
pub struct Engine {
    /// Name in tables.
    pub name: &'static str,
    /// Sets the choices.
    pub choose: fn(&mut TouchScene),
    /// Whether it must pass: of the published one it is only told where it fails.
    pub must_pass: bool,
}

/// Every engine.
pub const ENGINES: &[Engine] = &[
    Engine {
        name: "point",
        choose: |_| {},
        must_pass: true,
    },
    Engine {
        name: "point, both sides",
        choose: |scene| scene.choices.sides = Sides::Both,
        must_pass: true,
    },
    Engine {
        name: "published, all triangles",
        choose: |scene| {
            let options = published::Options {
                partition: "brute",
                ..published::Options::default()
            };
            let built = published::Published::build(&scene.surface, &options, &mut |_| true);
            scene.published = built.ok().flatten().map(Arc::new);
        },
        must_pass: false,
    },
];

/// Where and how large the surface is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Name in tables.
    pub name: &'static str,
    /// Size over that of the case.
    pub scale: f64,
    /// Way from the origin, mm.
    pub by_mm: Vec3,
}

/// As given, in other units, 1 km away.
pub const PLACES: &[Place] = &[
    Place {
        name: "mm",
        scale: 1.0,
        by_mm: Vec3::ZERO,
    },
    Place {
        name: "× 1/1000",
        scale: 1e-3,
        by_mm: Vec3::ZERO,
    },
    Place {
        name: "× 1000",
        scale: 1e3,
        by_mm: Vec3::ZERO,
    },
    Place {
        name: "1 km away",
        scale: 1.0,
        by_mm: Vec3::new(6.0e5, -8.0e5, 3.0e5),
    },
];

/// Speeds of the finger; a tick is 1 ms.
pub const SPEEDS_M_PER_S: [f64; 4] = [0.01, 0.1, 1.0, 10.0];

/// Skin on finger (Zhang & Mak 1999; Ji 2008, 2.4).
const SKIN: Friction = Friction {
    static_coefficient: 0.46,
    dynamic_coefficient: 0.44,
    skin_looseness: 1.0,
};

/// What a trial found; lengths and energies as if the surface were in its original size, stiffness 1 N/mm.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Ticks run.
    pub ticks: usize,
    /// Of these with contact.
    pub touched: usize,
    /// With the proxy where nothing may be that came from outside.
    pub through: usize,
    /// With a figure that is no number.
    pub not_finite: usize,
    /// Without friction: with the proxy elsewhere than where it must be, as far as the truth tells.
    pub misplaced: usize,
    /// Without friction: with a closer place on a triangle that the proxy is on, or farther behind than geometry explains.
    pub stuck: usize,
    /// With friction: with a pull beyond the cone.
    pub beyond_cone: usize,
    /// Largest excess of the lag over what geometry explains, mm.
    pub lag_over_mm: f64,
    /// Energy that came from nothing, N·mm: whenever the proxy went away from the finger.
    pub created_n_mm: f64,
    /// Work done on the spring between finger and proxy, N·mm.
    pub work_n_mm: f64,
    /// The first fault, in words.
    pub first_fault: Option<String>,
}

impl Findings {
    /// Number of faults, energy from nothing (more than 10⁻⁹ of the work) counting as one.
    pub fn faults(&self) -> usize {
        let created = self.created_n_mm > 1e-9 * self.work_n_mm;
        [
            self.through,
            self.not_finite,
            self.misplaced,
            self.stuck,
            self.beyond_cone,
        ]
        .iter()
        .sum::<usize>()
            + usize::from(created)
    }

    fn fault(&mut self, which: fn(&mut Self) -> &mut usize, words: impl FnOnce() -> String) {
        *which(self) += 1;
        if self.first_fault.is_none() {
            self.first_fault = Some(format!("tick {}: {}", self.ticks, words()));
        }
    }
}

/// A case brought to a place, with one engine.
pub struct Trial<'a> {
    case: &'a Case,
    place: Place,
    scene: TouchScene,
    /// Rounding of places and distances in the size of the case, mm.
    tolerance_mm: f64,
}

impl<'a> Trial<'a> {
    /// Builds the scene, 1 N/mm.
    ///
    /// # Errors
    /// Why the surface was refused, with the name of the case.
    pub fn new(
        case: &'a Case,
        engine: &Engine,
        place: Place,
        friction: bool,
    ) -> Result<Self, String> {
        let put = |p: &Vec3| *p * place.scale + place.by_mm;
        let mesh = RawMesh {
            positions: case.mesh.positions.iter().map(put).collect(),
            triangles: case.mesh.triangles.clone(),
        };
        let (surface, _) = Surface::new(mesh).map_err(|e| format!("{}: {e}", case.name))?;
        let search = Arc::new(Bvh::new(&surface));
        let mut scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
        scene.friction = friction.then_some(SKIN);
        (engine.choose)(&mut scene);
        let reach = place.by_mm.length() / place.scale + 100.0;
        Ok(Self {
            case,
            place,
            scene,
            tolerance_mm: 1e-9 + 4096.0 * f64::EPSILON * reach,
        })
    }

    /// The positions of the finger, in the size of the case, after each of at most `most` ticks of `step_mm`.
    pub fn path(&self, step_mm: f64, most: usize) -> Vec<Vec3> {
        let corners = &self.case.path;
        let mut at = corners[0];
        let mut path = Vec::new();
        for next in corners[1..].iter().chain(&corners[..1]) {
            while path.len() < most {
                let to = *next - at;
                let arrives = to.length() <= step_mm;
                at = if arrives {
                    *next
                } else {
                    at + unit_or(to, Vec3::ZERO) * step_mm
                };
                path.push(at);
                if arrives {
                    break;
                }
            }
        }
        path
    }

    fn start(&self) -> ContactState {
        ContactState {
            proxy_mm: self.put(self.case.path[0]),
            ..ContactState::default()
        }
    }

    fn put(&self, p: Vec3) -> Vec3 {
        p * self.place.scale + self.place.by_mm
    }

    fn back(&self, p: Vec3) -> Vec3 {
        (p - self.place.by_mm) / self.place.scale
    }

    /// Follows the path and does nothing else: for timing. Returns the last force, N.
    pub fn run_blind(&self, path: &[Vec3]) -> Vec3 {
        let mut state = self.start();
        (path.iter()).fold(Vec3::ZERO, |_, &p| {
            advance(&self.scene, &mut state, self.put(p)).force_n
        })
    }

    /// Follows the path and checks every tick.
    pub fn run(&self, path: &[Vec3]) -> Findings {
        let mut found = Findings::default();
        let mut state = self.start();
        let mut last = self.case.path[0];
        let mut held = 0.0;
        let scale_sq = self.place.scale * self.place.scale;
        for &at in path {
            let (hip, before) = (self.put(at), state);
            let c = advance(&self.scene, &mut state, hip);
            found.ticks += 1;
            found.touched += usize::from(c.touch != Touch::Free);
            let sane = [c.force_n, c.anchor_mm, c.foot_mm, c.normal];
            if !sane.iter().all(|v| v.is_finite()) {
                found.fault(|f| &mut f.not_finite, || format!("{c:?}"));
                continue;
            }
            let seen = Seen {
                from: last,
                at: self.back(hip),
                proxy: self.back(c.anchor_mm),
                contact: c,
                hip,
            };
            self.check_side(&seen, &mut found);
            if self.scene.friction.is_none() {
                self.check_place(&seen, &mut held, &mut found);
                self.check_rest(&seen, &mut found);
            } else {
                self.check_cone(&seen, &mut found);
            }
            let apart = |p: Vec3, q: Vec3| p.distance_squared(q) / 2.0 / scale_sq;
            let pulled = apart(hip, before.proxy_mm);
            found.created_n_mm += (apart(hip, c.anchor_mm) - pulled).max(0.0);
            found.work_n_mm += (pulled - apart(self.put(last), before.proxy_mm)).abs();
            last = at;
        }
        found
    }

    /// How much rounding may make of a depth, mm.
    fn slack_mm(&self) -> f64 {
        self.tolerance_mm * self.case.truth.steepness()
    }

    fn check_side(&self, seen: &Seen, found: &mut Findings) {
        let depth = self.case.truth.depth_mm(seen.proxy);
        let turned = seen.contact.behind && !matches!(self.case.truth, Truth::Plate { .. });
        if turned || depth > self.slack_mm() {
            found.fault(|f| &mut f.through, || format!("{depth} mm through, {seen}"));
        }
    }

    fn check_place(&self, seen: &Seen, held: &mut f64, found: &mut Findings) {
        let free = seen.contact.touch == Touch::Free;
        let expected = match &self.case.truth {
            Truth::Cell(cell) => closest_in(cell, seen.at),
            Truth::Plate { half_mm } => {
                let over = |p: Vec3| p.x.abs().max(p.y.abs()) <= *half_mm;
                let (from, at) = (seen.from, seen.at);
                let crosses =
                    from.z * at.z < 0.0 && over(from + (at - from) * (from.z / (from.z - at.z)));
                let felt = from.z > 0.0 || self.scene.choices.sides == Sides::Both;
                if *held == 0.0 && crosses && felt {
                    *held = from.z.signum();
                }
                if at.z * *held >= 0.0 || !over(at) {
                    *held = 0.0;
                }
                let behind = *held < 0.0;
                if (*held == 0.0) != free || seen.contact.behind != behind {
                    found.fault(
                        |f| &mut f.misplaced,
                        || format!("held should be {held}, {seen}"),
                    );
                }
                if free { at } else { Vec3::new(at.x, at.y, 0.0) }
            }
            Truth::Height { .. } | Truth::Bodies { .. } => return,
        };
        if expected.distance(seen.proxy) > self.tolerance_mm {
            found.fault(
                |f| &mut f.misplaced,
                || format!("should be at {expected}, {seen}"),
            );
        }
    }

    /// The proxy is in a local minimum of the distance: no triangle that it touches has a closer point. And it does not lag
    /// behind for other than geometric reasons.
    fn check_rest(&self, seen: &Seen, found: &mut Findings) {
        let over = seen.proxy.distance(seen.at) - self.case.truth.lag_bound_mm(seen.at);
        found.lag_over_mm = found.lag_over_mm.max(over);
        if over > self.slack_mm() {
            found.fault(
                |f| &mut f.stuck,
                || format!("{over} mm too far behind, {seen}"),
            );
        }
        if seen.contact.touch == Touch::Free || self.case.crossed {
            return;
        }
        let (surface, anchor) = (&self.scene.surface, seen.contact.anchor_mm);
        let (touch, reach) = (
            1e-3 * self.tolerance_mm * self.place.scale,
            anchor.distance(seen.hip),
        );
        let mut closer = 0.0_f64;
        self.scene.search.around(anchor, touch, |t| {
            let triangle = surface.triangle(t);
            if triangle.closest_point(anchor).point.distance(anchor) <= touch {
                let least = triangle.closest_point(seen.hip).point.distance(seen.hip);
                closer = closer.max(reach - least);
            }
        });
        if closer > self.tolerance_mm * self.place.scale {
            found.fault(
                |f| &mut f.stuck,
                || format!("could be {closer} mm closer, {seen}"),
            );
        }
    }

    fn check_cone(&self, seen: &Seen, found: &mut Findings) {
        let c = &seen.contact;
        let coefficient = match c.touch {
            Touch::Free => return,
            Touch::Slip => SKIN.dynamic_coefficient,
            Touch::Stick | Touch::Frictionless => SKIN.static_coefficient,
        };
        let most = coefficient * c.depth_mm * (1.0 + 1e-12);
        let pull = c.foot_mm.distance(c.anchor_mm);
        if pull > most + 1e-3 * self.tolerance_mm * self.place.scale {
            found.fault(
                |f| &mut f.beyond_cone,
                || format!("pull of {pull} for {most}, {seen}"),
            );
        }
    }
}

/// One tick, as the checks see it: in the size of the case, but for the contact and the HIP as the engine knows it.
struct Seen {
    from: Vec3,
    at: Vec3,
    proxy: Vec3,
    contact: Contact,
    hip: Vec3,
}

impl std::fmt::Display for Seen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "finger from {} to {}: proxy at {}, {:?} on {}",
            self.from, self.at, self.proxy, self.contact.touch, self.contact.triangle
        )
    }
}

/// Energy over a closed path, N·mm at 1 N/mm.
#[derive(Clone, Copy, Debug, Default)]
pub struct Energy {
    /// Came from nothing.
    pub created: f64,
    /// Went where the proxy jumped down, as over a convex edge.
    pub lost: f64,
    /// Put in by the finger and taken out of it.
    pub work: f64,
}

/// Halvings of a step in search of the place where the proxy passes from one plane to another.
const HALVINGS: u32 = 40;

/// Energy over the frictionless path of a case, exactly: a step is halved until the force is linear over it, so that work is
/// known without error, or the step is a jump.
///
/// # Errors
/// Why the surface was refused.
pub fn closed_path_energy(
    case: &Case,
    engine: &Engine,
    step_mm: f64,
    most: usize,
) -> Result<Energy, String> {
    let trial = Trial::new(case, engine, PLACES[0], false)?;
    let mut energy = Energy::default();
    let mut state = trial.start();
    let mut from = trial.case.path[0];
    for to in trial.path(step_mm, most) {
        state = halve(&trial.scene, state, from, to, HALVINGS, &mut energy);
        from = to;
    }
    Ok(energy)
}

fn halve(
    scene: &TouchScene,
    state: ContactState,
    from: Vec3,
    to: Vec3,
    left: u32,
    energy: &mut Energy,
) -> ContactState {
    let mut after = state;
    advance(scene, &mut after, to);
    let (pull, pull_after) = (from - state.proxy_mm, to - after.proxy_mm);
    let stored = (pull_after.length_squared() - pull.length_squared()) / 2.0;
    let work = (pull + pull_after).dot(to - from) / 2.0;
    let rounding = 1e-14 * (1.0 + from.length_squared());
    if (stored - work).abs() > rounding && left > 0 {
        let middle = (from + to) / 2.0;
        let half = halve(scene, state, from, middle, left - 1, energy);
        return halve(scene, half, middle, to, left - 1, energy);
    }
    energy.created += (stored - work).max(0.0);
    energy.lost += (work - stored).max(0.0);
    energy.work += work.abs();
    after
}
