//! Plays a stream of readings. Knows no file format.

use super::{Capabilities, Device, Reading};
use crate::geom::Vec3;

/// A device fed by recorded readings, one per tick; after the last it reports itself disconnected there.
pub struct Replay<I> {
    capabilities: Capabilities,
    readings: I,
    last: Reading,
}

impl<I: Iterator<Item = Reading>> Replay<I> {
    /// A device with the recorded device's capabilities that plays `readings`.
    pub fn new(capabilities: Capabilities, readings: I) -> Self {
        Self {
            capabilities,
            readings,
            last: Reading::default(),
        }
    }
}

impl<I: Iterator<Item = Reading> + Send> Device for Replay<I> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self, _dt_s: f64) -> Reading {
        match self.readings.next() {
            Some(reading) => self.last = reading,
            None => {
                self.last.connected = false;
                self.last.velocity_mm_s = Vec3::ZERO;
            }
        }
        self.last
    }

    fn write(&mut self, _force_n: Vec3) {}
}
