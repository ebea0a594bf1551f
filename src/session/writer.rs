//! Writing a session, synchronously.

use super::SessionError;
use super::extras::Extras;
use super::format::{self, Edit, Event};
use super::header::{Header, with_checksum};
use crate::servo::{FingerRecord, MAX_FINGERS};
use crate::units::{NS_PER_S, s_from_ns};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapError, McapResult, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A chunk is closed when it holds this much.
const CHUNK_BYTES: u64 = 256 * 1024;
/// A chunk is closed and handed to the system at least this often: what a killed program may lose. Four times a second
/// costs 0.2 % in size.
const FLUSH_EVERY: Duration = Duration::from_millis(250);
/// The disk is asked to keep what it was given this often: what a power cut may lose.
const KEEP_EVERY: Duration = Duration::from_secs(1);
/// That takes at most one part in this many of the time, so that a slow disk is not busy with it alone.
const KEEP_SHARE: u32 = 10;

/// What to do when the file is already there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IfExists {
    /// Refuse: a recording is never overwritten by accident.
    #[default]
    Refuse,
    /// Replace it; someone has said so.
    Replace,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RecordingSummary {
    /// The file.
    pub path: PathBuf,
    /// Number of fingers.
    pub fingers: usize,
    /// Ticks written.
    pub ticks: u64,
    /// Time from the first to the last tick, s.
    pub seconds: f64,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Records (one per finger and tick) that never reached the recorder.
    pub lost: u64,
    /// Events written.
    pub events: u64,
    /// Edits of the scene written.
    pub edits: u64,
}

/// Where the bytes of a session go: a file, or a stand-in that fails on purpose.
pub trait Store: Send + Sync {
    /// Appends all of `bytes`.
    ///
    /// # Errors
    /// What the system says.
    fn append(&self, bytes: &[u8]) -> io::Result<()>;

    /// Makes sure that what was appended outlives a power cut.
    ///
    /// # Errors
    /// What the system says, or that nobody will find the file again.
    fn keep(&self) -> io::Result<()>;
}

impl Store for Box<dyn Store> {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        (**self).append(bytes)
    }

    fn keep(&self) -> io::Result<()> {
        (**self).keep()
    }
}

impl Store for File {
    fn append(&self, bytes: &[u8]) -> io::Result<()> {
        let mut file = self;
        file.write_all(bytes)
    }

    fn keep(&self) -> io::Result<()> {
        #[cfg(unix)]
        if std::os::unix::fs::MetadataExt::nlink(&self.metadata()?) == 0 {
            // Writing would go on without error, into a file that no name leads to.
            return Err(io::Error::other(
                "the file was removed while it was recorded",
            ));
        }
        self.sync_data()
    }
}

/// What the MCAP writer writes to: gathers small pieces and appends them to the store at each flush.
struct Sink<S> {
    store: Arc<S>,
    buffer: Vec<u8>,
    appended: Arc<AtomicU64>,
    /// Bytes held here, and by the largest chunk that came.
    held: Arc<AtomicU64>,
    largest: usize,
}

impl<S: Store> Write for Sink<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.buffer.extend_from_slice(bytes);
        self.largest = self.largest.max(bytes.len());
        // A chunk comes whole, from a list that begins with room for one and grows by doubling.
        let chunk = (self.largest.next_power_of_two() as u64).max(CHUNK_BYTES);
        let held = self.buffer.capacity() as u64 + chunk;
        self.held.store(held, Ordering::Relaxed);
        if self.buffer.len() as u64 > 2 * CHUNK_BYTES {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.store.append(&self.buffer)?;
        let length = self.buffer.len() as u64;
        self.appended.fetch_add(length, Ordering::Relaxed);
        self.buffer.clear();
        Ok(())
    }
}

impl<S: Store> Seek for Sink<S> {
    /// Tells the position; moving is refused, nothing written is ever changed.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => {
                Ok(self.appended.load(Ordering::Relaxed) + self.buffer.len() as u64)
            }
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}

