//! One vertebra and the disc below it, in solids.

use super::column::{Column, Place};
use crate::geom::{Vec3, unit_or};
use crate::surface::RawMesh;
use crate::surface::solids::{Profile, Ring, mirror, sweep};

/// Corners of the cross-sections of bodies, and of processes.
const BODY_SIDES: u32 = 20;
const SIDES: u32 = 8;
/// Body and disc are rounded boxes seen from above.
const BODY: Profile = Profile {
    sides: BODY_SIDES,
    exponent: 0.82,
    caps_mm: [0.9, 0.9],
};
/// Lumbar levels begin here.
const FIRST_LUMBAR: usize = 13;

/// Adds the vertebra of a level (0 is C7).
pub fn add(mesh: &mut RawMesh, column: &Column, level: usize) {
    let place = &column.places[level];
    body(mesh, place);
    spinous_process(mesh, place, level);
    let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
    half_arch(mesh, place, level);
    transverse_process(mesh, place, level);
    mirror(mesh, vertices, triangles);
}

/// Adds the disc between a level and the next one down.
pub fn add_disc(mesh: &mut RawMesh, column: &Column, level: usize) {
    let (above, below) = (&column.places[level], &column.places[level + 1]);
    let foot = |p: &Place, sign: f64, size: f64| Ring {
        centre_mm: p.at(0.0, sign * p.half_height_mm, 0.0),
        u_mm: p.back * (p.half_depth_mm * size),
        v_mm: Vec3::X * (p.half_width_mm * size),
    };
    let (low, high) = (foot(below, 1.0, 0.94), foot(above, -1.0, 0.94));
    let middle = Ring {
        centre_mm: (low.centre_mm + high.centre_mm) / 2.0,
        u_mm: (low.u_mm + high.u_mm) * 0.51,
        v_mm: (low.v_mm + high.v_mm) * 0.51,
    };
    let profile = Profile {
        caps_mm: [0.0, 0.0],
        ..BODY
    };
    sweep(mesh, &[low, middle, high], profile);
}

fn body(mesh: &mut RawMesh, p: &Place) {
    let h = p.half_height_mm;
    // Waisted: the rims of the end plates stand out.
    let rings = [
        (-1.0, 0.97),
        (-0.82, 1.0),
        (-0.4, 0.92),
        (0.0, 0.89),
        (0.4, 0.92),
        (0.82, 1.0),
        (1.0, 0.97),
    ];
    let rings = rings.map(|(y, size)| Ring {
        centre_mm: p.at(0.0, y * h, 0.0),
        u_mm: p.back * (p.half_depth_mm * size),
        v_mm: Vec3::X * (p.half_width_mm * size),
    });
    sweep(mesh, &rings, BODY);
}

/// From the middle of the laminae to the tip: a blade higher than it is wide, with a knob at the end.
fn spinous_process(mesh: &mut RawMesh, p: &Place, level: usize) {
    let lumbar = level >= FIRST_LUMBAR;
    let root = p.at(0.0, -0.30 * p.half_height_mm, p.canal_back_mm - 1.0);
    let way = p.spinous_mm - root;
    let along = unit_or(way, p.back);
    let across = unit_or(along.cross(Vec3::X), p.up);
    // Half width, half height: at the root, half way, before the tip, at the tip.
    let sizes = if lumbar {
        [(5.0, 8.5), (2.6, 9.5), (2.8, 9.0), (3.4, 7.0)]
    } else {
        [(5.0, 6.5), (2.4, 5.0), (2.3, 4.0), (3.0, 3.4)]
    };
    let cap = 2.0;
    let shares = [0.0, 0.45, 0.8, 1.0];
    let rings: [Ring; 4] = std::array::from_fn(|i| {
        let share = shares[i] * (1.0 - cap / way.length().max(2.0 * cap));
        Ring {
            centre_mm: root + way * share,
            u_mm: Vec3::X * sizes[i].0,
            v_mm: across * sizes[i].1,
        }
    });
    let profile = Profile {
        sides: SIDES,
        exponent: 0.9,
        caps_mm: [0.5, cap],
    };
    sweep(mesh, &rings, profile);
}

