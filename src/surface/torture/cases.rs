//! The cases, one after the other.

use super::shapes::{block, grid, patch, planes, steps, together, turned};
use super::{Case, HalfSpace, Stream, Truth};
use crate::geom::Vec3;
use crate::surface::RawMesh;
use crate::surface::primitives::icosphere;
use std::f64::consts::TAU;

/// Every case, with a path for each seed.
pub fn all(seed: u64) -> Vec<Case> {
    let mut cases = saw_teeth(seed);
    cases.extend([
        blade(seed),
        slot(seed, 1.0, "1° slot"),
        slot(seed, 0.1, "0.1° slot"),
        double_sheet(seed, true),
        double_sheet(seed, false),
        needles_flat(seed),
        needles_rough(seed),
        hanging_flat(seed),
        hanging_valley(seed),
        hanging_ridge(seed),
        wall_on_plate(seed),
        corner(seed, false, false),
        corner(seed, true, false),
        corner(seed, true, true),
        pit(seed, 2.0, "pit"),
        pit(seed, 8.0, "steep pit"),
        tip(seed, 2.0, "tip"),
        tip(seed, 40.0, "needle tip"),
        spheres(seed, 15.0, "touching spheres"),
        spheres(seed, 10.0, "crossing spheres"),
        boxes(seed),
        plate(seed),
    ]);
    cases
}

/// Corners of a path.
const CORNERS: usize = 40;

/// A path between `low` and `high` that starts at `free`: corners at random, every third just over or under a vertex of the
/// mesh, so that motions run exactly along edges and through corners.
fn wander(seed: u64, mesh: &RawMesh, free: Vec3, low: Vec3, high: Vec3) -> Vec<Vec3> {
    let mut s = Stream(seed.wrapping_mul(1 << 20) + mesh.triangles.len() as u64);
    let within: Vec<Vec3> = (mesh.positions.iter().copied())
        .filter(|p| p.cmpge(low).all() && p.cmple(high).all())
        .collect();
    let mut path = vec![free];
    for i in 1..CORNERS {
        let mut p = (low + high) / 2.0 + s.vector() * (high - low) / 2.0;
        if i % 3 == 0 && !within.is_empty() {
            let at = (s.unit().abs() * within.len() as f64) as usize;
            let v = within[at.min(within.len() - 1)];
            p = Vec3::new(v.x, v.y, p.z);
        }
        path.push(p);
    }
    path
}

fn above(point: Vec3, normal: Vec3) -> HalfSpace {
    HalfSpace::new(point, normal)
}

fn saw_teeth(seed: u64) -> Vec<Case> {
    let teeth = [
        ("saw 2 × 0.5 mm", 2.0, 0.5),
        ("saw 2 × 5 mm", 2.0, 5.0),
        ("saw 2 × 50 mm", 2.0, 50.0),
        ("saw 0.25 × 5 mm", 0.25, 5.0),
    ];
    let case = |(name, pitch, tall): (&'static str, f64, f64)| {
        let half = pitch / 2.0;
        let height = move |x: f64, _: f64| {
            let x = x / half;
            tall * (x - 2.0 * (x / 2.0).round()).abs()
        };
        let xs: Vec<f64> = (-(24.0 / half) as i32..=(24.0 / half) as i32)
            .map(|i| f64::from(i) * half)
            .collect();
        let mesh = grid(&xs, &steps(-24.0, 24.0, 7), height);
        let (low, high) = (
            Vec3::new(-8.0, -12.0, -5.0),
            Vec3::new(8.0, 12.0, tall + 5.0),
        );
        Case {
            name,
            path: wander(seed, &mesh, Vec3::new(0.1, 0.0, tall + 4.0), low, high),
            mesh,
            truth: Truth::Height {
                height: Box::new(height),
                slope: tall / half,
                top_mm: tall,
            },
            crossed: false,
        }
    };
    teeth.map(case).into()
}

