//! The Devices panel over a hand-made state: names, wishes, what is said of no device, of a fault and of a stiff scene.
#![cfg(feature = "gui")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod support;

use dorsum::app::command::{self, Command};
use dorsum::app::dock;
use dorsum::app::hardware::{Attached, DeviceWish, FingerDevice, Hardware, InUse, StiffnessChoice};
use dorsum::app::panels::{self, PanelContext};
use dorsum::app::roles::Role;
use dorsum::app::shell::Start;
use dorsum::app::state::View;
use dorsum::app::theme::{DARK, Theme};
use dorsum::device::hid::arms::WOODEN;
use dorsum::device::hid::guard::Condition;
use dorsum::device::hid::report::wooden;
use dorsum::device::hid::transport::{Gone, Port, REPORT};
use dorsum::device::stable::Stable;
use dorsum::device::{Calibration, Device, Family as _, Found, Vitals};
use dorsum::servo::{Health, Limits};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::{Duration, Instant};

/// A board that reports each millisecond; its encoders jump when told.
struct Board {
    counter: i16,
    jumps: Arc<AtomicBool>,
}

impl Port for Board {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        if wait_ms == 0 {
            return Ok(0);
        }
        std::thread::sleep(Duration::from_millis(1));
        self.counter = self.counter.wrapping_add(1);
        // To and fro, so that one of the steps comes without a delay that would explain it.
        let away = self.jumps.load(Ordering::Relaxed) && self.counter % 2 == 0;
        let far = if away { 3000 } else { 0 };
        let report = wooden::In {
            encoders: [0, self.counter % 2, far],
            counter: self.counter,
        };
        into[..wooden::IN_BYTES].copy_from_slice(&report.encode());
        Ok(wooden::IN_BYTES)
    }

    fn write(&mut self, _report: &[u8]) -> Result<(), Gone> {
        Ok(())
    }
}

/// An arm whose link runs.
struct Running {
    _device: Box<dyn Device>,
    vitals: Arc<Vitals>,
    jumps: Arc<AtomicBool>,
}

impl Running {
    fn start() -> Self {
        let jumps = Arc::new(AtomicBool::new(false));
        let port = Board {
            counter: 0,
            jumps: jumps.clone(),
        };
        let mut calibration = WOODEN.defaults();
        (calibration.guards.silence_ms, calibration.guards.frozen_ms) = (100.0, 100.0);
        let device = WOODEN.open_port(Box::new(port), &calibration).unwrap();
        let vitals = device.vitals().unwrap();
        let running = Self {
            _device: Box::new(device),
            vitals,
            jumps,
        };
        running.until(|condition| condition == Condition::Good);
        running
    }

