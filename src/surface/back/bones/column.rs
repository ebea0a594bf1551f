//! The column: where each vertebra stands, which way it faces and how large it is.

use super::super::landmarks::{LEVELS, stored};
use super::under::Under;
use crate::geom::{Vec3, unit_or};

/// How many vertebrae there are.
const N: usize = LEVELS.len();

/// Sizes at some levels (number from C7, value): between them straight lines. Rounded from anatomy texts, adult male.
type Sizes<const K: usize> = [(f64, f64); K];

/// Half the width of the body, mm.
const HALF_WIDTH: Sizes<6> = [
    (0.0, 13.0),
    (2.0, 14.0),
    (5.0, 13.5),
    (9.0, 15.5),
    (12.0, 20.0),
    (17.0, 25.0),
];
/// Half its depth, mm.
const HALF_DEPTH: Sizes<5> = [
    (0.0, 8.5),
    (2.0, 9.5),
    (6.0, 13.0),
    (12.0, 16.0),
    (17.0, 17.5),
];
/// Half the width of the vertebral canal, mm.
const CANAL_HALF_WIDTH: Sizes<5> = [
    (0.0, 11.0),
    (4.0, 8.5),
    (9.0, 8.5),
    (12.0, 10.5),
    (17.0, 12.0),
];
/// From the skin over the column to the middle of the bodies, mm.
const DEPTH: Sizes<6> = [
    (0.0, 58.0),
    (2.0, 61.0),
    (5.0, 65.0),
    (9.0, 67.0),
    (13.0, 72.0),
    (17.0, 80.0),
];
/// From front to back of the canal, mm.
const CANAL_DEPTH_MM: f64 = 15.0;
/// Body height as a share of the distance between levels; the rest is disc.
const BODY_SHARE: f64 = 0.75;
/// Weights of neighbouring levels in the height of a body: the landmarks of transverse processes follow the rule of threes and
/// jump from level to level, bodies do not.
const WEIGHTS: [f64; 5] = [1.0, 2.0, 3.0, 2.0, 1.0];

/// One vertebra's frame and sizes. Lengths mm.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Middle of the body.
    pub origin_mm: Vec3,
    /// To the head, along the column.
    pub up: Vec3,
    /// To the back.
    pub back: Vec3,
    pub half_width_mm: f64,
    pub half_depth_mm: f64,
    pub half_height_mm: f64,
    pub canal_half_width_mm: f64,
    /// Back wall of the canal, from the origin.
    pub canal_back_mm: f64,
    /// Tip of the spinous process.
    pub spinous_mm: Vec3,
    /// Tip of the right transverse process.
    pub transverse_mm: Vec3,
}

impl Place {
    /// A place `x` to the right, `y` up and `z` to the back of the middle of the body, mm.
    pub fn at(&self, x: f64, y: f64, z: f64) -> Vec3 {
        self.origin_mm + Vec3::X * x + self.up * y + self.back * z
    }
}

/// The vertebrae from C7 to L5.
pub struct Column {
    pub places: [Place; N],
}

/// Depth of the tip of a spinous process, mm: assumed, as in the map of the depth to bone.
pub fn spinous_depth_mm(level: usize) -> f64 {
    if level > 12 { 8.0 } else { 6.0 }
}

/// The same for a transverse process.
fn transverse_depth_mm(level: usize) -> f64 {
    if level > 12 { 40.0 } else { 25.0 }
}

impl Column {
    /// Under a skin.
    pub fn new(under: &Under) -> Self {
        let mut spinous_y = [0.0; N];
        let mut transverse = [(0.0, 0.0); N];
        for (name, x, y) in stored() {
            for (i, level) in LEVELS.iter().enumerate() {
                match name.strip_prefix(level).map(str::trim_start) {
                    Some("spinous") => spinous_y[i] = y,
                    Some("transverse") => transverse[i] = (x, y),
                    _ => {}
                }
            }
        }
        // C7 has no such landmark: its process is as far out as that of T1, a little below the level of its spinous tip.
        transverse[0] = (transverse[1].0 - 1.0, spinous_y[0] - 4.0);
        let y = body_heights(&transverse);
        let middle = |i: usize| {
            let near = [-10.0, 0.0, 10.0].map(|dy| under.skin_mm(0.0, y[i] + dy));
            let skin = (near[0] + near[1] + near[2]) / 3.0;
            Vec3::new(0.0, y[i], skin - of(&DEPTH, i))
        };
        let middles: [Vec3; N] = std::array::from_fn(middle);
        let places = std::array::from_fn(|i| {
            let (above, below) = (i.saturating_sub(1), (i + 1).min(N - 1));
            let up = unit_or(middles[above] - middles[below], Vec3::Y);
            let gap = (middles[above] - middles[below]).length() / (below - above) as f64;
            let half_depth_mm = of(&HALF_DEPTH, i);
            let (x, y) = transverse[i];
            Place {
                origin_mm: middles[i],
                up,
                back: Vec3::X.cross(up),
                half_width_mm: of(&HALF_WIDTH, i),
                half_depth_mm,
                half_height_mm: 0.5 * BODY_SHARE * gap,
                canal_half_width_mm: of(&CANAL_HALF_WIDTH, i),
                canal_back_mm: half_depth_mm + CANAL_DEPTH_MM,
                spinous_mm: under.at(0.0, spinous_y[i], spinous_depth_mm(i)),
                transverse_mm: under.at(x, y, transverse_depth_mm(i)),
            }
        });
        Self { places }
    }
}

/// Heights of the middles of the bodies, mm: those of the transverse processes, smoothed. Past the ends they go on as before.
fn body_heights(transverse: &[(f64, f64); N]) -> [f64; N] {
    let at = |i: isize| {
        let last = N as isize - 1;
        let inner = transverse[i.clamp(0, last) as usize].1;
        let (first_step, last_step) = (
            transverse[0].1 - transverse[1].1,
            transverse[N - 2].1 - transverse[N - 1].1,
        );
        inner + first_step * (-i).max(0) as f64 - last_step * (i - last).max(0) as f64
    };
    let total: f64 = WEIGHTS.iter().sum();
    std::array::from_fn(|i| {
        let weighted = WEIGHTS.iter().enumerate();
        let sum: f64 = weighted
            .map(|(k, w)| w * at(i as isize + k as isize - 2))
            .sum();
        sum / total
    })
}

fn of<const K: usize>(sizes: &Sizes<K>, level: usize) -> f64 {
    let at = level as f64;
    let mut pairs = sizes.windows(2);
    let found = pairs.find(|p| at <= p[1].0);
    let [(x0, y0), (x1, y1)] = found.map_or([sizes[K - 2], sizes[K - 1]], |p| [p[0], p[1]]);
    y0 + (y1 - y0) * ((at - x0) / (x1 - x0)).clamp(0.0, 1.0)
}
