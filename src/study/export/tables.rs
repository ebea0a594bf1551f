//! The columns of the tables.

use crate::servo::FingerRecord;
use crate::session::format::{FIELDS, Role, Value, touch_name};
use crate::session::{Damage, Event};
use crate::study::{About, Analysis, Felt, METRICS, Metrics};
use crate::table::{Cell, Head, Sort};

/// A table: what its folder is called and its columns.
#[derive(Clone, Copy, Debug)]
pub struct Named {
    /// Name.
    pub name: &'static str,
    /// Its columns.
    pub heads: fn() -> Vec<Head>,
}

/// The tables that [`super::gather`] puts into one file each, in the order they are written.
pub static TABLES: [Named; 4] = [
    Named {
        name: "events",
        heads: event_heads,
    },
    Named {
        name: "felt",
        heads: felt_heads,
    },
    Named {
        name: "measures",
        heads: measure_heads,
    },
    Named {
        name: "sessions",
        heads: session_heads,
    },
];

/// The unit that a name ends with.
fn unit_of(name: &str) -> &'static str {
    const ENDINGS: [(&str, &str); 9] = [
        ("_n_per_mm", "N/mm"),
        ("_n_mm", "N·mm"),
        ("_mm_s", "mm/s"),
        ("_mm", "mm"),
        ("_ns", "ns"),
        ("_us", "µs"),
        ("_mj", "mJ"),
        ("_n", "N"),
        ("_s", "s"),
    ];
    let found = ENDINGS.iter().find(|(ending, _)| name.ends_with(ending));
    found.map_or("", |(_, unit)| unit)
}

/// Columns of `ticks`.
pub(super) fn tick_heads() -> Vec<Head> {
    let blank = FingerRecord::default();
    let mut heads = Vec::new();
    for field in FIELDS {
        let role = match field.role {
            Role::Key => "Names the row.",
            Role::Input => "Given to the tick.",
            Role::Outcome => "Follows from the tick's inputs and state.",
            Role::Measured => "Measured beside the run.",
        };
        let about = match field.name {
            "touch" => "FREE, FRICTIONLESS, STICK or SLIP.".to_owned(),
            "limits" => "Sum of the limits that acted: 1 not finite, 2 rated, 4 rise, 8 disabled, 16 late, 32 disconnected, 64 passivity controller, 128 skin rendered softer than it is.".to_owned(),
            _ => role.to_owned(),
        };
        let mut head = |name: String, sort: Sort| {
            let unit = unit_of(field.name);
            heads.push(
                Head::new(name, sort)
                    .required()
                    .unit(unit)
                    .about(about.clone()),
            );
        };
        let name = field.name.to_owned();
        match (field.get)(&blank) {
            Value::Vec3(_) => {
                for axis in ["x", "y", "z"] {
                    head(format!("{name}_{axis}"), Sort::Number);
                }
            }
            Value::F64(_) => head(name, Sort::Number),
            Value::F32(_) => head(name, Sort::Single),
            Value::U64(_) => head(name, Sort::Clock),
            Value::U32(_) => head(name, Sort::Count),
            Value::Bool(_) => head(name, Sort::Yes),
            Value::Touch(_) => head(name, Sort::Text),
        }
    }
    heads
}

/// A row of `ticks` into `cells`. Numbers are as recorded, to the bit.
pub(super) fn tick_cells(record: &FingerRecord, cells: &mut Vec<Cell<'static>>) {
    cells.clear();
    for field in FIELDS {
        match (field.get)(record) {
            Value::Vec3(v) => cells.extend(v.to_array().map(|x| Cell::Number(Some(x)))),
            Value::F64(x) => cells.push(Cell::Number(Some(x))),
            Value::F32(x) => cells.push(Cell::Single(Some(x))),
            Value::U64(n) => cells.push(Cell::natural(n)),
            Value::U32(n) => cells.push(Cell::Count(Some(n.into()))),
            Value::Bool(yes) => cells.push(Cell::Yes(Some(yes))),
            Value::Touch(touch) => cells.push(Cell::text(touch_name(touch))),
        }
    }
}

