//! What the makers say of their devices: the figures that defaults, limits and tests are held against.

/// One device, as published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Name.
    pub name: &'static str,
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Highest stiffness rendered stably at 1 kHz, N/mm.
    pub max_stiffness_n_per_mm: f64,
    /// Radius of the workspace, mm.
    pub workspace_radius_mm: f64,
}

const fn figures(name: &'static str, force: f64, stiffness: f64, radius: f64) -> Figures {
    Figures {
        name,
        rated_force_n: force,
        max_stiffness_n_per_mm: stiffness,
        workspace_radius_mm: radius,
    }
}

/// Devices of the field. They are the specifications that their drivers state to a 1 kHz loop; one sphere stands for
/// workspaces that are boxes in the data sheets.
pub static PUBLISHED: [Figures; 8] = [
    figures("Touch", 3.3, 0.4, 75.0),
    figures("Omni", 3.3, 0.7, 100.0),
    figures("Premium 1.5", 8.5, 0.8, 120.0),
    figures("Premium 3.0", 22.0, 1.0, 250.0),
    figures("Falcon", 8.0, 3.0, 40.0),
    figures("omega.3", 12.0, 5.0, 75.0),
    figures("delta.3", 20.0, 5.0, 150.0),
    figures("WoodenHaptics", 5.0, 1.0, 100.0),
];

/// The figures of the device called `name`, whatever the case.
pub fn of(name: &str) -> Option<&'static Figures> {
    PUBLISHED.iter().find(|f| f.name.eq_ignore_ascii_case(name))
}

/// Largest stiffness at which a sampled spring is passive, N/mm: k < 2 (b − |B|) / T, with the physical damping b and the
/// virtual damping B, both N·s/mm, and the sampling interval T, s (Colgate and Schenkel 1997). No damping to spare: 0.
pub fn passive_stiffness_n_per_mm(damping: f64, virtual_damping: f64, interval_s: f64) -> f64 {
    let spare = damping - virtual_damping.abs();
    if spare > 0.0 && interval_s > 0.0 {
        2.0 * spare / interval_s
    } else {
        0.0
    }
}

/// Largest stiffness at which neither sampling nor encoder steps feed energy in, N/mm: min(2b/T, 2f/Δ) with damping b,
/// N·s/mm, Coulomb friction f, N, interval T, s, and encoder step Δ, mm (Abbott and Okamura 2005). A bound that is not
/// there (T or Δ = 0) does not count.
pub fn quantised_stiffness_n_per_mm(
    damping: f64,
    coulomb_n: f64,
    interval_s: f64,
    step_mm: f64,
) -> f64 {
    let bound = |over: f64, by: f64| {
        if by > 0.0 {
            (2.0 * over / by).max(0.0)
        } else {
            f64::INFINITY
        }
    };
    bound(damping, interval_s).min(bound(coulomb_n, step_mm))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// METHOD, section 7.
    #[test]
    fn the_table_is_that_of_the_method() {
        let told = "Touch 3.3/0.4/75, Omni 3.3/0.7/100, Premium 1.5 8.5/0.8/120, Premium 3.0 22/1/250, Falcon 8/3/40, \
                    omega.3 12/5/75, delta.3 20/5/150, WoodenHaptics 5/1/100";
        let ours: Vec<String> = PUBLISHED
            .iter()
            .map(|f| {
                format!(
                    "{} {}/{}/{}",
                    f.name, f.rated_force_n, f.max_stiffness_n_per_mm, f.workspace_radius_mm
                )
            })
            .collect();
        assert_eq!(ours.join(", "), told);
        assert_eq!(of("touch"), Some(&PUBLISHED[0]));
        assert_eq!(of("touchy"), None);
    }

    /// METHOD, section 7: k = 0.5 N/mm at 1 kHz needs 0.25e-3 N·s/mm.
    #[test]
    fn half_a_newton_a_millimetre_needs_a_quarter_of_a_newton_second_a_metre() {
        assert!((passive_stiffness_n_per_mm(0.25e-3, 0.0, 0.001) - 0.5).abs() < 1e-12);
        assert!((passive_stiffness_n_per_mm(0.75e-3, -0.5e-3, 0.001) - 0.5).abs() < 1e-12);
        assert_eq!(passive_stiffness_n_per_mm(0.1e-3, 0.2e-3, 0.001), 0.0);
        assert_eq!(passive_stiffness_n_per_mm(f64::NAN, 0.0, 0.001), 0.0);
    }

    #[test]
    fn the_smaller_of_both_bounds_counts() {
        assert!((quantised_stiffness_n_per_mm(0.5e-3, 0.2, 0.001, 0.02) - 1.0).abs() < 1e-12);
        assert!((quantised_stiffness_n_per_mm(0.5e-3, 0.002, 0.001, 0.02) - 0.2).abs() < 1e-12);
        assert_eq!(
            quantised_stiffness_n_per_mm(0.5e-3, 0.2, 0.0, 0.0),
            f64::INFINITY
        );
    }
}
