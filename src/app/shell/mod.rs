//! The shell around the panels: menu, dock, own windows, status bar, keys.

mod apply;
mod frames;
mod menu;
mod palette;
mod pump;
mod status;
mod trainee;
mod windows;

use super::bench::{Bench, Source, Wake};
use super::command::{self, Command, CommandSender};
use super::dock::{self, Layout, Panels};
use super::messages::Level;
use super::panels::{self, PanelContext};
use super::roles::Role;
use super::state::{FrameTiming, GhostView, PartCost, Parts, View};
use super::study::SharedStudy;
use super::theme::Theme;
use crate::scenario::{Item, Use};
use egui_material_icons::icons as icon;
use frames::FrameMeter;
use palette::Palette;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};

/// What the main window and the panels' own windows share.
pub struct Shared {
    bench: Mutex<Bench>,
    panels: Panels,
    /// Those of the trainee's own window.
    trainee: Panels,
    send: CommandSender,
    chrome: Mutex<Chrome>,
}

/// The part of a [`View`] that the bench knows nothing of.
#[derive(Clone)]
struct Chrome {
    role: Role,
    trainee_window: bool,
    theme: Theme,
    gl: Option<Arc<eframe::glow::Context>>,
    frame: FrameTiming,
    parts: Parts,
    study: SharedStudy,
    /// Whether a Back view, plots and the Partition panel are open, be it behind another tab.
    drawn: bool,
    plotted: bool,
    partitioned: bool,
    /// Windows beside the main one, to be woken with it.
    windows: Vec<egui::ViewportId>,
}

impl Shared {
    /// The bench. Locked for moments only, never while a panel is drawn.
    pub fn bench(&self) -> MutexGuard<'_, Bench> {
        self.bench.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn chrome(&self) -> MutexGuard<'_, Chrome> {
        self.chrome.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The state at this instant, as the main window and the panels' own windows show it.
    pub fn view(&self) -> View {
        let role = self.chrome().role;
        self.view_of(role)
    }

    /// The state at this instant, as it is shown to somebody in `role`.
    pub fn view_of(&self, role: Role) -> View {
        let mut view = View::default();
        self.bench().fill(&mut view, role.sees_truth());
        let chrome = self.chrome();
        view.role = role;
        view.trainee_window = chrome.trainee_window;
        view.theme = chrome.theme;
        view.gl.clone_from(&chrome.gl);
        view.frame = chrome.frame;
        view.parts = chrome.parts.clone();
        view.study = chrome.study.clone();
        view.purpose = Use {
            fingers: view.devices.len(),
            live: view.ring_bytes > 0,
            drawn: chrome.drawn,
            deformed: chrome.drawn,
            recorded: view.recorder.recording.is_some(),
            plotted: chrome.plotted,
            partitioned: chrome.partitioned,
            coloured: view.parts.has(Item::SurfaceColour),
            bones_drawn: view.parts.has(Item::DrawnBones),
            named: view.parts.has(Item::LandmarkNames),
            hands_drawn: view.parts.has(Item::HandModel),
            two_eyes: view.parts.has(Item::SecondEye),
            ellipse_edited: view.parts.has(Item::EllipseEditor),
            stiffness_edited: view.parts.has(Item::StiffnessEditor),
            scenario_edited: view.parts.has(Item::ScenarioEditor),
            listed: view.parts.has(Item::Thumbnails),
            browsed: view.parts.has(Item::SessionPictures),
            ghosts: !view.ghosts.is_empty(),
            compared: view.parts.has(Item::Comparison),
            passivity: view.hardware.fingers.iter().any(|f| f.limits.passivity),
        };
        report_ghosts(&view);
        view
    }

    /// Draws a panel as things stand, in whichever window.
    fn draw(&self, ui: &mut egui::Ui, slot: &dock::PanelSlot, view: &View) {
        let cx = PanelContext {
            view,
            send: &self.send,
        };
        dock::draw(ui, slot, &cx);
    }
}

