//! Questions about the surface that have no place in it, and surfaces that searches find hard.

use super::drive::stream;
use super::readings::ODD;
use super::row::{Case, Ended, Size, Tally};
use crate::geom::{Aabb, Triangle, Vec3};
use crate::partition::hdb::{self, Query};
use crate::partition::structure::Structure;
use crate::partition::{self, Partition, Sides, brute::Brute, tree};
use crate::surface::torture::{Stream, grid, steps};
use crate::surface::{RawMesh, Surface};

/// Every structure on every question.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (name, _) in partition::all() {
        cases.push(Case::new(
            format!("{name}: places that are none"),
            "Partition::nearest, sweep, in_box",
            "NaN, ±∞, 1e308, 5e-324 in every coordinate and bound",
            move |size| odd_questions(size, name),
        ));
        for (shape, mesh) in SHAPES {
            cases.push(Case::new(
                format!("{name}: {shape}"),
                "Partition::nearest, sweep, in_box",
                "near, far and along",
                move |size| against_brute(size, name, mesh()),
            ));
        }
    }
    for kind in ["brute", "bsp", "octree", "hybrid"] {
        cases.push(Case::new(
            format!("{kind}: box that is none"),
            "Structure::gather, hdb::cube",
            "the published box about NaN, ±∞, 1e308",
            move |_| odd_boxes(kind),
        ));
    }
    cases.push(Case::new(
        "triangles without area, at places that are none",
        "Triangle::closest_point",
        "corners together, in line and apart; NaN, ±∞, 1e308",
        |_| odd_triangles(),
    ));
    cases
}

