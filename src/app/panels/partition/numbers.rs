//! What the box gathers, the leaf under the cursor, the tree's statistics and how full its leaves are.

use crate::app::study::Shown;
use crate::app::study::asked::{Answer, Asked, Place};
use crate::app::study::built::Built;
use crate::app::theme::Theme;
use crate::app::widgets::{bytes, grouped, time};
use crate::partition::tree::Occupancy;
use egui::{RichText, vec2};
use egui_plot::{Bar, BarChart, Plot};

/// Width of the names before the numbers, points.
const NAMES: f32 = 122.0;

/// Shows all numbers; dashes stand for what is not known yet, so that nothing moves.
pub fn show(ui: &mut egui::Ui, shown: &Shown, theme: &Theme) {
    ui.spacing_mut().item_spacing.y = 2.0;
    ui.spacing_mut().interact_size.y = 16.0;
    query_ui(ui, shown.asked.as_deref(), theme);
    ui.add_space(4.0);
    place_ui(ui, shown.place.as_ref());
    ui.add_space(4.0);
    statistics_ui(ui, shown.built.as_deref());
    ui.add_space(4.0);
    occupancy_ui(ui, shown.built.as_deref(), theme);
}

fn heading(ui: &mut egui::Ui, text: &str) {
    ui.label(RichText::new(text).strong());
}

/// A name and numbers in columns flush right.
fn line(ui: &mut egui::Ui, name: &str, why: &str, values: &[RichText]) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        let left = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(vec2(NAMES, 16.0), left, |ui| {
            ui.set_min_size(vec2(NAMES, 16.0));
            ui.label(RichText::new(name).weak()).on_hover_text(why);
        });
        let width = ((ui.available_width() - 2.0) / values.len() as f32).max(20.0);
        let right = egui::Layout::right_to_left(egui::Align::Center);
        for value in values {
            ui.allocate_ui_with_layout(vec2(width, 16.0), right, |ui| {
                ui.set_min_size(vec2(width, 16.0));
                ui.label(value.clone()).on_hover_text(why);
            });
        }
    });
}

fn number(text: Option<String>) -> RichText {
    match text {
        Some(text) => RichText::new(text).monospace(),
        None => RichText::new("–").monospace().weak(),
    }
}

fn query_ui(ui: &mut egui::Ui, asked: Option<&Asked>, theme: &Theme) {
    heading(ui, "Gathered in the box");
    let weak = |text: &str| RichText::new(text).size(11.5).weak();
    line(
        ui,
        "",
        "Both queries are asked each time the box moves",
        &[weak("Complete"), weak("As published")],
    );
    let both = |of: &dyn Fn(&Answer) -> String| {
        [
            number(asked.map(|a| of(&a.complete))),
            number(asked.map(|a| of(&a.published))),
        ]
    };
    let why = "Triangles that contact would be asked for in this haptic pass";
    line(ui, "Triangles", why, &both(&|a| grouped(a.triangles.len())));
    let why = "Nodes of the tree that the query entered, leaves included";
    line(ui, "Nodes visited", why, &both(&|a| grouped(a.cost.nodes)));
    let why = "Leaves with triangles that the query entered";
    line(
        ui,
        "Leaves visited",
        why,
        &both(&|a| grouped(a.cost.leaves)),
    );
    let why = "Median time of one query here, now";
    line(ui, "Time", why, &both(&|a| time(a.us)));
    let missed = asked.map_or(0, |a| a.missed);
    let mut lost = number(asked.map(|a| grouped(a.missed)));
    if missed > 0 {
        lost = lost.color(theme.warning);
    }
    line(
        ui,
        "Missed",
        "Triangles whose box overlaps the box that the published query does not gather: they jut out of their leaf",
        &[number(asked.map(|_| "0".into())), lost],
    );
}

