//! Which recordings are compared, and how they are aligned.

use super::work::Work;
use crate::app::command::Command;
use crate::app::dialogs;
use crate::app::panels::PanelContext;
use crate::app::panels::legend::swatch;
use crate::app::panels::sessions;
use crate::app::panels::sessions::entry::duration;
use crate::app::state::Compared;
use crate::app::widgets::{icon_button, named};
use crate::study::compare::{Align, Anchor, CompareOptions};
use crate::study::finger_name;
use egui::{Label, RichText};
use egui_material_icons::icons as icon;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Height of the list of recordings, at most, points.
const LIST: f32 = 104.0;

/// What was chosen.
#[derive(Default)]
pub struct Choices {
    align: Align,
    finger: Option<u8>,
    /// A path that is typed.
    path: String,
    inbox: Arc<Mutex<Option<PathBuf>>>,
}

/// The letter of recording `i`.
pub fn letter(i: usize) -> String {
    match u8::try_from(i) {
        Ok(i) if i < 26 => char::from(b'A' + i).to_string(),
        _ => format!("#{}", i + 1),
    }
}

impl Choices {
    /// As the comparison takes them.
    pub fn options(&self) -> CompareOptions {
        CompareOptions {
            align: self.align.clone(),
            // Most people press with the right one.
            finger: self.finger.unwrap_or(1),
            ..CompareOptions::default()
        }
    }

    /// To add recordings by path or dialog, and how to align them.
    pub fn add_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let picked = self
            .inbox
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(path) = picked {
            add(cx, path);
        }
        ui.horizontal(|ui| {
            let label = ui.label("Add");
            let field = ui
                .add(
                    egui::TextEdit::singleline(&mut self.path)
                        .hint_text("folder/recording.mcap")
                        .desired_width((ui.available_width() - 176.0).max(60.0)),
                )
                .labelled_by(label.id)
                .on_hover_text("A recording by its path; Enter adds it");
            let entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            let some = !self.path.trim().is_empty();
            let button = ui
                .add_enabled(some, egui::Button::new("Add"))
                .on_hover_text("Compare the recording at this path too");
            named(ui, &button, "Add recording path");
            if some && (entered || button.clicked()) {
                add(cx, PathBuf::from(std::mem::take(&mut self.path).trim()));
            }
            let browse = ui
                .button("Browse…")
                .on_hover_text("Choose a recording to compare");
            named(ui, &browse, "Browse for a recording to compare…");
            if browse.clicked() {
                let (inbox, ctx) = (self.inbox.clone(), ui.ctx().clone());
                let here = ctx.viewport_id();
                let folder = cx.view.recorder.folder.clone();
                dialogs::pick_recording(cx.send, folder, move |path| {
                    *inbox.lock().unwrap_or_else(PoisonError::into_inner) = Some(path);
                    ctx.request_repaint_of(here);
                });
            }
            let why = "Find recordings in the Sessions panel";
            if icon_button(ui, icon::ICON_VIDEO_LIBRARY, "Show sessions", why).clicked() {
                cx.send.send(Command::ShowPanel(sessions::KEY));
            }
        });
    }

    /// The recordings, each with what became of it, and how they are aligned.
    pub fn list_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, work: &mut Work) {
        egui::ScrollArea::vertical()
            .id_salt("compared")
            .max_height(LIST)
            .show(ui, |ui| {
                for (i, compared) in cx.view.compared.iter().enumerate() {
                    row_ui(ui, cx, i, compared, work);
                }
            });
        ui.horizontal_wrapped(|ui| {
            self.align_ui(ui, cx, work);
            self.finger_ui(ui);
            let again = icon_button(
                ui,
                icon::ICON_REFRESH,
                "Read recordings again",
                "Read again those that changed on the disk",
            );
            if again.clicked() {
                work.renew();
            }
            if let Some(status) = work.progress() {
                let bar = egui::ProgressBar::new(status.fraction as f32)
                    .desired_width(120.0)
                    .desired_height(8.0);
                ui.add(bar).on_hover_text(&status.part);
                let stop = ui
                    .small_button("Stop")
                    .on_hover_text("Stop reading; what is known stays");
                named(ui, &stop, "Stop comparing");
                if stop.clicked() {
                    work.stop();
                }
            } else if work.is_stopped() {
                let go_on = ui.small_button("Go on").on_hover_text("Read the rest");
                named(ui, &go_on, "Go on comparing");
                if go_on.clicked() {
                    work.resume();
                }
            }
        });
    }

    fn align_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, work: &Work) {
        ui.label("Align");
        let mut offers = vec![
            Align::Time,
            Align::Event(Anchor::FirstContact),
            Align::Event(Anchor::Press(1)),
            Align::Dtw,
        ];
        let told = cx.view.compared.iter().filter_map(|c| work.of(&c.path));
        let mut kinds: Vec<String> = told
            .filter_map(|t| t.as_ref().ok())
            .flat_map(|t| t.analysis.events.iter().map(|e| e.kind.clone()))
            .collect();
        kinds.sort_unstable();
        kinds.dedup();
        offers.extend(
            kinds
                .into_iter()
                .take(12)
                .map(|kind| Align::Event(Anchor::Event { kind, nth: 1 })),
        );
        let combo = egui::ComboBox::from_id_salt("align")
            .selected_text(words(&self.align))
            .width(190.0)
            .show_ui(ui, |ui| {
                for offer in offers {
                    let text = words(&offer);
                    ui.selectable_value(&mut self.align, offer, text);
                }
            });
        let why = "What is the same instant in all of them";
        combo.response.on_hover_text(why).widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Align recordings")
        });
    }

    fn finger_ui(&mut self, ui: &mut egui::Ui) {
        let mut finger = self.options().finger;
        let combo = egui::ComboBox::from_id_salt("finger")
            .selected_text(finger_name(finger))
            .width(130.0)
            .show_ui(ui, |ui| {
                for i in 0..crate::device::MAX_FINGERS as u8 {
                    ui.selectable_value(&mut finger, i, finger_name(i));
                }
            });
        let why = "Whose traces are shown and compared";
        combo.response.on_hover_text(why).widget_info(|| {
            egui::WidgetInfo::labeled(egui::accesskit::Role::ComboBox, true, "Compared finger")
        });
        self.finger = Some(finger);
    }
}

