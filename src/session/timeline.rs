//! A session opened by its index: at once, whatever its length, and without holding its ticks in memory.

use super::SessionError;
use super::format::{self, Edit, Event};
use super::header::Header;
use super::index::Summary;
use super::playback::Source;
use super::reader::Session;
use super::records::{Damage, Entry, Kind, Strictness, wire_error};
use super::wire::{self, Messages, WireError};
use crate::servo::{FingerRecord, MAX_FINGERS, TickRecord};
use crate::units::s_from_ns;
use mcap::records::op;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Unpacked chunks kept: a second and a half of two fingers at 1 kHz, 2 MB.
const KEPT: usize = 8;

/// A session that shows any instant of itself.
///
/// A finished file is opened by the chunk index at its end, in milliseconds for an hour; one without (killed, damaged) is read
/// through once, leniently, and indexed the same. Events and edits are held; ticks are read when they are asked for, a chunk
/// at a time, and the newest few chunks are kept. Copies share all of it.
///
/// For the whole course of a session, such as the plots of its past, stream it: [`Timeline::session`] and
/// [`Session::entries`] with [`Strictness::Lenient`] give every record in order in bounded memory.
#[derive(Clone, Debug)]
pub struct Timeline(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    session: Session,
    channels: BTreeMap<u16, Kind>,
    stretches: Vec<Stretch>,
    events: Vec<Event>,
    edits: Vec<Edit>,
    damage: Damage,
    span_ns: (u64, u64),
    n_ticks: u64,
    cache: Mutex<Cache>,
}

/// A chunk that holds ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    /// Where its record starts, bytes from the start of the file.
    at: u64,
    /// Length of the record with its prefix, bytes.
    length: u64,
    /// No record in it is earlier, monotonic ns.
    start_ns: u64,
    /// Records of each finger in it.
    counts: [u64; MAX_FINGERS],
}

/// The records of a chunk, finger by finger.
#[derive(Debug, Default)]
struct Unpacked {
    fingers: [Vec<FingerRecord>; MAX_FINGERS],
    events: Vec<Event>,
    edits: Vec<Edit>,
    /// Monotonic time behind log time of the first tick, ns.
    clock: Option<(u64, u64)>,
    /// Messages that could not be read.
    broken: u64,
}

#[derive(Debug)]
struct Cache {
    file: File,
    /// Newest last.
    kept: VecDeque<(usize, Arc<Unpacked>)>,
    /// Stretches that turned out to be damaged.
    bad: Vec<bool>,
    /// The last instant that could be had.
    shown: TickRecord,
}

impl Timeline {
    /// Opens a session.
    ///
    /// # Errors
    /// As [`Session::open`]; a file without a summary that can be used is read through, which the system may refuse.
    pub fn open(path: &Path) -> Result<Self, SessionError> {
        Self::open_watched(path, &mut |_| true)
    }

