//! The stiffness map as it is edited, and what can be done to it.

use crate::app::editor::editing::Document;
use crate::geom::Vec2;
use crate::maps::stiffness::{BRUSHED_N_PER_MM, STROKE_CHANGES, STROKE_POINTS, STROKE_RADII_MM};
use crate::maps::{Fit, StiffnessKey, StiffnessMap, Stroke};
use crate::scenario::{Scenario, edit};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// What a key may state, N/mm.
pub const KEY_N_PER_MM: RangeInclusive<f64> = BRUSHED_N_PER_MM;
/// Points of a stroke lie at least this part of its radius apart.
const SPACING: f64 = 0.2;

/// The map of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Doc {
    /// Its keys, at least one; shared between steps of undo.
    pub keys: Arc<Vec<StiffnessKey>>,
    /// The function through them.
    pub fit: Fit,
    /// Strokes of the brush over it, in order.
    pub strokes: Arc<Vec<Stroke>>,
}

impl Document for Doc {
    fn of(scenario: &Scenario) -> Self {
        Self {
            keys: Arc::new(scenario.stiffness_keys.clone()),
            fit: scenario.stiffness_fit,
            strokes: Arc::new(scenario.strokes.clone()),
        }
    }

    fn write(&self, source: &str) -> Result<String, String> {
        edit::with_stiffness(source, &self.keys, self.fit, &self.strokes).map_err(|e| e.to_string())
    }

    fn check(&self) -> Result<(), String> {
        // The fit itself may take long: it is made off the window's thread, and what it says is told from there.
        StiffnessMap::new(self.keys.to_vec(), Fit::Constant)
            .and_then(|map| map.with_strokes(self.strokes.to_vec()))
            .map(|_| ())
            .map_err(|e| e.to_string())
    }

    fn keys(&self) -> usize {
        self.keys.len()
    }
}

impl Doc {
    /// The map itself, by any fit.
    ///
    /// # Errors
    /// What is not allowed of it, in one line.
    pub fn map(&self, fit: Fit) -> Result<StiffnessMap, String> {
        StiffnessMap::new(self.keys.to_vec(), fit)
            .and_then(|map| map.with_strokes(self.strokes.to_vec()))
            .map_err(|e| e.to_string())
    }

    /// With another fit.
    #[must_use]
    pub fn with_fit(&self, fit: Fit) -> Self {
        Self {
            fit,
            ..self.clone()
        }
    }

    /// With these keys.
    #[must_use]
    pub fn with_keys(&self, keys: Vec<StiffnessKey>) -> Self {
        Self {
            keys: Arc::new(keys),
            ..self.clone()
        }
    }

    /// With `change` done to key `index`; its value stays what is allowed.
    #[must_use]
    pub fn with_key(&self, index: usize, change: impl FnOnce(&mut StiffnessKey)) -> Self {
        let mut doc = self.clone();
        if let Some(key) = Arc::make_mut(&mut doc.keys).get_mut(index) {
            let before = *key;
            change(key);
            let value = &mut key.stiffness_n_per_mm;
            if value.is_finite() {
                *value = value.clamp(*KEY_N_PER_MM.start(), *KEY_N_PER_MM.end());
            } else {
                *value = before.stiffness_n_per_mm;
            }
            if !key.at.is_finite() {
                key.at = before.at;
            }
        }
        doc
    }

    /// With one more key: the stiffness that the keys give there already.
    #[must_use]
    pub fn with_new_key(&self, at: Vec2) -> Self {
        let plain = Self {
            strokes: Arc::default(),
            ..self.clone()
        };
        let value = plain.map(self.fit).map_or(0.5, |map| map.at(at));
        let tidy = (value * 1000.0).round() / 1000.0;
        let mut keys = self.keys.to_vec();
        keys.push(StiffnessKey {
            at: tidy_place(at),
            stiffness_n_per_mm: tidy.clamp(*KEY_N_PER_MM.start(), *KEY_N_PER_MM.end()),
        });
        self.with_keys(keys)
    }

    /// With a copy of a key beside it.
    #[must_use]
    pub fn with_copy(&self, index: usize) -> Self {
        let mut keys = self.keys.to_vec();
        if let Some(key) = keys.get(index) {
            keys.push(StiffnessKey {
                at: key.at + Vec2::new(15.0, -15.0),
                ..*key
            });
        }
        self.with_keys(keys)
    }

    /// With a copy of every key on the other side, where there is none yet.
    #[must_use]
    pub fn with_mirrored(&self) -> Self {
        let mut keys = self.keys.to_vec();
        for key in self.keys.iter() {
            let at = Vec2::new(-key.at.x + 0.0, key.at.y);
            if keys.iter().all(|k| k.at.distance(at) > 1.0) {
                keys.push(StiffnessKey { at, ..*key });
            }
        }
        self.with_keys(keys)
    }

    /// Without a key; the last one stays.
    #[must_use]
    pub fn without(&self, index: usize) -> Self {
        let mut keys = self.keys.to_vec();
        if index < keys.len() && keys.len() > 1 {
            keys.remove(index);
        }
        self.with_keys(keys)
    }

    /// With a stroke that begins at a place.
    #[must_use]
    pub fn with_stroke(&self, at: Vec2, brush: &Brush, lower: bool) -> Self {
        let mut doc = self.clone();
        Arc::make_mut(&mut doc.strokes).push(Stroke {
            path: vec![tidy_place(at)],
            radius_mm: brush.radius_mm,
            change: brush.change(lower),
            falloff: brush.falloff.to_owned(),
        });
        doc
    }

