//! The columns of `motion.tsv`.

use crate::contact::Touch;
use crate::servo::FingerRecord;
use crate::table::number_text;
use std::fmt::Write;

/// What a column is, by BIDS's types.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Time since the first sample.
    Latency,
    /// Position.
    Pos,
    /// Velocity.
    Vel,
    /// Anything else.
    Misc,
}

impl Kind {
    fn text(self) -> &'static str {
        match self {
            Self::Latency => "LATENCY",
            Self::Pos => "POS",
            Self::Vel => "VEL",
            Self::Misc => "MISC",
        }
    }
}

type Get = fn(&FingerRecord) -> f64;

/// One column of `motion.tsv`.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Name, once in the file.
    pub name: String,
    /// `x`, `y`, `z` or `n/a`.
    pub component: &'static str,
    /// Type.
    pub kind: Kind,
    /// What was tracked, `n/a` for the clock.
    pub point: String,
    /// Unit.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Which finger, and its number; `None` for the clock.
    of: Option<(usize, Get)>,
}

/// Columns of each finger, without its number.
#[rustfmt::skip]
const FINGER: [(&str, &str, Kind, &str, &str, &str, Get); 18] = [
    ("position_x", "x", Kind::Pos, "", "mm", "Haptic interface point", |r| r.reading.position_mm.x),
    ("position_y", "y", Kind::Pos, "", "mm", "Haptic interface point", |r| r.reading.position_mm.y),
    ("position_z", "z", Kind::Pos, "", "mm", "Haptic interface point", |r| r.reading.position_mm.z),
    ("velocity_x", "x", Kind::Vel, "", "mm/s", "Velocity of the haptic interface point", |r| r.reading.velocity_mm_s.x),
    ("velocity_y", "y", Kind::Vel, "", "mm/s", "Velocity of the haptic interface point", |r| r.reading.velocity_mm_s.y),
    ("velocity_z", "z", Kind::Vel, "", "mm/s", "Velocity of the haptic interface point", |r| r.reading.velocity_mm_s.z),
    ("proxy_x", "x", Kind::Pos, "proxy", "mm", "Proxy on the skin", |r| r.contact.anchor_mm.x),
    ("proxy_y", "y", Kind::Pos, "proxy", "mm", "Proxy on the skin", |r| r.contact.anchor_mm.y),
    ("proxy_z", "z", Kind::Pos, "proxy", "mm", "Proxy on the skin", |r| r.contact.anchor_mm.z),
    ("force_x", "x", Kind::Misc, "", "N", "Force of the skin on the finger before any limit", |r| r.contact.force_n.x),
    ("force_y", "y", Kind::Misc, "", "N", "Force of the skin on the finger before any limit", |r| r.contact.force_n.y),
    ("force_z", "z", Kind::Misc, "", "N", "Force of the skin on the finger before any limit", |r| r.contact.force_n.z),
    ("sentforce_x", "x", Kind::Misc, "", "N", "Force sent to the device", |r| r.sent_force_n.x),
    ("sentforce_y", "y", Kind::Misc, "", "N", "Force sent to the device", |r| r.sent_force_n.y),
    ("sentforce_z", "z", Kind::Misc, "", "N", "Force sent to the device", |r| r.sent_force_n.z),
    ("depth", "n/a", Kind::Misc, "", "mm", "Depth of the haptic interface point below the skin", |r| r.contact.depth_mm),
    ("stiffness", "n/a", Kind::Misc, "", "N/mm", "Stiffness at the proxy", |r| r.contact.stiffness_n_per_mm),
    ("touch", "n/a", Kind::Misc, "", "n/a", "0 free, 1 frictionless, 2 stick, 3 slip", touch_code),
];

fn touch_code(record: &FingerRecord) -> f64 {
    match record.contact.touch {
        Touch::Free => 0.0,
        Touch::Frictionless => 1.0,
        Touch::Stick => 2.0,
        Touch::Slip => 3.0,
    }
}

/// The columns of a session of `fingers` fingers.
pub fn of(fingers: usize) -> Vec<Channel> {
    let clock = Channel {
        name: "latency".into(),
        component: "n/a",
        kind: Kind::Latency,
        point: "n/a".into(),
        unit: "s",
        about: "Time since the first sample",
        of: None,
    };
    let of_finger = |i: usize| {
        FINGER.iter().map(
            move |&(name, component, kind, point, unit, about, get)| Channel {
                name: format!("finger{i}_{name}"),
                component,
                kind,
                point: format!("finger{i}{point}"),
                unit,
                about,
                of: Some((i, get)),
            },
        )
    };
    let rest = (0..fingers).flat_map(of_finger);
    std::iter::once(clock).chain(rest).collect()
}

/// Writes a sample; what is not finite is missing.
pub fn line(channels: &[Channel], fingers: &[FingerRecord], first_ns: u64, line: &mut String) {
    for (i, channel) in channels.iter().enumerate() {
        if i > 0 {
            line.push('\t');
        }
        let value = match channel.of {
            None => {
                let now = fingers.first().map_or(first_ns, |r| r.time_ns);
                line.push_str(&super::seconds_between(first_ns, now));
                continue;
            }
            Some((finger, get)) => fingers.get(finger).map(get),
        };
        match value.filter(|x| x.is_finite()) {
            Some(x) => {
                let _ = write!(line, "{}", number_text(x));
            }
            None => line.push_str("n/a"),
        }
    }
    line.push('\n');
}

/// `channels.tsv`.
pub fn tsv(channels: &[Channel], rate_hz: f64) -> Vec<u8> {
    let names = [
        "name",
        "component",
        "type",
        "tracked_point",
        "units",
        "placement",
        "reference_frame",
        "description",
        "sampling_frequency",
    ];
    let mut lines = vec![names.map(str::to_owned).to_vec()];
    for channel in channels {
        let (frame, placement) = match channel.component {
            "n/a" => ("n/a", "n/a"),
            _ => ("subject", "fingertip"),
        };
        lines.push(vec![
            channel.name.clone(),
            channel.component.into(),
            channel.kind.text().into(),
            channel.point.clone(),
            channel.unit.into(),
            placement.into(),
            frame.into(),
            channel.about.into(),
            number_text(rate_hz),
        ]);
    }
    super::tsv(&lines)
}
