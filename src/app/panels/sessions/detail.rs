//! What is told of the row that is current, and what can be done with it.

use super::entry::{Entry, State, duration};
use crate::app::command::Command;
use crate::app::panels::{BACK_VIEW_KEY, PanelContext};
use crate::app::state::Compared;
use crate::app::widgets::{bytes, named};
use egui::{Label, RichText};
use egui_material_icons::icons as icon;
use std::path::PathBuf;

/// The tags as they are typed, and of which recording.
#[derive(Default)]
pub struct Typed(Option<(PathBuf, String)>);

/// Draws it; answers the tags that were entered.
pub fn ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    entry: &Entry,
    typed: &mut Typed,
) -> Option<Vec<String>> {
    let theme = &cx.view.theme;
    ui.horizontal(|ui| {
        ui.add(Label::new(RichText::new(entry.file()).strong()).truncate())
            .on_hover_text(entry.path.display().to_string());
    });
    let facts: Vec<String> = [
        Some(entry.date())
            .filter(|d| !d.is_empty())
            .map(|d| d + " UTC"),
        entry.participant.clone(),
        entry.seconds.map(duration),
        Some(bytes(entry.bytes)),
        (entry.lost > 0).then(|| format!("{} ticks lost", entry.lost)),
    ]
    .into_iter()
    .flatten()
    .collect();
    ui.add(Label::new(RichText::new(facts.join(" · ")).size(12.0).weak()).truncate());
    let fault = match &entry.state {
        State::Unread | State::Good => None,
        State::Sealed => Some((
            "Sealed: its trial was not answered, so it tells nothing",
            theme.weak_text,
        )),
        State::Damaged(why) | State::Unreadable(why) => Some((why.as_str(), theme.warning)),
    };
    if let Some((text, colour)) = fault {
        ui.add(Label::new(RichText::new(text).size(12.0).color(colour)).truncate())
            .on_hover_text(text);
    }
    let tags = tags_ui(ui, entry, typed);
    actions_ui(ui, cx, entry);
    tags
}

fn tags_ui(ui: &mut egui::Ui, entry: &Entry, typed: &mut Typed) -> Option<Vec<String>> {
    let mut entered = None;
    ui.horizontal(|ui| {
        let label = ui.label("Tags");
        let said = entry.tags.join(", ");
        let mut text = match &typed.0 {
            Some((path, text)) if *path == entry.path => text.clone(),
            _ => said.clone(),
        };
        let field = ui
            .add(
                egui::TextEdit::singleline(&mut text)
                    .hint_text("novice, before")
                    .desired_width((ui.available_width() - 8.0).max(60.0)),
            )
            .labelled_by(label.id)
            .on_hover_text(
                "Words to find and group it by, with commas between them; Enter keeps them",
            );
        if field.changed() {
            typed.0 = Some((entry.path.clone(), text));
        }
        if field.lost_focus()
            && let Some((path, text)) = typed.0.take()
            && path == entry.path
        {
            let tags = tags_of(&text);
            entered = (tags != entry.tags).then_some(tags);
        }
    });
    entered
}

/// The tags in a text: between commas, none twice, none empty.
fn tags_of(text: &str) -> Vec<String> {
    let mut tags: Vec<String> = Vec::new();
    for tag in text.split(',').map(str::trim).filter(|t| !t.is_empty()) {
        if !tags.iter().any(|t| t == tag) {
            tags.push(tag.to_owned());
        }
    }
    tags
}

fn actions_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, entry: &Entry) {
    ui.horizontal_wrapped(|ui| {
        let open = ui
            .add_enabled(
                entry.can_open(),
                egui::Button::new((icon::ICON_PLAY_ARROW.rich_text(), "Replay")),
            )
            .on_hover_text("Show it in the Back view, the plots and the recorder")
            .on_disabled_hover_text("There is nothing in it that could be shown");
        named(ui, &open, "Replay recording");
        if open.clicked() {
            replay(cx, entry.path.clone());
        }
        let compare = ui
            .add_enabled(
                entry.can_open(),
                egui::Button::new((icon::ICON_DIFFERENCE.rich_text(), "Compare")),
            )
            .on_hover_text("Add it to the recordings that the Compare panel sets side by side")
            .on_disabled_hover_text("There is nothing in it that could be compared");
        named(ui, &compare, "Add to comparison");
        if compare.clicked() {
            let (path, tags) = (entry.path.clone(), entry.tags.clone());
            cx.send
                .send(Command::Compare(vec![Compared { path, tags }]));
        }
        let ghost = ui
            .add_enabled(
                entry.can_open(),
                egui::Button::new((icon::ICON_LAYERS.rich_text(), "Ghost")),
            )
            .on_hover_text("Overlay its fingers, translucent, on the recording that is replayed")
            .on_disabled_hover_text("There is nothing in it that could be shown");
        named(ui, &ghost, "Show as ghost");
        if ghost.clicked() {
            cx.send.send(Command::AddGhosts(vec![entry.path.clone()]));
        }
        if entry.needs_recovery() {
            let recover = ui
                .button((icon::ICON_HEALING.rich_text(), "Recover"))
                .on_hover_text(
                    "Write what can be read of it to a new file beside it; it stays as it is",
                );
            named(ui, &recover, "Recover recording");
            if recover.clicked() {
                cx.send.send(Command::RecoverRecording(entry.path.clone()));
            }
        }
    });
}

/// Replays a recording and shows where it can be seen.
pub fn replay(cx: &PanelContext<'_>, path: PathBuf) {
    cx.send.send(Command::OpenRecording(path));
    cx.send.send(Command::ShowPanel(BACK_VIEW_KEY));
    cx.send
        .send(Command::ShowPanel(crate::app::panels::RECORDER_KEY));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_stand_between_commas() {
        assert_eq!(tags_of(" novice, before ,,novice"), ["novice", "before"]);
        assert!(tags_of(" , ").is_empty());
    }
}
