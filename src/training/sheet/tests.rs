use super::*;
use crate::training::journal::{Changes, Header};
use crate::training::score::Errors;
use crate::training::trial::TrialRecord;
use ::parquet::file::reader::{FileReader as _, SerializedFileReader};
use ::parquet::record::RowAccessor as _;

fn done(participant: &str, day: u32, threshold: f64) -> Done {
    let trials = (1..=60)
        .map(|i| {
            let percent = [8.0, 14.0, 20.0, 28.0, 40.0][i as usize % 5];
            TrialRecord {
                trial: i,
                task: "locate".into(),
                level: Some(percent / 3.0),
                strength_percent: Some(percent),
                measure: Some("compliance".into()),
                stiffness_percent: Some(percent),
                chance: 1.0 / 24.0,
                truth: "T5 left <b>\"x\", y".into(),
                answer: "T6 left transverse process".into(),
                right: percent > threshold || i % 9 == 0,
                confidence_percent: (i % 2 == 0).then_some(70),
                errors: Errors {
                    mm: Some(24.5),
                    levels: Some(1),
                    ..Errors::default()
                },
                settled_utc: "2031-05-17T09:30:00.000Z".into(),
                ..TrialRecord::default()
            }
        })
        .collect();
    let read = Read {
        header: Header {
            format: 1,
            program: "test".into(),
            scenario: "locate.toml".into(),
            blind_toml: String::new(),
            changes: Changes::default(),
            participant: Some(participant.into()),
            seed: None,
            observer: None,
            started_utc: format!("2031-05-{day:02}T09:30:00.000Z"),
        },
        trials,
        ended: None,
        cut_off: None,
        whole_bytes: 0,
    };
    Done::new(
        read,
        &Options {
            samples: 40,
            ..Options::default()
        },
    )
}

#[test]
fn a_sheet_is_written_whole_and_read_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let all = [
        done("P2", 17, 15.0),
        done("P1", 3, 25.0),
        done("P1", 9, 10.0),
    ];
    let files = write(folder.path(), &all).expect("written");
    assert_eq!(files.len(), FILES.len());

    let mut csv = csv::Reader::from_path(&files[1]).expect("there");
    let heads = csv.headers().expect("heads").clone();
    let rows: Vec<csv::StringRecord> = csv.records().map(|r| r.expect("a row")).collect();
    assert_eq!(rows.len(), 180);
    let file = std::fs::File::open(&files[2]).expect("there");
    let parquet = SerializedFileReader::new(file).expect("a Parquet file");
    let names: Vec<String> = (parquet
        .metadata()
        .file_metadata()
        .schema()
        .get_fields()
        .iter())
    .map(|f| f.name().to_owned())
    .collect();
    assert_eq!(names, heads.iter().collect::<Vec<_>>());
    let column = |name: &str| names.iter().position(|n| n == name).expect("a column");
    let mut n = 0;
    for (row, line) in parquet.get_row_iter(None).expect("rows").zip(&rows) {
        let row = row.expect("a row");
        let strength = row
            .get_double(column("strength_percent"))
            .expect("a number");
        let text = &line[column("strength_percent")];
        assert_eq!(crate::table::number_text(strength), text);
        assert_eq!(
            row.get_string(column("truth")).expect("text"),
            &line[column("truth")]
        );
        assert_eq!(
            row.get_bool(column("right")).expect("a bool").to_string(),
            line[column("right")]
        );
        // What is absent is null there and empty here.
        let sure = row
            .get_long(column("confidence_percent"))
            .ok()
            .map(|c| c.to_string());
        assert_eq!(sure.unwrap_or_default(), line[column("confidence_percent")]);
        n += 1;
    }
    assert_eq!(n, 180);

    let mut people = csv::Reader::from_path(&files[3]).expect("there");
    let order: Vec<String> = (people.records())
        .map(|r| {
            r.expect("a row")
                .iter()
                .take(2)
                .collect::<Vec<_>>()
                .join(" ")
        })
        .collect();
    assert_eq!(order.len(), 3);
    assert!(
        order.is_sorted() && order[0].starts_with("P1 2031-05-03"),
        "{order:?}"
    );
}

#[test]
fn the_page_stands_alone_and_says_what_is_asked_of_it() {
    let all = [done("P1", 3, 25.0), done("P1", 9, 10.0)];
    let page = page(&all).expect("drawn");
    for part in [
        "Learning curve",
        "Weber fraction",
        "Score sheet of P1",
        "T5 left &lt;b&gt;&quot;x&quot;, y",
        "Smallest change found",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for elsewhere in ["<script", "src=", "@import", "<link"] {
        assert!(!page.contains(elsewhere), "{elsewhere}");
    }
    assert!(page.matches("<svg").count() == 5 && !page.contains("NaN"));
    let nothing = super::page(&[]).expect("drawn");
    assert!(nothing.contains("Score sheet"));
}