/// Right half of the arch: pedicle, articular processes, lamina.
fn half_arch(mesh: &mut RawMesh, p: &Place, level: usize) {
    let (h, d, canal) = (p.half_height_mm, p.half_depth_mm, p.canal_half_width_mm);
    let side = canal + 3.5;
    let pillar_z = p.canal_back_mm - 3.0;
    let pedicle = [
        (p.at(canal * 0.95, 0.40 * h, d * 0.72), 4.2, 0.42 * h),
        (p.at(side, 0.38 * h, d + 4.5), 3.4, 0.36 * h),
        (p.at(side, 0.25 * h, pillar_z), 4.0, 0.45 * h),
    ];
    tube(mesh, &pedicle, Vec3::X, 1.0);
    // The pillar: its upper end meets the one above from the front, its lower end the one below from the back.
    // Nothing stands above C7 to be met.
    let top = if level == 0 { 0.75 } else { 1.0 };
    let pillar = [
        (p.at(side, -1.28 * h, pillar_z + 2.0), 3.4, 2.3),
        (p.at(side + 0.5, -0.55 * h, pillar_z + 2.2), 4.2, 3.2),
        (p.at(side + 1.0, 0.2 * h, pillar_z), 4.6, 4.0),
        (p.at(side + 1.0, 0.95 * top * h, pillar_z - 1.6), 4.2, 3.0),
        (p.at(side + 0.5, 1.28 * top * h, pillar_z - 2.4), 3.4, 2.0),
    ];
    tube(mesh, &pillar, Vec3::X, 2.0);
    // The lamina slopes from the pillar to the root of the spinous process; a plate higher than it is thick.
    let lamina = [
        (p.at(side + 0.5, 0.05 * h, pillar_z + 1.0), 2.8, 0.72 * h),
        (
            p.at(side * 0.55, -0.12 * h, p.canal_back_mm + 0.5),
            2.4,
            0.74 * h,
        ),
        (p.at(-0.5, -0.25 * h, p.canal_back_mm + 2.4), 2.6, 0.70 * h),
    ];
    tube(mesh, &lamina, p.back, 0.6);
}

/// From the pillar to under its landmark.
fn transverse_process(mesh: &mut RawMesh, p: &Place, level: usize) {
    let root = p.at(
        p.canal_half_width_mm + 3.0,
        0.25 * p.half_height_mm,
        p.canal_back_mm - 4.0,
    );
    let tip = p.transverse_mm;
    let half_way = root.lerp(tip, 0.5) - p.back * 1.0;
    let (at_root, waist, knob) = if level >= FIRST_LUMBAR {
        ((3.2, 5.5), (2.2, 4.4), (2.2, 3.6))
    } else {
        ((4.2, 5.5), (3.4, 4.2), (4.0, 4.6))
    };
    let end = tip - unit_or(tip - half_way, Vec3::X) * 2.0;
    let rings = [
        (root, at_root.0, at_root.1),
        (half_way, waist.0, waist.1),
        (end, knob.0, knob.1),
    ];
    tube(mesh, &rings, p.back, 2.0);
}

/// A tube through stations (centre, half-axis towards `towards`, half-axis across both, mm).
fn tube(mesh: &mut RawMesh, stations: &[(Vec3, f64, f64)], towards: Vec3, cap_mm: f64) {
    let points: Vec<[f64; 5]> = (stations.iter())
        .map(|&(c, a, b)| [c.x, c.y, c.z, a, b])
        .collect();
    let curve = crate::surface::solids::through(&points, 2);
    let centre = |p: &[f64; 5]| Vec3::new(p[0], p[1], p[2]);
    let rings: Vec<Ring> = (0..curve.len())
        .map(|i| {
            let before = centre(&curve[i.saturating_sub(1)]);
            let after = centre(&curve[(i + 1).min(curve.len() - 1)]);
            let along = unit_or(after - before, Vec3::Y);
            let u = unit_or(
                towards - along * towards.dot(along),
                crate::geom::any_tangent(along),
            );
            Ring {
                centre_mm: centre(&curve[i]),
                u_mm: u * curve[i][3],
                v_mm: along.cross(u) * curve[i][4],
            }
        })
        .collect();
    sweep(mesh, &rings, Profile::round(SIDES, cap_mm));
}
