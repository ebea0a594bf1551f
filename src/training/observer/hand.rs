//! How a simulated observer comes to feel a place: by pressing it, or by reading the map.

use crate::contact::Touch;
use crate::device::{MAX_FINGERS, Reading as DeviceReading};
use crate::geom::{Vec2, Vec3};
use crate::scenario::{self, Scenario, Scene, Use};
use crate::servo::{self, Limits, Rig, TickInput, TickRecord};
use crate::training::run::TrainingError;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a palpation came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Felt {
    /// Of each place, the logarithm of its stiffness over what it is where nothing is hidden.
    pub log_ratios: Vec<f64>,
    /// How long it took, s.
    pub seconds: f64,
}

/// A way to feel places.
pub trait Hand {
    /// Feels the places of a trial's scenario in their order; `told` gets each tick with its time step, s.
    ///
    /// # Errors
    /// The scene cannot be built, or a place cannot be felt.
    fn feel(
        &mut self,
        scenario: &Arc<Scenario>,
        places: &[Vec2],
        told: &mut dyn FnMut(&TickRecord, f64),
    ) -> Result<Felt, TrainingError>;
}

/// Reads the stiffness map: fast, and exact.
#[derive(Debug)]
pub struct Reading {
    blind: Arc<Scenario>,
}

/// How long one place takes the reading hand, s.
const READ_S: f64 = 0.5;

impl Reading {
    /// Compares with the scenario in which nothing is hidden.
    pub fn new(blind: Arc<Scenario>) -> Self {
        Self { blind }
    }
}

impl Hand for Reading {
    fn feel(
        &mut self,
        scenario: &Arc<Scenario>,
        places: &[Vec2],
        _: &mut dyn FnMut(&TickRecord, f64),
    ) -> Result<Felt, TrainingError> {
        let map = |s: &Scenario| s.stiffness_map().map_err(|e| TrainingError(e.to_string()));
        let (usual, now) = (map(&self.blind)?, map(scenario)?);
        let ratio = |at: &Vec2| libm::log(now.at(*at) / usual.at(*at));
        Ok(Felt {
            log_ratios: places.iter().map(ratio).collect(),
            seconds: READ_S * places.len() as f64,
        })
    }
}

/// Presses each place by a fixed policy, through the servo's own tick: down to a depth, a hold, up, on to the next. What it
/// takes of a place is the mean of force over depth while it holds.
pub struct Pressing {
    blind: Scene,
    /// What places feel like where nothing is hidden, by the bits of their coordinates.
    usual: BTreeMap<[u64; 2], f64>,
}

/// Time step, s.
const DT_S: f64 = 0.001;
/// How deep it presses, mm.
const DEPTH_MM: f64 = 3.0;
/// Ticks on the way down and up, held, and from one place to the next.
const RAMP: u32 = 80;
const HOLD: u32 = 60;
const TRAVEL: u32 = 100;
/// How far above the highest skin it travels, mm.
const ABOVE_MM: f64 = 10.0;

impl std::fmt::Debug for Pressing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pressing").finish_non_exhaustive()
    }
}

fn purpose() -> Use {
    Use {
        fingers: 1,
        ..Use::default()
    }
}

impl Pressing {
    /// Builds the scene in which nothing is hidden.
    ///
    /// # Errors
    /// It cannot be built.
    pub fn new(blind: Arc<Scenario>) -> Result<Self, TrainingError> {
        let blind = scenario::build(blind, purpose(), &mut |_, _| true);
        Ok(Self {
            blind: blind.map_err(|e| TrainingError(e.to_string()))?,
            usual: BTreeMap::new(),
        })
    }

    /// The scene in which nothing is hidden.
    pub fn scene(&self) -> &Scene {
        &self.blind
    }
}