/// Writes one session. Dropping it without [`Self::finish`] finishes the file as well as it can.
///
/// A writer that failed stays failed: every later call gives the first error again.
pub struct SessionWriter<S: Store = File> {
    /// `None` once failed or finished.
    mcap: Option<Writer<Sink<S>>>,
    store: Arc<S>,
    appended: Arc<AtomicU64>,
    held: Arc<AtomicU64>,
    path: PathBuf,
    failure: Option<String>,
    n_fingers: usize,
    started_ns: u64,
    step_ns: u64,
    message: Vec<u8>,
    /// The tick each finger is due to write next.
    due: [u64; MAX_FINGERS],
    /// Tick and time of the newest record written.
    newest: Option<(u64, u64)>,
    first_time_ns: u64,
    /// Added to ticks and times, so that those of a restarted servo come behind those already written.
    shift: (u64, u64),
    restart_pending: bool,
    ticks: u64,
    lost: u64,
    events: u64,
    edits: u64,
    flushed: Instant,
    kept: Instant,
    keep_wait: Duration,
}

impl SessionWriter<File> {
    /// Creates the file and writes all that precedes the ticks.
    ///
    /// # Errors
    /// The header is not writable, the file is already there ([`IfExists::Refuse`]), or the system refuses to write.
    pub fn create(path: &Path, header: &Header, if_exists: IfExists) -> Result<Self, SessionError> {
        Self::create_with(path, header, &Extras::of_this_machine(), if_exists)
    }

    /// As [`Self::create`], with the mesh and whatever else is to travel with the session.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn create_with(
        path: &Path,
        header: &Header,
        extras: &Extras,
        if_exists: IfExists,
    ) -> Result<Self, SessionError> {
        header.to_map()?;
        Self::with_extras(created(path, if_exists)?, path, header, extras)
    }
}

/// A new file.
pub(super) fn created(path: &Path, if_exists: IfExists) -> Result<File, SessionError> {
    let mut options = OpenOptions::new();
    options.write(true);
    match if_exists {
        IfExists::Refuse => options.create_new(true),
        IfExists::Replace => options.create(true).truncate(true),
    };
    options.open(path).map_err(|source| io_error(path, source))
}

impl<S: Store> SessionWriter<S> {
    /// Writes to `store`; `path` names it in messages.
    ///
    /// # Errors
    /// As [`SessionWriter::create`].
    pub fn on(store: S, path: &Path, header: &Header) -> Result<Self, SessionError> {
        Self::with_extras(store, path, header, &Extras::of_this_machine())
    }

    /// As [`Self::on`], with what is to travel with the session.
    ///
    /// # Errors
    /// As [`SessionWriter::create`].
    pub fn with_extras(
        store: S,
        path: &Path,
        header: &Header,
        extras: &Extras,
    ) -> Result<Self, SessionError> {
        let started_ns = header.started_ns()?;
        let store = Arc::new(store);
        let appended = Arc::new(AtomicU64::new(0));
        let held = Arc::new(AtomicU64::new(0));
        let sink = Sink {
            store: Arc::clone(&store),
            buffer: Vec::new(),
            appended: Arc::clone(&appended),
            held: Arc::clone(&held),
            largest: 0,
        };
        let mcap = begin(sink, header, extras, None)?.map_err(|e| failed(path, e))?;
        let now = Instant::now();
        Ok(Self {
            mcap: Some(mcap),
            store,
            appended,
            held,
            path: path.to_owned(),
            failure: None,
            n_fingers: header.n_fingers(),
            started_ns,
            step_ns: (header.dt_s() * NS_PER_S) as u64,
            message: Vec::new(),
            due: [0; MAX_FINGERS],
            newest: None,
            first_time_ns: 0,
            shift: (0, 0),
            restart_pending: false,
            ticks: 0,
            lost: 0,
            events: 0,
            edits: 0,
            flushed: now,
            kept: now,
            keep_wait: KEEP_EVERY,
        })
    }

