//! What becomes of the error in the course of a session: repetition, other rates and engines, energy, springs that ring.

use super::felt::{self, Engine};
use super::scenario;
use crate::contact::TouchScene;
use crate::deform::Press;
use crate::device::Device as _;
use crate::device::scripted::{Script, Scripted, Trajectory, Waypoint};
use crate::figure::{LinePlot, Scale, Series};
use crate::geom::Vec3;
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Verdict, Watch};
use crate::partition::hdb::Query;
use crate::reference::Elastic;
use crate::reference::fem::Slab;
use crate::reference::fem::linear::Fixed;
use crate::reference::springs::motion::{Motion, explicit_limit_s};
use crate::reference::springs::xpbd::Xpbd;
use crate::reference::springs::{Lattice, rest};
use crate::scenario::{Scenario, Scene};
use crate::servo::{Limits, MAX_FINGERS, Rig, TickInput, TickRecord, tick};
use crate::session::{Session, Strictness, input_of};
use std::path::Path;

/// Error over the time of a session.
pub struct ErrorOverSession;

/// Rate of a scripted session, Hz.
const RATE_HZ: f64 = 1000.0;
/// Depth of a scripted motion, mm.
const DEPTH_MM: f64 = 6.0;
/// A press that is less deep tells nothing, and one that is deeper no skin follows, mm (the cap of eq. 4.16).
const LEAST_DEPTH_MM: f64 = 0.5;
const MOST_DEPTH_MM: f64 = 10.0;
/// Ticks of a session that are looked at.
const MOST_TICKS: usize = 120_000;
/// Points of a curve.
const POINTS: usize = 600;
/// Energy below this share of what was put in is not drawn, %.
const LEAST_PERCENT: f64 = 1.0e-3;
/// Curves: colour by number. None is a finger's.
const COLOURS: [[u8; 3]; 6] = [
    [24, 26, 30],
    [214, 122, 0],
    [0, 140, 104],
    [136, 72, 168],
    [0, 150, 170],
    [124, 84, 28],
];

impl Experiment for ErrorOverSession {
    fn name(&self) -> &'static str {
        "error-over-session"
    }

    fn about(&self) -> &'static str {
        "A session over its time: repeated, at other rates and engines, with the energy handed out; springs that ring"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Scene, Choice::Session, Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let run = match &setup.session {
            Some(path) => Run::read(path, setup, &mut watch.part(0.0, 0.4))?,
            None => Run::scripted(setup, &mut watch.part(0.0, 0.4))?,
        };
        report.set("session", &run.name);
        report.set("scene", &run.scene.scenario.name);
        let seconds = run.recorded.len() as f64 * run.dt_s;
        report.set(
            "looked at",
            format!("{} ticks, {seconds:.1} s", run.recorded.len()),
        );
        tell_runs(&run, &mut report, &mut watch.part(0.4, 0.8))?;
        tell_springs(setup.quick, &mut report, &mut watch.part(0.8, 1.0))?;
        Ok(report)
    }
}

/// Inputs and what came of them.
pub struct Run {
    name: String,
    scene: Scene,
    dt_s: f64,
    limits: [Limits; MAX_FINGERS],
    inputs: Vec<TickInput>,
    recorded: Vec<TickRecord>,
}

impl Run {
    fn scripted(setup: &Setup, watch: &mut Watch<'_>) -> Result<Self, LabError> {
        let scene = felt::built(scenario(setup)?, watch)?;
        let script = if setup.quick {
            Script::Tap
        } else {
            Script::Spiral
        };
        let mut device = Scripted::new(felt::trajectory(&scene, script, DEPTH_MM));
        let limits = [Limits::of(device.capabilities()); MAX_FINGERS];
        let mut rig = Rig::new(Box::new(scene.touch.clone()), limits);
        let dt_s = 1.0 / RATE_HZ;
        let n_ticks = (script.duration_s() * RATE_HZ) as usize;
        let (mut inputs, mut recorded) = (Vec::new(), Vec::new());
        for _ in 0..n_ticks {
            let mut input = TickInput {
                n_fingers: 1,
                force_enabled: true,
                ..TickInput::default()
            };
            input.readings[0] = device.read(dt_s);
            recorded.push(tick(&mut rig, &input, dt_s));
            inputs.push(input);
        }
        Ok(Self {
            name: format!("scripted {script}, {DEPTH_MM} mm deep, {RATE_HZ} Hz"),
            scene,
            dt_s,
            limits,
            inputs,
            recorded,
        })
    }

