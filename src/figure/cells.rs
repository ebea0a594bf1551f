//! A map of cells that each belong to a class, with curves over it, as SVG.

use super::axis::{Axis, FARTHEST, Scale, extent, padded};
use super::plot::{Mark, Series, drawn};
use super::sheet::{
    AXIS, Area, DOT_RADIUS, FRAME_WIDTH, INK, LEFT_MARGIN, Legend, PX, RIGHT_MARGIN, Swatch,
    TEXT_SIZE, TITLE_HEIGHT, X_LABEL_HEIGHT, Y_LABEL_WIDTH, cut, named, say_no_data, sheet,
    shortened_chars, style, title,
};
use plotters::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::{Error, Result};

/// A class of cells.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Class {
    /// Name in the legend.
    pub name: String,
    /// sRGB colour.
    pub colour: [u8; 3],
}

/// Cells over two axes. Cell (i, j) reaches from `x_edges[i]` to `x_edges[i + 1]` and from `y_edges[j]` to
/// `y_edges[j + 1]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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

/// Cells of one class that lie side by side in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellBox {
    /// From where to where along x.
    pub x: [f64; 2],
    /// From where to where along y.
    pub y: [f64; 2],
    /// Their class, as its place among the classes.
    pub class: usize,
}

impl CellMap {
    /// All cells that have a class, those of one class side by side as one box.
    pub fn boxes(&self) -> Vec<CellBox> {
        let columns = self.x_edges.len().saturating_sub(1);
        let rows = self.y_edges.len().saturating_sub(1);
        let mut boxes: Vec<CellBox> = Vec::new();
        if columns == 0 {
            return boxes;
        }
        let mut open = None;
        for (i, &class) in self.cells.iter().enumerate().take(columns * rows) {
            let (row, column, class) = (i / columns, i % columns, usize::from(class));
            if class >= self.classes.len() {
                open = None;
                continue;
            }
            match boxes.last_mut() {
                Some(last) if open == Some((row, class)) && column > 0 => {
                    last.x[1] = self.x_edges[column + 1];
                }
                _ => boxes.push(CellBox {
                    x: [self.x_edges[column], self.x_edges[column + 1]],
                    y: [self.y_edges[row], self.y_edges[row + 1]],
                    class,
                }),
            }
            open = Some((row, class));
        }
        boxes
    }

    /// The class of the cell at a place; nothing where there is none.
    pub fn class_at(&self, [x, y]: [f64; 2]) -> Option<&Class> {
        let column = |edges: &[f64], at: f64| {
            edges
                .windows(2)
                .position(|pair| at >= pair[0] && at < pair[1])
        };
        let columns = self.x_edges.len().saturating_sub(1);
        let i = column(&self.y_edges, y)? * columns + column(&self.x_edges, x)?;
        self.classes.get(usize::from(*self.cells.get(i)?))
    }
}

const FRAME_HEIGHT: u32 = 400 * PX;
const LINE_WIDTH: u32 = 2 * PX;
/// Of the white beside a curve, so that it is seen over cells of any colour.
const OUTLINE_WIDTH: u32 = LINE_WIDTH + 3 * PX;

/// Draws it, with `caption`, if not empty, below in small type.
///
/// The frame holds just the cells; of a curve only what lies in it is drawn. A border that the axis has no place for, as 0
/// on a logarithmic one, takes its cells with it. A map with neither cell nor curve says so.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn svg(map: &CellMap, caption: &str) -> Result<String> {
    let classes = map
        .classes
        .iter()
        .map(|c| (&*c.name, c.colour, Swatch::Filled));
    // A ring on a dashed curve says "measured by someone else": over cells dashes are enough.
    let curves = named(&map.series).map(|(name, colour, swatch)| match swatch {
        Swatch::Curve(Mark::Dashed) => (name, colour, Swatch::Dashes),
        _ => (name, colour, swatch),
    });
    let legend = Legend::new(classes.chain(curves));
    let height = TITLE_HEIGHT + legend.height() + FRAME_HEIGHT + X_LABEL_HEIGHT;
    sheet(height, caption, |area| {
        title(area, &map.title)?;
        legend.draw(area)?;
        draw(area, map, legend.height())
    })
}

