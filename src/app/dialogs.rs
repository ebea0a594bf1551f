//! File dialogs, off the window's thread: with a desktop portal they block, without one they return nothing at once.

use super::command::{Command, CommandSender};
use super::messages::Level;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A dialog that closes faster than this was never shown.
const UNSEEN: Duration = Duration::from_millis(150);

/// Asks for a scenario file and opens it.
pub fn open_scenario(send: &CommandSender) {
    ask(send, "a scenario", |dialog| {
        dialog
            .set_title("Open scenario")
            .add_filter("Scenario", &["toml"])
            .pick_file()
            .map(Command::OpenScenario)
    });
}

/// Asks where to write the open scene.
pub fn save_scenario(send: &CommandSender, folder: Option<PathBuf>, name: String) {
    ask(send, "a place for the scenario", move |dialog| {
        let dialog = dialog
            .set_title("Save scenario as")
            .add_filter("Scenario", &["toml"])
            .set_file_name(name);
        let dialog = match folder {
            Some(folder) => dialog.set_directory(folder),
            None => dialog,
        };
        // The dialog asks before it names a file that is there.
        let replace = true;
        dialog
            .save_file()
            .map(|path| Command::SaveScenarioAs { path, replace })
    });
}

/// Asks for a recording and opens it.
pub fn open_recording(send: &CommandSender, folder: PathBuf) {
    ask(send, "a recording", move |dialog| {
        dialog
            .set_title("Open recording")
            .add_filter("Recording", &["mcap"])
            .set_directory(folder)
            .pick_file()
            .map(Command::OpenRecording)
    });
}

/// Asks for a recording; `then` gets its path.
pub fn pick_recording(
    send: &CommandSender,
    folder: PathBuf,
    then: impl FnOnce(PathBuf) + Send + 'static,
) {
    ask(send, "a recording", move |dialog| {
        let picked = dialog
            .set_title("Choose recording")
            .add_filter("Recording", &["mcap"])
            .set_directory(folder)
            .pick_file();
        answered(picked, then)
    });
}

/// Asks where to copy a recording to.
pub fn save_recording(send: &CommandSender, from: PathBuf) {
    ask(send, "a place for the recording", move |dialog| {
        let name = super::bench::file_name(&from);
        dialog
            .set_title("Save recording as")
            .add_filter("Recording", &["mcap"])
            .set_file_name(name)
            .save_file()
            .map(|to| Command::CopyRecording { from, to })
    });
}

/// Asks for a file with a table; `then` gets its path.
pub fn open_table(
    send: &CommandSender,
    what: &'static str,
    then: impl FnOnce(PathBuf) + Send + 'static,
) {
    ask(send, what, move |dialog| {
        let picked = dialog
            .set_title(format!("Import {what}"))
            .add_filter("Table", &["csv"])
            .pick_file();
        answered(picked, then)
    });
}

/// Asks where to write a table; `then` gets its path.
pub fn save_table(
    send: &CommandSender,
    what: &'static str,
    file_name: &'static str,
    then: impl FnOnce(PathBuf) + Send + 'static,
) {
    ask(send, what, move |dialog| {
        let picked = dialog
            .set_title(format!("Export {what}"))
            .add_filter("Table", &["csv"])
            .set_file_name(file_name)
            .save_file();
        answered(picked, then)
    });
}

/// Asks where to write a page; `then` gets its path.
pub fn save_page(
    send: &CommandSender,
    what: &'static str,
    folder: PathBuf,
    file_name: &'static str,
    then: impl FnOnce(PathBuf) + Send + 'static,
) {
    ask(send, what, move |dialog| {
        let picked = dialog
            .set_title(format!("Save {what}"))
            .add_filter("Page", &["html"])
            .set_directory(folder)
            .set_file_name(file_name)
            .save_file();
        answered(picked, then)
    });
}

/// Asks for a folder to write into; `then` gets its path.
pub fn open_folder(
    send: &CommandSender,
    what: &'static str,
    then: impl FnOnce(PathBuf) + Send + 'static,
) {
    ask(send, what, move |dialog| {
        let picked = dialog.set_title(format!("Folder for {what}")).pick_folder();
        answered(picked, then)
    });
}

/// Hands a picked path on; a dialog that was closed without one is no command.
fn answered(picked: Option<PathBuf>, then: impl FnOnce(PathBuf)) -> Option<Command> {
    then(picked?);
    None
}

fn ask(
    send: &CommandSender,
    what: &'static str,
    show: impl FnOnce(rfd::FileDialog) -> Option<Command> + Send + 'static,
) {
    let thread_send = send.clone();
    let spawned = std::thread::Builder::new()
        .name("file dialog".into())
        .spawn(move || {
            let start = Instant::now();
            match show(rfd::FileDialog::new()) {
                Some(command) => thread_send.send(command),
                None if start.elapsed() < UNSEEN => thread_send.send(Command::Tell(
                    Level::Warning,
                    format!(
                        "This desktop offers no file dialog: type the path of {what} into the field beside the button"
                    ),
                )),
                None => {}
            }
        });
    if let Err(e) = spawned {
        send.send(Command::Tell(
            Level::Error,
            format!("the file dialog cannot open: {e}"),
        ));
    }
}