    /// The first ticks of a recording without a gap, up to its first edit.
    pub fn read(path: &Path, setup: &Setup, watch: &mut Watch<'_>) -> Result<Self, LabError> {
        let input = |e: &dyn std::fmt::Display| LabError::Input(e.to_string());
        let session = Session::open(path).map_err(|e| input(&e))?;
        let header = session.header();
        let scenario = match &setup.scene {
            Some(_) => scenario(setup)?,
            None => {
                let origin = format!("{}: scenario", path.display());
                Scenario::parse(&header.scenario_toml, &origin, path.parent())
                    .map_err(|e| input(&e))?
            }
        };
        let scene = felt::built(scenario, watch)?;
        let (mut inputs, mut recorded) = (Vec::new(), Vec::<TickRecord>::new());
        for record in session.ticks(Strictness::Lenient).map_err(|e| input(&e))? {
            let record = record.map_err(|e| input(&e))?;
            let Some(first) = record.fingers().first() else {
                break;
            };
            let follows = recorded.last().and_then(|r| r.fingers().first());
            let gap = follows.is_some_and(|before| before.tick + 1 != first.tick);
            if gap || first.edit != header.edit || recorded.len() == MOST_TICKS {
                break;
            }
            inputs.push(input_of(&record));
            recorded.push(record);
        }
        if recorded.len() < 2 {
            return Err(LabError::Input(format!(
                "{}: there are no two ticks in a row",
                path.display()
            )));
        }
        Ok(Self {
            name: path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            scene,
            dt_s: header.dt_s(),
            limits: header.limits(),
            inputs,
            recorded,
        })
    }

    /// Its scene, the deepest press of its first finger and the motion of that.
    pub fn into_press(self) -> Result<(Scene, Option<Press>, Trajectory), LabError> {
        let touches = self.recorded.iter().filter_map(|r| r.fingers().first());
        let deepest = touches.max_by(|a, b| a.contact.depth_mm.total_cmp(&b.contact.depth_mm));
        let press = deepest.and_then(|record| self.scene.press(&record.contact));
        let press = press.filter(|p| p.depth_mm >= LEAST_DEPTH_MM);
        let name = &self.name;
        let press = press.ok_or_else(|| {
            let why = format!("{name}: nothing is pressed {LEAST_DEPTH_MM} mm deep or more");
            LabError::Input(why)
        })?;
        let readings = self.inputs.iter().map(|i| i.readings[0]).enumerate();
        let waypoints = readings
            .filter(|(_, reading)| reading.is_usable())
            .map(|(i, reading)| Waypoint {
                time_s: i as f64 * self.dt_s,
                position_mm: reading.position_mm,
            })
            .collect();
        let motion = Trajectory::new(waypoints);
        let motion = motion.map_err(|e| LabError::Input(format!("{name}: {e}")))?;
        let press = Press {
            depth_mm: press.depth_mm.min(MOST_DEPTH_MM),
            ..press
        };
        Ok((self.scene, Some(press), motion))
    }

    /// The session again, each `every`th tick of it, the others held: the force before limits of the first finger, N.
    fn again(&self, touch: &TouchScene, every: usize) -> Vec<Vec3> {
        let mut rig = Rig::new(Box::new(touch.clone()), self.limits);
        if every == 1 {
            rig.resume_from(&self.recorded[0]);
        }
        let mut felt_n = Vec::with_capacity(self.inputs.len());
        let mut held = Vec3::ZERO;
        for (i, input) in self.inputs.iter().enumerate() {
            if i == 0 && every == 1 {
                held = self.force_n(0);
            } else if i.is_multiple_of(every) {
                let out = tick(&mut rig, input, self.dt_s * every as f64);
                held = out
                    .fingers()
                    .first()
                    .map_or(Vec3::ZERO, |f| f.contact.force_n);
            }
            felt_n.push(held);
        }
        felt_n
    }

    fn force_n(&self, i: usize) -> Vec3 {
        self.recorded[i]
            .fingers()
            .first()
            .map_or(Vec3::ZERO, |f| f.contact.force_n)
    }