    fn until(&self, wanted: impl Fn(Condition) -> bool) -> Condition {
        let start = Instant::now();
        loop {
            let now = self.vitals.condition();
            if wanted(now) {
                return now;
            }
            assert!(start.elapsed().as_secs() < 20, "{now:?}");
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

fn found() -> Found {
    Found {
        family: "woodenhaptics",
        place: "/dev/hidraw3".into(),
        title: "WoodenHaptics".into(),
        serial: Some("A7".into()),
        note: None,
    }
}

fn in_use(vitals: Option<Arc<Vitals>>) -> InUse {
    let calibration = WOODEN.defaults();
    let capabilities = WOODEN.capabilities(&calibration);
    InUse {
        found: found(),
        emulated: false,
        stable: Stable {
            told_n_per_mm: 0.31,
            passive_n_per_mm: 0.66,
            coupled_n_per_mm: 1.33,
            quantised_n_per_mm: 2.0,
        },
        capabilities,
        calibration,
        vitals,
    }
}

fn finger(device: Option<InUse>) -> FingerDevice {
    let limits = (device.as_ref()).map_or_else(Limits::default, |d| Limits::of(&d.capabilities));
    FingerDevice {
        name: "Mouse".into(),
        device: device.map(Arc::new),
        gone: false,
        sunk: false,
        limits,
        stiffness: StiffnessChoice::AsIs,
        test: None,
    }
}

/// The left finger moved by an arm, the right one by the mouse; a SpaceMouse is attached too.
fn hardware(vitals: Option<Arc<Vitals>>) -> Hardware {
    let space = Found {
        family: "spacemouse",
        place: "/dev/hidraw5".into(),
        title: "SpaceMouse".into(),
        serial: None,
        note: None,
    };
    Hardware {
        attached: vec![
            Attached {
                found: found(),
                emulated: false,
                finger: Some(0),
                trouble: None,
            },
            Attached {
                found: space,
                emulated: false,
                finger: None,
                trouble: Some("/dev/hidraw5: you may not open it".into()),
            },
        ],
        fingers: vec![finger(Some(in_use(vitals))), finger(None)],
        missing: vec![("openhaptics", "libHD.so is not installed".into())],
        folder: PathBuf::from("/home/somebody/.local/share/dorsum/devices"),
        ..Hardware::default()
    }
}

fn view(hardware: Hardware) -> View {
    let mut view = support::running();
    view.hardware = Arc::new(hardware);
    view.live.health = Health::Good;
    view.live.record.n_fingers = 2;
    for i in 0..2 {
        view.live.record.fingers[i] = view.fingers[i];
    }
    view
}

/// The panel alone in a window as wide as the right column.
struct Panel {
    harness: Harness<'static>,
    view: Arc<Mutex<View>>,
    commands: mpsc::Receiver<Command>,
}

impl Panel {
    fn open(first: View, size: [f32; 2]) -> Self {
        let view = Arc::new(Mutex::new(first));
        let (send, commands) = command::queue(Arc::new(|| {}));
        let seen = view.clone();
        let mut panel = panels::devices::DevicesPanel::default();
        let harness = Harness::builder()
            .with_size(size)
            .with_context_setup(|ctx| {
                egui_material_icons::initialize(ctx);
                DARK.apply(ctx);
            })
            .build_ui(move |ui| {
                let view = seen.lock().unwrap().clone();
                let cx = PanelContext {
                    view: &view,
                    send: &send,
                };
                panels::Panel::ui(&mut panel, ui, &cx);
            });
        let mut panel = Self {
            harness,
            view,
            commands,
        };
        panel.draw();
        panel
    }

    fn tall(first: View) -> Self {
        Self::open(first, [404.0, 1800.0])
    }

    fn draw(&mut self) {
        self.harness.run_steps(3);
    }

    fn click(&mut self, name: &str) {
        self.harness.get_by_label(name).click();
        self.draw();
    }

    fn change(&mut self, change: impl FnOnce(&mut View)) {
        change(&mut self.view.lock().unwrap());
        self.draw();
    }

    fn hardware(&mut self, change: impl FnOnce(&mut Hardware)) {
        self.change(|view| change(Arc::make_mut(&mut view.hardware)));
    }

    fn says(&self, text: &str) -> bool {
        (self.harness.query_all_by_label_contains(text))
            .next()
            .is_some()
    }

    fn is_greyed(&self, name: &str) -> bool {
        let node = self.harness.get_by_label(name);
        node.accesskit_node().is_disabled()
    }

    /// What was wished for since the last call.
    fn wishes(&self) -> Vec<DeviceWish> {
        let wish = |command| match command {
            Command::Device(wish) => wish,
            other => panic!("{other:?} was sent"),
        };
        self.commands.try_iter().map(wish).collect()
    }
}

#[test]
fn without_a_device_it_says_what_to_do() {
    let hardware = Hardware {
        fingers: vec![finger(None), finger(None)],
        ..Hardware::default()
    };
    let mut panel = Panel::tall(view(hardware));
    assert!(panel.says("No device is attached"));
    assert!(panel.says("Plug one in"));
    assert_eq!(panel.says("70-dorsum.rules"), cfg!(target_os = "linux"));
    assert!(panel.says("with an emulator, never with hardware"));
    panel.click("Look for makers' libraries");
    assert_eq!(panel.wishes(), [DeviceWish::AskMakers]);
    for page in ["Live", "Force test", "Stiffness", "Calibration", "Link"] {
        panel.click(&format!("Page {page}"));
        panel.harness.check_accessibility();
    }
    assert!(panel.says("choose a device for this finger"));
    if cfg!(target_os = "linux") {
        panel.click("Page Attached");
        panel.click("Try without hardware");
        panel.click("Attach emulated device");
        let family = "woodenhaptics";
        let fault = None;
        assert_eq!(panel.wishes(), [DeviceWish::Emulate { family, fault }]);
        assert!(panel.is_greyed("End emulation"));
    }
}

#[test]
fn a_device_is_chosen_told_of_and_released() {
    let running = Running::start();
    let mut panel = Panel::tall(view(hardware(Some(running.vitals.clone()))));
    assert!(panel.says("Answers") && panel.says("serial number A7"));
    assert!(panel.says("you may not open it"));
    panel.click("Kinds of devices");
    assert!(panel.says("libHD.so is not installed"));
    assert!(panel.is_greyed("Release Left"));

    panel.click("Use WoodenHaptics at /dev/hidraw3 for Right");
    let assigned = |finger, found| DeviceWish::Assign { finger, found };
    assert_eq!(panel.wishes(), [assigned(1, Some(found()))]);
    panel.click("Device of Left");
    panel.click("Mouse");
    assert_eq!(panel.wishes(), [assigned(0, None)]);
    panel.click("Recentre Left");
    assert_eq!(panel.wishes(), [DeviceWish::Recentre { finger: 0 }]);

    running.jumps.store(true, Ordering::Relaxed);
    let fault = running.until(Condition::is_latched);
    panel.draw();
    // The sentence begins with a capital there.
    assert!(panel.says(&fault.title()[1..]), "{fault:?}");
    panel.click("Release Left");
    assert_eq!(panel.wishes(), [DeviceWish::Release { finger: 0 }]);

    // A fault can be let go whatever else may not be done.
    panel.hardware(|h| h.locked = Some("A recording runs"));
    assert!(panel.says("A recording runs"));
    assert!(!panel.is_greyed("Release Left") && panel.is_greyed("Recentre Left"));
    panel.harness.check_accessibility();
}

#[test]
fn a_force_test_is_begun_watched_and_stopped() {
    let running = Running::start();
    let mut panel = Panel::tall(view(hardware(Some(running.vitals.clone()))));
    panel.click("Page Force test");
    assert!(panel.says("The device will push by itself"));
    panel.click("Push Headward");
    // Half of the 5 N that it holds without end is allowed.
    panel
        .harness
        .get_by_label("Force of the test, N")
        .set_value_accesskit(9.0);
    panel.draw();
    assert!(panel.says("of at most 2.50 N"));
    panel.click("Push with Left");
    let test = DeviceWish::Test {
        finger: 0,
        axis: 1,
        force_n: 2.5,
    };
    assert_eq!(panel.wishes(), [test]);
    panel.hardware(|h| h.fingers[0].test = Some((1.25, 0.3)));
    assert!(panel.is_greyed("Push with Left"));
    panel.click("Stop push of Left");
    let stop = DeviceWish::StopTest { finger: 0 };
    assert_eq!(panel.wishes(), std::slice::from_ref(&stop));
    // The way to stop it stays, whatever is shown.
    panel.click("Page Live");
    assert!(panel.says("Left pushes"));
    panel.click("Stop push of Left");
    assert_eq!(panel.wishes(), [stop]);
    panel.hardware(|h| h.fingers[0].test = None);
    panel.click("Page Force test");
    panel.change(|view| view.force_enabled = false);
    assert!(panel.is_greyed("Push with Left") && panel.says("Force is off"));
    assert!(!panel.is_greyed("Stop push of Left"));
}

#[test]
fn a_stiff_scene_is_told_scaled_and_hidden_in_an_exercise() {
    let running = Running::start();
    let mut panel = Panel::tall(view(hardware(Some(running.vitals.clone()))));
    let stiffest = support::scene().stiffest_n_per_mm();
    assert!(stiffest > 0.31);
    panel.click("Page Stiffness");
    for text in ["0.31", "0.66", "1.33", "2.00"] {
        assert!(
            panel.harness.query_all_by_label(text).count() == 1,
            "{text}"
        );
    }
    assert!(panel.says(&format!("felt up to {stiffest:.2} N/mm, but")));
    assert!(panel.says("may buzz or shake"));
    panel.click("Stiffness of Left: Scale");
    let choice = StiffnessChoice::Scale;
    assert_eq!(
        panel.wishes(),
        [DeviceWish::Stiffness { finger: 0, choice }]
    );
    panel.click("Passivity controller of Left");
    let on = true;
    assert_eq!(panel.wishes(), [DeviceWish::Passivity { finger: 0, on }]);
    panel.change(|view| view.blind = true);
    assert!(!panel.says("felt up to") && panel.says("stays hidden"));
    panel.click("Page Live");
    assert!(panel.says("are hidden while the exercise runs"));
    for tells in ["Position, mm", "Force, N", "Current, mA", "Encoders"] {
        assert!(!panel.says(tells), "{tells}");
    }
    panel.harness.check_accessibility();
}

#[test]
fn a_calibration_is_edited_saved_and_thrown_away() {
    let mut panel = Panel::tall(view(hardware(None)));
    panel.click("Page Calibration");
    assert!(panel.says("woodenhaptics-A7.toml"));
    assert!(panel.is_greyed("Save calibration of Left"));
    panel
        .harness
        .get_by_label("Rated force, N")
        .set_value_accesskit(3.0);
    panel.draw();
    panel.click("Orientation Upright");
    assert!(panel.says("Changed and not saved"));
    panel.click("Save calibration of Left");
    let wishes = panel.wishes();
    let [
        DeviceWish::Calibrate {
            finger: 0,
            calibration,
        },
    ] = &wishes[..]
    else {
        panic!("{wishes:?}");
    };
    let mut wanted: Calibration = WOODEN.defaults();
    (wanted.rated_force_n, wanted.serial) = (3.0, Some("A7".into()));
    wanted.mapping.orientation = dorsum::device::calibration::Orientation::Upright;
    assert_eq!(**calibration, wanted);

    panel.click("Revert calibration of Left");
    assert!(panel.says("As the device has it"));
    panel.harness.get_by_label("Name of the device").focus();
    panel.draw();
    panel.harness.event(egui::Event::Text("x".repeat(130)));
    panel.draw();
    assert!(panel.says("1 to 120 characters"));
    assert!(panel.is_greyed("Save calibration of Left"));
    panel.click("Reset calibration of Left");
    assert_eq!(panel.wishes(), []);
    panel.click("Reset calibration of Left now");
    assert_eq!(panel.wishes(), [DeviceWish::ResetCalibration { finger: 0 }]);
    panel.hardware(|h| h.locked = Some("An exercise runs"));
    assert!(panel.is_greyed("Rated force, N"));
    panel.harness.check_accessibility();
}

#[test]
fn counts_and_times_of_the_link_are_told_at_any_size() {
    let running = Running::start();
    std::thread::sleep(Duration::from_millis(300));
    for dark in [true, false] {
        for size in [[404.0, 1200.0], [1400.0, 900.0], [220.0, 160.0]] {
            let mut first = view(hardware(Some(running.vitals.clone())));
            first.theme = Theme::of(dark);
            let mut panel = Panel::open(first, size);
            for page in ["Live", "Force test", "Stiffness", "Calibration", "Link"] {
                panel.click(&format!("Page {page}"));
                panel.harness.check_accessibility();
            }
            if size[1] > 500.0 {
                assert!(panel.says("Time between reports of Left, median"));
                assert!(panel.says("of 1000 stated"));
            }
        }
    }
}

#[test]
fn the_emergency_stop_is_in_sight_for_every_role() {
    for role in Role::ALL {
        for (width, height) in [(1280.0, 800.0), (1600.0, 950.0)] {
            let folder = tempfile::tempdir().unwrap();
            let mut window = support::workbench_as(Start {
                source: Some(dorsum::app::bench::Source::Example(
                    dorsum::scenario::default_example(),
                )),
                folder: folder.path().to_owned(),
                role: Some(role),
                ..Start::default()
            });
            window.set_size(egui::vec2(width, height));
            window.run_steps(3);
            let stop = window.get_by_label("Stop force").rect();
            let inside = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height));
            assert!(
                inside.contains_rect(stop) && stop.width() > 60.0,
                "{role:?}: {stop}"
            );
            window.get_by_label("Stop force").click();
            window.run_steps(3);
            let allow = window.get_by_label("Allow force").rect();
            let told = window.get_by_label("Force is off").rect();
            assert!(
                inside.contains_rect(allow) && inside.contains_rect(told),
                "{role:?}"
            );
            assert!(!allow.intersects(told), "{role:?}");
        }
    }
}

#[test]
fn the_panel_is_listed_once_closed_at_first() {
    let slots = dock::slots(panels::all());
    let own: Vec<_> = slots
        .iter()
        .filter(|s| s.key == panels::devices::KEY)
        .collect();
    assert_eq!(own.len(), 1);
    assert!(!own[0].opens_at_first && own[0].title == "Devices");
}
