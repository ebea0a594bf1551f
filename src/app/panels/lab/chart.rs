//! Figures, drawn as they are on paper: the same frames and marks, on logarithmic axes too. The pointer tells what a point
//! is.

use crate::app::theme::Theme;
use crate::figure::{CellMap, LinePlot, Mark, Marks, Scale, Series, axis_marks, axis_range};
use crate::lab::{Table, Value};
use egui::{Color32, Pos2, Rect, RichText, Shape, Stroke, vec2};
use egui_plot::{
    GridInput, GridMark, Line, LineStyle, Plot, PlotBounds, PlotGeometry, PlotItem, PlotItemBase,
    PlotPoint, PlotPoints, PlotTransform, Points,
};
use std::ops::RangeInclusive;

/// Height of a plot's frame, points.
const PLOT_HEIGHT: f32 = 230.0;
const MAP_HEIGHT: f32 = 340.0;
/// A pointer this near means a point, points.
const NEAR: f32 = 14.0;
/// Least contrast of a curve with what is behind it (WCAG 2.1, success criterion 1.4.11).
const CONTRAST: f32 = 3.0;

/// What charts need beside what they draw.
pub struct ChartContext<'a> {
    /// The colours.
    pub theme: &'a Theme,
    /// Where the figures of points stand, with what they belong to.
    pub tables: &'a [Table],
}

/// Draws plots one above the other over a common axis.
pub fn plots_ui(ui: &mut egui::Ui, cx: &ChartContext<'_>, plots: &[LinePlot]) {
    let is_log = plots.iter().any(|p| p.x_scale == Scale::Logarithmic);
    let x_scale = if is_log {
        Scale::Logarithmic
    } else {
        Scale::Linear
    };
    let placed: Vec<Vec<Placed<'_>>> = plots
        .iter()
        .map(|p| place_all(&p.series, x_scale, p.y_scale))
        .collect();
    let x_range = range(placed.iter().flatten(), 0, 0.03, x_scale);
    let link = ui.scope_id().with("x");
    for (i, (plot, series)) in plots.iter().zip(&placed).enumerate() {
        let frame = Frame {
            title: &plot.title,
            labels: [&plot.x_label, &plot.y_label],
            scales: [x_scale, plot.y_scale],
            ranges: [x_range.clone(), range(series.iter(), 1, 0.06, plot.y_scale)],
            is_counted: placed.iter().flatten().all(Placed::is_counted),
            height: PLOT_HEIGHT,
            link: Some(link),
        };
        ui.push_id(i, |ui| frame.show(ui, cx, series, None));
    }
}

/// Draws a map of cells with its curves.
pub fn map_ui(ui: &mut egui::Ui, cx: &ChartContext<'_>, map: &CellMap) {
    let series = place_all(&map.series, map.x_scale, map.y_scale);
    let frame = Frame {
        title: &map.title,
        labels: [&map.x_label, &map.y_label],
        scales: [map.x_scale, map.y_scale],
        ranges: [
            axis_range(
                map.x_edges.iter().map(|&e| map.x_scale.place(e)),
                0.0,
                map.x_scale,
            ),
            axis_range(
                map.y_edges.iter().map(|&e| map.y_scale.place(e)),
                0.0,
                map.y_scale,
            ),
        ]
        .map(|r| r.start..=r.end),
        is_counted: false,
        height: MAP_HEIGHT,
        link: None,
    };
    frame.show(ui, cx, &series, Some(map));
}

/// A curve with its points where the axes have them.
struct Placed<'a> {
    series: &'a Series,
    /// Where a point is drawn, and its place among all points of the series.
    points: Vec<([f64; 2], usize)>,
}

impl Placed<'_> {
    /// Dots at whole numbers along x: what is between means nothing.
    fn is_counted(&self) -> bool {
        let is_whole = |(at, _): &([f64; 2], usize)| at[0].fract() == 0.0;
        self.series.mark == Mark::Joined && self.points.iter().all(is_whole)
    }
}

