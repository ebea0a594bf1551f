//! Trajectories and named scripts: the device of headless runs, tests and benchmarks.

use super::{Capabilities, Device, MAX_FINGERS, Reading};
use crate::geom::Vec3;
use std::fmt;
use std::path::Path;

/// A place at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Time since the start, s.
    pub time_s: f64,
    /// Where the HIP is then, mm.
    pub position_mm: Vec3,
}

/// One finger's motion: straight at constant speed between waypoints, at rest after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    waypoints: Vec<Waypoint>,
}

/// Why a trajectory is refused: file, line, what, which value, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TrajectoryError(String);

/// Coordinates beyond this are taken for an error in units, mm.
const FAR_MM: f64 = 1.0e7;

/// Speeds beyond this are taken for an error in units, mm/s: ten kilometres within a tick.
const FAST_MM_S: f64 = 1.0e10;

impl Trajectory {
    /// A motion through `waypoints`.
    ///
    /// # Errors
    /// None at all, a number that is not finite or absurdly large, time that does not rise, a speed beyond reason.
    pub fn new(waypoints: Vec<Waypoint>) -> Result<Self, TrajectoryError> {
        if waypoints.is_empty() {
            return Err(TrajectoryError(
                "the trajectory has no points; at least one is needed".into(),
            ));
        }
        for (i, w) in waypoints.iter().enumerate() {
            if !w.time_s.is_finite() || w.time_s < 0.0 {
                return Err(TrajectoryError(format!(
                    "point {i}: t = {} s; a finite time ≥ 0 is needed",
                    w.time_s
                )));
            }
            if let Some(x) = w
                .position_mm
                .to_array()
                .into_iter()
                .find(|x| !x.is_finite() || x.abs() > FAR_MM)
            {
                return Err(TrajectoryError(format!(
                    "point {i}: coordinate {x} mm; within ±{FAR_MM:e} is allowed"
                )));
            }
            if i > 0 && w.time_s <= waypoints[i - 1].time_s {
                return Err(TrajectoryError(format!(
                    "point {i}: t = {} s does not come after t = {} s; times must rise",
                    w.time_s,
                    waypoints[i - 1].time_s
                )));
            }
            if let Some(before) = i.checked_sub(1).map(|i| waypoints[i]) {
                let way_mm = w.position_mm.distance(before.position_mm);
                let speed_mm_s = way_mm / (w.time_s - before.time_s);
                // Not a division of 0 by 0: times rise.
                if speed_mm_s > FAST_MM_S {
                    return Err(TrajectoryError(format!(
                        "point {i}: {way_mm} mm from t = {} s to t = {} s; up to {FAST_MM_S:e} mm/s is allowed",
                        before.time_s, w.time_s
                    )));
                }
            }
        }
        Ok(Self { waypoints })
    }

    /// Time of the last waypoint, s.
    pub fn duration_s(&self) -> f64 {
        self.waypoints.last().map_or(0.0, |w| w.time_s)
    }

    /// Place (mm) and velocity (mm/s) at a time, s. Before the first waypoint: at rest there.
    pub fn at(&self, time_s: f64) -> (Vec3, Vec3) {
        let next = self.waypoints.partition_point(|w| w.time_s <= time_s);
        match (
            next.checked_sub(1).map(|i| self.waypoints[i]),
            self.waypoints.get(next),
        ) {
            (Some(a), Some(b)) => {
                let velocity = (b.position_mm - a.position_mm) / (b.time_s - a.time_s);
                (a.position_mm + velocity * (time_s - a.time_s), velocity)
            }
            (Some(last), None) => (last.position_mm, Vec3::ZERO),
            (None, Some(first)) => (first.position_mm, Vec3::ZERO),
            (None, None) => (Vec3::ZERO, Vec3::ZERO),
        }
    }