impl Hand for Pressing {
    fn feel(
        &mut self,
        scenario: &Arc<Scenario>,
        places: &[Vec2],
        told: &mut dyn FnMut(&TickRecord, f64),
    ) -> Result<Felt, TrainingError> {
        // What is hidden changes maps; where it changes more, all is built anew.
        let scene = scenario::rebuild(&self.blind, Arc::clone(scenario), purpose())
            .or_else(|_| scenario::build(Arc::clone(scenario), purpose(), &mut |_, _| true))
            .map_err(|e| TrainingError(e.to_string()))?;
        let mut rig = rig_of(&scene);
        let mut still = rig_of(&self.blind);
        let mut log_ratios = Vec::with_capacity(places.len());
        let mut ticks = 0;
        for &place in places {
            let mut count = |tick: &TickRecord| {
                ticks += 1;
                told(tick, DT_S);
            };
            let felt = press(&scene, &mut rig, place, &mut count)?;
            let key = place.to_array().map(f64::to_bits);
            let usual = match self.usual.get(&key) {
                Some(usual) => *usual,
                None => {
                    let usual = press(&self.blind, &mut still, place, &mut |_| {})?;
                    self.usual.insert(key, usual);
                    usual
                }
            };
            log_ratios.push(libm::log(felt / usual));
        }
        Ok(Felt {
            log_ratios,
            seconds: f64::from(ticks) * DT_S,
        })
    }
}

fn rig_of(scene: &Scene) -> Rig {
    Rig::new(
        Box::new(scene.touch.clone()),
        [Limits::default(); MAX_FINGERS],
    )
}

/// Presses one place and gives back what it feels like, N/mm.
fn press(
    scene: &Scene,
    rig: &mut Rig,
    place: Vec2,
    told: &mut dyn FnMut(&TickRecord),
) -> Result<f64, TrainingError> {
    let skin_mm = scene.height_mm(place.x, place.y).ok_or_else(|| {
        let what = "is beside the skin and cannot be pressed";
        TrainingError(format!("({:.1}, {:.1}) mm {what}", place.x, place.y))
    })?;
    let above_mm = scene.surface.bounds().max.z + ABOVE_MM;
    let (mut sum, mut n) = (0.0, 0.0);
    let mut last = Vec3::new(place.x, place.y, above_mm);
    let total = TRAVEL + 2 * RAMP + HOLD;
    for i in 0..total {
        let down = |share: f64| skin_mm + 1.0 - share * (1.0 + DEPTH_MM);
        let z = if i < TRAVEL {
            above_mm + (skin_mm + 1.0 - above_mm) * f64::from(i) / f64::from(TRAVEL)
        } else if i < TRAVEL + RAMP {
            down(f64::from(i - TRAVEL) / f64::from(RAMP))
        } else if i < TRAVEL + RAMP + HOLD {
            down(1.0)
        } else {
            down(1.0 - f64::from(i - TRAVEL - RAMP - HOLD) / f64::from(RAMP))
        };
        let position_mm = Vec3::new(place.x, place.y, z);
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        // A finger that is lifted goes on elsewhere: its proxy is placed anew there.
        input.place_anew[0] = i == 0;
        input.readings[0] = DeviceReading {
            position_mm,
            velocity_mm_s: (position_mm - last) / DT_S,
            connected: true,
            ..DeviceReading::default()
        };
        last = position_mm;
        let tick = servo::tick(rig, &input, DT_S);
        told(&tick);
        let contact = &tick.fingers[0].contact;
        let holds = (TRAVEL + RAMP + HOLD / 2..TRAVEL + RAMP + HOLD).contains(&i);
        if holds && contact.touch != Touch::Free && contact.depth_mm > 0.0 {
            sum += contact.force_n.length() / contact.depth_mm;
            n += 1.0;
        }
    }
    if n > 0.0 && sum > 0.0 {
        return Ok(sum / n);
    }
    let what = "gives no force when it is pressed";
    Err(TrainingError(format!(
        "({:.1}, {:.1}) mm {what}",
        place.x, place.y
    )))
}