fn place_all(series: &[Series], x: Scale, y: Scale) -> Vec<Placed<'_>> {
    let place = |series| Placed {
        series,
        points: (series.points.iter().enumerate())
            .map(|(i, p)| ([x.place(p[0]), y.place(p[1])], i))
            .filter(|(p, _)| p.iter().all(|c| c.is_finite()))
            .collect(),
    };
    series.iter().map(place).collect()
}

fn range<'a>(
    placed: impl Iterator<Item = &'a Placed<'a>>,
    axis: usize,
    margin: f64,
    scale: Scale,
) -> RangeInclusive<f64> {
    let places = placed.flat_map(|p| p.points.iter().map(move |(at, _)| at[axis]));
    let range = axis_range(places, margin, scale);
    range.start..=range.end
}

struct Frame<'a> {
    title: &'a str,
    labels: [&'a str; 2],
    scales: [Scale; 2],
    ranges: [RangeInclusive<f64>; 2],
    /// Along x things are counted.
    is_counted: bool,
    height: f32,
    link: Option<egui::Id>,
}

impl Frame<'_> {
    fn show(
        &self,
        ui: &mut egui::Ui,
        cx: &ChartContext<'_>,
        series: &[Placed<'_>],
        map: Option<&CellMap>,
    ) {
        ui.add_space(4.0);
        ui.label(RichText::new(self.title).strong());
        legend_ui(ui, cx, series, map);
        let [x_scale, y_scale] = self.scales;
        let [x, y] = &self.ranges;
        let counted = self.is_counted && x_scale == Scale::Linear;
        let mut plot = Plot::new("plot")
            .height(self.height)
            .width(ui.available_width())
            .default_x_bounds(*x.start(), *x.end())
            .default_y_bounds(*y.start(), *y.end())
            .allow_scroll(false)
            .allow_double_click_reset(true)
            .show_crosshair(false)
            .label_formatter(|_| None)
            .x_axis_label(self.labels[0])
            .y_axis_label(self.labels[1])
            .y_axis_min_width(44.0)
            .x_grid_spacer(move |input| grid(input, 10, x_scale, counted))
            .y_grid_spacer(move |input| grid(input, 6, y_scale, false))
            .x_axis_formatter(move |mark, range| number_at(mark, range, 10, x_scale, counted))
            .y_axis_formatter(move |mark, range| number_at(mark, range, 6, y_scale, false))
            .show_grid(map.is_none())
            .grid_color(cx.theme.line);
        if let Some(link) = self.link {
            plot = plot.link_axis(link, [true, false]);
        }
        let response = plot.show(ui, |plot| {
            if let Some(map) = map {
                plot.add(Cells::new(map));
            }
            for (i, placed) in series.iter().enumerate() {
                draw(plot, cx.theme, placed, i, map.is_some());
            }
        });
        let name = format!("Figure: {}", self.title);
        response
            .response
            .widget_info(|| egui::WidgetInfo::labeled(egui::accesskit::Role::Figure, true, &name));
        let Some(pointer) = response.response.hover_pos() else {
            return;
        };
        let transform = response.transform;
        if let Some((placed, at, i)) = nearest(series, &transform, pointer) {
            let ring = Stroke::new(2.0, cx.theme.accent);
            ui.painter()
                .with_clip_rect(*transform.frame())
                .circle_stroke(at, 6.5, ring);
            let point = placed.series.points[i];
            tooltip(&response.response, |ui| {
                self.tell(ui, cx, placed.series, point)
            });
        } else if let Some(map) = map {
            let at = transform.value_from_position(pointer);
            let value = |scale, place: f64| match scale {
                Scale::Linear => place,
                Scale::Logarithmic => libm::pow(10.0, place),
            };
            let at = [value(x_scale, at.x), value(y_scale, at.y)];
            if let Some(class) = map.class_at(at) {
                tooltip(&response.response, |ui| {
                    ui.strong(&class.name);
                    self.values_ui(ui, at);
                });
            }
        }
    }

    /// Says what a point is: its curve, its values, and the names in the row of a table that holds both.
    fn tell(&self, ui: &mut egui::Ui, cx: &ChartContext<'_>, series: &Series, point: [f64; 2]) {
        if !series.name.trim().is_empty() {
            ui.strong(&series.name);
        }
        for name in names_of(cx.tables, point) {
            if name != series.name {
                ui.label(name);
            }
        }
        self.values_ui(ui, point);
    }

    fn values_ui(&self, ui: &mut egui::Ui, point: [f64; 2]) {
        for (label, value) in self.labels.iter().zip(point) {
            let text = format!("{label}: {}", Value::from(value).short());
            ui.label(RichText::new(text).weak());
        }
    }
}

