//! Plots as SVG: well formed, labelled, complete, and small.

use dorsum::figure::{
    CellMap, Class, LEFT, LinePlot, Mark, RIGHT, Scale, Series, cells, plot as line_plot, write_svg,
};

fn svg(plots: &[LinePlot]) -> std::io::Result<String> {
    line_plot::svg(plots, "")
}

fn series(name: &str, colour: [u8; 3], points: Vec<[f64; 2]>) -> Series {
    Series {
        name: name.to_owned(),
        colour,
        points,
        ..Series::default()
    }
}

fn plot(title: &str, y_label: &str, series: Vec<Series>) -> LinePlot {
    LinePlot {
        title: title.to_owned(),
        x_label: "time (s)".to_owned(),
        y_label: y_label.to_owned(),
        series,
        ..LinePlot::default()
    }
}

fn wave(n: usize, height: f64) -> Vec<[f64; 2]> {
    (0..n)
        .map(|i| [i as f64 / 1000.0, height * (i as f64 / 700.0).sin()])
        .collect()
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// Checks that tags close in order, attributes are quoted and no bare special character is left; returns the tags.
fn checked(svg: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut tags = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        let text = &rest[..start];
        assert!(!text.contains('>'), "bare > in {text:?}");
        for entity in text.split('&').skip(1) {
            let name = entity.split(';').next().unwrap_or_default();
            assert!(
                ["lt", "gt", "amp", "quot", "apos"].contains(&name),
                "&{entity}"
            );
        }
        let end = start + rest[start..].find('>').expect("a tag closes");
        let tag = &rest[start + 1..end];
        assert!(
            tag.matches('"').count().is_multiple_of(2) && !tag.contains('<'),
            "{tag}"
        );
        let name = tag.split_whitespace().next().unwrap_or_default();
        if let Some(closed) = name.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(closed));
        } else if !tag.ends_with('/') {
            open.push(name.to_owned());
        }
        tags.push(tag.to_owned());
        rest = &rest[end + 1..];
    }
    assert!(open.is_empty(), "left open: {open:?}");
    let allowed = |c: char| c == '\n' || c == '\t' || !c.is_control();
    assert!(svg.chars().all(allowed));
    tags
}

/// The polylines of a colour, as points in the drawing.
fn curves(tags: &[String], colour: [u8; 3]) -> Vec<Vec<[f64; 2]>> {
    let stroke = format!("stroke=\"{}\"", hex(colour));
    tags.iter()
        .filter(|t| t.starts_with("polyline") && t.contains(&stroke))
        .map(|t| {
            let points = t.split("points=\"").nth(1).expect("points");
            points
                .split('"')
                .next()
                .expect("quoted")
                .split_whitespace()
                .map(|p| {
                    let (x, y) = p.split_once(',').expect("a pair");
                    [x.parse().expect("a number"), y.parse().expect("a number")]
                })
                .collect()
        })
        .collect()
}

fn extent(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    [
        values.clone().fold(f64::INFINITY, f64::min),
        values.fold(f64::NEG_INFINITY, f64::max),
    ]
}

