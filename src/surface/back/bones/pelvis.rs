//! What of the pelvis lies under the back: the upper end of the sacrum and the rear of both iliac crests.

use super::super::landmarks::stored;
use super::under::Under;
use crate::geom::{Vec2, Vec3, unit_or};
use crate::surface::RawMesh;
use crate::surface::solids::{Profile, Ring, plate, sweep, through};

/// Right half of the sacrum's outline, mm, upwards from where the skin ends.
const SACRUM: [(f64, f64); 7] = [
    (22.0, 6.5),
    (32.0, 7.5),
    (37.0, 14.0),
    (41.0, 24.0),
    (38.0, 33.0),
    (26.0, 36.0),
    (12.0, 34.0),
];
const MIDDLE: Vec2 = Vec2::new(0.0, 20.0);
/// Depth of its rear face beside the midline, and its thickness there, mm.
const SACRUM_DEPTH_MM: f64 = 15.0;
const SACRUM_THICK_MM: f64 = 22.0;
/// Depths of the posterior superior iliac spine and of the top of the crest, mm: assumed, as in the map of the depth to bone.
const PSIS_DEPTH_MM: f64 = 7.0;
const CREST_DEPTH_MM: f64 = 12.0;

/// Adds the sacrum, cut off where the skin ends.
pub fn add_sacrum(mesh: &mut RawMesh, under: &Under) {
    let right = SACRUM.iter().map(|&(x, y)| Vec2::new(x, y));
    let left = SACRUM.iter().rev().map(|&(x, y)| Vec2::new(-x, y));
    let middle_top = std::iter::once(Vec2::new(0.0, 33.0));
    let middle_foot = std::iter::once(Vec2::new(0.0, 6.5));
    let corners: Vec<Vec2> = right
        .chain(middle_top)
        .chain(left)
        .chain(middle_foot)
        .collect();
    let outline = closed(&corners, 3);
    plate(mesh, &outline, MIDDLE, 5, |p, share| {
        let edge = (1.0 - share * share).max(0.0).sqrt();
        let rear = under.skin_mm(p.x, p.y) - SACRUM_DEPTH_MM;
        let half = 0.5 * SACRUM_THICK_MM * (0.25 + 0.75 * edge) * edge.min(0.5) / 0.5;
        let middle = rear - 0.5 * SACRUM_THICK_MM;
        [middle + half, middle - half]
    });
    // The median crest.
    let rings = [(33.0, 2.6), (24.0, 2.2), (15.0, 2.6), (7.5, 2.0)].map(|(y, half)| Ring {
        centre_mm: under.at(0.0, y, 13.0),
        u_mm: Vec3::X * half,
        v_mm: Vec3::Z * 4.5,
    });
    sweep(mesh, &rings, Profile::round(10, 1.0));
}

/// A smooth closed curve through corners.
fn closed(corners: &[Vec2], per_span: usize) -> Vec<Vec2> {
    let n = corners.len();
    let around: Vec<[f64; 2]> = (0..n + 4)
        .map(|i| corners[(i + n - 2) % n].to_array())
        .collect();
    let curve = through(&around, per_span);
    let once = &curve[2 * per_span..(n + 2) * per_span];
    once.iter().map(|&p| Vec2::from_array(p)).collect()
}

/// Adds the right iliac crest: from the posterior superior iliac spine over its top to the flank.
pub fn add_crest(mesh: &mut RawMesh, under: &Under) {
    let place = |wanted: &str, otherwise: (f64, f64)| {
        stored()
            .find(|(name, ..)| *name == wanted)
            .map_or(otherwise, |(_, x, y)| (x, y))
    };
    let (psis, top) = (
        place("PSIS", (38.0, 10.0)),
        place("iliac crest", (60.0, 71.9)),
    );
    // x, y, depth, half width on the map plane, half thickness in depth.
    let stations = [
        [psis.0, psis.1, PSIS_DEPTH_MM + 6.0, 5.6, 6.0],
        [psis.0 + 6.0, psis.1 + 24.0, 17.0, 5.0, 7.0],
        [psis.0 + 13.0, psis.1 + 45.0, 18.0, 4.4, 6.0],
        [top.0, top.1 - 4.4, CREST_DEPTH_MM + 4.5, 4.4, 4.5],
        [top.0 + 18.0, top.1 - 3.0, 18.0, 4.2, 5.0],
        [top.0 + 36.0, top.1 - 10.0, 19.0, 4.6, 5.0],
        [top.0 + 50.0, top.1 - 20.0, 19.0, 5.0, 5.0],
    ];
    let curve = through(&stations, 4);
    let centre = |i: usize| {
        let [x, y, depth, ..] = curve[i.min(curve.len() - 1)];
        under.at(x, y, depth)
    };
    let rings: Vec<Ring> = (0..curve.len())
        .map(|i| {
            let along = unit_or(centre(i + 1) - centre(i.saturating_sub(1)), Vec3::Y);
            let across = unit_or(Vec3::Z.cross(along), Vec3::X);
            Ring {
                centre_mm: centre(i),
                u_mm: across * curve[i][3],
                v_mm: along.cross(across) * curve[i][4],
            }
        })
        .collect();
    sweep(mesh, &rings, Profile::round(12, 3.0));
    wing(mesh, under, &rings);
}

/// The rear of the wing below the crest (*ala ossis ilii*), cut off where the skin ends.
fn wing(mesh: &mut RawMesh, under: &Under, crest: &[Ring]) {
    let along: Vec<Vec2> = crest.iter().map(|r| r.centre_mm.truncate()).collect();
    let below = [(108.0, 30.0), (102.0, 12.0), (84.0, 7.5), (62.0, 7.5)];
    let below = below.map(|(x, y)| Vec2::new(x, y));
    // Counter-clockwise: back along the crest from the flank to the spine, then below.
    let outline: Vec<Vec2> = along
        .iter()
        .rev()
        .copied()
        .chain(below.into_iter().rev())
        .collect();
    // Depth of the crest beside a place: the nearer a point of it, the more it counts.
    let beside = |p: Vec2| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for ring in crest {
            let c = ring.centre_mm;
            let weight = libm::exp(-c.truncate().distance_squared(p) / (2.0 * 14.0 * 14.0));
            sum += weight * (under.skin_mm(c.x, c.y) - c.z);
            weights += weight;
        }
        sum / weights
    };
    plate(mesh, &outline, Vec2::new(78.0, 40.0), 7, |p, share| {
        // A hollow: the muscles of the seat fill it.
        let hollow = 20.0 * (1.0 - share * share);
        let z = under.skin_mm(p.x, p.y) - beside(p) - 2.0 - hollow;
        let half = 2.2 * (1.0 - share * share).max(0.0).sqrt().min(0.35) / 0.35;
        [z + half, z - half]
    });
}
