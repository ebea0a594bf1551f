//! The built-in back: counts, shape of its triangles, landmarks, likeness to the samples it is made from.

use dorsum::geom::Vec3;
use dorsum::surface::back::{self, BackOptions, Heights, Kind, Side};
use dorsum::surface::{RIM, Surface};

const SAMPLES: &str = include_str!("../assets/back/heights.csv");

fn smallest_angle_deg(p: [Vec3; 3]) -> f64 {
    (0..3)
        .map(|i| {
            (p[(i + 1) % 3] - p[i])
                .angle_between(p[(i + 2) % 3] - p[i])
                .to_degrees()
        })
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn every_size_asked_for_is_made_without_a_defect() {
    for wanted in [200, 500, 2_962, 8_163, 20_389, 41_582, 100_000] {
        let raw = back::make(&BackOptions::with_triangles(wanted));
        let made = raw.triangles.len();
        let off = (made as f64 - wanted as f64).abs() / wanted as f64;
        assert!(off <= 0.01, "{wanted} asked for, {made} made");
        let given = raw.triangles.len();
        let (surface, report) = Surface::new(raw).expect("a surface");
        assert_eq!(
            surface.triangles().len(),
            given,
            "{wanted}: repaired: {report:?}"
        );
        assert!(report.is_clean(), "{wanted}: {report:?}");
    }
}

#[test]
fn the_sizes_of_the_published_tables_are_met_exactly() {
    for wanted in [2_962, 20_389, 41_582] {
        assert_eq!(
            back::make(&BackOptions::with_triangles(wanted))
                .triangles
                .len(),
            wanted
        );
    }
}

#[test]
fn the_large_sizes_are_met_too() {
    for wanted in [500_000, 2_000_000] {
        let made = back::make(&BackOptions::with_triangles(wanted))
            .triangles
            .len();
        let off = (made as f64 - wanted as f64).abs() / wanted as f64;
        assert!(off <= 0.01, "{wanted} asked for, {made} made");
    }
}

#[test]
fn the_rim_is_one_closed_loop_and_every_triangle_faces_out() {
    for wanted in [200, 333, 2_962, 41_582] {
        let (surface, _) =
            Surface::new(back::make(&BackOptions::with_triangles(wanted))).expect("a surface");
        let mut next = vec![None; surface.positions().len()];
        let mut n_rim = 0;
        for (t, corners) in surface.triangles().iter().enumerate() {
            for (i, &across) in surface.topology().across(t as u32).iter().enumerate() {
                if across == RIM {
                    let from = corners[i] as usize;
                    assert_eq!(next[from], None, "{wanted}: the rim branches at {from}");
                    next[from] = Some(corners[(i + 1) % 3] as usize);
                    n_rim += 1;
                }
            }
            let facing = surface.triangle(t as u32).normal().z;
            assert!(facing > 0.1, "{wanted}: triangle {t} has normal z {facing}");
        }
        let start = next.iter().position(Option::is_some).expect("a rim");
        let mut at = start;
        let mut n_walked = 0;
        while n_walked == 0 || at != start {
            at = next[at].expect("a closed rim");
            n_walked += 1;
        }
        assert_eq!(n_walked, n_rim, "{wanted}: more than one rim");
    }
}

#[test]
fn triangles_are_near_equilateral_on_the_skin_save_at_the_rim() {
    for wanted in [2_962, 20_389, 41_582] {
        let (surface, _) =
            Surface::new(back::make(&BackOptions::with_triangles(wanted))).expect("a surface");
        let mut at_rim = vec![false; surface.positions().len()];
        for (t, corners) in surface.triangles().iter().enumerate() {
            for (i, &across) in surface.topology().across(t as u32).iter().enumerate() {
                if across == RIM {
                    at_rim[corners[i] as usize] = true;
                    at_rim[corners[(i + 1) % 3] as usize] = true;
                }
            }
        }
        let mut worst = (90.0, 0);
        for (t, corners) in surface.triangles().iter().enumerate() {
            if corners.iter().any(|&v| at_rim[v as usize]) {
                continue;
            }
            let tri = surface.triangle(t as u32);
            let angle = smallest_angle_deg([tri.a, tri.b, tri.c]);
            if angle < worst.0 {
                worst = (angle, t);
            }
        }
        let at = surface.triangle(worst.1 as u32).centroid();
        assert!(worst.0 >= 25.0, "{wanted}: {:.1}° at {at}", worst.0);
    }
}

#[test]
fn the_heights_follow_the_samples() {
    let heights = Heights::new(&BackOptions {
        thoracic_bump_mm: 0.0,
        lumbar_bump_mm: 0.0,
        psis_dimple_mm: 0.0,
        ..BackOptions::default()
    });
    let mut lines = SAMPLES.lines().filter(|l| !l.starts_with('#'));
    let xs: Vec<f64> = lines
        .next()
        .expect("a header")
        .split(',')
        .skip(1)
        .map(|x| x.parse().expect("x"))
        .collect();
    let (mut sum_sq, mut worst, mut n) = (0.0, 0.0_f64, 0);
    for line in lines {
        let mut cells = line.split(',');
        let y: f64 = cells.next().expect("y").parse().expect("y");
        for (x, cell) in xs.iter().zip(cells) {
            // The flanks are steep: there a small shift along the map is a large one in height.
            if let (Ok(z), true) = (
                cell.parse::<f64>(),
                *x <= 110.0 && (10.0..=440.0).contains(&y),
            ) {
                let error = heights.at(*x, y) - z;
                (sum_sq, worst, n) = (sum_sq + error * error, worst.max(error.abs()), n + 1);
            }
        }
    }
    let rms = (sum_sq / f64::from(n)).sqrt();
    assert!(
        n > 1500 && rms < 0.15 && worst < 1.2,
        "{n} samples: RMS {rms:.3} mm, worst {worst:.3} mm"
    );
}

#[test]
fn left_and_right_mirror_each_other_until_the_spine_curves() {
    let straight = Heights::new(&BackOptions::default());
    let curved = Heights::new(&BackOptions {
        scoliosis_mm: 10.0,
        ..BackOptions::default()
    });
    let mut differing = 0;
    for i in 0..200 {
        let (x, y) = (
            f64::from(i % 20) * 7.0 + 1.0,
            f64::from(i / 20) * 45.0 + 10.0,
        );
        assert_eq!(straight.at(x, y).to_bits(), straight.at(-x, y).to_bits());
        differing += i32::from((curved.at(x, y) - curved.at(-x, y)).abs() > 0.1);
    }
    assert!(differing > 50);
}

#[test]
fn bumps_and_dimples_are_as_high_as_asked() {
    let with = Heights::new(&BackOptions::default());
    let without = Heights::new(&BackOptions {
        thoracic_bump_mm: 0.0,
        lumbar_bump_mm: 0.0,
        psis_dimple_mm: 0.0,
        ..BackOptions::default()
    });
    let options = BackOptions::default();
    for (level, height) in [("T1", 1.8), ("T6", 1.2), ("L3", 1.5)] {
        let at = back::landmark(&options, level, Kind::Spinous, Side::Middle)
            .expect(level)
            .position_mm;
        let bump = with.at(at.x, at.y) - without.at(at.x, at.y);
        assert!((bump - height).abs() < 0.1, "{level}: {bump}");
        let beside = with.at(5.0, at.y) - without.at(5.0, at.y);
        assert!(
            (beside / bump - 0.5).abs() < 0.02,
            "{level} is {beside} mm high 5 mm off the midline"
        );
    }
    assert!((with.at(38.0, 10.0) - without.at(38.0, 10.0) + 2.0).abs() < 1e-9);
}

#[test]
fn landmarks_lie_on_the_skin_on_both_sides() {
    let options = BackOptions {
        size: 1.1,
        girth: 0.9,
        scoliosis_mm: 6.0,
        ..BackOptions::with_triangles(41_582)
    };
    let (surface, _) = Surface::new(back::make(&options)).expect("a surface");
    let all = back::landmarks(&options);
    assert_eq!(all.iter().filter(|l| l.kind == Kind::Spinous).count(), 18);
    assert_eq!(
        all.iter().filter(|l| l.kind == Kind::Transverse).count(),
        34
    );
    for l in &all {
        let nearest = (0..surface.triangles().len() as u32)
            .map(|t| {
                surface
                    .triangle(t)
                    .closest_point(l.position_mm)
                    .point
                    .distance(l.position_mm)
            })
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 0.5, "{} is {nearest:.2} mm off the skin", l.name);
    }
    let t5 = |side| {
        back::landmark(&BackOptions::default(), "T5", Kind::Transverse, side)
            .expect("T5")
            .position_mm
    };
    assert_eq!((t5(Side::Left).x, t5(Side::Right).x), (-25.0, 25.0));
    assert!(back::landmark(&options, "T13", Kind::Spinous, Side::Middle).is_none());
}