    /// Work that the finger did on the skin so far, N·mm: below 0 the skin has handed out more than it was given.
    fn work_n_mm(&self, felt_n: &[Vec3]) -> Vec<f64> {
        let mut work = 0.0;
        let place = |i: usize| self.inputs[i].readings[0].position_mm;
        (0..felt_n.len())
            .map(|i| {
                if i > 0 {
                    // The force of a tick is held until the next one.
                    let step = place(i) - place(i - 1);
                    let by = -felt_n[i - 1].dot(step);
                    work += if by.is_finite() { by } else { 0.0 };
                }
                work
            })
            .collect()
    }

    fn curve(&self, name: &str, colour: usize, values: &[f64]) -> Series {
        let step = values.len().div_ceil(POINTS).max(1);
        let largest = |c: &[f64]| {
            c.iter()
                .copied()
                .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
        };
        let chunks = values.chunks(step).enumerate();
        Series {
            name: name.to_owned(),
            colour: COLOURS[colour % COLOURS.len()],
            points: chunks
                .map(|(i, c)| [(i * step) as f64 * self.dt_s, largest(c)])
                .collect(),
            ..Series::default()
        }
    }
}

fn tell_runs(run: &Run, report: &mut Report, watch: &mut Watch<'_>) -> Result<(), LabError> {
    let published = |threshold, hdb_part, query| Engine::Published {
        partition: "octree",
        threshold,
        hdb_part,
        query,
    };
    let ways: [(&str, Engine, usize); 5] = [
        ("the same again", Engine::Production, 1),
        ("every 2nd tick", Engine::Production, 2),
        ("every 10th tick", Engine::Production, 10),
        (
            "octree, threshold 1024, box 1/4, as printed",
            published(1024, 0.25, Query::Published),
            1,
        ),
        (
            "octree, threshold 64, box 1/50",
            published(64, 0.02, Query::Complete),
            1,
        ),
    ];
    let mut table = Table::new(
        "session",
        "The session again in other ways: how far the force is off the recorded one, and the work done on the skin",
        &[
            "way",
            "RMS (N)",
            "largest (N)",
            "at the end (N)",
            "work at the end (N·mm)",
            "least work (N·mm)",
        ],
    );
    let (mut off_curves, mut work_curves) = (Vec::new(), Vec::new());
    let mut same = None;
    let n = ways.len() as f64;
    for (i, (name, engine, every)) in ways.into_iter().enumerate() {
        let share = i as f64 / n;
        watch.at(name, share)?;
        let touch = match i {
            // As it was recorded, whatever the engine.
            0 => run.scene.touch.clone(),
            _ => {
                let mut part = watch.part(share, share + 1.0 / n);
                felt::touch(&run.scene, engine, &mut part)?
            }
        };
        let felt_n = run.again(&touch, every);
        let off: Vec<f64> = (0..felt_n.len())
            .map(|t| felt_n[t].distance(run.force_n(t)))
            .collect();
        let work = run.work_n_mm(&felt_n);
        let sum: f64 = off.iter().map(|o| o * o).sum();
        let largest = off.iter().copied().fold(0.0, f64::max);
        let least = work.iter().copied().fold(0.0, f64::min);
        let last = |v: &[f64]| v.last().copied().unwrap_or(0.0);
        table.push([
            name.into(),
            (sum / off.len().max(1) as f64).sqrt().into(),
            largest.into(),
            last(&off).into(),
            last(&work).into(),
            least.into(),
        ]);
        if i == 0 {
            same = Some(largest);
        }
        off_curves.push(run.curve(name, i, &off));
        work_curves.push(run.curve(name, i, &work));
    }
    report.tables.push(table);
    let plot = |title: &str, y_label: &str, series| LinePlot {
        title: title.to_owned(),
        x_label: "time (s)".to_owned(),
        y_label: y_label.to_owned(),
        series,
        ..LinePlot::default()
    };
    report.draw(
        "session",
        vec![
            plot("Force off the recorded one", "|difference| (N)", off_curves),
            plot("Work done on the skin", "work (N·mm)", work_curves),
        ],
    );
    let same = same.unwrap_or(f64::INFINITY);
    report.verdicts.push(Verdict::must(
        "the same session again, largest difference in force",
        format!("{same} N"),
        "0 N, bit for bit",
        same == 0.0,
    ));
    Ok(())
}

