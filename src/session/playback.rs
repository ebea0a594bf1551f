//! Playing a recording: a plain value that takes commands and time steps. It owns no clock and no window.

use super::format::Event;
use super::header::Header;
use super::timeline::Timeline;
use crate::servo::TickRecord;
use crate::units::{NS_PER_S, s_from_ns};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Speeds that [`Playback::set_speed`] allows, times real time.
pub const PLAYBACK_SPEEDS: RangeInclusive<f64> = 0.05..=20.0;

/// What can be played.
pub trait Source {
    /// What the run was.
    fn header(&self) -> &Header;

    /// Monotonic times of the first and the last tick, ns.
    fn span_ns(&self) -> (u64, u64);

    /// Every event.
    fn events(&self) -> &[Event];

    /// Every finger at an instant of the monotonic clock: its newest record then, or its first one before that. Fingers
    /// without any record are default.
    fn at_ns(&self, time_ns: u64) -> TickRecord;

    /// Time of the tick of finger 0 that is `ticks` recorded ticks from the newest one at `time_ns`; of the first or last
    /// where there are not so many. `None` without any.
    fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64>;
}

impl<S: Source + ?Sized> Source for Arc<S> {
    fn header(&self) -> &Header {
        (**self).header()
    }

    fn span_ns(&self) -> (u64, u64) {
        (**self).span_ns()
    }

    fn events(&self) -> &[Event] {
        (**self).events()
    }

    fn at_ns(&self, time_ns: u64) -> TickRecord {
        (**self).at_ns(time_ns)
    }

    fn step_ns(&self, time_ns: u64, ticks: i64) -> Option<u64> {
        (**self).step_ns(time_ns, ticks)
    }
}

/// A position in a recording, and how it moves on.
///
/// The instant is a time since the first tick, s. Where ticks are missing the last one before the gap stands.
#[derive(Clone, Debug)]
pub struct Playback<S: Source = Timeline> {
    source: S,
    /// Monotonic times of the first and last tick, ns.
    span_ns: (u64, u64),
    at_s: f64,
    playing: bool,
    speed: f64,
    looping: bool,
    following: bool,
}

impl<S: Source> Playback<S> {
    /// Stands paused at the first tick.
    pub fn new(source: S) -> Self {
        Self {
            span_ns: source.span_ns(),
            source,
            at_s: 0.0,
            playing: false,
            speed: 1.0,
            looping: false,
            following: false,
        }
    }

    /// What is played.
    pub fn source(&self) -> &S {
        &self.source
    }

    /// Length, s.
    pub fn duration_s(&self) -> f64 {
        s_from_ns(self.span_ns.1 - self.span_ns.0)
    }

    /// Present instant, s since the first tick.
    pub fn at_s(&self) -> f64 {
        self.at_s
    }

    /// Whether time moves on.
    pub fn is_playing(&self) -> bool {
        self.playing
    }

    /// Whether the end is reached.
    pub fn is_at_end(&self) -> bool {
        self.at_s >= self.duration_s()
    }

    /// Times real time.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Whether playing goes on from the start at the end.
    pub fn is_looping(&self) -> bool {
        self.looping
    }

    /// Lets time move on; from the start if it stands at the end.
    pub fn play(&mut self) {
        if self.is_at_end() {
            self.at_s = 0.0;
        }
        self.playing = true;
    }

    /// Stops time.
    pub fn pause(&mut self) {
        self.playing = false;
    }

    /// Play or pause, whichever it is not.
    pub fn toggle(&mut self) {
        if self.playing {
            self.pause()
        } else {
            self.play()
        }
    }

    /// Sets the speed, kept within [`PLAYBACK_SPEEDS`]; not a number leaves it as it is.
    pub fn set_speed(&mut self, times_real_time: f64) {
        if !times_real_time.is_nan() {
            self.speed = times_real_time.clamp(*PLAYBACK_SPEEDS.start(), *PLAYBACK_SPEEDS.end());
        }
    }

    /// Whether to go on from the start at the end.
    pub fn set_looping(&mut self, looping: bool) {
        self.looping = looping;
    }

    /// Whether playing pauses at each event.
    pub fn is_following(&self) -> bool {
        self.following
    }

    /// Whether playing pauses at each event that it comes to, so that nothing that happened is played past; playing on leads to
    /// the next. Lost ticks and restarts are events too.
    pub fn set_follow(&mut self, follow: bool) {
        self.following = follow;
    }

    /// Goes to an instant, kept within the recording; not a number leaves it as it is.
    pub fn seek_s(&mut self, at_s: f64) {
        if !at_s.is_nan() {
            self.at_s = at_s.clamp(0.0, self.duration_s());
        }
    }

