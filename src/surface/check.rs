//! Checks, slowly and by other means than the ones that built it, everything a [`Surface`] promises.

use super::{MAX_COORDINATE_MM, RIM, Surface};
use std::collections::HashMap;

impl Surface {
    /// Whether every promise of the type holds; if not, which one is broken where. For tests.
    ///
    /// # Errors
    /// The first broken promise.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), String> {
        let holds = |ok: bool, what: String| if ok { Ok(()) } else { Err(what) };
        let (n, topology) = (self.positions.len(), &self.topology);
        holds(!self.triangles.is_empty(), "no triangle".into())?;
        holds(self.normals.len() == n, "a normal for every vertex".into())?;
        holds(topology.n_vertices() == n, "topology of this mesh".into())?;
        for (v, (p, normal)) in self.positions.iter().zip(&self.normals).enumerate() {
            let sane = p
                .to_array()
                .iter()
                .all(|x| x.abs() <= MAX_COORDINATE_MM && x.to_bits() != (-0.0_f64).to_bits());
            holds(sane, format!("vertex {v} at {p}"))?;
            holds(
                (normal.length() - 1.0).abs() < 1e-12,
                format!("normal {v} is {normal}"),
            )?;
            holds(
                self.bounds.contains(*p),
                format!("vertex {v} out of bounds"),
            )?;
        }
        // Every directed edge once, so every edge at most twice and then in opposite directions.
        let mut directed = HashMap::new();
        for (t, corners) in self.triangles.iter().enumerate() {
            let [a, b, c] = *corners;
            holds(
                corners.iter().all(|&v| (v as usize) < n),
                format!("indices of {t}"),
            )?;
            holds(
                a != b && b != c && c != a,
                format!("triangle {t} repeats a vertex"),
            )?;
            let area = self.triangle(t as u32).area_mm2();
            holds(area > 0.0, format!("triangle {t} has the area {area}"))?;
            for i in 0..3 {
                let edge = (corners[i], corners[(i + 1) % 3]);
                let before = directed.insert(edge, t as u32);
                holds(before.is_none(), format!("edge {edge:?} runs twice"))?;
            }
        }
        let mut corners_of = vec![0; n];
        for (t, corners) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                corners_of[corners[i] as usize] += 1;
                let expected = directed.get(&(corners[(i + 1) % 3], corners[i]));
                holds(
                    topology.across(t as u32)[i] == expected.copied().unwrap_or(RIM),
                    format!("across edge {i} of triangle {t}"),
                )?;
            }
        }
        for v in 0..n as u32 {
            let fan = topology.triangles_of(v);
            holds(!fan.is_empty(), format!("vertex {v} has no triangle"))?;
            holds(
                fan.len() == corners_of[v as usize],
                format!("fan of {v} is not whole"),
            )?;
            let mut expected = Vec::new();
            for &t in fan {
                let corners = self.triangles[t as usize];
                let Some(i) = corners.iter().position(|&c| c == v) else {
                    return Err(format!("fan of {v} holds triangle {t}"));
                };
                let (leaving, returning) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
                if let Some(&last) = expected.last() {
                    holds(last == leaving, format!("fan of {v} jumps at triangle {t}"))?;
                } else {
                    expected.push(leaving);
                }
                expected.push(returning);
            }
            if expected.first() == expected.last() {
                expected.pop();
            } else {
                let first = (expected[0], v);
                holds(!directed.contains_key(&first), format!("fan of {v} is cut"))?;
            }
            holds(
                topology.neighbours(v) == expected,
                format!("neighbours of {v}"),
            )?;
        }
        Ok(())
    }
}
