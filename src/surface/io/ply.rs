//! PLY, ascii and binary, by `ply-rs-bw`: reading the elements `vertex` and `face`, writing with fields per vertex.

use super::polygon;
use crate::geom::Vec3;
use crate::surface::RawMesh;
use crate::units::LengthUnit;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    Addable, BeginList, ElementDef, Encoding, Header, Property, PropertyAccess,
    PropertyAccessResult, PropertyDef, PropertyType, ScalarType,
};
use ply_rs_bw::writer::Writer;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Begins the comment that names the units.
const UNITS: &str = "units ";

/// Reads vertices (x, y, z of any type) and faces (a list of indices), and the units if a comment names them; everything
/// else is passed over.
pub(super) fn parse(bytes: &[u8]) -> Result<(RawMesh, Option<LengthUnit>), String> {
    let (header, mut rest) = header(bytes)?;
    check_sizes(&header, rest.len())?;
    let mut wanted = 2;
    let mut positions = Vec::new();
    let mut faces = Faces::default();
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                for axis in ["x", "y", "z"] {
                    match element.properties.get(axis).map(|p| &p.data_type) {
                        Some(PropertyType::Scalar(_)) => {}
                        _ => return Err(format!("its vertices have no number {axis}")),
                    }
                }
                positions.reserve(element.count);
                rows(&mut rest, header.encoding, element, |vertex: Vertex| {
                    positions.push(vertex.0);
                    Ok(())
                })?;
                wanted -= 1;
            }
            "face" => {
                let list = |p: &PropertyDef| {
                    is_corner_list(&p.name) && matches!(p.data_type, PropertyType::List(..))
                };
                if !element.properties.values().any(list) {
                    return Err("its faces have no list vertex_indices".into());
                }
                faces.corners.reserve(element.count * 3);
                rows(&mut rest, header.encoding, element, |face| faces.add(&face))?;
                wanted -= 1;
            }
            _ => rows(&mut rest, header.encoding, element, |_: Skipped| Ok(()))?,
        }
        if wanted == 0 {
            break;
        }
    }
    let units = (header.comments.iter())
        .find_map(|comment| LengthUnit::from_name(comment.strip_prefix(UNITS)?.trim()));
    let triangles = faces.triangles(&positions);
    let mesh = RawMesh {
        positions,
        triangles,
    };
    Ok((mesh, units))
}

/// The header, and the bytes after it.
fn header(bytes: &[u8]) -> Result<(Header, &[u8]), String> {
    let mut end = 0;
    for line in bytes.split_inclusive(|&b| b == b'\n') {
        end += line.len();
        if line.trim_ascii() == b"end_header" {
            // Comments may hold names in any encoding; the parser takes UTF-8 only.
            let text: Vec<u8> = (bytes[..end].iter())
                .map(|&b| if b.is_ascii() { b } else { b'?' })
                .collect();
            let mut reader = Reader::new(&text[..]);
            let header = Parser::<Skipped>::new().read_header(&mut reader);
            return Ok((header.map_err(|e| told(&e))?, &bytes[end..]));
        }
    }
    Err("no line end_header".into())
}

/// Refuses what the file is too short for before anything is reserved or looped over, and elements that never end.
fn check_sizes(header: &Header, available: usize) -> Result<(), String> {
    let size = |scalar: &ScalarType| match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let mut least = 0_u128;
    for element in header.elements.values() {
        let row = match header.encoding {
            // A row is a line; the last may lack its end.
            Encoding::Ascii => 1,
            _ => (element.properties.values())
                .map(|p| match &p.data_type {
                    PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
                })
                .sum(),
        };
        if row == 0 && element.count > 0 {
            return Err(format!("its element {} has no properties", element.name));
        }
        least += element.count as u128 * row as u128;
        if least > available as u128 + 1 {
            return Err(format!(
                "its header claims {} of element {}; the file is too short for that",
                element.count, element.name
            ));
        }
    }
    Ok(())
}

/// Reads all rows of one element and hands each to `take`.
fn rows<E: PropertyAccess>(
    rest: &mut &[u8],
    encoding: Encoding,
    element: &ElementDef,
    mut take: impl FnMut(E) -> Result<(), String>,
) -> Result<(), String> {
    let parser = Parser::<E>::new();
    for row in 0..element.count {
        let fail = |what: String| format!("{} {row} of {}: {what}", element.name, element.count);
        let parsed = match encoding {
            Encoding::Ascii => {
                let line = next_line(rest).ok_or_else(|| fail("the file ends".into()))?;
                parser.read_ascii_element(line.map_err(&fail)?, element)
            }
            Encoding::BinaryLittleEndian => parser.read_little_endian_element(rest, element),
            Encoding::BinaryBigEndian => parser.read_big_endian_element(rest, element),
        };
        let parsed = parsed.map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => fail("the file ends".into()),
            _ => fail(told(&e)),
        })?;
        take(parsed).map_err(fail)?;
    }
    Ok(())
}

