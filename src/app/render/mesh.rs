//! The skin as the graphics card wants it, on the processor's side: rounded to `f32`, packed, with a list of what changed.

use super::values::Values;
use crate::deform::Displacement;
use crate::geom::Vec3;
use crate::surface::Surface;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Depth of a dent that counts as full in the shader, mm: the cap of the drawn deformation (Ji 2008, eq. 4.16).
const FULL_DENT_MM: f64 = 10.0;
/// Changed runs closer than this many vertices go up in one piece: one call costs about what copying this many does.
const MERGE_GAP: u32 = 128;

/// One vertex as uploaded: 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct SkinVertex {
    /// Deformed position, mm.
    pub position: [f32; 3],
    /// Unit normal in 1/32767, then the dent's depth in the same against `FULL_DENT_MM`.
    pub normal_dent: [i16; 4],
}

/// What is baked per vertex from the rest surface; see [`super::shade`].
pub type Shade = [u8; 4];

/// Neither hollow nor ridge, mean tone: what is drawn until the bake is done.
pub const PLAIN_SHADE: Shade = [128, 128, 128, 255];

/// The drawn skin of one surface.
#[derive(Debug)]
pub struct SkinMesh {
    id: u64,
    surface: Arc<Surface>,
    vertices: Vec<SkinVertex>,
    shade: Option<Vec<Shade>>,
    shade_changed: bool,
    changed: Vec<u32>,
    /// What it is coloured by; most of the time nothing.
    values: Option<Values>,
}

impl SkinMesh {
    /// The surface at rest.
    pub fn new(surface: Arc<Surface>) -> Self {
        static NEXT_ID: AtomicU64 = AtomicU64::new(1);
        let vertices = surface
            .positions()
            .iter()
            .zip(surface.normals())
            .map(|(&p, &n)| packed(p, n, 0.0))
            .collect();
        Self {
            id: NEXT_ID.fetch_add(1, Ordering::Relaxed),
            surface,
            vertices,
            shade: None,
            shade_changed: false,
            changed: Vec::new(),
            values: None,
        }
    }

    /// Tells two meshes apart, also across scenes.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// The surface it draws.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// Every vertex, as uploaded whole.
    pub fn vertices(&self) -> &[SkinVertex] {
        &self.vertices
    }

    /// Takes over the vertices that the last deformation touched. A displacement of another surface is ignored.
    pub fn update(&mut self, displacement: &Displacement) {
        if displacement.n_vertices() != self.vertices.len() {
            return;
        }
        for v in displacement.touched() {
            let i = v as usize;
            let offset = displacement.offset_mm(v);
            let dent_mm = -offset.dot(self.surface.normals()[i]);
            self.vertices[i] = packed(
                self.surface.positions()[i] + offset,
                displacement.normal(v),
                dent_mm,
            );
        }
        self.changed.extend(displacement.touched());
    }

    /// Hands in what was baked. Ignored when its length is not the number of vertices.
    pub fn set_shade(&mut self, shade: Vec<Shade>) {
        if shade.len() == self.vertices.len() {
            self.shade = Some(shade);
            self.shade_changed = true;
        }
    }

    /// Whether the bake has been handed in.
    pub fn is_shaded(&self) -> bool {
        self.shade.is_some()
    }

    /// Puts on what it is coloured by, or takes it off and frees it.
    pub fn set_values(&mut self, values: Option<Values>) {
        self.values = values;
    }

    /// What it is coloured by.
    pub fn values(&self) -> Option<&Values> {
        self.values.as_ref()
    }

    /// The same, to be written.
    pub fn values_mut(&mut self) -> Option<&mut Values> {
        self.values.as_mut()
    }

    /// Whether something waits to be uploaded.
    pub fn has_changes(&self) -> bool {
        let values_changed = self.values.as_ref().is_some_and(|v| !v.changed.is_empty());
        self.shade_changed || !self.changed.is_empty() || values_changed
    }

    /// The baked values, if they changed since the last call.
    pub(super) fn take_shade(&mut self) -> Option<&[Shade]> {
        std::mem::take(&mut self.shade_changed)
            .then_some(self.shade.as_deref())
            .flatten()
    }

