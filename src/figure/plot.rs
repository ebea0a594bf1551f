//! Curves over one axis, as SVG.

use super::axis::{Axis, FARTHEST, Scale, extent, padded};
use super::file::write_whole;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::io::{Error, Result};
use std::ops::Range;
use std::path::Path;

/// A curve.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// How the points of a curve are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mark {
    /// Joined by a line.
    #[default]
    Line,
    /// Each as a dot, joined by a line: a few measured points.
    Joined,
    /// Each as a ring, joined by a dashed line: the figures of someone else beside ours.
    Dashed,
    /// Each as a dot by itself.
    Points,
}

impl Mark {
    fn has_dots(self) -> bool {
        self != Self::Line
    }
}

/// Curves in one frame.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// The SVG backend draws in whole numbers: in quarters of a pixel slow curves stay smooth.
const PX: u32 = 4;
const WIDTH: u32 = 1000 * PX;
const TITLE_HEIGHT: u32 = 30 * PX;
const LEGEND_ROW_HEIGHT: u32 = 20 * PX;
const FRAME_HEIGHT: u32 = 210 * PX;
const X_LABEL_HEIGHT: u32 = 46 * PX;
const GAP: u32 = 14 * PX;
const LEFT_MARGIN: u32 = 12 * PX;
const RIGHT_MARGIN: u32 = 28 * PX;
const Y_LABEL_WIDTH: u32 = 68 * PX;
const SWATCH_WIDTH: u32 = 18 * PX;
const FRAME_LEFT: u32 = LEFT_MARGIN + Y_LABEL_WIDTH;
const FRAME_WIDTH: u32 = WIDTH - FRAME_LEFT - RIGHT_MARGIN;
/// The SVG backend divides a font's size by this.
const FONT_SCALE: f64 = 1.24;
const TITLE_SIZE: f64 = 16.0 * PX as f64;
const TEXT_SIZE: f64 = 12.5 * PX as f64;
/// A wide character, em: no font is at hand to measure with.
const EM_PER_CHAR: f64 = 0.62;
const DOT_RADIUS: u32 = 3 * PX;

const INK: RGBColor = RGBColor(52, 58, 66);
const FAINT: RGBColor = RGBColor(120, 128, 138);
const GRID: RGBColor = RGBColor(226, 230, 235);
const AXIS: RGBColor = RGBColor(160, 168, 178);

/// Draws the plots one above the other over a common range of x.
///
/// Each series is one polyline, or a dot where it has a single point. One with many points to a pixel column keeps, of each run of points in a column, the first,
/// the lowest, the highest and the last, so that every extremum stays and the file stays small. A plot without a point
/// says so. Text that does not fit is cut off with an ellipsis.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn svg(plots: &[LinePlot]) -> Result<String> {
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
    let x = Shared {
        scale: x_scale,
        range: padded(extent(xs), if dotted { 0.03 } else { 0.0 }, x_scale),
    };
    let tall: Vec<u32> = plots
        .iter()
        .enumerate()
        .map(|(i, plot)| height_of(plot, i + 1 == plots.len()))
        .collect();
    let height = tall.iter().sum::<u32>() + GAP;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE).map_err(Error::other)?;
        let mut rest = root;
        for (i, (plot, tall)) in plots.iter().zip(tall).enumerate() {
            let (area, below) = rest.split_vertically(tall);
            draw(&area, plot, &x, i + 1 == plots.len())?;
            rest = below;
        }
        rest.present().map_err(Error::other)?;
    }
    let drawn = format!("width=\"{WIDTH}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", WIDTH / PX, height / PX);
    Ok(text.replacen(&drawn, &shown, 1))
}

/// Writes [`svg`] to a file: beside `path`, then renamed, so that no reader sees half of one. The folder must exist.
///
/// # Errors
/// Those of the file system.
pub fn write_svg(path: &Path, plots: &[LinePlot]) -> Result<()> {
    write_whole(path, svg(plots)?.as_bytes())
}

