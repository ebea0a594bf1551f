//! What is plugged in and pulled out while the program runs. Looks by listing again, never from the servo.

use super::{Found, all};
use crate::device::hid::attached;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// What changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// It was plugged in.
    Came(Found),
    /// It was pulled out.
    Went(Found),
}

/// What changed from one look to the next: first what went, then what came. A place that another device took is both.
pub fn changes(before: &[Found], now: &[Found]) -> Vec<Change> {
    let missing = |from: &[Found], of: &Found| {
        !from.iter().any(|f| {
            (f.family, &f.place, &f.serial, &f.title)
                == (of.family, &of.place, &of.serial, &of.title)
        })
    };
    let went = before.iter().filter(|f| missing(now, f));
    let came = now.iter().filter(|f| missing(before, f));
    went.cloned()
        .map(Change::Went)
        .chain(came.cloned().map(Change::Came))
        .collect()
}

/// A look at every family that may be asked again and again. Devices are opened to be told apart only when the list changed.
pub fn looker() -> impl FnMut() -> Vec<Found> + Send + 'static {
    let mut seen: Option<Vec<String>> = None;
    let mut found = Vec::new();
    move || {
        let now = attached::paths();
        if seen.as_ref() != Some(&now) {
            let families = all().iter().filter(|f| f.may_be_watched());
            found = families.flat_map(|f| f.find()).collect();
            seen = Some(now);
        }
        found.clone()
    }
}

/// Most changes that wait to be heard.
const WAITING: usize = 64;

/// A thread that looks again and again, until it is dropped.
#[derive(Debug)]
pub struct Watch {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watch {
    /// Looks every so often; what there is at first comes as plugged in.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn start(
        mut look: impl FnMut() -> Vec<Found> + Send + 'static,
        every: Duration,
    ) -> io::Result<(Self, Receiver<Change>)> {
        let (changed, heard) = sync_channel(WAITING);
        let stop = Arc::new(AtomicBool::new(false));
        let in_thread = Arc::clone(&stop);
        let thread = std::thread::Builder::new()
            .name("device watch".into())
            .spawn(move || {
                let mut known: Vec<Found> = Vec::new();
                while !in_thread.load(Ordering::Acquire) {
                    for change in changes(&known, &look()) {
                        match changed.try_send(change.clone()) {
                            Ok(()) => {}
                            // Nobody hears: it is told with the next look.
                            Err(TrySendError::Full(_)) => break,
                            Err(TrySendError::Disconnected(_)) => return,
                        }
                        match change {
                            Change::Came(f) => known.push(f),
                            Change::Went(f) => known.retain(|k| *k != f),
                        }
                    }
                    std::thread::park_timeout(every);
                }
            })?;
        let watch = Self {
            stop,
            thread: Some(thread),
        };
        Ok((watch, heard))
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            drop(thread.join());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    fn found(place: &str, serial: &str) -> Found {
        Found {
            family: "f",
            place: place.into(),
            title: "F".into(),
            serial: Some(serial.into()),
            note: None,
        }
    }

    #[test]
    fn a_place_taken_by_another_device_went_and_came() {
        let (a, b, other) = (found("1", "a"), found("2", "b"), found("1", "c"));
        assert_eq!(changes(&[], &[]), []);
        let both = [a.clone(), b.clone()];
        assert_eq!(changes(&both, &both), []);
        assert_eq!(changes(&both, &both[..1]), [Change::Went(b.clone())]);
        let expected = [Change::Went(a), Change::Came(other.clone())];
        assert_eq!(changes(&both, &[b, other]), expected);
    }

    #[test]
    fn what_is_plugged_in_and_pulled_out_is_heard_in_order() {
        let there = Arc::new(Mutex::new(vec![found("1", "a")]));
        let looked_at = Arc::clone(&there);
        let look = move || looked_at.lock().map(|l| l.clone()).unwrap_or_default();
        let (watch, heard) = Watch::start(look, Duration::from_millis(1)).expect("started");
        let next = || {
            heard
                .recv_timeout(Duration::from_secs(10))
                .expect("a change")
        };
        assert_eq!(next(), Change::Came(found("1", "a")));
        there.lock().expect("lock").push(found("2", "b"));
        assert_eq!(next(), Change::Came(found("2", "b")));
        there.lock().expect("lock").remove(0);
        assert_eq!(next(), Change::Went(found("1", "a")));
        drop(watch);
        assert!(heard.recv().is_err(), "the watch has ended");
    }

    #[test]
    fn more_changes_than_are_heard_are_told_later() {
        let many: Vec<Found> = (0..3 * WAITING)
            .map(|i| found(&i.to_string(), "x"))
            .collect();
        let all_of_them = many.clone();
        let (_watch, heard) =
            Watch::start(move || all_of_them.clone(), Duration::from_millis(1)).expect("started");
        for f in many {
            let change = heard
                .recv_timeout(Duration::from_secs(10))
                .expect("a change");
            assert_eq!(change, Change::Came(f));
        }
    }

    #[test]
    fn looking_twice_tells_the_same() {
        let mut look = looker();
        assert_eq!(look(), look());
    }
}
