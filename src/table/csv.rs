//! Tables as CSV.

use super::{Cell, Head, Result, Rows, misfit};
use std::io::Write;

/// Writes a table as CSV (RFC 4180, line feeds): a line of names, then the rows; nothing stands for what is absent.
///
/// Numbers have as many digits as bring them back bit for bit. Readers that cut digits must be told: older versions of pandas
/// by `float_precision="round_trip"`.
pub struct CsvRows<W: Write> {
    writer: csv::Writer<W>,
    heads: Vec<Head>,
}

impl<W: Write> CsvRows<W> {
    /// Begins a table with the line of its names.
    ///
    /// # Errors
    /// Those of `into`.
    pub fn new(into: W, heads: &[Head]) -> Result<Self> {
        let mut writer = csv::Writer::from_writer(into);
        writer.write_record(heads.iter().map(|h| &*h.name))?;
        Ok(Self {
            writer,
            heads: heads.to_vec(),
        })
    }

    /// Writes what is still held back and gives the file back.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn into_inner(self) -> Result<W> {
        self.writer
            .into_inner()
            .map_err(csv::IntoInnerError::into_error)
    }
}

impl<W: Write> Rows for CsvRows<W> {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<()> {
        if let Some(error) = misfit(&self.heads, cells) {
            return Err(error);
        }
        for cell in cells {
            match cell {
                Cell::Number(Some(x)) => self.writer.write_field(number_text(*x))?,
                Cell::Single(Some(x)) => self.writer.write_field(format!("{x:?}"))?,
                Cell::Count(Some(n)) => self.writer.write_field(n.to_string())?,
                Cell::Yes(Some(true)) => self.writer.write_field("true")?,
                Cell::Yes(Some(false)) => self.writer.write_field("false")?,
                Cell::Text(Some(text)) => self.writer.write_field(&**text)?,
                _ => self.writer.write_field("")?,
            }
        }
        Ok(self.writer.write_record(None::<&[u8]>)?)
    }

    fn finish(&mut self) -> Result<()> {
        self.writer.flush()
    }
}

/// The fewest digits that read back to the same bits, always with a point or an exponent: whoever guesses what a column holds
/// takes it for numbers, and not for integers that know no `-0`.
pub fn number_text(x: f64) -> String {
    format!("{x:?}")
}
