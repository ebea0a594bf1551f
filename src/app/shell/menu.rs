//! The menu bar and the keys: both derive from the lists of actions and panels.

use super::Shared;
use crate::app::command::{Action, Command, Menu, panel_shortcut};
use crate::app::dock::Layout;
use crate::app::roles::Role;
use crate::app::state::View;
use crate::app::widgets::{icon_button, named, with_key};
use crate::training::Phase;
use egui_material_icons::icons as icon;

/// Runs what the pressed keys ask for.
pub fn keys(ctx: &egui::Context, shared: &Shared, recording_open: bool) {
    let mut actions: Vec<(egui::KeyboardShortcut, Action)> = Action::ALL
        .into_iter()
        .filter_map(|a| a.spec().shortcut.map(|s| (s, a)))
        .collect();
    // egui takes Ctrl+Shift+O for Ctrl+O too: the more specific first.
    actions.sort_by_key(|(s, _)| !s.modifiers.shift);
    let typing = ctx.memory(|m| m.focused().is_some());
    for (shortcut, action) in actions {
        if action == Action::StopForce {
            stop_key(ctx, shared);
            continue;
        }
        let plain = shortcut.modifiers.is_none() && shortcut.logical_key != egui::Key::F11;
        if plain && typing || action.needs_recording() && !recording_open {
            continue;
        }
        if ctx.input_mut(|i| i.consume_shortcut(&shortcut)) {
            shared.send.act(action);
        }
    }
    for (index, slot) in shared.panels.iter().enumerate() {
        if let Some(shortcut) = panel_shortcut(index)
            && ctx.input_mut(|i| i.consume_shortcut(&shortcut))
        {
            shared.send.send(Command::TogglePanel(slot.key));
        }
    }
}

/// Stops force on its key. Never consumed, never blocked: it must work whatever is open.
pub fn stop_key(ctx: &egui::Context, shared: &Shared) {
    let stop = Action::StopForce;
    if let Some(shortcut) = stop.spec().shortcut
        && ctx.input(|i| i.key_pressed(shortcut.logical_key))
    {
        shared.send.act(stop);
    }
}

/// The menu bar, with the emergency stop at its right end.
pub fn bar_ui(ui: &mut egui::Ui, shared: &Shared, layout: &Layout, view: &View) {
    egui::MenuBar::new().ui(ui, |ui| {
        menu_ui(ui, shared, "File", Menu::File, view);
        menu_ui(ui, shared, "Session", Menu::Session, view);
        menu_ui(ui, shared, "View", Menu::View, view);
        menu_ui(ui, shared, "Role", Menu::Role, view);
        panels_ui(ui, shared, layout);
        if view.role.offers_panels() {
            closed_ui(ui, shared, layout);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            force_ui(ui, shared, view.force_enabled);
            let (theme_icon, name) = if view.theme.dark {
                (icon::ICON_LIGHT_MODE, "Light window")
            } else {
                (icon::ICON_DARK_MODE, "Dark window")
            };
            let spec = Action::ToggleTheme.spec();
            let tooltip = with_key(ui.ctx(), spec.tooltip, Action::ToggleTheme);
            if icon_button(ui, theme_icon, name, &tooltip).clicked() {
                shared.send.act(Action::ToggleTheme);
            }
            let spec = Action::Palette.spec();
            let tooltip = with_key(ui.ctx(), spec.tooltip, Action::Palette);
            if icon_button(ui, spec.icon, spec.text, &tooltip).clicked() {
                shared.send.act(Action::Palette);
            }
        });
    });
}

fn menu_ui(ui: &mut egui::Ui, shared: &Shared, title: &str, menu: Menu, view: &View) {
    ui.menu_button(title, |ui| {
        ui.set_min_width(220.0);
        for action in Action::ALL {
            let spec = action.spec();
            if spec.menu != menu {
                continue;
            }
            let mut button =
                egui::Button::new((spec.icon.rich_text(), spec.text)).selected(is_on(action, view));
            if let Some(shortcut) = spec.shortcut {
                button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
            }
            let response = ui
                .add_enabled(is_possible(action, view), button)
                .on_hover_text(spec.tooltip);
            named(ui, &response, spec.text);
            if response.clicked() {
                shared.send.act(action);
                ui.close();
            }
        }
    });
}

/// Whether an action is a state that holds now.
fn is_on(action: Action, view: &View) -> bool {
    match action {
        Action::BeInstructor => view.role == Role::Instructor,
        Action::BeTrainee => view.role == Role::Trainee,
        Action::BeResearcher => view.role == Role::Researcher,
        Action::TraineeWindow => view.trainee_window,
        _ => false,
    }
}

