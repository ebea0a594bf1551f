//! Bones below the skin and hands in the place of fingertips: built when they are first to be seen, freed when they are not.

use super::model::Finger;
use super::options::Options;
use crate::app::render::hand::{self, Hands};
use crate::app::render::model::{Model, Placed};
use crate::app::render::{bones, pixels};
use crate::app::state::{PartCost, Parts};
use crate::app::theme::Theme;
use crate::scenario::{Item, Scene, SurfaceChoice};
use crate::surface::back::BackOptions;
use std::sync::Arc;
use std::time::Instant;

/// Why a scene has no bones to be shown; `None` where it has.
pub fn why_no_bones(scene: &Scene) -> Option<&'static str> {
    let on_back = matches!(scene.scenario.surface, SurfaceChoice::BuiltinBack { .. });
    (!on_back).then_some(
        "Known for the built-in back only: under another mesh nobody has said where they lie",
    )
}

/// What is held.
#[derive(Default)]
pub struct Anatomy {
    bones: Option<Arc<Model>>,
    /// How long the bones took to make, µs.
    build_us: f64,
    hands: Option<Hands>,
}

impl Anatomy {
    /// Makes what is to be seen in `scene` and frees the rest.
    pub fn follow(&mut self, scene: &Scene, options: &Options) {
        match scene.scenario.surface {
            SurfaceChoice::BuiltinBack { triangles } if options.shows_bones() => {
                if self.bones.is_none() {
                    let start = Instant::now();
                    // The bones do not depend on how finely the skin is cut.
                    let model = bones::model(&BackOptions::with_triangles(triangles));
                    self.build_us = start.elapsed().as_secs_f64() * 1e6;
                    self.bones = Some(Arc::new(model));
                }
            }
            _ => self.bones = None,
        }
        if !options.anatomy.hands {
            self.hands = None;
        }
    }

    /// What is to be drawn; with hands, which stand for the spheres of `fingers`, where `hands` is true.
    pub fn models(&mut self, fingers: &[Finger], theme: &Theme, hands: bool) -> Vec<Placed> {
        let mut models: Vec<Placed> = self.bones.iter().map(bones::placed).collect();
        if hands && !fingers.is_empty() {
            let held = self.hands.get_or_insert_default();
            models.extend(fingers.iter().map(|f| {
                held.placed(&hand::Finger {
                    is_right: f.index % 2 == 1,
                    centre_mm: f.centre_mm,
                    radius_mm: f.radius_mm,
                    normal: f.normal,
                    color: pixels::rgb(theme.finger(f.index)),
                })
            }));
        }
        models
    }

    /// Tells the ledger what is held; nothing of what is not.
    pub fn report(&self, parts: &Parts) {
        let bones = self.bones.as_ref().map(|bones| PartCost {
            bytes: bones.bytes(),
            cost_us: Some((self.build_us, "build")),
        });
        let hands = self.hands.as_ref().map(|hands| PartCost {
            bytes: hands.bytes(),
            cost_us: None,
        });
        for (item, cost) in [(Item::DrawnBones, bones), (Item::HandModel, hands)] {
            match cost {
                Some(cost) => parts.report(item, cost),
                None => parts.remove(item),
            }
        }
    }
}