fn tooltip(response: &egui::Response, add: impl FnOnce(&mut egui::Ui)) {
    egui::Tooltip::always_open(
        response.ctx.clone(),
        response.layer_id,
        response.id,
        egui::PopupAnchor::Pointer,
    )
    .gap(14.0)
    .show(add);
}

/// The names in the first row of a table that holds both numbers of a point: the first alone, the others with what they
/// are names of.
fn names_of(tables: &[Table], point: [f64; 2]) -> Vec<String> {
    let holds = |row: &&Vec<Value>| {
        let has = |x: f64| row.iter().any(|v| v.number() == Some(x));
        has(point[0]) && has(point[1])
    };
    let found = tables
        .iter()
        .find_map(|t| Some((t, t.rows().iter().find(holds)?)));
    let Some((table, row)) = found else {
        return Vec::new();
    };
    let mut names = Vec::new();
    for (column, value) in table.columns().iter().zip(row) {
        match value {
            Value::Text(text) if text.trim().is_empty() => {}
            Value::Text(text) if names.is_empty() => names.push(text.clone()),
            Value::Text(text) => names.push(format!("{}: {text}", column.name)),
            _ => {}
        }
    }
    names
}

/// The point nearest to the pointer, if one is near: its curve, where it is drawn and which it is.
fn nearest<'a>(
    series: &'a [Placed<'a>],
    transform: &PlotTransform,
    pointer: Pos2,
) -> Option<(&'a Placed<'a>, Pos2, usize)> {
    let mut best = None;
    let mut least = NEAR * NEAR;
    for placed in series {
        for &(point, i) in &placed.points {
            let at = transform.position_from_point(&PlotPoint::from(point));
            let apart = at.distance_sq(pointer);
            // Of curves that share a point the upper one is meant.
            if apart <= least {
                least = apart;
                best = Some((placed, at, i));
            }
        }
    }
    best
}

fn draw<'a>(
    plot: &mut egui_plot::PlotUi<'a>,
    theme: &Theme,
    placed: &Placed<'_>,
    number: usize,
    over_cells: bool,
) {
    let Series {
        name, colour, mark, ..
    } = placed.series;
    let own = Color32::from_rgb(colour[0], colour[1], colour[2]);
    // Cells keep their colours in the dark, so do the curves over them; a halo sets these off.
    let colour = if over_cells {
        own
    } else {
        readable(own, theme.inset)
    };
    let halo = Color32::WHITE.gamma_multiply(0.85);
    let points = || -> PlotPoints<'a> { placed.points.iter().map(|(p, _)| *p).collect() };
    let id = |part: &str| egui::Id::unique((number, part));
    let joined = *mark != Mark::Points && placed.points.len() > 1;
    if joined && over_cells {
        plot.line(
            Line::new(name, points())
                .id(id("halo"))
                .color(halo)
                .width(5.0)
                .allow_hover(false),
        );
    }
    if joined {
        let style = match mark {
            Mark::Dashed => LineStyle::dashed_loose(),
            _ => LineStyle::Solid,
        };
        let width = if over_cells { 2.2 } else { 1.6 };
        let line = Line::new(name, points()).id(id("line")).color(colour);
        plot.line(line.width(width).style(style).allow_hover(false));
    }
    let dotted = match mark {
        Mark::Line => placed.points.len() == 1,
        Mark::Dashed => !over_cells && placed.series.has_rings(),
        Mark::Joined | Mark::Points => true,
    };
    if !dotted {
        return;
    }
    let dots = |part, colour, radius: f32, filled| {
        let points = Points::new(name, points()).id(id(part)).color(colour);
        points.radius(radius).filled(filled).allow_hover(false)
    };
    if over_cells {
        plot.points(dots("dot halo", halo, 5.0, true));
    }
    if *mark == Mark::Dashed {
        plot.points(dots("hole", theme.inset, 4.0, true));
        plot.points(dots("ring", colour, 4.0, false));
    } else {
        plot.points(dots("dot", colour, 3.2, true));
    }
}

