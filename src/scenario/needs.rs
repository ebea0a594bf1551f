//! What a scene requires, and the ledger that tells it.

use super::{Scenario, SurfaceChoice};
use crate::contact::ForceModel;
use crate::maps::Fit;

/// What is going on beside the scene itself: it decides what else must exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Use {
    /// Fingers that palpate.
    pub fingers: usize,
    /// A servo thread runs.
    pub live: bool,
    /// A Back view is open: graphics mesh and deformation are drawn.
    pub drawn: bool,
    /// Deformation is computed though nothing is drawn (pictures, exports).
    pub deformed: bool,
    /// A recorder writes.
    pub recorded: bool,
    /// A plot panel is open.
    pub plotted: bool,
    /// A Partition panel is open.
    pub partitioned: bool,
    /// A quantity colours the skin.
    pub coloured: bool,
    /// Bones are drawn below the skin.
    pub bones_drawn: bool,
    /// Names of landmarks are shown.
    pub named: bool,
    /// Hands are drawn in the place of fingertips.
    pub hands_drawn: bool,
    /// The skin is drawn for two eyes.
    pub two_eyes: bool,
    /// The Ellipse map panel is open.
    pub ellipse_edited: bool,
    /// The Stiffness map panel is open.
    pub stiffness_edited: bool,
    /// The Scenario editor panel is open.
    pub scenario_edited: bool,
    /// The Scenarios panel is open.
    pub listed: bool,
    /// The Sessions panel is open.
    pub browsed: bool,
    /// Recordings are shown as ghosts.
    pub ghosts: bool,
    /// The Compare panel holds what it compares.
    pub compared: bool,
    /// The passivity controller is on.
    pub passivity: bool,
}

/// A part that a scene may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Item {
    /// The haptic surface with its adjacency.
    Surface,
    /// Bumps and hollows of dysfunctions: vertices of the surface moved.
    Bumps,
    /// The production search structure.
    Search,
    /// Stiffness per vertex; a uniform stiffness needs none.
    StiffnessField,
    /// Footprint ellipses per vertex; a scene with one circle for all needs none.
    EllipseField,
    /// Friction: anchor and slip.
    Friction,
    /// Skin drag per vertex.
    SkinDrag,
    /// Places that hurt.
    Tenderness,
    /// The structure of the published haptic pass.
    Published,
    /// A force model that takes more than stiffness times depth.
    ForceModel,
    /// A ball for a finger instead of a point.
    FingerPad,
    /// The force of the smooth surface that a mesh stands for.
    ForceShading,
    /// What holds back energy that the skin would give out.
    Passivity,
    /// Per-vertex displacement and normals of the drawn skin.
    Deformation,
    /// Its tangential half.
    TangentialField,
    /// Depth to bone per vertex: limits and narrows dents.
    Bones,
    /// Vertex buffers for the window.
    GraphicsMesh,
    /// A number per vertex that colours the skin.
    SurfaceColour,
    /// Bones to be seen below the skin; nothing is felt through them.
    DrawnBones,
    /// Names of landmarks and their places.
    LandmarkNames,
    /// Hands in the place of fingertips.
    HandModel,
    /// A picture for each eye. Held by the graphics card alone.
    SecondEye,
    /// A published tree of cells, to be looked at.
    PartitionTree,
    /// Canvas and colour field of the ellipse map's editor.
    EllipseEditor,
    /// Canvas and colour field of the stiffness map's editor.
    StiffnessEditor,
    /// Canvas and colour field of the scenario editor.
    ScenarioEditor,
    /// Small pictures of scenarios.
    Thumbnails,
    /// The list of recordings with its small pictures.
    SessionPictures,
    /// Recordings that are overlaid on the one that is replayed.
    Ghosts,
    /// What the Compare panel found.
    Comparison,
    /// Plot history.
    PlotHistory,
    /// The ring that takes every tick out of the servo.
    Ring,
    /// The recorder's writer.
    Recorder,
}

