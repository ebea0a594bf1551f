//! The running servo with its mouse fingers, and the near ends of its lines.

use crate::app::history::History;
use crate::contact::TouchScene;
use crate::device::Device;
use crate::device::mouse::{Hand, Mouse, MouseHandle};
use crate::geom::Vec3;
use crate::scenario::Scene;
use crate::servo::{
    self, Fault, FingerRecord, Health, Limits, Lines, MAX_FINGERS, Retired, Rig, Servo,
    ServoConfig, Snapshot,
};
use crate::session::recorder::{RecorderHandle, RecorderThread, Tap};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// Fingers of the bench: left and right.
pub const FINGERS: usize = 2;
/// Where fingers rest: this far above the highest point of the skin, mm.
const CLEARANCE_MM: f64 = 40.0;
/// And this far to the left and right of the middle, mm.
const APART_MM: f64 = 60.0;

/// The servo, felt through mouse fingers.
pub struct Live {
    servo: Servo,
    newest: triple_buffer::Output<Snapshot>,
    retired: rtrb::Consumer<Retired>,
    commands: rtrb::Producer<servo::Command>,
    recorder: Arc<RecorderHandle>,
    history: Arc<Mutex<History>>,
    plotted: Arc<AtomicBool>,
    felt: Felt,
    hands: Vec<MouseHandle>,
    names: Vec<String>,
    limits: Limits,
    config: ServoConfig,
    snapshot: Snapshot,
    /// Commands that found the line full, to be sent again.
    waiting: Vec<servo::Command>,
}

/// Where the fingers rest over a scene, mm.
fn rest_mm(scene: &Scene, finger: usize) -> Vec3 {
    let bounds = scene.surface.bounds();
    let middle = (bounds.min + bounds.max) * 0.5;
    let side = if finger.is_multiple_of(2) { -1.0 } else { 1.0 };
    Vec3::new(
        middle.x + side * APART_MM,
        middle.y,
        bounds.max.z + CLEARANCE_MM,
    )
}

/// Most records that wait for a plot that is being drawn: half a minute of two fingers.
const WAITING: usize = 1 << 16;

/// What was felt since it was last taken; `None` while nobody wants to know.
type Felt = Arc<Mutex<Option<Vec<FingerRecord>>>>;

/// Feeds every tick into `history` while someone plots; waits for nobody: while a plot reads, ticks queue up here. And into
/// `felt`, whose lock is held for a copy only.
fn tap_into(history: Arc<Mutex<History>>, plotted: Arc<AtomicBool>, felt: Felt) -> Tap {
    let mut waiting: Vec<FingerRecord> = Vec::new();
    Box::new(move |records| {
        if let Some(felt) = felt.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            let room = WAITING - felt.len().min(WAITING);
            felt.extend(records.iter().take(room));
        }
        if !plotted.load(Ordering::Relaxed) {
            waiting = Vec::new();
            return;
        }
        let mut history = match history.try_lock() {
            Ok(history) => history,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => {
                let room = WAITING - waiting.len().min(WAITING);
                waiting.extend(records.iter().take(room));
                return;
            }
        };
        for record in waiting.drain(..) {
            history.push(&record);
        }
        for record in records {
            history.push(record);
        }
    })
}

impl Live {
    /// Starts the servo on `scene`.
    ///
    /// # Errors
    /// When the system refuses another thread.
    pub fn start(scene: &Scene, force_enabled: bool) -> std::io::Result<Self> {
        let limits = Limits::default();
        let mut devices: Vec<Box<dyn Device>> = Vec::new();
        let mut hands = Vec::new();
        let mut names = Vec::new();
        for finger in 0..FINGERS {
            let (mouse, hand) = Mouse::new(rest_mm(scene, finger), Hand::default());
            names.push(mouse.capabilities().name.clone());
            devices.push(Box::new(mouse));
            hands.push(hand);
        }
        let rig = Rig::new(Box::new(scene.touch.clone()), [limits; MAX_FINGERS]);
        let config = ServoConfig {
            force_enabled,
            ..ServoConfig::default()
        };
        let (servo, lines) = servo::start(config, rig, devices)?;
        let Lines {
            snapshot: newest,
            records,
            retired,
            commands,
        } = lines;
        let history = Arc::new(Mutex::new(History::new(1.0 / config.dt_s())));
        let plotted = Arc::new(AtomicBool::new(true));
        let felt = Felt::default();
        let tap = tap_into(history.clone(), plotted.clone(), felt.clone());
        let recorder = RecorderThread::spawn(records, Some(tap))?;
        Ok(Self {
            servo,
            newest,
            retired,
            commands,
            recorder: Arc::new(recorder),
            history,
            plotted,
            felt,
            hands,
            names,
            limits,
            config,
            snapshot: Snapshot::default(),
            waiting: Vec::new(),
        })
    }

