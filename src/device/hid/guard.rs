//! What takes the force off a device: a state machine over reports and the time, without a clock of its own.

use crate::device::calibration::Guards;
use crate::geom::Vec3;

/// How a device is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum Condition {
    /// Nothing was heard yet.
    #[default]
    Waiting,
    /// It answers and its motion is plausible.
    Good,
    /// No report for too long. Good again with the next.
    Silent,
    /// Reports come whose counter and encoders stand. Good again when they move.
    Frozen,
    /// The place jumped. Stays until released.
    Jumped,
    /// It moved faster than a hand. Stays until released.
    TooFast,
    /// It is outside of what it can reach. Stays until released.
    TooFar,
    /// It ran against its force: an axis may be reversed. Stays until released.
    AgainstForce,
    /// It was pulled out, or the system took it away. Final.
    Unplugged,
    /// It was closed. Final.
    Closed,
    /// The thread that spoke with it ended by a fault of the program. Final.
    Ended,
}

impl Condition {
    /// All.
    pub const ALL: [Self; 11] = [
        Self::Waiting,
        Self::Good,
        Self::Silent,
        Self::Frozen,
        Self::Jumped,
        Self::TooFast,
        Self::TooFar,
        Self::AgainstForce,
        Self::Unplugged,
        Self::Closed,
        Self::Ended,
    ];

    /// The condition with this number.
    pub fn from_number(number: u8) -> Self {
        let found = Self::ALL.into_iter().find(|c| *c as u8 == number);
        found.unwrap_or(Self::Ended)
    }

    /// For people, in a sentence that says what to do.
    pub fn title(self) -> &'static str {
        match self {
            Self::Waiting => "waiting for its first report",
            Self::Good => "answers",
            Self::Silent => "does not answer; check the cable",
            Self::Frozen => "repeats itself; unplug it and plug it in again",
            Self::Jumped => "its place jumped; check the encoders, then release it",
            Self::TooFast => "moved too fast; hold it, then release it",
            Self::TooFar => "is outside of its reach; calibrate it, then release it",
            Self::AgainstForce => {
                "ran against its force; check the direction of its motors, then release it"
            }
            Self::Unplugged => "unplugged",
            Self::Closed => "closed",
            Self::Ended => "its thread ended by a fault of the program",
        }
    }

    /// Whether it stays until somebody releases it.
    pub fn is_latched(self) -> bool {
        matches!(
            self,
            Self::Jumped | Self::TooFast | Self::TooFar | Self::AgainstForce
        )
    }

    /// Whether nothing will be heard of it again.
    pub fn is_final(self) -> bool {
        matches!(self, Self::Unplugged | Self::Closed | Self::Ended)
    }
}

/// What one report says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sighting {
    /// When it came, s.
    pub time_s: f64,
    /// Where the device is, mm.
    pub position_mm: Vec3,
    /// How fast, mm/s.
    pub velocity_mm_s: Vec3,
    /// Encoders as they came.
    pub raw: [i32; 6],
    /// Its counter; `None` for a device that has none.
    pub counter: Option<u16>,
    /// The force rendered when it came, N.
    pub force_n: Vec3,
}

/// How long a device may run against half its force, s.
const AGAINST_S: f64 = 0.015;
/// How long it may seem too fast, s: one late report is no motion.
const FAST_S: f64 = 0.005;

/// The guard of one device. Times are seconds since any start, rising.
#[derive(Clone, Copy, Debug)]
pub struct Guard {
    bounds: Guards,
    rated_force_n: f64,
    /// Whether silence means trouble: some devices speak only when moved.
    periodic: bool,
    condition: Condition,
    last: Option<Sighting>,
    heard_s: f64,
    moved_s: f64,
    counter_moves: bool,
    against_since_s: Option<f64>,
    fast_since_s: Option<f64>,
}

impl Guard {
    /// A guard that has heard nothing.
    pub fn new(bounds: Guards, rated_force_n: f64, periodic: bool) -> Self {
        Self {
            bounds,
            rated_force_n,
            periodic,
            condition: Condition::Waiting,
            last: None,
            heard_s: 0.0,
            moved_s: 0.0,
            counter_moves: false,
            against_since_s: None,
            fast_since_s: None,
        }
    }

    /// How the device is.
    pub fn condition(&self) -> Condition {
        self.condition
    }

    /// Whether force may flow.
    pub fn may_push(&self) -> bool {
        self.condition == Condition::Good
    }

