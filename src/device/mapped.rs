//! A device laid over the subject: turned, scaled, shifted, and let go by a clutch.

use super::calibration::Mapping;
use super::hid::vitals::Vitals;
use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;
use glam::DMat3;
use std::sync::Arc;

/// A device whose motion is that of a finger on the subject.
///
/// p_subject = R s p_device + anchor, with R from [`Mapping::subject_from_device`] and s the scale. Force goes back turned
/// only, not scaled: a newton on the skin is a newton at the hand, whatever the scale of the motion. So a stiffness of k on
/// the skin is one of s k at the device, which the capabilities tell.
#[derive(Debug)]
pub struct Mapped<D> {
    device: D,
    capabilities: Capabilities,
    subject_from_device: DMat3,
    scale: f64,
    anchor_mm: Vec3,
    clutch: u32,
    /// Where the finger stands while the clutch is held, mm.
    held_mm: Option<Vec3>,
}

/// What a device can do, said of the finger on the subject: lengths times the scale, stiffness over it.
pub fn on_subject(device: &Capabilities, mapping: &Mapping) -> Capabilities {
    let scale = scale(mapping);
    Capabilities {
        max_stiffness_n_per_mm: device.max_stiffness_n_per_mm / scale,
        workspace_radius_mm: device.workspace_radius_mm * scale,
        resolution_mm: device.resolution_mm * scale,
        ..device.clone()
    }
}

/// Motion of the finger for motion of the device: 1 where it is no positive number.
pub(super) fn scale(mapping: &Mapping) -> f64 {
    if mapping.scale.is_finite() && mapping.scale > 0.0 {
        mapping.scale
    } else {
        1.0
    }
}

impl<D: Device> Mapped<D> {
    /// `device` laid over the subject as `mapping` says. A scale that is no positive number counts as 1.
    pub fn new(device: D, mapping: Mapping) -> Self {
        let scale = scale(&mapping);
        let capabilities = on_subject(device.capabilities(), &mapping);
        let button = mapping.clutch_button.and_then(|n| n.checked_sub(1));
        Self {
            device,
            capabilities,
            subject_from_device: mapping.subject_from_device(),
            scale,
            anchor_mm: if mapping.offset_mm.is_finite() {
                mapping.offset_mm
            } else {
                Vec3::ZERO
            },
            clutch: button.map_or(0, |n| 1_u32.checked_shl(n.into()).unwrap_or(0)),
            held_mm: None,
        }
    }
}

