//! The recording on show: its time, its speed, what happened in it.

use super::{action_button_as, file_name};
use crate::app::command::{Action, Command};
use crate::app::messages::clock;
use crate::app::panels::PanelContext;
use crate::app::state::{PlaybackStatus, RecordedEvent};
use crate::app::widgets::{action_button, icon_button, named, with_key};
use crate::session::PLAYBACK_SPEEDS;
use egui::{Align2, FontId, Label, Rect, RichText, Sense, Stroke, pos2, vec2};
use egui_material_icons::icons as icon;

/// Height of a line of the list of events, points.
const LINE: f32 = 20.0;

/// Draws all of it but the list of events.
pub fn ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    ui.horizontal(|ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            action_button_as(
                ui,
                cx,
                Action::BackToLive,
                icon::ICON_SENSORS,
                "Back to live",
            );
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let name = RichText::new(file_name(&playback.path)).strong();
                ui.add(Label::new(name).truncate())
                    .on_hover_text(playback.path.display().to_string());
            });
        });
    });
    if let Some(damage) = &playback.damage {
        let text = format!("Damaged: what can be read is shown. {damage}");
        let text = RichText::new(text).size(12.0).color(cx.view.theme.warning);
        ui.add(Label::new(text).truncate());
    }
    time_ui(ui, cx, playback);
    transport_ui(ui, cx, playback);
    speed_ui(ui, cx, playback);
}

/// The slider of time, with a tick for each event.
fn time_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    let theme = &cx.view.theme;
    let mut time_s = playback.time_s;
    let end_s = playback.duration_s.max(1e-3);
    ui.spacing_mut().slider_width = (ui.available_width() - 8.0).max(80.0);
    let slider = ui
        .add(
            egui::Slider::new(&mut time_s, 0.0..=end_s)
                .show_value(false)
                .trailing_fill(true),
        )
        .on_hover_text("Drag to go to any instant of the recording");
    slider.widget_info(|| egui::WidgetInfo::slider(true, playback.time_s, "Time in the recording"));
    if slider.changed() {
        cx.send.send(Command::Seek(time_s));
    }
    let rail = slider.rect.shrink2(vec2(slider.rect.height() / 2.0, 0.0));
    let mut last = f32::NEG_INFINITY;
    for event in playback.events.iter() {
        let x = rail.left() + (event.time_s / end_s).clamp(0.0, 1.0) as f32 * rail.width();
        // Thousands of events on a few hundred points: one tick a point.
        if x - last < 1.0 {
            continue;
        }
        last = x;
        let foot = Rect::from_min_max(
            pos2(x - 0.75, slider.rect.bottom() - 3.0),
            pos2(x + 0.75, slider.rect.bottom() + 1.0),
        );
        ui.painter().rect_filled(foot, 0.0, colour(event, theme));
    }
    if let Some(share) = playback.plotted {
        let text = format!("Reading the plots, {:.0} %", share * 100.0);
        let bar = egui::ProgressBar::new(share as f32)
            .desired_height(4.0)
            .desired_width(ui.available_width());
        ui.add(bar).on_hover_text(text);
    }
}

fn transport_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    ui.horizontal(|ui| {
        let act = |ui: &mut egui::Ui, action: Action, icon, name: &str| {
            let tooltip = with_key(ui.ctx(), action.spec().tooltip, action);
            if icon_button(ui, icon, name, &tooltip).clicked() {
                cx.send.act(action);
            }
        };
        let events = !playback.events.is_empty();
        ui.add_enabled_ui(events, |ui| {
            act(
                ui,
                Action::PreviousEvent,
                icon::ICON_FIRST_PAGE,
                "Previous event",
            );
        });
        act(ui, Action::StepBack, icon::ICON_SKIP_PREVIOUS, "Step back");
        let (icon, name) = if playback.playing {
            (icon::ICON_PAUSE, "Pause recording")
        } else {
            (icon::ICON_PLAY_ARROW, "Play recording")
        };
        act(ui, Action::PlayPause, icon, name);
        act(
            ui,
            Action::StepForward,
            icon::ICON_SKIP_NEXT,
            "Step forward",
        );
        ui.add_enabled_ui(events, |ui| {
            act(ui, Action::NextEvent, icon::ICON_LAST_PAGE, "Next event");
        });
        let why = "Start over at the end";
        if toggle_ui(ui, cx, playback.looped, icon::ICON_REPEAT, "Loop", why) {
            cx.send.send(Command::SetLooped(!playback.looped));
        }
        let why = "Pause at each event that comes, so that nothing is played past";
        let on = playback.following;
        if toggle_ui(ui, cx, on, icon::ICON_STEP_INTO, "Follow events", why) {
            cx.send.send(Command::SetFollowing(!on));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let text = format!(
                "{} / {}",
                precise(playback.time_s),
                precise(playback.duration_s)
            );
            ui.add(Label::new(RichText::new(text).monospace()).truncate());
        });
    });
}

