//! Mesh files: what is written is read back; what is damaged is told in one line, without a panic, without more time or
//! memory than the file is worth.

// Counting what a parser allocates needs an allocator.
#![allow(unsafe_code)]

mod mesh_samples;

use dorsum::geom::Vec3;
use dorsum::surface::io::ply::{self, Field, PlyEncoding, WriteError};
use dorsum::surface::io::{self, Format, UnitsSource};
use dorsum::surface::{RawMesh, Surface};
use dorsum::units::LengthUnit;
use mesh_samples::{obj_text, ply_binary, sheet, stl_binary, stl_text};
use proptest::prelude::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Counts the bytes the thread holds, and their peak.
struct Counting;

thread_local! {
    static HELD: Cell<usize> = const { Cell::new(0) };
    static PEAK: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: hands everything to the system's allocator and only counts.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let held = HELD.get().saturating_add(layout.size());
        HELD.set(held);
        PEAK.set(PEAK.get().max(held));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.set(HELD.get().saturating_sub(layout.size()));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn ply_written(mesh: &RawMesh, encoding: PlyEncoding) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ply");
    let values: Vec<f64> = mesh.positions.iter().map(|p| p.x * 0.1).collect();
    let fields = [Field {
        name: "strain",
        values: &values,
    }];
    ply::write(&path, &mesh.positions, &mesh.triangles, &fields, encoding).expect("written");
    std::fs::read(path).expect("there")
}

fn parsed(bytes: Vec<u8>, units: Option<LengthUnit>) -> RawMesh {
    let (mesh, _) = io::parse(bytes, None, units).expect("sound");
    mesh
}

fn told(bytes: &[u8], expected: Format) -> String {
    let error = io::parse(bytes.to_vec(), Some(expected), None).expect_err("damaged");
    error.to_string()
}

/// The same places in the same triangles, whatever the numbering and the first corner.
fn same_faces(a: &RawMesh, b: &RawMesh) -> bool {
    let faces = |mesh: &RawMesh| {
        let mut faces: Vec<_> = (mesh.triangles.iter())
            .map(|t| {
                let mut places = t.map(|v| mesh.positions[v as usize].to_array().map(f64::to_bits));
                let least = (0..3).min_by_key(|&i| places[i]).unwrap_or(0);
                places.rotate_left(least);
                places
            })
            .collect();
        faces.sort_unstable();
        faces
    };
    faces(a) == faces(b)
}

fn rounded(mesh: &RawMesh) -> RawMesh {
    RawMesh {
        positions: mesh
            .positions
            .iter()
            .map(|p| p.as_vec3().as_dvec3())
            .collect(),
        triangles: mesh.triangles.clone(),
    }
}

#[test]
fn every_format_gives_the_same_sheet() {
    let sheet = sheet();
    assert_eq!(parsed(obj_text(&sheet).into_bytes(), None), sheet);
    assert!(same_faces(
        &parsed(stl_text(&sheet).into_bytes(), None),
        &rounded(&sheet)
    ));
    assert!(same_faces(
        &parsed(stl_binary(&sheet), None),
        &rounded(&sheet)
    ));
    for encoding in [PlyEncoding::Ascii, PlyEncoding::BinaryLittleEndian] {
        assert_eq!(parsed(ply_written(&sheet, encoding), None), sheet);
    }
    for little in [true, false] {
        let mesh = parsed(ply_binary(&sheet, little), None);
        assert_eq!(mesh.positions, sheet.positions);
        assert_eq!(mesh.triangles.len(), sheet.triangles.len());
        let (surface, report) = Surface::new(mesh).expect("sound");
        surface.check().expect("keeps its promises");
        assert!(report.is_clean());
    }
}

#[test]
fn the_content_decides_and_the_extension_does_not() {
    let sheet = sheet();
    for expected in [Format::Obj, Format::Ply, Format::Stl] {
        for bytes in [
            obj_text(&sheet).into_bytes(),
            stl_text(&sheet).into_bytes(),
            stl_binary(&sheet),
            ply_binary(&sheet, true),
        ] {
            let (mesh, _) = io::parse(bytes, Some(expected), None).expect("sound");
            assert_eq!(mesh.triangles.len(), 18);
        }
    }
}

