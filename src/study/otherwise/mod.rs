//! A recording felt otherwise than it was: the same motion in another scenario, with another force model or contact engine, or
//! at another servo rate, and how far that is off over time.

mod thinned;

pub use thinned::{MOST_BOXES, Thinned};

use super::StudyError;
use crate::contact::published::KINDS;
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::Rig;
use crate::session::{
    Divergence, Edit, MeshSource, Otherwise, Rebuild, Session, SessionError, Strictness, diverge,
};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::Arc;
use toml_edit::{DocumentMut, Item, Table, value};

/// Rates that a session can be repeated at, Hz.
pub const RATES_HZ: RangeInclusive<f64> = 10.0..=1.0e5;

/// What is to be other than it was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Another scenario. Without it that of the recording, with its edits.
    pub scenario: Option<OtherScenario>,
    /// Another force model, as `[force] model` names it, with its default settings.
    pub force_model: Option<String>,
    /// Another contact engine: production, published, or a partition of the published one, one of [`KINDS`].
    pub engine: Option<String>,
    /// Another servo rate, within [`RATES_HZ`].
    pub rate_hz: Option<f64>,
}

/// A scenario that a session was not recorded in.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherScenario {
    /// What errors call it.
    pub origin: String,
    /// Its file.
    pub toml: Arc<str>,
    /// Where it finds its mesh.
    pub folder: Option<PathBuf>,
}

impl Changes {
    /// Whether anything is other.
    pub fn is_any(&self) -> bool {
        *self != Self::default()
    }

    /// In words, such as "force model linear, 500 Hz".
    pub fn words(&self) -> String {
        let parts = [
            self.scenario.as_ref().map(|s| s.origin.clone()),
            self.force_model
                .as_ref()
                .map(|name| format!("force model {name}")),
            self.engine.as_ref().map(|name| format!("engine {name}")),
            self.rate_hz.map(|rate| format!("{rate} Hz")),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        match parts.is_empty() {
            true => "as recorded".to_owned(),
            false => parts.join(", "),
        }
    }

    /// A scenario's text with engine and force model as wanted.
    ///
    /// # Errors
    /// The text is no TOML.
    pub fn varied(&self, text: &str) -> Result<String, String> {
        varied(text, self.engine.as_deref(), self.force_model.as_deref())
    }
}

/// A scenario's text with another engine and force model, where one is named.
///
/// # Errors
/// The text is no TOML.
pub fn varied(
    text: &str,
    engine: Option<&str>,
    force_model: Option<&str>,
) -> Result<String, String> {
    if engine.is_none() && force_model.is_none() {
        return Ok(text.to_owned());
    }
    let mut document: DocumentMut = text.parse().map_err(|e| format!("{e}"))?;
    if let Some(model) = force_model {
        let mut table = Table::new();
        table["model"] = value(model);
        document["force"] = Item::Table(table);
    }
    if let Some(engine) = engine {
        let mut table = Table::new();
        if KINDS.contains(&engine) {
            table["engine"] = value("published");
            table["partition"] = value(engine);
        } else {
            table["engine"] = value(engine);
        }
        document["contact"] = Item::Table(table);
    }
    Ok(document.to_string())
}

/// What repeating a session otherwise came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Repeated {
    /// Name of the recording.
    pub name: String,
    /// What was other, in words.
    pub changes: String,
    /// Figures over all of it.
    pub divergence: Divergence,
    /// Differences over time, finger by finger.
    pub fingers: Vec<Off>,
    /// Whether it was felt on the recorded surface; on another the proxy begins at the device.
    pub is_same_surface: bool,
    /// The first tick, and seconds from tick to tick.
    pub first_tick: u64,
    /// Time of a tick, s.
    pub step_s: f64,
}

/// How far one finger was off over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Off {
    /// Which, from 0.
    pub finger: u8,
    /// Distance of the proxies, mm.
    pub position_mm: Thinned,
    /// Magnitude of the difference of the forces before any limit, N.
    pub force_n: Thinned,
    /// Difference of the depths, otherwise less recorded, mm.
    pub depth_mm: Thinned,
}

impl Repeated {
    /// Time of a tick from the first, s.
    pub fn time_s(&self, tick: u64) -> f64 {
        tick.saturating_sub(self.first_tick) as f64 * self.step_s
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let of = |off: &Off| {
            let series = [&off.position_mm, &off.force_n, &off.depth_mm];
            series.map(Thinned::bytes).iter().sum::<usize>()
        };
        self.fingers.iter().map(of).sum()
    }
}