fn toggle_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    on: bool,
    icon: egui_material_icons::MaterialIcon,
    name: &str,
    why: &str,
) -> bool {
    let theme = &cx.view.theme;
    let colour = if on { theme.accent } else { theme.weak_text };
    let text = icon.rich_text().size(16.0).color(colour);
    let toggle = ui
        .add(egui::Button::new(text).frame(false))
        .on_hover_text(why);
    toggle.widget_info(|| {
        egui::WidgetInfo::selected(egui::accesskit::Role::CheckBox, true, on, name)
    });
    toggle.clicked()
}

fn speed_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    ui.horizontal(|ui| {
        let label = ui.label("Speed");
        let mut speed = if playback.speed.is_finite() {
            playback.speed
        } else {
            1.0
        };
        ui.spacing_mut().slider_width = (ui.available_width() - 236.0).clamp(40.0, 160.0);
        let slider = ui
            .add(
                egui::Slider::new(&mut speed, PLAYBACK_SPEEDS)
                    .logarithmic(true)
                    .suffix("×")
                    .max_decimals(2),
            )
            .labelled_by(label.id)
            .on_hover_text("How fast time runs; 1× is as it was");
        if slider.changed() {
            cx.send.send(Command::SetSpeed(speed));
        }
        let real = ui
            .add_enabled(playback.speed != 1.0, egui::Button::new("1×"))
            .on_hover_text("As fast as it was");
        named(ui, &real, "Real speed");
        if real.clicked() {
            cx.send.send(Command::SetSpeed(1.0));
        }
        action_button(ui, cx.send, Action::SaveRecordingAs, "Save as…");
    });
}

/// The list of events: a click goes there.
pub fn events_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, playback: &PlaybackStatus) {
    let theme = &cx.view.theme;
    let events = &playback.events;
    ui.label(RichText::new(format!("{} events", events.len())).weak());
    let present = events
        .iter()
        .rposition(|e| e.time_s <= playback.time_s + 1e-9);
    ui.spacing_mut().item_spacing.y = 0.0;
    egui::ScrollArea::vertical()
        .id_salt("events")
        .auto_shrink(false)
        .show_rows(ui, LINE, events.len(), |ui, rows| {
            for i in rows {
                let Some(event) = events.get(i) else { continue };
                let width = ui.available_width();
                let (rect, response) = ui.allocate_exact_size(vec2(width, LINE), Sense::click());
                let text = words(event);
                let name = format!("Go to {} at {}", text, precise(event.time_s));
                response.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::accesskit::Role::Button, true, &name)
                });
                if present == Some(i) {
                    let fill = theme.accent.gamma_multiply(0.28);
                    ui.painter().rect_filled(rect, 3.0, fill);
                } else if response.hovered() {
                    let fill = theme.line.gamma_multiply(0.5);
                    ui.painter().rect_filled(rect, 3.0, fill);
                }
                if response.has_focus() {
                    let ring = Stroke::new(1.5, theme.accent);
                    let inside = egui::StrokeKind::Inside;
                    ui.painter().rect_stroke(rect, 3.0, ring, inside);
                }
                let middle = rect.center().y;
                ui.painter().circle_filled(
                    pos2(rect.left() + 8.0, middle),
                    3.0,
                    colour(event, theme),
                );
                let time = precise(event.time_s);
                let at = pos2(rect.left() + 18.0, middle);
                let mono = FontId::monospace(12.0);
                let left = Align2::LEFT_CENTER;
                ui.painter().text(at, left, time, mono, theme.weak_text);
                let font = FontId::proportional(12.5);
                let mut job = egui::text::LayoutJob::simple_singleline(text, font, theme.text);
                job.wrap = egui::text::TextWrapping::truncate_at_width((width - 100.0).max(20.0));
                let galley = ui.ctx().fonts_mut(|f| f.layout_job(job));
                let at = pos2(rect.left() + 96.0, middle - galley.size().y / 2.0);
                ui.painter().galley(at, galley, theme.text);
                if response.clicked() {
                    cx.send.send(Command::SetPlaying(false));
                    cx.send.send(Command::Seek(event.time_s));
                }
            }
        });
}

/// What happened, in a line.
fn words(event: &RecordedEvent) -> String {
    let mut kind = event.kind.replace(['_', '-'], " ");
    if let Some(first) = kind.get_mut(0..1) {
        first.make_ascii_uppercase();
    }
    match event.text.trim() {
        "" => kind,
        text => format!("{kind}: {text}"),
    }
}

fn colour(event: &RecordedEvent, theme: &crate::app::theme::Theme) -> egui::Color32 {
    match event.kind.as_str() {
        "mark" => theme.accent,
        "lost" | "fault" | "pop" => theme.warning,
        _ => theme.weak_text,
    }
}

fn precise(time_s: f64) -> String {
    let s = time_s.max(0.0);
    format!("{}.{:02}", clock(s), (s.fract() * 100.0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_events_read_well() {
        assert_eq!(precise(61.256), "01:01.25");
        let event = |kind: &str, text: &str| RecordedEvent {
            time_s: 1.0,
            kind: kind.into(),
            text: text.into(),
        };
        assert_eq!(words(&event("mark", "")), "Mark");
        assert_eq!(
            words(&event("device_change", "Mouse")),
            "Device change: Mouse"
        );
        assert_eq!(words(&event("", "")), "");
    }
}