impl<D: Device> Device for Mapped<D> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        let theirs = self.device.read(dt_s);
        let moved_mm = self.subject_from_device * theirs.position_mm * self.scale;
        let mut reading = Reading {
            position_mm: moved_mm + self.anchor_mm,
            velocity_mm_s: self.subject_from_device * theirs.velocity_mm_s * self.scale,
            ..theirs
        };
        if theirs.buttons & self.clutch != 0 {
            let held_mm = *self.held_mm.get_or_insert(reading.position_mm);
            if theirs.is_usable() {
                self.anchor_mm = held_mm - moved_mm;
            }
            reading.position_mm = held_mm;
            reading.velocity_mm_s = Vec3::ZERO;
        } else {
            self.held_mm = None;
        }
        reading
    }

    fn write(&mut self, force_n: Vec3) {
        // A clutched device moves freely: the finger stays, and its force would push the hand about.
        let force_n = if self.held_mm.is_some() {
            Vec3::ZERO
        } else {
            self.subject_from_device.transpose() * force_n
        };
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
    use crate::device::calibration::Orientation;
    use proptest::prelude::*;

    /// A device that is where it is put and remembers the force.
    struct Put {
        capabilities: Capabilities,
        reading: Reading,
        force_n: Vec3,
    }

    impl Device for Put {
        fn capabilities(&self) -> &Capabilities {
            &self.capabilities
        }
        fn read(&mut self, _dt_s: f64) -> Reading {
            self.reading
        }
        fn write(&mut self, force_n: Vec3) {
            self.force_n = force_n;
        }
    }

    fn mapped(mapping: Mapping) -> Mapped<Put> {
        let capabilities = Capabilities {
            max_stiffness_n_per_mm: 1.0,
            workspace_radius_mm: 100.0,
            resolution_mm: 0.05,
            ..Capabilities::ideal("Put", 5.0)
        };
        let reading = Reading {
            connected: true,
            ..Reading::default()
        };
        let put = Put {
            capabilities,
            reading,
            force_n: Vec3::ZERO,
        };
        Mapped::new(put, mapping)
    }

    fn mapping() -> impl Strategy<Value = Mapping> {
        (
            0.1..5.0_f64,
            prop::array::uniform3(-180.0..180.0_f64),
            prop::array::uniform3(-300.0..300.0_f64),
            any::<bool>(),
        )
            .prop_map(|(scale, turn_deg, offset, upright)| Mapping {
                scale,
                turn_deg,
                offset_mm: Vec3::from(offset),
                orientation: if upright {
                    Orientation::Upright
                } else {
                    Orientation::Lying
                },
                clutch_button: Some(1),
                finger: 0,
            })
    }

    #[test]
    fn capabilities_are_those_on_the_subject() {
        let wide = mapped(Mapping {
            scale: 2.0,
            ..Mapping::default()
        });
        let c = wide.capabilities();
        assert_eq!(c.workspace_radius_mm, 200.0);
        assert_eq!(c.max_stiffness_n_per_mm, 0.5);
        assert_eq!(c.resolution_mm, 0.1);
        assert_eq!(c.rated_force_n, 5.0);
    }

    #[test]
    fn no_mapping_makes_a_place_that_is_none() {
        let mut m = mapped(Mapping {
            scale: f64::NAN,
            offset_mm: Vec3::NAN,
            turn_deg: [f64::INFINITY; 3],
            clutch_button: Some(255),
            finger: 9,
            ..Mapping::default()
        });
        assert!(m.read(0.001).is_usable());
    }

    proptest! {
        #[test]
        fn power_at_the_hand_is_power_on_the_skin_over_the_scale(
            mapping in mapping(), v in prop::array::uniform3(-100.0..100.0_f64), f in prop::array::uniform3(-5.0..5.0_f64),
        ) {
            let mut m = mapped(mapping);
            m.device.reading.velocity_mm_s = Vec3::from(v);
            let on_skin = m.read(0.001).velocity_mm_s.dot(Vec3::from(f));
            m.write(Vec3::from(f));
            let at_hand = m.device.force_n.dot(Vec3::from(v));
            prop_assert!((on_skin - at_hand * mapping.scale).abs() < 1e-6);
            prop_assert!((m.device.force_n.length() - Vec3::from(f).length()).abs() < 1e-9);
        }

        #[test]
        fn a_held_clutch_keeps_the_finger_and_letting_go_does_not_jump(
            mapping in mapping(), from in prop::array::uniform3(-100.0..100.0_f64), to in prop::array::uniform3(-100.0..100.0_f64),
        ) {
            let mut m = mapped(mapping);
            m.device.reading.position_mm = Vec3::from(from);
            let start = m.read(0.001).position_mm;
            m.device.reading.buttons = 1;
            prop_assert_eq!(m.read(0.001).position_mm, start);
            m.write(Vec3::Z);
            prop_assert_eq!(m.device.force_n, Vec3::ZERO);
            m.device.reading.position_mm = Vec3::from(to);
            prop_assert_eq!(m.read(0.001).position_mm, start);
            m.device.reading.buttons = 0;
            let after = m.read(0.001).position_mm;
            prop_assert!((after - start).length() < 1e-9);
            // And from there it moves as before.
            m.device.reading.position_mm += Vec3::X;
            let step = m.read(0.001).position_mm - after;
            prop_assert!((step - m.subject_from_device * Vec3::X * mapping.scale).length() < 1e-9);
        }
    }
}
