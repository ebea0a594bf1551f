//! The sites of the built-in back that a dysfunction can be put at with one click.

use crate::geom::Vec2;
use crate::scenario::{Side, Site, Target, VertebralLevel};
use std::sync::OnceLock;

/// Every site with its place, from the neck down: spinous processes in the middle, all else on both sides.
pub fn targets() -> &'static [(Site, Vec2)] {
    static TARGETS: OnceLock<Vec<(Site, Vec2)>> = OnceLock::new();
    TARGETS.get_or_init(|| {
        let mut out = Vec::new();
        for level in VertebralLevel::all() {
            for &target in Target::all() {
                let sides: &[Side] = match target {
                    Target::Spinous => &[Side::Middle],
                    Target::RibAngle if level.rib().is_none() => &[],
                    _ => &[Side::Left, Side::Right],
                };
                for &side in sides {
                    let site = Site {
                        level,
                        side,
                        target,
                    };
                    out.push((site, site.at_mm()));
                }
            }
        }
        out
    })
}

/// The site nearest to a place, at most `within_mm` away.
pub fn nearest(at: Vec2, within_mm: f64) -> Option<Site> {
    let far = |p: &Vec2| p.distance(at);
    targets()
        .iter()
        .filter(|(_, p)| far(p) <= within_mm)
        .min_by(|(_, a), (_, b)| far(a).total_cmp(&far(b)))
        .map(|(site, _)| *site)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_site_is_nearest_to_itself_and_far_away_there_is_none() {
        assert_eq!(targets().len(), 18 * 5 + 12 * 2);
        for (site, at) in targets() {
            assert_eq!(nearest(*at, 1.0), Some(*site));
        }
        assert_eq!(nearest(Vec2::new(900.0, 0.0), 9.0), None);
        assert_eq!(nearest(Vec2::NAN, f64::INFINITY), None);
    }
}