/// A closed blade of 1°, edge up; the finger comes from the left and never rises above the edge.
fn blade(seed: u64) -> Case {
    let half = libm::tan(TAU / 720.0) * 40.0;
    let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let (edge, left, right) = (
        [v(0.0, -32.0, 0.0), v(0.0, 32.0, 0.0)],
        [v(-half, -32.0, -40.0), v(-half, 32.0, -40.0)],
        [v(half, -32.0, -40.0), v(half, 32.0, -40.0)],
    );
    let mut mesh = [
        [edge[0], edge[1], left[1], left[0]],
        [edge[1], edge[0], right[0], right[1]],
        [left[0], left[1], right[1], right[0]],
    ]
    .map(|c| patch(c, 16))
    .into_iter()
    .fold(RawMesh::default(), together);
    // The two ends, fans over the points of their edges.
    let lattice = |a: Vec3, b: Vec3| patch([a, b, b, a], 16).positions[..17].to_vec();
    for (e, turn) in [(0, false), (1, true)] {
        let (l, r) = (lattice(edge[e], left[e]), lattice(edge[e], right[e]));
        let mut end = RawMesh::default();
        end.positions.extend(l.iter().chain(&r));
        for i in 0..16 {
            end.triangles
                .extend([[i, i + 1, i + 18], [i, i + 18, i + 17]]);
        }
        end.triangles.remove(1);
        mesh = together(mesh, if turn { turned(end) } else { end });
    }
    // The base between the ends is one cell wide there.
    let (low, high) = (v(-6.0, -20.0, -30.0), v(6.0, 20.0, -4.0));
    let face = above(edge[0], (edge[1] - edge[0]).cross(left[0] - edge[0]));
    Case {
        name: "1° blade",
        path: wander(seed, &mesh, v(-4.0, 0.0, -10.0), low, high),
        mesh,
        truth: Truth::Cell(vec![face]),
        crossed: false,
    }
}

/// Two walls that meet at the bottom.
fn slot(seed: u64, degrees: f64, name: &'static str) -> Case {
    let half = libm::tan(degrees * TAU / 720.0) * 40.0;
    let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let bottom = [v(0.0, -32.0, 0.0), v(0.0, 32.0, 0.0)];
    let left = [
        bottom[1],
        v(-half, 32.0, 40.0),
        v(-half, -32.0, 40.0),
        bottom[0],
    ];
    let right = [
        bottom[0],
        v(half, -32.0, 40.0),
        v(half, 32.0, 40.0),
        bottom[1],
    ];
    let plane = |c: [Vec3; 4]| above(c[0], (c[1] - c[0]).cross(c[3] - c[0]));
    let mesh = together(patch(left, 8), patch(right, 8));
    let (low, high) = (v(-5.0, -20.0, -8.0), v(5.0, 20.0, 30.0));
    Case {
        name,
        path: wander(seed, &mesh, v(0.0, 0.0, 20.0), low, high),
        mesh,
        truth: Truth::Cell(vec![plane(left), plane(right)]),
        crossed: false,
    }
}

/// Two sheets 0.1 mm apart that face away from each other, closed all round or not.
fn double_sheet(seed: u64, closed: bool) -> Case {
    let (low, high) = (Vec3::new(-20.0, -20.0, -0.1), Vec3::new(20.0, 20.0, 0.0));
    let mesh = if closed {
        block(low, high, 16)
    } else {
        let at = steps(-20.0, 20.0, 16);
        together(
            grid(&at, &at, |_, _| 0.0),
            turned(grid(&at, &at, |_, _| -0.1)),
        )
    };
    let (low, high) = (Vec3::new(-12.0, -12.0, -12.0), Vec3::new(12.0, 12.0, 6.0));
    Case {
        name: if closed {
            "closed sheet 0.1 mm"
        } else {
            "two sheets 0.1 mm"
        },
        path: wander(seed, &mesh, Vec3::Z * 5.0, low, high),
        mesh,
        truth: Truth::Cell(vec![above(Vec3::ZERO, Vec3::Z)]),
        crossed: false,
    }
}

/// Columns of ever smaller width: triangles 40 times to 10⁶ times as long as wide.
fn needle_columns() -> Vec<f64> {
    let mut xs = vec![0.0];
    for (width, n) in [
        (4.0e-5, 60),
        (4.0e-4, 60),
        (4.0e-3, 200),
        (0.2, 40),
        (1.0, 12),
    ] {
        for _ in 0..n {
            xs.push(xs[xs.len() - 1] + width);
        }
    }
    let left: Vec<f64> = xs.iter().skip(1).rev().map(|x| -x).collect();
    [left, xs].concat()
}

