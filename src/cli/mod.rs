//! The command line: one file per subcommand.

/// Runs the program with the process's arguments and returns its exit code: 0 done, 1 the thing checked does not hold,
/// 2 bad usage or bad input.
pub fn main() -> u8 {
    0
}
