//! One scene, used in one way, as it is counted in a process of its own: nothing else runs there.

use super::heap::{Heap, calls, grown};
use super::slider::Slider;
use crate::contact::{Contact, Friction, Stiffness, Touch, TouchScene};
use crate::deform::models::fsmd::Fsmd;
use crate::deform::{Displacement, Model as _};
use crate::device::scripted::Script;
use crate::device::{Device, Reading};
use crate::geom::Vec3;
use crate::lab::Samples;
use crate::partition::bvh::Bvh;
use crate::scenario::{self, Item, LedgerRow, Scenario, Scene, Use};
use crate::servo::{self, FingerRecord, Limits, MAX_FINGERS, Rig, ServoConfig, TickInput, tick};
use crate::session::writer::{IfExists, SessionWriter};
use crate::session::{self, DeviceInfo, Header, MeshSource};
use crate::surface::{RawMesh, Surface};
use serde::{Deserialize, Serialize};
use std::hint::black_box;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Ticks of the press: four seconds at 1 kHz.
const TICKS: usize = 4000;
const DT_S: f64 = 0.001;
/// The part of the press in which the finger is in touch: there instructions are counted.
const HELD: Range<f64> = 0.2..0.8;
/// A window draws about one frame in as many ticks.
const TICKS_PER_FRAME: usize = 16;
/// Ticks or records whose time is taken at once: the clock would be the dearer part of a single one.
const TIMED: usize = 100;
/// The recorder hands on what it has four times a second: so many records of one finger.
const RECORDS_PER_CHUNK: u64 = 250;
/// Scenes handed to a running servo, and the time between two.
const EDITS: u32 = 5;
const SETTLED: Duration = Duration::from_millis(100);
/// How deep the finger presses, mm.
const DEPTH_MM: f64 = 5.0;
/// How far above the skin a finger is that touches nothing, mm.
const ALOFT_MM: f64 = 300.0;

/// What is done again and again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Of {
    /// Ticks of the servo.
    Tick,
    /// Frames of the deformation.
    Frame,
    /// Records written to a session.
    Record,
    /// A servo thread that takes edits and another scene: its heap only.
    Servo,
}

impl Of {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tick => "tick",
            Self::Frame => "frame",
            Self::Record => "record",
            Self::Servo => "servo",
        }
    }
}

/// What the finger does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Finger {
    /// Hangs in the air.
    Aloft,
    /// Presses and slides.
    Slides,
    /// Presses without pulling at the skin; of frames only.
    Straight,
}

/// What is counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// The scenario.
    pub scenario: String,
    /// Whether the drawn skin is deformed.
    pub deformed: bool,
    /// What is done.
    pub of: Of,
    /// What the finger does.
    pub finger: Finger,
    /// How many times ticks, frames or records are counted, spread over the press; none: the heap only.
    pub windows: usize,
    /// How many at a time.
    pub per_window: usize,
    /// Instructions after which no more are counted: stepping is slow.
    pub most_steps: u64,
}

/// What one case holds and does, but for its instructions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// Bytes of the parsed scenario.
    pub scenario: Option<i64>,
    /// Bytes that building the scene added, but for the words of its ledger.
    pub scene: Option<i64>,
    /// Allocations and frees while it was built.
    pub build_calls: Option<u64>,
    /// Bytes of the surface alone.
    pub surface: Option<i64>,
    /// Bytes of the search structure alone.
    pub search: Option<i64>,
    /// Bytes that a rig, a deformation or a writer adds before it is used.
    pub unused: Option<i64>,
    /// The same after use.
    pub used: Option<i64>,
    /// Allocations and frees while it was used again.
    pub use_calls: Option<u64>,
    /// Median time of one tick, frame or record, µs.
    pub time_us: f64,
    /// Share of ticks, frames or records in which the finger touched.
    pub touching: f64,
    /// The ledger after all that: item, whether built, bytes.
    pub ledger: Vec<(String, bool, usize)>,
    /// Why instructions are not counted, where they are not.
    pub refused: Option<String>,
}

impl Counts {
    /// Bytes that the ledger tells of an item.
    pub fn told(&self, item: Item) -> usize {
        let row = self.ledger.iter().find(|(name, ..)| name == item.name());
        row.map_or(0, |&(_, _, bytes)| bytes)
    }

