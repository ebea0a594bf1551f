//! `dorsum recover`: saves what a damaged or unfinished session still holds, and counts what it does not.

use super::common::progress_bar;
use super::{CliError, Outcome, print, print_json};
use crate::session::{IfExists, RecoverOptions, RecoverReport, recover};
use std::path::PathBuf;

/// Which session, and where to.
#[derive(Debug, clap::Args)]
pub struct RecoverArgs {
    /// The session: damaged, cut off or whole.
    broken: PathBuf,
    /// The new session.
    out: PathBuf,
    /// Compress the new session.
    #[arg(long)]
    compress: bool,
    /// Replace the new session if it is there.
    #[arg(long)]
    force: bool,
}

#[derive(serde::Serialize)]
struct Printed<'a> {
    whole: bool,
    #[serde(flatten)]
    report: &'a RecoverReport,
}

/// Writes the new session and says what was saved and what was lost.
///
/// # Errors
/// The session has no header, the new one is there already, or the system refuses.
pub fn run(args: &RecoverArgs, json: bool) -> Result<Outcome, CliError> {
    if !args.force && args.out.exists() {
        let what = "is already there; choose another name or add --force";
        return Err(CliError::input(format_args!(
            "{}: {what}",
            args.out.display()
        )));
    }
    let options = RecoverOptions {
        compress: args.compress,
        if_exists: match args.force {
            true => IfExists::Replace,
            false => IfExists::Refuse,
        },
    };
    let bar = progress_bar(1000, "recovering   {bar:40} {percent:>3} %  {eta}");
    let report = recover(&args.broken, &args.out, &options, &mut |done| {
        bar.set_position((done * 1000.0) as u64);
        true
    });
    bar.finish_and_clear();
    let report = report.map_err(CliError::input)?;
    if json {
        let whole = report.is_whole();
        print_json(&Printed {
            whole,
            report: &report,
        })?;
    } else {
        tell(&report);
    }
    Ok(Outcome::Done)
}

fn tell(report: &RecoverReport) {
    let (ticks, seconds) = (report.ticks, report.seconds);
    print(format_args!(
        "saved         {ticks:>8} ticks, {seconds:.1} s, {} events, {} edits",
        report.events, report.edits
    ));
    for f in &report.fingers {
        let live = match f.lost_live {
            0 => String::new(),
            n => format!(", {n} lost while it was recorded"),
        };
        print(format_args!(
            "finger {}      {:>8} records, {} missing in {} gaps{live}",
            f.finger, f.records, f.missing, f.gaps
        ));
    }
    let d = &report.damage;
    print(format_args!(
        "skipped       {:>8} chunks, {} messages, {} bytes",
        d.chunks, d.messages, d.bytes
    ));
    if d.unfinished {
        print("unfinished    the recording was killed or cut; saved as far as it goes");
    }
    if !d.first.is_empty() {
        print(format_args!("first         at {}", d.first));
    }
    print(format_args!(
        "written to {}, {} bytes",
        report.out.display(),
        report.bytes
    ));
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: RecoverArgs,
    }

    #[test]
    fn a_sample_session_is_taken_over_and_nothing_is_overwritten() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("out.mcap");
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/sessions/healthy_slide.mcap");
        let line = ["recover", sample, &out.to_string_lossy(), "--compress"];
        let line = Line::try_parse_from(line).expect("good usage");
        assert_eq!(run(&line.args, true), Ok(Outcome::Done));
        let size = |path: &str| std::fs::metadata(path).expect("a file").len();
        assert!(size(&out.to_string_lossy()) * 2 < size(sample));
        let error = run(&line.args, true).expect_err("refused").to_string();
        assert!(error.contains("--force"), "{error}");
    }
}
