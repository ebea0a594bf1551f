//! What every part of a scene costs when it is absent, when it is there and has nothing to do, and when it is used.

use super::scenes::{PARTS, PLAIN, Part, Tables};
use super::{Case, Counted, Finger, Of, Uncounted, count};
use crate::lab::{Choice, Experiment, LabError, Report, Setup, Table, Value, Verdict, Watch};
use crate::scenario::{self, Item};

/// Bytes and instructions of every part of the core, counted.
pub struct Parts;

/// Triangles of the back, as many as the published model has.
const TRIANGLES: usize = 2962;
/// The ledger may be off by this share of what is counted …
const OFF_SHARE: f64 = 0.02;
/// … and by the small things that it does not list: the keys and nets that fields are made from, headers, names; bytes.
const OFF_BYTES: f64 = 2048.0;
/// Of the recorder it sees the buffers only, not what the file format's own writer keeps.
const RECORDER_SHARE: f64 = 0.10;
/// What a scene may hold more for having named a part and done without: the keys that it states; bytes.
const STATED_BYTES: i64 = 100;
/// Instructions of a tick that may come and go with where things lie in memory.
const WOBBLE: f64 = 4.0;

impl Experiment for Parts {
    fn name(&self) -> &'static str {
        "pruning-parts"
    }

    fn about(&self) -> &'static str {
        "What each part of a scene costs absent, unused and used, in bytes and instructions, and whether the ledger knows"
    }

    fn takes(&self) -> &'static [Choice] {
        &[Choice::Triangles]
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let mut report = Report::default();
        let mut counter = Counter::new(setup);
        report.set("back", format!("{} triangles", counter.triangles));
        report.set(
            "press",
            "5 mm deep, sliding 120 mm, 4 s at 1 kHz, one finger",
        );
        let mut bytes = Table::new(
            "bytes",
            "Bytes on the heap beside the same scene without the part, and the ledger's word",
            &[
                "part",
                "made by",
                "named but left out (bytes)",
                "unused (bytes)",
                "used (bytes)",
                "ledger (bytes)",
                "ledger off (%)",
                "calls to the heap in use",
            ],
        );
        let mut work = Table::new(
            "instructions",
            "Instructions of one tick, frame or record, by one finger",
            &[
                "part",
                "per",
                "idle: without",
                "idle: unused",
                "busy: without",
                "busy: used",
                "busy: left out",
                "time without (µs)",
                "time used (µs)",
            ],
        );
        let mut found = Found::default();
        always_there(&mut counter, watch, &mut found, &mut bytes)?;
        let mut done = 0.0;
        let n = (PARTS.len() + counter.examples().len() + 2) as f64;
        for part in &PARTS {
            let mut watch = watch.part(done / n, (done + 1.0) / n);
            part_rows(
                part,
                &mut counter,
                &mut watch,
                &mut found,
                [&mut bytes, &mut work],
            )?;
            done += 1.0;
        }
        report.tables.push(bytes);
        report.tables.push(work);
        let again = counter.repeat(&mut watch.part(done / n, (done + 1.0) / n))?;
        done += 1.0;
        let table = counter.ledgers(&mut watch.part(done / n, 1.0), &mut found)?;
        report.tables.push(table);
        conclude(&mut report, &counter, &found, again);
        Ok(report)
    }
}

/// What the verdicts are made of.
#[derive(Default)]
struct Found {
    /// Largest difference between a scene that names a part and does without, and one that never heard of it: bytes,
    /// instructions a tick; and how many were looked at.
    left_out: Option<(i64, Option<f64>)>,
    n_left_out: usize,
    /// Farthest that the ledger is off what may be, as a share of that, and of which part.
    ledger: Option<(f64, String)>,
    /// Most calls to the heap in ticks and frames.
    calls: Option<u64>,
    asking: Option<u64>,
    plain: Option<f64>,
}

impl Found {
    fn off(&mut self, of: &str, counted: i64, told: i64, share: f64) {
        let may = share * counted as f64 + OFF_BYTES;
        let off = (counted - told).abs() as f64 / may;
        if self.ledger.as_ref().is_none_or(|(most, _)| off > *most) {
            self.ledger = Some((off, of.to_owned()));
        }
    }
}

