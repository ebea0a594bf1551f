//! The tree of cells under study: which one, where its box stands, what is laid over the skin of it.
//!
//! | file | answers |
//! |---|---|
//! | [`settings`] | what the user chose |
//! | [`built`] | the tree with its numbers, and how it is built beside the window |
//! | [`asked`] | what the haptic detecting box gathers, and what that costs |
//! | [`shapes`] | boxes, planes and triangles as they are drawn |
//!
//! It belongs to the Partition panel; the Back view shows it too when asked to. Nothing is held while the panel is closed.

pub mod asked;
pub mod built;
pub mod settings;
pub mod shapes;

use super::bench::Wake;
use super::bench::job::Job;
use super::render::layer::Overlay;
use super::state::{BuildStatus, PartCost, View};
use super::theme::Theme;
use crate::contact::Touch;
use crate::geom::{Aabb, Vec3};
use crate::partition::hdb;
use crate::scenario::{Item, Scene};
use crate::servo::FingerRecord;
use asked::{Asked, Place};
use built::Built;
use settings::{Choice, Follow, Settings};
use shapes::Shapes;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A probe that moved less than this stands still, mm: a hand at rest still trembles.
const STILL_MM: f64 = 1e-3;

/// The study, shared by the panels that show it.
#[derive(Clone, Default)]
pub struct SharedStudy(Arc<Mutex<Study>>);

