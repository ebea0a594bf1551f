//! Where keys are read from and written to: by a dialog, or by a typed path where a desktop offers none.

use crate::app::command::Command;
use crate::app::dialogs;
use crate::app::messages::Level;
use crate::app::panels::PanelContext;
use crate::app::widgets::named;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// What is to be done with a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Read keys from it.
    Import,
    /// Write keys to it.
    Export,
}

/// The row with path and buttons, and what came of a dialog.
#[derive(Default)]
pub struct Files {
    path: String,
    inbox: Arc<Mutex<Option<(Wish, PathBuf)>>>,
}

impl Files {
    /// Shows the row; returns what is wished, also what a dialog was answered.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        what: &'static str,
        file_name: &'static str,
        can_import: bool,
    ) -> Option<(Wish, PathBuf)> {
        let mut wish = None;
        let (ctx, here) = (ui.ctx().clone(), ui.ctx().viewport_id());
        let inbox = self.inbox.clone();
        let answer = move |wish: Wish| {
            move |path: PathBuf| {
                *inbox.lock().unwrap_or_else(PoisonError::into_inner) = Some((wish, path));
                ctx.request_repaint_of(here);
            }
        };
        ui.horizontal(|ui| {
            let label = ui.label("Path");
            ui.add(
                egui::TextEdit::singleline(&mut self.path)
                    .hint_text(format!("folder/{file_name}"))
                    .desired_width((ui.available_width() - 8.0).max(60.0)),
            )
            .labelled_by(label.id)
            .on_hover_text("A file by its path, where there is no file dialog");
        });
        ui.horizontal_wrapped(|ui| {
            let typed = PathBuf::from(self.path.trim());
            let some = !self.path.trim().is_empty();
            let text = if some { "Import" } else { "Import…" };
            let import = ui
                .add_enabled(can_import, egui::Button::new(text))
                .on_hover_text(format!(
                    "Read {what} from a CSV file in place of those here; undo brings these back"
                ));
            named(ui, &import, &format!("Import {what}"));
            if import.clicked() {
                if some {
                    wish = Some((Wish::Import, typed.clone()));
                } else {
                    dialogs::open_table(cx.send, what, answer.clone()(Wish::Import));
                }
            }
            let text = if some { "Export" } else { "Export…" };
            let export = ui
                .button(text)
                .on_hover_text(format!("Write {what} to a CSV file"));
            named(ui, &export, &format!("Export {what}"));
            if export.clicked() {
                if some {
                    wish = Some((Wish::Export, typed));
                } else {
                    dialogs::save_table(cx.send, what, file_name, answer(Wish::Export));
                }
            }
        });
        let answered = self
            .inbox
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        wish.or(answered)
    }
}

/// Writes `text` to `path` and says so.
pub fn export(cx: &PanelContext<'_>, path: &std::path::Path, text: &str, what: &str) {
    let (level, said) = match std::fs::write(path, text) {
        Ok(()) => (Level::Info, format!("{what} written to {}", path.display())),
        Err(e) => (
            Level::Error,
            format!("{}: cannot be written: {e}", path.display()),
        ),
    };
    cx.send.send(Command::Tell(level, said));
}
