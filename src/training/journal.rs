//! The journal of an exercise: a line of JSON for each settled trial, on the disk before anything else happens.
//!
//! | line | holds |
//! |---|---|
//! | first | [`Header`]: which exercise, without anything that tells what its trials hide |
//! | others | a settled trial ([`TrialRecord`]), or how the exercise ended |
//!
//! Lines are only ever added, each in one piece and synced. Whoever ends the program at any byte loses the running trial and
//! nothing else: a line that is not whole is the last one, and is cut off when the exercise goes on. What the running trial
//! hides is not written, nor what it is drawn from, unless the user stated the seed.

use super::trial::TrialRecord;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Name of the file inside its folder.
pub const FILE: &str = "journal.jsonl";
/// Version of the format.
pub const FORMAT: u32 = 1;

/// What a journal says before its first trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Version of the format.
    pub format: u32,
    /// Version of the program.
    pub program: String,
    /// The scenario as the user named it.
    pub scenario: String,
    /// The scenario without what is hidden, whole.
    pub blind_toml: String,
    /// What the user changed of its exercise.
    pub changes: Changes,
    /// Who trains, by a pseudonym.
    pub participant: Option<String>,
    /// Where chance starts, if the user stated it.
    pub seed: Option<u64>,
    /// The simulated observer, if one trains.
    pub observer: Option<String>,
    /// When it began, UTC, ISO 8601.
    pub started_utc: String,
}

/// What a user changes of an exercise as the scenario states it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Changes {
    /// Another number of trials.
    pub trials: Option<u32>,
    /// Another rule of the staircase, by its key.
    pub staircase: Option<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Line {
    Exercise(Box<Header>),
    Trial(Box<TrialRecord>),
    Ended(String),
}

/// Why a journal cannot be written or read: one line.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The file system said so.
    #[error("{}: {error}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What it said.
        error: io::Error,
    },
    /// There is one already.
    #[error("{} is already there; go on with --resume, or choose another folder", .0.display())]
    Exists(PathBuf),
    /// Another program writes it.
    #[error("{} is in use by another program", .0.display())]
    InUse(PathBuf),
    /// It is no journal, or damaged where it matters.
    #[error("{}: line {line}: {what}", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// Which line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// A write failed before; nothing more is written after it.
    #[error("{}: an earlier write failed; resume the exercise once the cause is mended", .0.display())]
    Broken(PathBuf),
}

/// What was cut off the end of a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CutOff {
    /// Which line it was, from 1.
    pub line: usize,
    /// How many bytes.
    pub bytes: usize,
}

impl std::fmt::Display for CutOff {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (line, bytes) = (self.line, self.bytes);
        write!(
            f,
            "line {line} was not whole: {bytes} bytes were cut off, no settled trial among them"
        )
    }
}

/// A journal as read.
#[derive(Clone, Debug, PartialEq)]
pub struct Read {
    /// Which exercise.
    pub header: Header,
    /// Settled trials in order.
    pub trials: Vec<TrialRecord>,
    /// How it ended; absent while it may go on.
    pub ended: Option<String>,
    /// What of its end is not whole.
    pub cut_off: Option<CutOff>,
    /// Bytes that are whole.
    pub(super) whole_bytes: usize,
}

/// Reads the journal in `folder`.
///
/// # Errors
/// It is not there, is no journal, or is damaged before its last line.
pub fn read(folder: &Path) -> Result<Read, JournalError> {
    let path = folder.join(FILE);
    let bytes = std::fs::read(&path).map_err(|error| JournalError::Io {
        path: path.clone(),
        error,
    })?;
    parse(&bytes).map_err(|(line, what)| JournalError::Damaged { path, line, what })
}