impl SharedStudy {
    /// Locks it: briefly, never while a panel is drawn.
    pub fn lock(&self) -> MutexGuard<'_, Study> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What the study is about and where it stands.
#[derive(Default)]
pub struct Study {
    settings: Settings,
    /// The scene it follows, with the count of scenes.
    scene: Option<(Arc<Scene>, u64)>,
    job: Option<(Choice, Job<Option<Built>>)>,
    /// What the user stopped: not built again until something else was chosen or it is asked for.
    stopped: Option<Choice>,
    /// Why a tree cannot be built.
    fault: Option<String>,
    built: Option<Arc<Built>>,
    asked: Option<Arc<Asked>>,
    place: Option<Place>,
    shapes: Shapes,
    /// What the panel's own picture holds, bytes.
    picture_bytes: usize,
    /// Trees built so far.
    builds: u64,
}

/// What there is to show at one frame. Cheap to take: large parts are shared.
#[derive(Clone)]
pub struct Shown {
    /// What the user chose.
    pub settings: Settings,
    /// The tree; `None` until the first one is built.
    pub built: Option<Arc<Built>>,
    /// What the box gathers; `None` without a tree or a place for it.
    pub asked: Option<Arc<Asked>>,
    /// The leaf under the cursor.
    pub place: Option<Place>,
    /// How far the building of a tree is.
    pub building: Option<BuildStatus>,
    /// Whether the user stopped the building of what is chosen.
    pub stopped: bool,
    /// Why there is no tree.
    pub fault: Option<String>,
    /// What is laid over the skin.
    pub overlay: Overlay,
    /// Boxes drawn and boxes that there are to draw.
    pub boxes: [usize; 2],
}

impl Study {
    /// What the user chose.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Takes over what the user chose.
    pub fn choose(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Whether the Back view shows it.
    pub fn is_over_the_back(&self) -> bool {
        self.settings.show.in_back_view && self.scene.is_some()
    }

    /// Trees built so far.
    pub fn builds(&self) -> u64 {
        self.builds
    }

    /// Brings everything up to what `view` and the settings say: starts to build what is missing, takes over what is done,
    /// asks the box anew where it moved. `wake` is called when something is new to show. Does little when nothing changed.
    pub fn follow(&mut self, view: &View, wake: &Wake) {
        let Some(scene) = &view.scene else {
            self.forget();
            return;
        };
        let same = |(s, g): &(Arc<Scene>, u64)| {
            Arc::ptr_eq(&s.surface, &scene.surface) && *g == view.scene_generation
        };
        if !self.scene.as_ref().is_some_and(same) {
            self.forget();
            self.scene = Some((scene.clone(), view.scene_generation));
            self.settings.fixed_mm = built::middle(scene);
        }
        self.poll(wake);
        self.ask(&view.fingers);
        self.shapes.follow(
            &self.settings,
            &view.theme,
            self.built.as_ref(),
            self.asked.as_ref(),
            self.place.as_ref(),
        );
        self.report(view);
    }

    fn poll(&mut self, wake: &Wake) {
        if let Some((choice, job)) = &self.job
            && let Some(outcome) = job.poll(|| None)
        {
            let choice = *choice;
            self.job = None;
            if let Some(built) = outcome {
                self.built = Some(Arc::new(built));
                self.builds += 1;
                self.asked = None;
                self.place = None;
            } else {
                // Nobody asked it to: tried again only when asked for, or it might break off for ever.
                self.stopped = Some(choice);
                self.fault = Some("The builder broke off".into());
            }
        }
        let wanted = self.settings.choice.effective();
        if self.stopped.is_some_and(|stopped| stopped != wanted) {
            self.go_on();
        }
        let has = self.built.as_ref().is_some_and(|b| b.choice == wanted);
        let under_way = self.job.as_ref().map(|(choice, _)| *choice);
        if has {
            // Chosen back before the other one was finished.
            self.job = None;
        } else if under_way != Some(wanted) && self.stopped.is_none() {
            let Some((scene, _)) = &self.scene else {
                return;
            };
            match built::start(scene.surface.clone(), wanted, wake.clone()) {
                Ok(job) => self.job = Some((wanted, job)),
                Err(e) => {
                    self.stopped = Some(wanted);
                    self.fault = Some(format!("The builder cannot start: {e}"));
                }
            }
        }
    }

    /// Stops building; the tree that is there stays.
    pub fn stop(&mut self) {
        if let Some((choice, job)) = self.job.take() {
            job.cancel();
            self.stopped = Some(choice);
        }
    }

    /// Builds what was stopped after all.
    pub fn go_on(&mut self) {
        self.stopped = None;
        self.fault = None;
    }

    fn ask(&mut self, fingers: &[FingerRecord]) {
        let (Some(built), Some((scene, _))) = (&self.built, &self.scene) else {
            self.asked = None;
            return;
        };
        let Some(probe_mm) = probe_mm(&self.settings, fingers) else {
            self.asked = None;
            return;
        };
        let edge_mm = self.settings.edge_part * longest_edge_mm(scene);
        let region = Aabb::cube(probe_mm, edge_mm);
        let stands = self.asked.as_ref().is_some_and(|a| {
            a.region.min.abs_diff_eq(region.min, STILL_MM)
                && a.region.max.abs_diff_eq(region.max, STILL_MM)
        });
        if !stands {
            self.asked = Some(Arc::new(Asked::new(built, probe_mm, region)));
        }
    }

    /// Looks up the leaf at a point of the skin, on `triangle`; `None` for no point.
    pub fn point_at(&mut self, point: Option<(Vec3, u32)>) {
        self.place = match (&self.built, point) {
            (Some(built), Some((point_mm, triangle))) => Place::of(built, point_mm, triangle),
            _ => None,
        };
    }

    /// What there is to show.
    pub fn shown(&self) -> Shown {
        Shown {
            settings: self.settings,
            built: self.built.clone(),
            asked: self.asked.clone(),
            place: self.place.clone(),
            building: self.job.as_ref().map(|(_, job)| job.status()),
            stopped: self.stopped.is_some(),
            fault: self.fault.clone(),
            overlay: self.shapes.overlay(),
            boxes: self.shapes.boxes(),
        }
    }

    /// What the legend says: a colour and what wears it, for everything that is laid over the skin.
    pub fn legend(&self, theme: &Theme) -> Vec<(egui::Color32, &'static str)> {
        shapes::legend(&self.settings, theme, self.built.as_deref())
    }

    /// Notes what the panel's own picture holds, for the ledger.
    pub fn set_picture_bytes(&mut self, bytes: usize) {
        self.picture_bytes = bytes;
    }

    fn report(&self, view: &View) {
        let Some(built) = &self.built else {
            view.parts.remove(Item::PartitionTree);
            return;
        };
        let asked = self.asked.as_ref().map_or(0, |a| a.bytes());
        let cost = PartCost {
            bytes: built.structure().partition().bytes()
                + self.shapes.bytes()
                + asked
                + self.picture_bytes,
            cost_us: Some((built.build_us, "build")),
        };
        view.parts.report(Item::PartitionTree, cost);
    }

    fn forget(&mut self) {
        *self = Self {
            settings: self.settings,
            builds: self.builds,
            ..Self::default()
        };
    }

    /// Frees everything but the settings; a tree that is being built is given up.
    pub fn release(&mut self, view: &View) {
        if self.scene.is_some() {
            self.forget();
            view.parts.remove(Item::PartitionTree);
        }
    }
}

/// Longest edge of a scene's box, mm.
pub fn longest_edge_mm(scene: &Scene) -> f64 {
    hdb::edge_mm(&scene.surface) / hdb::EDGE_PART
}

/// Where the middle of the box belongs, mm: the proxy of the finger that it follows. Without that finger, or one that is
/// nowhere, where it was set by hand.
fn probe_mm(settings: &Settings, fingers: &[FingerRecord]) -> Option<Vec3> {
    let of_finger = |index: usize| {
        let record = fingers.iter().find(|f| usize::from(f.finger) == index)?;
        let contact = &record.contact;
        Some(match contact.touch {
            Touch::Free => record.reading.position_mm,
            _ => contact.anchor_mm,
        })
        .filter(|p| p.is_finite())
    };
    match settings.follow {
        Follow::Finger(index) => of_finger(index).or(Some(settings.fixed_mm)),
        Follow::Fixed => Some(settings.fixed_mm),
    }
    .filter(|p| p.is_finite())
}
