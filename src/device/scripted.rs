//! Trajectories and named scripts.
