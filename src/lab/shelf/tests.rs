//! A run that was stopped goes on where it was, and nothing is taken for what it is not.

use super::*;
use crate::figure::{CellMap, LinePlot, Series};
use crate::lab::{
    self, Choice, Document, Experiment, Mesh, Scene, Table, Value, Verdict, Watch, kept,
};
use crate::scenario::{Scenario, default_example};
use crate::surface::{Surface, back};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Numbers that are hard to write down.
const AWKWARD: [f64; 5] = [0.1, -0.0, 5e-324, f64::MAX, 1.0 / 3.0];

/// Five parts, each counted as it is made.
#[derive(Default)]
struct Counted {
    made: AtomicUsize,
}

impl Experiment for Counted {
    fn name(&self) -> &'static str {
        "test-counted"
    }

    fn about(&self) -> &'static str {
        "Whether parts are made again"
    }

    fn takes(&self) -> &'static [Choice] {
        &[
            Choice::Mesh,
            Choice::Triangles,
            Choice::Scene,
            Choice::Session,
            Choice::Seed,
            Choice::Seconds,
        ]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let mut table = Table::new("parts", "Parts", &["part", "value (mm)"]);
        let mut points = Vec::new();
        for (i, &number) in AWKWARD.iter().enumerate() {
            watch.at("a part", i as f64 / AWKWARD.len() as f64)?;
            let value: f64 = setup.shelf.part(&format!("part {i}"), || {
                self.made.fetch_add(1, Relaxed);
                Ok(number)
            })?;
            table.push([i.into(), value.into()]);
            points.push([i as f64, value]);
        }
        let series = vec![Series {
            points,
            ..Series::default()
        }];
        report.draw(
            "curve",
            vec![LinePlot {
                series,
                ..LinePlot::default()
            }],
        );
        report.draw_map(
            "map",
            CellMap {
                cells: vec![1, 2],
                ..CellMap::default()
            },
        );
        report.tables.push(table);
        report
            .verdicts
            .push(Verdict::must("done", "yes", "yes", true));
        Ok(report)
    }
}

impl Counted {
    fn made(&self) -> usize {
        self.made.load(Relaxed)
    }

    /// Runs until it was asked `words` times whether to go on.
    fn run_until(&self, setup: &Setup, words: usize) -> Result<Document, LabError> {
        let mut said = 0;
        let mut tell = |_: &str, _: f64| {
            said += 1;
            said <= words
        };
        lab::run(&[self], setup, &mut Watch::new(&mut tell))
    }

    fn run_whole(&self, setup: &Setup) -> Document {
        self.run_until(setup, usize::MAX).expect("runs")
    }
}

fn on(folder: &Path) -> Setup {
    Setup {
        shelf: Shelf::open(folder),
        ..Setup::default()
    }
}

/// The same but for the time of day, down to every bit of every number.
fn same(a: &Document, b: &Document) -> bool {
    let told = |d: &Document| {
        let mut d = d.clone();
        d.experiments.iter_mut().for_each(|r| r.measured.clear());
        format!("{d:?}")
    };
    told(a) == told(b)
}

/// The files of parts under `folder`, labels left out.
fn parts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.path().is_dir() {
            found.extend(parts(&entry.path()));
        } else if entry.file_name() != label::FILE {
            found.push(entry.path());
        }
    }
    found
}

#[test]
fn a_stopped_run_goes_on_and_gives_what_an_unbroken_one_gives() {
    let (whole, broken) = (Counted::default(), Counted::default());
    let unbroken = whole.run_whole(&Setup::default());
    let folder = tempfile::tempdir().expect("a folder");
    let setup = on(folder.path());
    // The first word is the run's own, then one before each part.
    assert_eq!(broken.run_until(&setup, 4), Err(LabError::Stopped));
    assert_eq!((broken.made(), parts(folder.path()).len()), (3, 3));
    let resumed = broken.run_whole(&setup);
    assert_eq!(broken.made(), 5, "finished parts are not made again");
    assert!(same(&resumed, &unbroken), "{resumed:#?}");
    // A whole report is there at once, drawings too, with the time at which it was made.
    let again = broken.run_whole(&setup);
    assert_eq!((again, broken.made()), (resumed.clone(), 5));
    assert_eq!(
        kept(&broken, &setup).expect("read"),
        Some(resumed.experiments[0].clone())
    );
    assert!(setup.shelf.trouble().is_none());
}

#[test]
fn measured_anew_nothing_old_is_used_and_what_is_new_is_kept() {
    let folder = tempfile::tempdir().expect("a folder");
    let setup = on(folder.path());
    let experiment = Counted::default();
    experiment.run_whole(&setup);
    let anew = Setup {
        shelf: setup.shelf.clone().anew(),
        ..setup.clone()
    };
    // Stopped after two new parts, the old ones are gone.
    assert_eq!(experiment.run_until(&anew, 3), Err(LabError::Stopped));
    assert_eq!((experiment.made(), parts(folder.path()).len()), (7, 2));
    experiment.run_whole(&setup);
    assert_eq!(experiment.made(), 10);
}

