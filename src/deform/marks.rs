//! Which patches an update changed, and what beside them hangs on that.

use super::patches::Patches;

/// The displaced vertices, patch by patch. Nothing is cleared between updates: a mark carries its generation.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    marks: Vec<Mark>,
    generation: u32,
    marked: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    generation: u32,
    /// Offset changed, a bit for each vertex.
    displaced: u64,
}

impl Marks {
    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of::<Mark>() * self.marks.capacity() + 4 * self.marked.capacity()
    }

    /// Forgets all marks.
    pub fn begin(&mut self, patches: &Patches) {
        if self.marks.len() != patches.len() || self.generation == u32::MAX {
            self.marks.clear();
            self.marks.resize(patches.len(), Mark::default());
            self.generation = 0;
        }
        self.generation += 1;
        self.marked.clear();
    }

    /// Notes the vertices of patch `p` whose offset changed.
    #[inline]
    pub fn note(&mut self, p: u32, displaced: u64) {
        if displaced != 0 {
            self.mark(p).displaced |= displaced;
        }
    }

    /// Marks the patches beside, too, where a vertex may have a triangle that changed.
    pub fn spread(&mut self, patches: &Patches) {
        for i in 0..self.marked.len() {
            let p = self.marked[i];
            let displaced = self.displaced(p);
            for beside in patches.patch(p).beside {
                if displaced & beside.mine != 0 {
                    self.mark(beside.block);
                }
            }
        }
        self.marked.sort_unstable();
    }

    /// The patches marked, ascending once they are spread.
    pub fn marked(&self) -> &[u32] {
        &self.marked
    }

    /// The vertices of a patch with a triangle that changed.
    #[inline]
    pub fn stale(&self, patches: &Patches, p: u32) -> u64 {
        patches.grown(p, |q| self.displaced(q))
    }

    /// The vertices of a patch with a triangle that is not at rest, from those that are `stale` and the words of `moved`.
    #[inline]
    pub fn bent(&self, patches: &Patches, p: u32, stale: u64, moved: &[u64]) -> u64 {
        if moved[p as usize] == patches.all(p) {
            return moved[p as usize];
        }
        let alike = |q: u32| self.displaced(q) == moved[q as usize];
        let beside = patches.patch(p).beside;
        if alike(p) && beside.iter().all(|b| alike(b.block)) {
            return stale;
        }
        patches.grown(p, |q| moved[q as usize])
    }

    /// The vertices of a patch whose offset changed.
    #[inline]
    pub fn displaced(&self, p: u32) -> u64 {
        let mark = &self.marks[p as usize];
        if mark.generation == self.generation {
            mark.displaced
        } else {
            0
        }
    }

    #[inline]
    fn mark(&mut self, p: u32) -> &mut Mark {
        let mark = &mut self.marks[p as usize];
        if mark.generation != self.generation {
            *mark = Mark {
                generation: self.generation,
                displaced: 0,
            };
            self.marked.push(p);
        }
        mark
    }
}
