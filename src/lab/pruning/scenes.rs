//! The scenes that are counted: a plain one, and for each part one that has it and one that names it and does without.

use super::{Finger, Of};
use crate::scenario::Item;

/// A part that a scene may have or do without, and the scenes to see what that makes.
pub struct Part {
    /// Which.
    pub item: Item,
    /// What it is paid in.
    pub of: Of,
    /// A scene that needs it.
    pub with: Tables,
    /// The scene beside it, which is the same but for the part; and whether its skin is drawn.
    pub beside: (Tables, bool),
    /// A scene that names it, does without it and shows no skin; and one that never heard of it and is the same for the rest.
    pub left_out: Option<[Tables; 2]>,
    /// What the finger does when the part is there and has nothing to do.
    pub idle: Finger,
}

/// The tables of a scenario after `[surface]`: `[stiffness]` without its head, then the others.
#[derive(Clone, Copy)]
pub struct Tables(pub &'static str, pub &'static str);

const UNIFORM: &str = "constant_n_per_mm = 0.4";
const VARIED: &str = "fit = \"natural\"\nkey = [\n\
    { x = 0, y = 455, stiffness_n_per_mm = 1.1 },\n\
    { x = 0, y = 45.6, stiffness_n_per_mm = 1.1 },\n\
    { x = -30, y = 250, stiffness_n_per_mm = 0.48 },\n\
    { x = 30, y = 250, stiffness_n_per_mm = 0.48 },\n\
    { x = -140, y = 120, stiffness_n_per_mm = 0.3 },\n\
    { x = 140, y = 120, stiffness_n_per_mm = 0.3 },\n]";
const ONE_VALUE: &str = "fit = \"natural\"\nkey = [\n\
    { x = 0, y = 455, stiffness_n_per_mm = 0.4 },\n\
    { x = 0, y = 45.6, stiffness_n_per_mm = 0.4 },\n\
    { x = 30, y = 250, stiffness_n_per_mm = 0.4 },\n]";
const FRICTION: &str = "[friction]\nstatic = 0.46\ndynamic = 0.44\n";
const DRAGGED: &str =
    "[friction]\nstatic = 0.46\ndynamic = 0.44\n[deformation]\nmax_tangential_mm = 20\n";
const ROUGH: &str = "[friction]\nstatic = 0.46\ndynamic = 0.44\n[[dysfunction]]\nkind = \"skin_drag\"\n\
    at_mm = [30, 250]\nradius_mm = [90, 90]\n";
const TENDER: &str = "[[dysfunction]]\nkind = \"tender\"\nat_mm = [30, 250]\n";
const NOT_TENDER: &str = "[[dysfunction]]\nkind = \"tender\"\nat_mm = [30, 250]\nseverity = 0\n";
const BONES: &str = "[bones]\nbuiltin = \"back\"\n";
const ELLIPSES: &str = "[ellipse]\nbasic_radius_mm = 140\nkey = [\n\
    { name = \"A\", x = 0, y = 250, half_major_mm = 150, half_minor_mm = 60, angle_deg = 90 },\n\
    { name = \"B\", x = 60, y = 250, half_major_mm = 120, half_minor_mm = 80, angle_deg = 60 },\n]\n";

/// A scene to be edited, with everything that edits may change.
pub const EDITED: Tables = Tables(
    VARIED,
    "[friction]\nstatic = 0.46\ndynamic = 0.44\n[bones]\nbuiltin = \"back\"\n[ellipse]\nbasic_radius_mm = 140\nkey = [\n\
     { name = \"A\", x = 0, y = 250, half_major_mm = 150, half_minor_mm = 60, angle_deg = 90 },\n]\n",
);
/// Another one.
pub const OTHER: Tables = Tables(UNIFORM, "[force]\nmodel = \"nonlinear\"\n");
/// Nothing that can be done without.
pub const PLAIN: Tables = Tables(UNIFORM, "");

const fn felt(item: Item, with: Tables, left_out: Option<Tables>) -> Part {
    Part {
        item,
        of: Of::Tick,
        with,
        beside: (PLAIN, false),
        left_out: match left_out {
            Some(tables) => Some([tables, PLAIN]),
            None => None,
        },
        idle: Finger::Aloft,
    }
}

