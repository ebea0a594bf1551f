//! Writing a session anew from another file: compressed, or what is left of a damaged one.

use super::format;
use super::header::Header;
use super::reader::Session;
use super::records::{Damage, Entry, Records, Strictness};
use super::writer::{self, IfExists};
use super::{SessionError, utc_now};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapError, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// How to save what is left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecoverOptions {
    /// Compress the chunks of the new file.
    pub compress: bool,
    /// Whether a file of the new name may be replaced.
    pub if_exists: IfExists,
}

/// What of one finger is in the new file and what is missing.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct FingerLoss {
    /// Which finger, from 0.
    pub finger: u8,
    /// Records saved.
    pub records: u64,
    /// Gaps in its tick numbers that the recording itself does not explain.
    pub gaps: u64,
    /// Ticks missing in them.
    pub missing: u64,
    /// Ticks that the recording says were lost while it ran.
    pub lost_live: u64,
}

/// What saving a session came to.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct RecoverReport {
    /// The file read.
    pub file: PathBuf,
    /// The file written.
    pub out: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// Ticks saved: of the finger that has most.
    pub ticks: u64,
    /// Time from the first to the last tick, s.
    pub seconds: f64,
    /// Events saved.
    pub events: u64,
    /// Edits saved.
    pub edits: u64,
    /// What is left and missing, finger by finger.
    pub fingers: Vec<FingerLoss>,
    /// What was stepped over.
    pub damage: Damage,
}

impl RecoverReport {
    /// Whether all of the file was whole.
    pub fn is_whole(&self) -> bool {
        self.damage.is_none() && self.fingers.iter().all(|f| f.missing == 0)
    }

    /// What was lost, in words.
    pub fn lost(&self) -> String {
        let d = &self.damage;
        let (chunks, messages, bytes) = (d.chunks, d.messages, d.bytes);
        let mut text = format!("{chunks} chunks, {messages} messages and {bytes} bytes skipped");
        if d.unfinished {
            text += "; the recording has no end";
        }
        for f in self.fingers.iter().filter(|f| f.missing > 0) {
            let (finger, missing, gaps) = (f.finger, f.missing, f.gaps);
            text += &format!("; finger {finger} lacks {missing} ticks in {gaps} gaps");
        }
        text
    }
}

/// What compressing a session came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Compressed {
    /// Size before, bytes.
    pub before: u64,
    /// Size after, bytes.
    pub after: u64,
}

