//! Every engine on every awkward surface, at every speed, size and place.

use super::trial::{ENGINES, Engine, Findings, PLACES, SPEEDS_M_PER_S, Trial, closed_path_energy};
use crate::lab::{Experiment, LabError, Report, Setup, Stopwatch, Table, Value, Verdict, Watch};
use crate::surface::torture::{Case, all};

/// Ticks of one trial; fewer where the path is shorter.
const TICKS: usize = 30_000;
const QUICK_TICKS: usize = 2_000;
/// Step at which energy is integrated before steps are halved, mm, and most steps.
const ENERGY_STEP_MM: f64 = 0.1;
/// Energy from nothing over work that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// The torture suite.
pub struct Torture;

impl Experiment for Torture {
    fn name(&self) -> &'static str {
        "contact-torture"
    }

    fn about(&self) -> &'static str {
        "Contact engines on surfaces that break them: pop-throughs, lag, energy, cost per tick"
    }

    fn run(&self, setup: &Setup, watch: &mut Watch<'_>) -> Result<Report, LabError> {
        let most = if setup.quick { QUICK_TICKS } else { TICKS };
        let mut report = Report::default();
        report.set("ticks", format!("at most {most} a trial, 1 ms each"));
        report.set("stiffness", "1 N/mm; friction 0.46 static, 0.44 dynamic");
        let mut by_speed = Table::new(
            "surface-speed",
            "Faults by surface and speed, over all sizes and places; time for the frictionless one in mm",
            &[
                "engine",
                "surface",
                "speed (m/s)",
                "ticks",
                "touched",
                "through",
                "not finite",
                "misplaced",
                "stuck",
                "beyond cone",
                "lag over bound (mm)",
                "created / work",
                "time (µs/tick)",
            ],
        );
        let mut energy = Table::new(
            "closed-path-energy",
            "Energy over the closed frictionless path, steps halved until the force is linear over each",
            &[
                "engine",
                "surface",
                "work (N·mm)",
                "lost in jumps (N·mm)",
                "created (N·mm)",
                "created / work",
            ],
        );
        let cases = all(1);
        let watched = (ENGINES.len() * cases.len()) as f64;
        let mut done = 0.0;
        for engine in ENGINES {
            let mut sum = Sum::default();
            for case in &cases {
                watch.at(&format!("{} on {}", engine.name, case.name), done / watched)?;
                for speed in SPEEDS_M_PER_S {
                    let (found, micros) = over_places(engine, case, speed, most)?;
                    by_speed.push(row(engine, case, speed, &found, micros));
                    sum.add(&found);
                }
                let e = closed_path_energy(case, engine, ENERGY_STEP_MM, most)
                    .map_err(LabError::Input)?;
                let share = e.created / e.work.max(f64::MIN_POSITIVE);
                energy.push([
                    engine.name.into(),
                    case.name.into(),
                    e.work.into(),
                    e.lost.into(),
                    e.created.into(),
                    share.into(),
                ]);
                sum.from_nothing = sum.from_nothing.max(share);
                done += 1.0;
            }
            sum.judge(engine, &mut report);
        }
        report.tables = vec![by_speed, energy];
        report.note(
            "Through: the proxy is where nothing may be that came from outside. Misplaced: it is not the closest point of the \
             free space, where that is convex. Stuck: a triangle that it touches has a closer point. Created: the spring \
             between finger and proxy grew by a motion of the proxy.",
        );
        Ok(report)
    }
}

/// One engine on one surface at one speed, everywhere, with and without friction.
fn over_places(
    engine: &Engine,
    case: &Case,
    speed: f64,
    most: usize,
) -> Result<(Findings, f64), LabError> {
    let mut sum = Findings::default();
    let mut micros = f64::NAN;
    for place in PLACES {
        for friction in [false, true] {
            let trial = Trial::new(case, engine, *place, friction).map_err(LabError::Input)?;
            let path = trial.path(speed, most);
            if micros.is_nan() {
                micros =
                    Stopwatch::new().time(|| trial.run_blind(&path)).1 / path.len().max(1) as f64;
            }
            let found = trial.run(&path);
            sum.ticks += found.ticks;
            sum.touched += found.touched;
            sum.through += found.through;
            sum.not_finite += found.not_finite;
            sum.misplaced += found.misplaced;
            sum.stuck += found.stuck;
            sum.beyond_cone += found.beyond_cone;
            sum.lag_over_mm = sum.lag_over_mm.max(found.lag_over_mm);
            sum.created_n_mm += found.created_n_mm;
            sum.work_n_mm += found.work_n_mm;
            sum.first_fault = sum.first_fault.or(found.first_fault);
        }
    }
    Ok((sum, micros))
}

fn row(engine: &Engine, case: &Case, speed: f64, f: &Findings, micros: f64) -> [Value; 13] {
    [
        engine.name.into(),
        case.name.into(),
        speed.into(),
        f.ticks.into(),
        f.touched.into(),
        f.through.into(),
        f.not_finite.into(),
        f.misplaced.into(),
        f.stuck.into(),
        f.beyond_cone.into(),
        f.lag_over_mm.into(),
        (f.created_n_mm / f.work_n_mm.max(f64::MIN_POSITIVE)).into(),
        micros.into(),
    ]
}

/// What one engine did over all surfaces.
#[derive(Default)]
struct Sum {
    ticks: usize,
    through: usize,
    not_finite: usize,
    misplaced: usize,
    stuck: usize,
    beyond_cone: usize,
    from_nothing: f64,
}

impl Sum {
    fn add(&mut self, f: &Findings) {
        self.ticks += f.ticks;
        self.through += f.through;
        self.not_finite += f.not_finite;
        self.misplaced += f.misplaced;
        self.stuck += f.stuck;
        self.beyond_cone += f.beyond_cone;
        let share = f.created_n_mm / f.work_n_mm.max(f64::MIN_POSITIVE);
        self.from_nothing = self.from_nothing.max(share);
    }

    fn judge(&self, engine: &Engine, report: &mut Report) {
        let mut push = |what: &str, measured: String, goal: String, holds: bool| {
            report.verdicts.push(Verdict {
                required: engine.must_pass,
                ..Verdict::must(format!("{}: {what}", engine.name), measured, goal, holds)
            });
        };
        for (what, count) in [
            ("through the surface", self.through),
            ("not finite", self.not_finite),
            ("elsewhere than the closest point", self.misplaced),
            ("stuck", self.stuck),
            ("pull beyond the friction cone", self.beyond_cone),
        ] {
            let measured = format!("{count} of {} ticks", self.ticks);
            push(what, measured, "none".into(), count == 0);
        }
        push(
            "energy from nothing over work",
            format!("{:.1e}", self.from_nothing),
            format!("at most {ROUNDING:.0e}"),
            self.from_nothing <= ROUNDING,
        );
    }
}
