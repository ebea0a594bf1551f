//! Two recordings beside each other: aligned, and how far they are apart over time.
//!
//! | part | answers |
//! |---|---|
//! | [`Align`] | what of the one goes with what of the other: by time, by an event, by warping |
//! | [`Comparison`] | how far they are apart, tick by tick, and how well they agree |
//! | [`Trace`] | one finger resampled, for warping and for drawing |

mod align;
mod difference;
pub mod dtw;
#[cfg(test)]
mod tests;
mod trace;

pub use align::{Align, Anchor};
pub use difference::{CompareOptions, Comparison, Series, Spread, compare};
pub use dtw::{Warp, warp};
pub use trace::{MOST_SAMPLES, TRACE_HZ, Trace, traces};
