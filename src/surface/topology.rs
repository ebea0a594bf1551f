//! Adjacency of a triangle mesh. Knows indices only, no positions.

/// Stands in [`Topology::across`] where an edge has no second triangle.
pub const RIM: u32 = u32::MAX;

/// Who is next to whom: vertex → ordered neighbours, vertex → triangles, triangle → triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    across: Vec<[u32; 3]>,
    fan_start: Vec<u32>,
    fans: Vec<u32>,
    neighbour_start: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Topology {
    /// Builds adjacency for an edge-manifold, consistently oriented mesh.
    ///
    /// An edge with more than two triangles, or two triangles that run it the same way, is treated as rim: validation
    /// lets neither through.
    pub fn new(n_vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let (fan_start, mut fans) = triangles_by_vertex(n_vertices, triangles);
        let across = triangles_across(triangles, &fan_start, &fans);
        let mut neighbour_start = Vec::with_capacity(n_vertices + 1);
        let mut neighbours = Vec::with_capacity(triangles.len() * 3 + n_vertices / 8);
        neighbour_start.push(0);
        let mut ordered = Vec::new();
        for v in 0..n_vertices {
            let fan = &mut fans[fan_start[v] as usize..fan_start[v + 1] as usize];
            order_fan(
                v as u32,
                triangles,
                &across,
                fan,
                &mut ordered,
                &mut neighbours,
            );
            neighbour_start.push(neighbours.len() as u32);
        }
        neighbours.shrink_to_fit();
        Self {
            across,
            fan_start,
            fans,
            neighbour_start,
            neighbours,
        }
    }

    /// Triangles across the edges of triangle `t`; edge `i` joins corners `i` and `i + 1`; [`RIM`] where there is none.
    pub fn across(&self, t: u32) -> [u32; 3] {
        self.across[t as usize]
    }

    /// Triangles around vertex `v`, counter-clockwise seen from outside, starting at the rim where there is one.
    pub fn triangles_of(&self, v: u32) -> &[u32] {
        &self.fans[self.fan_start[v as usize] as usize..self.fan_start[v as usize + 1] as usize]
    }

    /// Vertices joined to `v` by an edge, in the order of [`Topology::triangles_of`].
    pub fn neighbours(&self, v: u32) -> &[u32] {
        &self.neighbours[self.neighbour_start[v as usize] as usize
            ..self.neighbour_start[v as usize + 1] as usize]
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        self.fan_start.len() - 1
    }

    /// Number of edges that have only one triangle.
    pub fn n_rim_edges(&self) -> usize {
        self.across.iter().flatten().filter(|&&t| t == RIM).count()
    }

    /// Memory held, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.across[..])
            + size_of_val(&self.fan_start[..])
            + size_of_val(&self.fans[..])
            + size_of_val(&self.neighbour_start[..])
            + size_of_val(&self.neighbours[..])
    }
}

fn triangles_by_vertex(n_vertices: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0_u32; n_vertices + 1];
    for v in triangles.iter().flatten() {
        start[*v as usize + 1] += 1;
    }
    for v in 0..n_vertices {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut fans = vec![0_u32; triangles.len() * 3];
    for (t, corners) in triangles.iter().enumerate() {
        for &v in corners {
            fans[next[v as usize] as usize] = t as u32;
            next[v as usize] += 1;
        }
    }
    (start, fans)
}

fn triangles_across(triangles: &[[u32; 3]], fan_start: &[u32], fans: &[u32]) -> Vec<[u32; 3]> {
    let edge_of = |t: u32, from: u32, to: u32| {
        let c = triangles[t as usize];
        (0..3).any(|i| c[i] == from && c[(i + 1) % 3] == to)
    };
    triangles
        .iter()
        .map(|c| {
            [0, 1, 2].map(|i| {
                let (from, to) = (c[i], c[(i + 1) % 3]);
                let fan =
                    &fans[fan_start[from as usize] as usize..fan_start[from as usize + 1] as usize];
                let mut with_edge = fan.iter().filter(|&&t| edge_of(t, to, from));
                match (with_edge.next(), with_edge.next()) {
                    (Some(&t), None) => t,
                    _ => RIM,
                }
            })
        })
        .collect()
}

/// Sorts the triangles round `v` counter-clockwise and appends the neighbours of `v` in that order.
fn order_fan(
    v: u32,
    triangles: &[[u32; 3]],
    across: &[[u32; 3]],
    fan: &mut [u32],
    ordered: &mut Vec<u32>,
    neighbours: &mut Vec<u32>,
) {
    let corner = |t: u32| {
        triangles[t as usize]
            .iter()
            .position(|&c| c == v)
            .unwrap_or(0)
    };
    // Edge `corner` leaves v, edge `corner + 2` comes back to v: the next triangle counter-clockwise is across the latter.
    let next = |t: u32| across[t as usize][(corner(t) + 2) % 3];
    let previous = |t: u32| across[t as usize][corner(t)];
    ordered.clear();
    while ordered.len() < fan.len() {
        let Some(&seed) = fan.iter().find(|t| !ordered.contains(t)) else {
            break;
        };
        let mut first = seed;
        for _ in 0..fan.len() {
            match previous(first) {
                RIM => break,
                t if t == seed => break,
                t => first = t,
            }
        }
        let mut t = first;
        let leaving = triangles[t as usize][(corner(t) + 1) % 3];
        neighbours.push(leaving);
        loop {
            ordered.push(t);
            let returning = triangles[t as usize][(corner(t) + 2) % 3];
            if returning != leaving {
                neighbours.push(returning);
            }
            match next(t) {
                RIM => break,
                u if ordered.contains(&u) => break,
                u => t = u,
            }
        }
    }
    fan.copy_from_slice(ordered);
}
