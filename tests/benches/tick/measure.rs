//! Timing single calls, and rows of figures.

use std::time::{Duration, Instant};

/// What a call takes, µs.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub p50: f64,
    pub p99: f64,
    pub max: f64,
}

impl Cost {
    /// From single calls in ns, less what reading the clock takes.
    pub fn of(mut ns: Vec<u64>, clock_ns: f64) -> Self {
        ns.sort_unstable();
        let us = |i: usize| (ns[i] as f64 - clock_ns).max(0.0) / 1000.0;
        Self {
            p50: us(ns.len() / 2),
            p99: us(ns.len() * 99 / 100),
            max: us(ns.len() - 1),
        }
    }

    /// Median and 99th percentile.
    pub fn short(&self) -> String {
        let digits = |us: f64| match us {
            us if us < 10.0 => format!("{us:.2}"),
            us if us < 1000.0 => format!("{us:.1}"),
            us => format!("{us:.0}"),
        };
        format!("{} / {}", digits(self.p50), digits(self.p99))
    }
}

/// Times `call` on every `step`-th of `inputs`, for no longer than `at_most`.
pub fn each<T>(
    inputs: impl Iterator<Item = T>,
    step: usize,
    at_most: Duration,
    clock_ns: f64,
    mut call: impl FnMut(T),
) -> Cost {
    let begun = Instant::now();
    let mut ns = Vec::new();
    for input in inputs.step_by(step) {
        let start = Instant::now();
        call(input);
        ns.push(start.elapsed().as_nanos() as u64);
        if begun.elapsed() > at_most {
            break;
        }
    }
    Cost::of(ns, clock_ns)
}

/// Median of reading the clock twice, ns.
pub fn clock_cost_ns() -> f64 {
    let mut ns: Vec<u64> = (0..100_000)
        .map(|_| Instant::now().elapsed().as_nanos() as u64)
        .collect();
    ns.sort_unstable();
    ns[ns.len() / 2] as f64
}

/// How long `make` takes, ms, and what it makes.
pub fn timed_ms<T>(make: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let made = make();
    (start.elapsed().as_secs_f64() * 1e3, made)
}

/// Columns with their headings; a negative width puts text to the left.
pub struct Table(Vec<(&'static str, i32)>);

impl Table {
    pub fn new(columns: &[(&'static str, i32)]) -> Self {
        Self(columns.to_vec())
    }

    pub fn head(&self) {
        let names: Vec<String> = self.0.iter().map(|c| c.0.to_string()).collect();
        self.row(&names);
    }

    pub fn row(&self, cells: &[String]) {
        let cells = self.0.iter().zip(cells).map(|((_, width), cell)| {
            let n = width.unsigned_abs() as usize;
            if *width < 0 {
                format!("{cell:<n$}")
            } else {
                format!("{cell:>n$}")
            }
        });
        println!("{}", cells.collect::<Vec<_>>().join(" "));
    }
}
