//! Devices that speak HID: what goes over the wire, the arm behind it, how it is kept safe.
//!
//! | file | answers |
//! |---|---|
//! | [`report`] | which bytes mean what |
//! | [`arm`], [`models`] | where the tip is, which currents make a force |
//! | [`driver`] | an arm behind each protocol |
//! | [`arms`], [`spacemouse`] | the families |
//! | [`attached`] | which of them are there |
//! | [`velocity`] | how fast it moves, out of encoder steps |
//! | [`guard`] | when the force must go |
//! | [`transport`] | the wire |
//! | `line` | reports over a line of bytes (Linux) |
//! | [`link`] | the thread between wire and servo |
//! | [`emulator`] | a device that is not there, for tests |
//! | [`check`] | does the loop hold |
//! | [`vitals`] | what the link tells about itself |
//!
//! `bash tests/hid/run.sh` plugs the emulator into the kernel of a small Linux guest and tries all this through real hidraw.

pub mod arm;
pub mod arms;
pub mod attached;
pub mod check;
pub mod driver;
pub mod emulator;
pub mod guard;
#[cfg(target_os = "linux")]
pub mod line;
pub mod link;
pub mod models;
pub mod output;
pub mod report;
pub mod spacemouse;
pub mod transport;
pub mod velocity;
pub mod vitals;

#[cfg(test)]
mod chain;
#[cfg(test)]
mod tests {
    use super::report::{spacemouse, teensy, wooden};

    /// A device that is known but not in the rule would be found and not opened.
    #[test]
    fn the_udev_rule_names_every_device() {
        let rule = include_str!("../../../assets/70-dorsum.rules");
        let rule: Vec<&str> = rule.lines().filter(|line| !line.starts_with('#')).collect();
        let named = |(vendor, product): (u16, u16)| {
            let id = format!("*:{vendor:04X}:{product:04X}.*");
            rule.iter()
                .any(|line| line.contains(&id) && line.ends_with("TAG+=\"uaccess\""))
        };
        for ids in spacemouse::IDS
            .into_iter()
            .chain([wooden::IDS, teensy::IDS])
        {
            assert!(named(ids), "{:04X}:{:04X}", ids.0, ids.1);
        }
        assert!(!named((0x1234, 0x0007)));
    }
}
