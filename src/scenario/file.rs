//! The scenario file: TOML with units in the key names, checked down to line and value.

use super::check::Check;
use super::deformation::{BonesChoice, BonesTable, DeformationTable};
use super::dysfunction::table::DysfunctionTable;
use super::dysfunction::{self, Dysfunction, Patch};
use super::edit;
use super::exercise::{Exercise, ExerciseTable};
use super::feel::{ContactTable, ForceTable};
use super::maps::{EllipseTable, StiffnessTable};
use crate::contact::{Choices, Friction, published};
use crate::deform::models::fsmd;
use crate::maps::{EllipseKey, EllipseSettings, Fit, StiffnessKey, Stroke};
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::path::{Component, Path, PathBuf};
use toml::Spanned;

/// Version of the file format that this program reads.
pub const FORMAT: i64 = 1;

/// Where the surface comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceChoice {
    /// The built-in back with about this many triangles.
    BuiltinBack {
        /// Triangles asked for.
        triangles: usize,
    },
    /// A mesh file; the path is relative to the scenario's folder and stays inside it.
    Mesh {
        /// Path as stated in the file.
        path: PathBuf,
        /// Unit of its coordinates as stated (`mm`, `cm`, `m`, `inch`); `None`: guessed by size.
        units: Option<String>,
    },
}

/// A parsed and checked scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Name shown to people.
    pub name: String,
    /// One or two sentences on what the scene is for; may be empty.
    pub description: String,
    /// Where the surface comes from.
    pub surface: SurfaceChoice,
    /// Stiffness keys; one key is a constant map.
    pub stiffness_keys: Vec<StiffnessKey>,
    /// The fit through them.
    pub stiffness_fit: Fit,
    /// Strokes over it, in order.
    pub strokes: Vec<Stroke>,
    /// What is wrong with the back, in order.
    pub dysfunctions: Vec<Dysfunction>,
    /// Keys and settings of the ellipse map; absent: the basic circle everywhere.
    pub ellipse: Option<(Vec<EllipseKey>, EllipseSettings)>,
    /// Absent: frictionless.
    pub friction: Option<Friction>,
    /// How the finger meets the surface, by name.
    pub choices: Choices,
    /// Present: felt by the published haptic pass; absent: by the production engine.
    pub published: Option<published::Options>,
    /// Curve, footprint and caps of the drawn deformation; its bones are added when a scene is built.
    pub deform: fsmd::Settings,
    /// Bone under the surface; absent: nowhere near.
    pub bones: Option<BonesChoice>,
    /// What is asked of whom palpates; absent: free palpation.
    pub exercise: Option<Exercise>,
    /// The file, whole, as read.
    pub source: String,
    /// Folder that relative paths start from; `None` for embedded scenarios.
    pub folder: Option<PathBuf>,
}