/// What curves and cells are called: wrapped rows above the frame, so that nothing is covered.
fn legend_ui(
    ui: &mut egui::Ui,
    cx: &ChartContext<'_>,
    series: &[Placed<'_>],
    map: Option<&CellMap>,
) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(14.0, 2.0);
        let text = cx.theme.text;
        // Sign and name are one piece, so that rows break between entries only.
        let entry = |ui: &mut egui::Ui, name: &str, paint: &dyn Fn(&egui::Painter, Rect)| {
            let font = egui::FontId::proportional(12.0);
            let galley = ui.painter().layout_no_wrap(name.to_owned(), font, text);
            let size = vec2(galley.size().x + 24.0, galley.size().y.max(14.0));
            let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
            let (left, right) = rect.split_left_right_at_x(rect.left() + 18.0);
            paint(ui.painter(), left);
            let at = right.left_center() + vec2(6.0, -0.5 * galley.size().y);
            ui.painter().galley(at, galley, text);
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::accesskit::Role::Label, true, name)
            });
        };
        for class in map.iter().flat_map(|m| &m.classes) {
            let [r, g, b] = class.colour;
            entry(ui, &class.name, &|painter, rect| {
                painter.rect_filled(rect.shrink(1.0), 2.0, Color32::from_rgb(r, g, b));
            });
        }
        for Placed { series, .. } in series {
            if series.name.trim().is_empty() {
                continue;
            }
            let [r, g, b] = series.colour;
            let colour = readable(Color32::from_rgb(r, g, b), cx.theme.panel);
            entry(ui, &series.name, &|painter, rect| {
                sign(
                    painter,
                    rect,
                    series.mark,
                    series.has_rings() && map.is_none(),
                    colour,
                )
            });
        }
    });
}

/// What a curve looks like.
fn sign(painter: &egui::Painter, rect: Rect, mark: Mark, has_rings: bool, colour: Color32) {
    let (left, middle, right) = (rect.left_center(), rect.center(), rect.right_center());
    let stroke = Stroke::new(2.0, colour);
    match mark {
        Mark::Line => _ = painter.line_segment([left, right], stroke),
        Mark::Joined => {
            painter.line_segment([left, right], stroke);
            painter.circle_filled(middle, 3.2, colour);
        }
        Mark::Dashed => {
            painter.line_segment([left, left + vec2(4.5, 0.0)], stroke);
            painter.line_segment([right - vec2(4.5, 0.0), right], stroke);
            if has_rings {
                painter.circle_stroke(middle, 3.5, Stroke::new(1.5, colour));
            } else {
                painter.line_segment([middle - vec2(2.0, 0.0), middle + vec2(2.0, 0.0)], stroke);
            }
        }
        Mark::Points => _ = painter.circle_filled(middle, 3.5, colour),
    }
}

/// A colour for a white page as it is seen on `background`: in the dark greys change places, so that ink stays the one
/// that stands out, and others are made lighter until they are seen.
fn readable(colour: Color32, background: Color32) -> Color32 {
    let [r, g, b, _] = colour.to_array();
    let is_grey = r.max(g).max(b) - r.min(g).min(b) < 24;
    let is_dark = contrast(background, Color32::WHITE) > contrast(background, Color32::BLACK);
    let colour = match is_grey && is_dark {
        true => Color32::from_rgb(255 - r, 255 - g, 255 - b),
        false => colour,
    };
    let mut seen = colour;
    for i in 1..=10_u8 {
        if contrast(seen, background) >= CONTRAST {
            break;
        }
        let white = 0.1 * f32::from(i);
        seen = colour.lerp_to_gamma(Color32::WHITE, white);
    }
    if contrast(seen, background) >= CONTRAST {
        seen
    } else {
        colour
    }
}

