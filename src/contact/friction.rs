//! Friction as METHOD reads Ji 2008, 4.2 and 4.6: the cone as a ratio of lengths, and the anchor of a device that
//! reports only its force.

use super::{Friction, TouchScene};
use crate::geom::Vec3;

/// Largest coefficient and looseness, and one over the smallest looseness: beyond, the cone or the stiffness along the skin
/// would overflow.
const MOST: f64 = 1.0e9;

/// The friction cone in lengths: slip starts where |P − A| exceeds `starting` times the depth and goes on at `moving`
/// times the depth. Both zero without friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    pub(super) starting: f64,
    pub(super) moving: f64,
    /// f_adj: normal over tangential stiffness.
    pub(super) looseness: f64,
}

impl Cone {
    pub(super) fn of(friction: Option<&Friction>) -> Self {
        let Some(f) = friction else {
            return Self {
                starting: 0.0,
                moving: 0.0,
                looseness: 1.0,
            };
        };
        let looseness = positive_or(f.skin_looseness, 1.0).clamp(1.0 / MOST, MOST);
        let coefficient = |x: f64| positive_or(x, 0.0).min(MOST);
        let moving = coefficient(f.dynamic_coefficient) * looseness;
        Self {
            starting: (coefficient(f.static_coefficient) * looseness).max(moving),
            moving,
            looseness,
        }
    }

    /// The cone of `scene` for a proxy at `p` on `triangle`. The skin drag of a tick is that where its motion on the surface
    /// begins: a finger that slides feels the drag of where it was a tick before, less than a millimetre behind.
    pub(super) fn at(scene: &TouchScene, triangle: u32, p: Vec3) -> Self {
        let cone = Self::of(scene.friction.as_ref());
        if scene.friction.is_none() || !scene.has_drag() {
            return cone;
        }
        let at = scene.surface.triangle(triangle).closest_point(p);
        let corners = scene.surface.triangles()[triangle as usize];
        let drag = scene.drag_at(corners, at.barycentric);
        Self {
            starting: (cone.starting * drag).min(MOST * MOST),
            moving: (cone.moving * drag).min(MOST * MOST),
            ..cone
        }
    }
}

/// The anchor A, mm, of a device that reports only its proxy `foot_mm` (P), its position `hip_mm` (D) and its force (F).
///
/// The line through D along F meets the plane through P at right angles to `normal` in A′ (Ji 2008, 2.6, as METHOD reads
/// it). There A′ − P is F's tangential part over its normal part, times the depth. Tangential stiffness is F(d)/d over
/// `skin_looseness`, f_adj, so A′ is P + (A − P)/f_adj: A is f_adj times as far from P. This holds for every force
/// model, damped or not, and for a force that was scaled down to what a device can do. Without an f_adj of its own (a
/// device's own friction) it is 1; what is not positive and finite counts as 1.
///
/// Agrees with [`Contact::anchor_mm`](super::Contact::anchor_mm). `None` without contact: no force, a force that does not
/// push outward, or anything not finite.
pub fn anchor_from(
    foot_mm: Vec3,
    hip_mm: Vec3,
    force_n: Vec3,
    normal: Vec3,
    skin_looseness: f64,
) -> Option<Vec3> {
    let outward_n = force_n.dot(normal);
    let depth_mm = (foot_mm - hip_mm).dot(normal);
    if !(outward_n > 0.0 && depth_mm >= 0.0) {
        return None;
    }
    let met = hip_mm + force_n * (depth_mm / outward_n);
    let anchor = foot_mm + (met - foot_mm) * positive_or(skin_looseness, 1.0);
    anchor.is_finite().then_some(anchor)
}

fn positive_or(v: f64, or: f64) -> f64 {
    if v.is_finite() && v > 0.0 { v } else { or }
}

#[cfg(test)]
mod tests {
    use crate::contact::published::{Options, Published};
    use crate::contact::{Choices, Contact, ContactState, Friction, Stiffness, Touch, TouchScene};
    use crate::contact::{Fading, advance};
    use crate::geom::Vec3;
    use crate::partition::bvh::Bvh;
    use crate::surface::primitives::{bench_patch, bench_path};
    use crate::surface::{RawMesh, Surface};
    use std::sync::Arc;

    const SKIN: Friction = Friction {
        static_coefficient: 0.46,
        dynamic_coefficient: 0.44,
        skin_looseness: 1.0,
    };