/// The axis that plots have in common.
struct Shared {
    scale: Scale,
    range: Range<f64>,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(area: &Area, plot: &LinePlot, x: &Shared, last: bool) -> Result<()> {
    let title = style(TITLE_SIZE, INK).pos(Pos::new(HPos::Left, VPos::Center));
    let title_text = shortened(&plot.title, FRAME_WIDTH, TITLE_SIZE);
    let title_at = (FRAME_LEFT as i32, (TITLE_HEIGHT / 2 + 4 * PX) as i32);
    area.draw_text(&title_text, &title, title_at)
        .map_err(Error::other)?;
    for entry in legend(plot) {
        let middle = (TITLE_HEIGHT + entry.row * LEGEND_ROW_HEIGHT + LEGEND_ROW_HEIGHT / 2) as i32;
        let left = (FRAME_LEFT + entry.left) as i32;
        swatch(area, &entry, (left, middle))?;
        let text = style(TEXT_SIZE, INK).pos(Pos::new(HPos::Left, VPos::Center));
        let at = (left + (SWATCH_WIDTH + 6 * PX) as i32, middle);
        area.draw_text(&entry.name, &text, at)
            .map_err(Error::other)?;
    }

    let ys = points(plot, x.scale).map(|p| p[1]);
    let y_range = padded(extent(ys), 0.06, plot.y_scale);
    let x_label_height = if last { X_LABEL_HEIGHT } else { 0 };
    let mut chart = ChartBuilder::on(area)
        .margin_top(TITLE_HEIGHT + legend_rows(plot) * LEGEND_ROW_HEIGHT + 4 * PX)
        .margin_bottom(if last { 0 } else { 4 * PX })
        .margin_left(LEFT_MARGIN)
        .margin_right(RIGHT_MARGIN)
        .x_label_area_size(x_label_height)
        .y_label_area_size(Y_LABEL_WIDTH)
        .build_cartesian_2d(
            Axis::new(x.range.clone(), 10, x.scale),
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
        if !series.mark.has_dots() && curve.len() > 1 {
            continue;
        }
        for style in dot_styles(series.mark, colour) {
            let dots = joined.clone().map(|at| Circle::new(at, DOT_RADIUS, style));
            chart.draw_series(dots).map_err(Error::other)?;
        }
    }
    if points(plot, x.scale).next().is_none() {
        let style = style(TITLE_SIZE, FAINT).pos(Pos::new(HPos::Center, VPos::Center));
        let (x, y) = chart.plotting_area().get_pixel_range();
        let origin = area.get_base_pixel();
        let at = (
            (x.start + x.end) / 2 - origin.0,
            (y.start + y.end) / 2 - origin.1,
        );
        area.draw_text("no data", &style, at)
            .map_err(Error::other)?;
    }
    Ok(())
}

/// What a curve looks like, before its name in the legend; `at` is its left end, half way up.
fn swatch(area: &Area, entry: &Entry, (left, middle): (i32, i32)) -> Result<()> {
    let [r, g, b] = entry.colour;
    let colour = RGBColor(r, g, b);
    let wide = SWATCH_WIDTH as i32;
    let thick = PX as i32;
    let parts: &[(i32, i32)] = match entry.mark {
        Mark::Line | Mark::Joined => &[(0, wide)],
        Mark::Dashed => &[(0, wide / 5), (4 * wide / 5, wide)],
        Mark::Points => &[],
    };
    for (from, to) in parts {
        let bar = [(left + from, middle - thick), (left + to, middle + thick)];
        area.draw(&Rectangle::new(bar, colour.filled()))
            .map_err(Error::other)?;
    }
    if entry.mark.has_dots() {
        let at = (left + wide / 2, middle);
        for style in dot_styles(entry.mark, colour) {
            area.draw(&Circle::new(at, DOT_RADIUS, style))
                .map_err(Error::other)?;
        }
    }
    Ok(())
}

/// What makes up a dot, or a ring that hides the curve behind it.
fn dot_styles(mark: Mark, colour: RGBColor) -> Vec<ShapeStyle> {
    if mark == Mark::Dashed {
        vec![WHITE.filled(), colour.stroke_width(3 * PX / 2)]
    } else {
        vec![colour.filled()]
    }
}

fn style(size: f64, colour: RGBColor) -> TextStyle<'static> {
    let mut style = TextStyle::from(("sans-serif", size * FONT_SCALE).into_font());
    style.color = colour.to_backend_color();
    style
}

fn height_of(plot: &LinePlot, last: bool) -> u32 {
    let below = if last { X_LABEL_HEIGHT } else { GAP };
    TITLE_HEIGHT + legend_rows(plot) * LEGEND_ROW_HEIGHT + FRAME_HEIGHT + below
}

/// A name in the legend: where, in what colour.
struct Entry {
    row: u32,
    /// From the left of the frame, pixels.
    left: u32,
    name: String,
    colour: [u8; 3],
    mark: Mark,
}

/// The named series in as many rows as they need.
fn legend(plot: &LinePlot) -> Vec<Entry> {
    let (mut row, mut left) = (0, 0);
    let mut entries = Vec::new();
    for series in plot.series.iter().filter(|s| !s.name.trim().is_empty()) {
        let name = shortened(&series.name, FRAME_WIDTH / 2, TEXT_SIZE);
        let chars = name.chars().count() as f64;
        let wide = SWATCH_WIDTH + 24 * PX + (chars * EM_PER_CHAR * TEXT_SIZE) as u32;
        if left > 0 && left + wide > FRAME_WIDTH {
            (row, left) = (row + 1, 0);
        }
        entries.push(Entry {
            row,
            left,
            name,
            colour: series.colour,
            mark: series.mark,
        });
        left += wide;
    }
    entries
}

fn legend_rows(plot: &LinePlot) -> u32 {
    legend(plot).last().map_or(0, |entry| entry.row + 1)
}

/// How many characters fit.
fn shortened_chars(width_px: u32, size: f64) -> usize {
    (f64::from(width_px) / (EM_PER_CHAR * size)) as usize
}

fn shortened(text: &str, width_px: u32, size: f64) -> String {
    cut(text, shortened_chars(width_px, size))
}

/// At most `n` characters, with an ellipsis where some are missing, and none that XML forbids.
fn cut(text: &str, n: usize) -> String {
    let allowed = |c: char| {
        if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') {
            ' '
        } else {
            c
        }
    };
    let mut short: String = text.chars().take(n).map(allowed).collect();
    if text.chars().nth(n).is_some() {
        short.pop();
        short.push('…');
    }
    short
}

/// The points that can be shown, where the axes have them.
fn drawn(series: &Series, x: Scale, y: Scale) -> impl Iterator<Item = [f64; 2]> {
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
