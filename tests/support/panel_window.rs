//! A panel alone in a window, driven by its accessibility tree, and a bench that does what it is sent.

use dorsum::app::command::{self, Command};
use dorsum::app::panels::{Panel, PanelContext};
use dorsum::app::state::View;
use dorsum::app::theme::DARK;
use dorsum::scenario::{self, Scenario, Scene, Use};
use egui::{Key, Modifiers, PointerButton, Pos2};
use egui_kittest::{Harness, kittest::Queryable as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// A scene of a text.
pub fn scene_of(source: &str) -> Arc<Scene> {
    let scenario = Scenario::parse(source, "editors.toml", None).unwrap();
    Arc::new(scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true).unwrap())
}

/// A panel alone in a window, and a bench that does what it is sent.
pub struct Window {
    pub harness: Harness<'static>,
    pub view: Arc<Mutex<View>>,
    pub commands: mpsc::Receiver<Command>,
    pub closed: Arc<AtomicBool>,
    /// Every source that was sent.
    pub sent: Vec<String>,
    pub told: Vec<String>,
    /// What else was asked for.
    pub other: Vec<Command>,
}

impl Window {
    pub fn open(panel: impl Panel + 'static, source: &str, size: [f32; 2]) -> Self {
        let view = View {
            scene: Some(scene_of(source)),
            scene_generation: 1,
            theme: DARK,
            ..View::default()
        };
        let view = Arc::new(Mutex::new(view));
        let closed = Arc::new(AtomicBool::new(false));
        let (send, commands) = command::queue(Arc::new(|| {}));
        let (seen, is_closed) = (view.clone(), closed.clone());
        let mut panel = panel;
        let harness = Harness::builder()
            .with_size(size)
            .with_context_setup(|ctx| {
                egui_material_icons::initialize(ctx);
                DARK.apply(ctx);
            })
            .build_ui(move |ui| {
                let view = seen.lock().unwrap().clone();
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
        let mut window = Self {
            harness,
            view,
            commands,
            closed,
            sent: Vec::new(),
            told: Vec::new(),
            other: Vec::new(),
        };
        // The outline and the field come from threads of their own.
        let start = Instant::now();
        while start.elapsed() < Duration::from_millis(400) {
            window.frames(2);
            std::thread::sleep(Duration::from_millis(10));
        }
        window
    }

    /// Draws, and carries out what was sent as the bench does: the newest edit becomes the scene.
    pub fn frames(&mut self, n: usize) {
        for _ in 0..n {
            self.harness.run_steps(1);
            let mut newest = None;
            for command in self.commands.try_iter() {
                match command {
                    Command::EditScene { source } => {
                        self.sent.push(source.clone());
                        newest = Some(source);
                    }
                    Command::Tell(_, text) => self.told.push(text),
                    other => self.other.push(other),
                }
            }
            if let Some(source) = newest {
                let mut view = self.view.lock().unwrap();
                view.scene = Some(scene_of(&source));
                view.edit += 1;
            }
        }
    }

    /// Until what was last done has been sent: no oftener than 30 times a second.
    pub fn settle(&mut self) {
        self.frames(2);
        std::thread::sleep(Duration::from_millis(40));
        self.frames(3);
    }

    /// What the scene says after all that was sent.
    pub fn scenario(&self) -> Scenario {
        let view = self.view.lock().unwrap();
        let source = &view.scene.as_ref().unwrap().scenario.source;
        Scenario::parse(source, "sent.toml", None).unwrap()
    }

    pub fn click(&mut self, name: &str) {
        self.harness.get_by_label(name).click();
        self.settle();
    }

    pub fn set(&mut self, name: &str, value: f64) {
        self.harness.get_by_label(name).set_value_accesskit(value);
        self.settle();
    }

    pub fn at(&self, name: &str) -> Pos2 {
        self.harness.get_by_label(name).rect().center()
    }

    pub fn pointer(&mut self, at: Pos2, pressed: Option<bool>, modifiers: Modifiers) {
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        self.harness.event(egui::Event::PointerMoved(at));
        if let Some(pressed) = pressed {
            self.harness.event(egui::Event::PointerButton {
                pos: at,
                button: PointerButton::Primary,
                pressed,
                modifiers,
            });
        }
        self.frames(1);
    }

    pub fn drag(&mut self, from: Pos2, by: egui::Vec2, modifiers: Modifiers) {
        self.pointer(from, None, modifiers);
        self.pointer(from, Some(true), modifiers);
        for i in 1..=8 {
            self.pointer(from + by * (i as f32 / 8.0), None, modifiers);
        }
        self.pointer(from + by, Some(false), modifiers);
        self.harness
            .event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.settle();
    }

    pub fn press(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.event(egui::Event::ModifiersChanged(modifiers));
        for pressed in [true, false] {
            self.harness.event(egui::Event::Key {
                key,
                pressed,
                modifiers,
                repeat: false,
                physical_key: None,
            });
        }
        self.frames(1);
        self.harness
            .event(egui::Event::ModifiersChanged(Modifiers::NONE));
        self.settle();
    }

    pub fn says(&self, text: &str) -> bool {
        self.harness
            .query_all_by_label_contains(text)
            .next()
            .is_some()
    }
}
