//! Finds the pieces of a mesh and makes each of them face one way: outward, or out of the back.

use super::{Defect, Edge, Element, Found, Sheet};
use crate::geom::{Triangle, Vec3};
use crate::surface::RIM;
use crate::surface::edges::ends;
use crate::surface::topology::Bits;

/// An open piece whose area vectors add up to less than this part of its area has no side that faces +z: it is nearly
/// closed (a torso with open neck) or stands upright.
const FACING_SHARE: f64 = 0.1;

/// Volume over area^1.5 from which a piece counts as bulging to one side; a ball has 0.094.
const BULGING: f64 = 0.002;

/// A piece in which all triangles are joined across edges.
#[derive(Clone, Debug, Default)]
pub(super) struct Piece {
    pub triangles: usize,
    pub rim_edges: usize,
    pub area_mm2: f64,
    /// First triangle, as numbered now.
    first: u32,
    /// How many triangles have to turn to agree with the first.
    turned: usize,
    /// Sum of area times outward normal, mm².
    vector: Vec3,
    /// Sum of area times place relative to a vertex of the first triangle, mm³.
    moment: Vec3,
    /// Signed volume of the cone from that vertex over the piece, mm³.
    volume: f64,
}

/// Which piece every triangle belongs to, and the pieces in order of their first triangle.
#[derive(Default)]
pub(super) struct Pieces {
    pub of: Vec<u32>,
    pub list: Vec<Piece>,
}

/// Turns triangles so that every piece is consistent and faces outward, cutting where that is impossible.
///
/// `crooked` tells whether any two joined triangles run their edge the same way. The ends of edges cut are appended to
/// `cut_ends`.
pub(super) fn orient(
    sheet: &mut Sheet,
    crooked: bool,
    cut_ends: &mut Vec<u32>,
    defects: &mut Vec<Defect>,
) -> Pieces {
    let (mut pieces, turned) = find_pieces(sheet, crooked, cut_ends, defects);
    measure(sheet, &turned, &mut pieces);
    let mut flipped = Found::default();
    let (mut inside_out, mut inward) = (Found::default(), Found::default());
    let turns: Vec<(bool, bool)> = (pieces.list.iter())
        .map(|piece| {
            let minority_is_rest = piece.turned * 2 > piece.triangles;
            let turn = must_turn(piece, if minority_is_rest { -1.0 } else { 1.0 });
            (minority_is_rest, turn)
        })
        .collect();
    for (piece, &(_, turn)) in pieces.list.iter().zip(&turns) {
        if turn {
            let kind: &mut Found<Element> = if piece.rim_edges == 0 {
                &mut inside_out
            } else {
                &mut inward
            };
            kind.add(|| sheet.named(piece.first));
        }
    }
    if turned.any() || turns.iter().any(|&(rest, turn)| rest || turn) {
        for t in 0..sheet.triangles.len() {
            let (minority_is_rest, turn) = turns[pieces.of[t] as usize];
            let against = turned.get(t) != minority_is_rest;
            if against {
                flipped.add(|| sheet.named(t as u32));
            }
            if against != turn {
                sheet.triangles[t].swap(1, 2);
                sheet.across[t].swap(0, 2);
            }
        }
    }
    defects.extend(flipped.told(Defect::FlippedTriangles));
    defects.extend(inside_out.told(Defect::InsideOut));
    defects.extend(inward.told(Defect::FacingInward));
    pieces
}

/// Whether a piece, whose sums hold for the orientation `sign`, faces the wrong way.
fn must_turn(piece: &Piece, sign: f64) -> bool {
    let area = piece.area_mm2;
    // Volume seen from the piece's own middle: else it would depend on the vertex chosen wherever there is a rim.
    let volume = piece.volume - (piece.moment / area).dot(piece.vector) / 3.0;
    if piece.rim_edges == 0 {
        volume * sign < 0.0
    } else if piece.vector.z.abs() >= FACING_SHARE * area {
        piece.vector.z * sign < 0.0
    } else if volume.abs() >= BULGING * area * area.sqrt() {
        volume * sign < 0.0
    } else {
        false
    }
}

