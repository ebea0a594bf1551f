//! Beside the canvas: keys, settings of the map, what is shown, section, location ratio, files.

use super::doc::Doc;
use super::show::{Maps, Quantity, Show};
use super::{State, figures, table};
use crate::app::bench::Wake;
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::csv;
use crate::app::editor::field::Picture;
use crate::app::editor::files::{self, Wish};
use crate::app::editor::parts::{fold, fold_as, pick, row};
use crate::app::editor::section::{Series, span_of};
use crate::app::panels::PanelContext;
use crate::app::widgets::{icon_button, named};
use crate::geom::Vec2;
use crate::maps::appendix::{self, Force, Means};
use crate::maps::ellipse::{BASIC_RADII_MM, EFFECT_RADII_MM, HALF_AXES_MM};
use crate::maps::{AngleRule, Form, Level};
use egui::RichText;
use egui_material_icons::icons as icon;

/// What is known of the drags behind the data: shown wherever the map is.
pub const CAVEAT: &str = "All drags behind these data ran along the spine, and even an isotropic half-space gives longer contours \
    along a drag. So drag direction and muscle direction are confounded in them: they cannot be told apart.";

/// Shows it all.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    state: &mut State,
    wake: &Wake,
    editable: bool,
) {
    let theme = &cx.view.theme;
    ui.spacing_mut().item_spacing.y = 4.0;
    state.editing.fault_ui(ui, theme);
    if let Some((text, about)) = state.figure {
        ui.horizontal(|ui| {
            ui.strong(text);
            let why = "Forget which figure was loaded; its keys stay";
            if icon_button(ui, icon::ICON_CLOSE, "Close the figure's note", why).clicked() {
                state.figure = None;
            }
        });
        ui.label(RichText::new(about).size(12.0).weak());
        ui.separator();
    }
    if !state.editing.doc().on {
        absent(ui, state, editable);
        return;
    }
    fold(ui, "Keys", true, |ui| {
        table::show(ui, theme, &mut state.editing, editable);
        table::chosen(ui, theme, &mut state.editing, editable);
    });
    fold(ui, "Map", true, |ui| {
        ui.add_enabled_ui(editable, |ui| settings(ui, state));
    });
    fold(ui, "Show", true, |ui| shown(ui, &mut state.show));
    let now = state.open_section.take();
    let section = fold_as(ui, "Section", false, now, |ui| section(ui, cx, state));
    state.section.on = section;
    fold(ui, "Location ratio", false, |ui| {
        state.ratio.show(ui, theme, wake);
    });
    fold(ui, "File", false, |ui| file(ui, cx, state, editable));
    ui.label(RichText::new(CAVEAT).size(11.5).weak());
}

fn absent(ui: &mut egui::Ui, state: &mut State, editable: bool) {
    ui.label(RichText::new("No ellipse map").strong());
    ui.label("This scenario has none: a drag carries the skin equally far all around, in the basic circle.");
    ui.add_enabled_ui(editable, |ui| {
        let add = ui.button("Add the seven keys of appendix C").on_hover_text(
            "Means over the subjects, upward force, on the levels of the built-in back",
        );
        if add.clicked() {
            let keys = appendix::seven_keys(Force::Up, None);
            let doc = state.editing.doc().with_keys(keys);
            state.editing.set("Add map", doc);
        }
        let add = ui
            .button("Add a map without keys")
            .on_hover_text("The basic circle everywhere; double-click the canvas to add keys");
        if add.clicked() {
            let doc = state.editing.doc().with_keys(Vec::new());
            state.editing.set("Add map", doc);
        }
    });
    ui.label(RichText::new(CAVEAT).size(11.5).weak());
}

