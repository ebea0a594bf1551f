//! The calibration of a finger's device, as a draft that is saved, thrown away or given back to its maker's.

use super::draft::{Draft, FIELDS, Field, Group, applies};
use super::{PanelContext, add_button, button, finger_title, wish};
use crate::app::editor::cells::{self, Cell};
use crate::app::editor::parts::{choose, fold, pick, row};
use crate::app::hardware::{DeviceWish, InUse};
use crate::device::Found;
use crate::device::calibration::{self, Orientation};
use egui::RichText;

/// The form of one finger's device.
pub struct Form {
    finger: usize,
    found: Found,
    draft: Draft,
    /// The name as it is typed.
    name: String,
    told: Option<String>,
    /// Somebody asked for the published calibration and has to say so again.
    resetting: bool,
}

/// Parts of the form: heading and whether it is open at first.
const PARTS: [(Group, &str, bool); 6] = [
    (Group::Force, "Force", true),
    (Group::Mapping, "On the subject", true),
    (Group::Rate, "Deflection", true),
    (Group::Guards, "Guards", false),
    (Group::Mechanics, "Mechanics", false),
    (Group::Arm, "Encoders and motors", false),
];

impl Form {
    /// The form in `kept`, made anew for another finger or device.
    pub fn of<'a>(kept: &'a mut Option<Self>, finger: usize, device: &InUse) -> &'a mut Self {
        if let Some(form) = kept
            && (form.finger != finger || form.found != device.found)
        {
            *kept = None;
        }
        let form = kept.get_or_insert_with(|| Self {
            finger,
            found: device.found.clone(),
            draft: Draft::new(&device.calibration, device.found.serial.as_deref()),
            name: device.calibration.name.clone().unwrap_or_default(),
            told: None,
            resetting: false,
        });
        let before = form.draft.now.name.clone();
        form.draft.follow(&device.calibration);
        if form.draft.now.name != before {
            form.name = form.draft.now.name.clone().unwrap_or_default();
        }
        form
    }

    /// Draws it.
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, device: &InUse) {
        let locked = cx.view.hardware.locked;
        self.ends_ui(ui, cx, device, locked);
        ui.separator();
        ui.add_enabled_ui(locked.is_none(), |ui| {
            self.name_ui(ui);
            let has_force = device.capabilities.force_axes > 0;
            for (group, heading, open) in PARTS {
                if !applies(group, &self.draft.now, has_force) {
                    continue;
                }
                fold(ui, heading, open, |ui| {
                    for field in FIELDS.iter().filter(|f| f.group == group) {
                        self.number_ui(ui, field);
                    }
                    match group {
                        Group::Mapping => self.mapping_ui(ui, device),
                        Group::Arm => self.signs_ui(ui),
                        _ => {}
                    }
                });
            }
        });
    }

    /// Save, revert, reset; where it is kept, and what is wrong with it.
    fn ends_ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        device: &InUse,
        locked: Option<&'static str>,
    ) {
        let theme = &cx.view.theme;
        let finger = self.finger;
        let title = finger_title(finger);
        let edited = self.draft.is_edited();
        let wrong = edited.then(|| self.draft.wrong()).flatten();
        let unedited = (!edited).then_some("Nothing was changed");
        ui.horizontal_wrapped(|ui| {
            let refused = wrong
                .as_ref()
                .map(|_| "The draft cannot be saved: see below");
            let barred = locked.or(unedited).or(refused);
            let text = RichText::new("Save").strong();
            let save = if barred.is_none() {
                egui::Button::new(text.color(theme.on_accent)).fill(theme.accent)
            } else {
                egui::Button::new(text)
            };
            let name = format!("Save calibration of {title}");
            let why = "Write it into the device's file and use it from now on";
            if add_button(ui, barred, save, &name, why) {
                let calibration = Box::new(self.draft.now.clone());
                wish(
                    cx,
                    DeviceWish::Calibrate {
                        finger,
                        calibration,
                    },
                );
                self.told = None;
            }
            let name = format!("Revert calibration of {title}");
            let why = "Throw the changes away";
            if button(ui, unedited, "Revert", &name, why) {
                self.draft.revert();
                self.name = self.draft.now.name.clone().unwrap_or_default();
                (self.told, self.resetting) = (None, false);
            }
            if self.resetting {
                let name = format!("Reset calibration of {title} now");
                let why = "Remove the device's file and take the published calibration";
                let text = RichText::new("Remove its file").color(theme.warning);
                if button(ui, locked, text, &name, why) {
                    wish(cx, DeviceWish::ResetCalibration { finger });
                    self.draft.revert();
                    self.resetting = false;
                }
                let name = format!("Keep calibration of {title}");
                if button(ui, None, "Keep it", &name, "Leave everything as it is") {
                    self.resetting = false;
                }
            } else {
                let name = format!("Reset calibration of {title}");
                let why = "Take the calibration that is published for its family; asks again";
                if button(ui, locked, "Reset to published…", &name, why) {
                    self.resetting = true;
                }
            }
        });
        let file = calibration::file_name(device.found.family, device.found.serial.as_deref());
        let path = cx.view.hardware.folder.join(file);
        let path = format!("Kept in {}", path.display());
        ui.add(egui::Label::new(RichText::new(&path).weak().size(12.5)).wrap())
            .on_hover_text("One file for each device that tells its own serial number, else one for its family");
        let state = if edited {
            RichText::new("Changed and not saved yet").color(theme.warning)
        } else {
            RichText::new("As the device has it").weak()
        };
        ui.label(state);
        for told in [wrong, self.told.clone()].into_iter().flatten() {
            ui.label(RichText::new(told).color(theme.fault));
        }
    }

    fn name_ui(&mut self, ui: &mut egui::Ui) {
        row(
            ui,
            "Name",
            "Shown to people and written into recordings; empty: that of its family",
            |ui| {
                let width = ui.available_width().clamp(60.0, 220.0);
                let edit = ui.add(
                    egui::TextEdit::singleline(&mut self.name)
                        .hint_text("as its family")
                        .desired_width(width),
                );
                ui.ctx().accesskit_node_builder(edit.id, |node| {
                    node.set_label("Name of the device".to_owned());
                });
                if edit.changed() {
                    let name = self.name.trim();
                    self.draft.now.name = (!name.is_empty()).then(|| name.to_owned());
                }
            },
        );
    }

    fn number_ui(&mut self, ui: &mut egui::Ui, field: &Field) {
        let value = (field.get)(&self.draft.now);
        let (low, high) = (field.range.start(), field.range.end());
        let unit = if field.unit.is_empty() {
            String::new()
        } else {
            format!(", {}", field.unit)
        };
        let name = format!("{}{unit}", field.name);
        let tooltip = format!("{}; {low} to {high} {}", field.why, field.unit);
        let tooltip = format!("{} is allowed", tooltip.trim_end());
        named_row(ui, field.name, &tooltip, |ui| {
            let cell = Cell {
                name: &name,
                tooltip: &tooltip,
                range: field.range.clone(),
                decimals: field.decimals,
                unit: field.unit,
                speed: field.speed,
                width: 110.0,
            };
            let edit = cells::number(ui, &cell, value);
            if let Some(x) = edit.value {
                (field.set)(&mut self.draft.now, x);
                self.told = None;
            }
            if edit.told.is_some() {
                self.told = edit.told;
            }
            let range = format!("{low} … {high}");
            ui.label(RichText::new(range).weak().size(11.5));
        });
    }

    fn mapping_ui(&mut self, ui: &mut egui::Ui, device: &InUse) {
        let mapping = &mut self.draft.now.mapping;
        let why = "How the subject stands to the device: lying on a table before you, or upright as on the screen";
        named_row(ui, "Orientation", why, |ui| {
            for orientation in Orientation::ALL {
                let (text, why) = match orientation {
                    Orientation::Lying => {
                        ("Lying", "Up is out of the back; away from you is the head")
                    }
                    Orientation::Upright => {
                        ("Upright", "Up is the head; towards you is out of the back")
                    }
                };
                let on = mapping.orientation == orientation;
                if pick(ui, on, text, &format!("Orientation {text}"), why) {
                    mapping.orientation = orientation;
                }
            }
        });
        let why = "Held down, the device moves while the finger stays: to reach farther";
        named_row(ui, "Clutch button", why, |ui| {
            let word = |b: Option<u8>| b.map_or("none".to_owned(), |b| format!("button {b}"));
            let last = device.capabilities.n_buttons.min(32);
            let now = mapping.clutch_button;
            let items = std::iter::once(None)
                .chain((1..=last).map(Some))
                .chain(now.filter(|b| *b > last).map(Some))
                .map(|b| (word(b), b == now, b));
            let items: Vec<_> = items.collect();
            if let Some(picked) = choose(ui, "Clutch button", why, &word(now), 100.0, items) {
                mapping.clutch_button = picked;
            }
        });
        let why = "Which finger it takes when it is plugged in, if that one is free";
        named_row(ui, "First finger", why, |ui| {
            let now = usize::from(mapping.finger);
            let items =
                (0..crate::app::bench::FINGERS).map(|f| (finger_title(f).to_owned(), f == now, f));
            let items: Vec<_> = items.collect();
            if let Some(picked) = choose(ui, "First finger", why, finger_title(now), 100.0, items)
                && let Ok(picked) = u8::try_from(picked)
            {
                mapping.finger = picked;
            }
        });
    }

    /// Which way encoders count and motors turn.
    fn signs_ui(&mut self, ui: &mut egui::Ui) {
        let Some(arm) = &mut self.draft.now.arm else {
            return;
        };
        let rows = [
            (
                "Encoder counts",
                "Up as the motor turns, or down",
                &mut arm.encoder_sign,
            ),
            (
                "Body turns",
                "As its motor does, or against it. A wrong one pushes the wrong way: try it with a force test",
                &mut arm.motor_direction,
            ),
        ];
        for (name, why, signs) in rows {
            named_row(ui, name, why, |ui| {
                for (sign, motor) in signs.iter_mut().zip(["a", "b", "c"]) {
                    let on = *sign < 0.0;
                    let text = format!("{motor} {}", if on { "−" } else { "+" });
                    if pick(ui, on, &text, &format!("{name} backwards, {motor}"), why) {
                        *sign = -*sign;
                    }
                }
            });
        }
    }
}

/// A row whose name has room for three words.
fn named_row(ui: &mut egui::Ui, name: &str, why: &str, add: impl FnOnce(&mut egui::Ui)) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        ui.allocate_ui_with_layout(
            egui::vec2(126.0, 20.0),
            egui::Layout::left_to_right(egui::Align::Center),
            |ui| {
                ui.set_min_width(126.0);
                ui.label(RichText::new(name).weak()).on_hover_text(why);
            },
        );
        add(ui);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_has_a_number_and_every_number_a_part() {
        for (group, heading, _) in PARTS {
            assert!(FIELDS.iter().any(|f| f.group == group), "{heading}");
        }
        for field in &FIELDS {
            assert!(PARTS.iter().any(|(g, ..)| *g == field.group));
        }
    }
}