/// Surface and search structure, without which there is no scene: counted by building them alone.
fn always_there(
    counter: &mut Counter<'_>,
    watch: &mut Watch<'_>,
    found: &mut Found,
    bytes: &mut Table,
) -> Result<(), LabError> {
    let what = "surface and search";
    watch.at(what, 0.0)?;
    let mut go_on = || watch.at(what, 0.0).is_ok();
    let counts = counter
        .count(PLAIN, false, Of::Tick, Finger::Slides, &mut go_on)?
        .counts;
    for (item, counted) in [
        (Item::Surface, counts.surface),
        (Item::Search, counts.search),
    ] {
        let told = counts.told(item) as i64;
        if let Some(counted) = counted {
            found.off(item.name(), counted, told, OFF_SHARE);
        }
        bytes.push([
            item.name().into(),
            "every scene".into(),
            Value::Empty,
            cell(counted),
            cell(counted),
            cell(counted.map(|_| told)),
            counted.map(|n| 100.0 * (told - n) as f64 / n as f64).into(),
            Value::Empty,
        ]);
    }
    Ok(())
}

fn part_rows(
    part: &Part,
    counter: &mut Counter<'_>,
    watch: &mut Watch<'_>,
    found: &mut Found,
    [bytes, work]: [&mut Table; 2],
) -> Result<(), LabError> {
    let name = part.item.name();
    let drawn = part.of == Of::Frame;
    let (beside, beside_drawn) = part.beside;
    let beside_of = match (part.of, beside_drawn) {
        (Of::Tick, _) | (_, false) => Of::Tick,
        (of, true) => of,
    };
    let busy = Finger::Slides;
    let mut at = |counter: &mut Counter<'_>, share, tables: Tables, drawn, of, finger| {
        watch.at(name, share)?;
        counter.count(tables, drawn, of, finger, &mut || {
            watch.at(name, share).is_ok()
        })
    };
    let without_idle = at(counter, 0.0, beside, beside_drawn, beside_of, part.idle)?;
    let without = at(counter, 0.2, beside, beside_drawn, beside_of, busy)?;
    let unused = at(counter, 0.4, part.with, drawn, part.of, part.idle)?;
    let used = at(counter, 0.6, part.with, drawn, part.of, busy)?;
    let left_out = match part.left_out {
        None => None,
        Some([named, unheard]) => Some((
            at(counter, 0.8, named, false, Of::Tick, busy)?,
            at(counter, 0.9, unheard, false, Of::Tick, busy)?,
        )),
    };

    let absent = |c: &Counted| match part.of {
        // Without it there is no frame and no record.
        of if of != beside_of => c.counts.scene,
        _ => c.counts.held(),
    };
    let before_use = |c: &Counted| Some(c.counts.scene? + c.counts.unused?);
    let minus = |a: Option<i64>, b: Option<i64>| Some(a? - b?);
    let named_bytes = (left_out.as_ref())
        .and_then(|(named, unheard)| minus(named.counts.held(), unheard.counts.held()));
    let idle_bytes = minus(
        before_use(&unused),
        match part.of {
            of if of != beside_of => without_idle.counts.scene,
            _ => before_use(&without_idle),
        },
    );
    let used_bytes = minus(used.counts.held(), absent(&without));
    let told = used.counts.told_in_all() as i64 - without.counts.told_in_all() as i64;
    let off_percent = used_bytes
        .filter(|&n| n != 0)
        .map(|n| 100.0 * (told - n) as f64 / n as f64);
    bytes.push([
        name.into(),
        part.made_by().into(),
        cell(named_bytes),
        cell(idle_bytes),
        cell(used_bytes),
        cell(used_bytes.map(|_| told)),
        off_percent.into(),
        cell(used.counts.use_calls.map(|n| n as i64)),
    ]);
    let each = |c: &Counted| counter.each(c);
    let apart = part.of != beside_of;
    let nothing = |x: Option<f64>| if apart { x.map(|_| 0.0) } else { x };
    work.push([
        name.into(),
        part.of.name().into(),
        nothing(each(&without_idle)).into(),
        each(&unused).into(),
        nothing(each(&without)).into(),
        each(&used).into(),
        left_out.as_ref().and_then(|(named, _)| each(named)).into(),
        if apart { 0.0 } else { without.counts.time_us }.into(),
        used.counts.time_us.into(),
    ]);

    if let Some(counted) = used_bytes {
        let share = if part.item == Item::Recorder {
            RECORDER_SHARE
        } else {
            OFF_SHARE
        };
        found.off(name, counted, told, share);
    }
    if let (Some((named, unheard)), Some(bytes)) = (&left_out, named_bytes) {
        let steps = each(named).zip(each(unheard)).map(|(a, b)| (a - b).abs());
        let (most_bytes, most_steps) = found.left_out.unwrap_or_default();
        let steps = match (most_steps, steps) {
            (Some(a), Some(b)) => Some(f64::max(a, b)),
            (a, b) => a.or(b),
        };
        found.left_out = Some((most_bytes.max(bytes.abs()), steps));
        found.n_left_out += 1;
    }
    if part.of != Of::Record {
        found.calls = found.calls.max(used.counts.use_calls);
    }
    if part.of == Of::Tick {
        found.asking = found.asking.or(without.asking);
        found.plain = found.plain.or(each(&without));
    }
    Ok(())
}

