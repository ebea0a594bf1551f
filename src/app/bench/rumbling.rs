//! What the fingers feel, told to a gamepad that can rumble.

use super::Bench;
use crate::contact::Touch;
use crate::device::rumble::Indicator;

impl Bench {
    /// Tells the finger that is pushed with the greatest share of its rated force.
    pub(super) fn rumble(&mut self) {
        let (mut force_n, mut rated_n, mut slips) = (0.0, 1.0, false);
        if let Some(live) = &self.live {
            let fingers = live.snapshot().record;
            for (finger, (_, limits)) in fingers.fingers().iter().zip(live.devices()) {
                let felt_n = finger.sent_force_n.length();
                if felt_n * rated_n > force_n * limits.rated_force_n {
                    (force_n, rated_n) = (felt_n, limits.rated_force_n);
                    slips = finger.contact.touch == Touch::Slip;
                }
            }
        }
        if self.indicator.is_none() && force_n > 0.0 {
            self.indicator = Indicator::start();
        }
        if let Some(indicator) = &mut self.indicator {
            indicator.feel(force_n, rated_n, slips);
        }
    }
}
