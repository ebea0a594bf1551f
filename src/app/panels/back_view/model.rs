//! What the Back view shows of the fingers: from tick records and the deformed skin to places, lengths and numbers.

use crate::app::camera::{Camera, Projection};
use crate::contact::Touch;
use crate::deform::{Displacement, Press};
use crate::geom::{Vec3, unit_or};
use crate::partition::{Partition as _, Sides};
use crate::scenario::{Scene, SurfaceChoice};
use crate::servo::{FingerRecord, LimitFlags};
use crate::surface::back::{self, BackOptions, Kind};

/// Radius of the sphere that a point finger is drawn as, mm: a fingertip.
pub const FINGER_RADIUS_MM: f64 = 7.5;
/// Length of a force arrow, mm per N.
pub const ARROW_MM_PER_N: f64 = 8.0;
/// A finger farther than this from the skin is not shown, mm: it has been put away.
const SHOWN_WITHIN_MM: f64 = 120.0;

/// One finger as shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    /// Which, from 0; tells its colour.
    pub index: usize,
    /// Centre of its sphere, resting on the deformed skin, mm.
    pub centre_mm: Vec3,
    /// Radius of its sphere, mm.
    pub radius_mm: f64,
    /// Outward direction at its place.
    pub normal: Vec3,
    /// Where the device is while it touches, mm.
    pub hip_mm: Option<Vec3>,
    /// Force on the finger, N; zero when free.
    pub force_n: Vec3,
    /// Penetration depth, mm; zero when free.
    pub depth_mm: f64,
    /// Stiffness felt, N/mm; `None` when free.
    pub stiffness_n_per_mm: Option<f64>,
    /// The device cannot render the whole force.
    pub limited: bool,
}

impl Finger {
    /// Where its force arrow starts, mm: outside the sphere.
    pub fn arrow_from_mm(&self) -> Vec3 {
        self.centre_mm + unit_or(self.force_n, self.normal) * (self.radius_mm * 0.98)
    }

    /// From tail to tip of its force arrow, mm.
    pub fn arrow_mm(&self) -> Vec3 {
        self.force_n * ARROW_MM_PER_N
    }
}

/// The fingers near the skin of `scene`, drawn on it as deformed by `skin`.
pub fn fingers(scene: &Scene, skin: &Displacement, records: &[FingerRecord]) -> Vec<Finger> {
    records
        .iter()
        .filter_map(|record| finger(scene, skin, record))
        .collect()
}

/// One finger near the skin; nothing for one that has been put away.
pub fn finger(scene: &Scene, skin: &Displacement, record: &FingerRecord) -> Option<Finger> {
    let index = usize::from(record.finger);
    let contact = &record.contact;
    let hip = record.reading.position_mm;
    let pad_mm = scene.touch.choices.pad_mm();
    let radius_mm = pad_mm.unwrap_or(FINGER_RADIUS_MM);
    if contact.touch != Touch::Free {
        let on_skin = contact.anchor_mm - contact.normal * pad_mm.unwrap_or(0.0);
        let tip = skin.carried_point(&scene.surface, contact.triangle, on_skin);
        return Some(Finger {
            index,
            centre_mm: tip + contact.normal * radius_mm,
            radius_mm,
            normal: contact.normal,
            hip_mm: Some(hip),
            force_n: record.sent_force_n,
            depth_mm: contact.depth_mm,
            stiffness_n_per_mm: Some(contact.stiffness_n_per_mm),
            limited: record.limits.has(LimitFlags::RATED),
        })
        .filter(|f| f.centre_mm.is_finite());
    }
    let search = &scene.touch.search;
    let near = search.nearest(&scene.surface, hip, SHOWN_WITHIN_MM)?;
    let normal = scene.surface.triangle(near.triangle).normal();
    let outward = unit_or(hip - near.point, normal);
    // Just above the skin the direction to the closest point is noise: the normal takes over.
    let trust = ((hip - near.point).length() / radius_mm).clamp(0.0, 1.0);
    let normal = unit_or(normal * (1.0 - trust) + outward * trust, normal);
    Some(Finger {
        index,
        centre_mm: hip + normal * if pad_mm.is_some() { 0.0 } else { radius_mm },
        radius_mm,
        normal,
        hip_mm: None,
        force_n: Vec3::ZERO,
        depth_mm: 0.0,
        stiffness_n_per_mm: None,
        limited: false,
    })
}

/// A named place on the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What is written beside it; empty for a dot alone.
    pub text: String,
    /// Where on the rest surface, mm.
    pub point_mm: Vec3,
    /// The triangle it lies on.
    pub triangle: u32,
    /// The lower, the sooner its name gets a place.
    pub rank: u8,
}

