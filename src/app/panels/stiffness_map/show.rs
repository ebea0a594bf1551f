//! What of the map is shown, and in which colours.

use super::doc::Doc;
use crate::app::colours::map::Map;
use crate::app::editor::field::{Picture, Reader, Spec};
use crate::app::editor::plane::round_step;
use crate::app::editor::scale::Scale;
use crate::geom::Vec2;
use crate::maps::{Fit, StiffnessMap};
use std::sync::Arc;

/// What the canvas shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Show {
    /// The stiffness as colour.
    pub colour: bool,
    /// Lines of equal stiffness.
    pub lines: bool,
    /// The keys.
    pub keys: bool,
    /// The outline of the back.
    pub outline: bool,
    /// What lies beside the back dimmed.
    pub veiled: bool,
    /// Every fit along the section.
    pub all_fits: bool,
}

impl Default for Show {
    fn default() -> Self {
        Self {
            colour: true,
            lines: true,
            keys: true,
            outline: true,
            veiled: true,
            all_fits: false,
        }
    }
}

/// The map in use, and by the other fits where they are asked for.
pub struct Maps {
    /// As the scenario chooses.
    pub map: StiffnessMap,
    /// By every other fit that takes these keys.
    pub others: Vec<(Fit, StiffnessMap)>,
}

/// What the field shall be; `state` is another number for each state of the map.
pub fn spec(doc: &Doc, state: u64, show: &Show) -> Spec<Maps> {
    let (doc, all_fits) = (doc.clone(), show.all_fits);
    Spec {
        map: state * 2 + u64::from(all_fits),
        quantity: 0,
        build: Arc::new(move || {
            let others = Fit::all().iter().filter(|&&f| all_fits && f != doc.fit);
            Ok(Maps {
                map: doc.map(doc.fit)?,
                others: others
                    .filter_map(|&fit| Some((fit, doc.map(fit).ok()?)))
                    .collect(),
            })
        }),
        read: Arc::new(|maps: &Maps| -> Reader<'_> {
            let mut reader = maps.map.reader();
            Box::new(move |place: Vec2| reader(place))
        }),
        lines: true,
        line_at_zero: true,
    }
}

/// The colours: from round number to round number about the keys and what is in view.
pub fn scale(doc: &Doc, picture: &Picture<Maps>) -> Scale {
    let keys = doc.keys.iter().map(|k| k.stiffness_n_per_mm);
    let seen = picture.grid.range().map(|(lo, hi)| [lo, hi]);
    let (lo, hi) = keys
        .chain(seen.into_iter().flatten())
        .fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(v), hi.max(v)));
    let step = round_step((hi - lo).max(1e-3 * hi.abs()), 8.0);
    Scale::new(
        Map::Sequential,
        (lo / step + 1e-9).floor() * step,
        (hi / step - 1e-9).ceil() * step,
    )
}
