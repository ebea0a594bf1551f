//! The checker that every test calls after every build.

use super::build::outward;
use super::{Bvh, Child, SPARE_LEVELS, STACK, unpack};
use crate::surface::Surface;

/// Parents bound their children, leaves bound their triangles, every node and every triangle is there exactly once, and
/// no query can need more stack than there is.
pub(super) fn validate(bvh: &Bvh, surface: &Surface) -> Result<(), String> {
    let n = surface.triangles().len();
    if bvh.order.len() != n {
        return Err(format!("holds {} of {n} triangles", bvh.order.len()));
    }
    let mut node_seen = vec![false; bvh.nodes.len()];
    let mut triangle_seen = vec![false; n];
    let most_levels = (usize::BITS - (n.max(1) - 1).leading_zeros() + SPARE_LEVELS).div_ceil(2);
    let mut open = if n > 0 { vec![(0_u32, 1_u32)] } else { vec![] };
    while let Some((at, depth)) = open.pop() {
        let node = bvh
            .nodes
            .get(at as usize)
            .ok_or_else(|| format!("node {at} does not exist"))?;
        if std::mem::replace(&mut node_seen[at as usize], true) {
            return Err(format!("node {at} has two parents"));
        }
        if depth > most_levels || 3 * depth as usize + 1 > STACK {
            return Err(format!(
                "node {at} lies {depth} deep; at most {most_levels}"
            ));
        }
        for i in 0..4 {
            let holds = |min: [f32; 3], max: [f32; 3]| {
                (0..3).all(|k| node.min[k][i] <= min[k] && max[k] <= node.max[k][i])
            };
            match unpack(node.child[i]) {
                Child::None => {}
                Child::Node(child) => {
                    let inner = bvh
                        .nodes
                        .get(child as usize)
                        .ok_or_else(|| format!("node {at} names node {child}"))?;
                    for j in 0..4 {
                        let min = [0, 1, 2].map(|k| inner.min[k][j]);
                        let max = [0, 1, 2].map(|k| inner.max[k][j]);
                        if !matches!(unpack(inner.child[j]), Child::None) && !holds(min, max) {
                            return Err(format!("node {at} does not bound its child {child}"));
                        }
                    }
                    open.push((child, depth + 1));
                }
                Child::Leaf(start, count) => {
                    let Some(held) = bvh.order.get(start..start + count) else {
                        return Err(format!("a leaf of node {at} ends past the last triangle"));
                    };
                    for &triangle in held {
                        let seen = triangle_seen
                            .get_mut(triangle as usize)
                            .ok_or_else(|| format!("triangle {triangle} does not exist"))?;
                        if std::mem::replace(seen, true) {
                            return Err(format!("triangle {triangle} is held twice"));
                        }
                        let (min, max) = outward(bvh.frame, surface, triangle);
                        if !holds(min, max) {
                            return Err(format!("node {at} does not bound triangle {triangle}"));
                        }
                    }
                }
            }
        }
    }
    if let Some(lost) = triangle_seen.iter().position(|&seen| !seen) {
        return Err(format!("triangle {lost} is in no leaf"));
    }
    match node_seen.iter().position(|&seen| !seen) {
        Some(lost) => Err(format!("node {lost} has no parent")),
        None => Ok(()),
    }
}
