//! Re-simulation: the recorded inputs through the same tick.

use super::compare::{Difference, FieldDifference, Tally};
use super::header::hexadecimal;
use super::reader::Session;
use super::records::{Strictness, Ticks};
use super::{Damage, Edit, SessionError};
use crate::contact::{Fading, TouchScene};
use crate::device::MAX_FINGERS;
use crate::servo::{Rig, TickInput, TickRecord, tick};
use crate::surface::Surface;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// A recorded tick and what the same inputs give now.
#[derive(Clone, Copy, Debug)]
pub struct Resimulated {
    /// The tick as recorded.
    pub recorded: TickRecord,
    /// The tick as it comes out now. `None` where the run cannot be followed from the tick before: at the start and behind
    /// each gap. There the recorded tick is the state that the next one starts from.
    pub got: Option<TickRecord>,
}

/// Makes the scene of an edit, on the surface of the session; says why where it cannot.
pub type Rebuild<'a> = Box<dyn FnMut(&Edit) -> Result<TouchScene, String> + 'a>;

/// Repeats a session on `rig`, whose scene must be that of the header and whose limits those of the header's devices.
///
/// The first tick sets the state, all others are computed. A gap in the tick numbers starts anew behind it. Ticks felt after
/// an edit of the scene cannot be repeated: see [`resimulate_edited`].
///
/// # Errors
/// The rig has another surface than the session, or the file cannot be opened.
pub fn resimulate(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
) -> Result<Resimulation<'static>, SessionError> {
    let refuse = |_: &Edit| Err("repeat it with the scenarios of its edits".to_owned());
    resimulate_edited(session, rig, Box::new(refuse), strictness)
}

/// As [`resimulate`], through the edits of the scene too: `rebuild` makes the scene of each when the first tick feels it.
///
/// Ticks of an edit whose text is not in the file, or which `rebuild` refuses, are an error where reading is strict; else they
/// are stepped over and counted.
///
/// # Errors
/// As [`resimulate`].
pub fn resimulate_edited<'a>(
    session: &Session,
    mut rig: Rig,
    rebuild: Rebuild<'a>,
    strictness: Strictness,
) -> Result<Resimulation<'a>, SessionError> {
    if session.header().sealed {
        return Err(SessionError::Sealed {
            path: session.path().to_owned(),
        });
    }
    let found = hexadecimal(&rig.scene.surface.hash());
    let recorded = &session.header().mesh.hash;
    if *recorded != found {
        return Err(SessionError::OtherSurface {
            path: session.path().to_owned(),
            recorded: recorded.chars().take(12).collect(),
            found: found.chars().take(12).collect(),
        });
    }
    let first = session.header().edit;
    rig.edit = first;
    let scene = TouchScene::clone(&rig.scene);
    Ok(Resimulation {
        ticks: session.ticks(strictness)?,
        path: session.path().to_owned(),
        strictness,
        scenes: Scenes {
            rebuild,
            texts: BTreeMap::new(),
            made: BTreeMap::from([(first, Ok(scene))]),
        },
        rig,
        dt_s: session.header().dt_s(),
        started: false,
        known: true,
        tally: Passed::default(),
    })
}

/// The scenes of the edits, made when they are needed.
struct Scenes<'a> {
    rebuild: Rebuild<'a>,
    texts: BTreeMap<u32, Edit>,
    made: BTreeMap<u32, Result<TouchScene, String>>,
}

impl Scenes<'_> {
    fn after(&mut self, edit: u32, surface: &Arc<Surface>) -> Result<&TouchScene, String> {
        let Self {
            rebuild,
            texts,
            made,
        } = self;
        let made = made.entry(edit).or_insert_with(|| {
            let text = texts.get(&edit);
            let text = text.ok_or("the file does not hold what was edited")?;
            let scene = rebuild(text)?;
            let same =
                Arc::ptr_eq(&scene.surface, surface) || scene.surface.hash() == surface.hash();
            same.then_some(scene)
                .ok_or_else(|| "its scenario has another surface".to_owned())
        });
        made.as_ref().map_err(Clone::clone)
    }

    /// Forgets what ticks from `edit` on do not need: they feel it and the one before.
    fn forget_before(&mut self, edit: u32) {
        let oldest = edit.saturating_sub(1);
        self.texts.retain(|n, _| *n >= oldest);
        self.made.retain(|n, _| *n >= oldest);
    }
}

