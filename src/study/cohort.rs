//! Many files at once: as many threads as are asked for, results in the order of the files, in memory that does not grow with
//! their number.
//!
//! What a file tells is a pure function of that file ([`super::analyse()`]). So the same work can be spread over processes and
//! machines without this module; see [`super::export`] for the layout that their results share.

use super::{Analysis, Options, StudyError, analyse};
use crate::session::Session;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Files that may be begun before the one whose result is due, for each thread: a slow file does not hold up the others at
/// once, and finished results do not pile up.
const AHEAD: usize = 4;

/// How often `progress` is called while nothing is finished.
const TELL: Duration = Duration::from_millis(100);

/// Work on one file: gets the file, its place in the list, and whom to tell the share done, which answers whether to go on.
pub type Work<'a, T> = &'a (dyn Fn(usize, &Path, &mut dyn FnMut(f64) -> bool) -> T + Sync);

/// As many threads as there are processors.
pub fn default_jobs() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Analyses `files` with `jobs` threads. `each` gets the place in the list and the result, in the order of the list; what is
/// wrong with one file is its result, and the others go on. `progress` gets the share of all bytes that is done and answers
/// whether to go on.
///
/// # Errors
/// [`StudyError::Stopped`] when `progress` said so; an option is not allowed.
pub fn run(
    files: &[PathBuf],
    jobs: usize,
    options: &Options,
    progress: &mut dyn FnMut(f64) -> bool,
    each: &mut dyn FnMut(usize, Result<Analysis, StudyError>),
) -> Result<(), StudyError> {
    options.check()?;
    let work = |_: usize, path: &Path, done: &mut dyn FnMut(f64) -> bool| {
        analyse(&Session::open(path)?, options, done)
    };
    map(files, jobs, &work, progress, each)
}

/// Does `work` for each of `files` with `jobs` threads, as [`run`] does.
///
/// # Errors
/// [`StudyError::Stopped`] when `progress` said so.
pub fn map<T: Send>(
    files: &[PathBuf],
    jobs: usize,
    work: Work<'_, T>,
    progress: &mut dyn FnMut(f64) -> bool,
    each: &mut dyn FnMut(usize, T),
) -> Result<(), StudyError> {
    let jobs = jobs.clamp(1, files.len().max(1));
    let bytes: Vec<u64> = files.iter().map(|f| size_of(f)).collect();
    let pool = Pool {
        files,
        bytes: &bytes,
        ahead: AHEAD * jobs,
        state: Mutex::new(State {
            next: 0,
            delivered: 0,
            ready: BTreeMap::new(),
        }),
        changed: Condvar::new(),
        stop: AtomicBool::new(false),
        done: AtomicU64::new(0),
    };
    let whole = bytes.iter().sum::<u64>().max(1) as f64;
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| pool.work(work));
        }
        // Whatever ends this thread's part ends that of the others.
        let _end = StopOnDrop(&pool);
        for due in 0..files.len() {
            let result = loop {
                if !progress(pool.done.load(Ordering::Relaxed) as f64 / whole) {
                    return Err(StudyError::Stopped);
                }
                match pool.take(due) {
                    Some(result) => break result,
                    None if pool.stop.load(Ordering::Relaxed) => return Err(StudyError::Stopped),
                    None => {}
                }
            };
            each(due, result);
        }
        match progress(1.0) {
            true => Ok(()),
            false => Err(StudyError::Stopped),
        }
    })
}

fn size_of(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(1, |m| m.len().max(1))
}

struct State<T> {
    /// First file that nobody has begun.
    next: usize,
    /// Files whose result was handed on.
    delivered: usize,
    /// Results that wait for their turn.
    ready: BTreeMap<usize, T>,
}

struct Pool<'a, T> {
    files: &'a [PathBuf],
    bytes: &'a [u64],
    ahead: usize,
    state: Mutex<State<T>>,
    changed: Condvar,
    stop: AtomicBool,
    /// Bytes of the files that are done.
    done: AtomicU64,
}

struct StopOnDrop<'a, 'b, T>(&'a Pool<'b, T>);

