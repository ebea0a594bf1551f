use super::*;
use crate::geom::{Vec2, Vec3};
use crate::surface::back::{self, Heights, Kind};
use crate::surface::solids::{tests::is_closed, volume_mm3};

fn skeleton() -> Skeleton {
    Skeleton::under(&BackOptions::default())
}

#[test]
fn every_bone_of_the_back_is_there_once_by_its_name() {
    let s = skeleton();
    let mut names: Vec<String> = LEVELS.iter().map(|l| (*l).to_owned()).collect();
    names.extend(LEVELS.windows(2).map(|l| format!("disc {}–{}", l[0], l[1])));
    for side in ["left", "right"] {
        names.extend((1..=12).map(|n| format!("rib {n} {side}")));
        names.extend(["scapula", "iliac crest"].map(|n| format!("{n} {side}")));
    }
    names.push("sacrum".into());
    let mut found: Vec<String> = s.bones.iter().map(|b| b.name.clone()).collect();
    names.sort_unstable();
    found.sort_unstable();
    assert_eq!(found, names);
    // In order, without gaps.
    let (mut vertices, mut triangles) = (0, 0);
    for bone in &s.bones {
        assert_eq!(
            (bone.vertices.start, bone.triangles.start),
            (vertices, triangles)
        );
        (vertices, triangles) = (bone.vertices.end, bone.triangles.end);
        assert!(
            s.mesh.triangles[bone.triangles.clone()]
                .iter()
                .flatten()
                .all(|&v| bone.vertices.contains(&(v as usize)))
        );
    }
    assert_eq!(
        (vertices, triangles),
        (s.mesh.positions.len(), s.mesh.triangles.len())
    );
    println!(
        "{vertices} vertices, {triangles} triangles, {} bytes",
        s.bytes()
    );
}

#[test]
fn every_bone_is_closed_and_faces_outward() {
    let s = skeleton();
    for bone in &s.bones {
        assert!(
            is_closed(&s.mesh, bone.triangles.clone()),
            "{} is open",
            bone.name
        );
        let volume = volume_mm3(&s.mesh, bone.triangles.clone());
        // From the smallest disc to the largest scapula, overlaps counted twice.
        assert!(
            (300.0..120_000.0).contains(&volume),
            "{}: {volume} mm³",
            bone.name
        );
    }
    assert!(s.mesh.positions.iter().all(|p| p.is_finite()));
    assert!(s.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-9));
}

/// A vertex normal agrees with the triangles around it: no solid is turned inside out or folded.
#[test]
fn normals_agree_with_the_faces() {
    let s = skeleton();
    let (mut against, mut all) = (0, 0);
    for t in &s.mesh.triangles {
        let [a, b, c] = t.map(|v| s.mesh.positions[v as usize]);
        let face = (b - a).cross(c - a);
        if face.length() < 1e-3 {
            continue;
        }
        for &v in t {
            all += 1;
            against += usize::from(s.normals[v as usize].dot(face) < 0.0);
        }
    }
    assert!(against * 200 < all, "{against} of {all}");
}

/// Distance to the skin, taken at points of the height function close enough to one another to miss nothing that counts.
fn distance_to_skin_mm(heights: &Heights, p: Vec3) -> f64 {
    let up = heights.at(p.x, p.y) - p.z;
    let mut least = up;
    let reach = up.min(14.0);
    let n = 8;
    for i in -n..=n {
        for j in -n..=n {
            let at = Vec2::new(p.x, p.y)
                + Vec2::new(f64::from(i), f64::from(j)) * (reach / f64::from(n));
            least = least.min((at.extend(heights.at(at.x, at.y)) - p).length());
        }
    }
    least
}

#[test]
fn every_bone_lies_below_the_skin() {
    let s = skeleton();
    let heights = Heights::new(&BackOptions::default());
    let mut least = f64::INFINITY;
    for bone in &s.bones {
        for p in &s.mesh.positions[bone.vertices.clone()] {
            let up = heights.at(p.x, p.y) - p.z;
            assert!(up >= CLEARANCE_MM, "{} at {p}: {up} mm", bone.name);
            if up < 40.0 {
                least = least.min(distance_to_skin_mm(&heights, *p));
            }
        }
    }
    println!("least distance to the skin: {least:.2} mm");
    // The slope at a place tells the distance only as far as the skin is straight there.
    assert!(least > 0.85 * CLEARANCE_MM, "{least}");
}

#[test]
fn left_and_right_are_mirror_images() {
    let s = skeleton();
    let mirrored = |p: &Vec3| Vec3::new(-p.x, p.y, p.z);
    for bone in &s.bones {
        let own = &s.mesh.positions[bone.vertices.clone()];
        let other = match bone.side {
            Side::Middle => bone.name.clone(),
            Side::Left => bone.name.replace("left", "right"),
            Side::Right => bone.name.replace("right", "left"),
        };
        let other = &s.mesh.positions[s.bone(&other).unwrap().vertices.clone()];
        for p in own {
            let image = mirrored(p);
            let near = other
                .iter()
                .map(|q| q.distance(image))
                .fold(f64::INFINITY, f64::min);
            assert!(
                near < 1e-9,
                "{}: {p} has no image within {near} mm",
                bone.name
            );
        }
    }
}

