//! What of a scenario is written here, and what can be done to it.

use super::snap;
use crate::app::editor::editing::Document;
use crate::geom::Vec2;
use crate::scenario::{Dysfunction, Exercise, Kind, Place, Scenario, Site, dysfunction, edit};
use std::sync::Arc;

/// Offsets allowed, mm either way.
const MOST_OFFSET_MM: f64 = 100.0;
/// Half axes that a hand can make, mm.
const HALF_AXES_MM: [f64; 2] = [1.0, 300.0];
/// A copy of a point lies so far below it, mm.
const COPY_MM: f64 = 20.0;

/// Name, description, dysfunctions and exercise of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Doc {
    /// Its name.
    pub name: String,
    /// What it is for; may be empty.
    pub description: String,
    /// What is wrong with the back, in order; shared between steps of undo.
    pub list: Arc<Vec<Dysfunction>>,
    /// What is asked of whom palpates; `None`: nothing.
    pub exercise: Option<Arc<Exercise>>,
}

impl Document for Doc {
    fn of(scenario: &Scenario) -> Self {
        Self {
            name: scenario.name.clone(),
            description: scenario.description.clone(),
            list: Arc::new(scenario.dysfunctions.clone()),
            exercise: scenario.exercise.clone().map(Arc::new),
        }
    }

    fn write(&self, source: &str) -> Result<String, String> {
        edit::set_about(source, &self.name, &self.description)
            .and_then(|text| edit::set_dysfunctions(&text, &self.list))
            .and_then(|text| edit::set_exercise(&text, self.exercise.as_deref()))
            .map_err(|e| e.to_string())
    }

    fn check(&self) -> Result<(), String> {
        // Against the map and the friction under them they are checked beside, by the panel.
        for (i, d) in self.list.iter().enumerate() {
            d.patches()
                .map_err(|fault| format!("dysfunction {} ({d}): {fault}", i + 1))?;
        }
        Ok(())
    }

    fn keys(&self) -> usize {
        self.list.len()
    }
}

impl Doc {
    /// With these dysfunctions.
    #[must_use]
    pub fn with_list(&self, list: Vec<Dysfunction>) -> Self {
        Self {
            list: Arc::new(list),
            ..self.clone()
        }
    }

    /// With `change` done to the exercise, where there is one.
    #[must_use]
    pub fn with_exercise(&self, change: impl FnOnce(&mut Exercise)) -> Self {
        let mut doc = self.clone();
        if let Some(e) = &mut doc.exercise {
            change(Arc::make_mut(e));
        }
        doc
    }

    /// With `change` done to one.
    #[must_use]
    pub fn with(&self, index: usize, change: impl FnOnce(&mut Dysfunction)) -> Self {
        let mut doc = self.clone();
        if let Some(d) = Arc::make_mut(&mut doc.list).get_mut(index) {
            change(d);
        }
        doc
    }

    /// With one more at the end.
    #[must_use]
    pub fn with_new(&self, kind: &dyn Kind, place: Place, severity: u8) -> Self {
        self.with_more([kind.default_at(place, severity)])
    }

    /// With more at the end.
    #[must_use]
    pub fn with_more(&self, more: impl IntoIterator<Item = Dysfunction>) -> Self {
        let mut list = self.list.to_vec();
        list.extend(more);
        self.with_list(list)
    }

    /// With a copy of one right after it, a level further down where there is one: two of a kind cannot be at one place.
    #[must_use]
    pub fn with_copy(&self, index: usize) -> Self {
        let mut list = self.list.to_vec();
        if let Some(d) = self.list.get(index) {
            let mut copy = d.clone();
            match &mut copy.place {
                Place::At(at) => at.y -= COPY_MM,
                Place::Sites(sites) => {
                    let beside = |by: i32| -> Option<Vec<Site>> {
                        let shift = |s: &Site| {
                            let level = s.level.down(by)?;
                            let rib =
                                s.target != dysfunction::Target::RibAngle || level.rib().is_some();
                            rib.then_some(Site { level, ..*s })
                        };
                        sites.iter().map(shift).collect()
                    };
                    let levels = levels_spanned(sites);
                    if let Some(there) = beside(levels).or_else(|| beside(-levels)) {
                        *sites = there;
                    }
                }
            }
            list.insert(index + 1, copy);
        }
        self.with_list(list)
    }

    /// With one moved to the other side.
    #[must_use]
    pub fn with_mirrored(&self, index: usize) -> Self {
        self.with(index, |d| *d = mirrored(d))
    }

    /// With a mirror image of one right after it.
    #[must_use]
    pub fn with_mirror_copy(&self, index: usize) -> Self {
        let mut list = self.list.to_vec();
        if let Some(d) = self.list.get(index) {
            list.insert(index + 1, mirrored(d));
        }
        self.with_list(list)
    }

