//! The devices the test plugs in: ids, report descriptor and lengths of each.

/// One kind of device.
pub struct Kind {
    pub key: &'static str,
    /// Key of Dorsum's family of devices.
    pub family: &'static str,
    pub name: &'static str,
    pub vendor: u16,
    pub product: u16,
    pub usage_page: u16,
    pub usage: u16,
    /// Bytes of an input report as the host reads it: with the id byte where reports are numbered.
    pub in_bytes: usize,
    /// Bytes of an output report as the host writes it: the id byte always in front.
    pub out_bytes: usize,
    /// The id byte of an output report; 0 where reports are not numbered.
    pub out_id: u8,
    pub descriptor: fn() -> Vec<u8>,
    pub speaks: Speaks,
}

/// The protocol behind the reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speaks {
    /// Three encoders and a counter; three currents and a counter.
    Wooden8,
    /// Six encoders and a word of flags; three currents, a command, three attributes. One report for each of the host's, which must begin.
    Wooden14,
    /// The same 14 bytes at the head of 64, the rest free: this test counts reports there.
    Teensy64,
    /// Translation and rotation in reports 1 and 2, buttons in 3, the lamp in 4.
    SpaceMouseSplit,
    /// All six axes in report 1.
    SpaceMouseWhole,
}

impl Speaks {
    /// The board takes the currents off after so long without a report, ms.
    pub fn off_after_ms(self) -> u64 {
        if self == Self::Teensy64 { 10 } else { 500 }
    }
}

pub static KINDS: [Kind; 5] = [
    Kind {
        key: "wooden-8",
        family: "woodenhaptics",
        name: "WoodenHaptics v1",
        vendor: 0x1234,
        product: 0x0006,
        usage_page: 0xFFAB,
        usage: 0x0200,
        in_bytes: 8,
        out_bytes: 9,
        out_id: 0,
        descriptor: || plain(8, 8),
        speaks: Speaks::Wooden8,
    },
    Kind {
        key: "wooden-14",
        family: "polhem",
        name: "Polhem v2",
        vendor: 0x1234,
        product: 0x0006,
        usage_page: 0xFFAB,
        usage: 0x0200,
        in_bytes: 14,
        out_bytes: 15,
        out_id: 0,
        descriptor: || plain(14, 14),
        speaks: Speaks::Wooden14,
    },
    Kind {
        key: "teensy-64",
        family: "polhem-teensy",
        name: "Polhem Teensy",
        vendor: 0x16C0,
        product: 0x0486,
        usage_page: 0xFFAB,
        usage: 0x0200,
        in_bytes: 64,
        out_bytes: 65,
        out_id: 0,
        descriptor: || plain(64, 64),
        speaks: Speaks::Teensy64,
    },
    Kind {
        key: "spacemouse-split",
        family: "spacemouse",
        // Not the SpaceNavigator, C626: Linux leaves that one to a driver that takes it from a USB port only.
        name: "SpaceMouse Pro",
        vendor: 0x046D,
        product: 0xC62B,
        usage_page: 0x0001,
        usage: 0x0008,
        in_bytes: 7,
        out_bytes: 2,
        out_id: 4,
        descriptor: || spacemouse(false),
        speaks: Speaks::SpaceMouseSplit,
    },
    Kind {
        key: "spacemouse-whole",
        family: "spacemouse",
        name: "SpaceMouse Wireless",
        vendor: 0x256F,
        product: 0xC635,
        usage_page: 0x0001,
        usage: 0x0008,
        in_bytes: 13,
        out_bytes: 2,
        out_id: 4,
        descriptor: || spacemouse(true),
        speaks: Speaks::SpaceMouseWhole,
    },
];

/// The kind with this key.
pub fn named(key: &str) -> Result<&'static Kind, String> {
    KINDS.iter().find(|kind| kind.key == key).ok_or_else(|| {
        let keys: Vec<&str> = KINDS.iter().map(|kind| kind.key).collect();
        format!("no device is called '{key}'; allowed: {}", keys.join(", "))
    })
}

/// Vendor page FFAB, usage 0200: so many bytes in, so many out, no report ids.
fn plain(bytes_in: u8, bytes_out: u8) -> Vec<u8> {
    let mut d = vec![0x06, 0xAB, 0xFF, 0x0A, 0x00, 0x02, 0xA1, 0x01]; // page, usage, application
    d.extend([0x15, 0x00, 0x26, 0xFF, 0x00, 0x75, 0x08]); // 0 to 255, 8 bits each
    d.extend([0x95, bytes_in, 0x09, 0x01, 0x81, 0x02]);
    d.extend([0x95, bytes_out, 0x09, 0x02, 0x91, 0x02]);
    d.push(0xC0);
    d
}

/// A multi-axis controller, ±350 an axis: in two reports, or `whole` in one.
fn spacemouse(whole: bool) -> Vec<u8> {
    let mut d = vec![0x05, 0x01, 0x09, 0x08, 0xA1, 0x01]; // generic desktop, multi-axis controller, application
    let axes = |d: &mut Vec<u8>, first_usage: u8, count: u8| {
        d.extend([
            0x05, 0x01, 0x16, 0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x75, 0x10, 0x95, count,
        ]); // -350 to 350, 16 bits each
        for usage in first_usage..first_usage + count {
            d.extend([0x09, usage]);
        }
        d.extend([0x81, 0x02]);
    };
    if whole {
        d.extend([0xA1, 0x00, 0x85, 1]);
        axes(&mut d, 0x30, 6);
        d.push(0xC0);
    } else {
        for (id, first_usage) in [(1, 0x30), (2, 0x33)] {
            d.extend([0xA1, 0x00, 0x85, id]);
            axes(&mut d, first_usage, 3);
            d.push(0xC0);
        }
    }
    d.extend([
        0xA1, 0x02, 0x85, 3, 0x05, 0x09, 0x19, 1, 0x29, 16, 0x15, 0, 0x25, 1, 0x75, 1, 0x95, 16,
        0x81, 0x02, 0xC0,
    ]); // buttons
    d.extend([
        0xA1, 0x02, 0x85, 4, 0x05, 0x08, 0x09, 0x4B, 0x15, 0, 0x25, 1, 0x75, 1, 0x95, 1, 0x91, 0x02,
    ]); // lamp
    d.extend([0x75, 7, 0x95, 1, 0x91, 0x03, 0xC0]);
    d.push(0xC0);
    d
}
