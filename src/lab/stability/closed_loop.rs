//! The closed loop: a simulated hand and device about a flat skin that the real tick renders.
//!
//! ```text
//! plant ── encoder (steps, velocity by differences) ── tick ── delay ── force held until the next ── plant
//! ```
//! Two trials tell whether a loop is stable. They differ since a skin only pushes, and theory's spring pulls as well:
//! * a **tap** comes down on the skin from outside and is pushed on: it enters, bounces and settles, or does not. This is
//!   what a hand does, and what passivity speaks of;
//! * a **press** starts at rest within the skin and is disturbed by a hair. It stays in touch, and there the loop is
//!   theory's linear one. It counts as unstable when the disturbance grows, whatever becomes of it.

use super::plant::{Plant, State};
use crate::contact::{Stiffness, TouchScene};
use crate::device::Reading;
use crate::geom::Vec3;
use crate::lab::LabError;
use crate::partition::bvh::Bvh;
use crate::servo::{Limits, Rig, StiffnessBound, TickInput, tick};
use crate::surface::Surface;
use crate::surface::primitives::height_field;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A loop: what moves, what it touches and what lies between.
#[derive(Clone, Copy, Debug)]
pub struct Loop {
    /// Hand and device.
    pub plant: Plant,
    /// Stiffness of the skin, N/mm.
    pub stiffness_n_per_mm: f64,
    /// Ticks per second.
    pub rate_hz: f64,
    /// Time from reading to force, ticks, whole or not; at most [`MOST_DELAY_TICKS`].
    pub delay_ticks: f64,
    /// Step of the encoder, mm; 0 without.
    pub quantum_mm: f64,
    /// Bounds of the tick on the force, and whether the passivity controller is on.
    pub limits: Limits,
}

/// Longest delay, ticks.
pub const MOST_DELAY_TICKS: f64 = 14.0;

/// No bound on the force: the linear device of theory.
pub const UNLIMITED: Limits = Limits {
    rated_force_n: f64::INFINITY,
    rise_n_per_s: f64::INFINITY,
    passivity: false,
    stiffness: StiffnessBound::AsIs,
};

/// What became of a loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// It came to rest, or was on its way there.
    #[default]
    Stable,
    /// It went on swinging.
    LimitCycle,
    /// Its swings outgrew the way it came by ten times and more.
    Unstable,
}

impl Class {
    /// All, from the best.
    pub const ALL: [Self; 3] = [Self::Stable, Self::LimitCycle, Self::Unstable];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::LimitCycle => "limit cycle",
            Self::Unstable => "unstable",
        }
    }
}

/// What a tap came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Whether it came to rest.
    pub class: Class,
    /// Half the way between highest and lowest in the last quarter, mm.
    pub amplitude_mm: f64,
    /// Swings per second there; 0 where it does not swing.
    pub frequency_hz: f64,
    /// The most that the skin had given out, net, at any time: what a passive one never does, mJ.
    pub given_mj: f64,
    /// How much deeper than the depth at rest the first touches went, as a share of it.
    pub overshoot: f64,
    /// Ticks done.
    pub ticks: u64,
    /// Ticks whose record or motion was not finite.
    pub not_finite: u64,
    /// Ticks whose force was above the limit, or pulled.
    pub over_limit: u64,
}

/// One tick of a trial, for those who want to draw it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Since the start, s.
    pub time_s: f64,
    /// Height above the skin, mm.
    pub z_mm: f64,
    /// Force sent, N.
    pub force_n: f64,
    /// What the skin had given out by then, net, mJ; below 0 it has taken up.
    pub given_mj: f64,
}

