//! Ticks of one finger gathered into frames of 10 ms: what phases, speeds and measures go by.

use super::options::MOST_BANDS;
use crate::contact::Touch;
use crate::geom::Vec3;
use crate::scenario::dysfunction::Tenderness;
use crate::servo::{FingerRecord, LimitFlags};

/// Length of a frame, s; where ticks are rarer a frame is a tick.
const FRAME_S: f64 = 0.01;
/// Farther from the middle of the plane nothing is skin, mm.
const FARTHEST_MM: f64 = 2000.0;

/// Sums over ticks that can be added up.
#[derive(Clone, Debug, Default)]
pub(super) struct Sums {
    pub ticks: u64,
    pub contact_ticks: u64,
    pub path_hip_mm: f64,
    pub path_hip_contact_mm: f64,
    /// Time that the ways of the HIP took, s.
    pub moved_s: f64,
    pub moved_contact_s: f64,
    pub path_skin_mm: f64,
    pub force_sum_n: f64,
    pub depth_sum_mm: f64,
    pub peak_force_n: f64,
    pub peak_depth_mm: f64,
    pub peak_speed_mm_s: f64,
    pub band_ticks: [u64; MOST_BANDS],
    pub tender_presses: u32,
    pub tender_ticks: u64,
    /// Whether the scenario said where it is tender.
    pub tender_known: bool,
    pub limited: u64,
    pub late: u64,
    pub lost: u64,
}

impl Sums {
    pub(super) fn add(&mut self, other: &Self) {
        self.ticks += other.ticks;
        self.contact_ticks += other.contact_ticks;
        self.path_hip_mm += other.path_hip_mm;
        self.path_hip_contact_mm += other.path_hip_contact_mm;
        self.moved_s += other.moved_s;
        self.moved_contact_s += other.moved_contact_s;
        self.path_skin_mm += other.path_skin_mm;
        self.force_sum_n += other.force_sum_n;
        self.depth_sum_mm += other.depth_sum_mm;
        self.peak_force_n = self.peak_force_n.max(other.peak_force_n);
        self.peak_depth_mm = self.peak_depth_mm.max(other.peak_depth_mm);
        self.peak_speed_mm_s = self.peak_speed_mm_s.max(other.peak_speed_mm_s);
        for (mine, theirs) in self.band_ticks.iter_mut().zip(other.band_ticks) {
            *mine += theirs;
        }
        self.tender_presses += other.tender_presses;
        self.tender_ticks += other.tender_ticks;
        self.tender_known |= other.tender_known;
        self.limited += other.limited;
        self.late += other.late;
        self.lost += other.lost;
    }
}

/// A frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// Number from the first tick of the session.
    pub index: u64,
    /// Its first tick, from that of the session.
    pub start_tick: u64,
    /// Behind its last tick, likewise.
    pub end_tick: u64,
    pub sums: Sums,
    /// Mean position of the HIP where the device answered, mm.
    pub hip_mm: Option<Vec3>,
    /// Mean of the feet on the skin, mm.
    pub skin_mm: Option<Vec3>,
    /// Mean speed since the frame before, mm/s; absent at the start and behind a gap.
    pub speed_mm_s: Option<f64>,
    /// Cells of the lattice touched, and the ticks in each.
    pub cells: Vec<([i32; 2], u32)>,
    /// Nothing connects it with the frame before.
    pub after_gap: bool,
}

impl Frame {
    /// Mean force over the ticks on the skin, N.
    pub(super) fn force_n(&self) -> f64 {
        self.sums.force_sum_n / self.sums.contact_ticks.max(1) as f64
    }
}

/// Makes frames of one finger's ticks.
pub(super) struct Framer {
    pub ticks_per_frame: u64,
    dt_s: f64,
    cell_mm: f64,
    edges_n: Vec<f64>,
    first_tick: u64,
    next_tick: Option<u64>,
    frame: Frame,
    hip_sum: Vec3,
    hip_n: u32,
    skin_sum: Vec3,
    before_hip_mm: Option<(u64, Vec3)>,
    on_skin_mm: Option<Vec3>,
    hurting: bool,
    /// The next gap is a servo started anew, or a recording that was held.
    pub restarted: bool,
}

/// What of a tick is looked at: never a number that is not finite.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    pub at_mm: Vec3,
    /// Of the whole force, N.
    pub force_n: f64,
    /// Along the normal, N.
    pub normal_force_n: f64,
    pub depth_mm: f64,
}

impl Felt {
    /// `None` off the skin, and where the record holds what is no number.
    pub(super) fn of(record: &FingerRecord) -> Option<Self> {
        let contact = &record.contact;
        let felt = Self {
            at_mm: contact.foot_mm,
            force_n: contact.force_n.length(),
            normal_force_n: contact.force_n.dot(contact.normal),
            depth_mm: contact.depth_mm,
        };
        let sound = felt.at_mm.is_finite()
            && felt.force_n.is_finite()
            && felt.normal_force_n.is_finite()
            && felt.depth_mm.is_finite();
        (contact.touch != Touch::Free && sound).then_some(felt)
    }
}

impl Framer {
    pub(super) fn new(rate_hz: f64, first_tick: u64, cell_mm: f64, edges_n: &[f64]) -> Self {
        Self {
            ticks_per_frame: (libm::round(rate_hz * FRAME_S) as u64).max(1),
            dt_s: 1.0 / rate_hz,
            cell_mm,
            edges_n: edges_n.to_vec(),
            first_tick,
            next_tick: None,
            frame: Frame {
                after_gap: true,
                ..Frame::default()
            },
            hip_sum: Vec3::ZERO,
            hip_n: 0,
            skin_sum: Vec3::ZERO,
            before_hip_mm: None,
            on_skin_mm: None,
            hurting: false,
            restarted: false,
        }
    }