/// A slab of springs, pressed and let go without friction, under each integrator: what keeps its energy.
fn tell_springs(quick: bool, report: &mut Report, watch: &mut Watch<'_>) -> Result<(), LabError> {
    let input = |e: &dyn std::fmt::Display| LabError::Input(e.to_string());
    let n = if quick { 3 } else { 5 };
    let edge = 20.0 / n as f64;
    let xs: Vec<f64> = (0..=2 * n).map(|i| i as f64 * edge).collect();
    let depths: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
    let slab = Slab::flat(&xs, &xs, &depths, 20.0).map_err(|e| input(&e))?;
    let lattice = Lattice::new(&slab, Elastic::MUSCLE, [Fixed::Held; 4]).map_err(|e| input(&e))?;
    let middle = slab.node(n, n, 0);
    let pressed = rest::rest(&lattice, &[(middle, Vec3::NEG_Z * 0.3)]).map_err(|e| input(&e))?;
    let at_mm: Vec<Vec3> = (pressed.displacements_mm.iter().zip(&lattice.rest_mm))
        .map(|(u, r)| *u + *r)
        .collect();
    let whole = lattice.energy_n_mm(&at_mm);
    let limit_s = explicit_limit_s(&lattice);
    let duration_s = if quick { 0.02 } else { 0.1 };
    enum By {
        Explicit,
        Implicit,
        Position(usize),
    }
    let ways: [(&str, By, f64); 5] = [
        ("explicit, half its limit", By::Explicit, 0.5 * limit_s),
        ("explicit, 0.9 of its limit", By::Explicit, 0.9 * limit_s),
        ("implicit, 1 ms", By::Implicit, 1.0e-3),
        ("implicit, a frame", By::Implicit, 1.0 / 60.0),
        ("xpbd, 1 ms, 20 sweeps", By::Position(20), 1.0e-3),
    ];
    let mut table = Table::new(
        "ringing",
        format!(
            "Springs let go without friction: energy after {duration_s} s, over what was put in"
        ),
        &[
            "integrator",
            "step (ms)",
            "steps",
            "least (%)",
            "largest (%)",
            "at the end (%)",
        ],
    );
    let mut curves = Vec::new();
    for (i, (name, by, dt_s)) in ways.into_iter().enumerate() {
        watch.at(name, i as f64 / 5.0)?;
        let steps = (duration_s / dt_s).ceil() as usize;
        let mut motion = Motion::new(&lattice, 0.0);
        motion.at_mm.clone_from(&at_mm);
        let mut games = Xpbd::new(&lattice, 0.0);
        games.at_mm.clone_from(&at_mm);
        let mut shares = vec![1.0];
        for _ in 0..steps {
            match by {
                By::Explicit => motion.step_explicit(&[], dt_s),
                By::Implicit => motion.step_implicit(&[], dt_s).map_err(|e| input(&e))?,
                By::Position(sweeps) => {
                    games.step(&[], dt_s, sweeps);
                    motion.at_mm.clone_from(&games.at_mm);
                    motion.velocity_mm_s.clone_from(&games.velocity_mm_s);
                }
            }
            shares.push(motion.energy_n_mm() / whole);
        }
        let percent = |x: f64| 100.0 * x;
        table.push([
            name.into(),
            (1000.0 * dt_s).into(),
            steps.into(),
            percent(shares.iter().copied().fold(f64::INFINITY, f64::min)).into(),
            percent(shares.iter().copied().fold(0.0, f64::max)).into(),
            percent(shares.last().copied().unwrap_or(0.0)).into(),
        ]);
        let step = shares.len().div_ceil(POINTS).max(1);
        let points = shares.iter().enumerate().step_by(step);
        curves.push(Series {
            name: name.to_owned(),
            colour: COLOURS[i],
            points: points
                .map(|(t, e)| [1000.0 * t as f64 * dt_s, percent(*e)])
                .filter(|[_, e]| *e >= LEAST_PERCENT)
                .collect(),
            ..Series::default()
        });
    }
    report.tables.push(table);
    report.draw(
        "ringing",
        vec![LinePlot {
            title: "Energy of springs let go".to_owned(),
            x_label: "time (ms)".to_owned(),
            y_label: "energy (% of what was put in)".to_owned(),
            y_scale: Scale::Logarithmic,
            series: curves,
            ..LinePlot::default()
        }],
    );
    report.note(
        "Without friction the energy of a body stays. Explicit steps below their limit swing about it and lose none for \
         good; implicit steps and projection take it away, the faster the longer the step.",
    );
    Ok(())
}
