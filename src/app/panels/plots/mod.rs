//! Plots: force and penetration over time, per finger.

mod range;

use super::{Panel, PanelContext};
use crate::app::command::Command;
use crate::app::history::{Channel, History};
use crate::app::messages::clock;
use crate::app::panels::legend::swatch;
use crate::app::state::{GhostView, View};
use crate::app::widgets::{empty_ui, icon_button};
use egui_material_icons::icons as icon;
use egui_plot::{Line, LineStyle, Plot, PlotPoint, VLine};
use range::{Range, Top, WINDOWS_S, window_name};
use std::sync::{Arc, Mutex, PoisonError};

/// The panel's key.
pub const KEY: &str = "plots";

/// Letter of each finger: left, right, second left, second right.
pub const FINGER_NAMES: [&str; crate::device::MAX_FINGERS] = ["L", "R", "L2", "R2"];

/// The Plots panel.
#[derive(Debug, Default)]
pub struct Plots {
    range: Range,
    tops: [Top; Channel::ALL.len()],
    /// The history of the last frame: another one means that a recording was opened or closed.
    shown: Option<Arc<Mutex<History>>>,
    /// Time under the cursor, s.
    cursor_s: Option<f64>,
}

impl Panel for Plots {
    fn key(&self) -> &'static str {
        KEY
    }

    fn title(&self) -> &'static str {
        "Plots"
    }

    fn tooltip(&self) -> &'static str {
        "Force and penetration of each finger over time, live or of the open recording"
    }

    fn ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>) {
        if cx.view.blind {
            empty_ui(
                ui,
                icon::ICON_VISIBILITY_OFF,
                "Hidden while the exercise runs",
                "Force and depth would tell where to look",
            );
            return;
        }
        let shared = &cx.view.history;
        if !self.shown.as_ref().is_some_and(|s| Arc::ptr_eq(s, shared)) {
            self.shown = Some(shared.clone());
            self.range.follow();
            self.tops = Default::default();
        }
        let history = shared.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(span_s) = history.span_s() else {
            empty_ui(
                ui,
                icon::ICON_SHOW_CHART,
                "Nothing felt yet",
                "Touch the back in the Back view, or open a recording",
            );
            return;
        };
        let time_s = cx.view.playback.as_ref().map(|p| p.time_s);
        self.range.update(span_s, time_s);
        self.toolbar_ui(ui, cx.view);
        legend_ui(ui, cx.view);
        self.plots_ui(ui, cx, &history);
    }
}

