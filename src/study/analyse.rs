//! The one pass over a session.

use super::felt::felt;
use super::frame::{Felt as Touched, Frame, Framer};
use super::phases::{Joiner, PhaseKind, Segmenter, at as phase_at};
use super::presses::Detector;
use super::smooth::Smoothness;
use super::sum::{Covered, Scale, Total};
use super::told::{About, Analysis, Dwell, FingerAnalysis, MOST_EVENTS, Moment};
use super::{Options, StudyError};
use crate::geom::Vec2;
use crate::scenario::dysfunction::Tenderness;
use crate::scenario::{self, Scenario, Use};
use crate::servo::FingerRecord;
use crate::session::{Entry, Event, Session, Strictness};
use crate::training::Ground;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Records between two words on progress.
const BETWEEN: u64 = 8192;

/// What a session tells: a pure function of its file and `options`, in one pass, in memory that grows only with the number of
/// phases and presses. What is damaged is stepped over and told. `progress` gets the share that is done, 0 to 1, and answers
/// whether to go on.
///
/// The scenario is read from the file itself; where it names a mesh that is not beside the file, the share of the back that
/// was covered is absent.
///
/// # Errors
/// The file cannot be read, stays sealed, an option is not allowed, or `progress` said stop.
pub fn analyse(
    session: &Session,
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Analysis, StudyError> {
    options.check()?;
    let header = session.header();
    if header.sealed {
        return Err(StudyError::Sealed {
            path: session.path().to_owned(),
        });
    }
    let mut tender = TenderPlaces::default();
    let folder = session.path().parent();
    tender.read(header.edit, &header.scenario_toml, folder);
    let mut pass = Pass::new(session, options);
    let mut entries = session.entries(Strictness::Lenient)?;
    let mut n = 0_u64;
    while let Some(entry) = entries.next() {
        match entry? {
            Entry::Tick(record) => pass.tick(&record, tender.after(record.edit)),
            Entry::Edit(edit) => {
                pass.about.edits += 1;
                tender.read(edit.number, &edit.scenario_toml, folder);
            }
            Entry::Event(event) => {
                pass.event(event);
            }
        }
        n += 1;
        if n.is_multiple_of(BETWEEN) && !progress(entries.progress()) {
            return Err(StudyError::Stopped);
        }
    }
    let mut analysis = pass.finish(options, session);
    analysis.damage = entries.damage().clone();
    progress(1.0);
    Ok(analysis)
}

/// Where it was tender after each edit that ticks may still name.
#[derive(Default)]
struct TenderPlaces(BTreeMap<u32, Option<Tenderness>>);

/// Edits that are kept: a tick names the newest or the one before.
const KEPT_EDITS: usize = 8;

impl TenderPlaces {
    fn read(&mut self, edit: u32, text: &str, folder: Option<&Path>) {
        let parsed = Scenario::parse(text, "scenario", folder).ok();
        let patches = parsed.and_then(|s| s.patches().ok());
        let tenderness = patches.map(|p| Tenderness::of(p.iter().map(|(_, patch)| patch)));
        self.0.insert(edit, tenderness);
        while self.0.len() > KEPT_EDITS {
            self.0.pop_first();
        }
    }

    fn after(&self, edit: u32) -> Option<&Tenderness> {
        self.0.get(&edit)?.as_ref()
    }
}

/// The skin as cells of the lattice; `None` where the surface is not at hand.
fn ground(session: &Session, cell_mm: f64) -> Option<Ground> {
    let header = session.header();
    let parsed = Scenario::parse(&header.scenario_toml, "scenario", session.path().parent());
    let scene = scenario::build(Arc::new(parsed.ok()?), Use::default(), &mut |_, _| true).ok()?;
    let bounds = scene.surface.bounds();
    let low = (bounds.min.truncate() / cell_mm).floor() * cell_mm;
    let high = (bounds.max.truncate() / cell_mm).ceil() * cell_mm;
    Some(Ground::with_cells([low, high], cell_mm, Vec::new(), |at| {
        scene.height_mm(at.x, at.y).is_some()
    }))
}

/// How long a cell was touched, and by which finger in which phase.
#[derive(Clone, Copy, Default)]
struct Cell {
    ticks: u64,
    by: u16,
}

const WHOLE: u16 = 1;
const SEARCH: u16 = 2;
const PALPATION: u16 = 4;
/// Bits of one finger.
const BITS: u16 = 3;
/// One finger's bits in the place of every finger.
const EVERY_FINGER: u16 = 0b001_001_001_001;

/// One finger on the way through the session.
struct Finger {
    framer: Framer,
    segmenter: Segmenter,
    joiner: Joiner,
    detector: Detector,
    totals: [Total; 3],
    ticks: u64,
    first_contact_tick: Option<u64>,
}

struct Pass<'a> {
    options: &'a Options,
    about: About,
    dt_s: f64,
    fingers: Vec<Option<Finger>>,
    first_tick: Option<u64>,
    cells: BTreeMap<[i32; 2], Cell>,
    smoothness: Smoothness,
    events: Vec<Moment>,
}

