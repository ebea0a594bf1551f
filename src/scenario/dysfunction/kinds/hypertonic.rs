//! A muscle that holds on: stiffer along its fibres.

use super::by_severity;
use crate::scenario::dysfunction::place::one_each;
use crate::scenario::dysfunction::{Change, Dysfunction, Extent, Fault, Kind, Patch, Strength};

pub(super) struct Hypertonic;

/// Change of compliance by severity, percent. Assumed to be what trainees of the virtual haptic back just found: 14 after
/// six sessions, 28 before, 40 in an earlier study (BMC Med Educ 2008;8:14).
const COMPLIANCE_PERCENT: [f64; 4] = [0.0, -14.0, -28.0, -40.0];

impl Kind for Hypertonic {
    fn key(&self) -> &'static str {
        "hypertonic"
    }

    fn title(&self) -> &'static str {
        "Hypertonic muscle"
    }

    fn about(&self) -> &'static str {
        "A muscle that does not let go: it resists more than the same place on the other side. One stiffer ellipse along the \
         fibres."
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [18.0, 12.0],
            angle_deg: 80.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        Strength {
            change: (severity > 0)
                .then(|| Change::CompliancePercent(by_severity(COMPLIANCE_PERCENT, severity))),
            ..Strength::default()
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        Ok(one_each(d))
    }
}
