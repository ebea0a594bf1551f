//! How a back is palpated: facts gathered tick by tick, in memory that does not grow with time.

use crate::contact::Touch;
use crate::geom::{Vec2, Vec3};
use crate::servo::{FingerRecord, MAX_FINGERS, TickRecord};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What is told of a palpation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Facts {
    /// Time with a finger on the skin, s.
    pub contact_s: f64,
    /// How often a finger came down on the skin.
    pub presses: u32,
    /// Way of the fingers over the skin, mm.
    pub path_mm: f64,
    /// Share of the cells of the skin that were touched, 0 … 1.
    pub coverage: f64,
    /// Largest force of a finger against the skin, N.
    pub peak_force_n: f64,
    /// Mean over the time in contact, N.
    pub mean_force_n: f64,
    /// How often a tender place was pressed beyond what it bears.
    pub tender_presses: u32,
    /// For how long, s.
    pub tender_s: f64,
    /// Candidates in the order they were felt, by number from 0; the first [`MOST_VISITS`].
    pub visits: Vec<u16>,
    /// How many visits there were.
    pub n_visits: u32,
}

/// Most visits that are listed.
pub const MOST_VISITS: usize = 512;
/// Edge of a cell of the skin, mm.
pub const CELL_MM: f64 = 10.0;
/// A finger this near to a candidate feels it, mm: half the way between neighbouring levels.
const NEAR_MM: f64 = 12.0;
/// Most cells along an edge; larger cells are taken for a surface that would have more.
const MOST_CELLS: usize = 256;

/// The skin as cells of the map plane, and the places asked about.
#[derive(Clone, Debug, PartialEq)]
pub struct Ground {
    least_mm: Vec2,
    cell_mm: f64,
    columns: usize,
    rows: usize,
    skin: Vec<bool>,
    candidates_mm: Vec<Vec2>,
}

impl Ground {
    /// Cells of 10 mm between two corners, of which those count whose middle `is_skin` says to be skin.
    pub fn new(
        corners_mm: [Vec2; 2],
        candidates_mm: Vec<Vec2>,
        is_skin: impl FnMut(Vec2) -> bool,
    ) -> Self {
        Self::with_cells(corners_mm, CELL_MM, candidates_mm, is_skin)
    }

    /// The same with cells of another size; larger ones are taken for a surface that would have more than 256 along an edge.
    pub fn with_cells(
        corners_mm: [Vec2; 2],
        cell_mm: f64,
        candidates_mm: Vec<Vec2>,
        mut is_skin: impl FnMut(Vec2) -> bool,
    ) -> Self {
        let [a, b] = corners_mm.map(|c| if c.is_finite() { c } else { Vec2::ZERO });
        let (least_mm, size) = (a.min(b), (b - a).abs());
        let cell_mm = cell_mm.max(size.max_element() / MOST_CELLS as f64);
        let count = |length: f64| (libm::ceil(length / cell_mm) as usize).clamp(1, MOST_CELLS);
        let (columns, rows) = (count(size.x), count(size.y));
        let mut skin = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let middle = Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * cell_mm;
                skin.push(is_skin(least_mm + middle));
            }
        }
        Self {
            least_mm,
            cell_mm,
            columns,
            rows,
            skin,
            candidates_mm,
        }
    }

    /// The ground of a scene.
    pub fn of(scene: &crate::scenario::Scene, candidates_mm: Vec<Vec2>) -> Self {
        let bounds = scene.surface.bounds();
        let corners = [bounds.min.truncate(), bounds.max.truncate()];
        Self::new(corners, candidates_mm, |at| {
            scene.height_mm(at.x, at.y).is_some()
        })
    }

    /// Cells that count as skin.
    pub fn skin_cells(&self) -> usize {
        self.skin.iter().filter(|&&s| s).count()
    }

    /// Their area on the map plane, mm².
    pub fn skin_mm2(&self) -> f64 {
        self.skin_cells() as f64 * self.cell_mm * self.cell_mm
    }

    /// Whether the cell there counts as skin; none beside the ground does.
    pub fn is_skin(&self, at: Vec2) -> bool {
        self.cell(at).is_some_and(|cell| self.skin[cell])
    }

    fn cell(&self, at: Vec2) -> Option<usize> {
        let place = (at - self.least_mm) / self.cell_mm;
        // Written so that what is not a number is in no cell.
        let inside = place.x >= 0.0
            && place.y >= 0.0
            && place.x < self.columns as f64
            && place.y < self.rows as f64;
        inside.then(|| place.y as usize * self.columns + place.x as usize)
    }

    fn candidate(&self, at: Vec2) -> Option<u16> {
        let near = self.candidates_mm.iter().enumerate();
        let (i, distance) = near
            .map(|(i, c)| (i, c.distance_squared(at)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        (distance <= NEAR_MM * NEAR_MM).then(|| i.min(usize::from(u16::MAX)) as u16)
    }
}

/// A place that hurts when it is pressed harder than it bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tender {
    /// Its middle on the map plane, mm.
    pub at_mm: Vec2,
    /// How far it reaches, mm.
    pub radius_mm: f64,
    /// What it bears, N.
    pub above_n: f64,
}

