//! Which vertices a dent moves: ring by ring over adjacency (Ji 2008, 4.5).

/// Scratch memory of the search, reused from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct RingSearch {}
