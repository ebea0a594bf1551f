//! Curves over one axis, as SVG.

use super::axis::{Axis, FARTHEST, Scale, extent, padded};
use super::file::write_whole;
use super::sheet::{
    AXIS, Area, DOT_RADIUS, FRAME_WIDTH, GAP, GRID, INK, LEFT_MARGIN, Legend, PX, RIGHT_MARGIN,
    TEXT_SIZE, TITLE_HEIGHT, X_LABEL_HEIGHT, Y_LABEL_WIDTH, cut, dot_styles, named, say_no_data,
    sheet, shortened_chars, style, title,
};
use plotters::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::{Error, Result};
use std::ops::Range;
use std::path::Path;

/// A curve.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// sRGB colour.
    pub colour: [u8; 3],
    /// How its points are shown.
    pub mark: Mark,
    /// Points (x, y) in the order they are joined. Those not finite, or farther than 1e15 from 0, are left out; on a
    /// logarithmic axis so are those not above 0.
    pub points: Vec<[f64; 2]>,
}

impl Series {
    /// Whether its points are shown as rings: those of a dashed curve with few of them.
    pub fn has_rings(&self) -> bool {
        self.mark == Mark::Dashed && self.points.len() <= MOST_RINGS
    }
}

/// How the points of a curve are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mark {
    /// Joined by a line.
    #[default]
    Line,
    /// Each as a dot, joined by a line: a few measured points.
    Joined,
    /// Each as a ring, joined by a dashed line: the figures of someone else beside ours. A curve of many points goes
    /// without rings.
    Dashed,
    /// Each as a dot by itself.
    Points,
}

impl Mark {
    pub(super) fn has_dots(self) -> bool {
        self != Self::Line
    }
}

/// Curves in one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinePlot {
    /// Above the frame.
    pub title: String,
    /// What x is, with its unit, as `time (s)`.
    pub x_label: String,
    /// What y is, with its unit, as `force (N)`.
    pub y_label: String,
    /// How x is laid out. Plots drawn together share x: it is logarithmic when one of them says so.
    pub x_scale: Scale,
    /// How y is laid out.
    pub y_scale: Scale,
    /// The curves, the last on top.
    pub series: Vec<Series>,
}

/// Most points of a dashed curve that are shown as rings: more lie on each other.
const MOST_RINGS: usize = 40;

const FRAME_HEIGHT: u32 = 210 * PX;

/// Draws the plots one above the other over a common range of x.
///
/// Each series is one polyline, or a dot where it has a single point. One with many points to a pixel column keeps, of each run of points in a column, the first,
/// the lowest, the highest and the last, so that every extremum stays and the file stays small. A plot without a point
/// says so. Text that does not fit is cut off with an ellipsis. `caption`, if not empty, stands below in small type.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn svg(plots: &[LinePlot], caption: &str) -> Result<String> {
    let nothing = [LinePlot::default()];
    let plots = if plots.is_empty() { &nothing } else { plots };
    let logarithmic = plots.iter().any(|p| p.x_scale == Scale::Logarithmic);
    let x_scale = if logarithmic {
        Scale::Logarithmic
    } else {
        Scale::Linear
    };
    let dotted = plots
        .iter()
        .any(|p| p.series.iter().any(|s| s.mark.has_dots()));
    let xs = plots.iter().flat_map(|p| points(p, x_scale)).map(|p| p[0]);
    let whole = |p: &LinePlot| points(p, x_scale).all(|p| p[0].fract() == 0.0);
    let x = Shared {
        scale: x_scale,
        is_counted: dotted && x_scale == Scale::Linear && plots.iter().all(whole),
        range: padded(extent(xs), if dotted { 0.03 } else { 0.0 }, x_scale),
    };
    let tall: Vec<u32> = plots
        .iter()
        .enumerate()
        .map(|(i, plot)| height_of(plot, i + 1 == plots.len()))
        .collect();
    sheet(tall.iter().sum(), caption, |root| {
        let mut rest = root.clone();
        for (i, (plot, tall)) in plots.iter().zip(tall).enumerate() {
            let (area, below) = rest.split_vertically(tall);
            draw(&area, plot, &x, i + 1 == plots.len())?;
            rest = below;
        }
        Ok(())
    })
}

