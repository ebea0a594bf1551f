//! A document as one HTML file to read, print and hand on: no scripts, and nothing is loaded from elsewhere.

use super::{Column, Document, Report, Table, Value, Verdict};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::io::Result;

/// How it looks, in light, in the dark and on paper.
const STYLE: &str = include_str!("html.css");

/// The whole document.
///
/// # Errors
/// None that is known: those of the drawing library, which writes to memory here.
pub fn page(document: &Document, name: &str) -> Result<String> {
    let caption = document.caption();
    let sections: Vec<Markup> = document
        .experiments
        .iter()
        .map(|r| section(r, &caption))
        .collect::<Result<_>>()?;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "Dorsum lab: " (name) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (header(document, name))
                (contents(document))
                main { @for section in &sections { (section) } }
                footer { (caption) }
            }
        }
    };
    Ok(page.into_string())
}

fn header(document: &Document, name: &str) -> Markup {
    let build = document.build.as_deref().unwrap_or("unknown");
    let (first, last) = measured(document);
    html! {
        header {
            p.kind { "Dorsum lab" }
            h1 { (name) }
            p.outcome {
                @if document.holds {
                    span.badge.holds { "All holds that must" }
                } @else {
                    span.badge.fails { "Something does not hold" }
                }
                @if document.quick { span.badge.told { "Quick look" } }
            }
            dl.origin {
                dt { "Machine" } dd { (document.machine) }
                dt { "Program" } dd { "Dorsum " (document.dorsum) ", build " code { (build) } }
                dt { "Seed" } dd { (document.seed) }
                @if !first.is_empty() {
                    dt { "Measured" }
                    dd {
                        (day_and_minute(first))
                        @if day_and_minute(first) != day_and_minute(last) {
                            " to " (day_and_minute(last))
                        }
                        " UTC"
                    }
                }
            }
        }
    }
}

/// When the first and the last report were made; empty where that is not known.
fn measured(document: &Document) -> (&str, &str) {
    let times = || document.experiments.iter().map(|r| &*r.measured);
    (
        times().min().unwrap_or_default(),
        times().max().unwrap_or_default(),
    )
}

/// `2031-05-17T09:30:00.125Z` as `2031-05-17 09:30`.
fn day_and_minute(utc: &str) -> String {
    utc.chars().take(16).collect::<String>().replace('T', " ")
}

fn contents(document: &Document) -> Markup {
    html! {
        nav aria-label="Contents" {
            h2 { "Contents" }
            ol {
                @for report in &document.experiments {
                    li {
                        a href=(format!("#{}", report.experiment)) { (report.experiment) }
                        " "
                        (outcome(report))
                        span.about { (report.about) }
                    }
                }
            }
        }
    }
}

/// How many verdicts hold, in words and colour.
fn outcome(report: &Report) -> Markup {
    let n = report.verdicts.len();
    let held = report.verdicts.iter().filter(|v| v.holds).count();
    let class = match (report.holds(), held == n) {
        (false, _) => "badge fails",
        (true, false) => "badge told",
        (true, true) => "badge holds",
    };
    html! {
        @if n > 0 { span class=(class) { (held) " of " (n) " hold" } }
    }
}

fn section(report: &Report, caption: &str) -> Result<Markup> {
    let id = &report.experiment;
    let figures: Vec<(String, String)> = report
        .figures
        .iter()
        .map(|f| Ok((format!("{id}.{}", f.name), f.drawing.svg(caption)?)))
        .collect::<Result<_>>()?;
    Ok(html! {
        section id=(id) {
            h2 { (report.experiment) }
            p.about { (report.about) }
            @if !report.verdicts.is_empty() {
                h3 { "What holds" }
                (verdicts(&report.verdicts))
            }
            @if !report.notes.is_empty() {
                h3 { "Notes" }
                @for note in &report.notes { p.note { (note) } }
            }
            @if !figures.is_empty() {
                h3 { "Figures" }
                @for (name, svg) in &figures {
                    figure id=(name) {
                        // Made here, by a library that escapes its text.
                        (PreEscaped(svg))
                    }
                }
            }
            @if !report.tables.is_empty() {
                h3 { "Tables" }
                @for table in &report.tables { (table_of(table)) }
            }
            @if !report.settings.is_empty() {
                h3 { "Settings" }
                dl.settings {
                    @for setting in &report.settings {
                        dt { (setting.name) }
                        dd { (setting.value) }
                    }
                }
            }
        }
    })
}