type Shape = (&'static str, fn() -> RawMesh);

const SHAPES: [Shape; 4] = [
    ("needles of aspect 1e9", || {
        let mut xs = vec![-50.0];
        xs.extend((0..40).map(|i| f64::from(i) * 1.0e-7));
        xs.push(50.0);
        grid(&xs, &steps(-50.0, 50.0, 4), |x, y| 0.01 * x * y)
    }),
    ("one of 1e-6 mm among some of 1 km", || {
        let xs = [-1.0e6, -1.0, -1.0e-6, 0.0, 1.0e-6, 1.0, 1.0e6];
        grid(&xs, &xs, |x, _| 0.1 * x)
    }),
    ("2000 on one place", || {
        let mut mesh = RawMesh::default();
        for i in 0..2000_u32 {
            let lift = f64::from(i) * 1.0e-9;
            mesh.positions.extend([
                Vec3::new(0.0, 0.0, lift),
                Vec3::new(1.0, 0.0, lift),
                Vec3::new(0.0, 1.0, lift),
            ]);
            mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
        }
        mesh
    }),
    ("scaled by 1e-6", || {
        let s = steps(-5.0e-5, 5.0e-5, 12);
        grid(&s, &s, |x, y| 1.0e4 * x * y)
    }),
];

fn built(name: &str, surface: &Surface) -> Box<dyn Partition> {
    let found = partition::all().iter().find(|(n, _)| *n == name);
    found.map_or_else(
        || Box::new(Brute) as Box<dyn Partition>,
        |(_, b)| b(surface),
    )
}

fn plate() -> Surface {
    let s = steps(-50.0, 50.0, 12);
    let made = Surface::new(grid(&s, &s, |x, y| 0.01 * x * y));
    made.unwrap_or_else(|_| unreachable!()).0
}

/// A place with one coordinate odd, or all.
fn odd_place(i: usize) -> Vec3 {
    let x = ODD[i % ODD.len()];
    match i / ODD.len() % 4 {
        0 => Vec3::new(x, 1.0, 2.0),
        1 => Vec3::new(1.0, x, 2.0),
        2 => Vec3::new(1.0, 2.0, x),
        _ => Vec3::splat(x),
    }
}

fn odd_questions(_: &Size, name: &str) -> Ended {
    let surface = plate();
    let search = built(name, &surface);
    let mut tally = Tally::default();
    let mut fault = None;
    let mut say = |words: String| {
        fault.get_or_insert(words);
    };
    let n = surface.triangles().len() as u32;
    for i in 0..4 * ODD.len() {
        let p = odd_place(i);
        for max_mm in [f64::INFINITY, f64::NAN, -1.0, 0.0, 1.0e3] {
            let near = search.nearest(&surface, p, max_mm);
            tally.answers += 1;
            if let Some(near) = near {
                tally.lengths(near.point.to_array());
                if !p.is_finite() || near.triangle >= n {
                    say(format!("{p} has a nearest triangle {}", near.triangle));
                }
                // Squares of 1e160 mm overflow.
                if p.abs().max_element() < 1.0e150 {
                    tally.numbers([near.distance_sq]);
                }
            }
        }
        for (from, to) in [(p, Vec3::ZERO), (Vec3::Z, p), (p, -p)] {
            for sides in Sides::all() {
                tally.answers += 1;
                if let Some(hit) = search.sweep(&surface, from, to, *sides) {
                    tally.numbers(hit.point.to_array());
                    tally.numbers([hit.t]);
                    let sound = from.is_finite() && to.is_finite();
                    if !(sound && (0.0..=1.0).contains(&hit.t)) {
                        say(format!("from {from} to {to} it hits at {}", hit.t));
                    }
                }
            }
        }
        for region in [
            Aabb {
                min: p,
                max: Vec3::ONE,
            },
            Aabb {
                min: -Vec3::ONE,
                max: p,
            },
            Aabb::cube(p, 1.0),
            Aabb::cube(Vec3::ZERO, p.x),
        ] {
            let mut found = Vec::new();
            search.in_box(&surface, &region, &mut found);
            tally.answers += 1;
            if !found.is_sorted() || found.last().is_some_and(|t| *t >= n) {
                say(format!("{region:?} lists {found:?}"));
            }
        }
    }
    let check = "nothing where a place is none, else a triangle there is";
    Ended::checked(tally, check, fault)
}

/// Held against brute force.
fn against_brute(size: &Size, name: &str, mesh: RawMesh) -> Ended {
    let surface = match Surface::new(mesh) {
        Ok((surface, _)) => surface,
        Err(why) => return Ended::refused(why),
    };
    let search = built(name, &surface);
    if let Err(why) = search.validate(&surface) {
        return Ended::wrong(why);
    }
    let mut tally = Tally::default();
    let mut stream = stream(size.seed, name);
    let bounds = surface.bounds();
    let (centre, half) = (bounds.centre(), bounds.size() / 2.0 + 1.0e-6);
    let place = |s: &mut Stream| {
        let far = [1.0, 1.0e-6, 30.0][(s.unit().abs() * 3.0) as usize % 3];
        centre + s.vector() * half * far
    };
    let mut worst = 0.0_f64;
    let mut fault = None;
    for _ in 0..(size.questions / 10).max(20) {
        let (p, q) = (place(&mut stream), place(&mut stream));
        let [a, b] =
            [&*search, &Brute as &dyn Partition].map(|s| s.nearest(&surface, p, f64::INFINITY));
        let (Some(a), Some(b)) = (a, b) else {
            fault.get_or_insert(format!("nothing is nearest to {p}"));
            continue;
        };
        let scale = b.distance_sq.sqrt() + p.length();
        worst = worst.max((a.distance_sq.sqrt() - b.distance_sq.sqrt()).abs() / scale);
        tally.lengths([a.distance_sq.sqrt()]);
        let [a, b] =
            [&*search, &Brute as &dyn Partition].map(|s| s.sweep(&surface, p, q, Sides::Front));
        if a.is_some() != b.is_some() {
            fault.get_or_insert(format!("from {p} to {q}: {a:?}, brute force {b:?}"));
        }
        if let (Some(a), Some(b)) = (a, b) {
            worst = worst.max((a.t - b.t).abs());
            tally.lengths(a.point.to_array());
        }
        let region = Aabb::of_points([p, q]);
        let lists = [&*search, &Brute as &dyn Partition].map(|s| {
            let mut out = Vec::new();
            s.in_box(&surface, &region, &mut out);
            out
        });
        let lacking = lists[1].iter().any(|t| {
            let meets = surface.triangle(*t).meets(&region);
            meets && lists[0].binary_search(t).is_err()
        });
        if lacking {
            fault.get_or_insert(format!("{region:?} lacks a triangle"));
        }
    }
    match fault {
        None => Ended::held(tally, "brute force, share of the distance", worst, 1.0e-12),
        fault => Ended::checked(tally, "", fault),
    }
}

fn odd_boxes(kind: &'static str) -> Ended {
    let surface = plate();
    let built = Structure::build(kind, &surface, &tree::Options::default(), &mut |_| true);
    let Ok(Some(structure)) = built else {
        return Ended::wrong(format!("no {kind}"));
    };
    let n = surface.triangles().len() as u32;
    let mut tally = Tally::default();
    let mut fault = None;
    for i in 0..4 * ODD.len() {
        let region = hdb::cube(&surface, odd_place(i));
        for query in [Query::Published, Query::Complete] {
            let mut found = Vec::new();
            structure.each(&surface, &region, query, |t| found.push(t));
            tally.answers += 1;
            if found.iter().any(|t| *t >= n) {
                fault.get_or_insert(format!("{region:?} names a triangle that is none"));
            }
            let none = !odd_place(i).is_finite();
            if none && query == Query::Complete && !found.is_empty() {
                fault.get_or_insert(format!("{region:?} holds {} triangles", found.len()));
            }
        }
    }
    Ended::checked(tally, "only triangles that there are", fault)
}

fn odd_triangles() -> Ended {
    let mut tally = Tally::default();
    let (o, x) = (Vec3::ZERO, Vec3::X);
    let tiny = Vec3::splat(5.0e-324);
    let shapes = [
        [o, o, o],
        [o, x, x],
        [o, x, x * 2.0],
        [o, o, x],
        [o, tiny, x],
        [o, x, x + Vec3::Y * 1.0e-300],
        [o, x * 1.0e-160, Vec3::Y * 1.0e-160],
        [o, x * 1.0e7, Vec3::Y * 1.0e7],
        [o, x, Vec3::Y],
    ];
    let mut fault = None;
    for [a, b, c] in shapes {
        let triangle = Triangle { a, b, c };
        for i in 0..4 * ODD.len() {
            let at = triangle.closest_point(odd_place(i));
            tally.lengths(at.point.to_array());
            tally.numbers(at.barycentric);
            let sum: f64 = at.barycentric.iter().sum();
            let share = at
                .barycentric
                .iter()
                .all(|w| (-1.0e-12..=1.0 + 1.0e-12).contains(w));
            if !share || (sum - 1.0).abs() > 1.0e-12 {
                fault.get_or_insert(format!(
                    "{triangle:?} at {}: weights {:?}",
                    odd_place(i),
                    at.barycentric
                ));
            }
            tally.numbers(triangle.normal().to_array());
            let hit = triangle.crossing(odd_place(i), -odd_place(i));
            if let Some(hit) = hit {
                tally.numbers(hit.barycentric);
                tally.numbers([hit.t]);
            }
        }
    }
    Ended::checked(
        tally,
        "a point of the triangle, weights that add up to 1",
        fault,
    )
}
