//! The height of the back over the map plane.

use super::BackOptions;
use super::landmarks::{LEVELS, Levels};

/// Height of the back, mm, as a twice differentiable function of the map plane.
///
/// A uniform cubic B-spline with the 5 mm samples as control values: it smooths the facets of the mesh that was sampled
/// and does not pass through the samples. It stays within 0.36 mm of them up to 72 mm from the midline (RMS 0.06 mm) and
/// within 1.1 mm out to the rim on the steep flanks (y from 10 to 465 mm), and continues smoothly past them. On top of
/// it stand the parts that the samples lack: spinous processes and dimples.
#[derive(Clone, Debug)]
pub struct Heights {
    samples: Grid,
    bumps: Vec<Bump>,
    scoliosis_mm: f64,
}

/// Spacing of the samples, mm.
const STEP_MM: f64 = 5.0;
const HEIGHTS_CSV: &str = include_str!("../../../assets/back/heights.csv");

/// Samples for x ≥ 0, row by row from y = 0, with a margin filled in around those known.
#[derive(Clone, Debug)]
struct Grid {
    columns: usize,
    rows: usize,
    z_mm: Vec<f64>,
}

/// A Gaussian elevation.
#[derive(Clone, Copy, Debug)]
struct Bump {
    x_mm: f64,
    y_mm: f64,
    height_mm: f64,
    /// Standard deviations across and along, mm.
    across_mm: f64,
    along_mm: f64,
}

/// Full width at half height of a Gaussian over its standard deviation, 2 √(2 ln 2).
const FWHM_OVER_SD: f64 = 2.354_820_045_030_949;
/// Beyond this many standard deviations a bump is below 1e-6 of its height and left out.
const BUMP_REACH: f64 = 5.3;

/// Half the width of a spinous process at half height, mm: skin and fat over it spread its edge.
const SPINOUS_HALF_WIDTH_MM: f64 = 5.0;
/// Its length as a share of the spacing of the levels.
const SPINOUS_LENGTH: f64 = 0.42;
/// Place and width of the dimples over the posterior superior iliac spines, mm.
const PSIS: (f64, f64, f64) = (38.0, 10.0, 16.0);

impl Heights {
    /// The heights under `options`, unscaled: size and girth are applied to finished points.
    pub fn new(options: &BackOptions) -> Self {
        let finite = |x: f64| {
            if x.is_finite() {
                x.clamp(-50.0, 50.0)
            } else {
                0.0
            }
        };
        let mut bumps = Vec::new();
        let levels = Levels::get();
        for (i, level) in LEVELS.iter().enumerate() {
            let height_mm = match *level {
                "C7" | "L5" => continue,
                "T1" => 1.5 * finite(options.thoracic_bump_mm),
                l if l.starts_with('T') => finite(options.thoracic_bump_mm),
                _ => finite(options.lumbar_bump_mm),
            };
            let spacing_mm = levels.spinous_y_mm[i] - levels.spinous_y_mm[i + 1];
            bumps.push(Bump {
                x_mm: 0.0,
                y_mm: levels.spinous_y_mm[i],
                height_mm,
                across_mm: 2.0 * SPINOUS_HALF_WIDTH_MM / FWHM_OVER_SD,
                along_mm: SPINOUS_LENGTH * spacing_mm / FWHM_OVER_SD,
            });
        }
        let (x_mm, y_mm, width_mm) = PSIS;
        for x_mm in [-x_mm, x_mm] {
            let sd_mm = width_mm / FWHM_OVER_SD;
            let height_mm = -finite(options.psis_dimple_mm);
            bumps.push(Bump {
                x_mm,
                y_mm,
                height_mm,
                across_mm: sd_mm,
                along_mm: sd_mm,
            });
        }
        Self {
            samples: Grid::read(),
            bumps,
            scoliosis_mm: finite(options.scoliosis_mm),
        }
    }

    /// Height at a place of the map plane, mm. Finite everywhere; past the samples it continues their border.
    pub fn at(&self, x_mm: f64, y_mm: f64) -> f64 {
        let x = x_mm - self.shift_mm(x_mm, y_mm);
        // Folded, so that both sides are the same to the last bit.
        let mut z_mm = self.samples.spline(x.abs(), y_mm);
        for b in &self.bumps {
            let (u, v) = ((x - b.x_mm) / b.across_mm, (y_mm - b.y_mm) / b.along_mm);
            if u.abs() < BUMP_REACH && v.abs() < BUMP_REACH {
                z_mm += b.height_mm * libm::exp(-0.5 * (u * u + v * v));
            }
        }
        z_mm
    }

