//! The tables `[force]` and `[contact]`: how the finger meets the surface, by name.

use super::ScenarioError;
use super::check::Check;
use crate::contact::{Choices, ForceModel, published};
use crate::partition::Sides;
use crate::partition::hdb::Query;
use crate::partition::tree::Case;
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ForceTable {
    model: Spanned<String>,
    start_stiffness_percent: Option<Spanned<f64>>,
    trend_mm: Option<Spanned<f64>>,
    growth_per_mm: Option<Spanned<f64>>,
    damping_s_per_mm: Option<Spanned<f64>>,
    exponent: Option<Spanned<f64>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactTable {
    engine: Option<Spanned<String>>,
    partition: Option<Spanned<String>>,
    threshold: Option<Spanned<i64>>,
    case: Option<Spanned<String>>,
    hdb_part: Option<Spanned<f64>>,
    query: Option<Spanned<String>>,
    finger_radius_mm: Option<Spanned<f64>>,
    sides: Option<Spanned<String>>,
    shading: Option<Spanned<String>>,
}

/// Most triangles in a leaf allowed.
const THRESHOLD: RangeInclusive<i64> = 1..=10_000_000;

impl Check<'_> {
    /// What both tables choose; absent ones leave the defaults.
    pub(super) fn choices(
        &self,
        force: Option<&ForceTable>,
        contact: Option<&ContactTable>,
    ) -> Result<Choices, ScenarioError> {
        let radius = contact.and_then(|t| t.finger_radius_mm.as_ref());
        let sides = match contact.and_then(|t| t.sides.as_ref()) {
            Some(sides) => {
                let names: Vec<_> = Sides::all().iter().map(|s| (s.name(), *s)).collect();
                self.choice("sides", sides, &names)?
            }
            None => Sides::default(),
        };
        let finger_radius_mm = self.number_or("finger_radius_mm", radius, 0.0..=50.0, 0.0)?;
        let shaded = match contact.and_then(|t| t.shading.as_ref()) {
            None => false,
            Some(name) => {
                let shaded = self.choice("shading", name, &[("none", false), ("normals", true)])?;
                if shaded && finger_radius_mm > 0.0 {
                    let what = "shading = \"normals\" is for a point; a finger_radius_mm above 0 rounds by itself";
                    return Err(self.fail(&name.span(), what));
                }
                shaded
            }
        };
        Ok(Choices {
            sides,
            finger_radius_mm,
            shaded,
            force: force.map_or(Ok(ForceModel::default()), |t| self.force(t))?,
        })
    }

    /// The published pass, where the table asks for it.
    pub(super) fn published(
        &self,
        t: &ContactTable,
    ) -> Result<Option<published::Options>, ScenarioError> {
        let published = match &t.engine {
            None => false,
            Some(name) => self.choice(
                "engine",
                name,
                &[("production", false), ("published", true)],
            )?,
        };
        if !published {
            for (key, span) in [
                ("partition", t.partition.as_ref().map(Spanned::span)),
                ("threshold", t.threshold.as_ref().map(Spanned::span)),
                ("case", t.case.as_ref().map(Spanned::span)),
                ("hdb_part", t.hdb_part.as_ref().map(Spanned::span)),
                ("query", t.query.as_ref().map(Spanned::span)),
            ] {
                if let Some(span) = span {
                    let what = format!("{key} belongs to engine = \"published\"");
                    return Err(self.fail(&span, what));
                }
            }
            return Ok(None);
        }
        for (key, span) in [
            (
                "finger_radius_mm",
                t.finger_radius_mm.as_ref().map(Spanned::span),
            ),
            ("sides", t.sides.as_ref().map(Spanned::span)),
            ("shading", t.shading.as_ref().map(Spanned::span)),
        ] {
            if let Some(span) = span {
                let what = format!("{key} belongs to engine = \"production\"");
                return Err(self.fail(&span, what));
            }
        }
        let mut options = published::Options::default();
        if let Some(name) = &t.partition {
            let kinds = published::KINDS.map(|kind| (kind, kind));
            options.partition = self.choice("partition", name, &kinds)?;
        }
        let kind = options.partition;
        if let Some(threshold) = &t.threshold {
            let n = *threshold.get_ref();
            if kind == "brute" || !THRESHOLD.contains(&n) {
                let (lo, hi) = (THRESHOLD.start(), THRESHOLD.end());
                let what = match kind {
                    "brute" => "threshold belongs to a structure; brute has no leaves".to_owned(),
                    _ => format!("threshold = {n}; {lo} to {hi} is allowed"),
                };
                return Err(self.fail(&threshold.span(), what));
            }
            options.tree.threshold = n as usize;
        }
        if let Some(case) = &t.case {
            if kind != "bsp" {
                return Err(self.fail(&case.span(), "case belongs to partition = \"bsp\""));
            }
            let cases = [("A", Case::A), ("B", Case::B), ("C", Case::C)];
            options.tree.case = self.choice("case", case, &cases)?;
        }
        options.hdb_part = self.number_or(
            "hdb_part",
            t.hdb_part.as_ref(),
            0.001..=4.0,
            options.hdb_part,
        )?;
        if let Some(query) = &t.query {
            let queries = [
                ("published", Query::Published),
                ("complete", Query::Complete),
            ];
            options.query = self.choice("query", query, &queries)?;
        }
        Ok(Some(options))
    }

    fn force(&self, t: &ForceTable) -> Result<ForceModel, ScenarioError> {
        let models: Vec<_> = ForceModel::all().iter().map(|m| (m.name(), *m)).collect();
        let mut model = self.choice("model", &t.model, &models)?;
        let mut numbers = [
            Number::new("start_stiffness_percent", &t.start_stiffness_percent),
            Number::new("trend_mm", &t.trend_mm),
            Number::new("growth_per_mm", &t.growth_per_mm),
            Number::new("damping_s_per_mm", &t.damping_s_per_mm),
            Number::new("exponent", &t.exponent),
        ];
        let [start, trend, growth, damping, order] = &mut numbers;
        match &mut model {
            ForceModel::Linear => {}
            ForceModel::Nonlinear {
                start_share,
                trend_mm,
            } => {
                *start_share = start.take(self, 1.0..=100.0, *start_share * 100.0)? / 100.0;
                *trend_mm = trend.take(self, 0.01..=100.0, *trend_mm)?;
            }
            ForceModel::Exponential { growth_per_mm } => {
                *growth_per_mm = growth.take(self, 0.001..=10.0, *growth_per_mm)?;
            }
            ForceModel::HuntCrossley {
                damping_s_per_mm,
                exponent,
            } => {
                *damping_s_per_mm = damping.take(self, 0.0..=1.0, *damping_s_per_mm)?;
                *exponent = order.take(self, 1.0..=4.0, *exponent)?;
            }
        }
        if let Some((key, value)) = numbers.iter().find_map(|n| Some((n.key, n.value?))) {
            let what = format!("{key} does not belong to model = {:?}", model.name());
            return Err(self.fail(&value.span(), what));
        }
        Ok(model)
    }
}

