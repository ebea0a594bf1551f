//! Closed solids for drawing: tubes swept along a path and plates over an outline, gathered in one [`RawMesh`].
//!
//! Every solid is closed, consistently oriented and faces outward. Solids may overlap one another; they are drawn, never felt.

use super::RawMesh;
use crate::geom::{Vec2, Vec3, unit_or};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

/// One cross-section of a sweep: an ellipse, or a rounded box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Its centre, mm.
    pub centre_mm: Vec3,
    /// One half-axis, mm.
    pub u_mm: Vec3,
    /// The other one, mm; at right angles to the first.
    pub v_mm: Vec3,
}

/// What all cross-sections of a sweep share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// Corners of each cross-section; at least 3.
    pub sides: u32,
    /// Exponent of the superellipse |x|^(2/p) + |y|^(2/p) = 1: 1 is an ellipse, towards 0 a box.
    pub exponent: f64,
    /// How far the rounded ends stand out past the first and the last ring, mm.
    pub caps_mm: [f64; 2],
}

impl Profile {
    /// Ellipses with ends that stand out equally far.
    pub const fn round(sides: u32, cap_mm: f64) -> Self {
        Self {
            sides,
            exponent: 1.0,
            caps_mm: [cap_mm, cap_mm],
        }
    }
}

/// Share of a cap's height and size of its cross-sections between its foot and its top.
const CAP: [(f64, f64); 2] = [(0.62, 0.785), (0.93, 0.37)];