    /// Reads `t,x,y,z[,finger]` (s, mm) from CSV with a header line; one trajectory per finger, from finger 0 without a
    /// gap. `origin` names the text in errors.
    ///
    /// # Errors
    /// The first thing wrong, with its line.
    pub fn parse_csv(text: &str, origin: &str) -> Result<Vec<Self>, TrajectoryError> {
        let fail =
            |line: u64, what: String| TrajectoryError(format!("{origin}: line {line}: {what}"));
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let header = reader
            .headers()
            .map_err(|e| fail(1, e.to_string()))?
            .clone();
        let columns: Vec<&str> = header.iter().collect();
        let with_finger = match columns[..] {
            ["t", "x", "y", "z"] => false,
            ["t", "x", "y", "z", "finger"] => true,
            _ => {
                return Err(fail(
                    1,
                    format!(
                        "columns \"{}\"; allowed are t,x,y,z or t,x,y,z,finger",
                        columns.join(",")
                    ),
                ));
            }
        };
        let mut fingers: Vec<Vec<Waypoint>> = Vec::new();
        for row in reader.records() {
            let row = row.map_err(|e| {
                let line = e.position().map_or(0, csv::Position::line);
                fail(
                    line,
                    format!("{}; every row needs {} fields", kind_of(&e), columns.len()),
                )
            })?;
            let line = row.position().map_or(0, csv::Position::line);
            let number = |i: usize| {
                let text = row.get(i).unwrap_or_default();
                text.parse::<f64>()
                    .ok()
                    .filter(|x| x.is_finite() && x.abs() <= FAR_MM)
                    .ok_or_else(|| {
                        fail(
                            line,
                            format!(
                                "{} = \"{text}\"; a number within ±{FAR_MM:e} is needed",
                                columns[i]
                            ),
                        )
                    })
            };
            let waypoint = Waypoint {
                time_s: number(0)?,
                position_mm: Vec3::new(number(1)?, number(2)?, number(3)?),
            };
            let finger = if with_finger { number(4)? } else { 0.0 };
            if !(0.0..MAX_FINGERS as f64).contains(&finger) || finger.fract() != 0.0 {
                let last = MAX_FINGERS - 1;
                let what = format!("finger = {finger}; whole numbers from 0 to {last} are allowed");
                return Err(fail(line, what));
            }
            let finger = finger as usize;
            if fingers.len() <= finger {
                fingers.resize(finger + 1, Vec::new());
            }
            if waypoint.time_s < 0.0 {
                return Err(fail(
                    line,
                    format!("t = {} s; times start at 0", waypoint.time_s),
                ));
            }
            if let Some(last) = fingers[finger]
                .last()
                .filter(|last| waypoint.time_s <= last.time_s)
            {
                let (now, before) = (waypoint.time_s, last.time_s);
                return Err(fail(
                    line,
                    format!("t = {now} s does not come after t = {before} s; times must rise"),
                ));
            }
            fingers[finger].push(waypoint);
        }
        if fingers.is_empty() {
            return Err(TrajectoryError(format!(
                "{origin}: no points; at least one is needed"
            )));
        }
        fingers
            .into_iter()
            .enumerate()
            .map(|(i, w)| {
                Self::new(w).map_err(|e| TrajectoryError(format!("{origin}: finger {i}: {e}")))
            })
            .collect()
    }

    /// Reads a trajectory file, see [`Trajectory::parse_csv`].
    ///
    /// # Errors
    /// The file cannot be read, or the first thing wrong with it.
    pub fn load_csv(path: &Path) -> Result<Vec<Self>, TrajectoryError> {
        let text = std::fs::read_to_string(path)
            .map_err(|e| TrajectoryError(format!("{}: {e}", path.display())))?;
        Self::parse_csv(&text, &path.display().to_string())
    }
}

fn kind_of(e: &csv::Error) -> String {
    match e.kind() {
        csv::ErrorKind::UnequalLengths { len, .. } => format!("the row has {len} fields"),
        csv::ErrorKind::Utf8 { .. } => "the text is not UTF-8".into(),
        other => format!("{other:?}"),
    }
}

/// Motions with a name. All start above the skin, press, do what the name says, and leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Script {
    /// Straight down, hold, up.
    Press,
    /// Press and slide along the spine.
    Slide,
    /// Press and circle.
    Circle,
    /// Press and spiral outward.
    Spiral,
    /// Five short taps.
    Tap,
}

