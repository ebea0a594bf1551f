//! What is taken out of a [`View`] while something is hidden from its reader: all that tells stiffness by a number or a line.
//! What the hidden place does to the finger is for the finger to feel.

use crate::app::history::History;
use crate::app::state::View;
use crate::geom::Vec3;
use crate::servo::FingerRecord;
use std::sync::{Arc, Mutex};

/// Blinds `view`; `no_history` stands for the plotted past. The scene in it must be the blind one already.
pub fn blind(view: &mut View, no_history: &Arc<Mutex<History>>) {
    view.blind = true;
    view.history.clone_from(no_history);
    view.ghosts = Vec::new();
    for record in &mut view.fingers {
        without_force(record);
    }
    for record in &mut view.live.record.fingers {
        without_force(record);
    }
}

/// The record without what it says of force and stiffness. Place, depth and touch stay: they show the finger where it is.
fn without_force(record: &mut FingerRecord) {
    record.contact.stiffness_n_per_mm = 0.0;
    record.contact.force_n = Vec3::ZERO;
    record.contact.credit_mj = 0.0;
    record.contact.felt_depth_mm = record.contact.depth_mm;
    record.sent_force_n = Vec3::ZERO;
    record.limits = Default::default();
    record.passivity_energy_n_mm = 0.0;
    record.duration_us = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Contact, Touch};

    #[test]
    fn two_records_that_differ_by_stiffness_alone_look_the_same_when_blinded() {
        let felt = |stiffness_n_per_mm: f64| FingerRecord {
            contact: Contact {
                touch: Touch::Stick,
                depth_mm: 3.0,
                felt_depth_mm: 2.9,
                stiffness_n_per_mm,
                force_n: Vec3::new(0.0, 0.0, 3.0 * stiffness_n_per_mm),
                ..Contact::default()
            },
            sent_force_n: Vec3::new(0.0, 0.0, 3.0 * stiffness_n_per_mm),
            ..FingerRecord::default()
        };
        let none = Arc::default();
        let seen = |stiffness| {
            let mut view = View {
                fingers: vec![felt(stiffness); 2],
                ..View::default()
            };
            view.live.record.fingers[0] = felt(stiffness);
            view.history.lock().expect("free").push(&felt(stiffness));
            blind(&mut view, &none);
            (view.fingers, view.live, Arc::ptr_eq(&view.history, &none))
        };
        assert_eq!(seen(0.4), seen(0.9));
        let (fingers, _, empty) = seen(0.4);
        assert!(empty);
        assert_eq!(fingers[0].contact.depth_mm, 3.0);
        assert_eq!(fingers[0].contact.touch, Touch::Stick);
    }
}