fn settings(ui: &mut egui::Ui, state: &mut State) {
    let now = state.editing.doc().settings;
    for (name, why, value, range, basic) in [
        (
            "Basic circle",
            "Radius of the footprint far from every key; 140 mm is ours, none is printed for the back",
            now.basic_radius_mm,
            BASIC_RADII_MM,
            true,
        ),
        (
            "Effect radius",
            "How far from a key it has an effect; 200 mm is ours, none is printed for the back",
            now.effect_radius_mm,
            EFFECT_RADII_MM,
            false,
        ),
    ] {
        row(ui, name, why, |ui| {
            let said = format!("{name}, mm");
            let tooltip = format!("{why}. {} to {} mm is allowed", range.start(), range.end());
            let cell = Cell {
                name: &said,
                tooltip: &tooltip,
                range,
                decimals: 1,
                unit: "mm",
                speed: 0.5,
                width: 86.0,
            };
            let edit = cells::number(ui, &cell, value);
            state.editing.take(edit, "Change map", |doc, v| {
                doc.with_settings(|s| {
                    if basic {
                        s.basic_radius_mm = v;
                    } else {
                        s.effect_radius_mm = v;
                    }
                })
            });
        });
    }
    let mut next = now;
    row(ui, "Form", "How the effects of several keys stack", |ui| {
        for form in Form::all() {
            let (text, why) = match form {
                Form::Corrected => ("Corrected", "Eq. 5.16: exact at every key"),
                Form::Published => (
                    "Published",
                    "Eq. 5.7 as first derived: misses keys that lie in range of each other",
                ),
            };
            if pick(ui, now.form == *form, text, &format!("{text} form"), why) {
                next.form = *form;
            }
        }
    });
    row(ui, "Angle", "How directions are put together", |ui| {
        for rule in AngleRule::all() {
            let (text, why) = match rule {
                AngleRule::Tensor => (
                    "Tensor",
                    "By the double angle: 5° and 175° meet at 0°, whichever of two equal angles a file states",
                ),
                AngleRule::Linear => (
                    "Linear",
                    "As published, linear in degrees: 5° and 175° meet at 90°",
                ),
            };
            if pick(ui, now.angle == *rule, text, &format!("{text} angle"), why) {
                next.angle = *rule;
            }
        }
    });
    row(ui, "Level", "How the effect of a key falls off", |ui| {
        for level in Level::all() {
            let (text, why) = match level {
                Level::Exact => ("Exact", "The Gaussian itself"),
                Level::Array => ("Array of 700", "As printed: the nearest of 700 samples"),
            };
            if pick(ui, now.level == *level, text, &format!("{text} level"), why) {
                next.level = *level;
            }
        }
    });
    if next != now {
        let doc = state.editing.doc().with_settings(|s| *s = next);
        state.editing.set("Change map", doc);
    }
    ui.horizontal_wrapped(|ui| {
        appendix_menu(ui, state);
        let remove = ui
            .button("Remove map")
            .on_hover_text("Back to the basic circle everywhere; undo brings the map back");
        named(ui, &remove, "Remove the ellipse map");
        if remove.clicked() {
            let doc = Doc {
                on: false,
                ..state.editing.doc().clone()
            };
            state.editing.set("Remove map", doc);
        }
    });
}

fn appendix_menu(ui: &mut egui::Ui, state: &mut State) {
    let last = appendix::rows().iter().map(|r| r.subject).max();
    let menu = ui.menu_button("Load appendix C", |ui| {
        ui.set_min_width(260.0);
        for force in Force::all() {
            let direction = force.name();
            let mut choices = vec![
                (format!("Force {direction}, means as printed"), Means::Printed, None),
                (format!("Force {direction}, means by axes"), Means::Axial, None),
            ];
            for n in 1..=last.unwrap_or_default() {
                let text = format!("Force {direction}, subject {n}");
                choices.push((text, Means::Axial, Some(n)));
            }
            for (text, means, subject) in choices {
                let keys = appendix::seven_keys_by(means, *force, subject);
                let why = match (keys.is_empty(), subject, means) {
                    (true, ..) => "Not measured",
                    (_, Some(_), _) => "The keys of this subject alone",
                    (_, None, Means::Printed) => {
                        "Means over the subjects as the dissertation takes them: directions as plain numbers"
                    }
                    (_, None, Means::Axial) => {
                        "Means with the longer axis as the major one and directions as axes"
                    }
                };
                let item = ui
                    .add_enabled(!keys.is_empty(), egui::Button::new(&text))
                    .on_hover_text(format!("{why}. Undo brings yours back"))
                    .on_disabled_hover_text(why);
                if item.clicked() {
                    let doc = state.editing.doc().with_keys(keys);
                    state.editing.set("Load appendix C", doc);
                    ui.close();
                }
            }
            if *force == Force::Up {
                ui.separator();
            }
        }
    });
    menu.response
        .on_hover_text("Put the measured keys of the dissertation in place of those here");
}

fn shown(ui: &mut egui::Ui, show: &mut Show) {
    row(
        ui,
        "Quantity",
        "Which value is shown as colour and lines",
        |ui| {
            for q in Quantity::ALL {
                if pick(ui, show.quantity == q, q.text(), q.text(), q.about()) {
                    show.quantity = q;
                }
            }
        },
    );
    row(
        ui,
        "Of",
        "The map itself, or how far the published one is off",
        |ui| {
            if pick(
                ui,
                !show.difference,
                "The map",
                "Show the map",
                "As the form above says",
            ) {
                show.difference = false;
            }
            let why = "Published less corrected form of the same keys, everything else as printed";
            let text = "Published − corrected";
            if pick(
                ui,
                show.difference,
                text,
                "Show published less corrected",
                why,
            ) {
                show.difference = true;
            }
        },
    );
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut show.colour, "Colour")
            .on_hover_text("The value as colour");
        ui.checkbox(&mut show.lines, "Lines")
            .on_hover_text("Lines of equal value");
        ui.checkbox(&mut show.ellipses, "Ellipses")
            .on_hover_text("A grid of ellipses, all to one scale");
        ui.checkbox(&mut show.keys, "Keys")
            .on_hover_text("The keys' ellipses with their handles");
        ui.checkbox(&mut show.reach, "Radii")
            .on_hover_text("Effect radius and basic circle about the chosen key");
        ui.checkbox(&mut show.outline, "Back")
            .on_hover_text("Outline and landmarks of the back");
        ui.checkbox(&mut show.veiled, "Dim beside it")
            .on_hover_text("Dim the map where there is no skin");
    });
    row(
        ui,
        "Keys drawn at",
        "Size of the keys' ellipses; at 100 % they overlap",
        |ui| {
            let mut percent = show.key_size * 100.0;
            ui.spacing_mut().slider_width = (ui.available_width() - 70.0).clamp(40.0, 160.0);
            let slider = ui
                .add(
                    egui::Slider::new(&mut percent, 5.0..=100.0)
                        .suffix(" %")
                        .fixed_decimals(0),
                )
                .on_hover_text("Part of their true size on the canvas");
            ui.ctx().accesskit_node_builder(slider.id, |node| {
                node.set_label("Size of the keys' ellipses, percent");
            });
            show.key_size = percent / 100.0;
        },
    );
}

