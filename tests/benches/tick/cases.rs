//! The meshes that are touched, and the way over each.

use dorsum::geom::Vec3;
use dorsum::surface::primitives::{bench_height, bench_patch, bench_path, height_field};
use dorsum::surface::{RawMesh, io};
use dorsum::units::LengthUnit;
use std::f64::consts::TAU;

/// A mesh and the way over it.
pub struct Case {
    pub name: &'static str,
    pub mesh: RawMesh,
    /// Length of a millimetre of the benchmark in the coordinates of the mesh.
    pub unit: f64,
    /// The way over the surface in mm: time in s, height above it in mm.
    way: fn(f64, f64) -> Vec3,
}

impl Case {
    fn new(name: &'static str, mesh: RawMesh) -> Self {
        Self {
            name,
            mesh,
            unit: 1.0,
            way: bench_path,
        }
    }

    /// Where the device is `t_s` after the start, `offset_mm` above the surface, in the coordinates of the mesh.
    pub fn at(&self, t_s: f64, offset_mm: f64) -> Vec3 {
        (self.way)(t_s, offset_mm) * self.unit
    }

    /// Ticks of the approach from 30 mm above, not timed.
    pub fn approach(&self, offset_mm: f64) -> impl Iterator<Item = Vec3> {
        let first = (self.way)(0.0, 30.0);
        let down = move |i| (offset_mm - 30.0) * f64::from(i) / 299.0;
        (0..300).map(move |i| (first + Vec3::Z * down(i)) * self.unit)
    }

    /// How far a place lies below the surface that the mesh is cut from, mm.
    pub fn below_mm(&self, place: Vec3) -> f64 {
        let p = place / self.unit;
        bench_height(p.x, p.y) - p.z
    }
}

type Make = Box<dyn Fn() -> Case>;

/// All meshes with up to `largest` triangles, each made when its turn comes.
pub fn all(largest: usize) -> Vec<Make> {
    let mut all: Vec<(usize, Make)> = Vec::new();
    for n in [2962, 20_389, 41_582, 500_000, 2_000_000] {
        all.push((n, Box::new(move || Case::new("rows", bench_patch(n)))));
        all.push((n, Box::new(move || shuffled(n))));
    }
    all.push((41_582, Box::new(|| stated_in_metres(41_582))));
    all.push((41_582, Box::new(|| thousandth(41_582))));
    all.push((720_000, Box::new(tenth_of_a_millimetre)));
    let fits = all.into_iter().filter(|(n, _)| *n <= largest);
    fits.map(|(_, make)| make).collect()
}

/// With vertices and triangles in an order that tells nothing of where they are.
fn shuffled(n: usize) -> Case {
    let mesh = bench_patch(n);
    let mut seed = 1_u64;
    let mut below = |n: usize| {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 33) as usize) % n
    };
    let n = mesh.positions.len();
    let mut place: Vec<u32> = (0..n as u32).collect();
    for i in (1..n).rev() {
        place.swap(i, below(i + 1));
    }
    let mut positions = vec![Vec3::ZERO; n];
    for (i, &to) in place.iter().enumerate() {
        positions[to as usize] = mesh.positions[i];
    }
    let mut triangles: Vec<[u32; 3]> = (mesh.triangles.iter())
        .map(|t| t.map(|v| place[v as usize]))
        .collect();
    for i in (1..triangles.len()).rev() {
        triangles.swap(i, below(i + 1));
    }
    let mesh = RawMesh {
        positions,
        triangles,
    };
    Case::new("shuffled", mesh)
}

/// Written with coordinates in metres and read as such.
fn stated_in_metres(n: usize) -> Case {
    use io::ply::{PlyEncoding, write};
    let mesh = bench_patch(n);
    let metres: Vec<Vec3> = mesh.positions.iter().map(|p| *p / 1000.0).collect();
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("a folder: {e}"));
    let path = folder.path().join("metres.ply");
    let encoding = PlyEncoding::BinaryLittleEndian;
    write(&path, &metres, &mesh.triangles, &[], encoding).unwrap_or_else(|e| panic!("{e}"));
    let (mesh, _) = io::read(&path, Some(LengthUnit::M)).unwrap_or_else(|e| panic!("{e}"));
    Case::new("read from m", mesh)
}

/// Everything a thousandth of its size: the engine knows no unit.
fn thousandth(n: usize) -> Case {
    let mut mesh = bench_patch(n);
    for p in &mut mesh.positions {
        *p /= 1000.0;
    }
    Case {
        unit: 1e-3,
        ..Case::new("1/1000", mesh)
    }
}

/// A patch of 60 × 60 mm in cells of 0.1 mm, with a way of the benchmark's speed over it.
fn tenth_of_a_millimetre() -> Case {
    let way = |t_s: f64, offset_mm: f64| {
        let x = 60.0 + 25.0 * libm::sin(TAU * 1.28 * t_s);
        let y = 25.0 * libm::sin(TAU * 1.14 * t_s + 0.7);
        Vec3::new(x, y, bench_height(x, y) + offset_mm)
    };
    let mesh = height_field([30.0, 90.0], [-30.0, 30.0], [600; 2], 720_000, bench_height);
    Case {
        way,
        ..Case::new("0.1 mm cells", mesh)
    }
}
