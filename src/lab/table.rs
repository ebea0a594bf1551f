//! Tables whose columns say what they hold and in which unit.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What a cell holds. As JSON: nothing is `null`, the others are themselves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Nothing: the figure does not exist for this row.
    #[default]
    Empty,
    /// A count.
    Integer(i64),
    /// A measure; always finite where it came through [`From`].
    Number(f64),
    /// A name.
    Text(String),
}

impl Value {
    /// As shown to people: a number with four significant digits, a dash for nothing.
    pub fn short(&self) -> String {
        match self {
            Self::Empty => "–".to_owned(),
            Self::Number(x) => significant(*x),
            other => other.to_string(),
        }
    }

    /// The number in the cell, where there is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Integer(i) => Some(*i as f64),
            Self::Number(x) => Some(*x),
            Self::Empty | Self::Text(_) => None,
        }
    }
}

impl From<f64> for Value {
    /// What is not finite is nothing: neither JSON nor a reader of CSV can hold it.
    fn from(x: f64) -> Self {
        if x.is_finite() {
            Self::Number(x)
        } else {
            Self::Empty
        }
    }
}

impl From<usize> for Value {
    fn from(n: usize) -> Self {
        i64::try_from(n).map_or(Self::Number(n as f64), Self::Integer)
    }
}

impl From<u32> for Value {
    fn from(n: u32) -> Self {
        Self::Integer(n.into())
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Value>> From<Option<T>> for Value {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

impl fmt::Display for Value {
    /// As in a CSV file: a number with as many digits as bring it back bit for bit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Integer(i) => i.fmt(f),
            Self::Number(x) => x.fmt(f),
            Self::Text(text) => text.fmt(f),
        }
    }
}

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Its name, as `gather`.
    pub name: String,
    /// The unit of its numbers, as `µs`; empty for names and counts.
    pub unit: String,
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.unit.is_empty() {
            write!(f, "{}", self.name)
        } else {
            write!(f, "{} ({})", self.name, self.unit)
        }
    }
}

/// A table: every row has as many cells as there are columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Name in file names: lower case and hyphens.
    pub name: String,
    /// What it shows, in a line.
    pub title: String,
    columns: Vec<Column>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    /// A table without rows; columns are `name` or `name (unit)`.
    pub fn new(name: &str, title: impl Into<String>, columns: &[&str]) -> Self {
        let column = |text: &&str| {
            let (name, unit) = text
                .strip_suffix(')')
                .and_then(|t| t.rsplit_once(" ("))
                .unwrap_or((text, ""));
            Column {
                name: name.to_owned(),
                unit: unit.to_owned(),
            }
        };
        Self {
            name: name.to_owned(),
            title: title.into(),
            columns: columns.iter().map(column).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; cells that are missing are empty, those too many are dropped.
    pub fn push(&mut self, row: impl IntoIterator<Item = Value>) {
        let mut row: Vec<Value> = row.into_iter().collect();
        debug_assert_eq!(row.len(), self.columns.len(), "{}", self.name);
        row.resize(self.columns.len(), Value::Empty);
        self.rows.push(row);
    }

    /// What the columns hold.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The rows.
    pub fn rows(&self) -> &[Vec<Value>] {
        &self.rows
    }

    /// The cell of a row in the column called `name`; nothing where there is none.
    pub fn cell(&self, row: usize, name: &str) -> &Value {
        let at = self.columns.iter().position(|c| c.name == name);
        at.and_then(|at| self.rows.get(row)?.get(at))
            .unwrap_or(&Value::Empty)
    }

    /// The table as CSV with one line of headings (RFC 4180, UTF-8).
    ///
    /// # Errors
    /// None that is known: those of the writer, which writes to memory here.
    pub fn csv(&self) -> std::io::Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(self.columns.iter().map(Column::to_string))?;
        for row in &self.rows {
            writer.write_record(row.iter().map(Value::to_string))?;
        }
        writer.into_inner().map_err(|e| e.into_error())
    }
}

impl fmt::Display for Table {
    /// Aligned for people: numbers to the right with four significant digits, names to the left.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown: Vec<Vec<String>> = self
            .rows
            .iter()
            .map(|r| r.iter().map(Value::short).collect())
            .collect();
        let is_text = |i: usize| self.rows.iter().any(|r| matches!(r[i], Value::Text(_)));
        let wide = |text: &str| text.chars().count();
        let columns: Vec<(usize, bool)> = (0..self.columns.len())
            .map(|i| {
                let column = &self.columns[i];
                let heads = [wide(&column.name), wide(&column.unit)];
                let cells = shown.iter().map(|r| wide(&r[i]));
                (
                    heads.into_iter().chain(cells).max().unwrap_or(0),
                    is_text(i),
                )
            })
            .collect();
        let mut line = |cells: &mut dyn Iterator<Item = &str>| {
            let mut text = String::from(" ");
            for (cell, &(width, left)) in cells.zip(&columns) {
                text.push_str(&match left {
                    true => format!(" {cell:<width$} "),
                    false => format!(" {cell:>width$} "),
                });
            }
            writeln!(f, "{}", text.trim_end())
        };
        line(&mut self.columns.iter().map(|c| c.name.as_str()))?;
        if self.columns.iter().any(|c| !c.unit.is_empty()) {
            line(&mut self.columns.iter().map(|c| c.unit.as_str()))?;
        }
        for row in &shown {
            line(&mut row.iter().map(String::as_str))?;
        }
        Ok(())
    }
}

/// Four significant digits, without an exponent where the number is between a millionth and a million.
pub(crate) fn significant(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let power = libm::floor(libm::log10(x.abs()));
    if !(-6.0..6.0).contains(&power) {
        return format!("{x:.3e}");
    }
    format!("{x:.*}", (3.0 - power).max(0.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.012_344, "0.01234"),
            (-1.0, "-1.000"),
            (12_345.6, "12346"),
            (2.5e7, "2.500e7"),
            (3.0e-9, "3.000e-9"),
        ] {
            assert_eq!(significant(x), text);
        }
    }
}
