//! The layout of a session file.
