//! Writing files so that a reader never sees half of one.

use std::io::{BufWriter, Result, Write};
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

/// A file that is written bit by bit and is not there until it is [kept](Self::keep). Dropped before, it goes away; a killed
/// program leaves a hidden file `.partial…` that no reader takes for one of ours.
#[derive(Debug)]
pub struct Beside {
    file: BufWriter<NamedTempFile>,
    path: PathBuf,
}

impl Beside {
    /// Begins the file that is to be at `path`. Its folder must exist.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn new(path: &Path) -> Result<Self> {
        Ok(Self {
            file: BufWriter::with_capacity(256 * 1024, temporary(path)?),
            path: path.to_owned(),
        })
    }

    /// Puts the file in its place, instead of one that may be there.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn keep(self) -> Result<()> {
        let file = self.file.into_inner().map_err(|e| e.into_error())?;
        file.persist(&self.path)?;
        Ok(())
    }
}

impl Write for Beside {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.file.flush()
    }
}

/// Writes `bytes` beside `path`, then renames. The folder must exist.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    beside(path, bytes)?.persist(path)?;
    Ok(())
}

/// A file with `bytes` in the folder of `path`, which goes away unless it is renamed.
fn beside(path: &Path, bytes: &[u8]) -> Result<NamedTempFile> {
    let mut file = temporary(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

/// An empty file in the folder of `path`, which goes away unless it is renamed.
fn temporary(path: &Path) -> Result<NamedTempFile> {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // Temporary files are private by default; a figure is an ordinary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.prefix(".partial").tempfile_in(folder)
}
