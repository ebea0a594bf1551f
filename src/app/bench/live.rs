//! The running servo with its fingers, and the near ends of its lines.

use crate::app::history::History;
use crate::contact::TouchScene;
use crate::device::Device;
use crate::device::mouse::{Hand, Mouse, MouseHandle};
use crate::device::place::Place;
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

/// What moves a finger.
enum Mover {
    Mouse(MouseHandle),
    /// A device, seated over the skin; `None` where it is seated by its device file.
    Device(Option<Seat>),
}

/// Where a device sits.
pub struct Seat {
    /// The middle of its workspace, mm.
    pub place: Place,
    /// How far above the skin that is, mm.
    pub above_mm: f64,
}

impl Seat {
    /// Sits over `scene`.
    pub fn over(&self, scene: &Scene, finger: usize) {
        self.place.set(self.over_mm(scene, finger));
    }

    fn over_mm(&self, scene: &Scene, finger: usize) -> Vec3 {
        let rest = rest_mm(scene, finger);
        let skin_mm = scene.height_mm(rest.x, rest.y).unwrap_or(rest.z);
        Vec3::new(rest.x, rest.y, skin_mm + self.above_mm)
    }
}

/// One finger.
struct Finger {
    mover: Mover,
    name: String,
    limits: Limits,
}

/// The servo, felt through fingers that the mouse or devices move.
pub struct Live {
    servo: Servo,
    newest: triple_buffer::Output<Snapshot>,
    retired: rtrb::Consumer<Retired>,
    commands: rtrb::Producer<servo::Command>,
    recorder: Arc<RecorderHandle>,
    history: Arc<Mutex<History>>,
    plotted: Arc<AtomicBool>,
    felt: Felt,
    fingers: Vec<Finger>,
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

/// A finger of the mouse, at rest.
fn by_mouse(scene: &Scene, finger: usize) -> (Mouse, Finger) {
    let (mouse, hand) = Mouse::new(rest_mm(scene, finger), Hand::default());
    let finger = Finger {
        name: mouse.capabilities().name.clone(),
        mover: Mover::Mouse(hand),
        limits: Limits::default(),
    };
    (mouse, finger)
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
        let mut devices: Vec<Box<dyn Device>> = Vec::new();
        let mut fingers = Vec::new();
        for finger in 0..FINGERS {
            let (mouse, moved) = by_mouse(scene, finger);
            devices.push(Box::new(mouse));
            fingers.push(moved);
        }
        let limits = [Limits::default(); MAX_FINGERS];
        let rig = Rig::new(Box::new(scene.touch.clone()), limits);
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
            fingers,
            config,
            snapshot: Snapshot::default(),
            waiting: Vec::new(),
        })
    }

    /// Hands another scene to the servo and puts the fingers to rest over it.
    pub fn set_scene(&mut self, scene: &Scene) {
        for (i, finger) in self.fingers.iter().enumerate() {
            match &finger.mover {
                Mover::Mouse(hand) => hand.set(rest_mm(scene, i)),
                Mover::Device(Some(seat)) => seat.over(scene, i),
                Mover::Device(None) => {}
            }
        }
        let touch: Box<TouchScene> = Box::new(scene.touch.clone());
        self.send(servo::Command::SetScene(touch));
    }

    /// Has a finger moved by a device from now on; `limits` bound its force.
    pub fn use_device(
        &mut self,
        finger: usize,
        device: Box<dyn Device>,
        seat: Option<Seat>,
        limits: Limits,
    ) {
        let Some(slot) = self.fingers.get_mut(finger) else {
            return;
        };
        *slot = Finger {
            mover: Mover::Device(seat),
            name: device.capabilities().name.clone(),
            limits,
        };
        // Bounds before the device: it is never bounded by those of another.
        self.send(servo::Command::SetLimits(finger, limits));
        self.send(servo::Command::SetDevice(finger, device));
    }

    /// Has a finger moved by the mouse from now on, at rest over `scene`.
    pub fn use_mouse(&mut self, finger: usize, scene: &Scene) {
        let Some(slot) = self.fingers.get_mut(finger) else {
            return;
        };
        let (mouse, moved) = by_mouse(scene, finger);
        let limits = moved.limits;
        *slot = moved;
        self.send(servo::Command::SetDevice(finger, Box::new(mouse)));
        self.send(servo::Command::SetLimits(finger, limits));
    }

    /// Bounds the force on a finger otherwise.
    pub fn set_limits(&mut self, finger: usize, limits: Limits) {
        let changed = self.fingers.get_mut(finger).filter(|f| f.limits != limits);
        if let Some(slot) = changed {
            slot.limits = limits;
            self.send(servo::Command::SetLimits(finger, limits));
        }
    }

    /// Has the device of a finger sit so that it is now where it rests over `scene`; whether it could.
    pub fn recentre(&mut self, finger: usize, scene: &Scene) -> bool {
        let Some(Mover::Device(Some(seat))) = self.fingers.get(finger).map(|f| &f.mover) else {
            return false;
        };
        let shown = self.snapshot.record.fingers().get(finger);
        let Some(reading) = shown.map(|r| r.reading).filter(|r| r.is_usable()) else {
            return false;
        };
        let moved_mm = reading.position_mm - seat.place.get();
        // In one step: the servo may look in between.
        seat.place.set(seat.over_mm(scene, finger) - moved_mm);
        true
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
        while let Ok(retired) = self.retired.pop() {
            if let Retired::Device(mut device) = retired {
                device.close();
            }
        }
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

    /// What moves those fingers that the mouse moves.
    pub fn hands(&self) -> impl Iterator<Item = &MouseHandle> {
        self.fingers.iter().filter_map(|f| match &f.mover {
            Mover::Mouse(hand) => Some(hand),
            Mover::Device(_) => None,
        })
    }

    /// Names of the devices and bounds on their force, finger by finger.
    pub fn devices(&self) -> impl Iterator<Item = (&str, &Limits)> {
        self.fingers.iter().map(|f| (f.name.as_str(), &f.limits))
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