    /// With one `by` places later in the order; nothing beyond its ends.
    #[must_use]
    pub fn with_moved(&self, index: usize, by: isize) -> Self {
        let mut list = self.list.to_vec();
        if let Some(to) = index.checked_add_signed(by)
            && to < list.len()
            && index < list.len()
        {
            let d = list.remove(index);
            list.insert(to, d);
        }
        self.with_list(list)
    }

    /// Without one.
    #[must_use]
    pub fn without(&self, index: usize) -> Self {
        let mut list = self.list.to_vec();
        if index < list.len() {
            list.remove(index);
        }
        self.with_list(list)
    }
}

/// How many levels from the first to the last.
fn levels_spanned(sites: &[Site]) -> i32 {
    let first = sites.iter().map(|s| s.level).min();
    let last = sites.iter().map(|s| s.level).max();
    first
        .zip(last)
        .map_or(1, |(first, last)| first.levels_down_to(last) + 1)
}

/// The same on the other side. Offset and angle count from the midline outwards, so that they stay; in the middle, where
/// outwards is to the right, they are turned round.
pub fn mirrored(d: &Dysfunction) -> Dysfunction {
    let mut d = d.clone();
    let turned = match &mut d.place {
        Place::At(at) => {
            at.x = -at.x + 0.0;
            at.x == 0.0
        }
        Place::Sites(sites) => {
            let there: Vec<Site> = sites.iter().map(|s| s.mirrored()).collect();
            let same = there.iter().all(|s| sites.contains(s));
            if same {
                // Both sides, or the middle: the order stays, as it is that of the file.
                sites.iter().all(|s| s.side == dysfunction::Side::Middle)
            } else {
                *sites = there;
                false
            }
        }
    };
    if turned {
        d.offset_mm.x = -d.offset_mm.x + 0.0;
        d.angle_deg = tidy_angle(180.0 - d.angle_deg);
    }
    d
}

/// The sign of "outwards" at each of its places: −1 on the left.
pub fn outwards(place: &Place) -> Vec<f64> {
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    match place {
        Place::At(at) => vec![sign(at.x)],
        Place::Sites(sites) => sites.iter().map(|s| sign(s.lateral())).collect(),
    }
}

/// The centre of each of its places with the offset, mm; without the variation that a seed makes.
pub fn centres(d: &Dysfunction) -> Vec<Vec2> {
    let places = match &d.place {
        Place::At(at) => vec![*at],
        Place::Sites(sites) => sites.iter().map(Site::at_mm).collect(),
    };
    let offset = |out: &f64| Vec2::new(d.offset_mm.x * out, d.offset_mm.y);
    let outwards = outwards(&d.place);
    places
        .iter()
        .zip(&outwards)
        .map(|(at, out)| *at + offset(out))
        .collect()
}

/// Moves place `which` of it to `to`: to the nearest site, or freely beside the one it is at.
pub fn move_to(d: &mut Dysfunction, which: usize, to: Vec2, free: bool) {
    if !to.is_finite() {
        return;
    }
    let out = outwards(&d.place).get(which).copied().unwrap_or(1.0);
    match &mut d.place {
        Place::At(at) => *at = tidy_place(to),
        Place::Sites(sites) => {
            let Some(site) = sites.get(which).copied() else {
                return;
            };
            if free {
                let beside = tidy_place(to - site.at_mm());
                let offset = Vec2::new(beside.x * out, beside.y);
                d.offset_mm = offset
                    .clamp(Vec2::splat(-MOST_OFFSET_MM), Vec2::splat(MOST_OFFSET_MM))
                    + Vec2::ZERO;
                return;
            }
            let Some(nearest) = snap::nearest(to, f64::INFINITY) else {
                return;
            };
            if !sites.contains(&nearest) {
                sites[which] = nearest;
            }
            if sites.len() == 1 {
                d.offset_mm = Vec2::ZERO;
            }
        }
    }
}

/// Sets one of the half axes.
pub fn set_half_axis(d: &mut Dysfunction, which: usize, mm: f64) {
    if let Some(axis) = d.radius_mm.get_mut(which)
        && mm.is_finite()
    {
        let tidy = (mm * 10.0).round() / 10.0;
        *axis = tidy.clamp(HALF_AXES_MM[0], HALF_AXES_MM[1]);
    }
}

/// A direction from 0 to 180 degrees, to a tenth; an ellipse has no more.
pub fn tidy_angle(degrees: f64) -> f64 {
    let tidy = (degrees * 10.0).round() / 10.0;
    if tidy.is_finite() {
        tidy.rem_euclid(180.0)
    } else {
        0.0
    }
}

/// A place to a tenth of a mm: what a hand can mean.
pub fn tidy_place(at: Vec2) -> Vec2 {
    (at * 10.0).round() / 10.0 + Vec2::ZERO
}