impl Item {
    /// Every part, in the order of the ledger.
    pub const ALL: [Self; 33] = [
        Self::Surface,
        Self::Bumps,
        Self::Search,
        Self::StiffnessField,
        Self::EllipseField,
        Self::Friction,
        Self::SkinDrag,
        Self::Tenderness,
        Self::Published,
        Self::ForceModel,
        Self::FingerPad,
        Self::ForceShading,
        Self::Passivity,
        Self::Deformation,
        Self::TangentialField,
        Self::Bones,
        Self::GraphicsMesh,
        Self::SurfaceColour,
        Self::DrawnBones,
        Self::LandmarkNames,
        Self::HandModel,
        Self::SecondEye,
        Self::PartitionTree,
        Self::EllipseEditor,
        Self::StiffnessEditor,
        Self::ScenarioEditor,
        Self::Thumbnails,
        Self::SessionPictures,
        Self::Ghosts,
        Self::Comparison,
        Self::PlotHistory,
        Self::Ring,
        Self::Recorder,
    ];

    /// Name in the ledger.
    pub fn name(self) -> &'static str {
        match self {
            Self::Surface => "Surface and adjacency",
            Self::Bumps => "Bumps of the surface",
            Self::Search => "Search structure",
            Self::StiffnessField => "Stiffness per vertex",
            Self::EllipseField => "Ellipses per vertex",
            Self::Friction => "Friction",
            Self::SkinDrag => "Skin drag per vertex",
            Self::Tenderness => "Tender places",
            Self::Published => "Published haptic pass",
            Self::ForceModel => "Force model",
            Self::FingerPad => "Finger pad",
            Self::ForceShading => "Force shading",
            Self::Passivity => "Passivity controller",
            Self::Deformation => "Deformation",
            Self::TangentialField => "Tangential field",
            Self::Bones => "Bones",
            Self::GraphicsMesh => "Graphics mesh",
            Self::SurfaceColour => "Surface colour",
            Self::DrawnBones => "Drawn bones",
            Self::LandmarkNames => "Landmark names",
            Self::HandModel => "Hand model",
            Self::SecondEye => "Second eye",
            Self::PartitionTree => "Partition tree",
            Self::EllipseEditor => "Ellipse map editor",
            Self::StiffnessEditor => "Stiffness map editor",
            Self::ScenarioEditor => "Scenario editor",
            Self::Thumbnails => "Pictures of scenarios",
            Self::SessionPictures => "List of sessions",
            Self::Ghosts => "Ghosts",
            Self::Comparison => "Comparison",
            Self::PlotHistory => "Plot history",
            Self::Ring => "Ring of ticks",
            Self::Recorder => "Recorder",
        }
    }

    /// Whom `scenario` under `purpose` needs it for, or why it is left out.
    pub fn verdict(self, scenario: &Scenario, purpose: Use) -> Verdict {
        use Verdict::{LeftOut, Needed};
        let deformed = purpose.drawn || purpose.deformed;
        let on_back = matches!(scenario.surface, SurfaceChoice::BuiltinBack { .. });
        let choose = |needed, why, why_not| {
            if needed {
                Needed(why)
            } else {
                LeftOut(why_not)
            }
        };
        match self {
            Self::Surface => Needed("contact"),
            Self::Bumps => choose(
                scenario.has_patch(|p| p.bump_mm != 0.0),
                "[[dysfunction]]",
                "no dysfunction has a bump",
            ),
            Self::SkinDrag => match &scenario.friction {
                None => LeftOut("the scenario has no [friction]"),
                Some(_) => choose(
                    scenario.has_patch(|p| p.drag_factor != 1.0),
                    "[[dysfunction]]",
                    "no dysfunction changes skin drag",
                ),
            },
            Self::Tenderness => choose(
                scenario.has_patch(|p| p.tender.is_some()),
                "[[dysfunction]]",
                "no dysfunction is tender",
            ),
            Self::Search => Needed(if scenario.published.is_some() {
                "placing scripts and the cursor"
            } else {
                "contact"
            }),
            Self::Published => choose(
                scenario.published.is_some(),
                "[contact]",
                "the production engine feels the surface",
            ),
            Self::StiffnessField if !scenario.strokes.is_empty() => Needed("strokes"),
            Self::StiffnessField if scenario.has_patch(|p| p.stiffness_factor != 1.0) => {
                Needed("[[dysfunction]]")
            }
            Self::StiffnessField => {
                let mut keys = scenario.stiffness_keys.iter();
                let first = keys.next().map(|k| k.stiffness_n_per_mm);
                let varied = keys.any(|k| Some(k.stiffness_n_per_mm) != first);
                choose(
                    varied && scenario.stiffness_fit != Fit::Constant,
                    "stiffness keys",
                    "stiffness is the same everywhere",
                )
            }
            Self::EllipseField => {
                let keyed = (scenario.ellipse.as_ref()).is_some_and(|(keys, _)| !keys.is_empty());
                match (keyed, deformed) {
                    (true, true) => Needed("[ellipse] keys"),
                    (true, false) => LeftOut("nothing shows the skin"),
                    (false, _) => LeftOut("one circle for all places"),
                }
            }
            Self::Friction => choose(
                scenario.friction.is_some(),
                "[friction]",
                "the scenario has no [friction]",
            ),
            Self::ForceModel => choose(
                scenario.choices.force != ForceModel::Linear,
                "[force]",
                "linear: stiffness times depth",
            ),
            Self::FingerPad => choose(
                scenario.choices.pad_mm().is_some(),
                "[contact] finger_radius_mm",
                "the finger is a point",
            ),
            Self::ForceShading => choose(
                scenario.choices.shaded,
                "[contact] shading",
                "forces are those of the facets",
            ),
            Self::Passivity => choose(
                purpose.passivity,
                "--passivity",
                "forces are those of the contact",
            ),
            Self::Deformation => {
                let by = if purpose.drawn {
                    "back view"
                } else {
                    "picture"
                };
                choose(deformed, by, "nothing shows the skin")
            }
            Self::TangentialField => match (deformed, scenario.friction.is_some()) {
                (true, true) => Needed("friction drags the drawn skin"),
                (true, false) => LeftOut("without friction nothing is dragged"),
                (false, _) => LeftOut("nothing shows the skin"),
            },
            Self::Bones => match (deformed, &scenario.bones) {
                (true, Some(_)) => Needed("[bones]"),
                (true, None) => LeftOut("the scenario has no [bones]"),
                (false, _) => LeftOut("nothing shows the skin"),
            },
            Self::GraphicsMesh => choose(purpose.drawn, "back view", "no back view is open"),
            Self::SurfaceColour => choose(
                purpose.drawn && purpose.coloured,
                "back view",
                "bare skin is shown",
            ),
            Self::DrawnBones | Self::LandmarkNames if !on_back => {
                LeftOut("known for the built-in back only")
            }
            Self::DrawnBones => choose(
                purpose.drawn && purpose.bones_drawn,
                "back view",
                "nothing shows bones",
            ),
            Self::LandmarkNames => choose(
                purpose.drawn && purpose.named,
                "back view",
                "no landmarks are named",
            ),
            Self::HandModel => choose(
                purpose.drawn && purpose.hands_drawn,
                "back view",
                "fingertips are spheres",
            ),
            Self::SecondEye => choose(
                purpose.drawn && purpose.two_eyes,
                "back view",
                "one picture is drawn",
            ),
            Self::PartitionTree => choose(
                purpose.partitioned,
                "partition panel",
                "no partition panel is open and no engine uses it",
            ),
            Self::EllipseEditor => choose(
                purpose.ellipse_edited,
                "ellipse map panel",
                "the panel is closed",
            ),
            Self::StiffnessEditor => choose(
                purpose.stiffness_edited,
                "stiffness map panel",
                "the panel is closed",
            ),
            Self::ScenarioEditor => choose(
                purpose.scenario_edited,
                "scenario editor panel",
                "the panel is closed",
            ),
            Self::Thumbnails => choose(purpose.listed, "scenarios panel", "the panel is closed"),
            Self::SessionPictures => {
                choose(purpose.browsed, "sessions panel", "the panel is closed")
            }
            Self::Ghosts => choose(
                purpose.ghosts,
                "recordings overlaid",
                "no recording is overlaid",
            ),
            Self::Comparison => choose(purpose.compared, "compare panel", "nothing is compared"),
            Self::PlotHistory => choose(purpose.plotted, "plots", "no plot is open"),
            Self::Ring => choose(
                purpose.live,
                "servo: recorder and plots may start at any time",
                "no servo runs",
            ),
            Self::Recorder => choose(purpose.recorded, "recording", "nothing is recorded"),
        }
    }
}