fn verdicts(verdicts: &[Verdict]) -> Markup {
    html! {
        ul.verdicts {
            @for v in verdicts {
                @let (class, word) = match (v.holds, v.required) {
                    (true, _) => ("badge holds", "Holds"),
                    (false, true) => ("badge fails", "Does not hold"),
                    (false, false) => ("badge told", "Not reached"),
                };
                li {
                    span class=(class) { (word) }
                    div.what { (v.what) }
                    span.found { (v.measured) }
                    span.goal { "goal: " (v.goal) }
                }
            }
        }
    }
}

fn table_of(table: &Table) -> Markup {
    let is_text = |i: usize| table.rows().iter().any(|r| matches!(r[i], Value::Text(_)));
    let kinds: Vec<&str> = (0..table.columns().len())
        .map(|i| if is_text(i) { "text" } else { "number" })
        .collect();
    html! {
        h4 { (table.title) }
        // Can be reached by keyboard, so that a wide one can be scrolled without a mouse.
        div.wide tabindex="0" role="region" aria-label=(table.title) {
            table {
                thead {
                    tr { @for (column, kind) in table.columns().iter().zip(&kinds) { (head(column, kind)) } }
                }
                tbody {
                    @for row in table.rows() {
                        tr {
                            @for (value, kind) in row.iter().zip(&kinds) {
                                td class=(kind) { (value.short()) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn head(column: &Column, kind: &str) -> Markup {
    html! {
        th scope="col" class=(kind) {
            (column.name)
            @if !column.unit.is_empty() { " " span.unit { (column.unit) } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{CellMap, LinePlot, Series};
    use crate::lab::Setup;

    const ODD: &str = "a < b & \"c\" > 'd' <script>alert(1)</script>";

    fn report(name: &str) -> Report {
        let mut table = Table::new("odd", ODD, &["model", "cost (µs)", "count"]);
        table.push([ODD.into(), 12.3456.into(), 3_usize.into()]);
        table.push(["b".into(), f64::NAN.into(), Value::Empty]);
        let mut second = table.clone();
        second.name = "two".to_owned();
        let mut report = Report {
            experiment: name.to_owned(),
            about: ODD.to_owned(),
            measured: "2031-05-17T09:30:00.125Z".to_owned(),
            tables: vec![table, second],
            verdicts: vec![
                Verdict::must(ODD, ODD, ODD, true),
                Verdict::must("whole", "1 lost", "0 lost", false),
                Verdict::told("fast", "2 µs", "1 µs", false),
            ],
            ..Report::default()
        };
        report.set(ODD, ODD);
        report.note(ODD);
        let points = vec![[0.0, 1.0], [1.0, 2.0]];
        let series = vec![Series {
            name: ODD.to_owned(),
            points,
            ..Series::default()
        }];
        let title = ODD.to_owned();
        report.draw(
            "curve",
            vec![LinePlot {
                title,
                series,
                ..LinePlot::default()
            }],
        );
        report.draw_map(
            "map",
            CellMap {
                title: "A map".to_owned(),
                ..CellMap::default()
            },
        );
        report
    }

    /// Checks that tags close in order, attributes are quoted and no bare special character is left; counts the tags.
    fn tags(page: &str) -> impl Fn(&str) -> usize {
        let body = page
            .strip_prefix("<!DOCTYPE html>")
            .expect("a document type");
        // The style sheet is no markup.
        let (head, rest) = body.split_once("<style>").expect("a style");
        let (style, rest) = rest.split_once("</style>").expect("it ends");
        assert!(!style.contains('<') && !style.contains("url(") && !style.contains("@import"));
        let text = format!("{head}{rest}");
        let (mut open, mut found) = (Vec::new(), Vec::new());
        let mut rest = &*text;
        while let Some(start) = rest.find('<') {
            assert!(
                !rest[..start].contains('>'),
                "bare > in {:?}",
                &rest[..start]
            );
            for entity in rest[..start].split('&').skip(1) {
                let name = entity.split(';').next().unwrap_or_default();
                assert!(
                    ["lt", "gt", "amp", "quot", "apos"].contains(&name),
                    "&{entity}"
                );
            }
            let end = start + rest[start..].find('>').expect("a tag closes");
            let tag = &rest[start + 1..end];
            assert!(
                tag.matches('"').count() % 2 == 0 && !tag.contains('<'),
                "{tag}"
            );
            let name = tag.split_whitespace().next().unwrap_or_default();
            match name.strip_prefix('/') {
                Some(closed) => assert_eq!(open.pop().as_deref(), Some(closed)),
                None if tag.ends_with('/') || name == "meta" => {}
                None => open.push(name.to_owned()),
            }
            found.push(name.to_owned());
            rest = &rest[end + 1..];
        }
        assert!(open.is_empty(), "left open: {open:?}");
        move |name| found.iter().filter(|t| *t == name).count()
    }

    #[test]
    fn every_word_table_and_figure_is_in_it_and_nothing_comes_from_elsewhere() {
        let reports = vec![report("test-one"), report("test-two")];
        let document = Document::new(
            &Setup {
                seed: 42,
                ..Setup::default()
            },
            reports,
        );
        let page = page(&document, ODD).expect("made");
        let count = tags(&page);
        assert_eq!((count("svg"), count("table"), count("tr")), (4, 4, 12));
        assert_eq!(
            (
                count("section"),
                count("script"),
                count("img"),
                count("link")
            ),
            (2, 0, 0, 0)
        );
        // The name of a namespace is no address that anything is loaded from.
        let bare = page.replace("http://www.w3.org/2000/svg", "");
        for elsewhere in ["http:", "https:", "src=", "@import"] {
            assert!(!bare.contains(elsewhere), "{elsewhere}");
        }
        for told in [
            "seed 42",
            "2031-05-17 09:30 UTC",
            "Something does not hold",
            ">Holds<",
            ">Does not hold<",
            ">Not reached<",
            "1 of 3 hold",
            "href=\"#test-two\"",
            "id=\"test-two\"",
            ">12.35<",
            ">–<",
            "µs",
            "no data",
            &*document.machine.to_string(),
        ] {
            assert!(page.contains(told), "{told}");
        }
        assert_eq!(page.matches("&lt;script&gt;").count() % 2, 0);
        assert!(
            page.matches("a &lt; b &amp; &quot;c&quot; &gt; 'd'")
                .count()
                > 10
        );
    }

    #[test]
    fn numbers_stand_right_and_names_left() {
        let document = Document::new(&Setup::default(), vec![report("test")]);
        let page = page(&document, "test").expect("made");
        assert_eq!(page.matches("<th scope=\"col\" class=\"text\">").count(), 2);
        assert_eq!(
            page.matches("<th scope=\"col\" class=\"number\">").count(),
            4
        );
    }

    #[test]
    fn a_document_without_anything_is_a_page() {
        let empty = Document::new(&Setup::default(), Vec::new());
        assert_eq!(tags(&page(&empty, "nothing").expect("made"))("main"), 1);
        let bare = Document::new(&Setup::default(), vec![Report::default()]);
        assert_eq!(tags(&page(&bare, "bare").expect("made"))("section"), 1);
    }
}
