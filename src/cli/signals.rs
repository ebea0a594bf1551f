//! Signals and panics end all force before they end the program.

use crate::servo;
#[cfg(unix)]
use crate::servo::Halt;
#[cfg(unix)]
use std::time::{Duration, Instant};

/// How long what runs may take to end by itself: zero the force, close the devices, finish a recording.
#[cfg(unix)]
const PATIENCE: Duration = Duration::from_secs(10);
/// How long the program may take from there to its own end.
#[cfg(unix)]
const GRACE: Duration = Duration::from_secs(3);
/// How often it is looked whether it has.
#[cfg(unix)]
const LOOK: Duration = Duration::from_millis(5);

/// From now on SIGTERM, SIGINT, SIGHUP and a panic anywhere halt every servo first. Where nothing runs that must be let end
/// a signal ends the process at once, and so does the second in any case. Elsewhere than on Unix there are no such signals,
/// and a process that is ended is one whose devices fall silent: their own watchdogs take the force off.
pub(super) fn heed() {
    servo::halt_on_panic();
    #[cfg(unix)]
    if let Err(e) = listen() {
        log::warn!("signals end the program without a word to its devices: {e}");
    }
}

/// From now on Ctrl+C is nothing to this process: it is meant for the one that started it.
pub(super) fn leave_to_parent() {
    #[cfg(unix)]
    {
        let heard = std::sync::Arc::default();
        let _ = signal_hook::flag::register(signal_hook::consts::SIGINT, heard);
    }
}

#[cfg(unix)]
fn listen() -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGTERM, SIGINT, SIGHUP])?;
    let reason = |signal| match signal {
        SIGINT => Halt::Interrupted,
        SIGHUP => Halt::HungUp,
        _ => Halt::Terminated,
    };
    let thread = std::thread::Builder::new().name("signals".into());
    thread.spawn(move || {
        let Some(first) = signals.forever().next() else {
            return;
        };
        servo::halt(reason(first));
        let mut second = None;
        let mut wait = |until: Instant, runs: &dyn Fn() -> bool| {
            while second.is_none() && runs() && Instant::now() < until {
                std::thread::sleep(LOOK);
                second = signals.pending().next();
            }
            second
        };
        let any = servo::running() > 0;
        let mut last = wait(Instant::now() + PATIENCE, &|| servo::running() > 0);
        if any {
            // What ran has ended; the program says what became of it and returns by itself.
            last = wait(Instant::now() + GRACE, &|| true);
        }
        let last = last.unwrap_or(first);
        let _ = signal_hook::low_level::emulate_default_handler(last);
    })?;
    Ok(())
}