/// A tap starts so high above the skin, mm, at so many mm/s into it.
const TAP_FROM: State = State {
    z_mm: 2.0,
    v_mm_s: -100.0,
};
/// Blocks that a tap is divided into.
const BLOCKS: usize = 16;
/// Shortest and longest tap, s.
const TAP_S: [f64; 2] = [4.0, 12.0];
/// A tap lasts so many time constants of the damping, so many swings on the skin, and so many ticks, whatever is longest.
const TIME_CONSTANTS: f64 = 30.0;
const SWINGS: f64 = 64.0;
const TICKS: f64 = 4000.0;
/// Swings below this count as none, mm: what a hand on a stylus does not feel at most frequencies, and a tenth of the
/// finest encoder step here.
pub const UNFELT_MM: f64 = 1.0e-3;
/// Swings below this for a whole block end a tap.
const AT_REST_MM: f64 = 1.0e-5;
/// Swings die away that shrink from each eighth of a tap to the next over the last six, by this in all, in the logarithm, and
/// at the end as fast as this share of their mean: those that come down to a limit cycle shrink less and less. They are smaller
/// than the way from the start to the depth at rest: a loop that goes on swinging may do so without any order, now far, now
/// near, but then it leaps beyond where it came from.
const SHRUNK: f64 = 0.05;
const EVENLY: f64 = 0.6;
/// Swings count as outgrown beyond this many times the way from the start to the depth at rest.
const OUTGROWN: f64 = 10.0;
/// As far from the skin the loop counts as lost, mm.
const LOST_MM: f64 = 1000.0;
/// A press is disturbed by this share of its depth.
const DISTURBED: f64 = 1.0e-6;
/// A disturbance below this share of what it was has died away.
const DIED: f64 = 1.0e-6;
/// Where on the plate, mm: on no edge.
const AT: [f64; 2] = [7.0, -13.0];

/// A flat skin to try loops on.
#[derive(Clone, Debug)]
pub struct Bench {
    surface: Arc<Surface>,
    search: Arc<Bvh>,
}

impl Bench {
    /// A plate of two triangles at z = 0.
    ///
    /// # Errors
    /// None that is known: the plate is a surface.
    pub fn new() -> Result<Self, LabError> {
        let side = [-50.0, 50.0];
        let plate = height_field(side, side, [1, 1], 2, |_, _| 0.0);
        let (surface, _) = Surface::new(plate).map_err(|e| LabError::Input(e.to_string()))?;
        Ok(Self {
            search: Arc::new(Bvh::new(&surface)),
            surface: Arc::new(surface),
        })
    }

    /// Taps and tells what became of it.
    pub fn tap(&self, lap: &Loop) -> Outcome {
        self.tap_with(lap, |_| ())
    }

    /// As [`Bench::tap`]; `each` sees every tick.
    pub fn tap_with(&self, lap: &Loop, mut each: impl FnMut(&Moment)) -> Outcome {
        let mut run = Run::new(self, lap, TAP_FROM, 0.0);
        let n = ((lap.tap_s() * lap.rate_hz) as usize / BLOCKS).max(4);
        let mut blocks = [Block::default(); BLOCKS];
        for (i, block) in blocks.iter_mut().enumerate() {
            for _ in 0..n {
                run.step(lap);
                block.add(run.state.z_mm);
                each(&run.moment(lap));
                if run.is_lost() {
                    return run.outcome(Class::Unstable, lap, Block::default(), 0.0);
                }
            }
            if i > 0 && block.amplitude_mm() < AT_REST_MM {
                return run.outcome(Class::Stable, lap, *block, 0.0);
            }
        }
        let eighths = [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let [a, b] = [0, 1].map(|j| blocks[i * BLOCKS / 8 + j]);
            a.with(&b).amplitude_mm()
        });
        let last = blocks[BLOCKS * 3 / 4..]
            .iter()
            .fold(Block::default(), |a, b| a.with(b));
        let amplitude = last.amplitude_mm();
        let in_quarter = n * BLOCKS / 4;
        let frequency_hz = run.frequency_hz(last, in_quarter, lap.rate_hz);
        // Creeping to rest turns back nowhere.
        let swings = run.turns(in_quarter) >= 4;
        let way_mm = TAP_FROM.z_mm + lap.depth_at_rest_mm();
        let by = |from: usize| libm::log(eighths[from] / eighths[7]);
        let shrinks = eighths[2..].windows(2).all(|e| e[1] < e[0])
            && by(2) > SHRUNK
            && by(6) > EVENLY * by(2) / 5.0
            && amplitude < way_mm;
        let class = if amplitude < UNFELT_MM || !swings || shrinks {
            Class::Stable
        } else if amplitude > OUTGROWN * way_mm {
            Class::Unstable
        } else {
            Class::LimitCycle
        };
        run.outcome(class, lap, last, frequency_hz)
    }

    /// Whether a press comes to rest: a hair's disturbance within the skin dies away or at least does not grow. Also the
    /// number of ticks that it took.
    pub fn press(&self, lap: &Loop) -> (bool, u64) {
        let rest_mm = -lap.depth_at_rest_mm();
        let start = State {
            z_mm: rest_mm * (1.0 + DISTURBED),
            v_mm_s: 0.0,
        };
        let mut run = Run::new(self, lap, start, -lap.stiffness_n_per_mm * rest_mm);
        let n = ((lap.tap_s() * lap.rate_hz) as usize / 4).max(16);
        let mut quarters = [0.0_f64; 4];
        for farthest in &mut quarters {
            for _ in 0..n {
                run.step(lap);
                *farthest = farthest.max((run.state.z_mm - rest_mm).abs());
                if run.is_lost() || run.state.z_mm >= 0.0 {
                    return (false, run.ticks);
                }
            }
            if *farthest < DIED * DISTURBED * rest_mm.abs() {
                return (true, run.ticks);
            }
        }
        (quarters[3] <= quarters[2], run.ticks)
    }
}

