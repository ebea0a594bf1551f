//! Opening the window.

use super::bench::Source;
use super::roles::Role;
use super::shell::{Start, Workbench};
use crate::scenario;
use crate::servo::{Halt, halt, halted, wait_for_halt};
use std::path::PathBuf;
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// The id under which a desktop knows the program and its settings are stored.
const APP_ID: &str = "dorsum";

/// How the workbench is opened.
#[derive(Clone, Debug)]
pub struct Options {
    /// The scenario; `None` opens the default example.
    pub source: Option<Source>,
    /// A recording to replay at once.
    pub recording: Option<PathBuf>,
    /// When the program started.
    pub started: Instant,
    /// Print how long the first frame took, and leave.
    pub first_frame: bool,
    /// Write a picture of the window, and leave.
    pub screenshot: Option<Screenshot>,
    /// Let the fingers press by themselves.
    pub press: bool,
    /// Dark or light; `None` takes the stored choice.
    pub dark: Option<bool>,
    /// Whose workspace; `None` takes the stored one.
    pub role: Option<Role>,
    /// Whether the trainee's own window opens too.
    pub trainee_window: bool,
    /// A panel to bring to the front, by its key.
    pub panel: Option<String>,
    /// What the Back view colours the skin by, by its key; `None` takes the stored choice.
    pub colour: Option<String>,
    /// How the Back view draws the skin, what it shows of the body, and for which eyes: words as it keeps them.
    pub look: Vec<String>,
    /// The experiment that the Lab panel shows, by its name; `None` takes the one shown last.
    pub experiment: Option<String>,
    /// A simulated device that is attached: key of its family, and of what goes wrong with it.
    pub emulator: Option<(&'static str, Option<&'static str>)>,
    /// Size of the window, points.
    pub size: (u16, u16),
}

/// A picture of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Screenshot {
    /// The PNG file.
    pub path: PathBuf,
    /// Time the scene is on show before, s.
    pub after_s: f64,
}

impl Default for Options {
    /// The default example at 1280×800.
    fn default() -> Self {
        Self {
            source: None,
            recording: None,
            started: Instant::now(),
            first_frame: false,
            screenshot: None,
            press: false,
            dark: None,
            role: None,
            trainee_window: false,
            panel: None,
            colour: None,
            look: Vec::new(),
            experiment: None,
            emulator: None,
            size: (1280, 800),
        }
    }
}

/// The user's folder for recordings; the working directory where the system has none.
fn recordings_folder() -> PathBuf {
    directories::ProjectDirs::from("", "", APP_ID).map_or_else(
        || PathBuf::from("recordings"),
        |dirs| dirs.data_dir().join("recordings"),
    )
}

/// What panels take as if it had been chosen in them.
fn recalled(options: &Options) -> Vec<(String, String)> {
    use super::panels::{BACK_VIEW_KEY, lab};
    let of = |panel: &str, key: &str, value: &Option<String>| {
        let value = value.as_ref()?;
        Some((panel.to_owned(), format!("{key}={value}")))
    };
    let chosen = [
        of(BACK_VIEW_KEY, "colour", &options.colour),
        of(lab::KEY, "experiment", &options.experiment),
    ];
    let look = (options.look.iter()).map(|word| (BACK_VIEW_KEY.to_owned(), word.clone()));
    chosen.into_iter().flatten().chain(look).collect()
}

/// Opens the workbench and returns when it is closed.
///
/// # Errors
/// One line: no display, a missing library, no OpenGL, or a picture that cannot be written.
pub fn run(options: Options) -> Result<(), String> {
    super::libraries::can_open()?;
    let source = options
        .source
        .clone()
        .unwrap_or_else(|| Source::Example(scenario::default_example()));
    let start = Start {
        source: Some(source),
        recording: options.recording.clone(),
        folder: recordings_folder(),
        dark: options.dark,
        role: options.role,
        trainee_window: options.trainee_window,
        panel: options.panel.clone(),
        recall: recalled(&options),
    };
    let (width, height) = (f32::from(options.size.0), f32::from(options.size.1));
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Dorsum")
            .with_app_id(APP_ID)
            .with_inner_size([width, height])
            .with_min_inner_size([640.0, 420.0]),
        renderer: eframe::Renderer::Glow,
        depth_buffer: 24,
        // A picture has the size that was asked for, not the one of the last time.
        persist_window: options.screenshot.is_none(),
        ..eframe::NativeOptions::default()
    };
    let (outcome_send, outcome) = mpsc::sync_channel(1);
    eframe::run_native(
        APP_ID,
        native,
        Box::new(move |cc| {
            let workbench = Workbench::new(cc, start);
            if options.press {
                workbench.shared().bench().press();
            }
            workbench.shared().bench().watch_devices();
            if let Some((family, fault)) = options.emulator {
                workbench.shared().bench().emulate(family, fault);
            }
            wake_on_halt(&cc.egui_ctx);
            Ok(Box::new(Errand {
                workbench,
                first_frame: options.first_frame,
                started: options.started,
                screenshot: options.screenshot,
                scene_since: None,
                told_window: false,
                outcome: outcome_send,
            }))
        }),
    )
    .map_err(|e| format!("the window cannot open: {e}"))?;
    outcome.try_recv().unwrap_or(Ok(()))
}

