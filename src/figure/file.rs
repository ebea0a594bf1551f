//! Writing files so that a reader never sees half of one.

use std::io::{Result, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes each file's bytes beside its path, then renames them all: a fault before the last is written leaves everything
/// as it was. Folders must exist.
///
/// # Errors
/// Those of the file system.
pub fn write_files(files: &[(PathBuf, Vec<u8>)]) -> Result<()> {
    let written: Vec<NamedTempFile> = files
        .iter()
        .map(|(path, bytes)| beside(path, bytes))
        .collect::<Result<_>>()?;
    for (file, (path, _)) in written.into_iter().zip(files) {
        file.persist(path)?;
    }
    Ok(())
}

/// Writes `bytes` beside `path`, then renames. The folder must exist.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    beside(path, bytes)?.persist(path)?;
    Ok(())
}

/// A file with `bytes` in the folder of `path`, which goes away unless it is renamed.
fn beside(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; a figure is an ordinary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    Ok(file)
}
