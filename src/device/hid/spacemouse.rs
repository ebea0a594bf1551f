//! SpaceMouse: the deflection of its cap is a speed.

use super::attached;
use super::link::{Driver, Linked, Seen};
use super::report::spacemouse::{FULL, IDS, In, State, lamp};
use super::transport::{HidPort, Port, REPORT};
use super::vitals::Vitals;
use crate::device::calibration::RateControl;
use crate::device::mapped::Mapped;
use crate::device::{
    Calibration, Capabilities, Device, DeviceError, Family, Found, Proof, Reading,
};
use crate::geom::Vec3;
use std::sync::Arc;

/// The wire's side: deflections in, the lamp out.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cap {
    state: State,
}

impl Driver for Cap {
    fn take(&mut self, report: &[u8]) -> bool {
        let Some(report) = In::decode(report) else {
            return false;
        };
        self.state.take(report);
        true
    }

    fn seen(&self) -> Seen {
        let State {
            shift: [x, y, z],
            turn: [rx, ry, rz],
            buttons,
            ..
        } = self.state;
        // The device has y towards the user and z down; here x is towards the user, y to the right, z up.
        let part = |n: i16| f64::from(n) / f64::from(FULL);
        Seen {
            position_mm: Vec3::new(part(y), part(x), -part(z)),
            buttons,
            raw: [x, y, z, rx, ry, rz].map(i32::from),
            counter: None,
        }
    }

    fn render(&mut self, _force_n: Option<Vec3>, _out: &mut [u8; REPORT]) -> (usize, [i32; 3]) {
        (0, [0; 3])
    }

    fn greet(&mut self, opening: bool, out: &mut [u8; REPORT]) -> usize {
        out[..2].copy_from_slice(&lamp(opening));
        2
    }

    /// It is silent while nobody touches it.
    fn is_periodic(&self) -> bool {
        false
    }
}

/// Velocity for a deflection, −1 to 1 on each axis, mm/s: nothing within the dead zone, from there a power of the rest.
pub fn velocity_mm_s(rate: &RateControl, deflection: Vec3) -> Vec3 {
    let length = deflection.length();
    if !length.is_finite() || length <= rate.dead_zone || length == 0.0 {
        return Vec3::ZERO;
    }
    let past = ((length - rate.dead_zone) / (1.0 - rate.dead_zone)).clamp(0.0, 1.0);
    deflection / length * (libm::pow(past, rate.exponent) * rate.speed_mm_s)
}

/// The servo's side: a place that goes where the cap is pushed.
#[derive(Debug)]
pub struct SpaceMouse {
    link: Linked,
    rate: RateControl,
    position_mm: Vec3,
}

impl SpaceMouse {
    /// A SpaceMouse at `port`, in the middle of its reach.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(port: Box<dyn Port>, calibration: &Calibration) -> Result<Self, DeviceError> {
        let capabilities = FAMILY.capabilities(calibration);
        let rate = calibration.rate.unwrap_or_default();
        Ok(Self {
            link: Linked::start(capabilities, port, Box::new(Cap::default()), calibration)?,
            rate,
            position_mm: Vec3::ZERO,
        })
    }
}

impl Device for SpaceMouse {
    fn capabilities(&self) -> &Capabilities {
        self.link.capabilities()
    }

    fn read(&mut self, dt_s: f64) -> Reading {
        let heard = self.link.read(dt_s);
        let wanted = velocity_mm_s(&self.rate, heard.position_mm);
        let before = self.position_mm;
        if dt_s > 0.0 && dt_s.is_finite() && heard.connected {
            let next = before + wanted * dt_s;
            self.position_mm = next.clamp_length_max(self.rate.reach_mm);
        }
        let moved = self.position_mm - before;
        Reading {
            position_mm: self.position_mm,
            velocity_mm_s: if dt_s > 0.0 && moved != Vec3::ZERO {
                moved / dt_s
            } else {
                Vec3::ZERO
            },
            ..heard
        }
    }

    fn write(&mut self, _force_n: Vec3) {}

    fn close(&mut self) {
        self.link.close();
    }

    fn vitals(&self) -> Option<Arc<Vitals>> {
        Some(self.link.vitals())
    }
}

/// The family.
#[derive(Debug)]
pub struct SpaceMice;

/// The family.
pub static FAMILY: SpaceMice = SpaceMice;