fn draw(area: &Area, map: &CellMap, legend_height: u32) -> Result<()> {
    let x_edges = places(&map.x_edges, map.x_scale);
    let y_edges = places(&map.y_edges, map.y_scale);
    let range = |edges: &[f64], axis: usize, scale| {
        let known = || edges.iter().copied().filter(|e| e.is_finite());
        let curves = map
            .series
            .iter()
            .flat_map(|s| drawn(s, map.x_scale, map.y_scale))
            .map(|p| p[axis]);
        padded(extent(known()).or_else(|| extent(curves)), 0.0, scale)
    };
    let x_range = range(&x_edges, 0, map.x_scale);
    let y_range = range(&y_edges, 1, map.y_scale);
    let mut chart = ChartBuilder::on(area)
        .margin_top(TITLE_HEIGHT + legend_height + 4 * PX)
        .margin_left(LEFT_MARGIN)
        .margin_right(RIGHT_MARGIN)
        .x_label_area_size(X_LABEL_HEIGHT)
        .y_label_area_size(Y_LABEL_WIDTH)
        .build_cartesian_2d(
            Axis::new(x_range.clone(), 10, map.x_scale),
            Axis::new(y_range.clone(), 8, map.y_scale),
        )
        .map_err(Error::other)?;

    let mut empty = true;
    for cells in map.boxes() {
        let place = |i: usize| (map.x_scale.place(cells.x[i]), map.y_scale.place(cells.y[i]));
        let is_placed = |(x, y): (f64, f64)| x.abs() <= FARTHEST && y.abs() <= FARTHEST;
        if !is_placed(place(0)) || !is_placed(place(1)) {
            continue;
        }
        // Cells meet on whole pixels: no hairline shows between them.
        let corners = [0, 1].map(|i| {
            let (x, y) = chart.backend_coord(&place(i));
            (whole(x), whole(y))
        });
        let [r, g, b] = map.classes[cells.class].colour;
        area.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))
            .map_err(Error::other)?;
        empty = false;
    }

    let text = style(TEXT_SIZE, INK);
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(AXIS.stroke_width(PX))
        .set_all_tick_mark_size(5 * PX)
        .label_style(text.clone())
        .axis_desc_style(text)
        .x_desc(cut(&map.x_label, shortened_chars(FRAME_WIDTH, TEXT_SIZE)))
        .y_desc(cut(&map.y_label, shortened_chars(FRAME_HEIGHT, TEXT_SIZE)))
        .draw()
        .map_err(Error::other)?;

    let frame = [[x_range.start, x_range.end], [y_range.start, y_range.end]];
    for series in &map.series {
        let [r, g, b] = series.colour;
        let colour = RGBColor(r, g, b);
        let halo = WHITE.mix(0.85);
        let points: Vec<[f64; 2]> = drawn(series, map.x_scale, map.y_scale).collect();
        for piece in clipped(&points, frame) {
            empty = false;
            let line = || piece.iter().map(|&[x, y]| (x, y));
            let outline = halo.stroke_width(OUTLINE_WIDTH);
            let ink = colour.stroke_width(LINE_WIDTH);
            match series.mark {
                Mark::Points => continue,
                Mark::Line | Mark::Joined => {
                    chart
                        .draw_series(LineSeries::new(line(), outline))
                        .map_err(Error::other)?;
                    chart
                        .draw_series(LineSeries::new(line(), ink))
                        .map_err(Error::other)?;
                }
                Mark::Dashed => {
                    chart
                        .draw_series(LineSeries::new(line(), outline))
                        .map_err(Error::other)?;
                    chart
                        .draw_series(DashedLineSeries::new(line(), 7 * PX, 5 * PX, ink))
                        .map_err(Error::other)?;
                }
            }
        }
        if matches!(series.mark, Mark::Points | Mark::Joined) {
            let inside = points.iter().filter(|p| is_in(**p, frame));
            for &[x, y] in inside {
                empty = false;
                for (style, more) in [(halo.filled(), 3 * PX / 2), (colour.filled(), 0)] {
                    chart
                        .draw_series([Circle::new((x, y), DOT_RADIUS + more, style)])
                        .map_err(Error::other)?;
                }
            }
        }
    }
    if empty {
        let (x, y) = chart.plotting_area().get_pixel_range();
        say_no_data(area, ((x.start + x.end) / 2, (y.start + y.end) / 2))?;
    }
    Ok(())
}

/// The nearest whole pixel.
fn whole(quarters: i32) -> i32 {
    let px = PX as i32;
    (quarters + px / 2).div_euclid(px) * px
}

fn places(edges: &[f64], scale: Scale) -> Vec<f64> {
    edges
        .iter()
        .map(|&e| scale.place(e))
        .map(|e| if e.abs() <= FARTHEST { e } else { f64::NAN })
        .collect()
}

