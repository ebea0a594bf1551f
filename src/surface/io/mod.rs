//! Meshes from and to files, one format per file.
