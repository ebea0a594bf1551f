//! What the figures of training are worth: simulated observers whose d′ is known.
//!
//! | file | answers |
//! |---|---|
//! | [`observer`] | whether staircases, fits and d′ find what is put in |

pub mod observer;

pub use observer::TrainingObserver;
