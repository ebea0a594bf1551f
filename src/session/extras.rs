//! What travels with a session beside header and ticks: the mesh, calibrations, facts of the machine.

use super::SessionError;
use super::format;
use super::header::Header;
use super::records::wire_error;
use super::wire::{self, WireError};
use mcap::records::{Metadata, op};
use mcap::{Attachment, McapResult, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// What a session may carry beside what every session has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Extras {
    /// The mesh file that the surface was made from, as it was; `None` for a built-in surface, which needs none.
    pub mesh: Option<Arc<[u8]>>,
    /// How each finger's device was calibrated, in its own words; empty where it says nothing.
    pub calibrations: Vec<String>,
    /// Facts of the machine that recorded it, clock first: keys `clock`, `clock_step_ns`, `os`, `arch`, `cores`.
    pub host: BTreeMap<String, String>,
}

impl Extras {
    /// No mesh and no calibration; the facts of the machine at hand.
    pub fn of_this_machine() -> Self {
        let clock = if cfg!(target_os = "linux") {
            "CLOCK_MONOTONIC"
        } else {
            "monotonic"
        };
        let cores = std::thread::available_parallelism().map_or(0, usize::from);
        let facts = [
            ("clock", clock.to_owned()),
            ("clock_step_ns", clock_step_ns().to_string()),
            ("os", std::env::consts::OS.to_owned()),
            ("arch", std::env::consts::ARCH.to_owned()),
            ("cores", cores.to_string()),
        ];
        Self {
            host: facts.map(|(key, value)| (key.to_owned(), value)).into(),
            ..Self::default()
        }
    }

    /// As they are, and the mesh file of a surface that is not built in: `origin` as [`MeshSource`](super::MeshSource) has it, a
    /// path in the scenario's `folder`.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn with_mesh_of(self, origin: &str, folder: Option<&Path>) -> Result<Self, SessionError> {
        if is_builtin(origin) {
            return Ok(self);
        }
        let path = &folder.unwrap_or(Path::new("")).join(origin);
        let bytes = std::fs::read(path).map_err(|e| wire_error(path, WireError::Io(e)))?;
        Ok(Self {
            mesh: Some(bytes.into()),
            ..self
        })
    }

    /// Writes them: before all else.
    pub(super) fn write<W: Write + Seek>(
        &self,
        mcap: &mut Writer<W>,
        header: &Header,
        started_ns: u64,
    ) -> McapResult<()> {
        if !self.host.is_empty() {
            mcap.write_metadata(&Metadata {
                name: format::HOST_METADATA.into(),
                metadata: self.host.clone(),
            })?;
        }
        let said = (0..).zip(&self.calibrations);
        let said = said.filter(|(_, text)| !text.is_empty());
        let said: BTreeMap<_, _> = said
            .map(|(i, text): (usize, _)| (calibration_key(i), text.clone()))
            .collect();
        if !said.is_empty() {
            mcap.write_metadata(&Metadata {
                name: format::CALIBRATION_METADATA.into(),
                metadata: said,
            })?;
        }
        // A built-in surface needs none; one that is carried is that of another scene.
        if let Some(mesh) = self
            .mesh
            .as_ref()
            .filter(|_| !is_builtin(&header.mesh.origin))
        {
            mcap.attach(&Attachment {
                log_time: started_ns,
                create_time: started_ns,
                name: format::MESH.into(),
                media_type: "application/octet-stream".into(),
                data: (&**mesh).into(),
            })?;
        }
        Ok(())
    }

    /// Reads them from the records before the first chunk.
    pub(super) fn read(path: &Path, header: &Header) -> Result<Self, SessionError> {
        let mut extras = Self::default();
        let file = File::open(path).map_err(|e| wire_error(path, WireError::Io(e)))?;
        let mut file = BufReader::new(file);
        let mut at = mcap::MAGIC.len() as u64;
        while let Ok((opcode, length)) = wire::prefix_at(&mut file, at) {
            if opcode == op::CHUNK {
                break;
            }
            if matches!(opcode, op::METADATA | op::ATTACHMENT) {
                match wire::record_at(&mut file, at) {
                    Ok((opcode, record)) => extras.take(opcode, &record, header.n_fingers()),
                    Err(WireError::Io(e)) => return Err(wire_error(path, WireError::Io(e))),
                    Err(WireError::Damaged(..)) => break,
                }
            }
            at = match at.checked_add(wire::PREFIX as u64 + length) {
                Some(next) if length > 0 => next,
                _ => break,
            };
        }
        Ok(extras)
    }

    fn take(&mut self, opcode: u8, record: &[u8], n_fingers: usize) {
        if opcode == op::ATTACHMENT {
            if let Ok((name, data)) = wire::attachment(record)
                && name == format::MESH
            {
                self.mesh = Some(data.into());
            }
            return;
        }
        match wire::metadata(record) {
            Ok((name, entries)) if name == format::HOST_METADATA => self.host = entries,
            Ok((name, entries)) if name == format::CALIBRATION_METADATA => {
                let said = (0..n_fingers).map(|i| entries.get(&calibration_key(i)).cloned());
                self.calibrations = said.map(Option::unwrap_or_default).collect();
            }
            _ => {}
        }
    }
}

/// The folder in which the scenario of a session finds its mesh.
#[derive(Debug)]
pub enum Folder {
    /// That of the session file.
    Beside(PathBuf),
    /// One with the mesh that travelled with the session; gone once this is dropped.
    Unpacked(tempfile::TempDir),
}

impl Folder {
    /// Where it is.
    pub fn path(&self) -> &Path {
        match self {
            Self::Beside(path) => path,
            Self::Unpacked(folder) => folder.path(),
        }
    }

    /// The folder of a session: that of its file, unless its mesh is not there, or another one by now, and has travelled with it.
    pub(super) fn of(path: &Path, header: &Header) -> Result<Self, SessionError> {
        let beside = path.parent().unwrap_or(Path::new("")).to_owned();
        let origin = Path::new(&header.mesh.origin);
        let mut parts = origin.components();
        let plain = parts.all(|c| matches!(c, Component::Normal(_)));
        if is_builtin(&header.mesh.origin) || !plain {
            return Ok(Self::Beside(beside));
        }
        let Some(mesh) = Extras::read(path, header)?.mesh else {
            return Ok(Self::Beside(beside));
        };
        if std::fs::read(beside.join(origin)).is_ok_and(|there| there == *mesh) {
            return Ok(Self::Beside(beside));
        }
        let unpack = || {
            let folder = tempfile::tempdir()?;
            let file = folder.path().join(origin);
            std::fs::create_dir_all(file.parent().unwrap_or(folder.path()))?;
            std::fs::write(file, &mesh)?;
            Ok(folder)
        };
        let folder = unpack().map_err(|e| wire_error(path, WireError::Io(e)))?;
        Ok(Self::Unpacked(folder))
    }
}

fn is_builtin(origin: &str) -> bool {
    origin.starts_with("builtin:")
}

fn calibration_key(finger: usize) -> String {
    format!("finger.{finger}.calibration")
}

/// The least step of the clock that ticks are timed by, as seen here, ns.
fn clock_step_ns() -> u128 {
    use std::time::Instant;
    let step = |_| {
        let began = Instant::now();
        loop {
            let step = began.elapsed().as_nanos();
            if step > 0 {
                return step;
            }
        }
    };
    (0..16).map(step).min().unwrap_or(0)
}
