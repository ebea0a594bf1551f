//! Dorsum: a lab workbench for the virtual haptic back.
//!
//! A life-size human back is palpated with haptic devices or the mouse; the drawn skin deforms under the fingers,
//! stiffness hides dysfunctions, every session is recorded, replayed bit-exactly and compared.
//!
//! # Map
//! Each module names only those above it (`tests/architecture.rs` enforces it).
//!
//! | module | answers |
//! |---|---|
//! | [`units`] | which units the program speaks, and the only conversions |
//! | [`table`] | typed tables, row by row into CSV and Parquet |
//! | [`geom`] | where is the closest point, where does a segment cross |
//! | [`surface`] | what is the skin: mesh, adjacency, repair, file formats, the built-in back |
//! | [`partition`] | which triangles are near, which does a motion cross |
//! | [`maps`] | how stiff is the skin at a point, in which ellipse does it give way |
//! | [`contact`] | where is the proxy, what force does the finger feel |
//! | [`deform`] | how does the drawn skin move |
//! | [`mod@reference`] | what elasticity says it does |
//! | [`device`] | where is the finger, who takes the force |
//! | [`servo`] | the tick, the 1 kHz thread and its three lines to the window |
//! | [`session`] | how a run is written, read, replayed and checked |
//! | [`scenario`] | what a scene is made of, and what it needs |
//! | [`training`] | what is asked and hidden, how it is answered, what the answers come to |
//! | [`study`] | what recorded sessions tell, alone and beside each other |
//! | [`figure`] | pictures without a window: plots and the shaded back |
//! | [`lab`] | experiments: what a method costs, what it misses, what it gets right |
//! | `app` | the workbench (feature `gui`) |
//! | [`cli`] | the command line |
//!
//! # Invariants
//! - [`servo::tick`] is a pure function of rig, input and time step: no clock, allocation, lock, I/O, panic. Live run,
//!   replay and tests all call it, so a replay equals the run bit for bit.
//! - The haptic surface never deforms (Ji 2008, 2.3): the servo sees an immutable [`surface::Surface`].
//! - Core numbers are `f64` in mm, N, N/mm and s; `f32` lives only in `app::render`.
//! - Force is always finite and inside the device's rated force.

pub mod cli;
pub mod contact;
pub mod deform;
pub mod device;
pub mod figure;
pub mod geom;
pub mod lab;
pub mod maps;
pub mod partition;
pub mod reference;
pub mod scenario;
pub mod servo;
pub mod session;
pub mod study;
pub mod surface;
pub mod table;
pub mod training;
pub mod units;

#[cfg(feature = "gui")]
pub mod app;