/// A window that has nothing to draw sleeps; a signal must wake it to be closed.
fn wake_on_halt(ctx: &egui::Context) {
    let ctx = ctx.clone();
    let thread = std::thread::Builder::new().name("halt".into());
    let waiting = thread.spawn(move || {
        wait_for_halt();
        ctx.request_repaint();
    });
    if let Err(e) = waiting {
        log::warn!("a signal closes the window only once it draws: {e}");
    }
}

/// The workbench, and what it was opened for: to stay, to be timed, or to be pictured.
struct Errand {
    workbench: Workbench,
    first_frame: bool,
    started: Instant,
    screenshot: Option<Screenshot>,
    /// Since when a scene is on show.
    scene_since: Option<Instant>,
    told_window: bool,
    outcome: mpsc::SyncSender<Result<(), String>>,
}

impl Errand {
    /// A frame is on the screen when the next one begins.
    fn time_first_frame(&mut self, ctx: &egui::Context) {
        let ms = self.started.elapsed().as_millis();
        if !self.told_window && ctx.cumulative_frame_nr() > 0 {
            self.told_window = true;
            println!("first frame after {ms} ms");
        }
        if self.workbench.frames_with_scene() > 0 {
            println!("first frame with the back after {ms} ms");
            self.first_frame = false;
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        ctx.request_repaint();
    }

    fn take_picture(&mut self, ctx: &egui::Context) {
        let Some(screenshot) = &self.screenshot else {
            return;
        };
        if self.scene_since.is_none() && self.workbench.frames_with_scene() > 0 {
            self.scene_since = Some(Instant::now());
        }
        super::panels::back_view::draw_finely(ctx);
        let due = Duration::try_from_secs_f64(screenshot.after_s).unwrap_or_default();
        if self.scene_since.is_some_and(|since| since.elapsed() >= due) {
            let path = screenshot.path.clone();
            let outcome = self.outcome.clone();
            let close = ctx.clone();
            ctx.request_screenshot(move |image| {
                let _ = outcome.try_send(write_png(&path, &image));
                close.send_viewport_cmd_to(egui::ViewportId::ROOT, egui::ViewportCommand::Close);
            });
            self.screenshot = None;
        }
        ctx.request_repaint_after(Duration::from_millis(16));
    }
}

fn write_png(path: &std::path::Path, image: &egui::ColorImage) -> Result<(), String> {
    let failed = |e: &dyn std::fmt::Display| format!("{}: cannot be written: {e}", path.display());
    let [width, height] = image.size;
    let size = |n: usize| u32::try_from(n).map_err(|e| failed(&e));
    let (width, height) = (size(width)?, size(height)?);
    let bytes: Vec<u8> = image
        .pixels
        .iter()
        .flat_map(|p| [p.r(), p.g(), p.b()])
        .collect();
    let file = std::fs::File::create(path).map_err(|e| failed(&e))?;
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(|e| failed(&e))?;
    writer.write_image_data(&bytes).map_err(|e| failed(&e))?;
    writer.finish().map_err(|e| failed(&e))
}

impl eframe::App for Errand {
    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        if self.first_frame {
            self.time_first_frame(ctx);
        }
        self.take_picture(ctx);
        // After a panic elsewhere the window stays and says so.
        if halted().is_some_and(|halt| halt != Halt::Panicked) {
            ctx.send_viewport_cmd_to(egui::ViewportId::ROOT, egui::ViewportCommand::Close);
        }
        self.workbench.logic(ctx, frame);
    }

    fn ui(&mut self, ui: &mut egui::Ui, frame: &mut eframe::Frame) {
        self.workbench.ui(ui, frame);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        self.workbench.save(storage);
    }

    fn on_exit(&mut self, gl: Option<&eframe::glow::Context>) {
        // No force while the recording is being finished.
        halt(Halt::Closed);
        self.workbench.on_exit(gl);
    }

    fn clear_color(&self, visuals: &egui::Visuals) -> [f32; 4] {
        self.workbench.clear_color(visuals)
    }

    fn persist_egui_memory(&self) -> bool {
        self.workbench.persist_egui_memory()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_a_png_of_the_windows_size() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.png");
        let image = egui::ColorImage::filled([7, 5], egui::Color32::from_rgb(1, 2, 3));
        write_png(&path, &image).expect("writes");
        let file = std::io::BufReader::new(std::fs::File::open(&path).expect("opens"));
        let reader = png::Decoder::new(file).read_info().expect("a PNG");
        assert_eq!((reader.info().width, reader.info().height), (7, 5));
        let nowhere = folder.path().join("none/a.png");
        let error = write_png(&nowhere, &image).expect_err("no folder");
        assert!(error.contains("cannot be written"));
    }
}
