//! The list: as many rows as are seen are drawn, however many there are.

use super::entry::{Entry, State, duration};
use super::filter::{By, Sorting};
use crate::app::theme::Theme;
use egui::{
    Align2, Color32, EventFilter, FontId, Key, Rect, Response, Sense, Stroke, TextureHandle, Ui,
    pos2, vec2,
};
use egui_material_icons::icons as icon;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Height of a row, points.
const ROW: f32 = 52.0;
/// A list at least this wide has columns, points.
pub const WIDE: f32 = 720.0;
/// Size of a thumbnail, points.
pub const THUMB: egui::Vec2 = vec2(36.0, 44.0);
/// From the left edge to the words, points.
const LEAD: f32 = 30.0 + THUMB.x + 10.0;

/// Where the list stands.
#[derive(Default)]
pub struct List {
    /// The row that the details are of.
    pub current: Option<PathBuf>,
    /// The ticked ones.
    pub ticked: BTreeSet<PathBuf>,
    /// The row that is to have the keyboard once it is drawn.
    wants_focus: Option<PathBuf>,
    offset: f32,
    height: f32,
}

/// What was asked for in the list.
#[derive(Clone, Debug, PartialEq)]
pub enum Asked {
    /// Replay it.
    Open(PathBuf),
}

/// What the list is drawn from.
pub struct Shown<'a> {
    /// All entries.
    pub entries: &'a [Entry],
    /// Those shown, in order.
    pub places: &'a [usize],
    /// The colours.
    pub theme: &'a Theme,
    /// The recording on show, where there is one.
    pub replayed: Option<&'a Path>,
}

impl List {
    /// Draws it. `picture` gives the thumbnail of an entry, once there is one; it is asked only for rows that are seen.
    pub fn ui(
        &mut self,
        ui: &mut Ui,
        shown: &Shown<'_>,
        sorting: &mut Sorting,
        picture: &mut dyn FnMut(&Entry) -> Option<TextureHandle>,
    ) -> Option<Asked> {
        let width = ui.available_width();
        let columns = (width >= WIDE).then(|| Columns::of(width - 12.0));
        if let Some(columns) = &columns {
            heads_ui(ui, shown.theme, columns, sorting);
        }
        let mut asked = None;
        let n = shown.places.len();
        let mut area = egui::ScrollArea::vertical().auto_shrink(false);
        if let Some(row) = self.wanted_row(shown) {
            let top = row as f32 * ROW;
            if top < self.offset {
                area = area.vertical_scroll_offset(top);
            } else if top + ROW > self.offset + self.height {
                area = area.vertical_scroll_offset(top + ROW - self.height);
            }
        }
        ui.spacing_mut().item_spacing.y = 0.0;
        let output = area.show_rows(ui, ROW, n, |ui, rows| {
            for row in rows {
                let Some(entry) = shown.places.get(row).and_then(|&i| shown.entries.get(i)) else {
                    continue;
                };
                let (rect, _) =
                    ui.allocate_exact_size(vec2(ui.available_width(), ROW), Sense::hover());
                asked = self
                    .row_ui(ui, rect, row, entry, shown, columns.as_ref(), picture)
                    .or(asked.take());
            }
        });
        self.offset = output.state.clamped_offset().y;
        self.height = output.inner_rect.height();
        asked
    }

    fn wanted_row(&self, shown: &Shown<'_>) -> Option<usize> {
        let wanted = self.wants_focus.as_ref()?;
        (shown.places.iter()).position(|&i| shown.entries.get(i).is_some_and(|e| e.path == *wanted))
    }

