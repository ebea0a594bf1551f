//! The Lab panel: what it runs and shows is what the lab itself says; closed, it holds nothing.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

use dorsum::app::command::{self, Command};
use dorsum::app::messages::Level;
use dorsum::app::panels::lab::LabPanel;
use dorsum::app::panels::{Panel as _, PanelContext};
use dorsum::app::state::View;
use dorsum::app::theme::{DARK, LIGHT};
use dorsum::lab::{self, Document, Drawing, Setup, Shelf, Watch};
use egui_kittest::{Harness, kittest::Queryable as _};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// The panel alone in a window without OpenGL.
struct Window {
    harness: Harness<'static>,
    panel: Arc<Mutex<LabPanel>>,
    closed: Arc<AtomicBool>,
    commands: mpsc::Receiver<Command>,
}

impl Window {
    fn open(shelf: &Path, view: View) -> Self {
        let theme = view.theme;
        let panel = Arc::new(Mutex::new(LabPanel::keeping_on(Shelf::open(shelf))));
        let closed = Arc::new(AtomicBool::new(false));
        let (shown, is_closed) = (panel.clone(), closed.clone());
        let (send, commands) = command::queue(Arc::new(|| {}));
        let harness = Harness::builder()
            // High enough for all that is shown: what is scrolled away has no name.
            .with_size([1100.0, 2600.0])
            .with_context_setup(move |ctx| {
                egui_material_icons::initialize(ctx);
                theme.apply(ctx);
            })
            .build_ui(move |ui| {
                let mut panel = shown.lock().unwrap();
                if is_closed.load(Ordering::Relaxed) {
                    panel.release(&view);
                    return;
                }
                let cx = PanelContext {
                    view: &view,
                    send: &send,
                };
                panel.ui(ui, &cx);
            });
        Self {
            harness,
            panel,
            closed,
            commands,
        }
    }

    fn click(&mut self, name: &str) {
        self.harness.get_by_label(name).click();
        self.harness.run_steps(3);
    }

    fn type_into(&mut self, name: &str, text: &str) {
        self.harness.get_by_label(name).focus();
        self.harness.run_steps(2);
        self.harness.get_by_label(name).type_text(text);
        self.harness.run_steps(3);
    }

    fn has(&self, text: &str) -> bool {
        self.harness.query_all_by_label(text).next().is_some()
    }

    fn has_part(&self, text: &str) -> bool {
        (self.harness.query_all_by_label_contains(text))
            .next()
            .is_some()
    }

    fn found(&self) -> Option<Arc<Document>> {
        let panel = self.panel.lock().unwrap();
        panel.laboratory().found().map(|f| f.document.clone())
    }

    fn wait(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !done(self) {
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "{what} did not come"
            );
            self.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(5));
        }
        self.harness.run_steps(3);
    }
}

const QUICK: &str = "deform-curve-arrays";

#[test]
fn an_experiment_is_run_and_all_that_it_found_is_shown_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for theme in [DARK, LIGHT] {
        let view = View {
            theme,
            ..support::running()
        };
        let mut window = Window::open(&folder.path().join(format!("{}", theme.dark)), view);
        assert!(window.has("No experiment is chosen"));
        for experiment in lab::all() {
            assert!(
                window.has(experiment.name()),
                "{} is not listed",
                experiment.name()
            );
        }
        window.click(QUICK);
        window.harness.run_steps(5);
        assert!(window.has("No results yet"));
        window.click("Run");
        window.wait("a result", |w| w.found().is_some());
        let document = window.found().unwrap();
        let report = &document.experiments[0];
        assert_eq!(report.experiment, QUICK);
        for verdict in &report.verdicts {
            assert!(window.has_part(&verdict.measured), "{}", verdict.measured);
            assert!(window.has_part(&verdict.goal));
        }
        assert!(window.has("Holds") && window.has_part("verdicts hold"));
        for figure in &report.figures {
            let titles: Vec<&str> = match &figure.drawing {
                Drawing::Plots(plots) => plots.iter().map(|p| &*p.title).collect(),
                Drawing::Map(map) => vec![&map.title],
            };
            for title in titles {
                assert!(window.has(&format!("Figure: {title}")), "{title}");
            }
        }
        for table in &report.tables {
            assert!(window.has(&table.title));
            for column in table.columns() {
                assert!(window.has(&format!("Sort {} by {}", table.name, column.name)));
            }
            for cell in table.rows().iter().flatten() {
                assert!(window.has(&cell.short()), "{cell:?}");
            }
        }
        for note in &report.notes {
            assert!(window.has(note));
        }
        assert!(window.has_part(document.build.as_deref().unwrap()));
        window.harness.check_accessibility();
    }
}

