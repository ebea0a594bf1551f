//! Which vertices lie at exactly the same place.

use crate::geom::Vec3;
use std::hash::{BuildHasher, RandomState};

/// For every vertex the first one at exactly the same place; nothing where all places differ.
///
/// `positions` must be finite and without negative zeros. A table of numbers with open addressing: neighbours in the file
/// mostly share places, so it is read where it was just written. Its seed is drawn anew each time, so that no file can be
/// made to collide; the result does not depend on it.
pub(super) fn first_at_place(positions: &[Vec3]) -> Option<Vec<u32>> {
    const EMPTY: u32 = 0;
    let seed = RandomState::new().hash_one(0_u8);
    let slots = (positions.len() * 2).next_power_of_two();
    let shift = 64 - slots.trailing_zeros().max(1);
    let mut table = vec![EMPTY; slots];
    let mut first: Option<Vec<u32>> = None;
    for (v, p) in positions.iter().enumerate() {
        let mut slot = (hash(seed, *p) >> shift) as usize;
        loop {
            match table[slot & (slots - 1)] {
                EMPTY => {
                    table[slot & (slots - 1)] = v as u32 + 1;
                    break;
                }
                known if positions[known as usize - 1] == *p => {
                    let first = first.get_or_insert_with(|| (0..positions.len() as u32).collect());
                    first[v] = known - 1;
                    break;
                }
                _ => slot += 1,
            }
        }
    }
    first
}

/// The finaliser of SplitMix64 (Steele et al. 2014) over each coordinate in turn.
fn hash(seed: u64, p: Vec3) -> u64 {
    p.to_array().into_iter().fold(seed, |h, x| {
        let h = (h ^ x.to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^ h >> 31
    })
}
