//! A session file: what it says of itself, found also where the file was killed or damaged.

use super::SessionError;
use super::extras::{Extras, Folder};
use super::format;
use super::header::Header;
use super::index::Summary;
use super::recording::Recording;
use super::records::{Entry, Records, Strictness, Ticks, walk, wire_error};
use super::wire::{self, Walk, WireError};
use mcap::records::op;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

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
        Records::open(&self.path, self.header.n_fingers(), strictness)
    }

    /// Every whole tick in order; events are left out. Memory does not grow with the length of the session.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn ticks(&self, strictness: Strictness) -> Result<Ticks, SessionError> {
        let records = self.entries(strictness)?;
        Ok(Ticks::of(records, self.header.n_fingers()))
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
            damage: entries.damage().clone(),
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
