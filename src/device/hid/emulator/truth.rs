//! What an emulated device knows of itself, millisecond by millisecond, on a clock that every process of the machine shares.

use crate::geom::Vec3;
use std::io::{self, BufReader, BufWriter, Read as _, Write as _};
use std::path::Path;

/// One millisecond of the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// When, s of [`now_s`].
    pub at_s: f64,
    /// Where the tip was, mm, in the device's frame.
    pub position_mm: Vec3,
    /// Force of the currents that flowed, N.
    pub flowing_n: Vec3,
    /// Force that the newest command meant where the tip was when it came, N; zero once the board's watchdog took it off.
    pub commanded_n: Vec3,
    /// Number of the report that tells this place, 1 first; where this millisecond made none, that of the next one made.
    pub report: u64,
    /// Commands heard so far.
    pub heard: u64,
}

/// Numbers in a row of a file.
const NUMBERS: usize = 12;

impl Truth {
    fn numbers(&self) -> [f64; NUMBERS] {
        let [x, y, z] = self.position_mm.to_array();
        let [fx, fy, fz] = self.flowing_n.to_array();
        let [cx, cy, cz] = self.commanded_n.to_array();
        let (report, heard) = (self.report as f64, self.heard as f64);
        [self.at_s, x, y, z, fx, fy, fz, cx, cy, cz, report, heard]
    }

    fn of(row: &[f64; NUMBERS]) -> Self {
        let [at_s, x, y, z, fx, fy, fz, cx, cy, cz, report, heard] = *row;
        Self {
            at_s,
            position_mm: Vec3::new(x, y, z),
            flowing_n: Vec3::new(fx, fy, fz),
            commanded_n: Vec3::new(cx, cy, cz),
            report: report as u64,
            heard: heard as u64,
        }
    }
}

/// Seconds of a clock that does not jump and that all processes of this machine read alike, where the system has one (Linux);
/// elsewhere those since 1970.
pub fn now_s() -> f64 {
    #[cfg(target_os = "linux")]
    if let Ok(t) = nix::time::clock_gettime(nix::time::ClockId::CLOCK_MONOTONIC) {
        return t.tv_sec() as f64 + t.tv_nsec() as f64 * 1e-9;
    }
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0.0, |d| d.as_secs_f64())
}

/// Writes rows as they are: 12 numbers of 64 bits each, little-endian.
///
/// # Errors
/// The file cannot be written.
pub fn write(path: &Path, truths: &[Truth]) -> io::Result<()> {
    let mut file = BufWriter::new(std::fs::File::create(path)?);
    for truth in truths {
        for number in truth.numbers() {
            file.write_all(&number.to_le_bytes())?;
        }
    }
    file.flush()
}

/// Reads what [`write()`] wrote; a row that is cut off at the end is left out.
///
/// # Errors
/// The file cannot be read.
pub fn read(path: &Path) -> io::Result<Vec<Truth>> {
    let mut bytes = Vec::new();
    BufReader::new(std::fs::File::open(path)?).read_to_end(&mut bytes)?;
    let rows = bytes.chunks_exact(8 * NUMBERS).map(|row| {
        let mut numbers = [0.0; NUMBERS];
        for (number, bytes) in numbers.iter_mut().zip(row.chunks_exact(8)) {
            *number = bytes.try_into().map_or(0.0, f64::from_le_bytes);
        }
        Truth::of(&numbers)
    });
    Ok(rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_as_they_went_and_the_clock_goes_on() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("truth");
        let rows: Vec<Truth> = (0..5_u64)
            .map(|i| Truth {
                at_s: now_s(),
                position_mm: Vec3::new(i as f64, -0.1, 1e9),
                flowing_n: Vec3::X,
                commanded_n: Vec3::Y,
                report: i,
                heard: 1 << 40,
            })
            .collect();
        assert!(rows.is_sorted_by_key(|r| r.at_s));
        write(&path, &rows).expect("written");
        assert_eq!(read(&path).expect("read"), rows);
    }
}
