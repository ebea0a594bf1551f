//! Where the footprints of a press end: to be drawn, not to deform anything.

use super::{Footprint, Settings, sound};
use crate::deform::Press;
use crate::deform::footprint::Outline;
use crate::geom::Vec3;
use crate::surface::Surface;
use std::f64::consts::TAU;

impl Settings {
    /// The boundaries of the tangential and of the normal footprint of a press, each as `n` points on its tangent plane, mm,
    /// counter-clockwise seen from outside. Empty for a half that is not computed, has no extent, or of a press that is not
    /// finite; the normal one is also empty at no depth.
    pub fn outlines(&self, surface: &Surface, press: &Press, n: usize) -> [Vec<Vec3>; 2] {
        let Some(press) = sound(press, surface) else {
            return [Vec::new(), Vec::new()];
        };
        let [wide, narrow] = self.footprints_at(surface, &press);
        let wide = wide.filter(|_| self.tangential);
        let narrow = narrow.filter(|_| press.depth_mm > 0.0);
        [wide, narrow].map(|f| f.map_or_else(Vec::new, |f| boundary(&f, &press, n)))
    }
}

/// The ratio q grows in proportion along each ray from the centre, in every footprint: so it is 1 at 1/q(1 mm).
fn boundary(footprint: &Footprint, press: &Press, n: usize) -> Vec<Vec3> {
    let (o, normal) = (press.anchor_mm, press.normal);
    let u = crate::geom::any_tangent(normal);
    let v = normal.cross(u);
    let ratio = |at: Vec3| match footprint {
        Footprint::Ellipse(outline) => outline.ratio(at),
        Footprint::Printed(outline) => outline.ratio(at),
        Footprint::Polar(outline) => outline.ratio(at),
    };
    (0..n)
        .map(|i| {
            let (sin, cos) = libm::sincos(TAU * i as f64 / n as f64);
            let along = u * cos + v * sin;
            o + along / ratio(o + along)
        })
        .filter(|p| p.is_finite())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::footprint::Kind;
    use crate::surface::{RawMesh, Surface};

    fn one_triangle() -> Surface {
        let raw = RawMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        };
        Surface::new(raw).unwrap().0
    }

    fn press(depth_mm: f64) -> Press {
        Press {
            anchor_mm: Vec3::new(1.0, 2.0, 3.0),
            foot_mm: Vec3::new(1.0, 2.0, 3.0),
            normal: Vec3::Z,
            depth_mm,
            ..Press::default()
        }
    }

    #[test]
    fn every_point_of_an_outline_has_ratio_one_whatever_the_footprint() {
        let surface = one_triangle();
        let boundary_mm: Vec<f64> = (0..36).map(|i| 30.0 + f64::from(i % 7)).collect();
        for &kind in Kind::all() {
            let settings = Settings {
                footprint: kind,
                half_major_mm: 80.0,
                half_minor_mm: 50.0,
                angle_rad: 0.6,
                ..Settings::default()
            };
            let press = Press {
                boundary_mm: Some(boundary_mm.clone().into()),
                ..press(10.0)
            };
            let [wide, narrow] = settings.outlines(&surface, &press, 64);
            assert_eq!((wide.len(), narrow.len()), (64, 64));
            let footprint = settings.footprint_at(&press).unwrap();
            for (p, q) in wide.iter().zip(&narrow) {
                let ratio = match &footprint {
                    Footprint::Ellipse(o) => o.ratio(*p),
                    Footprint::Printed(o) => o.ratio(*p),
                    Footprint::Polar(o) => o.ratio(*p),
                };
                assert!((ratio - 1.0).abs() < 1e-9, "{kind:?}: {ratio}");
                assert!((p.z - 3.0).abs() < 1e-12);
                let share = (*q - press.anchor_mm).length() / (*p - press.anchor_mm).length();
                assert!((share - settings.normal_scale_deep).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_half_that_moves_nothing_has_no_outline() {
        let surface = one_triangle();
        let settings = Settings::default();
        let [wide, narrow] = settings.outlines(&surface, &press(0.0), 16);
        assert_eq!((wide.len(), narrow.len()), (16, 0));
        let still = Settings {
            tangential: false,
            ..settings.clone()
        };
        assert!(still.outlines(&surface, &press(3.0), 16)[0].is_empty());
        for broken in [f64::NAN, f64::INFINITY, -1.0] {
            let outlines = settings.outlines(&surface, &press(broken), 16);
            assert!(outlines.iter().all(Vec::is_empty), "{broken}");
        }
    }
}
