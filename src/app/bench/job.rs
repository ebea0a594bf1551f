//! Long work on a thread of its own, with progress and cancel.

use super::Wake;
use crate::app::state::BuildStatus;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};

/// Told what is being done and a fraction 0…1; answers whether to go on.
pub type Progress<'a> = &'a mut dyn FnMut(&str, f64) -> bool;

/// Work under way that comes to a `T`. Dropping it asks it to stop.
pub struct Job<T> {
    status: Arc<Mutex<BuildStatus>>,
    cancel: Arc<AtomicBool>,
    result: mpsc::Receiver<T>,
}

impl<T: Send + 'static> Job<T> {
    /// Starts `work` on a thread called `name`, with `status` on show until it says more. `wake` is called when there is
    /// something new to show.
    ///
    /// # Errors
    /// When the system refuses another thread.
    pub fn start(
        name: &str,
        status: BuildStatus,
        wake: Wake,
        work: impl FnOnce(Progress<'_>) -> T + Send + 'static,
    ) -> std::io::Result<Self> {
        let status = Arc::new(Mutex::new(status));
        let cancel = Arc::new(AtomicBool::new(false));
        let (send, result) = mpsc::sync_channel(1);
        let (shared, stop) = (status.clone(), cancel.clone());
        std::thread::Builder::new()
            .name(name.into())
            .spawn(move || {
                let mut progress = |part: &str, fraction: f64| {
                    let mut status = shared.lock().unwrap_or_else(PoisonError::into_inner);
                    part.clone_into(&mut status.part);
                    status.fraction = fraction;
                    drop(status);
                    wake();
                    !stop.load(Ordering::Relaxed)
                };
                // The bench may have gone in the meantime.
                let _ = send.send(work(&mut progress));
                wake();
            })?;
        Ok(Self {
            status,
            cancel,
            result,
        })
    }

    /// How far it is.
    pub fn status(&self) -> BuildStatus {
        self.status
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// Asks it to stop at the next step.
    pub fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The outcome, once there is one; `lost` makes one for work that broke off.
    pub fn poll(&self, lost: impl FnOnce() -> T) -> Option<T> {
        match self.result.try_recv() {
            Ok(outcome) => Some(outcome),
            Err(mpsc::TryRecvError::Empty) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(lost()),
        }
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}
