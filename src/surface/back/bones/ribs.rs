//! The ribs: from the head at the bodies over neck, tubercle and angle to the flank, where the skin of the back ends.

use super::column::Column;
use super::under::{CLEARANCE_MM, Under};
use crate::geom::{Vec3, unit_or};
use crate::surface::RawMesh;
use crate::surface::solids::{Profile, Ring, sweep, through};
use std::f64::consts::FRAC_PI_2;

/// How many pairs there are.
pub const PAIRS: usize = 12;
/// Corners of a cross-section.
const SIDES: u32 = 8;
/// Points of the curve between two stations.
const PER_SPAN: usize = 3;
/// Height of the widest place of the chest, mm: about the middle between back and front.
const CHEST_MIDDLE_Z_MM: f64 = 4.0;
/// A rib ends this far inside the outline of the skin, mm on the map plane.
const INSIDE_MM: f64 = 7.0;
/// And where less than this is left above its middle, mm.
const ROOM_MM: f64 = 3.0;

/// Of each rib, lengths mm. Rounded from anatomy texts and fitted to the built-in back.
struct Shape {
    /// The angle: from the midline, below the skin.
    angle_x: f64,
    angle_depth: f64,
    /// How far the angle lies below the middle of the vertebra's body.
    angle_drop: f64,
    /// How far the widest place lies below the angle.
    side_drop: f64,
    /// Half the width of the chest.
    half_width: f64,
    /// How far round it goes: 1 is to the widest place.
    length: f64,
}

const fn shape(
    angle_x: f64,
    angle_depth: f64,
    angle_drop: f64,
    side_drop: f64,
    half_width: f64,
    length: f64,
) -> Shape {
    Shape {
        angle_x,
        angle_depth,
        angle_drop,
        side_drop,
        half_width,
        length,
    }
}

const SHAPES: [Shape; PAIRS] = [
    shape(38.0, 44.0, 0.0, 12.0, 62.0, 0.95),
    shape(46.0, 37.0, 4.0, 26.0, 86.0, 0.95),
    shape(53.0, 32.0, 6.0, 38.0, 104.0, 0.95),
    shape(59.0, 28.0, 8.0, 46.0, 118.0, 0.95),
    shape(63.0, 26.0, 9.0, 52.0, 128.0, 0.95),
    shape(67.0, 25.0, 10.0, 56.0, 136.0, 0.95),
    shape(71.0, 26.0, 11.0, 60.0, 142.0, 0.95),
    shape(75.0, 22.0, 12.0, 62.0, 145.0, 0.95),
    shape(78.0, 19.0, 13.0, 60.0, 144.0, 0.95),
    shape(78.0, 19.0, 14.0, 56.0, 140.0, 0.95),
    shape(72.0, 21.0, 16.0, 46.0, 132.0, 0.68),
    shape(60.0, 26.0, 16.0, 40.0, 120.0, 0.34),
];

/// Adds the right rib of a pair (1 to 12).
pub fn add(mesh: &mut RawMesh, under: &Under, column: &Column, rib: usize) {
    // C7 is the first level of the column, so that rib n stands at level n.
    let (Some(place), Some(shape)) = (column.places.get(rib), SHAPES.get(rib.wrapping_sub(1)))
    else {
        return;
    };
    let process = place.transverse_mm;
    let tubercle = process + Vec3::new(3.5, 1.5, -8.0);
    // Heads of most ribs lie between two bodies.
    let high = if matches!(rib, 1 | 11 | 12) {
        0.35
    } else {
        0.95
    };
    let head = place.at(
        place.half_width_mm * 0.86,
        place.half_height_mm * high,
        place.half_depth_mm * 0.75,
    );
    let angle_y = place.origin_mm.y - shape.angle_drop;
    let angle = under.at(shape.angle_x, angle_y, shape.angle_depth);
    // Centre; half thickness towards the outside of the chest, half height across.
    let mut stations: Vec<[f64; 5]> = Vec::new();
    let mut station = |p: Vec3, thick: f64, high: f64| stations.push([p.x, p.y, p.z, thick, high]);
    station(head, 4.2, 4.6);
    station(head.lerp(tubercle, 0.5), 2.8, 3.6);
    station(tubercle, 3.4, 4.4);
    let broad = if rib <= 2 { 5.2 } else { 5.6 };
    let reach = shape.half_width - shape.angle_x;
    let depth = (angle.z - CHEST_MIDDLE_Z_MM).max(10.0);
    for step in 0..=8 {
        let turn = shape.length * f64::from(step) / 8.0;
        let (sin, cos) = (libm::sin(FRAC_PI_2 * turn), libm::cos(FRAC_PI_2 * turn));
        let p = Vec3::new(
            shape.angle_x + reach * sin,
            angle_y - shape.side_drop * turn,
            CHEST_MIDDLE_Z_MM + depth * cos,
        );
        let out = unit_or(Vec3::new(sin / reach, 0.0, cos / depth), Vec3::Z);
        let beside = p + Vec3::new(INSIDE_MM + CLEARANCE_MM, 0.0, 0.0) * out.x.max(0.3);
        let low = Vec3::new(beside.x, p.y - INSIDE_MM, p.z);
        let covered = under.is_covered(beside.x, beside.y) && under.is_covered(low.x, low.y);
        if !covered || under.room_mm(p) < ROOM_MM {
            break;
        }
        let tapering = if rib >= 11 { 1.0 - 0.35 * turn } else { 1.0 };
        station(p, 3.1 * tapering, broad * tapering);
    }
    let curve = through(&stations, PER_SPAN);
    let centre = |p: &[f64; 5]| Vec3::new(p[0], p[1], p[2]);
    let rings: Vec<Ring> = (0..curve.len())
        .map(|i| {
            let p = centre(&curve[i]);
            let before = centre(&curve[i.saturating_sub(1)]);
            let after = centre(&curve[(i + 1).min(curve.len() - 1)]);
            let along = unit_or(after - before, Vec3::X);
            // Out of the chest, whose axis runs up through its middle.
            let from_axis = Vec3::new(p.x, 0.0, p.z - CHEST_MIDDLE_Z_MM);
            let out = unit_or(
                from_axis - along * from_axis.dot(along),
                crate::geom::any_tangent(along),
            );
            Ring {
                centre_mm: p,
                u_mm: out * curve[i][3],
                v_mm: along.cross(out) * curve[i][4],
            }
        })
        .collect();
    sweep(mesh, &rings, Profile::round(SIDES, 2.4));
}
