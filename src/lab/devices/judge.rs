//! What a failed press came to, told from the emulator's truth and from the file.

use crate::device::hid::emulator::truth::Truth;
use crate::session::{IfExists, RecoverOptions, Session, SessionError, Strictness, recover};
use std::path::Path;

/// Force that is none: what is left of a current that decays, N.
const NONE_N: f64 = 0.02;
/// A host that was held up brings force back for a tick or two at most before it notices; none for this long is none, s.
const SETTLED_S: f64 = 0.003;

/// The force at the motors after a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Force {
    /// Just before it, N.
    pub(super) before_n: f64,
    /// Highest since, N.
    pub(super) highest_n: f64,
    /// From the fault until none was commanded for 3 ms, ms; nothing: never.
    pub(super) gone_ms: Option<f64>,
    /// Highest that was commanded after that, N.
    pub(super) again_n: f64,
    /// Longest between two of the emulator's milliseconds from the fault until then, ms.
    pub(super) held_up_ms: f64,
}

impl Force {
    /// What the truth tells about a fault at `fault_at_s`.
    pub(super) fn of(truths: &[Truth], fault_at_s: f64) -> Self {
        let from = truths.partition_point(|t| t.at_s < fault_at_s);
        let before_n = truths[..from].last().map_or(0.0, |t| t.flowing_n.length());
        let since = &truths[from..];
        let is_none = |t: &Truth| t.commanded_n.length() <= NONE_N;
        let gone = (0..since.len()).find(|&i| {
            let settled = since[i..]
                .iter()
                .take_while(|t| t.at_s <= since[i].at_s + SETTLED_S);
            settled.clone().all(is_none)
        });
        let until = gone.map_or(since.len(), |i| i + 1);
        let mut last_s = truths[..from].last().map_or(fault_at_s, |t| t.at_s);
        let mut held_up_ms: f64 = 0.0;
        for t in &since[..until] {
            held_up_ms = held_up_ms.max((t.at_s - last_s) * 1e3);
            last_s = t.at_s;
        }
        let highest = |f: fn(&Truth) -> f64, rows: &[Truth]| rows.iter().map(f).fold(0.0, f64::max);
        Self {
            before_n,
            highest_n: highest(|t| t.flowing_n.length(), since),
            gone_ms: gone.map(|i| ((since[i].at_s - fault_at_s) * 1e3).max(0.0)),
            again_n: highest(|t| t.commanded_n.length(), &since[until..]),
            held_up_ms,
        }
    }
}

/// What a recording came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct File {
    /// It reads whole, strictly, from its start to its proper end.
    pub(super) clean: bool,
    /// It reads, if need be after having been saved.
    pub(super) readable: bool,
    /// In words.
    pub(super) told: String,
    /// What it says went wrong.
    pub(super) faults: Vec<String>,
    /// Ticks in it.
    pub(super) ticks: usize,
}

impl File {
    /// Looks at the recording at `path`; one without a proper end is saved first.
    pub(super) fn of(path: &Path) -> Self {
        match Self::read(path) {
            Ok(file) => Self {
                clean: true,
                told: "whole".into(),
                ..file
            },
            Err(e) => {
                let out = path.with_extension("saved.mcap");
                let options = RecoverOptions {
                    if_exists: IfExists::Replace,
                    ..RecoverOptions::default()
                };
                let saved =
                    recover(path, &out, &options, &mut |_| true).and_then(|_| Self::read(&out));
                let _ = std::fs::remove_file(&out);
                match saved {
                    Ok(file) => Self {
                        told: "unfinished, saved by recover".into(),
                        ..file
                    },
                    Err(_) => Self {
                        told: e.to_string(),
                        ..Self::default()
                    },
                }
            }
        }
    }

    fn read(path: &Path) -> Result<Self, SessionError> {
        let read = Session::open(path)?.load(Strictness::Strict)?;
        let faults = read.events.iter().filter(|e| e.kind == "fault");
        Ok(Self {
            clean: false,
            readable: read.damage.is_none(),
            told: String::new(),
            faults: faults.map(|e| e.text.clone()).collect(),
            ticks: read.fingers.first().map_or(0, Vec::len),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Vec3;

    fn rows(commanded_n: impl Fn(usize) -> f64) -> Vec<Truth> {
        let row = |i: usize| Truth {
            at_s: i as f64 * 1e-3,
            commanded_n: Vec3::Z * commanded_n(i),
            flowing_n: Vec3::Z * commanded_n(i.saturating_sub(1)),
            ..Truth::default()
        };
        (0..200).map(row).collect()
    }

    #[test]
    fn force_is_gone_when_it_stays_gone_for_a_while() {
        let f = Force::of(&rows(|i| if i < 110 { 2.0 } else { 0.0 }), 0.1);
        assert_eq!((f.before_n, f.highest_n, f.again_n), (2.0, 2.0, 0.0));
        assert!((f.gone_ms.expect("gone") - 10.0).abs() < 1e-9, "{f:?}");
        assert!((f.held_up_ms - 1.0).abs() < 1e-9);
        // A tick without force is none yet; force that comes back later is told.
        let f = Force::of(
            &rows(|i| match i {
                105 | 110..150 => 0.0,
                _ => 2.5,
            }),
            0.1,
        );
        assert!((f.gone_ms.expect("gone") - 10.0).abs() < 1e-9, "{f:?}");
        assert_eq!(f.again_n, 2.5);
        assert_eq!(Force::of(&rows(|_| 1.0), 0.1).gone_ms, None);
        assert_eq!(Force::of(&[], 0.1), Force::default());
    }
}
