//! Colours that stand for numbers, and the quantities of the skin that can be shown by them.
//!
//! | file | answers |
//! |---|---|
//! | [`map`] | which colour stands for a share of the range |
//! | [`range`] | which values a legend spans, and the numbers beside it |

pub mod map;
pub mod range;
