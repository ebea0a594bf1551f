//! The chosen dysfunction in numbers and words.

use super::doc::{set_half_axis, set_kind, tidy_angle};
use super::{State, add, place, strength};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::{choose, row};
use crate::app::panels::PanelContext;
use crate::app::widgets::named;
use crate::geom::curve;
use crate::scenario::Dysfunction;
use egui::RichText;
use std::ops::RangeInclusive;

/// Shows it.
pub fn show(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State, index: usize) {
    let Some(d) = state.editing.doc().list.get(index).cloned() else {
        return;
    };
    let of = format!("dysfunction {}", index + 1);
    kind(ui, state, &d, index, &of);
    place::show(ui, cx, state, &d, index, &of);
    extent(ui, state, &d, index, &of);
    row(
        ui,
        "Severity",
        "0 none or background, 1 minor, 2 obvious, 3 the key lesion: its kind says how strong that is",
        |ui| {
            if let Some(severity) = add::severities(ui, &of, d.severity) {
                set(state, index, "Change severity", |d| d.severity = severity);
            }
            ui.weak(super::wording::severity(d.severity));
        },
    );
    strength::show(ui, cx, state, &d, index, &of);
    seed(ui, state, &d, index, &of);
}

/// Does `change` to a dysfunction in one step.
pub fn set(
    state: &mut State,
    index: usize,
    what: &'static str,
    change: impl FnOnce(&mut Dysfunction),
) {
    let doc = state.editing.doc().with(index, change);
    state.editing.set(what, doc);
}

/// A number of a dysfunction.
pub struct Number<'a> {
    /// What it is, with a capital.
    pub what: &'a str,
    /// What it is for.
    pub why: &'a str,
    /// What is allowed.
    pub range: RangeInclusive<f64>,
    /// Decimals shown.
    pub decimals: usize,
    /// Its unit; empty for a plain one.
    pub unit: &'a str,
    /// Change per point of a drag.
    pub speed: f64,
}

/// Shows a number and takes what a hand does to it.
pub fn number(
    ui: &mut egui::Ui,
    state: &mut State,
    index: usize,
    of: &str,
    number: &Number<'_>,
    value: f64,
    change: impl FnOnce(&mut Dysfunction, f64),
) {
    let unit = if number.unit.is_empty() {
        String::new()
    } else {
        format!(", {}", number.unit)
    };
    let name = format!("{} of {of}{unit}", number.what);
    let (least, most) = (number.range.start(), number.range.end());
    let tooltip = format!("{}; {least} to {most} is allowed", number.why);
    let cell = Cell {
        name: &name,
        tooltip: &tooltip,
        range: number.range.clone(),
        decimals: number.decimals,
        unit: number.unit,
        speed: number.speed,
        width: 76.0,
    };
    let edit = cells::number(ui, &cell, value);
    state.editing.take(edit, "Change dysfunction", |doc, v| {
        doc.with(index, |d| change(d, v))
    });
}

/// A button that gives a value back to the kind; disabled where it is the kind's already.
pub fn as_kind(ui: &mut egui::Ui, what: &str, is_default: bool) -> bool {
    let text = if is_default { "by kind" } else { "stated" };
    let button = ui
        .add_enabled(
            !is_default,
            egui::Button::new(RichText::new(text).size(11.5)),
        )
        .on_hover_text("Stated here; click to take what the kind says")
        .on_disabled_hover_text("What the kind says; change it to state another");
    named(ui, &button, &format!("{what} as the kind says"));
    button.clicked()
}

fn kind(ui: &mut egui::Ui, state: &mut State, d: &Dysfunction, index: usize, of: &str) {
    let width = (ui.available_width() - 110.0).clamp(90.0, 240.0);
    let Some(kind) = d.kind() else {
        return;
    };
    row(ui, "Kind", kind.about(), |ui| {
        let name = format!("Kind of {of}");
        let items = add::kinds(d.kind);
        if let Some(kind) = choose(ui, &name, kind.about(), kind.title(), width, items) {
            set(state, index, "Change kind", |d| set_kind(d, kind));
        }
    });
    if kind.presets().is_empty() {
        return;
    }
    let now = kind.presets().iter().find(|p| Some(p.key) == d.preset);
    let why = now.map_or("The kind chooses by the place", |p| p.about);
    row(ui, "Form", why, |ui| {
        let by_place =
            (!kind.needs_preset()).then(|| ("By the place".to_owned(), now.is_none(), None));
        let items = kind.presets().iter();
        let items = items.map(|p| (p.title.to_owned(), Some(p.key) == d.preset, Some(p.key)));
        let text = now.map_or("By the place", |p| p.title);
        let items = by_place.into_iter().chain(items);
        if let Some(preset) = choose(ui, &format!("Form of {of}"), why, text, width, items) {
            set(state, index, "Change form", |d| d.preset = preset);
        }
    });
}

