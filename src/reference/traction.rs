//! An elastic body without end dragged along its surface (Cerruti 1882; Johnson 1985, 3.6), the traction spread over a
//! Gaussian.

use super::bessel::i01_scaled;
use super::material::Elastic;
use super::size_mm;
use crate::geom::Vec2;
use std::f64::consts::{FRAC_PI_2, PI};

/// Gaussian traction of standard deviation s.
///
/// A point load's u = F/(2πGr) [(1−ν) + ν cos²θ] falls into a part that is the same all round and one with cos 2θ; spread
/// over the Gaussian their 1/r become √(π/2)/s e^(−x) I₀(x) and √(π/2)/s e^(−x) I₁(x) with x = r²/4s² (ours, by their
/// Hankel transforms of order 0 and 2).
#[derive(Clone, Copy, Debug)]
pub struct Gaussian {
    material: Elastic,
    deviation_mm: f64,
}

impl Gaussian {
    /// Traction with standard deviation `deviation_mm` on `material`; 1 to 100 mm.
    pub fn new(material: Elastic, deviation_mm: f64) -> Self {
        Self {
            material,
            deviation_mm: size_mm(deviation_mm),
        }
    }

    /// How far the surface has moved at `place_mm` from the middle, in the surface, mm, when the middle was dragged by
    /// `drag_mm`. 0 for what is no number.
    pub fn at_mm(&self, drag_mm: Vec2, place_mm: Vec2) -> Vec2 {
        let (s, nu) = (self.deviation_mm, self.material.nu());
        let r_sq = place_mm.length_squared();
        let x = r_sq / (4.0 * s * s);
        if !(x.is_finite() && drag_mm.is_finite()) {
            return Vec2::ZERO;
        }
        let [even, twice] = i01_scaled(x);
        let even = even * drag_mm;
        if r_sq <= f64::MIN_POSITIVE {
            return even;
        }
        // cos 2θ and sin 2θ against the drag: the drag mirrored at the direction of the place.
        let mirrored = 2.0 * place_mm * (place_mm.dot(drag_mm) / r_sq) - drag_mm;
        even + mirrored * (twice * nu / (2.0 - nu))
    }

    /// Force per drag of the middle, N/mm.
    pub fn stiffness_n_per_mm(&self) -> f64 {
        let (g, nu) = (self.material.shear_n_per_mm2(), self.material.nu());
        let per_n = libm::sqrt(FRAC_PI_2) / (2.0 * PI * g * self.deviation_mm) * (1.0 - nu / 2.0);
        1.0 / per_n
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Dent, half_space};
    use super::*;

    #[test]
    fn tangential_against_normal_stiffness_is_the_known_ratio() {
        let pressed = half_space::Gaussian::new(Elastic::MUSCLE, 3.5).force_n(1.0);
        let dragged = Gaussian::new(Elastic::MUSCLE, 3.5).stiffness_n_per_mm();
        let nu = Elastic::MUSCLE.nu();
        assert!((dragged / pressed - 2.0 * (1.0 - nu) / (2.0 - nu)).abs() < 1e-12);
        assert!((dragged / pressed - 0.710).abs() < 0.5e-3);
    }

    /// Far off the load is a point's: along the drag 1/(1−ν) times as far as across it.
    #[test]
    fn far_off_it_is_cerrutis() {
        let m = Elastic::MUSCLE;
        let traction = Gaussian::new(m, 3.5);
        let force_n = traction.stiffness_n_per_mm();
        for angle in [0.0, 0.7, FRAC_PI_2] {
            let (sin, cos) = libm::sincos(angle);
            let r = 500.0;
            let u = traction.at_mm(Vec2::X, Vec2::new(cos, sin) * r);
            let by_point = force_n / (2.0 * PI * m.shear_n_per_mm2() * r);
            let along = by_point * ((1.0 - m.nu()) + m.nu() * cos * cos);
            let across = by_point * m.nu() * sin * cos;
            assert!((u.x / along - 1.0).abs() < 1e-3, "{angle}");
            assert!((u.y - across).abs() < 1e-3 * along, "{angle}");
        }
        let ahead = traction.at_mm(Vec2::X, Vec2::X * 500.0).x;
        let beside = traction.at_mm(Vec2::X, Vec2::Y * 500.0).x;
        assert!((ahead / beside - 1.0 / (1.0 - m.nu())).abs() < 1e-3);
    }

    #[test]
    fn the_middle_goes_along_whole_and_nothing_is_not_a_number() {
        let traction = Gaussian::new(Elastic::MUSCLE, 3.5);
        let drag = Vec2::new(3.0, -2.0);
        assert_eq!(traction.at_mm(drag, Vec2::ZERO), drag);
        assert!((traction.at_mm(drag, Vec2::X * 1e-9) - drag).length() < 1e-12);
        for wrong in [Vec2::NAN, Vec2::INFINITY, Vec2::splat(1e200)] {
            assert!(traction.at_mm(drag, wrong).is_finite());
            assert!(traction.at_mm(wrong, Vec2::X).is_finite());
        }
    }
}
