//! The open scene and what an editor made of it: edits go out, at a bounded rate; what others change comes in.

use crate::app::command::Command;
use crate::app::panels::PanelContext;
use crate::scenario::Scene;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Least time between two edits that are sent.
const PERIOD: Duration = Duration::from_millis(33);
/// Edits remembered until the scene shows them.
const REMEMBERED: usize = 64;

/// What became of the scene since the last look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// Nothing that the editor does not know.
    Same,
    /// The same scene, edited elsewhere.
    Edited,
    /// Another scene.
    Another,
}

/// Follows the scene and sends edits.
#[derive(Default)]
pub struct Sync {
    generation: Option<u64>,
    scene: Option<Arc<Scene>>,
    /// Sources that were sent and have not come back, oldest first.
    sent: VecDeque<String>,
    sent_at: Option<Instant>,
    waiting: bool,
}

impl Sync {
    /// Forgets the scene.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Looks at the scene on show.
    pub fn look(&mut self, scene: &Arc<Scene>, generation: u64) -> Seen {
        if self.generation != Some(generation) {
            *self = Self {
                generation: Some(generation),
                scene: Some(scene.clone()),
                ..Self::default()
            };
            return Seen::Another;
        }
        if self.scene.as_ref().is_some_and(|s| Arc::ptr_eq(s, scene)) {
            return Seen::Same;
        }
        self.scene = Some(scene.clone());
        // Edits that follow fast are put together: with one that came back all before it are done.
        match self.sent.iter().position(|s| *s == scene.scenario.source) {
            Some(at) => {
                self.sent.drain(..=at);
                Seen::Same
            }
            None => Seen::Edited,
        }
    }

    /// Whether an edit waits for its time.
    pub fn is_waiting(&self) -> bool {
        self.waiting
    }

    /// Notes that there is something to send.
    pub fn want(&mut self) {
        self.waiting = true;
    }

    /// Nothing to send after all.
    pub fn drop_wish(&mut self) {
        self.waiting = false;
    }

    /// Sends what `write` makes of the scene's source, when it is wanted and time; else asks for a later frame.
    ///
    /// # Errors
    /// What `write` says; nothing is sent then.
    pub fn send(
        &mut self,
        ctx: &egui::Context,
        cx: &PanelContext<'_>,
        now: Instant,
        write: impl FnOnce(&str) -> Result<String, String>,
    ) -> Result<(), String> {
        let Some(scene) = self.scene.as_ref().filter(|_| self.waiting) else {
            return Ok(());
        };
        let since = self.sent_at.map(|at| now.saturating_duration_since(at));
        if let Some(rest) = since.and_then(|s| PERIOD.checked_sub(s)) {
            ctx.request_repaint_after(rest);
            return Ok(());
        }
        self.waiting = false;
        let source = write(&scene.scenario.source)?;
        if self.sent.back().unwrap_or(&scene.scenario.source) == &source {
            return Ok(());
        }
        self.sent_at = Some(now);
        if self.sent.len() == REMEMBERED {
            self.sent.pop_front();
        }
        self.sent.push_back(source.clone());
        cx.send.send(Command::EditScene { source });
        Ok(())
    }
}
