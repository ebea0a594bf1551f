//! The recordings in `sessions/` replay bit for bit, whatever machine recorded them.
//!
//! They were made with
//! ```text
//! dorsum run t5_right.toml --script press --record sessions/t5_right_press.mcap
//! dorsum run FIRST.toml --script slide --rate 400 --record sessions/healthy_slide.mcap
//! ```
//! A change of the built-in back, of contact or of the limits makes them differ on purpose: record them anew, and say so.

use dorsum::contact::Touch;
use dorsum::scenario::{self, Scenario, Use};
use dorsum::servo::Rig;
use dorsum::session::{Session, Strictness, check_with};
use std::path::Path;
use std::sync::Arc;

#[test]
fn recorded_sessions_replay_bit_for_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("sessions");
    let files = std::fs::read_dir(folder).expect("the folder of recordings");
    let files = files.map(|f| f.expect("a file").path());
    let mut files: Vec<_> = files
        .filter(|f| f.extension().is_some_and(|e| e == "mcap"))
        .collect();
    files.sort();
    assert!(files.len() >= 2, "{files:?}");
    for file in files {
        let session = Session::open(&file).expect("a session");
        let header = session.header();
        let origin = file.display().to_string();
        let scenario = Scenario::parse(&header.scenario_toml, &origin, None).expect("parses");
        let scene = scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true);
        let rig = Rig::new(Box::new(scene.expect("builds").touch), header.limits());
        // They are older than the passivity controller.
        assert!(header.limits().iter().all(|l| !l.passivity), "{origin}");
        let mut touching = 0;
        let report = check_with(&session, rig, Strictness::Strict, |pair, _| {
            let fingers = pair.recorded.fingers();
            touching += u64::from(fingers.iter().any(|r| r.contact.touch != Touch::Free));
            assert!(
                fingers.iter().all(|r| r.passivity_energy_n_mm == 0.0),
                "{origin}"
            );
        });
        let report = report.unwrap_or_else(|e| panic!("{e}"));
        assert!(
            report.is_bit_exact(),
            "{origin}: {:?}",
            report.first_difference
        );
        assert!(
            report.passed.gaps == 0 && report.ticks > 1000 && touching > 300,
            "{origin}: {report:?}"
        );
    }
}
