//! Two numbers at a time, which the compiler keeps in one register on every machine.

use std::ops::{Add, Div, Mul, Sub};

/// A number for each of two vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair(pub [f64; 2]);

impl Add for Pair {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1]])
    }
}

impl Sub for Pair {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self([self.0[0] - other.0[0], self.0[1] - other.0[1]])
    }
}

impl Mul for Pair {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self([self.0[0] * other.0[0], self.0[1] * other.0[1]])
    }
}

impl Div for Pair {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self([self.0[0] / other.0[0], self.0[1] / other.0[1]])
    }
}

impl Pair {
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self([self.0[0].sqrt(), self.0[1].sqrt()])
    }

    /// From a row.
    #[inline(always)]
    pub fn of(row: &[f64; 64], i: usize) -> Self {
        Self([row[i], row[i + 1]])
    }

    /// Into a row.
    #[inline(always)]
    pub fn put(self, row: &mut [f64; 64], i: usize) {
        row[i] = self.0[0];
        row[i + 1] = self.0[1];
    }
}
