//! Time on the skin over the back, as SVG.

use crate::geom::Vec2;
use crate::scenario::{self, Scenario, Use, VertebralLevel};
use crate::session::Session;
use crate::study::Dwell;
use maud::{Markup, PreEscaped, html};
use std::sync::Arc;

/// The outline of a back on the map plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Corners in order, mm.
    pub corners_mm: Vec<[f64; 2]>,
    /// Spinous processes with their levels, mm; none but on the built-in back.
    pub levels_mm: Vec<(&'static str, [f64; 2])>,
}

/// Strips of the outline along the body.
const STRIPS: usize = 96;

impl Outline {
    /// Of the surface that a session names; `None` where it is not at hand.
    pub fn of(session: &Session) -> Option<Self> {
        let header = session.header();
        let parsed = Scenario::parse(&header.scenario_toml, "scenario", session.path().parent());
        let scene =
            scenario::build(Arc::new(parsed.ok()?), Use::default(), &mut |_, _| true).ok()?;
        let bounds = scene.surface.bounds();
        let (low, high) = (bounds.min.y, bounds.max.y);
        let strip = (high - low) / STRIPS as f64;
        if strip.is_nan() || strip <= 0.0 {
            return None;
        }
        let mut widest = [[f64::INFINITY, f64::NEG_INFINITY]; STRIPS + 1];
        let positions = scene.surface.positions();
        for corners in scene.surface.triangles() {
            let corner = |i: usize| {
                positions
                    .get(corners[i] as usize)
                    .map_or(Vec2::ZERO, |p| p.truncate())
            };
            for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corner(i), corner(j))) {
                let (from, to) = (a.y.min(b.y), a.y.max(b.y));
                let first = ((from - low) / strip - 1e-9).ceil().max(0.0) as usize;
                let last = (((to - low) / strip + 1e-9).floor().max(0.0) as usize).min(STRIPS);
                for line in first..=last {
                    let y = low + line as f64 * strip;
                    let share = if to > from {
                        ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0)
                    } else {
                        0.0
                    };
                    let x = a.x + (b.x - a.x) * share;
                    if let Some([least, most]) = widest.get_mut(line) {
                        (*least, *most) = (least.min(x), most.max(x));
                    }
                }
            }
        }
        let lines = (0..=STRIPS).filter(|i| widest[*i][0] <= widest[*i][1]);
        let place = |side: usize| {
            let widest = &widest;
            move |i: usize| [widest[i][side], low + i as f64 * strip]
        };
        let left: Vec<[f64; 2]> = lines.clone().map(place(0)).collect();
        let right = lines.rev().map(place(1));
        let on_back = header.mesh.origin == "builtin:back";
        let levels = VertebralLevel::all().filter(|_| on_back).map(|level| {
            let site = scenario::Site {
                level,
                side: scenario::dysfunction::Side::Middle,
                target: scenario::Target::Spinous,
            };
            (level.name(), site.at_mm().to_array())
        });
        Some(Self {
            corners_mm: left.into_iter().chain(right).collect(),
            levels_mm: levels.collect(),
        })
    }
}

/// Viridis (Smith & van der Walt 2015) at five places, from its light end: little time is pale on paper.
const RAMP: [[f64; 3]; 5] = [
    [253.0, 231.0, 37.0],
    [94.0, 201.0, 98.0],
    [33.0, 145.0, 140.0],
    [59.0, 82.0, 139.0],
    [68.0, 1.0, 84.0],
];

/// The colour of a share of the longest time, as `#rrggbb`.
fn ramp(share: f64) -> String {
    let at = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
    let i = (at as usize).min(RAMP.len() - 2);
    let part = at - i as f64;
    let of = |c: usize| (RAMP[i][c] + (RAMP[i + 1][c] - RAMP[i][c]) * part).round() as u8;
    format!("#{:02x}{:02x}{:02x}", of(0), of(1), of(2))
}

