//! Buttons over the picture: where to look from, what to show, park the other finger.

use super::{BackView, PanelContext, model};
use crate::app::camera::{Preset, Projection};
use crate::app::colours::Quantity;
use crate::app::render::pixels;
use egui_material_icons::MaterialIcon;
use egui_material_icons::icons as icon;

impl BackView {
    pub(super) fn toolbar(
        &mut self,
        ui: &mut egui::Ui,
        rect: egui::Rect,
        cx: &PanelContext<'_>,
        fingers: &[model::Finger],
    ) {
        let size = pixels::delta(rect.size());
        let place = rect.shrink(8.0);
        let before = self.options;
        let builder = egui::UiBuilder::new()
            .max_rect(place)
            .layout(egui::Layout::left_to_right(egui::Align::Min));
        let end = ui.scope_builder(builder, |ui| {
            let plate = super::overlay::plate(&cx.view.theme).show(ui, |ui| {
                ui.spacing_mut().item_spacing.x = 2.0;
                ui.spacing_mut().button_padding = egui::vec2(6.0, 2.0);
                ui.horizontal_wrapped(|ui| {
                    for preset in Preset::ALL {
                        let (name, why) = preset_text(preset);
                        let there = ui
                            .selectable_label(self.preset == Some(preset), name)
                            .on_hover_text(why);
                        if there.clicked() {
                            self.go_to(preset, fingers, size);
                        }
                    }
                    ui.separator();
                    let scene = self.skin.as_ref().map(|skin| skin.scene());
                    let remark = |quantity: &Quantity| quantity.why_same(scene?);
                    if let Some(picked) = super::ramp::menu_ui(ui, &self.colour, remark) {
                        self.colour.choose(picked, &self.stage);
                    }
                    let scene = self.skin.as_ref().map(|skin| skin.scene());
                    super::look::anatomy_menu_ui(ui, &mut self.options, scene);
                    super::look::eyes_menu_ui(ui, &mut self.options, self.camera.distance_mm);
                    self.toggles(ui);
                    let live = cx.view.playback.is_none();
                    if live && cx.view.hands.len() > 1 {
                        let parked = self.palpation.is_parked();
                        let why = if parked {
                            "Lift the parked finger off the skin (P)"
                        } else {
                            "Let the other finger hold the press where this one is (P)"
                        };
                        if toggle(
                            ui,
                            parked,
                            icon::ICON_PUSH_PIN,
                            "Park the other finger",
                            why,
                        ) {
                            self.park(cx);
                        }
                    }
                });
            });
            plate.response.rect.right()
        });
        let moved = std::mem::replace(&mut self.toolbar_end, end.inner) != end.inner;
        if moved || self.options != before {
            // The picture below has been drawn already.
            ui.ctx().request_repaint();
        }
    }

    fn toggles(&mut self, ui: &mut egui::Ui) {
        let flat = self.camera.projection == Projection::Orthographic;
        if toggle(
            ui,
            flat,
            icon::ICON_GRID_ON,
            "Orthographic view",
            "Without perspective: the same scale everywhere, for measuring",
        ) {
            self.camera.projection = if flat {
                Projection::Perspective
            } else {
                Projection::Orthographic
            };
            self.glide = None;
        }
        let o = &mut self.options;
        for (on, icon, name, why) in [
            (
                &mut o.wireframe,
                icon::ICON_DEPLOYED_CODE,
                "Wireframe",
                "Show the edges of the triangles over the skin",
            ),
            (
                &mut o.arrows,
                icon::ICON_ARROW_OUTWARD,
                "Force arrows",
                "Show the force on each finger as an arrow, 8 mm long for each newton",
            ),
            (
                &mut o.footprints,
                icon::ICON_RADIO_BUTTON_UNCHECKED,
                "Footprints",
                "Show how far each press reaches: a drag of the finger to the outer line, its dent to the inner one",
            ),
        ] {
            if toggle(ui, *on, icon, name, why) {
                *on = !*on;
            }
        }
    }
}

/// A button that is on or off, with an icon, a name for a screen reader and a tooltip. True when clicked.
fn toggle(ui: &mut egui::Ui, on: bool, icon: MaterialIcon, name: &str, why: &str) -> bool {
    let response = ui.selectable_label(on, icon.rich_text().size(15.0));
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::accesskit::Role::Button, ui.is_enabled(), on, name)
    });
    response.on_hover_text(format!("{name}: {why}")).clicked()
}

pub(in crate::app::panels) fn preset_text(preset: Preset) -> (&'static str, &'static str) {
    match preset {
        Preset::Oblique => ("Oblique", "From behind, a little from the left and above"),
        Preset::Back => (
            "Back",
            "Straight from behind: the subject's right is on the right",
        ),
        Preset::Left => ("Left", "From the subject's left side"),
        Preset::Right => ("Right", "From the subject's right side"),
        Preset::Head => ("Head", "From above the head, along the spine"),
        Preset::Close => (
            "Finger",
            "Close to the finger, along the skin: dent and force show best",
        ),
    }
}
