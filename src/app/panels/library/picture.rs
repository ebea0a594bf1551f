//! The small picture of a scenario: its stiffness over the outline of the back, with its dysfunctions.

use crate::app::colours::map::Map;
use crate::app::editor::ink::Ink;
use crate::app::editor::plane::Area;
use crate::app::editor::scale::Scale;
use crate::app::editor::silhouette::Silhouette;
use crate::geom::Vec2;
use crate::maps::Spot;
use crate::scenario::{Scenario, SurfaceChoice};
use crate::surface::Surface;
use crate::surface::back::{self, BackOptions};
use egui::{Color32, ColorImage};
use std::sync::{Arc, OnceLock};

/// Size of a picture, pixels: two for each point.
pub const SIZE: [usize; 2] = [168, 200];
/// Triangles of the back whose outline is taken.
const TRIANGLES: usize = 2_962;
/// Half the width of an outline, pixels.
const LINE: f64 = 1.1;
/// Room around keys and dysfunctions where no outline is known, mm.
const ROOM_MM: f64 = 40.0;

/// The outline of the built-in back, worked out once.
#[derive(Default)]
pub struct Silhouettes {
    back: OnceLock<Option<Arc<Silhouette>>>,
}

impl Silhouettes {
    /// That outline; nothing where it cannot be made.
    pub fn back(&self) -> Option<Arc<Silhouette>> {
        let make = || {
            let options = BackOptions {
                triangles: TRIANGLES,
                ..BackOptions::default()
            };
            let (surface, _) = Surface::new(back::make(&options)).ok()?;
            Silhouette::of(&surface, &|| true).map(Arc::new)
        };
        self.back.get_or_init(make).clone()
    }
}

/// The picture; without `tells` it is of what lies under the dysfunctions. Nothing when `go_on` says so, or where the map is
/// refused.
pub fn paint(
    scenario: &Scenario,
    tells: bool,
    silhouettes: &Silhouettes,
    go_on: &dyn Fn() -> bool,
) -> Option<ColorImage> {
    let map = if tells {
        scenario.stiffness_map()
    } else {
        scenario.base_stiffness_map()
    }
    .ok()?;
    let spots: Vec<Spot> = if tells {
        let patches = scenario.patches().ok()?;
        patches.into_iter().map(|(_, p)| p.spot).collect()
    } else {
        Vec::new()
    };
    let silhouette = match scenario.surface {
        SurfaceChoice::BuiltinBack { .. } => silhouettes.back(),
        SurfaceChoice::Mesh { .. } => None,
    };
    let area = match &silhouette {
        Some(s) => s.area.grown(4.0),
        None => {
            let keys = scenario.stiffness_keys.iter().map(|k| k.at);
            Area::around(keys)?.grown(ROOM_MM)
        }
    };
    let [columns, rows] = SIZE;
    let size = Vec2::new(columns as f64, rows as f64);
    let mm = (area.size() / size).max_element();
    let at = |column: usize, row: usize| {
        let p = Vec2::new(column as f64 + 0.5, row as f64 + 0.5) - size * 0.5;
        area.centre() + Vec2::new(p.x, -p.y) * mm
    };
    let covers = |p: Vec2| match &silhouette {
        Some(s) => s.cover.between(p).unwrap_or(0.0),
        None => 1.0,
    };
    let mut reader = map.reader();
    let mut values = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        if !go_on() {
            return None;
        }
        for column in 0..columns {
            let p = at(column, row);
            values.push(if covers(p) > 0.0 { reader(p) } else { f64::NAN });
        }
    }
    let (lo, hi) = values
        .iter()
        .filter(|v| v.is_finite())
        .fold((f64::MAX, f64::MIN), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
    let scale = Scale::new(Map::Sequential, lo, hi);
    let ring = |p: Vec2| {
        let near = |s: &Spot| {
            let [a, b] = s.half_axes_mm;
            (s.ratio(p) - 1.0).abs() * a.min(b) < LINE * mm
        };
        spots.iter().any(near)
    };
    let mut pixels = Vec::with_capacity(values.len());
    for (i, value) in values.iter().enumerate() {
        if value.is_nan() {
            pixels.push(Color32::TRANSPARENT);
            continue;
        }
        let p = at(i % columns, i / columns);
        let colour = scale.colour(*value);
        let colour = if ring(p) {
            Ink::on(colour).text
        } else {
            colour
        };
        // Softly from nothing to something over the cells about the border.
        let cover = ((covers(p) - 0.5) * 3.0 + 0.5).clamp(0.0, 1.0);
        pixels.push(colour.gamma_multiply(cover as f32));
    }
    Some(ColorImage::new(SIZE, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(text: &str, tells: bool) -> ColorImage {
        let scenario = Scenario::parse(text, "a.toml", None).expect("good");
        paint(&scenario, tells, &Silhouettes::default(), &|| true).expect("a picture")
    }

    #[test]
    fn a_dysfunction_is_seen_only_where_it_may_be_told() {
        let plain = "format = 1\nname = \"A\"\n[surface]\nbuiltin = \"back\"\n[stiffness]\nconstant_n_per_mm = 1\n";
        let with = |level: &str| {
            format!(
                "{plain}[[dysfunction]]\nkind = \"hypertonic\"\nlevel = \"{level}\"\nside = \"left\"\n"
            )
        };
        let (bare, t5, l1) = (image(plain, true), with("T5"), with("L1"));
        assert_ne!(image(&t5, true), bare);
        assert_ne!(image(&t5, true), image(&l1, true));
        assert_eq!(image(&t5, false), bare);
        assert_eq!(image(&l1, false), image(&t5, false));
        let seen = bare.pixels.iter().filter(|p| p.a() == 255).count();
        let all = bare.pixels.len();
        assert!(seen * 3 > all && seen < all, "{seen} of {all}");
        // x to the right: the left side of the subject is on the left.
        let changed: Vec<usize> = (image(&t5, true).pixels.iter().zip(&bare.pixels).enumerate())
            .filter(|(_, (a, b))| a != b)
            .map(|(i, _)| i % SIZE[0])
            .collect();
        let mean = changed.iter().sum::<usize>() / changed.len().max(1);
        assert!(!changed.is_empty() && mean < SIZE[0], "{mean}");
    }
}
