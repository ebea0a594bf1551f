//! Under which choices an experiment runs; run and cancel.

use super::PanelContext;
use crate::app::bench::Wake;
use crate::app::laboratory::{Laboratory, Listed, Progress};
use crate::app::widgets::named;
use crate::lab::Choice;
use egui::{RichText, vec2};
use egui_material_icons::icons as icon;
use std::time::Duration;

/// Height of the bar that tells progress, points.
const BAR: f32 = 6.0;

/// Shows what the experiment answers, what it can be told, and how far it is.
pub fn show(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    laboratory: &mut Laboratory,
    refused: &mut Option<String>,
    wake: &Wake,
) {
    let Some(experiment) = laboratory.chosen() else {
        return;
    };
    ui.label(RichText::new(experiment.name()).strong().size(17.0));
    ui.label(RichText::new(experiment.about()).color(cx.view.theme.weak_text));
    ui.add_space(4.0);
    let progress = laboratory.progress();
    ui.add_enabled_ui(progress.is_none(), |ui| {
        choices_ui(ui, cx, laboratory, experiment);
    });
    let fault = laboratory.choices.asked(experiment, cx.view).err();
    ui.add_space(2.0);
    match progress {
        Some(progress) => progress_ui(ui, laboratory, &progress),
        None => run_ui(ui, cx, laboratory, refused, fault.is_none(), wake),
    }
    let told = fault.as_deref().or(refused.as_deref());
    if let Some(told) = told {
        ui.label(RichText::new(told).color(cx.view.theme.fault));
    } else if let Some(told) = laboratory.told() {
        ui.label(RichText::new(told).color(cx.view.theme.warning));
    }
}

fn choices_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    laboratory: &mut Laboratory,
    experiment: Listed,
) {
    let takes = |choice| experiment.takes().contains(&choice);
    let choices = &mut laboratory.choices;
    let scene = (cx.view.scene.as_ref()).map_or("none is open", |s| &*s.scenario.name);
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut choices.quick, "Quick look")
            .on_hover_text("Fewer repetitions and smaller sizes: seconds instead of minutes");
        if takes(Choice::Scene) {
            ui.checkbox(&mut choices.scene, "This scene")
                .on_hover_text(format!(
                    "Work in the open scene ({scene}) instead of the experiment's own"
                ));
        }
        if takes(Choice::Mesh) {
            ui.checkbox(&mut choices.skin, "This skin")
                .on_hover_text(format!(
                    "Work on the skin of the open scene ({scene}) instead of the experiment's own"
                ));
        }
        if takes(Choice::Triangles) {
            field(
                ui,
                "Triangles",
                &mut choices.triangles,
                "its own",
                110.0,
                "Sizes of the built-in back, with commas between; empty: the experiment's own",
            );
        }
        if takes(Choice::Seed) {
            field(
                ui,
                "Seed",
                &mut choices.seed,
                "0",
                70.0,
                "Where chance starts: the same number gives the same",
            );
        }
        if takes(Choice::Seconds) {
            field(
                ui,
                "Seconds",
                &mut choices.seconds,
                "its own",
                70.0,
                "How long to work in real time; empty: the experiment's own time",
            );
        }
        if takes(Choice::Session) {
            field(
                ui,
                "Session",
                &mut choices.session,
                "a scripted one",
                150.0,
                "Path of a recorded session (.mcap); empty: a scripted one",
            );
            if let Some(playback) = &cx.view.playback {
                let button = ui
                    .button("This recording")
                    .on_hover_text("Work on the recording that is open");
                if button.clicked() {
                    choices.session = playback.path.display().to_string();
                }
            }
        }
    });
}

/// A named field that stays on one line with its name.
fn field(ui: &mut egui::Ui, name: &str, text: &mut String, hint: &str, width: f32, why: &str) {
    together(ui, name, width, |ui| {
        let label = ui.label(name);
        ui.add(
            egui::TextEdit::singleline(text)
                .hint_text(hint)
                .desired_width(width),
        )
        .labelled_by(label.id)
        .on_hover_text(why);
    });
}

