//! The emulator as a process of its own: its wire is handed over as standard input, its outcome comes on standard output.

use super::{Fault, Hand, Mechanics, Options, Outcome, SUBCOMMAND, serve, truth};
use crate::device::hid::arms::{Arms, POLHEM, TEENSY, WOODEN};
use crate::device::hid::line::LinePort;
use crate::device::hid::transport::{Port, SocketPort};
use crate::device::{DeviceError, Family as _};
use serde::{Deserialize, Serialize};
use std::io::Read as _;
use std::os::fd::{AsFd as _, OwnedFd};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;

/// What lies between program and device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Wire {
    /// A socket that keeps reports whole, as HID does.
    #[default]
    Socket,
    /// A pseudo-terminal: a line of bytes, as a serial port is.
    Terminal,
}

impl Wire {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Socket, Self::Terminal];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Socket => "socket pair",
            Self::Terminal => "pseudo-terminal",
        }
    }

    /// Both ends of a new one: the program's, then the device's.
    ///
    /// # Errors
    /// The system gives none.
    pub fn pair(self) -> std::io::Result<(OwnedFd, OwnedFd)> {
        Ok(match self {
            Self::Socket => {
                let (host, board) = SocketPort::pair()?;
                (host.into_fd(), board.into_fd())
            }
            Self::Terminal => {
                let (host, board) = LinePort::pair()?;
                (host.into_fd(), board.into_fd())
            }
        })
    }

    /// The port at an end of one.
    ///
    /// # Errors
    /// It is of another kind.
    pub fn port(self, fd: OwnedFd) -> std::io::Result<Box<dyn Port>> {
        Ok(match self {
            Self::Socket => Box::new(SocketPort::from_fd(fd)),
            Self::Terminal => Box::new(LinePort::from_fd(fd)?),
        })
    }
}

/// What the process is asked for: its command line holds it as JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Key of the family.
    pub family: String,
    /// What lies between it and the program.
    pub wire: Wire,
    /// How long it lives, s.
    pub seconds: f64,
    /// What the hand does.
    pub hand: Hand,
    /// How late its reports come, ms.
    pub delay_ms: u16,
    /// What goes wrong.
    pub fault: Option<Fault>,
    /// Where it writes the truth of every millisecond when it ends; absent: nowhere.
    pub truth: Option<PathBuf>,
}

impl Request {
    /// A hand that presses an arm of this family 6 mm deep for up to an hour over a socket; nothing goes wrong.
    pub fn press(family: &str) -> Self {
        Self {
            family: family.into(),
            wire: Wire::Socket,
            seconds: 3600.0,
            hand: Hand::Press { depth_mm: 6.0 },
            delay_ms: 0,
            fault: None,
            truth: None,
        }
    }
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
    /// Starts `program`, which is this one, as an emulator; the program's end of its wire.
    ///
    /// # Errors
    /// The system gives no wire or no process.
    pub fn spawn(program: &Path, request: &Request) -> Result<(Self, Box<dyn Port>), DeviceError> {
        let (emulated, fd) = Self::spawn_raw(program, request)?;
        let port = request.wire.port(fd).map_err(no_emulator)?;
        Ok((emulated, port))
    }

    /// As [`spawn`](Self::spawn), with an end of the wire that can be handed to another process.
    ///
    /// # Errors
    /// The system gives no wire or no process.
    pub fn spawn_raw(program: &Path, request: &Request) -> Result<(Self, OwnedFd), DeviceError> {
        let (host, board) = request.wire.pair().map_err(no_emulator)?;
        let words = serde_json::to_string(request).map_err(no_emulator)?;
        let child = Command::new(program)
            .args([SUBCOMMAND, &words])
            .stdin(Stdio::from(board))
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .map_err(no_emulator)?;
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

fn no_emulator(e: impl std::fmt::Display) -> DeviceError {
    DeviceError::new(format!("no emulator: {e}"))
}

/// Is the emulator: serves the wire on standard input as `request`, JSON, asks, and gives its outcome as JSON.
///
/// # Errors
/// The request is wrong, or standard input is no such wire.
pub fn serve_stdin(request: &str) -> Result<String, DeviceError> {
    let request: Request = serde_json::from_str(request)
        .map_err(|e| DeviceError::new(format!("no request for an emulator: {e}")))?;
    let within = |what: &str, x: f64, least: f64, most: f64| {
        if (least..=most).contains(&x) {
            Ok(x)
        } else {
            Err(DeviceError::new(format!(
                "{what} {x}; {least} to {most} is allowed"
            )))
        }
    };
    let arms = family(&request.family)?;
    let Some(arm) = arms.defaults().arm else {
        return Err(DeviceError::new("no arm"));
    };
    within("depth_mm", request.hand.depth_mm(), -20.0, 50.0)?;
    within("delay_ms", request.delay_ms.into(), 0.0, 100.0)?;
    let options = Options {
        protocol: arms.protocol,
        arm,
        mechanics: Mechanics::default(),
        hand: request.hand,
        delay_ms: request.delay_ms,
        fault: request.fault,
        seconds: within("seconds", request.seconds, 0.0, 86_400.0)?,
        keeps_truth: request.truth.is_some(),
    };
    // Standard input stays open for as long as the process lives; only its end closes the wire.
    let fd = std::io::stdin().as_fd().try_clone_to_owned();
    let port = fd.and_then(|fd| request.wire.port(fd));
    let (outcome, truths) = serve(
        port.map_err(DeviceError::new)?,
        &options,
        &AtomicBool::new(false),
    );
    if let Some(path) = &request.truth {
        truth::write(path, &truths)
            .map_err(|e| DeviceError::new(format!("{}: {e}", path.display())))?;
    }
    serde_json::to_string(&outcome).map_err(DeviceError::new)
}
