//! The menus of how the body is looked at: skin, bones, names, hands; one eye or two.

use super::anatomy::why_no_bones;
use super::options::{LOOKS, Options};
use crate::app::render::SkinLook;
use crate::app::stereo::{self, Mode};
use crate::app::widgets::named;
use crate::scenario::Scene;
use egui::RichText;
use egui::containers::menu::{MenuButton, MenuConfig};
use egui_material_icons::MaterialIcon;
use egui_material_icons::icons as icon;

/// The menu of skin, bones, names and hands, as a button.
pub fn anatomy_menu_ui(ui: &mut egui::Ui, options: &mut Options, scene: Option<&Scene>) {
    let menu = stays_open(icon::ICON_SKELETON).ui(ui, |ui| {
        ui.set_min_width(230.0);
        ui.label(RichText::new("Skin").size(11.0).weak());
        for (look, name) in LOOKS {
            let (title, why) = match look {
                SkinLook::Opaque => ("Opaque", "As it is seen on a body"),
                SkinLook::Translucent => ("Translucent", "Lets what lies below show through"),
                SkinLook::Off => ("Off", "Only what lies below and what touches it"),
            };
            let response = ui.radio(options.skin == look, title).on_hover_text(why);
            let spoken = format!("Skin {name}");
            say(ui, &response, options.skin == look, &spoken);
            if response.clicked() {
                options.skin = look;
            }
        }
        ui.separator();
        let no_bones = scene.and_then(why_no_bones);
        let bones = ui.add_enabled_ui(no_bones.is_none(), |ui| {
            let why = "Vertebrae, ribs, shoulder blades and pelvis where the landmarks put them: schematic, not this subject's";
            check(ui, &mut options.anatomy.bones, "Bones", why)
        });
        if bones.inner && options.anatomy.bones && options.skin == SkinLook::Opaque {
            // Otherwise nothing would be seen of the choice.
            options.skin = SkinLook::Translucent;
        }
        if let Some(why) = no_bones {
            remark(ui, why);
        } else if options.anatomy.bones && options.skin == SkinLook::Opaque {
            remark(ui, "Hidden by the opaque skin");
        }
        ui.add_enabled_ui(no_bones.is_none(), |ui| {
            let why = "Name the vertebrae and other landmarks on the skin";
            check(ui, &mut options.anatomy.landmarks, "Landmark names", why);
        });
        let why = "Show each fingertip as that of a hand";
        check(ui, &mut options.anatomy.hands, "Hands", why);
    });
    let skin = LOOKS.iter().find(|(look, _)| *look == options.skin);
    let words = format!("Anatomy: skin {}", skin.map_or("", |(_, name)| name));
    named(ui, &menu.0, &words);
    menu.0
        .on_hover_text("Anatomy: see through the skin, show bones, landmarks, a hand");
}

/// The menu of one eye or two, as a button. `target_mm` is how far away what is looked at is.
pub fn eyes_menu_ui(ui: &mut egui::Ui, options: &mut Options, target_mm: f64) {
    let menu = stays_open(icon::ICON_EYEGLASSES_2).ui(ui, |ui| {
        ui.set_min_width(250.0);
        let shown = options.stereo.map(|s| s.mode);
        let mut picked = None;
        for (mode, title, why) in [
            (None, "One eye", "A single picture"),
            (
                Some(Mode::Parallel),
                "Side by side",
                "The left eye's picture on the left: for a viewer, or eyes that look straight ahead",
            ),
            (
                Some(Mode::CrossEyed),
                "Cross-eyed",
                "The left eye's picture on the right: for eyes that squint",
            ),
            (
                Some(Mode::Anaglyph),
                "Red and cyan",
                "Both in one, for glasses with a red left and a cyan right filter; colours change, fingers' too",
            ),
        ] {
            let response = ui.radio(shown == mode, title).on_hover_text(why);
            say(ui, &response, shown == mode, &format!("Stereo: {title}"));
            if response.clicked() {
                picked = Some(mode);
            }
        }
        if let Some(mode) = picked {
            options.choose_mode(mode);
        }
        ui.separator();
        let mut eyes = options.eyes;
        ui.horizontal(|ui| {
            ui.label("Eye separation");
            number(
                ui,
                &mut eyes.separation_mm,
                &stereo::SEPARATION_MM,
                "Eye separation",
                "From eye to eye; 63 mm is usual. Less makes depth flatter",
            );
        });
        let mut follows = eyes.convergence_mm.is_none();
        let why = "What is looked at lies in the plane of the screen, however far away it is";
        if check(ui, &mut follows, "Converge on what is looked at", why) {
            eyes.convergence_mm = (!follows).then_some(target_mm.round());
        }
        ui.horizontal(|ui| {
            ui.label("Convergence distance");
            let mut mm = eyes.convergence_mm.unwrap_or(target_mm);
            ui.add_enabled_ui(!follows, |ui| {
                number(
                    ui,
                    &mut mm,
                    &stereo::CONVERGENCE_MM,
                    "Convergence distance",
                    "From the eyes to what lies in the plane of the screen; what is nearer stands out of it",
                );
            });
            if !follows {
                eyes.convergence_mm = Some(mm);
            }
        });
        if eyes != options.eyes {
            options.eyes = eyes;
            options.choose_mode(options.stereo.map(|s| s.mode));
        }
    });
    let words = match options.stereo.map(|s| s.mode) {
        None => "one eye",
        Some(Mode::Parallel) => "side by side",
        Some(Mode::CrossEyed) => "cross-eyed",
        Some(Mode::Anaglyph) => "red and cyan",
    };
    named(ui, &menu.0, &format!("Stereo: {words}"));
    menu.0
        .on_hover_text("Stereo: a picture for each eye, so that depth is seen");
}

/// A menu in which several things are chosen: it closes when one clicks beside it.
fn stays_open(icon: MaterialIcon) -> MenuButton<'static> {
    let config = MenuConfig::new().close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
    MenuButton::new(icon.rich_text().size(15.0)).config(config)
}

fn say(ui: &egui::Ui, response: &egui::Response, on: bool, words: &str) {
    response.widget_info(|| {
        egui::WidgetInfo::selected(
            egui::accesskit::Role::MenuItemRadio,
            ui.is_enabled(),
            on,
            words,
        )
    });
}

fn check(ui: &mut egui::Ui, on: &mut bool, words: &str, why: &str) -> bool {
    ui.checkbox(on, words).on_hover_text(why).changed()
}

fn remark(ui: &mut egui::Ui, words: &str) {
    let text = RichText::new(words).size(11.0).weak();
    ui.add(egui::Label::new(text).wrap());
}

fn number(
    ui: &mut egui::Ui,
    value: &mut f64,
    range: &std::ops::RangeInclusive<f64>,
    name: &str,
    why: &str,
) {
    let drag = ui
        .add(
            egui::DragValue::new(value)
                .range(range.clone())
                .speed(range.end() / 400.0)
                .max_decimals(1)
                .suffix(" mm"),
        )
        .on_hover_text(why);
    let shown = *value;
    drag.widget_info(|| egui::WidgetInfo {
        label: Some(name.to_owned()),
        ..egui::WidgetInfo::drag_value(ui.is_enabled(), shown)
    });
}
