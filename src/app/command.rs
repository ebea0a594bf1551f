//! What a user can ask for, and how panels ask for it.
//!
//! [`Action`] is the one list of things with a name: menu, palette, keys and tooltips derive from it. [`Command`] is what
//! travels: an action or a wish that carries a value.

use super::bench::Wish;
use super::hardware::DeviceWish;
use super::messages::Level;
use super::state::{Alignment, Compared};
use egui::{Key, KeyboardShortcut, Modifiers};
use egui_material_icons::MaterialIcon;
use egui_material_icons::icons as icon;
use std::path::PathBuf;
use std::sync::{Arc, mpsc};

/// A wish sent to the bench or the shell, applied in one `match`.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Something from the list.
    Do(Action),
    /// Open a scenario file.
    OpenScenario(PathBuf),
    /// Open an embedded example by its file name.
    OpenExample(&'static str),
    /// Go over to an edit of the open scene, under the finger. Only the newest of many is built and felt.
    EditScene {
        /// The scenario as edited, whole.
        source: String,
    },
    /// Write the open scene to a file, which is its own from then on.
    SaveScenarioAs {
        /// The file.
        path: PathBuf,
        /// Someone has said that one that is there may be replaced.
        replace: bool,
    },
    /// Stop building the scene that is being built.
    CancelBuild,
    /// Switch force output on or off.
    EnableForce(bool),
    /// Ask something of a device.
    Device(DeviceWish),
    /// Open a recording.
    OpenRecording(PathBuf),
    /// Copy a recording to another place.
    CopyRecording {
        /// The recording.
        from: PathBuf,
        /// The new file.
        to: PathBuf,
    },
    /// Write what can be read of a damaged recording to a new file beside it.
    RecoverRecording(PathBuf),
    /// Add recordings to those that are compared, and show them.
    Compare(Vec<Compared>),
    /// A recording has other tags now; if it is compared, it is compared with these.
    Retag(Compared),
    /// Take a recording out of those that are compared.
    Uncompare(PathBuf),
    /// Show recordings as ghosts beside the one that is replayed.
    AddGhosts(Vec<PathBuf>),
    /// Take a ghost away.
    RemoveGhost(PathBuf),
    /// Show a ghost later, s, or earlier.
    SetGhostOffset {
        /// Which.
        path: PathBuf,
        /// By how much, s.
        offset_s: f64,
    },
    /// What makes the times of the ghosts that of the open recording.
    AlignGhosts(Alignment),
    /// Note something in the recording that is being written.
    Mark(String),
    /// Give new recordings this pseudonym; none when empty.
    SetParticipant(String),
    /// Compress recordings when they are finished, or leave them as they are.
    SetCompressed(bool),
    /// Pause at each event of the open recording, or play past them.
    SetFollowing(bool),
    /// Go to a time of the open recording, s.
    Seek(f64),
    /// Let time of the open recording run or stand.
    SetPlaying(bool),
    /// Replay at this speed, 1 is real time.
    SetSpeed(f64),
    /// Start over at the end of the recording, or stay there.
    SetLooped(bool),
    /// Show a panel and bring it to the front.
    ShowPanel(&'static str),
    /// Close a panel.
    ClosePanel(&'static str),
    /// Close a panel that is on screen, or bring it to the front.
    TogglePanel(&'static str),
    /// Give a panel a window of its own.
    PopOut(&'static str),
    /// Bring a panel back from its own window.
    DockBack(&'static str),
    /// Open or close the trainee's own window.
    ShowTraineeWindow(bool),
    /// Something of an exercise.
    Exercise(Wish),
    /// Add a line to the messages.
    Tell(Level, String),
}

/// Everything a user can ask for by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "each is documented by its tooltip")]
pub enum Action {
    OpenScenario,
    SaveScenario,
    SaveScenarioAs,
    OpenRecording,
    SaveRecordingAs,
    Quit,
    Record,
    Mark,
    PlayPause,
    StepBack,
    StepForward,
    PreviousEvent,
    NextEvent,
    BackToLive,
    StopForce,
    AllowForce,
    ToggleTheme,
    Fullscreen,
    Palette,
    ResetLayout,
    ResetTiming,
    ClearMessages,
    BeInstructor,
    BeTrainee,
    BeResearcher,
    TraineeWindow,
}

/// Which menu an action is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names of the menus")]
pub enum Menu {
    File,
    Session,
    View,
    Role,
}

/// What there is to know about an action.
#[derive(Clone, Copy, Debug)]
pub struct ActionSpec {
    /// Its name in menus, sentence case; "…" when a dialog follows.
    pub text: &'static str,
    /// Why one would want it.
    pub tooltip: &'static str,
    /// Its icon.
    pub icon: MaterialIcon,
    /// Its menu.
    pub menu: Menu,
    /// Its key.
    pub shortcut: Option<KeyboardShortcut>,
}

const fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

const fn ctrl_shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(
        Modifiers::COMMAND.plus(Modifiers::SHIFT),
        key,
    ))
}

const fn plain(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

impl Action {
    /// All of them, in the order of the menus.
    pub const ALL: [Self; 26] = [
        Self::OpenScenario,
        Self::SaveScenario,
        Self::SaveScenarioAs,
        Self::OpenRecording,
        Self::SaveRecordingAs,
        Self::Quit,
        Self::Record,
        Self::Mark,
        Self::PlayPause,
        Self::StepBack,
        Self::StepForward,
        Self::PreviousEvent,
        Self::NextEvent,
        Self::BackToLive,
        Self::StopForce,
        Self::AllowForce,
        Self::ToggleTheme,
        Self::Fullscreen,
        Self::Palette,
        Self::ResetLayout,
        Self::ResetTiming,
        Self::ClearMessages,
        Self::BeInstructor,
        Self::BeTrainee,
        Self::BeResearcher,
        Self::TraineeWindow,
    ];

    /// What there is to know about it.
    pub fn spec(self) -> ActionSpec {
        let (menu, text, tooltip, icon, shortcut) = match self {
            Self::OpenScenario => (
                Menu::File,
                "Open scenario…",
                "Feel another back: choose a scenario file",
                icon::ICON_FOLDER_OPEN,
                ctrl(Key::O),
            ),
            Self::SaveScenario => (
                Menu::File,
                "Save scenario",
                "Write the open scene, as edited, to its file",
                icon::ICON_SAVE,
                ctrl(Key::S),
            ),
            Self::SaveScenarioAs => (
                Menu::File,
                "Save scenario as…",
                "Write the open scene, as edited, to a file of your choice",
                icon::ICON_SAVE_AS,
                ctrl_shift(Key::S),
            ),
            Self::OpenRecording => (
                Menu::File,
                "Open recording…",
                "Replay a session recorded earlier",
                icon::ICON_HISTORY,
                ctrl_shift(Key::O),
            ),
            Self::SaveRecordingAs => (
                Menu::File,
                "Save recording as…",
                "Copy the open or the last recording to a place of your choice",
                icon::ICON_FILE_COPY,
                ctrl_shift(Key::R),
            ),
            Self::Quit => (
                Menu::File,
                "Quit",
                "Close the workbench; a running recording is finished first",
                icon::ICON_LOGOUT,
                ctrl(Key::Q),
            ),
            Self::Record => (
                Menu::Session,
                "Record or stop",
                "Write every tick of every finger to a session file, or finish it",
                icon::ICON_FIBER_MANUAL_RECORD,
                ctrl(Key::R),
            ),
            Self::Mark => (
                Menu::Session,
                "Mark this instant",
                "Note this instant in the recording that is being written, to find it again",
                icon::ICON_BOOKMARK_ADD,
                ctrl(Key::M),
            ),
            Self::PlayPause => (
                Menu::Session,
                "Play or pause",
                "Let the time of the open recording run or stand still",
                icon::ICON_PLAY_ARROW,
                plain(Key::Space),
            ),
            Self::StepBack => (
                Menu::Session,
                "Step back",
                "Go one tick back in the open recording",
                icon::ICON_SKIP_PREVIOUS,
                plain(Key::Comma),
            ),
            Self::StepForward => (
                Menu::Session,
                "Step forward",
                "Go one tick on in the open recording",
                icon::ICON_SKIP_NEXT,
                plain(Key::Period),
            ),
            Self::PreviousEvent => (
                Menu::Session,
                "Previous event",
                "Go back to the last mark, answer or other event of the open recording",
                icon::ICON_FIRST_PAGE,
                plain(Key::OpenBracket),
            ),
            Self::NextEvent => (
                Menu::Session,
                "Next event",
                "Go on to the next mark, answer or other event of the open recording",
                icon::ICON_LAST_PAGE,
                plain(Key::CloseBracket),
            ),
            Self::BackToLive => (
                Menu::Session,
                "Back to live",
                "Close the recording and show the fingers as they are now",
                icon::ICON_SENSORS,
                ctrl(Key::L),
            ),
            Self::StopForce => (
                Menu::Session,
                "Stop force",
                "Emergency stop: every device goes to zero force at once and stays there",
                icon::ICON_FRONT_HAND,
                plain(Key::Escape),
            ),
            Self::AllowForce => (
                Menu::Session,
                "Allow force",
                "Let the devices render force again after a stop",
                icon::ICON_BOLT,
                ctrl(Key::E),
            ),
            Self::ToggleTheme => (
                Menu::View,
                "Light or dark",
                "Change between the light and the dark window",
                icon::ICON_DARK_MODE,
                ctrl(Key::T),
            ),
            Self::Fullscreen => (
                Menu::View,
                "Full screen",
                "Use the whole screen, or a window again",
                icon::ICON_FULLSCREEN,
                plain(Key::F11),
            ),
            Self::Palette => (
                Menu::View,
                "Find a command…",
                "Type part of a name to run any command or open any panel",
                icon::ICON_SEARCH,
                ctrl(Key::P),
            ),
            Self::ResetLayout => (
                Menu::View,
                "Reset layout",
                "Put every panel back where it was at first",
                icon::ICON_DASHBOARD,
                None,
            ),
            Self::ResetTiming => (
                Menu::View,
                "Reset timing",
                "Start the servo's timing statistics anew",
                icon::ICON_RESTART_ALT,
                None,
            ),
            Self::ClearMessages => (
                Menu::View,
                "Clear messages",
                "Forget all messages so far",
                icon::ICON_DELETE,
                None,
            ),
            Self::BeInstructor => (
                Menu::Role,
                "Instructor",
                "Make scenarios and watch a trainee: scenario editor, exercise with its truth, live plots",
                icon::ICON_SCHOOL,
                None,
            ),
            Self::BeTrainee => (
                Menu::Role,
                "Trainee",
                "Palpate and answer: the back and the exercise, nothing that gives it away",
                icon::ICON_TOUCH_APP,
                None,
            ),
            Self::BeResearcher => (
                Menu::Role,
                "Researcher",
                "Measure, record, replay and compare: plots, timing, recorder",
                icon::ICON_SCIENCE,
                None,
            ),
            Self::TraineeWindow => (
                Menu::Role,
                "Trainee's window",
                "A window for the trainee, full screen on the second screen; this one keeps the truth",
                icon::ICON_DESKTOP_WINDOWS,
                ctrl_shift(Key::W),
            ),
        };
        ActionSpec {
            text,
            tooltip,
            icon,
            menu,
            shortcut,
        }
    }

    /// Actions whose key works only while a recording is open.
    pub fn needs_recording(self) -> bool {
        matches!(
            self,
            Self::PlayPause
                | Self::StepBack
                | Self::StepForward
                | Self::PreviousEvent
                | Self::NextEvent
                | Self::BackToLive
        )
    }
}

/// The key that toggles the panel at `index` of the list of panels: Ctrl+1 for the first.
pub fn panel_shortcut(index: usize) -> Option<KeyboardShortcut> {
    const KEYS: [Key; 9] = [
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    KEYS.get(index)
        .map(|key| KeyboardShortcut::new(Modifiers::COMMAND, *key))
}

/// The sending end of the bounded queue of commands.
#[derive(Clone)]
pub struct CommandSender {
    queue: mpsc::SyncSender<Command>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl CommandSender {
    /// Sends a command and wakes the main window. When the queue is full, which takes hundreds of commands within one
    /// frame, it is dropped.
    pub fn send(&self, command: Command) {
        if self.queue.try_send(command).is_err() {
            log::warn!("too many commands at once: one was dropped");
        }
        (self.wake)();
    }

    /// Sends an action.
    pub fn act(&self, action: Action) {
        self.send(Command::Do(action));
    }
}

/// A bounded queue of commands; `wake` is called after each.
pub fn queue(wake: Arc<dyn Fn() + Send + Sync>) -> (CommandSender, mpsc::Receiver<Command>) {
    let (queue, receiver) = mpsc::sync_channel(256);
    (CommandSender { queue, wake }, receiver)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_key_does_two_things() {
        let mut seen = HashSet::new();
        let actions = Action::ALL.iter().filter_map(|a| a.spec().shortcut);
        let panels = (0..crate::app::panels::all().len()).filter_map(panel_shortcut);
        for shortcut in actions.chain(panels) {
            assert!(seen.insert(shortcut), "{shortcut:?} is taken twice");
        }
    }

    #[test]
    fn every_action_is_listed_once_and_says_what_it_is() {
        let mut texts = HashSet::new();
        for action in Action::ALL {
            let spec = action.spec();
            assert!(texts.insert(spec.text), "{} is listed twice", spec.text);
            assert!(spec.tooltip.len() > spec.text.len());
            assert!(!spec.text.ends_with([':', '.']));
        }
    }

    #[test]
    fn a_flood_of_commands_is_bounded() {
        let (sender, receiver) = queue(Arc::new(|| {}));
        for _ in 0..10_000 {
            sender.act(Action::Record);
        }
        assert_eq!(receiver.try_iter().count(), 256);
    }
}
