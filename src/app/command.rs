//! What a user can ask for, and how panels ask for it.

use std::path::PathBuf;
use std::sync::mpsc;

/// A wish sent to the bench or the shell, applied in one `match`.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Open a scenario file.
    OpenScenario(PathBuf),
    /// Switch force output on or off.
    EnableForce(bool),
}

/// The sending end of the bounded queue of commands.
#[derive(Clone, Debug)]
pub struct CommandSender(mpsc::SyncSender<Command>);

impl CommandSender {
    /// Sends a command. When the queue is full, which takes hundreds of commands within one frame, it is dropped.
    pub fn send(&self, command: Command) {
        if self.0.try_send(command).is_err() {
            log::warn!("too many commands at once: one was dropped");
        }
    }
}

/// A bounded queue of commands.
pub fn queue() -> (CommandSender, mpsc::Receiver<Command>) {
    let (sender, receiver) = mpsc::sync_channel(256);
    (CommandSender(sender), receiver)
}
