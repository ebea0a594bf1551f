//! Keys as comma separated values: one row per key, units in the heads.

use crate::geom::Vec2;
use crate::maps::{EllipseKey, MAX_COORDINATE_MM, StiffnessKey};
use std::ops::RangeInclusive;
use std::path::Path;

/// Heads of a file of stiffness keys.
pub const STIFFNESS_HEADS: [&str; 3] = ["x_mm", "y_mm", "stiffness_n_per_mm"];
/// Heads of a file of ellipse keys.
pub const ELLIPSE_HEADS: [&str; 7] = [
    "name",
    "x_mm",
    "y_mm",
    "half_major_mm",
    "half_minor_mm",
    "angle_deg",
    "boundary_mm",
];
/// Most rows taken.
const MOST_ROWS: usize = 100_000;
/// Largest file taken, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Places a file may state, mm.
const PLACES_MM: RangeInclusive<f64> = -MAX_COORDINATE_MM..=MAX_COORDINATE_MM;

/// The text of a file, for one of the readers below.
///
/// # Errors
/// It cannot be read, or is too large to be a list of keys.
pub fn load(path: &Path) -> Result<String, String> {
    let shown = path.display();
    let size = std::fs::metadata(path)
        .map_err(|e| format!("{shown}: cannot be read: {e}"))?
        .len();
    if size > MOST_BYTES {
        return Err(format!(
            "{shown}: {size} bytes; a list of keys of at most {MOST_BYTES} bytes is allowed"
        ));
    }
    std::fs::read_to_string(path).map_err(|e| format!("{shown}: cannot be read: {e}"))
}

/// Stiffness keys. Columns may stand in any order; lines that begin with # are skipped.
///
/// # Errors
/// One line: file, line, value and what is allowed.
pub fn stiffness_keys(
    text: &str,
    origin: &str,
    allowed: &RangeInclusive<f64>,
) -> Result<Vec<StiffnessKey>, String> {
    rows(text, origin, &STIFFNESS_HEADS, 3, |row| {
        Ok(StiffnessKey {
            at: Vec2::new(row.number(0, &PLACES_MM)?, row.number(1, &PLACES_MM)?),
            stiffness_n_per_mm: row.number(2, allowed)?,
        })
    })
}

/// Ellipse keys; the column `boundary_mm` (radii with semicolons between) may be missing or empty.
///
/// # Errors
/// One line: file, line, value and what is allowed.
pub fn ellipse_keys(
    text: &str,
    origin: &str,
    allowed: &RangeInclusive<f64>,
) -> Result<Vec<EllipseKey>, String> {
    rows(text, origin, &ELLIPSE_HEADS, 6, |row| {
        let mut key = EllipseKey::new(
            row.text(0),
            Vec2::new(row.number(1, &PLACES_MM)?, row.number(2, &PLACES_MM)?),
            row.number(3, allowed)?,
            row.number(4, allowed)?,
            row.number(5, &(-360.0..=360.0))?.to_radians(),
        );
        let boundary = row.text(6);
        if !boundary.is_empty() {
            let radii = boundary
                .split(';')
                .map(|text| row.parse(6, text, allowed))
                .collect::<Result<_, _>>()?;
            key.boundary_mm = Some(radii);
        }
        Ok(key)
    })
}

/// Stiffness keys as text.
pub fn write_stiffness(keys: &[StiffnessKey]) -> String {
    let row = |k: &StiffnessKey| {
        vec![
            k.at.x.to_string(),
            k.at.y.to_string(),
            k.stiffness_n_per_mm.to_string(),
        ]
    };
    write(&STIFFNESS_HEADS, keys.iter().map(row))
}

/// Ellipse keys as text.
pub fn write_ellipses(keys: &[EllipseKey]) -> String {
    let row = |k: &EllipseKey| {
        let radii = k.boundary_mm.iter().flatten().map(f64::to_string);
        vec![
            k.name.clone(),
            k.at.x.to_string(),
            k.at.y.to_string(),
            k.half_major_mm.to_string(),
            k.half_minor_mm.to_string(),
            k.angle_rad.to_degrees().to_string(),
            radii.collect::<Vec<_>>().join(";"),
        ]
    };
    write(&ELLIPSE_HEADS, keys.iter().map(row))
}

