//! Re-simulation.
