//! Which recordings are shown, and in which order.

use super::entry::Entry;
use std::cmp::Ordering;
use std::time::{Duration, SystemTime};

/// How long ago a recording may have been made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Since {
    /// At any time.
    #[default]
    Any,
    /// In the last 24 hours.
    Day,
    /// In the last seven days.
    Week,
    /// In the last thirty days.
    Month,
    /// In the last 365 days.
    Year,
}

impl Since {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Any, Self::Day, Self::Week, Self::Month, Self::Year];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Any => "Any date",
            Self::Day => "Last 24 hours",
            Self::Week => "Last 7 days",
            Self::Month => "Last 30 days",
            Self::Year => "Last 365 days",
        }
    }

    fn reach(self) -> Option<Duration> {
        let days = match self {
            Self::Any => return None,
            Self::Day => 1,
            Self::Week => 7,
            Self::Month => 30,
            Self::Year => 365,
        };
        Some(Duration::from_secs(days * 86_400))
    }
}

/// What a recording must be like to be shown.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Filter {
    /// Words that must all be found in what is told of it.
    pub text: String,
    /// Its participant.
    pub participant: Option<String>,
    /// Its scenario.
    pub scenario: Option<String>,
    /// One of its tags.
    pub tag: Option<String>,
    /// Its age.
    pub since: Since,
}

impl Filter {
    /// Whether everything passes.
    pub fn is_open(&self) -> bool {
        *self == Self::default()
    }

    /// Whether `entry` passes; `now` is the present instant.
    pub fn passes(&self, entry: &Entry, now: SystemTime) -> bool {
        let is = |wanted: &Option<String>, found: Option<&String>| {
            wanted.is_none() || wanted.as_ref() == found
        };
        let young = || {
            let Some(reach) = self.since.reach() else {
                return true;
            };
            let age = entry.started().map(|s| now.duration_since(s));
            // One whose clock was ahead is new.
            age.is_some_and(|age| age.map_or(true, |age| age <= reach))
        };
        is(&self.participant, entry.participant.as_ref())
            && is(&self.scenario, Some(&entry.scenario))
            && self.tag.as_ref().is_none_or(|t| entry.tags.contains(t))
            && young()
            && self.found_in(entry)
    }

    fn found_in(&self, entry: &Entry) -> bool {
        if self.text.trim().is_empty() {
            return true;
        }
        let told = format!("{} {}", entry.spoken(), entry.file()).to_lowercase();
        let mut words = self.text.split_whitespace();
        words.all(|word| told.contains(&word.to_lowercase()))
    }
}

/// What the list is sorted by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum By {
    /// When it was recorded.
    #[default]
    Date,
    /// Its participant.
    Participant,
    /// Its scenario.
    Scenario,
    /// Its length.
    Duration,
    /// The score of its trial.
    Score,
    /// The name of its file.
    File,
}

impl By {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Date,
        Self::Participant,
        Self::Scenario,
        Self::Duration,
        Self::Score,
        Self::File,
    ];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Date => "Date",
            Self::Participant => "Participant",
            Self::Scenario => "Scenario",
            Self::Duration => "Duration",
            Self::Score => "Score",
            Self::File => "File",
        }
    }
}

/// The order of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sorting {
    /// By what.
    pub by: By,
    /// The newest, longest, last first.
    pub descending: bool,
}

impl Default for Sorting {
    /// The newest first.
    fn default() -> Self {
        Self {
            by: By::Date,
            descending: true,
        }
    }
}

impl Sorting {
    /// What has no such value comes last, whichever way; equal ones stand by date and file.
    fn compare(self, a: &Entry, b: &Entry) -> Ordering {
        let turned = |o: Ordering| if self.descending { o.reverse() } else { o };
        let some = |a: Option<&str>, b: Option<&str>| match (a, b) {
            (Some(a), Some(b)) => turned(a.cmp(b)),
            (a, b) => a.is_none().cmp(&b.is_none()),
        };
        fn word(text: &str) -> Option<&str> {
            Some(text).filter(|t| !t.is_empty())
        }
        let numbers = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => turned(a.total_cmp(&b)),
            (a, b) => a.is_none().cmp(&b.is_none()),
        };
        let dates = some(word(&a.started_utc), word(&b.started_utc));
        let first = match self.by {
            By::Date => dates,
            By::Participant => some(a.participant.as_deref(), b.participant.as_deref()),
            By::Scenario => some(word(&a.scenario), word(&b.scenario)),
            By::Duration => numbers(a.seconds, b.seconds),
            By::Score => {
                let rank = |e: &Entry| e.score.as_ref().map(|s| s.rank);
                numbers(rank(a), rank(b))
            }
            By::File => turned(a.path.file_name().cmp(&b.path.file_name())),
        };
        let newest = b.started_utc.cmp(&a.started_utc);
        first.then(newest).then_with(|| a.path.cmp(&b.path))
    }
}

/// The places in `entries` of those shown, in order.
pub fn shown(entries: &[Entry], filter: &Filter, sorting: Sorting, now: SystemTime) -> Vec<usize> {
    let mut places: Vec<usize> = (0..entries.len())
        .filter(|&i| filter.passes(&entries[i], now))
        .collect();
    places.sort_by(|&a, &b| sorting.compare(&entries[a], &entries[b]));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(file: &str, who: Option<&str>, day: u32, seconds: Option<f64>) -> Entry {
        Entry {
            participant: who.map(str::to_owned),
            scenario: "T5 right".into(),
            started_utc: format!("2031-05-{day:02}T09:30:00Z"),
            seconds,
            ..Entry::unread(file.into(), 1)
        }
    }

    fn entries() -> Vec<Entry> {
        let mut all = vec![
            entry("a.mcap", Some("P02"), 1, Some(30.0)),
            entry("b.mcap", None, 9, None),
            entry("c.mcap", Some("P01"), 17, Some(90.0)),
        ];
        all[0].tags = vec!["novice".into()];
        all
    }

    fn now() -> SystemTime {
        humantime::parse_rfc3339_weak("2031-05-18T00:00:00Z").expect("a date")
    }

    fn places(filter: &Filter, by: By, descending: bool) -> Vec<usize> {
        shown(&entries(), filter, Sorting { by, descending }, now())
    }

    #[test]
    fn it_sorts_both_ways_and_what_is_not_known_comes_last() {
        let all = Filter::default();
        assert_eq!(places(&all, By::Date, true), [2, 1, 0]);
        assert_eq!(places(&all, By::Date, false), [0, 1, 2]);
        assert_eq!(places(&all, By::Duration, false), [0, 2, 1]);
        assert_eq!(places(&all, By::Duration, true), [2, 0, 1]);
        assert_eq!(places(&all, By::Participant, false), [2, 0, 1]);
        assert_eq!(places(&all, By::File, false), [0, 1, 2]);
    }

    #[test]
    fn filters_work_together() {
        let by = |f: Filter| places(&f, By::Date, false);
        let text = |t: &str| Filter {
            text: t.into(),
            ..Filter::default()
        };
        assert_eq!(by(text("p0 T5")), [0, 2]);
        assert_eq!(by(text("C.MCAP")), [2]);
        assert_eq!(by(text("p02 p01")), [0; 0]);
        let tag = Filter {
            tag: Some("novice".into()),
            ..Filter::default()
        };
        assert_eq!(by(tag.clone()), [0]);
        let week = Filter {
            since: Since::Week,
            ..tag
        };
        assert_eq!(by(week), [0; 0]);
        let month = Filter {
            since: Since::Month,
            participant: Some("P01".into()),
            ..Filter::default()
        };
        assert_eq!(by(month), [2]);
    }
}
