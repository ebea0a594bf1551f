//! The drawn skin of one scene: deformed by the fingers, only where they changed it.

use super::model;
use super::stage::SharedStage;
use crate::deform::models::fsmd::Fsmd;
use crate::deform::{Displacement, Model, Press};
use crate::scenario::Scene;
use crate::servo::FingerRecord;
use std::sync::Arc;

/// A scene's skin with the state of its deformation.
pub struct DrawnSkin {
    scene: Arc<Scene>,
    generation: u64,
    model: Box<dyn Model>,
    displacement: Displacement,
    presses: Vec<Press>,
}

impl DrawnSkin {
    /// At rest.
    pub fn new(scene: Arc<Scene>, generation: u64) -> Self {
        Self {
            model: Box::new(Fsmd::new(scene.deform)),
            displacement: Displacement::at_rest(&scene.surface),
            presses: Vec::new(),
            scene,
            generation,
        }
    }

    /// Whether it belongs to this scene.
    pub fn is_of(&self, scene: &Arc<Scene>, generation: u64) -> bool {
        self.generation == generation && Arc::ptr_eq(&self.scene, scene)
    }

    /// The scene it belongs to.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// How far it is from rest.
    pub fn displacement(&self) -> &Displacement {
        &self.displacement
    }

    /// Follows the fingers and hands what changed to the stage. Does nothing while they rest.
    pub fn update(&mut self, fingers: &[FingerRecord], stage: &SharedStage) {
        let presses = model::presses(fingers, &self.scene);
        if !model::differ(&presses, &self.presses) {
            return;
        }
        self.model
            .update(&self.scene.surface, &presses, &mut self.displacement);
        self.presses = presses;
        if let Some(mesh) = &mut stage.lock().mesh {
            mesh.update(&self.displacement);
        }
    }
}
