//! How a part lies on the disk: JSON on three lines, of which the second is the part itself and the first tells its key and
//! its SHA-256.

use super::finite::is_finite;
use crate::figure::write_files;
use crate::lab::program::hexadecimal;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};

#[derive(Serialize, Deserialize)]
struct Head {
    key: String,
    sha256: String,
}

/// Ends the first line, so that the three of them are one JSON object.
const OPENS: &str = ",\"part\":";

/// Name of the file that holds the part called `key`.
pub(super) fn name(key: &str) -> PathBuf {
    format!("{}.json", hexadecimal(&Sha256::digest(key))).into()
}

/// The part called `key` in a file; nothing where there is none, where it is damaged and where it is of another kind.
pub(super) fn read<T: DeserializeOwned>(path: &Path, key: &str) -> Option<T> {
    let text = std::fs::read_to_string(path).ok()?;
    let (first, rest) = text.split_once('\n')?;
    let part = rest.strip_suffix("\n}\n")?;
    let head: Head = serde_json::from_str(&format!("{}}}", first.strip_suffix(OPENS)?)).ok()?;
    let whole = head.key == key && head.sha256 == hexadecimal(&Sha256::digest(part));
    whole.then(|| serde_json::from_str(part).ok()).flatten()
}

/// What the file of a part holds; nothing where it would not come back as it is.
pub(super) fn bytes<T: Serialize + DeserializeOwned>(key: &str, part: &T) -> Option<Vec<u8>> {
    if !is_finite(part) {
        return None;
    }
    let text = serde_json::to_string(part).ok()?;
    let back: T = serde_json::from_str(&text).ok()?;
    if serde_json::to_string(&back).ok()? != text {
        return None;
    }
    let head = Head {
        key: key.to_owned(),
        sha256: hexadecimal(&Sha256::digest(&text)),
    };
    let head = serde_json::to_string(&head).ok()?;
    let open = head.strip_suffix('}')?;
    Some(format!("{open}{OPENS}\n{text}\n}}\n").into_bytes())
}

/// Writes a part beside its place and puts it there; its folder is made where it is missing.
pub(super) fn write(path: &Path, bytes: Vec<u8>) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    write_files(&[(path.to_owned(), bytes)])
}
