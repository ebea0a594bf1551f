use super::flat::has_area;
use super::*;
use crate::surface::Surface;
use proptest::prelude::*;

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> RawMesh {
    RawMesh {
        positions: positions.iter().map(|&p| Vec3::from_array(p)).collect(),
        triangles: triangles.to_vec(),
    }
}

fn grid(n: u32) -> RawMesh {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut mesh = RawMesh::default();
    for j in 0..=n {
        for i in 0..=n {
            let (x, y) = (f64::from(i) * 10.0, f64::from(j) * 10.0);
            mesh.positions.push(Vec3::new(x, y, 0.01 * x * y));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn tetrahedron() -> RawMesh {
    mesh(
        &[
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 0.0],
            [0.0, 9.0, 0.0],
            [0.0, 0.0, 9.0],
        ],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
}

fn repaired(raw: RawMesh) -> (Surface, Report) {
    let (surface, report) = Surface::new(raw).expect("can be repaired");
    surface.check().expect("keeps its promises");
    (surface, report)
}

fn volume(surface: &Surface) -> f64 {
    (0..surface.triangles().len() as u32)
        .map(|t| surface.triangle(t))
        .map(|t| t.a.dot(t.b.cross(t.c)) / 6.0)
        .sum()
}

/// Places of the corners of all triangles, in order, each beginning with its least and going round as it does.
fn turned_faces(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<[[u64; 3]; 3]> {
    let mut faces: Vec<_> = (triangles.iter())
        .map(|c| {
            let mut places = c.map(|v| positions[v as usize].to_array().map(f64::to_bits));
            let least = (0..3).min_by_key(|&i| places[i]).unwrap_or(0);
            places.rotate_left(least);
            places
        })
        .collect();
    faces.sort_unstable();
    faces
}

#[test]
fn a_sound_mesh_is_left_alone() {
    for raw in [grid(5), tetrahedron()] {
        let (surface, report) = repaired(raw.clone());
        assert_eq!(surface.positions().len(), raw.positions.len());
        assert_eq!(
            turned_faces(surface.positions(), surface.triangles()),
            turned_faces(&raw.positions, &raw.triangles)
        );
        assert!(report.is_clean() && !report.is_repaired());
        assert_eq!(report.n_components, 1);
    }
}

#[test]
fn the_rim_is_measured() {
    let (_, report) = repaired(grid(4));
    let rim = report.rim().expect("an open sheet");
    assert_eq!((rim.edges, rim.hole, report.n_rims), (16, false, 1));
    // Two sides are level, two rise by 0.1 · 40 · x / 40 mm per 10 mm … the sheet is ruled, so its sides are straight.
    let expected = 2.0 * 40.0 + 2.0 * f64::hypot(40.0, 16.0);
    assert!((rim.perimeter_mm - expected).abs() < 1e-9);
    assert!(repaired(tetrahedron()).1.rim().is_none());
}

#[test]
fn a_closed_mesh_turned_inside_out_is_turned_back() {
    let mut raw = tetrahedron();
    for corners in &mut raw.triangles {
        corners.swap(1, 2);
    }
    let (surface, report) = repaired(raw);
    assert!((volume(&surface) - 9.0 * 9.0 * 9.0 / 6.0).abs() < 1e-9);
    assert!(matches!(&report.defects[..], [Defect::InsideOut(found)] if found.count == 1));
}

#[test]
fn a_nearly_closed_body_faces_outward_whatever_its_hole_faces() {
    let mut raw = tetrahedron();
    raw.triangles.remove(0);
    // Mean normal points up and outward by half: turned inside out it would point down, and must come back.
    for corners in &mut raw.triangles {
        corners.swap(0, 1);
    }
    let (surface, _) = repaired(raw);
    // Of the three sides left, the slanted one: the others pass through the origin.
    let mut sides = (0..3).map(|t| surface.triangle(t));
    let slanted = sides.find(|t| t.a.dot(t.area_normal()) != 0.0);
    let slanted = slanted.expect("the slanted side");
    assert!(slanted.area_normal().dot(Vec3::ONE) > 0.0);
}

#[test]
fn flipped_triangles_are_named_and_turned_to_the_majority() {
    let mut raw = grid(6);
    for t in [3, 40, 41] {
        raw.triangles[t].swap(0, 1);
    }
    let (surface, report) = repaired(raw);
    assert!((0..72).all(|t| surface.triangle(t).area_normal().z > 0.0));
    let [Defect::FlippedTriangles(found)] = &report.defects[..] else {
        panic!("{report}");
    };
    let named: Vec<_> = found.first.iter().map(|e| e.index).collect();
    assert_eq!(named, [3, 40, 41]);
}

#[test]
fn a_sheet_facing_inward_is_turned_and_its_minority_kept_apart() {
    let mut raw = grid(4);
    for (t, corners) in raw.triangles.iter_mut().enumerate() {
        if t != 7 {
            corners.swap(0, 2);
        }
    }
    let (surface, report) = repaired(raw);
    assert!((0..32).all(|t| surface.triangle(t).area_normal().z > 0.0));
    assert!(matches!(
        &report.defects[..],
        [Defect::FlippedTriangles(f), Defect::FacingInward(i)] if f.first[0].index == 7 && i.count == 1
    ));
}

#[test]
fn a_fin_on_a_sheet_is_cut_off_and_the_sheet_stays_whole() {
    let mut raw = grid(2);
    raw.positions.push(Vec3::new(10.0, 15.0, 30.0));
    // The fin stands on the edge from the middle vertex 4 to 7.
    raw.triangles.push([4, 7, 9]);
    let (surface, report) = repaired(raw);
    assert_eq!(report.n_components, 2);
    assert_eq!(report.components[0].triangles, 8);
    assert_eq!(surface.positions().len(), 12);
    let Some(Defect::NonManifoldEdges(found)) = report.defects.first() else {
        panic!("{report}");
    };
    assert_eq!((found.count, found.first[0].vertices), (1, [4, 7]));
    assert!(!(report.defects.iter()).any(|d| matches!(d, Defect::BowTieVertices(_))));
}

#[test]
fn two_bodies_touching_along_an_edge_come_apart_whole() {
    let mut raw = tetrahedron();
    raw.positions
        .extend([[9.0, 9.0, -9.0], [9.0, 9.0, -1.0]].map(Vec3::from_array));
    // A second tetrahedron on the edge 1–2, outside the first.
    raw.triangles
        .extend([[1, 2, 4], [2, 1, 5], [1, 4, 5], [4, 2, 5]]);
    let (surface, report) = repaired(raw);
    assert_eq!(report.n_components, 2);
    assert!(
        report
            .components
            .iter()
            .all(|c| c.closed && c.triangles == 4),
        "{report}"
    );
    assert_eq!(surface.positions().len(), 8);
}

#[test]
fn a_moebius_band_is_cut_once_across() {
    let n = 12;
    let mut raw = RawMesh::default();
    for i in 0..n {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let (across, out) = (10.0 * (turn / 2.0).sin(), 10.0 * (turn / 2.0).cos());
        for side in [-1.0, 1.0] {
            let r = 50.0 + side * out;
            let p = Vec3::new(r * turn.cos(), r * turn.sin(), side * across);
            raw.positions.push(p);
        }
    }
    for i in 0..n as u32 {
        let (a, b) = (2 * i, 2 * i + 1);
        // The last pair of vertices meets the first with its sides exchanged.
        let (c, d) = if i + 1 == n as u32 {
            (1, 0)
        } else {
            (a + 2, b + 2)
        };
        raw.triangles.extend([[a, c, b], [b, c, d]]);
    }
    let (surface, report) = repaired(raw);
    let Some(Defect::NonOrientable(found)) = report.defects.first() else {
        panic!("{report}");
    };
    assert_eq!(found.count, 1);
    assert_eq!(report.n_components, 1);
    assert_eq!(surface.triangles().len(), 24);
    assert_eq!(surface.positions().len(), 26);
}

#[test]
fn two_sheets_touching_in_a_vertex_get_one_each() {
    let raw = mesh(
        &[
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, -1.0, 0.0],
        ],
        &[[0, 1, 2], [0, 3, 4]],
    );
    let (surface, report) = repaired(raw);
    assert_eq!(surface.positions().len(), 6);
    assert!(matches!(&report.defects[0], Defect::BowTieVertices(f) if f.first[0].index == 0));
}

#[test]
fn vertices_on_the_edge_of_a_neighbour_leave_no_slit() {
    // Four vertices along an edge of the upper triangle, filled up with triangles that are lines.
    let line: Vec<[f64; 3]> = (0..6)
        .map(|i| [f64::from(i) * 0.3, 0.7 * f64::from(i), 0.1])
        .collect();
    let mut positions = line;
    positions.extend([[-2.0, 2.0, 0.0], [3.0, 0.0, 0.0]]);
    let mut triangles = vec![[0, 5, 6]];
    triangles.extend((0..5).map(|i| [i + 1, i, 7]));
    triangles.extend([[0, 2, 5], [0, 1, 2], [2, 4, 5], [2, 3, 4]]);
    let (surface, report) = repaired(mesh(&positions, &triangles));
    assert!(
        matches!(&report.defects[..], [Defect::DegenerateTriangles(f)] if f.count == 4),
        "{report}"
    );
    assert_eq!(surface.triangles().len(), 10);
    assert_eq!((report.n_rims, report.rims[0].edges), (1, 4));
    // At the rim there is no neighbour to cut and no slit to close.
    triangles.remove(0);
    let (surface, _) = repaired(mesh(&positions, &triangles));
    assert_eq!(surface.triangles().len(), 5);
}

#[test]
fn a_soup_is_joined_and_called_so() {
    let sheet = grid(3);
    let mut soup = RawMesh::default();
    for corners in &sheet.triangles {
        for &v in corners {
            soup.triangles.resize(soup.positions.len() / 3 + 1, [0; 3]);
            let at = soup.positions.len() as u32;
            soup.triangles[at as usize / 3][at as usize % 3] = at;
            soup.positions.push(sheet.positions[v as usize]);
        }
    }
    let (surface, report) = repaired(soup);
    assert_eq!(surface.positions().len(), 16);
    assert_eq!(surface.triangles().len(), 18);
    assert_eq!(
        report.defects,
        [Defect::UnsharedVertices {
            corners: 54,
            places: 16
        }]
    );
    assert!(report.is_clean());
}

#[test]
fn zeros_of_either_sign_are_one_place() {
    let mut raw = grid(1);
    raw.positions.push(Vec3::new(-0.0, 0.0, -0.0));
    raw.triangles[1][0] = 4;
    let (surface, report) = repaired(raw);
    assert_eq!(surface.positions().len(), 4);
    assert!(matches!(&report.defects[..], [Defect::CoincidentVertices(f)] if f.count == 1));
}

#[test]
fn what_cannot_be_a_mesh_is_refused_naming_the_element() {
    let refused = |raw: RawMesh| Surface::new(raw).expect_err("refused").to_string();
    let mut raw = grid(1);
    raw.positions[2].y = f64::NAN;
    assert!(refused(raw).contains("vertex 2 has a coordinate that is not finite (NaN)"));
    let mut raw = grid(1);
    raw.positions[3].x = -2.0e7;
    assert!(refused(raw).contains("vertex 3 has the coordinate -2e7 mm"));
    let mut raw = grid(1);
    raw.triangles[1][2] = 4;
    assert!(refused(raw).contains("triangle 1 names vertex 4; the mesh has 4 vertices"));
    assert!(refused(RawMesh::default()).contains("no triangles"));
    let line = mesh(&[[0.0; 3], [1.0; 3], [2.0; 3]], &[[0, 1, 2], [0, 0, 1]]);
    assert!(refused(line).contains("none of the 2 triangles has an area"));
}

#[test]
fn thousands_of_one_kind_are_told_in_one_line() {
    let mut raw = grid(40);
    let doubles = raw.triangles.clone();
    raw.triangles.extend(doubles);
    let (_, report) = repaired(raw);
    let line = report.to_string();
    assert!(
        line.starts_with("3200 triangles with the corners of an earlier one, removed: 3200 at (")
    );
    assert!(line.ends_with(" and 3195 more") && !line.contains('\n'));
    let json = serde_json::to_value(&report).expect("serialises");
    assert_eq!(json["defects"][0]["kind"], "duplicate_triangles");
    assert_eq!(json["defects"][0]["count"], 3200);
}

#[test]
fn holes_and_components_are_counted() {
    let mut raw = grid(8);
    raw.triangles.drain(60..62);
    let far: Vec<Vec3> = grid(1)
        .positions
        .iter()
        .map(|p| *p + 500.0 * Vec3::Y)
        .collect();
    let offset = raw.positions.len() as u32;
    raw.positions.extend(far);
    raw.triangles
        .extend(grid(1).triangles.iter().map(|c| c.map(|v| v + offset)));
    let (_, report) = repaired(raw);
    assert_eq!(
        report.defects[0],
        Defect::SeveralComponents {
            count: 2,
            triangles: vec![126, 2]
        }
    );
    assert!(
        matches!(&report.defects[1], Defect::Holes { count: 1, longest } if longest.edges == 4)
    );
    let mut sizes: Vec<_> = report
        .rims
        .iter()
        .map(|r| (r.component, r.hole, r.edges))
        .collect();
    sizes.sort_unstable();
    assert_eq!(sizes, [(0, false, 32), (0, true, 4), (1, false, 4)]);
    assert!(!report.is_clean() && !report.is_repaired());
}

/// Few places and many triangles: every fault at once.
fn soup() -> impl Strategy<Value = RawMesh> {
    let coordinate = prop_oneof![3 => (-2_i32..3).prop_map(f64::from), 1 => -2.0..2.0];
    let positions =
        prop::collection::vec([coordinate.clone(), coordinate.clone(), coordinate], 3..14);
    (
        positions,
        prop::collection::vec(any::<[prop::sample::Index; 3]>(), 1..50),
    )
        .prop_map(|(positions, corners)| {
            let n = positions.len();
            let corners: Vec<_> = (corners.iter().map(|c| c.map(|i| i.index(n) as u32))).collect();
            mesh(&positions, &corners)
        })
}

/// Places of the corners of all triangles, each beginning with its least, in order: the same for the same set of faces.
fn faces(positions: &[Vec3], triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[[u64; 3]; 3]> {
    let mut faces: Vec<_> = (triangles.into_iter())
        .map(|c| {
            let mut places = c.map(|v| (positions[v as usize] + 0.0).to_array().map(f64::to_bits));
            places.sort_unstable();
            places
        })
        .collect();
    faces.sort_unstable();
    faces
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_soup_becomes_a_manifold_of_the_same_triangles(raw in soup()) {
        match Surface::new(raw.clone()) {
            Err(error) => prop_assert_eq!(error, MeshError::NothingLeft { of: raw.triangles.len() }),
            Ok((surface, report)) => {
                surface.check().map_err(TestCaseError::fail)?;
                let places = |c: &[u32; 3]| c.map(|v| raw.positions[v as usize]);
                let on_a_line = |c: &[u32; 3]| {
                    let [a, b, c] = places(c);
                    a != b && b != c && c != a && !has_area([a, b, c])
                };
                // Else neighbours may have been cut.
                if !raw.triangles.iter().any(on_a_line) {
                    let sound = raw.triangles.iter().copied().filter(|c| has_area(places(c)));
                    let mut expected = faces(&raw.positions, sound);
                    expected.dedup();
                    let triangles = surface.triangles().iter().copied();
                    prop_assert_eq!(faces(surface.positions(), triangles), expected);
                }
                prop_assert_eq!(
                    surface.topology(),
                    &Topology::new(surface.positions().len(), surface.triangles())
                );
                let listed: usize = report.components.iter().map(|c| c.triangles).sum();
                prop_assert!(report.n_components > Report::LISTED || listed == surface.triangles().len());
                let edges: usize = report.rims.iter().map(|r| r.edges).sum();
                prop_assert!(report.n_rims > Report::LISTED || edges == surface.topology().n_rim_edges());
                for line in report.to_string().lines() {
                    prop_assert!(!line.is_empty());
                }
            }
        }
    }

    #[test]
    fn repairing_twice_changes_nothing_more(raw in soup()) {
        if let Ok((once, _)) = Surface::new(raw) {
            let (twice, _) = repaired(RawMesh {
                positions: once.positions().to_vec(),
                triangles: once.triangles().to_vec(),
            });
            prop_assert_eq!(
                faces(twice.positions(), twice.triangles().iter().copied()),
                faces(once.positions(), once.triangles().iter().copied())
            );
        }
    }

    #[test]
    fn closed_pieces_enclose_and_sheets_face_the_back(raw in soup()) {
        if let Ok((surface, report)) = Surface::new(raw)
            && report.n_components == 1
        {
            if report.components[0].closed {
                prop_assert!(volume(&surface) > -1e-9);
            } else {
                let sum: Vec3 = (0..surface.triangles().len() as u32)
                    .map(|t| surface.triangle(t).area_normal() / 2.0)
                    .sum();
                prop_assert!(sum.z > -0.1 * report.components[0].area_mm2);
            }
        }
    }
}
