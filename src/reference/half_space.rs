//! An elastic body without end under three loads (Johnson 1985, Contact Mechanics, ch. 3 and 4).

use super::bessel::i01_scaled;
use super::material::Elastic;
use super::{Dent, depth, size_mm};
use std::f64::consts::{FRAC_PI_2, PI};

/// Gaussian pressure of standard deviation s: u = F / (√(2π) E* s) · e^(−x) I₀(x), x = r² / 4s².
#[derive(Clone, Copy, Debug)]
pub struct Gaussian {
    material: Elastic,
    deviation_mm: f64,
}

impl Gaussian {
    /// Pressure with standard deviation `deviation_mm` on `material`; 1 to 100 mm.
    pub fn new(material: Elastic, deviation_mm: f64) -> Self {
        Self {
            material,
            deviation_mm: size_mm(deviation_mm),
        }
    }
}

impl Dent for Gaussian {
    fn name(&self) -> &'static str {
        "half-space-gaussian"
    }

    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
        let s = self.deviation_mm;
        let x = r_mm * r_mm / (4.0 * s * s);
        match depth(depth_mm) {
            Some(d) if x.is_finite() => d * i01_scaled(x)[0],
            _ => 0.0,
        }
    }

    fn force_n(&self, depth_mm: f64) -> f64 {
        let e = self.material.plane_strain_n_per_mm2();
        depth(depth_mm).map_or(0.0, |d| d * libm::sqrt(2.0 * PI) * e * self.deviation_mm)
    }
}

/// Uniform pressure p on a disc of radius a: 2pa/E* in the middle, 4pa/(πE*) at its edge, and complete elliptic integrals
/// between and beyond (Johnson 1985, eq. 3.29).
#[derive(Clone, Copy, Debug)]
pub struct Disc {
    material: Elastic,
    radius_mm: f64,
}

impl Disc {
    /// A disc of radius `radius_mm` on `material`; 1 to 100 mm.
    pub fn new(material: Elastic, radius_mm: f64) -> Self {
        Self {
            material,
            radius_mm: size_mm(radius_mm),
        }
    }
}

impl Dent for Disc {
    fn name(&self) -> &'static str {
        "half-space-disc"
    }

    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
        let Some(d) = depth(depth_mm).filter(|_| r_mm.is_finite()) else {
            return 0.0;
        };
        let t = r_mm.abs() / self.radius_mm;
        // In units of the middle, 2pa/E*.
        let share = if t <= 1.0 {
            let [k, lack] = elliptic(t);
            k * (1.0 - lack)
        } else {
            // E − (1 − 1/t²) K, which far away would be a difference of nearly equal numbers.
            let u = 1.0 / t;
            let [k, lack] = elliptic(u);
            k * (t * (u * u - lack))
        };
        d * (share / FRAC_PI_2)
    }

    fn force_n(&self, depth_mm: f64) -> f64 {
        // d = 2pa/E*, F = p π a².
        let e = self.material.plane_strain_n_per_mm2();
        depth(depth_mm).map_or(0.0, |d| d * e * FRAC_PI_2 * self.radius_mm)
    }
}

/// Of the complete elliptic integrals K and E of modulus `t` in 0 … 1: K and 1 − E/K, by the arithmetic–geometric mean
/// (Abramowitz and Stegun 1964, 17.6). K is infinite at t = 1, where its factor in [`Disc`] is 0: it is kept finite.
fn elliptic(t: f64) -> [f64; 2] {
    let (mut a, mut b, mut c) = (1.0, libm::sqrt((1.0 - t * t).max(1.0e-300)), t);
    let (mut power, mut sum) = (0.5, 0.0);
    for _ in 0..40 {
        sum += power * c * c;
        if c.abs() < 1e-17 {
            break;
        }
        (a, b, c) = (0.5 * (a + b), libm::sqrt(a * b), 0.5 * (a - b));
        power *= 2.0;
    }
    [FRAC_PI_2 / a, sum]
}

/// A rigid sphere of radius R pressed in (Hertz 1882): F = 4/3 E* √R d^(3/2), the skin follows it up to a = √(R d).
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    material: Elastic,
    radius_mm: f64,
}

impl Sphere {
    /// A sphere of radius `radius_mm` on `material`; 1 to 100 mm.
    pub fn new(material: Elastic, radius_mm: f64) -> Self {
        Self {
            material,
            radius_mm: size_mm(radius_mm),
        }
    }
}

