//! What is shown beside the skin, and how it is kept from one run to the next.

use crate::app::render::SkinLook;
use crate::app::stereo::{Mode, Stereo};

/// The choices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Edges of the triangles.
    pub wireframe: bool,
    /// Forces as arrows.
    pub arrows: bool,
    /// How far presses reach.
    pub footprints: bool,
    /// How the skin is drawn.
    pub skin: SkinLook,
    /// What is shown of the body beside its skin.
    pub anatomy: Anatomy,
    /// For two eyes, or for one.
    pub stereo: Option<Stereo>,
    /// The eyes that were chosen, also while one is enough.
    pub eyes: Stereo,
}

/// What is shown of the body, and of the hand that palpates it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Anatomy {
    /// Bones below the skin.
    pub bones: bool,
    /// Names of landmarks.
    pub landmarks: bool,
    /// Hands in the place of fingertips.
    pub hands: bool,
}

impl Anatomy {
    const WORDS: [&'static str; 3] = ["bones", "landmarks", "hands"];

    fn parts(&mut self) -> [&mut bool; 3] {
        [&mut self.bones, &mut self.landmarks, &mut self.hands]
    }

    /// What these words name, parted by commas; "none" names nothing.
    ///
    /// # Errors
    /// The first word that is not known, with those that are.
    pub fn named(words: &str) -> Result<Self, String> {
        let mut found = Self::default();
        for word in words.split(',').map(str::trim).filter(|w| *w != "none") {
            let at = Self::WORDS.iter().position(|known| *known == word);
            match at.and_then(|i| found.parts().into_iter().nth(i)) {
                Some(part) => *part = true,
                None => {
                    return Err(format!(
                        "\"{word}\": none, {} are allowed, with commas between",
                        Self::WORDS.join(", ")
                    ));
                }
            }
        }
        Ok(found)
    }

    fn words(mut self) -> String {
        let parts = self.parts().map(|on| *on);
        let on: Vec<_> = (Self::WORDS.iter().zip(parts))
            .filter_map(|(word, on)| on.then_some(*word))
            .collect();
        on.join(",")
    }
}

/// The names of how the skin is drawn.
pub const LOOKS: [(SkinLook, &str); 3] = [
    (SkinLook::Opaque, "opaque"),
    (SkinLook::Translucent, "translucent"),
    (SkinLook::Off, "off"),
];

/// How the skin is drawn, by its name.
pub fn look_named(name: &str) -> Option<SkinLook> {
    LOOKS
        .iter()
        .find(|(_, n)| *n == name)
        .map(|(look, _)| *look)
}

impl Default for Options {
    fn default() -> Self {
        Self {
            wireframe: false,
            arrows: true,
            footprints: false,
            skin: SkinLook::Opaque,
            anatomy: Anatomy::default(),
            stereo: None,
            eyes: Stereo::default(),
        }
    }
}

impl Options {
    /// Whether bones are to be seen: opaque skin hides them.
    pub fn shows_bones(&self) -> bool {
        self.anatomy.bones && self.skin != SkinLook::Opaque
    }

    /// What is not as at first, as words with a space before each.
    pub fn kept(&self) -> String {
        let first = Self::default();
        let mut words = String::new();
        let mut put = |word: String| {
            words.push(' ');
            words.push_str(&word);
        };
        for (on, word) in [
            (self.wireframe, "wireframe"),
            (!self.arrows, "no-arrows"),
            (self.footprints, "footprints"),
        ] {
            if on {
                put(word.to_owned());
            }
        }
        if let Some((_, name)) = LOOKS.iter().find(|(look, _)| *look == self.skin)
            && self.skin != first.skin
        {
            put(format!("skin={name}"));
        }
        if self.anatomy != first.anatomy {
            put(format!("anatomy={}", self.anatomy.words()));
        }
        if let Some(stereo) = self.stereo {
            put(format!("stereo={}", stereo.mode.key()));
        }
        if self.eyes.separation_mm != first.eyes.separation_mm {
            put(format!("eyes-mm={}", self.eyes.separation_mm));
        }
        if let Some(mm) = self.eyes.convergence_mm {
            put(format!("convergence-mm={mm}"));
        }
        words
    }

    /// Takes that back; other words are not its own.
    pub fn recall(&mut self, kept: &str) {
        for word in kept.split_whitespace() {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            let number = || value.parse::<f64>().ok().filter(|x| x.is_finite());
            match key {
                "wireframe" => self.wireframe = true,
                "no-arrows" => self.arrows = false,
                "footprints" => self.footprints = true,
                // From before there was more than landmarks to be chosen.
                "landmarks" => self.anatomy.landmarks = true,
                "skin" => self.skin = look_named(value).unwrap_or(self.skin),
                "anatomy" => self.anatomy = Anatomy::named(value).unwrap_or(self.anatomy),
                "stereo" => self.choose_mode(Mode::named(value)),
                "eyes-mm" => {
                    self.eyes.separation_mm = number().unwrap_or(self.eyes.separation_mm);
                }
                "convergence-mm" => self.eyes.convergence_mm = number(),
                _ => {}
            }
        }
        self.choose_mode(self.stereo.map(|s| s.mode));
    }

    /// Shows for two eyes in this way, or for one.
    pub fn choose_mode(&mut self, mode: Option<Mode>) {
        if let Some(mode) = mode {
            self.eyes.mode = mode;
        }
        self.stereo = mode.map(|_| self.eyes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_is_taken_back_as_it_was_kept() {
        for i in 0..384_usize {
            let bit = |k: usize| i >> k & 1 == 1;
            let mut options = Options {
                wireframe: bit(0),
                arrows: bit(1),
                footprints: bit(2),
                skin: LOOKS[i / 8 % 3].0,
                anatomy: Anatomy {
                    bones: bit(3),
                    landmarks: bit(4),
                    hands: bit(5),
                },
                ..Options::default()
            };
            if bit(6) {
                options.eyes.separation_mm = 58.5;
                options.eyes.convergence_mm = Some(812.25);
            }
            options.choose_mode(Mode::ALL.get(i / 96).copied());
            let mut again = Options::default();
            again.recall(&format!("colour=skin{} unknown", options.kept()));
            // The mode is kept while it is shown.
            if options.stereo.is_none() {
                again.eyes.mode = options.eyes.mode;
            }
            assert_eq!(again, options, "{}", options.kept());
        }
    }

    #[test]
    fn what_cannot_be_read_is_left_as_it_was() {
        let mut options = Options::default();
        options
            .recall("skin=glass anatomy=bones,muscles stereo=wall eyes-mm=wide convergence-mm=NaN");
        assert_eq!(options, Options::default());
        assert!(Anatomy::named("bones,muscles").is_err_and(|e| e.contains("\"muscles\"")));
        assert_eq!(Anatomy::named("none"), Ok(Anatomy::default()));
    }

    #[test]
    fn opaque_skin_hides_bones() {
        let mut options = Options::default();
        options.recall("anatomy=bones");
        assert!(options.anatomy.bones && !options.shows_bones());
        options.recall("skin=translucent");
        assert!(options.shows_bones());
    }
}