/// Whether a part is required.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// By whom.
    Needed(&'static str),
    /// Why not.
    LeftOut(&'static str),
}

/// Which parts are required.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Each required part with whom it is needed by, in the order of [`Item`].
    pub required: Vec<(Item, &'static str)>,
}

impl Needs {
    /// What `scenario` requires under `purpose`.
    pub fn of(scenario: &Scenario, purpose: Use) -> Self {
        let required = Item::ALL
            .into_iter()
            .filter_map(|item| match item.verdict(scenario, purpose) {
                Verdict::Needed(by) => Some((item, by)),
                Verdict::LeftOut(_) => None,
            })
            .collect();
        Self { required }
    }

    /// Whether `item` is required.
    pub fn has(&self, item: Item) -> bool {
        self.required.iter().any(|&(i, _)| i == item)
    }
}

/// One line of the ledger.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LedgerRow {
    /// Which part.
    pub item: &'static str,
    /// Whom it is needed by, or why it was left out.
    pub reason: String,
    /// Whether it was built.
    pub built: bool,
    /// Bytes it holds on the heap; 0 for what is a number or two in the scene itself, there or not.
    pub bytes: usize,
    /// How long building it took, µs; `None` for what is not built or takes no time worth the name.
    pub build_us: Option<f64>,
    /// Measured cost, µs, with what it is paid per; `None` for what has not been measured or costs nothing.
    pub cost_us: Option<f64>,
    /// "tick", "frame", "build"; empty when there is no cost.
    pub cost_per: &'static str,
}