impl Script {
    /// Every script.
    pub const ALL: [Self; 5] = [
        Self::Press,
        Self::Slide,
        Self::Circle,
        Self::Spiral,
        Self::Tap,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Press => "press",
            Self::Slide => "slide",
            Self::Circle => "circle",
            Self::Spiral => "spiral",
            Self::Tap => "tap",
        }
    }

    /// The script called `name`.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|s| s.name() == name)
    }

    /// The motion over a surface given as height (mm) over the map plane, around `(x, y)` mm, `depth_mm` deep.
    ///
    /// `height_mm` answers `None` where there is no skin; the motion then keeps the last height it knew. A place or depth that
    /// is not a number counts as 0, one beyond 2.5 km as that.
    pub fn trajectory(
        self,
        centre_mm: (f64, f64),
        depth_mm: f64,
        mut height_mm: impl FnMut(f64, f64) -> Option<f64>,
    ) -> Trajectory {
        const CLEARANCE_MM: f64 = 20.0;
        const STEP_S: f64 = 0.02;
        let sound = |x: f64| {
            if x.is_nan() {
                0.0
            } else {
                x.clamp(-0.25 * FAR_MM, 0.25 * FAR_MM)
            }
        };
        let (cx, cy) = (sound(centre_mm.0), sound(centre_mm.1));
        let depth_mm = sound(depth_mm);
        let mut height_mm = |x, y| height_mm(x, y).filter(|z| z.abs() <= 0.25 * FAR_MM);
        let mut known_mm = height_mm(cx, cy).unwrap_or(0.0);
        let mut waypoints: Vec<Waypoint> = Vec::new();
        let steps = (self.duration_s() / STEP_S).round() as usize;
        for i in 0..=steps {
            let time_s = i as f64 * STEP_S;
            let (dx, dy, down) = self.pose(time_s / self.duration_s());
            let (x, y) = (cx + dx, cy + dy);
            known_mm = height_mm(x, y).unwrap_or(known_mm);
            let z = known_mm + CLEARANCE_MM - down * (CLEARANCE_MM + depth_mm);
            waypoints.push(Waypoint {
                time_s,
                position_mm: Vec3::new(x, y, z),
            });
        }
        Trajectory { waypoints }
    }

    /// Length, s.
    pub fn duration_s(self) -> f64 {
        match self {
            Self::Press => 2.0,
            Self::Slide | Self::Circle => 4.0,
            Self::Spiral => 6.0,
            Self::Tap => 3.0,
        }
    }

    /// Offset on the map plane (mm) and how far down (0 above the skin, 1 at depth) at a fraction of the motion.
    fn pose(self, s: f64) -> (f64, f64, f64) {
        use std::f64::consts::TAU;
        let held = ramp(s / 0.2) * ramp((1.0 - s) / 0.2);
        let along = ((s - 0.2) / 0.6).clamp(0.0, 1.0);
        match self {
            Self::Press => (0.0, 0.0, held),
            Self::Slide => (0.0, 60.0 - 120.0 * ramp(along), held),
            Self::Circle => (
                25.0 * libm::sin(TAU * along),
                25.0 * (libm::cos(TAU * along) - 1.0),
                held,
            ),
            Self::Spiral => {
                let r = 40.0 * along;
                (
                    r * libm::sin(4.0 * TAU * along),
                    r * libm::cos(4.0 * TAU * along),
                    held,
                )
            }
            Self::Tap => (0.0, 0.0, 0.5 - 0.5 * libm::cos(5.0 * TAU * s)),
        }
    }
}

