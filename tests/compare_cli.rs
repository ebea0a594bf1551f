//! `dorsum compare`: recordings whose differences are known, groups against a computation of its own, the page, bad input.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::geom::Vec3;
use dorsum::scenario::{self, Scenario, Use};
use dorsum::session::{Entry, IfExists, Session, SessionWriter, Strictness};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, OnceLock};

fn dorsum(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_dorsum"));
    command.args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = dorsum(&[&["compare", "--json"], arguments].concat());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{told}");
    assert_eq!(told, "", "--json says nothing beside its document");
    // Refuses anything behind the document.
    serde_json::from_slice(&output.stdout).unwrap()
}

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("{path} is no number"))
}

/// A place near the skin of the first example, beside a vertex: on one, rounding tells which triangle is underfoot.
fn place() -> Vec3 {
    static PLACE: OnceLock<Vec3> = OnceLock::new();
    *PLACE.get_or_init(|| {
        let example = scenario::default_example();
        let scenario = Scenario::parse(example.text, example.file, None).unwrap();
        let built = scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true);
        let wanted = Vec3::new(40.0, 250.0, 0.0);
        let far = |p: &&Vec3| (p.x - wanted.x).hypot(p.y - wanted.y);
        let scene = built.unwrap();
        let positions = scene.surface.positions().iter();
        let nearest = positions.min_by(|a, b| far(a).total_cmp(&far(b)));
        *nearest.unwrap() + Vec3::new(1.3, 0.7, 0.0)
    })
}

/// Three presses of a second each, after `wait_s`: `slow` times as long, `deep_mm` deep. Recorded by the program.
fn recorded(folder: &Path, name: &str, wait_s: f64, slow: f64, deep_mm: f64) -> PathBuf {
    let at = place();
    let end_s = wait_s + 3.0 * slow + 0.4;
    let mut rows = String::from("t,x,y,z\n");
    for i in 0..=(end_s * 1000.0) as u32 {
        let t = f64::from(i) / 1000.0;
        let phase = ((t - wait_s) / slow).clamp(0.0, 3.0);
        // The second press is half as deep as the others.
        let share = if (1.0..2.0).contains(&phase) {
            0.5
        } else {
            1.0
        };
        let down = (std::f64::consts::PI * phase).sin().powi(2);
        let z = at.z + 4.0 - (4.0 + deep_mm * share) * down;
        rows += &format!("{t},{},{},{z}\n", at.x, at.y);
    }
    let path = folder.join(format!("{name}.csv"));
    std::fs::write(&path, rows).unwrap();
    let out = folder.join(format!("{name}.mcap"));
    let run = dorsum(&[
        "run",
        "FIRST.toml",
        "--path",
        text(&path),
        "--fast",
        "--record",
        text(&out),
    ]);
    let told = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{told}");
    out
}

#[test]
fn a_shift_is_found_by_an_event_and_a_slower_motion_by_warping() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let first = recorded(at, "first", 0.5, 1.0, 6.0);
    let late = recorded(at, "late", 0.75, 1.0, 6.0);
    let slow = recorded(at, "slow", 0.5, 1.3, 6.0);

    let same = json(&[text(&first), text(&first)]);
    let pairs = number(&same, "/comparisons/0/pairs");
    assert!(pairs > 3800.0 && number(&same, "/comparisons/0/identical") == pairs);
    for quantity in ["position_mm", "force_n", "depth_mm"] {
        assert_eq!(
            number(&same, &format!("/comparisons/0/{quantity}/max")),
            0.0
        );
    }

    // By time they are apart; so that the first touch falls together they are one.
    let by_time = json(&[text(&first), text(&late)]);
    assert!(number(&by_time, "/comparisons/0/force_n/rms") > 0.5);
    assert_eq!(number(&by_time, "/comparisons/0/shift_s"), 0.0);
    for event in ["contact", "press:1", "press:3"] {
        let aligned = ["--align", "event", "--event", event];
        let by_event = json(&[&[text(&first), text(&late)], &aligned[..]].concat());
        let shift_s = number(&by_event, "/comparisons/0/shift_s");
        assert!((shift_s - 0.25).abs() < 1e-9, "{event}: {shift_s}");
        for quantity in ["position_mm", "force_n", "depth_mm"] {
            let max = number(&by_event, &format!("/comparisons/0/{quantity}/max"));
            assert!(max < 1e-6, "{event}: {quantity} is off by {max}");
        }
    }

    // The slower one takes 1.3 times as long for the same: so do the times that go together.
    let plain = json(&[text(&first), text(&slow)]);
    let warped = json(&[text(&first), text(&slow), "--align", "dtw"]);
    let rms = |of: &Value| number(of, "/comparisons/0/force_n/rms");
    assert!(
        rms(&warped) < 0.15 * rms(&plain),
        "{} {}",
        rms(&warped),
        rms(&plain)
    );
    let together = warped.pointer("/comparisons/0/warp_s").unwrap();
    let mut seen = 0;
    for pair in together.as_array().unwrap() {
        let (a, b) = (number(pair, "/0"), number(pair, "/1"));
        // While it rests before, between and behind, any time goes with any.
        if (0.8..3.2).contains(&a) {
            let expected = 0.5 + 1.3 * (a - 0.5);
            assert!(
                (b - expected).abs() < 0.12,
                "{a} s goes with {b} s, not {expected} s"
            );
            seen += 1;
        }
    }
    assert!(seen > 100);
}