/// The next line that is not blank.
fn next_line<'a>(rest: &mut &'a [u8]) -> Option<Result<&'a str, String>> {
    loop {
        if rest.is_empty() {
            return None;
        }
        let end = rest.iter().position(|&b| b == b'\n');
        let (line, after) = rest.split_at(end.map_or(rest.len(), |end| end + 1));
        *rest = after;
        let line = line.trim_ascii();
        if !line.is_empty() {
            return Some(std::str::from_utf8(line).map_err(|_| "not text".into()));
        }
    }
}

/// The parser's message without the line, which is told already.
fn told(error: &ParseError) -> String {
    let text = error.to_string();
    let reason = text.split_once("Error: ").map(|(_, reason)| reason);
    reason.unwrap_or(&text).to_string()
}

/// Both names are in use.
fn is_corner_list(name: &str) -> bool {
    matches!(name, "vertex_indices" | "vertex_index")
}

/// A row of which nothing is kept.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Vec3::NAN)
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let value = match value {
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Int(v) => v.into(),
            Property::UInt(v) => v.into(),
            Property::Float(v) => v.into(),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::Ignored,
        };
        match name {
            "x" => self.0.x = value,
            "y" => self.0.y = value,
            "z" => self.0.z = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// Corners as the usual types hand them over without a copy, or as any other type of whole numbers.
struct Face {
    signed: Vec<i32>,
    unsigned: Vec<u32>,
    is_whole: bool,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self {
            signed: Vec::new(),
            unsigned: Vec::new(),
            is_whole: true,
        }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if is_corner_list(name) {
            match value.to_u32_list() {
                Some(corners) => self.unsigned = corners,
                None => self.is_whole = false,
            }
        }
        PropertyAccessResult::Set
    }

    fn begin_list_int(&mut self, name: &str, _len: usize) -> BeginList<'_, i32> {
        if is_corner_list(name) {
            BeginList::Fill(&mut self.signed)
        } else {
            BeginList::UseSetter
        }
    }

    fn begin_list_uint(&mut self, name: &str, _len: usize) -> BeginList<'_, u32> {
        if is_corner_list(name) {
            BeginList::Fill(&mut self.unsigned)
        } else {
            BeginList::UseSetter
        }
    }
}

/// Faces are cut into triangles only when all vertices are known: they may come first.
#[derive(Default)]
struct Faces {
    corners: Vec<u32>,
    /// Number of faces, and where those begin that are no triangles, with their numbers of corners.
    count: usize,
    others: Vec<(usize, usize)>,
}

impl Faces {
    fn add(&mut self, face: &Face) -> Result<(), String> {
        let begin = self.corners.len();
        self.corners.extend_from_slice(&face.unsigned);
        for &v in &face.signed {
            let v = u32::try_from(v).map_err(|_| format!("vertex {v}; none is negative"))?;
            self.corners.push(v);
        }
        let n = self.corners.len() - begin;
        if !face.is_whole {
            return Err("its corners are not whole numbers from 0".into());
        }
        if n < 3 {
            return Err(format!("{n} corners; a face needs 3 or more"));
        }
        if n > 3 {
            self.others.push((begin, n));
        }
        self.count += 1;
        Ok(())
    }

    fn triangles(&self, positions: &[Vec3]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.count);
        let mut at = 0;
        for &(begin, n) in self.others.iter().chain([&(self.corners.len(), 0)]) {
            let plain = self.corners[at..begin].chunks_exact(3);
            triangles.extend(plain.map(|c| [c[0], c[1], c[2]]));
            if n > 0 {
                polygon::append(positions, &self.corners[begin..begin + n], &mut triangles);
            }
            at = begin + n;
        }
        triangles
    }
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlyEncoding {
    /// As text that reads back to the same bits.
    Ascii,
    /// Binary, least byte first.
    BinaryLittleEndian,
}

/// A number for every vertex, such as a strain.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// Name of the property, best with its unit: letters, digits and `_`, beginning with a letter.
    pub name: &'a str,
    /// One finite value for every vertex.
    pub values: &'a [f64],
}

/// Why a PLY file was not written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// The system refused.
    #[error("cannot write the mesh: {cause}: {}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        cause: String,
    },
    /// A field cannot be a property of the vertices.
    #[error("cannot write the field {name:?}: {what}")]
    Field {
        /// Its name.
        name: String,
        /// What is wrong with it.
        what: String,
    },
    /// A coordinate is not finite.
    #[error("cannot write vertex {vertex}: it lies at {at}; all coordinates must be finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// Where it lies, mm.
        at: Vec3,
    },
}

