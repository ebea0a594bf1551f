//! The quantity that colours the skin: which one, over which range, and how its values are kept up to date.

use super::stage::SharedStage;
use crate::app::bench::Wake;
use crate::app::bench::job::Job;
use crate::app::colours::frame::PerFrame;
use crate::app::colours::range::Range;
use crate::app::colours::rest::Rest;
use crate::app::colours::{self, Quantity, Source};
use crate::app::render::tint::Tint;
use crate::app::render::values::Values;
use crate::app::state::{BuildStatus, PartCost, Parts};
use crate::deform::Displacement;
use crate::deform::strain::Strain;
use crate::scenario::{Item, Scene};
use std::sync::Arc;
use std::time::Instant;

/// Surfaces up to this many vertices are worked through at once: it takes less than a frame.
const AT_ONCE: usize = 50_000;
/// About as many level lines are drawn over the range.
const LINES: usize = 12;

/// The choice, and what exists for it: nothing while bare skin is shown.
#[derive(Default)]
pub struct SurfaceColour {
    quantity: Option<&'static Quantity>,
    /// Level lines over what stands still.
    contours: bool,
    /// There once a quantity was shown: its ranges are kept.
    ranges: Vec<(&'static str, Range)>,
    state: State,
    /// Cost of the last update or build, µs.
    cost_us: Option<(f64, &'static str)>,
}

/// Where the values come from at the moment.
#[derive(Default)]
enum State {
    /// Nothing is held.
    #[default]
    None,
    /// Follows the deformation.
    Frame(Box<dyn PerFrame>),
    /// Stands still; with the reason where it is the same everywhere.
    Rest {
        scene: Arc<Scene>,
        why: Option<&'static str>,
        job: Option<Job<Option<(Values, f64)>>>,
    },
}

impl SurfaceColour {
    /// What is shown; `None` for bare skin.
    pub fn quantity(&self) -> Option<&'static Quantity> {
        self.quantity
    }

    /// Shows something else.
    pub fn choose(&mut self, quantity: Option<&'static Quantity>, stage: &SharedStage) {
        if self.quantity != quantity {
            self.quantity = quantity;
            self.forget(stage);
        }
    }

    /// The choice as text, to be taken back by [`SurfaceColour::recall`].
    pub fn kept(&self) -> String {
        let key = self.quantity.map_or(colours::SKIN, |q| q.key);
        let contours = if self.contours { " contours" } else { "" };
        format!("colour={key}{contours}")
    }

    /// Takes the choice back; what it does not know it leaves. For before anything is drawn.
    pub fn recall(&mut self, kept: &str) {
        for word in kept.split_whitespace() {
            match word.strip_prefix("colour=").map(colours::named) {
                Some(Ok(quantity)) => self.quantity = quantity,
                Some(Err(_)) => {}
                None => self.contours |= word == "contours",
            }
        }
    }

    /// The entry `by` places on in the list, bare skin among them.
    pub fn beside(&self, by: isize) -> Option<&'static Quantity> {
        let all = colours::all();
        let now = self
            .quantity
            .and_then(|q| all.iter().position(|other| other == q))
            .map_or(0, |i| i + 1);
        let n = all.len() + 1;
        let next = (now as isize + by).rem_euclid(n as isize) as usize;
        next.checked_sub(1).and_then(|i| all.get(i))
    }

    /// Whether level lines are drawn where they can be.
    pub fn contours(&self) -> bool {
        self.contours
    }

    /// Draws level lines, or none.
    pub fn set_contours(&mut self, on: bool) {
        self.contours = on;
    }

    /// The range of what is shown.
    pub fn range(&mut self) -> Option<&mut Range> {
        let quantity = self.quantity?;
        let at = self.ranges.iter().position(|(key, _)| *key == quantity.key);
        let at = at.unwrap_or_else(|| {
            self.ranges.push((quantity.key, Range::new(quantity.span)));
            self.ranges.len() - 1
        });
        self.ranges.get_mut(at).map(|(_, range)| range)
    }

