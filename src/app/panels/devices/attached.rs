//! What is attached, which kinds of devices there are, and devices without hardware.

use super::{PanelContext, button, finger_title, told, wish};
use crate::app::editor::parts::{choose, fold};
use crate::app::hardware::{Attached, DeviceWish, Hardware};
use crate::device::hid::emulator::Fault;
use crate::device::{self, Proof};
use egui::RichText;
use egui_material_icons::icons as icon;

/// What is chosen for a simulated device.
#[derive(Debug, Default)]
pub struct Choices {
    family: Option<&'static str>,
    fault: Option<Fault>,
}

/// Draws it.
pub fn ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, choices: &mut Choices) {
    let hardware = &*cx.view.hardware;
    ui.add_space(4.0);
    if hardware.attached.is_empty() {
        empty_ui(ui);
    } else {
        ui.label(RichText::new("Attached").strong());
        for (i, device) in hardware.attached.iter().enumerate() {
            ui.push_id(i, |ui| device_ui(ui, cx, hardware, device));
        }
    }
    ui.add_space(4.0);
    fold(ui, "Try without hardware", false, |ui| {
        emulate_ui(ui, cx, hardware, choices);
    });
    let open = hardware.attached.is_empty();
    fold(ui, "Kinds of devices", open, |ui| {
        kinds_ui(ui, cx, hardware)
    });
}

fn empty_ui(ui: &mut egui::Ui) {
    ui.horizontal(|ui| {
        ui.label(icon::ICON_USB.rich_text().size(18.0).weak());
        ui.label(RichText::new("No device is attached").strong());
    });
    ui.label("Plug one in: it appears here by itself, and a finger can be moved by it.");
    if cfg!(target_os = "linux") {
        ui.label(
            "Linux lets nobody but root open it unless a rule says so: copy assets/70-dorsum.rules to \
             /etc/udev/rules.d, then plug it in again.",
        );
    }
    ui.label("Or try an emulated one below. The mouse moves every finger that has no device.");
}

fn device_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, hardware: &Hardware, device: &Attached) {
    let theme = &cx.view.theme;
    let found = &device.found;
    egui::Frame::new()
        .fill(theme.inset)
        .corner_radius(4.0)
        .inner_margin(egui::Margin::symmetric(8, 5))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.spacing_mut().item_spacing.y = 3.0;
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(told(&found.title, device.emulated)).strong());
                if let Some(finger) = device.finger {
                    let text = format!("moves {}", finger_title(finger));
                    ui.label(RichText::new(text).color(theme.good));
                }
            });
            let family = device::by_key(found.family).map_or(found.family, |f| f.title());
            let serial = (found.serial.as_ref())
                .map_or("no serial number".into(), |s| format!("serial number {s}"));
            let about = format!("{family} · {serial} · {}", found.place);
            ui.label(RichText::new(about).weak().size(12.5));
            let noted = if device.emulated {
                theme.weak_text
            } else {
                theme.warning
            };
            for (text, colour) in [(&found.note, noted), (&device.trouble, theme.fault)] {
                if let Some(text) = text {
                    ui.label(RichText::new(super::state::capital(text)).color(colour));
                }
            }
            ui.horizontal_wrapped(|ui| {
                for finger in 0..hardware.fingers.len() {
                    if device.finger == Some(finger) {
                        continue;
                    }
                    let title = finger_title(finger);
                    let text = format!("Use for {title}");
                    let name = format!("Use {} at {} for {title}", found.title, found.place);
                    let why = "Have this finger moved by it";
                    if button(ui, hardware.locked, text, &name, why) {
                        let found = Some(found.clone());
                        wish(cx, DeviceWish::Assign { finger, found });
                    }
                }
            });
        });
}