/// What a repetition went past so far.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Passed {
    /// Gaps in the tick numbers: lost ticks or a servo started anew.
    pub gaps: u64,
    /// Ticks missing in them.
    pub missing: u64,
    /// Edits of the scene that were felt.
    pub edits: u64,
    /// Ticks that could not be repeated since the scene they were felt in is not to be had.
    pub unrepeated: u64,
    /// Why not: of the first of them, in words; empty where there is none.
    pub first_unrepeated: String,
}

/// Iterates over the ticks of a session, each with its repetition.
pub struct Resimulation<'a> {
    ticks: Ticks,
    path: PathBuf,
    strictness: Strictness,
    scenes: Scenes<'a>,
    rig: Rig,
    dt_s: f64,
    started: bool,
    /// The scene of the tick before was to be had.
    known: bool,
    tally: Passed,
}

impl Resimulation<'_> {
    /// What it went past so far.
    pub fn passed(&self) -> &Passed {
        &self.tally
    }

    /// What a lenient reading stepped over so far.
    pub fn damage(&self) -> &Damage {
        self.ticks.damage()
    }

    /// How much of the file is done, 0 to 1.
    pub fn progress(&self) -> f64 {
        self.ticks.progress()
    }

    /// Brings the rig to where `recorded` leaves off.
    fn resume(&mut self, recorded: &TickRecord, edit: u32, fade: f64) -> Result<(), String> {
        if edit != self.rig.edit || fade < 1.0 || self.rig.is_fading() || !self.known {
            let surface = Arc::clone(&self.rig.scene.surface);
            let mut scene = self.scenes.after(edit, &surface)?.clone();
            if fade < 1.0 {
                let before = edit.checked_sub(1).ok_or("there is none before it")?;
                let before = self.scenes.after(before, &surface).map_err(|reason| {
                    format!("while edit {before} was still felt, of which {reason}")
                })?;
                scene.fading = Some(Fading {
                    from: before.stiffness.clone(),
                    from_drag: before.drag.clone(),
                    share: fade,
                });
            }
            *self.rig.scene = scene;
        }
        self.rig.resume_from(recorded);
        Ok(())
    }

    /// Does the tick again, or takes over its state where it does not follow.
    fn repeat(&mut self, recorded: &TickRecord) -> Result<Option<TickRecord>, String> {
        let first = &recorded.fingers[0];
        let (number, edit, fade) = (first.tick, first.edit, first.fade);
        let follows = self.started && number == self.rig.next_tick;
        if self.started && !follows {
            self.tally.gaps += 1;
            self.tally.missing += number.saturating_sub(self.rig.next_tick);
        }
        if !(follows && self.known) {
            return self.resume(recorded, edit, fade).map(|()| None);
        }
        if edit != self.rig.edit {
            let scene = self.scenes.after(edit, &self.rig.scene.surface)?.clone();
            drop(self.rig.edit_scene(edit, Box::new(scene)));
        }
        Ok(Some(tick(&mut self.rig, &input_of(recorded), self.dt_s)))
    }
}

impl Iterator for Resimulation<'_> {
    type Item = Result<Resimulated, SessionError>;

    fn next(&mut self) -> Option<Self::Item> {
        let recorded = match self.ticks.next()? {
            Ok(recorded) => recorded,
            Err(e) => return Some(Err(e)),
        };
        for edit in self.ticks.take_edits() {
            self.scenes.texts.insert(edit.number, edit);
        }
        let (number, edit) = (recorded.fingers[0].tick, recorded.fingers[0].edit);
        self.tally.edits += u64::from(self.started && edit != self.rig.edit);
        let outcome = self.repeat(&recorded);
        self.started = true;
        self.known = outcome.is_ok();
        (self.rig.edit, self.rig.next_tick) = (edit, number.saturating_add(1));
        self.scenes.forget_before(edit);
        let got = match outcome {
            Ok(got) => got,
            Err(reason) => {
                let error = SessionError::Edit {
                    path: self.path.clone(),
                    tick: number,
                    edit,
                    reason,
                };
                if self.strictness == Strictness::Strict {
                    return Some(Err(error));
                }
                if self.tally.unrepeated == 0 {
                    self.tally.first_unrepeated = error.to_string();
                }
                self.tally.unrepeated += 1;
                None
            }
        };
        Some(Ok(Resimulated { recorded, got }))
    }
}