/// What a finger feels that is moved whatever the force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Felt {
    /// Slope of the force over depth by least squares, N/mm.
    pub slope_n_per_mm: f64,
    /// Energy lost in a press, mJ; below 0 it is gained.
    pub lost_mj: f64,
    /// Largest change of the force from one tick to the next, N, beyond what the slope asks for.
    pub roughest_n: f64,
}

/// How deep a guided press goes, mm.
const GUIDED_MM: f64 = 4.0;

impl Bench {
    /// Moves a finger in and out of the skin along a cosine with this highest speed, three times at 1 kHz, and tells what the
    /// last press felt like. `controlled`: with the passivity controller.
    pub fn guided(
        &self,
        stiffness_n_per_mm: f64,
        quantum_mm: f64,
        speed_mm_s: f64,
        controlled: bool,
    ) -> Felt {
        let lap = Loop {
            plant: Plant {
                mass_kg: 1.0,
                damping_n_s_per_mm: 1.0,
                stiffness_n_per_mm: 0.0,
                push_n: 0.0,
                coulomb_n: 0.0,
            },
            stiffness_n_per_mm,
            rate_hz: 1000.0,
            delay_ticks: 0.0,
            quantum_mm,
            limits: Limits {
                passivity: controlled,
                ..UNLIMITED
            },
        };
        let above = 0.5;
        let reach = 0.5 * (GUIDED_MM + above);
        let period_s = std::f64::consts::TAU * reach / speed_mm_s;
        let n = libm::round(period_s * lap.rate_hz).max(8.0) as usize;
        let z = |i: usize| {
            let turn = std::f64::consts::TAU * i as f64 / n as f64;
            above - reach * (1.0 - libm::cos(turn))
        };
        let start = State {
            z_mm: above,
            v_mm_s: 0.0,
        };
        let mut run = Run::new(self, &lap, start, 0.0);
        let mut felt = Felt::default();
        let (mut count, mut sums) = (0.0, [0.0; 4]);
        let mut last: Option<(f64, f64)> = None;
        for i in 0..3 * n {
            let force = run.feel(&lap, lap.read(z(i)));
            if i >= 2 * n {
                // The force holds from this reading to the next.
                felt.lost_mj -= force * (z(i + 1) - z(i));
                let depth = -z(i);
                if depth > 0.0 {
                    count += 1.0;
                    let add = [depth, force, depth * depth, depth * force];
                    sums.iter_mut().zip(add).for_each(|(s, a)| *s += a);
                    if let Some((depth_before, before)) = last {
                        let asked = stiffness_n_per_mm * (depth - depth_before);
                        felt.roughest_n = felt.roughest_n.max((force - before - asked).abs());
                    }
                    last = Some((depth, force));
                } else {
                    last = None;
                }
            }
        }
        let [d, f, dd, df] = sums;
        felt.slope_n_per_mm = (count * df - d * f) / (count * dd - d * d);
        felt
    }
}

impl Loop {
    /// What the encoder says of a height, mm.
    fn read(&self, z_mm: f64) -> f64 {
        if self.quantum_mm > 0.0 {
            self.quantum_mm * libm::round(z_mm / self.quantum_mm)
        } else {
            z_mm
        }
    }

    /// Depth at rest, mm.
    pub fn depth_at_rest_mm(&self) -> f64 {
        -self.plant.push_n / (self.stiffness_n_per_mm + self.plant.stiffness_n_per_mm)
    }

