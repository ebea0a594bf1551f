//! The end of all force at once, whoever asks for it: a signal, a panic anywhere, the window's close.
//!
//! One atomic for the whole process, which waits for nothing. Every servo looks at it before each tick: once it is set the servo sends zero, switches
//! its devices off, closes them and ends. A servo started while it is set ends before its first tick.

use std::cell::Cell;
use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

/// Why all force ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
#[repr(u8)]
pub enum Halt {
    /// The window was closed.
    Closed = 1,
    /// The program panicked, on any thread.
    Panicked = 2,
    /// SIGTERM: the program was asked to end.
    Terminated = 3,
    /// SIGINT: Ctrl+C.
    Interrupted = 4,
    /// SIGHUP: its terminal went away.
    HungUp = 5,
}

impl Halt {
    /// All.
    pub const ALL: [Self; 5] = [
        Self::Closed,
        Self::Panicked,
        Self::Terminated,
        Self::Interrupted,
        Self::HungUp,
    ];

    /// For people, at the end of a sentence about force or a run.
    pub fn title(self) -> &'static str {
        match self {
            Self::Closed => "the window was closed",
            Self::Panicked => "the program panicked",
            Self::Terminated => "the program was told to end (SIGTERM)",
            Self::Interrupted => "the program was interrupted (SIGINT)",
            Self::HungUp => "the terminal went away (SIGHUP)",
        }
    }

    /// What the process answers with where this ended it: 128 and the signal's number as shells have it, 101 after a panic.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Closed => 0,
            Self::Panicked => 101,
            Self::Terminated => 143,
            Self::Interrupted => 130,
            Self::HungUp => 129,
        }
    }
}

static HALTED: AtomicU8 = AtomicU8::new(0);
static TOLD: (Mutex<()>, Condvar) = (Mutex::new(()), Condvar::new());
static RUNNING: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static TOLERANT: Cell<bool> = const { Cell::new(false) };
}

/// Ends all force of this process. The first reason stays.
pub fn halt(reason: Halt) {
    let _ = HALTED.compare_exchange(0, reason as u8, Ordering::AcqRel, Ordering::Acquire);
    // Nobody holds it longer than it takes to look.
    drop(TOLD.0.lock().unwrap_or_else(PoisonError::into_inner));
    TOLD.1.notify_all();
}

/// Waits until all force is ended, and tells why: for a thread that then closes a window.
pub fn wait_for_halt() -> Halt {
    let (lock, told) = &TOLD;
    let mut held = lock.lock().unwrap_or_else(PoisonError::into_inner);
    loop {
        if let Some(reason) = halted() {
            return reason;
        }
        held = told.wait(held).unwrap_or_else(PoisonError::into_inner);
    }
}

/// Whether all force was ended, and why.
pub fn halted() -> Option<Halt> {
    let number = HALTED.load(Ordering::Acquire);
    Halt::ALL.into_iter().find(|h| *h as u8 == number)
}

/// Lets servos be started again after a panic, once somebody has looked at it. What a signal or the window's close ended
/// stays so. Whether they may.
pub fn resume() -> bool {
    let panicked = Halt::Panicked as u8;
    let _ = HALTED.compare_exchange(panicked, 0, Ordering::AcqRel, Ordering::Acquire);
    halted().is_none()
}

/// Something that ends by itself once halted, and must be let: a servo, a recording that is being closed.
#[derive(Debug)]
#[must_use = "it counts until it is dropped"]
pub struct Running(());

impl Drop for Running {
    fn drop(&mut self) {
        RUNNING.fetch_sub(1, Ordering::AcqRel);
    }
}

impl Running {
    /// Counts until it is dropped.
    pub fn new() -> Self {
        RUNNING.fetch_add(1, Ordering::AcqRel);
        Self(())
    }
}

impl Default for Running {
    fn default() -> Self {
        Self::new()
    }
}

/// How many [`Running`] there are. A signal waits for them, and ends a process without any at once.
pub fn running() -> usize {
    RUNNING.load(Ordering::Acquire)
}

/// Calls `f`; a panic in it, on this thread, is its caller's to catch and halts nothing.
pub fn tolerate<T>(f: impl FnOnce() -> T) -> T {
    struct Restore(bool);
    impl Drop for Restore {
        fn drop(&mut self) {
            TOLERANT.set(self.0);
        }
    }
    let _restore = Restore(TOLERANT.replace(true));
    f()
}

/// From now on a panic on any thread halts, whether it is caught or not, except within [`tolerate`]. What panics did before
/// they still do. For the program, once; a test that panics must not end the servos beside it.
pub fn halt_on_panic() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        // First the force, then the words.
        if !TOLERANT.get() {
            halt(Halt::Panicked);
        }
        before(info);
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    // Halting itself is process-wide: `tests/halt.rs` does it in processes of its own.

    #[test]
    fn each_reason_has_its_own_number_words_and_code() {
        for (i, a) in Halt::ALL.into_iter().enumerate() {
            assert_eq!(a as usize, i + 1);
            for b in &Halt::ALL[i + 1..] {
                assert_ne!((a.title(), a.exit_code()), (b.title(), b.exit_code()));
            }
        }
        assert_eq!(halted(), None);
    }

    #[test]
    fn what_is_tolerated_ends_with_its_call() {
        assert!(!TOLERANT.get());
        let caught = catch_unwind(AssertUnwindSafe(|| {
            tolerate(|| {
                assert!(TOLERANT.get());
                tolerate(|| ());
                assert!(TOLERANT.get(), "the inner call ended, the outer did not");
                std::panic::resume_unwind(Box::new(()));
            });
        }));
        assert!(caught.is_err() && !TOLERANT.get());
    }
}