/// For each part: needed by whom, or left out; bytes; µs.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Ledger {
    /// One row per [`Item`].
    pub rows: Vec<LedgerRow>,
}

impl Ledger {
    /// Every part with its verdict; nothing built yet.
    pub fn of(scenario: &Scenario, purpose: Use) -> Self {
        let row = |item: Item| {
            let reason = match (item.verdict(scenario, purpose), &scenario.published) {
                (Verdict::Needed(why), _) if item == Item::ForceModel => {
                    format!("{why} {}", scenario.choices.force)
                }
                (Verdict::Needed(why), Some(options)) if item == Item::Published => {
                    format!("{why} {options}")
                }
                (Verdict::Needed(why) | Verdict::LeftOut(why), _) => why.to_owned(),
            };
            LedgerRow {
                item: item.name(),
                reason,
                built: false,
                bytes: 0,
                build_us: None,
                cost_us: None,
                cost_per: "",
            }
        };
        Self {
            rows: Item::ALL.into_iter().map(row).collect(),
        }
    }

    /// Notes that `item` was built and holds `bytes`.
    pub fn built(&mut self, item: Item, bytes: usize) {
        let row = &mut self.rows[item as usize];
        (row.built, row.bytes) = (true, bytes);
    }

    /// Takes over what `item` holds and cost where it was built before.
    pub(super) fn carry(&mut self, item: Item, from: &Self) {
        let row = &mut self.rows[item as usize];
        let reason = std::mem::take(&mut row.reason);
        *row = LedgerRow {
            reason,
            ..from.row(item).clone()
        };
    }

    /// Notes what `item` costs, µs, per "tick", "frame" or "build"; what building it took stays noted beside what it costs
    /// in use.
    pub fn cost(&mut self, item: Item, cost_us: f64, per: &'static str) {
        let row = &mut self.rows[item as usize];
        if per == "build" {
            row.build_us = Some(cost_us);
        }
        (row.cost_us, row.cost_per) = (Some(cost_us), per);
    }

    /// The row of `item`.
    pub fn row(&self, item: Item) -> &LedgerRow {
        &self.rows[item as usize]
    }

    /// Bytes of everything built.
    pub fn total_bytes(&self) -> usize {
        self.rows.iter().map(|r| r.bytes).sum()
    }
}
