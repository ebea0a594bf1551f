//! The passivity controller: the skin gives out no more energy than the finger has put in.
//!
//! A spring that is read T seconds apart and whose force is held in between takes up less on the way in than it gives out
//! on the way out: per tick ½ k Δx², as if it had a damping of −kT/2. Friction of hand and device must eat that; where they
//! do not, the finger is kicked about.
//!
//! **Observer** (Hannaford & Ryu 2002, one port, impedance causality). It counts the work of the force *really sent*, that
//! is after all limits, over the way the finger went under it. For a force held over the tick that sum is exact. From it
//! goes what is stored in the skin, so that it speaks as soon as energy appears, not when the finger leaves (the
//! reference energy of Ryu, Preusche, Hannaford & Hirzinger 2005). What is stored is counted at one stiffness before and
//! after: what a stiffness map gives or takes along the skin is the map's. Only the part of the force along the normal
//! takes part: what friction eats along the skin is not its business.
//!
//! **Controller.** While the balance is below 0 a damping force along the normal takes up what is missing within the next
//! tick, if the finger goes on as it did. At low speed a finger moves by an encoder step or not at all, and a force that
//! takes up a given energy over no way is noise (Ryu, Kwon & Hannaford 2004 saw the same). So it is bounded three ways: by
//! the damping kT/2 that sampling costs, by the force of the skin itself, so that it never pulls and at most doubles the
//! force, and afterwards by the limits of the device. What could not be taken up stays owed.
//!
//! What is owed outlives the contact, so that a bounce pays for the one before, and is forgotten off the skin within
//! [`FORGETTING_S`]. What was put in beyond what is stored is forgotten at once: it was eaten by friction or by the damping of
//! a force model, and saved up it would pay for kicks later. A delay between reading and force is not seen: the observer takes
//! the force to act at once.
//!
//! It is off unless [`Limits::passivity`](super::Limits::passivity) says so. Then nothing of it is computed.

use crate::contact::{Contact, ForceModel, Touch};
use crate::geom::Vec3;

/// The controller damps at most as this share of k T: half is what sampling and holding a spring costs (Colgate &
/// Schenkel 1997).
const MOST_DAMPING: f64 = 0.5;
/// Time in which a finger off the skin forgets what is owed to e⁻¹, s: longer than a bounce, shorter than a thought.
pub const FORGETTING_S: f64 = 0.25;

/// What one tick leaves behind for the next; part of the record, so that any record is a restart point. At rest where the
/// controller is off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observer {
    /// The tick before: none where the finger was placed anew or had no reading.
    pub before: Option<Before>,
    /// What the finger has put in less what it got back and what is stored, N·mm: 0, or below it where energy is owed.
    pub energy_n_mm: f64,
}

/// What the observer needs of the tick before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Before {
    /// The HIP, mm.
    pub hip_mm: Vec3,
    /// Outward unit normal; zero when free.
    pub normal: Vec3,
    /// Depth that the force answered to, mm.
    pub felt_depth_mm: f64,
    /// Stiffness there, N/mm.
    pub stiffness_n_per_mm: f64,
}

impl Observer {
    /// What a tick with this HIP, contact and balance leaves behind.
    pub fn after(hip_mm: Vec3, contact: &Contact, energy_n_mm: f64) -> Self {
        Self {
            before: Some(Before {
                hip_mm,
                normal: contact.normal,
                felt_depth_mm: contact.felt_depth_mm,
                stiffness_n_per_mm: contact.stiffness_n_per_mm,
            }),
            energy_n_mm,
        }
    }

    /// Counts what the force sent last did on the way to `hip_mm`, and returns the force to send now, N: that of the
    /// contact, damped where energy is owed, and whether it is.
    ///
    /// Finite for a finite contact. `sent_n` is the force sent in the tick before.
    pub(super) fn control(
        &mut self,
        model: &ForceModel,
        hip_mm: Vec3,
        contact: &Contact,
        sent_n: Vec3,
        dt_s: f64,
    ) -> (Vec3, bool) {
        let way_mm = self.before.map_or(Vec3::ZERO, |b| hip_mm - b.hip_mm);
        let balance = self.balance(model, way_mm, contact, sent_n, dt_s);
        *self = Self::after(hip_mm, contact, balance);
        let damping_n = damping(balance, way_mm.dot(contact.normal), contact);
        let force_n = contact.force_n + contact.normal * damping_n;
        if damping_n != 0.0 && force_n.is_finite() {
            (force_n, true)
        } else {
            (contact.force_n, false)
        }
    }

