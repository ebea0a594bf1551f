//! Where fingers dwelt, on the back's map plane: a picture for each recording, and one legend in seconds for all.

use super::measures::Named;
use crate::app::colours::map::Map;
use crate::app::editor::plane::Area;
use crate::app::panels::library::picture::Silhouettes;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::study::Dwell;
use egui::{
    Align2, Color32, ColorImage, FontId, Rect, RichText, Sense, TextureHandle, TextureOptions,
    pos2, vec2,
};

/// Pixels of a picture, before it is fitted.
const PIXELS: [usize; 2] = [240, 300];
/// Largest width of a picture, points.
const LARGEST: f32 = 360.0;
/// Smallest room for one, points, and how many stand beside each other at most.
const SMALLEST: f32 = 130.0;
const ABREAST: usize = 3;
/// Width of the legend, points.
const LEGEND: f32 = 78.0;
/// Steps of the legend's ramp.
const STEPS: usize = 96;

/// The pictures, and what they were made of.
#[derive(Default)]
pub struct Pictures {
    silhouettes: Silhouettes,
    made: Vec<TextureHandle>,
    of: Option<(u64, bool)>,
    area: Option<Area>,
    most_s: f64,
}

impl Pictures {
    /// Draws them beside each other; `number` changes with the recordings.
    pub fn ui(&mut self, ui: &mut egui::Ui, theme: &Theme, told: &[Named], number: u64) {
        let maps = || told.iter().map(|(_, t)| &t.analysis.dwell);
        if self.of != Some((number, theme.dark)) {
            self.of = Some((number, theme.dark));
            self.most_s = maps().map(Dwell::most_s).fold(0.0, f64::max);
            let area = self.area_of(maps());
            self.area = area;
            self.made = maps()
                .map(|dwell| {
                    let image = self.paint(dwell, theme);
                    (ui.ctx()).load_texture("dwell", image, TextureOptions::LINEAR)
                })
                .collect();
        }
        if self.most_s <= 0.0 {
            ui.weak("No finger touched the skin in these recordings");
            return;
        }
        // As many beside each other as can be told apart, the legend beside the first of them.
        let room = ui.available_width() - LEGEND - 24.0;
        let most = ((room / SMALLEST) as usize).clamp(1, ABREAST);
        let abreast = told.len().clamp(1, most);
        let width = (room / abreast as f32 - 10.0).clamp(SMALLEST - 10.0, LARGEST);
        let size = vec2(width, width * PIXELS[1] as f32 / PIXELS[0] as f32);
        let all: Vec<(&Named, &TextureHandle)> = told.iter().zip(&self.made).collect();
        for (i, row) in all.chunks(abreast).enumerate() {
            ui.horizontal_top(|ui| {
                for (named, texture) in row {
                    self.one_ui(ui, theme, named, texture, size);
                }
                if i == 0 {
                    self.legend_ui(ui, theme, size.y);
                }
            });
        }
    }

