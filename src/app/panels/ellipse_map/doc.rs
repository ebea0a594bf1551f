//! The ellipse map as it is edited, and what can be done to it.

use crate::app::editor::editing::Document;
use crate::geom::Vec2;
use crate::maps::ellipse::HALF_AXES_MM;
use crate::maps::{EllipseKey, EllipseMap, EllipseSettings};
use crate::scenario::{Scenario, edit};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Radii of a boundary that is made from an ellipse.
pub const RADII: usize = 12;
/// Decimals of a degree that are kept: a direction in a file is stated in degrees.
const DEGREE_PARTS: f64 = 1.0e9;
/// Keys nearer to the midline than this have no other side, mm.
const MIDLINE_MM: f64 = 0.5;

/// The map of a scenario, or none.
#[derive(Clone, Debug, PartialEq)]
pub struct Doc {
    /// Whether the scenario has an ellipse map; without one it is the basic circle everywhere.
    pub on: bool,
    /// Its keys; shared between steps of undo.
    pub keys: Arc<Vec<EllipseKey>>,
    /// What it chooses beside its keys.
    pub settings: EllipseSettings,
}

impl Document for Doc {
    fn of(scenario: &Scenario) -> Self {
        match &scenario.ellipse {
            None => Self {
                on: false,
                keys: Arc::default(),
                settings: EllipseSettings::default(),
            },
            Some((keys, settings)) => Self {
                on: true,
                keys: Arc::new(keys.iter().cloned().map(rounded).collect()),
                settings: *settings,
            },
        }
    }

    fn write(&self, source: &str) -> Result<String, String> {
        let map = self.on.then_some((self.keys.as_slice(), &self.settings));
        edit::with_ellipse(source, map).map_err(|e| e.to_string())
    }

    fn check(&self) -> Result<(), String> {
        self.map().map(|_| ())
    }

    fn keys(&self) -> usize {
        self.keys.len()
    }
}

impl Doc {
    /// The map itself.
    ///
    /// # Errors
    /// What is not allowed of it, in one line.
    pub fn map(&self) -> Result<EllipseMap, String> {
        let keys = if self.on {
            self.keys.to_vec()
        } else {
            Vec::new()
        };
        EllipseMap::new(keys, self.settings).map_err(|e| e.to_string())
    }

    /// With `change` done to key `index`.
    #[must_use]
    pub fn with_key(&self, index: usize, change: impl FnOnce(&mut EllipseKey)) -> Self {
        let mut doc = self.clone();
        if let Some(key) = Arc::make_mut(&mut doc.keys).get_mut(index) {
            change(key);
            *key = rounded(key.clone());
        }
        doc
    }

    /// With other settings.
    #[must_use]
    pub fn with_settings(&self, change: impl FnOnce(&mut EllipseSettings)) -> Self {
        let mut doc = self.clone();
        doc.on = true;
        change(&mut doc.settings);
        doc
    }

    /// With these keys.
    #[must_use]
    pub fn with_keys(&self, keys: Vec<EllipseKey>) -> Self {
        Self {
            on: true,
            keys: Arc::new(keys.into_iter().map(rounded).collect()),
            ..self.clone()
        }
    }

    /// With one more key: the ellipse that is there already, so that adding changes nothing by itself.
    #[must_use]
    pub fn with_new_key(&self, at: Vec2) -> Self {
        let oval = self.map().map(|map| map.at(at)).ok();
        let radius = self.settings.basic_radius_mm;
        let (a, b, angle) = oval.map_or((radius, radius, PI / 2.0), |o| {
            (o.half_major_mm, o.half_minor_mm, o.angle_rad)
        });
        let tidy = |mm: f64| {
            ((mm * 10.0).round() / 10.0).clamp(*HALF_AXES_MM.start(), *HALF_AXES_MM.end())
        };
        let angle = (angle.to_degrees() * 10.0).round() / 10.0;
        let key = EllipseKey::new(
            self.free_name(),
            tidy_place(at),
            tidy(a),
            tidy(b),
            angle.to_radians(),
        );
        let mut keys = self.keys.to_vec();
        keys.push(key);
        self.with_keys(keys)
    }

    /// With a copy of a key beside it.
    #[must_use]
    pub fn with_copy(&self, index: usize) -> Self {
        let mut keys = self.keys.to_vec();
        if let Some(key) = keys.get(index) {
            let mut copy = key.clone();
            copy.at += Vec2::new(20.0, -20.0);
            copy.name = self.free_name();
            keys.push(copy);
        }
        self.with_keys(keys)
    }

    /// Without a key.
    #[must_use]
    pub fn without(&self, index: usize) -> Self {
        let mut keys = self.keys.to_vec();
        if index < keys.len() {
            keys.remove(index);
        }
        Self {
            keys: Arc::new(keys),
            ..self.clone()
        }
    }

    /// Left and right exchanged, for one key or all.
    #[must_use]
    pub fn mirrored(&self, only: Option<usize>) -> Self {
        let flip = |(i, key): (usize, &EllipseKey)| match only {
            Some(index) if i != index => key.clone(),
            _ => mirror(key),
        };
        self.with_keys(self.keys.iter().enumerate().map(flip).collect())
    }

    /// With a mirrored copy of one key or of all, where the other side has none there yet.
    #[must_use]
    pub fn with_mirrored(&self, only: Option<usize>) -> Self {
        let mut keys = self.keys.to_vec();
        for (i, key) in self.keys.iter().enumerate() {
            let asked = only.is_none_or(|index| i == index);
            let copy = mirror(key);
            let free = keys
                .iter()
                .all(|k| k.at.distance(copy.at) > 2.0 * MIDLINE_MM);
            if asked && free && key.at.x.abs() > MIDLINE_MM {
                let name = match key.name.as_str() {
                    "" => String::new(),
                    name => format!("{name} mirrored"),
                };
                keys.push(EllipseKey { name, ..copy });
            }
        }
        self.with_keys(keys)
    }

