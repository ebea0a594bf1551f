//! Drawing the skin with OpenGL. `f32` lives only here.
