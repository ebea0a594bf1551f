//! What validation says: why a mesh is refused, what was repaired, what the repaired mesh consists of.

use crate::geom::Vec3;
use serde::Serialize;
use std::fmt;

/// The largest coordinate accepted, mm: ten kilometres. Beyond it the file's units are wrong or the number is damaged.
pub const MAX_COORDINATE_MM: f64 = 1.0e7;

/// How many elements of one kind are named; beyond them only the number is told.
const NAMED: usize = 5;

/// Why a mesh is refused. Each names the element, counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No triangle is left to touch.
    #[error("the mesh has no triangles; at least one is needed")]
    Empty,
    /// Every triangle had to be removed.
    #[error("none of the {of} triangles has an area; at least one is needed")]
    NothingLeft {
        /// How many triangles there were.
        of: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite ({value}); all must be finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
        /// The offending coordinate.
        value: f64,
    },
    /// A coordinate is too large for a mesh of a body.
    #[error(
        "vertex {vertex} has the coordinate {value:e} mm; allowed is −{MAX_COORDINATE_MM:e} to {MAX_COORDINATE_MM:e} mm"
    )]
    Absurd {
        /// Index of the vertex.
        vertex: usize,
        /// The offending coordinate, mm.
        value: f64,
    },
    /// A corner names a vertex that does not exist.
    #[error(
        "triangle {triangle} names vertex {vertex}; the mesh has {vertices} vertices, counted from 0"
    )]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The index it names.
        vertex: u64,
        /// How many vertices there are.
        vertices: usize,
    },
    /// More elements than 32-bit indices can tell apart.
    #[error(
        "the mesh has {vertices} vertices and {triangles} triangles; allowed are at most {most} of each"
    )]
    TooMany {
        /// How many vertices there are.
        vertices: usize,
        /// How many triangles there are.
        triangles: usize,
        /// How many of each are allowed.
        most: usize,
    },
}

/// A vertex or triangle of the mesh as it was handed in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Element {
    /// Index, counted from 0.
    pub index: usize,
    /// The vertex, or the middle of the triangle, mm.
    pub at_mm: [f64; 3],
}

/// An edge of the mesh as it was handed in.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// Indices of its two vertices, counted from 0.
    pub vertices: [usize; 2],
    /// How many triangles share it.
    pub triangles: usize,
    /// Its middle, mm.
    pub at_mm: [f64; 3],
}

/// How many there are, and the first few by name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found<T> {
    /// How many there are.
    pub count: usize,
    /// The first few.
    pub first: Vec<T>,
}

impl<T> Default for Found<T> {
    fn default() -> Self {
        Self {
            count: 0,
            first: Vec::new(),
        }
    }
}

impl<T> Found<T> {
    /// Counts one more, and keeps `name` if it is among the first.
    pub(super) fn add(&mut self, name: impl FnOnce() -> T) {
        self.count += 1;
        if self.first.len() < NAMED {
            self.first.push(name());
        }
    }
}

/// Something found and repaired or tolerated. Elements are those of the mesh as it was handed in.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Defect {
    /// No two triangles shared a vertex, as in STL: corners at exactly the same place were joined. The way the format
    /// is, hence no fault ([`Report::is_clean`]).
    UnsharedVertices {
        /// Number of corners.
        corners: usize,
        /// Number of places.
        places: usize,
    },
    /// Vertices at exactly the same place as an earlier one were joined to it.
    CoincidentVertices(Found<Element>),
    /// Triangles that name a vertex twice or have no area were removed, and neighbours cut where that would leave a gap.
    DegenerateTriangles(Found<Element>),
    /// Triangles with the same three vertices as an earlier one were removed.
    DuplicateTriangles(Found<Element>),
    /// Edges with more than two triangles: pairs that belong to one sheet stay joined, the others were cut along the edge.
    NonManifoldEdges(Found<Edge>),
    /// Going round the sheet one comes back on its other side; it was cut along these edges.
    NonOrientable(Found<Edge>),
    /// Triangles that still shared an edge with sheets they do not belong to were cut loose.
    CutLoose(Found<Element>),
    /// Triangles that ran against their neighbours were turned.
    FlippedTriangles(Found<Element>),
    /// Closed components that were inside out were turned.
    InsideOut(Found<Element>),
    /// Open components whose mean normal pointed into the back were turned.
    FacingInward(Found<Element>),
    /// Vertices in which sheets touch only there were doubled.
    BowTieVertices(Found<Element>),
    /// Vertices of no triangle were dropped.
    UnusedVertices(Found<Element>),
    /// The mesh is not in one piece. Nothing was changed.
    SeveralComponents {
        /// How many there are.
        count: usize,
        /// Triangles of the largest, at most five.
        triangles: Vec<usize>,
    },
    /// Rims inside a component, besides its longest. Nothing was changed.
    Holes {
        /// How many there are.
        count: usize,
        /// The longest of them.
        longest: RimLoop,
    },
}

/// A piece in which every triangle can be reached from every other across edges.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Component {
    /// Number of triangles.
    pub triangles: usize,
    /// Area, mm².
    pub area_mm2: f64,
    /// Whether it has no rim.
    pub closed: bool,
}

