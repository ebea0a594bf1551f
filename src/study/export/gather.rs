//! The tables of a folder in one file each.

use super::key::unescaped;
use super::tables::TABLES;
use super::tree::{Part, file_name};
use super::{Format, Settings, failed, output};
use crate::study::StudyError;
use crate::table::{Cell, Head, Sort};
use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
use ::parquet::record::Field;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Puts each table but the ticks into one file at the top of the folder, of all sessions that are whole there, in the order of
/// participant and session, which become its first columns. One session is in memory at a time.
///
/// # Errors
/// The file system refuses, or a file below is not one of ours.
pub fn gather(settings: &Settings) -> Result<(), StudyError> {
    let (folder, format) = (&settings.folder, settings.format);
    let places = places(folder, format)?;
    for table in &TABLES {
        let own = (table.heads)();
        let mut heads = vec![
            Head::new("participant", Sort::Text).required(),
            Head::new("session", Sort::Text).required(),
        ];
        heads.extend(own.iter().cloned());
        let name = Path::new(table.name).with_extension(match format {
            Format::Csv => "csv",
            _ => "parquet",
        });
        let path = folder.join(name);
        let mut part = Part::new(&path, format, &heads, &[]).map_err(failed(&path))?;
        for (participant, session) in &places {
            let from = folder.join(table.name).join(participant).join(session);
            let from = from.join(file_name(format));
            let named = [participant, session].map(|name| {
                let value = name.split_once('=').map_or("", |(_, value)| value);
                Cell::text(unescaped(value))
            });
            let mut each = |cells: Vec<Cell<'static>>| {
                let row = [&named[..], &cells].concat();
                part.row(&row).map_err(failed(&path))
            };
            match format {
                Format::Csv => read_csv(&from, &own, &mut each)?,
                _ => read_parquet(&from, &own, &mut each)?,
            }
        }
        part.keep().map_err(failed(&path))?;
    }
    Ok(())
}

/// The folders of all sessions that are whole, participant by participant.
fn places(folder: &Path, format: Format) -> Result<Vec<(String, String)>, StudyError> {
    let sessions = folder.join("sessions");
    let mut places = Vec::new();
    for participant in folders(&sessions, "participant=")? {
        let below = sessions.join(&participant);
        for session in folders(&below, "session=")? {
            if below.join(&session).join(file_name(format)).exists() {
                places.push((participant.clone(), session));
            }
        }
    }
    Ok(places)
}

/// Names of the folders in `folder` that begin with `prefix`, in order; none where it is not there.
pub(super) fn folders(folder: &Path, prefix: &str) -> Result<Vec<String>, StudyError> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed(folder))? {
        let entry = entry.map_err(failed(folder))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(prefix) && entry.path().is_dir() {
            names.push(name);
        }
    }
    names.sort_unstable();
    Ok(names)
}

type Each<'a> = &'a mut dyn FnMut(Vec<Cell<'static>>) -> Result<(), StudyError>;

fn foreign(path: &Path) -> StudyError {
    output(
        path,
        &"its columns are not those of this version; write it anew with --force",
    )
}

fn read_parquet(path: &PathBuf, heads: &[Head], each: Each<'_>) -> Result<(), StudyError> {
    let told = |e: ::parquet::errors::ParquetError| output(path, &e);
    let file = File::open(path).map_err(failed(path))?;
    let reader = SerializedFileReader::new(file).map_err(told)?;
    let schema = reader.metadata().file_metadata().schema();
    let names = schema.get_fields().iter().map(|f| f.name());
    if !names.eq(heads.iter().map(|h| &*h.name)) {
        return Err(foreign(path));
    }
    for row in reader.get_row_iter(None).map_err(told)? {
        let row = row.map_err(told)?;
        let fields = row.get_column_iter().map(|(_, field)| field);
        let cells = fields
            .zip(heads)
            .map(|(field, head)| cell(field, head.sort));
        each(cells.collect::<Option<_>>().ok_or_else(|| foreign(path))?)?;
    }
    Ok(())
}

fn cell(field: &Field, sort: Sort) -> Option<Cell<'static>> {
    Some(match (sort, field) {
        (Sort::Number, Field::Null) => Cell::Number(None),
        (Sort::Number, Field::Double(x)) => Cell::Number(Some(*x)),
        (Sort::Single, Field::Null) => Cell::Single(None),
        (Sort::Single, Field::Float(x)) => Cell::Single(Some(*x)),
        (Sort::Count | Sort::Clock, Field::Null) => Cell::Count(None),
        (Sort::Count | Sort::Clock, Field::Long(n)) => Cell::Count(Some(*n)),
        (Sort::Yes, Field::Null) => Cell::Yes(None),
        (Sort::Yes, Field::Bool(yes)) => Cell::Yes(Some(*yes)),
        (Sort::Text, Field::Null) => Cell::Text(None),
        (Sort::Text, Field::Str(text)) => Cell::text(text.clone()),
        _ => return None,
    })
}

fn read_csv(path: &PathBuf, heads: &[Head], each: Each<'_>) -> Result<(), StudyError> {
    let told = |e: csv::Error| output(path, &e);
    let mut reader = csv::Reader::from_path(path).map_err(told)?;
    let names = reader.headers().map_err(told)?;
    if !names.iter().eq(heads.iter().map(|h| &*h.name)) {
        return Err(foreign(path));
    }
    for row in reader.records() {
        let row = row.map_err(told)?;
        let cells = row.iter().zip(heads).map(|(text, head)| {
            let there = Some(text).filter(|t| !t.is_empty());
            Some(match head.sort {
                Sort::Number => Cell::Number(parsed(there)?),
                Sort::Single => Cell::Single(parsed(there)?),
                Sort::Count | Sort::Clock => Cell::Count(parsed(there)?),
                Sort::Yes => Cell::Yes(parsed(there)?),
                Sort::Text => Cell::Text(there.map(|t| t.to_owned().into())),
            })
        });
        each(cells.collect::<Option<_>>().ok_or_else(|| foreign(path))?)?;
    }
    Ok(())
}

/// The value of a cell, `Some(None)` where it is absent; `None`: it has none that can be read.
fn parsed<T: std::str::FromStr>(text: Option<&str>) -> Option<Option<T>> {
    text.map(str::parse).transpose().ok()
}
