//! Checks of scenario values: what is wrong is told in one line with file and line number.

use super::ScenarioError;
use std::ops::{Range, RangeInclusive};
use toml::Spanned;

/// Turns what is wrong into one line with file and line number.
pub(super) struct Check<'a> {
    pub(super) text: &'a str,
    pub(super) origin: &'a str,
}

impl Check<'_> {
    pub(super) fn fail(&self, span: &Range<usize>, what: impl AsRef<str>) -> ScenarioError {
        let line = 1 + self
            .text
            .bytes()
            .take(span.start)
            .filter(|&b| b == b'\n')
            .count();
        let what = what
            .as_ref()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        ScenarioError(format!("{}: line {line}: {what}", self.origin))
    }

    /// An error of the TOML reader: syntax, an unknown or missing key, a wrong type.
    pub(super) fn syntax(&self, e: &toml::de::Error) -> ScenarioError {
        let message = e
            .message()
            .replace("unknown field", "unknown key")
            .replace("missing field", "missing key");
        self.fail(
            &e.span().unwrap_or(0..0),
            message.replace("expected one of", "allowed are"),
        )
    }

    pub(super) fn number(
        &self,
        key: &str,
        value: &Spanned<f64>,
        allowed: RangeInclusive<f64>,
    ) -> Result<f64, ScenarioError> {
        let x = *value.get_ref();
        if allowed.contains(&x) {
            return Ok(x);
        }
        let what = format!(
            "{key} = {x}; {} to {} is allowed",
            allowed.start(),
            allowed.end()
        );
        Err(self.fail(&value.span(), what))
    }

    /// A named choice: one of `allowed`.
    pub(super) fn choice<T: Copy>(
        &self,
        key: &str,
        value: &Spanned<String>,
        allowed: &[(&str, T)],
    ) -> Result<T, ScenarioError> {
        let given = value.get_ref();
        if let Some((_, choice)) = allowed.iter().find(|(name, _)| name == given) {
            return Ok(*choice);
        }
        let names: Vec<_> = allowed
            .iter()
            .map(|(name, _)| format!("{name:?}"))
            .collect();
        let be = if names.len() == 1 { "is" } else { "are" };
        let what = format!("{key} = {given:?}; allowed {be} {}", names.join(", "));
        Err(self.fail(&value.span(), what))
    }

    /// A number that may be left out.
    pub(super) fn number_or(
        &self,
        key: &str,
        value: Option<&Spanned<f64>>,
        allowed: RangeInclusive<f64>,
        or: f64,
    ) -> Result<f64, ScenarioError> {
        value.map_or(Ok(or), |v| self.number(key, v, allowed))
    }
}
