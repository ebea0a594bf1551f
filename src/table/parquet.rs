//! Tables as Parquet.
//!
//! Zstd everywhere. Doubles are written plain, not byte-stream-split: engines in use cannot read that encoding, Spark's
//! vectorised reader among them until lately, and on ticks of a moving finger it saves a fifth at most. Clocks are
//! delta-packed, all else goes by dictionary.
//!
//! Units and meanings stand in the key-value metadata of the file as `unit.NAME` and `about.NAME`.

use super::{Cell, Head, Result, Rows, Sort, misfit};
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{
    BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type,
};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};
use std::io::{Error, Write};
use std::sync::Arc;

/// Rows that are held in memory before they are written as one row group.
pub const ROWS_PER_GROUP: usize = 65_536;

/// Writes a table as Parquet, a row group at a time: memory does not grow with its length.
pub struct ParquetRows<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    heads: Vec<Head>,
    columns: Vec<Column>,
    rows: usize,
}

/// The cells of a column that are there, and for every row whether it is.
struct Column {
    values: Values,
    levels: Vec<i16>,
}

enum Values {
    Number(Vec<f64>),
    Single(Vec<f32>),
    Count(Vec<i64>),
    Yes(Vec<bool>),
    Text(Vec<ByteArray>),
}

impl<W: Write + Send> ParquetRows<W> {
    /// Begins a table. `notes` join its key-value metadata.
    ///
    /// # Errors
    /// Those of `into`, and two columns of one name.
    pub fn new(into: W, heads: &[Head], notes: &[(&str, String)]) -> Result<Self> {
        let begun = || -> std::result::Result<_, ParquetError> {
            let fields = heads.iter().map(|h| Ok(Arc::new(field(h)?)));
            let schema = Type::group_type_builder("table")
                .with_fields(fields.collect::<std::result::Result<_, ParquetError>>()?)
                .build()?;
            let properties = Arc::new(properties(heads, notes)?);
            SerializedFileWriter::new(into, Arc::new(schema), properties)
        };
        Ok(Self {
            writer: begun().map_err(told)?,
            heads: heads.to_vec(),
            columns: heads.iter().map(|h| Column::new(h.sort)).collect(),
            rows: 0,
        })
    }

    /// Writes what is still held back and gives the file back.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn into_inner(mut self) -> Result<W> {
        if self.rows > 0 {
            self.write_group().map_err(told)?;
        }
        self.writer.into_inner().map_err(told)
    }

    fn write_group(&mut self) -> std::result::Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for (column, head) in self.columns.iter_mut().zip(&self.heads) {
            let Some(mut into) = group.next_column()? else {
                break;
            };
            column.put(&mut into, head.optional)?;
            into.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

impl<W: Write + Send> Rows for ParquetRows<W> {
    fn row(&mut self, cells: &[Cell<'_>]) -> Result<()> {
        if let Some(error) = misfit(&self.heads, cells) {
            return Err(error);
        }
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.push(cell);
        }
        self.rows += 1;
        if self.rows == ROWS_PER_GROUP {
            self.write_group().map_err(told)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        if self.rows > 0 {
            self.write_group().map_err(told)?;
        }
        self.writer.finish().map_err(told)?;
        self.writer.inner_mut().flush()
    }
}

fn told(error: ParquetError) -> Error {
    match error {
        ParquetError::External(source) => match source.downcast::<Error>() {
            Ok(io) => *io,
            Err(source) => Error::other(source),
        },
        other => Error::other(other),
    }
}

fn field(head: &Head) -> std::result::Result<Type, ParquetError> {
    let (physical, logical) = match head.sort {
        Sort::Number => (Physical::DOUBLE, None),
        Sort::Single => (Physical::FLOAT, None),
        Sort::Count | Sort::Clock => (Physical::INT64, None),
        Sort::Yes => (Physical::BOOLEAN, None),
        Sort::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&head.name, physical)
        .with_repetition(match head.optional {
            true => Repetition::OPTIONAL,
            false => Repetition::REQUIRED,
        })
        .with_logical_type(logical)
        .build()
}

fn properties(
    heads: &[Head],
    notes: &[(&str, String)],
) -> std::result::Result<WriterProperties, ParquetError> {
    let mut metadata: Vec<KeyValue> = notes
        .iter()
        .map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()))
        .collect();
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("dorsum version ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_statistics_enabled(EnabledStatistics::Chunk);
    for head in heads {
        let path = ColumnPath::from(&*head.name);
        for (key, value) in [("unit", &head.unit), ("about", &head.about)] {
            if !value.is_empty() {
                metadata.push(KeyValue::new(
                    format!("{key}.{}", head.name),
                    value.to_string(),
                ));
            }
        }
        let encoding = match head.sort {
            Sort::Number | Sort::Single => Encoding::PLAIN,
            Sort::Clock => Encoding::DELTA_BINARY_PACKED,
            Sort::Count | Sort::Yes | Sort::Text => continue,
        };
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, encoding);
    }
    Ok(properties.set_key_value_metadata(Some(metadata)).build())
}

impl Column {
    fn new(sort: Sort) -> Self {
        Self {
            values: match sort {
                Sort::Number => Values::Number(Vec::new()),
                Sort::Single => Values::Single(Vec::new()),
                Sort::Count | Sort::Clock => Values::Count(Vec::new()),
                Sort::Yes => Values::Yes(Vec::new()),
                Sort::Text => Values::Text(Vec::new()),
            },
            levels: Vec::new(),
        }
    }

    fn push(&mut self, cell: &Cell<'_>) {
        fn there<T>(values: &mut Vec<T>, value: Option<T>) -> bool {
            let is = value.is_some();
            values.extend(value);
            is
        }
        let is = match (&mut self.values, cell) {
            (Values::Number(values), Cell::Number(x)) => there(values, *x),
            (Values::Single(values), Cell::Single(x)) => there(values, *x),
            (Values::Count(values), Cell::Count(n)) => there(values, *n),
            (Values::Yes(values), Cell::Yes(yes)) => there(values, *yes),
            (Values::Text(values), Cell::Text(text)) => {
                there(values, text.as_deref().map(ByteArray::from))
            }
            _ => false,
        };
        self.levels.push(i16::from(is));
    }

    /// Writes all that is held and forgets it.
    fn put(
        &mut self,
        into: &mut SerializedColumnWriter<'_>,
        optional: bool,
    ) -> std::result::Result<(), ParquetError> {
        fn batch<T: DataType>(
            into: &mut SerializedColumnWriter<'_>,
            values: &mut Vec<T::T>,
            levels: Option<&[i16]>,
        ) -> std::result::Result<(), ParquetError> {
            into.typed::<T>().write_batch(values, levels, None)?;
            values.clear();
            Ok(())
        }
        let levels = optional.then_some(&self.levels[..]);
        match &mut self.values {
            Values::Number(values) => batch::<DoubleType>(into, values, levels),
            Values::Single(values) => batch::<FloatType>(into, values, levels),
            Values::Count(values) => batch::<Int64Type>(into, values, levels),
            Values::Yes(values) => batch::<BoolType>(into, values, levels),
            Values::Text(values) => batch::<ByteArrayType>(into, values, levels),
        }?;
        self.levels.clear();
        Ok(())
    }
}