    /// The same without what only a process of its own can count, since others allocate beside; and why there was none.
    pub fn uncounted(self, why: String) -> Self {
        Self {
            refused: Some(why),
            scenario: None,
            scene: None,
            build_calls: None,
            surface: None,
            search: None,
            unused: None,
            used: None,
            use_calls: None,
            ..self
        }
    }

    /// Bytes held beside the parsed scenario: the scene, and what uses it.
    pub fn held(&self) -> Option<i64> {
        Some(self.scene? + self.used.unwrap_or(0))
    }

    /// Bytes that the ledger tells in all.
    pub fn told_in_all(&self) -> usize {
        self.ledger.iter().map(|&(_, _, bytes)| bytes).sum()
    }
}

impl Case {
    /// Does it, and calls `mark` at the beginning and the end of: nothing, the questions whether a part is there, and each
    /// window.
    ///
    /// # Errors
    /// The scenario is refused.
    pub fn run(&self, mark: &mut dyn FnMut()) -> Result<Counts, String> {
        let purpose = Use {
            fingers: 1,
            deformed: self.deformed,
            recorded: self.of == Of::Record,
            ..Use::default()
        };
        let start = Heap::now();
        let scenario = Scenario::parse(&self.scenario, "case", None).map_err(|e| e.0)?;
        let scenario = Arc::new(scenario);
        let parsed = Heap::now();
        let mut scene =
            scenario::build(scenario, purpose, &mut |_, _| true).map_err(|e| e.to_string())?;
        let built = Heap::now();
        let mut ledger = std::mem::take(&mut scene.ledger);
        scene.measure(purpose, &mut ledger);
        let mut counts = Counts {
            scenario: grown(start, parsed),
            build_calls: calls(parsed, built),
            ledger: ledger.rows.iter().map(told).collect(),
            ..Counts::default()
        };
        let with_words = Heap::now();
        drop(ledger);
        let words = grown(Heap::now(), with_words);
        counts.scene = grown(parsed, built)
            .zip(words)
            .map(|(all, words)| all - words);
        alone(&scene, &mut counts)?;
        match self.of {
            Of::Tick => self.ticks(&scene, &mut counts, mark),
            Of::Frame => self.frames(&scene, &mut counts, mark),
            Of::Record => self.records(&scene, &mut counts, mark)?,
            Of::Servo => servo_thread(&scene, &mut counts).map_err(|e| e.to_string())?,
        }
        Ok(counts)
    }

    fn ticks(&self, scene: &Scene, counts: &mut Counts, mark: &mut dyn FnMut()) {
        let inputs = self.inputs(scene);
        counts.touching = touching(&felt(&scene.touch, &inputs));
        let before = Heap::now();
        let mut rig = rig(&scene.touch);
        counts.unused = grown(before, Heap::now());
        let mut step = |input: &TickInput| {
            black_box(tick(&mut rig, input, DT_S));
        };
        self.again_and_again(&inputs, &mut step, before, counts);
        self.marked(&scene.touch, &inputs, &mut step, mark);
    }

    fn frames(&self, scene: &Scene, counts: &mut Counts, mark: &mut dyn FnMut()) {
        // The same presses whatever the scene: with friction, since only that pulls at the skin.
        let touch = TouchScene {
            friction: Some(Friction {
                static_coefficient: 0.46,
                dynamic_coefficient: 0.44,
                skin_looseness: 1.0,
            }),
            ..scene.touch.clone()
        };
        let contact = |record: &FingerRecord| {
            let mut contact = record.contact;
            if self.finger == Finger::Straight {
                contact.foot_mm = contact.anchor_mm;
            }
            contact
        };
        let felt = felt(&touch, &self.inputs(scene));
        counts.touching = touching(&felt);
        let contacts: Vec<Contact> = felt.iter().step_by(TICKS_PER_FRAME).map(contact).collect();
        let before = Heap::now();
        let mut model = Fsmd::new(scene.deform.clone());
        model.prepare(&scene.surface);
        let mut skin = Displacement::at_rest(&scene.surface);
        counts.unused = grown(before, Heap::now());
        let mut frame = |contact: &Contact| {
            let press = scene.press(contact);
            model.update(&scene.surface, press.as_slice(), &mut skin);
        };
        self.again_and_again(&contacts, &mut frame, before, counts);
        self.marked(&scene.touch, &contacts, &mut frame, mark);
    }

