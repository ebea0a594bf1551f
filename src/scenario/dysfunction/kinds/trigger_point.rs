//! A trigger point: a tender knot in a taut band of muscle.

use super::by_severity;
use crate::scenario::dysfunction::patch::{amid, share_of};
use crate::scenario::dysfunction::place::places;
use crate::scenario::dysfunction::{Change, Dysfunction, Extent, Fault, Kind, Patch, Strength};

pub(super) struct TriggerPoint;

/// Change of stiffness of the knot by severity, percent; assumed.
const STIFFNESS_PERCENT: [f64; 4] = [0.0, 40.0, 80.0, 150.0];
/// Height of the knot under the skin by severity, mm; assumed.
const BUMP_MM: [f64; 4] = [0.0, 0.0, 0.3, 0.6];
/// Force from which on it hurts, N; assumed, in the range of fingers that palpate (METHOD, section 7).
const TENDER_N: [f64; 4] = [f64::INFINITY, 4.0, 3.0, 2.0];
/// The band: half its length and width as multiples of the knot's, and its share of the knot's change. Assumed: some 8 cm
/// long, as wide as the knot.
const BAND: [f64; 2] = [4.0, 0.9];
const BAND_SHARE: f64 = 0.4;

impl Kind for TriggerPoint {
    fn key(&self) -> &'static str {
        "trigger_point"
    }

    fn title(&self) -> &'static str {
        "Trigger point in a taut band"
    }

    fn about(&self) -> &'static str {
        "A hard, tender knot and a less hard band through it along the muscle. The ellipse is the knot; the band runs along \
         its first axis, four times as long."
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [10.0, 8.0],
            angle_deg: 80.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        if severity == 0 {
            return Strength::default();
        }
        Strength {
            change: Some(Change::StiffnessPercent(by_severity(
                STIFFNESS_PERCENT,
                severity,
            ))),
            bump_mm: Some(by_severity(BUMP_MM, severity)),
            tender_above_n: Some(by_severity(TENDER_N, severity)),
            ..Strength::default()
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        let mut out = Vec::new();
        for place in places(d) {
            let knot = place.patch(d);
            let [a, b] = place.half_axes_mm;
            let axes = [a * BAND[0], b * BAND[1]];
            let band = Patch {
                stiffness_factor: share_of(knot.stiffness_factor, BAND_SHARE),
                ..Patch::plain(place.spot_of(d, place.at_mm, axes, place.angle_rad))
            };
            out.extend([amid(knot, [&band]), band]);
        }
        Ok(out)
    }
}
