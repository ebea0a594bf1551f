//! BIDS-Motion: sessions as a dataset of the Brain Imaging Data Structure (Jeung et al. 2024, *Motion-BIDS*; specification 1.9
//! and later).
//!
//! ```text
//! dataset_description.json  README  participants.tsv  participants.json
//! sub-P07/ses-20310517T093000125Zrun/
//!     sub-…_ses-…_scans.tsv
//!     motion/sub-…_ses-…_task-palpation_tracksys-dorsum_motion.tsv     samples, no line of names
//!                                                     …_motion.json    rate, counts of channels, device
//!                                                     …_channels.tsv   what each column is
//!                                                     …_channels.json  the frame of reference
//!            sub-…_ses-…_task-palpation_events.tsv, .json              marks, answers, edits, pops, faults
//! ```
//!
//! A sample is a tick that every finger has; lost ticks are no samples, so that the `latency` channel and not the number of
//! the sample tells the time. Positions keep their millimetres, which the columns say. A session's folder is made beside and
//! renamed: it is there whole or not at all. `finish` adds what the dataset has once; files of that sort that are there
//! are kept, participants are added to `participants.tsv` below those that it has.

mod channels;
mod sidecars;

use super::gather::folders;
use super::{Exported, Key, Settings, failed, output};
use crate::figure::{Beside, write_files};
use crate::session::{Entry, Event, Session, Strictness};
use crate::study::StudyError;
use channels::Channel;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Version of BIDS that datasets are written by.
pub const BIDS_VERSION: &str = "1.10.0";
/// What fingers do, as file names say.
const TASK: &str = "palpation";
/// What tracks them.
const TRACKSYS: &str = "dorsum";
/// Ticks between two words on progress.
const BETWEEN: u64 = 4096;

/// Where a session's files lie and how their names begin.
struct Names {
    subject: String,
    session: String,
}

impl Names {
    fn of(key: &Key) -> Self {
        Self {
            subject: format!("sub-{}", key.bids_subject()),
            session: format!("ses-{}", key.bids_session()),
        }
    }

    fn start(&self) -> String {
        format!("{}_{}", self.subject, self.session)
    }

    fn tracked(&self, suffix: &str) -> String {
        let start = self.start();
        format!("motion/{start}_task-{TASK}_tracksys-{TRACKSYS}_{suffix}")
    }

    fn events(&self, ending: &str) -> String {
        let start = self.start();
        format!("motion/{start}_task-{TASK}_events.{ending}")
    }
}

