//! From any field round a finger to the vertices of the skin.

use super::Displacement;
use super::blocks::{Block, place, put};
use super::patches::Patches;
use super::shading::Shading;
use super::strain::Strain;
use crate::geom::Vec3;
use crate::surface::Surface;
use std::sync::Arc;

/// Gathers the offsets of one update and writes them, with the normals that follow from them.
///
/// For models that know a field of offsets and nothing of vertices. An update costs what the fields hold, not what the
/// surface holds: [`Spread::begin`], [`Spread::around`] for each press, [`Spread::write`].
#[derive(Clone, Debug, Default)]
pub struct Spread {
    patches: Arc<Patches>,
    shading: Shading,
    /// Zero but for the patches that are `affected`.
    offsets_mm: Vec<Block>,
    affected: Vec<u32>,
    /// Per patch and per vertex: the search that met it last, 0 for none.
    patch_met: Vec<u32>,
    vertex_met: Vec<u32>,
    update: u32,
    search: u32,
    waiting: Vec<u32>,
}

impl Spread {
    /// Builds what is kept about a surface (see [`Model::prepare`](super::Model::prepare)).
    pub fn prepare(&mut self, surface: &Surface) {
        if !self.patches.are_of(surface) {
            self.patches = Arc::new(Patches::new(surface));
            self.shading.prepare(surface, &self.patches);
            self.offsets_mm = vec![Block::ZERO; self.patches.len()];
            self.patch_met = vec![0; self.patches.len()];
            self.vertex_met = vec![0; surface.positions().len()];
            self.affected.clear();
            (self.update, self.search) = (0, 0);
        }
    }

    /// Starts from the surface at rest.
    pub fn begin(&mut self, surface: &Surface) {
        self.prepare(surface);
        for p in self.affected.drain(..) {
            self.offsets_mm[p as usize] = Block::ZERO;
        }
        self.update = next(self.update, &mut self.patch_met);
    }

    /// Adds what `offset` answers for the rest position of every vertex, mm, that hangs together with triangle `start` by
    /// vertices for which it answers. An answer that is not finite counts as no offset; a triangle that there is not starts
    /// nothing.
    pub fn around(&mut self, surface: &Surface, start: u32, offset: impl Fn(Vec3) -> Option<Vec3>) {
        let Some(corners) = surface.triangles().get(start as usize) else {
            return;
        };
        self.search = next(self.search, &mut self.vertex_met);
        self.waiting.clear();
        for &v in corners {
            self.meet(v);
        }
        while let Some(v) = self.waiting.pop() {
            let Some(by) = offset(surface.positions()[v as usize]) else {
                continue;
            };
            if by.is_finite() && by != Vec3::ZERO {
                let (p, _) = place(v);
                self.affect(p);
                let (block, i) = (&mut self.offsets_mm[p as usize], v as usize % 64);
                block.set(i, block.get(i) + by);
            }
            for &n in surface.topology().neighbours(v) {
                self.meet(n);
            }
        }
    }

    /// Brings `out`, and `strain` where there is one, to what was gathered since [`Spread::begin`].
    pub fn write(
        &mut self,
        surface: &Surface,
        out: &mut Displacement,
        strain: Option<&mut Strain>,
    ) {
        let updates = out.updates + 1;
        if out.n_vertices() != surface.positions().len() {
            *out = Displacement::at_rest(surface);
        }
        out.updates = updates;
        if !(out.patches.as_ref()).is_some_and(|p| Arc::ptr_eq(p, &self.patches)) {
            out.patches = Some(Arc::clone(&self.patches));
        }
        for p in std::mem::take(&mut out.moved_in) {
            self.affect(p);
        }
        self.affected.sort_unstable();
        self.shading.begin(&self.patches);
        for &p in &self.affected {
            let at = p as usize;
            let (changed, moved) = put(&mut out.offsets_mm[at], &self.offsets_mm[at]);
            out.moved[at] = moved;
            if moved != 0 {
                out.moved_in.push(p);
            }
            self.shading.note(p, changed);
        }
        self.shading.renew(surface, &self.patches, out, strain);
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        let words = [
            &self.affected,
            &self.patch_met,
            &self.vertex_met,
            &self.waiting,
        ];
        self.patches.bytes()
            + self.shading.bytes()
            + size_of::<Block>() * self.offsets_mm.capacity()
            + 4 * words.map(Vec::capacity).iter().sum::<usize>()
    }

