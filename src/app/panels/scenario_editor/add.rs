//! A new dysfunction: which kind, how severe, and where without a pointer.

use super::State;
use crate::app::editor::parts::{choose, pick, row};
use crate::app::panels::PanelContext;
use crate::app::widgets::named;
use crate::scenario::dysfunction::{self, DEFAULT_SEVERITY, MOST_SEVERE, side_name};
use crate::scenario::{Kind, Place, Side, Site, SurfaceChoice, Target, VertebralLevel};
use egui::RichText;

/// What is added next.
pub struct Add {
    kind: &'static str,
    /// How severe it is.
    pub severity: u8,
    site: Option<Site>,
}

impl Default for Add {
    fn default() -> Self {
        let first = dysfunction::all().first();
        Self {
            kind: first.map_or("", |kind| kind.key()),
            severity: DEFAULT_SEVERITY,
            site: VertebralLevel::named("T5").map(|level| Site {
                level,
                side: Side::Right,
                target: Target::Transverse,
            }),
        }
    }
}

impl Add {
    /// The kind.
    pub fn kind(&self) -> Option<&'static dyn Kind> {
        dysfunction::named(self.kind)
    }
}

/// Every kind as something to choose.
pub fn kinds(now: &str) -> impl Iterator<Item = (String, bool, &'static dyn Kind)> {
    let kinds = dysfunction::all().iter();
    kinds.map(move |kind| (kind.title().to_owned(), kind.key() == now, *kind))
}

/// Severities as buttons; which one was picked.
pub fn severities(ui: &mut egui::Ui, of: &str, now: u8) -> Option<u8> {
    let mut picked = None;
    for severity in 0..=MOST_SEVERE {
        let name = format!("Severity {severity} of {of}");
        let why = format!("{severity}: {}", super::wording::severity(severity));
        if pick(ui, now == severity, &severity.to_string(), &name, &why) && now != severity {
            picked = Some(severity);
        }
    }
    picked
}

/// Shows it.
pub fn show(ui: &mut egui::Ui, cx: &PanelContext<'_>, state: &mut State) {
    let width = (ui.available_width() - 110.0).clamp(90.0, 240.0);
    let add = &mut state.add;
    row(ui, "Kind", "What a click on the back adds", |ui| {
        let now = add.kind().map_or("", |k| k.title());
        let why = "What a click on the back adds";
        if let Some(kind) = choose(ui, "Kind to add", why, now, width, kinds(add.kind)) {
            add.kind = kind.key();
        }
    });
    if let Some(kind) = add.kind() {
        ui.label(RichText::new(kind.about()).size(12.0).weak());
    }
    row(
        ui,
        "Severity",
        "How severe it is: its kind says how strong that is",
        |ui| {
            if let Some(severity) = severities(ui, "what is added", add.severity) {
                add.severity = severity;
            }
            ui.weak(super::wording::severity(add.severity));
        },
    );
    let on_back = cx
        .view
        .scene
        .as_ref()
        .is_some_and(|s| matches!(s.scenario.surface, SurfaceChoice::BuiltinBack { .. }));
    if !on_back {
        ui.weak("Double-click the map to add one there");
        if ui
            .button("Add in the middle")
            .on_hover_text("Add one in the middle of the view")
            .clicked()
        {
            let at = state.canvas.middle();
            super::add(state, Place::At(super::doc::tidy_place(at)));
        }
        return;
    }
    let Some(site) = &mut add.site else {
        return;
    };
    let mut place = None;
    row(
        ui,
        "Where",
        "Click a site on the back, or choose one here",
        |ui| {
            let levels = VertebralLevel::all().map(|l| (l.name().to_owned(), l == site.level, l));
            let why = "Which vertebra";
            if let Some(level) = choose(ui, "Level to add at", why, site.level.name(), 40.0, levels)
            {
                site.level = level;
            }
            let sides = [Side::Left, Side::Middle, Side::Right];
            let sides = sides.map(|s| (side_name(s).to_owned(), s == site.side, s));
            let why = "Which side of the subject; the middle has the spinous process alone";
            let now = side_name(site.side);
            if let Some(side) = choose(ui, "Side to add at", why, now, 56.0, sides) {
                site.side = side;
                if side == Side::Middle {
                    site.target = Target::Spinous;
                }
            }
            let targets = Target::all().iter();
            let targets = targets.map(|t| (t.title().to_owned(), *t == site.target, *t));
            let why = "What of the vertebra";
            let now = site.target.name();
            if let Some(target) = choose(ui, "Target to add at", why, now, 84.0, targets) {
                site.target = target;
                if site.side == Side::Middle && target != Target::Spinous {
                    site.side = Side::Right;
                }
            }
        },
    );
    ui.horizontal(|ui| {
        let button = ui
            .button("Add here")
            .on_hover_text("Add one of this kind at this place");
        named(ui, &button, "Add dysfunction");
        if button.clicked() {
            place = Some(Place::from(*site));
        }
        ui.weak("or click a site on the back");
    });
    if let Some(place) = place {
        super::add(state, place);
    }
}