/// Writes the folder of a session.
pub(super) fn write(
    session: &Session,
    key: &Key,
    settings: &Settings,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Exported, StudyError> {
    let names = Names::of(key);
    let subject = settings.folder.join(&names.subject);
    let place = subject.join(&names.session);
    let mut exported = Exported::new(key);
    if place.exists() && !settings.force {
        exported.skipped = true;
        progress(1.0);
        return Ok(exported);
    }
    std::fs::create_dir_all(&subject).map_err(failed(&subject))?;
    let beside = tempfile::Builder::new()
        .prefix(".partial")
        .tempdir_in(&subject)
        .map_err(failed(&subject))?;
    let folder = beside.path().join(&names.session);
    let motion = folder.join("motion");
    std::fs::create_dir_all(&motion).map_err(failed(&motion))?;

    let channels = channels::of(session.header().n_fingers());
    let samples_path = folder.join(names.tracked("motion.tsv"));
    let samples = samples(
        session,
        &channels,
        &samples_path,
        &mut exported,
        &mut |share| progress(0.8 * share),
    )?;
    let events = events(session, &mut |share| progress(0.8 + 0.2 * share))?;
    let json = |value: serde_json::Value| format!("{value:#}\n").into_bytes();
    let header = session.header();
    let files = [
        (
            names.tracked("motion.json"),
            json(sidecars::motion(header, key, &channels, &samples)),
        ),
        (
            names.tracked("channels.tsv"),
            channels::tsv(&channels, header.rate_hz),
        ),
        (names.tracked("channels.json"), json(sidecars::channels())),
        (names.events("tsv"), events_tsv(&events, samples.first_ns)),
        (names.events("json"), json(sidecars::events())),
        (
            format!("{}_scans.tsv", names.start()),
            tsv(&[
                vec!["filename".into(), "acq_time".into()],
                vec![names.tracked("motion.tsv"), header.started_utc.clone()],
            ]),
        ),
    ];
    let files: Vec<(PathBuf, Vec<u8>)> = files
        .into_iter()
        .map(|(name, bytes)| (folder.join(name), bytes))
        .collect();
    exported.bytes += files
        .iter()
        .map(|(_, bytes)| bytes.len() as u64)
        .sum::<u64>();
    write_files(&files).map_err(failed(&folder))?;
    if place.exists() {
        // Out of the way in one step, so that no reader sees half of it.
        std::fs::rename(&place, beside.path().join("old")).map_err(failed(&place))?;
    }
    std::fs::rename(&folder, &place).map_err(failed(&place))?;
    progress(1.0);
    Ok(exported)
}

/// What the samples came to.
#[derive(Clone, Copy, Debug, Default)]
struct Samples {
    n: u64,
    first_ns: u64,
    last_ns: u64,
}

fn samples(
    session: &Session,
    channels: &[Channel],
    path: &Path,
    exported: &mut Exported,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Samples, StudyError> {
    let mut file = Beside::new(path).map_err(failed(path))?;
    let mut ticks = session.ticks(Strictness::Lenient)?;
    let mut samples = Samples::default();
    let mut line = String::new();
    while let Some(tick) = ticks.next() {
        let tick = tick?;
        let fingers = tick.fingers();
        let Some(first) = fingers.first() else {
            continue;
        };
        if samples.n == 0 {
            samples.first_ns = first.time_ns;
        }
        samples.last_ns = first.time_ns;
        samples.n += 1;
        line.clear();
        channels::line(channels, fingers, samples.first_ns, &mut line);
        file.write_all(line.as_bytes()).map_err(failed(path))?;
        if samples.n.is_multiple_of(BETWEEN) && !progress(ticks.progress()) {
            return Err(StudyError::Stopped);
        }
    }
    file.keep().map_err(failed(path))?;
    exported.rows = samples.n;
    exported.left_out = ticks.incomplete();
    exported.damage = ticks.damage().clone();
    exported.bytes += std::fs::metadata(path).map_err(failed(path))?.len();
    Ok(samples)
}

fn events(
    session: &Session,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Event>, StudyError> {
    let mut events = Vec::new();
    let mut entries = session.entries(Strictness::Lenient)?;
    let mut n = 0_u64;
    while let Some(entry) = entries.next() {
        if let Entry::Event(event) = entry? {
            events.push(event);
        }
        n += 1;
        if n.is_multiple_of(BETWEEN) && !progress(entries.progress()) {
            return Err(StudyError::Stopped);
        }
    }
    events.sort_by_key(|e| e.time_ns);
    Ok(events)
}

fn events_tsv(events: &[Event], first_ns: u64) -> Vec<u8> {
    let names = ["onset", "duration", "trial_type", "tick", "text"];
    let mut lines = vec![names.map(str::to_owned).to_vec()];
    for event in events {
        lines.push(vec![
            seconds_between(first_ns, event.time_ns),
            "0".into(),
            word(&event.kind),
            event.tick.to_string(),
            word(&event.text),
        ]);
    }
    tsv(&lines)
}

/// Seconds from one instant to another, exact to the nanosecond.
fn seconds_between(from_ns: u64, to_ns: u64) -> String {
    let sign = if to_ns < from_ns { "-" } else { "" };
    let ns = to_ns.abs_diff(from_ns);
    let text = format!("{sign}{}.{:09}", ns / 1_000_000_000, ns % 1_000_000_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A cell of text: no tabs, no line breaks, never empty.
fn word(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    match words.is_empty() {
        true => "n/a".to_owned(),
        false => words.join(" "),
    }
}

fn tsv(lines: &[Vec<String>]) -> Vec<u8> {
    let lines = lines.iter().map(|cells| cells.join("\t") + "\n");
    lines.collect::<String>().into_bytes()
}

/// Adds what a dataset has once.
pub(super) fn finish(folder: &Path) -> Result<(), StudyError> {
    let mut files = Vec::new();
    let json = |value: serde_json::Value| format!("{value:#}\n").into_bytes();
    let once = [
        ("dataset_description.json", json(sidecars::dataset())),
        ("README", sidecars::README.as_bytes().to_vec()),
        ("participants.json", json(sidecars::participants())),
    ];
    for (name, bytes) in once {
        let path = folder.join(name);
        if !path.exists() {
            files.push((path, bytes));
        }
    }
    let path = folder.join("participants.tsv");
    files.push((path.clone(), participants(folder, &path)?));
    write_files(&files).map_err(failed(folder))
}

/// `participants.tsv` as it is, with those that it lacks added.
fn participants(folder: &Path, path: &Path) -> Result<Vec<u8>, StudyError> {
    let before = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => "participant_id\tpseudonym\n".into(),
        Err(e) => return Err(output(path, &e)),
    };
    let mut lines = before.lines().filter(|l| !l.trim().is_empty());
    let names: Vec<&str> = lines.next().unwrap_or_default().split('\t').collect();
    if names.first() != Some(&"participant_id") {
        return Err(output(path, &"its first column is not participant_id"));
    }
    let known: Vec<&str> = lines.filter_map(|l| l.split('\t').next()).collect();
    let mut text = before.trim_end().to_owned() + "\n";
    for subject in folders(folder, "sub-")? {
        if known.contains(&&*subject) {
            continue;
        }
        let pseudonym = pseudonym(&folder.join(&subject))?;
        let cells = names.iter().map(|name| match *name {
            "participant_id" => subject.clone(),
            "pseudonym" => word(&pseudonym),
            _ => "n/a".to_owned(),
        });
        text.push_str(&(cells.collect::<Vec<_>>().join("\t") + "\n"));
    }
    Ok(text.into_bytes())
}

/// The pseudonym that the sessions of a subject were recorded under; empty where none tells.
fn pseudonym(subject: &Path) -> Result<String, StudyError> {
    for session in folders(subject, "ses-")? {
        let motion = subject.join(session).join("motion");
        let entries = std::fs::read_dir(&motion).into_iter().flatten().flatten();
        let mut paths = entries.map(|e| e.path());
        let sidecar = paths.find(|p| p.to_string_lossy().ends_with("_motion.json"));
        let bytes = sidecar
            .and_then(|p| std::fs::read(p).ok())
            .unwrap_or_default();
        let read: Option<serde_json::Value> = serde_json::from_slice(&bytes).ok();
        let told = read.and_then(|v| v[sidecars::PSEUDONYM].as_str().map(str::to_owned));
        if let Some(told) = told {
            return Ok(told);
        }
    }
    Ok(String::new())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_exact_and_words_stay_in_their_cell() {
        assert_eq!(seconds_between(5, 5), "0");
        assert_eq!(seconds_between(1_000_000_000, 3_500_000_001), "2.500000001");
        assert_eq!(seconds_between(2_000_000_000, 500_000_000), "-1.5");
        assert_eq!(seconds_between(0, u64::MAX), "18446744073.709551615");
        assert_eq!(seconds_between(0, 10_000_000_000), "10");
        assert_eq!(word(" a\tb\n c"), "a b c");
        assert_eq!(word("\t"), "n/a");
    }

    #[test]
    fn what_others_wrote_of_participants_is_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("participants.tsv");
        std::fs::write(&path, "participant_id\tage\npseudo-1\t30\nsub-P01\t41").expect("written");
        for subject in ["sub-P01", "sub-P02"] {
            std::fs::create_dir(folder.path().join(subject)).expect("made");
        }
        let text = participants(folder.path(), &path).expect("read");
        let expected = "participant_id\tage\npseudo-1\t30\nsub-P01\t41\nsub-P02\tn/a\n";
        assert_eq!(String::from_utf8(text).expect("UTF-8"), expected);
        std::fs::write(&path, "name\nsub-P01\n").expect("written");
        assert!(participants(folder.path(), &path).is_err());
    }
}