#[test]
fn any_other_setup_makes_anew_and_what_is_not_taken_does_not_matter() {
    let folder = tempfile::tempdir().expect("a folder");
    let session = folder.path().join("a.mcap");
    std::fs::write(&session, "one").expect("written");
    let surface = |triangles| {
        let raw = back::make(&back::BackOptions::with_triangles(triangles));
        Arc::new(Surface::new(raw).expect("a surface").0)
    };
    let scene = |text: &str, name: &str| Scene {
        name: name.to_owned(),
        scenario: Arc::new(Scenario::parse(text, name, None).expect("a scenario")),
    };
    let text = default_example().text;
    let base = Setup {
        mesh: Some(Mesh {
            name: "a".to_owned(),
            surface: surface(300),
        }),
        triangles: vec![300, 900],
        scene: Some(scene(text, "a.toml")),
        session: Some(session.clone()),
        seed: 1,
        ..on(&folder.path().join("kept"))
    };
    let changed = |change: &dyn Fn(&mut Setup)| {
        let mut setup = base.clone();
        change(&mut setup);
        setup
    };
    let other_session = folder.path().join("b.mcap");
    std::fs::write(&other_session, "one").expect("written");
    let others = [
        base.clone(),
        changed(&|s| s.quick = true),
        changed(&|s| s.mesh = None),
        changed(&|s| {
            s.mesh = Some(Mesh {
                name: "a".to_owned(),
                surface: surface(320),
            })
        }),
        changed(&|s| s.triangles = vec![900, 300]),
        changed(&|s| s.scene = None),
        changed(&|s| s.scene = Some(scene(&format!("{text}\n# a remark"), "a.toml"))),
        changed(&|s| s.scene = Some(scene(text, "b.toml"))),
        changed(&|s| s.session = None),
        changed(&|s| s.session = Some(other_session.clone())),
        changed(&|s| s.seed = 2),
        changed(&|s| s.seconds = Some(2.0)),
    ];
    let experiment = Counted::default();
    for (i, setup) in others.iter().enumerate() {
        experiment.run_whole(setup);
        assert_eq!(experiment.made(), 5 * (i + 1), "{i}");
    }
    // The same path with other contents.
    std::fs::write(&session, "two").expect("written");
    experiment.run_whole(&base);
    assert_eq!(experiment.made(), 5 * (others.len() + 1));
    std::fs::remove_file(&session).expect("removed");
    let refused = experiment.run_until(&base, usize::MAX).expect_err("gone");
    assert!(
        refused.to_string().contains("a.mcap: cannot be read"),
        "{refused}"
    );

    let untaken = lab::partition::Complexity;
    let shelf = |seed| {
        let setup = Setup {
            seed,
            quick: true,
            ..on(folder.path())
        };
        lab::run(&[&untaken], &setup, &mut Watch::new(&mut |_, _| true)).expect("runs")
    };
    assert_eq!(
        shelf(1).experiments,
        shelf(2).experiments,
        "kept: it takes no seed"
    );
}

#[test]
fn a_mesh_file_that_the_scene_names_belongs_to_its_shelf() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("a.obj"), "one").expect("written");
    let text = "format = 1\nname = \"a\"\n[surface]\nmesh = \"a.obj\"\n[stiffness]\n\
                key = [ { x = 0, y = 0, stiffness_n_per_mm = 0.5 } ]\n";
    let scenario = Scenario::parse(text, "a", Some(folder.path())).expect("a scenario");
    let setup = Setup {
        scene: Some(Scene {
            name: "a".to_owned(),
            scenario: Arc::new(scenario),
        }),
        ..Setup::default()
    };
    let name = || {
        Label::new("test", &setup)
            .expect("made")
            .expect("known")
            .folder_name()
    };
    let before = name();
    assert_eq!(before, name());
    std::fs::write(folder.path().join("a.obj"), "two").expect("written");
    assert_ne!(before, name());
}

