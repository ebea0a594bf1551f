//! Values as a scenario file states them.

use crate::geom::Vec2;
use toml_edit::{Array, Value};

/// A value in the program's units, for one key of a file.
#[derive(Clone, Debug)]
pub(super) enum Cell<'a> {
    Number(f64),
    /// Radians, stated in degrees.
    Degrees(f64),
    /// A change, stated in percent.
    Percent(f64),
    Text(&'a str),
    Numbers(&'a [f64]),
    Points(&'a [Vec2]),
}

impl Cell<'_> {
    /// Whether `value`, read from a file, means exactly this. Then it is left as somebody wrote it.
    pub fn is_said_by(&self, value: &Value) -> bool {
        let same = |x: f64, y: f64| x.to_bits() == y.to_bits();
        let number = |value: &Value| {
            let whole = value.as_integer().map(|n| n as f64);
            value.as_float().or(whole)
        };
        let all = |value: &Value, of: &[f64]| {
            value.as_array().is_some_and(|a| {
                let said = a.iter().map(|v| number(v).unwrap_or(f64::NAN));
                a.len() == of.len() && said.zip(of).all(|(x, y)| same(x, *y))
            })
        };
        match self {
            Self::Number(x) => number(value).is_some_and(|v| same(v, *x)),
            Self::Degrees(rad) => number(value).is_some_and(|v| same(v.to_radians(), *rad)),
            Self::Percent(change) => number(value).is_some_and(|v| same(v / 100.0, *change)),
            Self::Text(text) => value.as_str() == Some(text),
            Self::Numbers(numbers) => all(value, numbers),
            Self::Points(points) => value.as_array().is_some_and(|a| {
                let mut pairs = a.iter().zip(*points);
                a.len() == points.len() && pairs.all(|(v, p)| all(v, &[p.x, p.y]))
            }),
        }
    }

    /// How it is written. Read again it is the same, to the bit wherever the file's unit has such a number: not every angle
    /// in radians is that of a number of degrees; it then is off by a rounding.
    pub fn value(&self) -> Value {
        match self {
            Self::Number(x) => number(*x),
            Self::Degrees(rad) => number(shortest(*rad, rad.to_degrees(), f64::to_radians)),
            Self::Percent(change) => number(shortest(*change, change * 100.0, |p| p / 100.0)),
            Self::Text(text) => Value::from(*text),
            Self::Numbers(numbers) => Value::Array(numbers.iter().map(|x| number(*x)).collect()),
            Self::Points(points) => {
                let pair = |p: &Vec2| Value::Array(Array::from_iter([number(p.x), number(p.y)]));
                Value::Array(points.iter().map(pair).collect())
            }
        }
    }
}

/// 140 rather than 140.0.
pub(super) fn number(x: f64) -> Value {
    if x.fract() == 0.0 && x.abs() < 1.0e15 && !(x == 0.0 && x.is_sign_negative()) {
        Value::from(x as i64)
    } else {
        Value::from(x)
    }
}

/// The number with the fewest digits near `guess` that `read` turns into `target`; `guess` where none does.
fn shortest(target: f64, guess: f64, read: impl Fn(f64) -> f64) -> f64 {
    let fits = |x: &f64| read(*x).to_bits() == target.to_bits();
    let rounded = (0..17).filter_map(|digits| format!("{guess:.digits$e}").parse().ok());
    let beside = [guess.next_up(), guess.next_down()];
    rounded.chain(beside).find(fits).unwrap_or(guess)
}