fn is_in(point: [f64; 2], frame: [[f64; 2]; 2]) -> bool {
    (0..2).all(|i| point[i] >= frame[i][0] && point[i] <= frame[i][1])
}

/// The pieces of a curve that lie in a frame, cut at its border.
fn clipped(points: &[[f64; 2]], frame: [[f64; 2]; 2]) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut goes_on = false;
    for pair in points.windows(2) {
        let Some([from, to]) = inside([pair[0], pair[1]], frame) else {
            goes_on = false;
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if goes_on && from == pair[0] => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
        goes_on = to == pair[1];
    }
    pieces
}

/// The part of a segment that lies in a frame (Liang and Barsky 1984).
fn inside([a, b]: [[f64; 2]; 2], frame: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for i in 0..2 {
        let along = b[i] - a[i];
        let [low, high] = frame[i];
        if along == 0.0 {
            if a[i] < low || a[i] > high {
                return None;
            }
            continue;
        }
        let (s, t) = ((low - a[i]) / along, (high - a[i]) / along);
        enters = enters.max(s.min(t));
        leaves = leaves.min(s.max(t));
    }
    if enters > leaves {
        return None;
    }
    let at = |share: f64, whole: [f64; 2]| match share {
        // The ends themselves, bit for bit: pieces that meet are one.
        0.0 | 1.0 => whole,
        _ => [0, 1].map(|i| (a[i] + share * (b[i] - a[i])).clamp(frame[i][0], frame[i][1])),
    };
    Some([at(enters, a), at(leaves, b)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Beside a test of many points along the curve, each for itself.
        #[test]
        fn of_a_curve_just_the_part_in_the_frame_is_left(
            points in prop::collection::vec([-3.0..3.0, -3.0..3.0_f64], 2..12),
        ) {
            let frame = [[-1.0, 1.5], [-0.5, 2.0]];
            let pieces = clipped(&points, frame);
            for p in pieces.iter().flatten() {
                prop_assert!(is_in(*p, frame));
            }
            let length = |line: &[[f64; 2]]| -> f64 {
                line.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
            };
            let left: f64 = pieces.iter().map(|p| length(p)).sum();
            let n = 4000;
            let mut counted = 0.0;
            for pair in points.windows(2) {
                let step = length(pair) / f64::from(n);
                let hits = (0..n).filter(|i| {
                    let t = (f64::from(*i) + 0.5) / f64::from(n);
                    is_in([0, 1].map(|k| pair[0][k] + t * (pair[1][k] - pair[0][k])), frame)
                });
                counted += hits.count() as f64 * step;
            }
            prop_assert!((left - counted).abs() < 0.01 * points.len() as f64, "{} {}", left, counted);
        }
    }

    #[test]
    fn a_curve_inside_stays_one_piece() {
        let points = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(
            clipped(&points, [[0.0, 1.0], [0.0, 1.0]]),
            [points.to_vec()]
        );
        assert!(clipped(&points[..1], [[0.0, 1.0], [0.0, 1.0]]).is_empty());
    }

    #[test]
    fn cells_of_a_class_side_by_side_are_one_and_rows_are_not() {
        let map = CellMap {
            x_edges: vec![0.0, 1.0, 2.0, 3.0],
            y_edges: vec![0.0, 10.0, 20.0],
            cells: vec![0, 0, 1, 1, 9, 1, 0, 0],
            classes: ["a", "b"]
                .map(|name| Class {
                    name: name.to_owned(),
                    ..Class::default()
                })
                .into(),
            ..CellMap::default()
        };
        let boxes: Vec<_> = map.boxes().iter().map(|b| (b.x, b.y[0], b.class)).collect();
        assert_eq!(
            boxes,
            [
                ([0.0, 2.0], 0.0, 0),
                ([2.0, 3.0], 0.0, 1),
                ([0.0, 1.0], 10.0, 1),
                ([2.0, 3.0], 10.0, 1)
            ]
        );
        let name = |x, y| map.class_at([x, y]).map(|c| &*c.name);
        assert_eq!(
            [name(0.0, 0.0), name(2.5, 9.9), name(2.5, 10.0)],
            [Some("a"), Some("b"), Some("b")]
        );
        assert_eq!(
            [name(1.5, 15.0), name(3.0, 0.0), name(f64::NAN, 0.0)],
            [None; 3]
        );
        let without = CellMap {
            x_edges: vec![1.0],
            ..map
        };
        assert!(without.boxes().is_empty() && without.class_at([1.0, 1.0]).is_none());
    }
}
