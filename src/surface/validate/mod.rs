//! What is wrong with a mesh, what of it can be repaired, and what is refused.
//!
//! Steps, each on the result of the one before: refuse numbers and indices nothing can be made of; join vertices at the
//! same place; remove triangles without area and doubles; drop unused vertices; join triangles across edges; turn them to
//! face one way; double vertices where sheets touch in a point; number all anew so that neighbours are near in memory.
//! All of it costs time in proportion to the mesh, or sorting at most. Until the last step numbers ascend as in the mesh
//! handed in, so the first of a kind is the first there, and every element is named by its number there.

mod cut;
mod flat;
mod orient;
mod report;
mod weld;

#[cfg(test)]
mod tests;

use super::edges::{HalfEdges, ends, join};
use super::order::{Ordered, ordered};
use super::{RIM, RawMesh, Topology};
use crate::geom::{Triangle, Vec3};
use orient::{Pieces, orient};
pub use report::{
    Component, Defect, Edge, Element, Found, MAX_COORDINATE_MM, MeshError, Report, RimLoop,
};

/// The repaired mesh with its adjacency, and what was found.
#[derive(Debug)]
pub(super) struct Repaired {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub topology: Topology,
    pub report: Report,
}

/// A mesh under repair.
struct Sheet {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    across: Vec<[u32; 3]>,
    /// Index in the mesh handed in of every vertex and triangle.
    vertex_ids: Vec<u32>,
    triangle_ids: Vec<u32>,
}

/// Checks `raw`, repairs what can be repaired and lists it.
pub(super) fn repair(mut raw: RawMesh) -> Result<Repaired, MeshError> {
    refuse_unusable(&mut raw)?;
    let of = raw.triangles.len();
    let mut sheet = Sheet {
        vertex_ids: (0..raw.positions.len() as u32).collect(),
        triangle_ids: (0..of as u32).collect(),
        across: Vec::new(),
        positions: raw.positions,
        triangles: raw.triangles,
    };
    let mut defects = Vec::new();
    let joined = sheet.join_coincident(&mut defects);
    defects.extend(flat::remove_flat(&mut sheet).told(Defect::DegenerateTriangles));
    if sheet.triangles.is_empty() {
        return Err(MeshError::NothingLeft { of });
    }
    let unused = sheet.drop_unused(joined.as_deref());
    let (crooked, mut cut_ends) = sheet.join_triangles(&mut defects);
    defects.extend(unused.told(Defect::UnusedVertices));

    let mut pieces = orient(&mut sheet, crooked, &mut cut_ends, &mut defects);
    cut_ends.sort_unstable();
    let n = sheet.positions.len();
    let (mut mesh, mut topology, n_fans) = sheet.renumbered();
    if n_fans > n || !cut_ends.is_empty() {
        let mut doubled = cut::split_fans(&mut sheet);
        let loose = cut::cut_loose(&mut sheet);
        if !loose.is_empty() {
            defects.extend(sheet.found(&loose).told(Defect::CutLoose));
            pieces = orient(&mut sheet, false, &mut cut_ends, &mut defects);
            cut::split_fans(&mut sheet);
        }
        doubled.retain(|v| cut_ends.binary_search(v).is_err() && (*v as usize) < n);
        let mut bow_ties = Found::default();
        for v in doubled {
            bow_ties.add(|| sheet.named_vertex(v));
        }
        defects.extend(bow_ties.told(Defect::BowTieVertices));
        (mesh, topology, _) = sheet.renumbered();
    }
    drop(sheet);
    let mut report = Report {
        defects,
        ..Report::default()
    };
    describe(&mesh, &topology, &pieces, &mut report);
    Ok(Repaired {
        positions: mesh.positions,
        triangles: mesh.triangles,
        topology,
        report,
    })
}

/// Also turns negative zeros into zeros, so that equal places have equal bits.
fn refuse_unusable(raw: &mut RawMesh) -> Result<(), MeshError> {
    let (vertices, triangles) = (raw.positions.len(), raw.triangles.len());
    let most = u32::MAX as usize / 3;
    if triangles == 0 {
        return Err(MeshError::Empty);
    }
    if vertices > most || triangles > most {
        return Err(MeshError::TooMany {
            vertices,
            triangles,
            most,
        });
    }
    for (vertex, p) in raw.positions.iter_mut().enumerate() {
        if let Some(value) = p.to_array().into_iter().find(|x| !x.is_finite()) {
            return Err(MeshError::NotFinite { vertex, value });
        }
        if let Some(value) = (p.to_array().into_iter()).find(|x| x.abs() > MAX_COORDINATE_MM) {
            return Err(MeshError::Absurd { vertex, value });
        }
        *p += Vec3::ZERO;
    }
    for (triangle, corners) in raw.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(MeshError::IndexOutOfRange {
                triangle,
                vertex: vertex.into(),
                vertices,
            });
        }
    }
    Ok(())
}

