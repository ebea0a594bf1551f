//! Reports over a line of bytes, as a serial port or a pseudo-terminal is: each framed as RFC 1055 (SLIP) has it, so that one
//! that was cut off spoils no other.

use super::transport::{Gone, Port, REPORT};
use nix::errno::Errno;
use nix::fcntl::{FcntlArg, FdFlag, OFlag, fcntl};
use nix::poll::{PollFd, PollFlags, poll};
use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use nix::unistd::{read, write};
use std::os::fd::{AsFd as _, OwnedFd};

const END: u8 = 0xC0;
const ESC: u8 = 0xDB;
const ESC_END: u8 = 0xDC;
const ESC_ESC: u8 = 0xDD;
/// Longest frame: every byte escaped, an end on either side.
const FRAME: usize = 2 * REPORT + 2;

/// Frames a report; how many bytes.
fn frame(report: &[u8], out: &mut [u8; FRAME]) -> usize {
    let mut n = 0;
    let mut put = |byte| {
        if let Some(to) = out.get_mut(n) {
            *to = byte;
            n += 1;
        }
    };
    // An end in front closes whatever was cut off before.
    put(END);
    for &byte in report.iter().take(REPORT) {
        match byte {
            END => [ESC, ESC_END].into_iter().for_each(&mut put),
            ESC => [ESC, ESC_ESC].into_iter().for_each(&mut put),
            plain => put(plain),
        }
    }
    put(END);
    n
}

/// Takes frames apart, byte by byte.
#[derive(Clone, Copy, Debug)]
struct Unframer {
    report: [u8; REPORT],
    n: usize,
    escaped: bool,
    /// Longer than any report, or escaped as nobody escapes: thrown away up to its end.
    spoilt: bool,
}

impl Default for Unframer {
    fn default() -> Self {
        Self {
            report: [0; REPORT],
            n: 0,
            escaped: false,
            spoilt: false,
        }
    }
}

impl Unframer {
    /// Takes a byte; the length of the report that it closed, which lies in `report`.
    fn take(&mut self, byte: u8) -> Option<usize> {
        let plain = match (std::mem::take(&mut self.escaped), byte) {
            (_, END) => {
                let (n, spoilt) = (self.n, self.spoilt);
                (self.n, self.spoilt) = (0, false);
                return (n > 0 && !spoilt).then_some(n);
            }
            (false, ESC) => {
                self.escaped = true;
                return None;
            }
            (true, ESC_END) => END,
            (true, ESC_ESC) => ESC,
            (true, _) => {
                self.spoilt = true;
                return None;
            }
            (false, plain) => plain,
        };
        match self.report.get_mut(self.n) {
            Some(to) => {
                *to = plain;
                self.n += 1;
            }
            None => self.spoilt = true,
        }
        None
    }
}

/// One end of a line of bytes. The other end may be in another process.
#[derive(Debug)]
pub struct LinePort {
    fd: OwnedFd,
    unframer: Unframer,
    /// Bytes read that were not looked at yet: from, to.
    bytes: [u8; 512],
    waiting: (usize, usize),
    /// What of the last frame did not go out yet: from, to.
    frame: [u8; FRAME],
    unsent: (usize, usize),
}

impl LinePort {
    /// Both ends of a new pseudo-terminal that passes bytes on as they are: the program's, then the device's.
    ///
    /// # Errors
    /// The system gives none.
    pub fn pair() -> std::io::Result<(Self, Self)> {
        let pty = openpty(None, None)?;
        // A process started meanwhile must not keep an end open: the other would never hear that it is closed.
        for end in [&pty.master, &pty.slave] {
            fcntl(end, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC))?;
        }
        let mut settings = tcgetattr(&pty.slave)?;
        cfmakeraw(&mut settings);
        tcsetattr(&pty.slave, SetArg::TCSANOW, &settings)?;
        Ok((Self::from_fd(pty.slave)?, Self::from_fd(pty.master)?))
    }

    /// The end that was handed over as `fd`.
    ///
    /// # Errors
    /// It cannot be set not to block.
    pub fn from_fd(fd: OwnedFd) -> std::io::Result<Self> {
        let flags = OFlag::from_bits_retain(fcntl(&fd, FcntlArg::F_GETFL)?);
        fcntl(&fd, FcntlArg::F_SETFL(flags | OFlag::O_NONBLOCK))?;
        Ok(Self {
            fd,
            unframer: Unframer::default(),
            bytes: [0; 512],
            waiting: (0, 0),
            frame: [0; FRAME],
            unsent: (0, 0),
        })
    }

    /// This end, to be handed to another process.
    pub fn into_fd(self) -> OwnedFd {
        self.fd
    }

    /// The next report among the bytes that were read.
    fn unframed(&mut self, into: &mut [u8; REPORT]) -> Option<usize> {
        let (from, to) = self.waiting;
        for i in from..to {
            if let Some(n) = self.unframer.take(self.bytes[i]) {
                into[..n].copy_from_slice(&self.unframer.report[..n]);
                self.waiting.0 = i + 1;
                return Some(n);
            }
        }
        self.waiting = (0, 0);
        None
    }

    /// Sends what is left of the last frame; whether all went out.
    fn flush(&mut self) -> Result<bool, Gone> {
        let (from, to) = self.unsent;
        if from == to {
            return Ok(true);
        }
        match write(&self.fd, &self.frame[from..to]) {
            Ok(n) => {
                self.unsent.0 += n;
                Ok(self.unsent.0 == to)
            }
            Err(Errno::EAGAIN | Errno::EINTR) => Ok(false),
            Err(_) => Err(Gone),
        }
    }
}