impl<'a> Pass<'a> {
    fn new(session: &Session, options: &'a Options) -> Self {
        let header = session.header();
        Self {
            options,
            about: About::of(session),
            dt_s: header.dt_s(),
            fingers: (0..header.n_fingers()).map(|_| None).collect(),
            first_tick: None,
            cells: BTreeMap::new(),
            smoothness: Smoothness::default(),
            events: Vec::new(),
        }
    }

    fn tick(&mut self, record: &FingerRecord, tender: Option<&Tenderness>) {
        let first = *self.first_tick.get_or_insert(record.tick);
        let (options, rate_hz) = (self.options, self.about.rate_hz);
        let number = usize::from(record.finger);
        let Some(slot) = self.fingers.get_mut(number) else {
            return;
        };
        let finger = slot.get_or_insert_with(|| {
            let edges = &options.force_bands_n;
            let framer = Framer::new(rate_hz, first, options.cell_mm, edges);
            Finger {
                segmenter: Segmenter::new(&options.phases, 1.0 / framer.rate_hz()),
                framer,
                joiner: Joiner::default(),
                detector: Detector::new(&options.presses, first, 1.0 / rate_hz),
                totals: Default::default(),
                ticks: 0,
                first_contact_tick: None,
            }
        });
        finger.ticks += 1;
        let felt = Touched::of(record);
        if felt.is_some() && finger.first_contact_tick.is_none() {
            finger.first_contact_tick = Some(record.tick.saturating_sub(first));
        }
        finger.detector.add(record.tick, felt);
        if let Some(frame) = finger.framer.add(record, felt, tender) {
            self.frame(number, frame);
        }
    }

    fn event(&mut self, event: Event) {
        self.about.events += 1;
        let first = self.first_tick.unwrap_or(event.tick);
        if event.kind == "restart" {
            self.restarted();
        }
        if self.events.len() < MOST_EVENTS {
            self.events.push(Moment {
                time_s: event.tick.saturating_sub(first) as f64 * self.dt_s,
                kind: event.kind,
                text: event.text,
            });
        }
    }

    fn restarted(&mut self) {
        for finger in self.fingers.iter_mut().flatten() {
            finger.framer.restarted = true;
        }
    }

    /// Sends a frame, or the end of the recording, through the division into phases.
    fn frame(&mut self, number: usize, frame: impl Into<Option<Frame>>) {
        let Some(Some(finger)) = self.fingers.get_mut(number) else {
            return;
        };
        let (rate_hz, dt_s) = (finger.framer.rate_hz(), self.dt_s);
        let (totals, joiner) = (&mut finger.totals, &mut finger.joiner);
        let (cells, smoothness) = (&mut self.cells, &mut self.smoothness);
        let mut settle = |frame: Frame, kind: PhaseKind| {
            let bits = match kind {
                PhaseKind::Away => WHOLE,
                PhaseKind::Search => WHOLE | SEARCH,
                PhaseKind::Palpation => WHOLE | PALPATION,
            };
            joiner.add(&frame, kind, dt_s);
            for (i, total) in totals.iter_mut().enumerate() {
                if bits >> i & 1 == 1 {
                    total.add(&frame, rate_hz, smoothness);
                }
            }
            for (at, ticks) in &frame.cells {
                let cell = cells.entry(*at).or_default();
                cell.ticks += u64::from(*ticks);
                cell.by |= bits << (BITS * number as u16);
            }
        };
        match frame.into() {
            Some(frame) => finger.segmenter.push(frame, &mut settle),
            None => finger.segmenter.finish(&mut settle),
        }
    }

