//! Eye and lights of one picture, as the shaders take them. The lights hang from the camera: relief reads from every side.

use super::Picture;
use super::gl::Bound;
use crate::app::camera::Camera;
use crate::geom::{Vec2, Vec3, unit_or};

/// Eye, matrix and lights, rounded.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    clip_from_subject: [f32; 16],
    eye: [f32; 4],
    key: [f32; 3],
    fill: [f32; 3],
    rim: [f32; 3],
    up: [f32; 3],
    /// Towards the eye.
    back: Vec3,
}

impl Light {
    /// For one picture, as `camera` sees it in `size` pixels. The lights are the same for both of two eyes.
    pub fn of(picture: &Picture, camera: &Camera, size: Vec2) -> Self {
        let b = camera.basis();
        let from_camera = |right: f64, up: f64, back: f64| {
            unit_or(b.right * right + b.up * up + b.back * back, b.back)
                .to_array()
                .map(|x| x as f32)
        };
        let eye = match camera.projection {
            crate::app::camera::Projection::Perspective => camera.eye_mm().extend(1.0),
            crate::app::camera::Projection::Orthographic => b.back.extend(0.0),
        };
        Self {
            clip_from_subject: camera
                .clip_from_subject(size, &picture.bounds.union(picture.overlay.bounds))
                .to_cols_array()
                .map(|x| x as f32),
            eye: eye.to_array().map(|x| x as f32),
            // The key grazes: a slope of one degree changes its light by two per cent.
            key: from_camera(-0.70, 0.52, 0.49),
            fill: from_camera(0.85, 0.05, 0.52),
            rim: from_camera(0.35, 0.65, -0.68),
            up: from_camera(0.0, 1.0, 0.0),
            back: b.back,
        }
    }

    /// Sets everything.
    pub fn set(&self, program: &Bound<'_>) {
        self.set_matrix(program);
        program.vec4s("u_eye", &[self.eye]);
        program.vec3("u_key", self.key);
        program.vec3("u_fill", self.fill);
        program.vec3("u_rim", self.rim);
        program.vec3("u_up", self.up);
    }

    /// Sets the matrix only.
    pub fn set_matrix(&self, program: &Bound<'_>) {
        program.mat4("u_clip_from_subject", &self.clip_from_subject);
    }

    /// Light on skin that faces the eye, in no hollow and under no finger: the mean of the three colours, as `skin.frag`
    /// sums it up.
    pub fn flat(&self) -> f32 {
        let back = unit_or(self.back, Vec3::Z);
        let wrapped = |light: [f32; 3], w: f64| {
            let cosine = back.dot(Vec3::from_array(light.map(f64::from)));
            ((cosine + w) / (1.0 + w)).max(0.0).powi(2)
        };
        let sky = (0.2725 + 0.2475 + 0.2325) / 3.0;
        let of_lights: f64 = [(0.58, 1.08, 0.31), (0.50, 1.03, 0.285), (0.46, 0.97, 0.265)]
            .into_iter()
            .map(|(w, key, fill)| key * wrapped(self.key, w) + fill * wrapped(self.fill, w))
            .sum();
        (sky + of_lights / 3.0) as f32
    }

    /// Direction to the key light, for tests.
    pub fn key(&self) -> Vec3 {
        Vec3::from_array(self.key.map(f64::from))
    }
}
