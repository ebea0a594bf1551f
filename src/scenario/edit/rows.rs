//! Lists of tables in a file: changed row by row, so that comments stay with their rows.

use super::cells::Cell;
use toml_edit::{Array, ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

/// One table of a list: its keys in order.
pub(super) type Row<'a> = Vec<(&'static str, Cell<'a>)>;

/// What a list is to hold, row by row.
pub(super) trait NewRows {
    /// How many rows.
    fn len(&self) -> usize;
    /// Whether table `old`, counted as in the file, says row `new` already.
    fn says(&self, old: usize, table: &dyn TableLike, new: usize) -> bool;
    /// Makes `table` say row `new`; it was table `old` of the file, if any.
    fn write(&self, old: Option<usize>, table: &mut dyn TableLike, new: usize);
}

/// Rows given whole: a key that a row does not have is taken out.
impl NewRows for [Row<'_>] {
    fn len(&self) -> usize {
        <[Row<'_>]>::len(self)
    }

    fn says(&self, _: usize, table: &dyn TableLike, new: usize) -> bool {
        says(table, &self[new])
    }

    fn write(&self, _: Option<usize>, table: &mut dyn TableLike, new: usize) {
        set_row(table, &self[new]);
    }
}

/// Makes `table[key]` the list of `rows`, which are not none. A new list is written as inline tables where `inline`.
pub(super) fn set_rows<R: NewRows + ?Sized>(
    table: &mut dyn TableLike,
    key: &str,
    rows: &R,
    inline: bool,
) {
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
fn aligned(n_old: usize, n_new: usize, same: impl Fn(usize, usize) -> bool) -> Vec<Option<usize>> {
    let front = (0..n_old.min(n_new)).take_while(|&i| same(i, i)).count();
    let back = (1..=(n_old - front).min(n_new - front))
        .take_while(|&i| same(n_old - i, n_new - i))
        .count();
    let (n, m) = (n_old - back - front, n_new - back - front);
    let mut place: Vec<Option<usize>> = (0..n_new).map(|j| (j < front).then_some(j)).collect();
    for i in 0..back {
        place[n_new - 1 - i] = Some(n_old - 1 - i);
    }
    if n * m <= MOST_COMPARED {
        // longest[i][j]: of what follows old row i and new row j.
        let mut longest = vec![0_usize; (n + 1) * (m + 1)];
        let at = |i: usize, j: usize| i * (m + 1) + j;
        let equal = |i: usize, j: usize| same(front + i, front + j);
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
                if free < next.copied().unwrap_or(n_old) {
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

fn list_of_tables<R: NewRows + ?Sized>(list: &mut ArrayOfTables, rows: &R) {
    let tables: Vec<Table> = list.iter().cloned().collect();
    let same = |i: usize, j: usize| rows.says(i, &tables[i], j);
    let place = aligned(tables.len(), rows.len(), same);
    list.clear();
    for (j, place) in place.into_iter().enumerate() {
        let mut table = place.map(|i| tables[i].clone()).unwrap_or_default();
        rows.write(place, &mut table, j);
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

    fn with<R: NewRows + ?Sized>(mut self, rows: &R) -> Self {
        let same = |i: usize, j: usize| rows.says(i, &self.rows[i].table, j);
        let place = aligned(self.rows.len(), rows.len(), same);
        let lead = self.new_lead();
        if self.rows.is_empty() {
            "\n".clone_into(&mut self.closing);
        }
        self.rows = place
            .into_iter()
            .enumerate()
            .map(|(j, place)| {
                let old = place.map(|i| self.rows[i].clone());
                let mut entry = old.unwrap_or_else(|| InlineRow {
                    lead: lead.clone(),
                    table: InlineTable::new(),
                    tail: String::new(),
                });
                rows.write(place, &mut entry.table, j);
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