    /// How far to the right the curved spine has carried the skin that is now at a place, mm: an S between L5 and C7,
    /// fading to the flanks. [`Heights::carried_x_mm`] goes the other way.
    pub fn shift_mm(&self, x_mm: f64, y_mm: f64) -> f64 {
        if self.scoliosis_mm == 0.0 {
            return 0.0;
        }
        let levels = Levels::get();
        let (low, high) = (
            levels.spinous_y_mm[LEVELS.len() - 1],
            levels.spinous_y_mm[0],
        );
        let along = ((y_mm - low) / (high - low)).clamp(0.0, 1.0);
        let flank = x_mm / 90.0;
        -self.scoliosis_mm * libm::sin(std::f64::consts::TAU * along) * libm::exp(-flank * flank)
    }

    /// Where the skin that lies at `x_mm` on the straight back lies on this one, mm to the right.
    ///
    /// The shift changes by less than half a millimetre per millimetre even for the largest curve allowed (50 mm), so that
    /// the iteration halves the error each time.
    pub fn carried_x_mm(&self, x_mm: f64, y_mm: f64) -> f64 {
        (0..60).fold(x_mm, |x, _| x_mm + self.shift_mm(x, y_mm))
    }
}

impl Grid {
    fn read() -> Self {
        let mut known: Vec<Vec<Option<f64>>> = Vec::new();
        for line in HEIGHTS_CSV.lines().filter(|l| !l.starts_with('#')).skip(1) {
            known.push(
                line.split(',')
                    .skip(1)
                    .map(|cell| cell.parse().ok())
                    .collect(),
            );
        }
        let (rows, columns) = (known.len(), known.first().map_or(0, Vec::len));
        let mut z: Vec<Option<f64>> = known.into_iter().flatten().collect();
        z.resize(rows * columns, None);
        while z.iter().any(Option::is_none) {
            let before = z.clone();
            for row in 0..rows as isize {
                for column in 0..columns as isize {
                    let i = row as usize * columns + column as usize;
                    if before[i].is_none() {
                        z[i] = continued(&before, rows as isize, columns as isize, row, column);
                    }
                }
            }
            if z == before {
                z.iter_mut().for_each(|cell| *cell = cell.or(Some(0.0)));
            }
        }
        Self {
            columns,
            rows,
            z_mm: z.into_iter().flatten().collect(),
        }
    }

    /// A sample, mirrored over the midline and continued straight past the other three borders.
    fn sample(&self, column: isize, row: isize) -> f64 {
        let column = column.unsigned_abs();
        let at = |c: usize, r: usize| self.z_mm[r * self.columns + c];
        let along_row = |r: usize| match column.checked_sub(self.columns - 1) {
            None | Some(0) => at(column, r),
            Some(past) => {
                let (last, before) = (at(self.columns - 1, r), at(self.columns - 2, r));
                last + (last - before) * past.min(8) as f64
            }
        };
        let top = self.rows as isize - 1;
        let nearest = row.clamp(0, top);
        let past = (row - nearest).clamp(-8, 8) as f64;
        let inner = if nearest == 0 { 1 } else { nearest - 1 };
        let slope = if past == 0.0 {
            0.0
        } else {
            (along_row(nearest as usize) - along_row(inner as usize)).abs()
        };
        along_row(nearest as usize) - slope * past.abs()
    }

    /// Uniform cubic B-spline over the samples, mm.
    fn spline(&self, x_mm: f64, y_mm: f64) -> f64 {
        let cell = |v: f64| {
            let v = (v / STEP_MM).clamp(-1000.0, 1000.0);
            let floor = v.floor();
            (floor as isize, weights(v - floor))
        };
        let ((column, across), (row, along)) = (cell(x_mm), cell(y_mm));
        let mut z_mm = 0.0;
        for (j, wy) in along.iter().enumerate() {
            let mut line = 0.0;
            for (i, wx) in across.iter().enumerate() {
                line += wx * self.sample(column + i as isize - 1, row + j as isize - 1);
            }
            z_mm += wy * line;
        }
        z_mm
    }
}

/// Weights of the four samples around a place a fraction `t` between the middle two.
fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ]
}

/// A value for an unknown sample beside known ones: the mean of what the straight lines through them continue to.
fn continued(
    z: &[Option<f64>],
    rows: isize,
    columns: isize,
    row: isize,
    column: isize,
) -> Option<f64> {
    let get = |r: isize, c: isize| {
        // The midline mirrors.
        let c = c.abs();
        if r < 0 || r >= rows || c >= columns {
            None
        } else {
            z[(r * columns + c) as usize]
        }
    };
    let (mut sum, mut n) = (0.0, 0.0);
    for (dr, dc) in [
        (0, -1),
        (0, 1),
        (-1, 0),
        (1, 0),
        (-1, -1),
        (-1, 1),
        (1, -1),
        (1, 1),
    ] {
        if let (Some(near), Some(far)) = (
            get(row + dr, column + dc),
            get(row + 2 * dr, column + 2 * dc),
        ) {
            sum += near + (near - far);
            n += 1.0;
        }
    }
    (n > 0.0).then(|| sum / n)
}
