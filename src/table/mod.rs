//! Tables with typed columns, row by row into a file: CSV or Parquet from the same cells.
//!
//! | file | gives |
//! |---|---|
//! | `parquet` | columns in row groups of bounded size, zstd, with statistics and units |
//! | `csv` | one line a row, numbers that read back bit for bit |
//!
//! A table is told by its [`Head`]s; each row then has one [`Cell`] a column, of the sort that the head says or absent. What is
//! written never depends on how many rows there are: a table of no rows has the same columns.

mod csv;
mod parquet;

pub use csv::{CsvRows, number_text};
pub use parquet::{ParquetRows, ROWS_PER_GROUP};

use std::borrow::Cow;
use std::io::{Error, ErrorKind, Result};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sort {
    /// `f64`.
    Number,
    /// `f32`.
    Single,
    /// `i64`: engines that know no unsigned integers read it too.
    Count,
    /// `i64` that mostly grows by the same step, such as a clock.
    Clock,
    /// `bool`.
    Yes,
    /// UTF-8.
    Text,
}

/// What a cell holds; `None`: nothing.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell<'a> {
    /// A number, as it is: not finite ones too.
    Number(Option<f64>),
    /// A number of single precision.
    Single(Option<f32>),
    /// A count or a clock.
    Count(Option<i64>),
    /// Yes or no.
    Yes(Option<bool>),
    /// A name.
    Text(Option<Cow<'a, str>>),
}

impl<'a> Cell<'a> {
    /// A number; nothing where it is not finite.
    pub fn number(x: Option<f64>) -> Self {
        Self::Number(x.filter(|x| x.is_finite()))
    }

    /// A count.
    pub fn count(n: Option<impl Into<i64>>) -> Self {
        Self::Count(n.map(Into::into))
    }

    /// A count of any width; nothing where it is above what `i64` holds.
    pub fn natural(n: u64) -> Self {
        Self::Count(i64::try_from(n).ok())
    }

    /// A name.
    pub fn text(text: impl Into<Cow<'a, str>>) -> Self {
        Self::Text(Some(text.into()))
    }

    fn is_there(&self) -> bool {
        match self {
            Self::Number(x) => x.is_some(),
            Self::Single(x) => x.is_some(),
            Self::Count(n) => n.is_some(),
            Self::Yes(yes) => yes.is_some(),
            Self::Text(text) => text.is_some(),
        }
    }

    fn sort(&self) -> Sort {
        match self {
            Self::Number(_) => Sort::Number,
            Self::Single(_) => Sort::Single,
            Self::Count(_) => Sort::Count,
            Self::Yes(_) => Sort::Yes,
            Self::Text(_) => Sort::Text,
        }
    }
}

/// A column: what it is called and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Name; carries the unit.
    pub name: Cow<'static, str>,
    /// What its cells hold.
    pub sort: Sort,
    /// Whether a cell may be absent.
    pub optional: bool,
    /// Unit, empty where there is none.
    pub unit: Cow<'static, str>,
    /// What it means, one line; empty where the name says it.
    pub about: Cow<'static, str>,
}

impl Head {
    /// A column whose cells may be absent.
    pub fn new(name: impl Into<Cow<'static, str>>, sort: Sort) -> Self {
        Self {
            name: name.into(),
            sort,
            optional: true,
            unit: Cow::Borrowed(""),
            about: Cow::Borrowed(""),
        }
    }

    /// The same with every cell there.
    #[must_use]
    pub fn required(self) -> Self {
        Self {
            optional: false,
            ..self
        }
    }

    /// The same in a unit.
    #[must_use]
    pub fn unit(self, unit: impl Into<Cow<'static, str>>) -> Self {
        let unit = unit.into();
        Self { unit, ..self }
    }

    /// The same with what it means.
    #[must_use]
    pub fn about(self, about: impl Into<Cow<'static, str>>) -> Self {
        let about = about.into();
        Self { about, ..self }
    }

    /// Whether `cell` may stand in this column.
    fn takes(&self, cell: &Cell<'_>) -> bool {
        let sort = match self.sort {
            Sort::Clock => Sort::Count,
            sort => sort,
        };
        cell.sort() == sort && (self.optional || cell.is_there())
    }
}

/// A table that is being written.
pub trait Rows {
    /// Writes a row: one cell a column.
    ///
    /// # Errors
    /// Those of the file system, and a row that does not fit its columns.
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<()>;

    /// Writes what is still held back; without it the file is not whole.
    ///
    /// # Errors
    /// Those of the file system.
    fn finish(&mut self) -> Result<()>;
}

/// A row that does not fit its columns.
fn misfit(heads: &[Head], cells: &[Cell<'_>]) -> Option<Error> {
    let refused = |what: String| Some(Error::new(ErrorKind::InvalidInput, what));
    if heads.len() != cells.len() {
        let (columns, cells) = (heads.len(), cells.len());
        return refused(format!("{cells} cells in a row of {columns} columns"));
    }
    let pairs = || heads.iter().zip(cells);
    let (head, cell) = pairs().find(|(head, cell)| !head.takes(cell))?;
    refused(format!(
        "column {} holds {:?}, not {cell:?}",
        head.name, head.sort
    ))
}

/// A small table in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Table<'a> {
    /// Its columns.
    pub heads: Vec<Head>,
    /// Its rows: one cell a column.
    pub rows: Vec<Vec<Cell<'a>>>,
}

impl Table<'_> {
    /// As CSV.
    ///
    /// # Errors
    /// A row that does not fit the columns.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.write(&mut CsvRows::new(&mut bytes, &self.heads)?)?;
        Ok(bytes)
    }

    /// As Parquet.
    ///
    /// # Errors
    /// A row that does not fit the columns.
    pub fn parquet(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.write(&mut ParquetRows::new(&mut bytes, &self.heads, &[])?)?;
        Ok(bytes)
    }

    fn write(&self, into: &mut dyn Rows) -> Result<()> {
        for row in &self.rows {
            into.row(row)?;
        }
        into.finish()
    }
}

#[cfg(test)]
mod tests;
