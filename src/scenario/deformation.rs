//! The `[deformation]` table: how the drawn skin moves.

use super::ScenarioError;
use super::check::Check;
use crate::deform::models::fsmd;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeformationTable {
    normal_scale_shallow: Option<Spanned<f64>>,
    normal_scale_deep: Option<Spanned<f64>>,
    max_normal_mm: Option<Spanned<f64>>,
    max_tangential_mm: Option<Spanned<f64>>,
}

impl Check<'_> {
    /// The settings of the deformation; `tangential` where the scene has friction.
    pub(super) fn deformation(
        &self,
        table: Option<&DeformationTable>,
        tangential: bool,
    ) -> Result<fsmd::Settings, ScenarioError> {
        let default = fsmd::Settings {
            tangential,
            ..fsmd::Settings::default()
        };
        let Some(t) = table else {
            return Ok(default);
        };
        let scale = |key: &str, value: &Option<Spanned<f64>>, or: f64| {
            self.number_or(key, value.as_ref(), 0.01..=1.0, or)
        };
        Ok(fsmd::Settings {
            normal_scale_shallow: scale(
                "normal_scale_shallow",
                &t.normal_scale_shallow,
                default.normal_scale_shallow,
            )?,
            normal_scale_deep: scale(
                "normal_scale_deep",
                &t.normal_scale_deep,
                default.normal_scale_deep,
            )?,
            max_normal_mm: self.number_or(
                "max_normal_mm",
                t.max_normal_mm.as_ref(),
                0.1..=50.0,
                default.max_normal_mm,
            )?,
            max_tangential_mm: self.number_or(
                "max_tangential_mm",
                t.max_tangential_mm.as_ref(),
                0.0..=100.0,
                default.max_tangential_mm,
            )?,
            ..default
        })
    }
}