    /// Writes one finger's tick. Records are skipped until finger 0 begins a tick, so that the file starts with a whole
    /// one.
    ///
    /// # Errors
    /// The finger is not in the header, or writing failed.
    pub fn write(&mut self, record: &FingerRecord) -> Result<(), SessionError> {
        let finger = usize::from(record.finger);
        if finger >= self.n_fingers {
            let n = self.n_fingers;
            return Err(self.fail(format!(
                "finger {finger} ticks, but the header names {n} device(s), for fingers from 0"
            )));
        }
        if self.newest.is_none() {
            if finger != 0 {
                return Ok(());
            }
            self.first_time_ns = record.time_ns;
            self.due = [record.tick; MAX_FINGERS];
        }
        let mut record = *record;
        self.place(&mut record)?;
        let missing = record.tick - self.due[finger];
        if missing > 0 {
            self.lost += missing;
            let text = format!("{missing} of finger {finger} before tick {}", record.tick);
            self.event_at("lost", &text, record.tick, record.time_ns)?;
        }
        if self.newest.is_none_or(|(tick, _)| tick != record.tick) {
            self.ticks += 1;
        }
        self.due[finger] = record.tick.saturating_add(1);
        self.newest = Some((record.tick, record.time_ns));
        let mut message = std::mem::take(&mut self.message);
        format::encode_tick(&record, &mut message);
        let channel = format::finger_channel(record.finger);
        let outcome = self.put(channel, record.tick, record.time_ns, &message);
        self.message = message;
        outcome
    }

    /// Says that the servo was started anew: tick numbers go on behind those already written, after a gap.
    pub fn restarted(&mut self) {
        self.restart_pending = self.newest.is_some();
    }

    /// Shifts tick and time behind what is written when the servo was started anew; else leaves them.
    fn place(&mut self, record: &mut FingerRecord) -> Result<(), SessionError> {
        let shifted = |(ticks, ns)| {
            let tick = record.tick.saturating_add(ticks);
            (tick, record.time_ns.saturating_add(ns))
        };
        let (mut tick, mut time_ns) = shifted(self.shift);
        let backwards = tick < self.due[usize::from(record.finger)];
        if let Some((newest, newest_ns)) = self.newest
            && (backwards || self.restart_pending)
        {
            // One number stays free: the gap tells readers that this record does not follow from the one before.
            let next = newest.saturating_add(2);
            let next_ns = newest_ns.saturating_add(2 * self.step_ns);
            let by_ticks = next.saturating_sub(record.tick);
            self.shift = (by_ticks, next_ns.saturating_sub(record.time_ns));
            (tick, time_ns) = shifted(self.shift);
            let text = format!("servo started anew; tick {} is its {}", tick, record.tick);
            self.event_at("restart", &text, tick, time_ns)?;
            self.due = [tick; MAX_FINGERS];
            self.restart_pending = false;
        }
        (record.tick, record.time_ns) = (tick, time_ns);
        Ok(())
    }

    /// Writes an event at the newest tick.
    ///
    /// # Errors
    /// Writing failed.
    pub fn event(&mut self, kind: &str, text: &str) -> Result<(), SessionError> {
        let (tick, time_ns) = self.newest.unwrap_or((0, self.first_time_ns));
        self.event_at(kind, text, tick, time_ns)
    }

    fn event_at(
        &mut self,
        kind: &str,
        text: &str,
        tick: u64,
        time_ns: u64,
    ) -> Result<(), SessionError> {
        let message = format::encode_event(&Event {
            tick,
            time_ns,
            kind: kind.to_owned(),
            text: text.to_owned(),
        });
        self.events += 1;
        self.put(format::EVENTS_CHANNEL, tick, time_ns, &message)
    }

    /// Writes an edit of the scene: to be called before the first tick that feels it is written.
    ///
    /// # Errors
    /// Writing failed.
    pub fn edit(&mut self, number: u32, scenario_toml: &Arc<str>) -> Result<(), SessionError> {
        let (tick, time_ns) = self.newest.unwrap_or((0, self.first_time_ns));
        let message = format::encode_edit(&Edit {
            number,
            tick,
            time_ns,
            scenario_toml: Arc::clone(scenario_toml),
        });
        self.edits += 1;
        self.put(format::EDITS_CHANNEL, tick, time_ns, &message)
    }

