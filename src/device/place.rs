//! A place that one thread sets and the servo reads, without a lock.

use crate::geom::Vec3;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Farthest place that can be set, mm.
pub(super) const FAR_MM: f64 = 1.0e7;

/// A place, mm. Cheap to clone; all clones are the same place. Any thread may set it; whoever reads gets the newest, whole.
#[derive(Clone, Debug, Default)]
pub struct Place {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    /// Even when the words are whole, odd while they are being written.
    version: AtomicU64,
    words: [AtomicU64; 3],
}

impl Place {
    /// A place at `at_mm`, as [`Place::set`] takes it.
    pub fn at(at_mm: Vec3) -> Self {
        let place = Self::default();
        place.set(at_mm);
        place
    }

    /// Sets it. A place that is not finite is ignored, one beyond 10 km brought back to there.
    pub fn set(&self, at_mm: Vec3) {
        if !at_mm.is_finite() {
            return;
        }
        let at_mm = at_mm.clamp(Vec3::splat(-FAR_MM), Vec3::splat(FAR_MM));
        let s = &self.shared;
        // One writer at a time: take the odd version or wait for the other thread, which holds it for nanoseconds.
        let version = loop {
            let v = s.version.load(Ordering::Relaxed) & !1;
            if s.version
                .compare_exchange(v, v + 1, Ordering::Acquire, Ordering::Relaxed)
                .is_ok()
            {
                break v;
            }
            std::hint::spin_loop();
        };
        for (word, x) in s.words.iter().zip(at_mm.to_array()) {
            word.store(x.to_bits(), Ordering::SeqCst);
        }
        s.version.store(version + 2, Ordering::Release);
    }

    /// The last place set; the origin before the first.
    pub fn get(&self) -> Vec3 {
        loop {
            if let Some(at_mm) = self.try_get() {
                return at_mm;
            }
            std::hint::spin_loop();
        }
    }

    /// The last place set, or `None` while another thread is writing it: for who must not wait.
    pub fn try_get(&self) -> Option<Vec3> {
        let s = &self.shared;
        let before = s.version.load(Ordering::Acquire);
        let words = [0, 1, 2].map(|i| f64::from_bits(s.words[i].load(Ordering::SeqCst)));
        let after = s.version.load(Ordering::SeqCst);
        (before == after && before & 1 == 0).then(|| Vec3::from_array(words))
    }
}
