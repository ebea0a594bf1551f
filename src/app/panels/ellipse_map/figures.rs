//! The printed figures as map and view: Ji 2008, figures 5.8 to 5.11.

use super::doc::Doc;
use super::show::{Quantity, Show};
use crate::app::editor::plane::Area;
use crate::geom::Vec2;
use crate::maps::{AngleRule, EllipseKey, EllipseSettings, Form, Level, appendix};
use std::f64::consts::FRAC_PI_2;

/// A printed figure.
pub struct Figure {
    /// Its number and what it shows.
    pub text: &'static str,
    /// What to look at, and what is not printed.
    pub about: &'static str,
    /// Its map, over the one there is.
    pub doc: Doc,
    /// What is shown of it.
    pub show: Show,
    /// What is fitted into the canvas; nothing for the back.
    pub frame: Option<Area>,
    /// The section beside it.
    pub section: Option<[Vec2; 2]>,
}

/// Half the side of the printed square, mm.
const HALF_SQUARE_MM: f64 = 250.0;

/// All of them, made from `doc`.
pub fn all(doc: &Doc) -> Vec<Figure> {
    let square = Area {
        min: Vec2::new(-HALF_SQUARE_MM, 60.0 - HALF_SQUARE_MM),
        max: Vec2::new(HALF_SQUARE_MM, 60.0 + HALF_SQUARE_MM),
    };
    // Seen along x in the text: along the line of the keys.
    let along = [Vec2::new(0.0, square.min.y), Vec2::new(0.0, square.max.y)];
    let of_square = |form, level| {
        let settings = EllipseSettings {
            basic_radius_mm: 90.0,
            effect_radius_mm: 200.0,
            form,
            angle: AngleRule::Tensor,
            level,
        };
        Doc {
            settings,
            ..doc.with_keys(table_5_1())
        }
    };
    let plain = Show {
        outline: false,
        veiled: false,
        ellipses: false,
        ..Show::default()
    };
    let seven = Doc {
        settings: EllipseSettings::default(),
        ..doc.with_keys(appendix::seven_keys(appendix::Force::Up, None))
    };
    vec![
        Figure {
            text: "5.8 Effect ellipses in a square area",
            about: "The three key ellipses of table 5.1 at their true size, over a basic circle of 90 mm. Their minor axes are \
                    not printed: 90 mm here",
            doc: of_square(Form::Corrected, Level::Exact),
            show: Show {
                colour: false,
                lines: false,
                key_size: 1.0,
                reach: true,
                ..plain
            },
            frame: Some(square),
            section: None,
        },
        Figure {
            text: "5.9 Results do not fit the key points",
            about: "Eq. 5.7 with the array of 700: 115 and 112 at keys that state 120. The printed values come with an effect \
                    radius of 200 mm, so the 400 of the text is a diameter",
            doc: of_square(Form::Published, Level::Array),
            show: plain,
            frame: Some(square),
            section: Some(along),
        },
        Figure {
            text: "5.10 Results satisfy all the key points",
            about: "Eq. 5.16: 120 at all three keys",
            doc: of_square(Form::Corrected, Level::Exact),
            show: plain,
            frame: Some(square),
            section: Some(along),
        },
        Figure {
            text: "5.11 Half major axis on the back",
            about: "The seven key ellipses of appendix C, means of the upward force: warm where the half major axis is above \
                    the basic circle, cold where it is below, as about the waist. The basic radius is not printed: 140 mm here",
            doc: seven,
            show: Show {
                quantity: Quantity::HalfMajor,
                ellipses: false,
                key_size: 0.15,
                ..Show::default()
            },
            frame: None,
            section: None,
        },
    ]
}

/// The keys of table 5.1. Only the major axes are printed.
pub fn table_5_1() -> Vec<EllipseKey> {
    [("E1", 150.0), ("E2", 60.0), ("E3", -30.0)]
        .into_iter()
        .map(|(name, y)| EllipseKey::new(name, Vec2::new(0.0, y), 120.0, 90.0, FRAC_PI_2))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn each_figure_shows_the_printed_numbers() {
        let none = Doc {
            on: false,
            keys: Arc::default(),
            settings: EllipseSettings::default(),
        };
        let figures = all(&none);
        let at = |figure: usize, y: f64| {
            let map = figures[figure].doc.map().expect("good");
            map.at(Vec2::new(0.0, y)).half_major_mm
        };
        // METHOD.md, section 4: 115.102 and 112.204 with the array.
        assert!((at(1, 150.0) - 115.102).abs() < 5e-4, "{}", at(1, 150.0));
        assert!((at(1, 60.0) - 112.204).abs() < 5e-4, "{}", at(1, 60.0));
        for y in [150.0, 60.0, -30.0] {
            assert_eq!(at(2, y), 120.0);
        }
        let seven = &figures[3].doc;
        assert_eq!(seven.keys.len(), 7);
        let map = seven.map().expect("good");
        for key in seven.keys.iter() {
            assert!((map.at(key.at).half_major_mm - key.half_major_mm).abs() < 1e-9);
        }
        // Below the base about the waist, above it between the shoulder blades.
        let half_major = |x, y| map.at(Vec2::new(x, y)).half_major_mm;
        assert!(half_major(0.0, 116.8) < 140.0 && half_major(-100.0, 270.0) > 140.0);
    }
}