/// Whether an action can do something now.
pub fn is_possible(action: Action, view: &View) -> bool {
    match action {
        Action::SaveRecordingAs => view.playback.is_some() || !view.recorder.recent.is_empty(),
        Action::SaveScenario => view.unsaved && view.playback.is_none(),
        Action::SaveScenarioAs => view.scene.is_some() && view.playback.is_none(),
        Action::Record => view.scene.is_some(),
        Action::AllowForce => !view.force_enabled,
        Action::StopForce => view.force_enabled,
        Action::BeInstructor | Action::BeTrainee | Action::BeResearcher => {
            view.exercise
                .as_ref()
                .is_none_or(|e| matches!(e.shown.phase, Phase::Done(_)))
                || is_on(action, view)
        }
        a if a.needs_recording() => view.playback.is_some(),
        _ => true,
    }
}

fn panels_ui(ui: &mut egui::Ui, shared: &Shared, layout: &Layout) {
    ui.menu_button("Panels", |ui| {
        ui.set_min_width(220.0);
        for (index, slot) in shared.panels.iter().enumerate() {
            ui.horizontal(|ui| {
                let open = !layout.is_closed(slot.key);
                let mark = if open {
                    icon::ICON_CHECK_BOX
                } else {
                    icon::ICON_CHECK_BOX_OUTLINE_BLANK
                };
                let mut button = egui::Button::new((mark.rich_text(), slot.title));
                if let Some(shortcut) = panel_shortcut(index) {
                    button = button.shortcut_text(ui.ctx().format_shortcut(&shortcut));
                }
                let response = ui
                    .add_sized([190.0, 20.0], button)
                    .on_hover_text(slot.tooltip);
                response.widget_info(|| {
                    egui::WidgetInfo::selected(
                        egui::accesskit::Role::CheckBox,
                        true,
                        open,
                        format!("Panel {}", slot.title),
                    )
                });
                if response.clicked() {
                    let command = if open {
                        Command::ClosePanel(slot.key)
                    } else {
                        Command::ShowPanel(slot.key)
                    };
                    shared.send.send(command);
                    ui.close();
                }
                let (icon, name, command) = if layout.is_popped(slot.key) {
                    (
                        icon::ICON_DOCK_TO_RIGHT,
                        "Dock back",
                        Command::DockBack(slot.key),
                    )
                } else {
                    (icon::ICON_OPEN_IN_NEW, "Pop out", Command::PopOut(slot.key))
                };
                let name = format!("{name} {} from the menu", slot.title);
                let tooltip = "A window of its own, or back into the main window";
                if icon_button(ui, icon, &name, tooltip).clicked() {
                    shared.send.send(command);
                    ui.close();
                }
            });
        }
        ui.separator();
        let spec = Action::ResetLayout.spec();
        let response = ui
            .button((spec.icon.rich_text(), spec.text))
            .on_hover_text(spec.tooltip);
        named(ui, &response, "Reset layout of the panels");
        if response.clicked() {
            shared.send.act(Action::ResetLayout);
            ui.close();
        }
    })
    .response
    .on_hover_text("Open, close and pop out panels");
}

/// Room that the right end of the bar needs, points.
const RIGHT_END: f32 = 210.0;

/// Closed panels stay in reach: one click opens each again. Those without room are in the menu.
fn closed_ui(ui: &mut egui::Ui, shared: &Shared, layout: &Layout) {
    for slot in shared.panels.iter().filter(|p| layout.is_closed(p.key)) {
        let font = egui::TextStyle::Button.resolve(ui.style());
        let text = ui
            .painter()
            .layout_no_wrap(slot.title.into(), font, egui::Color32::WHITE);
        let padding = 2.0 * ui.spacing().button_padding.x + ui.spacing().item_spacing.x;
        if ui.available_width() < text.size().x + padding + 20.0 + RIGHT_END {
            break;
        }
        let button = ui
            .add(egui::Button::new((icon::ICON_ADD.rich_text(), slot.title)).frame(false))
            .on_hover_text(slot.tooltip);
        named(ui, &button, &format!("Open {}", slot.title));
        if button.clicked() {
            shared.send.send(Command::ShowPanel(slot.key));
        }
    }
}

/// The emergency stop, or the way back from it.
pub fn force_ui(ui: &mut egui::Ui, shared: &Shared, enabled: bool) {
    let theme = crate::app::theme::Theme::of(ui.visuals().dark_mode);
    let action = if enabled {
        Action::StopForce
    } else {
        Action::AllowForce
    };
    let spec = action.spec();
    let colour = if enabled { theme.text } else { theme.warning };
    let text = egui::RichText::new(spec.text).strong().color(colour);
    let button = egui::Button::new((spec.icon.rich_text().color(colour), text))
        .stroke(egui::Stroke::new(1.0, colour));
    let response = ui
        .add(button)
        .on_hover_text(with_key(ui.ctx(), spec.tooltip, action));
    named(ui, &response, spec.text);
    if response.clicked() {
        shared.send.act(action);
    }
    if !enabled {
        ui.label(egui::RichText::new("Force is off").color(theme.warning));
    }
}
