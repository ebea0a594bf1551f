//! The ring search against its definition: everything inside the outline that hangs together with the start triangle.

use dorsum::deform::footprint::{Ellipse, Outline, Polar, PrintedEllipse};
use dorsum::deform::{Patches, RingSearch};
use dorsum::geom::Vec3;
use dorsum::surface::{RIM, RawMesh, Surface};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::f64::consts::PI;

/// Grows from the start triangle over a table of who touches whom, one triangle at a time: slow and by definition.
fn by_definition(surface: &Surface, outline: &impl Outline, start: u32) -> BTreeSet<u32> {
    let p = surface.positions();
    let inside: Vec<bool> = p.iter().map(|p| outline.ratio(*p) < 1.0).collect();
    let triangles = surface.triangles();
    let mut at_corner = vec![Vec::new(); p.len()];
    for (t, corners) in triangles.iter().enumerate() {
        for &v in corners {
            at_corner[v as usize].push(t);
        }
    }
    let mut reached = BTreeSet::from([start as usize]);
    let mut waiting = vec![start as usize];
    while let Some(t) = waiting.pop() {
        let mut joined: Vec<usize> = Vec::new();
        for (edge, &v) in triangles[t].iter().enumerate() {
            if inside[v as usize] {
                joined.extend(&at_corner[v as usize]);
            }
            let to = triangles[t][(edge + 1) % 3];
            let across = surface.topology().across(t as u32)[edge];
            if across != RIM && outline.reaches(p[v as usize], p[to as usize]) {
                joined.push(across as usize);
            }
        }
        for u in joined {
            if reached.insert(u) {
                waiting.push(u);
            }
        }
    }
    let corners = reached.iter().flat_map(|&t| triangles[t]);
    corners.filter(|&v| inside[v as usize]).collect()
}

/// The triangle whose middle is nearest to a place.
fn triangle_at(surface: &Surface, place: Vec3) -> u32 {
    let to = |t: &u32| surface.triangle(*t).centroid().distance_squared(place);
    (0..surface.triangles().len() as u32)
        .min_by(|a, b| to(a).total_cmp(&to(b)))
        .expect("a triangle")
}

/// What a sheet is bent into.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Hills,
    Fold,
    Tube,
    TwoSheets,
}

#[derive(Clone, Debug)]
struct Case {
    shape: Shape,
    cells: usize,
    jitter: Vec<[f64; 3]>,
    holes: Vec<bool>,
    start: prop::sample::Index,
    weights: [f64; 2],
    half_axes: [f64; 2],
    angle_rad: f64,
}

fn cases() -> impl Strategy<Value = Case> {
    let shape = prop_oneof![
        Just(Shape::Hills),
        Just(Shape::Fold),
        Just(Shape::Tube),
        Just(Shape::TwoSheets)
    ];
    (shape, prop_oneof![3..10_usize, 10..40_usize]).prop_flat_map(|(shape, cells)| {
        (
            prop::collection::vec(
                prop::array::uniform3(-0.4..0.4_f64),
                (cells + 1) * (cells + 1),
            ),
            prop::collection::vec(prop::bool::weighted(0.12), 2 * cells * cells),
            any::<prop::sample::Index>(),
            prop::array::uniform2(0.0..0.5_f64),
            prop::array::uniform2(0.05..7.0_f64),
            0.0..PI,
        )
            .prop_map(
                move |(jitter, holes, start, weights, half_axes, angle_rad)| Case {
                    shape,
                    cells,
                    jitter,
                    holes,
                    start,
                    weights,
                    half_axes,
                    angle_rad,
                },
            )
    })
}

fn surface_of(case: &Case) -> Option<Surface> {
    let n = case.cells;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (s, y) = (i as f64 - n as f64 / 2.0, j as f64);
            let p = match case.shape {
                Shape::Hills => Vec3::new(s, y, (1.3 * s).sin() + y.cos()),
                Shape::Fold => Vec3::new(s.abs(), y, 0.3 * s.signum()),
                Shape::Tube => {
                    let phi = 1.8 * PI * i as f64 / n as f64;
                    Vec3::new(1.5 * phi.cos(), y, 1.5 * phi.sin())
                }
                Shape::TwoSheets => {
                    let second = usize::from(2 * i > n) as f64;
                    Vec3::new(s - second * n as f64 / 2.0, y, -0.5 * second)
                }
            };
            mesh.positions
                .push(p + Vec3::from(case.jitter[j * (n + 1) + i]) * 0.8);
        }
    }
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    for j in 0..n {
        for i in 0..n {
            if matches!(case.shape, Shape::TwoSheets) && 2 * i <= n && 2 * (i + 1) > n {
                continue;
            }
            let two = [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ];
            for (k, t) in two.into_iter().enumerate() {
                if !case.holes[2 * (j * n + i) + k] {
                    mesh.triangles.push(t);
                }
            }
        }
    }
    Surface::new(mesh).ok().map(|(surface, _)| surface)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn the_search_finds_what_hangs_together_and_nothing_else(
        first in cases(),
        others in prop::collection::vec((any::<prop::sample::Index>(), prop::array::uniform2(0.05..7.0_f64)), 3),
    ) {
        let surface = surface_of(&first);
        prop_assume!(surface.is_some());
        let Some(surface) = surface else { return Ok(()) };
        let patches = Patches::new(&surface);
        let mut search = RingSearch::default();
        let mut steps = vec![(first.start, first.half_axes)];
        steps.extend(others);
        for (start, [a, b]) in steps {
            let start = start.index(surface.triangles().len()) as u32;
            let t = surface.triangle(start);
            let [u, v] = first.weights;
            let anchor = t.at([1.0 - u - v, u, v]);
            let size = first.cells as f64 / 9.0;
            let (n, angle, a, b) = (t.normal(), first.angle_rad, a * size, b * size);
            let radii: Vec<f64> = (0..12).map(|i| if i % 3 == 0 { a } else { b }).collect();
            let ellipse = Ellipse::new(anchor, n, a, b, angle);
            let printed = PrintedEllipse::new(anchor, n, a.max(b), a.min(b), angle);
            let polar = Polar::new(anchor, n, &radii);
            let (Some(ellipse), Some(printed), Some(polar)) = (ellipse, printed, polar) else { continue };
            finds(&surface, &patches, &mut search, &ellipse, start)?;
            finds(&surface, &patches, &mut search, &printed, start)?;
            finds(&surface, &patches, &mut search, &polar, start)?;
        }
    }
}

