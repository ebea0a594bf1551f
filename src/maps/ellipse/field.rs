//! The ellipse map seen from the vertices of a surface.

use super::{EllipseMap, Oval};
use crate::geom::Vec2;
use crate::maps::parallel;
use crate::surface::Surface;

/// Half major axis and anisotropy at every vertex: what may be averaged between them.
#[derive(Clone, Debug, PartialEq)]
pub struct EllipseField {
    vertices: Vec<Entry>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Entry {
    half_major_mm: f64,
    anisotropy: Vec2,
}

impl EllipseField {
    /// The map at every vertex, seen along z (Ji 2008, 5.3). The same bits for any number of threads.
    pub(super) fn of(map: &EllipseMap, surface: &Surface) -> Self {
        let positions = surface.positions();
        let mut vertices = vec![Entry::default(); positions.len()];
        parallel::fill(&mut vertices, positions, || {
            |p| {
                let oval = map.at(p.truncate());
                Entry {
                    half_major_mm: oval.half_major_mm,
                    anisotropy: oval.anisotropy(),
                }
            }
        });
        Self { vertices }
    }

    /// The ellipse at a vertex. Published (Ji 2008, 5.2): that of the vertex nearest to the contact.
    ///
    /// A vertex that the surface does not have gives the first one's.
    pub fn vertex(&self, vertex: u32) -> Oval {
        let entry = self.entry(vertex);
        Oval::of_anisotropy(entry.half_major_mm, entry.anisotropy)
    }

    /// The ellipse at a point of a triangle; `barycentric` weighs its corners. Continuous over the surface.
    ///
    /// A triangle that the surface does not have counts as its first one, weights that are no numbers as equal ones.
    pub fn at(&self, surface: &Surface, triangle: u32, barycentric: [f64; 3]) -> Oval {
        let triangles = surface.triangles();
        let Some(corners) = triangles.get(triangle as usize).or(triangles.first()) else {
            return self.vertex(0);
        };
        let sum: f64 = barycentric.iter().map(|b| b.max(0.0)).sum();
        let weights = if sum > 0.0 && sum.is_finite() {
            barycentric.map(|b| b.max(0.0) / sum)
        } else {
            [1.0 / 3.0; 3]
        };
        let mut mean = Entry::default();
        for (corner, weight) in corners.iter().zip(weights) {
            let entry = self.entry(*corner);
            mean.half_major_mm += entry.half_major_mm * weight;
            mean.anisotropy += entry.anisotropy * weight;
        }
        Oval::of_anisotropy(mean.half_major_mm, mean.anisotropy)
    }

    fn entry(&self, vertex: u32) -> Entry {
        let entry = self.vertices.get(vertex as usize);
        *entry.or(self.vertices.first()).unwrap_or(&Entry {
            half_major_mm: super::BASIC_RADIUS_MM,
            anisotropy: Vec2::ZERO,
        })
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Entry>()
    }
}
