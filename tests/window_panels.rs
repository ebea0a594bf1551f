//! Every listed panel draws every state, dark and light, with a name on every control.
#![cfg(feature = "gui")]

mod support;

use dorsum::app::command;
use dorsum::app::dock;
use dorsum::app::panels::{self, PanelContext};
use dorsum::app::theme::Theme;
use egui_kittest::Harness;
use std::collections::HashSet;
use std::sync::Arc;

#[test]
fn every_panel_draws_every_state_dark_and_light_without_a_gpu() {
    let (send, _commands) = command::queue(Arc::new(|| {}));
    for dark in [true, false] {
        for (state, mut view) in support::views() {
            view.theme = Theme::of(dark);
            for slot in dock::slots(panels::all()).iter() {
                for size in [[420.0, 480.0], [200.0, 120.0], [1000.0, 700.0]] {
                    println!("{} {state} dark={dark} {size:?}", slot.key);
                    let cx = PanelContext {
                        view: &view,
                        send: &send,
                    };
                    let theme = view.theme;
                    let mut harness = Harness::builder()
                        .with_size(size)
                        .with_context_setup(move |ctx| {
                            egui_material_icons::initialize(ctx);
                            theme.apply(ctx);
                        })
                        .build_ui(|ui| dock::draw(ui, slot, &cx));
                    harness.run_steps(3);
                    harness.check_accessibility();
                }
            }
        }
    }
}

#[test]
fn panels_have_distinct_keys_and_titles_and_say_why() {
    let mut seen = HashSet::new();
    for panel in panels::all() {
        assert!(seen.insert(panel.key()) && seen.insert(panel.title()));
        assert!(panel.tooltip().len() > panel.title().len());
    }
}
