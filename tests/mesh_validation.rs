//! Every broken mesh in `tests/data` is told for what it is, by the library and by `dorsum mesh validate`.

use dorsum::surface::{Defect, Report, Surface, io};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(file)
}

fn dorsum(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dorsum"));
    command.args(arguments).output().expect("runs")
}

fn validate(file: &str, more: &[&str]) -> (Option<i32>, String, String) {
    let path = data(file);
    let path = path.to_str().expect("a plain path");
    let output = dorsum(&[&["mesh", "validate", path], more].concat());
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_string();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

fn repaired(file: &str) -> (Surface, Report) {
    let (raw, _) = io::read(&data(file), None).expect("readable");
    let (surface, report) = Surface::new(raw).expect("repairable");
    surface.check().expect("keeps its promises");
    (surface, report)
}

/// Files that are repaired or remarked on, with the only line told about each, and the last line.
const USABLE: &[(&str, &str, &str)] = &[
    (
        "degenerate_triangles.obj",
        "2 triangles without area, removed: 2 at (50.00, 0.00, 0.00), 5 at (0.00, 0.00, 0.00)",
        "repaired",
    ),
    (
        "duplicate_triangles.obj",
        "2 triangles with the corners of an earlier one, removed: 8 at (-100.00, -50.00, 13.33), 9 at (",
        "repaired",
    ),
    (
        "coincident_vertices.obj",
        "1 vertex at the place of an earlier one, joined to it: 9 at (0.00, 0.00, 40.00)",
        "repaired",
    ),
    (
        "flipped_triangle.obj",
        "1 triangle against the orientation of the neighbours, turned: 5 at (-100.00, 100.00, 13.33)",
        "repaired",
    ),
    (
        "facing_inward.obj",
        "1 open component facing into the back, turned (named by the first triangle): 0 at (",
        "repaired",
    ),
    (
        "inside_out.obj",
        "1 closed component inside out, turned (named by the first triangle): 0 at (100.00, 100.00, 0.00)",
        "repaired",
    ),
    (
        "unused_vertex.obj",
        "1 vertex of no triangle, dropped: 9 at (0.00, 0.00, 300.00)",
        "repaired",
    ),
    (
        "several_components.obj",
        "2 components, not one, kept: 8, 1 triangles",
        "usable as it is",
    ),
    (
        "hole.obj",
        "1 hole besides the rim, kept: the longest has 4 edges, 400.0 mm, at (",
        "usable as it is",
    ),
];

/// Files that are refused, with what is told.
const REFUSED: &[(&str, &str)] = &[
    (
        "not_finite.obj",
        "vertex 4 has a coordinate that is not finite (NaN); all must be finite",
    ),
    (
        "absurd_coordinate.obj",
        "vertex 7 has the coordinate 1e8 mm; allowed is −1e7 to 1e7 mm",
    ),
    (
        "index_out_of_range.ply",
        "triangle 3 names vertex 42; the mesh has 9 vertices, counted from 0",
    ),
    (
        "nothing_left.obj",
        "none of the 2 triangles has an area; at least one is needed",
    ),
    (
        "empty.obj",
        "the mesh has no triangles; at least one is needed",
    ),
    (
        "truncated.stl",
        "not a sound STL mesh: its header claims 8 triangles, the file has room for 3",
    ),
    (
        "lying_header.ply",
        "not a sound PLY mesh: its header claims 4000000000 of element vertex; the file is too short for that",
    ),
];

#[test]
fn every_repairable_mesh_is_told_for_its_one_defect() {
    for (file, line, verdict) in USABLE {
        let (surface, report) = repaired(file);
        assert!(report.to_string().starts_with(line), "{file}: {report}");
        assert_eq!(report.defects.len(), 1, "{file}: {report}");
        assert!(!report.is_clean());
        assert_eq!(report.is_repaired(), *verdict == "repaired", "{file}");
        assert!(surface.triangles().len() >= 2);
        let (code, out, _) = validate(file, &[]);
        assert_eq!(code, Some(0), "{file}");
        assert!(
            out.lines().nth(1).expect("a line").starts_with(line),
            "{file}: {out}"
        );
        assert_eq!(out.lines().last(), Some(*verdict), "{file}");
        assert_eq!(validate(file, &["--strict"]).0, Some(1), "{file}");
    }
}

#[test]
fn sheets_that_touch_where_they_should_not_come_apart() {
    let (surface, report) = repaired("non_manifold_edge.obj");
    assert!(report.to_string().starts_with("1 edge with more than two triangles, cut so that each sheet is one of its own: 4–7 (3 triangles) at (0.00, 75.00, 40.00)"));
    assert_eq!(
        report
            .components
            .iter()
            .map(|c| c.triangles)
            .collect::<Vec<_>>(),
        [8, 1]
    );
    assert_eq!(surface.positions().len(), 12);
    let (surface, report) = repaired("bow_tie.obj");
    assert!(report.to_string().starts_with(
        "1 vertex in which sheets touch in a point, doubled: 0 at (0.00, 0.00, 0.00)"
    ));
    assert!(matches!(
        report.defects[1],
        Defect::SeveralComponents { count: 2, .. }
    ));
    assert_eq!(surface.positions().len(), 6);
}

#[test]
fn a_band_with_one_side_is_cut_once_and_made_to_face_one_way() {
    let (surface, report) = repaired("moebius.obj");
    let line = "1 edge across which the sheet turns into its other side, cut: ";
    assert!(report.to_string().starts_with(line), "{report}");
    assert_eq!(
        (surface.triangles().len(), surface.positions().len()),
        (16, 18)
    );
    assert_eq!((report.n_components, report.n_rims), (1, 1));
}

#[test]
fn every_hopeless_mesh_is_refused_in_one_line() {
    for (file, line) in REFUSED {
        let (code, out, error) = validate(file, &["--units", "mm"]);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{file}");
        assert!(
            error.starts_with(&format!("dorsum: {line}: ")),
            "{file}: {error}"
        );
        assert!(
            error.ends_with(file) && !error.contains('\n'),
            "{file}: {error}"
        );
    }
}

#[test]
fn sound_meshes_are_clean_even_when_strict() {
    for (file, triangles) in [("clean.obj", 8), ("soup.stl", 8), ("metres.obj", 8)] {
        assert_eq!(repaired(file).0.triangles().len(), triangles);
        let (code, out, _) = validate(file, &["--strict"]);
        assert_eq!(
            (code, out.lines().last()),
            (Some(0), Some("clean")),
            "{file}"
        );
    }
    assert!(
        validate("soup.stl", &[])
            .1
            .contains("24 corners shared no vertex: joined into 9")
    );
    assert!(
        validate("metres.obj", &[])
            .1
            .starts_with("units: m, guessed")
    );
    assert!(
        validate("metres.obj", &["--units", "inch"])
            .1
            .starts_with("units: inch, as stated")
    );
}

#[test]
fn every_file_in_the_folder_is_tested_here() {
    let sound = [
        "clean.obj",
        "soup.stl",
        "metres.obj",
        "non_manifold_edge.obj",
        "bow_tie.obj",
        "moebius.obj",
    ];
    let mut named: Vec<&str> = USABLE.iter().map(|u| u.0).collect();
    named.extend(REFUSED.iter().map(|r| r.0));
    named.extend(sound);
    named.sort_unstable();
    let folder = std::fs::read_dir(data("")).expect("a folder");
    let mut there: Vec<_> = folder
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .filter(|name| {
            Path::new(name)
                .extension()
                .is_some_and(|e| ["obj", "ply", "stl"].map(|x| x.as_ref()).contains(&e))
        })
        .collect();
    there.sort_unstable();
    assert_eq!(there, named);
}

#[test]
fn json_is_one_document_with_units_and_defects() {
    let (code, out, _) = validate("hole.obj", &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).expect("one document");
    assert_eq!(code, Some(0));
    assert_eq!(json["verdict"], "remarks");
    assert_eq!(json["units"]["unit"], "mm");
    assert_eq!(json["defects"][0]["kind"], "holes");
    assert_eq!(json["rims"][0]["edges"], 12);
}

#[test]
fn info_measures_the_mesh() {
    let path = data("hole.obj");
    let output = dorsum(&["mesh", "info", path.to_str().expect("plain"), "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one document");
    let number = |key: &str| json[key].as_f64().expect("a number");
    assert_eq!((number("vertices"), number("triangles")), (16.0, 16.0));
    assert!((number("area_mm2") - 80_000.0).abs() < 1e-9);
    assert_eq!(
        (number("edge_min_mm"), number("edge_median_mm")),
        (100.0, 100.0)
    );
    assert!((number("edge_max_mm") - 20_000_f64.sqrt()).abs() < 1e-12);
    assert!((number("smallest_angle_deg") - 45.0).abs() < 1e-12);
    assert_eq!((number("n_rims"), number("n_components")), (2.0, 1.0));
    assert_eq!(json["bounds_max_mm"][0], 150.0);
    let text = dorsum(&["mesh", "info", path.to_str().expect("plain")]).stdout;
    let text = String::from_utf8(text).expect("text");
    assert!(
        text.contains("rim              12 edges, 1200.0 mm; 1 other loop"),
        "{text}"
    );
}

#[test]
fn the_built_in_back_is_written_clean() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("back.ply");
    let out = out.to_str().expect("plain");
    for more in [&[][..], &["--ascii"][..]] {
        let made = dorsum(&[&["mesh", "make", "--triangles", "3000", "--out", out], more].concat());
        assert!(made.status.success());
        let (code, told, error) = {
            let output = dorsum(&["mesh", "validate", "--strict", out]);
            let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
            (
                output.status.code(),
                text(output.stdout),
                text(output.stderr),
            )
        };
        assert_eq!(code, Some(0), "{told}{error}");
        assert!(told.starts_with("units: mm, as the file says"), "{told}");
    }
    let refused = dorsum(&["mesh", "make", "--out", "back.obj"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn a_scenario_reads_its_mesh_and_tells_units_and_defects() {
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = folder.path().join("a.toml");
    let text = "format = 1\nname = \"a\"\n[surface]\nmesh = \"flipped_triangle.obj\"\nunits = \"cm\"\n\
        [stiffness]\nconstant_n_per_mm = 0.5\n";
    std::fs::write(&scenario, text).expect("written");
    std::fs::copy(
        data("flipped_triangle.obj"),
        folder.path().join("flipped_triangle.obj"),
    )
    .expect("copied");
    let output = dorsum(&["scene", scenario.to_str().expect("plain"), "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one document");
    assert_eq!(json["units"]["unit"], "cm");
    assert_eq!(json["units"]["source"], "stated");
    assert_eq!(json["defects"][0]["kind"], "flipped_triangles");
    std::fs::remove_file(folder.path().join("flipped_triangle.obj")).expect("removed");
    let output = dorsum(&["scene", scenario.to_str().expect("plain")]);
    assert_eq!(output.status.code(), Some(2));
}
