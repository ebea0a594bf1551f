//! The bones of the built-in back as a model to be drawn.

use super::model::{Model, Placed};
use crate::surface::back::{BackOptions, BoneKind, Skeleton};
use glam::DMat4;
use std::sync::Arc;

/// Bone and cartilage, sRGB: ivory and a dull grey-green that no finger wears.
const COLORS: [[u8; 3]; 2] = [[236, 226, 202], [150, 170, 158]];

/// Makes the bones under the back made with `options`.
pub fn model(options: &BackOptions) -> Model {
    let skeleton = Skeleton::under(options);
    let discs: Vec<_> = (skeleton.bones.iter())
        .filter(|b| b.kind == BoneKind::Disc)
        .map(|b| b.vertices.clone())
        .collect();
    Model::new(
        &skeleton.mesh.positions,
        &skeleton.normals,
        &skeleton.mesh.triangles,
        |v| f64::from(u8::from(discs.iter().any(|d| d.contains(&v)))),
    )
}

/// Puts them where they are.
pub fn placed(model: &Arc<Model>) -> Placed {
    Placed {
        model: model.clone(),
        subject_from_model: DMat4::IDENTITY,
        colors: COLORS,
        gloss: 0.05,
        is_finger: false,
    }
}

#[cfg(test)]
mod tests {
    use crate::geom::Vec3;
    use crate::partition::{Partition as _, Sides};
    use crate::scenario::{self, Scenario, Use};
    use crate::surface::back::{BackOptions, Skeleton};
    use std::sync::Arc;

    /// Against the triangles of the default scene's own mesh, which cut the corners of the height function.
    #[test]
    fn every_bone_lies_below_the_mesh_that_is_felt() {
        let example = scenario::default_example();
        let scenario = Scenario::parse(example.text, example.file, None).expect("the example");
        let scene = scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true);
        let scene = scene.expect("a scene");
        let skeleton = Skeleton::under(&BackOptions::default());
        let search = &scene.touch.search;
        let mut least = f64::INFINITY;
        for bone in &skeleton.bones {
            for p in &skeleton.mesh.positions[bone.vertices.clone()] {
                let up = *p + Vec3::Z * 400.0;
                let over = search.sweep(&scene.surface, up, *p, Sides::Front);
                assert!(over.is_some(), "{} at {p} has no skin above it", bone.name);
                if let Some(near) = search.nearest(&scene.surface, *p, 12.0) {
                    least = least.min(near.point.distance(*p));
                }
            }
        }
        assert!(least > 2.5, "{least} mm");
    }
}