/// A closed line of edges that have only one triangle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RimLoop {
    /// Position of its component in [`Report::components`] before that list is cut short.
    pub component: usize,
    /// Whether it is not the longest of its component.
    pub hole: bool,
    /// Number of edges.
    pub edges: usize,
    /// Length, mm.
    pub perimeter_mm: f64,
    /// One of its vertices, mm.
    pub at_mm: [f64; 3],
}

/// What validation found and did, and what the repaired mesh consists of.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// In the order found.
    pub defects: Vec<Defect>,
    /// Number of components.
    pub n_components: usize,
    /// The components with the most triangles, at most [`Report::LISTED`], largest first.
    pub components: Vec<Component>,
    /// Number of rim loops.
    pub n_rims: usize,
    /// The longest rim loops, at most [`Report::LISTED`], longest first.
    pub rims: Vec<RimLoop>,
}

impl Report {
    /// How many components and rims are listed at most.
    pub const LISTED: usize = 16;

    /// Whether there is nothing to complain of.
    pub fn is_clean(&self) -> bool {
        (self.defects.iter()).all(|d| matches!(d, Defect::UnsharedVertices { .. }))
    }

    /// Whether a triangle or vertex had to be changed.
    pub fn is_repaired(&self) -> bool {
        (self.defects.iter()).any(|d| {
            !matches!(
                d,
                Defect::UnsharedVertices { .. }
                    | Defect::SeveralComponents { .. }
                    | Defect::Holes { .. }
            )
        })
    }

    /// The longest rim loop, if there is any.
    pub fn rim(&self) -> Option<&RimLoop> {
        self.rims.first()
    }
}

/// One defect a line.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<_> = self.defects.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnsharedVertices { corners, places } => write!(
                f,
                "{corners} corners shared no vertex: joined into {places} by equal position"
            ),
            Self::CoincidentVertices(v) => told(
                f,
                v,
                "vertex",
                "vertices",
                "at the place of an earlier one, joined to it",
            ),
            Self::DegenerateTriangles(t) => {
                told(f, t, "triangle", "triangles", "without area, removed")
            }
            Self::DuplicateTriangles(t) => told(
                f,
                t,
                "triangle",
                "triangles",
                "with the corners of an earlier one, removed",
            ),
            Self::NonManifoldEdges(e) => told(
                f,
                e,
                "edge",
                "edges",
                "with more than two triangles, cut so that each sheet is one of its own",
            ),
            Self::NonOrientable(e) => told(
                f,
                e,
                "edge",
                "edges",
                "across which the sheet turns into its other side, cut",
            ),
            Self::CutLoose(t) => told(
                f,
                t,
                "triangle",
                "triangles",
                "that fitted to no sheet, cut loose",
            ),
            Self::FlippedTriangles(t) => told(
                f,
                t,
                "triangle",
                "triangles",
                "against the orientation of the neighbours, turned",
            ),
            Self::InsideOut(t) => told(
                f,
                t,
                "closed component",
                "closed components",
                "inside out, turned (named by the first triangle)",
            ),
            Self::FacingInward(t) => told(
                f,
                t,
                "open component",
                "open components",
                "facing into the back, turned (named by the first triangle)",
            ),
            Self::BowTieVertices(v) => told(
                f,
                v,
                "vertex",
                "vertices",
                "in which sheets touch in a point, doubled",
            ),
            Self::UnusedVertices(v) => told(f, v, "vertex", "vertices", "of no triangle, dropped"),
            Self::SeveralComponents { count, triangles } => {
                let sizes: Vec<_> = triangles.iter().map(ToString::to_string).collect();
                let more = if *count > triangles.len() {
                    ", …"
                } else {
                    ""
                };
                write!(
                    f,
                    "{count} components, not one, kept: {}{more} triangles",
                    sizes.join(", ")
                )
            }
            Self::Holes { count, longest } => write!(
                f,
                "{} besides the rim, kept: the longest has {} edges, {:.1} mm, at {}",
                counted(*count, "hole", "holes"),
                longest.edges,
                longest.perimeter_mm,
                place(longest.at_mm)
            ),
        }
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {}", self.index, place(self.at_mm))
    }
}

impl fmt::Display for Edge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.vertices;
        write!(
            f,
            "{a}–{b} ({} triangles) at {}",
            self.triangles,
            place(self.at_mm)
        )
    }
}

impl Element {
    pub(super) fn new(index: usize, at: Vec3) -> Self {
        Self {
            index,
            at_mm: at.to_array(),
        }
    }
}

fn told<T: fmt::Display>(
    f: &mut fmt::Formatter<'_>,
    found: &Found<T>,
    one: &str,
    many: &str,
    what: &str,
) -> fmt::Result {
    let names: Vec<_> = found.first.iter().map(ToString::to_string).collect();
    write!(
        f,
        "{} {what}: {}",
        counted(found.count, one, many),
        names.join(", ")
    )?;
    match found.count - found.first.len() {
        0 => Ok(()),
        more => write!(f, " and {more} more"),
    }
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({x:.2}, {y:.2}, {z:.2})")
}