/// Writes [`svg`] to a file: beside `path`, then renamed, so that no reader sees half of one. The folder must exist.
///
/// # Errors
/// Those of the file system.
pub fn write_svg(path: &Path, plots: &[LinePlot]) -> Result<()> {
    write_whole(path, svg(plots, "")?.as_bytes())
}

/// The axis that plots have in common.
struct Shared {
    scale: Scale,
    /// Dots at whole numbers: what is between means nothing.
    is_counted: bool,
    range: Range<f64>,
}

fn draw(area: &Area, plot: &LinePlot, x: &Shared, last: bool) -> Result<()> {
    title(area, &plot.title)?;
    let legend = Legend::new(named(&plot.series));
    legend.draw(area)?;

    let ys = points(plot, x.scale).map(|p| p[1]);
    let y_range = padded(extent(ys), 0.06, plot.y_scale);
    let x_label_height = if last { X_LABEL_HEIGHT } else { 0 };
    let mut chart = ChartBuilder::on(area)
        .margin_top(TITLE_HEIGHT + legend.height() + 4 * PX)
        .margin_bottom(if last { 0 } else { 4 * PX })
        .margin_left(LEFT_MARGIN)
        .margin_right(RIGHT_MARGIN)
        .x_label_area_size(x_label_height)
        .y_label_area_size(Y_LABEL_WIDTH)
        .build_cartesian_2d(
            match x.is_counted {
                true => Axis::of_whole(x.range.clone(), 10, x.scale),
                false => Axis::new(x.range.clone(), 10, x.scale),
            },
            Axis::new(y_range, 5, plot.y_scale),
        )
        .map_err(Error::other)?;
    let text = style(TEXT_SIZE, INK);
    let label_chars = |px: u32| shortened_chars(px, TEXT_SIZE);
    let mut mesh = chart.configure_mesh();
    mesh.bold_line_style(GRID.stroke_width(PX))
        .axis_style(AXIS.stroke_width(PX))
        .set_all_tick_mark_size(5 * PX)
        .label_style(text.clone())
        .axis_desc_style(text)
        .y_desc(cut(&plot.y_label, label_chars(FRAME_HEIGHT)));
    if last {
        mesh.x_desc(cut(&plot.x_label, label_chars(FRAME_WIDTH)));
    }
    mesh.draw().map_err(Error::other)?;

    let column = (x.range.end - x.range.start) / f64::from(FRAME_WIDTH / PX);
    for series in &plot.series {
        let [r, g, b] = series.colour;
        let all = drawn(series, x.scale, plot.y_scale);
        let curve = decimated(all, x.range.start, column);
        let colour = RGBColor(r, g, b);
        let line = colour.stroke_width(3 * PX / 2);
        let joined = curve.iter().map(|&[x, y]| (x, y));
        if curve.len() > 1 && matches!(series.mark, Mark::Line | Mark::Joined) {
            chart
                .draw_series(LineSeries::new(joined.clone(), line))
                .map_err(Error::other)?;
        } else if curve.len() > 1 && series.mark == Mark::Dashed {
            let thin = colour.stroke_width(PX);
            chart
                .draw_series(DashedLineSeries::new(joined.clone(), 6 * PX, 4 * PX, thin))
                .map_err(Error::other)?;
        }
        let has_dots = match series.mark {
            Mark::Dashed => series.has_rings(),
            mark => mark.has_dots(),
        };
        if !has_dots && curve.len() > 1 {
            continue;
        }
        for style in dot_styles(series.mark, colour) {
            let dots = joined.clone().map(|at| Circle::new(at, DOT_RADIUS, style));
            chart.draw_series(dots).map_err(Error::other)?;
        }
    }
    if points(plot, x.scale).next().is_none() {
        let (x, y) = chart.plotting_area().get_pixel_range();
        let origin = area.get_base_pixel();
        let middle = (
            (x.start + x.end) / 2 - origin.0,
            (y.start + y.end) / 2 - origin.1,
        );
        say_no_data(area, middle)?;
    }
    Ok(())
}