/// Why a scenario is refused: file, line, key, value and what is allowed, in one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ScenarioError(pub String);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: Spanned<i64>,
    name: Spanned<String>,
    #[serde(default)]
    description: String,
    surface: Spanned<SurfaceTable>,
    stiffness: Spanned<StiffnessTable>,
    #[serde(default)]
    dysfunction: Vec<Spanned<DysfunctionTable>>,
    friction: Option<FrictionTable>,
    force: Option<ForceTable>,
    contact: Option<ContactTable>,
    ellipse: Option<EllipseTable>,
    deformation: Option<DeformationTable>,
    bones: Option<Spanned<BonesTable>>,
    exercise: Option<ExerciseTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceTable {
    builtin: Option<Spanned<String>>,
    triangles: Option<Spanned<i64>>,
    mesh: Option<Spanned<String>>,
    units: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FrictionTable {
    #[serde(rename = "static")]
    static_coefficient: Spanned<f64>,
    dynamic: Spanned<f64>,
    skin_looseness: Option<Spanned<f64>>,
}

const TRIANGLES: RangeInclusive<i64> = 200..=4_000_000;

impl Scenario {
    /// Parses `text`; `origin` names it in errors and `folder` is where relative paths start.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn parse(text: &str, origin: &str, folder: Option<&Path>) -> Result<Self, ScenarioError> {
        let check = Check { text, origin };
        let file: File = toml::from_str(text).map_err(|e| check.syntax(&e))?;
        if *file.format.get_ref() != FORMAT {
            let what = format!(
                "format = {}; this program reads format = {FORMAT}",
                file.format.get_ref()
            );
            return Err(check.fail(&file.format.span(), what));
        }
        let name = file.name.get_ref().trim();
        if name.is_empty() || name.chars().count() > 120 || name.chars().any(char::is_control) {
            let what =
                format!("name = {name:?}; 1 to 120 characters without line breaks are allowed");
            return Err(check.fail(&file.name.span(), what));
        }
        let friction = file
            .friction
            .as_ref()
            .map(|t| check.friction(t))
            .transpose()?;
        let mut deform = check.deformation(file.deformation.as_ref(), friction.is_some())?;
        let surface = check.surface(&file.surface)?;
        let on_back = matches!(surface, SurfaceChoice::BuiltinBack { .. });
        let ellipse = file
            .ellipse
            .as_ref()
            .map(|t| check.ellipse(t, on_back))
            .transpose()?;
        if let Some((_, settings)) = &ellipse {
            let radius_mm = settings.basic_radius_mm;
            (deform.half_major_mm, deform.half_minor_mm) = (radius_mm, radius_mm);
        }
        let stiffness = check.stiffness(&file.stiffness)?;
        let dysfunctions = check.dysfunctions(
            &file.dysfunction,
            on_back,
            friction.as_ref(),
            &stiffness.map,
        )?;
        Ok(Self {
            name: name.to_owned(),
            description: file.description.trim().to_owned(),
            surface,
            stiffness_keys: stiffness.keys,
            stiffness_fit: stiffness.fit,
            strokes: stiffness.strokes,
            dysfunctions,
            ellipse,
            friction,
            published: (file.contact.as_ref()).map_or(Ok(None), |t| check.published(t))?,
            choices: check.choices(file.force.as_ref(), file.contact.as_ref())?,
            deform,
            bones: (file.bones.as_ref())
                .map(|t| check.bones(t, on_back))
                .transpose()?,
            exercise: (file.exercise.as_ref())
                .map(|t| check.exercise(t, on_back))
                .transpose()?,
            source: text.to_owned(),
            folder: folder.map(Path::to_owned),
        })
    }

    /// Reads and parses a file.
    ///
    /// # Errors
    /// The file cannot be read, or the first thing wrong with it.
    pub fn load(path: &Path) -> Result<Self, ScenarioError> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| ScenarioError(format!("{}: cannot be read: {e}", path.display())))?;
        Self::parse(&text, &path.display().to_string(), path.parent())
    }

    /// The same scenario with these dysfunctions in place of its own, in the source text too, whose comments stay.
    ///
    /// # Errors
    /// A dysfunction has a value that is not allowed, or they cannot be together.
    pub fn with_dysfunctions(&self, list: &[Dysfunction]) -> Result<Self, ScenarioError> {
        let text = edit::set_dysfunctions(&self.source, list)?;
        Self::parse(&text, edit::ORIGIN, self.folder.as_deref())
    }

    /// Whether a dysfunction does to the map plane what `wanted` looks for.
    pub(super) fn has_patch(&self, wanted: impl Fn(&Patch) -> bool) -> bool {
        let of = |d: &Dysfunction| d.patches().unwrap_or_default();
        (self.dysfunctions.iter()).any(|d| of(d).iter().any(&wanted))
    }

    /// What the dysfunctions do to the map plane, in order, each with the number of its dysfunction counted from 0.
    ///
    /// # Errors
    /// None for a scenario that was parsed; what a changed one has wrong otherwise.
    pub fn patches(&self) -> Result<Vec<(usize, Patch)>, ScenarioError> {
        if self.dysfunctions.is_empty() {
            return Ok(Vec::new());
        }
        let map = self
            .base_stiffness_map()
            .map_err(|e| ScenarioError(e.to_string()))?;
        dysfunction::check(&self.dysfunctions, self.friction.as_ref(), &map)
            .map_err(|clash| ScenarioError(self.about_dysfunction(clash.index, &clash.fault.what)))
    }

    /// What is wrong with a dysfunction, counted from 0, told with its line in the file and its name.
    pub(super) fn about_dysfunction(&self, index: usize, what: &str) -> String {
        #[derive(Deserialize)]
        struct Lines {
            dysfunction: Vec<Spanned<serde::de::IgnoredAny>>,
        }
        let lines: Option<Lines> = toml::from_str(&self.source).ok();
        let span = lines.and_then(|l| l.dysfunction.get(index).map(Spanned::span));
        let line = span.map_or(String::new(), |span| {
            let before = self.source.bytes().take(span.start);
            format!("line {}: ", 1 + before.filter(|&b| b == b'\n').count())
        });
        let name = (self.dysfunctions.get(index)).map_or(String::new(), |d| format!(" ({d})"));
        format!("{line}dysfunction {}{name}: {what}", index + 1)
    }
}

