//! Lists of tables in a file: changed row by row, so that comments stay with their rows.

use super::cells::Cell;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

/// One table of a list: its keys in order.
pub(super) type Row<'a> = Vec<(&'static str, Cell<'a>)>;

/// Makes `table[key]` the list of `rows`, which are not none. A new list is written as inline tables where `inline`.
pub(super) fn set_rows(table: &mut dyn TableLike, key: &str, rows: &[Row<'_>], inline: bool) {
    match table.get_mut(key) {
        Some(Item::ArrayOfTables(list)) => list_of_tables(list, rows),
        Some(Item::Value(Value::Array(array))) => {
            *array = Inline::of(array).with(rows).into_array(array);
        }
        _ if inline => {
            let empty = Array::new();
            let array = Inline::of(&empty).with(rows).into_array(&empty);
            table.insert(key, Item::Value(Value::Array(array)));
        }
        _ => {
            let mut list = ArrayOfTables::new();
            list_of_tables(&mut list, rows);
            table.insert(key, Item::ArrayOfTables(list));
        }
    }
}

/// Sets a value unless it is said already; its comments stay.
pub(super) fn set(table: &mut dyn TableLike, key: &str, cell: &Cell<'_>) {
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            if !cell.is_said_by(old) {
                let decor = old.decor().clone();
                *old = cell.value();
                *old.decor_mut() = decor;
            }
        }
        _ => {
            table.insert(key, Item::Value(cell.value()));
        }
    }
}

fn set_row(table: &mut dyn TableLike, row: &Row<'_>) {
    let beside = |key: &str| row.iter().all(|(k, _)| *k != key);
    let extra: Vec<String> = table
        .iter()
        .map(|(key, _)| key.to_owned())
        .filter(|key| beside(key))
        .collect();
    for key in extra {
        table.remove(&key);
    }
    for (key, cell) in row {
        set(table, key, cell);
    }
}

fn says(table: &dyn TableLike, row: &Row<'_>) -> bool {
    table.len() == row.len()
        && row.iter().all(|(key, cell)| {
            let value = table.get(key).and_then(Item::as_value);
            value.is_some_and(|v| cell.is_said_by(v))
        })
}

