//! The real HID stack, in a guest: `bash tests/hid/run.sh`.
//!
//! A small Linux boots in an emulator with the kernel's own UHID and hidraw. In it this program plays both sides, each in
//! a process of its own: emulated devices (`hid device …`), which the kernel cannot tell from plugged-in ones, and the
//! checks on them (`hid check`), which use the library and the doors that Dorsum uses for real devices. Every check then
//! meets devices that are faulty in a known way, and must fail.
//!
//! It needs a machine of its own, so neither `cargo test` nor CI builds it (`test = false` in Cargo.toml).

mod arm;
mod board;
mod checks;
mod host;
mod kinds;
mod plug;
mod uhid;

use std::process::ExitCode;

use board::Fault;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        Some("device") => match plug::device(&arguments[1..]) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("emulated device: {error}");
                ExitCode::from(2)
            }
        },
        Some("arm") => match arm::arm(&arguments[1..]) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("emulated arm: {error}");
                ExitCode::from(2)
            }
        },
        Some("check") => check(),
        _ => {
            eprintln!("this program runs in the guest that `bash tests/hid/run.sh` boots");
            ExitCode::from(2)
        }
    }
}

fn check() -> ExitCode {
    // For the demonstration that a run fails: every device has this fault. The kernel hands `HID_FAULT=…` on to its init.
    let everywhere = std::env::var("HID_FAULT").ok();
    let everywhere = everywhere
        .and_then(|key| Fault::ALL.into_iter().find(|(known, _)| *known == key))
        .map(|(_, fault)| fault);
    let mut done = 0;
    let mut failed = 0;
    let mut row = |title: &str, kind: &str, good: bool, detail: &str| {
        done += 1;
        failed += u32::from(!good);
        println!(
            "{} {title:<24} {kind:<17} {detail}",
            if good { "ok  " } else { "FAIL" }
        );
    };
    for check in &checks::CHECKS {
        for kind in check.kinds {
            let outcome = (check.run)(kind, everywhere);
            row(
                check.title,
                kind,
                outcome.is_ok(),
                outcome.as_ref().unwrap_or_else(|error| error),
            );
        }
        for (fault, reason) in check.catches.iter().filter(|_| everywhere.is_none()) {
            let title = format!("{} ({})", check.title, fault.key());
            match (check.run)(check.kinds[0], Some(*fault)) {
                Err(error) if error.contains(reason) => {
                    row(&title, check.kinds[0], true, &format!("refused: {error}"))
                }
                Err(error) => row(
                    &title,
                    check.kinds[0],
                    false,
                    &format!("fails for another reason: {error}"),
                ),
                Ok(detail) => row(
                    &title,
                    check.kinds[0],
                    false,
                    &format!("a faulty device passes: {detail}"),
                ),
            }
        }
    }
    println!("checks: {done}, failed: {failed}");
    ExitCode::from(u8::from(failed > 0))
}
