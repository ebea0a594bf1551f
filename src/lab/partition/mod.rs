//! Space partitions (Ji 2008, chapter 3): what they cost, what they hold, what they lose.

mod completeness;
mod complexity;
mod shared;
mod threshold;

pub use completeness::Completeness;
pub use complexity::Complexity;
pub use threshold::Threshold;
