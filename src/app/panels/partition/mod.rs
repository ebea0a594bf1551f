//! The Partition panel: a published tree of cells over the skin, seen, measured and asked.
//!
//! | file | answers |
//! |---|---|
//! | `controls` | which tree, where its box stands, what is drawn |
//! | `numbers` | what the box gathers, the leaf under the cursor, statistics |
//! | `picture` | the skin with the tree over it |

mod controls;
mod numbers;
mod picture;

use super::{Panel, PanelContext};
use crate::app::bench::Wake;
use crate::app::dock::Home;
use crate::app::state::View;
use crate::app::widgets::empty_ui;
use egui_material_icons::icons as icon;
use picture::TreePicture;
use std::sync::Arc;

/// Key of the panel.
pub const KEY: &str = "partition";
/// Width of controls and numbers beside the picture, points.
const SIDE: f32 = 336.0;
/// From this width on the picture has its place beside the controls, points.
const WIDE: f32 = 680.0;

/// The Partition panel.
#[derive(Default)]
pub struct PartitionPanel {
    picture: TreePicture,
}

impl Panel for PartitionPanel {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Partition"
    }

    fn tooltip(&self) -> &'static str {
        "The published search trees over this skin: look at them, measure them, see what a haptic pass gathers"
    }

    fn home(&self) -> Home {
        Home::Main
    }

    fn opens_at_first(&self) -> bool {
        false
    }

    fn release(&mut self, view: &View) {
        view.study.lock().release(view);
        self.picture.release(view);
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        let Some(scene) = &cx.view.scene else {
            let next = if cx.view.build.is_some() {
                "The scene is being built; its tree comes next"
            } else {
                "Open a scene: its tree is built at once"
            };
            empty_ui(ui, icon::ICON_ACCOUNT_TREE, "No tree yet", next);
            return;
        };
        let wake = wake(ui.ctx());
        let shown = {
            let mut study = cx.view.study.lock();
            study.follow(cx.view, &wake);
            study.shown()
        };
        let mut settings = shown.settings;
        let whole = ui.available_rect_before_wrap();
        let (picture, side) = split(
            whole,
            cx.view.gl.is_some() && self.picture.fault().is_none(),
        );
        if let Some(rect) = picture {
            self.picture.ui(ui, rect, cx, scene, &shown, &mut settings);
        }
        let builder = egui::UiBuilder::new()
            .max_rect(side.shrink2(egui::vec2(8.0, 6.0)))
            .layout(egui::Layout::top_down(egui::Align::Min));
        ui.scope_builder(builder, |ui| {
            ui.set_clip_rect(ui.clip_rect().intersect(side));
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| {
                    // The bar of the scroll area lies over the right end of what it scrolls.
                    ui.set_max_width(ui.available_width() - 8.0);
                    controls::show(ui, cx, scene, &shown, &mut settings);
                    ui.separator();
                    numbers::show(ui, &shown, &cx.view.theme);
                });
        });
        ui.advance_cursor_after_rect(whole);
        if settings != shown.settings {
            cx.view.study.lock().choose(settings);
            ui.ctx().request_repaint();
        }
    }
}

/// Wakes the window that draws `ctx` now, and the main one, which may show the tree too.
pub fn wake(ctx: &egui::Context) -> Wake {
    let (ctx, here) = (ctx.clone(), ctx.viewport_id());
    Arc::new(move || {
        ctx.request_repaint_of(here);
        if here != egui::ViewportId::ROOT {
            ctx.request_repaint_of(egui::ViewportId::ROOT);
        }
    })
}

/// Where picture and controls go: side by side where there is room, else one above the other, else controls alone.
fn split(whole: egui::Rect, can_draw: bool) -> (Option<egui::Rect>, egui::Rect) {
    if !can_draw {
        return (None, whole);
    }
    if whole.width() >= WIDE {
        let (left, right) = whole.split_left_right_at_x(whole.right() - SIDE);
        return (Some(left), right);
    }
    if whole.height() >= 300.0 && whole.width() >= 160.0 {
        let (top, bottom) = whole.split_top_bottom_at_y(whole.top() + whole.height() * 0.45);
        return (Some(top), bottom);
    }
    (None, whole)
}
