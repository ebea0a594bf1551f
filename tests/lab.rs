//! The lab: every listed experiment keeps the contract, results survive being written, a stopped run leaves nothing.

use dorsum::figure::{LinePlot, Series};
use dorsum::lab::{
    self, Document, Drawing, Experiment, LabError, Mesh, Report, Setup, Table, Value, Verdict,
    Watch,
};
use dorsum::surface::Surface;
use dorsum::surface::back::{BackOptions, make};
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// A look at a back of few triangles.
fn toy() -> Setup {
    let raw = make(&BackOptions::with_triangles(900));
    Setup {
        quick: true,
        mesh: Some(Mesh {
            name: "toy".to_owned(),
            surface: Arc::new(Surface::new(raw).expect("a usable mesh").0),
        }),
        triangles: vec![300, 900],
        ..Setup::default()
    }
}

fn run(experiment: &dyn Experiment) -> Document {
    lab::run(&[experiment], &toy(), &mut Watch::new(&mut |_, _| true)).expect("runs")
}

#[test]
fn every_experiment_runs_at_toy_size_and_says_what_its_figures_are() {
    for &experiment in lab::all() {
        let name = experiment.name();
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(name.chars().all(plain), "{name}");
        assert_eq!(experiment.about().lines().count(), 1, "{name}");
        let document = run(experiment);
        assert!(document.quick && document.holds, "{document:#?}");
        let [report] = &document.experiments[..] else {
            panic!("{name}: one experiment, one report");
        };
        assert_eq!(report.experiment, name);
        assert_eq!(report.about, experiment.about());
        assert!(!report.verdicts.is_empty(), "{name}: nothing is concluded");
        let mut files = HashSet::new();
        for table in &report.tables {
            assert!(table.name.chars().all(plain), "{name}: {}", table.name);
            assert!(files.insert(&table.name), "{name}: {} twice", table.name);
            assert!(!table.rows().is_empty(), "{name}: {} is empty", table.name);
            let heads: HashSet<_> = table.columns().iter().map(|c| &c.name).collect();
            assert_eq!(heads.len(), table.columns().len(), "{name}: {}", table.name);
            for row in table.rows() {
                assert_eq!(row.len(), table.columns().len());
                let finite = |v: &Value| v.number().is_none_or(f64::is_finite);
                assert!(row.iter().all(finite), "{name}: {row:?}");
            }
            // A time without a unit is no time.
            for column in table.columns() {
                let timed = ["time", "median", "p99", "build"].contains(&&*column.name);
                assert!(!timed || !column.unit.is_empty(), "{name}: {column}");
            }
        }
        for figure in &report.figures {
            assert!(figure.name.chars().all(plain), "{name}: {}", figure.name);
            let Drawing::Plots(plots) = &figure.drawing else {
                continue;
            };
            for plot in plots {
                let points = plot.series.iter().map(|s| s.points.len()).sum::<usize>();
                assert!(points > 0, "{name}: {} shows nothing", plot.title);
                assert!(plot.y_label.contains('('), "{name}: {}", plot.y_label);
            }
        }
    }
}

#[test]
fn experiments_are_found_by_name_and_by_group() {
    for &experiment in lab::all() {
        let found = lab::select(experiment.name());
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].name(), experiment.name());
        let group = lab::select(lab::group_of(experiment.name()));
        assert!(group.iter().any(|e| e.name() == experiment.name()));
    }
    let names: HashSet<_> = lab::all().iter().map(|e| e.name()).collect();
    assert_eq!(names.len(), lab::all().len());
    for unknown in ["", "-", "parti", "partition-", "PARTITION"] {
        assert!(lab::select(unknown).is_empty(), "{unknown}");
    }
}

#[test]
fn whoever_watches_can_stop_every_experiment_and_progress_never_falls() {
    for &experiment in lab::all() {
        let mut heard = Vec::new();
        let mut tell = |_: &str, share: f64| {
            heard.push(share);
            true
        };
        lab::run(&[experiment], &toy(), &mut Watch::new(&mut tell)).expect("runs");
        assert!(heard.is_sorted(), "{}: {heard:?}", experiment.name());
        assert_eq!((heard.first(), heard.last()), (Some(&0.0), Some(&1.0)));
        assert!(heard.len() > 3, "{}: {heard:?}", experiment.name());
        // At the first word and after half of them.
        for last in [1, heard.len() / 2] {
            let mut said = 0;
            let mut tell = |_: &str, _: f64| {
                said += 1;
                said < last
            };
            let stopped = lab::run(&[experiment], &toy(), &mut Watch::new(&mut tell));
            assert_eq!(stopped, Err(LabError::Stopped), "{}", experiment.name());
            assert_eq!(said, last, "{}: it went on", experiment.name());
        }
    }
}

