//! Faults and pops of a run, told by the records themselves: noticed beside the tick, written at their onset.

use super::format;
use super::pops::Pops;
use crate::servo::{FingerRecord, LimitFlags, MAX_FINGERS};

/// Ticks after the onset of a fault in which the same one is not told again.
const QUIET_TICKS: u64 = 1000;

/// Watches records for devices that stop answering, late ticks, forces that are not finite and fingers that pop.
#[derive(Debug, Default)]
pub(super) struct Faults {
    connected: [Option<bool>; MAX_FINGERS],
    late: Watch,
    not_finite: [Watch; MAX_FINGERS],
    lost: [Watch; MAX_FINGERS],
    pops: Pops,
    popped: [Watch; MAX_FINGERS],
    /// It was told that the device does not answer.
    away: [bool; MAX_FINGERS],
}

/// One sort of fault.
#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    on: bool,
    told: Option<u64>,
    /// Onsets since it was told.
    untold: u64,
}

impl Watch {
    /// Whether the onset of the fault is to be told, and how many were not told before it.
    fn rises(&mut self, on: bool, tick: u64) -> Option<u64> {
        let onset = on && !self.on;
        self.on = on;
        if !onset {
            return None;
        }
        let told = self.told.filter(|t| tick >= *t);
        if told.is_some_and(|t| tick - t < QUIET_TICKS) {
            self.untold += 1;
            return None;
        }
        self.told = Some(tick);
        Some(std::mem::take(&mut self.untold))
    }
}

impl Faults {
    /// Looks at a record that was written; `tell` gets kind and text of what is to be written about it.
    pub(super) fn seen<E>(
        &mut self,
        record: &FingerRecord,
        mut tell: impl FnMut(&str, &str) -> Result<(), E>,
    ) -> Result<(), E> {
        let (finger, tick) = (usize::from(record.finger), record.tick);
        if finger >= MAX_FINGERS {
            return Ok(());
        }
        let more = |untold: u64| match untold {
            0 => String::new(),
            n => format!("; {n} more since it was told last"),
        };
        let connected = record.reading.connected;
        let was = self.connected[finger].replace(connected);
        let lost = self.lost[finger].rises(was == Some(true) && !connected, tick);
        if let Some(untold) = lost {
            let text = format!("device of finger {finger} does not answer{}", more(untold));
            self.away[finger] = true;
            tell(format::FAULT, &text)?;
        }
        if connected && std::mem::take(&mut self.away[finger]) {
            let text = format!("device of finger {finger} answers");
            tell(format::FAULT, &text)?;
        }
        let not_finite = record.limits.has(LimitFlags::NOT_FINITE);
        if let Some(untold) = self.not_finite[finger].rises(not_finite, tick) {
            let text = format!("force of finger {finger} was not finite{}", more(untold));
            tell(format::FAULT, &text)?;
        }
        let pop = self.pops.seen(record);
        if let Some(untold) = self.popped[finger].rises(pop.is_some(), tick)
            && let Some(text) = pop
        {
            tell(format::POP, &format!("{text}{}", more(untold)))?;
        }
        // A tick is late for all fingers: told once.
        if finger == 0
            && let Some(untold) = self.late.rises(record.late, tick)
        {
            let text = format!("tick later than the watchdog allows{}", more(untold));
            tell(format::FAULT, &text)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(records: &[FingerRecord]) -> Vec<(u64, String)> {
        let mut faults = Faults::default();
        let mut said = Vec::new();
        for r in records {
            let told: Result<(), ()> = faults.seen(r, |kind, text| {
                assert_eq!(kind, "fault");
                said.push((r.tick, text.to_owned()));
                Ok(())
            });
            assert_eq!(told, Ok(()));
        }
        said
    }

    fn record(tick: u64, connected: bool, late: bool) -> FingerRecord {
        let mut r = FingerRecord {
            tick,
            late,
            ..FingerRecord::default()
        };
        r.reading.connected = connected;
        r
    }

    #[test]
    fn a_device_that_stops_and_comes_back_is_told_once_each() {
        let run: Vec<_> = (0..3000)
            .map(|t| record(t, !(100..1500).contains(&t), false))
            .collect();
        let said = told(&run);
        let ticks: Vec<_> = said.iter().map(|(tick, _)| *tick).collect();
        assert_eq!(ticks, [100, 1500], "{said:?}");
        assert!(said[0].1.contains("does not answer") && said[1].1.ends_with("answers"));
        // One that was never there is no fault.
        assert!(told(&[record(0, false, false), record(1, false, false)]).is_empty());
    }

    #[test]
    fn late_ticks_are_told_at_their_onset_and_not_more_than_once_in_a_while() {
        let run: Vec<_> = (0..2500).map(|t| record(t, true, t % 100 < 2)).collect();
        let said = told(&run);
        let ticks: Vec<_> = said.iter().map(|(tick, _)| *tick).collect();
        assert_eq!(ticks, [0, 1000, 2000]);
        assert!(said[1].1.contains("9 more"), "{said:?}");
    }
}
