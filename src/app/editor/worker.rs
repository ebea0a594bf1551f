//! Work off the window's thread where only the newest wish counts.

use crate::app::bench::Wake;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A piece of work; it asks now and then whether to go on and returns nothing when not.
type Work<T> = Box<dyn FnOnce(&dyn Fn() -> bool) -> Option<T> + Send>;

/// At most one thread at a time, and none while nothing is asked.
pub struct Worker<T> {
    name: &'static str,
    running: Option<Running<T>>,
    waiting: Option<Work<T>>,
}

struct Running<T> {
    stop: Arc<AtomicBool>,
    done: Arc<Mutex<Option<Option<T>>>>,
}

impl<T: Send + 'static> Worker<T> {
    /// A worker whose threads are called `name`.
    pub fn new(name: &'static str) -> Self {
        Self {
            name,
            running: None,
            waiting: None,
        }
    }

    /// Asks for `work` once what runs has ended; what waited before is forgotten. With `hurry` what runs is told to stop.
    pub fn ask(
        &mut self,
        hurry: bool,
        work: impl FnOnce(&dyn Fn() -> bool) -> Option<T> + Send + 'static,
        wake: &Wake,
    ) {
        self.waiting = Some(Box::new(work));
        if hurry && let Some(running) = &self.running {
            running.stop.store(true, Ordering::Relaxed);
        }
        if self.running.is_none() {
            self.start(wake);
        }
    }

    /// The result that came since the last call; starts what waits.
    pub fn poll(&mut self, wake: &Wake) -> Option<T> {
        let running = self.running.as_ref()?;
        let done = running
            .done
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take()?;
        self.running = None;
        if self.waiting.is_some() {
            self.start(wake);
        }
        done
    }

    /// Whether something runs or waits.
    pub fn is_busy(&self) -> bool {
        self.running.is_some()
    }

    /// Forgets everything asked.
    pub fn stop(&mut self) {
        self.waiting = None;
        if let Some(running) = self.running.take() {
            running.stop.store(true, Ordering::Relaxed);
        }
    }

    fn start(&mut self, wake: &Wake) {
        let Some(work) = self.waiting.take() else {
            return;
        };
        let running = Running {
            stop: Arc::new(AtomicBool::new(false)),
            done: Arc::new(Mutex::new(None)),
        };
        let (stop, done, wake) = (running.stop.clone(), running.done.clone(), wake.clone());
        let spawned = std::thread::Builder::new()
            .name(self.name.into())
            .spawn(move || {
                // Set whatever happens to the work, so that a worker never waits for a thread that is gone.
                struct Finish<T>(Arc<Mutex<Option<Option<T>>>>, Option<T>, Wake);
                impl<T> Drop for Finish<T> {
                    fn drop(&mut self) {
                        let mut slot = self.0.lock().unwrap_or_else(PoisonError::into_inner);
                        *slot = Some(self.1.take());
                        drop(slot);
                        (self.2)();
                    }
                }
                let mut finish = Finish(done, None, wake);
                finish.1 = work(&|| !stop.load(Ordering::Relaxed));
            });
        match spawned {
            Ok(_) => self.running = Some(running),
            Err(e) => log::warn!("{} cannot start: {e}", self.name),
        }
    }
}

impl<T> Drop for Worker<T> {
    fn drop(&mut self) {
        if let Some(running) = &self.running {
            running.stop.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::sync_channel;
    use std::time::Duration;

    fn wake() -> Wake {
        Arc::new(|| {})
    }

    fn wait<T: Send + 'static>(worker: &mut Worker<T>) -> Option<T> {
        while worker.is_busy() {
            if let Some(done) = worker.poll(&wake()) {
                return Some(done);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        None
    }

    #[test]
    fn of_many_wishes_the_first_and_the_newest_are_done() {
        let (go, held) = sync_channel::<()>(1);
        let mut worker = Worker::new("test");
        worker.ask(false, move |_| held.recv().ok().map(|()| 0), &wake());
        for i in 1..10 {
            worker.ask(false, move |_| Some(i), &wake());
        }
        go.send(()).expect("the first waits");
        assert_eq!(wait(&mut worker), Some(0));
        assert_eq!(wait(&mut worker), Some(9));
        assert!(!worker.is_busy());
    }

    #[test]
    fn a_wish_in_a_hurry_stops_what_runs() {
        let mut worker = Worker::new("test");
        let forever = |go_on: &dyn Fn() -> bool| {
            while go_on() {
                std::thread::sleep(Duration::from_millis(1));
            }
            None
        };
        worker.ask(false, forever, &wake());
        worker.ask(true, |_| Some(1), &wake());
        assert_eq!(wait(&mut worker), Some(1));
    }

    #[test]
    fn work_that_panics_leaves_the_worker_usable() {
        let mut worker: Worker<i32> = Worker::new("test that panics");
        worker.ask(false, |_| panic!("expected in this test"), &wake());
        assert_eq!(wait(&mut worker), None);
        worker.ask(false, |_| Some(3), &wake());
        assert_eq!(wait(&mut worker), Some(3));
    }
}
