//! Vectors of 64 vertices at a time, each coordinate in a row of its own: what one vertex needs is done for two or more at
//! once, and a set of them is one word.

use crate::geom::Vec3;

/// Vertices in a block: one bit each in a word. Block `b` holds the vertices from 64 b on.
pub(super) const BLOCK: usize = 64;

/// One number for each vertex of a block.
pub(super) type Row = [f64; BLOCK];

/// One vector for each vertex of a block.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Block {
    pub x: Row,
    pub y: Row,
    pub z: Row,
}

impl Block {
    pub const ZERO: Self = Self {
        x: [0.0; BLOCK],
        y: [0.0; BLOCK],
        z: [0.0; BLOCK],
    };

    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    pub fn set(&mut self, i: usize, to: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (to.x, to.y, to.z);
    }
}

/// The vectors in blocks, the last one filled up with `padding`.
pub(super) fn blocks_of(vectors: &[Vec3], padding: Vec3) -> Vec<Block> {
    let blocks = vectors.chunks(BLOCK).map(|chunk| {
        let mut block = Block::ZERO;
        for i in 0..BLOCK {
            block.set(i, chunk.get(i).copied().unwrap_or(padding));
        }
        block
    });
    blocks.collect()
}

/// Block and bit of a vertex.
#[inline(always)]
pub(super) fn place(v: u32) -> (u32, u64) {
    (v / BLOCK as u32, 1 << (v % BLOCK as u32))
}

/// The vertex with a number in a block.
#[inline(always)]
pub(super) fn vertex(block: u32, i: usize) -> u32 {
    block * BLOCK as u32 + i as u32
}

/// Numbers of the bits set, ascending.
#[inline(always)]
pub(super) fn bits(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = word.trailing_zeros() as usize;
        word &= word.wrapping_sub(1);
        (i < 64).then_some(i)
    })
}

/// A word of what holds for each vertex of a block.
#[inline(always)]
pub(super) fn word(holds: impl Fn(usize) -> bool) -> u64 {
    (0..BLOCK).fold(0, |word, i| word | u64::from(holds(i)) << i)
}

/// A word of the vertices without a mark; `n` is the number of marks.
#[inline(always)]
pub(super) fn unless(marks: &[u64; BLOCK], n: u64) -> u64 {
    match n {
        0 => u64::MAX,
        64 => 0,
        _ => word(|i| marks[i] == 0),
    }
}

/// Writes an offset for each vertex of a patch; answers with the bits of those that changed, and of those not zero.
#[inline(always)]
pub(super) fn put_each(held: &mut Block, offset: impl Fn(usize) -> [f64; 3]) -> (u64, u64) {
    let (mut same, mut still) = ([0_u64; BLOCK], [0_u64; BLOCK]);
    let (mut n_same, mut n_still) = (0, 0);
    for i in 0..BLOCK {
        let [x, y, z] = offset(i);
        same[i] = u64::from((x == held.x[i]) & (y == held.y[i]) & (z == held.z[i]));
        still[i] = u64::from((x == 0.0) & (y == 0.0) & (z == 0.0));
        n_same += same[i];
        n_still += still[i];
        held.x[i] = x;
        held.y[i] = y;
        held.z[i] = z;
    }
    (unless(&same, n_same), unless(&still, n_still))
}

/// The same from a block of offsets.
pub(super) fn put(held: &mut Block, offsets: &Block) -> (u64, u64) {
    put_each(held, |i| [offsets.x[i], offsets.y[i], offsets.z[i]])
}