    /// How long a tap lasts, s.
    fn tap_s(&self) -> f64 {
        let m = self.plant.mass_kg / 1000.0;
        let fades_s = 2.0 * m / self.plant.damping_n_s_per_mm;
        let stiffness = self.stiffness_n_per_mm + self.plant.stiffness_n_per_mm;
        let swing_s = std::f64::consts::TAU * libm::sqrt(m / stiffness);
        (TIME_CONSTANTS * fades_s)
            .max(SWINGS * swing_s)
            .clamp(TAP_S[0], TAP_S[1])
            .max(TICKS / self.rate_hz)
    }
}

/// Highest and lowest in a stretch of ticks.
#[derive(Clone, Copy, Debug)]
struct Block {
    low_mm: f64,
    high_mm: f64,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            low_mm: f64::INFINITY,
            high_mm: f64::NEG_INFINITY,
        }
    }
}

impl Block {
    fn add(&mut self, z_mm: f64) {
        self.low_mm = self.low_mm.min(z_mm);
        self.high_mm = self.high_mm.max(z_mm);
    }

    fn with(self, other: &Self) -> Self {
        Self {
            low_mm: self.low_mm.min(other.low_mm),
            high_mm: self.high_mm.max(other.high_mm),
        }
    }

    fn amplitude_mm(&self) -> f64 {
        if self.high_mm >= self.low_mm {
            0.5 * (self.high_mm - self.low_mm)
        } else {
            0.0
        }
    }
}

/// Forces that wait or hold; those of [`MOST_DELAY_TICKS`] fit.
const QUEUE: usize = 16;

/// A trial on its way.
struct Run {
    rig: Rig,
    state: State,
    /// The stretches of a tick before and after the force of this reading, or one of a few ticks ago, takes over.
    before: super::plant::Stretch,
    after: super::plant::Stretch,
    whole: usize,
    /// Forces by tick, the newest at `ticks % QUEUE`.
    forces: [f64; QUEUE],
    last_read_mm: Option<f64>,
    ticks: u64,
    given_mj: f64,
    most_given_mj: f64,
    deepest_mm: f64,
    not_finite: u64,
    over_limit: u64,
    /// Heights of the last ticks, for the count of swings.
    trace: Vec<f64>,
}

impl Run {
    /// Starts at `state` under a force that has been held for long. Within the skin the proxy is placed above it first, as
    /// that of a finger that came from there.
    fn new(bench: &Bench, lap: &Loop, state: State, held_n: f64) -> Self {
        let scene = TouchScene::new(
            Arc::clone(&bench.surface),
            Arc::clone(&bench.search),
            Stiffness::Uniform(lap.stiffness_n_per_mm),
        );
        let delay = lap.delay_ticks.clamp(0.0, MOST_DELAY_TICKS);
        let whole = libm::floor(delay);
        let dt_s = 1.0 / lap.rate_hz;
        let mut limits = [Limits::default(); crate::device::MAX_FINGERS];
        limits[0] = lap.limits;
        let mut run = Self {
            rig: Rig::new(Box::new(scene), limits),
            state,
            before: lap.plant.stretch((delay - whole) * dt_s),
            after: lap.plant.stretch((1.0 - (delay - whole)) * dt_s),
            whole: whole as usize,
            forces: [held_n; QUEUE],
            last_read_mm: None,
            ticks: 0,
            given_mj: 0.0,
            most_given_mj: 0.0,
            deepest_mm: 0.0,
            not_finite: 0,
            over_limit: 0,
            trace: Vec::new(),
        };
        if state.z_mm < 0.0 {
            run.feel(lap, 1.0e-3);
            run.last_read_mm = Some(state.z_mm);
        }
        run
    }

    /// One tick of the servo at a height; returns the force sent, N.
    fn feel(&mut self, lap: &Loop, z_mm: f64) -> f64 {
        let dt_s = 1.0 / lap.rate_hz;
        let velocity = (z_mm - self.last_read_mm.unwrap_or(z_mm)) / dt_s;
        self.last_read_mm = Some(z_mm);
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        input.readings[0] = Reading {
            position_mm: Vec3::new(AT[0], AT[1], z_mm),
            velocity_mm_s: Vec3::new(0.0, 0.0, velocity),
            buttons: 0,
            connected: true,
        };
        let out = tick(&mut self.rig, &input, dt_s);
        let sent = out.fingers[0].sent_force_n;
        let finite = sent.is_finite() && out.fingers[0].contact.force_n.is_finite();
        self.not_finite += u64::from(!finite);
        let most = lap.limits.rated_force_n * (1.0 + 1e-12);
        // A skin that pulls is as wrong as one that is too strong.
        self.over_limit += u64::from(sent.length() > most || sent.z < 0.0);
        sent.z
    }