impl Check<'_> {
    fn surface(&self, table: &Spanned<SurfaceTable>) -> Result<SurfaceChoice, ScenarioError> {
        let t = table.get_ref();
        match (&t.builtin, &t.mesh) {
            (Some(builtin), None) => {
                if builtin.get_ref() != "back" {
                    let what = format!("builtin = {:?}; allowed is \"back\"", builtin.get_ref());
                    return Err(self.fail(&builtin.span(), what));
                }
                if let Some(units) = &t.units {
                    return Err(self.fail(
                        &units.span(),
                        "units belong to a mesh; the built-in back is in mm",
                    ));
                }
                let default = crate::surface::back::BackOptions::default().triangles;
                let triangles = match &t.triangles {
                    None => default,
                    Some(n) if TRIANGLES.contains(n.get_ref()) => *n.get_ref() as usize,
                    Some(n) => {
                        let (lo, hi) = (TRIANGLES.start(), TRIANGLES.end());
                        let what = format!("triangles = {}; {lo} to {hi} is allowed", n.get_ref());
                        return Err(self.fail(&n.span(), what));
                    }
                };
                Ok(SurfaceChoice::BuiltinBack { triangles })
            }
            (None, Some(mesh)) => {
                if let Some(n) = &t.triangles {
                    return Err(self.fail(
                        &n.span(),
                        "triangles belong to builtin = \"back\"; a mesh has its own",
                    ));
                }
                let path = PathBuf::from(mesh.get_ref());
                let inside = path
                    .components()
                    .all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
                if !inside || mesh.get_ref().is_empty() || mesh.get_ref().contains('\\') {
                    let what = format!(
                        "mesh = {:?}; a relative path with / inside the scenario's folder is allowed",
                        mesh.get_ref()
                    );
                    return Err(self.fail(&mesh.span(), what));
                }
                let units = match &t.units {
                    None => None,
                    Some(u) if ["mm", "cm", "m", "inch"].contains(&u.get_ref().as_str()) => {
                        Some(u.get_ref().clone())
                    }
                    Some(u) => {
                        let what = format!(
                            "units = {:?}; allowed are \"mm\", \"cm\", \"m\", \"inch\"",
                            u.get_ref()
                        );
                        return Err(self.fail(&u.span(), what));
                    }
                };
                Ok(SurfaceChoice::Mesh { path, units })
            }
            _ => Err(self.fail(
                &table.span(),
                "[surface] needs either builtin = \"back\" or mesh = \"file\"",
            )),
        }
    }

    fn friction(&self, t: &FrictionTable) -> Result<Friction, ScenarioError> {
        let static_coefficient = self.number("static", &t.static_coefficient, 0.0..=10.0)?;
        let dynamic_coefficient = self.number("dynamic", &t.dynamic, 0.0..=10.0)?;
        if dynamic_coefficient > static_coefficient {
            let what = format!(
                "dynamic = {dynamic_coefficient}; at most static = {static_coefficient} is allowed"
            );
            return Err(self.fail(&t.dynamic.span(), what));
        }
        let skin_looseness = t
            .skin_looseness
            .as_ref()
            .map_or(Ok(1.0), |v| self.number("skin_looseness", v, 0.1..=10.0))?;
        Ok(Friction {
            static_coefficient,
            dynamic_coefficient,
            skin_looseness,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec2;
    use proptest::prelude::*;

    const GOOD: &str = r#"format = 1
name = "Test"
[surface]
builtin = "back"
triangles = 2962
[stiffness]
fit = "natural"
key = [
  { x = 0, y = 284, stiffness_n_per_mm = 0.55 },
  { x = 40, y = 100.5, stiffness_n_per_mm = 1 },
]
[friction]
static = 0.46
dynamic = 0.44
[ellipse]
basic_radius_mm = 140
"#;

    #[test]
    fn a_good_file_says_what_it_says() {
        let s = Scenario::parse(GOOD, "a.toml", None).expect("good");
        assert_eq!(s.name, "Test");
        assert_eq!(s.surface, SurfaceChoice::BuiltinBack { triangles: 2962 });
        assert_eq!(s.stiffness_keys[1].at, Vec2::new(40.0, 100.5));
        assert_eq!(
            s.friction
                .map(|f| (f.static_coefficient, f.dynamic_coefficient)),
            Some((0.46, 0.44))
        );
        assert!(s.deform.tangential);
        assert_eq!(s.source, GOOD);
    }

    #[test]
    fn without_friction_nothing_tangential_is_wanted() {
        let text = GOOD.replace("[friction]\nstatic = 0.46\ndynamic = 0.44\n", "");
        let s = Scenario::parse(&text, "a.toml", None).expect("good");
        assert!(s.friction.is_none() && !s.deform.tangential);
    }

    #[test]
    fn each_fault_is_told_with_file_line_key_value_and_what_is_allowed() {
        for (from, to, told) in [
            (
                "format = 1",
                "format = 2",
                "a.toml: line 1: format = 2; this program reads format = 1",
            ),
            ("name = \"Test\"", "name = \"\"", "line 2: name = \"\""),
            ("name = \"Test\"\n", "", "missing key `name`"),
            (
                "triangles = 2962",
                "triangels = 2962",
                "line 5: unknown key `triangels`, allowed are",
            ),
            (
                "triangles = 2962",
                "triangles = 3",
                "line 5: triangles = 3; 200 to 4000000 is allowed",
            ),
            (
                "triangles = 2962",
                "units = \"mm\"",
                "line 5: units belong to a mesh",
            ),
            (
                "builtin = \"back\"",
                "builtin = \"front\"",
                "line 4: builtin = \"front\"",
            ),
            (
                "builtin = \"back\"",
                "mesh = \"x.obj\"",
                "triangles belong to builtin",
            ),
            (
                "builtin = \"back\"\ntriangles = 2962",
                "mesh = \"../x.obj\"",
                "line 4: mesh = \"../x.obj\"",
            ),
            (
                "builtin = \"back\"\ntriangles = 2962",
                "mesh = \"/x.obj\"",
                "inside the scenario's folder",
            ),
            (
                "builtin = \"back\"\ntriangles = 2962",
                "mesh = \"x.obj\"\nunits = \"ft\"",
                "line 5: units = \"ft\"",
            ),
            (
                "builtin = \"back\"\ntriangles = 2962",
                "",
                "needs either builtin",
            ),
            (
                "fit = \"natural\"",
                "fit = \"magic\"",
                "line 7: fit = \"magic\"",
            ),
            (
                "= 0.55",
                "= -0.55",
                "line 9: stiffness_n_per_mm = -0.55; 0.001 to 10000 is allowed",
            ),
            ("= 0.55", "= nan", "line 9: stiffness_n_per_mm = NaN"),
            ("= 0.55", "= \"soft\"", "line 9: invalid type"),
            ("x = 40", "x = inf", "line 10: x = inf"),
            (
                "dynamic = 0.44",
                "dynamic = 0.5",
                "line 14: dynamic = 0.5; at most static = 0.46",
            ),
            (
                "basic_radius_mm = 140",
                "basic_radius_mm = 0",
                "line 16: basic_radius_mm = 0; 1 to 1000 is allowed",
            ),
            ("[ellipse]", "[elipse]", "unknown key `elipse`"),
            ("[ellipse]", "[ellipse", "line 15"),
        ] {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD, "{from} is not in the file");
            let error = Scenario::parse(&text, "a.toml", None)
                .expect_err(to)
                .to_string();
            assert!(
                error.contains(told),
                "{to:?} gave {error:?}, wanted {told:?}"
            );
            assert!(!error.contains('\n'), "{error:?}");
        }
    }

    #[test]
    fn a_missing_file_is_told_by_its_name() {
        let error = Scenario::load(Path::new("no/such.toml"))
            .expect_err("missing")
            .to_string();
        assert!(error.starts_with("no/such.toml: cannot be read"), "{error}");
    }

    proptest! {
        #[test]
        fn any_mutation_is_parsed_or_refused_in_one_line(at in 0..GOOD.len(), with in "[ -~\n]{0,4}", cut in 0..12_usize) {
            let end = (at + cut).min(GOOD.len());
            let text = format!("{}{with}{}", &GOOD[..at], &GOOD[end..]);
            if let Err(e) = Scenario::parse(&text, "a.toml", None) {
                prop_assert!(e.0.starts_with("a.toml: line ") && !e.0.contains('\n'), "{}", e.0);
            }
        }
    }
}
