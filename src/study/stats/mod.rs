//! Agreement of two or more series of measures, and differences of groups.

mod quantile;

pub use quantile::{f_quantile, t_quantile};