#[test]
fn many_at_once_come_in_their_order_and_are_each_what_they_are_alone() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (0..5)
        .map(|i| {
            let name = format!("r{i}");
            recorded(folder.path(), &name, 0.3, 0.4, 3.0 + f64::from(i))
        })
        .collect();
    let paths: Vec<&str> = files.iter().map(|f| text(f)).collect();
    let all = json(&paths);
    for i in 1..5 {
        let alone = json(&[paths[0], paths[i]]);
        assert_eq!(all["comparisons"][i - 1], alone["comparisons"][0]);
        assert_eq!(all["sessions"][i], alone["sessions"][1]);
    }
    // Deeper and deeper, by a millimetre each.
    for i in 1..5 {
        let of = |k: usize| number(&all, &format!("/sessions/{k}/whole/peak_depth_mm"));
        assert!(
            (of(i) - of(i - 1) - 1.0).abs() < 0.3,
            "{} {}",
            of(i),
            of(i - 1)
        );
    }
}

/// Area below a curve by Simpson's rule.
fn area(of: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const N: u32 = 20_000;
    let step = (to - from) / f64::from(N);
    let weigh = |i: u32| match i {
        0 | N => 1.0,
        i if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = (0..=N)
        .map(|i| weigh(i) * of(from + f64::from(i) * step))
        .sum();
    sum * step / 3.0
}

/// Where a rising function is `wanted`.
fn solve(of: impl Fn(f64) -> f64, wanted: f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match of(middle) < wanted {
            true => low = middle,
            false => high = middle,
        }
    }
    0.5 * (low + high)
}

/// Probability that a noncentral t is at most `t`: over the chi variable s = √(χ² ⁄ df), Φ(t s − δ).
fn noncentral(t: f64, df: f64, delta: f64) -> f64 {
    let log_scale = 0.5 * df * (0.5 * df).ln() + 2_f64.ln() - libm::lgamma(0.5 * df);
    let density = |s: f64| match s {
        0.0 => 0.0,
        s => (log_scale + (df - 1.0) * s.ln() - 0.5 * df * s * s).exp(),
    };
    let below = |z: f64| 0.5 * libm::erfc(-z / 2_f64.sqrt());
    area(|s| density(s) * below(t * s - delta), 0.0, 6.0)
}

