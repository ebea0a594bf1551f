//! Where names stand beside what they name, so that none covers another. Pure: rectangles in, places out.

use egui::{Pos2, Rect, Vec2, vec2};

/// A name that wants a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// What it names.
    pub at: Pos2,
    /// Size of its text.
    pub size: Vec2,
    /// Whether it would rather stand on the left.
    pub on_left: bool,
    /// The lower, the sooner it gets a place.
    pub rank: u8,
}

/// Room between a name and what it names, points.
const BESIDE: f32 = 9.0;
/// Room around a name, points.
const AROUND: Vec2 = vec2(4.0, 1.5);
/// Steps up and down beside what is named, heights of the text: the nearest that is free is taken.
const STEPS: [f32; 5] = [0.0, -0.8, 0.8, -1.5, 1.5];

/// A place for each name, in the order of the wishes: its text's rectangle, within `within`, clear of every other name, of
/// `taken` and of what other names name. `None` where there is no room: then the name is left out.
pub fn placed(wishes: &[Wish], taken: &[Rect], within: Rect) -> Vec<Option<Rect>> {
    let mut order: Vec<usize> = (0..wishes.len()).collect();
    order.sort_by_key(|&i| wishes[i].rank);
    let mut held: Vec<Rect> = taken.to_vec();
    let mut places = vec![None; wishes.len()];
    for i in order {
        let wish = &wishes[i];
        let free = |place: &Rect| {
            let around = place.expand2(AROUND);
            within.contains_rect(around)
                && !held.iter().any(|other| other.intersects(around))
                && !(wishes.iter()).any(|other| place.contains(other.at))
        };
        let sides = [wish.on_left, !wish.on_left];
        let mut tries = sides.into_iter().flat_map(|on_left| {
            STEPS.into_iter().map(move |step| {
                let x = if on_left {
                    wish.at.x - BESIDE - wish.size.x
                } else {
                    wish.at.x + BESIDE
                };
                let y = wish.at.y + (step - 0.5) * wish.size.y;
                Rect::from_min_size(Pos2::new(x, y), wish.size)
            })
        });
        if let Some(place) = tries.find(free) {
            held.push(place.expand2(AROUND));
            places[i] = Some(place);
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    const WITHIN: Rect = Rect {
        min: Pos2::new(0.0, 0.0),
        max: Pos2::new(400.0, 300.0),
    };

    fn wish(x: f32, y: f32, rank: u8) -> Wish {
        Wish {
            at: pos2(x, y),
            size: vec2(30.0, 12.0),
            on_left: false,
            rank,
        }
    }

    fn check(wishes: &[Wish], taken: &[Rect]) -> Vec<Option<Rect>> {
        let places = placed(wishes, taken, WITHIN);
        assert_eq!(places.len(), wishes.len());
        let found: Vec<Rect> = places.iter().flatten().copied().collect();
        for (i, a) in found.iter().enumerate() {
            assert!(WITHIN.contains_rect(*a));
            assert!(found[i + 1..].iter().all(|b| !a.intersects(*b)));
            assert!(taken.iter().all(|b| !a.intersects(*b)));
            assert!(wishes.iter().all(|w| !a.contains(w.at)));
        }
        places
    }

    #[test]
    fn a_name_with_room_stands_beside_what_it_names() {
        let places = check(&[wish(100.0, 100.0, 0)], &[]);
        let place = places[0].unwrap();
        assert_eq!((place.min.x, place.center().y), (109.0, 100.0));
        let left = Wish {
            on_left: true,
            ..wish(100.0, 100.0, 0)
        };
        assert_eq!(check(&[left], &[])[0].unwrap().max.x, 91.0);
    }

    #[test]
    fn names_never_overlap_however_crowded_and_the_first_in_rank_stay() {
        // A lattice of points closer and closer.
        for step in [40.0, 20.0, 10.0, 5.0, 2.0] {
            let wishes: Vec<Wish> = (0..100)
                .map(|i| {
                    let (row, column) = ((i / 10) as f32, (i % 10) as f32);
                    wish(20.0 + column * step, 20.0 + row * step, u8::from(i != 55))
                })
                .collect();
            let places = check(&wishes, &[]);
            let n = places.iter().flatten().count();
            assert!(n >= 1 && (step < 40.0 || n > 50), "{n} at {step}");
            if step >= 20.0 {
                assert!(places[55].is_some());
            }
        }
    }

    #[test]
    fn what_is_taken_stays_clear_and_without_room_there_is_no_name() {
        let taken = [Rect::from_min_max(pos2(105.0, 0.0), pos2(400.0, 300.0))];
        let places = check(&[wish(100.0, 100.0, 0)], &taken);
        assert!(places[0].unwrap().max.x < 100.0);
        assert_eq!(check(&[wish(100.0, 100.0, 0)], &[WITHIN]), [None]);
        let far = Wish {
            at: pos2(f32::NAN, 1e9),
            ..wish(0.0, 0.0, 0)
        };
        assert_eq!(check(&[far], &[]), [None]);
    }
}
