//! What recordings survive and what they cost.
//!
//! | file | answers |
//! |---|---|
//! | [`damage`] | what is left of a session that was killed, cut or flipped |
//! | [`endurance`] | whether hours repeat bit for bit, and what recording, opening and scrubbing them costs |

pub mod damage;
pub mod endurance;
mod long;

pub use damage::SessionDamage;
pub use endurance::SessionEndurance;