    /// From one reading to the next.
    fn step(&mut self, lap: &Loop) {
        let now = self.ticks as usize;
        self.forces[now % QUEUE] = self.feel(lap, lap.read(self.state.z_mm));
        let sent = |back: usize| self.forces[(now + QUEUE - back) % QUEUE];
        for (stretch, force_n) in [
            (self.before, sent(self.whole + 1)),
            (self.after, sent(self.whole)),
        ] {
            let from = self.state.z_mm;
            self.state = lap.plant.advance(&stretch, self.state, force_n);
            self.given_mj += force_n * (self.state.z_mm - from);
            self.most_given_mj = self.most_given_mj.max(self.given_mj);
        }
        self.deepest_mm = self.deepest_mm.max(-self.state.z_mm);
        self.not_finite += u64::from(!self.state.z_mm.is_finite());
        self.trace.push(self.state.z_mm);
        self.ticks += 1;
    }

    fn is_lost(&self) -> bool {
        !self.state.z_mm.is_finite() || self.state.z_mm.abs() > LOST_MM
    }

    fn moment(&self, lap: &Loop) -> Moment {
        Moment {
            time_s: self.ticks as f64 / lap.rate_hz,
            z_mm: self.state.z_mm,
            force_n: self.forces[(self.ticks as usize + QUEUE - 1) % QUEUE],
            given_mj: self.given_mj,
        }
    }

    /// How often the last quarter crossed the middle of `block` upward, per second. It counts from half the amplitude below
    /// to half above, so that a step of the encoder is no swing.
    fn frequency_hz(&self, block: Block, n: usize, rate_hz: f64) -> f64 {
        let middle = 0.5 * (block.low_mm + block.high_mm);
        let beyond = 0.5 * block.amplitude_mm();
        let (mut below, mut crossed) = (false, 0_u32);
        for z in &self.trace[self.trace.len().saturating_sub(n)..] {
            if *z < middle - beyond {
                below = true;
            } else if below && *z > middle + beyond {
                below = false;
                crossed += 1;
            }
        }
        f64::from(crossed) * rate_hz / n as f64
    }

    /// How often the height turned back within the last `n` ticks.
    fn turns(&self, n: usize) -> usize {
        let last = &self.trace[self.trace.len().saturating_sub(n)..];
        let back = |w: &&[f64]| (w[1] - w[0]) * (w[2] - w[1]) < 0.0;
        last.windows(3).filter(back).count()
    }

