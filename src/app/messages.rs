//! What the workbench has to say: errors, warnings, notes, with the time since the start.

use std::sync::Arc;
use std::time::{Duration, Instant};

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For the record.
    Info,
    /// Look at this.
    Warning,
    /// Something did not work.
    Error,
}

impl Level {
    /// As a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Info => "Info",
            Self::Warning => "Warning",
            Self::Error => "Error",
        }
    }
}

/// One message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// How much it matters.
    pub level: Level,
    /// Time since the workbench started.
    pub since_start: Duration,
    /// What happened, in one line.
    pub text: String,
    /// How often it came in a row.
    pub times: usize,
}

impl Message {
    /// The time as `mm:ss` (or `h:mm:ss`).
    pub fn time(&self) -> String {
        clock(self.since_start.as_secs_f64())
    }
}

/// Seconds as `mm:ss`, or `h:mm:ss` from an hour up.
pub fn clock(time_s: f64) -> String {
    let s = time_s.max(0.0) as u64;
    let (h, m, s) = (s / 3600, s / 60 % 60, s % 60);
    if h > 0 {
        format!("{h}:{m:02}:{s:02}")
    } else {
        format!("{m:02}:{s:02}")
    }
}

/// Most messages kept; the oldest go first.
const KEPT: usize = 500;

/// All messages, oldest first; shared with the window without copying.
#[derive(Clone, Debug)]
pub struct Messages {
    start: Instant,
    list: Arc<Vec<Message>>,
    /// Counts messages told, so that a reader knows what is new to it.
    told: u64,
}

impl Default for Messages {
    fn default() -> Self {
        Self {
            start: Instant::now(),
            list: Arc::default(),
            told: 0,
        }
    }
}

impl Messages {
    /// Adds a message; a repetition of the last one is counted instead.
    pub fn tell(&mut self, level: Level, text: impl Into<String>) {
        let text = text.into();
        let since_start = self.start.elapsed();
        let list = Arc::make_mut(&mut self.list);
        self.told += 1;
        if let Some(last) = list.last_mut()
            && last.level == level
            && last.text == text
        {
            last.times += 1;
            last.since_start = since_start;
            return;
        }
        if list.len() == KEPT {
            list.remove(0);
        }
        list.push(Message {
            level,
            since_start,
            text,
            times: 1,
        });
    }

    /// All of them, oldest first.
    pub fn list(&self) -> Arc<Vec<Message>> {
        self.list.clone()
    }

    /// How many were ever told.
    pub fn told(&self) -> u64 {
        self.told
    }

    /// Forgets them.
    pub fn clear(&mut self) {
        self.list = Arc::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repetitions_are_counted_and_the_list_is_bounded() {
        let mut messages = Messages::default();
        messages.tell(Level::Error, "no file");
        messages.tell(Level::Error, "no file");
        assert_eq!(messages.list().len(), 1);
        assert_eq!(messages.list()[0].times, 2);
        for i in 0..2 * KEPT {
            messages.tell(Level::Info, format!("{i}"));
        }
        assert_eq!(messages.list().len(), KEPT);
        assert_eq!(messages.told(), 2 + 2 * KEPT as u64);
    }

    #[test]
    fn time_reads_as_a_clock() {
        assert_eq!(clock(65.9), "01:05");
        assert_eq!(clock(3661.0), "1:01:01");
        assert_eq!(clock(f64::NAN), "00:00");
    }
}