fn needles_flat(seed: u64) -> Case {
    let mesh = grid(&needle_columns(), &[-20.0, 20.0], |_, _| 0.0);
    let (low, high) = (Vec3::new(-8.0, -15.0, -6.0), Vec3::new(8.0, 15.0, 4.0));
    let mut path = wander(seed, &mesh, Vec3::Z * 3.0, low, high);
    // Slowly over the finest ones.
    path.extend([
        Vec3::new(-0.01, 1.0, -2.0),
        Vec3::new(0.01, 2.0, -2.0),
        Vec3::new(0.0, -3.0, -1.0),
    ]);
    Case {
        name: "needles, flat",
        path,
        mesh,
        truth: Truth::Cell(vec![above(Vec3::ZERO, Vec3::Z)]),
        crossed: false,
    }
}

fn needles_rough(seed: u64) -> Case {
    let xs = needle_columns();
    let zs: Vec<f64> = (xs.windows(2).enumerate())
        .scan(0.0, |z, (i, w)| {
            let before = *z;
            *z += (w[1] - w[0]) * [0.6, -0.6, -0.3, 0.3][i % 4];
            Some(before)
        })
        .chain([0.0])
        .collect();
    let n = xs.len();
    let (table, levels) = (xs.clone(), zs.clone());
    let height = move |x: f64, _: f64| {
        let i = table.partition_point(|&at| at <= x).clamp(1, n - 1);
        let share = (x - table[i - 1]) / (table[i] - table[i - 1]);
        levels[i - 1] + (levels[i] - levels[i - 1]) * share
    };
    let mesh = grid(&xs, &[-20.0, 20.0], &height);
    let (low, high) = (Vec3::new(-8.0, -15.0, -4.0), Vec3::new(8.0, 15.0, 4.0));
    let mut path = wander(seed, &mesh, Vec3::Z * 3.0, low, high);
    path.extend([
        Vec3::new(-0.01, 1.0, -1.0),
        Vec3::new(0.01, 2.0, -1.0),
        Vec3::new(0.0, -3.0, -1.0),
    ]);
    Case {
        name: "needles, rough",
        path,
        mesh,
        truth: Truth::Height {
            height: Box::new(height),
            slope: 20.0,
            top_mm: zs.iter().copied().fold(0.0, f64::max),
        },
        crossed: false,
    }
}

/// Two bands that meet at y = 0 with vertices of one on the edges of the other.
fn hanging(height: impl Fn(f64, f64) -> f64) -> RawMesh {
    let (lower, upper) = (steps(-20.0, 20.0, 7), steps(-20.0, 20.0, 12));
    together(
        grid(&lower, &steps(-20.0, 0.0, 3), &height),
        grid(&upper, &steps(0.0, 20.0, 3), &height),
    )
}

fn hanging_flat(seed: u64) -> Case {
    let mesh = hanging(|_, _| 0.0);
    let (low, high) = (Vec3::new(-12.0, -12.0, -6.0), Vec3::new(12.0, 12.0, 4.0));
    Case {
        name: "T-junctions, flat",
        path: wander(seed, &mesh, Vec3::Z * 3.0, low, high),
        mesh,
        truth: Truth::Cell(vec![above(Vec3::ZERO, Vec3::Z)]),
        crossed: true,
    }
}

fn hanging_valley(seed: u64) -> Case {
    let mesh = hanging(|_, y| 0.7 * y.abs());
    let (low, high) = (Vec3::new(-12.0, -6.0, -6.0), Vec3::new(12.0, 6.0, 6.0));
    Case {
        name: "T-junctions, valley",
        path: wander(seed, &mesh, Vec3::Z * 5.0, low, high),
        mesh,
        truth: Truth::Cell(vec![
            above(Vec3::ZERO, Vec3::new(0.0, -0.7, 1.0)),
            above(Vec3::ZERO, Vec3::new(0.0, 0.7, 1.0)),
        ]),
        crossed: true,
    }
}

fn hanging_ridge(seed: u64) -> Case {
    let height = |_: f64, y: f64| -0.7 * y.abs();
    let mesh = hanging(height);
    let (low, high) = (Vec3::new(-12.0, -8.0, -9.0), Vec3::new(12.0, 8.0, 3.0));
    Case {
        name: "T-junctions, ridge",
        path: wander(seed, &mesh, Vec3::Z * 3.0, low, high),
        mesh,
        truth: Truth::Height {
            height: Box::new(height),
            slope: 0.7,
            top_mm: 0.0,
        },
        crossed: true,
    }
}

