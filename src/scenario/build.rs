//! From a scenario to the things it needs, and nothing else.

use super::dysfunction::{Tender, Tenderness};
use super::felt;
use super::needs::{Item, Needs, Verdict};
use super::{Ledger, Scenario, ScenarioError, SurfaceChoice, Use};
use crate::contact::published::Published;
use crate::contact::{Contact, Shading, Stiffness, TouchScene};
use crate::deform::Press;
use crate::deform::bones::Bones;
use crate::deform::models::fsmd;
use crate::geom::Vec2;
use crate::maps::{BoneMap, EllipseField, EllipseMap, StiffnessMap};
use crate::partition::Partition as _;
use crate::partition::bvh::Bvh;
use crate::surface::io::UnitsFound;
use crate::surface::{self, RawMesh, Report, Surface, back};
use crate::units::LengthUnit;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// A scene ready to be felt and drawn. Cheap to clone: large parts are shared.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What it was built from.
    pub scenario: Arc<Scenario>,
    /// The skin at rest.
    pub surface: Arc<Surface>,
    /// What validation found and repaired.
    pub report: Arc<Report>,
    /// Stiffness over the map plane.
    pub stiffness: Arc<StiffnessMap>,
    /// Footprints over the map plane; absent where the scenario has no ellipse keys, or nothing draws the skin.
    pub ellipse: Option<Arc<EllipseMap>>,
    /// The same at every vertex of the skin.
    pub ellipse_field: Option<Arc<EllipseField>>,
    /// What the servo gets (a copy is boxed and handed in).
    pub touch: TouchScene,
    /// Where it hurts; absent where it hurts nowhere.
    pub tenderness: Option<Arc<Tenderness>>,
    /// Settings of the drawn deformation, with its bones.
    pub deform: fsmd::Settings,
    /// `builtin:back` or the mesh path as stated.
    pub mesh_origin: String,
    /// The units a mesh file was taken to be in; nothing for the built-in back.
    pub mesh_units: Option<UnitsFound>,
    /// What was built and what was left out, with its cost.
    pub ledger: Ledger,
}

impl Scene {
    /// How a finger in `contact` presses the drawn skin, with the footprint that the maps have at its anchor; `None` when it
    /// does not touch, or its triangle is none of this scene.
    pub fn press(&self, contact: &Contact) -> Option<Press> {
        let press = Press::of(contact, self.touch.choices.pad_mm())?;
        if press.triangle as usize >= self.surface.triangles().len() {
            return None;
        }
        Some(match (&self.ellipse, &self.ellipse_field) {
            (Some(map), Some(field)) => press.on_map(&self.surface, map, field),
            _ => press,
        })
    }
}

impl Scene {
    /// How tender the skin is at a place of the map plane, mm: the lowest threshold of the dysfunctions it lies in; `None`
    /// where it is not.
    pub fn tenderness_at(&self, place: Vec2) -> Option<Tender> {
        self.tenderness.as_ref()?.at(place)
    }
}

/// Parts of a scene that come and go with what it is used for.
const BY_PURPOSE: [Item; 2] = [Item::EllipseField, Item::Bones];

impl Scene {
    /// Whether it has what `purpose` needs and nothing that it does not; else [`rebuild`] brings it there, and what is felt
    /// stays the same.
    pub fn fits(&self, purpose: Use) -> bool {
        BY_PURPOSE.iter().all(|&item| {
            let needed = matches!(item.verdict(&self.scenario, purpose), Verdict::Needed(_));
            self.ledger.row(item).built == needed
        })
    }
}

/// Why a scene could not be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BuildError(pub String);

impl From<ScenarioError> for BuildError {
    fn from(e: ScenarioError) -> Self {
        Self(e.0)
    }
}

impl BuildError {
    /// What is said when `progress` answered stop.
    pub const CANCELLED: &'static str = "cancelled";
}