/// The search finds the set by definition, twice in the same order.
fn finds(
    surface: &Surface,
    patches: &Patches,
    search: &mut RingSearch,
    outline: &impl Outline,
    start: u32,
) -> Result<(), TestCaseError> {
    search.search(surface, patches, outline, start);
    let order: Vec<u32> = search.vertices().collect();
    let found: BTreeSet<u32> = order.iter().copied().collect();
    prop_assert_eq!(found.len(), order.len(), "no vertex twice");
    prop_assert_eq!(&found, &by_definition(surface, outline, start));
    search.search(surface, patches, outline, start);
    prop_assert!(search.vertices().eq(order), "the same order every time");
    Ok(())
}

#[test]
fn a_footprint_smaller_than_its_triangle_finds_nothing_or_the_corner_across_the_edge() {
    // Two flat triangles that share the long edge y = 0.
    let mesh = RawMesh {
        positions: vec![
            Vec3::new(-50.0, 0.0, 0.0),
            Vec3::new(50.0, 0.0, 0.0),
            Vec3::new(0.0, 40.0, 0.0),
            Vec3::new(0.0, -5.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [1, 0, 3]],
    };
    let skin = Surface::new(mesh).expect("a sound mesh").0;
    let patches = Patches::new(&skin);
    let mut search = RingSearch::default();
    let upper = triangle_at(&skin, Vec3::Y * 10.0);
    let mut found = |y: f64, radius: f64| {
        let centre = Vec3::new(0.0, y, 0.0);
        let circle = Ellipse::new(centre, Vec3::Z, radius, radius, 0.0).unwrap();
        search.search(&skin, &patches, &circle, upper);
        search
            .vertices()
            .map(|v| skin.positions()[v as usize])
            .collect::<Vec<_>>()
    };
    assert!(found(10.0, 5.0).is_empty());
    assert!(
        found(2.0, 6.0).is_empty(),
        "past the edge, short of the corner"
    );
    assert_eq!(found(2.0, 8.0), [Vec3::new(0.0, -5.0, 0.0)]);
}

/// A disc whose hub has more neighbours than a patch can number.
fn wheel(spokes: u32) -> Surface {
    let mut mesh = RawMesh {
        positions: vec![Vec3::ZERO],
        ..RawMesh::default()
    };
    for radius in [5.0, 6.0] {
        for i in 0..spokes {
            let phi = 2.0 * PI * f64::from(i) / f64::from(spokes);
            mesh.positions.push(Vec3::new(
                radius * phi.cos(),
                radius * phi.sin(),
                radius * 0.2,
            ));
        }
    }
    for i in 0..spokes {
        let next = (i + 1) % spokes;
        let (a, b) = (1 + i, 1 + next);
        mesh.triangles.push([0, a, b]);
        mesh.triangles.push([a, a + spokes, b + spokes]);
        mesh.triangles.push([a, b + spokes, b]);
    }
    Surface::new(mesh).expect("a sound mesh").0
}

#[test]
fn a_hub_with_hundreds_of_spokes_hangs_together_with_all_of_them() {
    let skin = wheel(300);
    let patches = Patches::new(&skin);
    let mut search = RingSearch::default();
    let start = triangle_at(&skin, Vec3::X * 3.0);
    for (centre, radius) in [
        (Vec3::ZERO, 1.0),
        (Vec3::ZERO, 5.5),
        (Vec3::ZERO, 9.0),
        (Vec3::X * 4.0, 4.5),
        (Vec3::X * 5.5, 1.0),
    ] {
        let circle = Ellipse::new(centre, Vec3::Z, radius, radius, 0.0).unwrap();
        search.search(&skin, &patches, &circle, start);
        let found: BTreeSet<u32> = search.vertices().collect();
        let expected = by_definition(&skin, &circle, start);
        assert_eq!(found, expected, "{centre} {radius}");
    }
}