/// The map of one session: cells over the outline of the back, with a legend in seconds. Colours go by the root of time, so
/// that a brief touch is seen beside a long stay. `most_s` is the longest time of the legend.
pub(super) fn svg(name: &str, dwell: &Dwell, outline: Option<&Outline>, most_s: f64) -> Markup {
    let cell = dwell.cell_mm;
    let [left, low] = dwell.origin_mm;
    let (right, high) = (
        left + dwell.columns as f64 * cell,
        low + dwell.rows as f64 * cell,
    );
    let none = Outline::default();
    let outline = outline.unwrap_or(&none);
    let grown = outline
        .corners_mm
        .iter()
        .fold([left, low, right, high], |b, c| {
            [
                b[0].min(c[0]),
                b[1].min(c[1]),
                b[2].max(c[0]),
                b[3].max(c[1]),
            ]
        });
    let margin = 12.0;
    let [x0, y0, x1, y1] = [
        grown[0] - margin,
        grown[1] - margin,
        grown[2] + margin,
        grown[3] + margin,
    ];
    let (width, height) = ((x1 - x0).max(40.0), (y1 - y0).max(40.0));
    // The head is up: y is drawn downward.
    let down = |y: f64| y1 - y;
    let path: String = outline
        .corners_mm
        .iter()
        .enumerate()
        .map(|(i, [x, y])| {
            format!(
                "{}{:.1} {:.1}",
                if i == 0 { "M" } else { "L" },
                x - x0,
                down(*y)
            )
        })
        .collect();
    let most_s = if most_s > 0.0 { most_s } else { 1.0 };
    let share = |s: f64| (s / most_s).sqrt();
    let touched = dwell.seconds.iter().enumerate().filter(|(_, s)| **s > 0.0);
    let cells: String = touched
        .map(|(i, s)| {
            let (column, row) = ((i % dwell.columns) as f64, (i / dwell.columns) as f64);
            let (x, y) = (left + column * cell - x0, down(low + (row + 1.0) * cell));
            let fill = ramp(share(f64::from(*s)));
            format!("<rect x='{x:.1}' y='{y:.1}' width='{cell}' height='{cell}' fill='{fill}'/>")
        })
        .collect();
    let (bar_x, bar_top, bar_height) = (width + 14.0, 0.14 * height, 0.72 * height);
    let (whole, font) = (width + 86.0, 13.0);
    html! {
        figure.heat {
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {whole:.1} {height:.1}")) role="img"
                aria-label=(format!("Time on the skin of {name}")) font-family="sans-serif" {
                path d=(format!("{path}Z")) fill="#f3ece6" stroke="#b9aca1" stroke-width="1.5" {}
                (PreEscaped(cells))
                @for (level, [x, y]) in &outline.levels_mm {
                    circle cx=(format!("{:.1}", x - x0)) cy=(format!("{:.1}", down(*y))) r="1.6" fill="none" stroke="#6b625b" stroke-width="0.8" {}
                    @if ["C7", "T4", "T8", "T12", "L4"].contains(level) {
                        text x=(format!("{:.1}", x - x0 + 5.0)) y=(format!("{:.1}", down(*y) + 3.5)) font-size="9" fill="#6b625b" { (level) }
                    }
                }
                @for step in 0..40 {
                    rect x=(format!("{bar_x:.1}")) y=(format!("{:.2}", bar_top + bar_height * (1.0 - f64::from(step + 1) / 40.0)))
                        width="14" height=(format!("{:.2}", bar_height / 40.0 + 0.3)) fill=(ramp((f64::from(step) + 0.5) / 40.0)) {}
                }
                @for part in [0.0_f64, 0.25, 0.5, 0.75, 1.0] {
                    text x=(format!("{:.1}", bar_x + 19.0)) y=(format!("{:.1}", bar_top + bar_height * (1.0 - part) + 4.5)) font-size=(font) fill="#343a42" {
                        (seconds(part * part * most_s))
                    }
                }
                text x=(format!("{bar_x:.1}")) y=(format!("{:.1}", bar_top - 12.0)) font-size=(font) fill="#343a42" { "time (s)" }
            }
            figcaption { (name) ": " (seconds(dwell.total_s())) " s on the skin, cells of " (format!("{cell}")) " mm" }
        }
    }
}

fn seconds(s: f64) -> String {
    match s {
        ..0.0005 => "0".into(),
        ..0.0995 => format!("{s:.3}"),
        ..9.95 => format!("{s:.2}"),
        ..99.5 => format!("{s:.1}"),
        _ => format!("{s:.0}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_goes_from_pale_to_dark_and_takes_what_is_beyond() {
        assert_eq!(
            (ramp(0.0).as_str(), ramp(1.0).as_str()),
            ("#fde725", "#440154")
        );
        assert_eq!((ramp(-3.0), ramp(9.0)), (ramp(0.0), ramp(1.0)));
        assert_eq!(ramp(0.25), "#5ec962");
        assert!(ramp(f64::NAN).starts_with('#'));
    }
}
