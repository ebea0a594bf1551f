//! What is written and drawn with over a coloured map.

use super::grid::Grid;
use super::scale::Scale;
use super::silhouette::Silhouette;
use crate::app::theme::{self, Theme};
use crate::geom::Vec2;
use egui::{Align2, Color32, FontId, Pos2, Rect, vec2};
use std::sync::Arc;

/// What is written and drawn with, so that it stands out from its ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    /// Of lines and text.
    pub text: Color32,
    /// Around them.
    pub halo: Color32,
}

impl Ink {
    /// On the ground of the window.
    pub fn of(theme: &Theme) -> Self {
        Self {
            text: theme.text,
            halo: theme.inset.gamma_multiply(0.75),
        }
    }

    /// On a colour: dark on light ones, light on dark ones.
    pub fn on(colour: Color32) -> Self {
        let of = |theme: &Theme| Self {
            text: theme.text,
            halo: theme.inset.gamma_multiply(0.55),
        };
        let [r, g, b] = [colour.r(), colour.g(), colour.b()].map(f32::from);
        // Weighed as the eye does, on the coded values: good enough for one or the other.
        let light = 0.299 * r + 0.587 * g + 0.114 * b > 132.0;
        of(if light { &theme::LIGHT } else { &theme::DARK })
    }
}

/// Which ink to use where.
pub struct Inks<'a> {
    /// Where there is no colour.
    pub plain: Ink,
    /// The colours.
    pub field: Option<(&'a Grid, Scale)>,
    /// Beside it colours are dimmed.
    pub within: Option<Arc<Silhouette>>,
}

impl Inks<'_> {
    /// The ink for a place of the map.
    pub fn at(&self, p: Vec2) -> Ink {
        let dimmed = self.within.as_ref().is_some_and(|s| !s.covers(p));
        match &self.field {
            Some((grid, scale)) if !dimmed => grid
                .between(p)
                .map_or(self.plain, |v| Ink::on(scale.colour(v))),
            _ => self.plain,
        }
    }
}

/// Text with a halo.
pub fn halo_text(
    painter: &egui::Painter,
    at: Pos2,
    align: Align2,
    text: &str,
    font: &FontId,
    ink: Ink,
) -> Rect {
    for d in [
        vec2(-1.0, 0.0),
        vec2(1.0, 0.0),
        vec2(0.0, -1.0),
        vec2(0.0, 1.0),
    ] {
        painter.text(at + d, align, text, font.clone(), ink.halo);
    }
    painter.text(at, align, text, font.clone(), ink.text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_stands_out_from_any_grey() {
        for grey in 0..=255 {
            let ink = Ink::on(Color32::from_gray(grey)).text;
            assert!(
                (f32::from(ink.g()) - f32::from(grey)).abs() > 70.0,
                "{grey}"
            );
        }
    }
}
