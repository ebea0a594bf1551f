//! What a scene leaves out costs nothing, and what it does not leave out costs what the ledger says: counted.
//!
//! The heap is counted by the program's allocator ([`Heap`]), instructions by stepping a child process. Both happen in a
//! process of their own ([`Case`]), where nothing else allocates; what they give is the same each time.

mod case;
mod heap;
mod live;
mod parts;
pub mod scenes;
mod slider;
mod steps;

pub use case::{Case, Counts, Finger, Of};
pub use heap::{Heap, calls, grown};
pub use live::Live;
pub use parts::Parts;
pub use steps::{Counted, SUBCOMMAND, Uncounted, count, counted_by, serve};