    /// Lets `dt_s` of real time pass. Returns whether the instant changed, so that the window knows whether to draw.
    #[must_use]
    pub fn advance(&mut self, dt_s: f64) -> bool {
        let step_s = dt_s * self.speed;
        if !self.playing || step_s.is_nan() || step_s <= 0.0 {
            return false;
        }
        let before_s = self.at_s;
        let duration_s = self.duration_s();
        let to_s = before_s + step_s;
        if let Some(event_s) = self.event_within(to_s) {
            self.at_s = event_s;
            self.playing = false;
        } else if to_s <= duration_s {
            self.at_s = to_s;
        } else if self.looping && duration_s > 0.0 {
            self.at_s = to_s % duration_s;
        } else {
            self.at_s = duration_s;
            self.playing = false;
        }
        self.at_s != before_s
    }

    /// Where following, the first event that is come to on the way to `to_s`, over the end and from the start where looping.
    fn event_within(&self, to_s: f64) -> Option<f64> {
        if !self.following {
            return None;
        }
        let now_ns = self.at_ns();
        let places = || self.source.events().iter().map(|e| self.place_of(e));
        let ahead = places().filter(|(ns, _)| *ns > now_ns).map(|(_, s)| s);
        if let Some(next_s) = ahead.min_by(f64::total_cmp) {
            return (next_s <= to_s).then_some(next_s);
        }
        let duration_s = self.duration_s();
        let over = self.looping && duration_s > 0.0 && to_s > duration_s;
        let first_s = places().map(|(_, s)| s).min_by(f64::total_cmp)?;
        (over && first_s <= to_s - duration_s).then_some(first_s)
    }

    /// The instant of an event, on the monotonic clock and in s since the first tick, kept within the recording.
    fn place_of(&self, event: &Event) -> (u64, f64) {
        let ns = event.time_ns.clamp(self.span_ns.0, self.span_ns.1);
        (ns, s_from_ns(ns - self.span_ns.0))
    }

    /// Pauses and goes `ticks` recorded ticks ahead, or back when negative; stops at either end.
    pub fn step(&mut self, ticks: i64) {
        self.pause();
        if let Some(target_ns) = self.source.step_ns(self.at_ns(), ticks) {
            self.at_s = s_from_ns(target_ns.saturating_sub(self.span_ns.0));
        }
    }

    /// Goes to the next event behind the instant; `None`, and stays, when there is none.
    pub fn seek_next_event(&mut self) -> Option<&Event> {
        let now_ns = self.at_ns();
        let mut events = self.source.events().iter();
        self.seek_event(events.position(|e| e.time_ns > now_ns)?)
    }

    /// Goes to the last event before the instant; `None`, and stays, when there is none.
    pub fn seek_previous_event(&mut self) -> Option<&Event> {
        let now_ns = self.at_ns();
        let mut events = self.source.events().iter();
        self.seek_event(events.rposition(|e| e.time_ns < now_ns)?)
    }

    /// Goes to an event by its place in [`Source::events`]; `None`, and stays, when there are not so many.
    pub fn seek_event(&mut self, index: usize) -> Option<&Event> {
        let event = self.source.events().get(index)?;
        self.at_s = self.place_of(event).1;
        Some(event)
    }

    /// Every finger at the present instant, as [`Source::at_ns`].
    pub fn at(&self) -> TickRecord {
        self.source.at_ns(self.at_ns())
    }

