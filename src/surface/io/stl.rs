//! STL, ascii and binary, by `stl_io`. Every triangle has its own three vertices; validation joins them.

use crate::geom::Vec3;
use crate::surface::RawMesh;
use std::io::Cursor;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Whether the length is that of a binary file with as many triangles as it claims.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|n| bytes.len() as u64 == HEADER as u64 + n * TRIANGLE as u64)
}

/// Whether it begins like an ascii file. Binary files may begin with "solid" too.
pub(super) fn is_ascii(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    let text = start.trim_ascii_start().to_ascii_lowercase();
    let named = text
        .strip_prefix(b"solid")
        .is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace));
    let contains = |word: &[u8]| text.windows(word.len()).any(|w| w == word);
    named && !text.contains(&0) && (contains(b"facet") || contains(b"endsolid"))
}

fn claimed(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?).into())
}

/// Reads the triangles of all solids.
pub(super) fn parse(mut bytes: Vec<u8>) -> Result<RawMesh, String> {
    let mut mesh = RawMesh::default();
    if !is_binary(&bytes) && is_ascii(&bytes) {
        // `stl_io` wants lower case, "solid" followed by a space, and stops after the first solid.
        bytes.make_ascii_lowercase();
        for solid in solids(&bytes) {
            let body = &solid[solid
                .iter()
                .position(|&b| b == b'\n')
                .unwrap_or(solid.len())..];
            append(&mut mesh, [b"solid ", body].concat())?;
        }
    } else {
        let Some(n) = claimed(&bytes) else {
            let least = HEADER;
            return Err(format!(
                "{} bytes; a binary file has at least {least}",
                bytes.len()
            ));
        };
        let room = (bytes.len() - HEADER) / TRIANGLE;
        if n > room as u64 {
            return Err(format!(
                "its header claims {n} triangles, the file has room for {room}"
            ));
        }
        // Else a header that begins with "solid " would be taken for ascii.
        bytes[0] = 0;
        append(&mut mesh, bytes)?;
    }
    Ok(mesh)
}

/// The text from every line that begins with "solid" up to the next.
fn solids(text: &[u8]) -> Vec<&[u8]> {
    let mut starts = Vec::new();
    let mut at = 0;
    for line in text.split_inclusive(|&b| b == b'\n') {
        if line.trim_ascii_start().starts_with(b"solid") {
            starts.push(at);
        }
        at += line.len();
    }
    starts.push(text.len());
    starts.windows(2).map(|w| &text[w[0]..w[1]]).collect()
}

fn append(mesh: &mut RawMesh, bytes: Vec<u8>) -> Result<(), String> {
    let mut cursor = Cursor::new(bytes);
    let fail = |mesh: &RawMesh, error: std::io::Error| {
        format!("after {} triangles: {error}", mesh.triangles.len())
    };
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|e| fail(mesh, e))?;
    for triangle in triangles {
        let triangle = triangle.map_err(|e| fail(mesh, e))?;
        let first = mesh.positions.len() as u32;
        for vertex in triangle.vertices {
            mesh.positions
                .push(Vec3::from_array(vertex.0.map(f64::from)));
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(())
}