fn height_of(plot: &LinePlot, last: bool) -> u32 {
    let below = if last { X_LABEL_HEIGHT } else { GAP };
    TITLE_HEIGHT + Legend::new(named(&plot.series)).height() + FRAME_HEIGHT + below
}

/// The points that can be shown, where the axes have them.
pub(super) fn drawn(series: &Series, x: Scale, y: Scale) -> impl Iterator<Item = [f64; 2]> {
    let placed = move |p: &[f64; 2]| [x.place(p[0]), y.place(p[1])];
    // Written so that what is not a number is not drawn.
    let is_drawn = |p: &[f64; 2]| p.iter().all(|c| c.abs() <= FARTHEST);
    series.points.iter().map(placed).filter(is_drawn)
}

fn points(plot: &LinePlot, x: Scale) -> impl Iterator<Item = [f64; 2]> {
    plot.series
        .iter()
        .flat_map(move |s| drawn(s, x, plot.y_scale))
}

/// The same curve with at most four points for each run of points in one column `column` wide: first, lowest, highest, last.
fn decimated(points: impl Iterator<Item = [f64; 2]>, start: f64, column: f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    let mut run: Option<Run> = None;
    for (i, point) in points.enumerate() {
        let at = libm::floor((point[0] - start) / column);
        match &mut run {
            Some(run) if run.column == at => run.add(i, point),
            _ => {
                if let Some(run) = run.take() {
                    run.put(&mut kept);
                }
                run = Some(Run {
                    column: at,
                    ends: [(i, point); 4],
                });
            }
        }
    }
    if let Some(run) = run {
        run.put(&mut kept);
    }
    kept
}

/// Points that follow each other inside one pixel column.
struct Run {
    column: f64,
    /// First, lowest, highest, last, each with its place in the curve.
    ends: [(usize, [f64; 2]); 4],
}

impl Run {
    fn add(&mut self, i: usize, point: [f64; 2]) {
        let [_, lowest, highest, last] = &mut self.ends;
        if point[1] < lowest.1[1] {
            *lowest = (i, point);
        }
        if point[1] > highest.1[1] {
            *highest = (i, point);
        }
        *last = (i, point);
    }

    fn put(mut self, out: &mut Vec<[f64; 2]>) {
        self.ends.sort_by_key(|end| end.0);
        let mut before = None;
        for (i, point) in self.ends {
            if before != Some(i) {
                out.push(point);
            }
            before = Some(i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn decimation_keeps_the_extrema_of_every_column_in_order(
            ys in prop::collection::vec(-50.0..50.0, 1..400),
            n_columns in 1..40_usize,
        ) {
            let points: Vec<[f64; 2]> = ys.iter().zip(0..).map(|(&y, i)| [f64::from(i), y]).collect();
            let column = points.len() as f64 / n_columns as f64;
            let kept = decimated(points.iter().copied(), 0.0, column);
            prop_assert!(kept.len() <= 4 * (n_columns + 1));
            prop_assert!(kept.is_sorted_by(|a, b| a[0] < b[0]));
            prop_assert_eq!(kept.first(), points.first());
            prop_assert_eq!(kept.last(), points.last());
            for i in 0..=n_columns {
                let inside = |p: &&[f64; 2]| (p[0] / column).floor() == i as f64;
                let before = extent(points.iter().filter(inside).map(|p| p[1]));
                let after = extent(kept.iter().filter(inside).map(|p| p[1]));
                prop_assert_eq!(before, after);
            }
        }
    }

    #[test]
    fn a_curve_that_runs_back_and_forth_keeps_its_order() {
        let there_and_back = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [1.0, 3.0], [0.0, 4.0]];
        let kept = decimated(there_and_back.into_iter(), 0.0, 0.5);
        assert_eq!(kept, there_and_back);
    }
}
