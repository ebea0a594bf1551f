//! The messages of a session one after the other, from whole files and from what is left of others.

use super::SessionError;
use super::format::{self, Edit, Event};
use super::wire::{self, Messages, Walk, WireError};
use crate::servo::{FingerRecord, MAX_FINGERS, TickRecord};
use mcap::records::op;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// How to meet damage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strictness {
    /// The first thing wrong ends the reading with an error that says what and where.
    #[default]
    Strict,
    /// Reads every chunk that is whole, steps over the rest and counts it. For recordings that were killed or damaged.
    Lenient,
}

/// What a lenient reading stepped over.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Damage {
    /// The file has no proper end: the recording was killed, or its tail is gone.
    pub unfinished: bool,
    /// Chunks that did not match their checksum or their format.
    pub chunks: u64,
    /// Bytes that belong to no readable record.
    pub bytes: u64,
    /// Messages that do not belong to a session or come in the wrong order.
    pub messages: u64,
    /// The first thing found, in words; empty when nothing was.
    pub first: String,
}

impl Damage {
    /// Whether the file is as its writer finished it.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// One message of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// A finger's tick.
    Tick(FingerRecord),
    /// An event.
    Event(Event),
    /// An edit of the scene; it comes before the first tick that feels it.
    Edit(Edit),
}

/// What is on a channel.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Finger(u8),
    Events,
    Edits,
    Foreign,
}

impl Kind {
    /// What the fixed channels are, in a file that does not say.
    pub(super) fn by_channel() -> BTreeMap<u16, Self> {
        let fingers = (0..MAX_FINGERS as u8).map(|i| (format::finger_channel(i), Self::Finger(i)));
        let others = [
            (format::EVENTS_CHANNEL, Self::Events),
            (format::EDITS_CHANNEL, Self::Edits),
        ];
        fingers.chain(others).collect()
    }

    /// What a topic is in a session of so many fingers.
    pub(super) fn of(topic: &str, n_fingers: usize) -> Self {
        let finger = (0..n_fingers).find(|i| topic == format::finger_topic(*i));
        match finger {
            Some(i) => Self::Finger(i as u8),
            None if topic == format::EVENTS_TOPIC => Self::Events,
            None if topic == format::EDITS_TOPIC => Self::Edits,
            None => Self::Foreign,
        }
    }
}

/// Iterates over the messages of a session. After an error it ends.
pub struct Records {
    walk: Walk<BufReader<File>>,
    path: PathBuf,
    n_fingers: usize,
    strictness: Strictness,
    channels: BTreeMap<u16, Kind>,
    chunk: Vec<u8>,
    at: usize,
    last: [Option<u64>; MAX_FINGERS],
    /// The data section is over.
    ended: bool,
    done: bool,
    damage: Damage,
    /// The last message, in the chunk.
    message: Range<usize>,
    /// A chunk was compressed.
    packed: bool,
}

/// A message as it lies in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RawMessage<'a> {
    /// The channel that a session has it on.
    pub(super) channel: u16,
    pub(super) sequence: u32,
    pub(super) log_ns: u64,
    pub(super) publish_ns: u64,
    pub(super) data: &'a [u8],
}

impl Records {
    pub(super) fn open(
        path: &Path,
        n_fingers: usize,
        strictness: Strictness,
    ) -> Result<Self, SessionError> {
        Ok(Self {
            walk: walk(path, strictness)?,
            path: path.to_owned(),
            n_fingers,
            strictness,
            channels: Kind::by_channel(),
            chunk: Vec::new(),
            at: 0,
            last: [None; MAX_FINGERS],
            ended: false,
            done: false,
            damage: Damage::default(),
            message: 0..0,
            packed: false,
        })
    }

    /// What was stepped over so far.
    pub fn damage(&self) -> &Damage {
        &self.damage
    }

    /// How much of the file is done, 0 to 1.
    pub fn progress(&self) -> f64 {
        self.walk.at() as f64 / self.walk.size().max(1) as f64
    }

    /// Where the chunk of the last entry starts and how long its record is, bytes.
    pub(super) fn chunk(&self) -> (u64, u64) {
        (self.walk.at(), self.walk.next() - self.walk.at())
    }