    /// With the last stroke led on to a place; nothing for a step too small to matter.
    #[must_use]
    pub fn with_stroke_to(&self, at: Vec2) -> Option<Self> {
        let last = self.strokes.last()?;
        let from = last.path.last()?;
        let far = from.distance(at) >= (SPACING * last.radius_mm).max(0.5);
        if !far || last.path.len() >= *STROKE_POINTS.end() {
            return None;
        }
        let mut doc = self.clone();
        if let Some(stroke) = Arc::make_mut(&mut doc.strokes).last_mut() {
            stroke.path.push(tidy_place(at));
        }
        Some(doc)
    }

    /// With `change` done to a stroke.
    #[must_use]
    pub fn with_changed_stroke(&self, index: usize, change: impl FnOnce(&mut Stroke)) -> Self {
        let mut doc = self.clone();
        if let Some(stroke) = Arc::make_mut(&mut doc.strokes).get_mut(index) {
            change(stroke);
        }
        doc
    }

    /// Without a stroke.
    #[must_use]
    pub fn without_stroke(&self, index: usize) -> Self {
        let mut doc = self.clone();
        if index < doc.strokes.len() {
            Arc::make_mut(&mut doc.strokes).remove(index);
        }
        doc
    }
}

/// A place to a tenth of a mm: what a hand can mean.
pub fn tidy_place(at: Vec2) -> Vec2 {
    (at * 10.0).round() / 10.0 + Vec2::ZERO
}

/// The brush in the hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brush {
    /// Whether a drag paints.
    pub on: bool,
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Change at its centre, percent; positive.
    pub percent: f64,
    /// Lowers instead of raising.
    pub lowers: bool,
    /// Name of its falloff.
    pub falloff: &'static str,
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            on: false,
            radius_mm: 25.0,
            percent: 20.0,
            lowers: false,
            falloff: "cosine",
        }
    }
}

impl Brush {
    /// Radii allowed, mm.
    pub const RADII_MM: RangeInclusive<f64> = STROKE_RADII_MM;

    /// What the stiffness is changed by, as a part of it.
    pub fn change(&self, lower: bool) -> f64 {
        let sign = if lower { -1.0 } else { 1.0 };
        (sign * self.percent / 100.0).clamp(*STROKE_CHANGES.start(), *STROKE_CHANGES.end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doc() -> Doc {
        let key = |x: f64, y: f64, k: f64| StiffnessKey {
            at: Vec2::new(x, y),
            stiffness_n_per_mm: k,
        };
        Doc {
            keys: Arc::new(vec![
                key(0.0, 0.0, 0.5),
                key(100.0, 0.0, 1.0),
                key(0.0, 100.0, 0.7),
            ]),
            fit: Fit::Natural,
            strokes: Arc::default(),
        }
    }

    #[test]
    fn values_stay_what_is_allowed() {
        let value = |v: f64| {
            let doc = doc().with_key(1, |k| k.stiffness_n_per_mm = v);
            doc.keys[1].stiffness_n_per_mm
        };
        assert_eq!(
            (value(-3.0), value(0.0), value(1e9)),
            (0.001, 0.001, 10_000.0)
        );
        assert_eq!((value(f64::NAN), value(f64::INFINITY)), (1.0, 1.0));
        let moved = doc().with_key(0, |k| k.at = Vec2::NAN);
        assert_eq!(moved, doc());
        assert_eq!(doc().with_key(9, |k| k.stiffness_n_per_mm = 2.0), doc());
    }

    #[test]
    fn a_new_key_changes_nothing_by_itself_and_the_last_one_stays() {
        let at = Vec2::new(25.0, 40.0);
        let after = doc().with_new_key(at);
        let (a, b) = (
            doc().map(Fit::Natural).expect("good").at(at),
            after.map(Fit::Natural).expect("good").at(at),
        );
        assert!((a - b).abs() < 1e-3);
        let mut one = doc();
        for _ in 0..5 {
            one = one.without(0);
        }
        assert_eq!(one.keys.len(), 1);
    }

    #[test]
    fn a_stroke_raises_under_its_path_and_nowhere_else() {
        let brush = Brush {
            radius_mm: 20.0,
            percent: 50.0,
            ..Brush::default()
        };
        let mut painted = doc().with_stroke(Vec2::new(30.0, 30.0), &brush, false);
        assert!(painted.with_stroke_to(Vec2::new(31.0, 30.0)).is_none());
        painted = painted
            .with_stroke_to(Vec2::new(50.0, 30.0))
            .expect("far enough");
        let (before, after) = (
            doc().map(Fit::Natural).expect("good"),
            painted.map(Fit::Natural).expect("good"),
        );
        let factor = |p: Vec2| after.at(p) / before.at(p);
        assert!((factor(Vec2::new(40.0, 30.0)) - 1.5).abs() < 1e-9);
        assert_eq!(factor(Vec2::new(80.0, 60.0)), 1.0);
        let lowered = doc().with_stroke(Vec2::new(30.0, 30.0), &brush, true);
        assert_eq!(lowered.strokes[0].change, -0.5);
        assert_eq!(painted.without_stroke(0), doc());
        let all = Brush {
            percent: 500.0,
            ..brush
        };
        assert_eq!((all.change(true), all.change(false)), (-0.99, 5.0));
    }

    #[test]
    fn mirrored_keys_complete_the_other_side() {
        let both = doc().with_mirrored();
        assert_eq!(both.keys.len(), 4);
        assert_eq!(both.keys[3].at, Vec2::new(-100.0, 0.0));
        assert_eq!(both.with_mirrored(), both);
    }
}
