//! The falloff from the centre of a dent to its rim.
