//! Every yardstick as a model of the drawn skin.

use super::continuum::Continuum;
use super::fem::linear::SolveError;
use super::fem::mesh::SlabError;
use super::patch::{Patch, PatchError, PatchOptions};
use super::slab::lattice::Stepping;
use super::slab::{Body, SlabModel, elements, lattice};
use super::{Dent, Elastic, half_space, layer, membrane, traction};
use crate::deform::Model;
use crate::geom::Vec3;
use crate::partition::Partition;
use crate::surface::Surface;
use std::sync::Arc;

/// What lies under the skin, and what presses on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tissue {
    /// Its material.
    pub material: Elastic,
    /// Depth of the bone, mm.
    pub thickness_mm: f64,
    /// Standard deviation of a fingertip's pressure, mm.
    pub deviation_mm: f64,
}

impl Default for Tissue {
    /// A fingertip on the muscle of a back (METHOD 6).
    fn default() -> Self {
        Self {
            material: Elastic::MUSCLE,
            thickness_mm: 20.0,
            deviation_mm: 3.5,
        }
    }
}

/// Where a yardstick is laid.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// The skin.
    pub surface: &'a Surface,
    /// Finds it along a line.
    pub search: &'a dyn Partition,
    /// The place pressed, mm.
    pub at_mm: Vec3,
    /// Outward unit normal there.
    pub normal: Vec3,
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum YardstickError {
    /// No slab can be laid there.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// The slab has no solution.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Stopped, or too many nodes.
    #[error("the slab was not condensed")]
    Condense,
}

impl From<SlabError> for YardstickError {
    fn from(error: SlabError) -> Self {
        Self::Patch(error.into())
    }
}

/// A yardstick by name.
#[derive(Debug)]
pub struct Yardstick {
    /// Name in files, tables and the command line.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    make: fn(Site<'_>, Tissue) -> Result<Box<dyn Model>, YardstickError>,
}

impl Yardstick {
    /// The model for presses at a site. Closed forms may be pressed anywhere; slabs only within the patch laid there.
    ///
    /// # Errors
    /// The skin ends within the patch, or the slab has no solution.
    pub fn make(&self, site: Site<'_>, tissue: Tissue) -> Result<Box<dyn Model>, YardstickError> {
        (self.make)(site, tissue)
    }
}

/// Every yardstick, from closed forms to what moves in time.
pub fn models() -> &'static [Yardstick] {
    &[
        Yardstick {
            name: "half-space-gaussian",
            about: "Closed form: a body without end under a fingertip",
            make: |_, t| closed(half_space::Gaussian::new(t.material, t.deviation_mm), t),
        },
        Yardstick {
            name: "half-space-disc",
            about: "Closed form: a body without end under an even pressure on a disc",
            make: |_, t| closed(half_space::Disc::new(t.material, 2.0 * t.deviation_mm), t),
        },
        Yardstick {
            name: "half-space-sphere",
            about: "Closed form: a body without end under a rigid ball (Hertz)",
            make: |_, t| closed(half_space::Sphere::new(t.material, 8.0), t),
        },
        Yardstick {
            name: "layer",
            about: "Closed form: a layer of tissue bonded to bone",
            make: |_, t| {
                closed(
                    layer::Bonded::new(t.material, t.deviation_mm, t.thickness_mm),
                    t,
                )
            },
        },
        Yardstick {
            name: "membrane",
            about: "Closed form: a tensed skin on a bed of springs (Winkler)",
            make: |_, t| closed(membrane::Tensed::new(5.0, 2.0 * t.deviation_mm, 0.002), t),
        },
        Yardstick {
            name: "fem-linear",
            about: "Finite elements for small strains, solved anew for each press",
            make: |s, t| slab(s, t, 14, 6, 5.0, |p| Ok(elements::linear(p, t.material)?)),
        },
        Yardstick {
            name: "fem-condensed",
            about: "The same condensed to the skin: a column for each node under the finger",
            make: |s, t| {
                slab(s, t, 14, 6, 5.0, |p| {
                    elements::condensed(p, t.material, &mut |_| true)?
                        .ok_or(YardstickError::Condense)
                })
            },
        },
        Yardstick {
            name: "fem-pressed",
            about: "The same for a fingertip on each node: four columns for a press",
            make: |s, t| {
                slab(s, t, 14, 6, 5.0, |p| {
                    elements::pressed(p, t.material, t.deviation_mm, &mut |_| true)?
                        .ok_or(YardstickError::Condense)
                })
            },
        },
        Yardstick {
            name: "fem-corotated",
            about: "Finite elements that turn, for large strains",
            make: |s, t| {
                slab(s, t, 7, 4, 5.0, |p| {
                    Ok(elements::corotated(p, t.material, 1.0e-8)?)
                })
            },
        },
        Yardstick {
            name: "springs-rest",
            about: "Mass and springs, brought to rest by Newton's method",
            make: |s, t| sprung(s, t, Stepping::Rest),
        },
        Yardstick {
            name: "springs-explicit",
            about: "Mass and springs in explicit steps",
            make: |s, t| sprung(s, t, Stepping::Explicit(800)),
        },
        Yardstick {
            name: "springs-implicit",
            about: "Mass and springs in implicit steps of a frame",
            make: |s, t| sprung(s, t, Stepping::Implicit(8)),
        },
        Yardstick {
            name: "xpbd",
            about: "Position-based dynamics on the same springs, as games use it",
            make: |s, t| sprung(s, t, Stepping::Position(20, 20, 1)),
        },
    ]
}