    /// Says in which scene a sealed session was felt: to be called once, behind its ticks.
    ///
    /// # Errors
    /// The header is not writable or still sealed, or writing failed.
    pub fn reveal(&mut self, header: &Header) -> Result<(), SessionError> {
        if header.sealed {
            return Err(SessionError::Header {
                key: "sealed".into(),
                value: "on".into(),
                allowed: "off, for what is revealed",
            });
        }
        let metadata = header.to_map()?;
        let started_ns = self.started_ns;
        self.attempt(|mcap| {
            about(mcap, header, metadata.clone(), started_ns)?;
            about(mcap, header, metadata, started_ns)
        })
    }

    fn put(
        &mut self,
        channel_id: u16,
        tick: u64,
        time_ns: u64,
        message: &[u8],
    ) -> Result<(), SessionError> {
        let since_first_ns = time_ns.saturating_sub(self.first_time_ns);
        let log_time = self.started_ns.saturating_add(since_first_ns);
        let header = MessageHeader {
            channel_id,
            sequence: tick as u32,
            log_time,
            publish_time: log_time,
        };
        self.attempt(|mcap| mcap.write_to_known_channel(&header, message))
    }

    /// Closes the chunk and hands it to the system: from here on a kill cannot lose it.
    ///
    /// # Errors
    /// Writing failed.
    pub fn flush(&mut self) -> Result<(), SessionError> {
        self.attempt(Writer::flush)
    }

    /// Does what is due by the clock: [`Self::flush`] four times a second; once a second, or less often on a slow disk,
    /// asks the disk to keep what it has and looks whether the file is still there. To be called often.
    ///
    /// # Errors
    /// Writing failed, or someone removed the file.
    pub fn tend(&mut self, now: Instant) -> Result<(), SessionError> {
        if now.saturating_duration_since(self.flushed) >= FLUSH_EVERY {
            self.flushed = now;
            self.flush()?;
        }
        if now.saturating_duration_since(self.kept) >= self.keep_wait {
            let began = Instant::now();
            let store = Arc::clone(&self.store);
            self.attempt(|_| Ok(store.keep()?))?;
            self.kept = now;
            self.keep_wait = KEEP_EVERY.max(began.elapsed() * KEEP_SHARE);
        }
        Ok(())
    }

    /// Ticks, bytes, seconds and lost records so far.
    pub fn summary(&self) -> RecordingSummary {
        let last_ns = self.newest.map_or(self.first_time_ns, |(_, ns)| ns);
        RecordingSummary {
            path: self.path.clone(),
            fingers: self.n_fingers,
            ticks: self.ticks,
            seconds: s_from_ns(last_ns.saturating_sub(self.first_time_ns)),
            bytes: self.appended.load(Ordering::Relaxed),
            lost: self.lost,
            events: self.events,
            edits: self.edits,
        }
    }

    /// Memory held, bytes, as far as it can be seen from outside the file format's own writer: the chunk that is gathered, and
    /// what waits for the system.
    pub fn held_bytes(&self) -> usize {
        self.held.load(Ordering::Relaxed) as usize + self.message.capacity()
    }

    /// Completes the file with its summary and has the disk keep it.
    ///
    /// # Errors
    /// Writing failed, now or before.
    pub fn finish(mut self) -> Result<RecordingSummary, SessionError> {
        let store = Arc::clone(&self.store);
        self.attempt(|mcap| {
            mcap.finish()?;
            Ok(store.keep()?)
        })?;
        Ok(self.summary())
    }

    fn attempt(
        &mut self,
        act: impl FnOnce(&mut Writer<Sink<S>>) -> McapResult<()>,
    ) -> Result<(), SessionError> {
        let outcome = match &mut self.mcap {
            Some(mcap) => act(mcap),
            None => Err(McapError::AttemptedWriteAfterFailure),
        };
        outcome.map_err(|e| match &self.failure {
            Some(first) => SessionError::Recorder(first.clone()),
            None => self.fail(failed(&self.path, e).to_string()),
        })
    }

