//! The plotted past, in bounded memory.

/// What was felt, per finger, over the last hour and more.
#[derive(Clone, Debug, Default)]
pub struct History {}