impl Dent for Sphere {
    fn name(&self) -> &'static str {
        "half-space-sphere"
    }

    fn at_mm(&self, depth_mm: f64, r_mm: f64) -> f64 {
        let Some(d) = depth(depth_mm).filter(|_| r_mm.is_finite()) else {
            return 0.0;
        };
        let t = r_mm.abs() / libm::sqrt(self.radius_mm * d);
        if t <= 1.0 {
            return d * (1.0 - 0.5 * t * t);
        }
        let u = 1.0 / t;
        let share = if u < 0.03 {
            // Its series: far away the terms below would cancel to nothing but rounding.
            let v = u * u;
            u * (4.0 / 3.0 + v * (2.0 / 15.0 + v * (3.0 / 70.0 + v * (5.0 / 252.0))))
        } else {
            (2.0 - t * t) * libm::asin(u) + t * libm::sqrt(1.0 - u * u)
        };
        d / PI * share
    }

    fn force_n(&self, depth_mm: f64) -> f64 {
        let e = self.material.plane_strain_n_per_mm2();
        depth(depth_mm).map_or(0.0, |d| {
            4.0 / 3.0 * e * libm::sqrt(self.radius_mm) * d * libm::sqrt(d)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_pressure_of_3_n_makes_the_known_dent() {
        let dent = Gaussian::new(Elastic::MUSCLE, 3.5);
        let depth_mm = 3.0 / dent.force_n(1.0);
        assert!((depth_mm - 10.908).abs() < 0.5e-3, "{depth_mm}");
        let at_20 = dent.at_mm(depth_mm, 20.0);
        assert!((at_20 - 1.548_30).abs() < 0.5e-5, "{at_20}");
    }

    #[test]
    fn a_disc_of_3_n_makes_the_known_dent() {
        let dent = Disc::new(Elastic::MUSCLE, 7.0);
        let depth_mm = 3.0 / dent.force_n(1.0);
        assert!((depth_mm - 8.7035).abs() < 0.5e-4, "{depth_mm}");
        let edge = dent.at_mm(depth_mm, 7.0);
        assert!((edge - 5.5408).abs() < 0.5e-4, "{edge}");
        let beyond = dent.at_mm(depth_mm, 7.0 * (1.0 + 1e-9));
        assert!((edge - beyond).abs() < 1e-6);
    }

    #[test]
    fn a_sphere_is_that_of_hertz() {
        let dent = Sphere::new(Elastic::MUSCLE, 8.0);
        assert!((dent.force_n(2.0) - 0.334_38).abs() < 0.5e-5);
        assert!(
            (dent.at_mm(2.0, 4.0) - 1.0).abs() < 1e-14,
            "half as deep at its edge"
        );
        assert!((dent.at_mm(2.0, 4.0 + 1e-9) - 1.0).abs() < 1e-8);
    }

    /// From 100 m on the sphere was nothing but rounding, the disc from 10 km on; a depth of 5e-324 mm gave NaN.
    #[test]
    fn farther_off_than_anyone_asks_they_still_are() {
        let e = Elastic::MUSCLE.plane_strain_n_per_mm2();
        let dents: [Box<dyn Dent>; 3] = [
            Box::new(Gaussian::new(Elastic::MUSCLE, 3.5)),
            Box::new(Disc::new(Elastic::MUSCLE, 7.0)),
            Box::new(Sphere::new(Elastic::MUSCLE, 8.0)),
        ];
        for dent in dents {
            for depth_mm in [1e-9, 1.0] {
                for r_mm in [1e5, 1e7, 1e9] {
                    let point = dent.force_n(depth_mm) / (PI * e * r_mm);
                    let share = dent.at_mm(depth_mm, r_mm) / point;
                    assert!((share - 1.0).abs() < 1e-8, "{}: {share}", dent.name());
                }
            }
            let least = dent.at_mm(5e-324, 3.0);
            assert!((0.0..=5e-324).contains(&least), "{}: {least}", dent.name());
        }
        // On both sides of where the series takes over.
        let sphere = Sphere::new(Elastic::MUSCLE, 8.0);
        let edge_mm = 4.0 / 0.03;
        let [near, far] = [1.0 - 1e-9, 1.0 + 1e-9].map(|s| sphere.at_mm(2.0, edge_mm * s) * s);
        assert!((near / far - 1.0).abs() < 1e-11, "{near} and {far}");
    }

    /// Far off every load is a point: u = F / (π E* r) (Boussinesq).
    #[test]
    fn far_off_all_three_are_boussinesqs() {
        let e = Elastic::MUSCLE.plane_strain_n_per_mm2();
        let dents: [Box<dyn Dent>; 3] = [
            Box::new(Gaussian::new(Elastic::MUSCLE, 3.5)),
            Box::new(Disc::new(Elastic::MUSCLE, 7.0)),
            Box::new(Sphere::new(Elastic::MUSCLE, 8.0)),
        ];
        for dent in dents {
            let r_mm = 400.0;
            let point = dent.force_n(4.0) / (PI * e * r_mm);
            let here = dent.at_mm(4.0, r_mm);
            assert!((here / point - 1.0).abs() < 1e-3, "{}", dent.name());
        }
    }
}
