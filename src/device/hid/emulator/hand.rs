//! What a simulated hand wants.

use crate::geom::Vec3;
use std::f64::consts::TAU;

/// The motion of a hand that holds an emulated device.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hand {
    /// Rests above, goes down within half a second and stays.
    Press {
        /// How far under the middle of the workspace, mm.
        depth_mm: f64,
    },
    /// Presses for a second and leaves, over and over: whoever lost it while it pressed has it again with the next press.
    Insist {
        /// How far under the middle of the workspace, mm.
        depth_mm: f64,
    },
    /// Presses and leaves over and over while it wanders sideways.
    Palpate {
        /// How far under the middle of the workspace, mm.
        depth_mm: f64,
    },
    /// Palpates for a while, then rests above for as long, in turn.
    Visit {
        /// How far under the middle of the workspace, mm.
        depth_mm: f64,
    },
}

/// Where it rests, mm above the middle of the workspace.
const ABOVE_MM: f64 = 20.0;
/// When it begins to go down, and how long that takes, s.
const BEGINS_S: f64 = 0.3;
const DOWN_S: f64 = 0.5;
/// An insisting hand: from press to press, until it leaves, and how long it goes down or up, s.
const INSISTS_S: f64 = 1.6;
const STAYS_S: f64 = 1.2;
const COMES_S: f64 = 0.3;
/// How high a palpating hand goes between two presses, mm: out of the skin.
const LEAVES_MM: f64 = 6.0;
/// Presses in a second, and turns of the wandering, Hz: none a multiple of another.
const PRESSES_HZ: f64 = 0.7;
const WANDERS_HZ: [f64; 2] = [0.23, 0.31];
/// How far it wanders, mm.
const WANDERS_MM: f64 = 12.0;
/// How long a visiting hand palpates and how long it rests, and how long it comes or goes, s.
const VISITS_S: f64 = 10.0;
const GOES_S: f64 = 1.0;

impl Hand {
    /// How deep it goes, mm.
    pub fn depth_mm(self) -> f64 {
        match self {
            Self::Press { depth_mm }
            | Self::Insist { depth_mm }
            | Self::Palpate { depth_mm }
            | Self::Visit { depth_mm } => depth_mm,
        }
    }

    /// Where it wants the tip `t` s after the start, mm.
    pub fn target_mm(self, t: f64) -> Vec3 {
        let depth_mm = self.depth_mm();
        let down = ((t - BEGINS_S) / DOWN_S).clamp(0.0, 1.0);
        let pressed = Vec3::Z * (ABOVE_MM - (ABOVE_MM + depth_mm) * down);
        let since_s = t - BEGINS_S - DOWN_S;
        match self {
            Self::Palpate { .. } if since_s > 0.0 => {
                let share = 0.5 + 0.5 * libm::cos(TAU * PRESSES_HZ * since_s);
                let [x, y] = WANDERS_HZ.map(|hz| WANDERS_MM * libm::sin(TAU * hz * since_s));
                Vec3::new(x, y, LEAVES_MM - (LEAVES_MM + depth_mm) * share)
            }
            Self::Visit { .. } => {
                let at = since_s.max(0.0) % (2.0 * VISITS_S);
                let share = |since_s: f64| (since_s / GOES_S).clamp(0.0, 1.0);
                let away = share(at - VISITS_S) - share(at - 2.0 * VISITS_S + GOES_S);
                let palpates = Self::Palpate { depth_mm }.target_mm(t);
                palpates.lerp(Vec3::Z * ABOVE_MM, away)
            }
            Self::Insist { .. } => {
                let t = (t - BEGINS_S).max(0.0) % INSISTS_S;
                let down = (t / COMES_S).min(1.0) - ((t - STAYS_S) / COMES_S).clamp(0.0, 1.0);
                Vec3::Z * (LEAVES_MM - (LEAVES_MM + depth_mm) * down)
            }
            _ => pressed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hands_move_without_a_jump_and_those_that_palpate_leave_the_skin() {
        for hand in [
            Hand::Press { depth_mm: 8.0 },
            Hand::Insist { depth_mm: 8.0 },
            Hand::Palpate { depth_mm: 8.0 },
            Hand::Visit { depth_mm: 8.0 },
        ] {
            let path: Vec<Vec3> = (0..25_000)
                .map(|ms| hand.target_mm(f64::from(ms) * 1e-3))
                .collect();
            let fastest = path
                .windows(2)
                .map(|w| w[0].distance(w[1]))
                .fold(0.0, f64::max);
            assert!(fastest < 0.1, "{hand:?}: {fastest} mm in a millisecond");
            let lowest = path.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            assert!((lowest + 8.0).abs() < 1e-3, "{hand:?}: {lowest}");
            let leaves = path[1000..].iter().any(|p| p.z > 5.0);
            assert_eq!(leaves, !matches!(hand, Hand::Press { .. }));
            let rests = path[12_000..19_500]
                .iter()
                .all(|p| p.distance(Vec3::Z * ABOVE_MM) < 1e-9);
            assert_eq!(rests, matches!(hand, Hand::Visit { .. }));
        }
    }
}