    /// Hands another scene to the servo and puts the fingers to rest over it.
    pub fn set_scene(&mut self, scene: &Scene) {
        for (finger, hand) in self.hands.iter().enumerate() {
            hand.set(rest_mm(scene, finger));
        }
        let touch: Box<TouchScene> = Box::new(scene.touch.clone());
        self.send(servo::Command::SetScene(touch));
    }

    /// Lets the servo go over to an edit of the scene; the fingers stay where they are.
    pub fn edit_scene(&mut self, number: u32, scene: &Scene) {
        let scene = Box::new(scene.touch.clone());
        self.send(servo::Command::EditScene { number, scene });
    }

    /// Switches force output.
    pub fn enable_force(&mut self, on: bool) {
        self.send(servo::Command::EnableForce(on));
    }

    /// Starts the timing statistics anew.
    pub fn reset_timing(&mut self) {
        self.send(servo::Command::ResetTiming);
    }

    fn send(&mut self, command: servo::Command) {
        self.waiting.push(command);
        self.flush();
    }

    fn flush(&mut self) {
        while !self.waiting.is_empty() {
            let command = self.waiting.remove(0);
            if let Err(rtrb::PushError::Full(command)) = self.commands.push(command) {
                self.waiting.insert(0, command);
                return;
            }
        }
    }

    /// Takes what the servo has sent, and frees what it is done with.
    pub fn poll(&mut self) {
        self.flush();
        while self.retired.pop().is_ok() {}
        self.snapshot = *self.newest.read();
        if self.servo.fault().is_some() {
            self.snapshot.health = Health::Fault;
        }
    }

    /// What is wrong with the servo.
    pub fn fault(&self) -> Option<Fault> {
        self.servo.fault()
    }

    /// The newest state.
    pub fn snapshot(&self) -> &Snapshot {
        &self.snapshot
    }

    /// The recorder at the end of the ring.
    pub fn recorder(&self) -> &Arc<RecorderHandle> {
        &self.recorder
    }

    /// Everything felt.
    pub fn history(&self) -> &Arc<Mutex<History>> {
        &self.history
    }

    /// Whether anyone plots: without, no history is kept.
    pub fn set_plotted(&self, on: bool) {
        if self.plotted.swap(on, Ordering::Relaxed) && !on {
            self.history
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
    }

    /// Whether what is felt is kept for [`Self::take_felt`].
    pub fn listen(&self, on: bool) {
        *self.felt.lock().unwrap_or_else(PoisonError::into_inner) = on.then(Vec::new);
    }

    /// What was felt since the last call, in order; nothing unless someone listens.
    pub fn take_felt(&self) -> Vec<FingerRecord> {
        let mut felt = self.felt.lock().unwrap_or_else(PoisonError::into_inner);
        felt.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// What moves the fingers.
    pub fn hands(&self) -> &[MouseHandle] {
        &self.hands
    }

    /// Names of the devices.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Bounds on the force.
    pub fn limits(&self) -> Limits {
        self.limits
    }

    /// Memory of the ring and of what drains it, bytes.
    pub fn ring_bytes(&self) -> usize {
        self.config.ring_bytes() + RecorderThread::BYTES
    }

    /// Ticks per second.
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.config.dt_s()
    }
}