/// The yardstick called `name`.
pub fn by_name(name: &str) -> Option<&'static Yardstick> {
    models().iter().find(|y| y.name == name)
}

/// How far closed forms are followed, mm.
const REACH_MM: f64 = 90.0;

fn closed(dent: impl Dent + 'static, tissue: Tissue) -> Result<Box<dyn Model>, YardstickError> {
    let drag = traction::Gaussian::new(tissue.material, tissue.deviation_mm);
    Ok(Box::new(Continuum::new(
        Arc::new(dent),
        Some(drag),
        REACH_MM,
    )))
}

fn slab(
    site: Site<'_>,
    tissue: Tissue,
    n_half: usize,
    layers: usize,
    growth: f64,
    body: impl FnOnce(&Patch) -> Result<Box<dyn Body>, YardstickError>,
) -> Result<Box<dyn Model>, YardstickError> {
    let options = PatchOptions {
        n_half,
        layers,
        growth,
        thickness_mm: tissue.thickness_mm,
        ..PatchOptions::default()
    };
    let patch = Patch::new(site.surface, site.search, site.at_mm, site.normal, options)?;
    let body = body(&patch)?;
    Ok(Box::new(SlabModel::new(patch, body, tissue.deviation_mm)))
}

/// Springs are at their best as cubes: a grid that is nearly even.
fn sprung(
    site: Site<'_>,
    tissue: Tissue,
    stepping: Stepping,
) -> Result<Box<dyn Model>, YardstickError> {
    slab(site, tissue, 8, 4, 2.0, |p| {
        Ok(lattice::springs(p, tissue.material, stepping)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::{Displacement, Press};
    use crate::geom::Vec2;
    use crate::partition::Sides;
    use crate::partition::bvh::Bvh;
    use crate::surface::back::{BackOptions, make};

    struct Skin {
        surface: Surface,
        search: Bvh,
        press: Press,
    }

    fn skin() -> Skin {
        let surface = Surface::new(make(&BackOptions::with_triangles(2962)))
            .unwrap()
            .0;
        let search = Bvh::new(&surface);
        let over = Vec2::new(35.0, 235.0).extend(500.0);
        let hit = search
            .sweep(&surface, over, over - Vec3::Z * 1000.0, Sides::Front)
            .unwrap();
        let press = Press {
            anchor_mm: hit.point,
            foot_mm: hit.point,
            normal: surface.triangle(hit.triangle).normal(),
            depth_mm: 3.0,
            triangle: hit.triangle,
            ..Press::default()
        };
        Skin {
            surface,
            search,
            press,
        }
    }

    /// Whatever is asked of a yardstick, the skin stays finite, goes back to rest exactly, and a good press moves it into
    /// the body and no deeper than the finger.
    #[test]
    fn every_yardstick_is_a_model_like_any_other() {
        let skin = skin();
        let site = Site {
            surface: &skin.surface,
            search: &skin.search,
            at_mm: skin.press.anchor_mm,
            normal: skin.press.normal,
        };
        for yardstick in models() {
            let name = yardstick.name;
            let mut model = yardstick.make(site, Tissue::default()).unwrap();
            assert_eq!(model.name(), name);
            let mut out = Displacement::at_rest(&skin.surface);
            let good = std::slice::from_ref(&skin.press);
            model.update(&skin.surface, good, &mut out);
            let deepest = (out
                .moved()
                .map(|v| -out.offset_mm(v).dot(skin.press.normal)))
            .fold(0.0, f64::max);
            assert!(deepest > 0.8 && deepest < 3.1, "{name}: {deepest}");
            let bad = [
                Press {
                    depth_mm: f64::NAN,
                    ..skin.press.clone()
                },
                Press {
                    depth_mm: f64::INFINITY,
                    ..skin.press.clone()
                },
                Press {
                    depth_mm: -1.0,
                    ..skin.press.clone()
                },
                Press {
                    normal: Vec3::ZERO,
                    ..skin.press.clone()
                },
                Press {
                    normal: Vec3::NAN,
                    ..skin.press.clone()
                },
                Press {
                    anchor_mm: Vec3::INFINITY,
                    ..skin.press.clone()
                },
                Press {
                    foot_mm: Vec3::NAN,
                    depth_mm: 0.0,
                    ..skin.press.clone()
                },
                Press {
                    triangle: u32::MAX,
                    ..skin.press.clone()
                },
                Press {
                    anchor_mm: Vec3::splat(1.0e9),
                    ..skin.press.clone()
                },
            ];
            for press in bad {
                model.update(&skin.surface, std::slice::from_ref(&press), &mut out);
                for v in 0..out.n_vertices() as u32 {
                    assert!(
                        out.offset_mm(v).is_finite() && out.normal(v).is_finite(),
                        "{name}: {press:?}"
                    );
                }
            }
            model.update(&skin.surface, &[], &mut out);
            assert_eq!(out.n_moved(), 0, "{name}");
            for v in 0..out.n_vertices() as u32 {
                assert_eq!(out.normal(v), skin.surface.normals()[v as usize], "{name}");
            }
        }
    }

    /// The three answers to one press: factored, by nodes, by fingertips. The first two are the same; the third widens the
    /// pressure between nodes.
    #[test]
    fn the_condensed_slab_dents_as_the_full_one() {
        let skin = skin();
        let site = Site {
            surface: &skin.surface,
            search: &skin.search,
            at_mm: skin.press.anchor_mm,
            normal: skin.press.normal,
        };
        let dent = |name: &str, foot: f64| {
            let mut model = by_name(name)
                .unwrap()
                .make(site, Tissue::default())
                .unwrap();
            let mut out = Displacement::at_rest(&skin.surface);
            let press = Press {
                anchor_mm: skin.press.anchor_mm + Vec3::X * foot,
                ..skin.press.clone()
            };
            model.update(&skin.surface, &[press], &mut out);
            let n = skin.press.normal;
            (0..out.n_vertices() as u32)
                .map(|v| out.offset_mm(v).dot(n))
                .collect::<Vec<_>>()
        };
        let apart = |a: &[f64], b: &[f64]| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max)
        };
        for foot in [0.0, 2.3] {
            let full = dent("fem-linear", foot);
            assert!(apart(&full, &dent("fem-condensed", foot)) < 1.0e-10);
            assert!(
                apart(&full, &dent("fem-pressed", foot)) < if foot == 0.0 { 1.0e-10 } else { 0.05 }
            );
        }
    }
}
