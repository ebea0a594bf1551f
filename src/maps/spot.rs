//! A place that differs from its surroundings: an ellipse on the map plane with a falloff from its centre to its rim.

use super::on_map;
use crate::geom::Vec2;
use crate::geom::curve::Curve;

/// An ellipse on the map plane with a falloff M(q): 1 at the centre, 0 from the rim on.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// Centre, mm.
    pub at_mm: Vec2,
    /// Half axes, mm: along `angle_rad`, and at right angles to it. Positive.
    pub half_axes_mm: [f64; 2],
    /// Direction of the first half axis, from x towards y, radians.
    pub angle_rad: f64,
    /// The falloff over q, the distance as a share of that to the rim.
    pub profile: Curve,
}

impl Spot {
    /// Distance of a place from the centre as a share of that to the rim, the same way: 1 on the rim. Infinite for a spot
    /// without extent or place.
    pub fn ratio(&self, place: Vec2) -> f64 {
        let (sin, cos) = (libm::sin(self.angle_rad), libm::cos(self.angle_rad));
        self.ratio_along(place, cos, sin)
    }

    fn ratio_along(&self, place: Vec2, cos: f64, sin: f64) -> f64 {
        let d = on_map(place) - self.at_mm;
        let u = (d.x * cos + d.y * sin) / self.half_axes_mm[0];
        let v = (d.y * cos - d.x * sin) / self.half_axes_mm[1];
        let q = libm::sqrt(u * u + v * v);
        if q.is_nan() { f64::INFINITY } else { q }
    }

    /// M(q) at a place.
    pub fn weight(&self, place: Vec2) -> f64 {
        self.profile.at(self.ratio(place))
    }

    /// Half the size of the smallest box around it, mm.
    pub fn reach_mm(&self) -> Vec2 {
        let [a, b] = self.half_axes_mm;
        let (sin, cos) = (libm::sin(self.angle_rad), libm::cos(self.angle_rad));
        Vec2::new(libm::hypot(a * cos, b * sin), libm::hypot(a * sin, b * cos))
    }

    /// The point at a share `q` of the way from the centre to the rim, in direction `turn` (radians) of the ellipse's own
    /// parameter.
    pub fn point(&self, q: f64, turn: f64) -> Vec2 {
        let [a, b] = self.half_axes_mm;
        let (u, v) = (a * q * libm::cos(turn), b * q * libm::sin(turn));
        let (sin, cos) = (libm::sin(self.angle_rad), libm::cos(self.angle_rad));
        self.at_mm + Vec2::new(u * cos - v * sin, u * sin + v * cos)
    }
}

/// A spot ready to be asked many times.
#[derive(Clone, Debug)]
pub struct SpotReader {
    spot: Spot,
    cos: f64,
    sin: f64,
    /// Bounds of all that it changes, mm.
    low: Vec2,
    high: Vec2,
}

impl SpotReader {
    /// Reads `spot`.
    pub fn new(spot: &Spot) -> Self {
        let reach = spot.reach_mm() * (1.0 + 1.0e-9);
        Self {
            cos: libm::cos(spot.angle_rad),
            sin: libm::sin(spot.angle_rad),
            low: spot.at_mm - reach,
            high: spot.at_mm + reach,
            spot: spot.clone(),
        }
    }

    /// As [`Spot::weight`], to the bit.
    pub fn weight(&self, place: Vec2) -> f64 {
        if place.cmplt(self.low).any() || place.cmpgt(self.high).any() {
            return 0.0;
        }
        let q = self.spot.ratio_along(place, self.cos, self.sin);
        self.spot.profile.at(q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spot(at: (f64, f64), axes: [f64; 2], angle_rad: f64) -> Spot {
        Spot {
            at_mm: at.into(),
            half_axes_mm: axes,
            angle_rad,
            profile: Curve::gaussian(),
        }
    }

    #[test]
    fn it_is_whole_at_the_centre_and_nothing_from_the_rim_on() {
        let s = spot((10.0, 20.0), [14.0, 9.0], 1.0);
        assert_eq!(s.weight(Vec2::new(10.0, 20.0)), 1.0);
        let along = Vec2::new(libm::cos(1.0), libm::sin(1.0));
        assert!((s.ratio(s.at_mm + along * 14.0) - 1.0).abs() < 1e-12);
        assert!((s.ratio(s.at_mm + along.perp() * 9.0) - 1.0).abs() < 1e-12);
        assert_eq!(s.weight(s.at_mm + along * 14.001), 0.0);
        let half = s.weight(s.at_mm + along.perp() * 4.5);
        assert!((half - Curve::gaussian().at(0.5)).abs() < 1e-12);
    }

    #[test]
    fn a_spot_without_extent_changes_nothing() {
        for axes in [[0.0, 0.0], [f64::NAN, 3.0]] {
            let s = spot((0.0, 0.0), axes, 0.0);
            assert_eq!(s.weight(Vec2::ZERO), 0.0);
        }
    }

    proptest! {
        #[test]
        fn placed_and_plain_agree_and_the_box_holds_all(
            a in 0.5..80.0, b in 0.5..80.0, angle in -7.0..7.0, x in -90.0..90.0, y in -90.0..90.0, q in 0.0..0.999,
            turn in 0.0..7.0
        ) {
            let s = spot((3.0, -4.0), [a, b], angle);
            let placed = SpotReader::new(&s);
            let place = Vec2::new(x, y);
            prop_assert_eq!(s.weight(place).to_bits(), placed.weight(place).to_bits());
            let inside = s.point(q, turn);
            prop_assert!((s.ratio(inside) - q).abs() < 1e-9);
            prop_assert!(inside.cmpge(placed.low).all() && inside.cmple(placed.high).all());
        }
    }
}
