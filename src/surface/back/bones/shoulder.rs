//! The shoulder blades: blade, spine with acromion, socket; the medial and lateral borders are the edges of the blade.

use super::super::landmarks::stored;
use super::under::Under;
use crate::geom::{Vec2, Vec3};
use crate::surface::RawMesh;
use crate::surface::solids::{Profile, Ring, plate, sweep, through};

/// Outline of the right blade on the map plane, mm, counter-clockwise from the inferior angle: lateral border, neck below the
/// socket, superior border, superior angle, medial border. The inferior angle and the end of the spine are landmarks.
const OUTLINE: [(f64, f64); 14] = [
    (75.0, 281.4),
    (86.0, 288.0),
    (100.0, 311.0),
    (115.0, 338.0),
    (130.0, 366.0),
    (142.0, 384.0),
    (145.0, 400.0),
    (134.0, 409.0),
    (116.0, 411.0),
    (96.0, 417.0),
    (77.0, 420.0),
    (68.0, 403.0),
    (65.0, 370.0),
    (67.0, 322.0),
];
/// From here the whole outline is seen, mm.
const MIDDLE: Vec2 = Vec2::new(98.0, 362.0);
/// Points of the outline between two that are given.
const PER_SPAN: usize = 4;
/// Depths of inferior angle and end of the spine below the skin, mm: assumed, as in the map of the depth to bone.
const ANGLE_DEPTH_MM: f64 = 10.0;
const SPINE_DEPTH_MM: f64 = 8.0;
/// The crest of the spine: x, y, depth below the skin, half width across it, half thickness, mm. It flattens to the acromion.
const CREST: [[f64; 5]; 6] = [
    [70.0, 382.5, SPINE_DEPTH_MM + 2.4, 3.6, 2.4],
    [86.0, 389.0, 9.5, 3.2, 2.4],
    [108.0, 398.0, 9.5, 3.2, 2.6],
    [130.0, 408.0, 9.0, 4.0, 2.8],
    [146.0, 415.0, 9.0, 7.0, 3.0],
    [159.0, 413.0, 9.5, 8.0, 2.6],
];
/// How far along the spine the wall below the crest goes: the acromion stands free.
const WALL_STATIONS: usize = 12;

/// Depth of the blade's middle sheet, mm.
fn blade_depth_mm(p: Vec2) -> f64 {
    let smooth = |t: f64| {
        let t = t.clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let angle_y = OUTLINE[0].1;
    ANGLE_DEPTH_MM
        + 2.0
        + 6.0 * smooth((p.y - angle_y) / 70.0)
        + 6.0 * smooth((p.x - 85.0) / 50.0)
        + 7.0 * smooth((p.y - 380.0) / 30.0)
}

/// Adds the right one.
pub fn add(mesh: &mut RawMesh, under: &Under) {
    let angle = stored()
        .find(|(name, ..)| *name == "scapula inferior angle")
        .map_or(Vec2::new(OUTLINE[0].0, OUTLINE[0].1), |(_, x, y)| {
            Vec2::new(x, y)
        });
    let mut corners: Vec<[f64; 2]> = OUTLINE.iter().map(|&(x, y)| [x, y]).collect();
    corners[0] = angle.to_array();
    // Closed: once round and cut where it would begin again.
    let n = corners.len();
    let around: Vec<[f64; 2]> = (0..n + 4).map(|i| corners[(i + n - 2) % n]).collect();
    let smooth = through(&around, PER_SPAN);
    let outline: Vec<Vec2> = smooth[2 * PER_SPAN..(n + 2) * PER_SPAN]
        .iter()
        .map(|&p| Vec2::from_array(p))
        .collect();
    plate(mesh, &outline, MIDDLE, 6, |p, share| {
        let z = under.skin_mm(p.x, p.y) - blade_depth_mm(p);
        // Thin in the middle, thick along the borders, round at the edge.
        let edge = (1.0 - share * share).max(0.0).sqrt();
        let border = share * share * share;
        let half = (1.4 + 3.4 * border * edge.min(0.6)) * edge.min(0.35) / 0.35;
        [z + half, z - half]
    });
    spine(mesh, under);
    socket(mesh, under);
}

fn spine(mesh: &mut RawMesh, under: &Under) {
    let curve = through(&CREST, 3);
    let station = |i: usize| {
        let [x, y, depth, ..] = curve[i.min(curve.len() - 1)];
        under.at(x, y, depth)
    };
    let along = |i: usize| {
        let way = station(i + 1) - station(i.saturating_sub(1));
        crate::geom::unit_or(way, Vec3::X)
    };
    let crest: Vec<Ring> = (0..curve.len())
        .map(|i| {
            let across = crate::geom::unit_or(Vec3::Z.cross(along(i)), Vec3::Y);
            Ring {
                centre_mm: station(i),
                u_mm: across * curve[i][3],
                v_mm: along(i).cross(across) * curve[i][4],
            }
        })
        .collect();
    sweep(mesh, &crest, Profile::round(12, 2.4));
    let wall: Vec<Ring> = (0..WALL_STATIONS.min(curve.len()))
        .map(|i| {
            let top = station(i);
            let foot = under.skin_mm(top.x, top.y) - blade_depth_mm(top.truncate());
            let across = crate::geom::unit_or(Vec3::Z.cross(along(i)), Vec3::Y);
            Ring {
                centre_mm: Vec3::new(top.x, top.y, (top.z + foot) / 2.0),
                u_mm: across * 1.9,
                v_mm: along(i).cross(across) * (0.5 * (top.z - foot).abs() + 0.8),
            }
        })
        .collect();
    sweep(mesh, &wall, Profile::round(10, 1.0));
}

/// Neck and socket (*cavitas glenoidalis*).
fn socket(mesh: &mut RawMesh, under: &Under) {
    let neck = [
        (134.0, 391.0, 2.6, 8.0),
        (144.0, 392.5, 5.4, 12.5),
        (148.5, 393.0, 6.4, 14.5),
    ];
    let rings = neck.map(|(x, y, thick, high)| Ring {
        centre_mm: under.at(x, y, blade_depth_mm(Vec2::new(x, y)) + 1.0),
        u_mm: Vec3::Y * high,
        v_mm: Vec3::Z * thick,
    });
    sweep(mesh, &rings, Profile::round(14, 1.8));
}
