//! Skin that drags more, or less.

use super::by_severity;
use crate::scenario::dysfunction::place::one_each;
use crate::scenario::dysfunction::{Dysfunction, Extent, Fault, Kind, Patch, Strength};

pub(super) struct SkinDrag;

/// Factor on the friction coefficients by severity: moist skin drags more. Assumed.
const DRAG: [f64; 4] = [1.0, 1.25, 1.5, 2.0];

impl Kind for SkinDrag {
    fn key(&self) -> &'static str {
        "skin_drag"
    }

    fn title(&self) -> &'static str {
        "Skin drag change"
    }

    fn about(&self) -> &'static str {
        "Skin over which a sliding finger meets more resistance, as where it is moist, or less. Needs friction."
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [25.0, 20.0],
            angle_deg: 90.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        Strength {
            skin_drag: (severity > 0).then(|| by_severity(DRAG, severity)),
            ..Strength::default()
        }
    }

    fn is_felt_by_friction_alone(&self) -> bool {
        true
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        Ok(one_each(d))
    }
}