/// The inputs of a recorded tick, but for the edit of the scene, which is the rig's.
pub fn input_of(recorded: &TickRecord) -> TickInput {
    let mut input = TickInput {
        n_fingers: recorded.n_fingers.min(MAX_FINGERS),
        ..TickInput::default()
    };
    for (i, record) in recorded.fingers().iter().enumerate().take(MAX_FINGERS) {
        input.readings[i] = record.reading;
        input.place_anew[i] = record.placed_anew;
        input.late = record.late;
        input.force_enabled = record.force_enabled;
    }
    input
}

/// What became of repeating a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckReport {
    /// Ticks in the session.
    pub ticks: u64,
    /// Ticks computed and compared: all but the first and those behind gaps.
    pub compared: u64,
    /// Number of fingers.
    pub fingers: usize,
    /// What the repetition went past: gaps, edits, ticks whose scene is not to be had.
    #[serde(flatten)]
    pub passed: Passed,
    /// Where recording and repetition part first; `None` when they are equal bit for bit.
    pub first_difference: Option<Difference>,
    /// How far apart they are, for each field that differs.
    pub differences: Vec<FieldDifference>,
    /// What a lenient reading stepped over.
    pub damage: Damage,
}

impl CheckReport {
    /// Whether every compared tick came out equal, bit for bit, and none had to be left out for want of its scene.
    pub fn is_bit_exact(&self) -> bool {
        self.first_difference.is_none() && self.passed.unrepeated == 0
    }
}

/// Repeats a session and compares every outcome bit for bit.
///
/// After a difference the repetition goes on from its own state, so that the report tells how far the runs drift apart.
///
/// # Errors
/// As [`resimulate`], and what reading finds.
pub fn check(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
) -> Result<CheckReport, SessionError> {
    check_with(session, rig, strictness, |_, _| ())
}

/// As [`check`]; `each` sees every tick and how much of the file is done, 0 to 1.
///
/// # Errors
/// As [`check`].
pub fn check_with(
    session: &Session,
    rig: Rig,
    strictness: Strictness,
    each: impl FnMut(&Resimulated, f64),
) -> Result<CheckReport, SessionError> {
    compare(resimulate(session, rig, strictness)?, session, each)
}

/// As [`check_with`], through the edits of the scene too: see [`resimulate_edited`].
///
/// # Errors
/// As [`check`].
pub fn check_edited(
    session: &Session,
    rig: Rig,
    rebuild: Rebuild<'_>,
    strictness: Strictness,
    each: impl FnMut(&Resimulated, f64),
) -> Result<CheckReport, SessionError> {
    compare(
        resimulate_edited(session, rig, rebuild, strictness)?,
        session,
        each,
    )
}

fn compare(
    mut resimulation: Resimulation<'_>,
    session: &Session,
    mut each: impl FnMut(&Resimulated, f64),
) -> Result<CheckReport, SessionError> {
    let mut tally = Tally::default();
    let (mut ticks, mut compared) = (0, 0);
    while let Some(pair) = resimulation.next() {
        let pair = pair?;
        ticks += 1;
        if let Some(got) = &pair.got {
            compared += 1;
            tally.add(&pair.recorded, got);
        }
        each(&pair, resimulation.progress());
    }
    let differences = tally.fields();
    Ok(CheckReport {
        ticks,
        compared,
        fingers: session.header().n_fingers(),
        passed: resimulation.passed().clone(),
        first_difference: tally.first,
        differences,
        damage: resimulation.damage().clone(),
    })
}