    /// Takes a report in.
    pub fn hear(&mut self, now: Sighting) {
        if self.condition.is_final() {
            return;
        }
        self.heard_s = now.time_s;
        let before = self.last.replace(now);
        let Some(before) = before else {
            self.moved_s = now.time_s;
            self.recover();
            self.judge_place(&now);
            return;
        };
        let counted = now.counter.is_some() && now.counter != before.counter;
        // A counter that never moved tells nothing: only one that did can be found standing.
        self.counter_moves |= counted;
        if counted || now.raw != before.raw {
            self.moved_s = now.time_s;
        }
        self.recover();
        if self.condition == Condition::Good {
            self.judge_motion(&before, &now);
            self.judge_place(&now);
            self.judge_against(&now);
        }
    }

    /// Looks at the clock; to be called also when nothing comes.
    pub fn look(&mut self, time_s: f64) {
        if self.condition != Condition::Good {
            return;
        }
        if self.periodic && time_s - self.heard_s > self.bounds.silence_ms / 1000.0 {
            self.trip(Condition::Silent);
        } else if self.counter_moves && time_s - self.moved_s > self.bounds.frozen_ms / 1000.0 {
            self.trip(Condition::Frozen);
        }
    }

    /// The device went for good.
    pub fn end(&mut self, how: Condition) {
        if !self.condition.is_final() {
            self.condition = how;
        }
    }

    /// Somebody looked at it and wants it back: whatever was latched is good again with the next report.
    pub fn release(&mut self) {
        if self.condition.is_latched() {
            self.condition = Condition::Silent;
            self.last = None;
            self.against_since_s = None;
        }
    }

    fn recover(&mut self) {
        match self.condition {
            Condition::Waiting => self.condition = Condition::Good,
            // It may be anywhere by now: what lies between is no jump.
            Condition::Silent => self.condition = Condition::Good,
            Condition::Frozen if self.moved_s == self.heard_s => self.condition = Condition::Good,
            _ => {}
        }
    }

    fn trip(&mut self, condition: Condition) {
        self.condition = condition;
        self.last = self.last.filter(|_| condition == Condition::Frozen);
        self.against_since_s = None;
        self.fast_since_s = None;
    }

    fn judge_motion(&mut self, before: &Sighting, now: &Sighting) {
        let interval_s = (now.time_s - before.time_s).max(0.0);
        let step_mm = (now.position_mm - before.position_mm).length();
        let allowed_mm = self.bounds.jump_mm + self.bounds.max_speed_mm_s * interval_s;
        if step_mm.is_nan() || step_mm > allowed_mm {
            self.trip(Condition::Jumped);
            return;
        }
        if now.velocity_mm_s.length() <= self.bounds.max_speed_mm_s {
            self.fast_since_s = None;
            return;
        }
        let since_s = *self.fast_since_s.get_or_insert(now.time_s);
        if now.time_s - since_s >= FAST_S {
            self.trip(Condition::TooFast);
        }
    }

    fn judge_place(&mut self, now: &Sighting) {
        let off_mm = now.position_mm.length();
        if self.condition == Condition::Good
            && (off_mm.is_nan() || off_mm > self.bounds.max_distance_mm)
        {
            self.trip(Condition::TooFar);
        }
    }