#[test]
fn two_plots_share_a_drawing_with_all_their_labels_and_curves() {
    let names = ["left index", "right index"];
    let curves_of = |h: f64| {
        vec![
            series(names[0], LEFT, wave(3000, h)),
            series(names[1], RIGHT, wave(2000, h / 2.0)),
        ]
    };
    let text = svg(&[
        plot("Force at the fingers", "force (N)", curves_of(3.3)),
        plot("Penetration", "depth (mm)", curves_of(8.0)),
    ])
    .expect("drawn");
    let tags = checked(&text);
    for label in [
        "Force at the fingers",
        "Penetration",
        "force (N)",
        "depth (mm)",
        "time (s)",
    ] {
        assert!(text.contains(label), "{label} is missing");
    }
    assert_eq!(text.matches("time (s)").count(), 1, "x is shared");
    for name in names {
        assert_eq!(text.matches(name).count(), 2, "{name} in both legends");
    }
    let (left, right) = (curves(&tags, LEFT), curves(&tags, RIGHT));
    assert_eq!((left.len(), right.len()), (2, 2));
    // Shared x: the same second lies at the same place in both.
    let ends = |c: &[[f64; 2]]| extent(c.iter().map(|p| p[0]));
    assert_eq!(ends(&left[0]), ends(&left[1]));
    let [start, end] = ends(&left[0]);
    let share = (ends(&right[0])[1] - start) / (end - start);
    assert!((share - 1999.0 / 2999.0).abs() < 1.0e-3, "{share}");
    // Nothing outside of the drawing, the second below the first.
    let view = text.split("viewBox=\"0 0 ").nth(1).expect("a view box");
    let size: Vec<f64> = view
        .split('"')
        .next()
        .expect("quoted")
        .split(' ')
        .map(|n| n.parse().expect("a number"))
        .collect();
    for p in left.iter().chain(&right).flatten() {
        assert!(p[0] > 0.0 && p[0] < size[0] && p[1] > 0.0 && p[1] < size[1]);
    }
    assert!(extent(left[0].iter().map(|p| p[1]))[1] < extent(left[1].iter().map(|p| p[1]))[0]);
}

#[test]
fn a_spike_of_one_tick_in_an_hour_stays_and_the_file_stays_small() {
    let mut points: Vec<[f64; 2]> = (0..3_600_000)
        .map(|i| [f64::from(i) / 1000.0, 1.0 + 0.01 * f64::from(i % 17)])
        .collect();
    points[1_234_567][1] = 9.0;
    points[2_345_678][1] = -4.0;
    let text = svg(&[plot(
        "An hour",
        "force (N)",
        vec![series("left", LEFT, points)],
    )])
    .expect("drawn");
    assert!(text.len() < 100_000, "{} bytes", text.len());
    let curve = curves(&checked(&text), LEFT).concat();
    let [top, bottom] = extent(curve.iter().map(|p| p[1]));
    let tall = bottom - top;
    let usual: Vec<f64> = curve.iter().map(|p| (bottom - p[1]) / tall).collect();
    // 9 at the top, −4 at the bottom, all else near 1.08: 5.08 ∕ 13 of the way up.
    let apart = usual
        .iter()
        .filter(|&&u| (u - 5.08 / 13.0).abs() > 0.02)
        .count();
    assert_eq!(apart, 2, "both spikes and nothing else");
}

#[test]
fn points_that_are_not_finite_are_left_out() {
    let mut points = wave(500, 2.0);
    let expected =
        svg(&[plot("t", "y (mm)", vec![series("a", LEFT, points.clone())])]).expect("drawn");
    points.insert(100, [0.1, f64::NAN]);
    points.insert(200, [f64::NAN, 0.3]);
    points.insert(300, [0.3, f64::INFINITY]);
    points.insert(400, [f64::NEG_INFINITY, 0.3]);
    points.insert(401, [1.0, f64::MAX]);
    let text = svg(&[plot("t", "y (mm)", vec![series("a", LEFT, points)])]).expect("drawn");
    assert_eq!(text, expected);
}

#[test]
fn an_empty_plot_says_so() {
    let nowhere = series("a", LEFT, vec![[f64::NAN, 1.0]]);
    for plots in [
        vec![],
        vec![plot("Empty", "y (mm)", vec![])],
        vec![plot("Empty", "y (mm)", vec![nowhere])],
    ] {
        let text = svg(&plots).expect("drawn");
        checked(&text);
        assert!(text.contains("no data"));
    }
    let some = svg(&[plot("t", "y (mm)", vec![series("a", LEFT, wave(9, 1.0))])]).expect("drawn");
    assert!(!some.contains("no data"));
}