#[test]
fn every_build_of_body_is_a_clean_surface() {
    for (scoliosis_mm, size, girth) in [
        (50.0, 1.0, 1.0),
        (-50.0, 0.6, 1.4),
        (0.0, 1.3, 0.7),
        (20.0, 5.0, 0.2),
    ] {
        let options = BackOptions {
            scoliosis_mm,
            size,
            girth,
            ..BackOptions::with_triangles(8_163)
        };
        let raw = back::make(&options);
        let off = (raw.triangles.len() as f64 - 8_163.0).abs() / 8_163.0;
        assert!(off <= 0.01, "{options:?}: {} made", raw.triangles.len());
        let (_, report) = Surface::new(raw).expect("a surface");
        assert!(report.is_clean(), "{options:?}: {report:?}");
    }
}

/// Landmarks off the midline used to be left behind by the curve: by 7 mm for a shift of 30 mm.
#[test]
fn a_curved_spine_carries_its_landmarks_along() {
    let straight = back::landmarks(&BackOptions::default());
    for scoliosis_mm in [-50.0, -12.0, 5.0, 30.0, 50.0] {
        let options = BackOptions {
            scoliosis_mm,
            ..BackOptions::default()
        };
        let heights = Heights::new(&options);
        for (before, after) in straight.iter().zip(back::landmarks(&options)) {
            let (p, q) = (before.position_mm, after.position_mm);
            let origin = q.x - heights.shift_mm(q.x, q.y);
            assert!(
                (origin - p.x).abs() < 1e-9,
                "{} by {scoliosis_mm} mm: it stands over x = {origin}",
                after.name
            );
            // It is the same skin, so it is as high as it was (the dimples and bumps move too).
            assert!((q.z - p.z).abs() < 1e-6, "{}", after.name);
        }
    }
}

#[test]
fn options_that_are_not_numbers_still_make_a_back() {
    let options = BackOptions {
        triangles: 0,
        thoracic_bump_mm: f64::NAN,
        lumbar_bump_mm: f64::INFINITY,
        psis_dimple_mm: -1e300,
        scoliosis_mm: f64::NAN,
        size: f64::NAN,
        girth: f64::INFINITY,
    };
    let raw = back::make(&options);
    assert!(raw.triangles.len() >= 190 && raw.positions.iter().all(|p| p.is_finite()));
}

/// Sessions name their surface by hash: when this one changes, recordings of the built-in back no longer replay.
#[test]
fn the_default_back_is_the_same_on_every_machine() {
    let (surface, _) = Surface::new(back::make(&BackOptions::default())).expect("a surface");
    let hash: String = surface
        .hash()
        .iter()
        .take(8)
        .map(|b| format!("{b:02x}"))
        .collect();
    assert_eq!(hash, "260a82672f85e794");
}