impl Plots {
    fn toolbar_ui(&mut self, ui: &mut egui::Ui, view: &View) {
        ui.horizontal(|ui| {
            let (icon, name, tooltip) = if self.range.is_following() {
                (
                    icon::ICON_PAUSE,
                    "Pause plots",
                    "Hold the plots to look back; recording goes on. Dragging or zooming a plot does the same",
                )
            } else {
                (
                    icon::ICON_PLAY_ARROW,
                    "Follow plots",
                    "Follow the newest values again; a double click on a plot does the same",
                )
            };
            if icon_button(ui, icon, name, tooltip).clicked() {
                self.range.toggle();
            }
            let mut window_s = self.range.width_s();
            egui::ComboBox::from_id_salt("window")
                .selected_text(window_name(window_s))
                .width(76.0)
                .show_ui(ui, |ui| {
                    for choice_s in WINDOWS_S {
                        ui.selectable_value(&mut window_s, choice_s, window_name(choice_s));
                    }
                })
                .response
                .on_hover_text("How much time the plots show")
                .widget_info(|| {
                    egui::WidgetInfo::labeled(
                        egui::accesskit::Role::ComboBox,
                        true,
                        "Plotted time",
                    )
                });
            if window_s != self.range.width_s() {
                self.range.set_width(window_s);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let text = match self.cursor_s {
                    Some(s) => format!("at {}{}", clock(s), thousandths(s)),
                    None if view.playback.is_some() => "recording".into(),
                    None if self.range.is_following() => "live".into(),
                    None => "paused".into(),
                };
                ui.label(egui::RichText::new(text).monospace().weak());
            });
        });
    }

    fn plots_ui(&mut self, ui: &mut egui::Ui, cx: &PanelContext<'_>, history: &History) {
        let gaps = ui.spacing().item_spacing.y * 6.0;
        let headers = 3.0 * ui.text_style_height(&egui::TextStyle::Body);
        let axis = 20.0;
        let height = ((ui.available_height() - gaps - headers - axis) / 3.0).max(48.0);
        let (from_s, to_s) = self.range.bounds_s();
        let playing_s = cx.view.playback.as_ref().map(|p| p.time_s);
        let newest_s = history.span_s().map(|(_, end)| end);
        let read_s = self.cursor_s.or(playing_s).or(newest_s);
        let mut cursor_s = None;
        for (i, channel) in Channel::ALL.into_iter().enumerate() {
            header_ui(ui, cx.view, history, channel, read_s);
            let last = i + 1 == Channel::ALL.len();
            let theme = &cx.view.theme;
            let bins = (ui.available_width() as usize * 2).max(64);
            let mut largest = history.largest(channel, from_s, to_s);
            let ghosts: Vec<_> = (cx.view.ghosts.iter())
                .map(|ghost| {
                    let (lines, most) = ghost_lines(ghost, channel, from_s, to_s, bins);
                    largest = largest.max(most);
                    (ghost, lines)
                })
                .collect();
            let top = self.tops[i].update(largest);
            let plot = Plot::new(("plot", channel))
                .height(if last { height + axis } else { height })
                .show_axes([last, true])
                .allow_drag(false)
                .allow_zoom(false)
                .allow_scroll(false)
                .allow_boxed_zoom(false)
                .allow_double_click_reset(false)
                .show_crosshair(false)
                .label_formatter(|_| None)
                .set_margin_fraction(egui::Vec2::ZERO)
                .y_axis_min_width(34.0)
                .x_grid_spacer(move |_| range::time_marks(from_s, to_s))
                .y_grid_spacer(move |_| range::marks(top))
                .y_axis_formatter(|mark, _| value_mark(mark))
                .x_axis_formatter(|mark, range| time_mark(mark.value, *range.start(), *range.end()))
                .grid_color(theme.line);
            let response = plot.show(ui, |plot| {
                plot.set_plot_bounds_x(from_s..=to_s);
                plot.set_plot_bounds_y(-0.06 * top..=1.06 * top);
                for (finger, name) in FINGER_NAMES.iter().enumerate().take(history.n_fingers()) {
                    for run in history.line(finger, channel, from_s, to_s, bins) {
                        let points: Vec<PlotPoint> =
                            run.iter().map(|p| PlotPoint::new(p[0], p[1])).collect();
                        plot.line(
                            Line::new(*name, egui_plot::PlotPoints::Owned(points))
                                .color(theme.finger(finger))
                                .width(1.5)
                                .allow_hover(false),
                        );
                    }
                }
                for (ghost, lines) in &ghosts {
                    for (finger, points) in lines {
                        let style = match finger {
                            0 => LineStyle::Solid,
                            _ => LineStyle::dashed_dense(),
                        };
                        plot.line(
                            Line::new(&ghost.name, egui_plot::PlotPoints::Borrowed(points))
                                .color(theme.ghost(ghost.colour))
                                .style(style)
                                .width(1.2)
                                .allow_hover(false),
                        );
                    }
                }
                if let Some(s) = playing_s {
                    plot.vline(VLine::new("now", s).color(theme.accent).width(1.5));
                }
                if let Some(s) = self.cursor_s {
                    plot.vline(
                        VLine::new("cursor", s)
                            .color(theme.weak_text)
                            .style(LineStyle::dotted_dense()),
                    );
                }
                plot.response()
                    .hovered()
                    .then(|| plot.pointer_coordinate())
                    .flatten()
            });
            cursor_s = cursor_s.or(response.inner.map(|p| p.x));
            self.interact(ui, &response.response, response.inner.map(|p| p.x), cx);
        }
        if cursor_s != self.cursor_s {
            self.cursor_s = cursor_s;
            ui.ctx().request_repaint();
        }
    }

    fn interact(
        &mut self,
        ui: &egui::Ui,
        plot: &egui::Response,
        pointer_s: Option<f64>,
        cx: &PanelContext<'_>,
    ) {
        let width_px = f64::from(plot.rect.width().max(1.0));
        if plot.dragged() {
            let delta_s = f64::from(plot.drag_delta().x) / width_px * self.range.width_s();
            self.range.pan(-delta_s);
        }
        if plot.hovered() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta(), i.zoom_delta()));
            let zoom = f64::from(pinch) * libm::exp(f64::from(scroll.y) / 200.0);
            if (zoom - 1.0).abs() > 1e-4
                && let Some(at_s) = pointer_s
            {
                self.range.zoom(zoom, at_s);
            }
        }
        if plot.double_clicked() {
            self.range.follow();
        } else if plot.clicked()
            && cx.view.playback.is_some()
            && let Some(at_s) = pointer_s
        {
            cx.send.send(Command::Seek(at_s));
        }
    }
}

