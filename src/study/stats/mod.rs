//! Agreement of two or more series of measures, and differences of groups.

mod agreement;
mod groups;
mod icc;
mod noncentral;
mod quantile;

pub use agreement::{BlandAltman, bland_altman};
pub use groups::{GroupDifference, Pairing, Summary, paired, small_sample, summary, unpaired};
pub use icc::{Icc, IccForm, icc};
pub use noncentral::{noncentral_t_below, noncentrality_interval};
pub use quantile::{f_quantile, t_quantile};
