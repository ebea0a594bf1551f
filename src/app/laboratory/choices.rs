//! What the user chose, and what an experiment gets of it.

use super::Listed;
use crate::app::state::View;
use crate::lab::{self, Choice, Mesh, Scene, Setup, Shelf};
use crate::surface::back;
use std::path::PathBuf;
use std::sync::Arc;

/// The choices as they stand in the panel: numbers are text as it is typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choices {
    /// A look in seconds.
    pub quick: bool,
    /// Sizes of the built-in back, with commas between; empty: the experiment's own.
    pub triangles: String,
    /// Work on the skin of the open scene.
    pub skin: bool,
    /// Work in the open scene.
    pub scene: bool,
    /// Path of a recorded session; empty: none.
    pub session: String,
    /// Where chance starts.
    pub seed: String,
    /// How long to work in real time, s; empty: the experiment's own time.
    pub seconds: String,
}

impl Default for Choices {
    fn default() -> Self {
        Self {
            quick: true,
            triangles: String::new(),
            skin: false,
            scene: false,
            session: String::new(),
            seed: "0".to_owned(),
            seconds: String::new(),
        }
    }
}

/// A question to an experiment: only what it takes, so that two questions with one answer are equal.
#[derive(Clone)]
pub struct Asked {
    experiment: Listed,
    quick: bool,
    mesh: Option<Mesh>,
    triangles: Vec<usize>,
    scene: Option<Scene>,
    session: Option<PathBuf>,
    seed: u64,
    seconds: Option<f64>,
}

impl PartialEq for Asked {
    fn eq(&self, other: &Self) -> bool {
        let mesh = |a: &Self| a.mesh.as_ref().map(|m| (m.name.clone(), m.surface.hash()));
        let scene = |a: &Self| (a.scene.as_ref()).map(|s| (s.name.clone(), s.scenario.clone()));
        let rest = |a: &Self| {
            let sizes = (a.triangles.clone(), a.seconds);
            (a.quick, sizes, a.session.clone(), a.seed)
        };
        self.experiment.name() == other.experiment.name()
            && rest(self) == rest(other)
            && mesh(self) == mesh(other)
            && scene(self) == scene(other)
    }
}

impl Asked {
    /// Name of the experiment.
    pub fn experiment(&self) -> &'static str {
        self.experiment.name()
    }

    /// As the lab takes it.
    pub fn setup(&self, shelf: &Shelf) -> Setup {
        Setup {
            quick: self.quick,
            mesh: self.mesh.clone(),
            triangles: self.triangles.clone(),
            scene: self.scene.clone(),
            session: self.session.clone(),
            seed: self.seed,
            seconds: self.seconds,
            shelf: shelf.clone(),
        }
    }
}

impl Choices {
    /// The question to `experiment`.
    ///
    /// # Errors
    /// A choice that it takes cannot be used: which, and what can.
    pub fn asked(&self, experiment: Listed, view: &View) -> Result<Asked, String> {
        let takes = |choice| experiment.takes().contains(&choice);
        let open = || view.scene.as_ref().ok_or("No scene is open");
        let mesh = match takes(Choice::Mesh) && self.skin {
            true => Some(Mesh {
                name: open()?.scenario.name.clone(),
                surface: Arc::clone(&open()?.surface),
            }),
            false => None,
        };
        let scene = match takes(Choice::Scene) && self.scene {
            true => Some(Scene {
                name: open()?.scenario.name.clone(),
                scenario: Arc::clone(&open()?.scenario),
            }),
            false => None,
        };
        let session = Some(self.session.trim())
            .filter(|path| takes(Choice::Session) && !path.is_empty())
            .map(PathBuf::from);
        if let Some(path) = &session
            && !path.is_file()
        {
            return Err(format!(
                "Session: {}: there is no such file",
                path.display()
            ));
        }
        Ok(Asked {
            experiment,
            quick: self.quick,
            mesh,
            triangles: match takes(Choice::Triangles) {
                true => triangles(&self.triangles)?,
                false => Vec::new(),
            },
            scene,
            session,
            seed: match takes(Choice::Seed) {
                true => seed(&self.seed)?,
                false => 0,
            },
            seconds: match takes(Choice::Seconds) {
                true => seconds(&self.seconds)?,
                false => None,
            },
        })
    }
}

fn triangles(text: &str) -> Result<Vec<usize>, String> {
    let allowed = back::FEWEST..=back::MOST;
    text.split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| {
            let n = part.parse().ok().filter(|n| allowed.contains(n));
            n.ok_or_else(|| {
                format!(
                    "Triangles: \"{part}\"; whole numbers from {} to {} with commas between are allowed",
                    back::FEWEST,
                    back::MOST
                )
            })
        })
        .collect()
}

fn seed(text: &str) -> Result<u64, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(0);
    }
    text.parse().map_err(|_| {
        format!(
            "Seed: \"{text}\"; a whole number from 0 to {} is allowed",
            u64::MAX
        )
    })
}

fn seconds(text: &str) -> Result<Option<f64>, String> {
    let text = text.trim();
    if text.is_empty() {
        return Ok(None);
    }
    let given = text.parse().ok().filter(|s| lab::SECONDS.contains(s));
    given.map(Some).ok_or_else(|| {
        format!(
            "Seconds: \"{text}\"; {} to {} are allowed",
            lab::SECONDS.start(),
            lab::SECONDS.end()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_typed_and_refused_in_one_line() {
        assert_eq!(triangles(" 300, 900 ,"), Ok(vec![300, 900]));
        assert_eq!(triangles(""), Ok(Vec::new()));
        assert_eq!((seed(" 7 "), seed("")), (Ok(7), Ok(0)));
        for bad in [
            "1",
            "300;900",
            "300, x",
            "-300",
            "1e3",
            "99999999999999999999",
        ] {
            let told = triangles(bad).expect_err(bad);
            assert!(told.contains("are allowed") && told.lines().count() == 1);
        }
        for bad in ["-1", "1.5", "x", "99999999999999999999"] {
            assert!(seed(bad).expect_err(bad).contains(bad));
        }
        assert_eq!((seconds(" 2.5 "), seconds("")), (Ok(Some(2.5)), Ok(None)));
        for bad in ["0", "-1", "NaN", "inf", "1e9", "x"] {
            assert!(seconds(bad).expect_err(bad).contains(bad));
        }
    }
}