impl fmt::Display for Script {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Smooth rise from 0 at `s` ≤ 0 to 1 at `s` ≥ 1 (smoothstep).
fn ramp(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// A device that follows a trajectory exactly, whatever the force.
#[derive(Clone, Debug)]
pub struct Scripted {
    capabilities: Capabilities,
    trajectory: Trajectory,
    ticks: u64,
}

impl Scripted {
    /// Follows `trajectory` from its start.
    pub fn new(trajectory: Trajectory) -> Self {
        let capabilities = Capabilities::ideal("Scripted", 22.0);
        Self {
            capabilities,
            trajectory,
            ticks: 0,
        }
    }
}

impl Device for Scripted {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        // Counted, not summed: an hour of steps must not drift.
        let (position_mm, velocity_mm_s) = self.trajectory.at(self.ticks as f64 * dt_s);
        self.ticks += 1;
        Reading {
            position_mm,
            velocity_mm_s,
            buttons: 0,
            connected: true,
        }
    }

    fn write(&mut self, _force_n: Vec3) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn csv_of_two_fingers_gives_two_trajectories() {
        let text = "t,x,y,z,finger\n0,1,2,3,0\n0,0,0,9,1\n1,1,2,5,0\n";
        let fingers = Trajectory::parse_csv(text, "a.csv").expect("valid");
        assert_eq!(fingers.len(), 2);
        assert_eq!(
            fingers[0].at(0.5),
            (Vec3::new(1.0, 2.0, 4.0), Vec3::new(0.0, 0.0, 2.0))
        );
        assert_eq!(fingers[1].at(7.0), (Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO));
    }

    /// 1 mm within 5e-324 s was a speed of infinity, and at the start infinity times 0 mm.
    #[test]
    fn a_speed_beyond_number_is_refused() {
        let at = |time_s, x| Waypoint {
            time_s,
            position_mm: Vec3::X * x,
        };
        let error = Trajectory::new(vec![at(0.0, 0.0), at(5e-324, 1.0)]).expect_err("refused");
        let told = "point 1: 1 mm from t = 0 s to t = ";
        assert!(error.to_string().starts_with(told), "{error}");
        assert!(
            error.to_string().ends_with("up to 1e10 mm/s is allowed"),
            "{error}"
        );
        let fast = Trajectory::new(vec![at(0.0, -1e7), at(0.002, 1e7)]).expect("allowed");
        assert_eq!(fast.at(0.001).0.x, 0.0);
        assert!(
            Trajectory::new(vec![at(0.0, 1.0), at(5e-324, 1.0)]).is_ok(),
            "at rest"
        );
    }

    /// They led into trajectories that no file could state.
    #[test]
    fn scripts_at_no_place_are_at_the_origin() {
        let bad = [f64::NAN, f64::INFINITY, 1e308];
        for script in Script::ALL {
            for x in bad {
                for made in [
                    script.trajectory((x, 0.0), 5.0, |_, _| None),
                    script.trajectory((0.0, 0.0), x, |_, _| None),
                    script.trajectory((0.0, 0.0), 5.0, |_, _| Some(x)),
                ] {
                    assert!(Trajectory::new(made.waypoints).is_ok(), "{script}, {x}");
                }
            }
        }
    }

    #[test]
    fn each_fault_in_a_csv_is_told_with_its_line_and_value() {
        for (text, told) in [
            ("", "columns"),
            ("t,x,y\n0,1,2\n", "columns \"t,x,y\""),
            ("t,x,y,z\n", "no points"),
            ("t,x,y,z\n0,1,2\n", "line 2"),
            ("t,x,y,z\n0,1,2,fish\n", "z = \"fish\""),
            ("t,x,y,z\n0,1,NaN,3\n", "y = \"NaN\""),
            ("t,x,y,z\n0,1e300,2,3\n", "x = \"1e300\""),
            (
                "t,x,y,z\n1,0,0,0\n1,0,0,0\n",
                "line 3: t = 1 s does not come after t = 1 s",
            ),
            ("t,x,y,z\n-1,0,0,0\n", "t = -1 s"),
            ("t,x,y,z,finger\n0,0,0,0,1.5\n", "finger = 1.5"),
            ("t,x,y,z,finger\n0,0,0,0,900\n", "finger = 900"),
            (
                "t,x,y,z,finger\n0,0,0,0,1\n",
                "finger 0: the trajectory has no points",
            ),
        ] {
            let error = Trajectory::parse_csv(text, "a.csv")
                .expect_err(text)
                .to_string();
            assert!(
                error.starts_with("a.csv") && error.contains(told),
                "{text:?} gave {error:?}"
            );
            assert!(!error.contains('\n'));
        }
    }

    #[test]
    fn every_script_starts_and_ends_above_the_skin_and_reaches_its_depth() {
        for script in Script::ALL {
            let trajectory = script.trajectory((0.0, 200.0), 6.0, |_, _| Some(100.0));
            let z = |t: f64| trajectory.at(t).0.z;
            assert!(z(0.0) > 115.0 && z(script.duration_s()) > 115.0, "{script}");
            let lowest = (0..6000)
                .map(|ms| z(f64::from(ms) / 1000.0))
                .fold(f64::INFINITY, f64::min);
            assert!(
                (lowest - 94.0).abs() < 0.5,
                "{script} went down to {lowest}"
            );
        }
    }

    #[test]
    fn scripts_know_their_own_names() {
        for script in Script::ALL {
            assert_eq!(Script::by_name(script.name()), Some(script));
        }
        assert_eq!(Script::by_name("dance"), None);
    }

    proptest! {
        #[test]
        fn any_text_is_parsed_or_refused_in_one_line(text in "(t,x,y,z(,finger)?\n)?([-0-9.,eEinfNaN\n]{0,60})") {
            if let Err(e) = Trajectory::parse_csv(&text, "a.csv") {
                prop_assert!(!e.to_string().contains('\n'));
            }
        }
    }
}
