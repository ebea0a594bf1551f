//! Who sits before the window, and the workspace that is ready for them.

use super::dock::{Home, PanelSlot};
use super::panels::{self, BACK_VIEW_KEY, PLOTS_KEY};

/// A role. It decides which panels are there at first, and who sees the truth while an exercise runs.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Measures, records, replays, compares.
    #[default]
    Researcher,
    /// Makes scenarios and watches a trainee.
    Instructor,
    /// Palpates and answers.
    Trainee,
}

/// Where a workspace has a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The part of the window.
    pub home: Home,
    /// Whether it is open at first.
    pub open: bool,
}

/// Shares that the places of a workspace take at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Of the width, for the main place.
    pub main: f32,
    /// Of the right column's height, for its upper half.
    pub top: f32,
}

impl Role {
    /// Every role, in the order of the menu.
    pub const ALL: [Self; 3] = [Self::Instructor, Self::Trainee, Self::Researcher];

    /// Its place in [`Role::ALL`].
    pub fn index(self) -> usize {
        Self::ALL.iter().position(|&r| r == self).unwrap_or(0)
    }

    /// Its name in files and arguments.
    pub fn key(self) -> &'static str {
        match self {
            Self::Researcher => "researcher",
            Self::Instructor => "instructor",
            Self::Trainee => "trainee",
        }
    }

    /// The role of that name.
    pub fn named(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.key() == key)
    }

    /// Whether the main window shows, while an exercise runs, what the trainee is to find.
    pub fn sees_truth(self) -> bool {
        self == Self::Instructor
    }

    /// Whether the menu bar offers the closed panels: a trainee has nothing to look for there.
    pub fn offers_panels(self) -> bool {
        self != Self::Trainee
    }

    /// Panels that are open at first, the front one of each part first; `None`: each as it says itself.
    fn opens(self) -> Option<&'static [(&'static str, Home)]> {
        match self {
            Self::Researcher => None,
            Self::Instructor => Some(&[
                (BACK_VIEW_KEY, Home::Main),
                (panels::scenario_editor::KEY, Home::Main),
                (panels::exercise::KEY, Home::RightTop),
                (panels::library::KEY, Home::RightTop),
                (panels::sessions::KEY, Home::RightTop),
                (PLOTS_KEY, Home::RightBottom),
            ]),
            Self::Trainee => Some(&[
                (BACK_VIEW_KEY, Home::Main),
                (panels::exercise::KEY, Home::RightTop),
            ]),
        }
    }

    /// Where its workspace has `panel`.
    pub fn place(self, panel: &PanelSlot) -> Place {
        let Some(opens) = self.opens() else {
            let (home, open) = (panel.home, panel.opens_at_first);
            return Place { home, open };
        };
        let own = opens.iter().find(|(key, _)| *key == panel.key);
        let home = own.map_or(panel.home, |(_, home)| *home);
        let home = match (self, home) {
            // One column, without a lower half that would stand empty.
            (Self::Trainee, Home::RightBottom) => Home::RightTop,
            _ => home,
        };
        let open = own.is_some();
        Place { home, open }
    }

    /// The rank of `panel` among those at its place: open ones first, as the workspace names them.
    pub fn rank(self, panel: &PanelSlot) -> usize {
        let opens = self.opens().unwrap_or_default();
        let own = opens.iter().position(|(key, _)| *key == panel.key);
        own.unwrap_or(opens.len())
    }

    /// How its workspace is divided.
    pub fn shares(self) -> Shares {
        match self {
            Self::Researcher => Shares {
                main: 2.0 / 3.0,
                top: 0.62,
            },
            Self::Instructor => Shares {
                main: 0.6,
                top: 0.66,
            },
            Self::Trainee => Shares {
                main: 0.7,
                top: 1.0,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::dock::slots;

    #[test]
    fn every_panel_that_a_role_opens_is_there() {
        let panels = slots(panels::all());
        for role in Role::ALL {
            assert_eq!(Role::named(role.key()), Some(role));
            for (key, _) in role.opens().unwrap_or_default() {
                assert!(
                    panels.iter().any(|p| p.key == *key),
                    "{}: no panel {key}",
                    role.key()
                );
            }
        }
        assert_eq!(Role::named("guest"), None);
    }

    #[test]
    fn only_an_instructor_sees_the_truth() {
        let seeing: Vec<_> = Role::ALL.into_iter().filter(|r| r.sees_truth()).collect();
        assert_eq!(seeing, [Role::Instructor]);
    }
}