fn place_ui(ui: &mut egui::Ui, place: Option<&Place>) {
    heading(ui, "Leaf under the cursor");
    let one = |of: &dyn Fn(&Place) -> String| [number(place.map(of))];
    let why = "Number of the leaf among the nodes, and levels under the root";
    let leaf = |p: &Place| format!("{}, level {}", grouped(p.leaf as usize), p.level);
    line(ui, "Leaf", why, &one(&leaf));
    let why = "Triangles that the leaf lists";
    line(ui, "Triangles", why, &one(&|p| grouped(p.held)));
    let size = |p: &Place| {
        let s = p.cell.size();
        format!("{:.1} × {:.1} × {:.1} mm", s.x, s.y, s.z)
    };
    line(
        ui,
        "Cell",
        "Edges of its cell along x, y and z",
        &one(&size),
    );
    let middle = |p: &Place| {
        let c = p.cell.centre();
        format!("{:.1}, {:.1}, {:.1} mm", c.x, c.y, c.z)
    };
    line(ui, "Middle", "Middle of its cell", &one(&middle));
    let triangle = |p: &Place| {
        let listed = if p.is_listed {
            "listed here"
        } else {
            "in another leaf"
        };
        format!("{} {listed}", p.triangle)
    };
    let why =
        "The triangle under the cursor. One that juts out of its leaf lies in the cell of another";
    line(ui, "Triangle", why, &one(&triangle));
    let why = "From the root, level by level: which side of each plane";
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        let left = egui::Layout::left_to_right(egui::Align::Min);
        // Room for two lines, so that the numbers below stay where they are.
        ui.allocate_ui_with_layout(vec2(NAMES - 40.0, 34.0), left, |ui| {
            ui.set_min_size(vec2(NAMES - 40.0, 34.0));
            ui.label(RichText::new("Path").weak()).on_hover_text(why);
        });
        let width = ui.available_width();
        ui.allocate_ui_with_layout(
            vec2(width, 34.0),
            egui::Layout::top_down(egui::Align::Max),
            |ui| {
                ui.set_min_size(vec2(width, 34.0));
                let text = place.map_or_else(|| "–".to_owned(), |p| shortened(&p.path));
                ui.add(egui::Label::new(RichText::new(text).monospace().size(11.0)).wrap())
                    .on_hover_text(place.map_or(why, |p| &p.path));
            },
        );
    });
}

/// A path in two lines at most: the middle of a long one is left out.
fn shortened(path: &str) -> String {
    const MOST: usize = 64;
    if path.is_empty() {
        return "the root".into();
    }
    if path.len() <= MOST {
        return path.to_owned();
    }
    let cut = |at: usize| path[..at].rfind(' ').unwrap_or(at);
    let from_end = path.len() - MOST / 2;
    let tail = path[from_end..]
        .find(' ')
        .map_or(from_end, |i| from_end + i);
    format!("{} …{}", &path[..cut(MOST / 2)], &path[tail..])
}

/// One line of the table of statistics: name, why one would look at it, value.
pub type Row = (&'static str, &'static str, String);

/// The table of statistics of a tree.
pub fn rows(built: &Built) -> Vec<Row> {
    let s = &built.statistics;
    let per = |n: f64| n / s.triangles.max(1) as f64;
    vec![
        (
            "Triangles",
            "Of the surface the tree is built over",
            grouped(s.triangles),
        ),
        ("Nodes", "Leaves and empty ones included", grouped(s.nodes)),
        (
            "Leaves",
            "Leaves, and how many of them hold nothing",
            format!("{}, {} empty", grouped(s.leaves), grouped(s.empty_leaves)),
        ),
        ("Height", "Levels under the root", s.height.to_string()),
        (
            "In a full leaf",
            "Mean and most triangles in a leaf that is not empty",
            format!(
                "mean {:.1}, most {}",
                s.mean_occupancy,
                grouped(s.max_occupancy)
            ),
        ),
        (
            "Above threshold",
            "Leaves whose triangles cannot be told apart",
            format!("{} leaves", grouped(s.unsplittable_leaves)),
        ),
        (
            "Entries",
            "In all leaves: pieces in case A, copies counted in case B; per triangle",
            format!("{}, {:.3} each", grouped(s.entries), per(s.entries as f64)),
        ),
        (
            "Overlap",
            "Mean number of other leaves whose loose bounds a leaf's bounds meet",
            format!("{:.1} leaves", s.mean_overlap),
        ),
        (
            "w, worst leaf",
            "Cost of finding the deepest leaf over finding it in a list: (nodes visited / nodes) · leaves",
            format!("{:.2}", s.w),
        ),
        (
            "w, complete tree",
            "The same of a complete tree of this height (Ji 2008, tables 3.3 and 3.4)",
            format!("{:.2}", s.w_complete),
        ),
        (
            "Lost as published",
            "Triangles that the published octree rule puts nowhere: no two vertices in one cell. Held here all the same",
            if built.choice.kind.has_cases() {
                "–".into()
            } else {
                grouped(s.lost_as_published)
            },
        ),
        (
            "Memory",
            "Of the tree alone, and per triangle",
            format!(
                "{}, {:.1} B each",
                bytes(s.bytes as u64),
                per(s.bytes as f64)
            ),
        ),
        (
            "Built in",
            "On one thread; counting and checking not included",
            time(built.build_us),
        ),
        (
            "Well formed",
            "The checker that every test runs, run after this build",
            built
                .fault
                .clone()
                .map_or("yes".into(), |f| format!("no: {f}")),
        ),
    ]
}

