//! A hand that palpates, in the place of a finger's sphere: an index finger with its nail, and as much of the hand behind it as
//! tells which way it comes from. Schematic, made here, in the finger's colour.
//!
//! ```text
//!                 z: out of the skin        knuckles ___
//!                 |                      ___------   hand
//!                 |     index  ___------
//!                 |   __------
//!   skin  ________o--_______________________  −y
//! ```

use super::model::{Model, Placed};
use crate::geom::{Vec3, any_tangent, unit_or};
use crate::surface::solids::{Profile, Ring, mirror, sweep, through};
use crate::surface::{RawMesh, vertex_normals};
use glam::DMat4;
use std::sync::Arc;

/// Radius of a sphere that the hand's own fingertip stands for, mm.
const RADIUS_MM: f64 = 7.5;
/// What of the colour is the finger's own; the rest is that of skin.
const OWN: f64 = 0.66;
/// Skin and nail, sRGB, before they are tinted.
const SKIN: [u8; 3] = [236, 206, 190];
const NAIL: [u8; 3] = [255, 244, 240];

/// Right and left hand, each made when first drawn.
#[derive(Debug, Default)]
pub struct Hands {
    right: Option<Arc<Model>>,
    left: Option<Arc<Model>>,
}

/// One finger that a hand stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Whether it belongs to a right hand.
    pub is_right: bool,
    /// Where the middle of its sphere would be, mm.
    pub centre_mm: Vec3,
    /// The sphere's radius, mm: the hand is as large as that asks for.
    pub radius_mm: f64,
    /// Out of the skin.
    pub normal: Vec3,
    /// sRGB.
    pub color: [u8; 3],
}

impl Hands {
    /// The hand of a finger, in its place.
    pub fn placed(&mut self, finger: &Finger) -> Placed {
        let side = if finger.is_right {
            &mut self.right
        } else {
            &mut self.left
        };
        let model = side.get_or_insert_with(|| Arc::new(make(finger.is_right)));
        let mix = |other: [u8; 3], own: f64| {
            std::array::from_fn(|k| {
                let (a, b) = (f64::from(finger.color[k]), f64::from(other[k]));
                (a * own + b * (1.0 - own)).round() as u8
            })
        };
        Placed {
            model: model.clone(),
            subject_from_model: pose(finger),
            colors: [mix(SKIN, OWN), mix(NAIL, 0.35)],
            gloss: 0.10,
            is_finger: true,
        }
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let hands = self.right.iter().chain(&self.left);
        hands.map(|m| m.bytes()).sum()
    }
}

/// Puts the pad of the fingertip where the sphere would touch, the finger towards the head and the spine, its back outward.
fn pose(finger: &Finger) -> DMat4 {
    let z = unit_or(finger.normal, Vec3::Z);
    let wanted = Vec3::new(if finger.is_right { -0.45 } else { 0.45 }, 1.0, 0.0);
    let y = unit_or(wanted - z * wanted.dot(z), any_tangent(z));
    let x = y.cross(z);
    let scale = finger.radius_mm / RADIUS_MM;
    let touches = finger.centre_mm - z * finger.radius_mm;
    DMat4::from_cols(
        (x * scale).extend(0.0),
        (y * scale).extend(0.0),
        (z * scale).extend(0.0),
        touches.extend(1.0),
    )
}

/// Stations of the index finger from the tip: y, z, half width, half thickness, mm.
const INDEX: [[f64; 4]; 9] = [
    [1.5, 7.2, 5.6, 5.0],
    [-4.0, 9.8, 7.2, 6.3],
    [-12.0, 14.4, 7.7, 7.0],
    [-21.0, 20.4, 7.4, 7.0],
    [-33.0, 29.4, 7.8, 7.4],
    [-46.0, 38.2, 8.8, 8.6],
    [-60.0, 43.4, 8.6, 8.6],
    [-76.0, 47.6, 9.6, 10.0],
    [-92.0, 50.0, 11.0, 12.0],
];
/// The three other fingers, curled: x of their knuckles, mm, and their size against the index.
const CURLED: [(f64, f64); 3] = [(20.0, 1.05), (38.5, 0.98), (54.0, 0.84)];

fn make(is_right: bool) -> Model {
    let mut mesh = RawMesh::default();
    finger(&mut mesh, &INDEX.map(|[y, z, a, b]| [0.0, y, z, a, b]), 4.2);
    let nail = mesh.positions.len();
    add_nail(&mut mesh);
    let after_nail = mesh.positions.len();
    for (x, size) in CURLED {
        let stations = [
            [x * 0.96, -104.0, 50.0, 10.0, 11.0],
            [x * 0.98, -88.0, 46.0, 9.2, 9.6],
            [x, -76.0, 37.0, 8.8, 9.0],
            [x, -76.0, 25.0, 8.2, 8.4],
            [x, -86.0, 19.0, 7.6, 7.6],
            [x, -97.0, 21.0, 7.0, 6.8],
        ];
        let about_knuckle = |[px, y, z, a, b]: [f64; 5]| {
            [
                px,
                -104.0 + (y + 104.0) * size,
                50.0 + (z - 50.0) * size,
                a * size,
                b * size,
            ]
        };
        finger(&mut mesh, &stations.map(about_knuckle), 5.0);
    }
    // Back of the hand and thumb.
    finger(
        &mut mesh,
        &[
            [24.0, -97.0, 49.0, 36.0, 11.0],
            [25.0, -112.0, 51.0, 37.0, 13.5],
            [25.0, -130.0, 52.0, 35.5, 14.5],
            [25.0, -146.0, 52.5, 32.0, 14.5],
        ],
        9.0,
    );
    finger(
        &mut mesh,
        &[
            [2.0, -138.0, 44.0, 14.0, 12.0],
            [-12.0, -120.0, 38.0, 11.0, 10.0],
            [-20.0, -102.0, 34.0, 9.6, 9.0],
            [-22.0, -86.0, 32.0, 9.4, 8.2],
            [-19.0, -72.0, 31.0, 7.6, 6.6],
        ],
        5.0,
    );
    // The pad touches the skin where the model has its origin.
    let lowest = mesh.positions[..nail]
        .iter()
        .fold(Vec3::splat(f64::INFINITY), |low, &p| {
            if p.z < low.z { p } else { low }
        });
    for p in &mut mesh.positions {
        *p -= Vec3::new(0.0, lowest.y, lowest.z);
    }
    if !is_right {
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        mirror(&mut mesh, 0, 0);
        mesh.positions.drain(..vertices);
        mesh.triangles.drain(..triangles);
        for t in &mut mesh.triangles {
            *t = t.map(|v| v - vertices as u32);
        }
    }
    let normals = vertex_normals(&mesh.positions, &mesh.triangles);
    Model::new(&mesh.positions, &normals, &mesh.triangles, |v| {
        f64::from(u8::from((nail..after_nail).contains(&v)))
    })
}

