//! Scenes with dysfunctions: what is built, what is felt, what an edit changes.

use super::*;
use crate::contact::{ContactState, advance};
use crate::geom::{Vec2, Vec3};
use crate::scenario::{Use, build, changes_surface, rebuild, sites};

const HEAD: &str = "format = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\ntriangles = 20389\n\
                    [stiffness]\nconstant_n_per_mm = 0.5\n";
const FRICTION: &str = "[friction]\nstatic = 0.46\ndynamic = 0.44\n";

fn parsed(tables: &str) -> Arc<Scenario> {
    let text = format!("{HEAD}{tables}");
    Arc::new(Scenario::parse(&text, "a.toml", None).expect("good"))
}

fn try_build(scenario: &Arc<Scenario>) -> Result<Scene, BuildError> {
    let purpose = Use {
        fingers: 1,
        ..Use::default()
    };
    build(Arc::clone(scenario), purpose, &mut |_, _| true)
}

fn built(tables: &str) -> Scene {
    try_build(&parsed(tables)).expect("builds")
}

fn table(kind: &str, rest: &str) -> String {
    format!("[[dysfunction]]\nkind = \"{kind}\"\nlevel = \"T5\"\nside = \"right\"\n{rest}\n")
}

fn t5() -> Vec2 {
    sites("T5 right").expect("good")[0].at_mm()
}

fn row_is_built(scene: &Scene, item: Item) -> bool {
    let row = scene.ledger.row(item);
    assert!(
        row.built || row.bytes == 0 && row.cost_us.is_none(),
        "{row:?}"
    );
    row.built
}

#[test]
fn a_bump_lifts_the_surface_that_is_felt_by_as_much() {
    let plain = built("");
    let lifted = built(&table("texture", "preset = \"oedema\"\nbump_mm = 2"));
    assert!(row_is_built(&lifted, Item::Bumps) && !row_is_built(&plain, Item::Bumps));
    assert_ne!(plain.surface.hash(), lifted.surface.hash());
    let patch = &lifted.scenario.patches().expect("sound")[0].1;
    // Vertices are numbered anew: by place they are the same.
    let by_place = |scene: &Scene| {
        let mut all = scene.surface.positions().to_vec();
        all.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        all
    };
    for (a, b) in by_place(&plain).iter().zip(by_place(&lifted)) {
        let at = a.truncate();
        assert_eq!(at, b.truncate());
        assert_eq!(b.z, a.z + 2.0 * patch.spot.weight(at));
    }
    // Between the vertices as well as the mesh can.
    let height = |scene: &Scene| scene.height_mm(t5().x, t5().y).expect("skin");
    let rise = height(&lifted) - height(&plain);
    assert!((1.9..=2.0).contains(&rise), "{rise}");
    // The finger stands on it.
    let mut state = ContactState::default();
    let over = Vec3::new(t5().x, t5().y, height(&lifted));
    state.proxy_mm = over + Vec3::Z;
    assert!(advance(&lifted.touch, &mut state, over - Vec3::Z * 0.5).depth_mm > 0.4);
    state = ContactState {
        proxy_mm: over + Vec3::Z,
        ..ContactState::default()
    };
    assert_eq!(
        advance(&plain.touch, &mut state, over - Vec3::Z * 0.5).depth_mm,
        0.0
    );
}

#[test]
fn what_is_not_stated_is_not_built() {
    let nothing = table("hypertonic", "severity = 0");
    let items = [
        Item::Bumps,
        Item::SkinDrag,
        Item::Tenderness,
        Item::StiffnessField,
    ];
    let plain = built(FRICTION);
    for tables in [FRICTION.to_owned(), format!("{nothing}{FRICTION}"), nothing] {
        let scene = built(&tables);
        assert!(
            items.iter().all(|item| !row_is_built(&scene, *item)),
            "{tables}"
        );
        assert!(scene.touch.drag.is_none() && scene.tenderness.is_none());
        assert_eq!(scene.surface.hash(), plain.surface.hash());
        assert_eq!(scene.touch.stiffness.bytes(), 0);
    }
    for (kind, item) in [
        ("hypertonic", Item::StiffnessField),
        ("skin_drag", Item::SkinDrag),
        ("tender", Item::Tenderness),
    ] {
        let scene = built(&format!("{}{FRICTION}", table(kind, "")));
        for other in items {
            assert_eq!(
                row_is_built(&scene, other),
                other == item,
                "{kind} {}",
                other.name()
            );
        }
        assert_eq!(scene.ledger.row(item).reason, "[[dysfunction]]");
    }
}

#[test]
fn skin_drag_is_the_patch_at_every_vertex_and_needs_friction() {
    let scene = built(&format!(
        "{}{FRICTION}",
        table("skin_drag", "skin_drag = 1.8")
    ));
    let spot = &scene.scenario.patches().expect("sound")[0].1.spot;
    let drag = scene.touch.drag.as_ref().expect("built");
    for (p, drag) in scene.surface.positions().iter().zip(&drag[..]) {
        let expected = 1.0 + 0.8 * spot.weight(p.truncate());
        assert!((drag - expected).abs() < 1e-15);
    }
    // Drag that is only a default is left out where there is no friction.
    let fibrosis = table("texture", "preset = \"fibrosis\"");
    assert!(built(&fibrosis).touch.drag.is_none());
    assert!(built(&format!("{fibrosis}{FRICTION}")).touch.drag.is_some());
    for stated in [
        table("skin_drag", ""),
        table("hypertonic", "skin_drag = 1.2"),
    ] {
        let error = Scenario::parse(&format!("{HEAD}{stated}"), "a.toml", None);
        let error = error.expect_err("no friction").0;
        assert!(
            error.contains("has no [friction]") && error.contains("line "),
            "{error}"
        );
    }
}

