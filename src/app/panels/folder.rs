//! The folder that a panel lists: typed, or chosen in a dialog, and remembered.

use crate::app::command::CommandSender;
use crate::app::dialogs;
use crate::app::widgets::named;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A folder that was chosen, or none.
#[derive(Default)]
pub struct FolderChoice {
    chosen: Option<PathBuf>,
    /// Its path while it is typed.
    typed: Option<String>,
    /// What a dialog answered.
    inbox: Arc<Mutex<Option<PathBuf>>>,
}

/// What its row says.
pub struct Words {
    /// What is in the folder, in the dialog's title.
    pub what: &'static str,
    /// What it is for, and what an empty path means.
    pub field: &'static str,
    /// What the button is for.
    pub button: &'static str,
}

impl FolderChoice {
    /// The folder that was chosen last, also in a dialog since.
    pub fn get(&mut self) -> Option<&PathBuf> {
        let mut inbox = self.inbox.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(folder) = inbox.take() {
            self.chosen = Some(folder);
        }
        drop(inbox);
        self.chosen.as_ref()
    }

    /// As a panel remembers it.
    pub fn keep(&self) -> Option<String> {
        let folder = self.chosen.as_ref()?.to_str()?;
        Some(format!("folder={folder}"))
    }

    /// Takes back what [`Self::keep`] gave; leaves what it does not understand.
    pub fn recall(&mut self, kept: &str) {
        if let Some(folder) = kept.strip_prefix("folder=").filter(|f| !f.is_empty()) {
            self.chosen = Some(PathBuf::from(folder));
        }
    }

    /// Field and button, with `room` points left free behind them; `folder` is the one that is listed.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        send: &CommandSender,
        folder: &Path,
        words: &Words,
        room: f32,
    ) {
        let label = ui.label("Folder");
        let said = folder.display().to_string();
        let mut text = self.typed.clone().unwrap_or(said);
        let width = (ui.available_width() - 84.0 - room).max(60.0);
        let field = ui
            .add(egui::TextEdit::singleline(&mut text).desired_width(width))
            .labelled_by(label.id)
            .on_hover_text(words.field);
        if field.changed() {
            self.typed = Some(text);
        }
        if field.lost_focus()
            && let Some(text) = self.typed.take()
        {
            let text = text.trim();
            self.chosen = (!text.is_empty()).then(|| PathBuf::from(text));
        }
        let button = ui.button("Choose…").on_hover_text(words.button);
        named(ui, &button, &format!("Choose folder of {}…", words.what));
        if button.clicked() {
            let (inbox, ctx) = (self.inbox.clone(), ui.ctx().clone());
            let here = ctx.viewport_id();
            dialogs::open_folder(send, words.what, move |path| {
                *inbox.lock().unwrap_or_else(PoisonError::into_inner) = Some(path);
                ctx.request_repaint_of(here);
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_what_was_chosen() {
        let mut choice = FolderChoice::default();
        assert!(choice.keep().is_none() && choice.get().is_none());
        for nonsense in ["", "folder=", "file=/a"] {
            choice.recall(nonsense);
            assert!(choice.get().is_none(), "{nonsense}");
        }
        choice.recall("folder=/a/b c");
        assert_eq!(choice.keep().as_deref(), Some("folder=/a/b c"));
        // A dialog that answers meanwhile counts.
        *choice.inbox.lock().expect("sound") = Some(PathBuf::from("/d"));
        assert_eq!(choice.get(), Some(&PathBuf::from("/d")));
    }
}
