//! Tables as Parquet: one row group, plain columns, absent cells null.

use super::table::{Cell, Column, Table};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::sync::Arc;

/// The table as the bytes of a file.
///
/// # Errors
/// Those of the library, none of which is known to come: it writes to memory.
pub fn bytes(table: &Table) -> Result<Vec<u8>, ParquetError> {
    let fields = table.columns.iter().map(|c| Ok(Arc::new(field(c)?)));
    let schema = Type::group_type_builder("table")
        .with_fields(fields.collect::<Result<_, ParquetError>>()?)
        .build()?;
    let properties = Arc::new(WriterProperties::builder().build());
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        let Some(mut into) = group.next_column()? else {
            break;
        };
        put(&mut into, column)?;
        into.close()?;
    }
    group.close()?;
    writer.into_inner()
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.cells.first() {
        Some(Cell::Number(_)) => (Physical::DOUBLE, None),
        Some(Cell::Count(_)) => (Physical::INT64, None),
        Some(Cell::Yes(_)) => (Physical::BOOLEAN, None),
        Some(Cell::Text(_)) | None => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
}

/// Values that are there, and for every row whether it is.
fn put(into: &mut SerializedColumnWriter<'_>, column: &Column) -> Result<(), ParquetError> {
    let there = |cell: &Cell| match cell {
        Cell::Number(x) => x.is_some(),
        Cell::Count(n) => n.is_some(),
        Cell::Yes(yes) => yes.is_some(),
        Cell::Text(_) => true,
    };
    let levels: Vec<i16> = column.cells.iter().map(|c| i16::from(there(c))).collect();
    let levels = Some(&levels[..]);
    let cells = || column.cells.iter();
    match column.cells.first() {
        Some(Cell::Number(_)) => {
            let values: Vec<f64> = cells()
                .filter_map(|c| if let Cell::Number(x) = c { *x } else { None })
                .collect();
            into.typed::<DoubleType>()
                .write_batch(&values, levels, None)?;
        }
        Some(Cell::Count(_)) => {
            let values: Vec<i64> = cells()
                .filter_map(|c| if let Cell::Count(n) = c { *n } else { None })
                .collect();
            into.typed::<Int64Type>()
                .write_batch(&values, levels, None)?;
        }
        Some(Cell::Yes(_)) => {
            let values: Vec<bool> = cells()
                .filter_map(|c| if let Cell::Yes(yes) = c { *yes } else { None })
                .collect();
            into.typed::<BoolType>()
                .write_batch(&values, levels, None)?;
        }
        Some(Cell::Text(_)) => {
            let values: Vec<ByteArray> = cells()
                .filter_map(|c| match c {
                    Cell::Text(text) => Some(ByteArray::from(text.as_str())),
                    _ => None,
                })
                .collect();
            into.typed::<ByteArrayType>()
                .write_batch(&values, levels, None)?;
        }
        None => {
            into.typed::<ByteArrayType>()
                .write_batch(&[], levels, None)?;
        }
    }
    Ok(())
}