/// The lines of a ghost in the time on show, each with its finger, and the largest value.
fn ghost_lines(
    ghost: &GhostView,
    channel: Channel,
    from_s: f64,
    to_s: f64,
    bins: usize,
) -> (Vec<(usize, Vec<PlotPoint>)>, f64) {
    let (own_from_s, own_to_s) = (from_s - ghost.shift_s, to_s - ghost.shift_s);
    let history = ghost.history.lock().unwrap_or_else(PoisonError::into_inner);
    let mut lines = Vec::new();
    for finger in 0..history.n_fingers() {
        for run in history.line(finger, channel, own_from_s, own_to_s, bins) {
            let points = run
                .iter()
                .map(|p| PlotPoint::new(p[0] + ghost.shift_s, p[1]));
            lines.push((finger, points.collect()));
        }
    }
    (lines, history.largest(channel, own_from_s, own_to_s))
}

/// Whose the lines are beside those of the fingers.
fn legend_ui(ui: &mut egui::Ui, view: &View) {
    if view.ghosts.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        for ghost in &view.ghosts {
            swatch(ui, view.theme.ghost(ghost.colour));
            let text = egui::RichText::new(&ghost.name).size(11.5);
            ui.add(egui::Label::new(text).truncate())
                .on_hover_text("Overlaid: the left finger drawn out, the others dashed");
        }
    });
}

/// Name of a channel and the value of each finger at the cursor.
fn header_ui(
    ui: &mut egui::Ui,
    view: &View,
    history: &History,
    channel: Channel,
    at_s: Option<f64>,
) {
    ui.horizontal(|ui| {
        ui.label(egui::RichText::new(channel.label()).weak());
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for finger in (0..history.n_fingers()).rev() {
                let value = at_s.and_then(|s| history.at(finger, channel, s));
                let text = match value {
                    Some(band) => format!("{} {:>6.2}", FINGER_NAMES[finger], band.max),
                    None => format!("{} {:>6}", FINGER_NAMES[finger], "–"),
                };
                ui.label(
                    egui::RichText::new(text)
                        .monospace()
                        .color(view.theme.finger(finger)),
                );
            }
        });
    });
}

fn thousandths(time_s: f64) -> String {
    format!(".{:03}", (time_s.max(0.0).fract() * 1000.0) as u32)
}

/// A time mark as short as the span on show allows; none so near the ends that it would be cut off.
fn time_mark(time_s: f64, from_s: f64, to_s: f64) -> String {
    let span_s = to_s - from_s;
    if time_s < 0.0 || time_s > to_s - 0.03 * span_s {
        String::new()
    } else if span_s < 1.0 {
        format!("{time_s:.2} s")
    } else if span_s < 10.0 {
        format!("{time_s:.1} s")
    } else {
        clock(time_s)
    }
}

/// Labels stand at the coarse marks only.
/// The value with as many decimals as it has, at most three: the middle of an axis up to 5 is 2.5.
fn value_mark(mark: egui_plot::GridMark) -> String {
    let rounded = (mark.value * 1000.0).round() / 1000.0;
    // Adding zero turns −0 into 0.
    format!("{}", rounded + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_marks_tell_the_value_they_stand_at() {
        let text = |value| {
            value_mark(egui_plot::GridMark {
                value,
                step_size: 5.0,
            })
        };
        assert_eq!(
            [text(0.0), text(-0.0), text(2.5), text(5.0)],
            ["0", "0", "2.5", "5"]
        );
        assert_eq!(
            [text(0.25), text(0.1 + 0.2), text(5e11)],
            ["0.25", "0.3", "500000000000"]
        );
    }

    #[test]
    fn time_marks_fit_their_span() {
        assert_eq!(time_mark(1.25, 1.0, 1.5), "1.25 s");
        assert_eq!(time_mark(1.25, 0.0, 5.0), "1.2 s");
        assert_eq!(time_mark(75.0, 60.0, 120.0), "01:15");
        assert_eq!(time_mark(-1.0, -5.0, 55.0), "");
        assert_eq!(thousandths(3.0625), ".062");
    }
}