/// Builds what `scenario` needs for `purpose`. `progress` is told what is being built and a fraction 0…1, and answers
/// whether to go on.
///
/// # Errors
/// The mesh cannot be read or is refused, a map is refused, or `progress` said stop.
pub fn build(
    scenario: Arc<Scenario>,
    purpose: Use,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Scene, BuildError> {
    let needs = Needs::of(&scenario, purpose);
    let mut ledger = Ledger::of(&scenario, purpose);
    let mut step = |what: &str, fraction: f64| {
        if progress(what, fraction) {
            Ok(())
        } else {
            Err(BuildError(BuildError::CANCELLED.into()))
        }
    };

    step("Reading the mesh", 0.0)?;
    let started = Instant::now();
    let (mut raw, mesh_origin, mesh_units) = raw_mesh(&scenario)?;
    let patches = (scenario.patches()).map_err(|e| BuildError(e.to_string()))?;
    felt::lift(&patches, &mut raw, &needs, &mut ledger);
    step("Checking the surface", 0.2)?;
    let (surface, report) =
        Surface::new(raw).map_err(|e| BuildError(format!("{mesh_origin}: {e}")))?;
    felt::fine_enough(&scenario, &patches, &surface)?;
    let surface = Arc::new(surface);
    ledger.built(Item::Surface, surface.bytes());
    ledger.cost(Item::Surface, us_since(started), "build");

    step("Building the search structure", 0.5)?;
    let started = Instant::now();
    let search = Arc::new(Bvh::new(&surface));
    ledger.built(Item::Search, search.bytes());
    ledger.cost(Item::Search, us_since(started), "build");

    let published = match &scenario.published {
        None => None,
        Some(options) => {
            step("Building the published structure", 0.7)?;
            let started = Instant::now();
            let built = Published::build(&surface, options, &mut |done| {
                step("Building the published structure", 0.7 + 0.1 * done).is_ok()
            })
            .map_err(|e| BuildError(e.to_string()))?
            .ok_or_else(|| BuildError(BuildError::CANCELLED.into()))?;
            ledger.built(Item::Published, built.bytes());
            ledger.cost(Item::Published, us_since(started), "build");
            Some(Arc::new(built))
        }
    };

    step("Fitting the stiffness map", 0.8)?;
    let (map, stiffness) = stiffness(&scenario, &needs, &surface, &mut ledger)?;
    felt::stiffness_allowed(&scenario, &patches, &surface, &stiffness)?;
    let drag = felt::drag(&patches, &needs, &surface, &mut ledger);
    let tenderness = felt::tenderness(&patches, &needs, &mut ledger);
    step("Spreading the ellipse map", 0.9)?;
    let (ellipse, ellipse_field) = ellipses(&scenario, &needs, &surface, &mut ledger)?;
    let shading = needs.has(Item::ForceShading).then(|| Shading::of(&surface));
    for item in IN_THE_SCENE {
        if needs.has(item) {
            ledger.built(item, 0);
        }
    }

    step("Ready", 1.0)?;
    let touch = TouchScene {
        friction: scenario.friction,
        drag,
        choices: scenario.choices,
        published,
        shading,
        ..TouchScene::new(Arc::clone(&surface), search, stiffness)
    };
    let deform = deform(&scenario, &needs, &surface, &mut ledger)?;
    Ok(Scene {
        scenario,
        surface,
        report: Arc::new(report),
        stiffness: map,
        ellipse,
        ellipse_field,
        touch,
        tenderness,
        deform,
        mesh_origin,
        mesh_units,
        ledger,
    })
}

/// Parts that are a few numbers in the scene, which has room for them whether they are wanted or not.
const IN_THE_SCENE: [Item; 5] = [
    Item::Friction,
    Item::ForceModel,
    Item::FingerPad,
    Item::ForceShading,
    Item::Passivity,
];

/// Parts that an edit of the maps leaves as they are.
const KEPT: [Item; 9] = [
    Item::Surface,
    Item::Bumps,
    Item::Search,
    Item::Published,
    Item::Friction,
    Item::ForceModel,
    Item::FingerPad,
    Item::ForceShading,
    Item::Passivity,
];

/// The scene of an edited scenario: shares with `old` all that the edit leaves as it is, and builds only what it changes.
///
/// An edit may change the name, the description, `[stiffness]`, `[[dysfunction]]`, `[ellipse]`, `[deformation]` and `[bones]`: what a finger in
/// touch can go over to without its proxy being placed anew.
///
/// # Errors
/// Another table has changed, or the bumps of the dysfunctions ([`changes_surface`]); or a map is refused.
pub fn rebuild(old: &Scene, scenario: Arc<Scenario>, purpose: Use) -> Result<Scene, BuildError> {
    if let Some(table) = fixed_table_changed(&old.scenario, &scenario) {
        return Err(BuildError(format!(
            "{table} cannot be edited under the finger; save the scenario and open it anew"
        )));
    }
    if changes_surface(&old.scenario, &scenario) {
        let what = "the bumps of [[dysfunction]] cannot be edited under the finger, since the surface is another with them; \
                    build the scene anew";
        return Err(BuildError(what.into()));
    }
    let needs = Needs::of(&scenario, purpose);
    let mut ledger = Ledger::of(&scenario, purpose);
    for item in KEPT {
        ledger.carry(item, &old.ledger);
    }
    let was = &old.scenario;
    let same_stiffness = was.stiffness_keys == scenario.stiffness_keys
        && was.stiffness_fit == scenario.stiffness_fit
        && was.strokes == scenario.strokes
        && was.dysfunctions == scenario.dysfunctions;
    let (map, felt) = if same_stiffness {
        ledger.carry(Item::StiffnessField, &old.ledger);
        (Arc::clone(&old.stiffness), old.touch.stiffness.clone())
    } else {
        stiffness(&scenario, &needs, &old.surface, &mut ledger)?
    };
    let (drag, tenderness) = if was.dysfunctions == scenario.dysfunctions {
        ledger.carry(Item::SkinDrag, &old.ledger);
        ledger.carry(Item::Tenderness, &old.ledger);
        (old.touch.drag.clone(), old.tenderness.clone())
    } else {
        let patches = (scenario.patches()).map_err(|e| BuildError(e.to_string()))?;
        felt::fine_enough(&scenario, &patches, &old.surface)?;
        felt::stiffness_allowed(&scenario, &patches, &old.surface, &felt)?;
        (
            felt::drag(&patches, &needs, &old.surface, &mut ledger),
            felt::tenderness(&patches, &needs, &mut ledger),
        )
    };
    let same_ellipses = was.ellipse == scenario.ellipse
        && old.ledger.row(Item::EllipseField).built == needs.has(Item::EllipseField);
    let (ellipse, ellipse_field) = if same_ellipses {
        ledger.carry(Item::EllipseField, &old.ledger);
        (old.ellipse.clone(), old.ellipse_field.clone())
    } else {
        ellipses(&scenario, &needs, &old.surface, &mut ledger)?
    };
    let same_bones =
        was.bones == scenario.bones && old.deform.bones.is_some() == needs.has(Item::Bones);
    let deform = if same_bones {
        ledger.carry(Item::Bones, &old.ledger);
        fsmd::Settings {
            bones: old.deform.bones.clone(),
            ..scenario.deform.clone()
        }
    } else {
        deform(&scenario, &needs, &old.surface, &mut ledger)?
    };
    Ok(Scene {
        surface: Arc::clone(&old.surface),
        report: Arc::clone(&old.report),
        stiffness: map,
        ellipse,
        ellipse_field,
        touch: TouchScene {
            stiffness: felt,
            drag,
            fading: None,
            ..old.touch.clone()
        },
        tenderness,
        deform,
        mesh_origin: old.mesh_origin.clone(),
        mesh_units: old.mesh_units.clone(),
        scenario,
        ledger,
    })
}

/// Whether the scene of `new` has another surface than that of `old`: another mesh, or other bumps. Then [`rebuild`] refuses,
/// and the scene is to be built anew.
pub fn changes_surface(old: &Scenario, new: &Scenario) -> bool {
    let bumps = |s: &Scenario| {
        let all = s
            .dysfunctions
            .iter()
            .flat_map(|d| d.patches().unwrap_or_default());
        let with = all.filter(|p| p.bump_mm != 0.0);
        with.map(|p| (p.spot, p.bump_mm)).collect::<Vec<_>>()
    };
    old.surface != new.surface
        || old.folder != new.folder && matches!(new.surface, SurfaceChoice::Mesh { .. })
        || old.dysfunctions != new.dysfunctions && bumps(old) != bumps(new)
}

/// The first table that differs of those which decide where a proxy rests and how it is pushed.
fn fixed_table_changed(a: &Scenario, b: &Scenario) -> Option<&'static str> {
    let contact = |s: &Scenario| {
        (
            s.choices.finger_radius_mm,
            s.choices.sides,
            s.choices.shaded,
        )
    };
    if a.surface != b.surface {
        Some("[surface]")
    } else if a.friction != b.friction {
        Some("[friction]")
    } else if a.choices.force != b.choices.force {
        Some("[force]")
    } else if a.published != b.published || contact(a) != contact(b) {
        Some("[contact]")
    } else {
        None
    }
}

