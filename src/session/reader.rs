//! Reading sessions, whole ones and what is left of others.

use super::SessionError;
use super::extras::{Extras, Folder};
use super::format::{self, Edit, Event};
use super::header::Header;
use super::index::Summary;
use super::playback::Source;
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

/// A session file whose header has been read. Cheap to open, whatever its length.
#[derive(Clone, Debug)]
pub struct Session {
    path: PathBuf,
    header: Header,
    bytes: u64,
}

impl Session {
    /// Opens a session and reads its header.
    ///
    /// # Errors
    /// The file cannot be read, is not a session, or its header is damaged.
    pub fn open(path: &Path) -> Result<Self, SessionError> {
        let mut walk = walk(path, Strictness::Lenient)?;
        let mut about = About::default();
        let begun = about.begin(&mut walk);
        begun.map_err(|e| wire_error(path, e))?;
        if about.is_sealed() {
            let said = indexed(path).or_else(|| revealed(&mut walk));
            about = said.unwrap_or(about);
        }
        let (map, scenario) = (
            about.map.unwrap_or_default(),
            about.scenario.unwrap_or_default(),
        );
        let header = Header::from_map(&map, scenario).map_err(|e| SessionError::Damaged {
            path: path.to_owned(),
            reason: e.to_string(),
        })?;
        Ok(Self {
            path: path.to_owned(),
            header,
            bytes: walk.size(),
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the run was.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// What travels with it: the mesh, calibrations, facts of the machine. What is damaged or was not written is not there.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn extras(&self) -> Result<Extras, SessionError> {
        Extras::read(&self.path, &self.header)
    }

    /// The folder in which its scenario finds its mesh: that of the file, or where the mesh is not there any more one that the mesh
    /// is unpacked into from the session. To be kept while the scene is built.
    ///
    /// # Errors
    /// The file cannot be read, or the mesh cannot be unpacked.
    pub fn folder(&self) -> Result<Folder, SessionError> {
        Folder::of(&self.path, &self.header)
    }

    /// Size of the file, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Every message in the order written. Memory does not grow with the length of the session.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn entries(&self, strictness: Strictness) -> Result<Records, SessionError> {
        Ok(Records {
            walk: walk(&self.path, strictness)?,
            path: self.path.clone(),
            n_fingers: self.header.n_fingers(),
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

    /// Every whole tick in order; events are left out. Memory does not grow with the length of the session.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn ticks(&self, strictness: Strictness) -> Result<Ticks, SessionError> {
        Ok(Ticks {
            records: self.entries(strictness)?,
            n_fingers: self.header.n_fingers(),
            pending: TickRecord::default(),
            tick: 0,
            incomplete: 0,
            edits: Vec::new(),
        })
    }

    /// Reads everything into memory: about 280 bytes per finger and tick.
    ///
    /// # Errors
    /// [`Strictness::Strict`]: the first thing wrong. [`Strictness::Lenient`]: only what the system refuses.
    pub fn load(&self, strictness: Strictness) -> Result<Recording, SessionError> {
        let mut fingers = vec![Vec::new(); self.header.n_fingers()];
        let (mut events, mut edits) = (Vec::new(), Vec::new());
        let mut entries = self.entries(strictness)?;
        for entry in &mut entries {
            match entry? {
                Entry::Tick(record) => fingers[usize::from(record.finger)].push(record),
                Entry::Event(event) => events.push(event),
                Entry::Edit(edit) => edits.push(edit),
            }
        }
        Ok(Recording {
            header: self.header.clone(),
            fingers,
            events,
            edits,
            damage: entries.damage,
        })
    }
}

/// What a session is stands within this of its start, bytes, if at all.
const FARTHEST_START: u64 = 64 * 1024 * 1024;

const NO_HEADER: &str = "its header is missing; was it recorded by Dorsum?";

/// Metadata and scenario of a session, as they are come upon.
#[derive(Default)]
struct About {
    map: Option<BTreeMap<String, String>>,
    scenario: Option<String>,
}

impl About {
    fn is_whole(&self) -> bool {
        self.map.is_some() && self.scenario.is_some()
    }

    fn is_sealed(&self) -> bool {
        self.map.as_ref().is_some_and(|m| m.contains_key("sealed"))
    }

    /// Reads on to the first that is whole. What it is stands twice, before and behind the first chunk: where the one is
    /// damaged, the other is taken.
    fn begin(&mut self, walk: &mut Walk<BufReader<File>>) -> Result<(), WireError> {
        let mut first_wrong = None;
        let mut chunks = 0;
        while !self.is_whole() && chunks < 2 {
            let wrong = match walk.advance() {
                Ok(None) => break,
                Ok(Some(op::CHUNK)) => {
                    chunks += 1;
                    continue;
                }
                Ok(Some(opcode)) => {
                    let taken = self.take(opcode, walk.record());
                    match (walk.makes_sense(opcode), taken) {
                        (true, Ok(())) => continue,
                        (_, Err(what)) => WireError::Damaged(walk.at(), what),
                        (false, Ok(())) => WireError::Damaged(walk.at(), NO_HEADER.into()),
                    }
                }
                Err(WireError::Io(e)) => return Err(WireError::Io(e)),
                Err(wrong) => wrong,
            };
            let behind = match &wrong {
                WireError::Damaged(at, _) => at + 1,
                WireError::Io(_) => walk.next() + 1,
            };
            first_wrong.get_or_insert(wrong);
            let near = behind.saturating_add(FARTHEST_START);
            if !walk.resynchronise(behind, near).map_err(WireError::Io)? {
                break;
            }
        }
        if self.is_whole() {
            return Ok(());
        }
        let missing = || WireError::Damaged(walk.at(), NO_HEADER.into());
        Err(first_wrong.unwrap_or_else(missing))
    }

    /// Takes a record: metadata begin anew, the scenario follows.
    fn take(&mut self, opcode: u8, record: &[u8]) -> Result<(), String> {
        match opcode {
            op::METADATA => {
                let (name, entries) = wire::metadata(record)?;
                if name == format::METADATA {
                    *self = Self::default();
                    self.map = Some(super::header::checked(entries)?);
                }
            }
            op::ATTACHMENT => {
                let (name, data) = wire::attachment(record)?;
                if name == format::SCENARIO {
                    let text =
                        std::str::from_utf8(data).map_err(|e| format!("the scenario: {e}"))?;
                    self.scenario = Some(text.to_owned());
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// What a finished session says of itself last, found by its summary; `None` where that is missing or wrong.
fn indexed(path: &Path) -> Option<About> {
    let mut file = File::open(path).ok()?;
    let summary = Summary::read(&mut file).ok()??;
    let last = |places: &BTreeMap<u64, String>, name: &str| {
        let mut named = places.iter().filter(|(_, n)| *n == name);
        named.next_back().map(|(at, _)| *at)
    };
    let mut about = About::default();
    for at in [
        last(&summary.metadata, format::METADATA)?,
        last(&summary.attachments, format::SCENARIO)?,
    ] {
        let (opcode, record) = wire::record_at(&mut file, at).ok()?;
        about.take(opcode, &record).ok()?;
    }
    about.is_whole().then_some(about)
}

/// What a sealed session says behind its ticks; `None` where it was never answered, or where what says so is damaged.
fn revealed(walk: &mut Walk<BufReader<File>>) -> Option<About> {
    let mut about = About::default();
    while !about.is_whole() || about.is_sealed() {
        let opcode = match walk.advance() {
            Ok(opcode) => opcode?,
            Err(_) => {
                let behind = walk.next() + 1;
                if !walk.resynchronise(behind, u64::MAX).unwrap_or(false) {
                    return None;
                }
                continue;
            }
        };
        if matches!(opcode, op::METADATA | op::ATTACHMENT) {
            let _ = about.take(opcode, walk.record());
        }
    }
    Some(about)
}

/// A session in memory.
#[derive(Clone, Debug)]
pub struct Recording {
    /// What the run was.
    pub header: Header,
    /// Every tick of each finger, tick numbers strictly increasing.
    pub fingers: Vec<Vec<FingerRecord>>,
    /// Every event.
    pub events: Vec<Event>,
    /// Every edit of the scene.
    pub edits: Vec<Edit>,
    /// What could not be read.
    pub damage: Damage,
}

impl Recording {
    /// The scenario after edit `number`; `None` where its text is not in the file.
    pub fn scenario_after(&self, number: u32) -> Option<&str> {
        self.header.scenario_after(number, &self.edits)
    }
}

impl Source for Recording {
    fn header(&self) -> &Header {
        &self.header
    }

    fn span_ns(&self) -> (u64, u64) {
        let firsts = self.fingers.iter().filter_map(|f| f.first());
        let first_ns = firsts.map(|r| r.time_ns).min().unwrap_or(0);
        let lasts = self.fingers.iter().filter_map(|f| f.last());
        let last_ns = lasts.map(|r| r.time_ns).max().unwrap_or(0);
        (first_ns, last_ns.max(first_ns))
    }

    fn events(&self) -> &[Event] {
        &self.events
    }

    fn at_ns(&self, time_ns: u64) -> TickRecord {
        let mut view = TickRecord {
            n_fingers: self.fingers.len().min(MAX_FINGERS),
            ..TickRecord::default()
        };
        for (shown, finger) in view.fingers.iter_mut().zip(&self.fingers) {
            let newest = finger.partition_point(|r| r.time_ns <= time_ns).max(1) - 1;
            if let Some(record) = finger.get(newest) {
                *shown = *record;
            }
        }
        view
    }

    fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64> {
        let line = self.fingers.first().filter(|f| !f.is_empty())?;
        let present = line.partition_point(|r| r.time_ns <= time_ns) as i64 - 1;
        let target = present
            .saturating_add(ticks)
            .clamp(0, line.len() as i64 - 1);
        Some(line[target as usize].time_ns)
    }
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
}

impl Ticks {
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

fn walk(path: &Path, strictness: Strictness) -> Result<Walk<BufReader<File>>, SessionError> {
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
