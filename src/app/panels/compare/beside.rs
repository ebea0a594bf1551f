//! All recordings beside the first: traces, differences, agreement.

use super::figures::{self, Beside};
use super::measures::Named;
use super::work::Work;
use crate::app::panels::PanelContext;
use crate::app::panels::lab::chart::{self, ChartContext};
use crate::app::state::Compared;
use crate::study::compare::CompareOptions;
use crate::study::stats::BlandAltman;
use egui::RichText;

/// All beside the first; `None` while there is nothing to show, which is said.
pub fn of(
    ui: &mut egui::Ui,
    cx: &PanelContext<'_>,
    work: &Work,
    told: &[(Compared, Named)],
    options: &CompareOptions,
) -> Option<Beside> {
    let (first, others) = told.split_first()?;
    if others.is_empty() {
        ui.weak("Add another recording: it is set beside this one");
        return None;
    }
    let mut beside = Beside::new();
    for (c, (name, _)) in others {
        let pair = work.pair(&first.0.path, &c.path, options);
        if let Some(Err(why)) = pair {
            let text = RichText::new(format!("{name}: {why}")).color(cx.view.theme.warning);
            ui.add(egui::Label::new(text).wrap());
        }
        beside.push(pair.and_then(|p| p.as_ref().ok().cloned()));
    }
    if beside.iter().all(Option::is_none) {
        if work.progress().is_some() {
            ui.weak("They are being set side by side");
        }
        return None;
    }
    Some(beside)
}

/// How far each is from the first, in a line each.
pub fn spreads_ui(ui: &mut egui::Ui, names: &[Named], beside: &Beside) {
    for (pair, (name, _)) in beside.iter().zip(names.iter().skip(1)) {
        let Some(c) = pair else { continue };
        let text = format!(
            "{name} against A, {}: RMS {:.3} N, {:.3} mm in depth, {:.2} mm in place; largest {:.3} N at {:.2} s",
            c.aligned,
            c.force_n.rms,
            c.depth_mm.rms,
            c.position_mm.rms,
            c.force_n.max,
            c.force_n.max_at_s
        );
        ui.add(egui::Label::new(text).wrap());
    }
}

/// Agreement of each with the first.
pub fn agreement_ui(ui: &mut egui::Ui, chart: &ChartContext<'_>, names: &[Named], beside: &Beside) {
    for (i, (pair, (name, _))) in beside.iter().zip(names.iter().skip(1)).enumerate() {
        let Some(c) = pair else { continue };
        let Some(found) = &c.force_agreement else {
            ui.weak(format!(
                "{name}: too little in common to tell agreement from"
            ));
            continue;
        };
        let title = format!("Mean force in windows of a second: {name} against A");
        let who = name.split(' ').next().unwrap_or_default();
        let plot = figures::agreement(found, (i + 1, who), &title, chart.theme);
        ui.push_id(name, |ui| chart::plots_ui(ui, chart, &[plot]));
        ui.add(egui::Label::new(words_of(found)).wrap());
    }
    ui.weak("Windows that follow each other are not independent: the intervals are too narrow where motion is slow");
}

fn words_of(found: &BlandAltman) -> String {
    format!(
        "Bias {:.3} N (95 % {:.3} to {:.3}), limits {:.3} to {:.3} N, RMSE {:.3} N, {} windows",
        found.bias,
        found.bias_interval[0],
        found.bias_interval[1],
        found.limits[0],
        found.limits[1],
        found.rmse,
        found.n
    )
}
