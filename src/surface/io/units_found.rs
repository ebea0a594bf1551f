//! Which units a mesh file is in: mesh formats do not say.

use crate::geom::{Aabb, Vec3};
use crate::surface::RawMesh;
use crate::units::LengthUnit;
use serde::Serialize;
use std::fmt;

/// A back from corner to corner of the box around it, mm.
const BACK_MM: std::ops::RangeInclusive<f64> = 200.0..=1000.0;

/// In the order tried: inches only where no other unit makes a back of it.
const GUESSED: [LengthUnit; 4] = [
    LengthUnit::Mm,
    LengthUnit::Cm,
    LengthUnit::M,
    LengthUnit::Inch,
];

/// Who said which units a mesh is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum UnitsSource {
    /// Whoever had the file read.
    Stated,
    /// The file, by the comment `units` that our own PLY files have.
    File,
    /// Nobody: guessed by the size.
    Guessed,
}

/// The units a mesh was taken to be in, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnitsFound {
    /// The unit.
    pub unit: LengthUnit,
    /// Who said so.
    pub source: UnitsSource,
    /// Whether the size in this unit is that of a back.
    pub fits_a_back: bool,
    /// Diagonal of the box around the mesh in its own units.
    pub diagonal: f64,
}

impl UnitsFound {
    /// The units stated; else those the file names; else the first of mm, cm, m and inch in which the diagonal of the mesh is that of a back, 0.2 to
    /// 1 m; else the one of mm, cm and m in which it comes closest.
    pub(super) fn of(
        mesh: &RawMesh,
        stated: Option<LengthUnit>,
        in_file: Option<LengthUnit>,
    ) -> Self {
        let corners = mesh.triangles.iter().flatten();
        let used = corners.filter_map(|&v| mesh.positions.get(v as usize).copied());
        let diagonal = Aabb::of_points(used.filter(|p| Vec3::is_finite(*p))).diagonal_mm();
        let fits = |unit: LengthUnit| BACK_MM.contains(&(diagonal * unit.in_mm()));
        let middle = (BACK_MM.start() * BACK_MM.end()).sqrt();
        // Both of the ratio and its inverse, so that twice as large is as far off as half as large.
        let off = |unit: LengthUnit| {
            let ratio = diagonal * unit.in_mm() / middle;
            ratio.max(1.0 / ratio)
        };
        let nearest = || {
            (GUESSED[..3].iter().copied())
                .min_by(|&a, &b| off(a).total_cmp(&off(b)))
                .unwrap_or(LengthUnit::Mm)
        };
        let (unit, source) = match (stated, in_file) {
            (Some(unit), _) => (unit, UnitsSource::Stated),
            (None, Some(unit)) => (unit, UnitsSource::File),
            (None, None) => {
                let fitting = GUESSED.into_iter().find(|&unit| fits(unit));
                (fitting.unwrap_or_else(nearest), UnitsSource::Guessed)
            }
        };
        Self {
            unit,
            source,
            fits_a_back: fits(unit),
            diagonal,
        }
    }
}

impl fmt::Display for UnitsFound {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = self.unit;
        let across = crate::units::m_from_mm(self.diagonal * unit.in_mm());
        match (self.source, self.fits_a_back) {
            (UnitsSource::Stated, _) => {
                write!(f, "{unit}, as stated: the mesh is {across:.3} m across")
            }
            (UnitsSource::File, _) => {
                write!(
                    f,
                    "{unit}, as the file says: the mesh is {across:.3} m across"
                )
            }
            (UnitsSource::Guessed, true) => write!(
                f,
                "{unit}, guessed: so the mesh is {across:.3} m across, the size of a back"
            ),
            (UnitsSource::Guessed, false) => write!(
                f,
                "{unit}, guessed although the mesh is {across:.3e} m across, not 0.2 to 1 m like a back; \
                 state the units if wrong"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guess(diagonal: f64) -> (LengthUnit, bool) {
        let mesh = RawMesh {
            positions: vec![Vec3::ZERO, Vec3::X * diagonal, Vec3::Y * 1.0e9],
            triangles: vec![[0, 1, 0]],
        };
        let found = UnitsFound::of(&mesh, None, None);
        (found.unit, found.fits_a_back)
    }

    #[test]
    fn the_unit_that_makes_a_back_of_it_is_guessed() {
        for (diagonal, unit) in [
            (600.0, LengthUnit::Mm),
            (200.0, LengthUnit::Mm),
            (60.0, LengthUnit::Cm),
            (24.0, LengthUnit::Cm),
            (10.0, LengthUnit::Inch),
            (0.6, LengthUnit::M),
        ] {
            assert_eq!(guess(diagonal), (unit, true), "{diagonal}");
        }
    }

    #[test]
    fn what_is_no_back_in_any_unit_gets_the_nearest() {
        for (diagonal, unit) in [
            (1800.0, LengthUnit::Mm),
            (1.0e12, LengthUnit::Mm),
            (150.0, LengthUnit::Mm),
            (1.8, LengthUnit::M),
            (1.0e-9, LengthUnit::M),
        ] {
            assert_eq!(guess(diagonal), (unit, false), "{diagonal}");
        }
        let (_, fits) = guess(0.0);
        assert!(!fits);
    }

    #[test]
    fn a_stated_unit_is_believed() {
        let found = |stated, in_file| {
            let found = UnitsFound::of(&RawMesh::default(), stated, in_file);
            (found.unit, found.source)
        };
        let (inch, cm) = (LengthUnit::Inch, LengthUnit::Cm);
        assert_eq!(found(Some(inch), Some(cm)), (inch, UnitsSource::Stated));
        assert_eq!(found(None, Some(cm)), (cm, UnitsSource::File));
    }
}
