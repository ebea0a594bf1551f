//! The answers to choose from, and what is said beside them.

use super::{PanelContext, pressed, send};
use crate::app::state::View;
use crate::app::widgets::named;
use crate::contact::Touch;
use crate::geom::Vec2;
use crate::scenario::dysfunction::{self, side_name};
use crate::scenario::{Side, Site, VertebralLevel};
use crate::training::{Answer, Choice, Input, Mark, Reply, Shown};
use egui::{Key, RichText};

/// An answer in the making.
#[derive(Default)]
pub struct Replying {
    confidence_percent: u8,
    kind: Option<&'static str>,
    severity: Option<u8>,
    marks: Vec<Mark>,
}

const DIGITS: [Key; 10] = [
    Key::Num0,
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// Where the finger is that presses deepest, on the map plane, mm.
fn touched_mm(view: &View) -> Option<Vec2> {
    let touching = (view.fingers.iter()).filter(|f| f.contact.touch != Touch::Free);
    let deepest = touching.max_by(|a, b| a.contact.depth_mm.total_cmp(&b.contact.depth_mm))?;
    Some(deepest.contact.anchor_mm.truncate())
}

impl Replying {
    pub fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, shown: &Shown) {
        ui.add_space(6.0);
        self.beside_ui(ui, shown);
        let answer = if shown.choices.is_empty() {
            self.marks_ui(ui, cx)
        } else if shown
            .choices
            .iter()
            .all(|c| matches!(c.answer, Answer::Site(_)))
        {
            sites_ui(ui, cx, &shown.choices)
        } else {
            choices_ui(ui, &shown.choices)
        };
        if let Some(answer) = answer {
            send(cx, Input::Answer(self.reply(answer, shown)));
        }
    }

    fn reply(&self, answer: Answer, shown: &Shown) -> Reply {
        Reply {
            answer,
            confidence_percent: shown.asks_confidence.then_some(self.confidence_percent),
            kind: self.kind.filter(|_| shown.asks_kind).map(str::to_owned),
            severity: self.severity.filter(|_| shown.asks_severity),
        }
    }

    /// What is asked beside the answer itself.
    fn beside_ui(&mut self, ui: &mut egui::Ui, shown: &Shown) {
        if shown.asks_kind {
            let title = |key: &str| dysfunction::named(key).map_or("choose", |k| k.title());
            egui::ComboBox::from_label("Kind")
                .selected_text(self.kind.map_or("choose", title))
                .show_ui(ui, |ui| {
                    for kind in dysfunction::all() {
                        let value = Some(kind.key());
                        ui.selectable_value(&mut self.kind, value, kind.title());
                    }
                });
        }
        if shown.asks_severity {
            ui.horizontal(|ui| {
                ui.label("Severity");
                for severity in 0..=3_u8 {
                    let value = Some(severity);
                    let button =
                        ui.selectable_value(&mut self.severity, value, severity.to_string());
                    named(ui, &button, &format!("Severity {severity}"));
                }
            });
        }
        if shown.asks_confidence {
            ui.horizontal(|ui| {
                let label = ui.label("How sure");
                ui.add(
                    egui::Slider::new(&mut self.confidence_percent, 0..=100)
                        .step_by(5.0)
                        .suffix(" %"),
                )
                .labelled_by(label.id)
                .on_hover_text("0 %: a guess; 100 %: certain. Set it before you answer");
            });
        }
    }

    /// Places marked by the finger, until they are said to be all.
    fn marks_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) -> Option<Answer> {
        let at = touched_mm(cx.view);
        let mark = ui
            .add_enabled(at.is_some(), egui::Button::new("Mark this place"))
            .on_hover_text("Mark where the deeper finger presses (M)")
            .on_disabled_hover_text("Press the skin where you have found something (M)");
        named(ui, &mark, "Mark this place");
        if let Some(at_mm) = at
            && (mark.clicked() || pressed(ui, &[Key::M]))
        {
            self.marks.push(Mark {
                at_mm,
                kind: self.kind.map(str::to_owned),
                severity: self.severity,
            });
        }
        let mut gone = None;
        for (i, mark) in self.marks.iter().enumerate() {
            ui.horizontal(|ui| {
                let name = format!("Forget place {}", i + 1);
                let button = ui.small_button("×").on_hover_text("Forget this place");
                named(ui, &button, &name);
                if button.clicked() {
                    gone = Some(i);
                }
                let at = mark.at_mm;
                ui.monospace(format!("{}: x {:+6.1}, y {:6.1} mm", i + 1, at.x, at.y));
            });
        }
        if let Some(i) = gone {
            self.marks.remove(i);
        }
        let text = match self.marks.len() {
            0 => "There is nothing".to_owned(),
            1 => "This is the only place".to_owned(),
            n => format!("These {n} places are all"),
        };
        let done = ui
            .button(&text)
            .on_hover_text("Answer with the places that are marked");
        named(ui, &done, &text);
        done.clicked()
            .then(|| Answer::Marks(std::mem::take(&mut self.marks)))
    }
}

