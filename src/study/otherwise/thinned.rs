//! A series of any length in bounded memory, for plots: nothing that stands out is lost.

/// Most boxes that a series is held in.
pub const MOST_BOXES: usize = 2000;

/// A series in at most [`MOST_BOXES`] boxes of equally many values: of each box the least and the greatest are kept, with their
/// times. Where the boxes are used up, each two become one.
#[derive(Clone, Debug, PartialEq)]
pub struct Thinned {
    boxes: Vec<Extremes>,
    /// Values of a full box.
    per_box: u64,
    /// Values in the last box.
    in_last: u64,
}

/// Least and greatest of some values: time, s, and value.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extremes {
    least: [f64; 2],
    greatest: [f64; 2],
}

impl Extremes {
    fn with(self, other: Self) -> Self {
        Self {
            least: match other.least[1] < self.least[1] {
                true => other.least,
                false => self.least,
            },
            greatest: match other.greatest[1] > self.greatest[1] {
                true => other.greatest,
                false => self.greatest,
            },
        }
    }
}

impl Default for Thinned {
    fn default() -> Self {
        Self {
            boxes: Vec::new(),
            per_box: 1,
            in_last: 0,
        }
    }
}

impl Thinned {
    /// Takes in a value; times rise. What is not finite is left out.
    pub fn add(&mut self, time_s: f64, value: f64) {
        if !(time_s.is_finite() && value.is_finite()) {
            return;
        }
        let point = [time_s, value];
        let alone = Extremes {
            least: point,
            greatest: point,
        };
        match self.boxes.last_mut() {
            Some(last) if self.in_last < self.per_box => {
                *last = last.with(alone);
                self.in_last += 1;
            }
            _ => {
                if self.boxes.len() == MOST_BOXES {
                    self.halve();
                }
                self.boxes.push(alone);
                self.in_last = 1;
            }
        }
    }

    /// Makes one of each two boxes; all are full.
    fn halve(&mut self) {
        self.boxes = self
            .boxes
            .chunks(2)
            .map(|pair| pair.iter().copied().reduce(Extremes::with))
            .map_while(|both| both)
            .collect();
        self.per_box *= 2;
    }

    /// Times, s, and values in the order of time: at most two a box.
    pub fn points(&self) -> Vec<[f64; 2]> {
        let mut points = Vec::with_capacity(2 * self.boxes.len());
        for Extremes { least, greatest } in &self.boxes {
            let (first, second) = match least[0] <= greatest[0] {
                true => (least, greatest),
                false => (greatest, least),
            };
            points.push(*first);
            if first != second {
                points.push(*second);
            }
        }
        points
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.boxes.capacity() * size_of::<Extremes>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A signal with rare spikes.
    fn value(i: u64) -> f64 {
        let slow = libm::sin(i as f64 * 1e-3);
        match i % 7919 {
            17 => 40.0 + slow,
            4000 => -30.0 - slow,
            _ => slow,
        }
    }

    #[test]
    fn of_every_stretch_the_least_and_the_greatest_are_kept() {
        for n in [0_u64, 1, 2, 1999, 2000, 2001, 4001, 100_003] {
            let mut series = Thinned::default();
            for i in 0..n {
                series.add(i as f64, value(i));
            }
            let points = series.points();
            assert!(points.len() <= 2 * MOST_BOXES && points.is_sorted_by(|a, b| a[0] < b[0]));
            if n <= MOST_BOXES as u64 {
                assert_eq!(points.len() as u64, n);
            }
            // By brute force: each box of the final width holds the extremes of its values.
            let per = series.per_box as usize;
            let all: Vec<f64> = (0..n).map(value).collect();
            for (k, stretch) in all.chunks(per).enumerate() {
                let inside = |p: &&[f64; 2]| (k * per..(k + 1) * per).contains(&(p[0] as usize));
                let kept: Vec<f64> = points.iter().filter(inside).map(|p| p[1]).collect();
                let least = |v: &[f64]| v.iter().copied().fold(f64::INFINITY, f64::min);
                let greatest = |v: &[f64]| v.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(least(&kept), least(stretch));
                assert_eq!(greatest(&kept), greatest(stretch));
            }
            assert!(points.iter().all(|p| all[p[0] as usize] == p[1]));
        }
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let mut series = Thinned::default();
        series.add(0.0, f64::NAN);
        series.add(f64::INFINITY, 1.0);
        assert!(series.points().is_empty());
        series.add(1.0, 2.0);
        assert_eq!(series.points(), [[1.0, 2.0]]);
    }
}
