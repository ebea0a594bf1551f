//! Every colour of the window, in one table per brightness.
//!
//! One accent colour. Blue and red belong to the left and the right finger and to nothing else: warnings are amber and
//! faults are told by words, an icon and a magenta that no finger wears.

use egui::Color32;

/// Colours of a tree of cells, as the dissertation draws them, in tones that no finger wears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeColors {
    /// Leaves: a blue near cyan.
    pub leaf: Color32,
    /// Inner nodes.
    pub node: Color32,
    /// Planes across x, y and z: green, a red near brown, yellow.
    pub planes: [Color32; 3],
    /// Haptic triangles and their box.
    pub haptic: Color32,
}

/// Colours of one brightness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Theme {
    /// Whether the window is dark.
    pub dark: bool,
    /// Behind everything.
    pub background: Color32,
    /// Of panels.
    pub panel: Color32,
    /// Of text fields and plots: a step away from the panel.
    pub inset: Color32,
    /// Of hairlines and grids.
    pub line: Color32,
    /// Of text.
    pub text: Color32,
    /// Of text that matters less.
    pub weak_text: Color32,
    /// The one accent: selection, primary buttons, focus.
    pub accent: Color32,
    /// Text on the accent.
    pub on_accent: Color32,
    /// All is well.
    pub good: Color32,
    /// Look at this.
    pub warning: Color32,
    /// This does not work.
    pub fault: Color32,
    /// Left and right finger, then a second left and right one.
    pub fingers: [Color32; crate::device::MAX_FINGERS],
    /// The floor behind the skin, at the top and at the bottom.
    pub floor: [Color32; 2],
    /// Recordings that are overlaid on another: none comes near a finger's colour.
    pub ghosts: [Color32; 6],
    /// A tree of cells over the skin.
    pub tree: TreeColors,
}

/// The dark table.
pub const DARK: Theme = Theme {
    dark: true,
    background: Color32::from_rgb(22, 24, 27),
    panel: Color32::from_rgb(31, 33, 37),
    inset: Color32::from_rgb(24, 26, 29),
    line: Color32::from_rgb(58, 62, 68),
    text: Color32::from_rgb(222, 225, 229),
    weak_text: Color32::from_rgb(154, 160, 168),
    accent: Color32::from_rgb(62, 166, 156),
    on_accent: Color32::from_rgb(10, 24, 22),
    good: Color32::from_rgb(112, 190, 126),
    warning: Color32::from_rgb(226, 174, 74),
    fault: Color32::from_rgb(226, 112, 196),
    fingers: [
        Color32::from_rgb(88, 158, 255),
        Color32::from_rgb(255, 98, 88),
        Color32::from_rgb(150, 198, 255),
        Color32::from_rgb(255, 160, 150),
    ],
    floor: [Color32::from_rgb(58, 63, 70), Color32::from_rgb(30, 33, 37)],
    ghosts: [
        Color32::from_rgb(240, 200, 72),
        Color32::from_rgb(118, 208, 116),
        Color32::from_rgb(202, 150, 255),
        Color32::from_rgb(84, 214, 206),
        Color32::from_rgb(236, 236, 236),
        Color32::from_rgb(190, 150, 104),
    ],
    tree: TreeColors {
        leaf: Color32::from_rgb(64, 224, 232),
        node: Color32::from_rgb(168, 172, 178),
        planes: [
            Color32::from_rgb(128, 178, 66),
            Color32::from_rgb(178, 104, 36),
            Color32::from_rgb(238, 214, 72),
        ],
        haptic: Color32::from_rgb(64, 240, 120),
    },
};

/// The light table.
pub const LIGHT: Theme = Theme {
    dark: false,
    background: Color32::from_rgb(226, 228, 231),
    panel: Color32::from_rgb(245, 246, 247),
    inset: Color32::from_rgb(255, 255, 255),
    line: Color32::from_rgb(204, 208, 213),
    text: Color32::from_rgb(34, 37, 41),
    weak_text: Color32::from_rgb(98, 104, 112),
    accent: Color32::from_rgb(14, 122, 112),
    on_accent: Color32::from_rgb(255, 255, 255),
    good: Color32::from_rgb(38, 128, 60),
    warning: Color32::from_rgb(158, 102, 0),
    fault: Color32::from_rgb(166, 32, 132),
    fingers: [
        Color32::from_rgb(24, 98, 214),
        Color32::from_rgb(208, 42, 34),
        Color32::from_rgb(96, 150, 226),
        Color32::from_rgb(222, 116, 108),
    ],
    floor: [
        Color32::from_rgb(236, 238, 241),
        Color32::from_rgb(198, 203, 209),
    ],
    ghosts: [
        Color32::from_rgb(168, 118, 0),
        Color32::from_rgb(30, 128, 48),
        Color32::from_rgb(122, 58, 190),
        Color32::from_rgb(0, 128, 132),
        Color32::from_rgb(70, 74, 80),
        Color32::from_rgb(126, 88, 44),
    ],
    tree: TreeColors {
        leaf: Color32::from_rgb(0, 152, 168),
        node: Color32::from_rgb(104, 108, 114),
        planes: [
            Color32::from_rgb(86, 132, 22),
            Color32::from_rgb(140, 76, 10),
            Color32::from_rgb(190, 156, 0),
        ],
        haptic: Color32::from_rgb(0, 176, 64),
    },
};

impl Theme {
    /// The table for a dark or a light window.
    pub fn of(dark: bool) -> Self {
        if dark { DARK } else { LIGHT }
    }

    /// Colour of finger `index`; indices past the last repeat.
    pub fn finger(&self, index: usize) -> Color32 {
        self.fingers[index % self.fingers.len()]
    }

    /// Colour of ghost `index`; indices past the last repeat.
    pub fn ghost(&self, index: usize) -> Color32 {
        self.ghosts[index % self.ghosts.len()]
    }

    /// Puts the table into `ctx`'s style.
    pub fn apply(&self, ctx: &egui::Context) {
        let theme = if self.dark {
            egui::Theme::Dark
        } else {
            egui::Theme::Light
        };
        ctx.set_theme(theme);
        let mut visuals = if self.dark {
            egui::Visuals::dark()
        } else {
            egui::Visuals::light()
        };
        visuals.panel_fill = self.panel;
        visuals.window_fill = self.panel;
        visuals.extreme_bg_color = self.inset;
        visuals.faint_bg_color = self.panel.lerp_to_gamma(self.inset, 0.6);
        visuals.hyperlink_color = self.accent;
        visuals.warn_fg_color = self.warning;
        visuals.error_fg_color = self.fault;
        visuals.weak_text_color = Some(self.weak_text);
        visuals.selection.bg_fill = self.accent;
        visuals.selection.stroke.color = self.on_accent;
        visuals.window_stroke.color = self.line;
        visuals.widgets.noninteractive.fg_stroke.color = self.text;
        visuals.widgets.noninteractive.bg_stroke.color = self.line;
        visuals.widgets.inactive.fg_stroke.color = self.text;
        ctx.set_visuals_of(theme, visuals);
        ctx.all_styles_mut(|style| {
            style.spacing.item_spacing = egui::vec2(8.0, 6.0);
            style.spacing.button_padding = egui::vec2(8.0, 3.0);
            style.interaction.tooltip_delay = 0.4;
        });
    }
}