/// The stiffness map, and what of it is felt.
fn stiffness(
    scenario: &Scenario,
    needs: &Needs,
    surface: &Surface,
    ledger: &mut Ledger,
) -> Result<(Arc<StiffnessMap>, Stiffness), BuildError> {
    let started = Instant::now();
    let map = scenario
        .stiffness_map()
        .map_err(|e| BuildError(e.to_string()))?;
    let felt = match map.uniform() {
        Some(k) if !needs.has(Item::StiffnessField) => Stiffness::Uniform(k),
        _ => {
            let field = Stiffness::PerVertex(map.per_vertex(surface).into());
            ledger.built(Item::StiffnessField, field.bytes());
            ledger.cost(Item::StiffnessField, us_since(started), "build");
            field
        }
    };
    Ok((Arc::new(map), felt))
}

/// The ellipse map and its values at the vertices; neither where nothing needs them.
type Ellipses = (Option<Arc<EllipseMap>>, Option<Arc<EllipseField>>);

fn ellipses(
    scenario: &Scenario,
    needs: &Needs,
    surface: &Surface,
    ledger: &mut Ledger,
) -> Result<Ellipses, BuildError> {
    if !needs.has(Item::EllipseField) {
        return Ok((None, None));
    }
    let started = Instant::now();
    let map = scenario
        .ellipse_map()
        .map_err(|e| BuildError(e.to_string()))?;
    let Some(map) = map else {
        return Ok((None, None));
    };
    let field = map.per_vertex(surface);
    ledger.built(Item::EllipseField, field.bytes());
    ledger.cost(Item::EllipseField, us_since(started), "build");
    Ok((Some(Arc::new(map)), Some(Arc::new(field))))
}

