//! The tables `[deformation]` and `[bones]`: how the drawn skin moves.

use super::ScenarioError;
use super::check::Check;
use super::maps::MAP_MM;
use crate::deform::bones::BoneSettings;
use crate::deform::curve::{self, Curve, Lookup, POINTS};
use crate::deform::footprint::Kind;
use crate::deform::models::fsmd;
use crate::geom::Vec2;
use crate::maps::bone::{BONE_DEPTHS_MM, assumed_back_keys};
use crate::maps::{BoneKey, BoneMap};
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

/// Samples that a curve may have: beyond, an array is no faster than the function.
pub const CURVE_SAMPLES: RangeInclusive<i64> = 2..=100_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeformationTable {
    curve: Option<Spanned<String>>,
    curve_points: Option<Spanned<Vec<Spanned<Vec<f64>>>>>,
    curve_samples: Option<Spanned<i64>>,
    lookup: Option<Spanned<String>>,
    footprint: Option<Spanned<String>>,
    normal_scale_shallow: Option<Spanned<f64>>,
    normal_scale_deep: Option<Spanned<f64>>,
    max_normal_mm: Option<Spanned<f64>>,
    max_tangential_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BonesTable {
    builtin: Option<Spanned<String>>,
    key: Option<Spanned<Vec<BoneKeyTable>>>,
    dent_share: Option<Spanned<f64>>,
    reference_depth_mm: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoneKeyTable {
    x: Spanned<f64>,
    y: Spanned<f64>,
    depth_mm: Spanned<f64>,
}

/// What a scenario says of the bones under its surface.
#[derive(Clone, Debug, PartialEq)]
pub struct BonesChoice {
    /// Keys of the map of the depth to bone; at least one, a map goes through them.
    pub keys: Vec<BoneKey>,
    /// Whether the keys are those assumed for the built-in back.
    pub assumed: bool,
    /// How far they limit and narrow a dent.
    pub settings: BoneSettings,
}

impl Check<'_> {
    /// The settings of the deformation, without bones; `tangential` where the scene has friction.
    pub(super) fn deformation(
        &self,
        table: Option<&DeformationTable>,
        tangential: bool,
    ) -> Result<fsmd::Settings, ScenarioError> {
        let default = fsmd::Settings {
            tangential,
            ..fsmd::Settings::default()
        };
        let Some(t) = table else {
            return Ok(default);
        };
        let number = |key: &str, value: &Option<Spanned<f64>>, allowed, or| {
            self.number_or(key, value.as_ref(), allowed, or)
        };
        let scale = |key, value, or| number(key, value, 0.01..=1.0, or);
        Ok(fsmd::Settings {
            curve: self.curve(t)?,
            footprint: match &t.footprint {
                None => default.footprint,
                Some(name) => {
                    let kinds: Vec<_> = Kind::all().iter().map(|k| (k.name(), *k)).collect();
                    self.choice("footprint", name, &kinds)?
                }
            },
            normal_scale_shallow: scale(
                "normal_scale_shallow",
                &t.normal_scale_shallow,
                default.normal_scale_shallow,
            )?,
            normal_scale_deep: scale(
                "normal_scale_deep",
                &t.normal_scale_deep,
                default.normal_scale_deep,
            )?,
            max_normal_mm: number(
                "max_normal_mm",
                &t.max_normal_mm,
                0.1..=50.0,
                default.max_normal_mm,
            )?,
            max_tangential_mm: number(
                "max_tangential_mm",
                &t.max_tangential_mm,
                0.0..=100.0,
                default.max_tangential_mm,
            )?,
            ..default
        })
    }

    fn curve(&self, t: &DeformationTable) -> Result<Curve, ScenarioError> {
        let lookup = match &t.lookup {
            None => None,
            Some(name) => {
                let lookups: Vec<_> = Lookup::all().iter().map(|l| (l.name(), *l)).collect();
                Some(self.choice("lookup", name, &lookups)?)
            }
        };
        if let (Some(samples), Some(Lookup::Exact)) = (&t.curve_samples, lookup) {
            let what = "curve_samples are those of an array; lookup = \"exact\" has none";
            return Err(self.fail(&samples.span(), what));
        }
        let samples = match &t.curve_samples {
            None => curve::PUBLISHED_SIZE,
            Some(n) if CURVE_SAMPLES.contains(n.get_ref()) => *n.get_ref() as usize,
            Some(n) => {
                let (lo, hi) = (CURVE_SAMPLES.start(), CURVE_SAMPLES.end());
                let what = format!("curve_samples = {}; {lo} to {hi} is allowed", n.get_ref());
                return Err(self.fail(&n.span(), what));
            }
        };
        let mut names: Vec<(&str, Option<Curve>)> = curve::all()
            .iter()
            .map(|(name, usual)| (*name, Some(usual())))
            .collect();
        names.push((POINTS, None));
        let named = match &t.curve {
            None if t.curve_points.is_some() => None,
            None => Some(Curve::gaussian()),
            Some(name) => {
                let places: Vec<_> = names.iter().enumerate().map(|(i, n)| (n.0, i)).collect();
                names.swap_remove(self.choice("curve", name, &places)?).1
            }
        };
        match (named, &t.curve_points) {
            (Some(usual), None) => {
                let lookup = lookup.unwrap_or(usual.lookup());
                Ok(Curve::named(usual.name(), samples, lookup).unwrap_or(usual))
            }
            (None, Some(points)) => {
                let point = |p: &Spanned<Vec<f64>>| match p.get_ref()[..] {
                    [q, share] => Ok((q, share)),
                    _ => {
                        let n = p.get_ref().len();
                        let what =
                            format!("curve_points: a point has {n} numbers; [q, share] is needed");
                        Err(self.fail(&p.span(), what))
                    }
                };
                let values: Result<Vec<_>, ScenarioError> =
                    points.get_ref().iter().map(point).collect();
                let values = values?;
                Curve::through(&values, samples, lookup.unwrap_or_default()).map_err(|e| {
                    let point = e.point().and_then(|i| points.get_ref().get(i));
                    let span = point.map_or(points.span(), Spanned::span);
                    self.fail(&span, format!("curve_points: {e}"))
                })
            }
            (Some(usual), Some(points)) => {
                let what = format!(
                    "curve_points belong to curve = \"{POINTS}\", not to {:?}",
                    usual.name()
                );
                Err(self.fail(&points.span(), what))
            }
            (None, None) => {
                let span = t.curve.as_ref().map_or(0..0, Spanned::span);
                let what = "curve = \"points\" needs curve_points = [ [0, 1], [0.5, 0.3], [1, 0] ] or the like";
                Err(self.fail(&span, what))
            }
        }
    }

    /// The bones; `on_back` where the surface is the built-in back.
    pub(super) fn bones(
        &self,
        table: &Spanned<BonesTable>,
        on_back: bool,
    ) -> Result<BonesChoice, ScenarioError> {
        let t = table.get_ref();
        let default = BoneSettings::default();
        let settings = BoneSettings {
            dent_share: self.number_or(
                "dent_share",
                t.dent_share.as_ref(),
                0.05..=1.0,
                default.dent_share,
            )?,
            reference_depth_mm: self.number_or(
                "reference_depth_mm",
                t.reference_depth_mm.as_ref(),
                BONE_DEPTHS_MM,
                default.reference_depth_mm,
            )?,
        };
        let (keys, assumed) = match (&t.builtin, &t.key) {
            (Some(name), None) => {
                self.choice("builtin", name, &[("back", ())])?;
                if !on_back {
                    let what = "builtin = \"back\" belongs to the built-in back; state the bones of a mesh as key = [ … ]";
                    return Err(self.fail(&name.span(), what));
                }
                (assumed_back_keys(), true)
            }
            (None, Some(keys)) => {
                let key = |k: &BoneKeyTable| {
                    Ok(BoneKey {
                        at: Vec2::new(
                            self.number("x", &k.x, MAP_MM)?,
                            self.number("y", &k.y, MAP_MM)?,
                        ),
                        depth_mm: self.number("depth_mm", &k.depth_mm, BONE_DEPTHS_MM)?,
                    })
                };
                let stated: Result<Vec<_>, ScenarioError> =
                    keys.get_ref().iter().map(key).collect();
                let stated = stated?;
                // The map's own checks (none, two depths at one place) are told with the line of the list.
                BoneMap::new(stated.clone()).map_err(|e| self.fail(&keys.span(), e.to_string()))?;
                (stated, false)
            }
            _ => {
                let what =
                    "[bones] needs either builtin = \"back\" or key = [ { x, y, depth_mm }, … ]";
                return Err(self.fail(&table.span(), what));
            }
        };
        Ok(BonesChoice {
            keys,
            assumed,
            settings,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Item, Scenario, Use, build, rebuild};
    use std::sync::Arc;

    fn parsed(tables: &str) -> Result<Scenario, ScenarioError> {
        let head = "format = 1\nname = \"Test\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\nconstant_n_per_mm = 0.5\n";
        Scenario::parse(&format!("{head}{tables}"), "a.toml", None)
    }

    #[test]
    fn without_the_tables_everything_is_as_by_default_and_there_are_no_bones() {
        let s = parsed("").unwrap();
        assert_eq!(s.deform.curve, Curve::gaussian());
        assert_eq!(s.deform.footprint, Kind::Ellipse);
        assert!(s.bones.is_none() && s.deform.bones.is_none());
    }

    #[test]
    fn curves_are_chosen_by_name_size_and_lookup() {
        let curve = |text: &str| {
            parsed(&format!("[deformation]\n{text}\n"))
                .unwrap()
                .deform
                .curve
        };
        for (name, usual) in curve::all() {
            assert_eq!(curve(&format!("curve = {name:?}")), usual(), "{name}");
        }
        let c = curve("curve = \"cosine\"\ncurve_samples = 20\nlookup = \"nearest\"");
        assert_eq!(
            (c.name(), c.samples().len(), c.lookup()),
            ("cosine", 20, Lookup::Nearest)
        );
        let c = curve("lookup = \"exact\"");
        assert_eq!((c.name(), c.lookup()), ("gaussian", Lookup::Exact));
        for text in ["curve = \"points\"\n", ""] {
            let c = curve(&format!(
                "{text}curve_points = [[0, 1], [0.5, 0.25], [1, 0]]"
            ));
            assert_eq!((c.name(), c.exact(0.5)), ("points", 0.25));
        }
    }

    #[test]
    fn footprints_and_bones_are_chosen() {
        for &kind in Kind::all() {
            let s = parsed(&format!("[deformation]\nfootprint = {:?}\n", kind.name())).unwrap();
            assert_eq!(s.deform.footprint, kind);
        }
        let s = parsed("[bones]\nbuiltin = \"back\"\ndent_share = 0.5\n").unwrap();
        let bones = s.bones.unwrap();
        assert!(bones.assumed && bones.keys.len() > 40 && bones.settings.dent_share == 0.5);
        let s =
            parsed("[bones]\nkey = [ { x = 0, y = 1, depth_mm = 6 } ]\nreference_depth_mm = 30")
                .unwrap();
        let bones = s.bones.unwrap();
        assert_eq!(
            (
                bones.keys[0].depth_mm,
                bones.assumed,
                bones.settings.reference_depth_mm
            ),
            (6.0, false, 30.0)
        );
    }

    #[test]
    fn each_fault_is_told_with_line_key_value_and_what_is_allowed() {
        for (tables, told) in [
            (
                "[deformation]\ncurve = \"parabola\"",
                "a.toml: line 8: curve = \"parabola\"; allowed are \"gaussian\", \"gaussian-printed\", \"cosine\", \"logarithmic\", \"gaussian-sharp\", \"points\"",
            ),
            (
                "[deformation]\ncurve = \"points\"",
                "line 8: curve = \"points\" needs curve_points",
            ),
            (
                "[deformation]\ncurve = \"cosine\"\ncurve_points = [[0, 1], [1, 0]]",
                "line 9: curve_points belong to curve = \"points\", not to \"cosine\"",
            ),
            (
                "[deformation]\ncurve_points = []",
                "line 8: curve_points: curve \"points\" has 0 points; at least 2 are needed",
            ),
            (
                "[deformation]\ncurve_points = [[0, 1],\n[0.5, 0.2],\n[0.4, 0.1], [1, 0]]",
                "line 10: curve_points: curve \"points\": point 3 is at q = 0.4; it must be a number above 0.5",
            ),
            (
                "[deformation]\ncurve_points = [[0, 1],\n[0.5, 7], [1, 0]]",
                "line 9: curve_points: curve \"points\": point 2 is 7 at q = 0.5; a number in -1 ... 1 is allowed",
            ),
            (
                "[deformation]\ncurve_points = [[0, nan], [1, 0]]",
                "line 8: curve_points: curve \"points\": point 1 is NaN",
            ),
            (
                "[deformation]\ncurve_points = [[0, 1, 2], [1, 0]]",
                "line 8: curve_points: a point has 3 numbers; [q, share] is needed",
            ),
            (
                "[deformation]\ncurve_samples = 1",
                "line 8: curve_samples = 1; 2 to 100000 is allowed",
            ),
            (
                "[deformation]\nlookup = \"exact\"\ncurve_samples = 20",
                "line 9: curve_samples are those of an array",
            ),
            (
                "[deformation]\nlookup = \"cubic\"",
                "line 8: lookup = \"cubic\"; allowed are \"nearest\", \"linear\", \"exact\"",
            ),
            (
                "[deformation]\nfootprint = \"square\"",
                "line 8: footprint = \"square\"; allowed are \"circle\", \"ellipse\", \"ellipse-printed\", \"irregular\"",
            ),
            (
                "[deformation]\nmax_normal_mm = 0",
                "line 8: max_normal_mm = 0; 0.1 to 50 is allowed",
            ),
            (
                "[deformation]\nnormal_scale_deep = 2",
                "line 8: normal_scale_deep = 2; 0.01 to 1 is allowed",
            ),
            (
                "[bones]\n",
                "line 7: [bones] needs either builtin = \"back\" or key",
            ),
            (
                "[bones]\nbuiltin = \"hand\"",
                "line 8: builtin = \"hand\"; allowed is \"back\"",
            ),
            (
                "[bones]\nbuiltin = \"back\"\ndent_share = 2",
                "line 9: dent_share = 2; 0.05 to 1 is allowed",
            ),
            (
                "[bones]\nbuiltin = \"back\"\nreference_depth_mm = nan",
                "line 9: reference_depth_mm = NaN; 1 to 500 is allowed",
            ),
            ("[bones]\nkey = []", "line 8: the map of bones has no keys"),
            (
                "[bones]\nkey = [ { x = 0, y = 0, depth_mm = 0.1 } ]",
                "line 8: depth_mm = 0.1; 1 to 500 is allowed",
            ),
            (
                "[bones]\nkey = [ { x = inf, y = 0, depth_mm = 9 } ]",
                "line 8: x = inf",
            ),
            (
                "[bones]\nkey = [ { x = 0, y = 0, depth_mm = 9 }, { x = 0, y = 0, depth_mm = 8 } ]",
                "line 8: bone keys 1 and 2 are both at (0, 0) mm",
            ),
            ("[bones]\nkeys = []", "line 8: unknown key `keys`"),
        ] {
            let error = parsed(tables).expect_err(tables).to_string();
            assert!(
                error.contains(told),
                "{tables:?} gave {error:?}, wanted {told:?}"
            );
            assert!(!error.contains('\n'), "{error:?}");
        }
    }

    #[test]
    fn assumed_bones_are_those_of_the_built_in_back_alone() {
        let text = "format = 1\nname = \"Test\"\n[surface]\nmesh = \"scan.obj\"\n[stiffness]\nconstant_n_per_mm = 0.5\n[bones]\nbuiltin = \"back\"\n";
        let error = Scenario::parse(text, "a.toml", None)
            .expect_err("a mesh")
            .to_string();
        assert!(
            error.contains("line 8: builtin = \"back\" belongs to the built-in back"),
            "{error}"
        );
    }

    #[test]
    fn bones_are_built_where_something_shows_the_skin_and_kept_by_an_edit_of_something_else() {
        let shown = Use {
            fingers: 1,
            deformed: true,
            ..Use::default()
        };
        let built = |tables: &str, purpose| {
            build(Arc::new(parsed(tables).unwrap()), purpose, &mut |_, _| true).unwrap()
        };
        let bones = "[bones]\nbuiltin = \"back\"\n";
        for scene in [built("", shown), built(bones, Use::default())] {
            let row = scene.ledger.row(Item::Bones);
            assert!(
                scene.deform.bones.is_none() && !row.built && row.bytes == 0,
                "{row:?}"
            );
        }
        let scene = built(bones, shown);
        let held = scene.deform.bones.clone().unwrap();
        assert_eq!(scene.ledger.row(Item::Bones).bytes, held.bytes());
        assert_eq!(held.depth_mm().len(), scene.surface.positions().len());

        let edited = |tables: &str| {
            let scenario = Arc::new(parsed(tables).unwrap());
            rebuild(&scene, scenario, shown).unwrap()
        };
        let other = edited(&format!("{bones}[deformation]\ncurve = \"cosine\"\n"));
        assert!(Arc::ptr_eq(other.deform.bones.as_ref().unwrap(), &held));
        assert_eq!(other.deform.curve.name(), "cosine");
        let softer = edited(&format!("{bones}dent_share = 0.4\n"));
        assert_eq!(softer.deform.bones.unwrap().settings().dent_share, 0.4);
        assert!(edited("").deform.bones.is_none());
    }
}
