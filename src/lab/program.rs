//! Which program is running.

use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Digits of a build's name.
const DIGITS: usize = 12;

/// First 12 hexadecimal digits of the SHA-256 of the running executable; nothing where it cannot be read. It is read once.
pub fn build() -> Option<&'static str> {
    static BUILD: OnceLock<Option<String>> = OnceLock::new();
    BUILD
        .get_or_init(|| {
            let mut digits = hexadecimal(&sha256_of(&executable()?).ok()?);
            digits.truncate(DIGITS);
            Some(digits)
        })
        .as_deref()
}

/// The file that this process runs.
fn executable() -> Option<PathBuf> {
    // On Linux this leads to the running program also after its file was replaced, as a path does not.
    let running = Path::new("/proc/self/exe");
    if running.exists() {
        return Some(running.to_owned());
    }
    std::env::current_exe().ok()
}

/// SHA-256 of a file, read piece by piece.
pub(super) fn sha256_of(path: &Path) -> std::io::Result<[u8; 32]> {
    let mut hasher = HashWriter(Sha256::new());
    std::io::copy(&mut std::fs::File::open(path)?, &mut hasher)?;
    Ok(hasher.0.finalize().into())
}

struct HashWriter(Sha256);

impl std::io::Write for HashWriter {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Lower-case hexadecimal.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_build_is_twelve_digits_and_stays_the_same() {
        let digits = build().expect("the test itself can be read");
        assert_eq!(digits.len(), DIGITS);
        assert!(digits.chars().all(|c| c.is_ascii_hexdigit()));
        assert_eq!(build(), Some(digits));
    }

    #[test]
    fn files_are_hashed_as_published() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").expect("written");
        // FIPS 180-4, the example of one block.
        assert_eq!(
            hexadecimal(&sha256_of(&path).expect("read")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        assert!(sha256_of(&folder.path().join("none")).is_err());
    }
}
