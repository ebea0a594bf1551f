//! Dysfunctions drawn at random, the same from the same seed on every machine.

use super::place::bits;
use super::{Change, DEFAULT_SEVERITY, Dysfunction, Kind, MOST_SEVERE, Site, named};

/// What to draw.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomSpec {
    /// Key of the kind.
    pub kind: &'static str,
    /// Sites to draw from; one that stands there twice counts once.
    pub candidates: Vec<Site>,
    /// Change of stiffness; means nothing to a kind that leaves stiffness as it is.
    pub strength: Change,
    /// How many, at different sites; at most as many as there are candidates.
    pub count: usize,
    /// Another seed, another draw.
    pub seed: u64,
}

/// Draws: every candidate is as likely as every other (but for one part in 2⁵⁸), without repetition, in the order drawn.
///
/// All but the strength has the default of the kind; preset and severity are those whose default change is nearest to it, so
/// that a softer texture is an oedema and a stiffer one a fibrosis. Empty for a kind that is in no list, or without
/// candidates.
pub fn random(spec: &RandomSpec) -> Vec<Dysfunction> {
    let Some(kind) = named(spec.kind) else {
        return Vec::new();
    };
    let mut left: Vec<Site> = Vec::new();
    for site in &spec.candidates {
        if !left.contains(site) {
            left.push(*site);
        }
    }
    let mut drawn = Vec::new();
    for n in 0..spec.count.min(left.len()) as u64 {
        let i = (bits(spec.seed, n) % left.len() as u64) as usize;
        let site = left.remove(i);
        let (preset, severity, is_change) = nearest(kind, spec.strength);
        drawn.push(Dysfunction {
            preset,
            change: is_change.then_some(spec.strength),
            ..kind.default_of(site, severity)
        });
    }
    drawn
}

/// The preset and severity whose change of stiffness is nearest to `strength` as a ratio, and whether the kind changes
/// stiffness at all.
fn nearest(kind: &dyn Kind, strength: Change) -> (Option<&'static str>, u8, bool) {
    let presets: Vec<Option<&'static str>> = match kind.presets() {
        presets if kind.needs_preset() => presets.iter().map(|p| Some(p.key)).collect(),
        _ => vec![None],
    };
    let mut best = (presets.first().copied().flatten(), DEFAULT_SEVERITY, false);
    let mut least = f64::INFINITY;
    for preset in presets {
        for severity in 1..=MOST_SEVERE {
            let Some(change) = kind.strength(preset, severity).change else {
                continue;
            };
            let apart = libm::fabs(libm::log(change.factor() / strength.factor()));
            if apart < least || !best.2 {
                (best, least) = ((preset, severity, true), apart);
            }
        }
    }
    best
}
