//! Depth below the skin of the back, and what keeps bones below it.

use super::super::{BackOptions, Heights, rim::Rim};
use crate::geom::Vec3;

/// Bones lie at least so far below the skin, mm along its normal as far as its slope at the place tells.
pub const CLEARANCE_MM: f64 = 4.0;
/// Width of the bend between a depth that is kept and one that is made larger, mm.
const BEND_MM: f64 = 2.0;
/// Half the step of the differences that give the slope, mm.
const SLOPE_STEP_MM: f64 = 2.0;

/// The skin as seen by what lies below it: the straight back, unscaled.
pub struct Under {
    options: BackOptions,
    straight: Heights,
    curved: Heights,
    rim: Rim,
}

impl Under {
    /// For the back made with `options`.
    pub fn new(options: &BackOptions) -> Self {
        let straight = Heights::new(&BackOptions {
            scoliosis_mm: 0.0,
            ..*options
        });
        Self {
            options: *options,
            rim: Rim::new(&straight),
            curved: Heights::new(options),
            straight,
        }
    }

    /// Height of the skin, mm.
    pub fn skin_mm(&self, x: f64, y: f64) -> f64 {
        self.straight.at(x, y)
    }

    /// A place `depth` mm below the skin, straight along z.
    pub fn at(&self, x: f64, y: f64, depth: f64) -> Vec3 {
        Vec3::new(x, y, self.skin_mm(x, y) - depth)
    }

    /// Whether a place of the map plane lies within the outline of the skin.
    pub fn is_covered(&self, x: f64, y: f64) -> bool {
        let points = &self.rim.points;
        let mut inside = false;
        for i in 0..points.len() {
            let (p, q) = (points[i], points[(i + 1) % points.len()]);
            if (p.1 <= y) != (q.1 <= y) && x < p.0 + (q.0 - p.0) * (y - p.1) / (q.1 - p.1) {
                inside = !inside;
            }
        }
        inside
    }

    /// How much deeper than it must a place lies, mm along z.
    pub fn room_mm(&self, p: Vec3) -> f64 {
        let slope = |dx: f64, dy: f64| {
            (self.skin_mm(p.x + dx, p.y + dy) - self.skin_mm(p.x - dx, p.y - dy))
                / (2.0 * SLOPE_STEP_MM)
        };
        let (sx, sy) = (slope(SLOPE_STEP_MM, 0.0), slope(0.0, SLOPE_STEP_MM));
        self.skin_mm(p.x, p.y) - p.z - CLEARANCE_MM * (1.0 + sx * sx + sy * sy).sqrt()
    }

    /// A place brought below the skin where it is not, carried along by the curve of the spine and brought to the subject's
    /// size.
    ///
    /// Along z, by a smooth function that rises with depth everywhere: what was closed stays closed, and inside stays inside.
    pub fn placed(&self, p: Vec3) -> Vec3 {
        let room = self.room_mm(p);
        let deeper = 0.5 * ((room * room + BEND_MM * BEND_MM).sqrt() - room);
        let x = self.curved.carried_x_mm(p.x, p.y);
        self.options.scaled(Vec3::new(x, p.y, p.z - deeper))
    }
}