fn event_heads() -> Vec<Head> {
    let about = "Newest tick when it was reported.";
    vec![
        Head::new("tick", Sort::Clock).about(about),
        Head::new("time_ns", Sort::Clock)
            .unit("ns")
            .about("Monotonic time of that tick."),
        Head::new("kind", Sort::Text).about("What sort of event, one word."),
        Head::new("text", Sort::Text).about("What it says."),
    ]
}

pub(super) fn event_cells(event: &Event) -> Vec<Cell<'_>> {
    vec![
        Cell::natural(event.tick),
        Cell::natural(event.time_ns),
        Cell::text(&event.kind),
        Cell::text(&event.text),
    ]
}

const FINGER: &str = "Finger, from 0; absent: all together.";

fn felt_heads() -> Vec<Head> {
    vec![
        Head::new("finger", Sort::Count).about(FINGER),
        Head::new("site", Sort::Text).about("Name of the site."),
        Head::new("at_mm_x", Sort::Number)
            .unit("mm")
            .about("Where it is on the map plane."),
        Head::new("at_mm_y", Sort::Number)
            .unit("mm")
            .about("Where it is on the map plane."),
        Head::new("presses", Sort::Count).about("Presses that have a slope."),
        Head::new("ticks", Sort::Count).about("Their ticks."),
        Head::new("slope_n_per_mm", Sort::Number)
            .unit("N/mm")
            .about("Mean of their slopes."),
        Head::new("slope_low_n_per_mm", Sort::Number)
            .unit("N/mm")
            .about("Lower end of its 95 % interval."),
        Head::new("slope_high_n_per_mm", Sort::Number)
            .unit("N/mm")
            .about("Upper end of its 95 % interval."),
        Head::new("pooled_n_per_mm", Sort::Number)
            .unit("N/mm")
            .about("One slope through all presses, each about its own means."),
        Head::new("r_squared", Sort::Number)
            .about("Share of the variation within presses that the pooled slope explains."),
    ]
}

/// The rows of `felt`.
pub(super) fn felt_rows(analysis: &Analysis) -> Vec<Vec<Cell<'_>>> {
    fn row(finger: Option<u8>, felt: &Felt) -> Vec<Cell<'_>> {
        let interval = felt.interval_n_per_mm;
        vec![
            Cell::count(finger),
            Cell::text(&felt.site),
            Cell::number(Some(felt.at_mm[0])),
            Cell::number(Some(felt.at_mm[1])),
            Cell::count(Some(felt.presses)),
            Cell::natural(felt.ticks),
            Cell::number(Some(felt.slope_n_per_mm)),
            Cell::number(interval.map(|i| i[0])),
            Cell::number(interval.map(|i| i[1])),
            Cell::number(Some(felt.pooled_n_per_mm)),
            Cell::number(felt.r_squared),
        ]
    }
    let all = analysis.felt.iter().map(|felt| row(None, felt));
    let each = analysis.fingers.iter().flat_map(|f| {
        let finger = Some(f.finger);
        f.felt.iter().map(move |felt| row(finger, felt))
    });
    all.chain(each).collect()
}

fn metric_heads() -> impl Iterator<Item = Head> {
    METRICS
        .iter()
        .map(|m| Head::new(m.key, Sort::Number).unit(m.unit).about(m.about))
}

fn metric_cells<'a>(metrics: &'a Metrics) -> impl Iterator<Item = Cell<'a>> {
    METRICS.iter().map(|m| Cell::number((m.get)(metrics)))
}

fn measure_heads() -> Vec<Head> {
    let first = [
        Head::new("part", Sort::Text).about("whole, search or palpation."),
        Head::new("finger", Sort::Count).about(FINGER),
    ];
    first.into_iter().chain(metric_heads()).collect()
}

/// The rows of `measures`.
pub(super) fn measure_rows(analysis: &Analysis) -> Vec<Vec<Cell<'_>>> {
    let parts = |finger: Option<u8>, whole, search, palpation| {
        [
            ("whole", whole),
            ("search", search),
            ("palpation", palpation),
        ]
        .map(|(part, metrics): (&'static str, &Metrics)| {
            let first = [Cell::text(part), Cell::count(finger)];
            first.into_iter().chain(metric_cells(metrics)).collect()
        })
    };
    let a = analysis;
    let mut rows = parts(None, &a.whole, &a.search, &a.palpation).to_vec();
    for f in &a.fingers {
        rows.extend(parts(Some(f.finger), &f.whole, &f.search, &f.palpation));
    }
    rows
}

