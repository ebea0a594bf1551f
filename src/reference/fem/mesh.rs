//! The slab of soft tissue between skin and bone, cut into bricks.

use crate::geom::Vec3;

/// Bricks in columns under a grid of skin points: `columns` × `rows` points, `layers` bricks down to the bone.
#[derive(Clone, Debug)]
pub struct Slab {
    columns: usize,
    rows: usize,
    layers: usize,
    /// Layer by layer from the skin down, row by row.
    nodes_mm: Vec<Vec3>,
}

/// Why a slab cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SlabError {
    /// Too small or too large.
    #[error(
        "a slab of {columns} × {rows} points and {layers} layers; 2 × 2 points and 1 layer to {MOST_NODES} nodes in all are allowed"
    )]
    Size {
        /// Points along x.
        columns: usize,
        /// Points along y.
        rows: usize,
        /// Bricks down.
        layers: usize,
    },
    /// A brick without volume.
    #[error("the slab is folded or empty in column {column}, row {row}, layer {layer}")]
    Folded {
        /// Which brick, along x.
        column: usize,
        /// Along y.
        row: usize,
        /// Down.
        layer: usize,
    },
}

/// Nodes a slab may have: beyond, its matrix takes gigabytes.
pub const MOST_NODES: usize = 300_000;

impl Slab {
    /// A slab under the skin points of a grid, down by `down_mm` of each to the bone. `depths` are shares of it, from 0 to 1.
    ///
    /// # Errors
    /// A grid that is too small, too large or does not have as many points as it says.
    pub fn new(
        columns: usize,
        rows: usize,
        skin_mm: &[Vec3],
        down_mm: &[Vec3],
        depths: &[f64],
    ) -> Result<Self, SlabError> {
        let layers = depths.len().saturating_sub(1);
        let n = columns.saturating_mul(rows);
        let fits = n.saturating_mul(layers + 1) <= MOST_NODES;
        if columns < 2
            || rows < 2
            || layers < 1
            || !fits
            || skin_mm.len() != n
            || down_mm.len() != n
        {
            return Err(SlabError::Size {
                columns,
                rows,
                layers,
            });
        }
        let columns_down = |share: &f64| {
            let share = *share;
            let both = skin_mm.iter().zip(down_mm);
            both.map(move |(skin, down)| *skin + *down * share)
        };
        Ok(Self {
            columns,
            rows,
            layers,
            nodes_mm: depths.iter().flat_map(columns_down).collect(),
        })
    }

    /// A flat slab with skin points at every pair of `xs` and `ys`, z = 0, and bone at z = −`thickness_mm`.
    ///
    /// # Errors
    /// As [`Slab::new`].
    pub fn flat(
        xs: &[f64],
        ys: &[f64],
        depths: &[f64],
        thickness_mm: f64,
    ) -> Result<Self, SlabError> {
        let skin: Vec<Vec3> = ys
            .iter()
            .flat_map(|y| xs.iter().map(move |x| Vec3::new(*x, *y, 0.0)))
            .collect();
        let down = vec![Vec3::NEG_Z * thickness_mm; skin.len()];
        Self::new(xs.len(), ys.len(), &skin, &down, depths)
    }

    /// Points along x and y, and bricks down.
    pub fn size(&self) -> [usize; 3] {
        [self.columns, self.rows, self.layers]
    }

    /// Every node, mm: the skin first, the bone last.
    pub fn nodes_mm(&self) -> &[Vec3] {
        &self.nodes_mm
    }

    /// The nodes of the skin, mm, row by row.
    pub fn skin_mm(&self) -> &[Vec3] {
        &self.nodes_mm[..self.columns * self.rows]
    }

    /// Number of a node.
    pub fn node(&self, column: usize, row: usize, layer: usize) -> usize {
        (layer * self.rows + row) * self.columns + column
    }

    /// Whether a node is on the bone.
    pub fn on_bone(&self, node: usize) -> bool {
        node >= self.columns * self.rows * self.layers
    }

    /// Whether a node is on one of the four sides: at the first or last column, at the first or last row.
    pub fn on_sides(&self, node: usize) -> [bool; 4] {
        let (column, row) = (node % self.columns, node / self.columns % self.rows);
        [
            column == 0,
            column + 1 == self.columns,
            row == 0,
            row + 1 == self.rows,
        ]
    }

    /// The nodes of every brick, in the order of [`super::hex::CORNERS`]: its bottom face is the deeper one.
    pub fn bricks(&self) -> impl Iterator<Item = [usize; 8]> + '_ {
        (0..self.layers).flat_map(move |layer| {
            (0..self.rows - 1).flat_map(move |row| {
                (0..self.columns - 1).map(move |column| {
                    let face = |layer: usize| {
                        [(0, 0), (1, 0), (1, 1), (0, 1)]
                            .map(|(c, r)| self.node(column + c, row + r, layer))
                    };
                    let ([a, b, c, d], [e, f, g, h]) = (face(layer + 1), face(layer));
                    [a, b, c, d, e, f, g, h]
                })
            })
        })
    }

    /// The faces of the skin, counter-clockwise seen from outside.
    pub fn faces(&self) -> impl Iterator<Item = [usize; 4]> + '_ {
        (0..self.rows - 1).flat_map(move |row| {
            (0..self.columns - 1).map(move |column| {
                [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(c, r)| self.node(column + c, row + r, 0))
            })
        })
    }

    /// The brick of this number in the order of [`Slab::bricks`], for messages.
    pub(in crate::reference) fn folded(&self, brick: usize) -> SlabError {
        let (columns, rows) = (self.columns - 1, self.rows - 1);
        SlabError::Folded {
            column: brick % columns,
            row: brick / columns % rows,
            layer: brick / (columns * rows),
        }
    }
}

/// `n` + 1 places from 0 to `end` at equal steps of t in (e^(βt) − 1), whose spacing grows e^β = `growth` ≥ 1 times from
/// first to last: the places of 2n hold those of n. A growth outside 1 … 1e6 is brought within; what is no number counts as 1.
pub fn graded(n: usize, end: f64, growth: f64) -> Vec<f64> {
    let growth = if growth > 1.0 { growth.min(1.0e6) } else { 1.0 };
    let beta = libm::log(growth);
    let n = n.max(1);
    let place = |i: usize| {
        let t = i as f64 / n as f64;
        if beta > 1.0e-9 {
            end * libm::expm1(beta * t) / libm::expm1(beta)
        } else {
            end * t
        }
    };
    (0..=n).map(place).collect()
}
