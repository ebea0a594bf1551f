//! A number over the map plane, as a picture: worked out off the window's thread, coarse first where it takes long.

use super::contour::{self, Contour};
use super::grid::Grid;
use super::plane::Area;
use super::worker::Worker;
use crate::app::bench::Wake;
use crate::geom::Vec2;
use std::sync::Arc;
use std::time::Instant;

/// Samples of a coarse picture.
const COARSE: f64 = 2_500.0;
/// Samples of a fine picture.
const FINE: f64 = 42_000.0;
/// A fine picture that takes less than this is made at once, s.
const AT_ONCE_S: f64 = 0.012;
/// Room around what is on show, part of it, so that there is something to see while it is moved.
const ROOM: f64 = 0.12;
/// Most lines.
const LEVELS: f64 = 9.0;

/// Reads values of a map at one place after another; it may hold scratch memory.
pub type Reader<'a> = Box<dyn FnMut(Vec2) -> f64 + 'a>;

/// What is to be shown. `M` is the map: built once for each change of it, asked for every place.
pub struct Spec<M> {
    /// Another number for each state of the map.
    pub map: u64,
    /// Another number for each value of it that can be shown.
    pub quantity: u64,
    /// Builds the map; off the window's thread.
    pub build: Arc<dyn Fn() -> Result<M, String> + Send + Sync>,
    /// The value at each place.
    pub read: Arc<dyn for<'a> Fn(&'a M) -> Reader<'a> + Send + Sync>,
    /// Whether lines of equal value make sense: not for directions.
    pub lines: bool,
    /// Whether there is a line at 0: not where most of the field is 0 but for rounding, which it would trace.
    pub line_at_zero: bool,
}

/// A picture.
pub struct Picture<M> {
    /// The state of the map.
    pub map_state: u64,
    /// Which of its values.
    pub quantity: u64,
    /// The map itself, for exact values at single places.
    pub map: Arc<M>,
    /// The values.
    pub grid: Grid,
    /// Lines of equal value.
    pub contours: Vec<Contour>,
    /// From one line to the next.
    pub step: f64,
    /// Whether a finer one comes.
    pub coarse: bool,
    s_per_sample: f64,
}

/// Keeps the picture of a [`Spec`] up to date.
pub struct Field<M> {
    worker: Worker<Result<Picture<M>, (u64, String)>>,
    shown: Option<Arc<Picture<M>>>,
    asked: Option<Asked>,
    fault: Option<String>,
    /// Counts pictures.
    made: u64,
}

#[derive(Clone, Copy, PartialEq)]
struct Asked {
    map: u64,
    quantity: u64,
    area: Area,
    coarse: bool,
}

impl<M: Send + Sync + 'static> Default for Field<M> {
    fn default() -> Self {
        Self {
            worker: Worker::new("map picture"),
            shown: None,
            asked: None,
            fault: None,
            made: 0,
        }
    }
}

