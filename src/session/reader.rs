//! Reading sessions.