    fn judge_against(&mut self, now: &Sighting) {
        if self.condition != Condition::Good {
            return;
        }
        let force_n = now.force_n.length();
        let along = if force_n > 0.0 {
            now.velocity_mm_s.dot(now.force_n) / force_n
        } else {
            0.0
        };
        let strong = self.rated_force_n > 0.0 && force_n >= 0.5 * self.rated_force_n;
        if !strong || along > -self.bounds.against_force_mm_s {
            self.against_since_s = None;
            return;
        }
        let since_s = *self.against_since_s.get_or_insert(now.time_s);
        if now.time_s - since_s >= AGAINST_S {
            self.trip(Condition::AgainstForce);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn guard() -> Guard {
        Guard::new(Guards::default(), 5.0, true)
    }

    fn at(ms: f64, x: f64, counter: u16) -> Sighting {
        Sighting {
            time_s: ms / 1000.0,
            position_mm: Vec3::X * x,
            raw: [libm::round(x * 100.0) as i32, 0, 0, 0, 0, 0],
            counter: Some(counter),
            ..Sighting::default()
        }
    }

    #[test]
    fn silence_takes_the_force_off_within_its_bound_and_the_next_report_gives_it_back() {
        let mut g = guard();
        assert!(!g.may_push());
        g.hear(at(0.0, 0.0, 0));
        assert!(g.may_push());
        g.look(0.008);
        assert!(g.may_push());
        g.look(0.0081);
        assert_eq!(g.condition(), Condition::Silent);
        // It moved meanwhile, far; that is no jump.
        g.hear(at(500.0, 200.0, 1));
        assert!(g.may_push());
    }

    #[test]
    fn a_counter_that_stands_is_told_from_a_hand_that_does() {
        let mut g = guard();
        for ms in 0..100_u16 {
            g.hear(at(f64::from(ms), 1.0, ms));
            g.look(f64::from(ms) / 1000.0);
            assert!(g.may_push(), "a still hand at {ms} ms");
        }
        let mut frozen_at = None;
        for ms in 100..200_u16 {
            g.hear(at(f64::from(ms), 1.0, 99));
            g.look(f64::from(ms) / 1000.0);
            if !g.may_push() {
                frozen_at.get_or_insert(ms);
            }
        }
        assert_eq!((g.condition(), frozen_at), (Condition::Frozen, Some(108)));
        g.hear(at(200.0, 1.0, 100));
        assert!(g.may_push());
    }

    #[test]
    fn a_counter_that_never_moved_is_no_counter() {
        let mut g = guard();
        for ms in 0..200_u16 {
            g.hear(at(f64::from(ms), 1.0, 0));
            g.look(f64::from(ms) / 1000.0);
        }
        assert!(g.may_push());
    }

    #[test]
    fn a_jump_stays_until_it_is_released() {
        let mut g = guard();
        g.hear(at(0.0, 0.0, 0));
        g.hear(at(1.0, 7.9, 1));
        assert!(g.may_push(), "5 mm and 3 mm of speed are allowed");
        g.hear(at(2.0, 16.0, 2));
        assert_eq!(g.condition(), Condition::Jumped);
        for ms in 3..1000_u16 {
            g.hear(at(f64::from(ms), 16.0, ms));
            assert!(!g.may_push());
        }
        g.release();
        assert!(!g.may_push(), "not before a report");
        g.hear(at(1001.0, 16.0, 1));
        assert!(g.may_push());
    }

    #[test]
    fn places_that_are_none_or_far_and_speeds_beyond_a_hand_are_faults() {
        for (x, speed, expected) in [
            (f64::NAN, 0.0, Condition::Jumped),
            (4.0, 3001.0, Condition::TooFast),
            (4.0, 2999.0, Condition::Good),
        ] {
            let mut g = guard();
            g.hear(at(0.0, 0.0, 0));
            for ms in 1..=6_u16 {
                let mut now = at(f64::from(ms), x, ms);
                now.velocity_mm_s = Vec3::Y * speed;
                assert!(ms == 1 || g.may_push() || x.is_nan(), "{speed} for {ms} ms");
                g.hear(now);
            }
            assert_eq!(g.condition(), expected, "{x} {speed}");
        }
        for x in [501.0, f64::NAN, f64::INFINITY] {
            let mut g = guard();
            g.hear(at(0.0, x, 0));
            assert_eq!(g.condition(), Condition::TooFar, "{x}");
        }
    }

    #[test]
    fn running_against_half_the_force_is_a_reversed_axis_pressing_is_not() {
        let run = |speed: f64, force: f64| {
            let mut g = guard();
            for ms in 0..40_u16 {
                let mut now = at(f64::from(ms), 0.0, ms);
                now.velocity_mm_s = Vec3::X * -speed;
                now.force_n = Vec3::X * force;
                g.hear(now);
            }
            g.condition()
        };
        assert_eq!(run(450.0, 3.0), Condition::AgainstForce);
        assert_eq!(run(350.0, 5.0), Condition::Good, "a quick press");
        assert_eq!(run(900.0, 2.0), Condition::Good, "a tap");
        assert_eq!(run(-900.0, 5.0), Condition::Good, "thrown out");
    }

    #[test]
    fn what_is_unplugged_stays_so() {
        let mut g = guard();
        g.hear(at(0.0, 0.0, 0));
        g.end(Condition::Unplugged);
        g.hear(at(1.0, 0.0, 1));
        g.release();
        g.end(Condition::Closed);
        assert_eq!(g.condition(), Condition::Unplugged);
    }

    #[test]
    fn a_device_that_speaks_only_when_moved_may_be_silent() {
        let mut g = Guard::new(Guards::default(), 0.0, false);
        g.hear(Sighting::default());
        g.look(3600.0);
        assert!(g.may_push());
    }

    #[test]
    fn conditions_know_their_numbers() {
        for c in Condition::ALL {
            assert_eq!(Condition::from_number(c as u8), c);
        }
        assert_eq!(Condition::from_number(200), Condition::Ended);
    }

    proptest! {
        /// Force flows only from a good device, and never after a place that is none.
        #[test]
        fn no_report_of_any_kind_lets_force_flow_from_nowhere(
            x in prop::num::f64::ANY, v in prop::num::f64::ANY, f in prop::num::f64::ANY, t in prop::num::f64::ANY,
        ) {
            let mut g = guard();
            g.hear(at(0.0, 0.0, 0));
            let mut now = at(1.0, x, 1);
            (now.time_s, now.velocity_mm_s, now.force_n) = (t, Vec3::Y * v, Vec3::Z * f);
            g.hear(now);
            prop_assert!(!g.may_push() || x.is_finite());
        }
    }
}