    /// Why the values are the same everywhere, where they are.
    pub fn why_same(&self) -> Option<&'static str> {
        match &self.state {
            State::Rest { why, .. } => *why,
            _ => None,
        }
    }

    /// Whether values are being worked out beside the window.
    pub fn is_working(&self) -> bool {
        matches!(&self.state, State::Rest { job: Some(_), .. })
    }

    /// Step between level lines, where there are any.
    pub fn contour_step(&mut self) -> Option<f64> {
        let drawn = self.contours && self.quantity?.has_contours();
        let step = self.range()?.step(LINES);
        drawn.then_some(step)
    }

    /// How the skin is to be coloured.
    pub fn tint(&mut self) -> Option<Tint> {
        let quantity = self.quantity?;
        let contour_step = self.contour_step();
        let range = self.range()?.bounds();
        Some(Tint {
            map: quantity.map,
            range,
            contour_step,
        })
    }

    /// The strain, where it is shown, for the model to bring along.
    pub fn strain(&mut self) -> Option<&mut Strain> {
        match &mut self.state {
            State::Frame(quantity) => quantity.strain(),
            _ => None,
        }
    }

    /// Brings the values up to what is chosen. `moved` tells whether the displacement had an update since the last call.
    pub fn follow(
        &mut self,
        scene: &Arc<Scene>,
        displacement: &Displacement,
        moved: bool,
        stage: &SharedStage,
        wake: impl FnOnce() -> Wake,
    ) {
        let Some(quantity) = self.quantity else {
            return;
        };
        match quantity.source {
            Source::Frame(make) => self.follow_frame(make, scene, displacement, moved, stage),
            Source::Rest(of) => self.follow_rest(of, scene, stage, wake),
        }
    }

    fn follow_frame(
        &mut self,
        make: fn(&crate::surface::Surface, &Displacement) -> Box<dyn PerFrame>,
        scene: &Arc<Scene>,
        displacement: &Displacement,
        moved: bool,
        stage: &SharedStage,
    ) {
        let surface = &scene.surface;
        let start = Instant::now();
        let new = match &mut self.state {
            State::Frame(_) if !moved => return,
            State::Frame(quantity) => {
                quantity.follow(surface, displacement);
                false
            }
            _ => {
                self.state = State::Frame(make(surface, displacement));
                true
            }
        };
        let State::Frame(quantity) = &self.state else {
            return;
        };
        let mut locked = stage.lock();
        let Some(mesh) = &mut locked.mesh else { return };
        if new {
            mesh.set_values(Some(Values::each(surface.positions().len(), |_| 0.0)));
        }
        let mut seen = None;
        if let Some(values) = mesh.values_mut() {
            quantity.changed(displacement, &mut |v| {
                values.set(v, quantity.value(displacement, v));
            });
            seen = values.range();
        }
        drop(locked);
        // What it cost to begin is paid once.
        if !new {
            self.cost_us = Some((start.elapsed().as_secs_f64() * 1e6, "frame"));
        }
        self.note(seen);
    }

    fn follow_rest(
        &mut self,
        of: fn(&Scene) -> Rest,
        scene: &Arc<Scene>,
        stage: &SharedStage,
        wake: impl FnOnce() -> Wake,
    ) {
        if let State::Rest { scene: of, job, .. } = &mut self.state
            && Arc::ptr_eq(of, scene)
        {
            let done = job.as_ref().and_then(|job| job.poll(|| None));
            if let Some(outcome) = done {
                *job = None;
                // Work that broke off leaves the skin bare: no colour is better than a wrong one.
                let (values, us) = outcome.map_or((None, None), |(v, us)| (Some(v), Some(us)));
                self.put(values, us, stage);
            }
            return;
        }
        let n = scene.surface.positions().len();
        let (mut why, mut job, mut now) = (None, None, None);
        let start = Instant::now();
        match of(scene) {
            Rest::Same {
                value,
                why: because,
            } => {
                why = Some(because);
                now = Some(Values::same(value));
            }
            Rest::PerVertex(value) if n <= AT_ONCE => now = Some(Values::each(n, value)),
            Rest::PerVertex(value) => {
                let status = BuildStatus {
                    scenario: scene.scenario.name.clone(),
                    part: "surface colour".into(),
                    fraction: 0.0,
                };
                // Without a thread the skin stays bare.
                job = Job::start("surface colour", status, wake(), move |_| {
                    let start = Instant::now();
                    let values = Values::each(n, value);
                    Some((values, start.elapsed().as_secs_f64() * 1e6))
                })
                .ok();
            }
        }
        // After an edit the old colours stay until the new ones are there.
        self.state = State::Rest {
            scene: scene.clone(),
            why,
            job,
        };
        if now.is_some() {
            let us = start.elapsed().as_secs_f64() * 1e6;
            self.put(now, Some(us).filter(|_| why.is_none()), stage);
        }
    }

    fn put(&mut self, values: Option<Values>, build_us: Option<f64>, stage: &SharedStage) {
        let seen = values.as_ref().and_then(Values::range);
        if let Some(mesh) = &mut stage.lock().mesh {
            mesh.set_values(values);
        }
        self.cost_us = build_us.map(|us| (us, "build"));
        if let Some(range) = self.range() {
            range.forget();
        }
        self.note(seen);
    }

    fn note(&mut self, seen: Option<[f64; 2]>) {
        if let (Some(seen), Some(range)) = (seen, self.range()) {
            range.note(seen);
        }
    }

    /// Lets the range follow the data anew. What moves starts from what is seen now.
    pub fn reset_range(&mut self, displacement: &Displacement) {
        let now = match &self.state {
            State::Frame(quantity) => {
                let (mut low, mut high) = (0.0, 0.0);
                for v in displacement.moved() {
                    let value = quantity.value(displacement, v);
                    (low, high) = (value.min(low), value.max(high));
                }
                Some([low, high])
            }
            _ => self.range().and_then(|range| range.seen()),
        };
        if let Some(range) = self.range() {
            range.reset(now);
        }
    }

    /// The scene was edited: what follows the deformation is made anew, since it may have missed a step of that. What stands
    /// still finds out by itself, and shows the old values until it has new ones.
    pub fn renew(&mut self) {
        if matches!(self.state, State::Frame(_)) {
            self.state = State::None;
        }
    }

    /// Frees everything; the choice stays.
    pub fn forget(&mut self, stage: &SharedStage) {
        self.state = State::None;
        self.cost_us = None;
        if let Some(mesh) = &mut stage.lock().mesh {
            mesh.set_values(None);
        }
    }

    /// Tells the ledger what it holds and costs; nothing while bare skin is shown.
    pub fn report(&self, parts: &Parts, stage: &SharedStage) {
        if self.quantity.is_none() {
            parts.remove(Item::SurfaceColour);
            return;
        }
        let own = match &self.state {
            State::Frame(quantity) => quantity.bytes(),
            _ => 0,
        };
        let locked = stage.lock();
        let values = locked.mesh.as_ref().and_then(|mesh| mesh.values());
        let cost = PartCost {
            bytes: own + values.map_or(0, Values::bytes),
            cost_us: self.cost_us,
        };
        drop(locked);
        parts.report(Item::SurfaceColour, cost);
    }
}