impl Sheet {
    /// The mesh as a surface numbers it, its adjacency, and the number of fans.
    fn renumbered(&self) -> (Ordered, Topology, usize) {
        let mut mesh = ordered(&self.positions, &self.triangles, &self.across);
        let across = std::mem::take(&mut mesh.across);
        let (topology, n_fans) =
            Topology::from_across(mesh.positions.len(), &mesh.triangles, across);
        (mesh, topology, n_fans)
    }

    fn triangle(&self, t: u32) -> Triangle {
        let [a, b, c] = self.triangles[t as usize].map(|v| self.positions[v as usize]);
        Triangle { a, b, c }
    }

    fn named(&self, t: u32) -> Element {
        let index = self.triangle_ids[t as usize] as usize;
        Element::new(index, self.triangle(t).centroid())
    }

    fn named_vertex(&self, v: u32) -> Element {
        let index = self.vertex_ids[v as usize] as usize;
        Element::new(index, self.positions[v as usize])
    }

    fn found(&self, triangles: &[u32]) -> Found<Element> {
        let mut found = Found::default();
        for &t in triangles {
            found.add(|| self.named(t));
        }
        found
    }

    /// Removes the triangles listed in ascending order.
    fn remove(&mut self, listed: &[u32]) -> Found<Element> {
        let found = self.found(listed);
        if let Some(&first) = listed.first() {
            let mut listed = listed.iter().copied().peekable();
            let mut kept = first as usize;
            for t in first..self.triangles.len() as u32 {
                if listed.next_if_eq(&t).is_none() {
                    self.triangles[kept] = self.triangles[t as usize];
                    self.triangle_ids[kept] = self.triangle_ids[t as usize];
                    kept += 1;
                }
            }
            self.triangles.truncate(kept);
            self.triangle_ids.truncate(kept);
        }
        found
    }

    /// Lets every corner name the first vertex at its place. Returns that vertex for each, where any differ.
    fn join_coincident(&mut self, defects: &mut Vec<Defect>) -> Option<Vec<u32>> {
        let first = weld::first_at_place(&self.positions)?;
        let corners = self.triangles.len() * 3;
        let unshared = corners == self.positions.len()
            && (self.triangles.iter().flatten().copied()).eq(0..corners as u32);
        let mut joined = Found::default();
        for (v, &at) in first.iter().enumerate() {
            if at as usize != v {
                joined.add(|| self.named_vertex(v as u32));
            }
        }
        if unshared {
            let places = corners - joined.count;
            defects.push(Defect::UnsharedVertices { corners, places });
        } else {
            defects.push(Defect::CoincidentVertices(joined));
        }
        for v in self.triangles.iter_mut().flatten() {
            *v = first[*v as usize];
        }
        Some(first)
    }

    /// Drops vertices of no triangle; tells of those that were not joined to another.
    fn drop_unused(&mut self, joined: Option<&[u32]>) -> Found<Element> {
        const UNUSED: u32 = u32::MAX;
        let mut unused = Found::default();
        let mut place = vec![UNUSED; self.positions.len()];
        for &v in self.triangles.iter().flatten() {
            place[v as usize] = 0;
        }
        let mut next = 0;
        for v in 0..place.len() {
            if place[v] == UNUSED {
                if joined.is_none_or(|first| first[v] as usize == v) {
                    unused.add(|| self.named_vertex(v as u32));
                }
                continue;
            }
            place[v] = next;
            self.positions[next as usize] = self.positions[v];
            self.vertex_ids[next as usize] = self.vertex_ids[v];
            next += 1;
        }
        if (next as usize) < place.len() {
            self.positions.truncate(next as usize);
            self.vertex_ids.truncate(next as usize);
            for v in self.triangles.iter_mut().flatten() {
                *v = place[*v as usize];
            }
        }
        unused
    }

