//! What the heap holds, counted by the allocator of the program.

use serde::{Deserialize, Serialize};
use stats_alloc::INSTRUMENTED_SYSTEM;
use std::hint::black_box;

/// The heap at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heap {
    /// Bytes allocated and not freed, as asked for: what the system rounds up to is its own.
    pub held: i64,
    /// Times something was allocated, made larger or freed.
    pub calls: u64,
}

impl Heap {
    /// The heap of this process now; `None` where the allocator does not count.
    pub fn now() -> Option<Self> {
        let before = INSTRUMENTED_SYSTEM.stats();
        drop(black_box(Box::new(0_u8)));
        if INSTRUMENTED_SYSTEM.stats().allocations == before.allocations {
            return None;
        }
        Some(Self {
            held: before.bytes_allocated as i64 - before.bytes_deallocated as i64,
            calls: (before.allocations + before.deallocations + before.reallocations) as u64,
        })
    }
}

/// What grew between two looks at the heap; `None` where nothing counts.
pub fn grown(before: Option<Heap>, after: Option<Heap>) -> Option<i64> {
    Some(after?.held - before?.held)
}

/// How often something was allocated or freed between two looks; `None` where nothing counts.
pub fn calls(before: Option<Heap>, after: Option<Heap>) -> Option<u64> {
    // Looking at it takes two.
    Some((after?.calls - before?.calls).saturating_sub(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_counting_allocator_nothing_is_told() {
        // The library's own tests run on the system's allocator.
        assert_eq!(Heap::now(), None);
        assert_eq!((grown(None, None), calls(None, None)), (None, None));
    }
}
