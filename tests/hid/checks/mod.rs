//! The checks, one function each. Every one says what it measured, or what is wrong.
//!
//! [`hidraw`] holds the kernel and `hidapi` to what Dorsum takes for granted of them; [`dorsum`] holds Dorsum's own devices
//! to their word over the same wire.

mod dorsum;
mod hidraw;

use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::board::Fault;
use crate::host::PATIENCE;

/// Something that must hold, the devices it must hold for, and the faulty devices that it must not let pass.
pub struct Check {
    pub title: &'static str,
    pub kinds: &'static [&'static str],
    pub run: fn(key: &str, fault: Option<Fault>) -> Result<String, String>,
    /// Each with a word of what it must be refused for: a check that fails for another reason has noticed nothing.
    pub catches: &'static [(Fault, &'static str)],
}

const ARMS: &[&str] = &["wooden-8", "wooden-14", "teensy-64"];
const MICE: &[&str] = &["spacemouse-split", "spacemouse-whole"];
const ALL: &[&str] = &[
    "wooden-8",
    "wooden-14",
    "teensy-64",
    "spacemouse-split",
    "spacemouse-whole",
];

pub static CHECKS: [Check; 16] = [
    Check {
        title: "listed",
        kinds: ALL,
        run: hidraw::is_listed,
        catches: &[(Fault::Alias, "serial number"), (Fault::Page, "usage page")],
    },
    Check {
        title: "udev rule",
        kinds: ALL,
        run: hidraw::may_be_opened,
        catches: &[(Fault::Stranger, "no tag")],
    },
    Check {
        title: "read",
        kinds: ARMS,
        run: hidraw::reads,
        catches: &[
            (Fault::Short, "report"),
            (Fault::Loses, "reports lost"),
            (Fault::Frozen, "frozen"),
        ],
    },
    Check {
        title: "read, numbered",
        kinds: MICE,
        run: hidraw::reads_numbered,
        catches: &[
            (Fault::Short, "report"),
            (Fault::Loses, "step of"),
            (Fault::Frozen, "step of"),
        ],
    },
    Check {
        title: "write",
        kinds: ARMS,
        run: hidraw::writes,
        catches: &[(Fault::Shifted, "encoder a")],
    },
    Check {
        title: "lamp",
        kinds: MICE,
        run: hidraw::lights,
        catches: &[],
    },
    Check {
        title: "drain to newest",
        kinds: &["wooden-8", "teensy-64"],
        run: hidraw::drains,
        catches: &[(Fault::Frozen, "newest count")],
    },
    Check {
        title: "unplug, replug",
        kinds: ALL,
        run: hidraw::replugs,
        catches: &[(Fault::Stays, "reading goes on")],
    },
    Check {
        title: "silent host",
        kinds: ARMS,
        run: hidraw::falls_silent,
        catches: &[(Fault::Deaf, "stay on")],
    },
    Check {
        title: "two, one serial",
        kinds: ARMS,
        run: hidraw::tells_twins,
        catches: &[(Fault::Stays, "still answers")],
    },
    Check {
        title: "1 kHz both ways",
        kinds: &["teensy-64"],
        run: hidraw::keeps_up,
        catches: &[(Fault::Loses, "on the way in")],
    },
    Check {
        title: "Dorsum: find",
        kinds: ALL,
        run: dorsum::finds,
        catches: &[(Fault::Stranger, "found 0")],
    },
    Check {
        title: "Dorsum: twins",
        kinds: ARMS,
        run: dorsum::tells_twins,
        catches: &[],
    },
    Check {
        title: "Dorsum: cap",
        kinds: MICE,
        run: dorsum::follows_cap,
        catches: &[(Fault::Frozen, "stands")],
    },
    Check {
        title: "Dorsum: loop",
        kinds: ARMS,
        run: dorsum::closes_loop,
        catches: &[(Fault::Bent, "position")],
    },
    Check {
        title: "Dorsum: trouble",
        kinds: ARMS,
        run: dorsum::meets_trouble,
        catches: &[],
    },
];

/// Asks until there is an answer or patience ends.
fn settle<T>(mut ask: impl FnMut() -> Result<Option<T>, String>) -> Result<Option<T>, String> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        if let Some(answer) = ask()? {
            return Ok(Some(answer));
        }
        sleep(Duration::from_millis(1));
    }
    Ok(None)
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, found: T, expected: T) -> Result<(), String> {
    if found == expected {
        Ok(())
    } else {
        Err(format!("{what}: {found:?}, expected {expected:?}"))
    }
}
