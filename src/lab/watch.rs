//! How far an experiment is, and whether it shall go on.

/// Whoever watched wants no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Tells someone what is being done and how far it is, and hears whether to go on.
pub struct Watch<'a> {
    tell: &'a mut dyn FnMut(&str, f64) -> bool,
    from: f64,
    to: f64,
}

impl<'a> Watch<'a> {
    /// `tell` gets what is being done and the share done, 0…1 and never falling, and answers `false` to stop.
    pub fn new(tell: &'a mut dyn FnMut(&str, f64) -> bool) -> Self {
        Self {
            tell,
            from: 0.0,
            to: 1.0,
        }
    }

    /// Tells that `what` is being done and `share`, 0…1, of this part is behind.
    ///
    /// # Errors
    /// [`Stopped`] when there is to be no more.
    pub fn at(&mut self, what: &str, share: f64) -> Result<(), Stopped> {
        let share = self.from + (self.to - self.from) * share.clamp(0.0, 1.0);
        if (self.tell)(what, share) {
            Ok(())
        } else {
            Err(Stopped)
        }
    }

    /// A watch over the part of this one from `from` to `to`, 0…1.
    pub fn part(&mut self, from: f64, to: f64) -> Watch<'_> {
        let span = self.to - self.from;
        Watch {
            tell: &mut *self.tell,
            from: self.from + span * from,
            to: self.from + span * to,
        }
    }
}