#[test]
fn units_are_stated_named_by_the_file_or_guessed() {
    let mut sheet = sheet();
    for p in &mut sheet.positions {
        *p /= 1000.0;
    }
    let text = obj_text(&sheet).into_bytes();
    let (mesh, found) = io::parse(text.clone(), None, None).expect("sound");
    assert_eq!(
        (found.unit, found.source),
        (LengthUnit::M, UnitsSource::Guessed)
    );
    assert!((mesh.positions[3].x - 210.3).abs() < 1e-4);
    let (mesh, found) = io::parse(text, None, Some(LengthUnit::Inch)).expect("sound");
    assert_eq!(found.source, UnitsSource::Stated);
    assert!((mesh.positions[3].x - 0.2103 * 25.4).abs() < 1e-6);
    // Our own files say mm, however small the mesh.
    let bytes = ply_written(&sheet, PlyEncoding::Ascii);
    let (mesh, found) = io::parse(bytes, None, None).expect("sound");
    assert_eq!(
        (found.unit, found.source),
        (LengthUnit::Mm, UnitsSource::File)
    );
    assert_eq!(mesh, sheet);
}

#[test]
fn odd_but_legal_files_are_read() {
    let obj = "v 0 0 0 1 0 0\nv 10 0 0 2\r\nv 5 5 0\n v\t0 5 0 0.5 0.5 0.5 # colour\nf -4 -3 \\\n -2 -1\nl 1 2\n";
    let mesh = parsed(obj.as_bytes().to_vec(), Some(LengthUnit::Mm));
    assert_eq!(mesh.positions[1], Vec3::new(5.0, 0.0, 0.0));
    assert_eq!(mesh.triangles.len(), 2);
    let two = format!(
        "  SOLID\r\n{}\nsolid b\nendsolid",
        stl_text(&sheet()).split_once('\n').expect("lines").1
    )
    .replace("facet", "FACET");
    assert_eq!(parsed(two.clone().into_bytes(), None).triangles.len(), 18);
    let twice = format!("{}{}", stl_text(&sheet()), two);
    assert_eq!(parsed(twice.into_bytes(), None).triangles.len(), 36);
    let mut trailing = stl_binary(&sheet());
    trailing.extend([1, 2, 3]);
    let (mesh, _) = io::parse(trailing, Some(Format::Stl), None).expect("sound");
    assert_eq!(mesh.triangles.len(), 18);
    let faces_first = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar uchar vertex_indices\nelement vertex 5\n\
        property short x\nproperty float y\nproperty int z\nend_header\n5 0 1 2 3 4\n\n0 0 0\n300 0 0\n300 300 0\n150 60 0\n0 300.5e0 0";
    let mesh = parsed(faces_first.as_bytes().to_vec(), None);
    assert_eq!(mesh.triangles.len(), 3);
    assert!(
        mesh.triangles.iter().all(|t| t.contains(&3)),
        "ears of a concave pentagon"
    );
}