#[test]
fn tips_and_edges_lie_under_their_landmarks() {
    let options = BackOptions::default();
    let s = skeleton();
    for landmark in back::landmarks(&options) {
        let side = match landmark.side {
            Side::Left => " left",
            Side::Right => " right",
            Side::Middle => "",
        };
        // Depth that is assumed over it, and how far beside the bone may be nearest to the skin.
        let (name, depth, beside) = match landmark.kind {
            Kind::Spinous if landmark.level.starts_with('L') => {
                (landmark.level.to_owned(), 8.0, 3.0)
            }
            Kind::Spinous => (landmark.level.to_owned(), 6.0, 3.0),
            Kind::Transverse if landmark.level.starts_with('L') => {
                (landmark.level.to_owned(), 40.0, 6.0)
            }
            Kind::Transverse => (landmark.level.to_owned(), 25.0, 6.0),
            Kind::ScapulaInferiorAngle => (format!("scapula{side}"), 10.0, 6.0),
            Kind::ScapulaSpine => (format!("scapula{side}"), 8.0, 5.0),
            Kind::Psis => (format!("iliac crest{side}"), 7.0, 6.0),
            Kind::IliacCrest => (format!("iliac crest{side}"), 12.0, 6.0),
        };
        let bone = s.bone(&name).unwrap();
        let at = landmark.position_mm;
        let found = s.mesh.positions[bone.vertices.clone()]
            .iter()
            .filter(|p| Vec2::new(p.x - at.x, p.y - at.y).length() <= beside)
            .map(|p| at.z - p.z)
            .fold(f64::INFINITY, f64::min);
        assert!(
            (found - depth).abs() <= 3.5,
            "{}: {found:.1} mm for {depth}",
            landmark.name
        );
    }
}

/// The shoulder blade glides over the ribs: they do not run through it.
#[test]
fn ribs_pass_below_the_blade() {
    let s = skeleton();
    let blade = &s.mesh.positions[s.bone("scapula right").unwrap().vertices.clone()];
    for rib in 1..=12 {
        let name = format!("rib {rib} right");
        let bone = s.bone(&name).unwrap();
        for p in &s.mesh.positions[bone.vertices.clone()] {
            let over = blade
                .iter()
                .filter(|q| Vec2::new(q.x - p.x, q.y - p.y).length() < 4.0);
            for q in over {
                assert!(
                    q.z > p.z + 0.5,
                    "{name} at {p} is not below the blade at {q}"
                );
            }
        }
    }
}

#[test]
fn neighbouring_ribs_leave_room_between_them() {
    let s = skeleton();
    for rib in 1..12 {
        let of = |n: usize| {
            let bone = s.bone(&format!("rib {n} right")).unwrap();
            &s.mesh.positions[bone.vertices.clone()]
        };
        let mut least = f64::INFINITY;
        for p in of(rib) {
            for q in of(rib + 1) {
                least = least.min(p.distance(*q));
            }
        }
        println!("ribs {rib} and {}: {least:.1} mm", rib + 1);
        assert!(least > 1.0, "ribs {rib} and {}: {least}", rib + 1);
    }
}

#[test]
fn bones_follow_size_girth_and_curve() {
    let large = BackOptions {
        size: 1.2,
        girth: 0.9,
        ..BackOptions::default()
    };
    let (plain, scaled) = (skeleton(), Skeleton::under(&large));
    for (p, q) in plain.mesh.positions.iter().zip(&scaled.mesh.positions) {
        let wanted = Vec3::new(p.x * 1.08, p.y * 1.2, p.z * 1.08);
        assert!(q.distance(wanted) < 1e-9);
    }
    let curved = BackOptions {
        scoliosis_mm: 25.0,
        ..BackOptions::default()
    };
    let heights = Heights::new(&curved);
    let bent = Skeleton::under(&curved);
    for (p, q) in plain.mesh.positions.iter().zip(&bent.mesh.positions) {
        let depth = heights.at(q.x, q.y) - q.z;
        assert!(depth >= CLEARANCE_MM - 1e-6, "{q}");
        assert!((p.x - q.x).abs() < 26.0);
    }
    for o in [
        &curved,
        &BackOptions {
            scoliosis_mm: f64::NAN,
            size: f64::INFINITY,
            ..curved
        },
    ] {
        assert!(
            Skeleton::under(o)
                .mesh
                .positions
                .iter()
                .all(|p| p.is_finite())
        );
    }
}
