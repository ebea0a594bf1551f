//! A picture as bytes, and as a PNG file.

use super::file::write_whole;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Pixels in rows from the top, sRGB, three bytes each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 · width · height` bytes.
    pub rgb: Vec<u8>,
}

impl Image {
    /// The colour at column `x`, row `y`; `None` outside.
    pub fn pixel(&self, x: usize, y: usize) -> Option<[u8; 3]> {
        if x >= self.width {
            return None;
        }
        let at = 3 * (y * self.width + x);
        self.rgb.get(at..at + 3).and_then(|c| c.try_into().ok())
    }

    /// The image as the bytes of a PNG file, marked sRGB.
    ///
    /// # Errors
    /// An image without pixels, or one whose size and bytes do not agree.
    pub fn png(&self) -> Result<Vec<u8>> {
        let invalid = |e: png::EncodingError| Error::new(ErrorKind::InvalidInput, e);
        let side = |n: usize| {
            u32::try_from(n).map_err(|_| {
                Error::new(
                    ErrorKind::InvalidInput,
                    format!("a picture cannot be {n} pixels wide or high"),
                )
            })
        };
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, side(self.width)?, side(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header().map_err(invalid)?;
        writer.write_image_data(&self.rgb).map_err(invalid)?;
        writer.finish().map_err(invalid)?;
        Ok(bytes)
    }

    /// Writes a PNG file: beside `path`, then renamed, so that no reader sees half of one. The folder must exist.
    ///
    /// # Errors
    /// Those of [`Image::png`], and those of the file system.
    pub fn write_png(&self, path: &Path) -> Result<()> {
        write_whole(path, &self.png()?)
    }
}
