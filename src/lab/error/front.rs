//! What nothing else beats in both cost and error, and what follows from that.

use crate::figure::{LinePlot, Mark, Scale, Series};

/// A measured setting as a point: lower is better on both axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub cost: f64,
    pub error: f64,
}

impl Point {
    fn is_sound(self) -> bool {
        self.cost.is_finite() && self.error.is_finite()
    }

    fn beats(self, other: Self) -> bool {
        let no_worse = self.cost <= other.cost && self.error <= other.error;
        no_worse && (self.cost < other.cost || self.error < other.error)
    }
}

/// Which points are on the Pareto front.
pub fn on_front(points: &[Point]) -> Vec<bool> {
    let beaten = |p: &Point| points.iter().any(|q| q.is_sound() && q.beats(*p));
    points.iter().map(|p| p.is_sound() && !beaten(p)).collect()
}

/// The cheapest of those whose `worst` error is at most `within`.
pub fn cheapest(points: &[Point], worst: &[f64], within: f64) -> Option<usize> {
    let good = (0..points.len()).filter(|&i| points[i].is_sound() && worst[i] <= within);
    good.min_by(|&a, &b| points[a].cost.total_cmp(&points[b].cost))
}

/// Decades between the least and the greatest cost.
pub fn decades(points: &[Point]) -> f64 {
    let costs = || {
        points
            .iter()
            .map(|p| p.cost)
            .filter(|c| c.is_finite() && *c > 0.0)
    };
    let (least, most) = (
        costs().fold(f64::INFINITY, f64::min),
        costs().fold(0.0, f64::max),
    );
    if most > 0.0 {
        libm::log10(most / least)
    } else {
        0.0
    }
}

/// Error over cost, both logarithmic, a colour for each family, the front as a line.
pub fn plot(
    title: &str,
    [x_label, y_label]: [&str; 2],
    families: &[(&str, [u8; 3])],
    rows: &[(&str, Point)],
    least_error: f64,
) -> LinePlot {
    let place = |p: &Point| [p.cost, p.error.max(least_error)];
    let points: Vec<Point> = rows.iter().map(|(_, p)| *p).collect();
    let front = on_front(&points);
    let mut points: Vec<[f64; 2]> = points
        .iter()
        .zip(front)
        .filter(|(_, on)| *on)
        .map(|(p, _)| place(p))
        .collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // At the bottom, so that the dots on it keep their colours.
    let mut series = vec![Series {
        name: "Pareto front".to_owned(),
        colour: [24, 26, 30],
        mark: Mark::Dashed,
        points,
    }];
    for (name, colour) in families {
        let of = rows
            .iter()
            .filter(|(family, p)| family == name && p.is_sound());
        let points: Vec<[f64; 2]> = of.map(|(_, p)| place(p)).collect();
        if !points.is_empty() {
            series.push(Series {
                name: (*name).to_owned(),
                colour: *colour,
                mark: Mark::Points,
                points,
            });
        }
    }
    LinePlot {
        title: title.to_owned(),
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        x_scale: Scale::Logarithmic,
        y_scale: Scale::Logarithmic,
        series,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(cost: f64, error: f64) -> Point {
        Point { cost, error }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [
            at(1.0, 9.0),
            at(2.0, 5.0),
            at(2.0, 6.0),
            at(3.0, 5.0),
            at(4.0, 1.0),
            at(0.5, f64::INFINITY),
            at(f64::NAN, 0.0),
            at(4.0, 1.0),
        ];
        let on = [true, true, false, false, true, false, false, true];
        assert_eq!(on_front(&points), on);
        let worst = [9.0, 7.0, 6.0, 5.0, 1.0, 0.0, 0.0, 1.0];
        assert_eq!(cheapest(&points, &worst, 6.0), Some(2));
        assert_eq!(cheapest(&points, &worst, 0.5), None);
        assert!((decades(&points) - 8.0_f64.log10()).abs() < 1e-12);
        assert_eq!(decades(&[]), 0.0);
    }
}
