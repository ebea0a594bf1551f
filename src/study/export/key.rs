//! Who and when: what a session is called wherever it is handed on to.

use crate::session::Session;
use serde::Serialize;
use sha2::{Digest, Sha256};

/// Participant of sessions without a pseudonym.
pub const UNKNOWN: &str = "unknown";
/// Most bytes of a name in a path, below the 255 that file systems take.
const LONGEST: usize = 160;
/// Most letters of a BIDS label.
const LONGEST_LABEL: usize = 60;

/// Tells a session from all others.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct Key {
    /// Pseudonym, or `unknown`.
    pub participant: String,
    /// When it began and what its file is called, such as `20310517T093000125Z-t5-right`.
    pub session: String,
    /// When it began: `20310517T093000125Z`.
    #[serde(skip)]
    started: String,
    #[serde(skip)]
    stem: String,
}

impl Key {
    /// The key of a session.
    pub fn of(session: &Session) -> Self {
        let header = session.header();
        let stem = session.path().file_stem().unwrap_or_default();
        Self::new(
            header.participant.as_deref(),
            &header.started_utc,
            &stem.to_string_lossy(),
        )
    }

    /// The key of what `participant` did in the file `stem`, begun at `started_utc`.
    pub fn new(participant: Option<&str>, started_utc: &str, stem: &str) -> Self {
        let participant = participant.map(str::trim).filter(|p| !p.is_empty());
        let kept = started_utc.chars().filter(char::is_ascii_alphanumeric);
        let started: String = kept.take(24).collect();
        Self {
            participant: participant.unwrap_or(UNKNOWN).to_owned(),
            session: format!("{started}-{stem}"),
            started,
            stem: stem.to_owned(),
        }
    }

    /// Folders of the session: `participant=P07/session=…`.
    pub fn place(&self) -> String {
        let (participant, session) = (escaped(&self.participant), escaped(&self.session));
        format!("participant={participant}/session={session}")
    }

    /// Label of the participant in BIDS, letters and digits.
    pub fn bids_subject(&self) -> String {
        label(&self.participant)
    }

    /// Label of the session in BIDS, letters and digits.
    pub fn bids_session(&self) -> String {
        format!("{}{}", self.started, label(&self.stem))
    }
}

/// What a path bears; all else as `%` and two hexadecimal digits, as Hive writes it. No two names become the same.
fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for byte in name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => {
                text.push(char::from(byte));
            }
            _ => text.push_str(&format!("%{byte:02X}")),
        }
    }
    if text.len() <= LONGEST {
        return text;
    }
    let mut end = LONGEST;
    // Not within a `%41`.
    while text[end - 2..end].contains('%') {
        end -= 1;
    }
    format!("{}-{}", &text[..end], fingerprint(name))
}

/// The way back of what engines read from a path.
pub(super) fn unescaped(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = text.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match digits.and_then(|d| u8::from_str_radix(d, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// Letters and digits alone; a name that had others gets a fingerprint of itself, so that no two become the same.
fn label(name: &str) -> String {
    let letters = name.chars().filter(char::is_ascii_alphanumeric);
    let kept: String = letters.take(LONGEST_LABEL).collect();
    match kept == name && !kept.is_empty() {
        true => kept,
        false => format!("{kept}x{}", fingerprint(name)),
    }
}

/// Eight hexadecimal digits that hardly any two names share.
fn fingerprint(name: &str) -> String {
    let digest = Sha256::digest(name.as_bytes());
    digest[..4].iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leaves_its_folder_and_no_two_share_one() {
        let long = "ä".repeat(300);
        let longer = format!("{long}b");
        let names = [
            "P07", "P 07", "P-07", "P/07", "../P07", "P%07", "P%2F07", "..", ".", "=", "Ω", "p07",
            "a\nb", "a\0b", &long, &longer,
        ];
        let keys: Vec<Key> = names
            .iter()
            .map(|n| Key::new(Some(n), "2031-05-17T09:30:00.125Z", n))
            .collect();
        for (i, key) in keys.iter().enumerate() {
            let place = key.place();
            let parts: Vec<&str> = place.split('/').collect();
            assert_eq!(parts.len(), 2, "{place}");
            assert!(parts.iter().all(|p| p.len() < 200 && p.is_ascii()));
            assert!(parts[0].starts_with("participant=") && parts[1].starts_with("session=2031"));
            let labels = [key.bids_subject(), key.bids_session()];
            let fine = |l: &String| l.bytes().all(|b| b.is_ascii_alphanumeric()) && l.len() < 110;
            assert!(
                labels.iter().all(|l| !l.is_empty() && fine(l)),
                "{labels:?}"
            );
            for other in &keys[..i] {
                assert_ne!(place, other.place());
                assert_ne!(labels, [other.bids_subject(), other.bids_session()]);
            }
            if key.participant.len() < 50 {
                let back = unescaped(parts[0].trim_start_matches("participant="));
                assert_eq!(back, key.participant);
            }
        }
        assert_eq!(keys[0].bids_subject(), "P07");
        assert_eq!(keys[0].session, "20310517T093000125Z-P07");
    }

    #[test]
    fn without_a_pseudonym_it_is_unknown() {
        for nobody in [None, Some(""), Some("  ")] {
            let key = Key::new(nobody, "2031-05-17T09:30:00Z", "a");
            assert_eq!(
                key.place(),
                "participant=unknown/session=20310517T093000Z-a"
            );
        }
    }
}