impl Port for LinePort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        loop {
            if let Some(n) = self.unframed(into) {
                return Ok(n);
            }
            let mut ready = [PollFd::new(self.fd.as_fd(), PollFlags::POLLIN)];
            match poll(&mut ready, wait_ms) {
                Ok(0) | Err(Errno::EINTR) => return Ok(0),
                Ok(_) => {}
                Err(_) => return Err(Gone),
            }
            match read(&self.fd, &mut self.bytes) {
                // The other end is closed; a terminal says so by an error.
                Ok(0) => return Err(Gone),
                Ok(n) => self.waiting = (0, n),
                Err(Errno::EAGAIN | Errno::EINTR) => return Ok(0),
                Err(_) => return Err(Gone),
            }
        }
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        // A frame that has begun must end; one that finds no room is lost whole, as with a device that is busy.
        if self.flush()? {
            self.unsent = (0, frame(report, &mut self.frame));
            self.flush()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unframed(bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut unframer = Unframer::default();
        let mut out = Vec::new();
        for &byte in bytes {
            if let Some(n) = unframer.take(byte) {
                out.push(unframer.report[..n].to_vec());
            }
        }
        out
    }

    fn framed(report: &[u8]) -> Vec<u8> {
        let mut out = [0; FRAME];
        let n = frame(report, &mut out);
        out[..n].to_vec()
    }

    #[test]
    fn a_frame_is_as_published() {
        assert_eq!(
            framed(&[1, END, 2, ESC, 3]),
            [END, 1, ESC, ESC_END, 2, ESC, ESC_ESC, 3, END]
        );
    }

    proptest! {
        #[test]
        fn reports_come_back_whatever_stands_before_them(
            rubbish in prop::collection::vec(any::<u8>(), 0..300),
            reports in prop::collection::vec(prop::collection::vec(any::<u8>(), 1..=REPORT), 1..5),
        ) {
            let mut bytes = rubbish.clone();
            for report in &reports {
                bytes.extend(framed(report));
            }
            let mut out = unframed(&bytes);
            // Rubbish may look like reports of its own; they come first.
            let first = out.len().saturating_sub(reports.len());
            prop_assert_eq!(out.split_off(first), reports);
        }
    }

    #[test]
    fn a_pseudo_terminal_passes_reports_whole_and_says_when_the_other_end_is_closed() {
        let (mut host, mut device) = LinePort::pair().expect("a pseudo-terminal");
        let mut into = [0; REPORT];
        assert_eq!(host.read(&mut into, 0), Ok(0));
        let report: [u8; REPORT] = std::array::from_fn(|i| (i * 7 + 0xBE) as u8);
        for _ in 0..20 {
            device.write(&report).expect("sent");
            device.write(&report[..8]).expect("sent");
            host.write(&report[..9]).expect("sent");
            assert_eq!(host.read(&mut into, 1000), Ok(REPORT));
            assert_eq!(into, report);
            assert_eq!(host.read(&mut into, 1000), Ok(8));
            assert_eq!(device.read(&mut into, 1000), Ok(9));
            assert_eq!(into[..9], report[..9]);
        }
        // One that nobody reads loses reports, and goes on whole when somebody does.
        for _ in 0..10_000 {
            device.write(&report).expect("lost or sent");
        }
        let mut n = 0;
        while host.read(&mut into, 10) == Ok(REPORT) {
            assert_eq!(into, report);
            n += 1;
            if n % 10 == 0 {
                device.write(&report).expect("sent");
            }
            if n > 2000 {
                break;
            }
        }
        assert!(n > 20, "{n}");
        drop(device);
        let gone = (0..5000).any(|_| host.read(&mut into, 1) == Err(Gone));
        assert!(gone);
        assert_eq!(host.write(&report), Err(Gone));
    }
}