    fn records(
        &self,
        scene: &Scene,
        counts: &mut Counts,
        mark: &mut dyn FnMut(),
    ) -> Result<(), String> {
        let records = felt(&scene.touch, &self.inputs(scene));
        counts.touching = touching(&records);
        let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
        let path = folder.path().join("counted.mcap");
        let header = header(scene);
        let before = Heap::now();
        let writer = SessionWriter::create(&path, &header, IfExists::Refuse);
        let mut writer = writer.map_err(|e| e.to_string())?;
        counts.unused = grown(before, Heap::now());
        let (mut next, mut refused) = (0, None);
        let mut write = |record: &FingerRecord| {
            let record = FingerRecord {
                tick: next,
                time_ns: next * 1_000_000,
                ..*record
            };
            next += 1;
            let mut outcome = writer.write(&record);
            if next.is_multiple_of(RECORDS_PER_CHUNK) {
                outcome = outcome.and_then(|()| writer.flush());
            }
            if let Err(e) = outcome {
                refused = Some(e.to_string());
            }
        };
        self.again_and_again(&records, &mut write, before, counts);
        self.marked(&scene.touch, &records, &mut write, mark);
        let row = counts.ledger.iter_mut();
        for (_, built, bytes) in row.filter(|(name, ..)| name == Item::Recorder.name()) {
            (*built, *bytes) = (true, writer.held_bytes());
        }
        refused.map_or(Ok(()), Err)
    }

    /// Three times through all: until nothing grows any more, to count what is allocated, and to take the time.
    fn again_and_again<T>(
        &self,
        all: &[T],
        each: &mut impl FnMut(&T),
        before: Option<Heap>,
        counts: &mut Counts,
    ) {
        all.iter().for_each(&mut *each);
        counts.used = grown(before, Heap::now());
        let again = Heap::now();
        all.iter().for_each(&mut *each);
        counts.use_calls = calls(again, Heap::now());
        let at_a_time = if self.of == Of::Frame { 1 } else { TIMED };
        let times: Samples = all
            .chunks(at_a_time)
            .map(|some| {
                let started = Instant::now();
                some.iter().for_each(&mut *each);
                started.elapsed().as_secs_f64() * 1e6 / some.len() as f64
            })
            .collect();
        counts.time_us = times.median();
    }

    /// Marks nothing, the questions whether a part is there, and the windows.
    fn marked<T>(
        &self,
        touch: &TouchScene,
        all: &[T],
        each: &mut impl FnMut(&T),
        mark: &mut dyn FnMut(),
    ) {
        if self.windows == 0 {
            return;
        }
        mark();
        mark();
        mark();
        black_box(asked(black_box(touch)));
        mark();
        self.windows(all, each, mark);
    }

    /// Goes through all that is done once for each window, and marks where it is. Windows come in an order that spreads
    /// any number of them.
    fn windows<T>(&self, all: &[T], each: &mut impl FnMut(&T), mark: &mut dyn FnMut()) {
        for window in 0..self.windows {
            let share = HELD.start + (HELD.end - HELD.start) * halved(window as u32 + 1);
            let at = ((share * all.len() as f64) as usize).min(all.len());
            let end = (at + self.per_window).min(all.len());
            all[..at].iter().for_each(&mut *each);
            mark();
            for one in &all[at..end] {
                each(black_box(one));
            }
            mark();
            all[end..].iter().for_each(&mut *each);
        }
    }

    /// What the servo reads: press and slide over the scene's own skin, or far above it.
    fn inputs(&self, scene: &Scene) -> Vec<TickInput> {
        let height_mm = |x, y| scene.height_mm(x, y);
        let path = Script::Slide.trajectory(scene.default_place_mm(), DEPTH_MM, height_mm);
        let aloft = match self.finger {
            Finger::Aloft => Vec3::new(0.0, 0.0, ALOFT_MM),
            Finger::Slides | Finger::Straight => Vec3::ZERO,
        };
        let input = |k: usize| {
            let (position_mm, velocity_mm_s) = path.at((k + 1) as f64 * DT_S);
            let mut input = TickInput {
                n_fingers: 1,
                force_enabled: true,
                ..TickInput::default()
            };
            input.readings[0] = Reading {
                position_mm: position_mm + aloft,
                velocity_mm_s,
                connected: true,
                ..Reading::default()
            };
            input
        };
        (0..TICKS).map(input).collect()
    }
}