/// A name and what is `width` wide beside it, as one piece of a wrapped row.
pub fn together(ui: &mut egui::Ui, name: &str, width: f32, add: impl FnOnce(&mut egui::Ui)) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    let galley = (ui.painter()).layout_no_wrap(name.to_owned(), font, egui::Color32::WHITE);
    let size = vec2(galley.size().x + 5.0 + width + 10.0, 22.0);
    let left = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(size, left, |ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        add(ui);
    });
}

fn run_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    laboratory: &mut Laboratory,
    refused: &mut Option<String>,
    can_run: bool,
    wake: &Wake,
) {
    let mut asked = None;
    let is_current = laboratory.is_current(cx.view);
    row(ui, |ui| {
        let theme = &cx.view.theme;
        let mut text = RichText::new("Run");
        let mut button_icon = icon::ICON_PLAY_ARROW.rich_text();
        if can_run && !is_current {
            text = text.color(theme.on_accent).strong();
            button_icon = button_icon.color(theme.on_accent);
        }
        let mut button = egui::Button::new((button_icon, text)).min_size(vec2(84.0, 24.0));
        if can_run && !is_current {
            button = button.fill(theme.accent);
        }
        let run = ui.add_enabled(can_run && !is_current, button);
        let run = run
            .on_hover_text("Run it beside the window, at low priority: the servo does not feel it")
            .on_disabled_hover_text(if is_current {
                "These results answer the choices as they are; Measure anew throws them away first"
            } else {
                "A choice cannot be used"
            });
        named(ui, &run, "Run");
        if run.clicked() {
            asked = Some(false);
        }
        let anew = ui
            .add_enabled(
                can_run,
                egui::Button::new("Measure anew").min_size(vec2(0.0, 24.0)),
            )
            .on_hover_text("Throw away what was kept of it under these choices, and run");
        if anew.clicked() {
            asked = Some(true);
        }
    });
    // The place of the bar, so that nothing moves when it comes.
    ui.allocate_space(vec2(1.0, BAR));
    if let Some(anew) = asked {
        *refused = laboratory.run(anew, cx.view, wake).err();
    }
}

fn progress_ui(ui: &mut egui::Ui, laboratory: &Laboratory, progress: &Progress) {
    row(ui, |ui| {
        let cancel = ui
            .add_enabled(
                !progress.stopping,
                egui::Button::new((icon::ICON_CLOSE.rich_text(), "Cancel"))
                    .min_size(vec2(84.0, 24.0)),
            )
            .on_hover_text("Stop it; parts that are finished are kept");
        named(ui, &cancel, "Cancel the experiment");
        if cancel.clicked() {
            laboratory.cancel();
        }
        ui.label(RichText::new(minutes(progress.elapsed)).monospace())
            .on_hover_text("Time since the start");
        let text = match (progress.stopping, &*progress.what) {
            (true, _) => "Stopping…".to_owned(),
            (false, "") => "Starting…".to_owned(),
            (false, what) => what.to_owned(),
        };
        ui.label(RichText::new(format!("{:>3.0} %", 100.0 * progress.share)).monospace());
        ui.add(egui::Label::new(&text).truncate());
    });
    let bar = egui::ProgressBar::new(progress.share as _).desired_height(BAR);
    ui.add(bar).widget_info(|| {
        let role = egui::accesskit::Role::ProgressIndicator;
        let name = format!("{}: {}", progress.experiment, progress.what);
        let mut info = egui::WidgetInfo::labeled(role, true, name);
        info.value = Some(100.0 * progress.share);
        info
    });
}

/// A row of steady height, whatever is in it.
fn row(ui: &mut egui::Ui, add: impl FnOnce(&mut egui::Ui)) {
    let left = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(ui.available_width(), 26.0), left, |ui| {
        ui.set_min_height(26.0);
        add(ui);
    });
}

/// Minutes and seconds.
fn minutes(time: Duration) -> String {
    let s = time.as_secs();
    format!("{}:{:02}", s / 60, s % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_told_in_minutes_and_seconds() {
        assert_eq!(minutes(Duration::from_secs(75)), "1:15");
        assert_eq!(minutes(Duration::from_millis(900)), "0:00");
    }
}