#[test]
fn a_damaged_part_is_made_anew() {
    let folder = tempfile::tempdir().expect("a folder");
    let setup = on(folder.path());
    let experiment = Counted::default();
    let whole = experiment.run_whole(&setup);
    let files = parts(folder.path());
    assert_eq!(files.len(), 6, "five parts and the whole");
    let good: Vec<Vec<u8>> = files
        .iter()
        .map(|f| std::fs::read(f).expect("read"))
        .collect();
    type Damage = fn(&[u8]) -> Vec<u8>;
    let damages: [Damage; 6] = [
        |_| Vec::new(),
        |b| b[..b.len() / 2].to_vec(),
        |b| b[..b.len() - 1].to_vec(),
        |_| b"\xff\xfe\n{}".to_vec(),
        // Still JSON: one digit or letter of the part is another.
        |b| {
            let at = b.iter().position(|&c| c == b'\n').expect("three lines");
            let digit = (at..b.len())
                .find(|&i| b[i].is_ascii_digit())
                .unwrap_or(at + 1);
            let mut bytes = b.to_vec();
            bytes[digit] = if bytes[digit] == b'1' { b'2' } else { b'1' };
            bytes
        },
        |b| [b, b].concat(),
    ];
    for (i, damage) in damages.iter().enumerate() {
        for (file, good) in files.iter().zip(&good) {
            std::fs::write(file, damage(good)).expect("written");
        }
        let again = experiment.run_whole(&setup);
        assert_eq!(experiment.made(), 5 * (i + 2), "damage {i}");
        assert!(same(&again, &whole));
    }
    // One part's file in place of another's.
    std::fs::copy(&files[0], &files[1]).expect("copied");
    experiment.run_whole(&setup);
    assert!(same(&experiment.run_whole(&setup), &whole));
}

#[test]
fn only_what_comes_back_as_it_was_is_kept() {
    #[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Lossy {
        #[serde(skip_serializing_if = "Option::is_none", default = "some")]
        x: Option<f64>,
    }
    fn some() -> Option<f64> {
        Some(1.0)
    }
    let folder = tempfile::tempdir().expect("a folder");
    let shelf = Shelf::open(folder.path());
    let count = |key: &str| {
        let made = AtomicUsize::new(0);
        let value = |_: usize| -> Result<Vec<Option<f64>>, LabError> {
            shelf.part(key, || {
                made.fetch_add(1, Relaxed);
                Ok(match key {
                    "nan" => vec![Some(1.0), Some(f64::NAN)],
                    "infinite" => vec![Some(f64::NEG_INFINITY)],
                    _ => AWKWARD.into_iter().map(Some).chain([None]).collect(),
                })
            })
        };
        let [a, b] = [0, 1].map(|i| value(i).expect("made"));
        let bits = |v: Vec<Option<f64>>| -> Vec<_> {
            v.into_iter().map(|x| x.map(f64::to_bits)).collect()
        };
        assert_eq!(bits(a), bits(b), "{key}");
        made.into_inner()
    };
    assert_eq!((count("nan"), count("infinite"), count("good")), (2, 2, 1));
    let lossy = |x| shelf.part("lossy", || Ok(Lossy { x })).expect("made");
    assert_eq!(lossy(None), Lossy { x: None });
    assert_eq!(lossy(None), Lossy { x: None });
    // An error is not kept, and one key asked for as another kind is made.
    let fails: Result<f64, _> = shelf.part("error", || Err(LabError::Input("no".to_owned())));
    assert!(fails.is_err());
    assert_eq!(shelf.part("error", || Ok(2.0)), Ok(2.0));
    assert_eq!(
        shelf.part("error", || Ok(Value::from("text"))),
        Ok(Value::Number(2.0))
    );
    assert_eq!(shelf.part("error", || Ok(vec![1])), Ok(vec![1]));
}

#[test]
fn what_cannot_be_kept_is_no_error_and_said_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "").expect("written");
    // A file stands where the folder should be.
    let setup = on(&file);
    let experiment = Counted::default();
    let whole = experiment.run_whole(&setup);
    assert!(same(&whole, &experiment.run_whole(&Setup::default())));
    let told = setup.shelf.trouble().expect("said").to_owned();
    assert!(told.contains("not kept") && told.contains("file"), "{told}");
    assert_eq!(told.lines().count(), 1);
}

#[test]
fn old_shelves_go_and_nothing_else_does() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let shelf = |i: usize| at(&format!("{i:064x}"));
    for i in 0..80 {
        std::fs::create_dir(shelf(i)).expect("made");
        std::fs::write(shelf(i).join(label::FILE), "{}").expect("written");
        let used = std::time::UNIX_EPOCH + std::time::Duration::from_secs(1_000_000 + i as u64);
        let label = std::fs::File::options()
            .write(true)
            .open(shelf(i).join(label::FILE));
        label.expect("open").set_modified(used).expect("set");
    }
    // Not shelves: another name, and no label.
    for other in ["mine", &"f".repeat(64)] {
        std::fs::create_dir(at(other)).expect("made");
    }
    std::fs::write(at("mine").join(label::FILE), "{}").expect("written");
    Counted::default().run_whole(&on(folder.path()));
    let left = std::fs::read_dir(folder.path()).expect("read").count();
    assert_eq!(left, 64 + 2);
    assert!(!shelf(16).exists() && shelf(17).exists() && at("mine").exists());
    // Run again, its own stays though others were used later.
    tidy::tidy(folder.path(), &shelf(17));
    assert!(shelf(17).exists());
}