fn write(heads: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = writer.write_record(heads);
    for row in rows {
        let _ = writer.write_record(&row);
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

/// A row with its place in the file.
struct Row<'a> {
    record: &'a csv::StringRecord,
    /// Which cell of the record holds each head.
    columns: &'a [Option<usize>],
    heads: &'a [&'static str],
    origin: &'a str,
    line: u64,
}

impl Row<'_> {
    fn text(&self, head: usize) -> &str {
        self.columns[head]
            .and_then(|c| self.record.get(c))
            .unwrap_or_default()
    }

    fn number(&self, head: usize, allowed: &RangeInclusive<f64>) -> Result<f64, String> {
        self.parse(head, self.text(head), allowed)
    }

    fn parse(&self, head: usize, text: &str, allowed: &RangeInclusive<f64>) -> Result<f64, String> {
        let (lo, hi) = (allowed.start(), allowed.end());
        match text.trim().parse::<f64>() {
            Ok(value) if allowed.contains(&value) => Ok(value),
            _ => Err(format!(
                "{}: line {}: {} = {text:?}; a number from {lo} to {hi} is allowed",
                self.origin, self.line, self.heads[head]
            )),
        }
    }
}

/// Reads rows with the given heads, the first `needed` of which must be there.
fn rows<T>(
    text: &str,
    origin: &str,
    heads: &'static [&'static str],
    needed: usize,
    mut take: impl FnMut(&Row<'_>) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let broken = |e: csv::Error| {
        let line = e.position().map_or(1, csv::Position::line);
        format!("{origin}: line {line}: is no row of comma separated values")
    };
    let first = reader.headers().map_err(broken)?.clone();
    if let Some(unknown) = first.iter().find(|h| !heads.contains(h)) {
        let allowed = heads.join(", ");
        return Err(format!(
            "{origin}: line 1: unknown head {unknown:?}; allowed are {allowed}"
        ));
    }
    let columns: Vec<_> = heads
        .iter()
        .map(|h| first.iter().position(|f| f == *h))
        .collect();
    if let Some(missing) = (0..needed).find(|&i| columns[i].is_none()) {
        return Err(format!(
            "{origin}: line 1: no head {:?}; needed are {}",
            heads[missing],
            heads[..needed].join(", ")
        ));
    }
    let mut out = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(broken)? {
        // Where a record says it begins, comments before it are counted to it; where it ends is sure.
        let end = reader.position();
        let before = usize::try_from(end.byte())
            .unwrap_or_default()
            .wrapping_sub(1);
        let past = text.as_bytes().get(before) == Some(&b'\n');
        let line = end.line() - u64::from(past);
        if record.len() != first.len() {
            return Err(format!(
                "{origin}: line {line}: {} values; {} are needed, one for each head",
                record.len(),
                first.len()
            ));
        }
        if out.len() == MOST_ROWS {
            return Err(format!(
                "{origin}: line {line}: too many rows; {MOST_ROWS} are allowed"
            ));
        }
        out.push(take(&Row {
            record: &record,
            columns: &columns,
            heads,
            origin,
            line,
        })?);
    }
    if out.is_empty() {
        return Err(format!("{origin}: no rows; at least one key is needed"));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const N_PER_MM: RangeInclusive<f64> = 0.001..=10_000.0;
    const MM: RangeInclusive<f64> = 1.0..=1000.0;

    #[test]
    fn each_fault_is_told_in_one_line_with_its_place() {
        for (text, told) in [
            (
                "",
                "a.csv: line 1: no head \"x_mm\"; needed are x_mm, y_mm, stiffness_n_per_mm",
            ),
            ("x_mm,y_mm\n1,2\n", "line 1: no head \"stiffness_n_per_mm\""),
            ("x_mm,y_mm,stiffness_n_per_mm\n", "a.csv: no rows"),
            (
                "x_mm,y_mm,stiffness_n_per_mm,w\n1,2,3,4\n",
                "line 1: unknown head \"w\"; allowed are x_mm",
            ),
            (
                "x_mm,y_mm,stiffness_n_per_mm\n1,2,0.5\n1,2\n",
                "line 3: 2 values; 3 are needed",
            ),
            (
                "x_mm,y_mm,stiffness_n_per_mm\n# a note\n1,2,soft\n",
                "line 3: stiffness_n_per_mm = \"soft\"; a number from 0.001 to 10000",
            ),
            (
                "x_mm,y_mm,stiffness_n_per_mm\n1,2,-0.5\n",
                "line 2: stiffness_n_per_mm = \"-0.5\"",
            ),
            (
                "x_mm,y_mm,stiffness_n_per_mm\nnan,2,0.5\n",
                "line 2: x_mm = \"nan\"",
            ),
            (
                "x_mm,y_mm,stiffness_n_per_mm\n1,inf,0.5\n",
                "line 2: y_mm = \"inf\"",
            ),
        ] {
            let error = stiffness_keys(text, "a.csv", &N_PER_MM).expect_err(text);
            assert!(
                error.contains(told),
                "{text:?} gave {error:?}, wanted {told:?}"
            );
            assert!(!error.contains('\n'));
        }
        let text =
            "name,x_mm,y_mm,half_major_mm,half_minor_mm,angle_deg,boundary_mm\nA,0,0,9,8,7,1;2;x\n";
        let error = ellipse_keys(text, "b.csv", &MM).expect_err("bad radius");
        assert!(
            error.starts_with("b.csv: line 2: boundary_mm = \"x\""),
            "{error}"
        );
    }

    #[test]
    fn columns_may_stand_in_any_order_and_the_boundary_may_be_missing() {
        let text = "\u{feff}# measured\nangle_deg, name ,x_mm,y_mm,half_minor_mm,half_major_mm\n90,\"T5, left\",-1,334.9,158,179\n";
        let keys = ellipse_keys(text, "a.csv", &MM).expect("reads");
        let expected = EllipseKey::new(
            "T5, left",
            Vec2::new(-1.0, 334.9),
            179.0,
            158.0,
            90_f64.to_radians(),
        );
        assert_eq!(keys, [expected]);
    }

    #[test]
    fn a_missing_file_is_told_by_its_name() {
        let error = load(Path::new("no/such.csv")).expect_err("missing");
        assert!(error.starts_with("no/such.csv: cannot be read"), "{error}");
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(keys in prop::collection::vec(
            ("[ -~]{0,12}", -500.0..500.0f64, -500.0..500.0f64, 1.0..300.0f64, 1.0..300.0f64, 0.0..180.0f64, any::<bool>()), 1..20
        )) {
            let keys: Vec<EllipseKey> = keys.into_iter().map(|(name, x, y, a, b, deg, irregular)| {
                let name = name.trim().trim_matches('"').trim().to_owned();
                let name = if name.starts_with('#') { String::new() } else { name };
                let mut key = EllipseKey::new(name, Vec2::new(x, y), a, b, deg.to_radians());
                key.boundary_mm = irregular.then(|| vec![a; 12]);
                key
            }).collect();
            let back = ellipse_keys(&write_ellipses(&keys), "a.csv", &MM).expect("reads");
            prop_assert_eq!(back.len(), keys.len());
            for (a, b) in back.iter().zip(&keys) {
                prop_assert!((a.angle_rad - b.angle_rad).abs() < 1e-14);
                prop_assert_eq!(EllipseKey { angle_rad: 0.0, ..a.clone() }, EllipseKey { angle_rad: 0.0, ..b.clone() });
            }
            let stiff: Vec<_> = keys.iter().map(|k| StiffnessKey { at: k.at, stiffness_n_per_mm: k.half_major_mm }).collect();
            prop_assert_eq!(stiffness_keys(&write_stiffness(&stiff), "a.csv", &N_PER_MM).expect("reads"), stiff);
        }

        #[test]
        fn any_text_is_read_or_refused_in_one_line(text in "(x_mm|y_mm|stiffness_n_per_mm|,|\n|\"|[0-9.eE#;-]|[ -~]){0,60}") {
            if let Err(e) = stiffness_keys(&text, "a.csv", &N_PER_MM) {
                prop_assert!(e.starts_with("a.csv: ") && !e.contains('\n'), "{e:?}");
            }
        }
    }
}