/// Contrast ratio (WCAG 2.1).
fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |colour: Color32| {
        let [r, g, b, _] = egui::Rgba::from(colour).to_array();
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// The marks of an axis; where things are counted only whole numbers.
fn marks(range: std::ops::Range<f64>, n: usize, scale: Scale, counted: bool) -> Marks {
    let mut marks = axis_marks(range, n, scale);
    if counted {
        marks.major.retain(|(at, _)| (at - at.round()).abs() < 1e-9);
        for (at, text) in &mut marks.major {
            *text = format!("{at:.0}");
        }
    }
    marks
}

/// Lines of the grid: those with a number full, those between them faint.
fn grid(input: GridInput, n: usize, scale: Scale, counted: bool) -> Vec<GridMark> {
    let (from, to) = input.bounds;
    let marks = marks(from..to, n, scale, counted);
    let mark = |value, step_size| GridMark { value, step_size };
    let is_major = |m: &f64| marks.major.iter().any(|(at, _)| (at - m).abs() < 1e-9);
    let minor = marks.minor.iter().copied().filter(|m| !is_major(m));
    let minor = minor.map(|m| mark(m, 3.0 * input.base_step_size));
    let major = marks.major.iter().map(|(at, _)| mark(*at, to - from));
    minor.chain(major).collect()
}

/// The number at a line of the grid; none at faint ones.
fn number_at(
    mark: GridMark,
    range: &RangeInclusive<f64>,
    n: usize,
    scale: Scale,
    counted: bool,
) -> String {
    let (from, to) = (*range.start(), *range.end());
    if mark.step_size < 0.5 * (to - from) {
        return String::new();
    }
    let marks = marks(from..to, n, scale, counted).major;
    let near = |(at, _): &(f64, String)| (at - mark.value).abs();
    let nearest = marks.iter().min_by(|a, b| near(a).total_cmp(&near(b)));
    nearest.map(|(_, text)| text.clone()).unwrap_or_default()
}

/// The cells of a map as one item of a plot.
struct Cells {
    base: PlotItemBase,
    /// Corners where the axes have them, and colours.
    boxes: Vec<([[f64; 2]; 2], Color32)>,
    bounds: PlotBounds,
}

impl Cells {
    fn new(map: &CellMap) -> Self {
        let mut bounds = PlotBounds::NOTHING;
        let mut boxes = Vec::new();
        for cells in map.boxes() {
            let corner = |i: usize| [map.x_scale.place(cells.x[i]), map.y_scale.place(cells.y[i])];
            let corners = [corner(0), corner(1)];
            if corners.iter().flatten().all(|c| c.is_finite()) {
                let [r, g, b] = map.classes[cells.class].colour;
                corners
                    .iter()
                    .for_each(|c| bounds.extend_with(&PlotPoint::from(*c)));
                boxes.push((corners, Color32::from_rgb(r, g, b)));
            }
        }
        Self {
            base: PlotItemBase::new("cells".into()),
            boxes,
            bounds,
        }
    }
}

impl PlotItem for Cells {
    fn shapes(&self, ui: &egui::Ui, transform: &PlotTransform, shapes: &mut Vec<Shape>) {
        let px = ui.pixels_per_point();
        // Cells meet on whole pixels: no hairline shows between them.
        let whole = |p: Pos2| egui::pos2((p.x * px).round() / px, (p.y * px).round() / px);
        for (corners, colour) in &self.boxes {
            let [a, b] = corners.map(|c| whole(transform.position_from_point(&PlotPoint::from(c))));
            shapes.push(Shape::rect_filled(Rect::from_two_pos(a, b), 0.0, *colour));
        }
    }

    fn initialize(&mut self, _x_range: RangeInclusive<f64>) {}

    fn allow_hover(&self) -> bool {
        false
    }

    fn color(&self) -> Color32 {
        Color32::TRANSPARENT
    }

    fn geometry(&self) -> PlotGeometry<'_> {
        PlotGeometry::None
    }

    fn bounds(&self) -> PlotBounds {
        self.bounds
    }

    fn base(&self) -> &PlotItemBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut PlotItemBase {
        &mut self.base
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::theme::{DARK, LIGHT};

    #[test]
    fn curves_meant_for_paper_are_seen_in_the_dark_and_keep_their_colour_in_the_light() {
        let ink = Color32::from_rgb(24, 26, 30);
        assert_eq!(readable(ink, LIGHT.inset), ink);
        assert!(contrast(readable(ink, DARK.inset), DARK.inset) > 10.0);
        let brown = Color32::from_rgb(120, 74, 18);
        assert!(contrast(readable(brown, DARK.inset), DARK.inset) >= CONTRAST);
        let bright = Color32::from_rgb(230, 160, 40);
        assert_eq!(readable(bright, DARK.inset), bright);
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 0.01);
    }

    #[test]
    fn maps_and_plots_of_any_content_are_drawn() {
        use crate::figure::Class;
        let class = |name: &str| Class {
            name: name.to_owned(),
            colour: [200, 230, 205],
        };
        let series = |points: Vec<[f64; 2]>| Series {
            name: "theory".to_owned(),
            points,
            ..Series::default()
        };
        let map = CellMap {
            title: "A map".to_owned(),
            y_scale: Scale::Logarithmic,
            x_edges: vec![0.0, 1.0, 2.0],
            y_edges: vec![0.1, 1.0, 10.0],
            cells: vec![0, 1, 1, 7],
            classes: vec![class("still"), class("growing")],
            series: vec![series(vec![[0.0, 0.2], [9.0, 90.0]])],
            ..CellMap::default()
        };
        assert_eq!(Cells::new(&map).boxes.len(), 3);
        let odd = |change: &dyn Fn(&mut CellMap)| {
            let mut map = map.clone();
            change(&mut map);
            map
        };
        let maps = [
            map.clone(),
            CellMap::default(),
            odd(&|m| m.y_edges[0] = 0.0),
            odd(&|m| m.x_edges = vec![f64::NAN; 3]),
            odd(&|m| m.x_edges = vec![1.0; 3]),
            odd(&|m| m.series = vec![series(Vec::new()), series(vec![[f64::NAN, 1.0]])]),
        ];
        let plot = |points| LinePlot {
            series: vec![series(points)],
            ..LinePlot::default()
        };
        let plots = [
            plot(Vec::new()),
            plot(vec![[1.0, 1.0]]),
            plot(vec![[0.0, 1e15], [f64::INFINITY, 1.0]]),
        ];
        let context = ChartContext {
            theme: &DARK,
            tables: &[],
        };
        egui::__run_test_ui(|ui| {
            for (i, map) in maps.iter().enumerate() {
                ui.push_id(i, |ui| map_ui(ui, &context, map));
            }
            ui.push_id("plots", |ui| plots_ui(ui, &context, &plots));
            plots_ui(ui, &context, &[]);
        });
    }

    #[test]
    fn grids_are_numbered_at_round_places_and_only_there() {
        let input = GridInput {
            bounds: (-2.2, 1.2),
            base_step_size: 0.05,
        };
        let marks = grid(input, 10, Scale::Logarithmic, false);
        let text = |m: &GridMark| number_at(*m, &(-2.2..=1.2), 10, Scale::Logarithmic, false);
        let told: Vec<String> = marks.iter().map(text).filter(|t| !t.is_empty()).collect();
        assert_eq!(told, ["0.01", "0.1", "1", "10"]);
        assert!(marks.len() > 20);
        for bounds in [
            (0.0, 0.0),
            (1.0, 1.0 + 1e-15),
            (f64::NAN, 1.0),
            (2.0, 1.0),
            (0.0, 1e300),
        ] {
            let input = GridInput {
                bounds,
                base_step_size: 1.0,
            };
            assert!(
                grid(input, 5, Scale::Linear, false).is_empty(),
                "{bounds:?}"
            );
        }
    }

    #[test]
    fn the_row_with_both_numbers_tells_what_a_point_is() {
        let mut table = Table::new("t", "T", &["model", "setting", "cost (µs)", "error (mm)"]);
        table.push(["a".into(), "fine".into(), 2.5.into(), 0.1.into()]);
        table.push(["b".into(), "".into(), 2.5.into(), 0.3.into()]);
        let tables = [table];
        assert_eq!(names_of(&tables, [2.5, 0.1]), ["a", "setting: fine"]);
        assert_eq!(names_of(&tables, [2.5, 0.3]), ["b"]);
        assert!(names_of(&tables, [2.5, 0.2]).is_empty());
    }
}