/// A tube through stations (x, y, z, half width, half thickness, mm), wide across x.
fn finger(mesh: &mut RawMesh, stations: &[[f64; 5]], cap_mm: f64) {
    let curve = through(stations, 4);
    sweep(mesh, &rings(&curve), Profile::round(18, cap_mm));
}

fn rings(curve: &[[f64; 5]]) -> Vec<Ring> {
    let centre = |p: &[f64; 5]| Vec3::new(p[0], p[1], p[2]);
    (0..curve.len())
        .map(|i| {
            let before = centre(&curve[i.saturating_sub(1)]);
            let after = centre(&curve[(i + 1).min(curve.len() - 1)]);
            let along = unit_or(after - before, Vec3::NEG_Y);
            let across = unit_or(Vec3::X - along * along.x, any_tangent(along));
            Ring {
                centre_mm: centre(&curve[i]),
                u_mm: across * curve[i][3],
                v_mm: along.cross(across) * curve[i][4],
            }
        })
        .collect()
}

/// Over the back of the last phalanx.
fn add_nail(mesh: &mut RawMesh) {
    let stations = INDEX[..3].iter().map(|&[y, z, a, b]| [0.0, y, z, a, b]);
    let curve = through(&stations.collect::<Vec<_>>(), 4);
    let bed: Vec<Ring> = rings(&curve)
        .into_iter()
        .skip(1)
        .map(|ring| {
            let up = if ring.v_mm.z > 0.0 {
                ring.v_mm
            } else {
                -ring.v_mm
            };
            Ring {
                centre_mm: ring.centre_mm + up * 0.80,
                u_mm: ring.u_mm * 0.70,
                v_mm: up * 0.27,
            }
        })
        .collect();
    sweep(mesh, &bed, Profile::round(14, 1.6));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finger_at(is_right: bool, normal: Vec3) -> Finger {
        Finger {
            is_right,
            centre_mm: Vec3::new(10.0, 200.0, 90.0),
            radius_mm: 9.0,
            normal,
            color: [88, 158, 255],
        }
    }

    #[test]
    fn the_pad_touches_where_the_sphere_would_and_nothing_is_below_it() {
        for is_right in [true, false] {
            let hand = make(is_right);
            let b = hand.bounds();
            assert!(b.min.z.abs() < 1e-5, "{}", b.min.z);
            assert!(
                b.max.z < 80.0 && b.min.y > -170.0 && b.max.y < 12.0,
                "{b:?}"
            );
            for normal in [
                Vec3::Z,
                Vec3::X,
                Vec3::new(0.4, 0.3, 0.8),
                Vec3::Y,
                Vec3::NEG_Y,
            ] {
                let f = finger_at(is_right, normal);
                let n = unit_or(normal, Vec3::Z);
                let origin = pose(&f).transform_point3(Vec3::ZERO);
                assert!(origin.distance(f.centre_mm - n * 9.0) < 1e-9);
                // Turned and scaled evenly, and no mirror image.
                let m = glam::DMat3::from_mat4(pose(&f));
                assert!((m.determinant() - 1.2_f64.powi(3)).abs() < 1e-9);
                assert!((m * Vec3::Z).distance(n * 1.2) < 1e-9);
                assert!(m.is_finite());
            }
        }
    }

    #[test]
    fn a_left_hand_is_the_mirror_image_of_a_right_one() {
        let [right, left] = [make(true), make(false)].map(|m| m.bounds());
        assert!((right.max.x + left.min.x).abs() < 1e-6);
        // The thumb of a right hand that points away, palm down, is on the left.
        assert!(right.min.x < -20.0 && right.max.x > 50.0, "{right:?}");
    }

    #[test]
    fn a_hand_is_made_when_it_is_drawn_and_wears_its_fingers_colour() {
        let mut hands = Hands::default();
        assert_eq!(hands.bytes(), 0);
        let placed = hands.placed(&finger_at(true, Vec3::Z));
        assert!(hands.left.is_none() && hands.bytes() > 10_000);
        let [r, _, b] = placed.colors[0];
        assert!(b > r.saturating_add(80));
        assert_eq!(placed, hands.placed(&finger_at(true, Vec3::Z)));
    }
}