/// The settings of the deformation, with the bones under the surface where they are needed.
fn deform(
    scenario: &Scenario,
    needs: &Needs,
    surface: &Surface,
    ledger: &mut Ledger,
) -> Result<fsmd::Settings, BuildError> {
    let started = Instant::now();
    let bones = match &scenario.bones {
        Some(choice) if needs.has(Item::Bones) => {
            let map = BoneMap::new(choice.keys.clone()).map_err(|e| BuildError(e.to_string()))?;
            let bones = Bones::new(&map, surface, choice.settings);
            ledger.built(Item::Bones, bones.bytes());
            ledger.cost(Item::Bones, us_since(started), "build");
            Some(Arc::new(bones))
        }
        _ => None,
    };
    Ok(fsmd::Settings {
        bones,
        ..scenario.deform.clone()
    })
}

fn us_since(started: Instant) -> f64 {
    started.elapsed().as_secs_f64() * 1.0e6
}

/// The mesh as its source gives it, the name of that source, and the units of a file.
fn raw_mesh(scenario: &Scenario) -> Result<(RawMesh, String, Option<UnitsFound>), BuildError> {
    match &scenario.surface {
        SurfaceChoice::BuiltinBack { triangles } => {
            let options = back::BackOptions {
                triangles: *triangles,
                ..back::BackOptions::default()
            };
            Ok((back::make(&options), "builtin:back".into(), None))
        }
        SurfaceChoice::Mesh { path, units } => {
            let Some(folder) = &scenario.folder else {
                let what =
                    "a scenario without a folder cannot name a mesh file; use builtin = \"back\"";
                return Err(BuildError(format!("mesh = {path:?}: {what}")));
            };
            let file = folder.join(path);
            stays_inside(&file, folder)?;
            let units = units.as_deref().and_then(LengthUnit::from_name);
            let read = surface::io::read(&file, units);
            let (mesh, units) = read.map_err(|e| BuildError(e.to_string()))?;
            Ok((mesh, path.display().to_string(), Some(units)))
        }
    }
}

/// Follows links: a mesh file must lie in the scenario's folder, whatever its path looks like.
fn stays_inside(file: &Path, folder: &Path) -> Result<(), BuildError> {
    let canonical = |p: &Path| {
        p.canonicalize()
            .map_err(|e| BuildError(format!("{}: cannot be read: {e}", p.display())))
    };
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    if canonical(file)?.starts_with(canonical(folder)?) {
        Ok(())
    } else {
        let what = "leads outside the scenario's folder; meshes must lie in it";
        Err(BuildError(format!("{}: {what}", file.display())))
    }
}