    #[expect(clippy::too_many_arguments, reason = "all of a row, and where it is")]
    fn row_ui(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        row: usize,
        entry: &Entry,
        shown: &Shown<'_>,
        columns: Option<&Columns>,
        picture: &mut dyn FnMut(&Entry) -> Option<TextureHandle>,
    ) -> Option<Asked> {
        let theme = shown.theme;
        let is_current = self.current.as_deref() == Some(&entry.path);
        let id = ui.scope_id().with(&entry.path);
        let response = ui.interact(rect, id, Sense::click());
        let spoken = entry.spoken();
        response.widget_info(|| {
            egui::WidgetInfo::selected(
                egui::accesskit::Role::ListBoxOption,
                ui.is_enabled(),
                is_current,
                &spoken,
            )
        });
        if self.wants_focus.as_deref() == Some(&entry.path) {
            self.wants_focus = None;
            response.request_focus();
        }
        let fill = if is_current {
            theme.accent.gamma_multiply(0.28)
        } else if response.hovered() {
            theme.line.gamma_multiply(0.5)
        } else if row % 2 == 1 {
            theme.inset.gamma_multiply(0.5)
        } else {
            Color32::TRANSPARENT
        };
        ui.painter().rect_filled(rect, 3.0, fill);
        if response.has_focus() {
            let ring = Stroke::new(1.5, theme.accent);
            let inside = egui::StrokeKind::Inside;
            ui.painter().rect_stroke(rect, 3.0, ring, inside);
        }
        self.tick_ui(ui, rect, entry, &spoken);
        thumb_ui(ui, rect, theme, entry, picture(entry));
        let is_open = shown.replayed == Some(&entry.path);
        match columns {
            Some(columns) => wide_words(ui, rect, theme, entry, columns, is_open),
            None => narrow_words(ui, rect, theme, entry, is_open),
        }
        self.keys(ui, &response, row, entry, shown)
            .or_else(|| {
                if response.clicked() {
                    self.current = Some(entry.path.clone());
                }
                let open = response.double_clicked() && entry.can_open();
                open.then(|| Asked::Open(entry.path.clone()))
            })
            .inspect(|_| self.current = Some(entry.path.clone()))
    }

    fn tick_ui(&mut self, ui: &mut Ui, rect: Rect, entry: &Entry, spoken: &str) {
        let place = Rect::from_center_size(
            pos2(rect.left() + 15.0, rect.center().y),
            egui::Vec2::splat(20.0),
        );
        let mut ticked = self.ticked.contains(&entry.path);
        let was = ticked;
        let check = ui
            .add_enabled_ui(entry.can_open(), |ui| {
                ui.put(place, egui::Checkbox::without_text(&mut ticked))
            })
            .inner
            .on_hover_text("Take it for a comparison or as a ghost")
            .on_disabled_hover_text("It cannot be looked into, so it cannot be compared");
        let name = format!("Tick {spoken}");
        check.widget_info(|| {
            egui::WidgetInfo::selected(
                egui::accesskit::Role::CheckBox,
                entry.can_open(),
                was,
                &name,
            )
        });
        if ticked != was {
            if ticked {
                self.ticked.insert(entry.path.clone());
            } else {
                self.ticked.remove(&entry.path);
            }
        }
    }

    /// The row that has the keyboard: arrows go from row to row, Space ticks, Enter replays.
    fn keys(
        &mut self,
        ui: &Ui,
        response: &Response,
        row: usize,
        entry: &Entry,
        shown: &Shown<'_>,
    ) -> Option<Asked> {
        if !response.has_focus() {
            return None;
        }
        let filter = EventFilter {
            vertical_arrows: true,
            ..EventFilter::default()
        };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
        if response.gained_focus() {
            self.current = Some(entry.path.clone());
        }
        let page = ((self.height / ROW) as usize).max(1);
        let last = shown.places.len().saturating_sub(1);
        let goal = ui.input(|i| {
            [
                (Key::ArrowDown, row + 1),
                (Key::ArrowUp, row.saturating_sub(1)),
                (Key::PageDown, row + page),
                (Key::PageUp, row.saturating_sub(page)),
                (Key::Home, 0),
                (Key::End, last),
            ]
            .into_iter()
            .find(|(key, _)| i.key_pressed(*key))
            .map(|(_, goal)| goal.min(last))
        });
        if let Some(next) = goal.and_then(|g| shown.entries.get(*shown.places.get(g)?)) {
            self.current = Some(next.path.clone());
            self.wants_focus = Some(next.path.clone());
            ui.ctx().request_repaint();
        }
        if ui.input(|i| i.key_pressed(Key::Space))
            && entry.can_open()
            && !self.ticked.remove(&entry.path)
        {
            self.ticked.insert(entry.path.clone());
        }
        let open = ui.input(|i| i.key_pressed(Key::Enter)) && entry.can_open();
        open.then(|| Asked::Open(entry.path.clone()))
    }
}

