//! Which tree, where its box stands, what is drawn of it.

use super::PanelContext;
use crate::app::panels::legend::swatch;
use crate::app::study::settings::{Boxes, EDGE_PARTS, Follow, Kind, Query, Settings, THRESHOLDS};
use crate::app::study::{Shown, longest_edge_mm};
use crate::app::widgets::named;
use crate::partition::tree::Case;
use crate::scenario::Scene;
use egui::{RichText, vec2};

/// Width of the names before the controls, points.
const NAMES: f32 = 74.0;

/// Shows the controls; what is chosen goes into `settings`.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    scene: &Scene,
    shown: &Shown,
    settings: &mut Settings,
) {
    ui.spacing_mut().item_spacing.y = 4.0;
    tree_ui(ui, settings);
    status_ui(ui, cx, shown);
    ui.separator();
    box_ui(ui, cx, scene, shown, settings);
    ui.separator();
    show_ui(ui, cx, shown, settings);
}

/// A row with its name.
fn row<R>(
    ui: &mut egui::Ui,
    name: &str,
    why: &str,
    add: impl FnOnce(&mut egui::Ui, egui::Id) -> R,
) -> R {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let label = ui
            .allocate_ui_with_layout(
                vec2(NAMES, 20.0),
                egui::Layout::left_to_right(egui::Align::Center),
                |ui| {
                    ui.set_min_width(NAMES);
                    ui.label(RichText::new(name).weak()).on_hover_text(why)
                },
            )
            .inner;
        add(ui, label.id)
    })
    .inner
}

/// One of several; true when it was picked.
fn pick(ui: &mut egui::Ui, on: bool, text: &str, name: &str, why: &str) -> bool {
    let response = ui.selectable_label(on, text);
    response.widget_info(|| {
        egui::WidgetInfo::selected(
            egui::accesskit::Role::RadioButton,
            ui.is_enabled(),
            on,
            name,
        )
    });
    response.on_hover_text(why).clicked()
}

fn tree_ui(ui: &mut egui::Ui, settings: &mut Settings) {
    let choice = &mut settings.choice;
    row(ui, "Tree", "Which of the published structures", |ui, _| {
        for (kind, text, why) in [
            (
                Kind::Bsp,
                "BSP",
                "Binary space partition: halves each cell across x, y and z in turn",
            ),
            (
                Kind::Octree,
                "Octree",
                "Parts each cell in eight; every leaf has a list of its own",
            ),
            (
                Kind::Hybrid,
                "Hybrid octree",
                "The octree over one list: a node wholly inside the box answers at once",
            ),
        ] {
            if pick(ui, choice.kind == kind, text, text, why) {
                choice.kind = kind;
            }
        }
    });
    row(
        ui,
        "On a plane",
        "What becomes of a triangle that a splitting plane cuts",
        |ui, _| {
            ui.add_enabled_ui(choice.kind.has_cases(), |ui| {
                let now = choice.effective().case;
                for (case, text, why) in [
                    (Case::A, "A: cut", "Case A: it is cut in pieces"),
                    (Case::B, "B: both", "Case B: both sides list it"),
                    (
                        Case::C,
                        "C: most",
                        "Case C: the side with most of its vertices lists it",
                    ),
                ] {
                    let why = if choice.kind.has_cases() {
                        why.to_owned()
                    } else {
                        format!("{why}. Octrees know case C only")
                    };
                    let name = format!("Case {case:?}");
                    if pick(ui, now == case, text, &name, &why) {
                        choice.case = case;
                    }
                }
            });
        },
    );
    row(
        ui,
        "Threshold",
        "A leaf with more triangles is split",
        |ui, label| {
            ui.spacing_mut().slider_width = (ui.available_width() - 118.0).max(40.0);
            ui.add(
                egui::Slider::new(&mut choice.threshold, THRESHOLDS)
                    .logarithmic(true)
                    .clamping(egui::SliderClamping::Always)
                    .suffix(" triangles"),
            )
            .labelled_by(label)
            .on_hover_text(
                "Most triangles in a leaf, 16 to 8192; 1024 as published. The tree is built anew",
            );
        },
    );
}