    fn one_ui(
        &self,
        ui: &mut egui::Ui,
        theme: &Theme,
        (name, told): &Named,
        texture: &TextureHandle,
        size: egui::Vec2,
    ) {
        ui.vertical(|ui| {
            ui.set_width(size.x);
            ui.add(egui::Label::new(RichText::new(name).strong()).truncate());
            let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
            let what = format!("Dwell map of {name}");
            response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::accesskit::Role::Figure, true, &what)
            });
            ui.painter().rect_filled(rect, 4.0, theme.inset);
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), rect, uv, Color32::WHITE);
            let dwell = &told.analysis.dwell;
            self.tell(&response, rect, dwell);
            let text = format!(
                "{:.1} s on the skin, at most {:.2} s in a cell",
                dwell.total_s(),
                dwell.most_s()
            );
            ui.add(egui::Label::new(RichText::new(text).size(11.5).weak()).truncate());
        });
    }

    fn area_of<'a>(&self, maps: impl Iterator<Item = &'a Dwell>) -> Option<Area> {
        let own = maps.filter(|d| d.most_s() > 0.0).map(|d| {
            let min = Vec2::from_array(d.origin_mm);
            let size = Vec2::new(d.columns as f64, d.rows as f64) * d.cell_mm;
            Area {
                min,
                max: min + size,
            }
        });
        let back = self.silhouettes.back().map(|s| s.area.grown(6.0));
        own.chain(back).reduce(|a, b| a.with(&b))
    }

    /// From a pixel, counted from the upper left, to the map plane, mm.
    fn at(&self, x: f64, y: f64) -> Option<(Vec2, f64)> {
        let area = self.area?;
        let size = Vec2::new(PIXELS[0] as f64, PIXELS[1] as f64);
        let mm = (area.size() / size).max_element();
        let p = Vec2::new(x, y) - size * 0.5;
        Some((area.centre() + Vec2::new(p.x, -p.y) * mm, mm))
    }

    fn paint(&self, dwell: &Dwell, theme: &Theme) -> ColorImage {
        let back = self.silhouettes.back();
        let skin = theme.weak_text.gamma_multiply(0.28);
        let mut pixels = Vec::with_capacity(PIXELS[0] * PIXELS[1]);
        for row in 0..PIXELS[1] {
            for column in 0..PIXELS[0] {
                let Some((p, _)) = self.at(column as f64 + 0.5, row as f64 + 0.5) else {
                    pixels.push(Color32::TRANSPARENT);
                    continue;
                };
                let seconds = seconds_at(dwell, p);
                let cover = back
                    .as_ref()
                    .and_then(|s| s.cover.between(p))
                    .unwrap_or(0.0);
                pixels.push(if seconds > 0.0 {
                    Map::Sequential.color((seconds / self.most_s).sqrt())
                } else {
                    skin.gamma_multiply(cover.clamp(0.0, 1.0) as f32)
                });
            }
        }
        ColorImage::new(PIXELS, pixels)
    }

    /// The time under the pointer.
    fn tell(&self, response: &egui::Response, rect: Rect, dwell: &Dwell) {
        let Some(pointer) = response.hover_pos() else {
            return;
        };
        let share = (pointer - rect.min) / rect.size();
        let (x, y) = (f64::from(share.x), f64::from(share.y));
        let at = self.at(x * PIXELS[0] as f64, y * PIXELS[1] as f64);
        if let Some((p, _)) = at {
            let seconds = seconds_at(dwell, p);
            response.clone().on_hover_text(format!(
                "{seconds:.2} s at x {:.0} mm, y {:.0} mm",
                p.x, p.y
            ));
        }
    }

    fn legend_ui(&self, ui: &mut egui::Ui, theme: &Theme, height: f32) {
        ui.vertical(|ui| {
            ui.set_width(LEGEND);
            ui.label(RichText::new("Dwell (s)").strong());
            let (rect, _) = ui.allocate_exact_size(vec2(LEGEND, height.min(240.0)), Sense::hover());
            let ramp =
                Rect::from_min_size(rect.min, vec2(16.0, rect.height())).shrink2(vec2(0.0, 7.0));
            for i in 0..STEPS {
                let (from, to) = (i as f32 / STEPS as f32, (i + 1) as f32 / STEPS as f32);
                let step = Rect::from_min_max(
                    pos2(ramp.left(), ramp.bottom() - to * ramp.height()),
                    pos2(ramp.right(), ramp.bottom() - from * ramp.height() + 0.5),
                );
                let colour = Map::Sequential.color(f64::from(from + to) * 0.5);
                ui.painter().rect_filled(step, 0.0, colour);
            }
            // The root of the time is what colours go by.
            for share in [0.0, 0.25, 0.5, 0.75, 1.0_f64] {
                let y = ramp.bottom() - share as f32 * ramp.height();
                let text = format!("{:.2}", share * share * self.most_s);
                let font = FontId::proportional(11.5);
                let at = pos2(ramp.right() + 6.0, y);
                ui.painter()
                    .text(at, Align2::LEFT_CENTER, text, font, theme.text);
            }
        });
    }
}

fn seconds_at(dwell: &Dwell, p: Vec2) -> f64 {
    if dwell.cell_mm.is_nan() || dwell.cell_mm <= 0.0 {
        return 0.0;
    }
    let cell = ((p - Vec2::from_array(dwell.origin_mm)) / dwell.cell_mm).floor();
    if cell.x < 0.0 || cell.y < 0.0 || cell.x >= dwell.columns as f64 {
        return 0.0;
    }
    let i = cell.y as usize * dwell.columns + cell.x as usize;
    dwell.seconds.get(i).copied().map_or(0.0, f64::from)
}