type GetAbout = for<'a> fn(&'a About, &'a Damage) -> Cell<'a>;

/// What a session's row says before its measures.
#[rustfmt::skip]
static ABOUT: [(&str, Sort, &str, &str, GetAbout); 21] = [
    ("pseudonym", Sort::Text, "", "Participant as recorded; absent when none.", |a, _| Cell::Text(a.participant.as_deref().map(Into::into))),
    ("file", Sort::Text, "", "Name of the recording.", |a, _| Cell::text(a.file.file_name().unwrap_or_default().to_string_lossy())),
    ("scenario", Sort::Text, "", "Name of the scenario.", |a, _| Cell::text(&a.scenario)),
    ("started_utc", Sort::Text, "", "Start, UTC, ISO 8601.", |a, _| Cell::text(&a.started_utc)),
    ("build", Sort::Text, "", "Program that recorded it.", |a, _| Cell::text(&a.build)),
    ("fingers", Sort::Count, "", "Number of fingers.", |a, _| Cell::natural(a.devices.len() as u64)),
    ("devices", Sort::Text, "", "One name a finger, with semicolons between.", |a, _| Cell::text(a.devices.join("; "))),
    ("rate_hz", Sort::Number, "Hz", "Ticks per second.", |a, _| Cell::number(Some(a.rate_hz))),
    ("ticks", Sort::Count, "", "Ticks of the finger that has most.", |a, _| Cell::natural(a.ticks)),
    ("seconds", Sort::Number, "s", "Their time.", |a, _| Cell::number(Some(a.seconds))),
    ("lost", Sort::Count, "", "Finger ticks that are missing.", |a, _| Cell::natural(a.lost)),
    ("edits", Sort::Count, "", "Edits of the scene while it was felt.", |a, _| Cell::count(Some(a.edits))),
    ("events", Sort::Count, "", "Events such as marks.", |a, _| Cell::count(Some(a.events))),
    ("mesh_hash", Sort::Text, "", "SHA-256 of the surface.", |a, _| Cell::text(&a.mesh_hash)),
    ("mesh_origin", Sort::Text, "", "builtin:back, or the mesh file as the scenario states it.", |a, _| Cell::text(&a.mesh_origin)),
    ("file_bytes", Sort::Count, "bytes", "Size of the recording.", |a, _| Cell::natural(a.bytes)),
    ("damage_unfinished", Sort::Yes, "", "The recording has no proper end.", |_, d| Cell::Yes(Some(d.unfinished))),
    ("damage_chunks", Sort::Count, "", "Chunks that could not be read.", |_, d| Cell::natural(d.chunks)),
    ("damage_bytes", Sort::Count, "bytes", "Bytes that belong to no readable record.", |_, d| Cell::natural(d.bytes)),
    ("damage_messages", Sort::Count, "", "Messages that could not be read.", |_, d| Cell::natural(d.messages)),
    ("damage_first", Sort::Text, "", "The first damage found; empty when none.", |_, d| Cell::text(&d.first)),
];

fn session_heads() -> Vec<Head> {
    let about = ABOUT
        .iter()
        .map(|(name, sort, unit, about, _)| Head::new(*name, *sort).unit(*unit).about(*about));
    let bands = Head::new("force_bands_n", Sort::Text)
        .unit("N")
        .about("Edges of the bands of force, with semicolons between.");
    about.chain([bands]).chain(metric_heads()).collect()
}

/// The row of `sessions`.
pub(super) fn session_cells(analysis: &Analysis) -> Vec<Cell<'_>> {
    let mut cells: Vec<Cell<'_>> = Vec::with_capacity(ABOUT.len() + 1 + METRICS.len());
    for (_, _, _, _, get) in &ABOUT {
        cells.push(get(&analysis.about, &analysis.damage));
    }
    let bands: Vec<String> = (analysis.force_bands_n.iter())
        .map(f64::to_string)
        .collect();
    cells.push(Cell::text(bands.join("; ")));
    cells.extend(metric_cells(&analysis.whole));
    cells
}
