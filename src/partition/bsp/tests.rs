//! What only a BSP has: planes in turn, pieces, half-infinite outer leaves.

use super::{Bsp, Case, Options, Partition, axis};
use crate::geom::{Aabb, Vec3};
use crate::partition::tree::worst_w;
use crate::surface::primitives::{bench_patch, one_per_cell};
use crate::surface::{RawMesh, Surface};

fn surface(mesh: RawMesh) -> Surface {
    Surface::new(mesh).unwrap().0
}

#[test]
fn one_leaf_of_a_complete_tree_costs_what_table_3_3_says() {
    let mesh = surface(one_per_cell([8, 8, 8]));
    for (threshold, height) in [(64, 3), (32, 4), (8, 6), (1, 9)] {
        let case = Case::C;
        let bsp = Bsp::new(&mesh, &Options { threshold, case });
        let s = bsp.statistics(&mesh);
        assert_eq!((s.height, s.leaves), (height, 1 << height));
        let mut found = Vec::new();
        let region = Aabb::cube(Vec3::splat(0.5), 0.1);
        let cost = bsp.gather_by_half_spaces(&region, &mut found);
        assert_eq!((cost.leaves, found.len()), (1, threshold));
        let w = cost.nodes as f64 / s.nodes as f64 * s.leaves as f64;
        assert!((w - worst_w(2, height)).abs() < 1e-12, "{height}: {w}");
    }
}

#[test]
fn planes_turn_by_level_at_the_middle_of_the_cell() {
    let mesh = surface(bench_patch(2000));
    let bsp = Bsp::new(
        &mesh,
        &Options {
            threshold: 32,
            case: Case::C,
        },
    );
    let tree = bsp.tree();
    for node in tree.nodes().iter().filter(|n| !n.is_leaf()) {
        let k = axis(node.level);
        let middle = node.cell.centre()[k];
        let under: Vec<_> = tree
            .children(node)
            .map(|c| tree.nodes()[c as usize])
            .collect();
        assert_eq!(
            (under[0].cell.max[k], under[1].cell.min[k]),
            (middle, middle)
        );
    }
    assert_eq!([0, 1, 2, 3, 4].map(axis), [0, 1, 2, 0, 1]);
}

#[test]
fn outer_leaves_answer_from_far_by_half_spaces_and_not_by_bounds() {
    let mesh = surface(bench_patch(4000));
    let bsp = Bsp::new(
        &mesh,
        &Options {
            threshold: 64,
            case: Case::C,
        },
    );
    let far = Aabb::cube(mesh.bounds().max + 1000.0, 10.0);
    let (mut published, mut ours) = (Vec::new(), Vec::new());
    let cost = bsp.gather_by_half_spaces(&far, &mut published);
    bsp.in_box(&mesh, &far, &mut ours);
    assert!(!published.is_empty() && published.len() <= 64);
    assert_eq!(cost.triangles, published.len());
    assert!(ours.is_empty());
}

#[test]
fn in_case_a_half_spaces_find_every_piece_in_the_box() {
    let mesh = surface(bench_patch(1000));
    let bsp = Bsp::new(
        &mesh,
        &Options {
            threshold: 16,
            case: Case::A,
        },
    );
    let region = Aabb::cube(mesh.bounds().centre(), 120.0);
    let mut found = Vec::new();
    bsp.gather_by_half_spaces(&region, &mut found);
    let meeting = bsp
        .pieces()
        .filter(|(_, corners)| Aabb::of_points(*corners).overlaps(&region));
    for (triangle, _) in meeting {
        assert!(found.binary_search(&triangle).is_ok(), "{triangle}");
    }
}

#[test]
fn a_cut_triangle_becomes_three_and_keeps_its_number() {
    let mesh = surface(RawMesh {
        positions: vec![
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(4.0, 0.0, 0.0),
            Vec3::new(1.0, 3.0, 0.0),
            Vec3::new(0.0, 5.0, 0.0),
            Vec3::new(1.0, 5.0, 0.0),
            Vec3::new(0.0, 6.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [3, 4, 5]],
    });
    let bsp = Bsp::new(
        &mesh,
        &Options {
            threshold: 3,
            case: Case::A,
        },
    );
    assert_eq!(bsp.statistics(&mesh).entries, 2);
    let bsp = Bsp::new(
        &mesh,
        &Options {
            threshold: 1,
            case: Case::A,
        },
    );
    // The plane x = 2 cuts the large triangle in a triangle and a quadrangle, of which y = 3 cuts off nothing.
    let of_first = bsp.pieces().filter(|(t, _)| *t == 0).count();
    assert!(of_first >= 3, "{of_first}");
    assert_eq!(bsp.validate(&mesh), Ok(()));
}

#[test]
fn a_broken_tree_is_told_apart() {
    let mesh = surface(bench_patch(600));
    for case in [Case::A, Case::B, Case::C] {
        let good = Bsp::new(
            &mesh,
            &Options {
                threshold: 16,
                case,
            },
        );
        assert_eq!(good.validate(&mesh), Ok(()));
        for fault in 0..4 {
            let mut bad = good.clone();
            bad.tree.damage(fault);
            assert!(bad.validate(&mesh).is_err(), "{case:?} {fault}");
        }
    }
    let mut bad = Bsp::new(
        &mesh,
        &Options {
            threshold: 16,
            case: Case::A,
        },
    );
    let at = (bad.pieces.iter())
        .position(|p| p.area_mm2() > 1.0)
        .unwrap();
    bad.pieces[at].corners[0] = bad.pieces[at].corners[1];
    assert!(bad.validate(&mesh).unwrap_err().contains("pieces"));
}