/// Gathers [`Facts`].
#[derive(Clone, Debug)]
pub struct Palpation {
    ground: Arc<Ground>,
    tender: Vec<Tender>,
    touched: Vec<bool>,
    n_touched: usize,
    /// Where each finger was on the skin at the last tick.
    on_skin_mm: [Option<Vec3>; MAX_FINGERS],
    hurting: [bool; MAX_FINGERS],
    last_visit: [Option<u16>; MAX_FINGERS],
    finger_s: f64,
    impulse_n_s: f64,
    facts: Facts,
}

impl Palpation {
    /// Nothing felt yet.
    pub fn new(ground: Arc<Ground>, tender: Vec<Tender>) -> Self {
        Self {
            touched: vec![false; ground.skin.len()],
            ground,
            tender,
            n_touched: 0,
            on_skin_mm: [None; MAX_FINGERS],
            hurting: [false; MAX_FINGERS],
            last_visit: [None; MAX_FINGERS],
            finger_s: 0.0,
            impulse_n_s: 0.0,
            facts: Facts::default(),
        }
    }

    /// Takes in a tick of `dt_s`. The force is that of the skin on the finger before a device limits it: a mouse presses too.
    pub fn add(&mut self, tick: &TickRecord, dt_s: f64) {
        let dt_s = if dt_s.is_finite() { dt_s.max(0.0) } else { 0.0 };
        let mut any = false;
        for (i, finger) in tick.fingers().iter().enumerate() {
            any |= self.finger(i, finger, dt_s);
        }
        if any {
            self.facts.contact_s += dt_s;
        }
    }

    /// One finger of a tick; whether it is on the skin.
    fn finger(&mut self, i: usize, finger: &FingerRecord, dt_s: f64) -> bool {
        let (contact, place_mm) = (&finger.contact, finger.contact.foot_mm);
        if contact.touch == Touch::Free || !place_mm.is_finite() {
            self.on_skin_mm[i] = None;
            self.hurting[i] = false;
            self.last_visit[i] = None;
            return false;
        }
        let force_n = contact.force_n.length();
        let facts = &mut self.facts;
        match self.on_skin_mm[i].replace(place_mm) {
            None => facts.presses += 1,
            Some(before) => facts.path_mm += before.distance(place_mm),
        }
        self.finger_s += dt_s;
        self.impulse_n_s += force_n * dt_s;
        facts.peak_force_n = facts.peak_force_n.max(force_n);
        let at = place_mm.truncate();
        if let Some(cell) = self.ground.cell(at)
            && self.ground.skin[cell]
            && !self.touched[cell]
        {
            self.touched[cell] = true;
            self.n_touched += 1;
        }
        let visit = self.ground.candidate(at);
        if visit != self.last_visit[i]
            && let Some(candidate) = visit
        {
            facts.n_visits += 1;
            if facts.visits.len() < MOST_VISITS {
                facts.visits.push(candidate);
            }
        }
        self.last_visit[i] = visit;
        let hurts = self.tender.iter().any(|t| {
            force_n > t.above_n && t.at_mm.distance_squared(at) <= t.radius_mm * t.radius_mm
        });
        if hurts {
            facts.tender_s += dt_s;
            facts.tender_presses += u32::from(!self.hurting[i]);
        }
        self.hurting[i] = hurts;
        true
    }

    /// What there is to tell so far.
    pub fn facts(&self) -> Facts {
        let skin = self.ground.skin_cells();
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        Facts {
            coverage: share(self.n_touched as f64, skin as f64),
            mean_force_n: share(self.impulse_n_s, self.finger_s),
            ..self.facts.clone()
        }
    }
}
