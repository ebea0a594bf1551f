//! A session in memory.

use super::format::{Edit, Event};
use super::header::Header;
use super::playback::Source;
use super::records::Damage;
use crate::servo::{FingerRecord, MAX_FINGERS, TickRecord};

/// A session in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    /// What the run was.
    pub header: Header,
    /// Every tick of each finger, tick numbers strictly increasing.
    pub fingers: Vec<Vec<FingerRecord>>,
    /// Every event.
    pub events: Vec<Event>,
    /// Every edit of the scene.
    pub edits: Vec<Edit>,
    /// What could not be read.
    pub damage: Damage,
}

impl Recording {
    /// The scenario after edit `number`; `None` where its text is not in the file.
    pub fn scenario_after(&self, number: u32) -> Option<&str> {
        self.header.scenario_after(number, &self.edits)
    }
}

impl Source for Recording {
    fn header(&self) -> &Header {
        &self.header
    }

    fn span_ns(&self) -> (u64, u64) {
        let firsts = self.fingers.iter().filter_map(|f| f.first());
        let first_ns = firsts.map(|r| r.time_ns).min().unwrap_or(0);
        let lasts = self.fingers.iter().filter_map(|f| f.last());
        let last_ns = lasts.map(|r| r.time_ns).max().unwrap_or(0);
        (first_ns, last_ns.max(first_ns))
    }

    fn events(&self) -> &[Event] {
        &self.events
    }

    fn at_ns(&self, time_ns: u64) -> TickRecord {
        let mut view = TickRecord {
            n_fingers: self.fingers.len().min(MAX_FINGERS),
            ..TickRecord::default()
        };
        for (shown, finger) in view.fingers.iter_mut().zip(&self.fingers) {
            let newest = finger.partition_point(|r| r.time_ns <= time_ns).max(1) - 1;
            if let Some(record) = finger.get(newest) {
                *shown = *record;
            }
        }
        view
    }

    fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64> {
        let line = self.fingers.first().filter(|f| !f.is_empty())?;
        let present = line.partition_point(|r| r.time_ns <= time_ns) as i64 - 1;
        let target = present
            .saturating_add(ticks)
            .clamp(0, line.len() as i64 - 1);
        Some(line[target as usize].time_ns)
    }
}
