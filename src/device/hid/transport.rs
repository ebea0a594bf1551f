//! The wire: reports in, reports out. Over HID, and over a socket to an emulator.

use crate::device::DeviceError;

/// Longest report of any device, report id included, bytes.
pub const REPORT: usize = 65;

/// The other end is gone: unplugged, or taken away by the system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the device is gone")]
pub struct Gone;

/// One open device.
pub trait Port: Send {
    /// The next report, after waiting up to `wait_ms` for one; how many bytes, 0 if none came.
    ///
    /// # Errors
    /// The device is gone.
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone>;

    /// Sends a report, its report id first.
    ///
    /// # Errors
    /// The device is gone.
    fn write(&mut self, report: &[u8]) -> Result<(), Gone>;

    /// Switches the force of a device that has a switch of its own, which is off when the port is opened.
    ///
    /// # Errors
    /// The device is gone.
    fn enable(&mut self, _on: bool) -> Result<(), Gone> {
        Ok(())
    }
}

impl Port for Box<dyn Port> {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        (**self).read(into, wait_ms)
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        (**self).write(report)
    }

    fn enable(&mut self, on: bool) -> Result<(), Gone> {
        (**self).enable(on)
    }
}

/// A device reached through the system's HID.
pub struct HidPort {
    device: hidapi::HidDevice,
}

impl HidPort {
    /// Opens the device at a path that the enumeration told.
    ///
    /// # Errors
    /// It is gone or may not be opened; then what to do.
    pub fn open(path: &str) -> Result<Self, DeviceError> {
        let fail = |what: String| DeviceError::new(format!("{path}: {what}"));
        let c_path = std::ffi::CString::new(path).map_err(|_| fail("no path".into()))?;
        let api = hidapi::HidApi::new().map_err(|e| fail(e.to_string()))?;
        match api.open_path(&c_path) {
            Ok(device) => Ok(Self { device }),
            Err(e) => Err(fail(format!("{e}{}", remedy(path)))),
        }
    }
}

/// What helps where a device may not be opened.
fn remedy(path: &str) -> &'static str {
    let refused = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .open(path)
        .is_err_and(|e| e.kind() == std::io::ErrorKind::PermissionDenied);
    if refused {
        "; you may not open it: copy assets/70-dorsum.rules to /etc/udev/rules.d, then plug it in again"
    } else {
        ""
    }
}

impl Port for HidPort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        self.device
            .read_timeout(into, i32::from(wait_ms))
            .map_err(|_| Gone)
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        self.device.write(report).map(|_| ()).map_err(|_| Gone)
    }
}

#[cfg(target_os = "linux")]
pub use socket::SocketPort;

#[cfg(target_os = "linux")]
mod socket {
    use super::{Gone, Port, REPORT};
    use nix::errno::Errno;
    use nix::poll::{PollFd, PollFlags, poll};
    use nix::sys::socket::{AddressFamily, MsgFlags, SockFlag, SockType, recv, send, socketpair};
    use std::os::fd::{AsFd as _, AsRawFd as _, OwnedFd};

    /// One end of a socket that keeps reports whole, as HID does. The other end may be in another process.
    #[derive(Debug)]
    pub struct SocketPort {
        fd: OwnedFd,
    }

    impl SocketPort {
        /// Both ends of a new socket.
        ///
        /// # Errors
        /// The system gives none.
        pub fn pair() -> std::io::Result<(Self, Self)> {
            let (a, b) = socketpair(
                AddressFamily::Unix,
                SockType::SeqPacket,
                None,
                SockFlag::SOCK_CLOEXEC,
            )?;
            Ok((Self { fd: a }, Self { fd: b }))
        }

        /// The end that was handed over as `fd`.
        pub fn from_fd(fd: OwnedFd) -> Self {
            Self { fd }
        }

        /// This end, to be handed to another process.
        pub fn into_fd(self) -> OwnedFd {
            self.fd
        }
    }

    impl Port for SocketPort {
        fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
            let mut ready = [PollFd::new(self.fd.as_fd(), PollFlags::POLLIN)];
            match poll(&mut ready, wait_ms) {
                Ok(0) | Err(Errno::EINTR) => return Ok(0),
                Ok(_) => {}
                Err(_) => return Err(Gone),
            }
            match recv(self.fd.as_raw_fd(), into, MsgFlags::MSG_DONTWAIT) {
                // The other end is closed.
                Ok(0) => Err(Gone),
                Ok(n) => Ok(n),
                Err(Errno::EAGAIN | Errno::EINTR) => Ok(0),
                Err(_) => Err(Gone),
            }
        }

        fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
            let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
            match send(self.fd.as_raw_fd(), report, flags) {
                // An end that does not read loses reports, as a device does that is busy.
                Ok(_) | Err(Errno::EAGAIN | Errno::EINTR) => Ok(()),
                Err(_) => Err(Gone),
            }
        }
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn reports_stay_whole_and_a_closed_end_is_noticed() {
            let (mut a, mut b) = SocketPort::pair().expect("pair");
            let mut into = [0; REPORT];
            assert_eq!(b.read(&mut into, 0), Ok(0));
            a.write(&[1, 2, 3]).expect("sent");
            a.write(&[4; REPORT]).expect("sent");
            assert_eq!(b.read(&mut into, 10), Ok(3));
            assert_eq!(into[..3], [1, 2, 3]);
            assert_eq!(b.read(&mut into, 10), Ok(REPORT));
            drop(a);
            assert_eq!(b.read(&mut into, 10), Err(Gone));
            assert_eq!(b.write(&[1]), Err(Gone));
        }

        #[test]
        fn an_end_that_does_not_read_never_blocks_the_other() {
            let (mut a, _b) = SocketPort::pair().expect("pair");
            for _ in 0..100_000 {
                a.write(&[0; 9]).expect("sent or lost");
            }
        }
    }
}