/// Sites as rows of levels and columns of sides, and the place that is touched.
fn sites_ui(ui: &mut egui::Ui, cx: &PanelContext<'_>, choices: &[Choice]) -> Option<Answer> {
    let sites: Vec<Site> = (choices.iter())
        .filter_map(|c| match c.answer {
            Answer::Site(site) => Some(site),
            _ => None,
        })
        .collect();
    let mut levels: Vec<VertebralLevel> = sites.iter().map(|s| s.level).collect();
    levels.sort();
    levels.dedup();
    let mut sides: Vec<Side> = Vec::new();
    for side in [Side::Left, Side::Middle, Side::Right] {
        if sites.iter().any(|s| s.side == side) {
            sides.push(side);
        }
    }
    let mut answer = None;
    let at = touched_mm(cx.view);
    let here = ui
        .add_enabled(at.is_some(), egui::Button::new("Here, under my finger"))
        .on_hover_text("Answer with the place nearest to the deeper finger (H)")
        .on_disabled_hover_text("Press the skin where it is (H)");
    named(ui, &here, "Here, under my finger");
    if let Some(at) = at
        && (here.clicked() || pressed(ui, &[Key::H]))
    {
        answer = Some(Answer::Here(at));
    }
    ui.add_space(4.0);
    egui::Grid::new("sites").spacing([6.0, 3.0]).show(ui, |ui| {
        for level in &levels {
            ui.label(RichText::new(level.to_string()).monospace().weak());
            for side in &sides {
                let of: Vec<&Site> = (sites.iter())
                    .filter(|s| s.level == *level && s.side == *side)
                    .collect();
                if of.is_empty() {
                    ui.label("");
                }
                for site in of {
                    let words = side_name(*side);
                    let button = egui::Button::new(words).min_size(egui::vec2(76.0, 20.0));
                    let response = ui.add(button).on_hover_text(site.to_string());
                    named(ui, &response, &site.to_string());
                    if response.clicked() {
                        answer = Some(Answer::Site(*site));
                    }
                }
            }
            ui.end_row();
        }
    });
    answer
}

/// Answers beside each other; up to nine have a digit.
fn choices_ui(ui: &mut egui::Ui, choices: &[Choice]) -> Option<Answer> {
    let mut answer = None;
    ui.horizontal_wrapped(|ui| {
        for (i, choice) in choices.iter().enumerate() {
            // A choice that is a digit has that one.
            let own = choice.key.and_then(|c| c.to_digit(10)).map(|d| d as usize);
            let digit = own.or_else(|| (choices.len() <= 9).then_some(i + 1));
            let key = digit.and_then(|d| DIGITS.get(d)).copied();
            let button = egui::Button::new(RichText::new(&choice.label).size(15.0))
                .min_size(egui::vec2(72.0, 32.0));
            let tooltip = match digit {
                Some(digit) => format!("Answer \"{}\" (key {digit})", choice.label),
                None => format!("Answer \"{}\"", choice.label),
            };
            let response = ui.add(button).on_hover_text(tooltip);
            named(ui, &response, &format!("Answer {}", choice.label));
            if response.clicked() || key.is_some_and(|key| pressed(ui, &[key])) {
                answer = Some(choice.answer.clone());
            }
        }
    });
    answer
}
