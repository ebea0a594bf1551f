//! The example scenarios embedded in the program.

/// An embedded scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// File name in `assets/scenarios`.
    pub file: &'static str,
    /// The file, whole.
    pub text: &'static str,
}

/// All of them; the first is the default.
pub fn examples() -> &'static [Example] {
    &[]
}

/// What opens when nothing is asked for.
pub fn default_example() -> Example {
    Example { file: "", text: "" }
}
