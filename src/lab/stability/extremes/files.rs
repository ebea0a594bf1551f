//! Files that state what is no number: scenarios, meshes.

use super::row::{Case, Ended, Size, Tally};
use crate::scenario::{Scenario, examples};
use crate::surface::Surface;
use crate::surface::io::{self, Format};
use crate::units::LengthUnit;

/// What a file may state in place of a number.
const WORDS: [&str; 9] = [
    "nan", "-nan", "inf", "-inf", "1e400", "-1e400", "1e308", "1e-400", "5e-324",
];

/// Scenarios and meshes.
pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for example in examples() {
        cases.push(Case::new(
            format!("scenario {}", example.file),
            "Scenario::parse",
            "each of its numbers in turn nan, inf, ±1e400, 1e308, 1e-400, 5e-324",
            move |size| scenario(size, example.text),
        ));
    }
    type Make = fn(&str) -> Vec<u8>;
    let meshes: [(&str, Format, Make); 5] = [
        ("OBJ, coordinate", Format::Obj, |x| {
            format!("v 0 0 0\nv {x} 0 0\nv 0 1 0\nf 1 2 3\n").into_bytes()
        }),
        ("OBJ, corner", Format::Obj, |x| {
            format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {x}\n").into_bytes()
        }),
        ("PLY, coordinate", Format::Ply, |x| {
            ply(&format!("0 0 0\n1 {x} 0\n0 1 0\n"), "3 0 1 2\n")
        }),
        ("PLY, corner", Format::Ply, |x| {
            ply("0 0 0\n1 0 0\n0 1 0\n", &format!("3 0 1 {x}\n"))
        }),
        ("STL, coordinate", Format::Stl, |x| {
            format!(
                "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 {x}\n\
                 vertex 0 1 0\nendloop\nendfacet\nendsolid s\n"
            )
            .into_bytes()
        }),
    ];
    for (name, format, make) in meshes {
        for word in WORDS {
            cases.push(Case::new(
                format!("{name} {word}"),
                "surface::io::parse, Surface::new",
                "a triangle that states it",
                move |_| mesh(make(word), format),
            ));
        }
    }
    for (name, bits) in [
        ("NaN", f32::NAN),
        ("infinity", f32::INFINITY),
        ("−infinity", f32::NEG_INFINITY),
        ("3e38", 3.0e38),
        ("the least number", f32::from_bits(1)),
    ] {
        cases.push(Case::new(
            format!("binary STL, {name}"),
            "surface::io::parse, Surface::new",
            "a triangle that holds it",
            move |_| mesh(binary_stl(bits, 1), Format::Stl),
        ));
    }
    cases.push(Case::new(
        "binary STL that states 4 294 967 295 triangles",
        "surface::io::parse",
        "134 bytes of it",
        |_| mesh(binary_stl(1.0, u32::MAX), Format::Stl),
    ));
    cases
}

fn ply(vertices: &str, faces: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n\
         property double z\nelement face 1\nproperty list uchar int vertex_indices\n\
         end_header\n{vertices}{faces}"
    )
    .into_bytes()
}

fn binary_stl(x: f32, n: u32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(n.to_le_bytes());
    for v in [[0.0, 0.0, 1.0], [0.0; 3], [x, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(v.into_iter().flat_map(f32::to_le_bytes));
    }
    bytes.extend([0, 0]);
    bytes
}

/// A mesh is refused with a line, or every coordinate of what it makes is finite.
fn mesh(bytes: Vec<u8>, format: Format) -> Ended {
    let raw = match io::parse(bytes, Some(format), Some(LengthUnit::Mm)) {
        Ok((raw, _)) => raw,
        Err(why) => return Ended::refused(why),
    };
    let surface = match Surface::new(raw) {
        Ok((surface, _)) => surface,
        Err(why) => return Ended::refused(why),
    };
    let mut tally = Tally::default();
    for (p, n) in surface.positions().iter().zip(surface.normals()) {
        tally.lengths(p.to_array());
        tally.numbers(n.to_array());
    }
    Ended::bounded(tally, "let in: coordinates and normals finite")
}

/// Places of the numbers in a scenario: after `=` or in a list, not in words and comments.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or_default();
        let bytes = code.as_bytes();
        let mut i = code.find('=').map_or(bytes.len(), |e| e + 1);
        let mut quoted = false;
        while i < bytes.len() {
            let digit = |b: u8| b.is_ascii_digit();
            quoted ^= bytes[i] == b'"';
            let starts = digit(bytes[i]) || (bytes[i] == b'-' && i + 1 < bytes.len());
            if quoted || !starts || bytes[i - 1].is_ascii_alphanumeric() || bytes[i - 1] == b'_' {
                i += 1;
                continue;
            }
            let start = i;
            while i < bytes.len() && (digit(bytes[i]) || b"-.e".contains(&bytes[i])) {
                i += 1;
            }
            found.push(at + start..at + i);
        }
        at += line.len();
    }
    found
}

/// With any number replaced a scenario is refused with a line, or what it says is finite.
fn scenario(size: &Size, text: &str) -> Ended {
    if let Err(why) = Scenario::parse(text, "s.toml", None) {
        return Ended::wrong(why.to_string());
    }
    let places = numbers(text);
    let step = if size.quick { 7 } else { 1 };
    let words = if size.quick { &WORDS[..3] } else { &WORDS };
    let mut tally = Tally::default();
    let (mut refused, mut let_in) = (0, 0);
    let mut line = String::new();
    for place in places.iter().step_by(step) {
        for word in words {
            let mut changed = text.to_owned();
            changed.replace_range(place.clone(), word);
            match Scenario::parse(&changed, "s.toml", None) {
                Err(why) => {
                    let why = why.to_string();
                    if why.trim().is_empty() || why.lines().count() != 1 {
                        return Ended::wrong(format!("{word}: {why:?}"));
                    }
                    tally.answers += 1;
                    refused += 1;
                    if line.is_empty() {
                        line = why;
                    }
                }
                Ok(read) => {
                    let_in += 1;
                    let keys = read.stiffness_keys.iter();
                    tally.numbers(keys.flat_map(|k| [k.at.x, k.at.y, k.stiffness_n_per_mm]));
                    let friction = read.friction.iter();
                    tally.numbers(friction.flat_map(|f| {
                        [
                            f.static_coefficient,
                            f.dynamic_coefficient,
                            f.skin_looseness,
                        ]
                    }));
                    let d = &read.deform;
                    tally.numbers([
                        d.half_major_mm,
                        d.half_minor_mm,
                        d.max_normal_mm,
                        d.max_tangential_mm,
                        read.choices.finger_radius_mm,
                    ]);
                    // What is no number must not get in at all.
                    if word.contains("nan") || word.contains("inf") || word.contains("e400") {
                        return Ended::wrong(format!(
                            "{word} in place of {} is let in",
                            &text[place.clone()]
                        ));
                    }
                }
            }
        }
    }
    if refused == 0 {
        return Ended::wrong("nothing was refused");
    }
    Ended::checked(
        tally,
        &format!(
            "{refused} refused with a line, {let_in} within what is allowed; the first: {line}"
        ),
        None,
    )
}
