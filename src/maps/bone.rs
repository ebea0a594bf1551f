//! How deep bone lies under the skin (Ji 2008, future work 1).

use super::fit::{Field, Fit, Sample, TOUCHING_MM};
use super::{MAX_COORDINATE_MM, MapError, on_map, on_the_map, parallel, places};
use crate::geom::Vec2;
use crate::surface::Surface;
use crate::surface::back::{self, BackOptions, Kind};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Depths a key may state, mm.
pub const BONE_DEPTHS_MM: RangeInclusive<f64> = 1.0..=500.0;

/// A known depth of bone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoneKey {
    /// Place on the map plane, mm.
    pub at: Vec2,
    /// Thickness of what gives way there: from the skin along its normal to the bone, mm.
    pub depth_mm: f64,
}

/// Why a map of bones is refused. Keys are counted from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoneError {
    /// There is no key.
    #[error("the map of bones has no keys; at least one is needed")]
    NoKeys,
    /// A key lies nowhere.
    #[error("bone key {key} at ({}, {}) mm: coordinates must be numbers within ±{MAX_COORDINATE_MM} mm", at.x, at.y)]
    Place {
        /// Which key.
        key: usize,
        /// Its place as stated, mm.
        at: Vec2,
    },
    /// A key states no depth.
    #[error(
        "bone key {key} at ({}, {}) mm: depth_mm is {depth_mm}; {} to {} is allowed",
        at.x, at.y, BONE_DEPTHS_MM.start(), BONE_DEPTHS_MM.end()
    )]
    Depth {
        /// Which key.
        key: usize,
        /// Its place, mm.
        at: Vec2,
        /// Its depth as stated, mm.
        depth_mm: f64,
    },
    /// One place, two depths.
    #[error(
        "bone keys {} and {} are both at ({}, {}) mm but state {} and {} mm; keep one of them",
        keys[0], keys[1], at.x, at.y, depths_mm[0], depths_mm[1]
    )]
    Conflict {
        /// Which keys.
        keys: [usize; 2],
        /// The place of the first, mm.
        at: Vec2,
        /// Their depths, mm.
        depths_mm: [f64; 2],
    },
    /// The keys cannot be fitted.
    #[error("map of bones: {0}")]
    Fit(#[from] MapError),
}

/// Depth to bone over the map plane: natural neighbour between the keys, outside their hull as at its closest point.
///
/// Continuous, and within the range of the keys.
#[derive(Clone, Debug)]
pub struct BoneMap {
    keys: Vec<BoneKey>,
    field: Arc<dyn Field>,
}

impl BoneMap {
    /// Fits `keys`. A key stated twice counts once; places within a nanometre of each other are the same.
    ///
    /// # Errors
    /// No key; a key whose place or depth is not allowed; two keys at one place with different depths.
    pub fn new(keys: Vec<BoneKey>) -> Result<Self, BoneError> {
        if keys.is_empty() {
            return Err(BoneError::NoKeys);
        }
        for (i, &BoneKey { at, depth_mm }) in keys.iter().enumerate() {
            let key = i + 1;
            if !on_the_map(at) {
                return Err(BoneError::Place { key, at });
            }
            if !BONE_DEPTHS_MM.contains(&depth_mm) {
                return Err(BoneError::Depth { key, at, depth_mm });
            }
        }
        let at: Vec<Vec2> = keys.iter().map(|k| k.at).collect();
        let repeated = places::repeated(&at, TOUCHING_MM, |i, j| {
            let depths_mm = [keys[i].depth_mm, keys[j].depth_mm];
            let conflict = BoneError::Conflict {
                keys: [i + 1, j + 1],
                at: keys[i].at,
                depths_mm,
            };
            (depths_mm[0] == depths_mm[1]).then_some(()).ok_or(conflict)
        })?;
        let distinct = keys.iter().zip(repeated).filter(|(_, repeated)| !repeated);
        let sample = |k: &BoneKey| Sample {
            at: k.at,
            value: k.depth_mm,
        };
        let samples: Vec<Sample> = distinct.map(|(k, _)| sample(k)).collect();
        let field = Fit::Natural.through(&samples)?;
        Ok(Self { keys, field })
    }

    /// The keys, as given.
    pub fn keys(&self) -> &[BoneKey] {
        &self.keys
    }

    /// Depth to bone at a place of the map plane, mm.
    ///
    /// A coordinate that is not a number counts as 0, one beyond 1e6 mm as 1e6 mm.
    pub fn at(&self, place: Vec2) -> f64 {
        self.field.reader().at(on_map(place))
    }

    /// Depth to bone under every vertex of the surface, seen along z, mm.
    pub fn per_vertex(&self, surface: &Surface) -> Vec<f64> {
        let positions = surface.positions();
        let mut depths_mm = vec![0.0; positions.len()];
        parallel::fill(&mut depths_mm, positions, || {
            let mut reader = self.field.reader();
            move |p| reader.at(on_map(p.truncate()))
        });
        depths_mm
    }
}

