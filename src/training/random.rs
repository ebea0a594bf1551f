//! Chance that can be repeated.

use sha2::{Digest as _, Sha256};
use std::hash::{BuildHasher as _, Hasher as _};

/// Where the chance of a run starts.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Seed {
    /// Stated by the user: the same seed gives the same trials, and it may be written down.
    Stated(u64),
    /// Nobody's business: whoever knew it would know what the trials hide, so that it is written nowhere.
    Secret(u64),
}

impl std::fmt::Debug for Seed {
    /// A secret one stays secret.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stated(seed) => write!(f, "Stated({seed})"),
            Self::Secret(_) => f.write_str("Secret"),
        }
    }
}

impl Seed {
    /// A secret one that the system draws.
    pub fn fresh() -> Self {
        let drawn = std::hash::RandomState::new();
        Self::Secret(drawn.build_hasher().finish())
    }

    /// The number, if it may be told.
    pub fn stated(self) -> Option<u64> {
        match self {
            Self::Stated(seed) => Some(seed),
            Self::Secret(_) => None,
        }
    }

    /// The chance of one trial. What one trial hid tells nothing of the next: they are joined by a hash.
    pub(super) fn of_trial(self, practice: bool, number: u32) -> Random {
        let (Self::Stated(seed) | Self::Secret(seed)) = self;
        let mut hash = Sha256::new();
        hash.update(seed.to_le_bytes());
        hash.update([u8::from(practice)]);
        hash.update(number.to_le_bytes());
        let digest: [u8; 32] = hash.finalize().into();
        let mut first = [0; 8];
        first.copy_from_slice(&digest[..8]);
        Random::new(u64::from_le_bytes(first))
    }
}

/// A stream of numbers (SplitMix64; Steele, Lea & Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// The stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// A number in 0 … 1, 1 excluded.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of 0 … n − 1, each as likely as the others (Lemire 2019); 0 where n is 0.
    pub fn below(&mut self, n: usize) -> usize {
        let wide = u128::from(self.bits()) * n as u128;
        // Of 2^64 values at most n are too many for one place: with n < 2^32 that is never noticed.
        (wide >> 64) as usize
    }

    /// A normal deviate of mean 0 and standard deviation 1 (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        // 1 − u is never 0, so that the logarithm is finite.
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(std::f64::consts::TAU * self.unit())
    }

    /// The same things in an order of chance (Fisher & Yates).
    pub fn shuffle<T>(&mut self, things: &mut [T]) {
        for i in (1..things.len()).rev() {
            things.swap(i, self.below(i + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_that_of_the_publication() {
        // First outputs for seed 1234567, as in the authors' reference code.
        let mut random = Random::new(1_234_567);
        let found = [(); 3].map(|()| random.bits());
        let printed = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
        ];
        assert_eq!(found, printed);
    }

    #[test]
    fn deviates_have_the_moments_of_the_normal_distribution() {
        let mut random = Random::new(7);
        let n = 200_000;
        let (mut sum, mut squares, mut fourth) = (0.0, 0.0, 0.0);
        for _ in 0..n {
            let z = random.normal();
            sum += z;
            squares += z * z;
            fourth += z * z * z * z;
        }
        let n = f64::from(n);
        // Five standard errors: √(1/n), √(2/n), √(96/n).
        assert!((sum / n).abs() < 5.0 / n.sqrt());
        assert!((squares / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((fourth / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
    }

    #[test]
    fn trials_share_no_chance_and_a_secret_is_not_shown() {
        let seed = Seed::Stated(3);
        let first = |practice, number| seed.of_trial(practice, number).bits();
        let all = [first(false, 1), first(false, 2), first(true, 1)];
        assert!(all[0] != all[1] && all[0] != all[2] && all[1] != all[2]);
        assert_eq!(first(false, 2), Seed::Secret(3).of_trial(false, 2).bits());
        assert_eq!(format!("{:?}", Seed::Secret(77)), "Secret");
        assert_ne!(Seed::fresh(), Seed::fresh());
        assert_eq!(Random::new(1).below(0), 0);
    }
}
