//! The JSON files.

use super::channels::{Channel, Kind};
use super::{BIDS_VERSION, Samples};
use crate::session::Header;
use crate::study::export::Key;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Key of the participant's pseudonym, of which the subject's label may be a shortening.
pub const PSEUDONYM: &str = "DorsumPseudonym";

/// What a dataset says to people.
pub const README: &str = "Palpation of the virtual haptic back\n\
    \n\
    Fingers palpated the skin of a simulated human back through haptic devices or a mouse. Each session holds the haptic\n\
    interface point, its velocity, the proxy on the skin and the forces of every finger at every tick of the haptic loop.\n\
    \n\
    Lengths are in mm, forces in N. Frame of the subject: x to the right, y to the head, z out of the back.\n\
    Samples that were lost are missing: the latency channel tells the time of a sample.\n\
    \n\
    Written by Dorsum.\n";

/// `…_motion.json`.
pub fn motion(header: &Header, key: &Key, channels: &[Channel], samples: &Samples) -> Value {
    let count = |kind: Kind| channels.iter().filter(|c| c.kind == kind).count();
    let tracked = channels.iter().filter(|c| c.kind == Kind::Pos);
    let points: BTreeSet<&str> = tracked.map(|c| c.point.as_str()).collect();
    let devices: Vec<&str> = header.devices.iter().map(|d| d.name.as_str()).collect();
    let device = match devices.is_empty() {
        true => "n/a".to_owned(),
        false => devices.join("; "),
    };
    let seconds = samples.last_ns.saturating_sub(samples.first_ns) as f64 / 1e9;
    let effective = (samples.n.saturating_sub(1)) as f64 / seconds;
    let effective = match effective.is_finite() && effective > 0.0 {
        true => json!(effective),
        false => json!("n/a"),
    };
    json!({
        "TaskName": super::TASK,
        "TaskDescription": format!("Palpation of a simulated human back. Scenario: {}", header.scenario_name),
        "SamplingFrequency": header.rate_hz,
        "SamplingFrequencyEffective": effective,
        "RecordingDuration": seconds,
        "TrackingSystemName": device,
        "ManufacturersModelName": device,
        "SoftwareVersions": header.build,
        "MissingValues": "n/a",
        "TrackedPointsCount": points.len(),
        "MotionChannelCount": channels.len(),
        "POSChannelCount": count(Kind::Pos),
        "VELChannelCount": count(Kind::Vel),
        "LATENCYChannelCount": count(Kind::Latency),
        "MiscChannelCount": count(Kind::Misc),
        "ACCELChannelCount": 0,
        "ANGACCELChannelCount": 0,
        "GYROChannelCount": 0,
        "JNTANGChannelCount": 0,
        "MAGNChannelCount": 0,
        "ORNTChannelCount": 0,
        PSEUDONYM: header.participant,
        "DorsumSession": key.session,
        "DorsumMeshSHA256": header.mesh.hash,
    })
}

/// `…_channels.json`.
pub fn channels() -> Value {
    json!({
        "reference_frame": {
            "Description": "Frame that components are given in.",
            "Levels": {
                "subject": {
                    "Description": "Frame of the simulated subject, who lies prone: x to the right, y to the head, z out of the back.",
                    "SpatialAxes": "RSP",
                    "RotationRule": "n/a",
                    "RotationOrder": "n/a",
                }
            }
        }
    })
}

/// `…_events.json`.
pub fn events() -> Value {
    json!({
        "onset": { "Description": "Time since the first sample of the motion recording.", "Units": "s" },
        "duration": { "Description": "Events are instants.", "Units": "s" },
        "trial_type": { "Description": "What sort of event, one word, such as mark, answer, lost or restart." },
        "tick": { "Description": "Number of the newest tick when the event was reported." },
        "text": { "Description": "What the event says." },
        "StimulusPresentation": {
            "SoftwareName": "Dorsum",
            "SoftwareVersion": env!("CARGO_PKG_VERSION"),
        }
    })
}

/// `dataset_description.json`.
pub fn dataset() -> Value {
    json!({
        "Name": "Palpation of the virtual haptic back",
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [{ "Name": "Dorsum", "Version": env!("CARGO_PKG_VERSION") }],
    })
}

/// `participants.json`.
pub fn participants() -> Value {
    json!({
        "pseudonym": { "Description": "Participant as recorded; n/a where the recording names none." }
    })
}
