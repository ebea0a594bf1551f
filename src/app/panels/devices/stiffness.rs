//! How stiff a skin a device renders, by four answers, beside how stiff the open scene is; and what is done about it.

use super::{PanelContext, finger_title, wish};
use crate::app::editor::parts::pick;
use crate::app::hardware::{DeviceWish, FingerDevice, InUse, StiffnessChoice};
use crate::app::state::View;
use crate::device::stable::{HAND_DAMPING_N_S_PER_MM, Stable};
use egui::RichText;
use egui_material_icons::icons as icon;

/// How stiff the open scene is, found once for each.
#[derive(Debug, Default)]
pub struct Stiffest {
    known: Option<((u64, u64), f64)>,
}

/// What there is to say of scene and device.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Notice {
    /// The scene is too stiff.
    exceeds: bool,
    text: String,
    /// What is done about it.
    then: Option<String>,
}

/// Compares the stiffest place of a scene with what a device renders, N/mm.
fn notice(stiffest: f64, rendered: f64, choice: StiffnessChoice) -> Notice {
    let bounded = rendered.is_finite();
    let exceeds = bounded && stiffest > rendered;
    let felt = format!("The scene is felt up to {stiffest:.2} N/mm");
    let text = match (bounded, exceeds) {
        (false, _) => format!("{felt}; nothing bounds what this device renders"),
        (true, false) => {
            format!("{felt}; this device renders up to {rendered:.2} N/mm without shaking")
        }
        (true, true) => {
            format!("{felt}, but this device renders only {rendered:.2} N/mm without shaking")
        }
    };
    let then = exceeds.then(|| match choice {
        StiffnessChoice::AsIs => {
            "As it is: the device may buzz or shake where the skin is stiffer".into()
        }
        StiffnessChoice::Scale => {
            let percent = 100.0 * rendered / stiffest;
            format!("Scaled: the whole skin is felt at {percent:.0} % of its stiffness")
        }
        StiffnessChoice::Clamp => {
            format!("Clamped: nowhere is it felt stiffer than {rendered:.2} N/mm")
        }
    });
    Notice {
        exceeds,
        text,
        then,
    }
}

/// The four answers: name, value, where it comes from.
fn answers(stable: &Stable) -> [(&'static str, f64, String); 4] {
    let hand = 1000.0 * HAND_DAMPING_N_S_PER_MM;
    [
        (
            "Told",
            stable.told_n_per_mm,
            "What its maker or its device file states at 1 kHz, in proportion to the rate below that".into(),
        ),
        (
            "Passive",
            stable.passive_n_per_mm,
            "Stable in whatever hand, also in none: k < (b - |B|) / (T/2 + t_d) (Colgate & Schenkel 1997)".into(),
        ),
        (
            "With a hand",
            stable.coupled_n_per_mm,
            format!(
                "Stable with a hand on it that damps with {hand:.0} N·s/m: k < (b + b_hand + B) / (T/2 + t_d) (Gil et al. 2009)"
            ),
        ),
        (
            "Quantised",
            stable.quantised_n_per_mm,
            "Neither sampling nor encoder steps feed energy in: k ≤ min(2b/T, 2f/Δ) (Abbott & Okamura 2005)".into(),
        ),
    ]
}

impl Stiffest {
    /// The highest stiffness of the open scene, N/mm.
    fn of(&mut self, view: &View) -> Option<f64> {
        let scene = view.scene.as_ref()?;
        let which = (view.scene_generation, view.edit);
        match self.known {
            Some((known, stiffest)) if known == which => Some(stiffest),
            _ => {
                let stiffest = scene.stiffest_n_per_mm();
                self.known = Some((which, stiffest));
                Some(stiffest)
            }
        }
    }

    /// Draws it.
    pub fn ui(
        &mut self,
        ui: &mut egui::Ui,
        cx: &PanelContext<'_>,
        finger: usize,
        one: &FingerDevice,
        device: &InUse,
    ) {
        let theme = &cx.view.theme;
        let locked = cx.view.hardware.locked;
        let stable = &device.stable;
        ui.label("Highest stiffness that it renders without shaking, N/mm:");
        egui::Grid::new("stable")
            .num_columns(4)
            .min_col_width(74.0)
            .spacing([10.0, 2.0])
            .show(ui, |ui| {
                let answers = answers(stable);
                for (name, _, why) in &answers {
                    ui.label(RichText::new(*name).weak()).on_hover_text(why);
                }
                ui.end_row();
                for (name, value, why) in &answers {
                    let text = if value.is_finite() {
                        format!("{value:.2}")
                    } else {
                        "any".into()
                    };
                    let counts = matches!(*name, "Told" | "With a hand");
                    let text = RichText::new(text).monospace();
                    let text = if counts { text.strong() } else { text };
                    ui.label(text).on_hover_text(why);
                }
                ui.end_row();
            });
        ui.label(
            RichText::new("A scene is held against the lower of told and with a hand; many devices are stable though not passive.")
                .weak()
                .size(12.5),
        );
        ui.add_space(6.0);
        if cx.view.blind {
            ui.horizontal_wrapped(|ui| {
                ui.label(icon::ICON_VISIBILITY_OFF.rich_text().weak());
                ui.weak("How stiff the scene is stays hidden while the exercise runs");
            });
        } else if let Some(stiffest) = self.of(cx.view) {
            let told = notice(stiffest, stable.rendered_n_per_mm(), one.stiffness);
            ui.horizontal_wrapped(|ui| {
                let (mark, colour) = if told.exceeds {
                    (icon::ICON_WARNING, theme.warning)
                } else {
                    (icon::ICON_CHECK, theme.good)
                };
                ui.label(mark.rich_text().color(colour));
                ui.label(RichText::new(&told.text).color(if told.exceeds {
                    theme.warning
                } else {
                    theme.text
                }));
            });
            if let Some(then) = &told.then {
                ui.label(then);
            }
        }
        let title = finger_title(finger);
        ui.horizontal_wrapped(|ui| {
            ui.weak("Where the skin is too stiff");
            ui.add_enabled_ui(locked.is_none(), |ui| {
                for choice in StiffnessChoice::ALL {
                    let name = format!("Stiffness of {title}: {}", choice.title());
                    let on = one.stiffness == choice;
                    let why = locked.unwrap_or(why(choice));
                    if pick(ui, on, choice.title(), &name, why) && !on {
                        wish(cx, DeviceWish::Stiffness { finger, choice });
                    }
                }
            });
        });
        ui.weak("Recordings note it, and a replay does the same.");
        ui.add_space(8.0);
        passivity_ui(ui, cx, finger, one);
    }
}

fn why(choice: StiffnessChoice) -> &'static str {
    match choice {
        StiffnessChoice::AsIs => "The skin is rendered as the scene has it",
        StiffnessChoice::Scale => {
            "The whole skin is made softer by one factor: differences stay what they are in per cent"
        }
        StiffnessChoice::Clamp => {
            "What is too stiff is made as stiff as can be; softer places stay as they are"
        }
    }
}

