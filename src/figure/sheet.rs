//! The sheet that figures are drawn on: sizes, inks, text that stays inside, the legend and the line below.

use super::plot::{Mark, Series};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::io::{Error, Result};

/// The SVG backend draws in whole numbers: in quarters of a pixel slow curves stay smooth.
pub(super) const PX: u32 = 4;
pub(super) const WIDTH: u32 = 1000 * PX;
pub(super) const TITLE_HEIGHT: u32 = 30 * PX;
const LEGEND_ROW_HEIGHT: u32 = 20 * PX;
pub(super) const X_LABEL_HEIGHT: u32 = 46 * PX;
pub(super) const GAP: u32 = 14 * PX;
/// Between the frames and the caption.
const CAPTION_GAP: u32 = 8 * PX;
const CAPTION_ROW_HEIGHT: u32 = 15 * PX;
pub(super) const LEFT_MARGIN: u32 = 12 * PX;
pub(super) const RIGHT_MARGIN: u32 = 28 * PX;
pub(super) const Y_LABEL_WIDTH: u32 = 68 * PX;
const SWATCH_WIDTH: u32 = 18 * PX;
pub(super) const FRAME_LEFT: u32 = LEFT_MARGIN + Y_LABEL_WIDTH;
pub(super) const FRAME_WIDTH: u32 = WIDTH - FRAME_LEFT - RIGHT_MARGIN;
/// The SVG backend divides a font's size by this.
const FONT_SCALE: f64 = 1.24;
pub(super) const TITLE_SIZE: f64 = 16.0 * PX as f64;
pub(super) const TEXT_SIZE: f64 = 12.5 * PX as f64;
const CAPTION_SIZE: f64 = 11.0 * PX as f64;
/// A wide character, em: no font is at hand to measure with.
const EM_PER_CHAR: f64 = 0.62;
pub(super) const DOT_RADIUS: u32 = 3 * PX;

pub(super) const INK: RGBColor = RGBColor(52, 58, 66);
pub(super) const FAINT: RGBColor = RGBColor(120, 128, 138);
pub(super) const GRID: RGBColor = RGBColor(226, 230, 235);
pub(super) const AXIS: RGBColor = RGBColor(160, 168, 178);

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// An SVG of `height` quarters of a pixel above `caption`, with what `draw` puts on it.
pub(super) fn sheet(
    height: u32,
    caption: &str,
    draw: impl FnOnce(&Area) -> Result<()>,
) -> Result<String> {
    let rows = caption_rows(caption);
    let above = if rows.is_empty() { 0 } else { CAPTION_GAP };
    let whole = height + above + rows.len() as u32 * CAPTION_ROW_HEIGHT + GAP;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, whole)).into_drawing_area();
        root.fill(&WHITE).map_err(Error::other)?;
        let (frames, below) = root.split_vertically(height);
        draw(&frames)?;
        let style = style(CAPTION_SIZE, FAINT).pos(Pos::new(HPos::Left, VPos::Center));
        for (i, row) in rows.iter().enumerate() {
            let middle = above + i as u32 * CAPTION_ROW_HEIGHT + CAPTION_ROW_HEIGHT / 2;
            below
                .draw_text(row, &style, (FRAME_LEFT as i32, middle as i32))
                .map_err(Error::other)?;
        }
        root.present().map_err(Error::other)?;
    }
    let drawn = format!("width=\"{WIDTH}\" height=\"{whole}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", WIDTH / PX, whole / PX);
    Ok(text.replacen(&drawn, &shown, 1))
}

/// The words of a caption in as many rows as they need.
fn caption_rows(caption: &str) -> Vec<String> {
    let most = shortened_chars(FRAME_WIDTH, CAPTION_SIZE);
    let mut rows: Vec<String> = Vec::new();
    for word in caption.split_whitespace() {
        let word = cut(word, most);
        match rows.last_mut() {
            Some(row) if row.chars().count() + 1 + word.chars().count() <= most => {
                row.push(' ');
                row.push_str(&word);
            }
            _ => rows.push(word),
        }
    }
    rows
}

/// Draws what stands above the frame.
pub(super) fn title(area: &Area, text: &str) -> Result<()> {
    let style = style(TITLE_SIZE, INK).pos(Pos::new(HPos::Left, VPos::Center));
    let at = (FRAME_LEFT as i32, (TITLE_HEIGHT / 2 + 4 * PX) as i32);
    area.draw_text(&shortened(text, FRAME_WIDTH, TITLE_SIZE), &style, at)
        .map_err(Error::other)
}

/// Says in the middle of a frame, given in pixels of the area, that it is empty.
pub(super) fn say_no_data(area: &Area, middle: (i32, i32)) -> Result<()> {
    let style = style(TITLE_SIZE, FAINT).pos(Pos::new(HPos::Center, VPos::Center));
    area.draw_text("no data", &style, middle)
        .map_err(Error::other)
}

pub(super) fn style(size: f64, colour: RGBColor) -> TextStyle<'static> {
    let mut style = TextStyle::from(("sans-serif", size * FONT_SCALE).into_font());
    style.color = colour.to_backend_color();
    style
}

/// How many characters fit.
pub(super) fn shortened_chars(width_px: u32, size: f64) -> usize {
    (f64::from(width_px) / (EM_PER_CHAR * size)) as usize
}

fn shortened(text: &str, width_px: u32, size: f64) -> String {
    cut(text, shortened_chars(width_px, size))
}

