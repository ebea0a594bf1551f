//! Tables: sorted by a click on a head, text that can be selected, copied as CSV.

use crate::app::theme::Theme;
use crate::app::widgets::named;
use crate::lab::{Table, Value};
use egui::{Align, Layout, Rect, RichText, TextStyle, pos2, vec2};
use egui_material_icons::icons as icon;
use std::cmp::Ordering;
use std::collections::HashMap;

/// Height of a row, points.
const ROW: f32 = 20.0;
/// Between columns, points.
const BETWEEN: f32 = 18.0;
/// Most rows seen at once; more are scrolled.
const MOST_ROWS: usize = 16;

/// Experiment and table.
type Key = (String, String);

/// How each table is sorted and laid out.
#[derive(Default)]
pub struct Tables(HashMap<Key, Laid>);

#[derive(Default)]
struct Laid {
    /// Of which answer.
    number: u64,
    /// Column, and whether the largest stands first.
    sorted: Option<(usize, bool)>,
    order: Vec<usize>,
    /// Text of every cell, row by row.
    text: Vec<Vec<String>>,
    widths: Vec<f32>,
    is_text: Vec<bool>,
}

impl Laid {
    fn new(ui: &egui::Ui, table: &Table, number: u64, sorted: Option<(usize, bool)>) -> Self {
        let text: Vec<Vec<String>> = (table.rows().iter())
            .map(|row| row.iter().map(Value::short).collect())
            .collect();
        let is_text: Vec<bool> = (0..table.columns().len())
            .map(|i| table.rows().iter().any(|r| matches!(r[i], Value::Text(_))))
            .collect();
        let body = TextStyle::Body.resolve(ui.style());
        let mono = TextStyle::Monospace.resolve(ui.style());
        let wide = |text: &str, font: &egui::FontId| {
            let colour = egui::Color32::WHITE;
            let galley = ui
                .painter()
                .layout_no_wrap(text.to_owned(), font.clone(), colour);
            galley.size().x
        };
        let widths = (0..table.columns().len())
            .map(|i| {
                let font = if is_text[i] { &body } else { &mono };
                let column = &table.columns()[i];
                // Room for the arrow beside the name.
                let head = wide(&column.name, &body) + 22.0;
                let unit = wide(&column.unit, &body);
                let cells = text.iter().map(|row| wide(&row[i], font));
                cells.fold(head.max(unit), f32::max).ceil()
            })
            .collect();
        let mut laid = Self {
            number,
            sorted,
            order: Vec::new(),
            text,
            widths,
            is_text,
        };
        laid.sort(table);
        laid
    }

    fn sort(&mut self, table: &Table) {
        self.order = order(table, self.sorted);
    }

    fn width(&self) -> f32 {
        self.widths.iter().map(|w| w + BETWEEN).sum()
    }
}

/// The rows of a table, sorted by a column: numbers by size, names by letters, nothing always last.
fn order(table: &Table, sorted: Option<(usize, bool)>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..table.rows().len()).collect();
    if let Some((column, descending)) = sorted {
        order.sort_by(|&a, &b| {
            let (a, b) = (&table.rows()[a][column], &table.rows()[b][column]);
            compare(a, b, descending)
        });
    }
    order
}

fn compare(a: &Value, b: &Value, descending: bool) -> Ordering {
    let turned = |order: Ordering| if descending { order.reverse() } else { order };
    match (a, b) {
        (Value::Empty, Value::Empty) => Ordering::Equal,
        (Value::Empty, _) => Ordering::Greater,
        (_, Value::Empty) => Ordering::Less,
        (Value::Text(a), Value::Text(b)) => turned(a.cmp(b)),
        (Value::Text(_), _) => turned(Ordering::Greater),
        (_, Value::Text(_)) => turned(Ordering::Less),
        (a, b) => {
            let number = |v: &Value| v.number().unwrap_or(f64::NAN);
            turned(number(a).total_cmp(&number(b)))
        }
    }
}

impl Tables {
    /// Shows a table of the answer `number`.
    pub fn show(&mut self, ui: &mut egui::Ui, key: Key, number: u64, table: &Table, theme: &Theme) {
        let salt = key.clone();
        let laid = self.0.entry(key).or_default();
        if laid.number != number {
            let kept = laid.sorted.filter(|(i, _)| *i < table.columns().len());
            *laid = Laid::new(ui, table, number, kept);
        }
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            let copy = ui
                .add(egui::Button::new((icon::ICON_CONTENT_COPY.rich_text(), "CSV")).small())
                .on_hover_text("Copy the whole table as CSV, with every digit");
            named(ui, &copy, &format!("Copy {} as CSV", table.name));
            if copy.clicked()
                && let Ok(csv) = table.csv()
            {
                ui.ctx()
                    .copy_text(String::from_utf8_lossy(&csv).into_owned());
            }
            ui.add(egui::Label::new(&table.title).truncate());
        });
        egui::Frame::new()
            .fill(theme.inset)
            .corner_radius(4.0)
            .inner_margin(egui::Margin::symmetric(8, 5))
            .show(ui, |ui| {
                ui.set_width(ui.available_width());
                ui.push_id(salt, |ui| {
                    egui::ScrollArea::horizontal()
                        .auto_shrink([false, true])
                        .show(ui, |ui| grid_ui(ui, table, laid, theme));
                });
            });
    }
}