/// What building does or came to, in a row of steady height.
fn status_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown) {
    let theme = &cx.view.theme;
    ui.allocate_ui_with_layout(
        vec2(ui.available_width(), 22.0),
        egui::Layout::left_to_right(egui::Align::Center),
        |ui| {
            ui.set_min_height(22.0);
            if let Some(status) = &shown.building {
                let width = (ui.available_width() - 76.0).max(60.0);
                ui.add(
                    egui::ProgressBar::new(status.fraction as _)
                        .desired_width(width)
                        .text(RichText::new(format!("Building: {}", status.part)).size(11.5)),
                );
                let cancel = ui
                    .button("Cancel")
                    .on_hover_text("Stop building and keep the tree that is there");
                named(ui, &cancel, "Cancel building the tree");
                if cancel.clicked() {
                    cx.view.study.lock().stop();
                }
                return;
            }
            if shown.stopped {
                let text = shown.fault.as_deref().unwrap_or("Building was stopped");
                ui.label(RichText::new(text).color(theme.warning));
                let build = ui
                    .button("Build")
                    .on_hover_text("Build the chosen tree after all");
                named(ui, &build, "Build the tree");
                if build.clicked() {
                    cx.view.study.lock().go_on();
                    ui.ctx().request_repaint();
                }
                return;
            }
            let Some(built) = &shown.built else {
                ui.label(RichText::new("Starting to build…").weak());
                return;
            };
            match &built.fault {
                None => {
                    let text = format!(
                        "Built in {}, well formed",
                        crate::app::widgets::time(built.build_us)
                    );
                    ui.label(RichText::new(text).color(theme.good)).on_hover_text(
                        "The checker that every test runs: cells halve, bounds hold, no triangle is lost",
                    );
                }
                Some(fault) => {
                    let text = format!("Not well formed: {fault}");
                    ui.label(RichText::new(text).color(theme.fault));
                }
            }
        },
    );
}

fn box_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    scene: &Scene,
    shown: &Shown,
    settings: &mut Settings,
) {
    row(
        ui,
        "Box edge",
        "Edge of the haptic detecting box: only triangles in it are asked in a haptic pass",
        |ui, label| {
            let whole_mm = longest_edge_mm(scene).max(1e-9);
            let mut edge_mm = settings.edge_part * whole_mm;
            ui.spacing_mut().slider_width = (ui.available_width() - 166.0).max(40.0);
            let mut percent = settings.edge_part * 100.0;
            let parts = EDGE_PARTS.start() * 100.0..=EDGE_PARTS.end() * 100.0;
            let slider = ui
                .add(
                    egui::Slider::new(&mut percent, parts)
                        .logarithmic(true)
                        .max_decimals(1)
                        .suffix(" %"),
                )
                .labelled_by(label)
                .on_hover_text(
                    "Part of the longest edge of the skin's box; 25 % as published. Smaller is faster, but at 10 % a fast proxy goes through",
                );
            if slider.changed() {
                settings.edge_part = percent / 100.0;
            }
            let drag = ui
                .add(
                    egui::DragValue::new(&mut edge_mm)
                        .range(EDGE_PARTS.start() * whole_mm..=EDGE_PARTS.end() * whole_mm)
                        .speed(whole_mm / 500.0)
                        .max_decimals(1)
                        .suffix(" mm"),
                )
                .on_hover_text("The same as a length");
            drag.widget_info(|| egui::WidgetInfo::drag_value(ui.is_enabled(), edge_mm));
            if drag.changed() {
                settings.edge_part = edge_mm / whole_mm;
            }
        },
    );
    row(ui, "Box at", "Where the middle of the box is", |ui, _| {
        let n_fingers = cx.view.fingers.len().clamp(1, 2);
        for (index, name) in ["L finger", "R finger"]
            .into_iter()
            .enumerate()
            .take(n_fingers)
        {
            let on = settings.follow == Follow::Finger(index);
            let why = "Follow the proxy of this finger, also in a recording";
            if pick(ui, on, name, name, why) {
                settings.follow = Follow::Finger(index);
            }
        }
        let on = settings.follow == Follow::Fixed;
        let why = "Stay where it was put: click the skin in the picture, or set the numbers";
        if pick(ui, on, "Fixed", "Fixed place", why) {
            settings.follow = Follow::Fixed;
            if let Some(asked) = &shown.asked {
                settings.fixed_mm = asked.probe_mm;
            }
        }
    });
    row(ui, "", "Middle of the box, mm", |ui, _| {
        let mut place = match (settings.follow, &shown.asked) {
            (Follow::Finger(_), Some(asked)) => asked.probe_mm,
            _ => settings.fixed_mm,
        };
        ui.add_enabled_ui(settings.follow == Follow::Fixed, |ui| {
            for (axis, name) in ["x ", "y ", "z "].into_iter().enumerate() {
                let mut value = place[axis];
                ui.spacing_mut().interact_size.x = 72.0;
                let drag = ui
                    .add(
                        egui::DragValue::new(&mut value)
                            .prefix(name)
                            .speed(0.5)
                            .fixed_decimals(1),
                    )
                    .on_hover_text("Middle of the box, mm")
                    .on_disabled_hover_text("Middle of the box, mm; choose Fixed to set it");
                if drag.changed() && value.is_finite() {
                    place[axis] = value.clamp(-1e6, 1e6);
                    settings.fixed_mm = place;
                }
            }
        });
    });
    row(
        ui,
        "Query",
        "What is marked as haptic triangles",
        |ui, _| {
            for (query, text, name, why) in [
                (
                    Query::Complete,
                    "Complete",
                    "Complete query",
                    "Every triangle whose box overlaps the box: none that intersects it is lost",
                ),
                (
                    Query::Published,
                    "As published",
                    "Query as published",
                    "Whole leaves on the box's side of the planes: more than needed, and triangles that jut out are missed",
                ),
            ] {
                if pick(ui, settings.query == query, text, name, why) {
                    settings.query = query;
                }
            }
        },
    );
}