/// A wall that stands on a plate without sharing a vertex with it.
fn wall_on_plate(seed: u64) -> Case {
    let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let mesh = together(
        block(v(-20.0, -20.0, -3.0), v(20.0, 20.0, 0.0), 8),
        block(v(3.3, -18.0, 0.0), v(5.0, 17.0, 14.0), 4),
    );
    let (low, high) = (v(-12.0, -12.0, -8.0), v(12.0, 12.0, 8.0));
    Case {
        name: "wall on plate",
        path: wander(seed, &mesh, v(-3.0, 0.0, 4.0), low, high),
        mesh,
        truth: Truth::Cell(vec![
            above(Vec3::ZERO, Vec3::Z),
            above(v(3.3, 0.0, 0.0), -Vec3::X),
        ]),
        crossed: true,
    }
}

/// Three walls at right angles, in line with the axes or not, joined or apart by roundings.
fn corner(seed: u64, oblique: bool, slit: bool) -> Case {
    let turn = |p: Vec3| {
        if oblique {
            let (c, s) = (libm::cos(0.7), libm::sin(0.7));
            let p = Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
            Vec3::new(p.x, c * p.y - s * p.z, s * p.y + c * p.z)
        } else {
            p
        }
    };
    let before = |p: Vec3| if slit { turn(p) } else { p };
    let after = |p: Vec3| if slit { p } else { turn(p) };
    let v = |x: f64, y: f64, z: f64| before(Vec3::new(x, y, z) * 24.0);
    let (o, x, y, z) = (
        v(0.0, 0.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(0.0, 1.0, 0.0),
        v(0.0, 0.0, 1.0),
    );
    let walls = [
        [o, x, v(1.0, 1.0, 0.0), y],
        [o, y, v(0.0, 1.0, 1.0), z],
        [o, z, v(1.0, 0.0, 1.0), x],
    ];
    let mut mesh = (walls.into_iter())
        .map(|w| patch(w, 8))
        .fold(RawMesh::default(), together);
    for p in &mut mesh.positions {
        *p = after(*p);
    }
    let (low, high) = (Vec3::splat(-8.0), Vec3::splat(10.0));
    let path = wander(seed, &mesh, Vec3::splat(4.0), low, high);
    Case {
        name: match (oblique, slit) {
            (false, _) => "inside corner",
            (true, false) => "inside corner, oblique",
            (true, true) => "inside corner, unjoined",
        },
        path: path.into_iter().map(turn).collect(),
        mesh,
        truth: Truth::Cell(
            [Vec3::X, Vec3::Y, Vec3::Z]
                .map(|n| above(Vec3::ZERO, turn(n)))
                .into(),
        ),
        crossed: slit,
    }
}

const SIDES: u32 = 12;

/// A cone of [`SIDES`] faces about z with its tip in the origin, 16 mm wide to each side; z = `slope` · radius in the edges.
fn cone(slope: f64) -> RawMesh {
    let mut mesh = RawMesh {
        positions: vec![Vec3::ZERO],
        ..RawMesh::default()
    };
    let at = |ring: u32, i: u32| 1 + (ring - 1) * SIDES + i % SIDES;
    for ring in 1..=4_u32 {
        for i in 0..SIDES {
            let angle = TAU * f64::from(i) / f64::from(SIDES);
            let r = 4.0 * f64::from(ring);
            mesh.positions.push(Vec3::new(
                r * libm::cos(angle),
                r * libm::sin(angle),
                slope * r,
            ));
            let (a, b) = (at(ring, i), at(ring, i + 1));
            if ring == 1 {
                mesh.triangles.push([0, a, b]);
            } else {
                let (c, d) = (at(ring - 1, i), at(ring - 1, i + 1));
                mesh.triangles.extend([[c, a, b], [c, b, d]]);
            }
        }
    }
    mesh
}

/// The planes of a cone's faces.
fn cone_planes(mesh: &RawMesh) -> Vec<HalfSpace> {
    let mut first = mesh.clone();
    first.triangles.retain(|t| t.contains(&0));
    planes(&first)
}

fn pit(seed: u64, slope: f64, name: &'static str) -> Case {
    let mesh = cone(slope);
    let deep = 2.0 * slope;
    let (low, high) = (Vec3::new(-6.0, -6.0, -6.0), Vec3::new(6.0, 6.0, deep + 6.0));
    Case {
        name,
        path: wander(seed, &mesh, Vec3::Z * (deep + 3.0), low, high),
        truth: Truth::Cell(cone_planes(&mesh)),
        mesh,
        crossed: false,
    }
}

fn tip(seed: u64, slope: f64, name: &'static str) -> Case {
    let mesh = cone(-slope);
    let faces = cone_planes(&mesh);
    let height = move |x: f64, y: f64| {
        (faces.iter()).fold(f64::INFINITY, |z, h| {
            z.min(-(h.normal.x * x + h.normal.y * y) / h.normal.z)
        })
    };
    let (low, high) = (
        Vec3::new(-5.0, -5.0, -4.0 * slope),
        Vec3::new(5.0, 5.0, 4.0),
    );
    Case {
        name,
        path: wander(seed, &mesh, Vec3::Z * 3.0, low, high),
        mesh,
        truth: Truth::Height {
            height: Box::new(height),
            // The faces are a little steeper than their edges.
            slope: slope * (1.0 / libm::cos(TAU / 2.0 / f64::from(SIDES))),
            top_mm: 0.0,
        },
        crossed: false,
    }
}

/// Two balls of 15 mm at ± `apart_mm`.
fn spheres(seed: u64, apart_mm: f64, name: &'static str) -> Case {
    let at = |x: f64| {
        let mut ball = icosphere(15.0, 3);
        ball.positions.iter_mut().for_each(|p| p.x += x);
        ball
    };
    let (one, two) = (at(-apart_mm), at(apart_mm));
    let bodies = vec![planes(&one), planes(&two)];
    let mesh = together(one, two);
    let reach = apart_mm + 15.0;
    let mut path = wander(
        seed,
        &mesh,
        Vec3::new(0.0, 0.0, 22.0),
        Vec3::new(-reach, -18.0, -18.0),
        Vec3::new(reach, 18.0, 18.0),
    );
    // Into the groove between them, and round it.
    for i in 0..12 {
        let angle = TAU * f64::from(i) / 12.0;
        let r = if i % 3 == 0 { 12.0 } else { 5.0 };
        path.push(Vec3::new(
            0.3 * f64::from(i % 4),
            r * libm::sin(angle),
            r * libm::cos(angle),
        ));
    }
    Case {
        name,
        path,
        mesh,
        truth: Truth::Bodies {
            bodies,
            radius_mm: reach,
        },
        crossed: true,
    }
}

/// A box, one inside it, and one that shares a part of a face with it.
fn boxes(seed: u64) -> Case {
    let v = Vec3::new;
    let parts = [
        block(v(-10.0, -10.0, -10.0), v(10.0, 10.0, 10.0), 4),
        block(v(-4.0, -5.0, -6.0), v(5.0, 4.0, 3.0), 2),
        block(v(-3.0, -4.0, 10.0), v(6.0, 5.0, 16.0), 4),
    ];
    let bodies = parts.iter().map(planes).collect();
    let mesh = parts.into_iter().fold(RawMesh::default(), together);
    Case {
        name: "boxes in and on a box",
        path: wander(
            seed,
            &mesh,
            Vec3::Z * 20.0,
            Vec3::splat(-14.0),
            v(14.0, 14.0, 20.0),
        ),
        mesh,
        truth: Truth::Bodies {
            bodies,
            radius_mm: 20.0,
        },
        crossed: true,
    }
}

/// A sheet open all round; the path leads over its rim and back.
fn plate(seed: u64) -> Case {
    let at = steps(-10.0, 10.0, 7);
    let mesh = grid(&at, &at, |_, _| 0.0);
    let (low, high) = (Vec3::new(-14.0, -14.0, -6.0), Vec3::new(14.0, 14.0, 6.0));
    Case {
        name: "open rim",
        path: wander(seed, &mesh, Vec3::Z * 5.0, low, high),
        mesh,
        truth: Truth::Plate { half_mm: 10.0 },
        crossed: false,
    }
}
