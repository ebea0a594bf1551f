//! What the user chose of a tree under study.

use crate::geom::Vec3;
use crate::partition::hdb;
use crate::partition::tree::{Case, Options};

/// Fewest and most triangles that a leaf can be chosen to hold.
pub const THRESHOLDS: std::ops::RangeInclusive<usize> = 16..=8192;
/// Smallest and largest part of the longest edge that the box can be chosen to have.
pub const EDGE_PARTS: std::ops::RangeInclusive<f64> = 0.01..=1.0;

/// Which tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Binary space partition.
    Bsp,
    /// Octree with a list for each leaf.
    Octree,
    /// Octree over one list.
    Hybrid,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Bsp, Self::Octree, Self::Hybrid];

    /// Its name as a [`Structure`](crate::partition::Structure).
    pub fn name(self) -> &'static str {
        match self {
            Self::Bsp => "bsp",
            Self::Octree => "octree",
            Self::Hybrid => "hybrid",
        }
    }

    /// Whether it knows cases of triangles on a plane.
    pub fn has_cases(self) -> bool {
        self == Self::Bsp
    }
}

/// Which tree, and how it is grown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Which tree.
    pub kind: Kind,
    /// What becomes of a triangle on a plane, where the tree knows cases.
    pub case: Case,
    /// Most triangles in a leaf.
    pub threshold: usize,
}

impl Default for Choice {
    /// As published.
    fn default() -> Self {
        let published = Options::default();
        Self {
            kind: Kind::Bsp,
            case: published.case,
            threshold: published.threshold,
        }
    }
}

impl Choice {
    /// The choice that counts: octrees know case C only.
    pub fn effective(self) -> Self {
        let case = if self.kind.has_cases() {
            self.case
        } else {
            Case::C
        };
        Self { case, ..self }
    }

    /// As the partition takes it.
    pub fn options(self) -> Options {
        Options {
            threshold: self.threshold,
            case: self.effective().case,
        }
    }
}

/// Where the middle of the box is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// At the proxy of this finger, also in a recording.
    Finger(usize),
    /// Where it was set by hand.
    Fixed,
}

/// Which query is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// Every triangle whose box overlaps the box: none is lost.
    Complete,
    /// Whole leaves, as published.
    Published,
}

/// Which nodes are drawn as boxes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Boxes {
    /// The nodes of the level, and leaves above it.
    All,
    /// Leaves down to the level.
    Leaves,
    /// Leaves down to the level that hold triangles.
    FullLeaves,
}

/// What is laid over the skin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Show {
    /// The deepest level drawn; anything beyond the tree's height is all of it.
    pub level: u32,
    /// Which nodes.
    pub boxes: Boxes,
    /// Nodes as wire boxes.
    pub wire: bool,
    /// The loose bounds of nodes instead of their cells.
    pub loose: bool,
    /// Split planes.
    pub planes: bool,
    /// What the box gathers.
    pub haptic: bool,
    /// The haptic detecting box.
    pub hdb: bool,
    /// The skin, in the panel's own picture.
    pub skin: bool,
    /// The same in the Back view.
    pub in_back_view: bool,
}

/// All of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which tree.
    pub choice: Choice,
    /// Edge of the box over the longest edge of the surface's box.
    pub edge_part: f64,
    /// Where the box is.
    pub follow: Follow,
    /// Where it was set by hand, mm.
    pub fixed_mm: Vec3,
    /// Which query is drawn.
    pub query: Query,
    /// What is drawn.
    pub show: Show,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            choice: Choice::default(),
            edge_part: hdb::EDGE_PART,
            follow: Follow::Finger(0),
            fixed_mm: Vec3::ZERO,
            query: Query::Complete,
            show: Show {
                level: u32::MAX,
                boxes: Boxes::FullLeaves,
                wire: true,
                loose: false,
                planes: true,
                haptic: true,
                hdb: true,
                skin: true,
                in_back_view: false,
            },
        }
    }
}
