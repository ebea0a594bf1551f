//! The `dorsum` program; everything is in the library.

use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use std::process::ExitCode;

/// The system's, counted: the lab tells what a scene really holds (`dorsum lab pruning`).
#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

fn main() -> ExitCode {
    ExitCode::from(dorsum::cli::main())
}