/// Every part of the core that a scene may do without, in the order of the ledger.
pub const PARTS: [Part; 13] = [
    felt(
        Item::StiffnessField,
        Tables(VARIED, ""),
        Some(Tables(ONE_VALUE, "")),
    ),
    Part {
        item: Item::EllipseField,
        of: Of::Frame,
        with: Tables(UNIFORM, ELLIPSES),
        beside: (PLAIN, true),
        left_out: Some([Tables(UNIFORM, ELLIPSES), PLAIN]),
        idle: Finger::Aloft,
    },
    felt(Item::Friction, Tables(UNIFORM, FRICTION), None),
    Part {
        beside: (Tables(UNIFORM, FRICTION), false),
        ..felt(Item::SkinDrag, Tables(UNIFORM, ROUGH), None)
    },
    felt(
        Item::Tenderness,
        Tables(UNIFORM, TENDER),
        Some(Tables(UNIFORM, NOT_TENDER)),
    ),
    felt(
        Item::Published,
        Tables(UNIFORM, "[contact]\nengine = \"published\"\n"),
        Some(Tables(UNIFORM, "[contact]\nengine = \"production\"\n")),
    ),
    felt(
        Item::ForceModel,
        Tables(UNIFORM, "[force]\nmodel = \"hunt-crossley\"\n"),
        Some(Tables(UNIFORM, "[force]\nmodel = \"linear\"\n")),
    ),
    felt(
        Item::FingerPad,
        Tables(UNIFORM, "[contact]\nfinger_radius_mm = 6\n"),
        Some(Tables(UNIFORM, "[contact]\nfinger_radius_mm = 0\n")),
    ),
    felt(
        Item::ForceShading,
        Tables(UNIFORM, "[contact]\nshading = \"normals\"\n"),
        Some(Tables(UNIFORM, "[contact]\nshading = \"none\"\n")),
    ),
    Part {
        item: Item::Deformation,
        of: Of::Frame,
        with: PLAIN,
        beside: (PLAIN, false),
        left_out: None,
        idle: Finger::Aloft,
    },
    Part {
        item: Item::TangentialField,
        of: Of::Frame,
        with: Tables(UNIFORM, FRICTION),
        beside: (PLAIN, true),
        left_out: Some([Tables(UNIFORM, DRAGGED), Tables(UNIFORM, FRICTION)]),
        idle: Finger::Straight,
    },
    Part {
        item: Item::Bones,
        of: Of::Frame,
        with: Tables(UNIFORM, BONES),
        beside: (PLAIN, true),
        left_out: Some([Tables(UNIFORM, BONES), PLAIN]),
        idle: Finger::Aloft,
    },
    Part {
        item: Item::Recorder,
        of: Of::Record,
        with: PLAIN,
        beside: (PLAIN, false),
        left_out: None,
        idle: Finger::Aloft,
    },
];

impl Part {
    /// What in the scene makes it needed, or who.
    pub fn made_by(&self) -> &'static str {
        match self.item {
            Item::StiffnessField => "[stiffness] key",
            Item::EllipseField => "[ellipse] key, skin drawn",
            Item::Friction => "[friction]",
            Item::SkinDrag | Item::Tenderness => "[[dysfunction]]",
            Item::Published => "[contact] engine",
            Item::ForceModel => "[force] model",
            Item::FingerPad => "[contact] finger_radius_mm",
            Item::ForceShading => "[contact] shading",
            Item::Deformation => "skin drawn",
            Item::TangentialField => "[friction], skin drawn",
            Item::Bones => "[bones], skin drawn",
            Item::Recorder => "recording",
            _ => "",
        }
    }
}

impl Tables {
    /// The scenario on the built-in back of so many triangles.
    pub fn on_back(self, triangles: usize) -> String {
        let Self(stiffness, others) = self;
        format!(
            "format = 1\nname = \"Counted\"\n[surface]\nbuiltin = \"back\"\ntriangles = {triangles}\n\
             [stiffness]\n{stiffness}\n{others}"
        )
    }
}
