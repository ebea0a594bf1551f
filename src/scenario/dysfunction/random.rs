//! Dysfunctions drawn at random, the same from the same seed on every machine.

use super::place::bits;
use super::{Change, DEFAULT_SEVERITY, Dysfunction, MOST_SEVERE, Site, named};

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
/// All but the strength has the default of the kind; the severity is the one whose default change is nearest to it. Empty for
/// a kind that is in no list, or without candidates.
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
        let preset = kind.default_of(site, DEFAULT_SEVERITY).preset;
        let distance = |severity: u8| {
            let change = kind.strength(preset, severity).change?;
            Some(libm::fabs(libm::log(
                change.factor() / spec.strength.factor(),
            )))
        };
        let nearest = (1..=MOST_SEVERE)
            .filter_map(|severity| Some((severity, distance(severity)?)))
            .fold(None, |best: Option<(u8, f64)>, next| match best {
                Some(best) if best.1 <= next.1 => Some(best),
                _ => Some(next),
            });
        let severity = nearest.map_or(DEFAULT_SEVERITY, |(severity, _)| severity);
        drawn.push(Dysfunction {
            change: nearest.map(|_| spec.strength),
            ..kind.default_of(site, severity)
        });
    }
    drawn
}