/// Saves what can be read of `broken` into a new, finished, indexed session `out`.
///
/// Every message of a whole chunk is taken over as it is. If anything was skipped or is missing, the new file says so in itself:
/// by an event `recovered` at its last tick and by metadata `dorsum.recovered`. It is written beside and renamed when it is whole:
/// a kill leaves nothing half done. `watch` hears the share done, 0 to 1, and answers whether to go on.
///
/// # Errors
/// The header of `broken` cannot be read, `out` is there already ([`IfExists::Refuse`]) or is the broken file itself, the system
/// refuses to read or write, or [`SessionError::Stopped`].
pub fn recover(
    broken: &Path,
    out: &Path,
    options: &RecoverOptions,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<RecoverReport, SessionError> {
    let session = Session::open(broken)?;
    refuse_taken(broken, out, options.if_exists)?;
    let mut copy = Copy::begin(&session, out, options.compress)?;
    let mut tally = Tally::new(session.header().n_fingers());
    let mut entries = session.entries(Strictness::Lenient)?;
    let mut n = 0_u64;
    while let Some(entry) = entries.next() {
        let entry = entry?;
        tally.add(&entry);
        copy.put(&entries, &entry)?;
        n += 1;
        if n.is_multiple_of(4096) && !watch(entries.progress()) {
            return Err(SessionError::Stopped);
        }
    }
    let mut report = tally.report(broken, out, entries.damage().clone());
    if !report.is_whole() {
        copy.say_recovered(&report)?;
        report.events += 1;
    }
    let file = copy.finish()?;
    // What cannot be read in full is not handed out as saved.
    for entry in Session::open(file.path())?.entries(Strictness::Strict)? {
        entry?;
    }
    report.bytes = place(file, out, options.if_exists)?;
    watch(1.0);
    Ok(report)
}

/// Compresses the chunks of a finished session, in place: written beside, compared message by message, renamed. A kill at any
/// instant leaves one whole file of that name. A session that is compressed already stays as it is.
///
/// # Errors
/// The file is damaged or unfinished, the system refuses, or [`SessionError::Stopped`] when `watch` said so: then the file is
/// as it was.
pub fn compress(
    path: &Path,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Compressed, SessionError> {
    let session = Session::open(path)?;
    let before = session.bytes();
    let mut copy = Copy::begin(&session, path, true)?;
    let mut entries = session.entries(Strictness::Strict)?;
    let mut n = 0_u64;
    while let Some(entry) = entries.next() {
        let entry = entry?;
        if entries.is_packed() {
            return Ok(Compressed {
                before,
                after: before,
            });
        }
        copy.put(&entries, &entry)?;
        n += 1;
        if n.is_multiple_of(4096) && !watch(0.6 * entries.progress()) {
            return Err(SessionError::Stopped);
        }
    }
    let file = copy.finish()?;
    let written = Session::open(file.path())?;
    let mut old = session.entries(Strictness::Strict)?;
    let mut new = written.entries(Strictness::Strict)?;
    let mut same = written.header() == session.header();
    loop {
        match (old.next(), new.next()) {
            (None, None) => break,
            (Some(a), Some(b)) => {
                a?;
                b?;
                same &= old.message() == new.message();
            }
            _ => same = false,
        }
        if !same {
            return Err(SessionError::Recorder(format!(
                "{}: the compressed copy differs; the file stays as it is",
                path.display()
            )));
        }
        n -= n.min(1);
        if n.is_multiple_of(4096) && !watch(0.6 + 0.4 * new.progress()) {
            return Err(SessionError::Stopped);
        }
    }
    let after = place(file, path, IfExists::Replace)?;
    Ok(Compressed { before, after })
}

fn refuse_taken(broken: &Path, out: &Path, if_exists: IfExists) -> Result<(), SessionError> {
    let taken = |reason: &str| SessionError::Io {
        path: out.to_owned(),
        source: std::io::Error::new(std::io::ErrorKind::AlreadyExists, reason),
    };
    if if_exists == IfExists::Refuse && out.exists() {
        return Err(taken(
            "is already there; choose another name or replace it by force",
        ));
    }
    match (std::fs::canonicalize(broken), std::fs::canonicalize(out)) {
        (Ok(a), Ok(b)) if a == b => Err(taken("is the broken file itself; choose another name")),
        _ => Ok(()),
    }
}

/// Has the disk keep a file, gives it its name, and tells its size.
fn place(file: NamedTempFile, out: &Path, if_exists: IfExists) -> Result<u64, SessionError> {
    let io = |source| writer::io_error(out, source);
    file.as_file().sync_all().map_err(io)?;
    let bytes = file.as_file().metadata().map_err(io)?.len();
    let placed = match if_exists {
        IfExists::Refuse => file.persist_noclobber(out),
        IfExists::Replace => file.persist(out),
    };
    placed.map_err(|e| io(e.error))?;
    Ok(bytes)
}

/// A session that is being written from another.
struct Copy {
    mcap: Writer<BufWriter<File>>,
    file: NamedTempFile,
    out: PathBuf,
    newest: Newest,
}

/// What an event at the end of the copy refers to.
#[derive(Clone, Copy, Default)]
struct Newest {
    tick: u64,
    time_ns: u64,
    log_ns: u64,
}

impl Copy {
    fn begin(session: &Session, out: &Path, compress: bool) -> Result<Self, SessionError> {
        let header: &Header = session.header();
        let folder = out.parent().filter(|p| !p.as_os_str().is_empty());
        let file = tempfile::Builder::new()
            .prefix(".dorsum-")
            .suffix(".part")
            .tempfile_in(folder.unwrap_or(Path::new(".")))
            .map_err(|e| writer::io_error(out, e))?;
        let handle = file.reopen().map_err(|e| writer::io_error(out, e))?;
        let sink = BufWriter::with_capacity(1 << 20, handle);
        let compression = compress.then_some(Compression::Zstd);
        let extras = session.extras()?;
        let mcap = writer::begin(sink, header, &extras, compression)?;
        let mcap = mcap.map_err(|e| writer::failed(out, e))?;
        Ok(Self {
            mcap,
            file,
            out: out.to_owned(),
            newest: Newest {
                log_ns: header.started_ns()?,
                ..Newest::default()
            },
        })
    }

    fn put(&mut self, entries: &Records, entry: &Entry) -> Result<(), SessionError> {
        let Some(message) = entries.message() else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id: message.channel,
            sequence: message.sequence,
            log_time: message.log_ns,
            publish_time: message.publish_ns,
        };
        if let Entry::Tick(record) = entry {
            self.newest = Newest {
                tick: record.tick,
                time_ns: record.time_ns,
                log_ns: message.log_ns,
            };
        }
        let written = self.mcap.write_to_known_channel(&header, message.data);
        self.done(written)
    }

    fn say_recovered(&mut self, report: &RecoverReport) -> Result<(), SessionError> {
        let Newest {
            tick,
            time_ns,
            log_ns,
        } = self.newest;
        let event = format::encode_event(&format::Event {
            tick,
            time_ns,
            kind: format::RECOVERED.into(),
            text: report.lost(),
        });
        let header = MessageHeader {
            channel_id: format::EVENTS_CHANNEL,
            sequence: tick as u32,
            log_time: log_ns,
            publish_time: log_ns,
        };
        let written = self.mcap.write_to_known_channel(&header, &event);
        self.done(written)?;
        let d = &report.damage;
        let name = report.file.file_name().unwrap_or_default();
        let mut metadata = BTreeMap::from([
            ("file".to_owned(), name.to_string_lossy().into_owned()),
            ("recovered_utc".to_owned(), utc_now()),
            ("build".to_owned(), super::build_id()),
            ("chunks".to_owned(), d.chunks.to_string()),
            ("messages".to_owned(), d.messages.to_string()),
            ("bytes".to_owned(), d.bytes.to_string()),
            ("unfinished".to_owned(), d.unfinished.to_string()),
            ("first".to_owned(), d.first.clone()),
        ]);
        for f in &report.fingers {
            let key = |what: &str| format!("finger.{}.{what}", f.finger);
            metadata.insert(key("missing"), f.missing.to_string());
            metadata.insert(key("gaps"), f.gaps.to_string());
        }
        let written = self.mcap.write_metadata(&Metadata {
            name: format::RECOVERED_METADATA.into(),
            metadata,
        });
        self.done(written)
    }

    fn finish(mut self) -> Result<NamedTempFile, SessionError> {
        let finished = self.mcap.finish().map(drop);
        self.done(finished)?;
        let flushed = std::io::Write::flush(&mut self.mcap.into_inner());
        flushed.map_err(|e| writer::io_error(&self.out, e))?;
        Ok(self.file)
    }

    fn done(&self, outcome: Result<(), McapError>) -> Result<(), SessionError> {
        outcome.map_err(|e| writer::failed(&self.out, e))
    }
}

/// Counts what is there and what is missing.
struct Tally {
    fingers: Vec<FingerLoss>,
    last: Vec<Option<u64>>,
    /// Tick and kind of the newest event that explains a gap.
    restart: Option<u64>,
    lost: Option<u64>,
    span_ns: Option<(u64, u64)>,
    events: u64,
    edits: u64,
}

impl Tally {
    fn new(n_fingers: usize) -> Self {
        let finger = |i| FingerLoss {
            finger: i as u8,
            ..FingerLoss::default()
        };
        Self {
            fingers: (0..n_fingers).map(finger).collect(),
            last: vec![None; n_fingers],
            restart: None,
            lost: None,
            span_ns: None,
            events: 0,
            edits: 0,
        }
    }

    fn add(&mut self, entry: &Entry) {
        let record = match entry {
            Entry::Event(event) => {
                self.events += 1;
                match event.kind.as_str() {
                    "restart" => self.restart = Some(event.tick),
                    "lost" => self.lost = Some(event.tick),
                    _ => {}
                }
                return;
            }
            Entry::Edit(_) => {
                self.edits += 1;
                return;
            }
            Entry::Tick(record) => record,
        };
        let i = usize::from(record.finger);
        let (Some(finger), Some(last)) = (self.fingers.get_mut(i), self.last.get_mut(i)) else {
            return;
        };
        finger.records += 1;
        let due = last.map_or(record.tick, |t| t.saturating_add(1));
        let missing = record.tick.saturating_sub(due);
        if missing > 0 && self.restart != Some(record.tick) {
            if self.lost == Some(record.tick) {
                finger.lost_live += missing;
            } else {
                finger.gaps += 1;
                finger.missing += missing;
            }
        }
        *last = Some(record.tick);
        let (first, newest) = self.span_ns.unwrap_or((record.time_ns, 0));
        self.span_ns = Some((first.min(record.time_ns), newest.max(record.time_ns)));
    }

    fn report(self, broken: &Path, out: &Path, damage: Damage) -> RecoverReport {
        let (first, last) = self.span_ns.unwrap_or_default();
        RecoverReport {
            file: broken.to_owned(),
            out: out.to_owned(),
            bytes: 0,
            ticks: self.fingers.iter().map(|f| f.records).max().unwrap_or(0),
            seconds: crate::units::s_from_ns(last.saturating_sub(first)),
            events: self.events,
            edits: self.edits,
            fingers: self.fingers,
            damage,
        }
    }
}