    /// With an irregular boundary for a key, from its ellipse, or without one.
    #[must_use]
    pub fn with_boundary(&self, index: usize, on: bool) -> Self {
        // All boundaries of a map have as many radii.
        let n = self
            .keys
            .iter()
            .find_map(|k| k.boundary_mm.as_ref().map(Vec::len))
            .unwrap_or(RADII);
        self.with_key(index, |key| {
            let oval = key.oval();
            key.boundary_mm = on.then(|| {
                let direction = |i: usize| TAU * i as f64 / n as f64;
                (0..n)
                    .map(|i| (oval.radius_mm(direction(i)) * 10.0).round() / 10.0)
                    .collect()
            });
        })
    }

    fn free_name(&self) -> String {
        let taken = |name: &str| self.keys.iter().any(|k| k.name == name);
        (1..)
            .map(|n| format!("P{n}"))
            .find(|name| !taken(name))
            .unwrap_or_default()
    }
}

/// A place to a tenth of a mm: what a hand can mean.
pub fn tidy_place(at: Vec2) -> Vec2 {
    (at * 10.0).round() / 10.0 + Vec2::ZERO
}

/// A key whose direction is a number of degrees that a file can state, so that it is the same when it is read again.
pub fn rounded(mut key: EllipseKey) -> EllipseKey {
    let degrees = (key.angle_rad.to_degrees() * DEGREE_PARTS).round() / DEGREE_PARTS;
    key.angle_rad = degrees.to_radians();
    key
}

/// A key on the other side: x becomes −x, the direction 180° less it.
pub fn mirror(key: &EllipseKey) -> EllipseKey {
    let mut out = key.clone().mirrored();
    // Turns −0 into 0.
    out.at.x += 0.0;
    rounded(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn doc(keys: Vec<EllipseKey>) -> Doc {
        Doc {
            on: true,
            keys: Arc::new(keys),
            settings: EllipseSettings::default(),
        }
    }

    fn key(x: f64, deg: f64) -> EllipseKey {
        rounded(EllipseKey::new(
            "P4",
            Vec2::new(x, 270.0),
            179.0,
            132.0,
            deg.to_radians(),
        ))
    }

    #[test]
    fn a_mirrored_key_is_on_the_other_side_with_its_direction_turned_round() {
        let m = mirror(&key(-100.0, 99.4));
        assert_eq!(m.at, Vec2::new(100.0, 270.0));
        assert!((m.angle_rad.to_degrees() - 80.6).abs() < 1e-9);
        assert_eq!(mirror(&key(0.0, 90.0)), key(0.0, 90.0));
    }

    #[test]
    fn copies_are_made_only_where_the_other_side_has_none() {
        let one = doc(vec![key(-100.0, 99.4), key(0.0, 90.0)]);
        let both = one.with_mirrored(None);
        assert_eq!(both.keys.len(), 3);
        assert_eq!(both.keys[2].name, "P4 mirrored");
        assert_eq!(both.with_mirrored(None).keys.len(), 3);
        assert_eq!(one.with_mirrored(Some(1)).keys.len(), 2);
    }

    #[test]
    fn a_new_key_changes_nothing_by_itself_and_has_a_free_name() {
        let before = doc(vec![key(-100.0, 99.4)]);
        let at = Vec2::new(-40.0, 260.0);
        let after = before.with_new_key(at);
        assert_eq!(after.keys[1].name, "P1");
        let (a, b) = (
            before.map().expect("good").at(at),
            after.map().expect("good").at(at),
        );
        assert!((a.half_major_mm - b.half_major_mm).abs() < 0.06);
        assert!((a.angle_rad - b.angle_rad).abs() < 1e-3);
        assert_eq!(after.without(1), before);
        assert_eq!(before.without(7), before);
    }

    #[test]
    fn a_boundary_begins_as_the_ellipse_and_all_have_as_many_radii() {
        let with = doc(vec![key(-100.0, 90.0), key(100.0, 90.0)]).with_boundary(0, true);
        let radii = with.keys[0].boundary_mm.clone().expect("radii");
        assert_eq!(radii.len(), RADII);
        assert!(
            (radii[0] - 132.0).abs() < 0.06 && (radii[3] - 179.0).abs() < 0.06,
            "{radii:?}"
        );
        let mut odd = with.clone();
        Arc::make_mut(&mut odd.keys)[0].boundary_mm = Some(vec![100.0; 9]);
        let both = odd.with_boundary(1, true);
        assert_eq!(both.keys[1].boundary_mm.as_ref().map(Vec::len), Some(9));
        assert!(both.map().is_ok());
        assert_eq!(both.with_boundary(1, false).keys[1].boundary_mm, None);
    }

    proptest! {
        #[test]
        fn mirroring_twice_is_where_it_was(x in -200.0..200.0f64, deg in 0.0..180.0f64, radii in prop::option::of(prop::collection::vec(1.0..200.0f64, 12))) {
            let key = rounded(EllipseKey { boundary_mm: radii, ..key(x, deg) });
            let back = mirror(&mirror(&key));
            let turn = (back.angle_rad - key.angle_rad).sin().abs();
            prop_assert!(turn < 1e-9);
            prop_assert_eq!(EllipseKey { angle_rad: 0.0, ..back }, EllipseKey { angle_rad: 0.0, ..key });
        }
    }
}