    /// The baked values.
    pub(super) fn shade(&self) -> Option<&[Shade]> {
        self.shade.as_deref()
    }

    /// The runs of vertices that changed since the last call, in rising order, apart by more than [`MERGE_GAP`].
    pub(super) fn take_changed(&mut self, runs: &mut Vec<Range<u32>>) {
        take_runs(&mut self.changed, runs);
    }

    /// Memory held, bytes, without the surface and what it is coloured by.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.vertices[..])
            + self.shade.as_ref().map_or(0, |s| size_of_val(&s[..]))
            + self.changed.capacity() * size_of::<u32>()
    }
}

/// Turns a list of changed vertices into the runs that cover it, and empties it.
pub(super) fn take_runs(changed: &mut Vec<u32>, runs: &mut Vec<Range<u32>>) {
    changed.sort_unstable();
    runs.clear();
    for &v in changed.iter() {
        match runs.last_mut() {
            Some(run) if v < run.end => {}
            Some(run) if v - run.end <= MERGE_GAP => run.end = v + 1,
            _ => runs.push(v..v + 1),
        }
    }
    changed.clear();
}

fn packed(position_mm: Vec3, normal: Vec3, dent_mm: f64) -> SkinVertex {
    let unit = |x: f64| (x.clamp(-1.0, 1.0) * 32767.0).round() as i16;
    SkinVertex {
        position: position_mm.to_array().map(|x| x as f32),
        normal_dent: [
            unit(normal.x),
            unit(normal.y),
            unit(normal.z),
            unit(dent_mm / FULL_DENT_MM),
        ],
    }
}

/// Two ends per edge, each edge once, in the order of the triangles.
pub fn edges(surface: &Surface) -> Vec<[u32; 2]> {
    let mut edges = Vec::with_capacity(surface.triangles().len() * 3 / 2 + 64);
    for (t, corners) in surface.triangles().iter().enumerate() {
        let across = surface.topology().across(t as u32);
        for i in 0..3 {
            // RIM is the largest index: a rim edge is taken by its only triangle.
            if across[i] > t as u32 {
                edges.push([corners[i], corners[(i + 1) % 3]]);
            }
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{back, back::BackOptions};

    fn skin() -> SkinMesh {
        let raw = back::make(&BackOptions::with_triangles(800));
        SkinMesh::new(Arc::new(Surface::new(raw).unwrap().0))
    }

    #[test]
    fn changed_runs_cover_exactly_the_touched_vertices_and_small_gaps() {
        let mut skin = skin();
        skin.changed = vec![300, 5, 6, 5, 40];
        let mut runs = Vec::new();
        skin.take_changed(&mut runs);
        assert_eq!(runs, vec![5..41, 300..301]);
        skin.take_changed(&mut runs);
        assert!(runs.is_empty(), "a run goes up once");
    }

    #[test]
    fn only_touched_vertices_move() {
        let mut skin = skin();
        let rest = skin.vertices.clone();
        let mut d = Displacement::at_rest(&skin.surface);
        let normal = skin.surface.normals()[7];
        d.put(8, Vec3::ONE, normal);
        d.put(7, normal * -5.0, normal);
        skin.update(&d);
        let moved: Vec<_> = (0..rest.len())
            .filter(|&i| rest[i] != skin.vertices[i])
            .collect();
        assert_eq!(moved, vec![7]);
        assert!((16383..=16384).contains(&skin.vertices[7].normal_dent[3]));
    }

    #[test]
    fn every_edge_is_listed_once() {
        let skin = skin();
        let mut edges: Vec<[u32; 2]> = edges(&skin.surface)
            .into_iter()
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        let n = edges.len();
        edges.sort_unstable();
        edges.dedup();
        assert_eq!(edges.len(), n);
        // Every triangle has three edges; inner ones are shared by two.
        let rim = skin.surface.topology().n_rim_edges();
        assert_eq!(2 * n, 3 * skin.surface.triangles().len() + rim);
    }

    #[test]
    fn a_displacement_of_another_surface_is_ignored() {
        let mut skin = skin();
        skin.update(&Displacement::default());
        assert!(!skin.has_changes());
    }
}
