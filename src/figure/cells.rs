//! A map of cells that each belong to a class, with curves over it, as SVG.

use super::{LinePlot, Scale, Series, plot};
use std::io::Result;

/// A class of cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Class {
    /// Name in the legend.
    pub name: String,
    /// sRGB colour.
    pub colour: [u8; 3],
}

/// Cells over two axes. Cell (i, j) reaches from `x_edges[i]` to `x_edges[i + 1]` and from `y_edges[j]` to
/// `y_edges[j + 1]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMap {
    /// Above the frame.
    pub title: String,
    /// What x is, with its unit.
    pub x_label: String,
    /// What y is, with its unit.
    pub y_label: String,
    /// How x is laid out.
    pub x_scale: Scale,
    /// How y is laid out.
    pub y_scale: Scale,
    /// Borders of the columns, ascending: one more than columns.
    pub x_edges: Vec<f64>,
    /// Borders of the rows, ascending: one more than rows.
    pub y_edges: Vec<f64>,
    /// The class of every cell, as its place in `classes`: row after row from the lowest y. One that there is not stays
    /// bare.
    pub cells: Vec<u8>,
    /// The classes, in the order of the legend.
    pub classes: Vec<Class>,
    /// Curves over the cells.
    pub series: Vec<Series>,
}

/// Draws it.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn svg(map: &CellMap) -> Result<String> {
    plot::svg(&[LinePlot {
        title: map.title.clone(),
        x_label: map.x_label.clone(),
        y_label: map.y_label.clone(),
        x_scale: map.x_scale,
        y_scale: map.y_scale,
        series: map.series.clone(),
    }])
}
