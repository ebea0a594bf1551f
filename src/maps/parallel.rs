//! One value for every vertex, by several threads, the same bits for any number of them.

use crate::geom::Vec3;
use std::sync::{Mutex, PoisonError};

/// Vertices a thread takes at a time: half a millisecond of work or more, against tens of µs for starting a thread.
const PART: usize = 2048;

/// Sets every value from its position. `reader` makes what a thread reads with; what it answers must depend on the position
/// alone.
pub(super) fn fill<T: Send, R: FnMut(Vec3) -> T>(
    values: &mut [T],
    positions: &[Vec3],
    reader: impl Fn() -> R + Sync,
) {
    let n_helpers = std::thread::available_parallelism()
        .map_or(1, usize::from)
        .min(positions.len().div_ceil(PART))
        .saturating_sub(1);
    let parts = Mutex::new(values.chunks_mut(PART).zip(positions.chunks(PART)));
    let work = || {
        let mut read = reader();
        loop {
            let part = parts.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some((values, positions)) = part else {
                return;
            };
            for (value, p) in values.iter_mut().zip(positions) {
                *value = read(*p);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..n_helpers {
            // A helper that cannot be had is done without.
            let builder = std::thread::Builder::new().name("map".into());
            let _ = builder.spawn_scoped(scope, work);
        }
        work();
    });
}