#[test]
fn a_scene_tells_where_it_hurts() {
    let scene = built(&format!(
        "{}[[dysfunction]]\nkind = \"tender\"\nat_mm = [43, 348]\ntender_above_n = 1\ntender_shown = false\n",
        table("tender", "tender_above_n = 3")
    ));
    let at = |x: f64| scene.tenderness_at(Vec2::new(x, 348.2));
    assert_eq!(at(25.0).map(|t| (t.above_n, t.shown)), Some((3.0, true)));
    // Where both are, the more tender one.
    assert_eq!(at(34.0).map(|t| (t.above_n, t.shown)), Some((1.0, false)));
    assert_eq!(at(14.9), None);
    assert_eq!(
        scene.ledger.row(Item::Tenderness).bytes,
        scene.tenderness.as_ref().expect("there").bytes()
    );
}

#[test]
fn edits_share_what_they_leave_and_a_bump_is_no_edit() {
    let text = |rest: &str| format!("{}{FRICTION}", table("hypertonic", rest));
    let old = built(&text("skin_drag = 1.5"));
    let purpose = Use {
        fingers: 1,
        ..Use::default()
    };
    let edit = |rest: &str| rebuild(&old, parsed(&text(rest)), purpose);
    let same = edit("skin_drag = 1.5").expect("an edit");
    let shared = |a: &Scene, b: &Scene| {
        let of = |s: &Scene| s.touch.drag.as_ref().map(|d| d.as_ptr());
        of(a) == of(b)
    };
    assert!(shared(&old, &same));
    let other = edit("skin_drag = 1.8\ntender_above_n = 2\nseverity = 3").expect("an edit");
    let afresh = built(&text("skin_drag = 1.8\ntender_above_n = 2\nseverity = 3"));
    assert_eq!(other.touch.drag, afresh.touch.drag);
    assert_eq!(other.tenderness, afresh.tenderness);
    let values = |s: &Scene| match &s.touch.stiffness {
        Stiffness::PerVertex(values) => values.to_vec(),
        Stiffness::Uniform(_) => Vec::new(),
    };
    assert!(values(&other) == values(&afresh) && values(&other) != values(&old));
    for (a, b) in other.ledger.rows.iter().zip(&afresh.ledger.rows) {
        assert_eq!(
            (a.built, a.bytes, &a.reason),
            (b.built, b.bytes, &b.reason),
            "{}",
            a.item
        );
    }
    let bump = edit("bump_mm = 1").expect_err("a bump").0;
    assert!(
        bump.starts_with("the bumps of [[dysfunction]] cannot be edited"),
        "{bump}"
    );
    let with = parsed(&text("bump_mm = 1"));
    assert!(changes_surface(&old.scenario, &with) && changes_surface(&with, &old.scenario));
    assert!(!changes_surface(&old.scenario, &other.scenario));
    assert!(!changes_surface(
        &with,
        &parsed(&text("bump_mm = 1\nseverity = 3"))
    ));
    assert!(changes_surface(
        &with,
        &parsed(&text("bump_mm = 1\nradius_mm = [20, 20]"))
    ));
}

#[test]
fn a_finer_mesh_carries_more() {
    let of = |triangles: &str| {
        let tables = format!(
            "{}{}",
            table("hypertonic", ""),
            "[[dysfunction]]\nkind = \"tender\"\nat_mm = [0, 9]\n"
        );
        let text = format!("{HEAD}{tables}").replace("20389", triangles);
        let scenario = Scenario::parse(&text, "a.toml", None).expect("good");
        try_build(&Arc::new(scenario)).expect("builds").carried()
    };
    let (coarse, fine) = (of("5000"), of("80000"));
    assert!(
        coarse[0] >= 0.5 && fine[0] > 0.97 && fine[0] <= 1.0,
        "{coarse:?} {fine:?}"
    );
    assert!(fine[0] > coarse[0]);
    assert_eq!((coarse[1], coarse.len()), (1.0, 2));
}

#[test]
fn a_mesh_that_cannot_carry_a_dysfunction_is_told_with_line_and_name() {
    let coarse = |tables: &str| {
        let text = format!("{HEAD}{tables}").replace("20389", "400");
        let scenario = Scenario::parse(&text, "a.toml", None).expect("good");
        try_build(&Arc::new(scenario)).expect_err("too coarse").0
    };
    let error = coarse(&table("hypertonic", "radius_mm = [14, 9]"));
    let told = "line 8: dysfunction 1 (hypertonic at T5 right transverse process): ";
    assert!(error.starts_with(told), "{error}");
    assert!(
        error.contains("the mesh is too coarse") || error.contains("no vertex"),
        "{error}"
    );
    let beside = "[[dysfunction]]\nkind = \"hypertonic\"\nat_mm = [900, 0]\n";
    assert!(coarse(beside).contains("no vertex of the mesh lies in it at (900.0, 0.0) mm"));
    // Tenderness needs no vertex.
    let text = format!("{HEAD}{}", table("tender", "")).replace("20389", "400");
    let scenario = Scenario::parse(&text, "a.toml", None).expect("good");
    assert!(try_build(&Arc::new(scenario)).is_ok());
}
