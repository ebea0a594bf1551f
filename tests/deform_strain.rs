//! Strain of the drawn skin against closed forms and against all vertices computed anew.

use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::strain::Strain;
use dorsum::deform::{Displacement, Model as _, Press};
use dorsum::geom::{Vec3, any_tangent};
use dorsum::surface::{RawMesh, Surface};
use proptest::prelude::*;

/// A sheet of n × n cells of 5 mm, one triangle left out, lifted by `height`.
fn sheet(n: usize, height: impl Fn(f64, f64) -> f64) -> Surface {
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (i as f64 * 5.0, j as f64 * 5.0);
            mesh.positions.push(Vec3::new(x, y, height(x, y)));
        }
    }
    let at = |i: usize, j: usize| (j * (n + 1) + i) as u32;
    for j in 0..n {
        for i in 0..n {
            mesh.triangles
                .push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles
                .push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh.triangles.remove(n * n);
    Surface::new(mesh).expect("a sound mesh").0
}

fn waves(n: usize) -> Surface {
    sheet(n, |x, y| 9.0 * (x / 17.0).sin() + 6.0 * (y / 11.0).cos())
}

/// Every vertex put where `to` says.
fn moved_by(surface: &Surface, to: impl Fn(Vec3) -> Vec3) -> Displacement {
    let mut out = Displacement::at_rest(surface);
    for (v, &p) in surface.positions().iter().enumerate() {
        out.put(v as u32, to(p) - p, surface.normals()[v]);
    }
    out
}

fn press(surface: &Surface, triangle: u32, depth_mm: f64, pull_mm: f64) -> Press {
    let t = surface.triangle(triangle);
    let anchor_mm = t.centroid();
    Press {
        anchor_mm,
        foot_mm: anchor_mm + any_tangent(t.normal()) * pull_mm,
        normal: t.normal(),
        depth_mm,
        triangle,
        ..Press::default()
    }
}

fn model() -> Fsmd {
    Fsmd::new(Settings {
        half_major_mm: 40.0,
        half_minor_mm: 25.0,
        ..Settings::default()
    })
}

#[test]
fn drawing_a_sheet_out_alike_everywhere_gives_just_that() {
    let skin = waves(12);
    for stretch in [1.25, 0.5, 1.0 + 1e-6] {
        let out = moved_by(&skin, |p| p * stretch);
        for &strain in Strain::new(&skin, &out).values() {
            assert!((strain - (stretch - 1.0)).abs() < 1e-13, "{strain}");
        }
    }
}

#[test]
fn drawing_out_along_x_counts_each_edge_by_its_direction() {
    let skin = sheet(12, |_, _| 0.0);
    let out = moved_by(&skin, |p| Vec3::new(1.2 * p.x, p.y, p.z));
    let strain = Strain::new(&skin, &out);
    // Inside: two edges along x, two along y, two across a cell.
    let across = ((1.44_f64 + 1.0) / 2.0).sqrt() - 1.0;
    let expected = (2.0 * 0.2 + 2.0 * across) / 6.0;
    let mut inside = 0;
    for (v, strain) in strain.values().iter().enumerate() {
        if skin.topology().triangles_of(v as u32).len() == 6 {
            inside += 1;
            assert!((strain - expected).abs() < 1e-14);
        }
    }
    assert!(inside > 80);
}

#[test]
fn a_rigid_motion_is_no_strain() {
    let skin = waves(12);
    let (s, c) = 0.7_f64.sin_cos();
    let turned = |p: Vec3| Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
    let out = moved_by(&skin, |p| turned(p) + Vec3::new(3.0, -20.0, 8.0));
    for &strain in Strain::new(&skin, &out).values() {
        assert!(strain.abs() < 1e-13, "{strain}");
    }
}

#[test]
fn one_vertex_strains_itself_and_its_neighbours_alone() {
    let skin = waves(12);
    let mut out = Displacement::at_rest(&skin);
    let mut strain = Strain::new(&skin, &out);
    assert_eq!(strain.touched().count(), 0);
    let v = 70;
    out.put(v, Vec3::new(1.0, 0.5, -2.0), skin.normals()[v as usize]);
    strain.update(&skin, &out);
    let mut near: Vec<u32> = skin.topology().neighbours(v).to_vec();
    near.push(v);
    near.sort_unstable();
    let mut touched: Vec<u32> = strain.touched().collect();
    touched.sort_unstable();
    assert_eq!(touched, near);
    for (i, strain) in strain.values().iter().enumerate() {
        assert_eq!(*strain != 0.0, near.contains(&(i as u32)));
    }
    strain.update(&skin, &out);
    assert_eq!(strain.touched().count(), 0, "nothing new");
}

#[test]
fn an_edge_without_length_is_left_out() {
    let tiny = 1e-160;
    let mesh = RawMesh {
        positions: vec![
            Vec3::ZERO,
            Vec3::X * tiny,
            Vec3::new(4.0, 3.0, 0.0),
            Vec3::new(-4.0, 3.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    // Validation may take such a sliver out; whatever it leaves must have finite strain.
    let Ok((skin, _)) = Surface::new(mesh) else {
        return;
    };
    let out = moved_by(&skin, |p| p * 2.0 + Vec3::new(p.y, 0.0, p.x * p.x));
    assert!(
        Strain::new(&skin, &out)
            .values()
            .iter()
            .all(|s| s.is_finite())
    );
}

#[test]
fn another_surface_or_a_missed_update_makes_it_anew() {
    let (skin, other) = (waves(12), waves(7));
    let mut out = Displacement::at_rest(&skin);
    let mut strain = Strain::new(&skin, &out);
    let mut model = model();
    for t in [20, 150, 90] {
        model.update(&skin, &[press(&skin, t, 5.0, 4.0)], &mut out);
    }
    strain.update(&skin, &out);
    assert_eq!(strain.values(), Strain::new(&skin, &out).values());
    let at_rest = Displacement::at_rest(&other);
    strain.update(&other, &at_rest);
    assert_eq!(strain.values(), vec![0.0; other.positions().len()]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn following_the_updates_equals_all_vertices_anew(
        steps in prop::collection::vec(
            prop::collection::vec((0..1560_u32, 0.0..12.0_f64, -20.0..20.0_f64), 0..3), 1..8),
    ) {
        let skin = waves(28);
        let mut model = model();
        let mut out = Displacement::at_rest(&skin);
        let mut strain = Strain::new(&skin, &out);
        for (i, step) in steps.iter().enumerate() {
            let presses: Vec<Press> = step.iter().map(|&(t, d, p)| press(&skin, t, d, p)).collect();
            let before = strain.values().to_vec();
            // In the pass of the model, after it, or both.
            if i % 2 == 0 {
                model.update_strained(&skin, &presses, &mut out, &mut strain);
            } else {
                model.update(&skin, &presses, &mut out);
            }
            if i % 4 != 0 {
                strain.update(&skin, &out);
            }
            let anew = Strain::new(&skin, &out);
            let bits = |s: &Strain| s.values().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&strain), bits(&anew));
            let mut touched: Vec<u32> = strain.touched().collect();
            touched.sort_unstable();
            let changed: Vec<u32> = (0..before.len() as u32)
                .filter(|&v| before[v as usize] != strain.values()[v as usize])
                .collect();
            prop_assert_eq!(touched, changed);
            for (v, &value) in strain.values().iter().enumerate() {
                let by_definition = mean_stretch(&skin, &out, v as u32);
                prop_assert!((value - by_definition).abs() < 1e-14, "{} {}", value, by_definition);
            }
        }
    }
}

/// Equations 4.19 and 4.20 the long way.
fn mean_stretch(surface: &Surface, out: &Displacement, v: u32) -> f64 {
    let rest = surface.positions();
    let neighbours = surface.topology().neighbours(v);
    let stretch = |&k: &u32| {
        let now = out.position(surface, k).distance(out.position(surface, v));
        let before = rest[k as usize].distance(rest[v as usize]);
        (now - before) / before
    };
    neighbours.iter().map(stretch).sum::<f64>() / neighbours.len() as f64
}
