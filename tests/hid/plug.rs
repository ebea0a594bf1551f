//! The emulated device as a process of its own, and the lead by which the checks hold it: a line in, a line back.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use crate::board::{Board, Fault, Seen};
use crate::kinds::{self, Kind};
use crate::uhid::{Event, Identity, Uhid};

const TICK: Duration = Duration::from_millis(1);

enum Message {
    Kernel(Event),
    Line(String),
    Gone,
}

/// The device process: `KEY SERIAL OFFSET FAULT`, then commands line by line until its input ends.
pub fn device(arguments: &[String]) -> Result<(), String> {
    let [key, serial, offset, fault] = arguments else {
        return Err(
            "a device is four words: kind, serial number, offset of encoder a, fault".into(),
        );
    };
    let kind = kinds::named(key)?;
    let offset = offset
        .parse()
        .map_err(|error| format!("offset '{offset}': {error}"))?;
    let fault = Fault::ALL
        .iter()
        .find(|(key, _)| key == fault)
        .map(|(_, fault)| *fault);
    let uhid = Arc::new(Uhid::new().map_err(|error| format!("/dev/uhid: {error}"))?);

    let (send, receive) = sync_channel(1024);
    let kernel = Arc::clone(&uhid);
    start("kernel", send.clone(), move |send| {
        while let Ok(event) = kernel.next() {
            if send.send(Message::Kernel(event)).is_err() {
                break;
            }
        }
    })?;
    start("lead", send, |send| {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            if send.send(Message::Line(line)).is_err() {
                return;
            }
        }
        let _ = send.send(Message::Gone);
    })?;

    let mut board = Board::new(kind, offset, fault);
    let mut plugged = false;
    let mut held = false;
    let mut next = Instant::now() + TICK;
    loop {
        match receive.recv_timeout(next.saturating_duration_since(Instant::now())) {
            Ok(Message::Kernel(Event::Output(report))) => board.output(&report),
            Ok(Message::Kernel(Event::Open)) => board.seen.open = true,
            Ok(Message::Kernel(Event::Close)) => board.seen.open = false,
            Ok(Message::Kernel(Event::Other(_))) => {}
            Ok(Message::Line(line)) => {
                match line.as_str() {
                    "plug" if !plugged => {
                        board.plugged();
                        plug(&uhid, kind, serial, fault)
                            .map_err(|error| format!("plug: {error}"))?;
                        plugged = true;
                    }
                    "unplug" if plugged && fault != Some(Fault::Stays) => {
                        uhid.unplug().map_err(|error| format!("unplug: {error}"))?;
                        plugged = false;
                    }
                    "hold" => held = true,
                    "go" => held = false,
                    _ => {}
                }
                println!("{}", tell(&board.seen));
            }
            Ok(Message::Gone) | Err(RecvTimeoutError::Disconnected) => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {
                if plugged && !held {
                    for report in board.step() {
                        uhid.input(&report)
                            .map_err(|error| format!("input report: {error}"))?;
                    }
                }
                // After a stall the rhythm begins anew: no burst of reports that no device would send.
                next = (next + TICK).max(Instant::now() - 5 * TICK);
            }
        }
    }
}

/// A named thread.
fn start(
    name: &str,
    send: SyncSender<Message>,
    run: impl FnOnce(SyncSender<Message>) + Send + 'static,
) -> Result<(), String> {
    thread::Builder::new()
        .name(name.into())
        .spawn(move || run(send))
        .map(drop)
        .map_err(|error| format!("thread {name}: {error}"))
}

/// Plugs a device of a kind in.
pub fn plug(uhid: &Uhid, kind: &Kind, serial: &str, fault: Option<Fault>) -> std::io::Result<()> {
    let mut descriptor = (kind.descriptor)();
    if fault == Some(Fault::Page) {
        // The second byte of either layout is the low byte of the usage page.
        descriptor[1] ^= 0x0F;
    }
    uhid.plug(&Identity {
        name: kind.name,
        serial: if fault == Some(Fault::Alias) {
            "ALIAS"
        } else {
            serial
        },
        vendor: kind.vendor,
        product: if fault == Some(Fault::Stranger) {
            !kind.product
        } else {
            kind.product
        },
        descriptor: &descriptor,
    })
}

/// One line: sent, got, missing, off, open, and the newest output report in hexadecimal (a dash for none).
fn tell(seen: &Seen) -> String {
    let mut last: String = seen.last.iter().map(|byte| format!("{byte:02x}")).collect();
    if last.is_empty() {
        last.push('-');
    }
    let Seen {
        sent,
        got,
        missing,
        off,
        open,
        ..
    } = seen;
    format!("{sent} {got} {missing} {off} {open} {last}")
}

fn heard(line: &str) -> Option<Seen> {
    let mut words = line.split_whitespace();
    let mut word = || words.next();
    let seen = Seen {
        sent: word()?.parse().ok()?,
        got: word()?.parse().ok()?,
        missing: word()?.parse().ok()?,
        off: word()?.parse().ok()?,
        open: word()?.parse().ok()?,
        last: Vec::new(),
    };
    let last = word()?;
    let bytes = last.as_bytes().chunks_exact(2).map(|pair| {
        std::str::from_utf8(pair)
            .ok()
            .and_then(|pair| u8::from_str_radix(pair, 16).ok())
    });
    Some(Seen {
        last: bytes.collect::<Option<Vec<u8>>>()?,
        ..seen
    })
}

/// A device process, held by its lead. It is unplugged and gone when this is dropped.
pub struct Emulated {
    pub kind: &'static Kind,
    pub serial: String,
    process: Child,
    lead: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Emulated {
    /// Starts the process and plugs the device in.
    pub fn plugged(
        key: &str,
        serial: &str,
        offset: i16,
        fault: Option<Fault>,
    ) -> Result<Self, String> {
        let program = std::env::current_exe().map_err(|error| format!("own path: {error}"))?;
        let mut process = Command::new(program)
            .args([
                "device",
                key,
                serial,
                &offset.to_string(),
                fault.map_or("none", Fault::key),
            ])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("device process: {error}"))?;
        let lead = process.stdin.take();
        let answers = process
            .stdout
            .take()
            .ok_or("the device process has no output")?;
        let mut emulated = Self {
            kind: kinds::named(key)?,
            serial: serial.into(),
            process,
            lead,
            answers: BufReader::new(answers),
        };
        emulated.tell("plug")?;
        Ok(emulated)
    }

    /// Gives a command (`plug`, `unplug`, `hold`, `go`, `seen`); answers what the device has seen by then.
    pub fn tell(&mut self, command: &str) -> Result<Seen, String> {
        let lead = self
            .lead
            .as_mut()
            .ok_or("the device process has no input")?;
        writeln!(lead, "{command}")
            .map_err(|error| format!("device process, {command}: {error}"))?;
        let mut line = String::new();
        self.answers
            .read_line(&mut line)
            .map_err(|error| format!("device process, {command}: {error}"))?;
        heard(&line).ok_or_else(|| {
            format!(
                "the device process answers '{}' to {command}",
                line.trim_end()
            )
        })
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        self.lead = None;
        let _ = self.process.wait();
    }
}