#[test]
fn groups_of_a_table_have_the_effect_and_the_intervals_of_another_computation() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let deep = [[4.0, 4.6, 5.5], [6.0, 7.4, 7.9]];
    let mut table = String::from("group,file\n");
    let mut files = Vec::new();
    for (group, deep) in ["novice", "expert"].iter().zip(deep) {
        for (i, deep_mm) in deep.into_iter().enumerate() {
            let name = format!("{group}{i}");
            files.push(recorded(at, &name, 0.2, 0.4, deep_mm));
            table += &format!("{group},{name}.mcap\n");
        }
    }
    let groups = at.join("groups.csv");
    std::fs::write(&groups, table).unwrap();
    let mut arguments: Vec<&str> = files.iter().map(|f| text(f)).collect();
    arguments.extend(["--groups", text(&groups)]);
    let told = json(&arguments);

    let value = |i: usize| number(&told, &format!("/sessions/{i}/whole/peak_force_n"));
    let (a, b): (Vec<f64>, Vec<f64>) = ((0..3).map(value).collect(), (3..6).map(value).collect());
    let mean = |v: &[f64]| v.iter().sum::<f64>() / 3.0;
    let variance = |v: &[f64]| v.iter().map(|x| (x - mean(v)).powi(2)).sum::<f64>() / 2.0;
    let (va, vb) = (variance(&a) / 3.0, variance(&b) / 3.0);
    let difference = mean(&b) - mean(&a);
    assert!(difference > 0.5);
    // Welch: degrees of freedom by Satterthwaite, the quantile by integration.
    let df = (va + vb).powi(2) / (va * va / 2.0 + vb * vb / 2.0);
    let half = solve(|t| noncentral(t, df, 0.0), 0.975, 0.0, 100.0) * (va + vb).sqrt();
    // Hedges: for 4 degrees of freedom the factor of his table is 0.7979.
    let d = difference / (0.5 * (variance(&a) + variance(&b))).sqrt();
    let factor = 0.797_884_56;
    let scale = 1.5_f64.sqrt();
    // The noncentrality falls as the probability rises.
    let end = |p: f64| -solve(|minus| noncentral(d * scale, 4.0, -minus), p, -40.0, 40.0);
    let expected = [
        ("difference", difference),
        ("difference_interval/0", difference - half),
        ("difference_interval/1", difference + half),
        ("df", df),
        ("g", factor * d),
        ("g_interval/0", factor * end(0.975) / scale),
        ("g_interval/1", factor * end(0.025) / scale),
    ];
    assert_eq!(
        told["groups"][0]["names"],
        serde_json::json!(["novice", "expert"])
    );
    let measures = told["groups"][0]["measures"].as_array().unwrap();
    let force = measures
        .iter()
        .find(|m| m["key"] == "peak_force_n")
        .unwrap();
    for (what, expected) in expected {
        let found = number(force, &format!("/difference/{what}"));
        let close = (found - expected).abs() < 1e-4 * expected.abs().max(1.0);
        assert!(
            close,
            "{what}: {found}, and by another computation {expected}"
        );
    }
}

/// What is wrong with the nesting of a page's elements.
fn fault_of(page: &str) -> Option<String> {
    const VOID: [&str; 3] = ["meta", "br", "hr"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        // A bracket inside of quotes ends nothing.
        let mut quote = None;
        let end = rest.char_indices().find(|&(_, c)| {
            match (quote, c) {
                (None, '"' | '\'') => quote = Some(c),
                (Some(q), c) if q == c => quote = None,
                _ => {}
            }
            quote.is_none() && c == '>'
        });
        let Some((end, _)) = end else {
            return Some("a tag has no end".to_owned());
        };
        let tag = &rest[..end];
        rest = &rest[end + 1..];
        let name = |t: &'_ str| t.split([' ', '\n', '/']).next().unwrap_or_default().len();
        if tag.starts_with('!') {
            continue;
        }
        if let Some(closed) = tag.strip_prefix('/') {
            match open.pop() {
                Some(last) if last == closed => {}
                last => return Some(format!("</{closed}> closes {last:?}")),
            }
        } else if !tag.ends_with('/') && !VOID.contains(&&tag[..name(tag)]) {
            open.push(&tag[..name(tag)]);
        }
    }
    open.last().map(|last| format!("<{last}> is not closed"))
}

#[test]
fn the_page_needs_nothing_beside_itself_and_is_well_formed() {
    assert_eq!(
        fault_of("<!DOCTYPE html><p title=\"a > b\">x<br></p>"),
        None
    );
    assert!(fault_of("<p><b></p></b>").is_some() && fault_of("<p>").is_some());
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // What people write is text on the page, and no element of it.
    let files = [
        recorded(at, "<b>one & only", 0.3, 1.0, 5.0),
        recorded(at, "two", 0.5, 1.0, 7.0),
        recorded(at, "three", 0.4, 1.0, 6.0),
        recorded(at, "four", 0.4, 1.0, 8.0),
    ];
    let paths: Vec<&str> = files.iter().map(|f| text(f)).collect();
    let page = at.join("page.html");
    let plain = [&paths[..], &["--align", "event"]].concat();
    let in_groups = at.join("groups.csv");
    std::fs::write(
        &in_groups,
        "file,group\n<b>one & only.mcap,light\ntwo.mcap,light\nthree.mcap,firm\nfour.mcap,firm\n",
    )
    .unwrap();
    let by_table = [&paths[..], &["--groups", text(&in_groups)]].concat();
    // Curves over each other, differences three times, four maps; with groups the maps.
    for (arguments, least_figures) in [(plain, 1 + 3 + 4), (by_table, 4)] {
        let told = json(&[&arguments[..], &["--report", text(&page)]].concat());
        assert_eq!(told["written"][0], text(&page));
        let html = std::fs::read_to_string(&page).unwrap();
        assert_eq!(fault_of(&html), None);
        let figures = html.matches("<svg").count();
        assert!(figures >= least_figures, "{figures} figures");
        for loads in [
            "<script", "<link", "<img", "<iframe", "@import", "url(", "src=", "href=",
        ] {
            assert!(!html.contains(loads), "{loads}");
        }
        let names_only = html.replace("http://www.w3.org/2000/svg", "");
        assert!(!names_only.contains("http:") && !names_only.contains("https:"));
        assert!(html.contains("&lt;b&gt;one &amp; only") && !html.contains("<b>one"));
        // Bands of force tell their bounds.
        assert!(html.contains("Force 0.5–2 N (s)") && !html.contains("Force band"));
    }
    let left = std::fs::read_dir(at).unwrap().flatten();
    let partial = left.filter(|e| e.file_name().to_string_lossy().starts_with(".partial"));
    assert_eq!(partial.count(), 0);
}