fn show_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown, settings: &mut Settings) {
    let show = &mut settings.show;
    let height = (shown.built.as_ref()).map_or(0, |b| b.height());
    row(ui, "Level", "How deep the tree is drawn", |ui, label| {
        let mut level = show.level.min(height);
        ui.spacing_mut().slider_width = (ui.available_width() - 92.0).max(40.0);
        let slider = ui
            .add_enabled(
                height > 0,
                egui::Slider::new(&mut level, 0..=height.max(1))
                    .custom_formatter(move |n, _| format!("{n:.0} of {height}")),
            )
            .labelled_by(label)
            .on_hover_text("The deepest level drawn: 0 is the box around the skin");
        if slider.changed() {
            // All of it stays all of it when the next tree is deeper.
            show.level = if level >= height { u32::MAX } else { level };
        }
    });
    row(ui, "Boxes", "Which nodes are drawn", |ui, _| {
        for (boxes, text, name, why) in [
            (
                Boxes::FullLeaves,
                "Full leaves",
                "Boxes of leaves with triangles",
                "Leaves down to the level that hold triangles",
            ),
            (
                Boxes::Leaves,
                "Leaves",
                "Boxes of all leaves",
                "Leaves down to the level, empty ones too",
            ),
            (
                Boxes::All,
                "Nodes",
                "Boxes of the level",
                "The nodes of the level, and leaves above it",
            ),
        ] {
            if pick(ui, show.boxes == boxes, text, name, why) {
                show.boxes = boxes;
            }
        }
    });
    let colors = cx.view.theme.tree;
    let toggle = |ui: &mut egui::Ui, on: &mut bool, color, text: &str, why: &str| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            ui.checkbox(on, text).on_hover_text(why);
            if let Some(color) = color {
                swatch(ui, color);
            }
        });
    };
    ui.columns(2, |columns| {
        let left = &mut columns[0];
        toggle(
            left,
            &mut show.wire,
            Some(colors.leaf),
            "Wire boxes",
            "Nodes as wire boxes",
        );
        toggle(
            left,
            &mut show.loose,
            None,
            "Loose bounds",
            "Draw the boxes that hold every triangle of a node wholly, instead of its cell",
        );
        left.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            ui.checkbox(&mut show.planes, "Split planes")
                .on_hover_text("Planes that split the nodes above the level: across x, y and z");
            ui.add_space(3.0);
            for color in colors.planes {
                swatch(ui, color);
            }
        });
        let right = &mut columns[1];
        toggle(
            right,
            &mut show.haptic,
            Some(colors.haptic),
            "Haptic triangles",
            "Mark the triangles that the query gathers",
        );
        toggle(
            right,
            &mut show.hdb,
            Some(colors.haptic),
            "Detecting box",
            "The haptic detecting box",
        );
        toggle(
            right,
            &mut show.skin,
            None,
            "Skin",
            "Draw the skin in this picture",
        );
    });
    ui.checkbox(&mut show.in_back_view, "Show in Back view")
        .on_hover_text("Lay the same over the skin in the Back view, as it deforms");
    let [drawn, all] = shown.boxes;
    if drawn < all {
        let text =
            format!("{drawn} of {all} boxes are drawn: choose a lower level to see whole levels");
        ui.label(RichText::new(text).size(11.5).color(cx.view.theme.warning));
    }
}