fn told(row: &LedgerRow) -> (String, bool, usize) {
    (row.item.to_owned(), row.built, row.bytes)
}

fn rig(touch: &TouchScene) -> Rig {
    Rig::new(Box::new(touch.clone()), [Limits::default(); MAX_FINGERS])
}

/// The `n`th number of a sequence that halves what is left between those before: 1/2, 1/4, 3/4, 1/8 …
/// (van der Corput 1935).
fn halved(n: u32) -> f64 {
    f64::from(n.reverse_bits()) / (f64::from(u32::MAX) + 1.0)
}

/// What a scripted finger feels.
fn felt(touch: &TouchScene, inputs: &[TickInput]) -> Vec<FingerRecord> {
    let mut rig = rig(touch);
    let record = |input| tick(&mut rig, input, DT_S).fingers[0];
    inputs.iter().map(record).collect()
}

/// Share of records in which the finger touches.
fn touching(records: &[FingerRecord]) -> f64 {
    let touching = records.iter().filter(|r| r.contact.touch != Touch::Free);
    touching.count() as f64 / records.len() as f64
}

/// Runs a servo that is handed edits and a scene: what it asks of the heap meanwhile, and what is left when it has gone.
fn servo_thread(scene: &Scene, counts: &mut Counts) -> std::io::Result<()> {
    // What a thread needs once in a program's life is there after the first one.
    for _ in 0..2 {
        let before = Heap::now();
        let device: Box<dyn Device> = Box::new(Slider::over(scene));
        let (servo, mut lines) =
            servo::start(ServoConfig::default(), rig(&scene.touch), vec![device])?;
        let mut boxes: Vec<Box<TouchScene>> = Vec::new();
        for i in 1..=EDITS {
            let share = 1.0 - 0.05 * f64::from(i);
            let stiffness = match &scene.touch.stiffness {
                Stiffness::Uniform(k) => Stiffness::Uniform(k * share),
                Stiffness::PerVertex(values) => {
                    Stiffness::PerVertex(values.iter().map(|k| k * share).collect())
                }
            };
            boxes.push(Box::new(TouchScene {
                stiffness,
                ..scene.touch.clone()
            }));
        }
        std::thread::sleep(SETTLED);
        let quiet = Heap::now();
        for number in 1..=EDITS {
            let Some(scene) = boxes.pop() else { break };
            let command = if number == EDITS {
                servo::Command::SetScene(scene)
            } else {
                servo::Command::EditScene { number, scene }
            };
            // Room for 64; one that came back would be freed here and be counted.
            let _ = lines.commands.push(command);
            std::thread::sleep(SETTLED);
        }
        counts.use_calls = calls(quiet, Heap::now());
        drop((boxes, servo, lines));
        counts.used = grown(before, Heap::now());
    }
    Ok(())
}

/// Surface and search structure are in every scene: they are built once more and counted by themselves.
fn alone(scene: &Scene, counts: &mut Counts) -> Result<(), String> {
    let before = Heap::now();
    let raw = RawMesh {
        positions: scene.surface.positions().to_vec(),
        triangles: scene.surface.triangles().to_vec(),
    };
    let (surface, report) = Surface::new(raw).map_err(|e| e.to_string())?;
    drop(report);
    let after = Heap::now();
    let search = Bvh::new(&surface);
    let last = Heap::now();
    counts.surface = grown(before, after);
    counts.search = grown(after, last);
    drop(search);
    Ok(())
}

/// Asks for every part that a tick may find absent, as the tick does: by one test each.
#[inline(never)]
fn asked(scene: &TouchScene) -> [bool; 6] {
    [
        black_box(scene).published.is_some(),
        black_box(scene).friction.is_some(),
        black_box(scene).shading.is_some(),
        black_box(scene).fading.is_some(),
        black_box(scene).choices.pad_mm().is_some(),
        matches!(black_box(scene).stiffness, Stiffness::PerVertex(_)),
    ]
}

fn header(scene: &Scene) -> Header {
    Header {
        scenario_toml: scene.scenario.source.clone(),
        scenario_name: scene.scenario.name.clone(),
        mesh: MeshSource::new(&scene.surface, &scene.mesh_origin),
        devices: vec![DeviceInfo::new("scripted", &Limits::default())],
        rate_hz: 1.0 / DT_S,
        build: session::build_id(),
        started_utc: session::utc_now(),
        participant: None,
        edit: 0,
        sealed: false,
    }
}
