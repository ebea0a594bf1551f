//! One number per vertex, which colours the skin: rounded to `f32`, with a list of what changed.

use std::sync::atomic::{AtomicU64, Ordering};

/// What is written for a number that is none, or too large for `f32`: no such value reaches a shader.
const NO_NUMBER: f32 = 0.0;

/// A quantity over the vertices of one skin.
#[derive(Debug)]
pub struct Values {
    id: u64,
    held: Held,
    /// Smallest and largest value ever written.
    range: Option<[f64; 2]>,
    pub(super) changed: Vec<u32>,
}

#[derive(Debug)]
pub(super) enum Held {
    /// The same everywhere: nothing is held per vertex, here or on the graphics card.
    Same(f32),
    /// One per vertex.
    Each(Vec<f32>),
}

fn next_id() -> u64 {
    static NEXT_ID: AtomicU64 = AtomicU64::new(1);
    NEXT_ID.fetch_add(1, Ordering::Relaxed)
}

fn rounded(value: f64) -> f32 {
    let x = value as f32;
    if x.is_finite() { x } else { NO_NUMBER }
}

impl Values {
    /// One value for all vertices.
    pub fn same(value: f64) -> Self {
        let x = rounded(value);
        Self {
            id: next_id(),
            held: Held::Same(x),
            range: Some([f64::from(x); 2]),
            changed: Vec::new(),
        }
    }

    /// The value of each of `n` vertices.
    pub fn each(n: usize, value: impl Fn(u32) -> f64) -> Self {
        let held: Vec<f32> = (0..n as u32).map(|v| rounded(value(v))).collect();
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for &x in &held {
            (low, high) = (low.min(x), high.max(x));
        }
        Self {
            id: next_id(),
            held: Held::Each(held),
            range: (low <= high).then(|| [f64::from(low), f64::from(high)]),
            changed: Vec::new(),
        }
    }

    /// Writes the value of one vertex, to be uploaded with the next picture. A vertex that is not there, and values that are
    /// the same everywhere, stay as they are.
    pub fn set(&mut self, vertex: u32, value: f64) {
        let Held::Each(held) = &mut self.held else {
            return;
        };
        let Some(place) = held.get_mut(vertex as usize) else {
            return;
        };
        let x = rounded(value);
        if *place != x {
            *place = x;
            self.changed.push(vertex);
            let x = f64::from(x);
            let [low, high] = self.range.unwrap_or([x, x]);
            self.range = Some([low.min(x), high.max(x)]);
        }
    }

    /// The value of a vertex; `None` for one that is not there.
    pub fn at(&self, vertex: u32) -> Option<f64> {
        match &self.held {
            Held::Same(x) => Some(f64::from(*x)),
            Held::Each(held) => held.get(vertex as usize).map(|x| f64::from(*x)),
        }
    }

    /// Smallest and largest value written so far; `None` of no vertex.
    pub fn range(&self) -> Option<[f64; 2]> {
        self.range
    }

    /// Memory held, bytes; the graphics card holds a number per vertex as well.
    pub fn bytes(&self) -> usize {
        let held = match &self.held {
            Held::Same(_) => 0,
            Held::Each(held) => size_of_val(&held[..]),
        };
        held + self.changed.capacity() * size_of::<u32>()
    }

    /// Tells two fields apart.
    pub(super) fn id(&self) -> u64 {
        self.id
    }

    pub(super) fn held(&self) -> &Held {
        &self.held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_never_held() {
        let odd = [f64::NAN, f64::INFINITY, -1e300, 2.5];
        let mut values = Values::each(4, |v| odd[v as usize]);
        assert_eq!(values.at(3), Some(2.5));
        for v in 0..3 {
            assert_eq!(values.at(v), Some(0.0));
        }
        values.set(3, f64::NAN);
        assert_eq!(values.at(3), Some(0.0));
        assert_eq!(Values::same(f64::NAN).at(9), Some(0.0));
        assert_eq!(values.range(), Some([0.0, 2.5]));
    }

    #[test]
    fn one_value_for_all_takes_no_memory_and_a_write_of_the_same_is_no_change() {
        let mut same = Values::same(0.5);
        same.set(0, 3.0);
        assert_eq!((same.bytes(), same.at(7)), (0, Some(0.5)));
        let mut each = Values::each(3, |_| 1.0);
        each.set(1, 1.0);
        assert!(each.changed.is_empty());
        each.set(1, 4.0);
        each.set(9, 4.0);
        assert_eq!(each.changed, [1]);
        assert_eq!(each.range(), Some([1.0, 4.0]));
        assert_eq!(Values::each(0, |_| 1.0).range(), None);
    }
}
