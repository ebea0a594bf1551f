//! Pictures without a window: plots and the shaded back.