/// Tells the ledger what ghosts hold.
fn report_ghosts(view: &View) {
    if view.ghosts.is_empty() {
        view.parts.remove(Item::Ghosts);
        return;
    }
    let bytes = |ghost: &GhostView| {
        let history = ghost.history.lock().unwrap_or_else(PoisonError::into_inner);
        history.bytes()
    };
    let cost = PartCost {
        bytes: view.ghosts.iter().map(bytes).sum(),
        cost_us: None,
    };
    view.parts.report(Item::Ghosts, cost);
}

/// How a workbench starts.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// What opens first; `None` opens nothing.
    pub source: Option<Source>,
    /// A recording to replay at once.
    pub recording: Option<PathBuf>,
    /// Where recordings are kept.
    pub folder: PathBuf,
    /// Dark or light; `None` takes the stored choice, or dark.
    pub dark: Option<bool>,
    /// Whose workspace; `None` takes the stored one, or a researcher's.
    pub role: Option<Role>,
    /// Whether the trainee's own window opens too.
    pub trainee_window: bool,
    /// A panel to bring to the front.
    pub panel: Option<String>,
    /// What panels take as if they had chosen it in an earlier run: key and text.
    pub recall: Vec<(String, String)>,
}

/// The workbench as eframe runs it.
pub struct Workbench {
    shared: Arc<Shared>,
    commands: mpsc::Receiver<Command>,
    /// One for each of [`Role::ALL`].
    layouts: [Layout; Role::ALL.len()],
    dark: bool,
    palette: Option<Palette>,
    toasts: egui_notify::Toasts,
    toasted: u64,
    /// What was shown of late, and when, s: what repeats is shown once.
    shown: Vec<(String, f64)>,
    title: String,
    meter: FrameMeter,
    frames_with_scene: u64,
}

/// The same message is not shown over the window again for this long, s.
const SHOWN_ONCE_S: f64 = 10.0;

const ROLE_KEY: &str = "role";
const DARK_KEY: &str = "dark";

/// Where the layout of a role is stored.
fn layout_key(role: Role) -> String {
    format!("layout.{}", role.key())
}

/// Where what a panel chose to remember is stored.
fn kept_key(panel: &str) -> String {
    format!("panel.{panel}")
}

