//! A device seated somewhere on the subject, and seated elsewhere while it is in use.

use super::hid::vitals::Vitals;
use super::place::Place;
use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;
use std::sync::Arc;

/// A device whose motion is shifted by a place that the window sets.
///
/// A finger that is seated elsewhere has not moved there: for one tick the device is told not to answer, so that no force is
/// sent and the proxy is placed anew.
pub struct Seated {
    device: Box<dyn Device>,
    seat: Place,
    at_mm: Vec3,
}

impl Seated {
    /// `device`, shifted by `seat`, mm on the subject.
    pub fn new(device: Box<dyn Device>, seat: &Place) -> Self {
        Self {
            device,
            at_mm: seat.get(),
            seat: seat.clone(),
        }
    }
}

impl Device for Seated {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        let mut reading = self.device.read(dt_s);
        if let Some(at_mm) = self.seat.try_get().filter(|at| *at != self.at_mm) {
            self.at_mm = at_mm;
            reading.connected = false;
        }
        reading.position_mm += self.at_mm;
        reading
    }

    fn write(&mut self, force_n: Vec3) {
        self.device.write(force_n);
    }

    fn enable(&mut self, on: bool) {
        self.device.enable(on);
    }

    fn close(&mut self) {
        self.device.close();
    }

    fn vitals(&self) -> Option<Arc<Vitals>> {
        self.device.vitals()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::mouse::{Hand, Mouse};

    #[test]
    fn a_device_seated_elsewhere_is_away_for_one_tick_and_then_there() {
        let (mouse, _) = Mouse::new(Vec3::X, Hand::default());
        let seat = Place::at(Vec3::new(0.0, 100.0, 0.0));
        let mut seated = Seated::new(Box::new(mouse), &seat);
        let first = seated.read(0.001);
        assert!(first.connected);
        assert!((first.position_mm - Vec3::new(1.0, 100.0, 0.0)).length() < 1e-9);
        seat.set(Vec3::new(0.0, -50.0, 7.0));
        assert!(!seated.read(0.001).is_usable());
        let there = seated.read(0.001);
        assert!(there.connected);
        assert!((there.position_mm - Vec3::new(1.0, -50.0, 7.0)).length() < 1e-9);
        // What is no place is none.
        seat.set(Vec3::NAN);
        assert_eq!(seated.read(0.001), there);
    }
}
