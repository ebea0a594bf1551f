use super::*;
use ::parquet::basic::{Compression, Encoding};
use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
use ::parquet::record::Field;

fn heads() -> Vec<Head> {
    vec![
        Head::new("time_ns", Sort::Clock)
            .required()
            .unit("ns")
            .about("Time"),
        Head::new("depth_mm", Sort::Number).unit("mm"),
        Head::new("duration_us", Sort::Single),
        Head::new("finger", Sort::Count),
        Head::new("late", Sort::Yes),
        Head::new("touch", Sort::Text),
    ]
}

/// Numbers that lose bits wherever digits are cut, and those with no digits at all.
const HARD: [f64; 11] = [
    0.1 + 0.2,
    -0.0,
    5e-324,
    f64::MAX,
    1e16,
    -1.234_567_890_123_456_7e-5,
    9.999_999e-6,
    1.0 / 3.0,
    f64::NAN,
    f64::NEG_INFINITY,
    123_456_789.0,
];

fn row(i: usize) -> Vec<Cell<'static>> {
    let there = !i.is_multiple_of(7);
    vec![
        Cell::Count(Some(1_000_000 * i as i64)),
        Cell::Number(there.then(|| HARD[i % HARD.len()])),
        Cell::Single(Some(0.1 * i as f32)),
        Cell::Count((!i.is_multiple_of(5)).then_some(i64::MAX - i as i64)),
        Cell::Yes((!i.is_multiple_of(3)).then_some(i.is_multiple_of(2))),
        Cell::Text((!i.is_multiple_of(4)).then_some(Cow::Borrowed("a \"b\", c\nµ"))),
    ]
}

fn same(field: &Field, cell: &Cell<'_>) -> bool {
    match (field, cell) {
        (Field::Null, Cell::Number(None) | Cell::Count(None)) => true,
        (Field::Null, Cell::Yes(None) | Cell::Text(None)) => true,
        (Field::Double(a), Cell::Number(Some(b))) => a.to_bits() == b.to_bits(),
        (Field::Float(a), Cell::Single(Some(b))) => a.to_bits() == b.to_bits(),
        (Field::Long(a), Cell::Count(Some(b))) => a == b,
        (Field::Bool(a), Cell::Yes(Some(b))) => a == b,
        (Field::Str(a), Cell::Text(Some(b))) => a == b,
        _ => false,
    }
}

#[test]
fn parquet_brings_every_cell_back_over_several_row_groups() {
    let n = 2 * ROWS_PER_GROUP + 3;
    let mut bytes = Vec::new();
    let notes = [("dorsum.format", "1".to_owned())];
    let mut rows = ParquetRows::new(&mut bytes, &heads(), &notes).expect("begun");
    for i in 0..n {
        rows.row(&row(i)).expect("taken");
    }
    rows.finish().expect("finished");
    drop(rows);

    let reader =
        SerializedFileReader::new(prost::bytes::Bytes::from(bytes)).expect("a Parquet file");
    let metadata = reader.metadata();
    assert_eq!(metadata.num_row_groups(), 3);
    let notes = metadata.file_metadata().key_value_metadata();
    let told = |key: &str| {
        let found = notes.expect("notes").iter().find(|n| n.key == key);
        found.and_then(|n| n.value.as_deref())
    };
    assert_eq!(told("dorsum.format"), Some("1"));
    assert_eq!(told("unit.depth_mm"), Some("mm"));
    assert_eq!(told("about.time_ns"), Some("Time"));
    assert_eq!(told("unit.finger"), None);
    for (column, head) in metadata.row_group(0).columns().iter().zip(heads()) {
        assert!(matches!(column.compression(), Compression::ZSTD(_)));
        assert!(column.statistics().is_some(), "{}", head.name);
        // What engines have read for years, nothing newer.
        let old = [
            Encoding::PLAIN,
            Encoding::RLE,
            Encoding::RLE_DICTIONARY,
            Encoding::DELTA_BINARY_PACKED,
        ];
        assert!(column.encodings().all(|e| old.contains(&e)));
    }
    let mut count = 0;
    for (i, read) in reader.get_row_iter(None).expect("rows").enumerate() {
        let read = read.expect("a row");
        for ((name, field), cell) in read.get_column_iter().zip(row(i)) {
            assert!(same(field, &cell), "row {i}, {name}: {field:?} {cell:?}");
        }
        count += 1;
    }
    assert_eq!(count, n);
}

#[test]
fn csv_brings_numbers_back_bit_for_bit() {
    let table = Table {
        heads: heads(),
        rows: (0..100).map(row).collect(),
    };
    let bytes = table.csv().expect("written");
    let mut reader = ::csv::Reader::from_reader(&bytes[..]);
    let names: Vec<String> = heads().iter().map(|h| h.name.to_string()).collect();
    assert_eq!(
        reader.headers().expect("names").iter().collect::<Vec<_>>(),
        names
    );
    let mut count = 0;
    for (i, read) in reader.records().enumerate() {
        let read = read.expect("a row");
        for (text, cell) in read.iter().zip(row(i)) {
            let same = match cell {
                Cell::Number(Some(x)) => {
                    let back: f64 = text.parse().expect("a number");
                    back.to_bits() == x.to_bits() || (back.is_nan() && x.is_nan())
                }
                Cell::Single(Some(x)) => text.parse::<f32>().expect("a number") == x,
                Cell::Count(Some(n)) => text.parse() == Ok(n),
                Cell::Yes(Some(yes)) => text.parse() == Ok(yes),
                Cell::Text(Some(expected)) => text == expected,
                _ => text.is_empty(),
            };
            assert!(same, "row {i}: {text}");
        }
        count += 1;
    }
    assert_eq!(count, 100);
    assert!(number_text(f64::MAX).len() < 25 && number_text(5e-324) == "5e-324");
}

#[test]
fn a_table_of_no_rows_keeps_its_columns() {
    let table = Table {
        heads: heads(),
        rows: Vec::new(),
    };
    let bytes = table.parquet().expect("written");
    let reader =
        SerializedFileReader::new(prost::bytes::Bytes::from(bytes)).expect("a Parquet file");
    let schema = reader.metadata().file_metadata().schema();
    let kinds: Vec<String> = (schema.get_fields().iter())
        .map(|f| f.get_physical_type().to_string())
        .collect();
    assert_eq!(
        kinds,
        ["INT64", "DOUBLE", "FLOAT", "INT64", "BOOLEAN", "BYTE_ARRAY"]
    );
    let text = String::from_utf8(table.csv().expect("written")).expect("UTF-8");
    assert_eq!(text, "time_ns,depth_mm,duration_us,finger,late,touch\n");
}

#[test]
fn a_row_that_does_not_fit_is_refused() {
    let mut bytes = Vec::new();
    let mut rows = ParquetRows::new(&mut bytes, &heads(), &[]).expect("begun");
    let told = |rows: &mut ParquetRows<_>, cells: &[Cell<'_>]| {
        rows.row(cells).expect_err("refused").to_string()
    };
    assert!(told(&mut rows, &row(1)[..5]).contains("5 cells in a row of 6"));
    let mut swapped = row(1);
    swapped.swap(1, 2);
    assert!(told(&mut rows, &swapped).contains("column depth_mm holds Number"));
    let mut lacking = row(1);
    lacking[0] = Cell::Count(None);
    assert!(told(&mut rows, &lacking).contains("column time_ns holds Clock, not Count(None)"));
    drop(rows);
    assert!(CsvRows::new(&mut Vec::new(), &heads()).is_ok_and(|mut csv| csv.row(&[]).is_err()));
}