/// Repeats a session otherwise. `progress` is told what is being done and a fraction 0 to 1, and answers whether to go on.
///
/// Memory does not grow with the length of the session. Which tick is compared with which: [`diverge`].
///
/// # Errors
/// The session stays sealed or cannot be read, the rate is not within [`RATES_HZ`], the scene cannot be built, or `progress`
/// said stop.
pub fn repeat(
    session: &Session,
    changes: &Changes,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Repeated, StudyError> {
    let header = session.header();
    if header.sealed {
        let path = session.path().to_owned();
        return Err(StudyError::Sealed { path });
    }
    if let Some(rate_hz) = changes.rate_hz.filter(|rate| !RATES_HZ.contains(rate)) {
        return Err(StudyError::Option {
            option: "rate_hz",
            value: rate_hz.to_string(),
            allowed: "10 to 100000",
        });
    }
    let purpose = Use {
        fingers: header.n_fingers(),
        ..Use::default()
    };
    let folder = session.folder()?;
    let scene = built(session, changes, folder.path(), purpose, progress)?;
    let rebuild = |edit: &Edit| -> Result<_, String> {
        let text = changes.varied(&edit.scenario_toml)?;
        let origin = format!("edit {}", edit.number);
        let folder = scene.scenario.folder.as_deref();
        let scenario = Scenario::parse(&text, &origin, folder).map_err(|e| e.to_string())?;
        let edited = scenario::rebuild(&scene, Arc::new(scenario), purpose);
        edited.map(|s| s.touch).map_err(|e| e.to_string())
    };
    let otherwise = Otherwise {
        rate_hz: changes.rate_hz,
        // In a scenario of one's own the recorded edits mean nothing.
        rebuild: match changes.scenario {
            Some(_) => None,
            None => Some(Box::new(rebuild) as Rebuild<'_>),
        },
    };
    let surface = MeshSource::new(&scene.surface, &scene.mesh_origin);
    let rig = Rig::new(Box::new(scene.touch.clone()), header.limits());
    let mut fingers: Vec<Off> = (0..header.n_fingers())
        .map(|i| Off {
            finger: i as u8,
            ..Off::default()
        })
        .collect();
    let (mut seen, mut first_tick) = (0_u64, None);
    let found = diverge(session, rig, otherwise, Strictness::Lenient, |off, done| {
        // The first tick itself is where the run begins: it is not compared.
        let ticks_before = libm::round(off.time_s / header.dt_s()) as u64;
        first_tick.get_or_insert(off.tick.saturating_sub(ticks_before));
        if let Some(finger) = fingers.get_mut(usize::from(off.finger)) {
            let at_s = off.time_s;
            finger.position_mm.add(at_s, off.proxy_mm.length());
            finger.force_n.add(at_s, off.force_n.length());
            finger.depth_mm.add(at_s, off.depth_mm);
        }
        seen += 1;
        !seen.is_multiple_of(4096) || progress("repeating", 0.05 + 0.95 * done)
    });
    let divergence = match found {
        Err(SessionError::Stopped) => return Err(StudyError::Stopped),
        found => found?,
    };
    Ok(Repeated {
        name: super::About::of(session).name(),
        changes: changes.words(),
        divergence,
        fingers,
        is_same_surface: surface.hash == header.mesh.hash,
        first_tick: first_tick.unwrap_or(0),
        step_s: header.dt_s(),
    })
}

fn built(
    session: &Session,
    changes: &Changes,
    folder: &std::path::Path,
    purpose: Use,
    progress: &mut dyn FnMut(&str, f64) -> bool,
) -> Result<Scene, StudyError> {
    let scene = |e: String| StudyError::Scene(e);
    let (text, origin, folder) = match &changes.scenario {
        Some(other) => (&*other.toml, other.origin.clone(), other.folder.as_deref()),
        None => {
            let origin = format!("{}: scenario", session.path().display());
            (
                session.header().scenario_toml.as_str(),
                origin,
                Some(folder),
            )
        }
    };
    let text = changes.varied(text).map_err(scene)?;
    let scenario = Scenario::parse(&text, &origin, folder).map_err(|e| scene(e.to_string()))?;
    let mut going = true;
    let built = scenario::build(Arc::new(scenario), purpose, &mut |what, share| {
        // Building is brief beside the repeating.
        going = progress(what, 0.05 * share);
        going
    });
    match built {
        _ if !going => Err(StudyError::Stopped),
        built => built.map_err(|e| scene(e.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Reading;
    use crate::geom::Vec3;
    use crate::servo::{TickInput, tick};
    use crate::session::{IfExists, SessionWriter};
    use crate::study::tests::header;

    /// A second of pressing on the first example, felt by the one tick that there is.
    fn recorded(folder: &std::path::Path, sealed: bool) -> Session {
        let example = scenario::default_example();
        let scenario = Scenario::parse(example.text, example.file, None).expect("sound");
        let purpose = Use {
            fingers: 1,
            ..Use::default()
        };
        let scene = scenario::build(Arc::new(scenario), purpose, &mut |_, _| true).expect("built");
        let mut header = header(1, example.text);
        header.mesh = MeshSource::new(&scene.surface, &scene.mesh_origin);
        header.sealed = sealed;
        let path = folder.join(if sealed { "sealed.mcap" } else { "a.mcap" });
        let mut writer = SessionWriter::create(&path, &header, IfExists::Refuse).expect("created");
        let mut rig = Rig::new(Box::new(scene.touch.clone()), header.limits());
        let top_mm = scene.surface.bounds().max.z;
        for i in 0..1000_u64 {
            let mut input = TickInput {
                n_fingers: 1,
                force_enabled: true,
                ..TickInput::default()
            };
            let down = 0.5 - 0.5 * libm::cos(std::f64::consts::TAU * i as f64 / 1000.0);
            input.readings[0] = Reading {
                position_mm: Vec3::new(30.0, 284.0, top_mm + 10.0 - 60.0 * down),
                connected: true,
                ..Reading::default()
            };
            let record = tick(&mut rig, &input, header.dt_s());
            for finger in record.fingers() {
                writer.write(finger).expect("written");
            }
        }
        writer.finish().expect("finished");
        Session::open(&path).expect("opened")
    }

    fn repeated(session: &Session, changes: &Changes) -> Result<Repeated, StudyError> {
        repeat(session, changes, &mut |_, _| true)
    }

    #[test]
    fn what_is_as_recorded_differs_in_nothing_and_another_model_by_what_its_curve_shows() {
        let folder = tempfile::tempdir().expect("a folder");
        let session = recorded(folder.path(), false);
        let same = repeated(&session, &Changes::default()).expect("repeated");
        assert!(same.is_same_surface && same.divergence.compared == 999);
        let off = &same.divergence.fingers[0];
        assert_eq!(
            (off.force_n.max, off.proxy_mm.max, off.depth_mm.max),
            (0.0, 0.0, 0.0)
        );

        let changes = Changes {
            force_model: Some("exponential".into()),
            ..Changes::default()
        };
        let other = repeated(&session, &changes).expect("repeated");
        let spread = &other.divergence.fingers[0].force_n;
        assert!(spread.max > 0.05, "{}", spread.max);
        let points = other.fingers[0].force_n.points();
        let largest = points
            .iter()
            .max_by(|a, b| a[1].total_cmp(&b[1]))
            .expect("one");
        assert_eq!(largest[1], spread.max);
        assert!((other.time_s(spread.max_tick) - largest[0]).abs() < 1e-9);
        // The depth is that of the device below the same skin.
        assert_eq!(other.divergence.fingers[0].depth_mm.max, 0.0);
        assert_eq!(other.changes, "force model exponential");
    }

    #[test]
    fn what_is_sealed_or_not_allowed_is_refused_and_stopping_is_heard() {
        let folder = tempfile::tempdir().expect("a folder");
        let sealed = recorded(folder.path(), true);
        let refused = repeated(&sealed, &Changes::default());
        assert!(matches!(refused, Err(StudyError::Sealed { .. })));
        let session = recorded(folder.path(), false);
        let rate = |rate_hz| {
            let rate_hz = Some(rate_hz);
            let changes = Changes {
                rate_hz,
                ..Changes::default()
            };
            repeated(&session, &changes)
        };
        for wrong in [0.0, -5.0, f64::NAN, f64::INFINITY, 1.0e6] {
            assert!(
                matches!(rate(wrong), Err(StudyError::Option { .. })),
                "{wrong}"
            );
        }
        assert!(rate(500.0).is_ok());
        let magic = Changes {
            engine: Some("magic".into()),
            ..Changes::default()
        };
        let refused = repeated(&session, &magic).expect_err("no such engine");
        assert!(refused.to_string().contains("magic"), "{refused}");
        let stopped = repeat(&session, &Changes::default(), &mut |_, _| false);
        assert!(matches!(stopped, Err(StudyError::Stopped)));
    }

    #[test]
    fn engine_and_force_model_go_into_the_scenario() {
        let changes = Changes {
            engine: Some("octree".into()),
            force_model: Some("linear".into()),
            rate_hz: Some(500.0),
            ..Changes::default()
        };
        let text =
            "format = 1\n[contact]\nsides = \"both\"\n[force]\nmodel = \"power\"\nexponent = 1.5\n";
        let read: toml::Table = changes.varied(text).expect("TOML").parse().expect("TOML");
        assert_eq!(read["contact"]["engine"].as_str(), Some("published"));
        assert_eq!(read["contact"]["partition"].as_str(), Some("octree"));
        assert_eq!(read["force"].as_table().map(toml::Table::len), Some(1));
        assert!(read["contact"].get("sides").is_none());
        assert_eq!(Changes::default().varied(text).as_deref(), Ok(text));
        assert_eq!(changes.words(), "force model linear, engine octree, 500 Hz");
        assert!(changes.is_any() && !Changes::default().is_any());
    }
}
