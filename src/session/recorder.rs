//! The recorder: a thread that owns the servo's ring for its whole life and writes it to a file when asked.

use super::SessionError;
use super::extras::Extras;
use super::faults::Faults;
use super::header::Header;
use super::writer::{IfExists, RecordingSummary, SessionWriter, Store, created};
use crate::servo::{FingerRecord, Running};
use rtrb::Consumer;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// The ring is emptied this often. It holds seconds of ticks; this is short so that plots are fluid.
const PERIOD: Duration = Duration::from_millis(8);
/// Records handed on at once.
const BATCH: usize = 1024;
/// Orders that wait while the disk is slow.
const ORDERS: usize = 16;
/// Edits that wait while the disk is slow.
const EDITS: usize = 64;
/// How long [`RecorderHandle::start`] and [`RecorderHandle::stop`] wait for a slow disk.
const PATIENCE: Duration = Duration::from_secs(10);

/// Sees every record in order, whether it is written or not: the history of the plots. Runs on the recorder's thread; must
/// not block.
pub type Tap = Box<dyn FnMut(&[FingerRecord]) + Send>;

/// What the recorder does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum RecorderState {
    /// Empties the ring; nothing is written.
    #[default]
    Idle,
    /// Writes.
    Recording {
        /// The file.
        path: PathBuf,
    },
    /// Could not go on writing. Stays so until the next start; what was written before is readable.
    Failed {
        /// Why.
        reason: String,
    },
}

/// The recorder at a glance.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecorderStatus {
    /// What it does.
    pub state: RecorderState,
    /// Ticks written.
    pub ticks: u64,
    /// Bytes handed to the system.
    pub bytes: u64,
    /// Time from the first to the last tick written, s.
    pub seconds: f64,
    /// Records that were lost because the ring was full.
    pub lost: u64,
    /// Memory that the recording holds, bytes; 0 while nothing is recorded.
    pub held_bytes: usize,
}

enum Order {
    Start(
        PathBuf,
        Box<Header>,
        Target,
        SyncSender<Result<(), SessionError>>,
    ),
    Stop(SyncSender<Result<RecordingSummary, SessionError>>),
    Reveal(Box<Header>, SyncSender<Result<(), SessionError>>),
    Hold(bool, SyncSender<()>),
    Mark(String, String),
    Swap(Consumer<FingerRecord>),
    Carry(Box<Extras>),
    Quit,
}

/// Writes to a file, or to whatever stands in for one.
type Writer = SessionWriter<Box<dyn Store>>;

/// What a recording is to be written to.
enum Target {
    File(IfExists),
    Store(Box<dyn Store>),
}

/// Number of an edit and the scenario as edited.
type EditText = (u32, Arc<str>);

/// The recorder's thread.
pub struct RecorderThread {
    records: Consumer<FingerRecord>,
    tap: Option<Tap>,
    orders: Receiver<Order>,
    edits: Receiver<EditText>,
    /// Edits that ticks to come may feel.
    known: VecDeque<EditText>,
    status: Arc<Mutex<RecorderStatus>>,
    writer: Option<Writer>,
    /// A signal lets the file be closed.
    running: Option<Running>,
    /// What every recording begun carries.
    extras: Extras,
    faults: Faults,
    /// What is felt now does not belong into the file.
    held: bool,
    batch: Vec<FingerRecord>,
}

impl RecorderThread {
    /// Memory that the thread holds for what it takes from the ring at a time, bytes, whether it records or not.
    pub const BYTES: usize = BATCH * size_of::<FingerRecord>();

    /// Starts the thread on the servo's ring.
    ///
    /// # Errors
    /// The system refuses another thread.
    pub fn spawn(
        records: Consumer<FingerRecord>,
        tap: Option<Tap>,
    ) -> std::io::Result<RecorderHandle> {
        let (sender, orders) = sync_channel(ORDERS);
        let (edit_sender, edits) = sync_channel(EDITS);
        let status = Arc::new(Mutex::new(RecorderStatus::default()));
        let recorder = Self {
            records,
            tap,
            orders,
            edits,
            known: VecDeque::new(),
            status: Arc::clone(&status),
            writer: None,
            running: None,
            extras: Extras::of_this_machine(),
            faults: Faults::default(),
            held: false,
            batch: vec![FingerRecord::default(); BATCH],
        };
        let name = Builder::new().name("recorder".into());
        let thread = name.spawn(move || recorder.run())?;
        Ok(RecorderHandle {
            orders: sender,
            edits: edit_sender,
            status,
            thread: Some(thread),
        })
    }

