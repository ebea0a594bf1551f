//! The house keeps its order: each module names only those to its left, and nothing else lies at the top level.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules from left to right; each may name those before it, except where [`NOT`] says otherwise.
const ORDER: &[&str] = &[
    "units",
    "table",
    "geom",
    "surface",
    "partition",
    "maps",
    "contact",
    "deform",
    "reference",
    "device",
    "servo",
    "session",
    "scenario",
    "figure",
    "training",
    "study",
    "lab",
    "app",
    "cli",
];

/// Neighbours on one level do not know each other, and some rooms have fewer doors than the order would allow.
const NOT: &[(&str, &[&str])] = &[
    ("maps", &["partition"]),
    (
        "device",
        &["surface", "partition", "maps", "contact", "deform"],
    ),
    ("servo", &["deform"]),
    ("scenario", &["session"]),
    (
        "figure",
        &[
            "partition",
            "maps",
            "contact",
            "device",
            "servo",
            "session",
            "scenario",
        ],
    ),
];

/// Crates that only the window may know.
const GUI_CRATES: &[&str] = &[
    "egui",
    "eframe",
    "glow",
    "egui_plot",
    "egui_tiles",
    "egui_notify",
    "rfd",
    "egui_material_icons",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn may_name(module: &str, named: &str) -> bool {
    let place = |m: &str| ORDER.iter().position(|&o| o == m);
    let barred = NOT
        .iter()
        .any(|(m, names)| *m == module && names.contains(&named));
    place(named) < place(module) && !barred
}

/// Every Rust file under `src`, with its path from there.
fn sources() -> Vec<(String, String)> {
    fn walk(folder: &Path, out: &mut Vec<PathBuf>) {
        let mut entries: Vec<_> = fs::read_dir(folder)
            .expect("folder")
            .map(|e| e.expect("entry").path())
            .collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                walk(&path, out);
            } else if path.extension().is_some_and(|e| e == "rs") {
                out.push(path);
            }
        }
    }
    let src = root().join("src");
    let mut files = Vec::new();
    walk(&src, &mut files);
    files
        .into_iter()
        .map(|f| {
            let shown = f
                .strip_prefix(&src)
                .expect("in src")
                .to_string_lossy()
                .replace('\\', "/");
            (shown, fs::read_to_string(&f).expect("readable"))
        })
        .collect()
}

fn module_of(file: &str) -> &str {
    file.split('/')
        .next()
        .unwrap_or_default()
        .trim_end_matches(".rs")
}

/// Line number and word of everything that follows `before` in `text`, outside of comments.
fn words_after<'a>(text: &'a str, before: &'a str) -> impl Iterator<Item = (usize, &'a str)> {
    text.lines().enumerate().flat_map(move |(i, line)| {
        let code = line.split("//").next().unwrap_or_default();
        code.match_indices(before).map(move |(at, _)| {
            let rest = &code[at + before.len()..];
            let end = rest
                .find(|c: char| !c.is_alphanumeric() && c != '_')
                .unwrap_or(rest.len());
            (i + 1, &rest[..end])
        })
    })
}

#[test]
fn each_module_names_only_those_to_its_left() {
    let mut faults = Vec::new();
    for (file, text) in sources() {
        let module = module_of(&file);
        if ["lib", "main"].contains(&module) {
            continue;
        }
        if !ORDER.contains(&module) {
            faults.push(format!("src/{file}: module `{module}` is not in the table"));
        }
        for (line, named) in words_after(&text, "crate::") {
            if ORDER.contains(&named) && named != module && !may_name(module, named) {
                faults.push(format!("src/{file}:{line}: `{module}` names `{named}`"));
            }
            if named.is_empty() {
                faults.push(format!(
                    "src/{file}:{line}: write one `use crate::module` a line"
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn only_the_workbench_knows_a_window_library() {
    let mut faults = Vec::new();
    for (file, text) in sources()
        .iter()
        .filter(|(file, _)| module_of(file) != "app")
    {
        for name in GUI_CRATES {
            for path in [
                format!(" {name}::"),
                format!("({name}::"),
                format!("&{name}::"),
                format!("<{name}::"),
            ] {
                faults.extend(
                    words_after(text, &path)
                        .map(|(line, _)| format!("src/{file}:{line}: knows `{name}`")),
                );
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_top_level_holds_what_the_layout_names() {
    let allowed = [
        "Cargo.toml",
        "Cargo.lock",
        "src",
        "assets",
        "sessions",
        "tests",
        "README.md",
        "LICENSE",
        ".ci",
        ".gitignore",
    ];
    let built = ["target", ".git"];
    for entry in fs::read_dir(root()).expect("root") {
        let name = entry
            .expect("entry")
            .file_name()
            .into_string()
            .expect("UTF-8");
        assert!(
            allowed.contains(&&*name) || built.contains(&&*name),
            "`{name}` does not belong at the top level"
        );
    }
}

#[test]
fn unsafe_code_stands_only_at_the_edges_and_says_why() {
    for (file, text) in sources() {
        let allows: Vec<&str> = text
            .split("#")
            .filter(|s| s.contains("allow(") && s.contains("unsafe_code"))
            .collect();
        if !allows.is_empty() {
            let edges = ["app/render/", "app/libraries.rs", "device/vendor/"];
            let at_an_edge = edges.iter().any(|edge| file.starts_with(edge));
            assert!(at_an_edge, "src/{file} allows unsafe code");
            assert!(
                allows.iter().all(|a| a.contains("reason")),
                "src/{file} allows unsafe code without a reason"
            );
        }
    }
}