/// Breadth first, so that a cut through a piece without a second side is short.
fn find_pieces(
    sheet: &mut Sheet,
    crooked: bool,
    cut_ends: &mut Vec<u32>,
    defects: &mut Vec<Defect>,
) -> (Pieces, Bits) {
    const UNKNOWN: u32 = u32::MAX;
    let n = sheet.triangles.len();
    let mut pieces = Pieces {
        of: vec![UNKNOWN; n],
        list: Vec::new(),
    };
    let mut turned = Bits::new(n);
    let mut queue = Vec::new();
    let mut cut = Found::default();
    for seed in 0..n as u32 {
        if pieces.of[seed as usize] != UNKNOWN {
            continue;
        }
        let label = pieces.list.len() as u32;
        let mut piece = Piece {
            first: seed,
            ..Piece::default()
        };
        pieces.of[seed as usize] = label;
        queue.clear();
        queue.push(seed);
        while let Some(&t) = queue.get(piece.triangles) {
            piece.triangles += 1;
            piece.turned += usize::from(turned.get(t as usize));
            for i in 0..3 {
                let u = sheet.across[t as usize][i];
                if u == RIM {
                    piece.rim_edges += 1;
                    continue;
                }
                let known = pieces.of[u as usize] != UNKNOWN;
                if known && !crooked {
                    continue;
                }
                let j = sheet.edge_to(u, t);
                let twist = crooked && sheet.from(t, i) == sheet.from(u, j);
                let turn = turned.get(t as usize) != twist;
                if !known {
                    pieces.of[u as usize] = label;
                    queue.push(u);
                    if turn {
                        turned.set(u as usize);
                    }
                } else if turned.get(u as usize) != turn {
                    let half = 3 * t + i as u32;
                    cut.add(|| sheet.named_edge(half, 2));
                    cut_ends.extend(&ends(&sheet.triangles, half)[..2]);
                    sheet.across[t as usize][i] = RIM;
                    sheet.across[u as usize][j] = RIM;
                    // The other side counts its half when its turn comes, or has passed this edge already.
                    piece.rim_edges += 1;
                }
            }
        }
        pieces.list.push(piece);
    }
    defects.extend(cut.told(Defect::NonOrientable));
    (pieces, turned)
}

fn measure(sheet: &Sheet, turned: &Bits, pieces: &mut Pieces) {
    for (t, &label) in pieces.of.iter().enumerate() {
        let piece = &mut pieces.list[label as usize];
        let from = sheet.positions[sheet.triangles[piece.first as usize][0] as usize];
        let Triangle { a, b, c } = sheet.triangle(t as u32);
        let (a, b, c) = (a - from, b - from, c - from);
        let mut vector = (b - a).cross(c - a) / 2.0;
        let area = vector.length();
        if turned.get(t) {
            vector = -vector;
        }
        piece.area_mm2 += area;
        piece.vector += vector;
        piece.moment += (a + b + c) / 3.0 * area;
        piece.volume += a.dot(vector) / 3.0;
    }
}

impl Sheet {
    /// Which edge of triangle `u` leads to triangle `t`. No two triangles share two edges, for they would be doubles.
    pub(super) fn edge_to(&self, u: u32, t: u32) -> usize {
        let over = self.across[u as usize];
        (0..3).find(|&j| over[j] == t).unwrap_or(0)
    }

    fn from(&self, t: u32, i: usize) -> u32 {
        self.triangles[t as usize][i]
    }

    /// Edge of `half` in the numbering of the mesh handed in.
    pub(super) fn named_edge(&self, half: u32, triangles: usize) -> Edge {
        let [a, b, _] = ends(&self.triangles, half);
        let middle = (self.positions[a as usize] + self.positions[b as usize]) / 2.0;
        let mut vertices = [a, b].map(|v| self.vertex_ids[v as usize] as usize);
        vertices.sort_unstable();
        Edge {
            vertices,
            triangles,
            at_mm: middle.to_array(),
        }
    }
}