#[test]
fn damaged_files_are_told_where() {
    let ply = |body: &str| format!("ply\nformat {body}");
    let vertices = "property float x\nproperty float y\nproperty float z\n";
    let faces = "property list uchar int vertex_indices\nend_header\n";
    for (format, text, expected) in [
        (
            Format::Obj,
            "v 0 0 0\nv 1 0 0\nv 0 1 x\n".into(),
            "line 3: position parse error",
        ),
        (
            Format::Obj,
            "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n".into(),
            "line 5: a face names vertex 4; the file has vertices 1 to 3",
        ),
        (
            Format::Obj,
            "v 0 0 0\nf 0 1 1\n".into(),
            "line 2: a face names vertex 0",
        ),
        (
            Format::Obj,
            "v 0 0 0\nf -2 1 1\n".into(),
            "line 2: a face names vertex -2",
        ),
        (
            Format::Obj,
            "v 0 0 0\nf 1 1.5 1\n".into(),
            "line 2: face parse error",
        ),
        (
            Format::Obj,
            "v 0 0 0\nf 1 1\n".into(),
            "line 2: a face with 2 corners; it needs 3 or more",
        ),
        (Format::Ply, ply("ascii 1.0\n"), "no line end_header"),
        (
            Format::Ply,
            ply(&format!(
                "ascii 1.0\nelement vertex 4000000000\n{vertices}end_header\n"
            )),
            "its header claims 4000000000 of element vertex; the file is too short",
        ),
        (
            Format::Ply,
            ply("binary_little_endian 1.0\nelement foo 4000000000000\nend_header\n"),
            "its element foo has no properties",
        ),
        (
            Format::Ply,
            ply("ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n"),
            "its vertices have no number y",
        ),
        (
            Format::Ply,
            ply(&format!(
                "ascii 1.0\nelement vertex 1\n{vertices}element face 1\n{faces}0 0 0\n3 0 0 -7\n"
            )),
            "face 0 of 1: vertex -7; none is negative",
        ),
        (
            Format::Ply,
            ply(&format!(
                "ascii 1.0\nelement vertex 1\n{vertices}element face 1\n{faces}0 0 0\n2 0 0\n"
            )),
            "face 0 of 1: 2 corners; a face needs 3 or more",
        ),
        (
            Format::Ply,
            ply(&format!(
                "ascii 1.0\nelement vertex 3\n{vertices}element face 1\n{faces}0 0 0\n1 1 abc\n"
            )),
            "vertex 1 of 3: ",
        ),
        (
            Format::Ply,
            ply(&format!(
                "ascii 1.0\nelement vertex 3\n{vertices}element face 0\n{faces}0 0 0\n"
            )),
            "vertex 1 of 3: the file ends",
        ),
        (
            Format::Stl,
            "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 oops\n".into(),
            "after 0 triangles: ",
        ),
        (
            Format::Stl,
            "short".into(),
            "5 bytes; a binary file has at least 84",
        ),
    ] {
        let line = told(text.as_bytes(), format);
        assert!(line.contains(expected), "{line}\nshould tell: {expected}");
        assert!(!line.contains('\n'));
    }
    let mut cut = stl_binary(&sheet());
    cut.truncate(500);
    let line = told(&cut, Format::Stl);
    assert!(
        line.contains("claims 18 triangles, the file has room for 8"),
        "{line}"
    );
}

#[test]
fn files_that_are_no_mesh_are_told_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "Dear all,\nthe scan").expect("written");
    let line = io::read(&path, None).expect_err("no mesh").to_string();
    assert!(line.starts_with(
        "neither an OBJ, a PLY nor an STL mesh: it begins with \"Dear all, the scan\""
    ));
    assert!(line.ends_with("notes.txt"));
    let line = io::read(&folder.path().join("none.obj"), None)
        .expect_err("missing")
        .to_string();
    assert!(
        line.starts_with("cannot read the mesh: ") && line.ends_with("none.obj"),
        "{line}"
    );
    assert!(io::read(folder.path(), None).is_err());
}

#[test]
fn a_field_that_does_not_fit_is_refused_and_nothing_is_written() {
    let sheet = sheet();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ply");
    let values = vec![0.0; 16];
    let mut broken = values.clone();
    broken[3] = f64::NAN;
    for (name, values) in [
        ("strain", &values[..3]),
        ("x", &values),
        ("a b", &values),
        ("", &values),
        ("ok", &broken),
    ] {
        let fields = [Field { name, values }];
        let result = ply::write(
            &path,
            &sheet.positions,
            &sheet.triangles,
            &fields,
            PlyEncoding::Ascii,
        );
        assert!(matches!(result, Err(WriteError::Field { .. })), "{name}");
    }
    let result = ply::write(
        &folder.path().join("no/a.ply"),
        &sheet.positions,
        &[],
        &[],
        PlyEncoding::Ascii,
    );
    assert!(matches!(result, Err(WriteError::Io { .. })));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        0
    );
}

proptest! {
    #[test]
    fn what_is_written_is_read_back_to_the_bit(
        coordinates in prop::collection::vec(prop::array::uniform3(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO), 3..20),
        corners in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..20),
        ascii in any::<bool>(),
    ) {
        let n = coordinates.len();
        let mesh = RawMesh {
            positions: coordinates.into_iter().map(Vec3::from_array).collect(),
            triangles: corners.iter().map(|c| c.map(|i| i.index(n) as u32)).collect(),
        };
        let encoding = if ascii { PlyEncoding::Ascii } else { PlyEncoding::BinaryLittleEndian };
        let read = parsed(ply_written(&mesh, encoding), None);
        prop_assert_eq!(&read.triangles, &mesh.triangles);
        let bits = |mesh: &RawMesh| -> Vec<_> {
            mesh.positions.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
        };
        prop_assert_eq!(bits(&read), bits(&mesh));
    }
}

