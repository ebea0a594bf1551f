//! Edited scenes: what an edit leaves as it is is shared, what it changes is what a scene built from scratch has, bit for bit.

use dorsum::contact::Stiffness;
use dorsum::scenario::{self, Item, Scenario, Scene, Use};
use std::sync::Arc;

const TEXT: &str = r#"format = 1
name = "Edited"
[surface]
builtin = "back"
triangles = 2962
[stiffness]
key = [
  { x = 0, y = 100, stiffness_n_per_mm = 0.5 },
  { x = 100, y = 300, stiffness_n_per_mm = 0.8 },
  { x = -100, y = 200, stiffness_n_per_mm = 0.3 },
]
[friction]
static = 0.46
dynamic = 0.44
[ellipse]
key = [
  { x = 0, y = 200, half_major_mm = 160, half_minor_mm = 90, angle_deg = 40 },
]
[deformation]
max_normal_mm = 10
"#;

const DRAWN: Use = Use {
    fingers: 2,
    live: true,
    drawn: true,
    deformed: true,
    recorded: false,
    plotted: false,
    partitioned: false,
    bones_drawn: false,
    named: false,
    hands_drawn: false,
    two_eyes: false,
    coloured: false,
    ellipse_edited: false,
    stiffness_edited: false,
    scenario_edited: false,
    listed: false,
    browsed: false,
    ghosts: false,
    compared: false,
    passivity: false,
};

fn parsed(text: &str) -> Arc<Scenario> {
    Arc::new(Scenario::parse(text, "a.toml", None).expect("good"))
}

fn built(text: &str, purpose: Use) -> Scene {
    scenario::build(parsed(text), purpose, &mut |_, _| true).expect("builds")
}

fn values(scene: &Scene) -> Vec<u64> {
    match &scene.touch.stiffness {
        Stiffness::Uniform(k) => vec![k.to_bits()],
        Stiffness::PerVertex(values) => values.iter().map(|k| k.to_bits()).collect(),
    }
}

fn ovals(scene: &Scene) -> Option<Vec<[u64; 3]>> {
    let field = scene.ellipse_field.as_ref()?;
    let vertices = 0..scene.surface.positions().len() as u32;
    let bits = vertices.map(|v| {
        let oval = field.vertex(v);
        [oval.half_major_mm, oval.half_minor_mm, oval.angle_rad].map(f64::to_bits)
    });
    Some(bits.collect())
}

fn shares_stiffness(a: &Scene, b: &Scene) -> bool {
    let same_field = match (&a.touch.stiffness, &b.touch.stiffness) {
        (Stiffness::PerVertex(a), Stiffness::PerVertex(b)) => Arc::ptr_eq(a, b),
        _ => false,
    };
    assert_eq!(same_field, Arc::ptr_eq(&a.stiffness, &b.stiffness));
    same_field
}

fn shares_ellipses(a: &Scene, b: &Scene) -> bool {
    match (&a.ellipse_field, &b.ellipse_field) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}

#[test]
fn an_edit_builds_what_it_changes_and_shares_the_rest() {
    let old = built(TEXT, DRAWN);
    assert!(old.ellipse.is_some() && old.ledger.row(Item::EllipseField).built);
    // Text, whether it keeps the stiffness and the ellipses.
    let edits = [
        (TEXT.replace("0.8", "0.9"), false, true),
        (
            TEXT.replace("half_minor_mm = 90", "half_minor_mm = 70"),
            true,
            false,
        ),
        (
            TEXT.replace("max_normal_mm = 10", "max_normal_mm = 12"),
            true,
            true,
        ),
        (TEXT.replace("\"Edited\"", "\"Renamed\""), true, true),
        (format!("{TEXT}# a remark\n"), true, true),
    ];
    for (text, same_stiffness, same_ellipses) in edits {
        let new = scenario::rebuild(&old, parsed(&text), DRAWN).expect("an edit");
        let fresh = built(&text, DRAWN);
        assert!(Arc::ptr_eq(&old.surface, &new.surface));
        assert!(Arc::ptr_eq(&old.touch.search, &new.touch.search));
        assert!(new.touch.fading.is_none());
        assert_eq!(shares_stiffness(&old, &new), same_stiffness);
        assert_eq!(shares_ellipses(&old, &new), same_ellipses);
        assert_eq!(values(&new), values(&fresh));
        assert_eq!(ovals(&new), ovals(&fresh));
        assert_eq!(new.deform, fresh.deform);
        assert_eq!(new.scenario, fresh.scenario);
        assert_eq!(new.touch.choices, fresh.touch.choices);
        for (a, b) in new.ledger.rows.iter().zip(&fresh.ledger.rows) {
            assert_eq!((a.item, &a.reason), (b.item, &b.reason));
            assert_eq!((a.built, a.bytes), (b.built, b.bytes), "{}", a.item);
        }
    }
}

#[test]
fn a_map_goes_and_comes_with_its_keys_and_with_what_shows_the_skin() {
    let old = built(TEXT, DRAWN);
    let start = TEXT.find("[ellipse]").expect("there");
    let end = TEXT.find("[deformation]").expect("there");
    let circle = format!("{}{}", &TEXT[..start], &TEXT[end..]);
    let without = scenario::rebuild(&old, parsed(&circle), DRAWN).expect("an edit");
    assert!(without.ellipse.is_none() && without.ellipse_field.is_none());
    assert!(!without.ledger.row(Item::EllipseField).built);
    assert!(ovals(&old).is_some());
    let again = scenario::rebuild(&without, parsed(TEXT), DRAWN).expect("an edit");
    assert_eq!(ovals(&again), ovals(&old));

    let felt_only = built(TEXT, Use::default());
    assert!(felt_only.ellipse_field.is_none());
    let shown = scenario::rebuild(&felt_only, parsed(TEXT), DRAWN).expect("an edit");
    assert_eq!(ovals(&shown), ovals(&old));

    let constant = TEXT.replace("0.5 }", "0.3 }").replace("0.8 }", "0.3 }");
    let constant = scenario::rebuild(&old, parsed(&constant), DRAWN).expect("an edit");
    assert!(matches!(constant.touch.stiffness, Stiffness::Uniform(_)));
}

#[test]
fn what_decides_where_a_finger_rests_is_not_edited_under_it() {
    let old = built(TEXT, DRAWN);
    for (table, text) in [
        ("[surface]", TEXT.replace("2962", "3000")),
        ("[friction]", TEXT.replace("static = 0.46", "static = 0.5")),
        (
            "[friction]",
            TEXT.replace("[friction]\nstatic = 0.46\ndynamic = 0.44\n", ""),
        ),
        (
            "[force]",
            format!("{TEXT}[force]\nmodel = \"exponential\"\n"),
        ),
        (
            "[contact]",
            format!("{TEXT}[contact]\nfinger_radius_mm = 4.0\n"),
        ),
        (
            "[contact]",
            format!("{TEXT}[contact]\nshading = \"normals\"\n"),
        ),
        (
            "[contact]",
            format!("{TEXT}[contact]\nengine = \"published\"\n"),
        ),
    ] {
        let error = scenario::rebuild(&old, parsed(&text), DRAWN).expect_err(table);
        assert!(
            error.0.starts_with(table) && !error.0.contains('\n'),
            "{error}"
        );
    }
}
