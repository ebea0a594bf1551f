//! The link's part of the safety chain, with every family's own bounds: each fault by itself takes all current off in time.

use super::guard::{Condition, Guard, Sighting};
use super::output::{Asked, Output};
use crate::device::{Calibration, all};
use crate::geom::Vec3;
use crate::units::MS_PER_S;

/// Longest from a fault to no current, ms: the bound, and a report.
const BOUND_MS: u32 = 11;
/// When the fault comes, ms.
const FAULT_MS: u32 = 50;

/// What the device and the servo do in one millisecond.
#[derive(Clone, Copy)]
struct Moment {
    position_mm: Vec3,
    velocity_mm_s: Vec3,
    counter: Option<u16>,
    raw: i32,
    reports: bool,
    on: bool,
    order_age_ms: f64,
    force_n: Vec3,
}

/// A fault from [`FAULT_MS`] on: given its age, ms, what goes wrong in that moment.
type Fault = fn(&mut Moment, u32);

const FAULTS: [(&str, Fault); 12] = [
    ("switched off", |m, _| m.on = false),
    ("the servo hangs", |m, age| m.order_age_ms = f64::from(age)),
    ("a force that is none", |m, _| m.force_n = Vec3::NAN),
    ("an endless force", |m, _| {
        m.force_n = Vec3::X * f64::INFINITY
    }),
    ("silent", |m, _| m.reports = false),
    ("frozen", |m, _| {
        (m.counter, m.raw) = (Some(FAULT_MS as u16), 0)
    }),
    ("jumped", |m, _| m.position_mm.x += 100.0),
    ("a place that is none", |m, _| m.position_mm.y = f64::NAN),
    ("far off", |m, _| m.position_mm.z = 1.0e4),
    ("endlessly far off", |m, _| m.position_mm.z = f64::INFINITY),
    ("too fast", |m, _| m.velocity_mm_s = Vec3::Y * 4000.0),
    ("a speed that is none", |m, _| m.velocity_mm_s = Vec3::NAN),
];

fn moment(ms: u32, force_n: Vec3) -> Moment {
    Moment {
        position_mm: Vec3::Z * -2.0,
        velocity_mm_s: Vec3::ZERO,
        counter: Some(ms as u16),
        raw: ms as i32,
        reports: true,
        on: true,
        order_age_ms: 1.0,
        force_n,
    }
}

/// Runs a link's guard and output with `fault`; when the last current flowed, ms after the fault, and how it ended.
fn last_current_ms(c: &Calibration, fault: Option<Fault>) -> (Option<u32>, Condition) {
    let mut guard = Guard::new(c.guards, c.rated_force_n, true);
    let timeout_s = c.guards.command_timeout_ms / MS_PER_S;
    let mut output = Output::new(c.rated_force_n, timeout_s, 1.0e-3);
    let (mut last, mut sent_n) = (None, Vec3::ZERO);
    for ms in 0..FAULT_MS + 100 {
        // More than is rated is asked for all the time.
        let mut m = moment(ms, Vec3::Z * 2.0 * c.rated_force_n);
        if let Some(fault) = fault.filter(|_| ms >= FAULT_MS) {
            fault(&mut m, ms - FAULT_MS);
        }
        let now_s = f64::from(ms) / MS_PER_S;
        if m.reports {
            guard.hear(Sighting {
                time_s: now_s,
                position_mm: m.position_mm,
                velocity_mm_s: m.velocity_mm_s,
                raw: [m.raw, 0, 0, 0, 0, 0],
                counter: m.counter,
                force_n: sent_n,
            });
        }
        guard.look(now_s);
        let asked = Asked {
            on: m.on,
            age_s: m.order_age_ms / MS_PER_S,
            force_n: m.force_n,
        };
        let sent = output.at(now_s, &asked, guard.may_push(), m.velocity_mm_s);
        sent_n = sent.map_or(Vec3::ZERO, |s| s.force_n);
        let rated = c.rated_force_n * (1.0 + 1e-12);
        assert!(sent_n.is_finite() && sent_n.length() <= rated);
        if sent.is_some() && ms >= FAULT_MS {
            last = Some(ms - FAULT_MS);
        }
    }
    (last, guard.condition())
}

#[test]
fn with_every_familys_bounds_each_fault_by_itself_takes_the_current_off_in_time() {
    for family in all() {
        let c = family.defaults();
        if c.rated_force_n == 0.0 {
            continue;
        }
        let (last, condition) = last_current_ms(&c, None);
        assert_eq!(
            (last, condition),
            (Some(99), Condition::Good),
            "{}",
            family.key()
        );
        for (what, fault) in FAULTS {
            let (last, condition) = last_current_ms(&c, Some(fault));
            let in_time = last.is_none_or(|ms| ms <= BOUND_MS);
            assert!(
                in_time,
                "{}: {what}: {last:?} ms, {condition:?}",
                family.key()
            );
        }
    }
}
