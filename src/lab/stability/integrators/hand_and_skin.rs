//! The limit of a hand and the skin that take turns.

use super::MM_PER_S2;
use super::limits::{BLOWN_UP, Limit, border, open};
use crate::contact::{ForceModel, Stiffness, TouchScene};
use crate::device::mouse::{Hand, Mouse};
use crate::device::{Device as _, MAX_FINGERS};
use crate::geom::Vec3;
use crate::partition::bvh::Bvh;
use crate::servo::{Limits, Rig, TickInput, tick};
use crate::surface::Surface;
use crate::surface::torture::{grid, steps};
use std::sync::Arc;

/// A hand that follows its target implicitly, on a skin whose force is as old as the last tick.
///
/// With the hand's mass m, stiffness k, damping b, the skin's stiffness K and damping B about where they rest,
/// D = m + b h + k h² (in kg): v′ = (m v − (k + K) h x − B h v)/D, x′ = x + h v′. So t = 1 + (m − B h)/D − (k + K) h²/D and
/// d = (m − B h)/D: stable while (k + K) h² < 2 (D + m − B h).
struct Loop {
    hand: Hand,
    model: ForceModel,
    skin_n_per_mm: f64,
    dt_s: f64,
}

/// Depth that the hand holds, mm.
const HELD_MM: f64 = 4.0;

impl Loop {
    /// Stiffness and damping of the skin about where it is held.
    fn slopes(&self) -> [f64; 2] {
        match self.model {
            ForceModel::HuntCrossley {
                damping_s_per_mm,
                exponent,
            } => {
                let held_n = self.skin_n_per_mm * libm::pow(HELD_MM, exponent);
                [exponent * held_n / HELD_MM, held_n * damping_s_per_mm]
            }
            _ => [self.skin_n_per_mm, 0.0],
        }
    }

    /// What is left of stability, kg; 0 at the border.
    fn margin(&self) -> f64 {
        let Hand {
            mass_kg: m,
            stiffness_n_per_mm: k,
            damping_n_s_per_mm: b,
        } = self.hand;
        let h = self.dt_s;
        let [skin, damper] = self.slopes();
        let held = m + MM_PER_S2 * h * (b + k * h);
        2.0 * (held + m - MM_PER_S2 * damper * h) - MM_PER_S2 * (k + skin) * h * h
    }

    /// Whether hand and skin stay where they balance.
    fn stays(&self, scene: &TouchScene, many: usize) -> bool {
        let mut scene = scene.clone();
        scene.stiffness = Stiffness::Uniform(self.skin_n_per_mm);
        scene.choices.force = self.model;
        let free = Limits {
            rated_force_n: 1.0e12,
            rise_n_per_s: 1.0e18,
            ..Limits::default()
        };
        let held_n = self.model.force_n(self.skin_n_per_mm, HELD_MM, 0.0);
        let start_mm = 1.0e-6;
        let (mut device, handle) = Mouse::new(Vec3::Z * (start_mm - HELD_MM), self.hand);
        handle.set(Vec3::Z * (-HELD_MM - held_n / self.hand.stiffness_n_per_mm));
        device.write(Vec3::Z * held_n);
        let mut rig = Rig::new(Box::new(scene), [free; MAX_FINGERS]);
        let mut input = TickInput {
            n_fingers: 1,
            force_enabled: true,
            ..TickInput::default()
        };
        // Once outside, so that the skin holds.
        input.readings[0].connected = true;
        input.readings[0].position_mm = Vec3::Z;
        tick(&mut rig, &input, self.dt_s);
        for _ in 0..many {
            input.readings[0] = device.read(self.dt_s);
            let off = (input.readings[0].position_mm.z + HELD_MM).abs();
            if off.is_nan() || off >= start_mm * BLOWN_UP {
                return false;
            }
            device.write(tick(&mut rig, &input, self.dt_s).fingers[0].sent_force_n);
        }
        true
    }
}

/// The zero of a function that falls.
fn zero(mut above: f64, mut below: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (above + below);
        if f(middle) > 0.0 {
            above = middle;
        } else {
            below = middle;
        }
    }
    0.5 * (above + below)
}

pub(super) fn loops(many: usize) -> Vec<Limit> {
    let s = steps(-10.0, 10.0, 2);
    let Ok((surface, _)) = Surface::new(grid(&s, &s, |_, _| 0.0)) else {
        return Vec::new();
    };
    let search = Arc::new(Bvh::new(&surface));
    let scene = TouchScene::new(Arc::new(surface), search, Stiffness::Uniform(1.0));
    let hand = Hand::default();
    let mut limits = Vec::new();
    let mut find =
        |integrator: &str, what: String, unit: &str, most: f64, of: &dyn Fn(f64) -> Loop| {
            let theory = zero(0.0, most, |x| of(x).margin());
            let measured = border(0.5 * theory, 2.0 * theory, |x| of(x).stays(&scene, many));
            limits.push(Limit {
                integrator: integrator.to_owned(),
                what,
                unit: unit.to_owned(),
                theory,
                measured,
                open: open(many, true),
            });
        };
    for rate_hz in [100.0, 1000.0, 10_000.0] {
        find(
            "mouse's hand on linear skin",
            format!("stiffest skin at {rate_hz} Hz"),
            "N/mm",
            1.0e9,
            &|skin_n_per_mm| Loop {
                hand,
                model: ForceModel::Linear,
                skin_n_per_mm,
                dt_s: 1.0 / rate_hz,
            },
        );
    }
    find(
        "mouse's hand on linear skin",
        "longest tick on 100 N/mm".to_owned(),
        "s",
        1.0,
        &|dt_s| Loop {
            hand,
            model: ForceModel::Linear,
            skin_n_per_mm: 100.0,
            dt_s,
        },
    );
    for exponent in [1.0, 1.5] {
        find(
            "mouse's hand on a Hunt–Crossley skin",
            format!("largest damping at 1 kHz, 2 N at 1 mm, exponent {exponent}"),
            "s/mm",
            1.0e6,
            &|damping_s_per_mm| Loop {
                hand,
                model: ForceModel::HuntCrossley {
                    damping_s_per_mm,
                    exponent,
                },
                skin_n_per_mm: 2.0,
                dt_s: 1.0e-3,
            },
        );
    }
    limits
}
