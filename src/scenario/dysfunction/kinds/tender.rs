//! A tender point: nothing to be felt, but it hurts.

use super::by_severity;
use crate::scenario::dysfunction::place::one_each;
use crate::scenario::dysfunction::{Dysfunction, Extent, Fault, Kind, Patch, Strength};

pub(super) struct Tender;

/// Force from which on it hurts by severity, N; assumed, in the range of fingers that palpate (METHOD, section 7).
const TENDER_N: [f64; 4] = [f64::INFINITY, 4.0, 2.5, 1.5];

impl Kind for Tender {
    fn key(&self) -> &'static str {
        "tender"
    }

    fn title(&self) -> &'static str {
        "Tender point"
    }

    fn about(&self) -> &'static str {
        "A place that hurts from a force on. Nothing is felt there; the patient shows it, or it is only counted."
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [10.0, 10.0],
            angle_deg: 0.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        Strength {
            tender_above_n: (severity > 0).then(|| by_severity(TENDER_N, severity)),
            ..Strength::default()
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        Ok(one_each(d))
    }
}
