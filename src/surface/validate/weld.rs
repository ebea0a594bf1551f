//! Which vertices lie at exactly the same place.

use crate::geom::Vec3;

/// For every vertex the first one at exactly the same place; nothing where all places differ.
///
/// `positions` must be finite and without negative zeros. Equal places are found by sorting a hash: same result
/// everywhere, and no input makes it slow.
pub(super) fn first_at_place(positions: &[Vec3]) -> Option<Vec<u32>> {
    let mut keys: Vec<u64> = (positions.iter().enumerate())
        .map(|(v, p)| hash(*p) << 32 | v as u64)
        .collect();
    keys.sort_unstable();
    let place = |key: u64| positions[key as u32 as usize].to_array().map(f64::to_bits);
    let mut first: Option<Vec<u32>> = None;
    for group in keys.chunk_by_mut(|a, b| a >> 32 == b >> 32) {
        if group.len() == 1 {
            continue;
        }
        group.sort_unstable_by_key(|&key| (place(key), key));
        for same in group.chunk_by(|&a, &b| place(a) == place(b)) {
            for &v in &same[1..] {
                let first = first.get_or_insert_with(|| (0..positions.len() as u32).collect());
                first[v as u32 as usize] = same[0] as u32;
            }
        }
    }
    first
}

/// 32 well-mixed bits (the finaliser of SplitMix64, Steele et al. 2014, over each coordinate in turn).
fn hash(p: Vec3) -> u64 {
    let mixed = p.to_array().into_iter().fold(0_u64, |h, x| {
        let h = (h ^ x.to_bits()).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let h = (h ^ h >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let h = (h ^ h >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^ h >> 31
    });
    mixed >> 32
}
