//! Name and description of a scenario written.

use super::cells::Cell;
use super::rows::set;
use super::{ORIGIN, checked, parsed};
use crate::scenario::{Scenario, ScenarioError};

/// `source` with this name and this description; an empty description is left out. What it says already stays as written,
/// with its comments.
///
/// # Errors
/// `source` is no scenario, or the name is not allowed.
pub fn set_about(source: &str, name: &str, description: &str) -> Result<String, ScenarioError> {
    let mut document = parsed(source)?;
    let old = Scenario::parse(source, ORIGIN, None)?;
    let (name, description) = (name.trim(), description.trim());
    if name != old.name {
        set(document.as_table_mut(), "name", &Cell::Text(name));
    }
    if description.is_empty() {
        document.remove("description");
    } else if description != old.description {
        set(
            document.as_table_mut(),
            "description",
            &Cell::Text(description),
        );
    }
    checked(&document)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "format = 1\nname = \"A\" # short\ndescription = \" One. \"\n[surface]\nbuiltin = \"back\"\n\
                        [stiffness]\nconstant_n_per_mm = 1\n";

    #[test]
    fn what_is_said_already_stays_as_written_and_comments_stay() {
        assert_eq!(set_about(FILE, "A", "One.").as_deref(), Ok(FILE));
        let text = set_about(FILE, "B \"b\"", "Two\nlines.").expect("good");
        assert!(text.contains("# short"), "{text}");
        let read = Scenario::parse(&text, "a", None).expect("good");
        assert_eq!(
            (read.name.as_str(), read.description.as_str()),
            ("B \"b\"", "Two\nlines.")
        );
        let bare = set_about(&text, "B", "").expect("good");
        assert!(!bare.contains("description"), "{bare}");
        let again = set_about(&bare, "B", "Back.").expect("good");
        let read = Scenario::parse(&again, "a", None).expect("good");
        assert_eq!(read.description, "Back.");
    }

    #[test]
    fn a_name_that_is_not_allowed_is_refused_in_one_line() {
        for name in ["", " ", "a\nb"] {
            let error = set_about(FILE, name, "").expect_err(name).to_string();
            assert!(error.contains("name") && !error.contains('\n'), "{error}");
        }
    }
}