#[test]
fn every_range_of_values_can_be_drawn() {
    for points in [
        vec![[0.0, 0.0]],
        vec![[3.0, 2.0], [3.0, 2.0]],
        vec![[0.0, 5.0], [1.0, 5.0]],
        vec![[0.0, 1.0e-300], [1.0, 2.0e-300]],
        vec![[0.0, 1.0e15], [1.0, -1.0e15]],
        vec![[1.0e15, 1.0], [1.0e15 + 1.0, 2.0]],
        vec![[0.0, 1.0], [5.0e-324, 1.0 + f64::EPSILON]],
        vec![[1.0, 0.0], [-1.0, 1.0], [0.5, 0.5]],
    ] {
        let text =
            svg(&[plot("t", "y (mm)", vec![series("a", LEFT, points.clone())])]).expect("drawn");
        let tags = checked(&text);
        let dots = tags.iter().filter(|t| t.starts_with("circle")).count();
        assert_eq!(curves(&tags, LEFT).len() + dots, 1, "{points:?}");
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }
}

#[test]
fn odd_text_neither_breaks_the_drawing_nor_runs_out_of_it() {
    let odd = "a < b & \"c\" > 'd'\u{0}\u{7}";
    let long = "very long ".repeat(60);
    let many: Vec<Series> = (0..40)
        .map(|i| series(&format!("series number {i}"), LEFT, wave(5, f64::from(i))))
        .collect();
    for (title, label, curves) in [
        (odd, odd, vec![series(odd, LEFT, wave(5, 1.0))]),
        (&*long, &*long, vec![series(&long, LEFT, wave(5, 1.0))]),
        ("many", "y (mm)", many),
    ] {
        let text = svg(&[LinePlot {
            x_label: label.to_owned(),
            ..plot(title, label, curves)
        }])
        .expect("drawn");
        checked(&text);
    }
    let text = svg(&[plot(&long, "y (mm)", vec![])]).expect("drawn");
    assert!(text.contains('…') && !text.contains(&long));
}

#[test]
fn the_file_is_replaced_whole_and_is_the_same_every_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("force.svg");
    std::fs::write(&path, "an older drawing".repeat(10_000)).expect("written");
    let plots = [plot(
        "Force",
        "force (N)",
        vec![series("left", LEFT, wave(300, 1.0))],
    )];
    write_svg(&path, &plots).expect("written");
    let text = std::fs::read_to_string(&path).expect("read");
    assert_eq!(text, svg(&plots).expect("drawn"));
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("a folder").count(),
        1
    );
    assert!(write_svg(&folder.path().join("no/such/folder.svg"), &plots).is_err());
}

fn dots(tags: &[String], colour: [u8; 3]) -> Vec<[f64; 2]> {
    tags.iter()
        .filter(|t| t.starts_with("circle") && t.contains(&hex(colour)))
        .map(|t| {
            ["cx=\"", "cy=\""].map(|key| {
                let at = t.split(key).nth(1).and_then(|r| r.split('"').next());
                at.expect("a place").parse().expect("a number")
            })
        })
        .collect()
}

#[test]
fn on_logarithmic_axes_equal_factors_are_equally_long_and_what_is_not_above_zero_is_left_out() {
    let powers: Vec<[f64; 2]> = (0..5)
        .map(|i| [10_f64.powi(i), 3.0 * 100_f64.powi(-i)])
        .collect();
    let drawn = |points: Vec<[f64; 2]>| {
        let text = svg(&[LinePlot {
            x_scale: Scale::Logarithmic,
            y_scale: Scale::Logarithmic,
            ..plot("Cost", "time (µs)", vec![series("a", LEFT, points)])
        }]);
        text.expect("drawn")
    };
    let text = drawn(powers.clone());
    let curve = curves(&checked(&text), LEFT).concat();
    assert_eq!(curve.len(), 5);
    let steps: Vec<[f64; 2]> = curve
        .windows(2)
        .map(|w| [w[1][0] - w[0][0], w[1][1] - w[0][1]])
        .collect();
    for step in &steps {
        assert!(
            (step[0] - steps[0][0]).abs() <= 1.0 && step[0] > 100.0,
            "{steps:?}"
        );
        assert!(
            (step[1] - steps[0][1]).abs() <= 1.0 && step[1] > 50.0,
            "{steps:?}"
        );
    }
    for mark in ["10000", "1e", "0.01"] {
        assert!(text.contains(mark), "{mark}");
    }
    let mut with_others = powers;
    for odd in [
        [0.0, 1.0],
        [-1.0, 1.0],
        [5.0, 0.0],
        [5.0, -2.0],
        [f64::NAN, 1.0],
    ] {
        with_others.insert(2, odd);
    }
    assert_eq!(drawn(with_others), text);
    assert!(drawn(vec![[-1.0, 1.0]]).contains("no data"));
}

