//! The recordings that are overlaid on the one on show.

use crate::app::command::Command;
use crate::app::panels::PanelContext;
use crate::app::panels::legend::swatch;
use crate::app::state::{Alignment, GhostView};
use crate::app::widgets::icon_button;
use egui::{Label, RichText};
use egui_material_icons::icons as icon;

/// Draws them; nothing where there is none.
pub fn ui(ui: &mut egui::Ui, cx: &PanelContext<'_>) {
    let ghosts = &cx.view.ghosts;
    if ghosts.is_empty() {
        return;
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Ghosts").weak())
            .on_hover_text("Recordings overlaid on this one in the Back view and in the plots");
        let mut chosen = cx.view.alignment;
        let words = |a: Alignment| match a {
            Alignment::Start => "Aligned by start",
            Alignment::FirstContact => "Aligned by first contact",
        };
        let combo = egui::ComboBox::from_id_salt("alignment")
            .selected_text(words(chosen))
            .width(170.0)
            .show_ui(ui, |ui| {
                for choice in [Alignment::Start, Alignment::FirstContact] {
                    ui.selectable_value(&mut chosen, choice, words(choice));
                }
            });
        let why = "What is the same instant in all of them";
        combo.response.on_hover_text(why).widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Align ghosts")
        });
        if chosen != cx.view.alignment {
            cx.send.send(Command::AlignGhosts(chosen));
        }
    });
    for ghost in ghosts {
        ghost_ui(ui, cx, ghost);
    }
}

fn ghost_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, ghost: &GhostView) {
    ui.horizontal(|ui| {
        swatch(ui, cx.view.theme.ghost(ghost.colour));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let name = format!("Remove ghost {}", ghost.name);
            let why = "Take this ghost away";
            if icon_button(ui, icon::ICON_CLOSE, &name, why).clicked() {
                cx.send.send(Command::RemoveGhost(ghost.path.clone()));
            }
            let mut offset_s = ghost.offset_s;
            let sign = if offset_s >= 0.0 { "+" } else { "" };
            let drag = ui
                .add(
                    egui::DragValue::new(&mut offset_s)
                        .speed(0.02)
                        .range(-86_400.0..=86_400.0)
                        .fixed_decimals(2)
                        .prefix(sign)
                        .suffix(" s"),
                )
                .on_hover_text("How much later it is shown; drag or type");
            let name = format!("Offset of ghost {}", ghost.name);
            drag.widget_info(|| egui::WidgetInfo::drag_value(true, offset_s));
            ui.ctx()
                .accesskit_node_builder(drag.id, |node| node.set_label(name.as_str()));
            if drag.changed() {
                cx.send.send(Command::SetGhostOffset {
                    path: ghost.path.clone(),
                    offset_s,
                });
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let mut text = ghost.name.clone();
                if let Some(share) = ghost.plotted {
                    text += &format!(" · reading, {:.0} %", share * 100.0);
                } else if ghost.trails.is_empty() {
                    text += " · not at this time";
                }
                ui.add(Label::new(RichText::new(text).size(12.5)).truncate())
                    .on_hover_text(ghost.path.display().to_string());
            });
        });
    });
}