/// Adds a tube through `rings` in their order, with rounded ends. Fewer than two rings or three sides add nothing.
///
/// Neighbouring rings must not cross one another; then the tube does not cross itself.
pub fn sweep(mesh: &mut RawMesh, rings: &[Ring], profile: Profile) {
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else {
        return;
    };
    if rings.len() < 2 || profile.sides < 3 {
        return;
    }
    let ends = [
        (
            first,
            unit_or(first.centre_mm - rings[1].centre_mm, Vec3::ZERO),
        ),
        (
            last,
            unit_or(
                last.centre_mm - rings[rings.len() - 2].centre_mm,
                Vec3::ZERO,
            ),
        ),
    ];
    let cap = |end: usize, &(height, size): &(f64, f64)| {
        let (ring, out) = ends[end];
        Ring {
            centre_mm: ring.centre_mm + out * (height * profile.caps_mm[end]),
            u_mm: ring.u_mm * size,
            v_mm: ring.v_mm * size,
        }
    };
    let mut all: Vec<Ring> = CAP.iter().rev().map(|c| cap(0, c)).collect();
    all.extend(rings);
    all.extend(CAP.iter().map(|c| cap(1, c)));
    // Outward is where u, v and the way along the tube make a right-handed frame.
    let turned = first.u_mm.cross(first.v_mm).dot(ends[0].1) > 0.0;
    let start = mesh.positions.len() as u32;
    for ring in &all {
        for k in 0..profile.sides {
            let angle = TAU * f64::from(k) / f64::from(profile.sides);
            let along = |x: f64| {
                let size = libm::pow(x.abs(), profile.exponent);
                if x < 0.0 { -size } else { size }
            };
            let (u, v) = (along(libm::cos(angle)), along(libm::sin(angle)));
            let v = if turned { -v } else { v };
            mesh.positions
                .push(ring.centre_mm + ring.u_mm * u + ring.v_mm * v);
        }
    }
    let n = profile.sides;
    for ring in 0..all.len() as u32 - 1 {
        for k in 0..n {
            let next = (k + 1) % n;
            let [a, b] = [k, next].map(|k| start + ring * n + k);
            mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    let top = start + (all.len() as u32 - 1) * n;
    let tips = [(0, start), (1, top)];
    for (end, row) in tips {
        let (ring, out) = ends[end];
        let tip = mesh.positions.len() as u32;
        mesh.positions
            .push(ring.centre_mm + out * profile.caps_mm[end]);
        for k in 0..n {
            let (a, b) = (row + k, row + (k + 1) % n);
            mesh.triangles
                .push(if end == 0 { [b, a, tip] } else { [a, b, tip] });
        }
    }
}

/// Adds a plate over a closed outline that turns counter-clockwise and is seen whole from `middle`.
///
/// `sheets` gives, for a place of the map plane and its share of the way from the middle to the outline (0 to 1), the heights
/// of the upper and the lower face, mm; at the outline their mean counts. Fewer than three points add nothing.
pub fn plate(
    mesh: &mut RawMesh,
    outline: &[Vec2],
    middle: Vec2,
    steps: u32,
    sheets: impl Fn(Vec2, f64) -> [f64; 2],
) {
    let n = outline.len() as u32;
    if n < 3 || steps == 0 {
        return;
    }
    let rim = mesh.positions.len() as u32;
    for &p in outline {
        let [upper, lower] = sheets(p, 1.0);
        mesh.positions.push(p.extend((upper + lower) / 2.0));
    }
    for (face, sign) in [(0, false), (1, true)] {
        let mut outer = rim;
        for step in (1..steps).rev() {
            // Rings crowd at the outline, where the plate is rounded.
            let share = libm::sin(FRAC_PI_2 * f64::from(step) / f64::from(steps));
            let ring = mesh.positions.len() as u32;
            for &p in outline {
                let at = middle.lerp(p, share);
                mesh.positions.push(at.extend(sheets(at, share)[face]));
            }
            for k in 0..n {
                let next = (k + 1) % n;
                let quad = [outer + k, outer + next, ring + next, ring + k];
                fan(mesh, &quad, sign);
            }
            outer = ring;
        }
        let tip = mesh.positions.len() as u32;
        mesh.positions
            .push(middle.extend(sheets(middle, 0.0)[face]));
        for k in 0..n {
            fan(mesh, &[outer + k, outer + (k + 1) % n, tip], sign);
        }
    }
}

fn fan(mesh: &mut RawMesh, corners: &[u32], turned: bool) {
    for i in 1..corners.len() - 1 {
        let (a, b, c) = (corners[0], corners[i], corners[i + 1]);
        mesh.triangles
            .push(if turned { [a, c, b] } else { [a, b, c] });
    }
}

/// Adds the mirror image, over the plane x = 0, of the solids made since the mesh had so many vertices and triangles.
pub fn mirror(mesh: &mut RawMesh, vertices_from: usize, triangles_from: usize) {
    let n_vertices = mesh.positions.len();
    let shift = (n_vertices - vertices_from.min(n_vertices)) as u32;
    for i in vertices_from..n_vertices {
        let p = mesh.positions[i];
        mesh.positions.push(Vec3::new(-p.x, p.y, p.z));
    }
    for i in triangles_from..mesh.triangles.len() {
        let [a, b, c] = mesh.triangles[i];
        mesh.triangles.push([a + shift, c + shift, b + shift]);
    }
}

/// Points on a smooth curve through `points`, `per_span` for each span, ends included. Two points give a line, one gives
/// itself.
///
/// Catmull & Rom 1974 with centripetal knots (Yuksel et al. 2011): no loop and no kink where near points follow far ones.
pub fn through<const N: usize>(points: &[[f64; N]], per_span: usize) -> Vec<[f64; N]> {
    let Some(&last) = points.last() else {
        return Vec::new();
    };
    let mut out = Vec::with_capacity((points.len() - 1) * per_span + 1);
    for (span, pair) in points.windows(2).enumerate() {
        let (b, c) = (pair[0], pair[1]);
        // Past the ends the curve goes on as it came.
        let a = if span == 0 {
            past(b, c)
        } else {
            points[span - 1]
        };
        let d = points.get(span + 2).copied().unwrap_or(past(c, b));
        let knots = [a, b, c, d];
        let mut at = [0.0; 4];
        for i in 1..4 {
            at[i] = at[i - 1] + apart(knots[i - 1], knots[i]).sqrt().max(1e-6);
        }
        for step in 0..per_span {
            let t = at[1] + (at[2] - at[1]) * step as f64 / per_span as f64;
            let mix = |p: [f64; N], q: [f64; N], from: f64, to: f64| -> [f64; N] {
                let share = (t - from) / (to - from);
                std::array::from_fn(|k| p[k] + (q[k] - p[k]) * share)
            };
            // Barry & Goldman 1988.
            let near = [0, 1, 2].map(|i| mix(knots[i], knots[i + 1], at[i], at[i + 1]));
            let [p, q] = [0, 1].map(|i| mix(near[i], near[i + 1], at[i], at[i + 2]));
            out.push(if step == 0 {
                b
            } else {
                mix(p, q, at[1], at[2])
            });
        }
    }
    out.push(last);
    out
}

fn apart<const N: usize>(p: [f64; N], q: [f64; N]) -> f64 {
    (0..N)
        .map(|k| (q[k] - p[k]) * (q[k] - p[k]))
        .sum::<f64>()
        .sqrt()
}

/// As far past `from` as `towards` lies before it.
fn past<const N: usize>(from: [f64; N], towards: [f64; N]) -> [f64; N] {
    std::array::from_fn(|k| 2.0 * from[k] - towards[k])
}

/// Volume within some triangles of a mesh, mm³: positive where closed solids face outward (divergence theorem).
pub fn volume_mm3(mesh: &RawMesh, triangles: Range<usize>) -> f64 {
    mesh.triangles[triangles]
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Whether each edge is run once each way: then the triangles close and agree on their sides.
    pub(in crate::surface) fn is_closed(mesh: &RawMesh, triangles: Range<usize>) -> bool {
        let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for t in &mesh.triangles[triangles] {
            for i in 0..3 {
                *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
            }
        }
        edges
            .iter()
            .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    fn ring(z: f64, a: f64, b: f64) -> Ring {
        Ring {
            centre_mm: Vec3::Z * z,
            u_mm: Vec3::X * a,
            v_mm: Vec3::Y * b,
        }
    }

    #[test]
    fn a_tube_is_closed_faces_outward_and_has_its_volume_either_way_round() {
        let profile = Profile {
            sides: 64,
            exponent: 1.0,
            caps_mm: [0.0, 0.0],
        };
        // A cylinder over an ellipse: π a b h.
        for rings in [
            [ring(0.0, 3.0, 2.0), ring(10.0, 3.0, 2.0)],
            [ring(10.0, 3.0, 2.0), ring(0.0, 3.0, 2.0)],
        ] {
            let mut mesh = RawMesh::default();
            sweep(&mut mesh, &rings, profile);
            assert!(is_closed(&mesh, 0..mesh.triangles.len()));
            let volume = volume_mm3(&mesh, 0..mesh.triangles.len());
            let wanted = std::f64::consts::PI * 60.0;
            assert!((volume / wanted - 1.0).abs() < 0.01, "{volume} {wanted}");
        }
    }

    #[test]
    fn too_little_adds_nothing() {
        let mut mesh = RawMesh::default();
        sweep(&mut mesh, &[], Profile::round(8, 1.0));
        sweep(&mut mesh, &[ring(0.0, 1.0, 1.0)], Profile::round(8, 1.0));
        sweep(
            &mut mesh,
            &[ring(0.0, 1.0, 1.0), ring(1.0, 1.0, 1.0)],
            Profile::round(2, 1.0),
        );
        plate(&mut mesh, &[Vec2::ZERO, Vec2::X], Vec2::ZERO, 3, |_, _| {
            [1.0, 0.0]
        });
        assert_eq!(mesh, RawMesh::default());
    }

    #[test]
    fn a_plate_is_closed_faces_outward_and_has_its_volume() {
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec2::new(x * 10.0, y * 10.0));
        let mut mesh = RawMesh::default();
        // A pyramid on each side: two times 400 mm² × 3 mm / 3.
        plate(&mut mesh, &square, Vec2::ZERO, 4, |_, share| {
            [3.0 * (1.0 - share), -3.0 * (1.0 - share)]
        });
        assert!(is_closed(&mesh, 0..mesh.triangles.len()));
        let volume = volume_mm3(&mesh, 0..mesh.triangles.len());
        assert!((volume - 800.0).abs() < 1e-9, "{volume}");
    }

    #[test]
    fn a_mirror_image_faces_outward_too() {
        let mut mesh = RawMesh::default();
        sweep(
            &mut mesh,
            &[ring(0.0, 3.0, 2.0), ring(10.0, 1.0, 2.0)],
            Profile::round(12, 1.0),
        );
        let n = mesh.triangles.len();
        let vertices = mesh.positions.len();
        mirror(&mut mesh, 0, 0);
        assert_eq!(mesh.positions.len(), 2 * vertices);
        assert!(is_closed(&mesh, n..2 * n));
        let [one, other] = [0..n, n..2 * n].map(|part| volume_mm3(&mesh, part));
        assert!((one - other).abs() < 1e-9 && one > 0.0);
    }

    #[test]
    fn a_curve_goes_through_its_points_and_a_line_stays_one() {
        let points = [[0.0, 0.0], [1.0, 2.0], [4.0, 1.0], [5.0, 5.0]];
        let curve = through(&points, 4);
        assert_eq!(curve.len(), 13);
        for (i, p) in points.iter().enumerate() {
            assert_eq!(curve[4 * i], *p);
        }
        for [x, y] in through(&[[0.0, 1.0], [2.0, 5.0]], 8) {
            assert!((y - 1.0 - 2.0 * x).abs() < 1e-12);
        }
        assert_eq!(through(&[[7.0]], 5), vec![[7.0]]);
    }
}
