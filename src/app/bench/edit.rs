//! Edits of the open scene: from the text that an editor sends, to what is drawn and what the finger feels.
//!
//! An edit is the whole scenario as edited. It is built beside the window, from the scene that is open; drawn as soon as it is
//! built; and handed to the servo when the edit before it is wholly felt. Whoever drags a key sends many: of those that come
//! in the meantime only the newest is built, and only the newest built is felt.

use super::builder::Built;
use super::job::Job;
use super::live::Live;
use super::{Bench, Ready, Wake};
use crate::app::messages::Level;
use crate::app::state::BuildStatus;
use crate::scenario::{self, BuildError, Scenario, Scene, Use};
use std::sync::Arc;

/// Number of an edit and the scenario as edited.
pub type EditText = (u32, Arc<str>);

/// The edits on their way.
pub struct Edits {
    /// The newest that was asked for and is not being built.
    wanted: Option<String>,
    build: Option<Job<Result<Built, BuildError>>>,
    /// Drawn, and waiting for the edit before it to be wholly felt.
    ready: Option<Arc<Scene>>,
    /// The newest that the servo wholly feels, and the one that it is going over to.
    settled: EditText,
    under_way: Option<EditText>,
    applied: u64,
    /// What was last wrong, told once.
    fault: String,
}

impl Default for Edits {
    fn default() -> Self {
        Self {
            wanted: None,
            build: None,
            ready: None,
            settled: (0, Arc::from("")),
            under_way: None,
            applied: 0,
            fault: String::new(),
        }
    }
}

impl Edits {
    /// Counts those that were drawn.
    pub fn applied(&self) -> u64 {
        self.applied
    }

    /// The newest edit that is wholly felt: a recording that begins now names its scenario.
    pub fn settled(&self) -> &EditText {
        &self.settled
    }

    /// Whether no edit is asked for, being built or on its way to the finger.
    pub fn is_at_rest(&self) -> bool {
        self.wanted.is_none()
            && self.build.is_none()
            && self.ready.is_none()
            && self.under_way.is_none()
    }

    /// Another scene is felt from now on: edits of the one before are forgotten.
    pub fn begin(&mut self, scene: &Scene) {
        let number = match &self.under_way {
            Some((number, _)) => *number,
            None => self.settled.0,
        };
        *self = Self {
            settled: (number, scene.scenario.source.as_str().into()),
            applied: self.applied,
            ..Self::default()
        };
    }

    /// Starts to build the newest one, unless one is being built; without one, what the scene is newly used for.
    fn start(&mut self, open: &Arc<Scene>, purpose: Use, wake: &Wake) -> std::io::Result<()> {
        if self.build.is_some() {
            return Ok(());
        }
        let source = match self.wanted.take() {
            Some(source) => source,
            None if open.fits(purpose) => return Ok(()),
            None => open.scenario.source.clone(),
        };
        let old = Arc::clone(open);
        let work =
            move |_: super::job::Progress<'_>| Built::of(edited(&old, &source, purpose)?, purpose);
        let job = Job::start("scene editor", BuildStatus::default(), wake.clone(), work)?;
        self.build = Some(job);
        Ok(())
    }

    /// Hands what is ready to the servo, once it wholly feels the edit before.
    fn hand_over(&mut self, live: &mut Live) {
        if let Some((number, _)) = &self.under_way {
            let felt = live.snapshot();
            if felt.edit != *number || felt.fade < 1.0 {
                return;
            }
        }
        if let Some(felt) = self.under_way.take() {
            self.settled = felt;
        }
        let Some(scene) = &self.ready else {
            return;
        };
        let number = self.settled.0 + 1;
        let text: Arc<str> = scene.scenario.source.as_str().into();
        // The recorder first: it must know the text before a tick feels it.
        if live.recorder().edit(number, Arc::clone(&text)) {
            live.edit_scene(number, scene);
            self.under_way = Some((number, text));
            self.ready = None;
        }
    }
}

