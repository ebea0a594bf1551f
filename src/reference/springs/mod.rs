//! Mass–spring models of the slab, the classic of interactive simulation, and the position-based one that games use.
//!
//! | file | holds |
//! |---|---|
//! | [`lattice`] | points and springs, fitted to a material |
//! | [`rest`] | where the lattice comes to rest (quasi-static) |
//! | [`motion`] | how it gets there: explicit and implicit steps in time |
//! | [`xpbd`] | the same springs as constraints with compliance (position-based) |

pub mod lattice;
pub mod motion;
pub mod rest;
pub mod xpbd;

pub use lattice::{Lattice, Spring};