fn statistics_ui(ui: &mut egui::Ui, built: Option<&Built>) {
    heading(ui, "Tree");
    match built {
        Some(built) => {
            for (name, why, value) in rows(built) {
                line(ui, name, why, &[number(Some(value))]);
            }
        }
        None => line(ui, "Nodes", "The tree is being built", &[number(None)]),
    }
}

fn holding(o: &Occupancy) -> String {
    if o.from == o.to {
        o.from.to_string()
    } else {
        format!("{} to {}", o.from, o.to)
    }
}

fn occupancy_ui(ui: &mut egui::Ui, built: Option<&Built>, theme: &Theme) {
    let Some(built) = built else { return };
    heading(ui, "Leaves by what they hold");
    let bins = &built.statistics.occupancy;
    let labels: Vec<Occupancy> = bins.clone();
    let bars = bins
        .iter()
        .enumerate()
        .filter(|(_, o)| o.leaves > 0)
        .map(|(i, o)| {
            Bar::new(i as f64, o.leaves as f64)
                .width(0.86)
                .name(holding(o))
        })
        .collect();
    let top = bins.iter().map(|o| o.leaves).max().unwrap_or(1) as f64;
    let chart = BarChart::new("Leaves", bars)
        .color(theme.tree.leaf)
        .element_formatter(Box::new(|bar, _| {
            format!("{:.0} leaves with {} triangles", bar.value, bar.name)
        }));
    let step = (bins.len() / 6 + 1) as f64;
    let n_bins = bins.len() as f64;
    Plot::new("leaves by what they hold")
        .height(118.0)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show_crosshair(false)
        .set_margin_fraction(egui::Vec2::ZERO)
        .x_axis_label("Triangles in a leaf, at least")
        .x_grid_spacer(move |_| marks(n_bins, step))
        .x_axis_formatter(move |mark, _| {
            labels
                .get(mark.value.round().max(0.0) as usize)
                .map_or_else(String::new, |o| o.from.to_string())
        })
        .y_grid_spacer(move |_| marks(top * 1.05, nice(top / 3.0)))
        .y_axis_min_width(40.0)
        .grid_color(theme.line)
        .show(ui, |plot| {
            plot.set_plot_bounds_x(-0.7..=n_bins - 0.3);
            plot.set_plot_bounds_y(0.0..=top * 1.1);
            plot.bar_chart(chart);
        });
}

fn nice(step: f64) -> f64 {
    crate::app::panels::back_view::model::round_below(step.max(1.0)).unwrap_or(1.0)
}

fn marks(top: f64, step: f64) -> Vec<egui_plot::GridMark> {
    (0..32)
        .map(|i| f64::from(i) * step)
        .take_while(|value| *value <= top)
        .map(|value| egui_plot::GridMark {
            value,
            step_size: top,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_keeps_its_ends_and_whole_turns() {
        let turns: Vec<String> = (0..60)
            .map(|i| format!("+{}", ["x", "y", "z"][i % 3]))
            .collect();
        let short = shortened(&turns.join(" "));
        assert!(short.len() <= 72, "{short}");
        let ok = |t: &str| t == "…" || (t.len() == 2 && t.starts_with('+'));
        assert!(
            short
                .split(' ')
                .all(|t| ok(t.trim_start_matches('…')) || t == "…"),
            "{short}"
        );
        assert_eq!(shortened("+x -y"), "+x -y");
        assert_eq!(shortened(""), "the root");
    }
}