    /// Frames per second.
    pub(super) fn rate_hz(&self) -> f64 {
        1.0 / (self.dt_s * self.ticks_per_frame as f64)
    }

    /// Takes in a tick; gives back the frame that it ends.
    pub(super) fn add(
        &mut self,
        record: &FingerRecord,
        felt: Option<Felt>,
        tender: Option<&Tenderness>,
    ) -> Option<Frame> {
        let index = record.tick.saturating_sub(self.first_tick) / self.ticks_per_frame;
        let missing = match self.next_tick {
            Some(next) => record.tick.saturating_sub(next),
            None => 0,
        };
        let gap = missing > 0 || self.restarted;
        let ended = if self.frame.sums.ticks > 0 && (index != self.frame.index || gap) {
            Some(self.take())
        } else {
            None
        };
        if gap {
            // Nothing is known of the way between: none is counted.
            self.before_hip_mm = None;
            self.on_skin_mm = None;
            self.hurting = false;
            self.frame.after_gap = true;
        }
        self.frame.index = index;
        if !self.restarted {
            self.frame.sums.lost += missing;
        }
        self.restarted = false;
        self.next_tick = Some(record.tick.saturating_add(1));
        self.count(record, felt, tender);
        ended
    }

    fn count(&mut self, record: &FingerRecord, felt: Option<Felt>, tender: Option<&Tenderness>) {
        let tick = record.tick.saturating_sub(self.first_tick);
        if self.frame.sums.ticks == 0 {
            self.frame.start_tick = tick;
        }
        self.frame.end_tick = tick + 1;
        let sums = &mut self.frame.sums;
        sums.ticks += 1;
        sums.late += u64::from(record.late);
        sums.limited += u64::from(limited(record.limits));
        sums.tender_known |= tender.is_some();
        if record.reading.is_usable() {
            self.hip_sum += record.reading.position_mm;
            self.hip_n += 1;
        }
        let Some(felt) = felt else {
            self.on_skin_mm = None;
            self.hurting = false;
            return;
        };
        sums.contact_ticks += 1;
        sums.force_sum_n += felt.force_n;
        sums.depth_sum_mm += felt.depth_mm;
        sums.peak_force_n = sums.peak_force_n.max(felt.force_n);
        sums.peak_depth_mm = sums.peak_depth_mm.max(felt.depth_mm);
        let band = self
            .edges_n
            .iter()
            .take_while(|edge| felt.force_n >= **edge)
            .count();
        sums.band_ticks[band.min(MOST_BANDS - 1)] += 1;
        if let Some(before) = self.on_skin_mm.replace(felt.at_mm) {
            sums.path_skin_mm += before.distance(felt.at_mm);
        }
        self.skin_sum += felt.at_mm;
        let at = felt.at_mm.truncate();
        if at.abs().max_element() <= FARTHEST_MM {
            let cell = (at / self.cell_mm).floor();
            let cell = [cell.x as i32, cell.y as i32];
            match self.frame.cells.iter_mut().find(|(c, _)| *c == cell) {
                Some((_, ticks)) => *ticks += 1,
                None => self.frame.cells.push((cell, 1)),
            }
        }
        let hurts = tender
            .and_then(|t| t.at(at))
            .is_some_and(|t| felt.force_n > t.above_n);
        sums.tender_ticks += u64::from(hurts);
        sums.tender_presses += u32::from(hurts && !self.hurting);
        self.hurting = hurts;
    }

    /// The frame so far, and a new one.
    fn take(&mut self) -> Frame {
        let mut frame = std::mem::take(&mut self.frame);
        let contact_ticks = frame.sums.contact_ticks;
        if contact_ticks > 0 {
            frame.skin_mm = Some(self.skin_sum / contact_ticks as f64);
        }
        if self.hip_n > 0 {
            let hip_mm = self.hip_sum / f64::from(self.hip_n);
            frame.hip_mm = Some(hip_mm);
            if let Some((index, before)) = self.before_hip_mm
                && index + 1 == frame.index
            {
                let (way_mm, frame_s) = (hip_mm.distance(before), 1.0 / self.rate_hz());
                let sums = &mut frame.sums;
                sums.path_hip_mm = way_mm;
                sums.moved_s = frame_s;
                if contact_ticks > 0 {
                    sums.path_hip_contact_mm = way_mm;
                    sums.moved_contact_s = frame_s;
                }
                sums.peak_speed_mm_s = way_mm / frame_s;
                frame.speed_mm_s = Some(way_mm / frame_s);
            }
        }
        self.before_hip_mm = frame.hip_mm.map(|hip_mm| (frame.index, hip_mm));
        (self.hip_sum, self.hip_n, self.skin_sum) = (Vec3::ZERO, 0, Vec3::ZERO);
        frame
    }

    /// The frame that the recording ends in.
    pub(super) fn finish(&mut self) -> Option<Frame> {
        (self.frame.sums.ticks > 0).then(|| self.take())
    }
}

/// Whether a limit changed the force, where force was wanted.
fn limited(limits: LimitFlags) -> bool {
    const ACTED: [LimitFlags; 4] = [
        LimitFlags::NOT_FINITE,
        LimitFlags::RATED,
        LimitFlags::RISE,
        LimitFlags::PASSIVITY,
    ];
    ACTED.iter().any(|l| limits.has(*l))
}
