//! What a program says to `/dev/uhid` and hears from it: the records of `linux/uhid.h`, packed, in the machine's byte order.
//!
//! One record is one `read` or one `write`. Only what a device needs is spelt here.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};

/// The largest record: the type and a `CREATE2` request.
const RECORD: usize = 4 + CREATE2;
const CREATE2: usize = 128 + 64 + 64 + 2 + 2 + 4 * 4 + DATA_MAX;
const DATA_MAX: usize = 4096;
const BUS_USB: u16 = 3;

/// What the kernel tells the device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// A program opened the first handle.
    Open,
    /// The last handle was closed.
    Close,
    /// A report for the device, as the host wrote it: the report id byte first.
    Output(Vec<u8>),
    /// Something this test has no use for, by its number.
    Other(u32),
}

/// How the device introduces itself.
pub struct Identity<'a> {
    pub name: &'a str,
    pub serial: &'a str,
    pub vendor: u16,
    pub product: u16,
    pub descriptor: &'a [u8],
}

/// One emulated HID device: it exists between [`plug`](Self::plug) and [`unplug`](Self::unplug), and goes with the process.
pub struct Uhid(File);

impl Uhid {
    pub fn new() -> io::Result<Self> {
        OpenOptions::new()
            .read(true)
            .write(true)
            .open("/dev/uhid")
            .map(Self)
    }

    pub fn plug(&self, who: &Identity) -> io::Result<()> {
        let mut record = Vec::with_capacity(RECORD);
        record.extend(11_u32.to_ne_bytes());
        text(&mut record, who.name, 128);
        text(&mut record, "", 64);
        text(&mut record, who.serial, 64);
        record.extend((who.descriptor.len() as u16).to_ne_bytes());
        record.extend(BUS_USB.to_ne_bytes());
        for number in [u32::from(who.vendor), u32::from(who.product), 0, 0] {
            record.extend(number.to_ne_bytes());
        }
        record.extend(who.descriptor);
        self.send(&record)
    }

    pub fn unplug(&self) -> io::Result<()> {
        self.send(&1_u32.to_ne_bytes())
    }

    /// A report to the host: its id byte first where the device numbers its reports, the bare bytes where not.
    pub fn input(&self, report: &[u8]) -> io::Result<()> {
        let mut record = Vec::with_capacity(6 + report.len());
        record.extend(12_u32.to_ne_bytes());
        record.extend((report.len() as u16).to_ne_bytes());
        record.extend(report);
        self.send(&record)
    }

    /// Waits for the kernel's next word.
    pub fn next(&self) -> io::Result<Event> {
        let mut record = [0; RECORD];
        let length = (&self.0).read(&mut record)?;
        if length < 4 {
            return Err(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                format!("{length} bytes from /dev/uhid, 4 at least"),
            ));
        }
        let number = u32::from_ne_bytes([record[0], record[1], record[2], record[3]]);
        Ok(match number {
            4 => Event::Open,
            5 => Event::Close,
            6 => {
                let size =
                    u16::from_ne_bytes([record[4 + DATA_MAX], record[5 + DATA_MAX]]) as usize;
                Event::Output(record[4..4 + size.min(DATA_MAX)].to_vec())
            }
            other => Event::Other(other),
        })
    }

    fn send(&self, record: &[u8]) -> io::Result<()> {
        (&self.0).write_all(record)
    }
}

fn text(record: &mut Vec<u8>, text: &str, room: usize) {
    let end = record.len() + room;
    record.extend(text.bytes().take(room - 1));
    record.resize(end, 0);
}
