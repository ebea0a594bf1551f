//! What a scene requires, and the ledger that tells it.

/// What is going on beside the scene itself: it decides what else must exist.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Use {
    /// Fingers that palpate.
    pub fingers: usize,
    /// A Back view is open: graphics mesh and deformation are drawn.
    pub drawn: bool,
    /// Deformation is computed though nothing is drawn (pictures, exports).
    pub deformed: bool,
    /// A recorder writes.
    pub recorded: bool,
    /// A plot panel is open.
    pub plotted: bool,
}

/// A part that a scene may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Item {
    /// The haptic surface with its adjacency.
    Surface,
    /// The production search structure.
    Search,
    /// Stiffness per vertex; a uniform stiffness needs none.
    StiffnessField,
    /// Friction: anchor and slip.
    Friction,
    /// Per-vertex displacement and normals of the drawn skin.
    Deformation,
    /// Its tangential half.
    TangentialField,
    /// Vertex buffers for the window.
    GraphicsMesh,
    /// Plot history.
    PlotHistory,
    /// The recorder's writer.
    Recorder,
}

/// Which parts are required.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// Each required part with whom it is needed by, in the order of [`Item`].
    pub required: Vec<(Item, &'static str)>,
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
    /// Bytes it holds.
    pub bytes: usize,
    /// Cost, µs, with what it is paid per; `None` for what costs nothing by itself.
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