    /// Removes doubles and joins triangles across edges. Returns whether any two joined triangles run their edge the same
    /// way, and the ends of edges that had to be cut.
    fn join_triangles(&mut self, defects: &mut Vec<Defect>) -> (bool, Vec<u32>) {
        let mut crowded: Vec<Vec<u32>>;
        let mut crooked;
        loop {
            (crowded, crooked) = (Vec::new(), false);
            let mut doubles = Vec::new();
            let mut across = vec![[RIM; 3]; self.triangles.len()];
            let triangles = &self.triangles;
            let edges = HalfEdges::new(self.positions.len(), triangles);
            edges.for_each(|_, _, group| match *group {
                [_] => {}
                [g, h] => {
                    let ([from, _, over], [other_from, _, other_over]) =
                        (ends(triangles, g), ends(triangles, h));
                    if over == other_over {
                        doubles.push(h / 3);
                    } else {
                        crooked |= from == other_from;
                        join(&mut across, g, h);
                    }
                }
                _ => {
                    let mut over: Vec<_> =
                        (group.iter().map(|&h| (ends(triangles, h)[2], h))).collect();
                    over.sort_unstable();
                    let n_doubles = doubles.len();
                    doubles.extend(
                        (over.windows(2))
                            .filter(|w| w[0].0 == w[1].0)
                            .map(|w| w[1].1 / 3),
                    );
                    if doubles.len() == n_doubles {
                        crowded.push(group.to_vec());
                    }
                }
            });
            self.across = across;
            if doubles.is_empty() {
                break;
            }
            doubles.sort_unstable();
            doubles.dedup();
            defects.extend(self.remove(&doubles).told(Defect::DuplicateTriangles));
        }
        let mut found = Found::default();
        let mut cut_ends = Vec::new();
        let mut pairs = Vec::new();
        for group in &crowded {
            found.add(|| self.named_edge(group[0], group.len()));
            let [a, b, _] = ends(&self.triangles, group[0]);
            cut_ends.extend([a, b]);
            pairs.extend(cut::pairs(self, group));
        }
        for (g, h) in pairs {
            crooked |= ends(&self.triangles, g)[0] == ends(&self.triangles, h)[0];
            join(&mut self.across, g, h);
        }
        defects.extend(found.told(Defect::NonManifoldEdges));
        (crooked, cut_ends)
    }
}

impl<T> Found<T> {
    /// The defect, if there is anything to tell.
    fn told(self, kind: impl FnOnce(Self) -> Defect) -> Option<Defect> {
        (self.count > 0).then(|| kind(self))
    }
}

/// Enters the components and rims of the repaired mesh.
fn describe(mesh: &Ordered, topology: &Topology, pieces: &Pieces, report: &mut Report) {
    let mut order: Vec<u32> = (0..pieces.list.len() as u32).collect();
    order.sort_by_key(|&p| std::cmp::Reverse(pieces.list[p as usize].triangles));
    let mut rank = vec![0; order.len()];
    for (place, &p) in order.iter().enumerate() {
        rank[p as usize] = place;
    }
    report.n_components = order.len();
    report.components = (order.iter().take(Report::LISTED))
        .map(|&p| &pieces.list[p as usize])
        .map(|piece| Component {
            triangles: piece.triangles,
            area_mm2: piece.area_mm2,
            closed: piece.rim_edges == 0,
        })
        .collect();
    if order.len() > 1 {
        report.defects.push(Defect::SeveralComponents {
            count: order.len(),
            triangles: (report.components.iter().take(5))
                .map(|c| c.triangles)
                .collect(),
        });
    }
    let mut rims = rims(&mesh.positions, &mesh.triangles, topology);
    for rim in &mut rims {
        let piece = pieces.of[mesh.was[rim.component] as usize];
        rim.component = rank[piece as usize];
    }
    rims.sort_by(|a, b| b.perimeter_mm.total_cmp(&a.perimeter_mm));
    let mut has_rim = vec![false; order.len()];
    for rim in &mut rims {
        rim.hole = std::mem::replace(&mut has_rim[rim.component], true);
    }
    if let Some(longest) = rims.iter().find(|rim| rim.hole) {
        report.defects.push(Defect::Holes {
            count: rims.iter().filter(|rim| rim.hole).count(),
            longest: longest.clone(),
        });
    }
    report.n_rims = rims.len();
    rims.truncate(Report::LISTED);
    report.rims = rims;
}

/// All rim loops; `component` holds a triangle of the loop until the components are numbered.
fn rims(positions: &[Vec3], triangles: &[[u32; 3]], topology: &Topology) -> Vec<RimLoop> {
    let mut done = super::topology::Bits::new(positions.len());
    let mut rims = Vec::new();
    for (t, corners) in triangles.iter().enumerate() {
        for (i, over) in topology.across(t as u32).into_iter().enumerate() {
            let start = corners[i];
            if over != RIM || done.get(start as usize) {
                continue;
            }
            let mut rim = RimLoop {
                component: t,
                hole: false,
                edges: 0,
                perimeter_mm: 0.0,
                at_mm: positions[start as usize].to_array(),
            };
            // One fan a vertex: the rim edge that leaves it is the first of its fan, and leads to its first neighbour.
            let mut v = start;
            while !done.get(v as usize) {
                done.set(v as usize);
                let Some(&next) = topology.neighbours(v).first() else {
                    break;
                };
                rim.edges += 1;
                rim.perimeter_mm += positions[v as usize].distance(positions[next as usize]);
                v = next;
            }
            rims.push(rim);
        }
    }
    rims
}
