//! Bones under the built-in back, to be seen: schematic, not a subject's anatomy.
//!
//! Simple solids stand for the seventh cervical to the fifth lumbar vertebra (*vertebrae C7–L5*: body, pedicles, articular
//! processes, laminae, transverse and spinous process) with the discs between them, the twelve pairs of ribs (*costae I–XII*)
//! from head to flank, the shoulder blades (*scapulae*: blade, spine, acromion, socket), and what lies under the skin's lower
//! end of sacrum (*os sacrum*) and iliac crests (*cristae iliacae*).
//!
//! They are placed from the landmarks and the height function of the back: tips of processes, angles of the shoulder blades
//! and edges of the pelvis lie under their landmarks at the depths that the map of the depth to bone assumes there; all else
//! follows the skin at plausible depths, at least [`CLEARANCE_MM`] below it. No part was measured on a body, and nothing is
//! felt through them. Bumps that a scenario lays on the skin do not move them. Left and right are mirror images but for the
//! curve of the spine that [`BackOptions`] may ask for.
//!
//! | file | places |
//! |---|---|
//! | `under` | depth below the skin |
//! | `column` | the frames and sizes of the vertebrae |
//! | `vertebra` | one vertebra, one disc |
//! | `ribs` | the ribs |
//! | `shoulder` | the shoulder blades |
//! | `pelvis` | sacrum and iliac crests |

mod column;
mod pelvis;
mod ribs;
mod shoulder;
#[cfg(test)]
mod tests;
mod under;
mod vertebra;

use super::landmarks::LEVELS;
use super::{BackOptions, Side};
use crate::surface::solids::mirror;
use crate::surface::{RawMesh, vertex_normals};
use std::ops::Range;
pub use under::CLEARANCE_MM;
use under::Under;

/// What a bone is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BoneKind {
    /// A vertebra.
    Vertebra,
    /// The disc below a vertebra: cartilage, not bone.
    Disc,
    /// A rib.
    Rib,
    /// A shoulder blade.
    Scapula,
    /// The sacrum, its upper end.
    Sacrum,
    /// The crest of a hip bone, its rear part.
    IliacCrest,
}

/// One bone: closed solids that overlap.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Name, such as "T5", "rib 5 left", "scapula right".
    pub name: String,
    /// What it is.
    pub kind: BoneKind,
    /// Which side of the subject.
    pub side: Side,
    /// Its vertices.
    pub vertices: Range<usize>,
    /// Its triangles.
    pub triangles: Range<usize>,
}

/// All bones in one mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// Closed solids facing outward. Positions mm, in the frame of the back.
    pub mesh: RawMesh,
    /// Unit normals at the vertices.
    pub normals: Vec<crate::geom::Vec3>,
    /// Which part of the mesh is which bone, in order and without gaps.
    pub bones: Vec<Bone>,
}

impl Skeleton {
    /// The bones under the back made with `options`. Same options, same bits.
    pub fn under(options: &BackOptions) -> Self {
        let mut made = Self::default();
        let under = Under::new(options);
        let column = column::Column::new(&under);
        for (i, level) in LEVELS.iter().enumerate() {
            made.add(level, BoneKind::Vertebra, false, |mesh| {
                vertebra::add(mesh, &column, i);
            });
            if i + 1 < LEVELS.len() {
                let name = format!("disc {level}–{}", LEVELS[i + 1]);
                made.add(&name, BoneKind::Disc, false, |mesh| {
                    vertebra::add_disc(mesh, &column, i);
                });
            }
        }
        for rib in 1..=ribs::PAIRS {
            made.add(&format!("rib {rib}"), BoneKind::Rib, true, |mesh| {
                ribs::add(mesh, &under, &column, rib);
            });
        }
        made.add("scapula", BoneKind::Scapula, true, |mesh| {
            shoulder::add(mesh, &under);
        });
        made.add("sacrum", BoneKind::Sacrum, false, |mesh| {
            pelvis::add_sacrum(mesh, &under);
        });
        made.add("iliac crest", BoneKind::IliacCrest, true, |mesh| {
            pelvis::add_crest(mesh, &under);
        });
        for p in &mut made.mesh.positions {
            *p = under.placed(*p);
        }
        made.normals = vertex_normals(&made.mesh.positions, &made.mesh.triangles);
        made
    }

    /// The bone of this name, if there is one.
    pub fn bone(&self, name: &str) -> Option<&Bone> {
        self.bones.iter().find(|b| b.name == name)
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.mesh.positions[..])
            + size_of_val(&self.mesh.triangles[..])
            + size_of_val(&self.normals[..])
            + size_of_val(&self.bones[..])
            + self.bones.iter().map(|b| b.name.len()).sum::<usize>()
    }

    /// Adds the right one of a pair and its mirror image, or a single one.
    fn add(&mut self, name: &str, kind: BoneKind, paired: bool, make: impl FnOnce(&mut RawMesh)) {
        let [vertices, triangles] = self.ends();
        make(&mut self.mesh);
        let (side, suffix) = if paired {
            (Side::Right, " right")
        } else {
            (Side::Middle, "")
        };
        self.note(format!("{name}{suffix}"), kind, side, [vertices, triangles]);
        if paired {
            let from = self.ends();
            mirror(&mut self.mesh, vertices, triangles);
            self.note(format!("{name} left"), kind, Side::Left, from);
        }
    }

    fn ends(&self) -> [usize; 2] {
        [self.mesh.positions.len(), self.mesh.triangles.len()]
    }

    fn note(&mut self, name: String, kind: BoneKind, side: Side, from: [usize; 2]) {
        let to = self.ends();
        self.bones.push(Bone {
            name,
            kind,
            side,
            vertices: from[0]..to[0],
            triangles: from[1]..to[1],
        });
    }
}