impl Family for SpaceMice {
    fn key(&self) -> &'static str {
        "spacemouse"
    }

    fn title(&self) -> &'static str {
        "SpaceMouse"
    }

    fn about(&self) -> &'static str {
        "Cap on springs: pushed it moves the finger, and lets no force be felt"
    }

    fn reached(&self) -> &'static str {
        "HID 046D and 256F, no driver"
    }

    fn proof(&self) -> Proof {
        Proof::Emulator
    }

    fn defaults(&self) -> Calibration {
        let mut out = Calibration::plain(self.key(), 0.0, f64::INFINITY);
        out.rate = Some(RateControl::default());
        out
    }

    fn capabilities(&self, calibration: &Calibration) -> Capabilities {
        let name = calibration.name.as_deref().unwrap_or(self.title());
        let rate = calibration.rate.unwrap_or_default();
        Capabilities {
            workspace_radius_mm: rate.reach_mm,
            n_buttons: 2,
            ..Capabilities::ideal(name, 0.0)
        }
    }

    fn ready(&self) -> Result<(), DeviceError> {
        attached::ready()
    }

    fn find(&self) -> Vec<Found> {
        let mut out: Vec<Found> = attached::list(&IDS)
            .into_iter()
            .map(|a| a.found(self.key(), self.title(), None))
            .collect();
        Found::tell_apart(&mut out);
        out
    }

    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let port = HidPort::open(&found.place)?;
        let device = SpaceMouse::start(Box::new(port), calibration)?;
        Ok(Box::new(Mapped::new(device, calibration.mapping)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_dead_zone_is_rest_and_full_deflection_full_speed() {
        let rate = RateControl::default();
        assert_eq!(velocity_mm_s(&rate, Vec3::X * 0.06), Vec3::ZERO);
        assert_eq!(velocity_mm_s(&rate, Vec3::ZERO), Vec3::ZERO);
        let full = velocity_mm_s(&rate, Vec3::NEG_Y);
        assert!((full - Vec3::NEG_Y * 120.0).length() < 1e-9);
        // It begins at rest: no step at the edge of the dead zone.
        assert!(velocity_mm_s(&rate, Vec3::X * 0.0601).length() < 1e-3);
    }

    #[test]
    fn axes_are_those_of_the_house() {
        let mut cap = Cap::default();
        let mut bytes = [0; 13];
        let n = In::Shift([350, 0, -175]).encode(&mut bytes);
        assert!(cap.take(&bytes[..n]));
        // Right stays right, the device's down is turned to up.
        assert_eq!(cap.seen().position_mm, Vec3::new(0.0, 1.0, 0.5));
        assert!(!cap.take(&[99, 0, 0]));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_pushed_cap_moves_the_finger_and_the_reach_holds_it() {
        use crate::device::hid::transport::SocketPort;
        let (host, mut cap) = SocketPort::pair().expect("pair");
        let calibration = FAMILY.defaults();
        let mut device = SpaceMouse::start(Box::new(host), &calibration).expect("started");
        let mut into = [0; REPORT];
        assert_eq!(cap.read(&mut into, 2000), Ok(2));
        assert_eq!(into[..2], lamp(true));
        assert!(!device.read(0.001).connected, "nothing was heard yet");
        for report in [In::Both([350, 0, 0], [0; 3]), In::Buttons(2)] {
            let mut bytes = [0; 13];
            let n = report.encode(&mut bytes);
            cap.write(&bytes[..n]).expect("sent");
        }
        let until = std::time::Instant::now() + std::time::Duration::from_secs(10);
        while device.read(0.0).buttons != 2 {
            assert!(std::time::Instant::now() < until, "never heard");
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        for _ in 0..1000 {
            device.read(0.001);
        }
        let there = device.read(0.0).position_mm;
        assert!((there - Vec3::Y * 120.0).length() < 1e-6, "{there}");
        for _ in 0..5000 {
            let reading = device.read(0.001);
            assert!(reading.position_mm.length() <= 250.0 + 1e-9 && reading.is_usable());
        }
        assert_eq!(
            device.read(0.001).velocity_mm_s,
            Vec3::ZERO,
            "at the end of its reach"
        );
        device.close();
        assert_eq!(cap.read(&mut into, 1000), Ok(2));
        assert_eq!(into[..2], lamp(false));
        assert!(!device.read(0.001).connected);
    }

    proptest! {
        #[test]
        fn no_deflection_makes_a_speed_beyond_the_highest(d in prop::array::uniform3(prop::num::f64::ANY)) {
            let v = velocity_mm_s(&RateControl::default(), Vec3::from(d));
            prop_assert!(v.is_finite() && v.length() <= 120.0 * (1.0 + 1e-12));
        }
    }
}
