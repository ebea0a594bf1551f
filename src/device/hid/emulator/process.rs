//! The emulator as a process of its own: its socket is handed over as standard input, its outcome comes on standard output.

use super::{Fault, Mechanics, Options, Outcome, SUBCOMMAND, serve};
use crate::device::hid::arms::{Arms, POLHEM, TEENSY, WOODEN};
use crate::device::hid::transport::SocketPort;
use crate::device::{DeviceError, Family as _};
use std::io::Read as _;
use std::os::fd::AsFd as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;

/// What the process is asked for: words of its command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Key of the family.
    pub family: &'static str,
    /// How long it lives, s.
    pub seconds: f64,
    /// How deep the hand presses, mm.
    pub press_mm: f64,
    /// How late its reports come, ms.
    pub delay_ms: u16,
    /// What goes wrong.
    pub fault: Option<Fault>,
}

/// The families that can be emulated.
pub fn families() -> [&'static Arms; 3] {
    [&WOODEN, &POLHEM, &TEENSY]
}

/// The arm family called `key`.
///
/// # Errors
/// There is none; which there are.
pub fn family(key: &str) -> Result<&'static Arms, DeviceError> {
    let found = families().into_iter().find(|f| f.key() == key);
    found.ok_or_else(|| {
        let keys = families().map(|f| f.key()).join(", ");
        DeviceError::new(format!("no emulator for \"{key}\"; there are {keys}"))
    })
}

/// A running emulator.
#[derive(Debug)]
pub struct Emulated {
    child: Child,
}

impl Emulated {
    /// Starts `program`, which is this one, as an emulator; the host's end of its socket.
    ///
    /// # Errors
    /// The system gives no socket or no process.
    pub fn spawn(program: &Path, request: &Request) -> Result<(Self, SocketPort), DeviceError> {
        let fail = |e: std::io::Error| DeviceError::new(format!("no emulator: {e}"));
        let (host, board) = SocketPort::pair().map_err(fail)?;
        let mut command = Command::new(program);
        command
            .args([SUBCOMMAND, request.family])
            .arg(request.seconds.to_string())
            .arg(request.press_mm.to_string())
            .arg(request.delay_ms.to_string())
            .args(request.fault.map(Fault::key))
            .stdin(Stdio::from(board.into_fd()))
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit());
        let child = command.spawn().map_err(fail)?;
        Ok((Self { child }, host))
    }

    /// Its outcome; waits until its time is over or the host's end is closed.
    ///
    /// # Errors
    /// It ended without one.
    pub fn outcome(mut self) -> Result<Outcome, DeviceError> {
        let fail = |e: &dyn std::fmt::Display| DeviceError::new(format!("the emulator: {e}"));
        let mut text = String::new();
        if let Some(out) = &mut self.child.stdout {
            out.read_to_string(&mut text).map_err(|e| fail(&e))?;
        }
        self.child.wait().map_err(|e| fail(&e))?;
        serde_json::from_str(&text).map_err(|e| fail(&e))
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // One whose outcome was read has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Is the emulator: serves the socket on standard input as the words of the command line ask, and gives its outcome as JSON.
///
/// # Errors
/// The words are wrong, or standard input is no socket.
pub fn serve_stdin(words: &[String]) -> Result<String, DeviceError> {
    let number = |i: usize, least: f64, most: f64| {
        let text = words.get(i).map_or("", String::as_str);
        let number = text.parse().ok().filter(|x| (least..=most).contains(x));
        number.ok_or_else(|| {
            DeviceError::new(format!(
                "\"{text}\"; a number from {least} to {most} is needed"
            ))
        })
    };
    let arms = family(words.first().map_or("", String::as_str))?;
    let fault = match words.get(4) {
        None => None,
        Some(key) => Some(Fault::by_key(key).ok_or_else(|| {
            let keys = Fault::ALL.map(Fault::key).join(", ");
            DeviceError::new(format!("no fault \"{key}\"; there are {keys}"))
        })?),
    };
    let Some(arm) = arms.defaults().arm else {
        return Err(DeviceError::new("no arm"));
    };
    let options = Options {
        protocol: arms.protocol,
        arm,
        mechanics: Mechanics::default(),
        press_mm: number(2, -20.0, 50.0)?,
        delay_ms: number(3, 0.0, 100.0)? as u16,
        fault,
        seconds: number(1, 0.0, 86_400.0)?,
    };
    let fd = std::io::stdin().as_fd().try_clone_to_owned();
    let fd = fd.map_err(DeviceError::new)?;
    // Standard input stays open for as long as the process lives; only its end closes the socket.
    let outcome = serve(SocketPort::from_fd(fd), &options, &AtomicBool::new(false));
    serde_json::to_string(&outcome).map_err(DeviceError::new)
}