fn cell(n: Option<i64>) -> Value {
    n.map_or(Value::Empty, Value::Integer)
}

/// Counts cases, each once.
struct Counter<'a> {
    setup: &'a Setup,
    triangles: usize,
    /// Why nothing is counted, once it is known.
    refused: Option<String>,
    known: Vec<(Case, Counted)>,
}

impl<'a> Counter<'a> {
    fn new(setup: &'a Setup) -> Self {
        Self {
            setup,
            triangles: setup.triangles.first().copied().unwrap_or(TRIANGLES),
            refused: None,
            known: Vec::new(),
        }
    }

    fn case(&self, tables: Tables, deformed: bool, of: Of, finger: Finger) -> Case {
        let (windows, most_steps) = if self.setup.quick {
            (1, 6_000)
        } else {
            (16, 600_000)
        };
        Case {
            scenario: tables.on_back(self.triangles),
            deformed,
            of,
            finger,
            windows,
            per_window: 1,
            most_steps,
        }
    }

    /// Instructions of one tick, frame or record.
    fn each(&self, counted: &Counted) -> Option<f64> {
        let n = counted.windows.len() as f64;
        (n > 0.0).then(|| counted.windows.iter().sum::<u64>() as f64 / n)
    }

    fn count(
        &mut self,
        tables: Tables,
        deformed: bool,
        of: Of,
        finger: Finger,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Counted, LabError> {
        let case = self.case(tables, deformed, of, finger);
        if let Some((_, counted)) = self.known.iter().find(|(c, _)| *c == case) {
            return Ok(counted.clone());
        }
        let counted = self.count_anew(&case, "once", go_on)?;
        self.known.push((case, counted.clone()));
        Ok(counted)
    }

    /// Counts in a process of its own; where that is not to be had, runs it here and leaves the counts empty.
    fn count_anew(
        &mut self,
        case: &Case,
        time: &str,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Counted, LabError> {
        let key = serde_json::to_string(&(time, case))
            .map_err(|e| LabError::Input(format!("a case cannot be told: {e}")))?;
        let counted = self.setup.shelf.part(&key, || {
            let why = match count(case, go_on) {
                Ok(counted) => return Ok(counted),
                Err(Uncounted::Stopped) => return Err(LabError::Stopped),
                Err(Uncounted::Here(why)) => why,
            };
            let counts = case.run(&mut || ()).map_err(LabError::Input)?;
            Ok(Counted {
                counts: counts.uncounted(why),
                asking: None,
                windows: Vec::new(),
            })
        })?;
        if let Some(why) = &counted.counts.refused {
            self.refused = Some(why.clone());
        }
        Ok(counted)
    }

    /// The plain scene's ticks counted once more: by how many instructions they differ.
    fn repeat(&mut self, watch: &mut Watch<'_>) -> Result<Option<f64>, LabError> {
        let what = "once more";
        watch.at(what, 0.0)?;
        let case = self.case(PLAIN, false, Of::Tick, Finger::Slides);
        let mut go_on = || watch.at(what, 0.0).is_ok();
        let first = self.count(PLAIN, false, Of::Tick, Finger::Slides, &mut go_on)?;
        let second = self.count_anew(&case, "twice", &mut go_on)?;
        let apart = first.windows.iter().zip(&second.windows);
        let apart = apart.map(|(a, b)| a.abs_diff(*b) as f64);
        Ok((!first.windows.is_empty()).then(|| apart.fold(0.0, f64::max)))
    }

    /// Names and texts of the examples that are looked at.
    fn examples(&self) -> Vec<scenario::Example> {
        let all = scenario::examples().iter().copied();
        if self.setup.quick {
            all.filter(|e| e.file == "published.toml").collect()
        } else {
            all.collect()
        }
    }

    /// The ledger of `dorsum scene --drawn` beside the count, for every example.
    fn ledgers(&mut self, watch: &mut Watch<'_>, found: &mut Found) -> Result<Table, LabError> {
        let mut table = Table::new(
            "ledgers",
            "The ledger of each example beside what its scene holds, the skin drawn, after use",
            &[
                "scene",
                "counted (bytes)",
                "ledger (bytes)",
                "ledger off (%)",
            ],
        );
        let examples = self.examples();
        for (i, example) in examples.iter().enumerate() {
            let share = i as f64 / examples.len() as f64;
            watch.at(example.file, share)?;
            let case = Case {
                scenario: example.text.to_owned(),
                deformed: true,
                of: Of::Frame,
                finger: Finger::Slides,
                windows: 0,
                per_window: 0,
                most_steps: 0,
            };
            let mut go_on = || watch.at(example.file, share).is_ok();
            let counted = self.count_anew(&case, "once", &mut go_on)?.counts;
            let told = counted.told_in_all() as i64;
            let held = counted.held();
            if let Some(held) = held {
                found.off(example.file, held, told, OFF_SHARE);
            }
            table.push([
                example.file.into(),
                cell(held),
                cell(Some(told)),
                held.map(|n| 100.0 * (told - n) as f64 / n as f64).into(),
            ]);
        }
        Ok(table)
    }
}

fn conclude(report: &mut Report, counter: &Counter<'_>, found: &Found, again: Option<f64>) {
    const NOT: &str = "not counted here";
    let bytes = found.left_out.map(|(bytes, _)| bytes);
    report.verdicts.push(Verdict::must(
        format!(
            "a part that is named and not needed is never built ({} scenes)",
            found.n_left_out
        ),
        bytes.map_or(NOT.into(), |n| format!("{n} bytes more than unheard of")),
        format!("0 bytes, but for keys as stated: {STATED_BYTES}"),
        bytes.is_none_or(|n| n <= STATED_BYTES),
    ));
    let steps = found.left_out.and_then(|(_, steps)| steps);
    report.verdicts.push(Verdict::must(
        "a tick without a part is the plain scene's tick",
        steps.map_or(NOT.into(), |n| format!("{n:.1} instructions apart")),
        format!("at most {WOBBLE} instructions"),
        steps.is_none_or(|n| n <= WOBBLE),
    ));
    let off = found.ledger.as_ref();
    report.verdicts.push(Verdict::must(
        "the ledger tells what the heap holds",
        off.map_or(NOT.into(), |(off, of)| {
            format!("at worst {:.0} % of what it may be off: {of}", 100.0 * off)
        }),
        format!(
            "{:.0} % and {OFF_BYTES} bytes; the recorder {:.0} %",
            100.0 * OFF_SHARE,
            100.0 * RECORDER_SHARE
        ),
        off.is_none_or(|(off, _)| *off <= 1.0),
    ));
    report.verdicts.push(Verdict::must(
        "ticks and frames in use ask nothing of the heap",
        found.calls.map_or(NOT.into(), |n| format!("{n} calls")),
        "0 calls",
        found.calls.is_none_or(|n| n == 0),
    ));
    report.verdicts.push(Verdict::must(
        "counting again gives the same",
        again.map_or(NOT.into(), |n| format!("{n} instructions apart")),
        format!("at most {WOBBLE} instructions a tick"),
        again.is_none_or(|n| n <= WOBBLE),
    ));
    if let (Some(asking), Some(plain)) = (found.asking, found.plain) {
        report.note(format!(
            "A plain tick in touch takes {plain:.0} instructions. Asking once for each of the six parts that a tick may find \
             absent takes {asking} with the call, counted by itself: such a question is all that an absent part costs."
        ));
    }
    if let Some(why) = &counter.refused {
        report.note(format!("Not counted here: {why}."));
    } else if counter.setup.quick {
        report.note("A quick look counts one tick each, and leaves out what takes more than 6000 instructions.");
    }
    report.note(
        "Bytes are those asked of the allocator. Instructions are steps of a process of its own (ptrace), between a begin and an \
         end whose own steps are taken off; a repeated string instruction counts once per repetition. Idle: the finger is in \
         the air, of the tangential field it presses without pulling.",
    );
    report.note(
        "The ledger leaves out small things: the keys of a fit and the net it finds places in, headers of shared lists, names. \
         Of the recorder it tells the buffers, not what the file format's own writer keeps.",
    );
    report.note(
        "Graphics mesh, surface colour, partition tree, editors and plot history belong to the window: tests/pruning.rs counts \
         them by opening and closing their panels.",
    );
}