/// Makes it another kind: what is not the first kind's default stays.
pub fn set_kind(d: &mut Dysfunction, kind: &'static dyn Kind) {
    let before = d
        .kind()
        .map(|old| old.default_at(d.place.clone(), d.severity));
    let after = kind.default_at(d.place.clone(), d.severity);
    let mut next = d.clone();
    (next.kind, next.preset) = (after.kind, after.preset);
    if let Some(before) = before {
        if d.radius_mm == before.radius_mm {
            next.radius_mm = after.radius_mm;
        }
        if d.angle_deg == before.angle_deg {
            next.angle_deg = after.angle_deg;
        }
        if d.profile == before.profile {
            next.profile = after.profile;
        }
    }
    *d = next;
}

/// What a dysfunction is called in one line: kind and place.
pub fn title(d: &Dysfunction) -> String {
    let kind = d.kind().map_or(d.kind, |k| k.title());
    format!("{kind}, {}", d.place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::dysfunction::{all, named};
    use crate::scenario::sites;

    fn doc(text: &str) -> Doc {
        let doc = Doc {
            name: "A".into(),
            description: String::new(),
            list: Arc::default(),
            exercise: None,
        };
        let kind = named("hypertonic").expect("listed");
        doc.with_new(kind, Place::Sites(sites(text).expect("sites")), 2)
    }

    fn place(doc: &Doc, index: usize) -> String {
        doc.list[index].place.to_string()
    }

    #[test]
    fn a_copy_lies_below_and_at_the_end_of_the_spine_above() {
        assert_eq!(
            place(&doc("T5 right").with_copy(0), 1),
            "T6 right transverse process"
        );
        assert_eq!(
            place(&doc("L4-L5 left muscle").with_copy(0), 1),
            "L2-L3 left muscles"
        );
        assert_eq!(
            place(&doc("T12 left rib angle").with_copy(0), 1),
            "T11 left rib angle"
        );
        let all = doc("C7-L5 middle");
        assert_eq!(all.with_copy(0).list[1].place, all.list[0].place);
    }

    #[test]
    fn mirrored_twice_is_as_before_for_every_kind_and_place() {
        for kind in all() {
            for text in [
                "T5 right",
                "T5 middle",
                "T3-T6 both sides",
                "T2 left rib angle",
            ] {
                let mut d = kind.default_at(Place::Sites(sites(text).expect("sites")), 2);
                d.offset_mm = Vec2::new(3.0, -4.0);
                assert_eq!(mirrored(&mirrored(&d)), d, "{text}");
                let (a, b) = (centres(&d), centres(&mirrored(&d)));
                for p in &a {
                    let image = Vec2::new(-p.x, p.y);
                    assert!(
                        b.iter().any(|q| q.distance(image) < 1e-9),
                        "{text}: {a:?} {b:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_drag_goes_from_site_to_site_and_freely_beside_one() {
        let mut d = doc("T5 left").list[0].clone();
        let t7 = sites("T7 left").expect("a site")[0];
        move_to(&mut d, 0, t7.at_mm() + Vec2::new(0.4, 0.4), false);
        assert_eq!(d.place, Place::from(t7));
        assert_eq!(d.offset_mm, Vec2::ZERO);
        move_to(&mut d, 0, t7.at_mm() + Vec2::new(-2.04, 1.0), true);
        assert_eq!(d.place, Place::from(t7));
        assert_eq!(d.offset_mm, Vec2::new(2.0, 1.0), "outwards is to the left");
        let at = centres(&d)[0];
        assert!((at - t7.at_mm() - Vec2::new(-2.0, 1.0)).length() < 1e-9);
        move_to(&mut d, 0, Vec2::new(1e9, 0.0), true);
        assert_eq!(d.offset_mm, Vec2::new(-100.0, -100.0));
        move_to(&mut d, 0, Vec2::NAN, true);
        assert!(d.offset_mm.is_finite());
    }

    #[test]
    fn another_kind_keeps_what_was_stated() {
        let mut d = doc("T5 left").list[0].clone();
        d.angle_deg = 33.0;
        let to = named("tender").expect("listed");
        set_kind(&mut d, to);
        let default = to.default_at(d.place.clone(), 2);
        assert_eq!((d.angle_deg, d.radius_mm), (33.0, default.radius_mm));
        assert_eq!(d.kind, "tender");
    }

    #[test]
    fn order_copies_and_removal_keep_the_rest() {
        let two = doc("T5 left").with_copy(0).with_copy(1);
        assert_eq!(place(&two.with_moved(0, 2), 2), place(&two, 0));
        assert_eq!(two.with_moved(0, -1), two);
        assert_eq!(two.with_moved(2, 1), two);
        assert_eq!(two.without(1).list.len(), 2);
        assert_eq!(two.without(9), two);
        assert_eq!(two.with_mirror_copy(0).list.len(), 4);
    }
}
