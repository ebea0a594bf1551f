//! Numbers and changes in words.

use crate::scenario::Change;

/// A number with its sign, at most one decimal, and a true minus.
pub fn signed(x: f64) -> String {
    let tidy = (x * 10.0).round() / 10.0;
    if tidy == 0.0 || !tidy.is_finite() {
        return "0".to_owned();
    }
    let sign = if tidy < 0.0 { '−' } else { '+' };
    format!("{sign}{}", tidy.abs())
}

/// A change as both: "compliance −28 % = stiffness +38.9 %".
pub fn both(change: Change) -> String {
    format!(
        "compliance {} % = stiffness {} %",
        signed(change.compliance_percent()),
        signed(change.stiffness_percent())
    )
}

/// What a severity is called.
pub fn severity(severity: u8) -> &'static str {
    match severity {
        0 => "none or background",
        1 => "minor",
        2 => "obvious",
        _ => "key lesion",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_told_as_both() {
        assert_eq!(
            both(Change::CompliancePercent(-28.0)),
            "compliance −28 % = stiffness +38.9 %"
        );
        assert_eq!(
            both(Change::StiffnessPercent(-50.0)),
            "compliance +100 % = stiffness −50 %"
        );
        assert_eq!(signed(-0.04), "0");
        assert_eq!(signed(f64::NAN), "0");
    }
}
