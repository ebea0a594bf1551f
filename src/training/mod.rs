//! Training: what is asked, what is hidden, how it is answered, and what the answers come to.
//!
//! | part | answers |
//! |---|---|
//! | [`exercise`] | what can be asked: one task a file |
//! | [`run`] | an exercise as it is done, trial after trial; [`shown`]: what of it the trainee may see |
//! | [`trial`] | what a trial hides, what is answered, what is written of it |
//! | [`staircase`] | how strong the next trial is: one rule a file |
//! | [`sitting`], [`journal`] | an exercise with its journal, which no end of the program takes a settled trial from |
//! | [`observer`] | a simulated trainee whose d′ is known |
//! | [`analysis`] | what the trials of an exercise say of who did them |
//! | [`sheet`] | score sheets to print, CSV, Parquet |
//! | [`psychometric`], [`detection`], [`normal`] | share of right answers over strength, fitted; d′ |
//! | [`palpation`], [`score`] | how a back is palpated, and by how much an answer is wrong |
//! | [`level`], [`random`] | strengths on a staircase's scale; chance that can be repeated |

pub mod analysis;
pub mod detection;
pub mod exercise;
pub mod journal;
pub mod level;
pub mod normal;
pub mod observer;
pub mod palpation;
pub mod psychometric;
pub mod random;
pub mod run;
pub mod score;
pub mod sheet;
pub mod shown;
pub mod sitting;
pub mod staircase;
pub mod trial;

pub use palpation::{Facts, Ground, Palpation};
pub use random::Seed;
pub use run::{Felt, Input, Run, TrainingError};
pub use score::{Errors, Score};
pub use shown::{Choice, Phase, Shown, Told, Why};
pub use sitting::{Begun, Sitting};
pub use trial::{Answer, Mark, Reply, TrialRecord};