    /// The present instant on the recording's monotonic clock, rounded to the nearest nanosecond so that the time of a tick
    /// that went through seconds finds its tick again.
    fn at_ns(&self) -> u64 {
        let since_ns = (self.at_s * NS_PER_S).round() as u64;
        self.span_ns.0.saturating_add(since_ns).min(self.span_ns.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::FingerRecord;
    use crate::session::Recording;
    use crate::session::header::tests::sample;

    /// Two fingers, ticks 100 … 109 at 1 ms from 5 s on, tick 104 missing, an event at ticks 102 and 107.
    fn playback() -> Playback<Arc<Recording>> {
        let finger = |finger: u8| {
            let numbers = (100..110).filter(|n| *n != 104);
            let record = |tick: u64| FingerRecord {
                tick,
                finger,
                time_ns: 5_000_000_000 + (tick - 100) * 1_000_000,
                ..FingerRecord::default()
            };
            numbers.map(record).collect::<Vec<_>>()
        };
        let event = |tick: u64| Event {
            tick,
            time_ns: 5_000_000_000 + (tick - 100) * 1_000_000,
            kind: "mark".into(),
            text: tick.to_string(),
        };
        Playback::new(Arc::new(Recording {
            header: sample(2),
            fingers: vec![finger(0), finger(1)],
            events: vec![event(102), event(107)],
            edits: Vec::new(),
            damage: crate::session::Damage::default(),
        }))
    }

    fn tick(p: &Playback<Arc<Recording>>) -> u64 {
        let view = p.at();
        assert_eq!(view.n_fingers, 2);
        assert_eq!(view.fingers[0].tick, view.fingers[1].tick);
        assert_eq!(view.fingers[1].finger, 1);
        view.fingers[0].tick
    }

    #[test]
    fn it_starts_paused_and_plays_at_its_speed() {
        let mut p = playback();
        assert_eq!(p.duration_s(), 0.009);
        assert!(!p.advance(1.0));
        p.set_speed(0.5);
        p.play();
        assert!(p.advance(0.0041));
        assert_eq!(tick(&p), 102);
        p.pause();
        assert!(!p.advance(1.0));
        assert_eq!(tick(&p), 102);
    }

    #[test]
    fn at_the_end_it_stops_and_play_begins_again() {
        let mut p = playback();
        p.play();
        assert!(p.advance(1.0));
        assert_eq!(
            (tick(&p), p.is_playing(), p.is_at_end()),
            (109, false, true)
        );
        p.play();
        assert_eq!((tick(&p), p.is_playing()), (100, true));
    }

    #[test]
    fn a_loop_goes_on_with_what_is_left_of_the_step() {
        let mut p = playback();
        p.set_looping(true);
        p.play();
        assert!(p.advance(0.009 * 3.0 + 0.0021));
        assert_eq!((tick(&p), p.is_playing()), (102, true));
    }

    #[test]
    fn a_gap_shows_the_tick_before_it() {
        let mut p = playback();
        p.seek_s(0.0045);
        assert_eq!(tick(&p), 103);
    }

    #[test]
    fn steps_visit_every_tick_and_stop_at_the_ends() {
        let mut p = playback();
        p.play();
        let mut seen = vec![tick(&p)];
        for _ in 0..10 {
            p.step(1);
            seen.push(tick(&p));
        }
        assert_eq!(
            seen,
            [100, 101, 102, 103, 105, 106, 107, 108, 109, 109, 109]
        );
        assert!(!p.is_playing());
        p.step(-3);
        assert_eq!(tick(&p), 106);
        p.step(i64::MIN);
        assert_eq!(tick(&p), 100);
    }

    #[test]
    fn events_are_followed_both_ways() {
        let mut p = playback();
        assert_eq!(p.seek_next_event().map(|e| e.tick), Some(102));
        assert_eq!(p.seek_next_event().map(|e| e.tick), Some(107));
        assert_eq!(tick(&p), 107);
        assert_eq!(p.seek_next_event(), None);
        assert_eq!(p.seek_previous_event().map(|e| e.tick), Some(102));
        assert_eq!(p.seek_previous_event(), None);
        assert_eq!(tick(&p), 102);
    }

    #[test]
    fn following_stops_at_each_event_and_goes_on_from_there() {
        let mut p = playback();
        p.set_follow(true);
        p.set_looping(true);
        let mut stops = Vec::new();
        for _ in 0..5 {
            p.play();
            // More than the whole way: what is past an event is not played.
            assert!(p.advance(0.008));
            stops.push((tick(&p), p.is_playing()));
        }
        let t = |tick| (tick, false);
        assert_eq!(stops, [t(102), t(107), t(102), t(107), t(102)]);
        p.set_follow(false);
        p.play();
        assert!(p.advance(0.005));
        assert_eq!((tick(&p), p.is_playing()), (107, true));
        assert_eq!(p.seek_event(0).map(|e| e.tick), Some(102));
        assert_eq!(p.seek_event(9), None);
        assert_eq!(tick(&p), 102);
    }

    #[test]
    fn speeds_and_instants_stay_in_range_whatever_is_asked() {
        let mut p = playback();
        for (asked, got) in [
            (0.0, 0.05),
            (f64::INFINITY, 20.0),
            (2.0, 2.0),
            (f64::NAN, 2.0),
        ] {
            p.set_speed(asked);
            assert_eq!(p.speed(), got);
        }
        for (asked, got) in [(-1.0, 100), (f64::INFINITY, 109), (f64::NAN, 109)] {
            p.seek_s(asked);
            assert_eq!(tick(&p), got);
        }
        p.play();
        assert!(!p.advance(f64::NAN));
        assert!(p.advance(f64::INFINITY));
    }

    #[test]
    fn an_empty_recording_has_nothing_to_show_and_does_not_fail() {
        let mut p = playback();
        let mut empty = Recording::clone(p.source());
        empty.fingers = vec![Vec::new(), Vec::new()];
        empty.events.clear();
        p = Playback::new(Arc::new(empty));
        p.set_looping(true);
        p.play();
        let _ = p.advance(1.0);
        p.step(1);
        assert_eq!(p.seek_next_event(), None);
        assert_eq!(p.at().fingers(), [FingerRecord::default(); 2]);
        assert_eq!(p.duration_s(), 0.0);
    }
}