    fn meet(&mut self, v: u32) {
        let met = &mut self.vertex_met[v as usize];
        if *met != self.search {
            *met = self.search;
            self.waiting.push(v);
        }
    }

    fn affect(&mut self, p: u32) {
        let met = &mut self.patch_met[p as usize];
        if *met != self.update {
            *met = self.update;
            self.affected.push(p);
        }
    }
}

/// The number after `last`, which no mark carries.
fn next(last: u32, marks: &mut [u32]) -> u32 {
    if last == u32::MAX {
        marks.fill(0);
        return 1;
    }
    last + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deform::models::fsmd::{Fsmd, Settings};
    use crate::deform::{Model as _, Press};
    use crate::surface::back::{BackOptions, make};

    fn back() -> Surface {
        Surface::new(make(&BackOptions::with_triangles(2962)))
            .unwrap()
            .0
    }

    /// Normals and what counts as touched are those of the model that everyone uses: its offsets, written this way.
    #[test]
    fn a_field_written_vertex_by_vertex_is_the_field() {
        let surface = back();
        let mut model = Fsmd::new(Settings::default());
        let (mut theirs, mut ours) = (
            Displacement::at_rest(&surface),
            Displacement::at_rest(&surface),
        );
        let mut spread = Spread::default();
        for (t, depth_mm) in [(900_u32, 4.0), (905, 7.0), (2000, 2.0), (2000, 0.0)] {
            let corners = surface.triangle(t);
            let press = Press {
                anchor_mm: corners.centroid(),
                foot_mm: corners.centroid(),
                normal: corners.normal(),
                depth_mm,
                triangle: t,
                ..Press::default()
            };
            model.update(&surface, &[press], &mut theirs);
            let moved: Vec<(Vec3, Vec3)> = theirs
                .moved()
                .map(|v| (surface.positions()[v as usize], theirs.offset_mm(v)))
                .collect();
            spread.begin(&surface);
            // In two halves, which add up.
            for _ in 0..2 {
                spread.around(&surface, t, |at| {
                    let found = moved.iter().find(|(p, _)| *p == at);
                    Some(found.map_or(Vec3::ZERO, |(_, by)| *by * 0.5))
                });
            }
            spread.write(&surface, &mut ours, None);
            assert!(theirs.moved().eq(ours.moved()), "{t}");
            assert!(theirs.touched().eq(ours.touched()), "{t}");
            for v in 0..surface.positions().len() as u32 {
                assert_eq!(theirs.offset_mm(v), ours.offset_mm(v), "{v}");
                assert_eq!(theirs.normal(v), ours.normal(v), "{v}");
            }
        }
        assert_eq!(ours.n_moved(), 0, "the last press was none");
    }

    #[test]
    fn what_does_not_hang_together_with_the_finger_stays() {
        let surface = back();
        let start = surface.triangle(900).centroid();
        let mut skin = Displacement::at_rest(&surface);
        let mut spread = Spread::default();
        spread.begin(&surface);
        // An answer within 20 mm and beyond 60 mm: only the island with the finger is met.
        spread.around(&surface, 900, |at| {
            let r = at.distance(start);
            (!(20.0..=60.0).contains(&r)).then_some(Vec3::Z)
        });
        spread.around(&surface, 4_000_000, |_| Some(Vec3::Z));
        spread.around(&surface, 900, |_| Some(Vec3::NAN));
        spread.write(&surface, &mut skin, None);
        let expected = surface
            .positions()
            .iter()
            .filter(|p| p.distance(start) < 20.0);
        assert_eq!(skin.n_moved(), expected.count());
        assert!(skin.n_moved() > 10);
    }
}
