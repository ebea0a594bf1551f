//! What there is to know of a recording without opening it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// How far a recording can be trusted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// Not looked into yet.
    Unread,
    /// As its writer finished it.
    Good,
    /// A trial that was not answered: nothing is told of it but that.
    Sealed,
    /// Readable as far as it goes; what is wrong, in words.
    Damaged(String),
    /// Not readable as it is; why.
    Unreadable(String),
}

/// What the trial of a recording came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// In a few words.
    pub text: String,
    /// Better ones are higher.
    pub rank: f64,
}

/// A recording in the list.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The file.
    pub path: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// How far it can be trusted.
    pub state: State,
    /// Pseudonym of the participant.
    pub participant: Option<String>,
    /// Name of the scenario; empty for a sealed or unreadable one.
    pub scenario: String,
    /// Start, UTC, as the file says it.
    pub started_utc: String,
    /// Length, s; `None` until it is known.
    pub seconds: Option<f64>,
    /// Ticks that are missing in it.
    pub lost: u64,
    /// What its trial came to.
    pub score: Option<Mark>,
    /// What the user wrote on it.
    pub tags: Vec<String>,
    /// Where the fingers dwelt.
    pub dwell: Option<Arc<crate::study::index::Thumbnail>>,
}

impl Entry {
    /// A file of which nothing is known yet but that it is there.
    pub fn unread(path: PathBuf, bytes: u64) -> Self {
        Self {
            path,
            bytes,
            state: State::Unread,
            participant: None,
            scenario: String::new(),
            started_utc: String::new(),
            seconds: None,
            lost: 0,
            score: None,
            tags: Vec::new(),
            dwell: None,
        }
    }

    /// The name of its file.
    pub fn file(&self) -> String {
        file_name(&self.path)
    }

    /// When it was recorded.
    pub fn started(&self) -> Option<SystemTime> {
        humantime::parse_rfc3339_weak(&self.started_utc).ok()
    }

    /// Day and minute of its start, UTC, such as `2031-05-17 09:30`.
    pub fn date(&self) -> String {
        let minute: String = self.started_utc.chars().take(16).collect();
        minute.replace('T', " ")
    }

    /// What it is called in a line: its scenario, or what it is instead.
    pub fn title(&self) -> String {
        match &self.state {
            State::Sealed => "Sealed trial".into(),
            State::Unreadable(_) => "Unreadable".into(),
            _ if self.scenario.is_empty() => self.file(),
            _ => self.scenario.clone(),
        }
    }

    /// Whether its ticks may be looked at.
    pub fn can_open(&self) -> bool {
        matches!(self.state, State::Unread | State::Good | State::Damaged(_))
    }

    /// Whether there is something to be recovered.
    pub fn needs_recovery(&self) -> bool {
        matches!(self.state, State::Damaged(_) | State::Unreadable(_))
    }

    /// All of it in a line, for a screen reader.
    pub fn spoken(&self) -> String {
        let mut parts = vec![self.title(), self.date()];
        parts.extend(self.participant.clone());
        parts.extend(self.seconds.map(duration));
        parts.extend(self.score.as_ref().map(|s| s.text.clone()));
        parts.extend(self.tags.iter().cloned());
        match &self.state {
            State::Damaged(_) => parts.push("damaged".into()),
            State::Unreadable(_) | State::Sealed => parts.push(self.file()),
            State::Unread | State::Good => {}
        }
        parts.retain(|p| !p.is_empty());
        parts.join(", ")
    }
}

/// A length of time: `8.4 s`, `1:23 min`, `1:02:03 h`.
pub fn duration(seconds: f64) -> String {
    let s = if seconds.is_finite() {
        seconds.max(0.0)
    } else {
        0.0
    };
    let whole = s.round() as u64;
    if s < 59.95 {
        format!("{s:.1} s")
    } else if whole < 3600 {
        format!("{}:{:02} min", whole / 60, whole % 60)
    } else {
        format!(
            "{}:{:02}:{:02} h",
            whole / 3600,
            whole / 60 % 60,
            whole % 60
        )
    }
}

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_reads_well_and_a_sealed_one_tells_nothing() {
        let mut e = Entry::unread("a/b.mcap".into(), 10);
        assert_eq!(e.title(), "b.mcap");
        e.scenario = "T5 right".into();
        e.started_utc = "2031-05-17T09:30:00.125Z".into();
        e.seconds = Some(83.4);
        e.score = Some(Mark {
            text: "wrong by 34 mm".into(),
            rank: -34.0,
        });
        e.participant = Some("P07".into());
        e.tags = vec!["before".into()];
        assert_eq!(
            e.spoken(),
            "T5 right, 2031-05-17 09:30, P07, 1:23 min, wrong by 34 mm, before"
        );
        e.state = State::Sealed;
        assert!(!e.spoken().contains("T5"), "{}", e.spoken());
        assert!(!e.can_open());
    }

    #[test]
    fn lengths_have_units() {
        assert_eq!(duration(8.44), "8.4 s");
        assert_eq!(duration(59.97), "1:00 min");
        assert_eq!(duration(3723.0), "1:02:03 h");
        assert_eq!(duration(f64::NAN), "0.0 s");
    }
}
