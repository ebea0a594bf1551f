//! Pops: a finger that was pressed in loses the skin without having come out, told by the records themselves.

use crate::contact::Contact;
use crate::geom::Vec3;
use crate::servo::{FingerRecord, MAX_FINGERS};

/// A press less deep than this cannot pop, mm: there the skin's own facets decide where a finger comes out.
const LEAST_DEPTH_MM: f64 = 1.0;
/// A pop is when this share of the depth was still to come out.
const SHARE: f64 = 0.5;

/// Watches records for pops. A god object has none by construction; what pops is a finger that slides off the open border
/// of a mesh, a pad on an edge thinner than itself, or a model that is compared with ours.
#[derive(Debug, Default)]
pub(super) struct Pops {
    before: [Option<Pressed>; MAX_FINGERS],
}

/// A press, as the tick before left it.
#[derive(Clone, Copy, Debug)]
struct Pressed {
    tick: u64,
    edit: u32,
    anchor_mm: Vec3,
    normal: Vec3,
    depth_mm: f64,
    force_n: f64,
}

impl Pressed {
    fn of(record: &FingerRecord) -> Option<Self> {
        let contact: &Contact = &record.contact;
        (contact.depth_mm >= LEAST_DEPTH_MM).then(|| Self {
            tick: record.tick,
            edit: record.edit,
            anchor_mm: contact.anchor_mm,
            normal: contact.normal,
            depth_mm: contact.depth_mm,
            force_n: contact.force_n.length(),
        })
    }
}

impl Pops {
    /// Looks at a record that was written; answers what is to be written about it.
    ///
    /// A pop is told where the next tick of the same finger, in the same scene and with the same device, feels nothing
    /// while the HIP is still below the tangent plane that held it, by more than half of its depth.
    pub(super) fn seen(&mut self, record: &FingerRecord) -> Option<String> {
        let before = self.before.get_mut(usize::from(record.finger))?;
        let was = std::mem::replace(before, Pressed::of(record))?;
        let follows = record.tick == was.tick + 1 && record.edit == was.edit;
        let felt_on = record.reading.is_usable() && !record.placed_anew;
        if !follows || !felt_on || record.contact.depth_mm > 0.0 {
            return None;
        }
        let below_mm = (was.anchor_mm - record.reading.position_mm).dot(was.normal);
        (below_mm > SHARE * was.depth_mm).then(|| {
            format!(
                "finger {} lost the skin {below_mm:.1} mm deep; {:.2} N fell to none in a tick",
                record.finger, was.force_n
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::Reading;

    fn told(records: &[FingerRecord]) -> Vec<(u64, String)> {
        let mut pops = Pops::default();
        let seen = |r: &FingerRecord| pops.seen(r).map(|text| (r.tick, text));
        records.iter().filter_map(seen).collect()
    }

    /// A finger `depth_mm` below a plane at height 0, held by it or not.
    fn at(tick: u64, depth_mm: f64, held: bool) -> FingerRecord {
        let hip_mm = Vec3::new(0.0, 0.0, -depth_mm);
        let mut record = FingerRecord {
            tick,
            reading: Reading {
                position_mm: hip_mm,
                connected: true,
                ..Reading::default()
            },
            ..FingerRecord::default()
        };
        record.contact.anchor_mm = hip_mm;
        if held && depth_mm > 0.0 {
            record.contact = Contact {
                anchor_mm: Vec3::ZERO,
                foot_mm: Vec3::ZERO,
                normal: Vec3::Z,
                depth_mm,
                force_n: Vec3::Z * (0.5 * depth_mm),
                ..Contact::default()
            };
        }
        record
    }

    #[test]
    fn a_press_that_ends_deep_is_a_pop_and_one_that_comes_out_is_none() {
        let down = |t: u64| 0.01 * t as f64;
        let popped: Vec<_> = (0..600).map(|t| at(t, down(t), t < 500)).collect();
        let said = told(&popped);
        assert_eq!(said.len(), 1, "{said:?}");
        assert_eq!(said[0].0, 500);
        assert_eq!(
            said[0].1,
            "finger 0 lost the skin 5.0 mm deep; 2.50 N fell to none in a tick"
        );
        let out: Vec<_> = (0..1200).map(|t| at(t, 5.0 - down(t), true)).collect();
        assert!(told(&out).is_empty());
        // Out at three metres a second: from 3 mm below to the surface within a tick.
        assert!(told(&[at(0, 3.0, true), at(1, 0.0, true)]).is_empty());
        // Less deep than a millimetre.
        assert!(told(&[at(0, 0.9, true), at(1, 0.9, false)]).is_empty());
    }

    #[test]
    fn what_takes_the_skin_away_on_purpose_is_no_pop() {
        let pressed = at(7, 5.0, true);
        assert_eq!(told(&[pressed, at(8, 5.0, false)]).len(), 1);
        let changed = |change: &dyn Fn(&mut FingerRecord)| {
            let mut next = at(8, 5.0, false);
            change(&mut next);
            told(&[pressed, next])
        };
        assert!(changed(&|r| r.reading.connected = false).is_empty());
        assert!(changed(&|r| r.placed_anew = true).is_empty());
        assert!(changed(&|r| r.edit = 1).is_empty());
        assert!(changed(&|r| r.tick = 9).is_empty(), "a gap");
        assert!(changed(&|r| r.finger = 1).is_empty(), "another finger");
        assert!(changed(&|r| r.finger = 200).is_empty());
    }
}