/// Assumed depths over the landmarks of the built-in back: spinous processes and the edges of scapula and pelvis lie just
/// under the skin, transverse processes under the muscles beside the spine.
fn depth_over(kind: Kind, level: &str) -> f64 {
    let lumbar = level.starts_with('L');
    match kind {
        Kind::Spinous if lumbar => 8.0,
        Kind::Spinous => 6.0,
        Kind::Transverse if lumbar => 40.0,
        Kind::Transverse => 25.0,
        Kind::ScapulaInferiorAngle => 10.0,
        Kind::ScapulaSpine => 8.0,
        Kind::Psis => 7.0,
        Kind::IliacCrest => 12.0,
    }
}

/// Assumed depths where the built-in back has no landmark (x mirrored, y, depth), mm: shoulders, ribs beside the muscles,
/// flanks with no bone between ribs and pelvis, seat.
const BESIDE_LANDMARKS: [(f64, f64, f64); 14] = [
    (100.0, 420.0, 20.0),
    (170.0, 420.0, 25.0),
    (110.0, 340.0, 14.0),
    (60.0, 330.0, 22.0),
    (60.0, 260.0, 20.0),
    (110.0, 250.0, 15.0),
    (160.0, 340.0, 25.0),
    (160.0, 250.0, 22.0),
    (60.0, 190.0, 24.0),
    (130.0, 180.0, 22.0),
    (75.0, 125.0, 60.0),
    (140.0, 120.0, 80.0),
    (140.0, 60.0, 60.0),
    (110.0, 5.0, 45.0),
];

/// Keys for the built-in back. Assumed, not measured: orders of magnitude from surface anatomy, to be replaced by the
/// subject's own from ultrasound or imaging.
pub fn assumed_back_keys() -> Vec<BoneKey> {
    let landmarks = back::landmarks(&BackOptions::default());
    let over = landmarks.iter().map(|l| BoneKey {
        at: l.position_mm.truncate(),
        depth_mm: depth_over(l.kind, l.level),
    });
    let beside = BESIDE_LANDMARKS.iter().flat_map(|&(x, y, depth_mm)| {
        [-x, x].map(|x| BoneKey {
            at: Vec2::new(x, y),
            depth_mm,
        })
    });
    over.chain(beside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(x: f64, y: f64, depth_mm: f64) -> BoneKey {
        BoneKey {
            at: Vec2::new(x, y),
            depth_mm,
        }
    }

    #[test]
    fn the_assumed_back_is_met_at_its_keys_and_lies_between_them_elsewhere() {
        let keys = assumed_back_keys();
        let map = BoneMap::new(keys.clone()).unwrap();
        for k in &keys {
            assert_eq!(map.at(k.at), k.depth_mm, "{}", k.at);
        }
        for i in 0..60 {
            for j in 0..60 {
                let at = Vec2::new(f64::from(i) * 7.0 - 210.0, f64::from(j) * 9.0 - 30.0);
                assert!((6.0..=80.0).contains(&map.at(at)), "{at}");
                assert!(
                    (map.at(at) - map.at(at * Vec2::new(-1.0, 1.0))).abs() < 1e-9,
                    "{at}"
                );
            }
        }
        // Shallow along the spine, deep in the flank.
        assert!((0..40).all(|i| map.at(Vec2::new(0.0, 46.0 + 10.0 * f64::from(i))) < 14.0));
        assert!(map.at(Vec2::new(140.0, 110.0)) > 60.0);
        let surface = Surface::new(back::make(&BackOptions::with_triangles(500)))
            .unwrap()
            .0;
        for (p, depth) in surface.positions().iter().zip(map.per_vertex(&surface)) {
            assert_eq!(depth, map.at(p.truncate()));
        }
    }

    #[test]
    fn keys_that_are_not_allowed_are_told_by_number() {
        let told = |keys: &[BoneKey]| BoneMap::new(keys.to_vec()).unwrap_err().to_string();
        assert!(told(&[]).contains("has no keys"));
        let good = key(0.0, 0.0, 10.0);
        assert_eq!(
            told(&[good, key(1.0, 2.0, 0.5)]),
            "bone key 2 at (1, 2) mm: depth_mm is 0.5; 1 to 500 is allowed"
        );
        assert!(told(&[key(0.0, 0.0, f64::NAN)]).contains("depth_mm is NaN"));
        assert!(
            told(&[good, key(f64::NAN, 0.0, 5.0)])
                .contains("bone key 2 at (NaN, 0) mm: coordinates")
        );
        assert_eq!(
            told(&[good, key(9.0, 0.0, 5.0), key(0.0, 0.0, 12.0)]),
            "bone keys 1 and 3 are both at (0, 0) mm but state 10 and 12 mm; keep one of them"
        );
        assert_eq!(
            BoneMap::new(vec![good, good])
                .unwrap()
                .at(Vec2::splat(f64::NAN)),
            10.0
        );
    }
}