/// For every new row the old one that it takes the place of.
///
/// As many as can be stay with a row that says the same, in order (the longest common subsequence); between two of those,
/// the first new row takes the first old one's place, and so on.
fn aligned<T>(
    old: &[T],
    rows: &[Row<'_>],
    same: impl Fn(&T, &Row<'_>) -> bool,
) -> Vec<Option<usize>> {
    let front = old.iter().zip(rows).take_while(|(o, r)| same(o, r)).count();
    let ends = old[front..].iter().rev().zip(rows[front..].iter().rev());
    let back = ends.take_while(|(o, r)| same(o, r)).count();
    let (n, m) = (old.len() - back - front, rows.len() - back - front);
    let mut place: Vec<Option<usize>> = (0..rows.len()).map(|j| (j < front).then_some(j)).collect();
    for i in 0..back {
        place[rows.len() - 1 - i] = Some(old.len() - 1 - i);
    }
    if n * m <= MOST_COMPARED {
        // longest[i][j]: of what follows old row i and new row j.
        let mut longest = vec![0_usize; (n + 1) * (m + 1)];
        let at = |i: usize, j: usize| i * (m + 1) + j;
        let equal = |i: usize, j: usize| same(&old[front + i], &rows[front + j]);
        for i in (0..n).rev() {
            for j in (0..m).rev() {
                longest[at(i, j)] = if equal(i, j) {
                    longest[at(i + 1, j + 1)] + 1
                } else {
                    longest[at(i + 1, j)].max(longest[at(i, j + 1)])
                };
            }
        }
        let (mut i, mut j) = (0, 0);
        while i < n && j < m {
            if equal(i, j) {
                place[front + j] = Some(front + i);
                (i, j) = (i + 1, j + 1);
            } else if longest[at(i + 1, j)] >= longest[at(i, j + 1)] {
                i += 1;
            } else {
                j += 1;
            }
        }
    }
    let mut free = 0;
    for j in 0..place.len() {
        match place[j] {
            Some(i) => free = i + 1,
            None => {
                let next = place[j..].iter().flatten().next();
                if free < next.copied().unwrap_or(old.len()) {
                    place[j] = Some(free);
                    free += 1;
                }
            }
        }
    }
    place
}

/// Pairs of rows beyond which a list is not searched for what stayed the same: a few ms.
const MOST_COMPARED: usize = 100_000;

fn list_of_tables(list: &mut ArrayOfTables, rows: &[Row<'_>]) {
    let tables: Vec<Table> = list.iter().cloned().collect();
    let place = aligned(&tables, rows, |table, row| says(table, row));
    list.clear();
    for (row, place) in rows.iter().zip(place) {
        let mut table = place.map(|i| tables[i].clone()).unwrap_or_default();
        set_row(&mut table, row);
        list.push(table);
    }
}

/// An array of inline tables, cut so that a comment lies with the row that it follows on the same line, or stands above.
struct Inline {
    /// What follows the opening bracket on its line.
    opening: String,
    rows: Vec<InlineRow>,
    /// What is left before the closing bracket.
    closing: String,
}

#[derive(Clone)]
struct InlineRow {
    /// Own lines above, and indentation.
    lead: String,
    table: InlineTable,
    /// The rest of its line, behind the comma.
    tail: String,
}

impl Inline {
    fn of(array: &Array) -> Self {
        let mut opening = String::new();
        let mut rows: Vec<InlineRow> = Vec::new();
        let mut behind = |rows: &mut Vec<InlineRow>, text: &str| {
            let (line, rest) = match text.find('\n') {
                Some(end) if text[..end].contains('#') => text.split_at(end),
                _ => ("", text),
            };
            match rows.last_mut() {
                Some(row) => row.tail = line.to_owned(),
                None => opening = line.to_owned(),
            }
            rest.to_owned()
        };
        let text = |raw: Option<&toml_edit::RawString>| {
            raw.and_then(|r| r.as_str()).unwrap_or_default().to_owned()
        };
        let mut after_last = String::new();
        for value in array.iter() {
            let lead = behind(&mut rows, &text(value.decor().prefix()));
            let mut table = value.as_inline_table().cloned().unwrap_or_default();
            after_last = text(value.decor().suffix());
            table.decor_mut().clear();
            rows.push(InlineRow {
                lead,
                table,
                tail: String::new(),
            });
        }
        let end = text(Some(array.trailing()));
        let closing = behind(&mut rows, &format!("{after_last}{end}"));
        Self {
            opening,
            rows,
            closing,
        }
    }

    fn with(mut self, rows: &[Row<'_>]) -> Self {
        let place = aligned(&self.rows, rows, |r, row| says(&r.table, row));
        let lead = self.new_lead();
        if self.rows.is_empty() {
            "\n".clone_into(&mut self.closing);
        }
        self.rows = rows
            .iter()
            .zip(place)
            .map(|(row, place)| {
                let old = place.map(|i| self.rows[i].clone());
                let mut entry = old.unwrap_or_else(|| InlineRow {
                    lead: lead.clone(),
                    table: InlineTable::new(),
                    tail: String::new(),
                });
                set_row(&mut entry.table, row);
                entry
            })
            .collect();
        self
    }

    /// As the last row is set off from the one before, without its comments.
    fn new_lead(&self) -> String {
        let Some(row) = self.rows.last() else {
            return "\n  ".to_owned();
        };
        match row.lead.rfind('\n') {
            Some(line) => row.lead[line..].to_owned(),
            None => " ".to_owned(),
        }
    }

    /// As the array `like`, whose place and comments around it are kept.
    fn into_array(self, like: &Array) -> Array {
        let mut array = Array::new();
        let mut before = self.opening;
        for row in self.rows {
            let lead = format!("{before}{}", row.lead);
            array.push_formatted(Value::InlineTable(row.table).decorated(lead, ""));
            before = row.tail;
        }
        let trailing = format!("{before}{}", self.closing);
        array.set_trailing_comma(trailing.contains('\n'));
        array.set_trailing(trailing);
        *array.decor_mut() = like.decor().clone();
        array
    }
}
