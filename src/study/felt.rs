//! The stiffness felt at a site: how the force answered to depth when it was pressed.
//!
//! Each press near a site gives one slope, by least squares of the force along the normal on depth over its ticks. Ticks that
//! follow each other are far from independent, so that the interval is not told from them: it is that of the mean of the
//! presses' slopes, each press counting once, by Student's t. R² is that of one slope for all presses, each about its own
//! means. Strokes are left out.

use super::options::NamedPlace;
use super::presses::{Press, PressKind};
use super::stats::t_quantile;
use serde::{Deserialize, Serialize};

/// The stiffness felt at a site.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Felt {
    /// Name of the site.
    pub site: String,
    /// Where it is on the map plane, mm.
    pub at_mm: [f64; 2],
    /// Presses that have a slope.
    pub presses: u32,
    /// Their ticks.
    pub ticks: u64,
    /// Mean of their slopes, N/mm.
    pub slope_n_per_mm: f64,
    /// Ends of its 95 % interval, N/mm; absent for a single press.
    pub interval_n_per_mm: Option<[f64; 2]>,
    /// One slope through all presses, each about its own means, N/mm.
    pub pooled_n_per_mm: f64,
    /// Share of the force's variation within presses that the pooled slope explains; absent where there is none.
    pub r_squared: Option<f64>,
}

/// The stiffness felt at those `sites` that `presses` came within `near_mm` of; a press belongs to the nearest.
pub fn felt<'a>(
    presses: impl IntoIterator<Item = &'a Press>,
    sites: &[NamedPlace],
    near_mm: f64,
) -> Vec<Felt> {
    let mut at_site: Vec<Vec<(&Press, f64)>> = vec![Vec::new(); sites.len()];
    for press in presses {
        let (Some(slope), PressKind::Press) = (press.slope_n_per_mm, press.kind) else {
            continue;
        };
        let distance = |site: &NamedPlace| {
            libm::hypot(
                site.at_mm[0] - press.at_mm[0],
                site.at_mm[1] - press.at_mm[1],
            )
        };
        let measured = sites.iter().map(distance).enumerate();
        if let Some((site, far)) = measured.min_by(|a, b| a.1.total_cmp(&b.1))
            && far <= near_mm
        {
            at_site[site].push((press, slope));
        }
    }
    let pressed = sites
        .iter()
        .zip(&at_site)
        .filter(|(_, presses)| !presses.is_empty());
    pressed.map(|(site, presses)| of(site, presses)).collect()
}

fn of(site: &NamedPlace, presses: &[(&Press, f64)]) -> Felt {
    let n = presses.len() as f64;
    let mean = presses.iter().map(|p| p.1).sum::<f64>() / n;
    let squares = presses
        .iter()
        .map(|p| (p.1 - mean) * (p.1 - mean))
        .sum::<f64>();
    let interval = t_quantile(0.975, n - 1.0).map(|t| {
        let half = t * (squares / (n - 1.0) / n).sqrt();
        [mean - half, mean + half]
    });
    let sum = |i: usize| presses.iter().map(|p| p.0.squares[i]).sum::<f64>();
    let [depth, force, both] = [sum(0), sum(1), sum(2)];
    Felt {
        site: site.name.clone(),
        at_mm: site.at_mm,
        presses: presses.len() as u32,
        ticks: presses.iter().map(|p| u64::from(p.0.ticks)).sum(),
        slope_n_per_mm: mean,
        interval_n_per_mm: interval,
        pooled_n_per_mm: both / depth,
        r_squared: (force > 0.0).then(|| both * both / (depth * force)),
    }
}
