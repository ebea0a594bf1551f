//! One session into the folders of the tables.

use super::tables::{self, TABLES};
use super::{Exported, Format, Key, Settings, failed};
use crate::figure::Beside;
use crate::session::{Entry, Session, Strictness};
use crate::study::{StudyError, analyse};
use crate::table::{Cell, CsvRows, Head, ParquetRows, Rows};
use std::io::Result;
use std::path::{Path, PathBuf};

/// Version of the tables' layout, `dorsum.format` in every Parquet file.
const FORMAT: &str = "1";
/// Records between two words on progress.
const BETWEEN: u64 = 8192;

/// What the files of a table are called below their folders.
pub(super) fn file_name(format: Format) -> &'static str {
    match format {
        Format::Csv => "part-0.csv",
        _ => "part-0.parquet",
    }
}

/// A table's file under way.
pub(super) struct Part<'a> {
    path: &'a Path,
    rows: Writer,
}

enum Writer {
    Parquet(Box<ParquetRows<Beside>>),
    Csv(Box<CsvRows<Beside>>),
}

impl<'a> Part<'a> {
    pub(super) fn new(
        path: &'a Path,
        format: Format,
        heads: &[Head],
        notes: &[(&str, String)],
    ) -> Result<Self> {
        let into = Beside::new(path)?;
        let rows = match format {
            Format::Csv => Writer::Csv(Box::new(CsvRows::new(into, heads)?)),
            _ => {
                let format = [("dorsum.format", FORMAT.to_owned())];
                let notes = [&format, notes].concat();
                Writer::Parquet(Box::new(ParquetRows::new(into, heads, &notes)?))
            }
        };
        Ok(Self { path, rows })
    }

    pub(super) fn row(&mut self, cells: &[Cell<'_>]) -> Result<()> {
        match &mut self.rows {
            Writer::Parquet(rows) => rows.row(cells),
            Writer::Csv(rows) => rows.row(cells),
        }
    }

    /// Puts the file in its place and tells its size.
    pub(super) fn keep(self) -> Result<u64> {
        match self.rows {
            Writer::Parquet(rows) => rows.into_inner()?.keep()?,
            Writer::Csv(rows) => rows.into_inner()?.keep()?,
        }
        Ok(std::fs::metadata(self.path)?.len())
    }
}

/// Writes the tables of a session, that of sessions last.
pub(super) fn write(
    session: &Session,
    key: &Key,
    settings: &Settings,
    progress: &mut dyn FnMut(f64) -> bool,
) -> std::result::Result<Exported, StudyError> {
    let format = settings.format;
    let place = key.place();
    let path_of = |table: &str| -> PathBuf {
        let folder = settings.folder.join(table).join(&place);
        folder.join(file_name(format))
    };
    let mut exported = Exported::new(key);
    if path_of("sessions").exists() && !settings.force {
        exported.skipped = true;
        progress(1.0);
        return Ok(exported);
    }
    let header = session.header();
    let notes = [
        ("dorsum.scenario", header.scenario_name.clone()),
        ("dorsum.started_utc", header.started_utc.clone()),
        ("dorsum.build", header.build.clone()),
        ("dorsum.rate_hz", header.rate_hz.to_string()),
        ("dorsum.mesh_sha256", header.mesh.hash.clone()),
    ];
    let names = ["ticks"].into_iter().chain(TABLES.iter().map(|t| t.name));
    let paths: Vec<PathBuf> = names.map(path_of).collect();
    let [ticks, events, felt, measures, sessions] = &paths[..] else {
        unreachable!("a path for each table");
    };
    for folder in paths.iter().filter_map(|p| p.parent()) {
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
    }
    // While it is replaced it is not whole.
    if sessions.exists() {
        std::fs::remove_file(sessions).map_err(failed(sessions))?;
    }
    let part = |path, heads: &[Head]| Part::new(path, format, heads, &notes).map_err(failed(path));
    let mut tick_part = part(ticks, &tables::tick_heads())?;
    let mut event_part = part(events, &(TABLES[0].heads)())?;
    let mut entries = session.entries(Strictness::Lenient)?;
    let mut cells = Vec::new();
    let mut n = 0_u64;
    while let Some(entry) = entries.next() {
        match entry? {
            Entry::Tick(record) => {
                tables::tick_cells(&record, &mut cells);
                // Clocks beyond what 63 bits hold: no recorder writes them.
                if cells.contains(&Cell::Count(None)) {
                    exported.left_out += 1;
                    continue;
                }
                tick_part.row(&cells).map_err(failed(ticks))?;
                exported.rows += 1;
            }
            Entry::Event(event) => {
                let cells = tables::event_cells(&event);
                event_part.row(&cells).map_err(failed(events))?;
            }
            Entry::Edit(_) => {}
        }
        n += 1;
        if n.is_multiple_of(BETWEEN) && !progress(0.6 * entries.progress()) {
            return Err(StudyError::Stopped);
        }
    }
    exported.damage = entries.damage().clone();
    exported.bytes += tick_part.keep().map_err(failed(ticks))?;
    exported.bytes += event_part.keep().map_err(failed(events))?;
    let analysis = analyse(session, &settings.options, &mut |share| {
        progress(0.6 + 0.4 * share)
    })?;
    let small = [
        (felt, 1, tables::felt_rows(&analysis)),
        (measures, 2, tables::measure_rows(&analysis)),
        (sessions, 3, vec![tables::session_cells(&analysis)]),
    ];
    for (path, table, rows) in small {
        let mut part = part(path, &(TABLES[table].heads)())?;
        for row in &rows {
            part.row(row).map_err(failed(path))?;
        }
        exported.bytes += part.keep().map_err(failed(path))?;
    }
    Ok(exported)
}