/// Small steps of a linear congruential generator (Knuth, MMIX).
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

/// What parsers stumble over.
const NASTY: &[&str] = &[
    "4294967295",
    "-1",
    "0",
    "1e999",
    "nan",
    "-inf",
    "18446744073709551616",
    "9223372036854775807",
    "-9223372036854775808",
    "\n",
    "\r",
    "\0",
    " ",
    "\\\n",
    "f 1 2 3\n",
    "v 0 0 0\n",
    "end_header\n",
    "element face 9\n",
    "property list uint uint vertex_indices\n",
    "solid ",
    "endsolid\n",
    "facet normal 0 0 0\n",
    "#",
    "/",
    "1/",
    "é",
    "\u{fffd}",
];

fn mutated(original: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..1 + dice.below(3) {
        let at = dice.below(bytes.len() + 1);
        let to = at + dice.below((bytes.len() - at).min(40) + 1);
        match dice.below(7) {
            0 => bytes.truncate(at),
            1 => (0..1 + dice.below(8)).for_each(|_| {
                let at = dice.below(bytes.len());
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << dice.below(8);
                }
            }),
            2 => {
                let noise: Vec<u8> = (0..dice.below(16)).map(|_| dice.below(256) as u8).collect();
                bytes.splice(at..at, noise);
            }
            3 => {
                let chunk = bytes[at..to].to_vec();
                bytes.splice(at..at, chunk);
            }
            4 => drop(bytes.drain(at..to)),
            5 => drop(bytes.splice(at..to, NASTY[dice.below(NASTY.len())].bytes())),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = [0, 255, b'9', b'-', b' '][dice.below(5)];
                }
            }
        }
    }
    bytes
}

fn survives_10_000_mutations(original: Vec<u8>, expected: Format) {
    /// What a reader may take beside what the file's own size asks for, bytes.
    const SPARE: usize = 1 << 20;
    let mut dice = Dice(original.len() as u64);
    let (mut read, mut sound) = (0, 0);
    for i in 0..10_000 {
        let bytes = mutated(&original, &mut dice);
        let (len, before) = (bytes.len(), HELD.get());
        PEAK.set(before);
        let result = io::parse(bytes, Some(expected), None);
        let peak = PEAK.get().saturating_sub(before);
        assert!(
            peak < SPARE + 100 * len,
            "mutation {i}: {peak} bytes for a file of {len}"
        );
        let told = match result {
            Err(error) => error.to_string(),
            Ok((mesh, found)) => {
                read += 1;
                assert!(!found.to_string().contains('\n'));
                match Surface::new(mesh) {
                    Err(error) => error.to_string(),
                    Ok((surface, _)) => {
                        sound += 1;
                        if i % 16 == 0 {
                            surface.check().expect("keeps its promises");
                        }
                        "sound".into()
                    }
                }
            }
        };
        assert!(!told.is_empty() && told.len() < 600, "mutation {i}: {told}");
        assert!(!told.contains(char::is_control), "mutation {i}: {told:?}");
    }
    // Else the mutations would test the first line of the parser only.
    assert!(
        read > 100 && sound > 100 && read < 9_900,
        "{read} read, {sound} sound"
    );
}

#[test]
fn mutated_obj_files() {
    survives_10_000_mutations(obj_text(&sheet()).into_bytes(), Format::Obj);
}

#[test]
fn mutated_ascii_ply_files() {
    survives_10_000_mutations(ply_written(&sheet(), PlyEncoding::Ascii), Format::Ply);
}

#[test]
fn mutated_little_endian_ply_files() {
    survives_10_000_mutations(ply_binary(&sheet(), true), Format::Ply);
}

#[test]
fn mutated_big_endian_ply_files() {
    survives_10_000_mutations(ply_binary(&sheet(), false), Format::Ply);
}

#[test]
fn mutated_ascii_stl_files() {
    survives_10_000_mutations(stl_text(&sheet()).into_bytes(), Format::Stl);
}

#[test]
fn mutated_binary_stl_files() {
    survives_10_000_mutations(stl_binary(&sheet()), Format::Stl);
}
