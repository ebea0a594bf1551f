//! Two pictures in one for a red filter before the left eye and a cyan one before the right.

use super::gl::{Bound, Program};
use eframe::glow;

/// What the left and the right picture add to each channel, rows red, green, blue, in linear light.
///
/// Dubois 2001 ("A projection method to generate anaglyph stereo images", values for red and cyan): the colours that, seen
/// through the filters, come nearest to those of the two pictures in CIE XYZ. Greys stay grey, lightness is kept in both eyes,
/// and skin does not flicker between bright red and dark cyan as it does where channels are merely exchanged.
pub const LEFT: [[f32; 3]; 3] = [
    [0.437, 0.449, 0.164],
    [-0.062, -0.062, -0.024],
    [-0.048, -0.050, -0.017],
];
/// The same of the right picture.
pub const RIGHT: [[f32; 3]; 3] = [
    [-0.011, -0.032, -0.007],
    [0.377, 0.761, 0.009],
    [-0.026, -0.093, 1.234],
];

/// The program that brings them together; made when an anaglyph is first shown.
#[derive(Debug)]
pub struct Anaglyph {
    program: Program,
}

impl Anaglyph {
    /// Compiles it.
    ///
    /// # Errors
    /// What the driver's compiler says.
    pub fn new(gl: &glow::Context) -> Result<Self, String> {
        Ok(Self {
            program: Program::new(
                gl,
                "anaglyph",
                include_str!("shaders/floor.vert"),
                include_str!("shaders/anaglyph.frag"),
            )?,
        })
    }

    /// Makes it current, for a texture in unit 0 with the left eye's picture on the left.
    pub fn bind<'a>(&'a self, gl: &'a glow::Context) -> Bound<'a> {
        let program = self.program.bind(gl);
        program.mat3("u_left", &columns(&LEFT));
        program.mat3("u_right", &columns(&RIGHT));
        program
    }

    /// Frees it.
    pub fn delete(self, gl: &glow::Context) {
        self.program.delete(gl);
    }
}

fn columns(rows: &[[f32; 3]; 3]) -> [f32; 9] {
    std::array::from_fn(|i| rows[i % 3][i / 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_stays_grey_and_as_bright() {
        for channel in 0..3 {
            let sum: f32 = LEFT[channel].iter().chain(&RIGHT[channel]).sum();
            assert!((sum - 1.0).abs() < 0.005, "{channel}: {sum}");
        }
    }

    #[test]
    fn red_comes_from_the_left_eye_and_the_others_from_the_right() {
        let weight = |row: &[f32; 3]| row.iter().map(|x| x.abs()).sum::<f32>();
        assert!(weight(&LEFT[0]) > 15.0 * weight(&RIGHT[0]));
        for channel in [1, 2] {
            assert!(weight(&RIGHT[channel]) > 7.0 * weight(&LEFT[channel]));
        }
        assert_eq!(columns(&LEFT)[1], LEFT[1][0]);
    }
}
