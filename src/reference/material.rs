//! A linear elastic, isotropic material.

use crate::units::n_per_mm2_from_kpa;

/// Young's modulus and Poisson's ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    e_n_per_mm2: f64,
    nu: f64,
}

/// Why two numbers are no material.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// Young's modulus.
    #[error("Young's modulus is {0} kPa; above 0 and at most 1e9 is allowed")]
    Modulus(f64),
    /// Poisson's ratio.
    #[error("Poisson's ratio is {0}; 0 to 0.5 is allowed")]
    Ratio(f64),
}

impl Elastic {
    /// Muscle of the back: E = 25 kPa, ν = 0.45.
    pub const MUSCLE: Self = Self {
        e_n_per_mm2: 0.025,
        nu: 0.45,
    };

    /// A material with Young's modulus `e_kpa`, kPa, and Poisson's ratio `nu`.
    ///
    /// # Errors
    /// A modulus that is not above 0 and at most 1e9 kPa; a ratio outside 0 … 0.5.
    pub fn new(e_kpa: f64, nu: f64) -> Result<Self, MaterialError> {
        if !(e_kpa > 0.0 && e_kpa <= 1.0e9) {
            return Err(MaterialError::Modulus(e_kpa));
        }
        if !(0.0..=0.5).contains(&nu) {
            return Err(MaterialError::Ratio(nu));
        }
        Ok(Self {
            e_n_per_mm2: n_per_mm2_from_kpa(e_kpa),
            nu,
        })
    }

    /// Young's modulus, N/mm².
    pub fn e_n_per_mm2(self) -> f64 {
        self.e_n_per_mm2
    }

    /// Poisson's ratio.
    pub fn nu(self) -> f64 {
        self.nu
    }

    /// Plane-strain modulus E* = E / (1 − ν²), N/mm².
    pub fn plane_strain_n_per_mm2(self) -> f64 {
        self.e_n_per_mm2 / (1.0 - self.nu * self.nu)
    }

    /// Bulk modulus K = E / (3 (1 − 2ν)), N/mm²; infinite at ν = 0.5.
    pub fn bulk_n_per_mm2(self) -> f64 {
        self.e_n_per_mm2 / (3.0 * (1.0 - 2.0 * self.nu))
    }

    /// Shear modulus G = E / (2 (1 + ν)), N/mm².
    pub fn shear_n_per_mm2(self) -> f64 {
        self.e_n_per_mm2 / (2.0 * (1.0 + self.nu))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moduli_follow_from_each_other() {
        let m = Elastic::new(25.0, 0.45).unwrap();
        assert_eq!(m, Elastic::MUSCLE);
        // E* = 2 G / (1 − ν).
        let e_star = 2.0 * m.shear_n_per_mm2() / (1.0 - m.nu());
        assert!((m.plane_strain_n_per_mm2() / e_star - 1.0).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_material_is_refused() {
        for (e_kpa, nu) in [
            (0.0, 0.3),
            (-1.0, 0.3),
            (f64::NAN, 0.3),
            (25.0, 0.51),
            (25.0, -0.1),
            (25.0, f64::NAN),
        ] {
            let error = Elastic::new(e_kpa, nu).unwrap_err().to_string();
            assert!(error.contains("allowed"), "{error}");
        }
    }
}
