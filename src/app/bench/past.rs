//! The plotted past of a recording: streamed from the file on a thread of its own, shown as far as it is read.

use super::Wake;
use super::job::Job;
use crate::app::history::History;
use crate::app::state::BuildStatus;
use crate::contact::Touch;
use crate::servo::FingerRecord;
use crate::session::{Entry, Session, Strictness, Timeline};
use crate::units::{NS_PER_S, s_from_ns};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Records handed over at a time: the plots wait for about a millisecond.
const BATCH: usize = 4096;
/// The window is woken no oftener while the file is read.
const TOLD: Duration = Duration::from_millis(50);
/// How far the plots reach tick by tick to either side of the present instant, s.
const NEAR_S: f64 = 30.0;
/// They are read anew when the instant comes this close to the end of that, s.
const MARGIN_S: f64 = 10.0;
/// Recordings up to this length are kept tick by tick as a whole, s.
const SHORT_S: f64 = 60.0;

/// What one recording was, for the plots.
pub struct Past {
    timeline: Timeline,
    wake: Wake,
    history: Arc<Mutex<History>>,
    first_contact_s: Arc<OnceLock<f64>>,
    fill: Option<Job<()>>,
    near: Option<Job<Option<(f64, History)>>>,
    /// The instant that [`History::set_near`] was last read about.
    about_s: Option<f64>,
}

impl Past {
    /// Starts reading. Nothing is plotted of it where the system refuses a thread.
    pub fn of(timeline: &Timeline, wake: &Wake) -> Self {
        let rate_hz = timeline.header().rate_hz;
        let history = Arc::new(Mutex::new(History::new(rate_hz)));
        let first_contact_s = Arc::new(OnceLock::new());
        let (session, start_ns) = (timeline.session().clone(), timeline.span_ns().0);
        let (shared, contact) = (history.clone(), first_contact_s.clone());
        let work = move |progress: super::job::Progress<'_>| {
            fill(&session, start_ns, &shared, &contact, progress);
        };
        let fill = Job::start("replay plots", BuildStatus::default(), wake.clone(), work);
        Self {
            timeline: timeline.clone(),
            wake: wake.clone(),
            history,
            first_contact_s,
            fill: fill.ok(),
            near: None,
            about_s: None,
        }
    }

    /// Its plots, as far as they are read.
    pub fn history(&self) -> &Arc<Mutex<History>> {
        &self.history
    }

    /// Share of the file that is read, 0 to 1; `None` once all is.
    pub fn progress(&self) -> Option<f64> {
        self.fill.as_ref().map(|job| job.status().fraction)
    }

    /// When a finger first touched the skin, s from the start; `None` until that is read.
    pub fn first_contact_s(&self) -> Option<f64> {
        self.first_contact_s.get().copied()
    }

    /// Takes over what was read, and reads what is plotted tick by tick about `at_s`. Answers whether there is more to see.
    pub fn follow(&mut self, at_s: f64) -> bool {
        let mut changed = self.fill.is_some();
        if self
            .fill
            .as_ref()
            .is_some_and(|job| job.poll(|| ()).is_some())
        {
            self.fill = None;
        }
        if let Some(read) = self.near.as_ref().and_then(|job| job.poll(|| None)) {
            self.near = None;
            if let Some((about_s, near)) = read {
                self.about_s = Some(about_s);
                let mut history = self.history.lock().unwrap_or_else(PoisonError::into_inner);
                history.set_near(near);
                changed = true;
            }
        }
        let reached = |about_s: f64| (at_s - about_s).abs() <= NEAR_S - MARGIN_S;
        if self.timeline.duration_s() > SHORT_S
            && self.near.is_none()
            && !self.about_s.is_some_and(reached)
        {
            let timeline = self.timeline.clone();
            let work = move |progress: super::job::Progress<'_>| near(&timeline, at_s, progress);
            let job = Job::start(
                "replay detail",
                BuildStatus::default(),
                self.wake.clone(),
                work,
            );
            self.near = job.ok();
        }
        changed
    }
}

/// Streams a file into `history`, from time zero.
fn fill(
    session: &Session,
    start_ns: u64,
    history: &Mutex<History>,
    first_contact_s: &OnceLock<f64>,
    progress: super::job::Progress<'_>,
) {
    let Ok(mut entries) = session.entries(Strictness::Lenient) else {
        return;
    };
    let mut batch: Vec<FingerRecord> = Vec::with_capacity(BATCH);
    let mut told = Instant::now();
    loop {
        let entry = entries.next();
        let more = match entry {
            Some(Ok(Entry::Tick(mut record))) => {
                record.time_ns = record.time_ns.saturating_sub(start_ns);
                if record.contact.touch != Touch::Free {
                    first_contact_s.get_or_init(|| s_from_ns(record.time_ns));
                }
                batch.push(record);
                true
            }
            Some(Ok(_)) => true,
            // What was read until the disk refused is plotted.
            Some(Err(_)) | None => false,
        };
        if batch.len() == BATCH || !more {
            let mut history = history.lock().unwrap_or_else(PoisonError::into_inner);
            for record in batch.drain(..) {
                history.push(&record);
            }
            drop(history);
            let due = told.elapsed() >= TOLD;
            if due {
                told = Instant::now();
            }
            if due && !progress("plots", entries.progress()) || !more {
                return;
            }
        }
    }
}

/// The ticks about `at_s`, from the same file opened once more: what the window asks for meanwhile stays in its cache.
fn near(
    timeline: &Timeline,
    at_s: f64,
    progress: super::job::Progress<'_>,
) -> Option<(f64, History)> {
    let own = Timeline::open(timeline.session().path()).ok()?;
    let rate_hz = own.header().rate_hz;
    let mut history = History::new(rate_hz);
    let (start_ns, end_ns) = own.span_ns();
    let ns = |s: f64| start_ns.saturating_add((s.max(0.0) * NS_PER_S) as u64);
    let to_ns = ns(at_s + NEAR_S).min(end_ns);
    // At most as many as the finest plot holds.
    let step_ns = ((NS_PER_S / rate_hz) as u64).max(1_000_000);
    let mut now_ns = ns(at_s - NEAR_S);
    let mut last = [None; crate::servo::MAX_FINGERS];
    let mut steps = 0_u32;
    while now_ns <= to_ns {
        let tick = own.at_ns(now_ns);
        for (record, last) in tick.fingers().iter().zip(&mut last) {
            if *last != Some(record.tick) {
                *last = Some(record.tick);
                history.push(&FingerRecord {
                    time_ns: record.time_ns.saturating_sub(start_ns),
                    ..*record
                });
            }
        }
        now_ns = now_ns.saturating_add(step_ns);
        steps += 1;
        if steps.is_multiple_of(4096) && !progress("detail", 0.0) {
            return None;
        }
    }
    Some((at_s, history))
}