/// A report whose every word is awkward.
fn awkward() -> Report {
    let mut table = Table::new(
        "odd",
        "Odd, \"quoted\"",
        &["name, odd", "cost (µs)", "count"],
    );
    table.push(["a,b".into(), 0.1.into(), 3_usize.into()]);
    table.push(["say \"x\"\nand y".into(), f64::NAN.into(), Value::Empty]);
    table.push(["".into(), 1.0e-300.into(), u32::MAX.into()]);
    table.push([" ü ".into(), (-1.0 / 3.0).into(), 0_usize.into()]);
    let mut report = Report {
        experiment: "test-odd".to_owned(),
        tables: vec![table],
        verdicts: vec![Verdict::must("it holds", 1.5, "2", true)],
        ..Report::default()
    };
    report.set("mesh", "back <&> \"x\"");
    report.note("Nothing.");
    report.draw(
        "curve",
        vec![LinePlot {
            title: "A curve".to_owned(),
            series: vec![Series {
                name: "a".to_owned(),
                points: vec![[0.0, 1.0], [1.0, 2.0]],
                ..Series::default()
            }],
            ..LinePlot::default()
        }],
    );
    report
}

#[test]
fn a_table_comes_back_from_csv_bit_for_bit() {
    let table = &awkward().tables[0];
    let bytes = table.csv().expect("written");
    let mut reader = csv::Reader::from_reader(&bytes[..]);
    let heads: Vec<String> = reader
        .headers()
        .expect("one line")
        .iter()
        .map(Into::into)
        .collect();
    assert_eq!(heads, ["name, odd", "cost (µs)", "count"]);
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("whole")).collect();
    assert_eq!(rows.len(), table.rows().len());
    for (row, read) in table.rows().iter().zip(&rows) {
        for (value, text) in row.iter().zip(read) {
            match value {
                Value::Empty => assert_eq!(text, ""),
                Value::Integer(i) => assert_eq!(text.parse(), Ok(*i)),
                Value::Number(x) => {
                    let back: f64 = text.parse().expect("a number");
                    assert_eq!(back.to_bits(), x.to_bits());
                }
                Value::Text(t) => assert_eq!(text, t),
            }
        }
    }
    assert_eq!(table.cell(0, "cost").number(), Some(0.1));
    assert_eq!(table.cell(1, "cost"), &Value::Empty, "NaN is nothing");
    assert_eq!(table.cell(9, "cost"), &Value::Empty);
    assert_eq!(table.cell(0, "price"), &Value::Empty);
}

#[test]
fn a_document_comes_back_from_json_as_it_was() {
    let document = Document::new(&Setup::default(), vec![awkward()]);
    let text = serde_json::to_string(&document).expect("written");
    let mut back: Document = serde_json::from_str(&text).expect("read");
    assert!(
        back.experiments[0].figures[0].drawing == Drawing::default(),
        "drawings are files"
    );
    back.experiments[0].figures = document.experiments[0].figures.clone();
    assert_eq!(back, document);
}

#[test]
fn only_what_must_hold_decides_whether_all_holds() {
    let mut report = awkward();
    report
        .verdicts
        .push(Verdict::told("fast", "2 µs", "1 µs", false));
    assert!(report.holds() && Document::new(&Setup::default(), vec![report.clone()]).holds);
    assert!(
        report
            .to_string()
            .contains("does not hold: fast: 2 µs (goal: 1 µs)")
    );
    report
        .verdicts
        .push(Verdict::must("right", "1 missed", "0", false));
    assert!(!report.holds() && !Document::new(&Setup::default(), vec![report.clone()]).holds);
    assert!(report.to_string().contains("DOES NOT HOLD: right"));
}

fn listed(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|e| {
            e.expect("an entry")
                .file_name()
                .into_string()
                .expect("UTF-8")
        })
        .collect();
    names.sort();
    names
}

#[test]
fn results_are_files_that_say_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let document = Document::new(&Setup::default(), vec![awkward()]);
    let files = lab::write(&document, "test", folder.path()).expect("written");
    let names = [
        "test-odd.curve.svg",
        "test-odd.odd.csv",
        "test.html",
        "test.json",
        "test.txt",
    ];
    assert_eq!(listed(folder.path()), names);
    assert_eq!(files.len(), names.len());
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).expect("read");
    let back: Document = serde_json::from_str(&read("test.json")).expect("a document");
    assert_eq!(back.experiments[0].tables, document.experiments[0].tables);
    assert_eq!(
        read("test-odd.odd.csv").as_bytes(),
        document.experiments[0].tables[0].csv().expect("CSV")
    );
    assert!(read("test-odd.curve.svg").contains("A curve"));
    let text = read("test.txt");
    for told in [
        "Measured on ",
        "cost",
        "µs",
        "holds: it holds: 1.5 (goal: 2)",
        "Nothing.",
    ] {
        assert!(text.contains(told), "{told}: {text}");
    }
    // Written again, they are replaced.
    lab::write(&document, "test", folder.path()).expect("written again");
    assert_eq!(listed(folder.path()), names);
}