    /// As [`Self::open`]; where the file is read through, `watch` hears the share done, 0 to 1, and answers whether to go on.
    ///
    /// # Errors
    /// As [`Self::open`], and [`SessionError::Stopped`] when `watch` said so.
    pub fn open_watched(
        path: &Path,
        watch: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Self, SessionError> {
        let session = Session::open(path)?;
        let open = || {
            let mut file = File::open(path)?;
            let summary = Summary::read(&mut file)?;
            Ok((file, summary))
        };
        let (file, summary) = open().map_err(|e| wire_error(path, WireError::Io(e)))?;
        let mut inner = Inner {
            cache: Mutex::new(Cache {
                file,
                kept: VecDeque::new(),
                bad: Vec::new(),
                shown: TickRecord::default(),
            }),
            session,
            channels: Kind::by_channel(),
            stretches: Vec::new(),
            events: Vec::new(),
            edits: Vec::new(),
            damage: Damage::default(),
            span_ns: (0, 0),
            n_ticks: 0,
        };
        let indexed = match summary {
            Some(summary) => inner.take_index(summary)?,
            None => false,
        };
        if !indexed {
            inner.scan(watch)?;
        }
        inner.measure()?;
        Ok(Self(Arc::new(inner)))
    }

    /// The session that it is of: its file, and all its records in order.
    pub fn session(&self) -> &Session {
        &self.0.session
    }

    /// What the run was.
    pub fn header(&self) -> &Header {
        self.0.session.header()
    }

    /// Monotonic times of the first and the last tick, ns; both 0 where there is none.
    pub fn span_ns(&self) -> (u64, u64) {
        self.0.span_ns
    }

    /// Time from the first to the last tick, s.
    pub fn duration_s(&self) -> f64 {
        s_from_ns(self.0.span_ns.1 - self.0.span_ns.0)
    }

    /// Ticks: of the finger that has most. Those of damaged chunks are among them where the file has its index.
    pub fn n_ticks(&self) -> u64 {
        self.0.n_ticks
    }

    /// Every event in the order written.
    pub fn events(&self) -> &[Event] {
        &self.0.events
    }

    /// Every edit of the scene in the order written.
    pub fn edits(&self) -> &[Edit] {
        &self.0.edits
    }

    /// What opening stepped over. In a finished file only the chunks with events are looked at: damage of others shows when
    /// they are read through.
    pub fn damage(&self) -> &Damage {
        &self.0.damage
    }

    /// The scenario after edit `number`; `None` where its text is not in the file.
    pub fn scenario_after(&self, number: u32) -> Option<&str> {
        self.header().scenario_after(number, &self.0.edits)
    }

    /// Every finger at an instant of the monotonic clock: its newest record then, or its first one before that. Fingers
    /// without any record are default. What is in damaged chunks is not there; where the system refuses to read, the last
    /// instant that could be had stands.
    pub fn at_ns(&self, time_ns: u64) -> TickRecord {
        let inner = &*self.0;
        let mut cache = inner.cache();
        let mut view = TickRecord {
            n_fingers: self.header().n_fingers().min(MAX_FINGERS),
            ..TickRecord::default()
        };
        for finger in 0..view.n_fingers {
            match inner.newest(&mut cache, finger, time_ns) {
                Ok(found) => view.fingers[finger] = found.unwrap_or_default(),
                Err(_) => return cache.shown,
            }
        }
        cache.shown = view;
        view
    }

    /// Time of the tick of finger 0 that is `ticks` recorded ticks behind (or, negative, before) the newest one at `time_ns`;
    /// of the first or last where there are not so many. `None` without any, or where the system refuses to read. Damaged chunks
    /// in between that were never looked at count with the ticks they had.
    pub fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64> {
        let inner = &*self.0;
        let mut cache = inner.cache();
        loop {
            // Each time round without an answer a damaged chunk more is known.
            let known = cache.bad.iter().filter(|bad| **bad).count();
            let found = inner.stepped(&mut cache, time_ns, ticks).ok()?;
            if found.is_some() || cache.bad.iter().filter(|bad| **bad).count() == known {
                return found;
            }
        }
    }
}

impl Source for Timeline {
    fn header(&self) -> &Header {
        Timeline::header(self)
    }

    fn span_ns(&self) -> (u64, u64) {
        Timeline::span_ns(self)
    }

    fn events(&self) -> &[Event] {
        Timeline::events(self)
    }

    fn at_ns(&self, time_ns: u64) -> TickRecord {
        Timeline::at_ns(self, time_ns)
    }

    fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64> {
        Timeline::step_ns(self, time_ns, ticks)
    }
}

impl Inner {
    fn cache(&self) -> MutexGuard<'_, Cache> {
        self.cache.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn io(&self, error: std::io::Error) -> SessionError {
        wire_error(self.session.path(), WireError::Io(error))
    }

    /// Takes over what the summary tells; `false` where it is of no use.
    fn take_index(&mut self, summary: Summary) -> Result<bool, SessionError> {
        let n_fingers = self.session.header().n_fingers();
        for (id, topic) in &summary.channels {
            self.channels.insert(*id, Kind::of(topic, n_fingers));
        }
        let mut others = Vec::new();
        for chunk in &summary.chunks {
            let mut stretch = Stretch {
                at: chunk.at,
                length: chunk.length,
                start_ns: chunk.start_ns,
                counts: [0; MAX_FINGERS],
            };
            let mut other = false;
            for (channel, count) in &chunk.counts {
                match self.channels.get(channel) {
                    Some(Kind::Finger(f)) => stretch.counts[usize::from(*f)] += count,
                    Some(Kind::Events | Kind::Edits) => other = true,
                    Some(Kind::Foreign) | None => {}
                }
            }
            if stretch.counts.iter().any(|n| *n > 0) {
                self.stretches.push(stretch);
            }
            if other {
                others.push(stretch);
            }
        }
        let clock = self.clock()?;
        if clock.is_none() && !self.stretches.is_empty() {
            self.stretches.clear();
            return Ok(false);
        }
        let (log_ns, time_ns) = clock.unwrap_or_default();
        let mut latest = 0;
        for stretch in &mut self.stretches {
            let since = stretch.start_ns.saturating_sub(log_ns);
            latest = time_ns.saturating_add(since).max(latest);
            stretch.start_ns = latest;
        }
        // A finger's first record may be earlier than the one that the clock was read at.
        if let Some(first) = self.stretches.first_mut() {
            first.start_ns = 0;
        }
        for stretch in others {
            let unpacked = self.unpack(&mut self.cache().file, &stretch, true);
            match unpacked {
                Ok(mut found) => {
                    self.events.append(&mut found.events);
                    self.edits.append(&mut found.edits);
                    self.damage.messages += found.broken;
                }
                Err(WireError::Io(e)) => return Err(self.io(e)),
                Err(WireError::Damaged(at, what)) => {
                    self.damage.chunks += 1;
                    if self.damage.first.is_empty() {
                        self.damage.first = format!("byte {at}: {what}");
                    }
                }
            }
        }
        Ok(true)
    }