/// Where columns begin, from the left edge, points.
struct Columns {
    by: [(By, f32, f32); 5],
    tags: (f32, f32),
}

impl Columns {
    fn of(width: f32) -> Self {
        let room = width - LEAD;
        let shares = [
            (By::Scenario, 0.30),
            (By::Participant, 0.13),
            (By::Date, 0.20),
            (By::Duration, 0.11),
            (By::Score, 0.08),
        ];
        let mut left = LEAD;
        let by = shares.map(|(by, share)| {
            let start = left;
            left += room * share;
            (by, start, room * share)
        });
        Self {
            by,
            tags: (left, width - left),
        }
    }
}

fn heads_ui(ui: &mut Ui, theme: &Theme, columns: &Columns, sorting: &mut Sorting) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 22.0), Sense::hover());
    for (by, left, width) in columns.by {
        let place = Rect::from_min_size(
            pos2(rect.left() + left - 4.0, rect.top()),
            vec2(width, 22.0),
        );
        let on = sorting.by == by;
        let arrow = match (on, sorting.descending) {
            (false, _) => "",
            (true, true) => icon::ICON_ARROW_DROP_DOWN.codepoint,
            (true, false) => icon::ICON_ARROW_DROP_UP.codepoint,
        };
        let text = egui::RichText::new(format!("{}{arrow}", by.words())).color(theme.weak_text);
        let button = egui::Button::new(text).frame(false).truncate();
        let builder = egui::UiBuilder::new()
            .max_rect(place)
            .layout(egui::Layout::left_to_right(egui::Align::Center));
        let response = ui
            .scope_builder(builder, |ui| ui.add(button))
            .inner
            .on_hover_text("Sort by this; again turns the order round");
        let name = format!("Sort by {}", by.words().to_lowercase());
        crate::app::widgets::named(ui, &response, &name);
        if response.clicked() {
            sorting.descending = if on {
                !sorting.descending
            } else {
                by == By::Date
            };
            sorting.by = by;
        }
    }
    let at = pos2(rect.left() + columns.tags.0, rect.center().y);
    let font = egui::TextStyle::Button.resolve(ui.style());
    ui.painter()
        .text(at, Align2::LEFT_CENTER, "Tags", font, theme.weak_text);
}

fn thumb_ui(ui: &Ui, rect: Rect, theme: &Theme, entry: &Entry, texture: Option<TextureHandle>) {
    let place = Rect::from_center_size(
        pos2(rect.left() + 30.0 + THUMB.x / 2.0, rect.center().y),
        THUMB,
    );
    ui.painter().rect_filled(place, 3.0, theme.inset);
    if let Some(texture) = texture {
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture.id(), place, uv, Color32::WHITE);
        return;
    }
    let (sign, colour) = match &entry.state {
        State::Sealed => (icon::ICON_LOCK, theme.weak_text),
        State::Unreadable(_) => (icon::ICON_BROKEN_IMAGE, theme.fault),
        State::Damaged(_) => (icon::ICON_WARNING, theme.warning),
        State::Unread | State::Good => return,
    };
    let text = sign.rich_text().size(18.0).color(colour);
    let galley = egui::WidgetText::from(text).into_galley(
        ui,
        Some(egui::TextWrapMode::Extend),
        THUMB.x,
        egui::TextStyle::Body,
    );
    let at = place.center() - galley.size() * 0.5;
    ui.painter().galley(at, galley, colour);
}

/// One line of text, cut off with "…" at `width`. Answers how wide it became.
fn line(ui: &Ui, at: egui::Pos2, width: f32, text: &str, size: f32, colour: Color32) -> f32 {
    if width < 12.0 || text.is_empty() {
        return 0.0;
    }
    let mut job = egui::text::LayoutJob::simple_singleline(
        text.to_owned(),
        FontId::proportional(size),
        colour,
    );
    job.wrap = egui::text::TextWrapping::truncate_at_width(width);
    let galley = ui.ctx().fonts_mut(|f| f.layout_job(job));
    let used = galley.size().x;
    let top = at.y - galley.size().y * 0.5;
    ui.painter().galley(pos2(at.x, top), galley, colour);
    used
}

