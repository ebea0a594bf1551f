//! The recorder thread.
