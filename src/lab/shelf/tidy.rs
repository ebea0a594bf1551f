//! Throws away shelves that nobody uses any more.

use super::label;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Shelves that stay, those used last.
const MOST: usize = 64;

/// Throws away all but the shelves in `root` that were used last; `in_use` stays in any case.
///
/// Only folders with the name and the label of a shelf are touched. What cannot be removed stays.
pub(super) fn tidy(root: &Path, in_use: &Path) {
    let mut shelves = shelves(root);
    shelves.sort_by_key(|(used, folder)| (folder != in_use, std::cmp::Reverse(*used)));
    for (_, folder) in shelves.into_iter().skip(MOST) {
        discard(&folder);
    }
}

/// Removes a shelf, if it is one.
pub(super) fn discard(folder: &Path) {
    if used(folder).is_some() {
        let _ = std::fs::remove_dir_all(folder);
    }
}

/// The shelves in `root`, and when an experiment was last begun on each.
fn shelves(root: &Path) -> Vec<(SystemTime, PathBuf)> {
    let Ok(entries) = std::fs::read_dir(root) else {
        return Vec::new();
    };
    entries
        .filter_map(|entry| {
            let folder = entry.ok()?.path();
            Some((used(&folder)?, folder))
        })
        .collect()
}

/// When an experiment was last begun on the shelf in `folder`; nothing where it is no shelf.
fn used(folder: &Path) -> Option<SystemTime> {
    let name = folder.file_name()?.to_str()?;
    let is_hash = name.len() == 64 && name.chars().all(|c| c.is_ascii_hexdigit());
    let label = folder.join(label::FILE).symlink_metadata().ok()?;
    let is_folder = folder.symlink_metadata().ok()?.is_dir();
    if is_hash && is_folder && label.is_file() {
        label.modified().ok()
    } else {
        None
    }
}
