//! The method of constant stimuli: the same levels over and over, in an order of chance.

use super::{Estimate, Rule, Settings, Staircase};
use crate::training::random::Random;

/// Constant stimuli.
pub struct Constant;

impl Rule for Constant {
    fn key(&self) -> &'static str {
        "constant"
    }

    fn title(&self) -> &'static str {
        "Constant stimuli"
    }

    fn about(&self) -> &'static str {
        "The stated levels in blocks, each once a block, in an order of chance; the threshold comes from the fit (Fechner 1860)"
    }

    fn target(&self, _: &Settings) -> Option<f64> {
        None
    }

    fn start(&self, settings: &Settings) -> Box<dyn Staircase> {
        let stated = settings.constant.iter();
        let mut levels: Vec<f64> = stated
            .map(|level| level.clamp(settings.least, settings.most))
            .collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        if levels.is_empty() {
            levels.push(settings.start);
        }
        Box::new(Blocks {
            used: vec![0; levels.len()],
            levels,
        })
    }
}

struct Blocks {
    levels: Vec<f64>,
    used: Vec<u32>,
}

impl Staircase for Blocks {
    fn level(&mut self, random: &mut Random) -> f64 {
        let least = self.used.iter().min().copied().unwrap_or(0);
        let left = || (0..self.used.len()).filter(|&i| self.used[i] == least);
        let chosen = left().nth(random.below(left().count()));
        self.levels[chosen.unwrap_or(0)]
    }

    fn answered(&mut self, level: f64, _: bool) {
        let distance = |i: &usize| (self.levels[*i] - level).abs();
        let nearest = (0..self.levels.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(i) = nearest {
            self.used[i] += 1;
        }
    }

    fn is_done(&self) -> bool {
        false
    }

    fn reversals(&self) -> &[f64] {
        &[]
    }

    fn estimate(&self) -> Option<Estimate> {
        None
    }
}