#[test]
fn tables_are_sorted_by_a_click_and_copied_with_every_digit() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(folder.path(), support::running());
    window.click(QUICK);
    window.click("Run");
    window.wait("a result", |w| w.found().is_some());
    let table = window.found().unwrap().experiments[0].tables[0].clone();
    let errors: Vec<f64> = (0..table.rows().len())
        .filter_map(|row| table.cell(row, "largest error").number())
        .collect();
    let below = |window: &Window, text: &str| {
        let rect = window.harness.get_all_by_label(text).next().unwrap().rect();
        rect.top()
    };
    let shown = |x: f64| lab::Value::from(x).short();
    let largest = shown(errors.iter().copied().fold(0.0, f64::max));
    let least = shown(
        errors
            .iter()
            .copied()
            .filter(|e| *e > 0.0)
            .fold(f64::MAX, f64::min),
    );
    let head = format!("Sort {} by largest error", table.name);
    window.click(&head);
    assert!(
        below(&window, &least) < below(&window, &largest),
        "the smallest first"
    );
    window.click(&head);
    assert!(
        below(&window, &least) > below(&window, &largest),
        "the other way round"
    );

    window
        .harness
        .get_by_label(&format!("Copy {} as CSV", table.name))
        .click();
    window.harness.step();
    let copied = (0..3).find_map(|_| {
        let output = &window.harness.output().platform_output;
        let text = output.commands.iter().find_map(|c| match c {
            egui::OutputCommand::CopyText(text) => Some(text.clone()),
            _ => None,
        });
        if text.is_none() {
            window.harness.step();
        }
        text
    });
    assert_eq!(copied.unwrap().as_bytes(), table.csv().unwrap());
}

#[test]
fn a_run_is_cancelled_and_what_was_kept_comes_back_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(folder.path(), support::running());
    // Minutes, were it not stopped.
    window.click("contact-torture");
    window.click("Quick look");
    window.click("Run");
    window.wait("progress", |w| w.has_part("contact-torture: "));
    assert!(!window.has("Run"));
    window.click("Cancel the experiment");
    window.wait("the end", |w| w.has("Run"));
    assert!(window.has_part("Stopped. Finished parts are kept"));
    assert!(window.found().is_none());

    let setup = Setup {
        quick: true,
        shelf: Shelf::open(folder.path()),
        ..Setup::default()
    };
    let experiment = lab::select(QUICK);
    let kept = lab::run(&experiment, &setup, &mut Watch::new(&mut |_, _| true)).unwrap();
    let mut second = Window::open(folder.path(), support::running());
    second.click(QUICK);
    second.wait("what was kept", |w| w.found().is_some());
    let found = second.found().unwrap();
    assert_eq!(found.experiments, kept.experiments, "not measured again");
    // Under other choices it is something else, and that is said.
    second.click("Quick look");
    assert!(second.has_part("of other choices"));
    second.click("Quick look");
    assert!(!second.has_part("of other choices"));
    second.click("Measure anew");
    second.wait("a new result", |w| {
        w.found()
            .is_some_and(|d| d.experiments[0].measured != kept.experiments[0].measured)
    });
}

#[test]
fn a_choice_that_cannot_be_used_is_told_and_nothing_runs() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(folder.path(), support::running());
    let takes = |e: &&&dyn lab::Experiment| e.takes().contains(&lab::Choice::Triangles);
    let taker = lab::all().iter().find(takes).unwrap();
    window.click(QUICK);
    assert!(!window.has("Triangles"), "it takes none");
    window.click(taker.name());
    window.type_into("Triangles", "300; 900");
    assert!(window.has_part("with commas between are allowed"));
    window.click("Run");
    assert!(window.has("Run"), "nothing runs");
}

#[test]
fn results_are_saved_as_files_and_closing_forgets_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = Window::open(&folder.path().join("shelf"), support::running());
    window.click(QUICK);
    window.click("Run");
    window.wait("a result", |w| w.found().is_some());
    let out = folder.path().join("report/here");
    window.type_into("Folder", &out.display().to_string());
    window.click("Save report to folder");
    let Ok(Command::Tell(level, text)) = window.commands.recv_timeout(Duration::from_secs(60))
    else {
        panic!("it is told how that went");
    };
    assert_eq!(level, Level::Info, "{text}");
    for file in ["html", "json", "txt"] {
        assert!(out.join(format!("{QUICK}.{file}")).is_file(), "{file}");
    }
    // A folder that cannot be made: below a file.
    window.type_into("Folder", &format!("/{QUICK}.html/x"));
    window.click("Save report to folder");
    let Ok(Command::Tell(level, text)) = window.commands.recv_timeout(Duration::from_secs(60))
    else {
        panic!("it is told how that went");
    };
    assert!(
        level == Level::Error && text.contains("cannot be written"),
        "{text}"
    );

    window.closed.store(true, Ordering::Relaxed);
    window.harness.run_steps(2);
    assert!(
        window.found().is_none()
            && window
                .panel
                .lock()
                .unwrap()
                .laboratory()
                .progress()
                .is_none()
    );
    let chosen = window.panel.lock().unwrap().keep();
    assert_eq!(
        chosen.as_deref(),
        Some("experiment=deform-curve-arrays quick=true")
    );
    // Opened again, the shelf still has them.
    window.closed.store(false, Ordering::Relaxed);
    window.wait("what was kept", |w| w.found().is_some());
}

#[test]
fn what_was_chosen_comes_back_in_the_next_run_and_nonsense_is_left() {
    let mut panel = LabPanel::default();
    assert_eq!(panel.keep(), None);
    for nonsense in ["", "experiment", "experiment=none", "=", "quick"] {
        panel.recall(nonsense);
        assert_eq!(panel.keep(), None, "{nonsense}");
    }
    panel.recall("experiment=contact-torture quick=false");
    assert_eq!(
        panel.keep().as_deref(),
        Some("experiment=contact-torture quick=false")
    );
}
