//! What only the hybrid has: one list.

use super::{Hybrid, Options, Partition};
use crate::geom::Aabb;
use crate::partition::octree::Octree;
use crate::surface::Surface;
use crate::surface::primitives::bench_patch;

const OPTIONS: Options = Options {
    threshold: 16,
    case: crate::partition::tree::Case::C,
};

fn patch() -> Surface {
    Surface::new(bench_patch(2000)).unwrap().0
}

#[test]
fn it_is_the_octree_in_fewer_bytes() {
    let mesh = patch();
    let (octree, hybrid) = (Octree::new(&mesh, &OPTIONS), Hybrid::new(&mesh, &OPTIONS));
    let pairs = octree.tree().nodes().iter().zip(hybrid.tree().nodes());
    for (a, b) in pairs {
        assert_eq!((a.cell, a.bounds, a.held), (b.cell, b.bounds, b.held));
        assert_eq!(octree.tree().held(a), hybrid.tree().held(b));
    }
    assert!(hybrid.bytes() < octree.bytes());
}

#[test]
fn a_node_inside_the_box_answers_without_its_children() {
    let mesh = patch();
    let (octree, hybrid) = (Octree::new(&mesh, &OPTIONS), Hybrid::new(&mesh, &OPTIONS));
    let region = Aabb::cube(mesh.bounds().centre(), 250.0);
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let apart = octree.tree().gather(&mesh, &region, &mut a);
    let one = hybrid.tree().gather(&mesh, &region, &mut b);
    assert_eq!(a, b);
    assert!(one.nodes < apart.nodes, "{one:?} {apart:?}");
}

#[test]
fn a_broken_tree_is_told_apart() {
    let mesh = patch();
    let good = Hybrid::new(&mesh, &OPTIONS);
    for fault in 0..4 {
        let mut bad = good.clone();
        bad.tree.damage(fault);
        assert!(bad.validate(&mesh).is_err(), "{fault}");
    }
}
