//! Space partitions (Ji 2008, chapter 3): what they cost, what they hold, what they lose.

mod box_size;
mod completeness;
mod complexity;
mod passes;
mod printed;
mod shared;
mod threshold;

pub use box_size::BoxSize;
pub use completeness::Completeness;
pub use complexity::Complexity;
pub use passes::Passes;
pub use threshold::Threshold;