    fn finish(mut self, options: &Options, session: &Session) -> Analysis {
        for number in 0..self.fingers.len() {
            let last = self.fingers[number]
                .as_mut()
                .and_then(|f| f.framer.finish());
            if last.is_some() {
                self.frame(number, last);
            }
            self.frame(number, None);
            if let Some(finger) = &mut self.fingers[number] {
                finger.detector.finish();
                let rate_hz = finger.framer.rate_hz();
                for total in &mut finger.totals {
                    total.finish(rate_hz, &mut self.smoothness);
                }
            }
        }
        let ground = ground(session, options.cell_mm);
        let scale = Scale {
            dt_s: self.dt_s,
            cell_mm: options.cell_mm,
            bands: options.force_bands_n.len() + 1,
            skin_mm2: ground.as_ref().map(Ground::skin_mm2),
        };
        let covered = |bits: u16| {
            let touched = self.cells.iter().filter(|(_, cell)| cell.by & bits != 0);
            let mut covered = Covered::default();
            for (at, _) in touched {
                let middle = Vec2::new(f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5);
                covered.cells += 1;
                let skin = ground
                    .as_ref()
                    .is_some_and(|g| g.is_skin(middle * options.cell_mm));
                covered.skin += u64::from(skin);
            }
            covered
        };
        let sites: &[_] = match options.sites_of_builtin && self.about.mesh_origin != "builtin:back"
        {
            true => &[],
            false => &options.sites,
        };
        let mut together: [Total; 3] = Default::default();
        let mut fingers = Vec::new();
        for (number, finger) in self.fingers.iter_mut().enumerate() {
            let Some(finger) = finger else { continue };
            self.about.ticks = self.about.ticks.max(finger.ticks);
            for (sum, total) in together.iter_mut().zip(&finger.totals) {
                sum.merge(total);
            }
            let phases = std::mem::take(&mut finger.joiner.phases);
            let presses = std::mem::take(&mut finger.detector.presses);
            let of = |bit: u16, kind: Option<PhaseKind>| {
                let inside = presses
                    .iter()
                    .filter(|p| kind.is_none() || phase_at(&phases, p.peak_s) == kind);
                let total = &finger.totals[bit.trailing_zeros() as usize];
                total.metrics(&scale, covered(bit << (BITS * number as u16)), inside)
            };
            let (whole, search) = (of(WHOLE, None), of(SEARCH, Some(PhaseKind::Search)));
            let palpation = of(PALPATION, Some(PhaseKind::Palpation));
            fingers.push(FingerAnalysis {
                finger: number as u8,
                first_contact_s: finger
                    .first_contact_tick
                    .map(|tick| tick as f64 * self.dt_s),
                whole,
                search,
                palpation,
                felt: felt(&presses, sites, options.near_mm),
                phases,
                presses,
            });
        }
        let of = |bit: u16, kind: Option<PhaseKind>| {
            let inside = fingers.iter().flat_map(|f: &FingerAnalysis| {
                let is = move |p: &&super::Press| {
                    kind.is_none() || phase_at(&f.phases, p.peak_s) == kind
                };
                f.presses.iter().filter(is)
            });
            together[bit.trailing_zeros() as usize].metrics(
                &scale,
                covered(bit * EVERY_FINGER),
                inside,
            )
        };
        let (whole, search) = (of(WHOLE, None), of(SEARCH, Some(PhaseKind::Search)));
        let palpation = of(PALPATION, Some(PhaseKind::Palpation));
        let felt = felt(
            fingers.iter().flat_map(|f| &f.presses),
            sites,
            options.near_mm,
        );
        self.about.seconds = self.about.ticks as f64 * self.dt_s;
        self.about.lost = whole.lost_ticks;
        Analysis {
            dwell: dwell(&self.cells, options.cell_mm, self.dt_s),
            about: self.about,
            whole,
            search,
            palpation,
            felt,
            fingers,
            events: self.events,
            force_bands_n: options.force_bands_n.clone(),
            damage: Default::default(),
        }
    }
}

fn dwell(cells: &BTreeMap<[i32; 2], Cell>, cell_mm: f64, dt_s: f64) -> Dwell {
    let range = |axis: usize| {
        let places = cells.keys().map(|at| at[axis]);
        Some((places.clone().min()?, places.max()?))
    };
    let (Some((left, right)), Some((low, high))) = (range(0), range(1)) else {
        return Dwell {
            cell_mm,
            ..Dwell::default()
        };
    };
    let (columns, rows) = ((right - left) as usize + 1, (high - low) as usize + 1);
    let mut seconds = vec![0.0_f32; columns * rows];
    for (at, cell) in cells {
        let place = (at[1] - low) as usize * columns + (at[0] - left) as usize;
        seconds[place] = (cell.ticks as f64 * dt_s) as f32;
    }
    Dwell {
        origin_mm: [f64::from(left) * cell_mm, f64::from(low) * cell_mm],
        cell_mm,
        columns,
        rows,
        seconds,
    }
}
