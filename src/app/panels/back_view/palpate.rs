//! From cursor and keys to where the mouse fingers are wanted. Pure: no widget, no device.
//!
//! ```text
//!   away ──cursor on skin──► hovering ──press──► pressing ──release──► hovering
//!     ◄──cursor off skin──────┘                     │ park: the other finger takes the press and holds it
//! ```

use crate::geom::Vec3;

/// How far above the skin the finger follows the cursor, mm: clear of every ridge within a finger's width.
const HOVER_MM: f64 = 6.0;
/// How far it rises when the cursor has left the skin, mm.
const AWAY_MM: f64 = 30.0;
/// Deepest press that can be asked for, mm. The hand gives way, so the skin sees less.
const MAX_DEPTH_MM: f64 = 30.0;
/// A first press: felt and seen on any back.
const FIRST_DEPTH_MM: f64 = 6.0;

/// A place on the rest surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinPoint {
    /// Where a finger just touches there, mm: on the skin, or a pad's radius above it.
    pub point_mm: Vec3,
    /// Outward unit normal, interpolated over the triangle.
    pub normal: Vec3,
}

impl SkinPoint {
    /// The place `depth_mm` below the skin; above it where negative.
    fn at_depth(&self, depth_mm: f64) -> Vec3 {
        self.point_mm - self.normal * depth_mm
    }
}

/// What the user does in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// Skin under the cursor.
    pub cursor: Option<SkinPoint>,
    /// The press is held down.
    pub press: bool,
    /// The place stays although the cursor moves (depth is being dragged).
    pub hold_place: bool,
    /// Change of the wanted depth, mm.
    pub depth_step_mm: f64,
    /// Park or lift the second finger.
    pub park: bool,
}

/// Where the fingers are wanted, mm; `None` leaves a finger alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Targets {
    /// The finger that follows the cursor.
    pub moving_mm: Option<Vec3>,
    /// The one that can be parked.
    pub parked_mm: Option<Vec3>,
}

/// The state of both mouse fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palpation {
    depth_mm: f64,
    place: Option<SkinPoint>,
    pressed: Option<SkinPoint>,
    pressing: bool,
    /// After parking, the finger that follows the cursor stays up until the button has been let go.
    lifted: bool,
    parked: Option<(SkinPoint, f64)>,
}

impl Default for Palpation {
    fn default() -> Self {
        Self {
            depth_mm: FIRST_DEPTH_MM,
            place: None,
            pressed: None,
            pressing: false,
            lifted: false,
            parked: None,
        }
    }
}

impl Palpation {
    /// Depth that a press asks for, mm.
    pub fn depth_mm(&self) -> f64 {
        self.depth_mm
    }

    /// Whether the finger that follows the cursor presses.
    pub fn is_pressing(&self) -> bool {
        self.pressing
    }

    /// Whether the second finger is parked.
    pub fn is_parked(&self) -> bool {
        self.parked.is_some()
    }

    /// The place last pressed.
    pub fn pressed(&self) -> Option<SkinPoint> {
        self.pressed
    }

    /// The place last pointed at.
    pub fn place(&self) -> Option<SkinPoint> {
        self.place
    }

    /// One frame later. `n_fingers` mouse fingers can be moved; parking needs two.
    pub fn step(&mut self, input: &Input, n_fingers: usize) -> Targets {
        if input.depth_step_mm.is_finite() {
            self.depth_mm = (self.depth_mm + input.depth_step_mm).clamp(0.0, MAX_DEPTH_MM);
        }
        let keep = input.hold_place && input.press;
        let on_skin = input.cursor.is_some() || input.press;
        if let Some(cursor) = input.cursor
            && !keep
        {
            self.place = Some(cursor);
        }
        self.lifted &= input.press;
        self.pressing = input.press && self.place.is_some() && !self.lifted;

        if self.pressing {
            self.pressed = self.place;
        }

        let mut targets = Targets::default();
        if input.park {
            targets.parked_mm = self.park(n_fingers);
        }
        if let Some(place) = self.place.filter(|_| n_fingers > 0) {
            let depth = match (self.pressing, on_skin) {
                (true, _) => self.depth_mm,
                (false, true) => -HOVER_MM,
                (false, false) => -AWAY_MM,
            };
            targets.moving_mm = Some(place.at_depth(depth));
        }
        targets
    }