    /// The last entry as it lies in the file; `None` before the first.
    pub(super) fn message(&self) -> Option<RawMessage<'_>> {
        let record = self.chunk.get(self.message.clone())?;
        let (id, log_ns, data) = wire::message(record).ok()?;
        let u = |at: usize, n: usize| {
            let bytes = record[at..at + n].iter().rev();
            bytes.fold(0, |sum: u64, byte| sum << 8 | u64::from(*byte))
        };
        let channel = match self.channels.get(&id)? {
            Kind::Finger(finger) => format::finger_channel(*finger),
            Kind::Events => format::EVENTS_CHANNEL,
            Kind::Edits => format::EDITS_CHANNEL,
            Kind::Foreign => return None,
        };
        Some(RawMessage {
            channel,
            sequence: u(2, 4) as u32,
            log_ns,
            publish_ns: u(14, 8),
            data,
        })
    }

    /// Whether a chunk so far was compressed.
    pub(super) fn is_packed(&self) -> bool {
        self.packed
    }

    /// What is on each channel, as far as it is known.
    pub(super) fn channels(&self) -> &BTreeMap<u16, Kind> {
        &self.channels
    }

    fn step(&mut self) -> Result<Option<Entry>, SessionError> {
        loop {
            while self.at < self.chunk.len() {
                match wire::record_in_chunk(&self.chunk, self.at) {
                    Ok((opcode, range)) => {
                        self.at = range.end;
                        self.message = range.clone();
                        match self.interpret(opcode, range) {
                            Ok(Some(entry)) => return Ok(Some(entry)),
                            Ok(None) => {}
                            Err(what) => {
                                self.tell(self.walk.at(), what)?;
                                self.damage.messages += 1;
                            }
                        }
                    }
                    Err(what) => {
                        self.tell(self.walk.at(), what)?;
                        self.damage.chunks += 1;
                        self.at = self.chunk.len();
                    }
                }
            }
            if !self.next_chunk()? {
                return Ok(None);
            }
        }
    }

    fn interpret(&mut self, opcode: u8, range: Range<usize>) -> Result<Option<Entry>, String> {
        let record = &self.chunk[range];
        match opcode {
            op::CHANNEL => {
                let (id, topic) = wire::channel(record)?;
                self.channels.insert(id, Kind::of(&topic, self.n_fingers));
                Ok(None)
            }
            op::MESSAGE => {
                let (id, _, data) = wire::message(record)?;
                match self.channels.get(&id) {
                    Some(Kind::Finger(finger)) => {
                        let record = format::decode_tick(data)?;
                        self.check(*finger, &record)?;
                        self.last[usize::from(record.finger)] = Some(record.tick);
                        Ok(Some(Entry::Tick(record)))
                    }
                    Some(Kind::Events) => Ok(Some(Entry::Event(format::decode_event(data)?))),
                    Some(Kind::Edits) => Ok(Some(Entry::Edit(format::decode_edit(data)?))),
                    Some(Kind::Foreign) => Ok(None),
                    None => Err(format!("channel {id} is unknown")),
                }
            }
            _ => Ok(None),
        }
    }

    fn check(&self, channel: u8, record: &FingerRecord) -> Result<(), String> {
        let finger = usize::from(record.finger);
        if record.finger != channel || finger >= self.n_fingers {
            return Err(format!(
                "finger {finger} on the channel of finger {channel}"
            ));
        }
        match self.last[finger] {
            Some(last) if record.tick <= last => {
                let tick = record.tick;
                Err(format!(
                    "tick {tick} of finger {finger} comes after tick {last}"
                ))
            }
            _ => Ok(()),
        }
    }

    /// Goes to the next chunk that can be read. `false` at the end.
    fn next_chunk(&mut self) -> Result<bool, SessionError> {
        self.walk.recycle(std::mem::take(&mut self.chunk));
        self.at = 0;
        loop {
            match self.walk.advance() {
                Ok(None) => return Ok(false),
                Ok(Some(op::CHUNK)) if !self.ended => {
                    match wire::chunk_messages(self.walk.record()) {
                        Ok(Messages::Plain(start)) => {
                            self.chunk = self.walk.take_record();
                            self.at = start;
                            return Ok(true);
                        }
                        Ok(Messages::Unpacked(messages)) => {
                            self.chunk = messages;
                            self.packed = true;
                            return Ok(true);
                        }
                        Err(what) => {
                            self.tell(self.walk.at(), what)?;
                            self.damage.chunks += 1;
                        }
                    }
                }
                Ok(Some(opcode)) => {
                    let known = self.ended || self.walk.makes_sense(opcode);
                    self.ended |= known && opcode == op::DATA_END;
                    if !known {
                        let at = self.walk.at();
                        let what = format!("a record of kind {opcode} that makes no sense here");
                        self.tell(at, what)?;
                        if !self.skip_from(at)? {
                            return Ok(false);
                        }
                    }
                }
                Err(WireError::Io(e)) => return Err(wire_error(&self.path, WireError::Io(e))),
                Err(WireError::Damaged(at, what)) => {
                    self.tell(at, what)?;
                    if self.ended || !self.skip_from(at)? {
                        self.damage.unfinished = true;
                        return Ok(false);
                    }
                }
            }
        }
    }

    /// Strict: an error. Lenient: noted.
    fn tell(&mut self, at: u64, what: String) -> Result<(), SessionError> {
        if self.strictness == Strictness::Strict {
            return Err(wire_error(&self.path, WireError::Damaged(at, what)));
        }
        if self.damage.first.is_empty() {
            self.damage.first = format!("byte {at}: {what}");
        }
        Ok(())
    }

    /// Lenient: leaves the record at `at` and goes to the next chunk behind it.
    fn skip_from(&mut self, at: u64) -> Result<bool, SessionError> {
        let found = self.walk.resynchronise(at + 1, u64::MAX);
        let found = found.map_err(|e| wire_error(&self.path, WireError::Io(e)))?;
        let until = if found {
            self.walk.next()
        } else {
            self.walk.size()
        };
        self.damage.bytes += until.saturating_sub(at);
        if !found {
            self.damage.unfinished = true;
        }
        Ok(found)
    }
}

