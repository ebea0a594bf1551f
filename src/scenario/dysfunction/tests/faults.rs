//! What is refused, and how it is told.

use super::*;

#[test]
fn each_fault_is_told_with_line_dysfunction_key_value_and_what_is_allowed() {
    let head = "kind = \"hypertonic\"\nlevel = \"T5\"\nside = \"right\"\n";
    let again = format!("{head}[[dysfunction]]\n{head}");
    let many = "kind = \"rotation\"\nlevels = \"T3-T6\"\nside = \"left\"\n";
    for (table, told) in [
        (
            format!("{head}radius_mm = [0, 9]"),
            "a.toml: line 15: dysfunction 1 (hypertonic at T5 right transverse process): \
            radius_mm = [0, 9]; 1 to 300 is allowed for each",
        ),
        (
            format!("{head}severity = 4"),
            "line 15: dysfunction 1 (hypertonic): severity = 4; 0 to 3 is allowed",
        ),
        (format!("{head}severity = -1"), "severity = -1; 0 to 3"),
        (
            format!("{head}profile = \"flat\""),
            "profile = \"flat\"; allowed are \"gaussian\"",
        ),
        (
            format!("{head}preset = \"x\""),
            "preset = \"x\"; kind = \"hypertonic\" has none",
        ),
        (
            format!("{head}stiffness_change = {{ compliance_percent = -100 }}"),
            "line 15: dysfunction 1 (hypertonic at T5 right transverse process): compliance_percent = -100; -90 to 9900 is allowed",
        ),
        (
            format!("{head}stiffness_change = {{ stiffness_percent = -100 }}"),
            "stiffness_percent = -100; -99 to 900",
        ),
        (
            format!("{head}stiffness_change = {{ }}"),
            "needs either compliance_percent or stiffness_percent",
        ),
        (
            format!("{head}stiffness_change = {{ percent = 3 }}"),
            "unknown key `percent`",
        ),
        (
            format!("{head}skin_drag = 0"),
            "skin_drag = 0; 0.1 to 10 is allowed",
        ),
        (
            format!("{head}bump_mm = 40"),
            "bump_mm = 40; -20 to 20 is allowed",
        ),
        (format!("{head}bump_mm = 12"), "makes a bump as steep as"),
        (
            format!("{head}tender_above_n = 0"),
            "tender_above_n = 0; 0.1 to 50 is allowed",
        ),
        (
            format!("{head}seed = -1"),
            "seed = -1; 0 to 9223372036854775807",
        ),
        (
            format!("{head}at_mm = [1, 2]"),
            "the place needs either level (or levels) and side, or sites, or at_mm",
        ),
        (format!("{head}colour = 3"), "line 15: unknown key `colour`"),
        (
            "kind = \"gout\"\nlevel = \"T5\"".into(),
            "line 12: dysfunction 1 (gout): kind = \"gout\"; allowed are \"hypertonic\", \"trigger_point\"",
        ),
        ("kind = \"tender\"".into(), "the place needs either"),
        (
            "kind = \"tender\"\nlevel = \"T5\"".into(),
            "line 13: dysfunction 1 (tender): side is missing",
        ),
        (
            "kind = \"tender\"\nlevel = \"T5\"\nside = \"up\"".into(),
            "line 14: dysfunction 1 (tender): side = \"up\"; allowed are \"left\"",
        ),
        (
            "kind = \"tender\"\nlevel = \"T5\"\nside = \"middle\"\ntarget = \"muscle\"".into(),
            "a muscle is left or right",
        ),
        (
            "kind = \"tender\"\nlevel = \"T5-T6\"\nside = \"left\"".into(),
            "level = \"T5-T6\": not one level",
        ),
        (
            "kind = \"tender\"\nlevels = \"T6-T5\"\nside = \"left\"".into(),
            "levels = \"T6-T5\": T6-T5 runs upward",
        ),
        (
            "kind = \"tender\"\nsites = \"T5 nowhere\"".into(),
            "sites = \"T5 nowhere\"",
        ),
        (
            "kind = \"tender\"\nat_mm = [1, nan]".into(),
            "at_mm = [1, NaN]",
        ),
        (
            "kind = \"texture\"\nlevel = \"T5\"\nside = \"left\"".into(),
            "kind = \"texture\" needs a preset: \"oedema\", \"fibrosis\"",
        ),
        (
            "kind = \"rotation\"\nlevel = \"T5\"\nside = \"both\"".into(),
            "rotation is to one side",
        ),
        (
            format!("{many}preset = \"fryette_two\""),
            "fryette_two takes one level; 4 are given",
        ),
        (
            many.replace("T3-T6", "T3,T5"),
            "a group of rotated vertebrae has no gaps",
        ),
        (
            "kind = \"rotation\"\nlevel = \"T5\"\nside = \"left\"\npreset = \"fryette_one\"".into(),
            "fryette_one takes several levels",
        ),
        (
            "kind = \"rotation\"\nat_mm = [0, 300]".into(),
            "at_mm must lie beside the midline",
        ),
        (
            again.clone(),
            "line 16: dysfunction 2 (hypertonic at T5 right transverse process): dysfunction 1 is hypertonic at T5 \
            right transverse process too; keep one of them",
        ),
        (
            format!("{head}[[dysfunction]]\nkind = \"hypertonic\"\nat_mm = [25.1, 348]"),
            "line 16: dysfunction 2",
        ),
        (
            format!(
                "{head}tender_above_n = 3\n[[dysfunction]]\nkind = \"tender\"\nlevel = \"T5\"\nside = \"right\"\ntender_above_n = 2"
            ),
            "line 20: dysfunction 2 (tender at T5 right transverse process): tender above 2 N (shown), but dysfunction 1",
        ),
    ] {
        let error = parse(&format!("[[dysfunction]]\n{table}"))
            .expect_err(&table)
            .0;
        assert!(
            error.contains(told),
            "{table}\ngave {error:?}\nwanted {told:?}"
        );
        assert!(!error.contains('\n'));
    }
    let mesh = HEAD.replace("builtin = \"back\"", "mesh = \"a.obj\"");
    let on_mesh =
        |table: &str| Scenario::parse(&format!("{mesh}[[dysfunction]]\n{table}"), "a.toml", None);
    let error = on_mesh(head).expect_err("levels").0;
    assert!(
        error.contains("line 13: dysfunction 1 (hypertonic): levels are those of builtin"),
        "{error}"
    );
    assert!(on_mesh("kind = \"hypertonic\"\nat_mm = [1, 2]").is_ok());
}

