//! The kinds of dysfunction, one file each.

mod hypertonic;
mod restricted;
mod rotation;
mod skin_drag;
mod tender;
mod texture;
mod trigger_point;

use super::Kind;

const KINDS: [&dyn Kind; 7] = [
    &hypertonic::Hypertonic,
    &trigger_point::TriggerPoint,
    &texture::Texture,
    &rotation::Rotation,
    &restricted::Restricted,
    &tender::Tender,
    &skin_drag::SkinDrag,
];

/// Every kind.
pub fn all() -> &'static [&'static dyn Kind] {
    &KINDS
}

/// The kind with this key.
pub fn named(key: &str) -> Option<&'static dyn Kind> {
    all().iter().copied().find(|kind| kind.key() == key)
}

/// Of four values that of a severity; a higher one counts as the highest.
fn by_severity<T: Copy>(values: [T; 4], severity: u8) -> T {
    values[usize::from(severity).min(3)]
}