fn emulate_ui(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    hardware: &Hardware,
    choices: &mut Choices,
) {
    ui.label(
        RichText::new(
            "A simulated arm in a simulated hand, in a process of its own that speaks the protocol of the real board.",
        )
        .weak(),
    );
    let families = emulated_families();
    let (Some(first), true) = (families.first(), cfg!(target_os = "linux")) else {
        ui.weak("Emulators run on Linux only");
        return;
    };
    let key = choices.family.unwrap_or(first);
    let title = |key: &'static str| device::by_key(key).map_or(key, |f| f.title());
    ui.horizontal_wrapped(|ui| {
        ui.weak("Device");
        let items = families
            .iter()
            .map(|k| (title(k).to_owned(), *k == key, *k));
        let why = "Which board is simulated";
        if let Some(picked) = choose(ui, "Emulated device", why, title(key), 130.0, items) {
            choices.family = Some(picked);
        }
    });
    ui.horizontal_wrapped(|ui| {
        ui.weak("What goes wrong");
        let why = "What happens some time after it is pressed against the skin";
        let now = choices.fault.map_or("Nothing", fault_title);
        let items = std::iter::once(("Nothing".to_owned(), choices.fault.is_none(), None)).chain(
            Fault::ALL.into_iter().map(|f| {
                let on = choices.fault == Some(f);
                (fault_title(f).to_owned(), on, Some(f))
            }),
        );
        if let Some(picked) = choose(ui, "Emulated fault", why, now, 190.0, items) {
            choices.fault = picked;
        }
    });
    ui.horizontal_wrapped(|ui| {
        let why = "Attach it as if it were plugged in; then choose it for a finger";
        if button(ui, hardware.locked, "Attach", "Attach emulated device", why) {
            let fault = choices.fault.map(Fault::key);
            wish(cx, DeviceWish::Emulate { family: key, fault });
        }
        let any = hardware.attached.iter().any(|a| a.emulated);
        let barred = hardware.locked.or((!any).then_some("None is attached"));
        let why = "Pull every emulated device out";
        if button(ui, barred, "End emulation", "End emulation", why) {
            wish(cx, DeviceWish::EndEmulation);
        }
    });
}

/// Keys of the families that can be emulated.
fn emulated_families() -> Vec<&'static str> {
    #[cfg(target_os = "linux")]
    {
        use crate::device::Family as _;
        let families = device::hid::emulator::process::families();
        families.iter().map(|f| f.key()).collect()
    }
    #[cfg(not(target_os = "linux"))]
    {
        Vec::new()
    }
}

fn fault_title(fault: Fault) -> &'static str {
    match fault {
        Fault::Unplugged => "It is pulled out",
        Fault::Frozen => "It repeats its last report",
        Fault::Silent => "It falls silent",
        Fault::Jump => "Its encoders jump",
        Fault::Extreme => "Its encoders say the most they can",
        Fault::Short => "Its reports are cut off",
        Fault::Slow => "It reports every 50 ms",
        Fault::Reversed => "A motor turns the wrong way",
    }
}

fn kinds_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, hardware: &Hardware) {
    let theme = &cx.view.theme;
    ui.horizontal_wrapped(|ui| {
        let text = if hardware.makers_asked {
            "Look for makers' libraries again"
        } else {
            "Look for makers' libraries"
        };
        let why = "Some devices are found by their maker's library only: load those that are installed and ask them";
        if button(ui, None, text, "Look for makers' libraries", why) {
            wish(cx, DeviceWish::AskMakers);
        }
    });
    for family in device::all() {
        let missing = hardware
            .missing
            .iter()
            .find(|(key, _)| *key == family.key());
        let asked = family.may_be_watched() || hardware.makers_asked;
        ui.add_space(3.0);
        ui.label(RichText::new(family.title()).strong());
        ui.spacing_mut().item_spacing.y = 2.0;
        ui.label(RichText::new(family.about()).size(12.5));
        ui.label(
            RichText::new(format!("Reached by {}", family.reached()))
                .weak()
                .size(12.5),
        );
        let proof = family.proof();
        let colour = if proof == Proof::Hardware {
            theme.good
        } else {
            theme.weak_text
        };
        let tested = format!("Tested {}", proof.title());
        let tested = if proof == Proof::Nothing {
            super::state::capital(proof.title())
        } else {
            tested
        };
        ui.label(RichText::new(tested).color(colour).size(12.5));
        if let Some((_, why)) = missing {
            ui.label(RichText::new(why).color(theme.warning).size(12.5));
        } else if !asked {
            ui.label(RichText::new("Not looked for yet").weak().size(12.5));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_has_words_and_every_emulated_family_is_one() {
        for fault in Fault::ALL {
            assert!(fault_title(fault).len() > 5);
        }
        for key in emulated_families() {
            assert!(device::by_key(key).is_some(), "{key}");
        }
    }
}