impl<T> Drop for StopOnDrop<'_, '_, T> {
    fn drop(&mut self) {
        self.0.stop.store(true, Ordering::Relaxed);
        self.0.changed.notify_all();
    }
}

impl<T> Pool<'_, T> {
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One thread: file after file until none is left.
    fn work(&self, work: Work<'_, T>) {
        while let Some(i) = self.begin() {
            // A panic in `work` must not leave the others waiting for this file.
            let guard = StopOnDrop(self);
            let mut counted = 0_u64;
            let result = work(i, &self.files[i], &mut |share| {
                let bytes = (share.clamp(0.0, 1.0) * self.bytes[i] as f64) as u64;
                let more = bytes.saturating_sub(counted);
                counted += more;
                self.done.fetch_add(more, Ordering::Relaxed);
                !self.stop.load(Ordering::Relaxed)
            });
            std::mem::forget(guard);
            let rest = self.bytes[i].saturating_sub(counted);
            self.done.fetch_add(rest, Ordering::Relaxed);
            self.lock().ready.insert(i, result);
            self.changed.notify_all();
        }
    }

    /// The next file, as soon as it may be begun; `None` at the end.
    fn begin(&self) -> Option<usize> {
        let mut state = self.lock();
        loop {
            if state.next >= self.files.len() || self.stop.load(Ordering::Relaxed) {
                return None;
            }
            if state.next < state.delivered + self.ahead {
                state.next += 1;
                return Some(state.next - 1);
            }
            let waited = self.changed.wait_timeout(state, TELL);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// The result of file `due`, waited for no longer than [`TELL`].
    fn take(&self, due: usize) -> Option<T> {
        let mut state = self.lock();
        if !state.ready.contains_key(&due) {
            let waited = self.changed.wait_timeout(state, TELL);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let result = state.ready.remove(&due)?;
        state.delivered += 1;
        drop(state);
        self.changed.notify_all();
        Some(result)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    fn files(n: usize) -> Vec<PathBuf> {
        (0..n).map(|i| PathBuf::from(format!("{i}"))).collect()
    }

    #[test]
    fn results_come_in_the_order_of_the_files_and_never_pile_up() {
        let n = 200;
        for jobs in [1, 3, 16, 1000] {
            let held = AtomicUsize::new(0);
            let most = AtomicUsize::new(0);
            let work = |i: usize, path: &Path, _: &mut dyn FnMut(f64) -> bool| {
                most.fetch_max(held.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                // The first of every ten keeps the others waiting.
                if i.is_multiple_of(10) {
                    std::thread::sleep(Duration::from_millis(2));
                }
                path.to_string_lossy().parse::<usize>().expect("a number")
            };
            let mut seen = Vec::new();
            let mut shares = Vec::new();
            map(
                &files(n),
                jobs,
                &work,
                &mut |share| {
                    shares.push(share);
                    true
                },
                &mut |i, result| {
                    held.fetch_sub(1, Ordering::SeqCst);
                    seen.push((i, result));
                },
            )
            .expect("not stopped");
            assert!(seen.iter().copied().eq((0..n).map(|i| (i, i))));
            assert!(shares.is_sorted() && shares.last() == Some(&1.0));
            assert!(most.load(Ordering::SeqCst) <= AHEAD * jobs.min(n) + 1);
        }
    }

    #[test]
    fn whoever_says_stop_is_heard_by_work_under_way() {
        let work = |_: usize, _: &Path, go_on: &mut dyn FnMut(f64) -> bool| {
            while go_on(0.5) {
                std::thread::yield_now();
            }
        };
        let mut calls = 0;
        let stopped = map(
            &files(5),
            2,
            &work,
            &mut |_| {
                calls += 1;
                calls < 3
            },
            &mut |_, ()| panic!("nothing is ever finished"),
        );
        assert!(matches!(stopped, Err(StudyError::Stopped)));
    }

    #[test]
    fn no_files_are_done_at_once() {
        let work = |_: usize, _: &Path, _: &mut dyn FnMut(f64) -> bool| ();
        assert!(map(&[], 4, &work, &mut |_| true, &mut |_, ()| ()).is_ok());
    }
}
