//! Wavefront OBJ: vertices and faces, by `tobj`.

use super::polygon;
use crate::geom::Vec3;
use crate::surface::RawMesh;
use std::io::{self, BufRead, Read};
use tobj::{LoadError, LoadOptions};

/// Every vertex stands as a point of its own in what `tobj` gives back, which keeps the order of the file.
const OPTIONS: LoadOptions = LoadOptions {
    single_index: false,
    triangulate: false,
    ignore_points: false,
    ignore_lines: false,
};

/// Whether one of the first lines is that of an OBJ file.
pub(super) fn is_obj(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(64 << 10)];
    !start.contains(&0)
        && start.split(|&b| b == b'\n' || b == b'\r').any(|line| {
            let mut words = words(line);
            matches!(words.next(), Some(b"v" | b"f")) && words.count() >= 3
        })
}

/// Reads vertices and faces; everything else in the file is passed over.
pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, String> {
    let mut lines = Lines::new(bytes);
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut lines, &OPTIONS, no_materials).map_err(|error| {
        let Lines { number, fault, .. } = lines;
        match (fault, error) {
            (Some(fault), _) => fault,
            (None, LoadError::FaceVertexOutOfBounds) => {
                missing_vertex(bytes).unwrap_or_else(|| error.to_string())
            }
            (None, LoadError::ReadError) => format!("line {number} is not text"),
            (None, _) => format!("line {number}: {error}"),
        }
    })?;
    let mut mesh = RawMesh::default();
    for model in models {
        let tobj::Mesh {
            positions,
            indices,
            face_arities,
            ..
        } = model.mesh;
        let first = mesh.positions.len() as u32;
        mesh.positions
            .extend((positions.chunks_exact(3)).map(|p| Vec3::new(p[0], p[1], p[2])));
        let mut rest = &indices[..];
        for arity in face_arities {
            let Some((corners, after)) = rest.split_at_checked(arity as usize) else {
                break;
            };
            rest = after;
            if corners.len() >= 3 {
                let corners: Vec<u32> = corners.iter().map(|v| v + first).collect();
                polygon::append(&mesh.positions, &corners, &mut mesh.triangles);
            }
        }
    }
    Ok(mesh)
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
}

/// Hands `tobj` only what it needs and counts lines for messages: vertices without colour, each followed by a point that
/// uses it; faces without texture and normal indices; no groups and materials, which would part the mesh.
struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the line handed out last, from 1.
    number: usize,
    out: Vec<u8>,
    at: usize,
    fault: Option<String>,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            number: 0,
            out: Vec::new(),
            at: 0,
            fault: None,
        }
    }

    fn next_line(&mut self) -> &'a [u8] {
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &self.rest[..0]),
        };
        self.rest = rest;
        line
    }

    /// The next vertex or face with the lines that continue it; nothing at the end of the file.
    fn statement(&mut self) -> Option<(bool, Vec<&'a [u8]>)> {
        while !self.rest.is_empty() {
            let line = self.next_line();
            let mut parts = words(line);
            let is_vertex = match parts.next() {
                Some(b"v") => true,
                Some(b"f") => false,
                _ => continue,
            };
            let mut all: Vec<_> = parts.collect();
            while all.last().is_some_and(|w| w.ends_with(b"\\")) && !self.rest.is_empty() {
                if let Some(last) = all.pop()
                    && last.len() > 1
                {
                    all.push(&last[..last.len() - 1]);
                }
                all.extend(words(self.next_line()));
            }
            if let Some(comment) = all.iter().position(|w| w.starts_with(b"#")) {
                all.truncate(comment);
            }
            return Some((is_vertex, all));
        }
        None
    }

    fn refill(&mut self) -> io::Result<()> {
        self.out.clear();
        self.at = 0;
        let Some((is_vertex, parts)) = self.statement() else {
            return Ok(());
        };
        if is_vertex {
            // Three coordinates and perhaps a weight; six or more are coordinates and a colour.
            let kept = if parts.len() == 4 { 4 } else { 3 };
            self.out.push(b'v');
            for part in parts.iter().take(kept) {
                self.out.push(b' ');
                self.out.extend_from_slice(part);
            }
            self.out.extend_from_slice(b"\nf -1\n");
        } else {
            if parts.len() < 3 {
                let (number, corners) = (self.number, parts.len());
                let fault =
                    format!("line {number}: a face with {corners} corners; it needs 3 or more");
                self.fault = Some(fault);
                return Err(io::ErrorKind::InvalidData.into());
            }
            self.out.push(b'f');
            for part in parts {
                self.out.push(b' ');
                self.out.extend(part.iter().take_while(|&&b| b != b'/'));
            }
            self.out.push(b'\n');
        }
        Ok(())
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(buffer)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at >= self.out.len() {
            self.refill()?;
        }
        Ok(&self.out[self.at..])
    }

    fn consume(&mut self, n: usize) {
        self.at += n;
    }
}

/// Names the first face whose corner names no vertex.
fn missing_vertex(bytes: &[u8]) -> Option<String> {
    let mut lines = Lines::new(bytes);
    let mut total = 0_i64;
    while let Some((is_vertex, _)) = lines.statement() {
        total += i64::from(is_vertex);
    }
    let mut lines = Lines::new(bytes);
    let mut so_far = 0_i64;
    while let Some((is_vertex, parts)) = lines.statement() {
        if is_vertex {
            so_far += 1;
            continue;
        }
        for part in parts {
            let index = part.split(|&b| b == b'/').next()?;
            let index: i64 = std::str::from_utf8(index).ok()?.parse().ok()?;
            // Negative indices count back from the vertex read last.
            if index == 0 || index > total || index < -so_far {
                let line = lines.number;
                return Some(format!(
                    "line {line}: a face names vertex {index}; the file has vertices 1 to {total}"
                ));
            }
        }
    }
    None
}