/// At most `n` characters, with an ellipsis where some are missing, and none that XML forbids.
pub(super) fn cut(text: &str, n: usize) -> String {
    let allowed = |c: char| {
        if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') {
            ' '
        } else {
            c
        }
    };
    let mut short: String = text.chars().take(n).map(allowed).collect();
    if text.chars().nth(n).is_some() {
        short.pop();
        short.push('…');
    }
    short
}

/// What stands before a name in the legend.
#[derive(Clone, Copy)]
pub(super) enum Swatch {
    /// A piece of a curve.
    Curve(Mark),
    /// A piece of a dashed curve without rings.
    Dashes,
    /// A filled box.
    Filled,
}

/// The names of a figure and where they stand, in as many rows as they need.
pub(super) struct Legend(Vec<Entry>);

struct Entry {
    row: u32,
    /// From the left of the frame, quarters of a pixel.
    left: u32,
    name: String,
    colour: RGBColor,
    swatch: Swatch,
}

/// An entry for the legend of each curve.
pub(super) fn named(series: &[Series]) -> impl Iterator<Item = (&str, [u8; 3], Swatch)> {
    series.iter().map(|s| {
        let swatch = match s.has_rings() {
            false if s.mark == Mark::Dashed => Swatch::Dashes,
            _ => Swatch::Curve(s.mark),
        };
        (&*s.name, s.colour, swatch)
    })
}

impl Legend {
    /// Lays out the names that are not empty.
    pub(super) fn new<'a>(entries: impl Iterator<Item = (&'a str, [u8; 3], Swatch)>) -> Self {
        let (mut row, mut left) = (0, 0);
        let mut laid = Vec::new();
        for (name, [r, g, b], swatch) in entries.filter(|e| !e.0.trim().is_empty()) {
            let name = shortened(name, FRAME_WIDTH / 2, TEXT_SIZE);
            let chars = name.chars().count() as f64;
            let wide = SWATCH_WIDTH + 24 * PX + (chars * EM_PER_CHAR * TEXT_SIZE) as u32;
            if left > 0 && left + wide > FRAME_WIDTH {
                (row, left) = (row + 1, 0);
            }
            laid.push(Entry {
                row,
                left,
                name,
                colour: RGBColor(r, g, b),
                swatch,
            });
            left += wide;
        }
        Self(laid)
    }

    /// How high it is.
    pub(super) fn height(&self) -> u32 {
        self.0
            .last()
            .map_or(0, |entry| (entry.row + 1) * LEGEND_ROW_HEIGHT)
    }

    /// Draws it below the title.
    pub(super) fn draw(&self, area: &Area) -> Result<()> {
        let text = style(TEXT_SIZE, INK).pos(Pos::new(HPos::Left, VPos::Center));
        for entry in &self.0 {
            let top = TITLE_HEIGHT + entry.row * LEGEND_ROW_HEIGHT;
            let middle = (top + LEGEND_ROW_HEIGHT / 2) as i32;
            let left = (FRAME_LEFT + entry.left) as i32;
            entry.draw(area, (left, middle))?;
            let at = (left + (SWATCH_WIDTH + 6 * PX) as i32, middle);
            area.draw_text(&entry.name, &text, at)
                .map_err(Error::other)?;
        }
        Ok(())
    }
}

impl Entry {
    /// What the named thing looks like; `at` is its left end, half way up.
    fn draw(&self, area: &Area, (left, middle): (i32, i32)) -> Result<()> {
        let wide = SWATCH_WIDTH as i32;
        let (parts, half): (&[(i32, i32)], u32) = match self.swatch {
            Swatch::Curve(Mark::Line | Mark::Joined) => (&[(0, wide)], PX),
            Swatch::Dashes | Swatch::Curve(Mark::Dashed) => {
                (&[(0, wide / 5), (4 * wide / 5, wide)], PX)
            }
            Swatch::Curve(Mark::Points) => (&[], PX),
            Swatch::Filled => (&[(2, wide - 2)], 6 * PX),
        };
        let half = half as i32;
        for (from, to) in parts {
            let bar = [(left + from, middle - half), (left + to, middle + half)];
            area.draw(&Rectangle::new(bar, self.colour.filled()))
                .map_err(Error::other)?;
        }
        if let Swatch::Curve(mark) = self.swatch
            && mark.has_dots()
        {
            for style in dot_styles(mark, self.colour) {
                area.draw(&Circle::new((left + wide / 2, middle), DOT_RADIUS, style))
                    .map_err(Error::other)?;
            }
        }
        Ok(())
    }
}

/// What makes up a dot, or a ring that hides the curve behind it.
pub(super) fn dot_styles(mark: Mark, colour: RGBColor) -> Vec<ShapeStyle> {
    if mark == Mark::Dashed {
        vec![WHITE.filled(), colour.stroke_width(3 * PX / 2)]
    } else {
        vec![colour.filled()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captions_are_broken_between_words_and_nothing_is_lost() {
        let words: Vec<String> = (0..60).map(|i| format!("word{i}")).collect();
        let text = words.join(" ");
        let rows = caption_rows(&text);
        assert!(rows.len() > 1 && rows.join(" ") == text);
        let most = shortened_chars(FRAME_WIDTH, CAPTION_SIZE);
        assert!(rows.iter().all(|r| r.chars().count() <= most));
        assert!(caption_rows("  ").is_empty());
        assert!(caption_rows(&"x".repeat(1000))[0].ends_with('…'));
    }
}
