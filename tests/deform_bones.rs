//! Bone under the skin: limits and narrows dents, and is not there when it is deep or off (Ji 2008, future work 1).

use dorsum::deform::bones::{BoneSettings, Bones};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::{Displacement, Model, Press};
use dorsum::geom::{Vec2, Vec3};
use dorsum::maps::bone::assumed_back_keys;
use dorsum::maps::{BoneKey, BoneMap};
use dorsum::surface::{Surface, back};
use proptest::prelude::*;
use std::sync::{Arc, LazyLock};

/// The built-in back, fine enough for a narrow dent.
static BACK: LazyLock<Surface> = LazyLock::new(|| {
    let raw = back::make(&back::BackOptions::with_triangles(20_000));
    Surface::new(raw).expect("a sound mesh").0
});

fn bones(keys: Vec<BoneKey>) -> Arc<Bones> {
    let map = BoneMap::new(keys).expect("keys");
    Arc::new(Bones::new(&map, &BACK, BoneSettings::default()))
}

fn everywhere(depth_mm: f64) -> Arc<Bones> {
    let at = Vec2::ZERO;
    bones(vec![BoneKey { at, depth_mm }])
}

fn press(triangle: u32, depth_mm: f64, pull_mm: f64) -> Press {
    let triangle = triangle % BACK.triangles().len() as u32;
    let t = BACK.triangle(triangle);
    let anchor_mm = t.at([0.5, 0.3, 0.2]);
    let normal = t.normal();
    Press {
        anchor_mm,
        foot_mm: anchor_mm + dorsum::geom::any_tangent(normal) * pull_mm,
        normal,
        depth_mm,
        triangle,
        ..Press::default()
    }
}

fn pressed(bones: Option<Arc<Bones>>, presses: &[Press]) -> Displacement {
    let mut model = Fsmd::new(Settings {
        bones,
        ..Settings::default()
    });
    let mut out = Displacement::at_rest(&BACK);
    model.update(&BACK, presses, &mut out);
    out
}

fn offsets(d: &Displacement) -> Vec<Vec3> {
    (0..d.n_vertices() as u32).map(|v| d.offset_mm(v)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn deep_bone_changes_nothing_bit_for_bit(t in 0..20_000_u32, depth in 0.1..30.0_f64, pull in 0.0..15.0_f64) {
        let presses = [press(t, depth, pull), press(t / 2, depth, 0.0)];
        let (with, without) = (pressed(Some(everywhere(60.0)), &presses), pressed(None, &presses));
        prop_assert_eq!(offsets(&with), offsets(&without));
    }

    #[test]
    fn no_dent_reaches_the_bone_wherever_fingers_press(t in 0..20_000_u32, other in 0..20_000_u32, depth in 0.1..30.0_f64) {
        let bones = bones(assumed_back_keys());
        for presses in [&[press(t, depth, 0.0)][..], &[press(t, depth, 0.0), press(other, depth, 0.0), press(t + 1, depth, 0.0)]] {
            let d = pressed(Some(Arc::clone(&bones)), presses);
            for v in d.moved() {
                prop_assert!(d.offset_mm(v).length() < 0.7 * bones.depth_mm()[v as usize]);
            }
        }
    }

    #[test]
    fn the_shallower_the_bone_the_shallower_and_narrower_the_dent(t in 0..20_000_u32, depth in 1.0..12.0_f64) {
        let presses = [press(t, depth, 0.0)];
        let mut last: Option<Vec<Vec3>> = None;
        for bone_mm in [60.0, 35.0, 20.0, 12.0, 8.0, 4.0, 1.0] {
            let now = offsets(&pressed(Some(everywhere(bone_mm)), &presses));
            if let Some(last) = last {
                for (now, last) in now.iter().zip(&last) {
                    prop_assert!(now.length() <= last.length() * (1.0 + 1e-12));
                }
            }
            last = Some(now);
        }
    }

    #[test]
    fn a_dent_changes_little_when_press_and_bone_change_little(t in 0..20_000_u32, depth in 1.0..12.0_f64, bone_mm in 2.0..60.0_f64) {
        let here = offsets(&pressed(Some(everywhere(bone_mm)), &[press(t, depth, 0.0)]));
        let deeper = offsets(&pressed(Some(everywhere(bone_mm)), &[press(t, depth + 1e-6, 0.0)]));
        let nearer = offsets(&pressed(Some(everywhere(bone_mm - 1e-6)), &[press(t, depth, 0.0)]));
        for ((a, b), c) in here.iter().zip(&deeper).zip(&nearer) {
            prop_assert!(a.distance(*b) < 2e-5 && a.distance(*c) < 2e-5);
        }
    }
}

#[test]
fn a_dent_beside_the_spine_is_held_up_at_the_spinous_processes() {
    // Beside T8, where the muscle is thick enough for the whole depth but the footprint reaches the midline.
    let near = |x: f64, y: f64| {
        let away =
            |t: &u32| (BACK.triangle(*t).at([1.0 / 3.0; 3]).truncate() - Vec2::new(x, y)).length();
        let all = 0..BACK.triangles().len() as u32;
        all.min_by(|a, b| away(a).total_cmp(&away(b)))
            .expect("triangles")
    };
    let presses = [press(near(18.0, 259.0), 10.0, 0.0)];
    let (with, without) = (
        pressed(Some(bones(assumed_back_keys())), &presses),
        pressed(None, &presses),
    );
    let at_spine = (0..BACK.positions().len() as u32).filter(|&v| {
        BACK.positions()[v as usize]
            .truncate()
            .distance(Vec2::new(0.0, 259.0))
            < 3.0
    });
    let deepest = |d: &Displacement| {
        at_spine
            .clone()
            .map(|v| d.offset_mm(v).length())
            .fold(0.0, f64::max)
    };
    let (with, without) = (deepest(&with), deepest(&without));
    assert!(
        1.0 < with && with < 0.75 * without,
        "{with}, {without} without bones"
    );
}

#[test]
fn bones_of_another_surface_or_broken_settings_do_no_harm() {
    let map = BoneMap::new(assumed_back_keys()).expect("keys");
    let small = Surface::new(back::make(&back::BackOptions::with_triangles(300)))
        .expect("mesh")
        .0;
    let broken = BoneSettings {
        dent_share: f64::NAN,
        reference_depth_mm: -1.0,
    };
    let bones = Bones::new(&map, &small, broken);
    assert_eq!(*bones.settings(), BoneSettings::default());
    let d = pressed(Some(Arc::new(bones)), &[press(19_000, 8.0, 3.0)]);
    assert!(offsets(&d).iter().all(|o| o.is_finite()) && d.n_moved() > 0);
}
