//! Adjacency of a triangle mesh. Knows indices only, no positions.

use super::edges;

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
    /// Builds adjacency for an edge-manifold, consistently oriented mesh whose indices are below `n_vertices`.
    ///
    /// An edge with more than two triangles, or two triangles that run it the same way, is treated as rim: validation
    /// lets neither through. Time grows linearly with the triangles, also where one vertex has most of them.
    pub fn new(n_vertices: usize, triangles: &[[u32; 3]]) -> Self {
        Self::from_across(n_vertices, triangles, edges::across(n_vertices, triangles)).0
    }

    /// Builds the fans from known neighbours; also gives the number of fans, which exceeds the number of vertices in use
    /// where sheets touch in a single vertex.
    pub(super) fn from_across(
        n_vertices: usize,
        triangles: &[[u32; 3]],
        across: Vec<[u32; 3]>,
    ) -> (Self, usize) {
        let mut fan_start = vec![0_u32; n_vertices + 1];
        let mut neighbour_start = vec![0_u32; n_vertices + 1];
        for (corners, over) in triangles.iter().zip(&across) {
            for (&v, &u) in corners.iter().zip(over) {
                fan_start[v as usize + 1] += 1;
                neighbour_start[v as usize + 1] += 1 + u32::from(u == RIM);
            }
        }
        for v in 0..n_vertices {
            fan_start[v + 1] += fan_start[v];
            neighbour_start[v + 1] += neighbour_start[v];
        }
        let mut walk = FanWalk {
            triangles,
            across: &across,
            fans: vec![0; triangles.len() * 3],
            neighbours: vec![0; neighbour_start[n_vertices] as usize],
            next_triangle: fan_start.clone(),
            next_neighbour: neighbour_start.clone(),
            done: Bits::new(triangles.len() * 3),
        };
        let mut n_fans = 0;
        for (t, over) in across.iter().enumerate() {
            for (i, &u) in over.iter().enumerate() {
                if u == RIM {
                    walk.fan(t as u32, i);
                    n_fans += 1;
                }
            }
        }
        for t in 0..triangles.len() {
            for i in 0..3 {
                if !walk.done.get(3 * t + i) {
                    walk.fan(t as u32, i);
                    n_fans += 1;
                }
            }
        }
        let FanWalk {
            fans, neighbours, ..
        } = walk;
        let topology = Self {
            across,
            fan_start,
            fans,
            neighbour_start,
            neighbours,
        };
        (topology, n_fans)
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

/// Which corner of the triangle is `v`; the first one where it is none.
pub(super) fn corner_of(corners: &[u32; 3], v: u32) -> usize {
    if corners[1] == v {
        1
    } else if corners[2] == v {
        2
    } else {
        0
    }
}

/// Writes the triangles round one vertex after the other into their places.
struct FanWalk<'a> {
    triangles: &'a [[u32; 3]],
    across: &'a [[u32; 3]],
    fans: Vec<u32>,
    neighbours: Vec<u32>,
    next_triangle: Vec<u32>,
    next_neighbour: Vec<u32>,
    done: Bits,
}

impl FanWalk<'_> {
    /// Walks counter-clockwise round corner `i` of triangle `t`, until the rim or a corner already walked.
    ///
    /// Edge `i` leaves the vertex and edge `i + 2` comes back to it: the next triangle is across the latter.
    fn fan(&mut self, mut t: u32, mut i: usize) {
        let v = self.triangles[t as usize][i] as usize;
        loop {
            self.done.set(3 * t as usize + i);
            self.fans[self.next_triangle[v] as usize] = t;
            self.next_triangle[v] += 1;
            let corners = &self.triangles[t as usize];
            self.neighbours[self.next_neighbour[v] as usize] = corners[(i + 1) % 3];
            self.next_neighbour[v] += 1;
            let u = self.across[t as usize][(i + 2) % 3];
            if u == RIM {
                self.neighbours[self.next_neighbour[v] as usize] = corners[(i + 2) % 3];
                self.next_neighbour[v] += 1;
                return;
            }
            (t, i) = (u, corner_of(&self.triangles[u as usize], v as u32));
            if self.done.get(3 * t as usize + i) {
                return;
            }
        }
    }
}

/// A row of flags, one bit each.
pub(super) struct Bits(Vec<u64>);

impl Bits {
    pub fn new(len: usize) -> Self {
        Self(vec![0; len.div_ceil(64)])
    }

    pub fn get(&self, i: usize) -> bool {
        self.0[i / 64] >> (i % 64) & 1 == 1
    }

    pub fn set(&mut self, i: usize) {
        self.0[i / 64] |= 1 << (i % 64);
    }

