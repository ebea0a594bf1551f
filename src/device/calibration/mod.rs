//! What is known of one device: its geometry, its bounds, how it is laid over the subject. One file per device.

mod file;
mod mechanics;
mod store;
mod text;

use super::hid::arm::{Arm, Gravity};
use crate::geom::Vec3;
use crate::units::rad_from_deg;
use glam::DMat3;

pub use file::CalibrationError;
pub use mechanics::Mechanics;
pub use store::{file_name, load, save, usual_folder};

/// Version of the file format that this program reads.
pub const FORMAT: i64 = 1;

/// A device file, read and checked; or what stands in where there is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Which family it is for.
    pub family: String,
    /// Serial number of the one device that it is for; `None`: for any of the family.
    pub serial: Option<String>,
    /// Name shown to people; `None`: that of the family.
    pub name: Option<String>,
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Highest stiffness at 1 kHz, N/mm.
    pub max_stiffness_n_per_mm: f64,
    /// Geometry and motors of a device that is an arm.
    pub arm: Option<Arm>,
    /// Masses held up by the motors; absent: they hang.
    pub gravity: Option<Gravity>,
    /// How a device without a place of its own is moved.
    pub rate: Option<RateControl>,
    /// What it does to a motion by itself.
    pub mechanics: Mechanics,
    /// What takes the force off.
    pub guards: Guards,
    /// How it is laid over the subject.
    pub mapping: Mapping,
}

/// Bounds beyond which a device is taken for faulty and its force for unsafe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guards {
    /// No new force from the servo for this long: no current, ms.
    pub command_timeout_ms: f64,
    /// No report for this long: disconnected, ms.
    pub silence_ms: f64,
    /// Reports whose counter stands still for this long: disconnected, ms.
    pub frozen_ms: f64,
    /// A step between two reports beyond this and what the highest speed allows is a fault, mm.
    pub jump_mm: f64,
    /// Motion faster than this is a fault, mm/s.
    pub max_speed_mm_s: f64,
    /// Motion faster than this against at least half the rated force is a fault: an axis may be reversed, mm/s.
    pub against_force_mm_s: f64,
    /// A place farther from the middle of the workspace is a fault, mm.
    pub max_distance_mm: f64,
}

impl Default for Guards {
    /// A palpating hand stays below 1 m/s; a free arm thrown by hand reaches 3. The force is to be gone 10 ms after a fault: 8 ms
    /// leave the link and the wire a millisecond each to do it.
    fn default() -> Self {
        Self {
            command_timeout_ms: 8.0,
            silence_ms: 8.0,
            frozen_ms: 8.0,
            jump_mm: 5.0,
            max_speed_mm_s: 3000.0,
            against_force_mm_s: 400.0,
            max_distance_mm: 500.0,
        }
    }
}

/// A deflection that sets a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateControl {
    /// Speed at full deflection, mm/s.
    pub speed_mm_s: f64,
    /// Share of the deflection, 0 … 1, that is taken for rest.
    pub dead_zone: f64,
    /// Power of the deflection past the dead zone: 1 is proportional, 2 gentler near rest.
    pub exponent: f64,
    /// Farthest from the middle that it goes, mm.
    pub reach_mm: f64,
}

impl Default for RateControl {
    fn default() -> Self {
        Self {
            speed_mm_s: 120.0,
            dead_zone: 0.06,
            exponent: 2.0,
            reach_mm: 250.0,
        }
    }
}

/// How the device stands to the subject.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// The subject lies on a table before the user, head away: the device's up is out of the back.
    #[default]
    Lying,
    /// The subject is seen upright, as on the screen: the device's up is towards the head, towards the user is out of the back.
    Upright,
}

impl Orientation {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Lying, Self::Upright];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lying => "lying",
            Self::Upright => "upright",
        }
    }

    /// The subject's axes (x to its right, y to the head, z out of the back) from the device's (x towards the user, y to the
    /// user's right, z up).
    pub fn subject_from_device(self) -> DMat3 {
        let columns = match self {
            Self::Lying => [Vec3::NEG_Y, Vec3::X, Vec3::Z],
            Self::Upright => [Vec3::Z, Vec3::X, Vec3::Y],
        };
        DMat3::from_cols(columns[0], columns[1], columns[2])
    }
}

