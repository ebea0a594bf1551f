//! Space partitions (Ji 2008, chapter 3): what they cost, what they hold, what they lose.

mod complexity;

pub use complexity::Complexity;