/// A copy that says that its trial was not answered.
fn sealed(from: &Path, to: &Path) {
    let session = Session::open(from).unwrap();
    let mut header = session.header().clone();
    header.sealed = true;
    let mut writer = SessionWriter::create(to, &header, IfExists::Refuse).unwrap();
    for entry in session.entries(Strictness::Strict).unwrap() {
        if let Entry::Tick(record) = entry.unwrap() {
            writer.write(&record).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn bad_input_is_one_line_that_names_it_and_exit_code_2() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let good = recorded(at, "good", 0.2, 0.4, 5.0);
    let other = recorded(at, "other", 0.2, 0.4, 6.0);
    let (good, other) = (text(&good), text(&other));
    let file = |name: &str, content: &str| {
        let path = at.join(name);
        std::fs::write(&path, content).unwrap();
        text(&path).to_owned()
    };
    let hidden = at.join("hidden.mcap");
    sealed(Path::new(good), &hidden);
    let hidden = text(&hidden);
    let no_session = file("no.mcap", "no session");
    let no_column = file("no_column.csv", "file,party\ngood.mcap,a\n");
    let names_none = file("names_none.csv", "file,group\nelsewhere.mcap,a\n");
    let one_group = file("one_group.csv", "file,group\ngood.mcap,a\nother.mcap,a\n");
    let nowhere = text(&at.join("nowhere/page.html")).to_owned();
    let missing = text(&at.join("missing.mcap")).to_owned();
    let cases: [(&[&str], &[&str]); 15] = [
        (&[good, &missing], &["missing.mcap"]),
        (&[good, &no_session], &["no.mcap", "not an MCAP file"]),
        (&[good, hidden], &["hidden.mcap", "sealed"]),
        (&[hidden, good], &["hidden.mcap", "sealed"]),
        (
            &[good, other, "--finger", "1"],
            &["finger 1", "there are 1"],
        ),
        (&[good, other, "--finger", "9"], &["9"]),
        (&[good, other, "--event", "contact"], &["--align event"]),
        (
            &[good, other, "--align", "event", "--event", "mark:0"],
            &["mark:0", "from 1"],
        ),
        (
            &[good, other, "--align", "event", "--event", "mark:2"],
            &["mark 2"],
        ),
        (
            &[good, other, "--groups", &no_column],
            &["no_column.csv", "group"],
        ),
        (&[good, other, "--groups", &names_none], &["names_none.csv"]),
        (&[good, other, "--groups", &one_group], &["one group alone"]),
        (
            &[good, other, "--group", "a=g*", "--group", "b=*"],
            &["two groups", "good.mcap"],
        ),
        (&[good, other, "--group", "a"], &["NAME=PATTERN"]),
        (&[good, other, "--report", &nowhere], &["page.html"]),
    ];
    for (arguments, told) in cases {
        for with in [&[][..], &["--json"]] {
            let output = dorsum(&[&["compare"], arguments, with].concat());
            let said = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
            assert!(output.stdout.is_empty(), "{arguments:?}");
            assert_eq!(said.trim_end().lines().count(), 1, "{said}");
            assert!(said.starts_with("dorsum: "), "{said}");
            for word in told {
                assert!(
                    said.contains(word),
                    "{arguments:?}: {word} is not in: {said}"
                );
            }
        }
    }
}
