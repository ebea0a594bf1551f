//! The example scenarios embedded in the program.

/// An embedded scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// File name in `assets/scenarios`.
    pub file: &'static str,
    /// The file, whole.
    pub text: &'static str,
}

const EXAMPLES: [Example; 14] = [
    Example {
        file: "FIRST.toml",
        text: include_str!("../../assets/scenarios/FIRST.toml"),
    },
    Example {
        file: "t5_right.toml",
        text: include_str!("../../assets/scenarios/t5_right.toml"),
    },
    Example {
        file: "compare_two.toml",
        text: include_str!("../../assets/scenarios/compare_two.toml"),
    },
    Example {
        file: "unknown_back.toml",
        text: include_str!("../../assets/scenarios/unknown_back.toml"),
    },
    Example {
        file: "fryette_two.toml",
        text: include_str!("../../assets/scenarios/fryette_two.toml"),
    },
    Example {
        file: "tender_knot.toml",
        text: include_str!("../../assets/scenarios/tender_knot.toml"),
    },
    Example {
        file: "fibrosis.toml",
        text: include_str!("../../assets/scenarios/fibrosis.toml"),
    },
    Example {
        file: "locate.toml",
        text: include_str!("../../assets/scenarios/locate.toml"),
    },
    Example {
        file: "frictionless.toml",
        text: include_str!("../../assets/scenarios/frictionless.toml"),
    },
    Example {
        file: "loose_skin.toml",
        text: include_str!("../../assets/scenarios/loose_skin.toml"),
    },
    Example {
        file: "fingertip.toml",
        text: include_str!("../../assets/scenarios/fingertip.toml"),
    },
    Example {
        file: "fibres.toml",
        text: include_str!("../../assets/scenarios/fibres.toml"),
    },
    Example {
        file: "bones.toml",
        text: include_str!("../../assets/scenarios/bones.toml"),
    },
    Example {
        file: "published.toml",
        text: include_str!("../../assets/scenarios/published.toml"),
    },
];

/// All of them; the first is the default.
pub fn examples() -> &'static [Example] {
    &EXAMPLES
}

/// What opens when nothing is asked for.
pub fn default_example() -> Example {
    EXAMPLES[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Item, Needs, Scenario, Use, build};
    use std::sync::Arc;

    #[test]
    fn every_example_parses_and_builds_and_has_its_own_name() {
        let mut names = Vec::new();
        for example in examples() {
            let scenario = Scenario::parse(example.text, example.file, None).expect(example.file);
            names.push(scenario.name.clone());
            assert!(
                !scenario.description.is_empty(),
                "{} says nothing of itself",
                example.file
            );
            let scene = build(
                Arc::new(scenario),
                Use {
                    fingers: 1,
                    ..Use::default()
                },
                &mut |_, _| true,
            );
            assert!(scene.expect(example.file).surface.triangles().len() > 2000);
        }
        names.sort();
        names.dedup();
        assert_eq!(names.len(), examples().len());
    }

    #[test]
    fn every_file_in_the_folder_is_embedded() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/scenarios");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .expect("folder")
            .map(|f| f.expect("entry").file_name().into_string().expect("UTF-8"))
            .collect();
        files.sort();
        let mut embedded: Vec<&str> = examples().iter().map(|e| e.file).collect();
        embedded.sort_unstable();
        assert_eq!(files, embedded);
    }

    #[test]
    fn a_frictionless_uniform_scene_gets_nothing_it_does_not_need() {
        let example = examples()
            .iter()
            .find(|e| e.file == "frictionless.toml")
            .expect("embedded");
        let scenario = Arc::new(Scenario::parse(example.text, example.file, None).expect("valid"));
        let purpose = Use {
            fingers: 1,
            drawn: true,
            ..Use::default()
        };
        let needs = Needs::of(&scenario, purpose);
        assert!(
            !needs.has(Item::Friction)
                && !needs.has(Item::TangentialField)
                && !needs.has(Item::StiffnessField)
        );
        let scene = build(scenario, purpose, &mut |_, _| true).expect("builds");
        assert!(scene.touch.friction.is_none() && !scene.deform.tangential);
        assert_eq!(scene.touch.stiffness.bytes(), 0);
        for item in [
            Item::Friction,
            Item::TangentialField,
            Item::StiffnessField,
            Item::PlotHistory,
            Item::Recorder,
        ] {
            let row = scene.ledger.row(item);
            assert!(
                !row.built && row.bytes == 0 && row.cost_us.is_none(),
                "{row:?}"
            );
        }
    }

    /// Every part that a scene of dysfunctions may do without, and whether each example has it.
    #[test]
    fn what_a_dysfunction_does_not_need_is_absent() {
        use Item::{Bumps, Friction, SkinDrag, StiffnessField, Tenderness};
        for (file, built) in [
            ("FIRST.toml", [true, true, false, false, false]),
            ("fryette_two.toml", [true, true, true, false, true]),
            ("tender_knot.toml", [true, false, true, false, true]),
            ("fibrosis.toml", [true, true, true, true, false]),
            ("frictionless.toml", [false; 5]),
        ] {
            let example = examples()
                .iter()
                .find(|e| e.file == file)
                .expect("embedded");
            let scenario = Scenario::parse(example.text, file, None).expect("valid");
            let plain = scenario.with_dysfunctions(&[]).expect("valid");
            let [scene, plain] = [scenario, plain].map(|s| {
                let fingers = Use {
                    fingers: 1,
                    ..Use::default()
                };
                build(Arc::new(s), fingers, &mut |_, _| true).expect("builds")
            });
            for (item, built) in [StiffnessField, Friction, Bumps, SkinDrag, Tenderness]
                .into_iter()
                .zip(built)
            {
                let row = scene.ledger.row(item);
                assert_eq!(row.built, built, "{file}: {row:?}");
                assert!(
                    built || row.bytes == 0 && row.cost_us.is_none(),
                    "{file}: {row:?}"
                );
            }
            let touch = &scene.touch;
            assert_eq!(touch.drag.is_some(), built[3], "{file}");
            assert_eq!(touch.friction.is_some(), built[1], "{file}");
            assert_eq!(scene.tenderness.is_some(), built[4], "{file}");
            assert_eq!(
                scene.surface.hash() != plain.surface.hash(),
                built[2],
                "{file}"
            );
        }
    }

    #[test]
    fn stopping_the_builder_stops_it() {
        let example = default_example();
        let scenario = Arc::new(Scenario::parse(example.text, example.file, None).expect("valid"));
        let error = build(scenario, Use::default(), &mut |_, fraction| fraction < 0.5)
            .expect_err("stopped");
        assert_eq!(error.0, "cancelled");
    }
}