fn extent(ui: &mut egui::Ui, state: &mut State, d: &Dysfunction, index: usize, of: &str) {
    let Some(default) = d.kind().map(|k| k.default_at(d.place.clone(), d.severity)) else {
        return;
    };
    row(ui, "Extent", "Half axes of the ellipse, mm", |ui| {
        for (which, what) in ["First half axis", "Second half axis"]
            .into_iter()
            .enumerate()
        {
            let cell = Number {
                what,
                why: what,
                range: 1.0..=300.0,
                decimals: 1,
                unit: "mm",
                speed: 0.3,
            };
            number(ui, state, index, of, &cell, d.radius_mm[which], |d, v| {
                set_half_axis(d, which, v);
            });
        }
        if as_kind(ui, "Extent", d.radius_mm == default.radius_mm) {
            set(state, index, "Change extent", |d| {
                d.radius_mm = default.radius_mm
            });
        }
    });
    let why = "Direction of the first half axis: 0° points away from the midline, 90° to the head; the same number on \
               both sides is a mirror image";
    row(ui, "Angle", why, |ui| {
        let cell = Number {
            what: "Angle",
            why,
            range: -360.0..=360.0,
            decimals: 1,
            unit: "°",
            speed: 0.5,
        };
        number(ui, state, index, of, &cell, d.angle_deg, |d, v| {
            d.angle_deg = tidy_angle(v);
        });
        if as_kind(ui, "Angle", d.angle_deg == default.angle_deg) {
            set(state, index, "Turn dysfunction", |d| {
                d.angle_deg = default.angle_deg
            });
        }
    });
    row(
        ui,
        "Falloff",
        "How it fades from its centre to its rim",
        |ui| {
            let items = curve::all().iter();
            let items = items.map(|(n, _)| ((*n).to_owned(), *n == d.profile, *n));
            let why = "The curve from the centre to the rim";
            let name = format!("Falloff of {of}");
            if let Some(profile) = choose(ui, &name, why, &d.profile, 92.0, items) {
                set(state, index, "Change falloff", |d| {
                    profile.clone_into(&mut d.profile)
                });
            }
            if as_kind(ui, "Falloff", d.profile == default.profile) {
                set(state, index, "Change falloff", |d| {
                    d.profile = default.profile
                });
            }
        },
    );
}

fn seed(ui: &mut egui::Ui, state: &mut State, d: &Dysfunction, index: usize, of: &str) {
    let why = "With a seed place, extent and angle vary a little, as patients differ: by up to 2 mm, 10 % and 10°";
    row(ui, "Varies", why, |ui| {
        let mut on = d.seed.is_some();
        let toggle = ui.checkbox(&mut on, "by seed").on_hover_text(why);
        named_box(ui, &toggle, on, &format!("{} varies by seed", capital(of)));
        if toggle.changed() {
            set(state, index, "Change seed", |d| d.seed = on.then_some(1));
        }
        if let Some(seed) = d.seed {
            let cell = Number {
                what: "Seed",
                why: "Another seed, another variation",
                range: 0.0..=1e9,
                decimals: 0,
                unit: "",
                speed: 1.0,
            };
            number(ui, state, index, of, &cell, seed as f64, |d, v| {
                d.seed = Some(v.round().max(0.0) as u64);
            });
        }
    });
}

/// Gives a check box the name a screen reader says.
pub fn named_box(ui: &egui::Ui, response: &egui::Response, on: bool, name: &str) {
    response.widget_info(|| {
        let role = egui::accesskit::Role::CheckBox;
        egui::WidgetInfo::selected(role, ui.is_enabled(), on, name)
    });
}

/// With a capital.
fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars
        .next()
        .map_or(String::new(), |c| c.to_uppercase().chain(chars).collect())
}
