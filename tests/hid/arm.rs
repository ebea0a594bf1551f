//! Dorsum's own emulator, a simulated arm in a simulated hand, plugged into the kernel instead of a socket.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use dorsum::device::Family as _;
use dorsum::device::hid::emulator::{self, Hand, Mechanics, Options, Outcome};
use dorsum::device::hid::transport::{Gone, Port, REPORT};

use crate::board::Fault;
use crate::kinds;
use crate::plug::plug;
use crate::uhid::{Event, Uhid};

/// The device's end of the kernel's wire.
struct UhidPort {
    uhid: Arc<Uhid>,
    reports: Receiver<Vec<u8>>,
}

impl Port for UhidPort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        match self
            .reports
            .recv_timeout(Duration::from_millis(wait_ms.into()))
        {
            Ok(report) => {
                let length = report.len().min(REPORT);
                into[..length].copy_from_slice(&report[..length]);
                Ok(length)
            }
            Err(RecvTimeoutError::Timeout) => Ok(0),
            Err(RecvTimeoutError::Disconnected) => Err(Gone),
        }
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        self.uhid.input(report).map_err(|_| Gone)
    }
}

/// The arm's process: `KEY SERIAL PRESS_MM TROUBLE FAULT`. It lives until its input ends or its trouble unplugs it, and
/// then tells what it came to.
pub fn arm(arguments: &[String]) -> Result<(), String> {
    let [key, serial, press_mm, trouble, fault] = arguments else {
        return Err(
            "an arm is five words: kind, serial number, press in mm, trouble, fault".into(),
        );
    };
    let kind = kinds::named(key)?;
    let depth_mm = press_mm
        .parse()
        .map_err(|error| format!("press '{press_mm}': {error}"))?;
    let fault = Fault::ALL
        .iter()
        .find(|(key, _)| key == fault)
        .map(|(_, fault)| *fault);
    let family = emulator::process::family(kind.family).map_err(|error| error.to_string())?;
    let mut arm = family.defaults().arm.ok_or("the family has no arm")?;
    if fault == Some(Fault::Bent) {
        arm.length_b_mm *= 1.05;
    }
    let options = Options {
        protocol: family.protocol,
        arm,
        mechanics: Mechanics::default(),
        hand: Hand::Press { depth_mm },
        delay_ms: 0,
        fault: emulator::Fault::by_key(trouble),
        seconds: 60.0,
        keeps_truth: false,
    };

    let uhid = Arc::new(Uhid::new().map_err(|error| format!("/dev/uhid: {error}"))?);
    let (send, reports) = sync_channel(1024);
    let kernel = Arc::clone(&uhid);
    let hear = move || {
        while let Ok(event) = kernel.next() {
            if let Event::Output(report) = event
                && send.send(report).is_err()
            {
                break;
            }
        }
    };
    thread::Builder::new()
        .name("kernel".into())
        .spawn(hear)
        .map_err(|error| format!("thread: {error}"))?;
    let stop = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&stop);
    let wait = move || {
        let _ = std::io::stdin().lock().read_to_end(&mut Vec::new());
        told.store(true, Ordering::Release);
    };
    thread::Builder::new()
        .name("lead".into())
        .spawn(wait)
        .map_err(|error| format!("thread: {error}"))?;

    plug(&uhid, kind, serial, fault).map_err(|error| format!("plug: {error}"))?;
    let port = UhidPort {
        uhid: Arc::clone(&uhid),
        reports,
    };
    let (outcome, _) = emulator::serve(port, &options, &stop);
    uhid.unplug().map_err(|error| format!("unplug: {error}"))?;
    println!(
        "{}",
        serde_json::to_string(&outcome).map_err(|error| error.to_string())?
    );
    Ok(())
}

/// An arm's process, held by its lead.
pub struct EmulatedArm {
    process: Child,
    lead: Option<ChildStdin>,
}

impl EmulatedArm {
    /// Starts the process, which plugs the arm in.
    pub fn plugged(
        key: &str,
        serial: &str,
        press_mm: f64,
        trouble: Option<emulator::Fault>,
        fault: Option<Fault>,
    ) -> Result<Self, String> {
        let program = std::env::current_exe().map_err(|error| format!("own path: {error}"))?;
        let trouble = trouble.map_or("none", emulator::Fault::key);
        let fault = fault.map_or("none", Fault::key);
        let mut process = Command::new(program)
            .args(["arm", key, serial, &press_mm.to_string(), trouble, fault])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("arm process: {error}"))?;
        let lead = process.stdin.take();
        Ok(Self { process, lead })
    }

    /// Ends it; what it came to, which is the truth about it.
    pub fn end(&mut self) -> Result<Outcome, String> {
        self.lead = None;
        let answer = self
            .process
            .stdout
            .take()
            .ok_or("the arm's process has ended")?;
        let mut line = String::new();
        BufReader::new(answer)
            .read_line(&mut line)
            .map_err(|error| format!("arm process: {error}"))?;
        serde_json::from_str(&line)
            .map_err(|error| format!("arm process says '{}': {error}", line.trim_end()))
    }
}

impl Drop for EmulatedArm {
    fn drop(&mut self) {
        self.lead = None;
        let _ = self.process.wait();
    }
}