    /// What monotonic time belongs to what log time, both ns: by the first tick that can be read.
    fn clock(&self) -> Result<Option<(u64, u64)>, SessionError> {
        for stretch in &self.stretches {
            match self.unpack(&mut self.cache().file, stretch, false) {
                Ok(found) if found.clock.is_some() => return Ok(found.clock),
                Err(WireError::Io(e)) => return Err(self.io(e)),
                Ok(_) | Err(WireError::Damaged(..)) => {}
            }
        }
        Ok(None)
    }

    /// Reads all through, leniently, and notes where what is.
    fn scan(&mut self, watch: &mut dyn FnMut(f64) -> bool) -> Result<(), SessionError> {
        let mut records = self.session.entries(Strictness::Lenient)?;
        while let Some(entry) = records.next() {
            let (at, length) = records.chunk();
            match entry? {
                Entry::Tick(record) => {
                    if self.stretches.last().is_none_or(|s| s.at != at) {
                        if !watch(records.progress()) {
                            return Err(SessionError::Stopped);
                        }
                        let latest = self.stretches.last().map_or(0, |s| s.start_ns);
                        self.stretches.push(Stretch {
                            at,
                            length,
                            start_ns: record.time_ns.max(latest),
                            counts: [0; MAX_FINGERS],
                        });
                    }
                    if let Some(stretch) = self.stretches.last_mut() {
                        stretch.counts[usize::from(record.finger)] += 1;
                    }
                }
                Entry::Event(event) => self.events.push(event),
                Entry::Edit(edit) => self.edits.push(edit),
            }
        }
        self.channels = records.channels().clone();
        self.damage = records.damage().clone();
        Ok(())
    }

    /// Finds span and number of ticks.
    fn measure(&mut self) -> Result<(), SessionError> {
        self.cache().bad = vec![false; self.stretches.len()];
        let n_fingers = self.session.header().n_fingers();
        let (mut first, mut last) = (None::<u64>, 0);
        for finger in 0..n_fingers {
            let mut cache = self.cache();
            let earliest = self.first(&mut cache, finger);
            let newest = self.newest(&mut cache, finger, u64::MAX);
            drop(cache);
            let time = |r: Result<Option<FingerRecord>, std::io::Error>| {
                r.map(|r| r.map(|r| r.time_ns)).map_err(|e| self.io(e))
            };
            first = time(earliest)?.into_iter().chain(first).min();
            last = time(newest)?.unwrap_or(0).max(last);
        }
        let first = first.unwrap_or(0);
        self.span_ns = (first, last.max(first));
        let of = |finger: usize| self.stretches.iter().map(|s| s.counts[finger]).sum();
        self.n_ticks = (0..n_fingers).map(of).max().unwrap_or(0);
        Ok(())
    }

    /// The newest record of a finger at an instant, or its first one.
    fn newest(
        &self,
        cache: &mut Cache,
        finger: usize,
        time_ns: u64,
    ) -> Result<Option<FingerRecord>, std::io::Error> {
        let behind = self.stretches.partition_point(|s| s.start_ns <= time_ns);
        for i in (0..behind).rev() {
            if let Some(found) = self.unpacked(cache, i, finger)? {
                let records = &found.fingers[finger];
                let n = records.partition_point(|r| r.time_ns <= time_ns);
                if n > 0 {
                    return Ok(records.get(n - 1).copied());
                }
            }
        }
        self.first(cache, finger)
    }

    fn first(
        &self,
        cache: &mut Cache,
        finger: usize,
    ) -> Result<Option<FingerRecord>, std::io::Error> {
        for i in 0..self.stretches.len() {
            let found = self.unpacked(cache, i, finger)?;
            if let Some(first) = found.and_then(|u| u.fingers[finger].first().copied()) {
                return Ok(Some(first));
            }
        }
        Ok(None)
    }