fn section(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State) {
    let Some(picture) = state.field.picture().cloned() else {
        ui.weak("The map is being worked out");
        return;
    };
    let theme = &cx.view.theme;
    let quantity = state.show.quantity;
    let of = |f: &dyn Fn(&Maps, Vec2) -> f64| state.section.values(|p| f(&picture.map, p));
    let series = [
        Series {
            name: "in use",
            colour: theme.accent,
            dashed: false,
            values: of(&|m, p| quantity.of(&m.map.at(p))),
        },
        Series {
            name: "published",
            colour: theme.warning,
            dashed: true,
            values: of(&|m, p| quantity.of(&m.published.at(p))),
        },
        Series {
            name: "corrected",
            colour: theme.weak_text,
            dashed: true,
            values: of(&|m, p| quantity.of(&m.corrected.at(p))),
        },
    ];
    let span = span_of(&series);
    let unit = quantity.unit();
    state
        .section
        .plot(ui, theme, "Section of the ellipse map", unit, span, &series);
    ui.weak("Drag the ends A and B on the canvas");
}

fn file(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State, editable: bool) {
    let wish = state
        .files
        .ui(ui, cx, "ellipse keys", "ellipse_keys.csv", editable);
    match wish {
        Some((Wish::Export, path)) => {
            let text = csv::write_ellipses(&state.editing.doc().keys);
            files::export(cx, &path, &text, "Ellipse keys");
        }
        Some((Wish::Import, path)) if editable => {
            let read = csv::load(&path).and_then(|text| {
                csv::ellipse_keys(&text, &path.display().to_string(), &HALF_AXES_MM)
            });
            let checked = read.and_then(|keys| {
                let doc = state.editing.doc().with_keys(keys);
                let map = doc.map().map_err(|e| format!("{}: {e}", path.display()));
                map.map(|_| doc)
            });
            match checked {
                Ok(doc) => state.editing.set("Import keys", doc),
                Err(fault) => state.editing.told = Some(fault),
            }
        }
        _ => {}
    }
}

/// The menu of printed figures.
pub fn figures_menu(ui: &mut egui::Ui, state: &mut State, editable: bool) {
    let menu = ui.menu_button("Figures", |ui| {
        ui.set_min_width(280.0);
        for figure in figures::all(state.editing.doc()) {
            let item = ui
                .add_enabled(editable, egui::Button::new(figure.text))
                .on_hover_text(format!(
                    "{}. Loads its keys and view; undo brings yours back",
                    figure.about
                ));
            if item.clicked() {
                state.editing.set("Load figure", figure.doc);
                state.editing.selected = None;
                state.show = figure.show;
                state.canvas.fit(figure.frame);
                state.figure = Some((figure.text, figure.about));
                state.open_section = Some(figure.section.is_some());
                if let Some(ends) = figure.section {
                    state.section.ends = ends;
                }
                state.section.on = figure.section.is_some();
                ui.close();
            }
        }
    });
    menu.response
        .on_hover_text("The printed maps of chapter 5 as views");
}

/// The value under the pointer, and what it is.
pub fn told(show: &Show, picture: Option<&Picture<Maps>>, cursor_mm: Option<Vec2>) -> String {
    let Some(p) = cursor_mm else {
        return String::new();
    };
    let place = format!("x {:>6.1}  y {:>6.1} mm", p.x, p.y);
    let Some(picture) = picture else {
        return place;
    };
    if show.difference {
        let value = picture.map.value(show, p);
        let (q, unit) = (show.quantity, show.quantity.unit());
        return format!(
            "{place}  difference {value:>+8.0$} {unit}",
            q.decimals() + 1
        );
    }
    let o = picture.map.map.at(p);
    format!(
        "{place}  {:>5.1} × {:>5.1} mm  ratio {:.3}  {:>5.1}°",
        o.half_major_mm,
        o.half_minor_mm,
        o.major_over_minor(),
        o.angle_rad.to_degrees()
    )
}