    pub fn any(&self) -> bool {
        self.0.iter().any(|&word| word != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Two triangles per cell of a grid of `nx` × `ny` cells.
    fn grid(nx: u32, ny: u32) -> (usize, Vec<[u32; 3]>) {
        let at = |i: u32, j: u32| j * (nx + 1) + i;
        let cells = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j)));
        let triangles = cells
            .flat_map(|(i, j)| {
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                [[a, b, c], [a, c, d]]
            })
            .collect();
        (((nx + 1) * (ny + 1)) as usize, triangles)
    }

    /// Neighbour of a triangle across the edge from `a` to `b`, by looking at all triangles.
    fn brute_across(triangles: &[[u32; 3]], a: u32, b: u32) -> u32 {
        let runs = |c: &[u32; 3]| (0..3).any(|i| c[i] == b && c[(i + 1) % 3] == a);
        (triangles.iter().position(runs)).map_or(RIM, |t| t as u32)
    }

    fn check_fans(n: usize, triangles: &[[u32; 3]], topology: &Topology) {
        for (t, c) in triangles.iter().enumerate() {
            let expected = [0, 1, 2].map(|i| brute_across(triangles, c[i], c[(i + 1) % 3]));
            assert_eq!(topology.across(t as u32), expected, "triangle {t}");
        }
        for v in 0..n as u32 {
            let fan = topology.triangles_of(v);
            let mut sorted = fan.to_vec();
            sorted.sort_unstable();
            let expected: Vec<u32> = (0..triangles.len() as u32)
                .filter(|&t| triangles[t as usize].contains(&v))
                .collect();
            assert_eq!(sorted, expected, "triangles of {v}");
            let corners = |t: u32| {
                let c = triangles[t as usize];
                let i = c.iter().position(|&u| u == v).expect("in its fan");
                (c[(i + 1) % 3], c[(i + 2) % 3])
            };
            for pair in fan.windows(2) {
                assert_eq!(corners(pair[0]).1, corners(pair[1]).0, "fan of {v}");
            }
            let mut around: Vec<u32> = fan.iter().map(|&t| corners(t).0).collect();
            if let (Some(&first), Some(&last)) = (fan.first(), fan.last()) {
                if corners(last).1 == corners(first).0 {
                    assert_ne!(topology.across(first), [RIM; 3]);
                } else {
                    around.push(corners(last).1);
                    assert_eq!(brute_across(triangles, v, corners(first).0), RIM);
                }
            }
            assert_eq!(topology.neighbours(v), around, "neighbours of {v}");
        }
    }

    #[test]
    fn fans_of_a_grid_are_ordered_and_start_at_the_rim() {
        for (nx, ny) in [(1, 1), (3, 2), (7, 5)] {
            let (n, triangles) = grid(nx, ny);
            let topology = Topology::new(n, &triangles);
            check_fans(n, &triangles, &topology);
            assert_eq!(topology.n_rim_edges(), 2 * (nx + ny) as usize);
        }
    }

    #[test]
    fn closed_meshes_have_no_rim_and_every_vertex_its_degree() {
        let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let octahedron: Vec<[u32; 3]> = (0..4)
            .flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]])
            .collect();
        for (n, triangles, degree) in [(4, tetrahedron, 3), (6, octahedron, 4)] {
            let topology = Topology::new(n, &triangles);
            check_fans(n, &triangles, &topology);
            assert_eq!(topology.n_rim_edges(), 0);
            assert!((0..n as u32).all(|v| topology.neighbours(v).len() == degree));
        }
    }

    #[test]
    fn a_lone_triangle_and_a_lone_vertex_are_fine() {
        let topology = Topology::new(5, &[[4, 0, 2]]);
        check_fans(5, &[[4, 0, 2]], &topology);
        assert!(topology.triangles_of(1).is_empty() && topology.neighbours(3).is_empty());
        assert_eq!(Topology::new(0, &[]).n_vertices(), 0);
    }

    #[test]
    fn a_vertex_with_a_hundred_thousand_triangles_is_ordered_in_linear_time() {
        // A quadratic walk would take minutes here.
        let n = 100_000;
        let triangles: Vec<[u32; 3]> = (0..n)
            .map(|i| [0, 1 + (i * 7919) % n, 1 + ((i * 7919) % n + 1) % n])
            .collect();
        let topology = Topology::new(n as usize + 1, &triangles);
        let around = topology.neighbours(0);
        assert_eq!(around.len(), n as usize);
        assert!((around.windows(2)).all(|w| w[1] == w[0] % n + 1));
    }

    #[test]
    fn an_edge_with_three_triangles_is_rim_for_all_of_them() {
        let topology = Topology::new(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
        assert!((0..3).all(|t| topology.across(t) == [RIM; 3]));
        assert_eq!(topology.triangles_of(0).len(), 3);
    }

    proptest! {
        #[test]
        fn a_grid_in_any_order_has_the_same_neighbours(
            nx in 1_u32..6,
            ny in 1_u32..6,
            seed in any::<u64>(),
        ) {
            let (n, mut triangles) = grid(nx, ny);
            let mut state = seed;
            for t in (1..triangles.len()).rev() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                triangles.swap(t, (state >> 33) as usize % (t + 1));
                triangles[t].rotate_left((state >> 20) as usize % 3);
            }
            check_fans(n, &triangles, &Topology::new(n, &triangles));
        }

        #[test]
        fn any_indices_give_every_corner_one_place(
            triangles in prop::collection::vec([0_u32..9, 0_u32..9, 0_u32..9], 0..60),
        ) {
            let topology = Topology::new(9, &triangles);
            let mut corners = vec![0; triangles.len()];
            for v in 0..9 {
                for &t in topology.triangles_of(v) {
                    prop_assert!(triangles[t as usize].contains(&v));
                    corners[t as usize] += 1;
                }
            }
            prop_assert!(corners.iter().all(|&n| n == 3));
        }
    }
}