/// A number of the table that a model takes if it is its own.
struct Number<'a> {
    key: &'static str,
    value: Option<&'a Spanned<f64>>,
}

impl<'a> Number<'a> {
    fn new(key: &'static str, value: &'a Option<Spanned<f64>>) -> Self {
        let value = value.as_ref();
        Self { key, value }
    }

    fn take(
        &mut self,
        check: &Check<'_>,
        allowed: RangeInclusive<f64>,
        or: f64,
    ) -> Result<f64, ScenarioError> {
        check.number_or(self.key, self.value.take(), allowed, or)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn parse(tables: &str) -> Result<Scenario, ScenarioError> {
        let text = format!(
            "format = 1\nname = \"T\"\nsurface.builtin = \"back\"\nstiffness.constant_n_per_mm = 1\n{tables}"
        );
        Scenario::parse(&text, "a.toml", None)
    }

    #[test]
    fn the_sides_felt_are_chosen_by_name() {
        for sides in Sides::all() {
            let table = format!("[contact]\nsides = {:?}", sides.name());
            assert_eq!(parse(&table).expect("valid").choices.sides, *sides);
        }
        let error = parse("[contact]\nsides = \"back\"").expect_err("no such side");
        let text = error.to_string();
        assert!(text.contains("sides") && text.contains("front"), "{text}");
    }

    #[test]
    fn every_force_model_is_chosen_by_name_with_its_defaults() {
        assert_eq!(parse("").expect("valid").choices, Choices::default());
        for model in ForceModel::all() {
            let scenario = parse(&format!("[force]\nmodel = {:?}", model.name())).expect("valid");
            assert_eq!(scenario.choices.force, *model);
        }
    }

    #[test]
    fn the_numbers_of_a_model_reach_it() {
        let force = |text: &str| {
            parse(&format!("[force]\n{text}"))
                .expect(text)
                .choices
                .force
        };
        assert_eq!(
            force("model = \"nonlinear\"\nstart_stiffness_percent = 25\ntrend_mm = 2.5"),
            ForceModel::Nonlinear {
                start_share: 0.25,
                trend_mm: 2.5
            }
        );
        assert_eq!(
            force("model = \"exponential\"\ngrowth_per_mm = 0.4"),
            ForceModel::Exponential { growth_per_mm: 0.4 }
        );
        assert_eq!(
            force("model = \"hunt-crossley\"\ndamping_s_per_mm = 0.01\nexponent = 2"),
            ForceModel::HuntCrossley {
                damping_s_per_mm: 0.01,
                exponent: 2.0
            }
        );
    }

    #[test]
    fn the_published_pass_is_chosen_whole() {
        let published = |text: &str| parse(text).expect(text).published;
        assert_eq!(published("[contact]\nengine = \"production\""), None);
        let default = published::Options::default();
        assert_eq!(
            published("[contact]\nengine = \"published\""),
            Some(default)
        );
        let mut options = published::Options {
            partition: "bsp",
            hdb_part: 0.1,
            query: Query::Complete,
            ..default
        };
        (options.tree.threshold, options.tree.case) = (64, Case::B);
        assert_eq!(
            published(
                "[contact]\nengine = \"published\"\npartition = \"bsp\"\nthreshold = 64\ncase = \"B\"\nhdb_part = 0.1\nquery = \"complete\""
            ),
            Some(options)
        );
    }

    #[test]
    fn the_finger_is_a_point_unless_it_has_a_radius() {
        let choices = |text: &str| parse(text).expect(text).choices;
        assert_eq!(choices("").pad_mm(), None);
        let pad = choices("[contact]\nfinger_radius_mm = 5.5");
        assert_eq!(pad.pad_mm(), Some(5.5));
    }

    #[test]
    fn shading_is_off_unless_chosen() {
        let shaded = |text: &str| parse(text).expect(text).choices.shaded;
        assert!(!shaded(""));
        assert!(!shaded("[contact]\nshading = \"none\""));
        assert!(shaded("[contact]\nshading = \"normals\""));
    }

    #[test]
    fn each_fault_is_told_with_line_key_value_and_what_is_allowed() {
        for (tables, told) in [
            (
                "[force]\nmodel = \"spring\"",
                "line 6: model = \"spring\"; allowed are \"linear\", \"nonlinear\", \"exponential\", \"hunt-crossley\"",
            ),
            ("[force]\ntrend_mm = 3", "line 5: missing key `model`"),
            (
                "[force]\nmodel = \"linear\"\ntrend_mm = 3",
                "line 7: trend_mm does not belong to model = \"linear\"",
            ),
            (
                "[force]\nmodel = \"nonlinear\"\nstart_stiffness_percent = 0",
                "line 7: start_stiffness_percent = 0; 1 to 100 is allowed",
            ),
            (
                "[force]\nmodel = \"exponential\"\ngrowth_per_mm = nan",
                "line 7: growth_per_mm = NaN; 0.001 to 10 is allowed",
            ),
            (
                "[force]\nmodel = \"hunt-crossley\"\nexponent = 0.5",
                "line 7: exponent = 0.5; 1 to 4 is allowed",
            ),
            (
                "[force]\nmodel = \"linear\"\nk = 3",
                "line 7: unknown key `k`",
            ),
            (
                "[contact]\nengine = \"magic\"",
                "line 6: engine = \"magic\"; allowed",
            ),
            (
                "[contact]\nshading = \"phong\"",
                "line 6: shading = \"phong\"; allowed are \"none\", \"normals\"",
            ),
            (
                "[contact]\nshading = \"normals\"\nfinger_radius_mm = 5",
                "line 6: shading = \"normals\" is for a point",
            ),
            (
                "[contact]\nengine = \"published\"\nfinger_radius_mm = 5",
                "line 7: finger_radius_mm belongs to engine = \"production\"",
            ),
            (
                "[contact]\nfinger_radius_mm = -1",
                "line 6: finger_radius_mm = -1; 0 to 50 is allowed",
            ),
            (
                "[contact]\nengine = \"published\"\nfinger_radius_mm = 5",
                "line 7: finger_radius_mm belongs to engine = \"production\"",
            ),
            (
                "[contact]\nengines = \"production\"",
                "line 6: unknown key `engines`",
            ),
        ] {
            let error = parse(tables).expect_err(tables).to_string();
            assert!(error.contains(told), "{tables:?} gave {error:?}");
            assert!(!error.contains('\n'), "{error:?}");
        }
    }
}
