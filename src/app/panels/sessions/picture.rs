//! The thumbnail of a recording: where its fingers dwelt, over the outline of the back.

use super::list::THUMB;
use crate::app::colours::map::Map;
use crate::app::editor::plane::Area;
use crate::app::panels::library::picture::Silhouettes;
use crate::app::theme::Theme;
use crate::geom::Vec2;
use crate::study::index::Thumbnail;
use egui::ColorImage;

/// Pixels: two for each point.
const SIZE: [usize; 2] = [THUMB.x as usize * 2, THUMB.y as usize * 2];

/// The picture of `dwell`; nothing where nothing dwelt.
pub fn paint(dwell: &Thumbnail, silhouettes: &Silhouettes, theme: &Theme) -> Option<ColorImage> {
    if dwell.most_s <= 0.0 || !dwell.cell_mm.is_finite() || dwell.cell_mm <= 0.0 {
        return None;
    }
    let silhouette = silhouettes.back();
    let origin_mm = Vec2::from_array(dwell.origin_mm);
    let own = Area {
        min: origin_mm,
        max: origin_mm + Vec2::new(dwell.columns as f64, dwell.rows as f64) * dwell.cell_mm,
    };
    let area = match &silhouette {
        Some(s) => s.area.grown(4.0),
        None => own.grown(4.0),
    };
    let [columns, rows] = SIZE;
    let size = Vec2::new(columns as f64, rows as f64);
    let mm = (area.size() / size).max_element();
    let skin = theme.weak_text.gamma_multiply(0.30);
    let mut pixels = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let p = Vec2::new(column as f64 + 0.5, row as f64 + 0.5) - size * 0.5;
            let p = area.centre() + Vec2::new(p.x, -p.y) * mm;
            let seconds = share(dwell, p, mm);
            let covered = silhouette
                .as_ref()
                .and_then(|s| s.cover.between(p))
                .unwrap_or(0.0);
            pixels.push(if seconds > 0.0 {
                Map::Sequential.color(seconds)
            } else {
                skin.gamma_multiply(covered.clamp(0.0, 1.0) as f32)
            });
        }
    }
    Some(ColorImage::new(SIZE, pixels))
}

/// The largest shade of the cells that a pixel of `pixel_mm` about `p` covers, 0 to 1, so that no short visit falls between
/// pixels.
fn share(dwell: &Thumbnail, p: Vec2, pixel_mm: f64) -> f64 {
    let half = Vec2::splat(pixel_mm * 0.5);
    let cell = |p: Vec2| (p - Vec2::from_array(dwell.origin_mm)) / dwell.cell_mm;
    let (lo, hi) = (cell(p - half).floor(), cell(p + half).ceil());
    let end = |x: f64, n: usize| x.clamp(0.0, n as f64) as usize;
    let mut largest = 0;
    for row in end(lo.y, dwell.rows)..end(hi.y, dwell.rows) {
        for column in end(lo.x, dwell.columns)..end(hi.x, dwell.columns) {
            let shade = dwell.shade.get(row * dwell.columns + column);
            largest = largest.max(shade.copied().unwrap_or(0));
        }
    }
    f64::from(largest) / 255.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_visit_is_seen_and_nothing_gives_no_picture() {
        let mut dwell = Thumbnail {
            origin_mm: [-200.0, -250.0],
            cell_mm: 10.0,
            columns: 40,
            rows: 50,
            most_s: 0.0,
            shade: vec![0; 2000],
        };
        let theme = crate::app::theme::DARK;
        let silhouettes = Silhouettes::default();
        assert!(paint(&dwell, &silhouettes, &theme).is_none());
        // A shade of 1 at the upper left of the map, the longest at its lower right: so in the picture, which begins at its top.
        dwell.most_s = 9.0;
        dwell.shade[37 * 40 + 10] = 1;
        dwell.shade[10 * 40 + 30] = 255;
        let image = paint(&dwell, &silhouettes, &theme).expect("a picture");
        let bright: Vec<usize> = (0..image.pixels.len())
            .filter(|&i| image.pixels[i].a() == 255)
            .collect();
        let at = |i: usize| (i % SIZE[0], i / SIZE[0]);
        let (first, last) = (at(bright[0]), at(bright[bright.len() - 1]));
        assert!(first.0 < last.0 && first.1 < last.1, "{first:?} {last:?}");
    }
}