    /// Parks the second finger where the first is wanted, or lifts it off again.
    fn park(&mut self, n_fingers: usize) -> Option<Vec3> {
        if let Some((place, _)) = self.parked.take() {
            return Some(place.at_depth(-AWAY_MM));
        }
        let place = self.place.filter(|_| n_fingers > 1)?;
        self.parked = Some((place, self.depth_mm));
        self.lifted = self.pressing;
        self.pressing = false;
        Some(place.at_depth(self.depth_mm))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> SkinPoint {
        SkinPoint {
            point_mm: Vec3::new(x, 100.0, 50.0),
            normal: Vec3::Z,
        }
    }

    fn hover(x: f64) -> Input {
        Input {
            cursor: Some(at(x)),
            ..Input::default()
        }
    }

    fn press(x: f64) -> Input {
        Input {
            press: true,
            ..hover(x)
        }
    }

    #[test]
    fn a_hovering_finger_stays_above_the_skin_and_a_pressing_one_goes_in() {
        let mut p = Palpation::default();
        assert_eq!(p.step(&Input::default(), 2), Targets::default());
        assert_eq!(p.step(&hover(0.0), 2).moving_mm.unwrap().z, 50.0 + HOVER_MM);
        assert_eq!(
            p.step(&press(0.0), 2).moving_mm.unwrap().z,
            50.0 - FIRST_DEPTH_MM
        );
        assert_eq!(p.step(&hover(0.0), 2).moving_mm.unwrap().z, 50.0 + HOVER_MM);
        assert_eq!(
            p.step(&Input::default(), 2).moving_mm.unwrap().z,
            50.0 + AWAY_MM
        );
    }

    #[test]
    fn moving_while_pressed_slides_and_leaving_the_skin_keeps_the_last_place() {
        let mut p = Palpation::default();
        p.step(&press(0.0), 1);
        assert_eq!(p.step(&press(12.0), 1).moving_mm.unwrap().x, 12.0);
        let off = Input {
            cursor: None,
            ..press(0.0)
        };
        let target = p.step(&off, 1).moving_mm.unwrap();
        assert_eq!((target.x, target.z), (12.0, 50.0 - FIRST_DEPTH_MM));
    }

    #[test]
    fn depth_changes_in_steps_within_its_bounds_and_the_place_can_be_held() {
        let mut p = Palpation::default();
        p.step(&press(0.0), 1);
        let deeper = Input {
            depth_step_mm: 2.5,
            hold_place: true,
            ..press(40.0)
        };
        let target = p.step(&deeper, 1).moving_mm.unwrap();
        assert_eq!((target.x, target.z), (0.0, 50.0 - FIRST_DEPTH_MM - 2.5));
        for step in [f64::NAN, 1e9, -1e9] {
            p.step(
                &Input {
                    depth_step_mm: step,
                    ..hover(0.0)
                },
                1,
            );
            assert!((0.0..=MAX_DEPTH_MM).contains(&p.depth_mm()));
        }
        assert_eq!(p.depth_mm(), 0.0);
    }

    #[test]
    fn parking_hands_the_press_to_the_second_finger_and_lifts_the_first() {
        let mut p = Palpation::default();
        p.step(&press(5.0), 2);
        let park = Input {
            park: true,
            ..press(5.0)
        };
        let targets = p.step(&park, 2);
        assert_eq!(
            targets.parked_mm,
            Some(Vec3::new(5.0, 100.0, 50.0 - FIRST_DEPTH_MM))
        );
        assert_eq!(targets.moving_mm.unwrap().z, 50.0 + HOVER_MM);
        assert!(p.is_parked());
        // Still held down: stays up. Let go and pressed again elsewhere: presses, and the parked one is left alone.
        assert!(p.step(&press(5.0), 2).moving_mm.unwrap().z > 50.0);
        p.step(&hover(60.0), 2);
        let again = p.step(&press(60.0), 2);
        assert_eq!(again.parked_mm, None);
        assert!(again.moving_mm.unwrap().z < 50.0);
        // Lifted off again.
        let lifted = p.step(&park, 2).parked_mm.unwrap();
        assert_eq!(lifted.z, 50.0 + AWAY_MM);
        assert!(!p.is_parked());
    }

    #[test]
    fn parking_needs_two_fingers() {
        let mut p = Palpation::default();
        p.step(&press(5.0), 1);
        let targets = p.step(
            &Input {
                park: true,
                ..press(5.0)
            },
            1,
        );
        assert_eq!(targets.parked_mm, None);
        assert!(!p.is_parked() && p.is_pressing());
    }
}
