//! How stiff a skin may be before the loop no longer rests: search, and the same search for many loops at once.

use super::closed_loop::{Bench, Class, Loop, Outcome};
use serde::{Deserialize, Serialize};
use std::num::NonZero;
use std::ops::AddAssign;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{available_parallelism, scope};

/// Stiffnesses that are looked at, N/mm.
pub const RANGE_N_PER_MM: [f64; 2] = [0.01, 1.0e4];

/// How finely a border is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Fineness {
    /// From one stiffness to the next on the way up, a factor.
    pub stride: f64,
    /// The border is known to this factor.
    pub resolution: f64,
}

/// What was counted over many ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Ticks of the servo.
    pub ticks: u64,
    /// Those whose record or motion was not finite.
    pub not_finite: u64,
    /// Those whose force was above the limit, or pulled.
    pub over_limit: u64,
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.ticks += other.ticks;
        self.not_finite += other.not_finite;
        self.over_limit += other.over_limit;
    }
}

impl From<&Outcome> for Tally {
    fn from(outcome: &Outcome) -> Self {
        Self {
            ticks: outcome.ticks,
            not_finite: outcome.not_finite,
            over_limit: outcome.over_limit,
        }
    }
}

/// The stiffest skin on which a loop rests.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Border {
    /// Its stiffness, N/mm; none where it rests on all of [`RANGE_N_PER_MM`].
    pub stiffness_n_per_mm: Option<f64>,
    /// What the search took.
    pub tally: Tally,
}

/// Goes up from the softest skin to the first on which `rests` says no, then halves. `rests` also tells what it counted.
pub fn border(fineness: Fineness, mut rests: impl FnMut(f64) -> (bool, Tally)) -> Border {
    let mut tally = Tally::default();
    let mut ask = |k: f64| {
        let (rests, counted) = rests(k);
        tally += counted;
        rests
    };
    let [mut good, top] = RANGE_N_PER_MM;
    let mut bad = good * fineness.stride;
    while ask(bad) {
        good = bad;
        bad *= fineness.stride;
        if bad > top {
            return Border {
                stiffness_n_per_mm: None,
                tally,
            };
        }
    }
    while bad / good > fineness.resolution {
        let middle = libm::sqrt(good * bad);
        if ask(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Border {
        stiffness_n_per_mm: Some(good),
        tally,
    }
}

/// The border of taps: `at` makes the loop for a stiffness.
pub fn tap_border(bench: &Bench, fineness: Fineness, at: impl Fn(f64) -> Loop) -> Border {
    border(fineness, |k| {
        let outcome = bench.tap(&at(k));
        (outcome.class == Class::Stable, Tally::from(&outcome))
    })
}

/// The border of presses, where the loop is linear.
pub fn press_border(bench: &Bench, fineness: Fineness, at: impl Fn(f64) -> Loop) -> Border {
    border(fineness, |k| {
        let (rests, ticks) = bench.press(&at(k));
        let tally = Tally {
            ticks,
            ..Tally::default()
        };
        (rests, tally)
    })
}

/// What `work` makes of each item, in their order, on all processors. The same whatever their number.
pub fn on_all_processors<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let some = || {
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            match items.get(i) {
                Some(item) => done.push((i, work(item))),
                None => return done,
            }
        }
    };
    let n = available_parallelism().map_or(1, NonZero::get);
    let mut done: Vec<(usize, R)> = scope(|s| {
        let others: Vec<_> = (1..n.min(items.len())).map(|_| s.spawn(some)).collect();
        let mut done = some();
        for other in others {
            match other.join() {
                Ok(more) => done.extend(more),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        done
    });
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, r)| r).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_border_is_found_to_its_resolution() {
        let fineness = Fineness {
            stride: 2.0,
            resolution: 1.01,
        };
        for wanted in [0.03, 0.5, 77.0] {
            let found = border(fineness, |k| (k <= wanted, Tally::default()));
            let k = found.stiffness_n_per_mm.expect("a border");
            assert!(k <= wanted && wanted <= k * 1.01, "{k}");
        }
        let none = border(fineness, |_| (true, Tally::default()));
        assert_eq!(none.stiffness_n_per_mm, None);
    }

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..500).collect();
        let squares = on_all_processors(&items, |i| i * i);
        assert_eq!(squares, items.iter().map(|i| i * i).collect::<Vec<_>>());
        assert!(on_all_processors(&[0_u8; 0], |_| ()).is_empty());
    }
}
