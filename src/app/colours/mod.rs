//! Colours that stand for numbers: perceptually uniform maps and the scales that lay numbers on them.

pub mod maps;

pub use maps::{ColourMap, Scale};