/// How a device is laid over the subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Which finger it is, 0 first.
    pub finger: u8,
    /// Motion of the finger for motion of the device.
    pub scale: f64,
    /// How it stands to the subject.
    pub orientation: Orientation,
    /// Turns on top of that about the subject's x, then y, then z, degrees.
    pub turn_deg: [f64; 3],
    /// Where the middle of its workspace lies on the subject, mm.
    pub offset_mm: Vec3,
    /// Button, 1 first, that lets the device move while the finger stays; absent: none.
    pub clutch_button: Option<u8>,
}

impl Default for Mapping {
    fn default() -> Self {
        Self {
            finger: 0,
            scale: 1.0,
            orientation: Orientation::Lying,
            turn_deg: [0.0; 3],
            offset_mm: Vec3::ZERO,
            clutch_button: None,
        }
    }
}

impl Mapping {
    /// The subject's axes from the device's. A pure rotation, whatever the angles.
    pub fn subject_from_device(&self) -> DMat3 {
        let [x, y, z] = self.turn_deg.map(|deg| {
            let rad = rad_from_deg(deg);
            if rad.is_finite() {
                (libm::sin(rad), libm::cos(rad))
            } else {
                (0.0, 1.0)
            }
        });
        let about_x =
            DMat3::from_cols(Vec3::X, Vec3::new(0.0, x.1, x.0), Vec3::new(0.0, -x.0, x.1));
        let about_y =
            DMat3::from_cols(Vec3::new(y.1, 0.0, -y.0), Vec3::Y, Vec3::new(y.0, 0.0, y.1));
        let about_z =
            DMat3::from_cols(Vec3::new(z.1, z.0, 0.0), Vec3::new(-z.0, z.1, 0.0), Vec3::Z);
        about_z * about_y * about_x * self.orientation.subject_from_device()
    }
}

impl Calibration {
    /// What stands in for a family whose devices are no arms.
    pub fn plain(family: &str, rated_force_n: f64, max_stiffness_n_per_mm: f64) -> Self {
        Self {
            family: family.into(),
            serial: None,
            name: None,
            rated_force_n,
            max_stiffness_n_per_mm,
            arm: None,
            gravity: None,
            rate: None,
            mechanics: Mechanics::default(),
            guards: Guards::default(),
            mapping: Mapping::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_way_to_stand_is_a_rotation_and_points_where_it_says() {
        for orientation in Orientation::ALL {
            let m = orientation.subject_from_device();
            assert!((m.determinant() - 1.0).abs() < 1e-12, "{orientation:?}");
        }
        let lying = Orientation::Lying.subject_from_device();
        assert_eq!(lying * Vec3::Z, Vec3::Z, "up is out of the back");
        assert_eq!(lying * Vec3::Y, Vec3::X, "right is right");
        assert_eq!(lying * Vec3::X, Vec3::NEG_Y, "towards the user is footward");
        let upright = Orientation::Upright.subject_from_device();
        assert_eq!(upright * Vec3::Z, Vec3::Y, "up is headward");
        assert_eq!(
            upright * Vec3::X,
            Vec3::Z,
            "towards the user is out of the back"
        );
    }

    #[test]
    fn turns_are_right_handed_and_come_after_the_orientation() {
        let mapping = Mapping {
            turn_deg: [0.0, 0.0, 90.0],
            ..Mapping::default()
        };
        // To the user's right is the subject's right; turned a quarter about z it is headward.
        let there = mapping.subject_from_device() * Vec3::Y;
        assert!((there - Vec3::Y).length() < 1e-12, "{there}");
        for i in 0..3 {
            let mut turn_deg = [33.0, -70.0, 120.0];
            turn_deg[i] = f64::NAN;
            let m = Mapping {
                turn_deg,
                ..mapping
            }
            .subject_from_device();
            assert!((m.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
