//! Devices that speak HID: what goes over the wire, the arm behind it, how it is kept safe.
//!
//! | file | answers |
//! |---|---|
//! | [`report`] | which bytes mean what |
//! | [`arm`], [`models`] | where the tip is, which currents make a force |
//! | [`driver`] | an arm behind each protocol |
//! | [`arms`], [`spacemouse`] | the families |
//! | [`attached`] | which of them are there |
//! | [`velocity`] | how fast it moves, out of encoder steps |
//! | [`guard`] | when the force must go |
//! | [`transport`] | the wire |
//! | [`link`] | the thread between wire and servo |
//! | [`emulator`] | a device that is not there, for tests |
//! | [`check`] | does the loop hold |
//! | [`vitals`] | what the link tells about itself |

pub mod arm;
pub mod arms;
pub mod attached;
pub mod check;
pub mod driver;
pub mod emulator;
pub mod guard;
pub mod link;
pub mod models;
pub mod report;
pub mod spacemouse;
pub mod transport;
pub mod velocity;
pub mod vitals;