#[test]
fn a_fault_while_writing_leaves_what_was_there() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("test.json"), "older").expect("written");
    let mut report = awkward();
    report
        .tables
        .push(Table::new("no/such/folder", "Nowhere", &["a"]));
    let document = Document::new(&Setup::default(), vec![report]);
    assert!(lab::write(&document, "test", folder.path()).is_err());
    assert_eq!(listed(folder.path()), ["test.json"]);
    let kept = std::fs::read_to_string(folder.path().join("test.json")).expect("read");
    assert_eq!(kept, "older");
    assert!(lab::write(&document, "test", &folder.path().join("missing")).is_err());
}

mod complexity {
    use super::*;

    #[test]
    fn the_printed_w_and_the_walked_ones_stand_beside_each_other() {
        let document = run(&lab::partition::Complexity);
        let table = &document.experiments[0].tables[0];
        let column = |name: &str| -> Vec<f64> {
            (0..table.rows().len())
                .map(|row| table.cell(row, name).number().expect("a number"))
                .collect()
        };
        let printed = [
            2.13, 2.58, 3.04, 3.53, 4.02, 4.51, 5.01, 5.50, 2.63, 3.50, 4.38,
        ];
        assert_eq!(column("w printed"), printed);
        // (h + 1) / n nodes · leaves, written out for heights 5 and 9 of table 3.3 and 2 of table 3.4.
        let walked = column("w walked");
        for (row, w) in [
            (2, 6.0 / 63.0 * 32.0),
            (6, 10.0 / 1023.0 * 512.0),
            (8, 3.0 / 73.0 * 64.0),
        ] {
            assert!(
                (walked[row] - w).abs() < 1e-12,
                "row {row}: {}",
                walked[row]
            );
        }
        assert_eq!(column("nodes")[..3], [15.0, 31.0, 63.0]);
    }
}

/// The cells of a column in the rows where `key` holds `wanted`.
fn column<'a>(table: &'a Table, key: &str, wanted: &str, name: &str) -> Vec<&'a Value> {
    (0..table.rows().len())
        .filter(|&row| table.cell(row, key).to_string() == wanted)
        .map(|row| table.cell(row, name))
        .collect()
}

mod completeness {
    use super::*;

    /// On the built-in back with as many triangles as the publication's model.
    #[test]
    fn the_printed_octree_rule_loses_249_triangles_and_the_complete_query_none() {
        let setup = Setup {
            quick: true,
            ..Setup::default()
        };
        let experiment = lab::partition::Completeness;
        let document = lab::run(&[&experiment], &setup, &mut Watch::new(&mut |_, _| true));
        let report = &document.expect("runs").experiments[0];
        let table = &report.tables[0];
        for row in 0..table.rows().len() {
            assert_eq!(table.cell(row, "missed"), &Value::Integer(0), "{row}");
            let mean = |name: &str| table.cell(row, name).number();
            assert!(mean("needed") <= mean("gathered"), "{row}");
            assert!(mean("needed") > Some(100.0), "{row}");
        }
        let lost = column(table, "structure", "octree", "lost by printed rule");
        assert_eq!(lost[0], &Value::Integer(249));
        assert_eq!(lost.len(), 4, "two thresholds, two boxes");
        // A cut triangle, or one listed on both sides, is in every leaf whose cell it meets.
        for complete in ["bsp a", "bsp b"] {
            for missed in column(table, "structure", complete, "published missed") {
                assert_eq!(missed, &Value::Integer(0), "{complete}");
            }
        }
        for jutting in ["bsp c", "octree"] {
            let missed = column(table, "structure", jutting, "published missed");
            let sum: f64 = missed.iter().filter_map(|v| v.number()).sum();
            assert!(sum > 0.0, "{jutting}");
        }
        assert!(report.holds());
    }
}

mod threshold {
    use super::*;
    use dorsum::geom::Aabb;
    use dorsum::partition::brute::Brute;
    use dorsum::partition::{Partition as _, hdb};