    /// Stops writing for good. Nothing more is appended: what is on disk ends with a whole chunk, or with the piece of one
    /// that the system took before it refused.
    fn fail(&mut self, reason: String) -> SessionError {
        if let Some(mcap) = self.mcap.take() {
            drop(mcap.into_inner());
        }
        self.failure = Some(reason.clone());
        SessionError::Recorder(reason)
    }
}

/// Writes all that precedes the ticks. The first chunk, with schemas and channels only, is closed at once: what is killed
/// right after its start is a readable, empty session.
pub(super) fn begin<W: Write + Seek>(
    sink: W,
    header: &Header,
    extras: &Extras,
    compression: Option<Compression>,
) -> Result<McapResult<Writer<W>>, SessionError> {
    let metadata = header.to_map()?;
    let started_ns = header.started_ns()?;
    Ok(begun(
        sink,
        header,
        extras,
        compression,
        metadata,
        started_ns,
    ))
}

fn begun<W: Write + Seek>(
    sink: W,
    header: &Header,
    extras: &Extras,
    compression: Option<Compression>,
    metadata: BTreeMap<String, String>,
    started_ns: u64,
) -> McapResult<Writer<W>> {
    let options = WriteOptions::new()
        .compression(compression)
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES))
        .profile(format::PROFILE)
        .library(concat!("dorsum ", env!("CARGO_PKG_VERSION")))
        // A chunk is built in memory and appended whole: the file never holds one with a blank header.
        .disable_seeking(true);
    let mut mcap = options.create(sink)?;
    extras.write(&mut mcap, header, started_ns)?;
    about(&mut mcap, header, metadata.clone(), started_ns)?;
    let schemas = format::file_descriptor_set();
    let tick = mcap.add_schema(format::TICK_SCHEMA, "protobuf", &schemas)?;
    let event = mcap.add_schema(format::EVENT_SCHEMA, "protobuf", &schemas)?;
    for (finger, device) in (0..).zip(&header.devices) {
        let about = BTreeMap::from([("device".to_owned(), device.name.clone())]);
        let id = format::finger_channel(finger);
        let topic = format::finger_topic(finger.into());
        mcap.add_channel_with_id(id, tick, &topic, "protobuf", &about)?;
    }
    let edit = mcap.add_schema(format::EDIT_SCHEMA, "protobuf", &schemas)?;
    for (id, schema, topic) in [
        (format::EVENTS_CHANNEL, event, format::EVENTS_TOPIC),
        (format::EDITS_CHANNEL, edit, format::EDITS_TOPIC),
    ] {
        mcap.add_channel_with_id(id, schema, topic, "protobuf", &BTreeMap::new())?;
    }
    mcap.flush()?;
    // A second time, in case that the first is damaged one day.
    about(&mut mcap, header, metadata, started_ns)?;
    mcap.flush()?;
    Ok(mcap)
}

/// Writes what the run is: metadata and scenario.
fn about<W: Write + Seek>(
    mcap: &mut Writer<W>,
    header: &Header,
    metadata: BTreeMap<String, String>,
    started_ns: u64,
) -> McapResult<()> {
    mcap.write_metadata(&Metadata {
        name: format::METADATA.into(),
        metadata: with_checksum(metadata),
    })?;
    mcap.attach(&Attachment {
        log_time: started_ns,
        create_time: started_ns,
        name: format::SCENARIO.into(),
        media_type: "application/toml".into(),
        data: header.scenario_toml.as_bytes().into(),
    })
}

pub(super) fn io_error(path: &Path, source: io::Error) -> SessionError {
    SessionError::Io {
        path: path.to_owned(),
        source,
    }
}

pub(super) fn failed(path: &Path, error: McapError) -> SessionError {
    let source = match error {
        McapError::Io(source) => source,
        other => io::Error::other(other.to_string()),
    };
    io_error(path, source)
}