    fn run(mut self) {
        loop {
            let order = self.orders.recv_timeout(PERIOD);
            // Whatever is ordered holds for what comes after the records already there.
            self.drain();
            match order {
                Ok(Order::Start(path, header, target, reply)) => {
                    let _ = reply.send(self.start(&path, &header, target));
                }
                Ok(Order::Stop(reply)) => {
                    let _ = reply.send(self.stop());
                }
                Ok(Order::Reveal(header, reply)) => {
                    let _ = reply.send(self.reveal(&header));
                }
                Ok(Order::Hold(hold, reply)) => {
                    self.hold(hold);
                    let _ = reply.send(());
                }
                Ok(Order::Mark(kind, text)) => self.write(|w| w.event(&kind, &text)),
                Ok(Order::Carry(extras)) => self.extras = *extras,
                Ok(Order::Swap(records)) => {
                    self.records = records;
                    if let Some(writer) = &mut self.writer {
                        writer.restarted();
                    }
                }
                Ok(Order::Quit) | Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
        if self.writer.is_some() {
            let _ = self.stop();
        }
    }

    /// Empties the ring, at most what it holds now, so that orders are heard even when the servo outruns the disk.
    fn drain(&mut self) {
        let mut left = self.records.slots();
        self.take_edits();
        while left > 0 {
            let n = left.min(BATCH);
            let Ok(chunk) = self.records.read_chunk(n) else {
                break;
            };
            for (slot, record) in self.batch.iter_mut().zip(chunk) {
                *slot = record;
            }
            left -= n;
            if let Some(tap) = &mut self.tap {
                tap(&self.batch[..n]);
            }
            let batch = std::mem::take(&mut self.batch);
            if !self.held {
                let mut faults = std::mem::take(&mut self.faults);
                self.write(|w| {
                    batch[..n].iter().try_for_each(|r| {
                        w.write(r)?;
                        faults.seen(r, |kind, text| w.event(kind, text))
                    })
                });
                self.faults = faults;
            }
            if let Some(newest) = batch[..n].last() {
                self.forget_edits_before(newest);
            }
            self.batch = batch;
        }
        self.write(|w| w.tend(Instant::now()));
        if let Some(writer) = &self.writer {
            report(&self.status, &writer.summary());
            locked(&self.status).held_bytes = writer.held_bytes();
        }
    }

    /// Takes in and writes the edits that were told. Each is told before it is handed to the servo: called after looking how
    /// much the ring holds, this has the text of every edit in there.
    fn take_edits(&mut self) {
        while let Ok((number, scenario_toml)) = self.edits.try_recv() {
            self.write(|w| w.edit(number, &scenario_toml));
            self.known.push_back((number, scenario_toml));
        }
    }

    /// Keeps the edit that was felt last, and the one before while both are felt: a file begun now needs no earlier one.
    fn forget_edits_before(&mut self, newest: &FingerRecord) {
        let felt_before = u32::from(newest.fade < 1.0);
        let oldest = newest.edit.saturating_sub(felt_before);
        while self.known.front().is_some_and(|(n, _)| *n < oldest) {
            self.known.pop_front();
        }
    }

    /// Writes if recording; a failure ends it.
    fn write(&mut self, act: impl FnOnce(&mut Writer) -> Result<(), SessionError>) {
        let Some(writer) = &mut self.writer else {
            return;
        };
        if let Err(e) = act(writer) {
            self.writer = None;
            self.running = None;
            let mut status = locked(&self.status);
            status.held_bytes = 0;
            status.state = RecorderState::Failed {
                reason: e.to_string(),
            };
        }
    }

    fn start(&mut self, path: &Path, header: &Header, target: Target) -> Result<(), SessionError> {
        if self.writer.is_some() {
            return Err(SessionError::Recorder(
                "is recording already; stop it first".into(),
            ));
        }
        header.to_map()?;
        let store = match target {
            Target::File(if_exists) => Box::new(created(path, if_exists)?),
            Target::Store(store) => store,
        };
        let mut writer = SessionWriter::with_extras(store, path, header, &self.extras)?;
        self.faults = Faults::default();
        for (number, scenario_toml) in &self.known {
            if *number > header.edit {
                writer.edit(*number, scenario_toml)?;
            }
        }
        self.writer = Some(writer);
        self.running = Some(Running::new());
        self.held = false;
        *locked(&self.status) = RecorderStatus {
            state: RecorderState::Recording {
                path: path.to_owned(),
            },
            ..RecorderStatus::default()
        };
        Ok(())
    }

    fn hold(&mut self, hold: bool) {
        if self.held
            && !hold
            && let Some(writer) = &mut self.writer
        {
            writer.restarted();
        }
        self.held = hold;
    }

    fn reveal(&mut self, header: &Header) -> Result<(), SessionError> {
        let Some(writer) = &mut self.writer else {
            return Err(SessionError::Recorder("is not recording".into()));
        };
        writer.reveal(header)
    }

    fn stop(&mut self) -> Result<RecordingSummary, SessionError> {
        let Some(writer) = self.writer.take() else {
            let reason = match &locked(&self.status).state {
                RecorderState::Failed { reason } => reason.clone(),
                _ => "is not recording".into(),
            };
            return Err(SessionError::Recorder(reason));
        };
        let outcome = writer.finish();
        self.running = None;
        locked(&self.status).held_bytes = 0;
        match &outcome {
            Ok(summary) => {
                report(&self.status, summary);
                locked(&self.status).state = RecorderState::Idle;
            }
            Err(e) => {
                locked(&self.status).state = RecorderState::Failed {
                    reason: e.to_string(),
                };
            }
        }
        outcome
    }
}

fn report(status: &Mutex<RecorderStatus>, summary: &RecordingSummary) {
    let mut status = locked(status);
    status.ticks = summary.ticks;
    status.bytes = summary.bytes;
    status.seconds = summary.seconds;
    status.lost = summary.lost;
}

/// Held for a few assignments only, never over a file operation.
fn locked(status: &Mutex<RecorderStatus>) -> MutexGuard<'_, RecorderStatus> {
    status.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The outside end of the recorder. Dropping it finishes a running recording and joins the thread.
pub struct RecorderHandle {
    orders: SyncSender<Order>,
    edits: SyncSender<EditText>,
    status: Arc<Mutex<RecorderStatus>>,
    thread: Option<JoinHandle<()>>,
}

impl RecorderHandle {
    /// Creates the file and writes every tick from now on to it, from the next whole one. An existing file is refused.
    ///
    /// # Errors
    /// The file cannot be created, the header is not writable, a recording runs already, or the disk does not answer within
    /// ten seconds.
    pub fn start(&self, path: &Path, header: Header) -> Result<(), SessionError> {
        self.start_as(path, header, Target::File(IfExists::Refuse))
    }

    /// As [`Self::start`], but replaces an existing file: only after someone has said so.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_replacing(&self, path: &Path, header: Header) -> Result<(), SessionError> {
        self.start_as(path, header, Target::File(IfExists::Replace))
    }

    /// As [`Self::start`], but onto `store`, such as one that is slow or full on purpose; `path` names it.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_on(
        &self,
        store: Box<dyn Store>,
        path: &Path,
        header: Header,
    ) -> Result<(), SessionError> {
        self.start_as(path, header, Target::Store(store))
    }