    fn balance(
        &self,
        model: &ForceModel,
        way_mm: Vec3,
        contact: &Contact,
        sent_n: Vec3,
        dt_s: f64,
    ) -> f64 {
        let Some(before) = self.before else {
            return 0.0;
        };
        let put_in = -sent_n.dot(before.normal) * way_mm.dot(before.normal);
        let touching = contact.touch != Touch::Free;
        let k = if touching {
            contact.stiffness_n_per_mm
        } else {
            before.stiffness_n_per_mm
        };
        let stored = |depth_mm: f64| model.energy_mj(k, depth_mm);
        let grown = stored(contact.felt_depth_mm) - stored(before.felt_depth_mm);
        let balance = (self.energy_n_mm + put_in - grown).min(0.0);
        let balance = if touching {
            balance
        } else {
            balance * libm::exp(-dt_s.max(0.0) / FORGETTING_S)
        };
        if balance.is_finite() { balance } else { 0.0 }
    }
}

/// The force along the normal that takes up what is owed while the finger goes `out_mm` outward in a tick, within its
/// bounds; 0 where nothing is owed.
fn damping(balance_n_mm: f64, out_mm: f64, contact: &Contact) -> f64 {
    if balance_n_mm >= 0.0 || out_mm == 0.0 || contact.felt_depth_mm <= 0.0 {
        return 0.0;
    }
    let skin_n = contact.force_n.dot(contact.normal).max(0.0);
    let k = skin_n / contact.felt_depth_mm;
    let most_n = (MOST_DAMPING * k * out_mm.abs()).min(skin_n);
    let wanted_n = balance_n_mm / out_mm;
    if most_n.is_finite() {
        wanted_n.clamp(-most_n, most_n)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINEAR: ForceModel = ForceModel::Linear;
    const DT_S: f64 = 1e-3;

    /// A frictionless contact with a skin of 2 N/mm at z = 0.
    fn contact(z_mm: f64) -> Contact {
        let depth_mm = (-z_mm).max(0.0);
        if depth_mm == 0.0 {
            return Contact::default();
        }
        Contact {
            touch: Touch::Frictionless,
            normal: Vec3::Z,
            depth_mm,
            felt_depth_mm: depth_mm,
            stiffness_n_per_mm: 2.0,
            force_n: Vec3::Z * (2.0 * depth_mm),
            ..Contact::default()
        }
    }

    /// Goes through these heights; each force is sent as it comes out where `heeded`, else undamped. Balances and forces.
    fn through(heights: &[f64], heeded: bool) -> Vec<(f64, f64)> {
        let (mut observer, mut sent) = (Observer::default(), Vec3::ZERO);
        let step = |z: &f64| {
            let contact = contact(*z);
            let at = Vec3::new(3.0, 4.0, *z);
            let (force, _) = observer.control(&LINEAR, at, &contact, sent, DT_S);
            sent = if heeded { force } else { contact.force_n };
            (observer.energy_n_mm, force.z)
        };
        heights.iter().map(step).collect()
    }

    #[test]
    fn sampling_a_spring_gives_out_half_k_times_the_square_of_every_step() {
        // Down and up by 0.5 mm a tick: ½ · 2 · 0.25 = 0.25 N·mm each.
        let heights = [0.0, -0.5, -1.0, -1.5, -1.0, -0.5];
        for (i, (energy, _)) in through(&heights, false).into_iter().enumerate() {
            assert!((energy + 0.25 * i as f64).abs() < 1e-12, "{i}: {energy}");
        }
    }

    #[test]
    fn the_balance_is_the_work_done_less_what_is_stored_and_never_a_credit() {
        let heights = [1.0, -0.3, -1.1, -0.9, -2.0, -0.4, 0.2];
        let found = through(&heights, true);
        let stored = |z: f64| if z < 0.0 { z * z } else { 0.0 };
        let mut balance = 0.0_f64;
        for i in 1..heights.len() {
            let work = -found[i - 1].1 * (heights[i] - heights[i - 1]);
            balance = (balance + work - stored(heights[i]) + stored(heights[i - 1])).min(0.0);
            if heights[i] >= 0.0 {
                balance *= libm::exp(-DT_S / FORGETTING_S);
            }
            assert!((found[i].0 - balance).abs() < 1e-12, "{i}");
        }
        assert!(balance < 0.0);
    }

    #[test]
    fn what_is_owed_is_damped_both_ways_within_the_bounds() {
        // kT/2 at 0.5 mm a tick: ½ · 2 · 0.5 = 0.5 N against the motion.
        let found = through(&[0.0, -0.5, -1.0, -1.5, -1.0, -0.5], true);
        let wanted = [0.0, 1.5, 2.5, 3.5, 1.5, 0.5];
        for ((energy, force), wanted) in found.into_iter().zip(wanted) {
            assert!((force - wanted).abs() < 1e-12, "{force} {wanted}");
            // A quarter is owed when it enters; turning back gives out what was damped last. No more from there on.
            assert!((-0.75 - 1e-12..=0.0).contains(&energy), "{energy}");
        }
        // Without motion there is nothing to damp; off the skin neither.
        assert_eq!(through(&[0.0, -0.5, -0.5], true)[2].1, 1.0);
        assert_eq!(through(&[0.0, -0.5, 0.5], true)[2].1, 0.0);
    }

    #[test]
    fn the_force_never_pulls_and_is_at_most_doubled() {
        let heights: Vec<f64> = (0..400)
            .map(|i| libm::sin(f64::from(i) * 1.7) * 3.0 - 0.5)
            .collect();
        for ((_, force), z) in through(&heights, true).into_iter().zip(&heights) {
            let skin = 2.0 * (-z).max(0.0);
            assert!(
                force >= 0.0 && force <= 2.0 * skin + 1e-12,
                "{force} {skin}"
            );
        }
    }

    #[test]
    fn debts_are_forgotten_off_the_skin_and_credit_at_once() {
        let mut heights = vec![0.0, -1.0, 1.0];
        heights.extend([1.0; 1000]);
        let found = through(&heights, false);
        // 2 N over 2 mm given, nothing put in.
        assert!((found[2].0 + 4.0 * libm::exp(-DT_S / FORGETTING_S)).abs() < 1e-12);
        assert!(found[1002].0 < 0.0 && found[1002].0 > -4.0 * 0.02);
        // Pressed in by a force that is there, and gone when the finger leaves: credit.
        let mut observer = Observer::after(Vec3::NEG_Z, &contact(-1.0), 0.0);
        observer.control(&LINEAR, Vec3::Z, &contact(1.0), Vec3::ZERO, DT_S);
        assert_eq!(observer.energy_n_mm, 0.0);
        let mut observer = Observer::after(Vec3::NEG_Z, &contact(-1.0), 0.0);
        observer.control(&LINEAR, Vec3::Z * -2.0, &contact(-2.0), Vec3::Z * 9.0, DT_S);
        assert_eq!(observer.energy_n_mm, 0.0);
    }

    #[test]
    fn friction_buys_nothing() {
        let mut observer = Observer::after(Vec3::NEG_Z, &contact(-1.0), 0.0);
        let sent = Vec3::new(-5.0, 0.0, 2.0);
        observer.control(
            &LINEAR,
            Vec3::new(10.0, 0.0, -1.0),
            &contact(-1.0),
            sent,
            DT_S,
        );
        assert_eq!(observer.energy_n_mm, 0.0);
    }

    #[test]
    fn numbers_at_the_edge_leave_the_force_finite() {
        let wild = [
            0.0,
            -f64::MIN_POSITIVE,
            1e300,
            -1e300,
            f64::MAX,
            -0.0,
            5e-324,
        ];
        let mut observer = Observer::default();
        for z in wild {
            for sent in wild {
                let (force, _) = observer.control(
                    &LINEAR,
                    Vec3::Z * z,
                    &contact((z).clamp(-1e6, 1e6)),
                    Vec3::Z * sent,
                    DT_S,
                );
                assert!(
                    force.is_finite() && observer.energy_n_mm.is_finite(),
                    "{z} {sent}"
                );
            }
        }
    }
}
