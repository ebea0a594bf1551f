//! The checker: a tree of halved cells, each leaf holding what its case says.

use super::{Bsp, halves};
use crate::partition::tree::{self, Case, Ownership};
use crate::surface::Surface;

pub(super) fn validate(bsp: &Bsp, surface: &Surface) -> Result<(), String> {
    let ownership = match bsp.case {
        Case::A | Case::B => Ownership::Several,
        Case::C => Ownership::One,
    };
    let tree = &bsp.tree;
    tree.check(surface, halves, ownership, bsp.case == Case::B)?;
    let mut piece = bsp.pieces.iter();
    for (at, leaf) in tree.nodes().iter().enumerate() {
        for &t in tree.held(leaf) {
            let corners = surface.triangle(t);
            let fits = match bsp.case {
                Case::A => piece.next().is_some_and(|p| {
                    p.triangle == t && p.corners.iter().all(|&c| leaf.cell.contains(c))
                }),
                Case::B => corners.aabb().overlaps(&leaf.cell),
                Case::C => leaf
                    .cell
                    .contains(tree::median([corners.a, corners.b, corners.c])),
            };
            if !fits {
                return Err(format!("triangle {t} does not belong in leaf {at}"));
            }
        }
    }
    match bsp.case {
        Case::A => pieces_cover(bsp, surface),
        Case::B | Case::C => Ok(()),
    }
}

/// The pieces of a triangle together have its area, to rounding.
fn pieces_cover(bsp: &Bsp, surface: &Surface) -> Result<(), String> {
    let mut area = vec![0.0; surface.triangles().len()];
    for piece in &bsp.pieces {
        area[piece.triangle as usize] += piece.area_mm2();
    }
    let reach = bsp.tree.reach_mm();
    for (t, found) in area.into_iter().enumerate() {
        let triangle = surface.triangle(t as u32);
        let whole = triangle.area_mm2();
        let allowed = 1e-9 * whole + 1e-13 * reach * triangle.aabb().diagonal_mm();
        if (found - whole).abs() > allowed {
            return Err(format!(
                "the pieces of triangle {t} have {found} mm² of {whole} mm²"
            ));
        }
    }
    Ok(())
}
