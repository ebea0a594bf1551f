//! Counts instructions exactly: a case runs in a child process of the same program, which is stepped instruction by
//! instruction (ptrace) between its marks. No hardware counter is needed, and none is asked for: virtual machines have none.

use super::case::{Case, Counts};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::process::{Child, Stdio};
use std::sync::OnceLock;

/// Name of the hidden subcommand that runs a case.
pub const SUBCOMMAND: &str = "count-case";

static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Says which program runs cases: one whose subcommand [`SUBCOMMAND`] calls [`serve`]. Without it nothing is counted.
/// Only the first call counts.
pub fn counted_by(program: PathBuf) {
    let _ = PROGRAM.set(program);
}

/// A case, and who asked for it.
#[derive(Serialize, Deserialize)]
struct Job {
    parent: u32,
    case: Case,
}

/// What a case held and did, and the instructions of each window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Counted {
    /// Bytes, allocations, times.
    pub counts: Counts,
    /// Instructions that asking whether the parts are there takes; `None` where they are not counted.
    pub asking: Option<u64>,
    /// Instructions of each window, without the marks; empty where they are not counted.
    pub windows: Vec<u64>,
}

impl Counted {
    /// Instructions of one tick, frame or record: the mean over all windows.
    pub fn each(&self, case: &Case) -> Option<f64> {
        let n = (self.windows.len() * case.per_window) as f64;
        (n > 0.0).then(|| self.windows.iter().sum::<u64>() as f64 / n)
    }
}

/// Why nothing was counted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Uncounted {
    /// It cannot be counted here, and why.
    Here(String),
    /// Whoever watches wants no more.
    Stopped,
}

/// Runs `case` in a process of its own. `go_on` is asked now and then whether to.
///
/// # Errors
/// There is no program to run it, or it failed.
pub fn count(case: &Case, go_on: &mut dyn FnMut() -> bool) -> Result<Counted, Uncounted> {
    let here = |e: &dyn std::fmt::Display| Uncounted::Here(e.to_string());
    let Some(program) = PROGRAM.get() else {
        return Err(Uncounted::Here("only the program itself can count".into()));
    };
    let job = Job {
        parent: std::process::id(),
        case: case.clone(),
    };
    let job = serde_json::to_vec(&job).map_err(|e| here(&e))?;
    let child = std::process::Command::new(program)
        .arg(SUBCOMMAND)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|e| here(&format!("{}: {e}", program.display())))?;
    let mut child = Running(child);
    if let Some(mut stdin) = child.0.stdin.take() {
        std::io::Write::write_all(&mut stdin, &job).map_err(|e| here(&e))?;
    }
    let windows = follow(&child.0, case.most_steps, go_on)?;
    let read = |from: Option<&mut dyn std::io::Read>| {
        let mut text = String::new();
        from.map_or(Ok(0), |from| from.read_to_string(&mut text))?;
        Ok(text)
    };
    let out = child.0.stdout.as_mut().map(|s| s as &mut dyn std::io::Read);
    let said = read(out).map_err(|e: std::io::Error| here(&e))?;
    let outcome: Result<Counts, String> = serde_json::from_str(&said).map_err(|_| {
        let err = child.0.stderr.as_mut().map(|s| s as &mut dyn std::io::Read);
        here(&read(err).unwrap_or_default().trim())
    })?;
    let counts = outcome.map_err(|e| here(&e))?;
    let mut marks = windows.into_iter();
    let nothing = marks.next();
    let bare = |n: u64| n.saturating_sub(nothing.unwrap_or(0));
    let asking = marks.next().map(bare);
    Ok(Counted {
        counts,
        asking,
        windows: marks.map(bare).collect(),
    })
}

/// A child that does not outlive whoever started it.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // One that has ended is told so and no more.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the hidden subcommand does: runs the case that stands on `input` as JSON and gives back what it counted, as JSON.
///
/// # Errors
/// The case is none, or was not asked for by the process that started this one.
pub fn serve(input: &str) -> Result<String, String> {
    let job: Job = serde_json::from_str(input)
        .map_err(|e| format!("{SUBCOMMAND} is for the lab: run `dorsum lab pruning` ({e})"))?;
    if !traced::is_child_of(job.parent) {
        return Err(format!(
            "{SUBCOMMAND} is for the lab: run `dorsum lab pruning`"
        ));
    }
    let mut marks = traced::Marks::default();
    let mut outcome = job.case.run(&mut || marks.mark());
    if let Ok(counts) = &mut outcome {
        counts.refused = marks.refused();
    }
    serde_json::to_string(&outcome).map_err(|e| e.to_string())
}

