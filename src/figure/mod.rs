//! Pictures without a window: plots and the shaded back.
//!
//! [`Picture`] draws the skin and the fingers in software, [`plot`] draws curves as SVG. Both need no display, no graphics
//! library and no installed font, and give the same bytes every time.

mod axis;
mod camera;
pub mod cells;
mod file;
mod image;
pub mod page;
pub mod picture;
pub mod plot;
mod raster;
mod relief;
mod sheet;

pub use axis::{Marks, Scale, axis_marks, axis_range};
pub use camera::Camera;
pub use cells::{CellBox, CellMap, Class};
pub use file::{Beside, write_files};
pub use image::Image;
pub use page::Page;
pub use picture::{Ball, Picture};
pub use plot::{LinePlot, Mark, Series, write_svg};

/// sRGB colour of the left finger, everywhere.
pub const LEFT: [u8; 3] = [38, 104, 196];
/// sRGB colour of the right finger, everywhere.
pub const RIGHT: [u8; 3] = [200, 52, 48];