#[test]
fn marks_tell_measured_points_from_curves_and_one_source_from_another() {
    let points = || vec![[0.0, 1.0], [1.0, 4.0], [2.0, 2.0]];
    let of = |mark: Mark| {
        let marked = Series {
            mark,
            ..series("a", LEFT, points())
        };
        let text = svg(&[plot("Marked", "y (mm)", vec![marked])]).expect("drawn");
        let tags = checked(&text);
        (dots(&tags, LEFT).len(), curves(&tags, LEFT).len())
    };
    assert_eq!(of(Mark::Line), (0, 1));
    // With one in the legend.
    assert_eq!(of(Mark::Joined), (4, 1));
    assert_eq!(of(Mark::Points), (4, 0));
    let (rings, dashes) = of(Mark::Dashed);
    assert!(rings == 4 && dashes > 10, "{rings} {dashes}");
}

#[test]
fn a_caption_stands_below_and_leaves_the_plot_as_it_is() {
    let plots = [plot(
        "Force",
        "force (N)",
        vec![series("a", LEFT, wave(50, 1.0))],
    )];
    let without = svg(&plots).expect("drawn");
    let caption = "Dorsum 1.2.3, build 0123456789ab, seed 7; a <fast> & loud machine, 2 threads";
    let with = line_plot::svg(&plots, caption).expect("drawn");
    let tags = checked(&with);
    assert!(with.contains("build 0123456789ab, seed 7; a &lt;fast&gt; &amp; loud machine"));
    assert_eq!(curves(&tags, LEFT), curves(&checked(&without), LEFT));
}

/// A map of 4 × 3 cells in three classes.
fn map() -> CellMap {
    let class = |name: &str, colour| Class {
        name: name.to_owned(),
        colour,
    };
    CellMap {
        title: "Where it holds still".to_owned(),
        x_label: "damping (N s/m)".to_owned(),
        y_label: "stiffness (N/mm)".to_owned(),
        y_scale: Scale::Logarithmic,
        x_edges: vec![0.0, 1.0, 2.0, 3.0, 4.0],
        y_edges: vec![0.1, 1.0, 10.0, 100.0],
        cells: vec![0, 0, 0, 1, 0, 0, 1, 1, 0, 1, 2, 7],
        classes: vec![
            class("still", [200, 230, 205]),
            class("ringing", [250, 220, 150]),
            class("growing", [235, 150, 130]),
        ],
        series: vec![Series {
            mark: Mark::Dashed,
            ..series("theory", [20, 24, 30], vec![[-1.0, 0.01], [5.0, 1000.0]])
        }],
        ..CellMap::default()
    }
}

/// The filled boxes of a colour: left, top, width, height.
fn boxes(tags: &[String], colour: [u8; 3]) -> Vec<[f64; 4]> {
    tags.iter()
        .filter(|t| t.starts_with("rect") && t.contains(&hex(colour)))
        .map(|t| {
            [" x=\"", " y=\"", " width=\"", " height=\""].map(|key| {
                let at = t.split(key).nth(1).and_then(|r| r.split('"').next());
                at.expect("a size").parse().expect("a number")
            })
        })
        .collect()
}