    fn start_as(&self, path: &Path, header: Header, target: Target) -> Result<(), SessionError> {
        let (reply, answer) = sync_channel(1);
        self.order(Order::Start(
            path.to_owned(),
            Box::new(header),
            target,
            reply,
        ))?;
        wait(&answer)?
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// Nothing is recorded, writing failed now or before, or the disk does not answer within ten seconds.
    pub fn stop(&self) -> Result<RecordingSummary, SessionError> {
        let (reply, answer) = sync_channel(1);
        self.order(Order::Stop(reply))?;
        wait(&answer)?
    }

    /// Says in which scene the sealed session was felt that is being recorded; nothing felt later is to be recorded with it.
    ///
    /// # Errors
    /// Nothing is recorded, the header is not writable, writing failed, or the disk does not answer within ten seconds.
    pub fn reveal(&self, header: Header) -> Result<(), SessionError> {
        let (reply, answer) = sync_channel(1);
        self.order(Order::Reveal(Box::new(header), reply))?;
        wait(&answer)?
    }

    /// Leaves out of the file what is felt from now on, until told otherwise; it goes on behind a gap. For a while in which
    /// another scene is felt.
    ///
    /// # Errors
    /// The recorder does not answer within ten seconds.
    pub fn hold(&self, hold: bool) -> Result<(), SessionError> {
        let (reply, answer) = sync_channel(1);
        self.order(Order::Hold(hold, reply))?;
        wait(&answer)
    }

    /// What every recording begun from now on carries, such as its mesh; before it is told, the facts of this machine.
    pub fn carry(&self, extras: Extras) {
        // A recorder that has ended records nothing.
        let _ = self.order(Order::Carry(Box::new(extras)));
    }

    /// Writes an event at the newest tick; nothing happens when nothing is recorded. Never waits: `false` when the disk is
    /// so slow that the mark could not be taken.
    #[must_use]
    pub fn mark(&self, kind: &str, text: &str) -> bool {
        let order = Order::Mark(kind.to_owned(), text.to_owned());
        self.orders.try_send(order).is_ok()
    }

    /// Tells of an edit of the scene: to be called before the edit is handed to the servo. Its text is written, if recording,
    /// before the first tick that feels it. Never waits: `false` when the disk is so slow that the edit could not be taken; then
    /// it is not to be handed over yet.
    ///
    /// The header of a recording begun later may name this edit, or the one before while this one is not wholly felt.
    #[must_use]
    pub fn edit(&self, number: u32, scenario_toml: Arc<str>) -> bool {
        // A recorder that has ended has nothing to write it to.
        !matches!(
            self.edits.try_send((number, scenario_toml)),
            Err(TrySendError::Full(_))
        )
    }

    /// Goes over to the ring of a servo that was started anew, once the old one is empty. A running recording goes on with
    /// an event and a gap in its tick numbers.
    ///
    /// # Errors
    /// The recorder does not answer within ten seconds.
    pub fn swap_records(&self, records: Consumer<FingerRecord>) -> Result<(), SessionError> {
        self.order(Order::Swap(records))
    }

    /// The recorder at a glance. Never waits for the disk.
    pub fn status(&self) -> RecorderStatus {
        let mut status = locked(&self.status).clone();
        if self.thread.as_ref().is_none_or(JoinHandle::is_finished) {
            status.state = RecorderState::Failed {
                reason: "its thread has ended".into(),
            };
        }
        status
    }

    fn order(&self, mut order: Order) -> Result<(), SessionError> {
        let until = Instant::now() + PATIENCE;
        loop {
            order = match self.orders.try_send(order) {
                Ok(()) => return Ok(()),
                Err(TrySendError::Full(order)) if Instant::now() < until => order,
                Err(TrySendError::Full(_)) => return Err(silent()),
                Err(TrySendError::Disconnected(_)) => return Err(gone()),
            };
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for RecorderHandle {
    fn drop(&mut self) {
        let _ = self.order(Order::Quit);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn wait<T>(answer: &Receiver<T>) -> Result<T, SessionError> {
    answer.recv_timeout(PATIENCE).map_err(|e| match e {
        RecvTimeoutError::Timeout => silent(),
        RecvTimeoutError::Disconnected => gone(),
    })
}

fn silent() -> SessionError {
    let s = PATIENCE.as_secs();
    SessionError::Recorder(format!("no answer within {s} s; is the disk very slow?"))
}

fn gone() -> SessionError {
    SessionError::Recorder("its thread has ended".into())
}
