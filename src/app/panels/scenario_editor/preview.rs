//! What the dysfunctions do to the stiffness: as colour over the back and along a line.

use super::State;
use super::doc::{Doc, centres};
use super::wording;
use crate::app::colours::map::Map;
use crate::app::editor::field::{Picture, Reader, Spec};
use crate::app::editor::parts::{pick, row};
use crate::app::editor::plane::round_step;
use crate::app::editor::scale::Scale;
use crate::app::editor::section::{Series, span_of};
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::maps::StiffnessMap;
use crate::scenario::{Exercise, Patch, Scenario, edit};
use std::sync::Arc;

/// Half the length of a section through a dysfunction, as a multiple of its larger half axis.
const SECTION_SHARE: f64 = 2.5;
/// Shortest half of such a section, mm.
const SECTION_MM: f64 = 45.0;

/// What is shown as colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// The stiffness with the dysfunctions.
    #[default]
    With,
    /// The stiffness without them.
    Without,
    /// How much they change it.
    Change,
}

impl Quantity {
    const ALL: [Self; 3] = [Self::With, Self::Without, Self::Change];

    fn text(self) -> &'static str {
        match self {
            Self::With => "With",
            Self::Without => "Without",
            Self::Change => "Change",
        }
    }

    fn about(self) -> &'static str {
        match self {
            Self::With => "The stiffness as it is felt, N/mm",
            Self::Without => "The stiffness without the dysfunctions, N/mm",
            Self::Change => "How much the dysfunctions change the stiffness, percent",
        }
    }

    /// Over the legend.
    pub fn legend(self) -> &'static str {
        match self {
            Self::With => "Stiffness, N/mm",
            Self::Without => "Stiffness without, N/mm",
            Self::Change => "Change of stiffness, %",
        }
    }

    /// Decimals of round numbers beside the colours.
    pub fn decimals(self) -> usize {
        match self {
            Self::With | Self::Without => 2,
            Self::Change => 0,
        }
    }
}

/// What the canvas shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Show {
    /// What the colours stand for.
    pub quantity: Quantity,
    /// The colours.
    pub colour: bool,
    /// Lines of equal value.
    pub lines: bool,
    /// The sites that a click adds at.
    pub sites: bool,
    /// The section goes through the chosen dysfunction, and with it.
    pub follows: bool,
    /// The section runs along the spine instead of across it.
    pub along: bool,
}

impl Default for Show {
    fn default() -> Self {
        Self {
            quantity: Quantity::With,
            colour: true,
            lines: false,
            sites: true,
            follows: true,
            along: false,
        }
    }
}

/// The stiffness with and without the dysfunctions.
pub struct Maps {
    /// With.
    pub with: StiffnessMap,
    /// Without.
    pub without: StiffnessMap,
}

impl Maps {
    fn of(scenario: &Scenario) -> Result<Self, String> {
        let with = scenario.stiffness_map().map_err(|e| e.to_string())?;
        let without = scenario.base_stiffness_map().map_err(|e| e.to_string())?;
        Ok(Self { with, without })
    }

    fn reader(&self, quantity: Quantity) -> Reader<'_> {
        let mut with = self.with.reader();
        let mut without = self.without.reader();
        Box::new(move |place| match quantity {
            Quantity::With => with(place),
            Quantity::Without => without(place),
            Quantity::Change => 100.0 * (with(place) / without(place) - 1.0),
        })
    }
}

/// What the dysfunctions under the hands lead to, on the map and the friction of the scene.
pub struct Ground {
    /// The scene's scenario with the newest dysfunctions that can be together.
    pub scenario: Arc<Scenario>,
    /// What they do to the map plane, in order, each with the number of its dysfunction.
    pub patches: Vec<(usize, Patch)>,
    /// Another number for each state of it.
    pub state: u64,
    looked_at: Option<u64>,
    /// The exercise that was last checked.
    exercise: Option<Arc<Exercise>>,
}

impl Ground {
    /// That of a scenario as it is.
    pub fn new(scenario: &Arc<Scenario>) -> Self {
        Self {
            scenario: scenario.clone(),
            patches: scenario.patches().unwrap_or_default(),
            state: 0,
            looked_at: None,
            exercise: scenario.exercise.clone().map(Arc::new),
        }
    }

    /// Follows the scene and the dysfunctions, whose state is `state`.
    ///
    /// # Errors
    /// Why they cannot be together; the one before stays on show, with the outlines of the new one.
    pub fn follow(&mut self, scene: &Arc<Scenario>, doc: &Doc, state: u64) -> Result<(), String> {
        let same = same_ground(&self.scenario, scene);
        if same && self.looked_at == Some(state) {
            return Ok(());
        }
        self.looked_at = Some(state);
        let before = std::mem::replace(&mut self.exercise, doc.exercise.clone());
        let next = Scenario {
            dysfunctions: doc.list.to_vec(),
            ..Scenario::clone(scene)
        };
        match next.patches() {
            Ok(patches) => {
                if let Some(e) = doc.exercise.as_deref().filter(|_| doc.exercise != before) {
                    edit::set_exercise(&scene.source, Some(e)).map_err(|e| e.to_string())?;
                }
                if !same || self.scenario.dysfunctions != next.dysfunctions {
                    self.scenario = Arc::new(next);
                    self.state += 1;
                }
                self.patches = patches;
                Ok(())
            }
            Err(e) => {
                let each = doc.list.iter().enumerate();
                let of = each.flat_map(|(i, d)| {
                    let patches = d.patches().unwrap_or_default();
                    patches.into_iter().map(move |p| (i, p))
                });
                self.patches = of.collect();
                Err(e.to_string())
            }
        }
    }

