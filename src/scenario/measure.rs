//! What the parts of a scene hold and cost once a finger has pressed and slid.

use super::{Item, Ledger, Scene, Use};
use crate::contact::Contact;
use crate::deform::{Displacement, Model as _, models::fsmd::Fsmd};
use crate::device::scripted::{Script, Scripted};
use crate::geom::Vec3;
use crate::partition::{Partition as _, Sides};
use crate::servo::{self, Limits, MAX_FINGERS, Rig};
use std::time::{Duration, Instant};

/// Simulated time step, s.
const DT_S: f64 = 0.001;
/// Ticks of the press.
const TICKS: usize = 4000;
/// A window draws about one frame in as many ticks.
const TICKS_PER_FRAME: usize = 16;
/// How deep the finger presses, mm.
const DEPTH_MM: f64 = 5.0;
/// Frames of a very large mesh are slow: enough is measured by then.
const MEASURED_FOR: Duration = Duration::from_secs(1);

impl Scene {
    /// Height at which a finger touches the skin over a place of the map plane, mm, seen from behind: a pad's centre is a
    /// radius above it. `None` beside the surface.
    pub fn height_mm(&self, x: f64, y: f64) -> Option<f64> {
        let bounds = self.surface.bounds();
        let (from, to) = (
            Vec3::new(x, y, bounds.max.z + 1.0),
            Vec3::new(x, y, bounds.min.z - 1.0),
        );
        self.touch
            .search
            .sweep(&self.surface, from, to, Sides::Front)
            .map(|hit| hit.point.z + self.touch.choices.pad_mm().unwrap_or(0.0))
    }

    /// Where scripts press unless told otherwise, mm on the map plane: right of the middle, over the muscle of the built-in
    /// back beside the spine.
    pub fn default_place_mm(&self) -> (f64, f64) {
        let bounds = self.surface.bounds();
        (
            bounds.centre().x + 0.08 * bounds.size().x,
            bounds.centre().y,
        )
    }

    /// Presses and slides for four seconds of simulated time. Notes in `ledger` what a tick and, where `purpose` shows the
    /// skin, a frame cost in the mean, and what the deformation then holds. Gives back the cost of a tick, µs.
    pub fn measure(&self, purpose: Use, ledger: &mut Ledger) -> f64 {
        let (contacts, tick_us) = self.slide();
        let engine = if self.touch.published.is_some() {
            Item::Published
        } else {
            Item::Search
        };
        ledger.cost(engine, tick_us, "tick");
        if purpose.drawn || purpose.deformed {
            self.measure_deformation(&contacts, ledger);
        }
        tick_us
    }

    fn slide(&self) -> (Vec<Contact>, f64) {
        let height_mm = |x, y| self.height_mm(x, y);
        let script = Script::Slide.trajectory(self.default_place_mm(), DEPTH_MM, height_mm);
        let mut rig = Rig::new(
            Box::new(self.touch.clone()),
            [Limits::default(); MAX_FINGERS],
        );
        let mut contacts = Vec::with_capacity(TICKS);
        let started = Instant::now();
        servo::run_offline(
            &mut rig,
            vec![Box::new(Scripted::new(script))],
            DT_S,
            |out| {
                contacts.push(out.fingers[0].contact);
                contacts.len() < TICKS
            },
        );
        let tick_us = started.elapsed().as_secs_f64() * 1.0e6 / TICKS as f64;
        (contacts, tick_us)
    }

    fn measure_deformation(&self, contacts: &[Contact], ledger: &mut Ledger) {
        let mut model = Fsmd::new(self.deform.clone());
        model.prepare(&self.surface);
        let mut skin = Displacement::at_rest(&self.surface);
        let started = Instant::now();
        let mut n_frames = 0_u32;
        for contact in contacts.iter().step_by(TICKS_PER_FRAME) {
            let press = self.press(contact);
            model.update(&self.surface, press.as_slice(), &mut skin);
            n_frames += 1;
            if started.elapsed() > MEASURED_FOR {
                break;
            }
        }
        let frame_us = started.elapsed().as_secs_f64() * 1.0e6 / f64::from(n_frames.max(1));
        ledger.built(Item::Deformation, skin.bytes() + model.bytes());
        ledger.cost(Item::Deformation, frame_us, "frame");
        if self.deform.tangential {
            // Its half of every vertex is summed where the normal half is: it holds nothing of its own.
            ledger.built(Item::TangentialField, 0);
        }
    }
}
