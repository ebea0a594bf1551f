//! Meshes from and to files, one format per file.
//!
//! A file is read whole, then handed to the parser of its format. What the parsers trust and we do not (counts in a
//! header, lengths of lists) is checked against the size of the file first.

mod obj;
pub mod ply;
mod polygon;
mod stl;
mod units_found;

use super::RawMesh;
use crate::units::LengthUnit;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use units_found::{UnitsFound, UnitsSource};

/// The largest file that is read, bytes.
pub const MAX_FILE_BYTES: u64 = 4 << 30;

/// Formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// PLY, ascii or binary of either byte order.
    Ply,
    /// STL, ascii or binary.
    Stl,
}

impl Format {
    /// The format that files with this extension usually have.
    pub fn from_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }

    /// The format the content has by its first bytes.
    fn from_content(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            Some(Self::Ply)
        } else if stl::is_binary(bytes) || stl::is_ascii(bytes) {
            Some(Self::Stl)
        } else if obj::is_obj(bytes) {
            Some(Self::Obj)
        } else {
            None
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        }
    }
}

/// Why a mesh file could not be read. One line that ends with the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("cannot read the mesh: {cause}: {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: String,
    },
    /// The file is larger than [`MAX_FILE_BYTES`].
    #[error("the mesh file has {bytes} bytes; at most {MAX_FILE_BYTES} are read: {}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// The content is not a mesh.
    #[error("{cause}: {}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        cause: ParseError,
    },
}

/// Why bytes are not a mesh. One line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseError {
    /// Neither extension nor content tells a format.
    #[error("neither an OBJ, a PLY nor an STL mesh: it begins with \"{start}\"")]
    UnknownFormat {
        /// Its first bytes.
        start: String,
    },
    /// The content breaks the rules of its format.
    #[error("not a sound {} mesh: {what}", format.name())]
    Malformed {
        /// The format it was read as.
        format: Format,
        /// Where and what.
        what: String,
    },
}

/// Reads a mesh file into mm. The content decides the format, the extension where the content does not.
///
/// `units` are those of the file where they are known; else the file may name them, else they are guessed by the size of
/// the mesh, see [`UnitsFound`].
///
/// # Errors
/// The file cannot be read, is no mesh, or is damaged.
pub fn read(path: &Path, units: Option<LengthUnit>) -> Result<(RawMesh, UnitsFound), ReadError> {
    let io = |cause: std::io::Error| ReadError::Io {
        path: path.to_path_buf(),
        cause: cause.to_string(),
    };
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(io(std::io::Error::other("not a file")));
    }
    let too_large = |bytes| ReadError::TooLarge {
        path: path.to_path_buf(),
        bytes,
    };
    if metadata.len() > MAX_FILE_BYTES {
        return Err(too_large(metadata.len()));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize + 1);
    let read = file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes);
    if read.map_err(io)? as u64 > MAX_FILE_BYTES {
        return Err(too_large(bytes.len() as u64));
    }
    parse(bytes, Format::from_extension(path), units).map_err(|cause| ReadError::Content {
        path: path.to_path_buf(),
        cause,
    })
}

/// Reads a mesh from the bytes of a file; see [`read`]. `expected` is the format to assume where the content does not tell.
///
/// # Errors
/// The bytes are no mesh, or a damaged one.
pub fn parse(
    bytes: Vec<u8>,
    expected: Option<Format>,
    units: Option<LengthUnit>,
) -> Result<(RawMesh, UnitsFound), ParseError> {
    let Some(format) = Format::from_content(&bytes).or(expected) else {
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(24)]).into_owned();
        return Err(ParseError::UnknownFormat {
            start: one_line(&start),
        });
    };
    let parsed = match format {
        Format::Obj => obj::parse(&bytes).map(|mesh| (mesh, None)),
        Format::Ply => ply::parse(&bytes),
        Format::Stl => stl::parse(bytes).map(|mesh| (mesh, None)),
    };
    let (mut mesh, in_file) = parsed.map_err(|what| ParseError::Malformed {
        format,
        what: one_line(&what),
    })?;
    let found = UnitsFound::of(&mesh, units, in_file);
    if found.unit != LengthUnit::Mm {
        for p in &mut mesh.positions {
            *p *= found.unit.in_mm();
        }
    }
    Ok((mesh, found))
}

/// Printable, on one line and not too long, whatever a damaged file or a parser puts into a message.
fn one_line(text: &str) -> String {
    const LONGEST: usize = 160;
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() {
            line.push(' ');
        }
        line.extend(
            word.chars()
                .map(|c| if c.is_control() { '\u{fffd}' } else { c }),
        );
        if line.chars().count() > LONGEST {
            return line.chars().take(LONGEST).chain(['…']).collect();
        }
    }
    line
}