    /// What the field shall be.
    pub fn spec(&self, quantity: Quantity) -> Spec<Maps> {
        let scenario = self.scenario.clone();
        Spec {
            map: self.state,
            quantity: quantity as u64,
            build: Arc::new(move || Maps::of(&scenario)),
            read: Arc::new(move |maps: &Maps| maps.reader(quantity)),
            lines: true,
            line_at_zero: quantity != Quantity::Change,
        }
    }
}

/// Whether what lies under the dysfunctions is the same.
fn same_ground(a: &Scenario, b: &Scenario) -> bool {
    a.stiffness_fit == b.stiffness_fit
        && a.friction == b.friction
        && a.stiffness_keys == b.stiffness_keys
        && a.strokes == b.strokes
}

/// The colours: the same for both sides of a comparison, so that they can be compared.
pub fn scale(quantity: Quantity, picture: &Picture<Maps>) -> Scale {
    let range = picture.grid.range().unwrap_or((0.0, 1.0));
    let (lo, hi) = range;
    if quantity == Quantity::Change {
        let most = lo.abs().max(hi.abs()).max(10.0);
        let step = round_step(most, 4.0);
        return Scale::about(Map::Diverging, 0.0, (most / step - 1e-9).ceil() * step);
    }
    let keys = picture.map.without.keys().iter();
    let (lo, hi) = keys
        .map(|k| k.stiffness_n_per_mm)
        .fold((lo, hi), |(lo, hi), v| (lo.min(v), hi.max(v)));
    let step = round_step((hi - lo).max(1e-3 * hi.abs()), 8.0);
    Scale::new(
        Map::Sequential,
        (lo / step + 1e-9).floor() * step,
        (hi / step - 1e-9).ceil() * step,
    )
}

/// What is under the pointer.
pub fn told(picture: Option<&Picture<Maps>>, cursor_mm: Option<Vec2>) -> String {
    let Some(p) = cursor_mm else {
        return String::new();
    };
    let place = format!("x {:>6.1}  y {:>6.1} mm", p.x, p.y);
    let Some(picture) = picture else {
        return place;
    };
    let (with, without) = (picture.map.with.at(p), picture.map.without.at(p));
    let change = 100.0 * (with / without - 1.0);
    if change.abs() < 0.05 {
        return format!("{place}  {with:>6.3} N/mm");
    }
    let change = wording::signed(change);
    format!("{place}  {with:>6.3} N/mm ({change} %)")
}

/// Puts the section through the chosen dysfunction.
pub fn follow_section(state: &mut State) {
    if !state.show.follows {
        return;
    }
    let doc = state.editing.doc();
    let chosen = state.editing.selected.and_then(|i| doc.list.get(i));
    let Some((d, at)) = chosen.and_then(|d| Some((d, *centres(d).first()?))) else {
        return;
    };
    let reach = d.radius_mm[0].max(d.radius_mm[1]) * SECTION_SHARE;
    let half = reach.max(SECTION_MM);
    let by = if state.show.along {
        Vec2::new(0.0, -half)
    } else {
        Vec2::new(half, 0.0)
    };
    state.section.ends = [at - by, at + by];
}

/// What is shown over the back.
pub fn shown(ui: &mut egui::Ui, show: &mut Show) {
    row(ui, "Colour", "What the colours stand for", |ui| {
        for q in Quantity::ALL {
            let name = format!("Colour: {}", q.text());
            if pick(ui, show.quantity == q, q.text(), &name, q.about()) {
                show.quantity = q;
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut show.colour, "Colours")
            .on_hover_text("The stiffness as colour");
        ui.checkbox(&mut show.lines, "Lines")
            .on_hover_text("Lines of equal value");
        ui.checkbox(&mut show.sites, "Sites").on_hover_text(
            "Spinous and transverse processes, rib angles and muscles: a click on one adds there",
        );
    });
}

/// Stiffness with and without along the section.
pub fn section(ui: &mut egui::Ui, theme: &Theme, state: &mut State) {
    ui.horizontal_wrapped(|ui| {
        ui.checkbox(&mut state.show.follows, "Through the chosen one")
            .on_hover_text(
                "Keep the section on the chosen dysfunction; else drag its ends A and B",
            );
        for (along, text, why) in [
            (false, "Across", "From left to right"),
            (true, "Along", "From head to foot"),
        ] {
            let name = format!("Section {}", text.to_lowercase());
            if pick(ui, state.show.along == along, text, &name, why) {
                state.show.along = along;
                state.show.follows = true;
            }
        }
    });
    let Some(picture) = state.field.picture().cloned() else {
        ui.weak("The map is being worked out");
        return;
    };
    let along = |map: &StiffnessMap| state.section.values(map.reader());
    let series = [
        Series {
            name: "with",
            colour: theme.accent,
            dashed: false,
            values: along(&picture.map.with),
        },
        Series {
            name: "without",
            colour: theme.weak_text,
            dashed: true,
            values: along(&picture.map.without),
        },
    ];
    let (_, hi) = span_of(&series);
    let span = (0.0, hi.max(1e-3));
    let name = "Felt cross-section";
    state.section.plot(ui, theme, name, "N/mm", span, &series);
}
