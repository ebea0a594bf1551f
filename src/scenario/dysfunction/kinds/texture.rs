//! Changed tissue texture: oedema and fibrosis.

use super::by_severity;
use crate::scenario::dysfunction::place::one_each;
use crate::scenario::dysfunction::{
    Change, Dysfunction, Extent, Fault, Kind, Patch, Preset, Strength,
};

pub(super) struct Texture;

const OEDEMA: &str = "oedema";
const FIBROSIS: &str = "fibrosis";

const PRESETS: [Preset; 2] = [
    Preset {
        key: OEDEMA,
        title: "Oedema",
        about: "Boggy: softer and a little swollen, as in a fresh strain.",
    },
    Preset {
        key: FIBROSIS,
        title: "Fibrosis",
        about: "Ropy: stiffer, and the skin drags more, as in an old strain.",
    },
];

/// By severity, all assumed: change of stiffness in percent, swelling in mm, drag.
const OEDEMA_PERCENT: [f64; 4] = [0.0, -15.0, -30.0, -45.0];
const OEDEMA_MM: [f64; 4] = [0.0, 0.4, 0.8, 1.5];
const FIBROSIS_PERCENT: [f64; 4] = [0.0, 20.0, 45.0, 90.0];
const FIBROSIS_DRAG: [f64; 4] = [1.0, 1.15, 1.3, 1.6];

impl Kind for Texture {
    fn key(&self) -> &'static str {
        "texture"
    }

    fn title(&self) -> &'static str {
        "Tissue texture change"
    }

    fn about(&self) -> &'static str {
        "Tissue that feels different over a wider area: boggy where it is swollen, ropy where it is scarred."
    }

    fn presets(&self) -> &'static [Preset] {
        &PRESETS
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [30.0, 20.0],
            angle_deg: 80.0,
            profile: "cosine",
        }
    }

    fn strength(&self, preset: Option<&str>, severity: u8) -> Strength {
        let change = |percent| Some(Change::StiffnessPercent(by_severity(percent, severity)));
        match preset {
            _ if severity == 0 => Strength::default(),
            Some(FIBROSIS) => Strength {
                change: change(FIBROSIS_PERCENT),
                skin_drag: Some(by_severity(FIBROSIS_DRAG, severity)),
                ..Strength::default()
            },
            _ => Strength {
                change: change(OEDEMA_PERCENT),
                bump_mm: Some(by_severity(OEDEMA_MM, severity)),
                ..Strength::default()
            },
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        Ok(one_each(d))
    }
}
