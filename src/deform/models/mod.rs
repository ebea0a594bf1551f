//! Deformation models, one per file.

pub mod fsmd;