impl<M: Send + Sync + 'static> Field<M> {
    /// The newest picture.
    pub fn picture(&self) -> Option<&Arc<Picture<M>>> {
        self.shown.as_ref()
    }

    /// Why the map cannot be built.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Counts pictures: another number for another picture.
    pub fn made(&self) -> u64 {
        self.made
    }

    /// Whether a newer picture is being made.
    pub fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }

    /// Frees everything.
    pub fn clear(&mut self) {
        self.worker.stop();
        (self.shown, self.asked, self.fault) = (None, None, None);
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.shown.as_ref().map_or(0, |p| p.grid.bytes())
    }

    /// Takes what came, and asks for what `spec` says of the places in `area`.
    pub fn follow(&mut self, spec: &Spec<M>, area: Area, wake: &Wake) {
        match self.worker.poll(wake) {
            Some(Ok(picture)) => {
                self.shown = Some(Arc::new(picture));
                self.made += 1;
                self.fault = None;
            }
            Some(Err((map, fault))) if map == spec.map => self.fault = Some(fault),
            _ => {}
        }
        let room = area.size() * ROOM;
        let wide = Area {
            min: area.min - room,
            max: area.max + room,
        };
        let usable = |a: &Asked| {
            let (have, want) = (a.area.size().max_element(), wide.size().max_element());
            a.map == spec.map
                && a.quantity == spec.quantity
                && a.area.with(&area) == a.area
                && have < 1.4 * want
        };
        if let Some(asked) = self.asked.filter(usable) {
            let there = self.shown.as_ref().is_some_and(|p| {
                p.map_state == asked.map
                    && p.quantity == asked.quantity
                    && p.grid.area == asked.area
            });
            // The coarse one is there: now the fine one of the same area.
            if !(asked.coarse && there && !self.worker.is_busy()) {
                return;
            }
            self.ask(spec, asked.area, false, wake);
            return;
        }
        let s_per_sample = self.shown.as_ref().map_or(1e-6, |p| p.s_per_sample);
        self.ask(spec, wide, s_per_sample * FINE > AT_ONCE_S, wake);
    }

    fn ask(&mut self, spec: &Spec<M>, area: Area, coarse: bool, wake: &Wake) {
        let ready = self
            .shown
            .as_ref()
            .filter(|p| p.map_state == spec.map)
            .map(|p| p.map.clone());
        let (build, read, lines) = (spec.build.clone(), spec.read.clone(), spec.lines);
        let line_at_zero = spec.line_at_zero;
        let (map_state, quantity) = (spec.map, spec.quantity);
        // A quick one is let finish: stopped by every step of a drag, none would ever come.
        let slow = self
            .shown
            .as_ref()
            .is_some_and(|p| p.s_per_sample * FINE > AT_ONCE_S);
        let made_fine = self.asked.is_some_and(|a| !a.coarse);
        let work = move |go_on: &dyn Fn() -> bool| {
            let map = match ready.map_or_else(|| build().map(Arc::new), Ok) {
                Ok(map) => map,
                Err(fault) => return Some(Err((map_state, fault))),
            };
            let samples = if coarse { COARSE } else { FINE };
            let size = area.size();
            let cell_mm = (size.x * size.y / samples).sqrt();
            let started = Instant::now();
            // A coarse one is soon done and always finished: while something is dragged it is all there is to see.
            let go_on: &dyn Fn() -> bool = if coarse { &|| true } else { go_on };
            let grid = Grid::sample(area, cell_mm, read(&map), go_on)?;
            let s_per_sample = started.elapsed().as_secs_f64() / grid.values.len() as f64;
            let (mut levels, step) = match grid.range() {
                Some((lo, hi)) if lines => contour::levels(lo, hi, LEVELS),
                _ => (Vec::new(), 1.0),
            };
            levels.retain(|level| line_at_zero || level.abs() > 1e-6 * step);
            Some(Ok(Picture {
                map_state,
                quantity,
                map,
                contours: contour::contours(&grid, &levels),
                grid,
                step,
                coarse,
                s_per_sample,
            }))
        };
        self.worker.ask(slow && made_fine, work, wake);
        self.asked = Some(Asked {
            map: spec.map,
            quantity: spec.quantity,
            area,
            coarse,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn spec(map: u64, slow: bool) -> Spec<f64> {
        Spec {
            map,
            quantity: 0,
            build: Arc::new(move || {
                if map == 13 {
                    Err("thirteen".into())
                } else {
                    Ok(map as f64)
                }
            }),
            read: Arc::new(move |m: &f64| {
                Box::new(move |p: Vec2| {
                    if slow {
                        std::thread::sleep(Duration::from_micros(5));
                    }
                    m * p.x
                })
            }),
            lines: true,
            line_at_zero: map != 3,
        }
    }

    fn area() -> Area {
        Area {
            min: Vec2::ZERO,
            max: Vec2::new(100.0, 60.0),
        }
    }

    fn settle(field: &mut Field<f64>, spec: &Spec<f64>) {
        let wake: Wake = Arc::new(|| {});
        let started = Instant::now();
        loop {
            field.follow(spec, area(), &wake);
            let done = field
                .picture()
                .is_some_and(|p| p.map_state == spec.map && !p.coarse);
            if done || field.fault().is_some() {
                return;
            }
            assert!(started.elapsed() < Duration::from_secs(60), "never came");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn the_picture_is_that_of_the_newest_map_and_the_map_is_at_hand() {
        let mut field = Field::default();
        settle(&mut field, &spec(2, false));
        settle(&mut field, &spec(3, true));
        let picture = field.picture().expect("a picture").clone();
        assert_eq!(*picture.map, 3.0);
        assert!(picture.grid.values.len() as f64 > 0.8 * FINE);
        assert!(picture.grid.area.with(&area()) == picture.grid.area);
        assert_eq!(picture.step, 50.0);
        let levels: Vec<_> = picture.contours.iter().map(|c| c.level).collect();
        assert_eq!(levels[0], 0.0 + picture.step, "none at 0 here: {levels:?}");
        let before = field.made();
        settle(&mut field, &spec(3, true));
        assert_eq!(field.made(), before, "nothing changed, nothing is made");
    }

    #[test]
    fn a_map_that_cannot_be_built_is_told_and_the_last_picture_stays() {
        let mut field = Field::default();
        settle(&mut field, &spec(2, false));
        settle(&mut field, &spec(13, false));
        assert_eq!(field.fault(), Some("thirteen"));
        assert_eq!(field.picture().map(|p| *p.map), Some(2.0));
        field.fault = None;
        settle(&mut field, &spec(4, false));
        assert_eq!(field.fault(), None);
        field.clear();
        assert!(field.picture().is_none() && field.bytes() == 0);
    }
}
