//! Undo and redo of a small value: one step per edit, one per drag however long.

use std::collections::VecDeque;

/// Steps kept; older ones are forgotten.
const DEPTH: usize = 200;

/// A value with its past and its undone future.
#[derive(Clone, Debug, PartialEq)]
pub struct History<T> {
    now: T,
    /// Oldest first: the value before a step, and what the step did.
    past: VecDeque<(T, &'static str)>,
    /// The value after a step that was undone, next one last.
    future: Vec<(T, &'static str)>,
    /// The value before the drag that is under way.
    held: Option<(T, &'static str)>,
}

impl<T: Clone + PartialEq> History<T> {
    /// A value without a past.
    pub fn new(now: T) -> Self {
        Self {
            now,
            past: VecDeque::new(),
            future: Vec::new(),
            held: None,
        }
    }

    /// The value.
    pub fn now(&self) -> &T {
        &self.now
    }

    /// Sets it in one step that did `what`; equal values are no step. Within a drag it belongs to that drag.
    pub fn set(&mut self, what: &'static str, value: T) {
        if value == self.now {
            return;
        }
        let before = std::mem::replace(&mut self.now, value);
        if self.held.is_none() {
            self.push(before, what);
        }
    }

    /// A drag begins: whatever is set until [`Self::release`] is one step. A drag that is under way goes on.
    pub fn hold(&mut self, what: &'static str) {
        if self.held.is_none() {
            self.held = Some((self.now.clone(), what));
        }
    }

    /// The drag ends; no step when it came back to where it began.
    pub fn release(&mut self) {
        if let Some((before, what)) = self.held.take()
            && before != self.now
        {
            self.push(before, what);
        }
    }

    /// Whether a drag is under way.
    pub fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// What undoing would undo.
    pub fn undoes(&self) -> Option<&'static str> {
        self.past.back().map(|(_, what)| *what)
    }

    /// What redoing would redo.
    pub fn redoes(&self) -> Option<&'static str> {
        self.future.last().map(|(_, what)| *what)
    }

    /// Takes the last step back; a drag under way ends first. True when there was one.
    pub fn undo(&mut self) -> bool {
        self.release();
        let Some((before, what)) = self.past.pop_back() else {
            return false;
        };
        let after = std::mem::replace(&mut self.now, before);
        self.future.push((after, what));
        true
    }

    /// Takes the last undone step again. True when there was one.
    pub fn redo(&mut self) -> bool {
        self.release();
        let Some((after, what)) = self.future.pop() else {
            return false;
        };
        let before = std::mem::replace(&mut self.now, after);
        self.past.push_back((before, what));
        true
    }

    fn push(&mut self, before: T, what: &'static str) {
        if self.past.len() == DEPTH {
            self.past.pop_front();
        }
        self.past.push_back((before, what));
        self.future.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[derive(Clone, Debug)]
    enum Do {
        Set(u8),
        Hold,
        Release,
        Undo,
        Redo,
    }

    fn doing() -> impl Strategy<Value = Do> {
        prop_oneof![
            4 => (0..6u8).prop_map(Do::Set),
            1 => Just(Do::Hold),
            1 => Just(Do::Release),
            2 => Just(Do::Undo),
            2 => Just(Do::Redo),
        ]
    }

    fn after(steps: &[Do]) -> History<u8> {
        let mut h = History::new(0);
        for step in steps {
            match step {
                Do::Set(v) => h.set("set", *v),
                Do::Hold => h.hold("drag"),
                Do::Release => h.release(),
                Do::Undo => {
                    h.undo();
                }
                Do::Redo => {
                    h.redo();
                }
            }
        }
        h.release();
        h
    }

    proptest! {
        #[test]
        fn undo_after_a_step_is_as_if_it_had_not_been_done(steps in prop::collection::vec(doing(), 0..60), v in 0..6u8) {
            let before = after(&steps);
            prop_assume!(v != *before.now());
            let mut h = before.clone();
            h.set("set", v);
            prop_assert_eq!(*h.now(), v);
            prop_assert!(h.undo());
            prop_assert_eq!(h.now(), before.now());
            prop_assert!(h.redo());
            prop_assert_eq!(*h.now(), v);
        }

        #[test]
        fn redo_after_undo_changes_nothing_and_undo_after_redo_neither(steps in prop::collection::vec(doing(), 0..60)) {
            let h = after(&steps);
            let mut there = h.clone();
            if there.undo() {
                prop_assert!(there.redo());
                prop_assert_eq!(&there, &h);
            }
            let mut there = h.clone();
            if there.redo() {
                prop_assert!(there.undo());
                prop_assert_eq!(&there, &h);
            }
        }

        #[test]
        fn all_the_way_back_and_forth_meets_every_value_again(values in prop::collection::vec(0..6u8, 0..60)) {
            let mut h = History::new(0);
            let mut seen = vec![0];
            for v in values {
                h.set("set", v);
                if seen.last() != Some(&v) {
                    seen.push(v);
                }
            }
            for v in seen.iter().rev().skip(1) {
                prop_assert!(h.undo());
                prop_assert_eq!(h.now(), v);
            }
            prop_assert!(!h.undo());
            for v in seen.iter().skip(1) {
                prop_assert!(h.redo());
                prop_assert_eq!(h.now(), v);
            }
            prop_assert!(!h.redo());
        }
    }

    #[test]
    fn a_drag_is_one_step_and_one_that_comes_back_is_none() {
        let mut h = History::new(0);
        h.hold("drag");
        for v in 1..50 {
            h.set("set", v);
        }
        h.release();
        assert_eq!(h.undoes(), Some("drag"));
        assert!(h.undo());
        assert_eq!(*h.now(), 0);
        assert!(!h.undo());
        h.hold("drag");
        h.set("set", 7);
        h.set("set", 0);
        h.release();
        assert_eq!(h.undoes(), None);
        assert_eq!(
            h.redoes(),
            Some("drag"),
            "nothing was done, so nothing is lost"
        );
    }

    #[test]
    fn a_new_step_forgets_what_was_undone_and_the_past_is_bounded() {
        let mut h = History::new(0);
        for v in 1..1000 {
            h.set("set", v);
        }
        let mut undone = 0;
        while h.undo() {
            undone += 1;
        }
        assert_eq!(undone, DEPTH);
        h.set("set", -1);
        assert!(!h.redo());
    }
}