fn grid_ui(ui: &mut egui::Ui, table: &Table, laid: &mut Laid, theme: &Theme) {
    let width = laid.width();
    ui.set_min_width(width);
    ui.spacing_mut().item_spacing = vec2(0.0, 0.0);
    head_ui(ui, table, laid, theme);
    let rows = laid.order.len();
    let height = rows.min(MOST_ROWS) as f32 * ROW;
    egui::ScrollArea::vertical()
        .max_height(height)
        .min_scrolled_height(height)
        .auto_shrink([false, true])
        .show_rows(ui, ROW, rows, |ui, range| {
            for i in range {
                let (rect, _) = ui.allocate_exact_size(vec2(width, ROW), egui::Sense::hover());
                if i % 2 == 1 {
                    let stripe = rect.expand2(vec2(4.0, 0.0));
                    ui.painter().rect_filled(stripe, 2.0, theme.panel);
                }
                let row = laid.order[i];
                cells(laid, rect, |at, column| {
                    let text = &laid.text[row][column];
                    let text = match laid.is_text[column] {
                        true => RichText::new(text),
                        false => RichText::new(text).monospace(),
                    };
                    cell_ui(ui, at, laid.is_text[column], |ui| {
                        ui.add(egui::Label::new(text).selectable(true).extend());
                    });
                });
            }
        });
}

fn head_ui(ui: &mut egui::Ui, table: &Table, laid: &mut Laid, theme: &Theme) {
    let has_units = table.columns().iter().any(|c| !c.unit.is_empty());
    let height = if has_units {
        2.0 * ROW - 4.0
    } else {
        ROW + 2.0
    };
    let (rect, _) = ui.allocate_exact_size(vec2(laid.width(), height), egui::Sense::hover());
    let mut clicked = None;
    cells(laid, rect, |at, i| {
        let column = &table.columns()[i];
        let (name, unit) = at.split_top_bottom_at_y(at.top() + ROW);
        cell_ui(ui, name, laid.is_text[i], |ui| {
            let name = RichText::new(&column.name).strong();
            let arrow = match laid.sorted {
                Some((of, true)) if of == i => Some(icon::ICON_ARROW_DOWNWARD),
                Some((of, false)) if of == i => Some(icon::ICON_ARROW_UPWARD),
                _ => None,
            };
            let button = match arrow {
                Some(arrow) => egui::Button::new((name, arrow.rich_text().size(12.0))),
                None => egui::Button::new(name),
            };
            let head = ui
                .add(button.frame(false).min_size(vec2(0.0, ROW)))
                .on_hover_text(format!(
                    "Sort by {column}; again: the other way round; a third time: as it was"
                ));
            named(
                ui,
                &head,
                &format!("Sort {} by {}", table.name, column.name),
            );
            if head.clicked() {
                clicked = Some(i);
            }
        });
        if !column.unit.is_empty() {
            cell_ui(ui, unit, laid.is_text[i], |ui| {
                ui.label(RichText::new(&column.unit).weak().size(11.5));
            });
        }
    });
    let y = rect.bottom() - 1.0;
    ui.painter()
        .hline(rect.x_range(), y, egui::Stroke::new(1.0, theme.line));
    if let Some(i) = clicked {
        // Numbers: the smallest first, for most of them are costs and errors.
        laid.sorted = match laid.sorted {
            Some((of, false)) if of == i => Some((i, true)),
            Some((of, true)) if of == i => None,
            _ => Some((i, false)),
        };
        laid.sort(table);
    }
}

/// Calls `draw` with the place of each column's cell in a row.
fn cells(laid: &Laid, row: Rect, mut draw: impl FnMut(Rect, usize)) {
    let mut left = row.left();
    for (i, width) in laid.widths.iter().enumerate() {
        let rect = Rect::from_min_max(pos2(left, row.top()), pos2(left + width, row.bottom()));
        draw(rect, i);
        left += width + BETWEEN;
    }
}

fn cell_ui(ui: &mut egui::Ui, rect: Rect, left: bool, add: impl FnOnce(&mut egui::Ui)) {
    let layout = match left {
        true => Layout::left_to_right(Align::Center),
        false => Layout::right_to_left(Align::Center),
    };
    let mut cell = ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(layout));
    add(&mut cell);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_sorted_by_size_names_by_letters_and_nothing_stands_last() {
        let mut table = Table::new("t", "T", &["name", "cost (µs)"]);
        table.push(["b".into(), 10.0.into()]);
        table.push(["a".into(), Value::Empty]);
        table.push(["c".into(), 9_usize.into()]);
        table.push(["".into(), (-1.0).into()]);
        let sorted = |column, descending| order(&table, Some((column, descending)));
        assert_eq!(order(&table, None), [0, 1, 2, 3]);
        assert_eq!(sorted(1, false), [3, 2, 0, 1]);
        assert_eq!(sorted(1, true), [0, 2, 3, 1]);
        assert_eq!(sorted(0, false), [3, 1, 0, 2]);
        assert_eq!(sorted(0, true), [2, 0, 1, 3]);
    }
}