/// The scene of an edited scenario, sharing with `old` what did not change. Bumps that did give it another surface.
///
/// # Errors
/// What is wrong with the text, with its line, or what cannot be edited under the finger.
pub fn edited(old: &Scene, source: &str, purpose: Use) -> Result<Scene, BuildError> {
    let folder = old.scenario.folder.as_deref();
    let scenario = Arc::new(Scenario::parse(source, "edited scenario", folder)?);
    if old.scenario.surface == scenario.surface
        && scenario::changes_surface(&old.scenario, &scenario)
    {
        scenario::build(scenario, purpose, &mut |_, _| true)
    } else {
        scenario::rebuild(old, scenario, purpose)
    }
}

impl Bench {
    /// Goes over to an edit of the open scene: the whole scenario as edited. What is wrong with it is told, and the scene
    /// stays as it is.
    pub fn edit_scene(&mut self, source: String) {
        if self.replay.is_some() {
            let text = "A recording is on show: go back to live to edit the scene";
            self.tell(Level::Warning, text);
        } else if self.conceals && self.blind.is_some() {
            let text =
                "The trainee's workspace keeps what the exercise hides: edit in another role";
            self.tell(Level::Warning, text);
        } else if self.exercise.is_some() {
            let text = "An exercise runs: end it to edit the scene";
            self.tell(Level::Warning, text);
        } else if self.scene.is_none() {
            self.tell(
                Level::Warning,
                "There is nothing to edit: open a scene first",
            );
        } else {
            self.edits.wanted = Some(source);
            self.start_edit();
        }
    }

    /// Whether a Back view is open: without, nothing of the scene is kept for it. What is felt is not concerned.
    pub fn set_drawn(&mut self, on: bool) {
        if std::mem::replace(&mut self.drawn, on) != on {
            self.start_edit();
        }
    }

    /// Builds what was asked for since, if anything was.
    pub(super) fn start_edit(&mut self) {
        let purpose = self.purpose();
        if let Some(scene) = &self.scene
            && let Err(e) = self.edits.start(scene, purpose, &self.wake)
        {
            self.tell(Level::Error, format!("the edit cannot be built: {e}"));
        }
    }

    fn is_on_another_surface(&self, built: &Built) -> bool {
        let open = self.scene.as_ref();
        open.is_some_and(|open| !Arc::ptr_eq(&open.surface, &built.scene.surface))
    }

    /// Draws what is built, hands it on to the servo and builds what was asked for since.
    pub(super) fn poll_edits(&mut self) -> bool {
        let lost = || Err(BuildError("the editor stopped unexpectedly".into()));
        let built = self.edits.build.as_ref().and_then(|job| job.poll(lost));
        let changed = built.is_some();
        let built_well = matches!(built, Some(Ok(_)));
        match built {
            Some(Ok(built)) if self.is_on_another_surface(&built) => {
                self.edits.applied += 1;
                self.edits.fault.clear();
                self.ready = Some(Ready {
                    built,
                    opened: None,
                });
            }
            Some(Ok(Built { scene, blind })) => {
                let text = |s: &Scene| s.scenario.source.clone();
                if self.scene.as_deref().map(text) != Some(text(&scene)) {
                    self.edits.ready = Some(Arc::clone(&scene));
                }
                self.edits.applied += 1;
                self.edits.fault.clear();
                (self.scene, self.blind) = (Some(scene), blind);
            }
            Some(Err(e)) if e.0 != self.edits.fault => {
                self.edits.fault.clone_from(&e.0);
                self.tell(Level::Error, e.0);
            }
            _ => {}
        }
        if changed {
            self.edits.build = None;
            // What could not be built once will not be the second time.
            if built_well || self.edits.wanted.is_some() {
                self.start_edit();
            }
        }
        if let Some(live) = &mut self.live {
            self.edits.hand_over(live);
        }
        changed
    }
}