impl Workbench {
    /// A workbench in a window that is about to open.
    pub fn new(cc: &eframe::CreationContext<'_>, start: Start) -> Self {
        let ctx = cc.egui_ctx.clone();
        egui_material_icons::initialize(&ctx);
        let stored = |key: &str| cc.storage.and_then(|s| s.get_string(key));
        let dark = start
            .dark
            .or_else(|| stored(DARK_KEY).map(|s| s == "true"))
            .unwrap_or(true);
        let theme = Theme::of(dark);
        theme.apply(&ctx);
        let wake: Wake = {
            let ctx = ctx.clone();
            Arc::new(move || ctx.request_repaint_of(egui::ViewportId::ROOT))
        };
        let mut listed = panels::all();
        for panel in &mut listed {
            let key = panel.key();
            let kept = stored(&kept_key(key));
            let chosen = start.recall.iter().filter(|(of, _)| of == key);
            for kept in kept.iter().chain(chosen.map(|(_, text)| text)) {
                panel.recall(kept);
            }
        }
        let panels = dock::slots(listed);
        let role = start
            .role
            .or_else(|| Role::named(&stored(ROLE_KEY)?))
            .unwrap_or_default();
        let mut layouts = Role::ALL.map(|role| {
            cc.storage
                .and_then(|s| eframe::get_value::<Layout>(s, &layout_key(role)))
                .filter(|l| l.fits(&panels))
                .unwrap_or_else(|| Layout::of(role, &panels))
        });
        let layout = &mut layouts[role.index()];
        if let Some(slot) = panels
            .iter()
            .find(|p| Some(p.key) == start.panel.as_deref())
        {
            layout.show(slot.key);
        }
        let (send, commands) = command::queue(wake.clone());
        let mut bench = Bench::new(wake, start.folder);
        bench.set_drawn(!layout.is_closed(panels::BACK_VIEW_KEY));
        if let Some(source) = start.source {
            bench.open(source);
        }
        if let Some(path) = start.recording {
            send.send(Command::OpenRecording(path));
        }
        let shared = Arc::new(Shared {
            bench: Mutex::new(bench),
            panels,
            trainee: dock::slots(panels::trainee()),
            send,
            chrome: Mutex::new(Chrome {
                role,
                trainee_window: start.trainee_window,
                theme,
                gl: cc.gl.clone(),
                frame: FrameTiming::default(),
                parts: Parts::default(),
                study: SharedStudy::default(),
                drawn: true,
                plotted: true,
                partitioned: false,
                windows: Vec::new(),
            }),
        });
        if let Err(e) = pump::start(&shared, ctx) {
            let text = format!("the window cannot follow the servo: {e}");
            shared.bench().tell(Level::Error, text);
        }
        Self {
            shared,
            commands,
            layouts,
            dark,
            palette: None,
            toasts: egui_notify::Toasts::default()
                .with_anchor(egui_notify::Anchor::BottomRight)
                .with_margin(egui::vec2(8.0, 36.0)),
            toasted: 0,
            shown: Vec::new(),
            title: String::new(),
            meter: FrameMeter::default(),
            frames_with_scene: 0,
        }
    }