impl Iterator for Records {
    type Item = Result<Entry, SessionError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let step = self.step().transpose();
        self.done = !matches!(step, Some(Ok(_)));
        step
    }
}

/// Iterates over the whole ticks of a session.
pub struct Ticks {
    records: Records,
    n_fingers: usize,
    /// Records of one tick, until all are there.
    pending: TickRecord,
    tick: u64,
    incomplete: u64,
    edits: Vec<Edit>,
}

impl Ticks {
    pub(super) fn of(records: Records, n_fingers: usize) -> Self {
        Self {
            records,
            n_fingers,
            pending: TickRecord::default(),
            tick: 0,
            incomplete: 0,
            edits: Vec::new(),
        }
    }

    /// What was stepped over so far.
    pub fn damage(&self) -> &Damage {
        self.records.damage()
    }

    /// How much of the file is done, 0 to 1.
    pub fn progress(&self) -> f64 {
        self.records.progress()
    }

    /// Ticks left out because not every finger's record is there. The last tick of a killed recording is not counted.
    pub fn incomplete(&self) -> u64 {
        self.incomplete
    }

    /// The edits met since the last call: all that the ticks so far name are among those taken.
    pub fn take_edits(&mut self) -> Vec<Edit> {
        std::mem::take(&mut self.edits)
    }
}

impl Iterator for Ticks {
    type Item = Result<TickRecord, SessionError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let record = match self.records.next()? {
                Err(e) => return Some(Err(e)),
                Ok(Entry::Event(_)) => continue,
                Ok(Entry::Edit(edit)) => {
                    self.edits.push(edit);
                    continue;
                }
                Ok(Entry::Tick(record)) => record,
            };
            if self.pending.n_fingers > 0 && self.tick != record.tick {
                self.incomplete += 1;
                self.pending.n_fingers = 0;
            }
            self.tick = record.tick;
            self.pending.fingers[usize::from(record.finger)] = record;
            self.pending.n_fingers += 1;
            if self.pending.n_fingers == self.n_fingers {
                return Some(Ok(std::mem::take(&mut self.pending)));
            }
        }
    }
}

/// The records of a file from its start.
pub(super) fn walk(
    path: &Path,
    strictness: Strictness,
) -> Result<Walk<BufReader<File>>, SessionError> {
    let open = || {
        let file = File::open(path)?;
        let check = strictness == Strictness::Strict;
        Walk::new(BufReader::with_capacity(64 * 1024, file), check)
    };
    open().map_err(|source| SessionError::Io {
        path: path.to_owned(),
        source,
    })
}

pub(super) fn wire_error(path: &Path, error: WireError) -> SessionError {
    let path = path.to_owned();
    match error {
        WireError::Io(source) => SessionError::Io { path, source },
        WireError::Damaged(at, what) => SessionError::Damaged {
            path,
            reason: format!("byte {at}: {what}"),
        },
    }
}