/// The same of the bytes of a file; an error is the number of a line and what is wrong with it.
pub fn parse(bytes: &[u8]) -> Result<Read, (usize, String)> {
    let mut lines = Vec::new();
    let mut start = 0;
    while start < bytes.len() {
        let end = bytes[start..].iter().position(|&b| b == b'\n');
        let Some(end) = end.map(|at| start + at) else {
            // A line without its end was being written, even if it reads well.
            lines.push((start, Err("it is not whole".to_owned())));
            break;
        };
        let line = serde_json::from_slice::<Line>(&bytes[start..end]);
        lines.push((start, line.map_err(|e| e.to_string())));
        start = end + 1;
    }
    let n = lines.len();
    let mut read: Option<Read> = None;
    for (i, (at, line)) in lines.into_iter().enumerate() {
        let number = i + 1;
        let read = match (&mut read, line) {
            (None, Ok(Line::Exercise(header))) if header.format == FORMAT => {
                read = Some(Read {
                    header: *header,
                    trials: Vec::new(),
                    ended: None,
                    cut_off: None,
                    whole_bytes: bytes.len(),
                });
                continue;
            }
            (None, Ok(Line::Exercise(header))) => {
                let what = format!(
                    "format {}; this program reads format {FORMAT}",
                    header.format
                );
                return Err((number, what));
            }
            (None, Ok(_)) => return Err((number, "a journal starts with its exercise".into())),
            (None, Err(e)) => {
                return Err((number, format!("this is no journal of an exercise: {e}")));
            }
            (Some(read), Err(_)) if number == n => {
                read.whole_bytes = at;
                read.cut_off = Some(CutOff {
                    line: number,
                    bytes: bytes.len() - at,
                });
                continue;
            }
            (Some(_), Err(e)) => {
                return Err((number, format!("damaged, with good lines after it: {e}")));
            }
            (Some(read), Ok(line)) => (read, line),
        };
        match read {
            (_, Line::Exercise(_)) => return Err((number, "a second exercise".into())),
            (read, Line::Ended(why)) => read.ended = Some(why),
            (read, Line::Trial(trial)) => {
                let before = read.trials.iter().filter(|t| t.practice == trial.practice);
                let expected = before.count() as u32 + 1;
                if trial.trial != expected {
                    let what = format!("trial {}; trial {expected} belongs here", trial.trial);
                    return Err((number, what));
                }
                read.ended = None;
                read.trials.push(*trial);
            }
        }
    }
    read.ok_or_else(|| (1, "the file is empty: no exercise was begun".into()))
}

/// A journal being written. It is locked: no other program writes it.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    broken: bool,
}

impl Journal {
    /// A new one in `folder`, which is made if need be.
    ///
    /// # Errors
    /// There is one already, or the file system refuses.
    pub fn create(folder: &Path, header: &Header) -> Result<Self, JournalError> {
        let path = folder.join(FILE);
        let failed = |error| JournalError::Io {
            path: path.clone(),
            error,
        };
        std::fs::create_dir_all(folder).map_err(failed)?;
        // Whole or not there: written beside and renamed.
        let mut beside = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
        let line = text(&Line::Exercise(Box::new(header.clone()))).map_err(failed)?;
        beside.write_all(&line).map_err(failed)?;
        beside.as_file().sync_all().map_err(failed)?;
        match beside.persist_noclobber(&path) {
            Ok(_) => {}
            Err(e) if e.error.kind() == io::ErrorKind::AlreadyExists => {
                return Err(JournalError::Exists(path));
            }
            Err(e) => return Err(failed(e.error)),
        }
        sync_folder(folder);
        Self::open(path)
    }

    /// Goes on with the one in `folder`; what is not whole at its end is cut off.
    ///
    /// # Errors
    /// As [`read`]; another program writes it.
    pub fn resume(folder: &Path) -> Result<(Self, Read), JournalError> {
        let journal = Self::open(folder.join(FILE))?;
        let read = read(folder)?;
        if read.cut_off.is_some() {
            let failed = |error| JournalError::Io {
                path: journal.path.clone(),
                error,
            };
            (journal.file.set_len(read.whole_bytes as u64)).map_err(failed)?;
            journal.file.sync_all().map_err(failed)?;
        }
        Ok((journal, read))
    }

    fn open(path: PathBuf) -> Result<Self, JournalError> {
        let opened = OpenOptions::new().append(true).open(&path);
        let file = opened.map_err(|error| JournalError::Io {
            path: path.clone(),
            error,
        })?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JournalError::InUse(path)),
            // A file system without locks: two programs at once are then the user's care.
            Err(TryLockError::Error(_)) => {}
        }
        Ok(Self {
            file,
            path,
            broken: false,
        })
    }

    /// Adds a settled trial; it is on the disk when this returns.
    ///
    /// # Errors
    /// The file system refuses, or did before.
    pub fn settle(&mut self, trial: &TrialRecord) -> Result<(), JournalError> {
        self.add(&Line::Trial(Box::new(trial.clone())))
    }

    /// Says how the exercise ended.
    ///
    /// # Errors
    /// As [`Journal::settle`].
    pub fn end(&mut self, why: &str) -> Result<(), JournalError> {
        self.add(&Line::Ended(why.to_owned()))
    }

    fn add(&mut self, line: &Line) -> Result<(), JournalError> {
        if self.broken {
            return Err(JournalError::Broken(self.path.clone()));
        }
        let written = text(line).and_then(|line| {
            self.file.write_all(&line)?;
            self.file.sync_data()
        });
        written.map_err(|error| {
            self.broken = true;
            JournalError::Io {
                path: self.path.clone(),
                error,
            }
        })
    }
}

