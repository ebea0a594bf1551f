//! Psychometric functions: the share of right answers over the strength, fitted to answers.
//!
//! P(x) = γ + (1 − γ − λ) F(x), with the guess rate γ fixed at the share of right answers by guessing, and the lapse rate λ
//! fixed or bounded (Wichmann & Hill 2001a). x is a strength above 0, such as the percentage of a change; at x = 0 every
//! family answers by guessing alone, as an observer does who is given nothing to feel.

mod bootstrap;
mod family;
mod fit;
#[cfg(test)]
mod tests;

pub use bootstrap::{Bootstrap, Told};
pub use family::{Family, Shape};
pub use fit::{Fit, Lapse, Model, Point, points};