/// Levels that are named before the others: one finds the rest from them.
const FIRST_NAMED: [&str; 8] = ["C7", "T1", "T4", "T7", "T10", "L1", "L3", "L5"];

/// The landmarks of a scene on the built-in back; a mesh from a file has none.
pub fn marks(scene: &Scene) -> Vec<Mark> {
    let SurfaceChoice::BuiltinBack { triangles } = scene.scenario.surface else {
        return Vec::new();
    };
    let landmarks = back::landmarks(&BackOptions::with_triangles(triangles));
    landmarks
        .into_iter()
        .filter_map(|landmark| {
            let near = scene
                .touch
                .search
                .nearest(&scene.surface, landmark.position_mm, 20.0)?;
            // The column reads by its spinous processes; its transverse ones are dots beside them.
            let text = match landmark.kind {
                Kind::Spinous => landmark.level.to_owned(),
                Kind::Transverse => String::new(),
                _ => sentence_case(&landmark.name),
            };
            let rank = match landmark.kind {
                Kind::Spinous if !FIRST_NAMED.contains(&landmark.level) => 1,
                Kind::Transverse => 2,
                _ => 0,
            };
            Some(Mark {
                text,
                point_mm: near.point,
                triangle: near.triangle,
                rank,
            })
        })
        .collect()
}

fn sentence_case(name: &str) -> String {
    let mut letters = name.chars();
    letters
        .next()
        .map(|first| first.to_uppercase().chain(letters).collect())
        .unwrap_or_default()
}

/// Whether nothing of the rest surface lies between the eye and a place on it.
pub fn is_seen(scene: &Scene, camera: &Camera, point_mm: Vec3) -> bool {
    const HIDDEN_BY_MM: f64 = 3.0;
    let towards = match camera.projection {
        Projection::Perspective => camera.eye_mm() - point_mm,
        Projection::Orthographic => camera.basis().back * 10_000.0,
    };
    let from = point_mm + unit_or(towards, Vec3::ZERO) * HIDDEN_BY_MM;
    let search = &scene.touch.search;
    search
        .sweep(&scene.surface, point_mm + towards, from, Sides::Both)
        .is_none()
}

/// The presses that deform the skin, each with its finger, in the order of the fingers. A record of another scene, whose
/// triangle this one does not have, is left out.
pub fn presses(records: &[FingerRecord], scene: &Scene) -> (Vec<usize>, Vec<Press>) {
    records
        .iter()
        .filter_map(|r| Some((usize::from(r.finger), scene.press(&r.contact)?)))
        .unzip()
}

/// Whether two sets of presses differ by more than can be seen: a hand at rest still trembles by nanometres.
pub fn differ(a: &[Press], b: &[Press]) -> bool {
    const SEEN_MM: f64 = 1e-4;
    let same = |a: &Press, b: &Press| {
        a.triangle == b.triangle
            && a.anchor_mm.abs_diff_eq(b.anchor_mm, SEEN_MM)
            && a.foot_mm.abs_diff_eq(b.foot_mm, SEEN_MM)
            && a.normal.abs_diff_eq(b.normal, SEEN_MM)
            && (a.depth_mm - b.depth_mm).abs() <= SEEN_MM
            && a.oval == b.oval
            && a.boundary_mm == b.boundary_mm
    };
    a.len() != b.len() || !a.iter().zip(b).all(|(a, b)| same(a, b))
}

/// The largest of 1, 2 and 5 times a power of ten that is at most `most`; `None` unless `most` is positive and finite.
pub fn round_below(most: f64) -> Option<f64> {
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let power = 10.0_f64.powf(most.log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|m| m * power)
        .find(|&v| v <= most * (1.0 + 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_lengths_are_round() {
        assert_eq!(round_below(1.0), Some(1.0));
        assert_eq!(round_below(19.0), Some(10.0));
        assert_eq!(round_below(49.9), Some(20.0));
        assert_eq!(round_below(780.0), Some(500.0));
        assert_eq!(round_below(0.0), None);
        assert_eq!(round_below(f64::NAN), None);
    }

    #[test]
    fn trembling_is_not_a_change_but_a_tenth_of_a_millimetre_is() {
        let press = Press {
            depth_mm: 3.0,
            ..Press::default()
        };
        let deeper = |by: f64| Press {
            depth_mm: 3.0 + by,
            ..press.clone()
        };
        let still = std::slice::from_ref(&press);
        assert!(!differ(still, &[deeper(1e-6)]));
        assert!(differ(still, &[deeper(0.1)]));
        assert!(differ(still, &[]));
        assert!(differ(still, &[deeper(f64::NAN)]));
    }
}
