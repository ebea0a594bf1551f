//! Small pieces that several panels draw.

use super::command::{Action, CommandSender};
use egui_material_icons::MaterialIcon;

/// A button that shows an icon, with a name for a screen reader and a tooltip that says why.
pub fn icon_button(
    ui: &mut egui::Ui,
    icon: MaterialIcon,
    name: &str,
    tooltip: &str,
) -> egui::Response {
    let response = ui.add(egui::Button::new(icon.rich_text().size(16.0)).frame(false));
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Button, ui.is_enabled(), name)
    });
    response.on_hover_text(tooltip)
}

/// The text of a tooltip with its key.
pub fn with_key(ctx: &egui::Context, tooltip: &str, action: Action) -> String {
    match action.spec().shortcut {
        Some(shortcut) => format!("{tooltip} ({})", ctx.format_shortcut(&shortcut)),
        None => tooltip.to_owned(),
    }
}

/// A button with icon and text that sends an action.
pub fn action_button(
    ui: &mut egui::Ui,
    send: &CommandSender,
    action: Action,
    text: &str,
) -> egui::Response {
    let spec = action.spec();
    let response = ui
        .button((spec.icon.rich_text(), text))
        .on_hover_text(with_key(ui.ctx(), spec.tooltip, action));
    named(ui, &response, text);
    if response.clicked() {
        send.act(action);
    }
    response
}

/// Gives a button the name a screen reader says.
pub fn named(ui: &egui::Ui, response: &egui::Response, name: &str) {
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Button, ui.is_enabled(), name)
    });
}

/// What an empty panel says: what it will show and what to do next.
pub fn empty_ui(ui: &mut egui::Ui, icon: MaterialIcon, headline: &str, next: &str) {
    ui.vertical_centered(|ui| {
        ui.add_space((ui.available_height() * 0.3).clamp(8.0, 120.0));
        ui.label(icon.rich_text().size(28.0).weak());
        ui.label(egui::RichText::new(headline).strong());
        ui.label(egui::RichText::new(next).weak());
    });
}

/// Bytes as a number of steady width with its unit.
pub fn bytes(n: u64) -> String {
    let n = n as f64;
    if n < 1e3 {
        format!("{n:.0} B")
    } else if n < 1e6 {
        format!("{:.1} kB", n / 1e3)
    } else if n < 1e9 {
        format!("{:.1} MB", n / 1e6)
    } else {
        format!("{:.2} GB", n / 1e9)
    }
}

/// A time with three figures and its unit.
pub fn time(us: f64) -> String {
    if us < 10.0 {
        format!("{us:.2} µs")
    } else if us < 100.0 {
        format!("{us:.1} µs")
    } else if us < 1e3 {
        format!("{us:.0} µs")
    } else if us < 1e4 {
        format!("{:.2} ms", us / 1e3)
    } else if us < 1e5 {
        format!("{:.1} ms", us / 1e3)
    } else {
        format!("{:.0} ms", us / 1e3)
    }
}

/// A count with commas between thousands.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn bytes_have_units() {
        assert_eq!(super::bytes(999), "999 B");
        assert_eq!(super::bytes(1500), "1.5 kB");
        assert_eq!(super::bytes(2_000_000), "2.0 MB");
        assert_eq!(super::bytes(3_500_000_000), "3.50 GB");
    }

    #[test]
    fn numbers_read_well() {
        assert_eq!(super::grouped(2_000_000), "2,000,000");
        assert_eq!(super::grouped(962), "962");
        assert_eq!(super::time(0.523), "0.52 µs");
        assert_eq!(super::time(12345.6), "12.3 ms");
        assert_eq!(super::time(345_678.0), "346 ms");
    }
}
