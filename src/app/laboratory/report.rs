//! How results become files: beside the window, all of them or none.

use crate::app::command::{Command, CommandSender};
use crate::app::messages::Level;
use crate::lab::{self, Document};
use std::path::PathBuf;
use std::sync::Arc;

/// Writes a document into `folder`, which is made where it is missing, and tells how that went.
pub fn save(document: Arc<Document>, name: &'static str, folder: PathBuf, send: &CommandSender) {
    let tell = send.clone();
    let work = move || {
        let written =
            std::fs::create_dir_all(&folder).and_then(|()| lab::write(&document, name, &folder));
        let (level, text) = match written {
            Ok(files) => (
                Level::Info,
                format!(
                    "Report written: {} and {} more files beside it",
                    folder.join(format!("{name}.html")).display(),
                    files.len().saturating_sub(1)
                ),
            ),
            Err(e) => (
                Level::Error,
                format!("The report cannot be written: {}: {e}", folder.display()),
            ),
        };
        tell.send(Command::Tell(level, text));
    };
    let spawned = std::thread::Builder::new()
        .name("lab report".into())
        .spawn(work);
    if let Err(e) = spawned {
        let text = format!("The report cannot be written: {e}");
        send.send(Command::Tell(Level::Error, text));
    }
}
