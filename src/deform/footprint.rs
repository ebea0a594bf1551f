//! The outline of a dent on the skin.
