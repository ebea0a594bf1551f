//! The tables `[stiffness]` and `[ellipse]`: keys over the map plane and the functions through them.

use super::check::Check;
use super::{Scenario, ScenarioError};
use crate::geom::Vec2;
use crate::geom::curve;
use crate::maps::appendix::{self, Force, Means};
use crate::maps::ellipse::{BASIC_RADII_MM, EFFECT_RADII_MM, HALF_AXES_MM};
use crate::maps::stiffness::{STROKE_CHANGES, STROKE_RADII_MM};
use crate::maps::{
    AngleRule, EllipseKey, EllipseMap, EllipseSettings, Fit, Form, Level, MapError, StiffnessKey,
    StiffnessMap, Stroke,
};
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StiffnessTable {
    fit: Option<Spanned<String>>,
    constant_n_per_mm: Option<Spanned<f64>>,
    key: Option<Spanned<Vec<Spanned<KeyTable>>>>,
    stroke: Option<Vec<Spanned<StrokeTable>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyTable {
    x: Spanned<f64>,
    y: Spanned<f64>,
    stiffness_n_per_mm: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct StrokeTable {
    path: Vec<Spanned<[f64; 2]>>,
    radius_mm: Spanned<f64>,
    change_percent: Spanned<f64>,
    falloff: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EllipseTable {
    basic_radius_mm: Option<Spanned<f64>>,
    effect_radius_mm: Option<Spanned<f64>>,
    form: Option<Spanned<String>>,
    angle: Option<Spanned<String>>,
    level: Option<Spanned<String>>,
    key: Option<Spanned<Vec<Spanned<EllipseKeyTable>>>>,
    keys_from: Option<Spanned<String>>,
    force: Option<Spanned<String>>,
    subject: Option<Spanned<i64>>,
    means: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EllipseKeyTable {
    name: Option<Spanned<String>>,
    x: Spanned<f64>,
    y: Spanned<f64>,
    half_major_mm: Spanned<f64>,
    half_minor_mm: Spanned<f64>,
    angle_deg: Spanned<f64>,
    boundary_mm: Option<Spanned<Vec<f64>>>,
}

/// Falloff of a stroke that names none.
pub(super) const DEFAULT_FALLOFF: &str = "gaussian";

/// Map coordinates allowed, mm: a hundred times a back, so that a mistaken unit is noticed.
pub(super) const MAP_MM: RangeInclusive<f64> = -50_000.0..=50_000.0;
const STIFFNESS_N_PER_MM: RangeInclusive<f64> = 0.001..=10_000.0;
const ANGLES_DEG: RangeInclusive<f64> = -360.0..=360.0;
/// Subjects of appendix C.
const SUBJECTS: RangeInclusive<i64> = 1..=5;
const LONGEST_NAME: usize = 40;

/// What `[stiffness]` says.
pub(super) struct Stiffness {
    pub(super) keys: Vec<StiffnessKey>,
    pub(super) fit: Fit,
    pub(super) strokes: Vec<Stroke>,
    /// The map that they make.
    pub(super) map: StiffnessMap,
}

impl Scenario {
    /// The stiffness map, with its strokes and what the dysfunctions make of it.
    ///
    /// # Errors
    /// None for a scenario that was parsed; what a changed one has wrong otherwise.
    pub fn stiffness_map(&self) -> Result<StiffnessMap, MapError> {
        let patches = self.patches().map_err(|e| MapError::Spot(e.0))?;
        let spots = patches.iter().map(|(_, p)| (&p.spot, p.stiffness_factor));
        Ok(self.base_stiffness_map()?.with_spots(spots))
    }

    /// The stiffness map with its strokes, without the dysfunctions: what they are laid over.
    ///
    /// # Errors
    /// As [`Scenario::stiffness_map`].
    pub fn base_stiffness_map(&self) -> Result<StiffnessMap, MapError> {
        StiffnessMap::new(self.stiffness_keys.clone(), self.stiffness_fit)?
            .with_strokes(self.strokes.clone())
    }

    /// The ellipse map; `None` where the scenario has no `[ellipse]`, or one that is the basic circle everywhere.
    ///
    /// # Errors
    /// As [`Scenario::stiffness_map`].
    pub fn ellipse_map(&self) -> Result<Option<EllipseMap>, MapError> {
        let Some((keys, settings)) = &self.ellipse else {
            return Ok(None);
        };
        let map = EllipseMap::new(keys.clone(), *settings)?;
        Ok((!map.is_circle()).then_some(map))
    }
}

impl Check<'_> {
    pub(super) fn stiffness(
        &self,
        table: &Spanned<StiffnessTable>,
    ) -> Result<Stiffness, ScenarioError> {
        let t = table.get_ref();
        let fit = self.named("fit", t.fit.as_ref(), Fit::all(), Fit::name)?;
        let at_table = || table.span();
        let (keys, spans) = match (&t.constant_n_per_mm, &t.key) {
            (Some(k), None) => {
                let stiffness_n_per_mm = self.number("constant_n_per_mm", k, STIFFNESS_N_PER_MM)?;
                let key = StiffnessKey {
                    at: Vec2::ZERO,
                    stiffness_n_per_mm,
                };
                (vec![key], vec![k.span()])
            }
            (None, Some(keys)) if !keys.get_ref().is_empty() => {
                let keys = keys.get_ref();
                let read = keys.iter().map(|k| self.stiffness_key(k.get_ref()));
                let read = read.collect::<Result<Vec<_>, _>>()?;
                (read, keys.iter().map(Spanned::span).collect())
            }
            (None, Some(keys)) => {
                return Err(self.fail(&keys.span(), "key = []; at least one key is needed"));
            }
            _ => {
                let what = "[stiffness] needs either constant_n_per_mm or key = [ { x, y, stiffness_n_per_mm }, … ]";
                return Err(self.fail(&at_table(), what));
            }
        };
        let strokes = t.stroke.as_deref().unwrap_or_default();
        let strokes = strokes
            .iter()
            .map(|s| self.stroke(s))
            .collect::<Result<Vec<_>, _>>()?;
        // What concerns several keys is told by the map.
        let map = StiffnessMap::new(keys.clone(), fit)
            .and_then(|map| map.with_strokes(strokes.clone()))
            .map_err(|e| {
                let span = e.key().and_then(|k| spans.get(k - 1).cloned());
                self.fail(&span.unwrap_or_else(at_table), e.to_string())
            })?;
        Ok(Stiffness {
            keys,
            fit,
            strokes,
            map,
        })
    }

    fn stiffness_key(&self, k: &KeyTable) -> Result<StiffnessKey, ScenarioError> {
        Ok(StiffnessKey {
            at: self.place(&k.x, &k.y)?,
            stiffness_n_per_mm: self.number(
                "stiffness_n_per_mm",
                &k.stiffness_n_per_mm,
                STIFFNESS_N_PER_MM,
            )?,
        })
    }

    fn place(&self, x: &Spanned<f64>, y: &Spanned<f64>) -> Result<Vec2, ScenarioError> {
        Ok(Vec2::new(
            self.number("x", x, MAP_MM)?,
            self.number("y", y, MAP_MM)?,
        ))
    }

    fn stroke(&self, stroke: &Spanned<StrokeTable>) -> Result<Stroke, ScenarioError> {
        let t = stroke.get_ref();
        if t.path.is_empty() {
            return Err(self.fail(&stroke.span(), "path = []; at least one point is needed"));
        }
        let path = t.path.iter().map(|point| {
            let [x, y] = *point.get_ref();
            if [x, y].iter().all(|c| MAP_MM.contains(c)) {
                return Ok(Vec2::new(x, y));
            }
            let (least, most) = (MAP_MM.start(), MAP_MM.end());
            let what = format!("path has a point [{x}, {y}]; {least} to {most} is allowed");
            Err(self.fail(&point.span(), what))
        });
        let percent = 100.0 * STROKE_CHANGES.start()..=100.0 * STROKE_CHANGES.end();
        let falloffs: Vec<_> = curve::all()
            .iter()
            .map(|(name, _)| (*name, *name))
            .collect();
        let falloff = t.falloff.as_ref().map_or(Ok(DEFAULT_FALLOFF), |name| {
            self.choice("falloff", name, &falloffs)
        })?;
        Ok(Stroke {
            path: path.collect::<Result<_, _>>()?,
            radius_mm: self.number("radius_mm", &t.radius_mm, STROKE_RADII_MM)?,
            change: self.number("change_percent", &t.change_percent, percent)? / 100.0,
            falloff: falloff.to_owned(),
        })
    }

    /// `on_back`: the surface is the built-in back.
    pub(super) fn ellipse(
        &self,
        t: &EllipseTable,
        on_back: bool,
    ) -> Result<(Vec<EllipseKey>, EllipseSettings), ScenarioError> {
        let default = EllipseSettings::default();
        let settings = EllipseSettings {
            basic_radius_mm: self.number_or(
                "basic_radius_mm",
                t.basic_radius_mm.as_ref(),
                BASIC_RADII_MM,
                default.basic_radius_mm,
            )?,
            effect_radius_mm: self.number_or(
                "effect_radius_mm",
                t.effect_radius_mm.as_ref(),
                EFFECT_RADII_MM,
                default.effect_radius_mm,
            )?,
            form: self.named("form", t.form.as_ref(), Form::all(), Form::name)?,
            angle: self.named("angle", t.angle.as_ref(), AngleRule::all(), AngleRule::name)?,
            level: self.named("level", t.level.as_ref(), Level::all(), Level::name)?,
        };
        if let Some(from) = &t.keys_from {
            let keys = self.keys_from(t, from, on_back)?;
            return Ok((keys, settings));
        }
        for (key, span) in [
            ("force", t.force.as_ref().map(Spanned::span)),
            ("subject", t.subject.as_ref().map(Spanned::span)),
            ("means", t.means.as_ref().map(Spanned::span)),
        ] {
            if let Some(span) = span {
                let what = format!("{key} belongs to keys_from = \"appendix-c\"");
                return Err(self.fail(&span, what));
            }
        }
        let Some(keys) = &t.key else {
            return Ok((Vec::new(), settings));
        };
        let read = keys.get_ref().iter();
        let read: Vec<_> = read
            .map(|k| self.ellipse_key(k.get_ref()))
            .collect::<Result<_, _>>()?;
        // What concerns several keys, or a boundary, is told by the map.
        EllipseMap::new(read.clone(), settings).map_err(|e| {
            let key = e.key().and_then(|k| keys.get_ref().get(k - 1));
            self.fail(&key.map_or(keys.span(), Spanned::span), e.to_string())
        })?;
        Ok((read, settings))
    }

    fn ellipse_key(&self, k: &EllipseKeyTable) -> Result<EllipseKey, ScenarioError> {
        let name = match &k.name {
            None => String::new(),
            Some(name) => {
                let text = name.get_ref();
                if text.chars().count() > LONGEST_NAME || text.chars().any(char::is_control) {
                    let what = format!(
                        "name = {text:?}; up to {LONGEST_NAME} characters without line breaks are allowed"
                    );
                    return Err(self.fail(&name.span(), what));
                }
                text.clone()
            }
        };
        let key = EllipseKey {
            name,
            at: self.place(&k.x, &k.y)?,
            half_major_mm: self.number("half_major_mm", &k.half_major_mm, HALF_AXES_MM)?,
            half_minor_mm: self.number("half_minor_mm", &k.half_minor_mm, HALF_AXES_MM)?,
            angle_rad: self
                .number("angle_deg", &k.angle_deg, ANGLES_DEG)?
                .to_radians(),
            boundary_mm: k.boundary_mm.as_ref().map(|b| b.get_ref().clone()),
        };
        if key.half_minor_mm > key.half_major_mm {
            let what = format!(
                "half_minor_mm = {}; at most half_major_mm = {} is allowed",
                key.half_minor_mm, key.half_major_mm
            );
            return Err(self.fail(&k.half_minor_mm.span(), what));
        }
        Ok(key)
    }

    fn keys_from(
        &self,
        t: &EllipseTable,
        from: &Spanned<String>,
        on_back: bool,
    ) -> Result<Vec<EllipseKey>, ScenarioError> {
        self.choice("keys_from", from, &[("appendix-c", ())])?;
        if let Some(key) = &t.key {
            let what = "key and keys_from are both there; keep one of them";
            return Err(self.fail(&key.span(), what));
        }
        if !on_back {
            let what = "keys_from = \"appendix-c\" places keys by the vertebrae of builtin = \"back\"; a mesh needs \
                        key = [ … ]";
            return Err(self.fail(&from.span(), what));
        }
        let force = self.named("force", t.force.as_ref(), Force::all(), Force::name)?;
        let means = self.named("means", t.means.as_ref(), Means::all(), Means::name)?;
        let Some(subject) = &t.subject else {
            return Ok(appendix::seven_keys_by(means, force, None));
        };
        let number = *subject.get_ref();
        let keys = u32::try_from(number)
            .map(|number| appendix::seven_keys_by(means, force, Some(number)))
            .unwrap_or_default();
        if !keys.is_empty() {
            return Ok(keys);
        }
        let measured: Vec<String> = SUBJECTS
            .filter(|s| {
                let rows = appendix::rows().iter();
                rows.filter(|r| r.force == force)
                    .any(|r| i64::from(r.subject) == *s)
            })
            .map(|s| s.to_string())
            .collect();
        let what = format!(
            "subject = {number}; with force = {:?} there are {}",
            force.name(),
            measured.join(", ")
        );
        Err(self.fail(&subject.span(), what))
    }

    /// One of a list by its name; the default where none is given.
    fn named<T: Copy + Default>(
        &self,
        key: &str,
        value: Option<&Spanned<String>>,
        all: &[T],
        name: fn(T) -> &'static str,
    ) -> Result<T, ScenarioError> {
        let Some(value) = value else {
            return Ok(T::default());
        };
        let names: Vec<_> = all.iter().map(|&t| (name(t), t)).collect();
        self.choice(key, value, &names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn parse(tables: &str) -> Result<Scenario, ScenarioError> {
        let head = "format = 1\nname = \"T\"\n[surface]\nbuiltin = \"back\"\n";
        Scenario::parse(&format!("{head}{tables}"), "a.toml", None)
    }

    fn with_ellipse(table: &str) -> Result<Scenario, ScenarioError> {
        parse(&format!(
            "[stiffness]\nconstant_n_per_mm = 0.5\n[ellipse]\n{table}"
        ))
    }

    const KEY: &str = "{ name = \"P1\", x = 0, y = 300, half_major_mm = 180, half_minor_mm = 150, angle_deg = 90 }";

    #[test]
    fn strokes_are_read_in_percent_and_order() {
        let s = parse(
            "[stiffness]\nfit = \"gri\"\nconstant_n_per_mm = 0.5\n[[stiffness.stroke]]\npath = [[1, 2], [3.5, 4]]\n\
             radius_mm = 15\nchange_percent = -30\n[[stiffness.stroke]]\npath = [[0, 0]]\nradius_mm = 5\n\
             change_percent = 50\nfalloff = \"gaussian-printed\"\n",
        )
        .expect("good");
        assert_eq!(s.stiffness_fit, Fit::Gri);
        assert_eq!((s.strokes[0].change, s.strokes[0].radius_mm), (-0.3, 15.0));
        assert_eq!(s.strokes[0].path[1], Vec2::new(3.5, 4.0));
        assert_eq!(s.strokes[1].falloff, "gaussian-printed");
        let map = s.stiffness_map().expect("sound");
        assert_eq!(map.at(Vec2::new(3.5, 4.0)), 0.5 * 0.7);
    }

    #[test]
    fn an_ellipse_table_is_read_in_full_or_stays_the_basic_circle() {
        let plain = with_ellipse("").expect("good");
        assert_eq!(plain.ellipse, Some((vec![], EllipseSettings::default())));
        assert!(plain.ellipse_map().expect("sound").is_none());
        let full = format!(
            "basic_radius_mm = 120\neffect_radius_mm = 250\nform = \"published\"\nangle = \"linear\"\nlevel = \"array\"\n\
             key = [ {KEY} ]\n"
        );
        let (keys, settings) = with_ellipse(&full).expect("good").ellipse.expect("there");
        let expected = EllipseSettings {
            basic_radius_mm: 120.0,
            effect_radius_mm: 250.0,
            ..EllipseSettings::default().published()
        };
        assert_eq!(settings, expected);
        assert_eq!((keys[0].name.as_str(), keys[0].angle_rad), ("P1", PI / 2.0));
        let measured = with_ellipse(
            "keys_from = \"appendix-c\"\nforce = \"down\"\nsubject = 3\nmeans = \"axial\"",
        );
        let measured = measured
            .expect("good")
            .ellipse_map()
            .expect("sound")
            .expect("there");
        assert_eq!(
            measured.keys(),
            appendix::seven_keys_by(Means::Axial, Force::Down, Some(3))
        );
    }

    #[test]
    fn each_fault_of_a_map_is_told_with_line_key_value_and_what_is_allowed() {
        let radii = |n: usize| vec!["100"; n].join(", ");
        for (table, told) in [
            (
                "effect_radius_mm = 0".to_owned(),
                "a.toml: line 8: effect_radius_mm = 0; 1 to 10000 is allowed",
            ),
            (
                "form = \"best\"".to_owned(),
                "line 8: form = \"best\"; allowed are \"corrected\", \"published\"",
            ),
            (
                "angle = \"round\"".to_owned(),
                "line 8: angle = \"round\"; allowed are \"tensor\", \"linear\"",
            ),
            (
                "level = \"high\"".to_owned(),
                "line 8: level = \"high\"; allowed are \"exact\", \"array\"",
            ),
            (
                "levels = \"high\"".to_owned(),
                "line 8: unknown key `levels`",
            ),
            (
                "subject = 2".to_owned(),
                "line 8: subject belongs to keys_from = \"appendix-c\"",
            ),
            (
                "keys_from = \"book\"".to_owned(),
                "line 8: keys_from = \"book\"; allowed is \"appendix-c\"",
            ),
            (
                "keys_from = \"appendix-c\"\nsubject = 9".to_owned(),
                "line 9: subject = 9; with force = \"up\" there are 1, 2, 3, 4, 5",
            ),
            (
                "keys_from = \"appendix-c\"\nforce = \"down\"\nsubject = -1".to_owned(),
                "line 10: subject = -1; with force = \"down\" there are 3, 4, 5",
            ),
            (
                format!("keys_from = \"appendix-c\"\nkey = [ {KEY} ]"),
                "line 9: key and keys_from are both there",
            ),
            (
                format!("key = [\n{KEY},\n{}\n]", KEY.replace("x = 0", "x = inf")),
                "line 10: x = inf",
            ),
            (
                format!("key = [ {} ]", KEY.replace("150", "190")),
                "line 8: half_minor_mm = 190; at most half_major_mm = 180 is allowed",
            ),
            (
                format!("key = [ {} ]", KEY.replace("180", "nan")),
                "line 8: half_major_mm = NaN; 1 to 1000 is allowed",
            ),
            (
                format!("key = [ {} ]", KEY.replace("= 90", "= 400")),
                "line 8: angle_deg = 400; -360 to 360 is allowed",
            ),
            (
                format!("key = [ {} ]", KEY.replace("P1", "P\\n1")),
                "line 8: name = \"P\\n1\"; up to 40 characters",
            ),
            (
                format!("key = [\n{KEY},\n{}\n]", KEY.replace("180", "181")),
                "line 10: ellipse key 1 (P1) and ellipse key 2 (P1) are both at (0, 300) mm but state different ellipses",
            ),
            (
                format!(
                    "key = [ {} ]",
                    KEY.replace("= 90", &format!("= 90, boundary_mm = [{}]", radii(7)))
                ),
                "line 8: ellipse key 1 (P1): number of radii in boundary_mm is 7; 8 to 72 are allowed",
            ),
            (
                format!(
                    "key = [ {} ]",
                    KEY.replace("= 90", &format!("= 90, boundary_mm = [{}, -5]", radii(9)))
                ),
                "line 8: ellipse key 1 (P1): a radius in boundary_mm is -5; 1 to 1000 is allowed",
            ),
        ] {
            let error = with_ellipse(&table).expect_err(&table).0;
            assert!(
                error.contains(told),
                "{table:?} gave {error:?}, wanted {told:?}"
            );
            assert!(!error.contains('\n'));
        }
        for (rest, told) in [
            (
                "path = []\nradius_mm = 5\nchange_percent = 5",
                "line 7: path = []; at least one point",
            ),
            (
                "path = [[1, nan]]\nradius_mm = 5\nchange_percent = 5",
                "line 8: path has a point [1, NaN]",
            ),
            (
                "path = [[1]]\nradius_mm = 5\nchange_percent = 5",
                "line 8: invalid length",
            ),
            (
                "path = [[1, 2]]\nradius_mm = 0\nchange_percent = 5",
                "line 9: radius_mm = 0; 0.1 to 1000 is allowed",
            ),
            (
                "path = [[1, 2]]\nradius_mm = 5\nchange_percent = -100",
                "line 10: change_percent = -100; -99 to 900 is allowed",
            ),
            (
                "path = [[1, 2]]\nradius_mm = 5\nchange_percent = 5\nfalloff = \"soft\"",
                "line 11: falloff = \"soft\"; allowed are \"gaussian\"",
            ),
        ] {
            let error = parse(&format!(
                "[stiffness]\nconstant_n_per_mm = 0.5\n[[stiffness.stroke]]\n{rest}"
            ));
            let error = error.expect_err(rest).0;
            assert!(
                error.contains(told),
                "{rest:?} gave {error:?}, wanted {told:?}"
            );
        }
        let e = parse(
            "[stiffness]\nkey = [\n{ x = 1, y = 2, stiffness_n_per_mm = 1 },\n{ x = 1, y = 2, stiffness_n_per_mm = 2 },\n]",
        );
        let e = e.expect_err("clash").0;
        assert!(
            e.starts_with("a.toml: line 8: stiffness keys 1 and 2 are both"),
            "{e}"
        );
        let mesh = "format = 1\nname = \"T\"\n[surface]\nmesh = \"a.obj\"\n[stiffness]\nconstant_n_per_mm = 1\n[ellipse]\nkeys_from = \"appendix-c\"";
        let e = Scenario::parse(mesh, "a.toml", None).expect_err("mesh").0;
        assert!(
            e.contains("line 8: keys_from = \"appendix-c\" places keys by the vertebrae"),
            "{e}"
        );
    }
}