#[test]
fn what_several_lead_to_together_is_bounded() {
    let stack = |kinds: &[&str], rest: &str| {
        let table = |kind: &&str| {
            format!("[[dysfunction]]\nkind = \"{kind}\"\nat_mm = [40, 300]\n{rest}\n")
        };
        parse(&kinds.iter().map(table).collect::<String>())
    };
    let most = "stiffness_change = { stiffness_percent = 900 }";
    let kinds = ["hypertonic", "tender", "skin_drag", "restricted"];
    assert!(stack(&kinds, most).is_ok());
    let soft = parse("").expect("good").source.replace("= 0.5", "= 5000");
    let table = format!("[[dysfunction]]\nkind = \"tender\"\nat_mm = [40, 300]\n{most}\n");
    let error = Scenario::parse(&format!("{soft}{table}"), "a.toml", None)
        .expect_err("too stiff")
        .0;
    let told = "dysfunction 1 (tender at (40, 300) mm): makes the stiffness 50000.0000 N/mm at (40.0, 300.0) mm";
    assert!(error.contains(told), "{error}");
    let error = stack(&kinds, "skin_drag = 4").expect_err("too rough").0;
    assert!(
        error.contains("makes the drag 256.000 times that of [friction]"),
        "{error}"
    );
    let error = stack(&kinds, "bump_mm = 4.5").expect_err("too steep").0;
    assert!(error.contains("makes a bump as steep as"), "{error}");
}