fn text(line: &Line) -> io::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec(line)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// A renamed file is there after a loss of power once its folder is synced. Where folders cannot be, nothing is lost but that.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            format: FORMAT,
            program: "test".into(),
            scenario: "a.toml".into(),
            blind_toml: "format = 1\nname = \"Ü\"\n".into(),
            changes: Changes::default(),
            participant: Some("P07".into()),
            seed: None,
            observer: None,
            started_utc: String::new(),
        }
    }

    fn trial(number: u32) -> TrialRecord {
        TrialRecord {
            trial: number,
            level: Some(0.1 * f64::from(number)),
            right: !number.is_multiple_of(3),
            truth: "T5 right\n\"transverse\" process".into(),
            ..TrialRecord::default()
        }
    }

    fn written(folder: &Path, n: u32) -> Vec<u8> {
        let mut journal = Journal::create(folder, &header()).expect("created");
        for i in 1..=n {
            journal.settle(&trial(i)).expect("written");
        }
        std::fs::read(folder.join(FILE)).expect("there")
    }

    #[test]
    fn whoever_ends_the_program_at_any_byte_loses_no_settled_trial() {
        let folder = tempfile::tempdir().expect("a folder");
        let bytes = written(folder.path(), 5);
        let ends: Vec<usize> = (0..bytes.len())
            .filter(|&i| bytes[i] == b'\n')
            .map(|i| i + 1)
            .collect();
        for cut in 0..=bytes.len() {
            let whole = ends.iter().filter(|&&end| end <= cut).count();
            let read = parse(&bytes[..cut]);
            if whole == 0 {
                assert!(read.is_err(), "{cut}");
                continue;
            }
            let read = read.expect("the header is whole");
            assert_eq!(read.header, header());
            let expected: Vec<TrialRecord> = (1..whole as u32).map(trial).collect();
            assert_eq!(read.trials, expected, "{cut}");
            let last = ends[whole - 1];
            assert_eq!(
                read.cut_off.map(|c| c.bytes),
                (cut > last).then_some(cut - last)
            );
        }
    }

    #[test]
    fn a_journal_goes_on_after_any_cut() {
        let first = tempfile::tempdir().expect("a folder");
        let bytes = written(first.path(), 3);
        let header_end = bytes.iter().position(|&b| b == b'\n').expect("a line") + 1;
        for cut in (header_end..=bytes.len()).step_by(7).chain([bytes.len()]) {
            let folder = tempfile::tempdir().expect("a folder");
            std::fs::write(folder.path().join(FILE), &bytes[..cut]).expect("written");
            let (mut journal, read) = Journal::resume(folder.path()).expect("resumed");
            let n = read.trials.len() as u32;
            journal.settle(&trial(n + 1)).expect("written");
            drop(journal);
            let again = super::read(folder.path()).expect("whole");
            assert_eq!(again.trials.len() as u32, n + 1, "{cut}");
            assert_eq!(
                (again.cut_off, again.trials.last()),
                (None, Some(&trial(n + 1)))
            );
        }
    }

    #[test]
    fn damage_before_the_end_is_told_and_nothing_is_thrown_away() {
        let folder = tempfile::tempdir().expect("a folder");
        let bytes = written(folder.path(), 4);
        let text = String::from_utf8(bytes).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        let of = |lines: &[&str]| parse((lines.join("\n") + "\n").as_bytes());
        for (wrong, line, told) in [
            (
                vec![lines[0], lines[1], "{\"trial\":", lines[3]],
                3,
                "damaged",
            ),
            (vec![lines[0], lines[2]], 2, "trial 2; trial 1 belongs here"),
            (vec![lines[0], lines[1], lines[1]], 3, "trial 1; trial 2"),
            (vec![lines[0], lines[0]], 2, "a second exercise"),
            (vec![lines[1]], 1, "starts with its exercise"),
            (vec!["no json", lines[1]], 1, "no journal"),
        ] {
            let (at, what) = of(&wrong).expect_err(told);
            assert!(
                at == line && what.contains(told),
                "{told}: line {at}: {what}"
            );
        }
        let newer = lines[0].replace("\"format\":1", "\"format\":2");
        assert!(of(&[&newer]).is_err_and(|e| e.1.contains("format 2")));
        std::fs::write(folder.path().join(FILE), "").expect("written");
        assert!(read(folder.path()).is_err_and(|e| e.to_string().contains("empty")));
    }

    #[test]
    fn a_journal_is_begun_once_and_written_by_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let journal = Journal::create(folder.path(), &header()).expect("created");
        assert!(matches!(
            Journal::create(folder.path(), &header()),
            Err(JournalError::Exists(_))
        ));
        assert!(matches!(
            Journal::resume(folder.path()),
            Err(JournalError::InUse(_))
        ));
        drop(journal);
        let (mut journal, _) = Journal::resume(folder.path()).expect("free again");
        journal.end("all done").expect("written");
        assert_eq!(
            read(folder.path()).expect("whole").ended.as_deref(),
            Some("all done")
        );
        let left = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(left, 1, "nothing else is left behind");
        assert!(matches!(
            read(Path::new("no/such")),
            Err(JournalError::Io { .. })
        ));
    }
}