#[test]
fn cells_fill_the_frame_each_in_the_colour_of_its_class() {
    let text = cells::svg(&map(), "seed 3").expect("drawn");
    let tags = checked(&text);
    for told in [
        "Where it holds still",
        "damping (N s/m)",
        "stiffness (N/mm)",
        "still",
        "ringing",
        "growing",
        "theory",
        "seed 3",
        "\n100\n",
        "\n0.1\n",
    ] {
        assert!(text.contains(told), "{told} is missing");
    }
    let of = |i: usize| boxes(&tags, map().classes[i].colour);
    // One box in the legend; cells of a class side by side are one.
    assert_eq!([0, 1, 2].map(|i| of(i).len()), [4, 4, 2]);
    let cells_of = |i: usize| of(i)[1..].to_vec();
    let all: Vec<[f64; 4]> = (0..3).flat_map(cells_of).collect();
    let growing = cells_of(2)[0];
    // Decades are equally high, columns equally wide.
    for [_, _, width, height] in &all {
        let columns = (width / growing[2]).round();
        assert!((width - columns * growing[2]).abs() <= 8.0, "{all:?}");
        assert!((height - growing[3]).abs() <= 8.0, "{all:?}");
    }
    let area: f64 = all.iter().map(|b| b[2] * b[3]).sum();
    let frame = [
        extent(all.iter().flat_map(|b| [b[0], b[0] + b[2]])),
        extent(all.iter().flat_map(|b| [b[1], b[1] + b[3]])),
    ];
    let whole = (frame[0][1] - frame[0][0]) * (frame[1][1] - frame[1][0]);
    // The last cell has a class that there is not.
    assert!(
        (area / whole - 11.0 / 12.0).abs() < 0.01,
        "{area} of {whole}"
    );
    // The stiffest row is at the top, the largest damping on the right.
    assert!((growing[1] - frame[1][0]).abs() <= 4.0, "{growing:?}");
    assert!((growing[0] + 2.0 * growing[2] - frame[0][1]).abs() <= 8.0);
    // The curve reaches out of the frame and is cut there.
    for p in curves(&tags, [20, 24, 30]).concat() {
        assert!(
            p[0] >= frame[0][0] - 4.0 && p[0] <= frame[0][1] + 4.0,
            "{p:?}"
        );
        assert!(
            p[1] >= frame[1][0] - 4.0 && p[1] <= frame[1][1] + 4.0,
            "{p:?}"
        );
    }
    assert!(curves(&tags, [20, 24, 30]).len() > 10, "dashes");
    assert_eq!(text, cells::svg(&map(), "seed 3").expect("drawn"));
}

#[test]
fn a_map_that_holds_nothing_says_so_and_an_odd_one_is_drawn_all_the_same() {
    let empty = cells::svg(&CellMap::default(), "").expect("drawn");
    checked(&empty);
    assert!(empty.contains("no data"));
    let odd = |change: &dyn Fn(&mut CellMap)| {
        let mut map = map();
        change(&mut map);
        let text = cells::svg(&map, "").expect("drawn");
        checked(&text);
        assert!(!text.contains("NaN") && !text.contains("inf"));
        text
    };
    assert!(!odd(&|_| {}).contains("no data"));
    odd(&|m| m.cells.truncate(3));
    odd(&|m| m.cells.extend([0; 50]));
    odd(&|m| m.y_edges[0] = 0.0);
    odd(&|m| m.x_edges[2] = f64::NAN);
    odd(&|m| m.x_edges = vec![1.0; 5]);
    odd(&|m| m.x_edges.reverse());
    odd(&|m| m.series[0].points = vec![[f64::INFINITY, 1.0], [1.0, f64::NAN]]);
    odd(&|m| m.series[0].mark = Mark::Joined);
    odd(&|m| m.title = "a < b & \"c\"\u{0}".repeat(90));
    let bare = odd(&|m| {
        m.classes.clear();
        m.series.clear();
    });
    assert!(bare.contains("no data"));
}