    fn outcome(&self, class: Class, lap: &Loop, last: Block, frequency_hz: f64) -> Outcome {
        Outcome {
            class,
            amplitude_mm: last.amplitude_mm(),
            frequency_hz,
            given_mj: self.most_given_mj,
            overshoot: (self.deepest_mm / lap.depth_at_rest_mm() - 1.0).max(0.0),
            ticks: self.ticks,
            not_finite: self.not_finite,
            over_limit: self.over_limit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::stability::plant::Hand;
    use crate::lab::stability::theory::{LinearLoop, passive_stiffness_n_per_mm};

    /// A device by itself, or in a hand, pushed by about a newton.
    fn lap(hand: Hand, k: f64) -> Loop {
        let device = (0.075, 0.002);
        let push_n = if hand == Hand::NONE {
            -1.0
        } else {
            -5.0 * hand.stiffness_n_per_mm
        };
        Loop {
            plant: Plant {
                mass_kg: device.0 + hand.mass_kg,
                damping_n_s_per_mm: device.1 + hand.damping_n_s_per_mm,
                stiffness_n_per_mm: hand.stiffness_n_per_mm,
                push_n,
                coulomb_n: 0.0,
            },
            stiffness_n_per_mm: k,
            rate_hz: 1000.0,
            delay_ticks: 0.0,
            quantum_mm: 0.0,
            limits: UNLIMITED,
        }
    }

    fn bench() -> Bench {
        Bench::new().expect("a plate")
    }

    #[test]
    fn a_press_is_stable_exactly_where_the_linear_loop_is() {
        let bench = bench();
        for hand in [Hand::NONE, Hand::middle()] {
            for delay_ticks in [0.0, 0.4, 1.0, 2.5] {
                let at = |k: f64| Loop {
                    delay_ticks,
                    ..lap(hand, k)
                };
                let plant = at(1.0).plant;
                let limit =
                    LinearLoop::new(&plant, 1e-3, delay_ticks).stable_stiffness_n_per_mm(0.1);
                assert!(
                    bench.press(&at(0.99 * limit)).0,
                    "{hand:?} {delay_ticks} {limit}"
                );
                assert!(
                    !bench.press(&at(1.01 * limit)).0,
                    "{hand:?} {delay_ticks} {limit}"
                );
            }
        }
    }

    #[test]
    fn a_passive_wall_lets_a_tap_rest_and_one_beyond_both_limits_does_not() {
        let bench = bench();
        let passive = passive_stiffness_n_per_mm(0.002, 1e-3, 0.0, 0.0);
        let quiet = bench.tap(&lap(Hand::NONE, 0.9 * passive));
        assert_eq!(quiet.class, Class::Stable, "{quiet:?}");
        let wild = bench.tap(&lap(Hand::NONE, 2.0 * passive));
        assert_eq!(wild.class, Class::LimitCycle, "{wild:?}");
        assert!(
            wild.given_mj > 10.0 * quiet.given_mj && wild.amplitude_mm > 0.5,
            "{wild:?} {quiet:?}"
        );
        assert!(
            // Half a swing on the skin, 52 Hz, the rest in the air.
            wild.frequency_hz > 20.0 && wild.frequency_hz < 52.0,
            "{wild:?}"
        );
        let coarse = Loop {
            rate_hz: 100.0,
            ..lap(Hand::NONE, 40.0)
        };
        assert_eq!(bench.tap(&coarse).class, Class::Unstable);
    }

    #[test]
    fn a_soft_wall_read_fast_gives_out_nothing_and_overshoots_as_a_spring_does() {
        let soft = Loop {
            rate_hz: 10_000.0,
            ..lap(Hand::NONE, 0.2)
        };
        let outcome = bench().tap(&soft);
        assert_eq!(outcome.class, Class::Stable);
        assert!(outcome.given_mj < 1e-6, "{outcome:?}");
        // The same mass on a spring that is there all the time, in short stretches.
        let off = soft.plant;
        let on = Plant {
            stiffness_n_per_mm: 0.2,
            ..off
        };
        let [in_air, within] = [off, on].map(|p| p.stretch(1e-6));
        let (mut state, mut deepest) = (TAP_FROM, 0.0_f64);
        for _ in 0..200_000 {
            state = if state.z_mm > 0.0 {
                off.advance(&in_air, state, 0.0)
            } else {
                on.advance(&within, state, 0.0)
            };
            deepest = deepest.max(-state.z_mm);
        }
        let wanted = deepest / soft.depth_at_rest_mm() - 1.0;
        assert!(
            (outcome.overshoot / wanted - 1.0).abs() < 0.01,
            "{outcome:?} {wanted}"
        );
    }

    #[test]
    fn steps_of_the_encoder_keep_a_frictionless_wall_awake_and_friction_lets_it_sleep() {
        let awake = Loop {
            quantum_mm: 0.05,
            ..lap(Hand::NONE, 3.0)
        };
        let asleep = Loop {
            plant: Plant {
                coulomb_n: 0.15,
                ..awake.plant
            },
            ..awake
        };
        let bench = bench();
        assert_eq!(
            bench.tap(&awake).class,
            Class::LimitCycle,
            "{:?}",
            bench.tap(&awake)
        );
        assert_eq!(
            bench.tap(&asleep).class,
            Class::Stable,
            "{:?}",
            bench.tap(&asleep)
        );
    }

    #[test]
    fn forces_stay_below_the_limit_of_the_device() {
        let limits = Limits {
            rated_force_n: 3.0,
            rise_n_per_s: 600.0,
            ..Limits::default()
        };
        let hard = Loop {
            limits,
            ..lap(Hand::middle(), 500.0)
        };
        let mut most = 0.0_f64;
        let outcome = bench().tap_with(&hard, |m| most = most.max(m.force_n));
        assert_eq!((outcome.over_limit, outcome.not_finite), (0, 0));
        assert!(most > 2.9 && most <= 3.0 * (1.0 + 1e-12), "{most}");
        assert_ne!(outcome.class, Class::Stable);
    }
}
