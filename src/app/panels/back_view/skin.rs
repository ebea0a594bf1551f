//! The drawn skin of one scene: deformed by the fingers, only where they changed it.

use super::footprints::{self, Boundary};
use super::model::{self, Mark};
use super::stage::SharedStage;
use crate::app::state::{PartCost, Parts};
use crate::deform::models::fsmd::Fsmd;
use crate::deform::strain::Strain;
use crate::deform::{Displacement, Model, Press};
use crate::scenario::{Item, Scene};
use crate::servo::FingerRecord;
use std::cell::OnceCell;
use std::sync::Arc;
use std::time::Instant;

/// A scene's skin with the state of its deformation.
pub struct DrawnSkin {
    scene: Arc<Scene>,
    generation: u64,
    model: Box<dyn Model>,
    displacement: Displacement,
    /// What the skin is deformed by; `None` where that is to be found anew.
    presses: Option<Vec<Press>>,
    /// The finger of each press.
    fingers: Vec<usize>,
    /// Cost of the last update that had something to do, µs.
    update_us: Option<f64>,
    /// Found when they are first shown.
    marks: OnceCell<Vec<Mark>>,
    /// The same, anew for each update.
    boundaries: OnceCell<Vec<Boundary>>,
}

impl DrawnSkin {
    /// At rest.
    pub fn new(scene: Arc<Scene>, generation: u64) -> Self {
        Self {
            model: Box::new(Fsmd::new(scene.deform.clone())),
            displacement: Displacement::at_rest(&scene.surface),
            presses: Some(Vec::new()),
            fingers: Vec::new(),
            update_us: None,
            marks: OnceCell::new(),
            boundaries: OnceCell::new(),
            scene,
            generation,
        }
    }

    /// Whether it belongs to this scene.
    pub fn is_of(&self, scene: &Arc<Scene>, generation: u64) -> bool {
        self.generation == generation && Arc::ptr_eq(&self.scene, scene)
    }

    /// Takes over an edited scene on the same surface, with the skin as it is. `false`, and nothing done, where it is
    /// another scene or another surface.
    pub fn renew(&mut self, scene: &Arc<Scene>, generation: u64, stage: &SharedStage) -> bool {
        if self.generation != generation || !Arc::ptr_eq(&self.scene.surface, &scene.surface) {
            return false;
        }
        if self.scene.deform != scene.deform {
            // A model's displacement is its own: back to rest first, then the new one starts from there.
            self.model
                .update(&self.scene.surface, &[], &mut self.displacement);
            if let Some(mesh) = &mut stage.lock().mesh {
                mesh.update(&self.displacement);
            }
            self.model = Box::new(Fsmd::new(scene.deform.clone()));
        }
        self.scene = scene.clone();
        // Everything is asked anew: footprints may have changed under a finger that rests.
        self.presses = None;
        true
    }

    /// The scene it belongs to.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// How far it is from rest.
    pub fn displacement(&self) -> &Displacement {
        &self.displacement
    }

    /// Its named places.
    pub fn marks(&self) -> &[Mark] {
        self.marks.get_or_init(|| model::marks(&self.scene))
    }

    /// Frees its named places: they are found anew when they are shown again.
    pub fn forget_marks(&mut self) {
        self.marks = OnceCell::new();
    }

    /// How far the presses reach.
    pub fn boundaries(&self) -> &[Boundary] {
        self.boundaries.get_or_init(|| {
            let presses = self.presses.iter().flatten();
            let presses: Vec<_> = self.fingers.iter().copied().zip(presses).collect();
            footprints::boundaries(&self.scene, &self.displacement, &presses)
        })
    }

    /// Follows the fingers and hands what changed to the stage; answers whether there was anything. Does nothing while they
    /// rest. `strain` is brought along.
    pub fn update(
        &mut self,
        fingers: &[FingerRecord],
        stage: &SharedStage,
        strain: Option<&mut Strain>,
    ) -> bool {
        let (fingers, presses) = model::presses(fingers, &self.scene);
        let before = self.presses.as_ref();
        if before.is_some_and(|before| !model::differ(&presses, before)) {
            return false;
        }
        let start = Instant::now();
        let (surface, skin) = (&self.scene.surface, &mut self.displacement);
        match strain {
            Some(strain) => (self.model).update_strained(surface, &presses, skin, strain),
            None => self.model.update(surface, &presses, skin),
        }
        self.update_us = Some(start.elapsed().as_secs_f64() * 1e6);
        (self.fingers, self.presses) = (fingers, Some(presses));
        self.boundaries = OnceCell::new();
        if let Some(mesh) = &mut stage.lock().mesh {
            mesh.update(&self.displacement);
        }
        true
    }

    /// Tells the ledger what the drawn skin holds and costs.
    pub fn report(&self, parts: &Parts, stage: &SharedStage) {
        let per_frame = self.update_us.map(|us| (us, "frame"));
        let deformation = PartCost {
            bytes: self.displacement.bytes() + self.model.bytes(),
            cost_us: per_frame,
        };
        parts.report(Item::Deformation, deformation);
        match self.marks.get() {
            Some(marks) => {
                let text = |m: &Mark| size_of::<Mark>() + m.text.len();
                let names = PartCost {
                    bytes: marks.iter().map(text).sum(),
                    cost_us: None,
                };
                parts.report(Item::LandmarkNames, names);
            }
            None => parts.remove(Item::LandmarkNames),
        }
        // It shares the offsets of the deformation and its time.
        parts.report(Item::TangentialField, PartCost::default());
        if let Some(mesh) = &stage.lock().mesh {
            let mesh = PartCost {
                bytes: mesh.bytes(),
                cost_us: None,
            };
            parts.report(Item::GraphicsMesh, mesh);
        }
    }
}
