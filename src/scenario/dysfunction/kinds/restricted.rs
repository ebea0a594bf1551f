//! A segment that does not move.

use super::by_severity;
use crate::geom::Vec2;
use crate::scenario::dysfunction::patch::{amid, share_of};
use crate::scenario::dysfunction::place::places;
use crate::scenario::dysfunction::{Change, Dysfunction, Extent, Fault, Kind, Patch, Strength};

pub(super) struct Restricted;

/// Change of stiffness by severity, percent; assumed.
const STIFFNESS_PERCENT: [f64; 4] = [0.0, 20.0, 45.0, 80.0];
/// What the whole segment has of it, from one transverse process to the other; assumed.
const SEGMENT_SHARE: f64 = 0.5;

impl Kind for Restricted {
    fn key(&self) -> &'static str {
        "restricted"
    }

    fn title(&self) -> &'static str {
        "Restricted segment"
    }

    fn about(&self) -> &'static str {
        "A vertebra that does not give way when it is sprung: most at the place stated, half as much across the whole segment."
    }

    fn extent(&self) -> Extent {
        Extent {
            radius_mm: [16.0, 12.0],
            angle_deg: 90.0,
            profile: "cosine",
        }
    }

    fn strength(&self, _: Option<&str>, severity: u8) -> Strength {
        Strength {
            change: (severity > 0)
                .then(|| Change::StiffnessPercent(by_severity(STIFFNESS_PERCENT, severity))),
            ..Strength::default()
        }
    }

    fn patches(&self, d: &Dysfunction) -> Result<Vec<Patch>, Fault> {
        let mut segments: Vec<Patch> = Vec::new();
        let mut stated = Vec::new();
        let mut levels = Vec::new();
        for place in places(d) {
            let main = place.patch(d);
            let level = place.site.map(|site| site.level);
            if level.is_none() || !levels.contains(&level) {
                levels.push(level);
                let [a, b] = place.half_axes_mm;
                let across = [place.at_mm.x.abs() + a, b];
                let middle = Vec2::new(0.0, place.at_mm.y);
                segments.push(Patch {
                    stiffness_factor: share_of(main.stiffness_factor, SEGMENT_SHARE),
                    ..Patch::plain(place.spot_of(d, middle, across, 0.0))
                });
            }
            stated.push(main);
        }
        let stated = stated.into_iter().map(|main| amid(main, &segments));
        let stated: Vec<Patch> = stated.collect();
        segments.extend(stated);
        Ok(segments)
    }
}
