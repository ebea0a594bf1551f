//! Which recording is in which group: by patterns, or by a table.

use super::CompareArgs;
use crate::cli::CliError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(super) fn parse_group(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, pattern)) if !name.trim().is_empty() && !pattern.is_empty() => {
            Ok((name.trim().to_owned(), pattern.to_owned()))
        }
        _ => Err(format!(
            "\"{text}\" is no group; NAME=PATTERN is needed, such as novice=N*.mcap"
        )),
    }
}

/// The group of every recording.
pub(super) fn groups(args: &CompareArgs) -> Result<Vec<Option<String>>, CliError> {
    if let Some(path) = &args.groups_file {
        return from_table(path, &args.files);
    }
    let mut found = vec![None; args.files.len()];
    for (name, pattern) in &args.groups {
        let mut any = false;
        for (file, group) in args.files.iter().zip(&mut found) {
            let file_name = file.file_name().map(|n| n.to_string_lossy().into_owned());
            let fits = fits(pattern, &file.to_string_lossy())
                || file_name.is_some_and(|n| fits(pattern, &n));
            if !fits {
                continue;
            }
            any = true;
            if let Some(other) = group.replace(name.clone())
                && other != *name
            {
                let file = file.display();
                return Err(CliError::input(format_args!(
                    "{file}: fits two groups, {other} and {name}; a recording is in one"
                )));
            }
        }
        if !any {
            return Err(CliError::input(format_args!(
                "group {name}: no recording fits \"{pattern}\""
            )));
        }
    }
    need_two(&found)?;
    Ok(found)
}

fn need_two(found: &[Option<String>]) -> Result<(), CliError> {
    let names: std::collections::BTreeSet<_> = found.iter().flatten().collect();
    if names.len() == 1 {
        return Err(CliError::input(
            "one group alone cannot be compared; name a second",
        ));
    }
    Ok(())
}

/// Whether a text fits a pattern of `*` for anything and `?` for one character.
fn fits(pattern: &str, text: &str) -> bool {
    let (pattern, text): (Vec<char>, Vec<char>) =
        (pattern.chars().collect(), text.chars().collect());
    let (mut p, mut t) = (0, 0);
    let mut star: Option<(usize, usize)> = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, t));
                p += 1;
            }
            Some(c) if *c == '?' || *c == text[t] => {
                p += 1;
                t += 1;
            }
            _ => match star {
                Some((at, taken)) => {
                    star = Some((at, taken + 1));
                    (p, t) = (at + 1, taken + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Reads `file` and `group`; a file is named by its path as given, by its path from the table's folder, or by its name.
fn from_table(path: &Path, files: &[PathBuf]) -> Result<Vec<Option<String>>, CliError> {
    let failed = |what: String| CliError::input(format_args!("{}: {what}", path.display()));
    let mut reader = csv::Reader::from_path(path).map_err(|e| failed(e.to_string()))?;
    let heads = reader.headers().map_err(|e| failed(e.to_string()))?.clone();
    let column = |name: &str| {
        let found = heads
            .iter()
            .position(|h| h.trim().eq_ignore_ascii_case(name));
        found.ok_or_else(|| {
            failed(format!(
                "there is no column {name}; file and group are needed"
            ))
        })
    };
    let (file, group) = (column("file")?, column("group")?);
    let mut named: BTreeMap<PathBuf, String> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| failed(e.to_string()))?;
        let cell = |i: usize| record.get(i).unwrap_or_default().trim().to_owned();
        named.insert(cell(file).into(), cell(group));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let found = files.iter().map(|wanted| {
        let by_path = named.get(wanted);
        let beside = || {
            named
                .iter()
                .find(|(name, _)| folder.join(name) == *wanted)
                .map(|n| n.1)
        };
        let by_name = || named.get(Path::new(wanted.file_name()?));
        let group = by_path.or_else(beside).or_else(by_name);
        group.filter(|g| !g.is_empty()).cloned()
    });
    let found: Vec<_> = found.collect();
    if found.iter().all(Option::is_none) {
        return Err(failed("it names none of the recordings".into()));
    }
    need_two(&found)?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_what_they_say() {
        for (pattern, text) in [
            ("*", ""),
            ("N*.mcap", "N12.mcap"),
            ("?1*", "P1"),
            ("*a*b*", "xaxxbx"),
            ("a", "a"),
        ] {
            assert!(fits(pattern, text), "{pattern} {text}");
        }
        for (pattern, text) in [
            ("", "a"),
            ("N*.mcap", "N12.mca"),
            ("?", ""),
            ("*ab", "aba"),
            ("a?", "a"),
        ] {
            assert!(!fits(pattern, text), "{pattern} {text}");
        }
        assert!(
            parse_group("a=b*").is_ok() && parse_group("=b").is_err() && parse_group("a").is_err()
        );
    }
}