    /// What is shared with the panels' own windows.
    pub fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }

    /// Where the panels are.
    pub fn layout(&self) -> &Layout {
        &self.layouts[self.role().index()]
    }

    fn layout_mut(&mut self) -> &mut Layout {
        let index = self.role().index();
        &mut self.layouts[index]
    }

    /// Whose workspace is shown.
    pub fn role(&self) -> Role {
        self.shared.chrome().role
    }

    /// Frames drawn since a scene is open.
    pub fn frames_with_scene(&self) -> u64 {
        self.frames_with_scene
    }

    fn set_title(&mut self, ctx: &egui::Context, view: &View) {
        let title = match &view.scene {
            Some(scene) if view.unsaved && view.playback.is_none() => {
                format!("Dorsum — {} (edited)", scene.scenario.name)
            }
            Some(scene) => format!("Dorsum — {}", scene.scenario.name),
            None => "Dorsum".into(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    /// Warnings and errors also appear over the window for some seconds.
    fn toast(&mut self, ctx: &egui::Context, view: &View) {
        let told = self.shared.bench().told();
        let new = usize::try_from(told - self.toasted.min(told)).unwrap_or(usize::MAX);
        self.toasted = told;
        for message in view.messages.iter().rev().take(new.min(3)).rev() {
            let (icon, colour, seconds) = match message.level {
                Level::Info => continue,
                Level::Warning => (icon::ICON_WARNING, view.theme.warning, 5),
                Level::Error => (icon::ICON_ERROR, view.theme.fault, 9),
            };
            let now_s = ctx.input(|i| i.time);
            self.shown.retain(|(_, at_s)| now_s - at_s < SHOWN_ONCE_S);
            if self.shown.iter().any(|(text, _)| *text == message.text) {
                continue;
            }
            self.shown.push((message.text.clone(), now_s));
            self.toasts
                .custom(&message.text, icon.codepoint.to_owned(), colour)
                .duration(Some(std::time::Duration::from_secs(seconds)));
        }
        self.toasts.show(ctx);
    }
}

impl eframe::App for Workbench {
    fn logic(&mut self, ctx: &egui::Context, frame: &mut eframe::Frame) {
        while let Ok(command) = self.commands.try_recv() {
            self.apply(ctx, command);
        }
        let work_ms = frame.info().cpu_usage.map_or(0.0, |s| f64::from(s) * 1e3);
        let timing = self.meter.count(std::time::Instant::now(), work_ms);
        let layout = &self.layouts[self.role().index()];
        let mut chrome = self.shared.chrome();
        chrome.frame = timing;
        chrome.theme = Theme::of(self.dark);
        chrome.drawn = !layout.is_closed(panels::BACK_VIEW_KEY) || chrome.trainee_window;
        chrome.plotted = !layout.is_closed(panels::PLOTS_KEY);
        chrome.partitioned = !layout.is_closed(panels::partition::KEY);
        let (drawn, plotted) = (chrome.drawn, chrome.plotted);
        let conceals = chrome.role == Role::Trainee || chrome.trainee_window;
        let trainee = chrome.trainee_window.then(trainee::viewport_id);
        let popped = layout.popped().map(windows::viewport_id);
        chrome.windows = popped.chain(trainee).collect();
        drop(chrome);
        let mut bench = self.shared.bench();
        bench.set_plotted(plotted);
        bench.set_drawn(drawn);
        bench.conceal(conceals);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let ctx = ui.ctx().clone();
        let view = self.shared.view();
        self.frames_with_scene += u64::from(view.scene.is_some());
        self.set_title(&ctx, &view);
        menu::keys(&ctx, &self.shared, view.playback.is_some());
        let theme = view.theme;
        egui::Panel::top("menu")
            .frame(
                egui::Frame::new()
                    .fill(theme.panel)
                    .inner_margin(egui::Margin::symmetric(8, 4)),
            )
            .show(ui, |ui| {
                menu::bar_ui(ui, &self.shared, self.layout(), &view)
            });
        egui::Panel::bottom("status")
            .frame(
                egui::Frame::new()
                    .fill(theme.panel)
                    .inner_margin(egui::Margin::symmetric(8, 3)),
            )
            .show(ui, |ui| status::ui(ui, &view, &self.shared.send));
        egui::CentralPanel::no_frame().show(ui, |ui| {
            ui.painter()
                .rect_filled(ui.max_rect(), 0.0, theme.background);
            let shared = self.shared.clone();
            self.layout_mut()
                .ui(ui, &shared.panels, &shared.send, &mut |ui, slot| {
                    shared.draw(ui, slot, &view);
                });
        });
        windows::show(&ctx, &self.shared, self.layout());
        trainee::show(&ctx, &self.shared, &view);
        let closed = (self.shared.panels.iter()).filter(|slot| self.layout().is_closed(slot.key));
        let unseen = self.shared.trainee.iter().filter(|_| !view.trainee_window);
        for slot in closed.chain(unseen) {
            // A closed panel is drawn nowhere, so its lock is free; were it not, the next frame comes.
            if let Ok(mut panel) = slot.panel.try_lock() {
                panel.release(&view);
            }
        }
        if let Some(palette) = &mut self.palette
            && palette.ui(&ctx, &self.shared)
        {
            self.palette = None;
        }
        self.toast(&ctx, &view);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        for role in Role::ALL {
            eframe::set_value(storage, &layout_key(role), &self.layouts[role.index()]);
        }
        storage.set_string(ROLE_KEY, self.role().key().to_owned());
        storage.set_string(DARK_KEY, self.dark.to_string());
        for slot in self.shared.panels.iter() {
            let panel = slot.panel.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(kept) = panel.keep() {
                storage.set_string(&kept_key(slot.key), kept);
            }
        }
    }

    fn on_exit(&mut self, _gl: Option<&eframe::glow::Context>) {
        self.shared.bench().shut_down();
    }

    fn clear_color(&self, _visuals: &egui::Visuals) -> [f32; 4] {
        Theme::of(self.dark).background.to_normalized_gamma_f32()
    }

    fn persist_egui_memory(&self) -> bool {
        false
    }
}