    /// As [`Timeline::step_ns`]; `None` also where a chunk on the way turned out to be damaged.
    fn stepped(
        &self,
        cache: &mut Cache,
        time_ns: u64,
        ticks: i64,
    ) -> Result<Option<u64>, std::io::Error> {
        let Some(present) = self.newest(cache, 0, time_ns)? else {
            return Ok(None);
        };
        // Ticks of finger 0 before each stretch, damaged ones left out.
        let mut total = 0;
        let mut before = Vec::with_capacity(self.stretches.len());
        for (stretch, bad) in self.stretches.iter().zip(&cache.bad) {
            before.push(total);
            total += if *bad { 0 } else { stretch.counts[0] };
        }
        let behind = self.stretches.partition_point(|s| s.start_ns <= time_ns);
        let mut place = None;
        for i in (0..behind.max(1)).rev() {
            if let Some(found) = self.unpacked(cache, i, 0)? {
                let at = found.fingers[0].iter().position(|r| r.tick == present.tick);
                if let Some(at) = at {
                    place = Some(before[i].saturating_add(at as u64));
                    break;
                }
            }
        }
        // A time before the first tick stands before it.
        let early = present.time_ns > time_ns;
        let place = place.unwrap_or(0) as i64 - i64::from(early);
        let last = i64::try_from(total).unwrap_or(i64::MAX) - 1;
        let target = place.saturating_add(ticks).clamp(0, last.max(0)) as u64;
        let i = before.partition_point(|n| *n <= target);
        // Of stretches without ticks of the finger, all begin at the same number: the last of them has it.
        let Some(i) = i.checked_sub(1) else {
            return Ok(None);
        };
        let found = self.unpacked(cache, i, 0)?;
        let record = found.and_then(|u| u.fingers[0].get((target - before[i]) as usize).copied());
        Ok(record.map(|r| r.time_ns))
    }

    /// The records of a stretch; `None` where it has none of the finger or is damaged.
    fn unpacked(
        &self,
        cache: &mut Cache,
        i: usize,
        finger: usize,
    ) -> Result<Option<Arc<Unpacked>>, std::io::Error> {
        let stretch = &self.stretches[i];
        if stretch.counts[finger] == 0 || cache.bad[i] {
            return Ok(None);
        }
        if let Some(at) = cache.kept.iter().position(|(n, _)| *n == i)
            && let Some((n, found)) = cache.kept.remove(at)
        {
            cache.kept.push_back((n, Arc::clone(&found)));
            return Ok(Some(found));
        }
        match self.unpack(&mut cache.file, stretch, false) {
            Ok(found) => {
                let found = Arc::new(found);
                cache.kept.push_back((i, Arc::clone(&found)));
                if cache.kept.len() > KEPT {
                    cache.kept.pop_front();
                }
                Ok(Some(found))
            }
            Err(WireError::Io(e)) => Err(e),
            Err(WireError::Damaged(..)) => {
                cache.bad[i] = true;
                Ok(None)
            }
        }
    }

    /// Reads a chunk: its ticks, or all but them.
    fn unpack(
        &self,
        file: &mut File,
        stretch: &Stretch,
        others: bool,
    ) -> Result<Unpacked, WireError> {
        let damaged = |what: String| WireError::Damaged(stretch.at, what);
        let mut file = BufReader::with_capacity(0, file);
        let (opcode, mut record) = wire::record_at(&mut file, stretch.at)?;
        if opcode != op::CHUNK || (wire::PREFIX + record.len()) as u64 != stretch.length {
            return Err(damaged("not the chunk that the index names".into()));
        }
        let mut at = match wire::chunk_messages(&record).map_err(damaged)? {
            Messages::Plain(start) => start,
            Messages::Unpacked(messages) => {
                record = messages;
                0
            }
        };
        let mut found = Unpacked::default();
        while at < record.len() {
            let Ok((opcode, range)) = wire::record_in_chunk(&record, at) else {
                found.broken += 1;
                break;
            };
            at = range.end;
            if opcode == op::MESSAGE && self.take(&record[range], others, &mut found).is_err() {
                found.broken += 1;
            }
        }
        Ok(found)
    }

    fn take(&self, record: &[u8], others: bool, found: &mut Unpacked) -> Result<(), String> {
        let (id, log_ns, data) = wire::message(record)?;
        match self.channels.get(&id) {
            Some(Kind::Finger(finger)) if !others => {
                let record = format::decode_tick(data)?;
                let of_finger = &mut found.fingers[usize::from(*finger)];
                let follows = of_finger.last().is_none_or(|r| r.tick < record.tick);
                if record.finger != *finger || !follows {
                    return Err(format!("tick {} is out of order", record.tick));
                }
                found.clock.get_or_insert((log_ns, record.time_ns));
                of_finger.push(record);
            }
            Some(Kind::Events) if others => found.events.push(format::decode_event(data)?),
            Some(Kind::Edits) if others => found.edits.push(format::decode_edit(data)?),
            _ => {}
        }
        Ok(())
    }
}