fn words(align: &Align) -> String {
    match align {
        Align::Time => "by start".into(),
        Align::Event(anchor) => format!("by {anchor}"),
        Align::Dtw => "by dynamic time warping".into(),
    }
}

fn add(cx: &PanelContext<'_>, path: PathBuf) {
    let tags = Vec::new();
    cx.send
        .send(Command::Compare(vec![Compared { path, tags }]));
}

fn row_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, i: usize, compared: &Compared, work: &Work) {
    let theme = &cx.view.theme;
    ui.horizontal(|ui| {
        swatch(ui, theme.ghost(i));
        ui.label(RichText::new(letter(i)).strong());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let name = format!("Take {} out", letter(i));
            let why = "Take it out of the comparison";
            if icon_button(ui, icon::ICON_CLOSE, &name, why).clicked() {
                cx.send.send(Command::Uncompare(compared.path.clone()));
            }
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let file = crate::app::bench::file_name(&compared.path);
                let (text, colour) = match work.of(&compared.path) {
                    None => (format!("{file} · not read yet"), theme.weak_text),
                    Some(Err(why)) => (why.clone(), theme.warning),
                    Some(Ok(told)) => {
                        let about = &told.analysis.about;
                        let date: String = about.started_utc.chars().take(16).collect();
                        let mut parts: Vec<String> = about.participant.iter().cloned().collect();
                        parts.push(about.scenario.clone());
                        parts.push(date.replace('T', " "));
                        parts.push(duration(about.seconds));
                        parts.extend(compared.tags.iter().cloned());
                        (parts.join(" · "), theme.text)
                    }
                };
                let label = RichText::new(text).size(12.5).color(colour);
                ui.add(Label::new(label).truncate())
                    .on_hover_text(compared.path.display().to_string());
            });
        });
    });
}