    #[test]
    fn counts_are_those_of_the_trees_and_of_brute_force() {
        let setup = toy();
        let document = run(&lab::partition::Threshold);
        let [trees, queries] = &document.experiments[0].tables[..] else {
            panic!("two tables");
        };
        let surface = &setup.mesh.expect("the toy").surface;
        // The same places as in the experiment are not known here; their mean is near that over all triangles.
        let edge_mm = hdb::edge_mm(surface);
        let mut sum = 0;
        for t in 0..surface.triangles().len() as u32 {
            let region = Aabb::cube(surface.triangle(t).centroid(), edge_mm);
            let mut found = Vec::new();
            Brute.in_box(surface, &region, &mut found);
            sum += found.len();
        }
        let mean = sum as f64 / surface.triangles().len() as f64;
        for row in 0..queries.rows().len() {
            let number = |name: &str| queries.cell(row, name).number().expect("a number");
            let complete = number("complete gathered");
            assert!((complete / mean - 1.0).abs() < 0.15, "{complete}, {mean}");
            let ratio = number("published gathered") / complete;
            assert!((number("gathered / needed") - ratio).abs() < 1e-12);
        }
        for row in 0..trees.rows().len() {
            let number = |name: &str| trees.cell(row, name).number();
            assert!(number("largest leaf") <= number("threshold"), "{row}");
            assert!(number("entries per triangle") >= Some(1.0), "{row}");
            // 900 triangles fit into one leaf of 1024.
            if number("threshold") >= Some(1024.0) {
                assert_eq!((number("nodes"), number("height")), (Some(1.0), Some(0.0)));
                assert_eq!(number("largest leaf"), Some(900.0));
            }
        }
    }
}

mod passes {
    use super::*;

    #[test]
    fn printed_figures_stand_beside_ours() {
        let document = run(&lab::partition::Passes);
        let report = &document.experiments[0];
        let table = |name: &str| {
            let found = report.tables.iter().find(|t| t.name == name);
            found.unwrap_or_else(|| panic!("{name} is missing"))
        };
        // Tables 3.2 and B: seven rows for each of three conditions.
        let beside = table("beside-print");
        assert_eq!(beside.rows().len(), 42);
        let first = |structure: &str, name: &str| {
            column(beside, "structure", structure, name)[0]
                .number()
                .expect("a number")
        };
        assert_eq!(
            (first("bsp c", "haptic triangles"), first("bsp c", "2008")),
            (1387.0, 2.6)
        );
        assert_eq!(
            (
                first("octree", "haptic triangles"),
                first("octree", "2008 rate")
            ),
            (1373.0, 385.0)
        );
        let against = table("octree-against-bsp");
        let percent =
            |row: usize, name: &str| against.cell(row, name).number().expect("a number").round();
        let printed = |row| (percent(row, "2008, least"), percent(row, "2008, most"));
        assert_eq!(
            [0, 1, 2].map(printed),
            [(-18.0, -1.0), (18.0, 32.0), (15.0, 38.0)]
        );
        // The sizes asked for.
        let models = table("by-model");
        assert_eq!(models.rows().len(), 2);
        assert_eq!(models.cell(1, "model triangles"), &Value::Integer(900));
        // Without a structure all triangles are asked.
        let by_box = table("by-box");
        for triangles in column(by_box, "structure", "brute", "haptic triangles") {
            assert_eq!(triangles.number(), Some(900.0));
        }
        for structure in ["bsp c", "octree", "hybrid"] {
            let found = column(by_box, "structure", structure, "haptic triangles");
            assert!(
                found.iter().all(|n| n.number() <= Some(900.0)),
                "{structure}"
            );
        }
    }
}

mod box_size {
    use super::*;

    #[test]
    fn a_box_that_reaches_farther_than_a_step_lets_nothing_through_and_a_tiny_one_does() {
        let document = run(&lab::partition::BoxSize);
        let table = &document.experiments[0].tables[0];
        let speeds = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0];
        let mut punctured_by_tiny = 0.0;
        for row in 0..table.rows().len() {
            let number = |name: &str| table.cell(row, name).number();
            let engine = table.cell(row, "engine").to_string();
            for v in speeds {
                let percent = number(&format!("{v} m/s")).expect("a share");
                match number("safe by geometry") {
                    None => assert_eq!(percent, 0.0, "{engine} at {v} m/s"),
                    // As published a triangle that juts out of its leaf may be missed all the same.
                    Some(safe) if v <= 0.9 * safe && engine.contains("complete") => {
                        assert_eq!(percent, 0.0, "{engine}, row {row}, {v} m/s, safe {safe}");
                    }
                    Some(safe) if v > 20.0 * safe => punctured_by_tiny += percent,
                    Some(_) => {}
                }
            }
        }
        assert_eq!(column(table, "engine", "production", "rate").len(), 2);
        assert!(punctured_by_tiny > 0.0);
    }
}