fn passivity_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, finger: usize, one: &FingerDevice) {
    let locked = cx.view.hardware.locked;
    let mut on = one.limits.passivity;
    let name = format!("Passivity controller of {}", finger_title(finger));
    let why = "Watches the energy in every tick and takes the excess out of the force on the way out: no buzzing, at the \
               price of a skin that holds on a little less";
    let switch = ui.add_enabled(
        locked.is_none(),
        egui::Checkbox::new(&mut on, "Passivity controller"),
    );
    switch.widget_info(|| {
        egui::WidgetInfo::selected(egui::accesskit::Role::CheckBox, locked.is_none(), on, &name)
    });
    let switch = switch
        .on_hover_text(why)
        .on_disabled_hover_text(locked.unwrap_or_default());
    if switch.changed() {
        wish(cx, DeviceWish::Passivity { finger, on });
    }
    ui.weak("The skin may give out no more energy than the finger has put in.");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_that_is_too_stiff_is_told_with_what_is_done_about_it() {
        use StiffnessChoice::{AsIs, Clamp, Scale};
        let within = notice(0.6, 0.8, Scale);
        assert!(!within.exceeds && within.then.is_none());
        assert!(within.text.contains("0.60 N/mm") && within.text.contains("0.80 N/mm"));
        let told = |choice| notice(1.6, 0.8, choice).then.unwrap_or_default();
        assert!(notice(1.6, 0.8, AsIs).text.contains("only 0.80 N/mm"));
        assert!(told(AsIs).contains("may buzz"));
        assert!(told(Scale).contains("50 %"));
        assert!(told(Clamp).contains("0.80 N/mm"));
        assert!(!notice(9.0, f64::INFINITY, AsIs).exceeds);
    }

    #[test]
    fn each_answer_names_its_source() {
        let stable = Stable {
            told_n_per_mm: 1.0,
            passive_n_per_mm: 2.0,
            coupled_n_per_mm: 3.0,
            quantised_n_per_mm: 4.0,
        };
        let values: Vec<f64> = answers(&stable).iter().map(|a| a.1).collect();
        assert_eq!(values, [1.0, 2.0, 3.0, 4.0]);
    }
}