/// What is wrong with it, in a word.
fn badge(entry: &Entry, theme: &Theme, is_open: bool) -> Option<(&'static str, Color32)> {
    match &entry.state {
        State::Damaged(_) => Some(("Damaged", theme.warning)),
        State::Unreadable(_) => Some(("Cannot be read", theme.fault)),
        State::Sealed => Some(("Its trial was not answered", theme.weak_text)),
        State::Good if is_open => Some(("On show", theme.accent)),
        State::Good if entry.lost > 0 => Some(("Ticks lost", theme.warning)),
        State::Unread | State::Good => None,
    }
}

/// Tags as small plates, as many as there is room for.
fn tags(ui: &Ui, at: egui::Pos2, width: f32, theme: &Theme, entry: &Entry) {
    let mut left = at.x;
    let end = at.x + width;
    for tag in &entry.tags {
        let room = end - left - 12.0;
        if room < 24.0 {
            return;
        }
        let mut job = egui::text::LayoutJob::simple_singleline(
            tag.clone(),
            FontId::proportional(11.0),
            theme.text,
        );
        job.wrap = egui::text::TextWrapping::truncate_at_width(room);
        let galley = ui.ctx().fonts_mut(|f| f.layout_job(job));
        let size = galley.size() + vec2(10.0, 2.0);
        let plate = Rect::from_min_size(pos2(left, at.y - size.y / 2.0), size);
        let fill = theme.accent.gamma_multiply(0.25);
        ui.painter().rect_filled(plate, size.y / 2.0, fill);
        ui.painter()
            .galley(plate.min + vec2(5.0, 1.0), galley, theme.text);
        left += size.x + 4.0;
    }
}

fn wide_words(ui: &Ui, rect: Rect, theme: &Theme, entry: &Entry, columns: &Columns, is_open: bool) {
    let middle = rect.center().y;
    for (by, left, width) in columns.by {
        let at = pos2(rect.left() + left, middle);
        let width = width - 10.0;
        let text = match by {
            By::Scenario => {
                let (upper, lower) = (at - vec2(0.0, 9.0), at + vec2(0.0, 9.0));
                line(ui, upper, width, &entry.title(), 13.5, theme.text);
                let (text, colour) = match badge(entry, theme, is_open) {
                    Some((text, colour)) => (text.to_owned(), colour),
                    None => (entry.file(), theme.weak_text),
                };
                line(ui, lower, width, &text, 11.5, colour);
                continue;
            }
            By::Participant => entry.participant.clone().unwrap_or_default(),
            By::Date => entry.date(),
            By::Duration => entry.seconds.map(duration).unwrap_or_default(),
            By::Score => entry
                .score
                .as_ref()
                .map(|s| s.text.clone())
                .unwrap_or_default(),
            By::File => continue,
        };
        line(ui, at, width, &text, 12.5, theme.text);
    }
    let (left, width) = columns.tags;
    tags(
        ui,
        pos2(rect.left() + left, middle),
        width - 8.0,
        theme,
        entry,
    );
}

fn narrow_words(ui: &Ui, rect: Rect, theme: &Theme, entry: &Entry, is_open: bool) {
    let left = rect.left() + LEAD;
    let right = rect.right() - 10.0;
    let upper = rect.center().y - 10.0;
    let lower = rect.center().y + 10.0;
    let date = entry.date();
    // As wide as a date is: titles end at the same place.
    let date_left = right - 108.0;
    line(
        ui,
        pos2(date_left, upper),
        112.0,
        &date,
        11.5,
        theme.weak_text,
    );
    line(
        ui,
        pos2(left, upper),
        date_left - left - 8.0,
        &entry.title(),
        13.5,
        theme.text,
    );
    let facts: Vec<String> = [
        entry.participant.clone(),
        entry.seconds.map(duration),
        entry.score.as_ref().map(|s| s.text.clone()),
    ]
    .into_iter()
    .flatten()
    .collect();
    let mut at = left;
    if let Some((text, colour)) = badge(entry, theme, is_open) {
        at += line(ui, pos2(at, lower), right - at, text, 11.5, colour) + 10.0;
    }
    let facts = facts.join(" · ");
    let used = line(
        ui,
        pos2(at, lower),
        right - at,
        &facts,
        11.5,
        theme.weak_text,
    );
    at += used + if used > 0.0 { 10.0 } else { 0.0 };
    tags(ui, pos2(at, lower), right - at, theme, entry);
}
