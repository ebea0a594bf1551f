//! Devices that speak HID: what goes over the wire, the arm behind it, how it is kept safe.

pub mod arm;
pub mod models;
pub mod report;