    fn scene(mesh: RawMesh) -> TouchScene {
        let surface = Arc::new(Surface::new(mesh).expect("sound").0);
        let search = Arc::new(Bvh::new(&surface));
        TouchScene {
            friction: Some(SKIN),
            ..TouchScene::new(surface, search, Stiffness::Uniform(0.8))
        }
    }

    fn plane() -> TouchScene {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        scene(RawMesh {
            positions: vec![
                at(-50.0, -50.0),
                at(50.0, -50.0),
                at(50.0, 50.0),
                at(-50.0, 50.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        })
    }

    fn with_drag(scene: &TouchScene, of: impl Fn(Vec3) -> f64) -> TouchScene {
        TouchScene {
            drag: Some(scene.surface.positions().iter().map(|p| of(*p)).collect()),
            ..scene.clone()
        }
    }

    fn along(scene: &TouchScene, path: &[Vec3]) -> Vec<Contact> {
        let mut state = ContactState {
            proxy_mm: path[0],
            ..ContactState::default()
        };
        path.iter()
            .map(|p| advance(scene, &mut state, *p))
            .collect()
    }

    #[test]
    fn the_same_drag_everywhere_is_another_pair_of_coefficients_in_every_engine() {
        let plain = scene(bench_patch(2000));
        let path: Vec<Vec3> = (0..2000_u32)
            .map(|i| bench_path(f64::from(i) / 1000.0, 6.0 * libm::cos(0.004 * f64::from(i))))
            .collect();
        let published = Published::build(&plain.surface, &Options::default(), &mut |_| true);
        let published = Some(Arc::new(published.expect("sound").expect("built")));
        let pad = Choices {
            finger_radius_mm: 5.0,
            ..Choices::default()
        };
        for plain in [
            plain.clone(),
            TouchScene {
                published,
                ..plain.clone()
            },
            TouchScene {
                choices: pad,
                ..plain.clone()
            },
        ] {
            let other = TouchScene {
                friction: Some(Friction {
                    static_coefficient: 1.5 * SKIN.static_coefficient,
                    dynamic_coefficient: 1.5 * SKIN.dynamic_coefficient,
                    ..SKIN
                }),
                ..plain.clone()
            };
            let (got, expected) = (
                along(&with_drag(&plain, |_| 1.5), &path),
                along(&other, &path),
            );
            assert!(got == expected);
            let slips = expected.iter().filter(|c| c.touch == Touch::Slip);
            assert!(slips.count() > 100);
            assert!(along(&with_drag(&plain, |_| 1.0), &path) == along(&plain, &path));
        }
    }

    #[test]
    fn a_sliding_finger_is_dragged_by_the_drag_where_it_was() {
        let scene = with_drag(&plane(), |p| 1.5 + p.x / 100.0);
        let path: Vec<Vec3> = (0..800)
            .map(|i| {
                Vec3::new(
                    -40.0 + 0.1 * f64::from(i),
                    1.0,
                    (2.0 - f64::from(i)).max(-2.0),
                )
            })
            .collect();
        let felt = along(&scene, &path);
        let mut n_slips = 0;
        for pair in felt
            .windows(2)
            .filter(|w| w.iter().all(|c| c.touch == Touch::Slip))
        {
            let drag = 1.5 + pair[0].anchor_mm.x / 100.0;
            let share = -pair[1].force_n.x / pair[1].force_n.z;
            assert!(
                (share - SKIN.dynamic_coefficient * drag).abs() < 1e-9,
                "{share} {drag}"
            );
            n_slips += 1;
        }
        assert!(n_slips > 700, "{n_slips}");
    }

    #[test]
    fn drag_is_on_its_way_as_stiffness_is_and_what_is_none_counts_as_one() {
        let at = |scene: &TouchScene| scene.drag_at([0, 1, 2], [0.25, 0.25, 0.5]);
        let two = with_drag(&plane(), |_| 2.0);
        assert_eq!(at(&two), 2.0);
        for (share, drag) in [(0.0, 1.0), (0.25, 1.25), (1.0, 2.0)] {
            let fading = Fading {
                from: Stiffness::Uniform(0.8),
                from_drag: None,
                share,
            };
            let scene = TouchScene {
                fading: Some(fading),
                ..two.clone()
            };
            assert_eq!(at(&scene), drag);
        }
        for odd in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(at(&with_drag(&plane(), |_| odd)), 1.0);
        }
        let few = TouchScene {
            drag: Some(Arc::from([2.0])),
            ..plane()
        };
        assert_eq!(at(&few), 1.25);
        assert_eq!(few.bytes(), plane().bytes() + 8);
    }
}
