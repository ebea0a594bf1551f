//! What only octrees have: the triangles that the published rule loses.

use super::{Octree, Options, Partition};
use crate::geom::{Aabb, Vec3};
use crate::partition::brute::Brute;
use crate::partition::tree::worst_w;
use crate::surface::primitives::{bench_patch, icosphere, one_per_cell};
use crate::surface::{RawMesh, Surface};

fn surface(mesh: RawMesh) -> Surface {
    Surface::new(mesh).unwrap().0
}

fn with_threshold(surface: &Surface, threshold: usize) -> Octree {
    let options = Options {
        threshold,
        ..Options::default()
    };
    Octree::new(surface, &options)
}

/// One large triangle with a corner in each of three octants, and a small one in each of two others.
fn spanning_three_octants() -> Surface {
    let mut mesh = RawMesh {
        positions: vec![
            Vec3::new(-9.0, -8.0, -1.0),
            Vec3::new(9.0, -8.0, 3.0),
            Vec3::new(-2.0, 9.0, 2.0),
        ],
        triangles: vec![[0, 1, 2]],
    };
    for (i, at) in [Vec3::splat(-10.0), Vec3::splat(8.0)]
        .into_iter()
        .enumerate()
    {
        let small = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::splat(2.0)];
        mesh.positions.extend(small.map(|p| at + p));
        let first = 3 + 3 * i as u32;
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    surface(mesh)
}

/// Number of the large triangle: a surface numbers its triangles by where they are.
fn large(mesh: &Surface) -> u32 {
    let area = |t: &u32| mesh.triangle(*t).area_mm2();
    let all = 0..mesh.triangles().len() as u32;
    all.max_by(|a, b| area(a).total_cmp(&area(b))).unwrap()
}

#[test]
fn a_triangle_that_spans_three_octants_is_lost_as_published_and_kept_here() {
    let mesh = spanning_three_octants();
    let octree = with_threshold(&mesh, 1);
    let large = large(&mesh);
    assert_eq!(octree.lost_as_published(&mesh), [large]);
    assert_eq!(octree.statistics(&mesh).lost_as_published, 1);
    assert_eq!(octree.validate(&mesh), Ok(()));
    // Around each of its corners it is found.
    let t = mesh.triangle(large);
    for corner in [t.a, t.b, t.c] {
        let region = Aabb::cube(corner, 0.1);
        let mut found = Vec::new();
        octree.in_box(&mesh, &region, &mut found);
        assert!(found.contains(&large), "corner {corner}: {found:?}");
    }
}

#[test]
fn the_published_cells_miss_what_juts_out_and_the_loose_bounds_do_not() {
    let mesh = spanning_three_octants();
    let octree = with_threshold(&mesh, 1);
    let (mut published, mut ours, mut all) = (Vec::new(), Vec::new(), Vec::new());
    let large = large(&mesh);
    let region = Aabb::cube(mesh.triangle(large).a, 0.1);
    octree.gather_by_cells(&region, &mut published);
    octree.in_box(&mesh, &region, &mut ours);
    Brute.in_box(&mesh, &region, &mut all);
    assert!(!published.contains(&large), "{published:?}");
    assert_eq!(ours, all);
}

#[test]
fn a_sphere_loses_triangles_as_published_and_none_here() {
    let mesh = surface(icosphere(50.0, 3));
    let octree = with_threshold(&mesh, 8);
    assert!(!octree.lost_as_published(&mesh).is_empty());
    assert_eq!(octree.validate(&mesh), Ok(()));
    let mut all = Vec::new();
    octree.in_box(&mesh, &mesh.bounds(), &mut all);
    assert!(all.iter().copied().eq(0..mesh.triangles().len() as u32));
}

#[test]
fn one_leaf_of_a_complete_tree_costs_what_table_3_4_says() {
    let mesh = surface(one_per_cell([16, 16, 16]));
    for (threshold, height) in [(64, 2), (8, 3), (1, 4)] {
        let octree = with_threshold(&mesh, threshold);
        let s = octree.statistics(&mesh);
        assert_eq!((s.height, s.leaves), (height, 1 << (3 * height)));
        let mut found = Vec::new();
        let region = Aabb::cube(Vec3::splat(0.5), 0.1);
        let cost = octree.gather_by_cells(&region, &mut found);
        assert_eq!((cost.leaves, found.len()), (1, threshold));
        let w = cost.nodes as f64 / s.nodes as f64 * s.leaves as f64;
        assert!((w - worst_w(8, height)).abs() < 1e-12, "{height}: {w}");
    }
}

#[test]
fn a_broken_tree_is_told_apart() {
    let mesh = surface(bench_patch(600));
    let good = with_threshold(&mesh, 16);
    for fault in 0..4 {
        let mut bad = good.clone();
        bad.tree.damage(fault);
        assert!(bad.validate(&mesh).is_err(), "{fault}");
    }
}