use traced::follow;

#[cfg(target_os = "linux")]
mod traced {
    use super::Uncounted;
    use nix::errno::Errno;
    use nix::sys::ptrace;
    use nix::sys::signal::{Signal, raise};
    use nix::sys::wait::{WaitStatus, waitpid};
    use nix::unistd::{Pid, getppid};

    /// Marks the beginning and the end of what is counted.
    const MARK: Signal = Signal::SIGUSR1;
    /// Steps between two questions whether to go on.
    const ASKED: u64 = 1 << 14;

    pub fn is_child_of(parent: u32) -> bool {
        u32::try_from(getppid().as_raw()) == Ok(parent)
    }

    /// The child's side: marks by a signal to itself, which only stops who is traced.
    #[derive(Default)]
    pub struct Marks {
        traced: Option<Result<(), Errno>>,
    }

    impl Marks {
        pub fn mark(&mut self) {
            let traced = *self.traced.get_or_insert_with(ptrace::traceme);
            if traced.is_ok() {
                // It stops here until the parent lets it go on, and never gets the signal.
                let _ = raise(MARK);
            }
        }

        pub fn refused(&self) -> Option<String> {
            let refused = self.traced?.err()?;
            Some(format!("stepping is refused: {refused}"))
        }
    }

    /// The parent's side: lets the child run, steps it between marks, and gives back the steps of each pair of marks. After
    /// `most` steps it lets it run without; the window it is in then is not told.
    pub fn follow(
        child: &std::process::Child,
        most: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<u64>, Uncounted> {
        let here = |e: Errno| Uncounted::Here(format!("stepping is refused: {e}"));
        let pid = Pid::from_raw(child.id().cast_signed());
        let mut windows = Vec::new();
        let mut inside: Option<u64> = None;
        let mut steps_left = most;
        loop {
            let mut passed_on = None;
            match waitpid(pid, None) {
                Ok(WaitStatus::Stopped(_, MARK)) => match inside.take() {
                    Some(steps) => windows.push(steps),
                    None if steps_left > 0 => inside = Some(0),
                    None => {}
                },
                Ok(WaitStatus::Stopped(_, Signal::SIGTRAP)) => {
                    if let Some(steps) = &mut inside {
                        *steps += 1;
                        steps_left -= 1;
                        if steps_left.is_multiple_of(ASKED) && !go_on() {
                            return Err(Uncounted::Stopped);
                        }
                    }
                    if steps_left == 0 {
                        inside = None;
                    }
                }
                Ok(WaitStatus::Stopped(_, signal)) => passed_on = Some(signal),
                Ok(WaitStatus::Exited(..)) => return Ok(windows),
                Ok(WaitStatus::Signaled(_, signal, _)) => {
                    return Err(Uncounted::Here(format!("it was ended by {signal}")));
                }
                Ok(_) => continue,
                Err(Errno::EINTR) => continue,
                Err(e) => return Err(here(e)),
            }
            let resumed = match inside {
                Some(_) => ptrace::step(pid, passed_on),
                None => ptrace::cont(pid, passed_on),
            };
            resumed.map_err(here)?;
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod traced {
    use super::Uncounted;

    /// Nobody can tell here.
    pub fn is_child_of(_parent: u32) -> bool {
        true
    }

    /// Marks that nobody sees.
    #[derive(Default)]
    pub struct Marks;

    impl Marks {
        pub fn mark(&mut self) {}

        pub fn refused(&self) -> Option<String> {
            Some("stepping is known on Linux only".into())
        }
    }

    /// Nothing is stepped: the caller waits for what the child says.
    pub fn follow(
        _child: &std::process::Child,
        _most: u64,
        _go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Vec<u64>, Uncounted> {
        Ok(Vec::new())
    }
}