/// Writes a mesh with `fields` at its vertices. The file appears whole or not at all: it is written beside and renamed.
///
/// Positions in mm as doubles.
///
/// # Errors
/// A number is not finite, a field does not fit, or the system refuses.
pub fn write(
    path: &Path,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    fields: &[Field<'_>],
    encoding: PlyEncoding,
) -> Result<(), WriteError> {
    check_fields(positions, fields)?;
    let io = |cause: io::Error| WriteError::Io {
        path: path.to_path_buf(),
        cause: cause.to_string(),
    };
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // Temporary files are for their owner's eyes only; this one becomes a file like any other.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(io)?;
    let mut out = BufWriter::with_capacity(1 << 16, file);
    write_to(&mut out, positions, triangles, fields, encoding).map_err(io)?;
    let file = out.into_inner().map_err(|e| io(e.into_error()))?;
    file.persist(path).map_err(|e| io(e.error))?;
    Ok(())
}

fn check_fields(positions: &[Vec3], fields: &[Field<'_>]) -> Result<(), WriteError> {
    if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
        let at = positions[vertex];
        return Err(WriteError::NotFinite { vertex, at });
    }
    for (i, &Field { name, values }) in fields.iter().enumerate() {
        let starts = name.starts_with(|c: char| c.is_ascii_alphabetic());
        let taken = ["x", "y", "z"].contains(&name) || fields[..i].iter().any(|f| f.name == name);
        let what = if !starts || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            "a name consists of letters, digits and _ and begins with a letter".to_string()
        } else if taken {
            "the name is taken".to_string()
        } else if values.len() != positions.len() {
            let (found, needed) = (values.len(), positions.len());
            format!("it has {found} values; the mesh has {needed} vertices")
        } else if let Some(vertex) = values.iter().position(|v| !v.is_finite()) {
            format!("its value at vertex {vertex} is {}", values[vertex])
        } else {
            continue;
        };
        let name = name.to_string();
        return Err(WriteError::Field { name, what });
    }
    Ok(())
}

fn write_to(
    out: &mut impl Write,
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    fields: &[Field<'_>],
    encoding: PlyEncoding,
) -> io::Result<()> {
    let number = PropertyType::Scalar(ScalarType::Double);
    let mut vertex = ElementDef::new("vertex".into());
    vertex.count = positions.len();
    for name in ["x", "y", "z"]
        .into_iter()
        .chain(fields.iter().map(|f| f.name))
    {
        vertex
            .properties
            .add(PropertyDef::new(name.into(), number.clone()));
    }
    let mut face = ElementDef::new("face".into());
    face.count = triangles.len();
    face.properties.add(PropertyDef::new(
        "vertex_indices".into(),
        PropertyType::List(ScalarType::UChar, ScalarType::UInt),
    ));
    let mut header = Header::new();
    header.encoding = match encoding {
        PlyEncoding::Ascii => Encoding::Ascii,
        PlyEncoding::BinaryLittleEndian => Encoding::BinaryLittleEndian,
    };
    header.comments.push(format!("{UNITS}{}", LengthUnit::Mm));
    header.elements.add(vertex.clone());
    header.elements.add(face.clone());
    let writer = Writer::<Row<'_>>::new();
    writer.write_header(out, &header)?;
    let mut row = |element: &Row<'_>, definition: &ElementDef| match encoding {
        PlyEncoding::Ascii => writer.write_ascii_element(out, element, definition),
        PlyEncoding::BinaryLittleEndian => {
            writer.write_little_endian_element(out, element, definition)
        }
    };
    for (index, &at) in positions.iter().enumerate() {
        row(&Row::Vertex { at, index, fields }, &vertex)?;
    }
    for corners in triangles {
        row(&Row::Face(corners), &face)?;
    }
    Ok(())
}

/// What the writer asks for by name.
enum Row<'a> {
    Vertex {
        at: Vec3,
        index: usize,
        fields: &'a [Field<'a>],
    },
    Face(&'a [u32]),
}

impl PropertyAccess for Row<'_> {
    fn new() -> Self {
        Self::Face(&[])
    }

    fn get_double(&self, name: &str) -> Option<f64> {
        let Self::Vertex { at, index, fields } = self else {
            return None;
        };
        match name {
            "x" => Some(at.x),
            "y" => Some(at.y),
            "z" => Some(at.z),
            _ => {
                let field = fields.iter().find(|f| f.name == name)?;
                field.values.get(*index).copied()
            }
        }
    }

    fn get_list_uint(&self, _name: &str) -> Option<&[u32]> {
        match self {
            Self::Face(corners) => Some(corners),
            Self::Vertex { .. } => None,
        }
    }
}
