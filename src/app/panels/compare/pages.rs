//! What is shown of the recordings, page by page.

/// A page of the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Page {
    /// Tables of measures.
    #[default]
    Measures,
    /// Force and depth, overlaid.
    Traces,
    /// Differences over time.
    Difference,
    /// Maps of dwell.
    Dwell,
    /// Bland–Altman.
    Agreement,
    /// Measures over sessions.
    Learning,
    /// Two groups.
    Groups,
    /// A recording against itself, felt otherwise.
    Repeat,
}

impl Page {
    /// All of them, in the order of the tabs.
    pub const ALL: [Self; 8] = [
        Self::Measures,
        Self::Traces,
        Self::Difference,
        Self::Dwell,
        Self::Agreement,
        Self::Learning,
        Self::Groups,
        Self::Repeat,
    ];

    /// On its tab.
    pub fn words(self) -> &'static str {
        match self {
            Self::Measures => "Measures",
            Self::Traces => "Traces",
            Self::Difference => "Difference",
            Self::Dwell => "Dwell",
            Self::Agreement => "Agreement",
            Self::Learning => "Learning",
            Self::Groups => "Groups",
            Self::Repeat => "Repeat",
        }
    }

    /// What it is for.
    pub fn why(self) -> &'static str {
        match self {
            Self::Measures => "Each measure of each recording, and the stiffness felt at each site",
            Self::Traces => "Force and depth over time, overlaid",
            Self::Difference => "How far the others are from A, over time",
            Self::Dwell => "How long the fingers were where on the back",
            Self::Agreement => "Difference against mean with its limits (Bland and Altman)",
            Self::Learning => "A measure over the sessions of each participant",
            Self::Groups => "Two groups: means, difference and effect size with their intervals",
            Self::Repeat => {
                "A recording against itself, felt in another scenario, with another model, engine or rate"
            }
        }
    }
}

/// The tabs.
pub fn tabs_ui(ui: &mut egui::Ui, shown: &mut Page) {
    for page in Page::ALL {
        let on = *shown == page;
        let button = ui
            .selectable_label(on, page.words())
            .on_hover_text(page.why());
        let name = format!("Page {}", page.words());
        button.widget_info(|| {
            egui::WidgetInfo::selected(egui::accesskit::Role::Tab, true, on, &name)
        });
        if button.clicked() {
            *shown = page;
        }
    }
}
