//! Where every command is carried out.

use super::{Palette, Workbench};
use crate::app::bench::Source;
use crate::app::command::{Action, Command};
use crate::app::dialogs;
use crate::app::dock::Layout;
use crate::app::messages::Level;
use crate::app::panels;
use crate::app::roles::Role;
use crate::app::theme::Theme;

impl Workbench {
    /// Carries out one command.
    pub fn apply(&mut self, ctx: &egui::Context, command: Command) {
        let shared = self.shared.clone();
        match command {
            Command::Do(action) => self.act(ctx, action),
            Command::OpenScenario(path) => shared.bench().open(Source::File(path)),
            Command::OpenExample(file) => shared.bench().open_example(file),
            Command::EditScene { source } => shared.bench().edit_scene(source),
            Command::SaveScenarioAs { path, replace } => {
                shared.bench().save_scenario_as(path, replace);
            }
            Command::CancelBuild => shared.bench().cancel_build(),
            Command::EnableForce(on) => shared.bench().enable_force(on),
            Command::Device(wish) => shared.bench().device(wish),
            Command::OpenRecording(path) => shared.bench().open_recording(path),
            Command::CopyRecording { from, to } => shared.bench().copy_recording(&from, &to),
            Command::RecoverRecording(path) => shared.bench().recover_recording(path),
            Command::Compare(recordings) => {
                shared.bench().compare(recordings);
                self.layout_mut().show(panels::compare::KEY);
            }
            Command::Retag(recording) => shared.bench().retag(recording),
            Command::Uncompare(path) => shared.bench().uncompare(&path),
            Command::AddGhosts(paths) => shared.bench().add_ghosts(paths),
            Command::RemoveGhost(path) => shared.bench().remove_ghost(&path),
            Command::SetGhostOffset { path, offset_s } => {
                shared.bench().set_ghost_offset(&path, offset_s);
            }
            Command::AlignGhosts(alignment) => shared.bench().align_ghosts(alignment),
            Command::Mark(text) => shared.bench().mark(&text),
            Command::SetParticipant(name) => shared.bench().set_participant(name),
            Command::SetCompressed(on) => shared.bench().set_compresses(on),
            Command::SetFollowing(on) => shared.bench().set_following(on),
            Command::Seek(time_s) => shared.bench().seek(time_s),
            Command::SetPlaying(on) => shared.bench().set_playing(on),
            Command::SetSpeed(speed) => shared.bench().set_speed(speed),
            Command::SetLooped(on) => shared.bench().set_looped(on),
            Command::ShowPanel(key) => self.layout_mut().show(key),
            Command::ClosePanel(key) => self.layout_mut().close(key),
            Command::TogglePanel(key) => {
                let layout = self.layout_mut();
                if layout.is_shown(key) {
                    layout.close(key);
                } else {
                    layout.show(key);
                }
            }
            Command::PopOut(key) => self.layout_mut().pop_out(key),
            Command::DockBack(key) => self.layout_mut().dock_back(key),
            Command::ShowTraineeWindow(on) => shared.chrome().trainee_window = on,
            Command::Exercise(wish) => shared.bench().exercise(wish),
            Command::Tell(level, text) => shared.bench().tell(level, text),
        }
        ctx.request_repaint();
    }

    fn act(&mut self, ctx: &egui::Context, action: Action) {
        let shared = self.shared.clone();
        let send = &shared.send;
        match action {
            Action::OpenScenario => dialogs::open_scenario(send),
            Action::SaveScenario if shared.bench().scenario_path().is_some() => {
                shared.bench().save_scenario();
            }
            Action::SaveScenario | Action::SaveScenarioAs => {
                let (folder, name) = shared.bench().suggested_file();
                dialogs::save_scenario(send, folder, name);
            }
            Action::OpenRecording => {
                let folder = shared.bench().folder().to_owned();
                dialogs::open_recording(send, folder);
            }
            Action::SaveRecordingAs => {
                let from = shared.bench().recording_to_save();
                if let Some(from) = from {
                    dialogs::save_recording(send, from);
                }
            }
            Action::Quit => {
                ctx.send_viewport_cmd_to(egui::ViewportId::ROOT, egui::ViewportCommand::Close)
            }
            Action::Record => shared.bench().toggle_recording(),
            Action::Mark => shared.bench().mark(""),
            Action::PreviousEvent => shared.bench().seek_event(false),
            Action::NextEvent => shared.bench().seek_event(true),
            Action::PlayPause => shared.bench().play_or_pause(),
            Action::StepBack => shared.bench().step(-1),
            Action::StepForward => shared.bench().step(1),
            Action::BackToLive => shared.bench().close_recording(),
            Action::StopForce => shared.bench().enable_force(false),
            Action::AllowForce => shared.bench().enable_force(true),
            Action::ToggleTheme => {
                self.dark = !self.dark;
                Theme::of(self.dark).apply(ctx);
                shared.chrome().theme = Theme::of(self.dark);
            }
            Action::Fullscreen => {
                let on = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(egui::ViewportCommand::Fullscreen(!on));
            }
            Action::Palette => {
                self.palette = match self.palette.take() {
                    Some(_) => None,
                    None => Some(Palette::default()),
                };
            }
            Action::ResetLayout => *self.layout_mut() = Layout::of(self.role(), &shared.panels),
            Action::BeInstructor => self.take_role(Role::Instructor),
            Action::BeTrainee => self.take_role(Role::Trainee),
            Action::BeResearcher => self.take_role(Role::Researcher),
            Action::TraineeWindow => {
                let mut chrome = shared.chrome();
                chrome.trainee_window = !chrome.trainee_window;
            }
            Action::ResetTiming => shared.bench().reset_timing(),
            Action::ClearMessages => shared.bench().clear_messages(),
        }
    }

    /// Shows the workspace of `role`; not while an exercise runs, whose answer it might show.
    fn take_role(&mut self, role: Role) {
        if role != self.role() && self.shared.bench().is_blind() {
            let text = "The role stays while an exercise runs: end it first";
            self.shared.bench().tell(Level::Warning, text);
            return;
        }
        self.shared.chrome().role = role;
    }
}
