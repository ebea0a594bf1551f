//! How a finger's device is, in words and in colour.

use crate::app::hardware::FingerDevice;
use crate::app::theme::Theme;
use crate::device::hid::guard::Condition;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Nothing to say.
    Rest,
    /// It works.
    Good,
    /// It may come back by itself.
    Warning,
    /// Somebody has to do something.
    Fault,
}

impl Severity {
    /// Its colour.
    pub fn colour(self, theme: &Theme) -> egui::Color32 {
        match self {
            Self::Rest => theme.weak_text,
            Self::Good => theme.good,
            Self::Warning => theme.warning,
            Self::Fault => theme.fault,
        }
    }
}

/// How a finger's device is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct State {
    /// A sentence that says what to do.
    pub title: String,
    /// Two words; empty where all is well.
    pub short: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// Whether it stays until somebody releases it.
    pub is_latched: bool,
}

/// How the device of `finger` is.
pub fn of(finger: &FingerDevice) -> State {
    let plain = |title: &str, short, severity| State {
        title: title.into(),
        short,
        severity,
        is_latched: false,
    };
    if finger.gone {
        let title = "Pulled out; the finger is held without force until the recording is finished";
        return plain(title, "pulled out", Severity::Warning);
    }
    let Some(device) = &finger.device else {
        return plain("Moved by the mouse in the Back view", "", Severity::Rest);
    };
    match &device.vitals {
        None => plain("In use", "", Severity::Good),
        Some(vitals) => {
            let condition = vitals.condition();
            if condition == Condition::Good && finger.sunk {
                let title = "Under the skin, where nothing is felt: lift it out first";
                return plain(title, "under the skin", Severity::Warning);
            }
            State {
                title: capital(condition.title()),
                short: short(condition),
                severity: severity(condition),
                is_latched: condition.is_latched(),
            }
        }
    }
}

fn severity(condition: Condition) -> Severity {
    match condition {
        Condition::Good => Severity::Good,
        Condition::Waiting => Severity::Rest,
        Condition::Silent | Condition::Frozen => Severity::Warning,
        _ => Severity::Fault,
    }
}

fn short(condition: Condition) -> &'static str {
    match condition {
        Condition::Good => "",
        Condition::Waiting => "waiting",
        Condition::Silent => "silent",
        Condition::Frozen => "frozen",
        Condition::Jumped => "jumped",
        Condition::TooFast => "too fast",
        Condition::TooFar => "too far",
        Condition::AgainstForce => "against force",
        Condition::Unplugged => "unplugged",
        Condition::Closed => "closed",
        Condition::Ended => "ended",
    }
}

/// The text with a capital.
pub fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(chars).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::hardware::StiffnessChoice;

    #[test]
    fn only_what_answers_needs_no_word() {
        for condition in Condition::ALL {
            let good = condition == Condition::Good;
            assert_eq!(short(condition).is_empty(), good, "{condition:?}");
            assert_eq!(severity(condition) == Severity::Good, good);
            let bad = condition.is_latched() || condition.is_final();
            assert_eq!(severity(condition) == Severity::Fault, bad, "{condition:?}");
            assert!(capital(condition.title()).starts_with(char::is_uppercase));
        }
        assert_eq!(capital(""), "");
    }

    #[test]
    fn a_mouse_is_at_rest_and_a_device_pulled_out_is_told_first() {
        let mut finger = FingerDevice {
            name: "Mouse".into(),
            device: None,
            gone: false,
            sunk: false,
            limits: Default::default(),
            stiffness: StiffnessChoice::AsIs,
            test: None,
        };
        assert_eq!(of(&finger).severity, Severity::Rest);
        finger.gone = true;
        assert_eq!(of(&finger).severity, Severity::Warning);
    }
}
