//! Boxes, planes and triangles of a tree as they are drawn: made anew only when what they show changes.

use super::asked::{Asked, Place};
use super::built::Built;
use super::settings::{Boxes, Settings, Show};
use crate::app::render::layer::{Layer, LayerBuilder, Overlay, Patch};
use crate::app::render::pixels::rgb;
use crate::app::theme::{Theme, TreeColors};
use crate::geom::Aabb;
use crate::partition::tree::{Node, Tree};
use egui::Color32;
use std::sync::Arc;

/// Most boxes and most planes drawn: beyond them a picture is a tangle, and on software GL a slow one.
pub const MOST: usize = 20_000;

/// What a tree's lines depend on.
struct TreeKey {
    /// Kept, so that no other tree comes to lie at its address.
    built: Arc<Built>,
    show: (u32, Boxes, bool, bool, bool),
    colors: TreeColors,
}

impl PartialEq for TreeKey {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.built, &other.built)
            && self.show == other.show
            && self.colors == other.colors
    }
}

/// The drawn parts, each with what it was made for.
#[derive(Default)]
pub struct Shapes {
    tree: Option<(TreeKey, Option<Arc<Layer>>, [usize; 2])>,
    haptic: Option<(Vec<u32>, Color32, Arc<Patch>)>,
    hdb: Option<(Aabb, Color32, Arc<Layer>)>,
    leaf: Option<(u32, Aabb, Color32, Arc<Layer>)>,
    bounds: Option<Aabb>,
}

fn opaque(color: Color32, opacity: u8) -> [u8; 4] {
    let [r, g, b] = rgb(color);
    [r, g, b, opacity]
}

impl Shapes {
    /// Makes what is missing and drops what is not shown.
    pub fn follow(
        &mut self,
        settings: &Settings,
        theme: &Theme,
        built: Option<&Arc<Built>>,
        asked: Option<&Arc<Asked>>,
        place: Option<&Place>,
    ) {
        let Some(built) = built else {
            *self = Self::default();
            return;
        };
        let (show, colors) = (settings.show, theme.tree);
        self.follow_tree(built, show, colors);
        self.bounds = Some(built.surface.bounds());
        match asked.filter(|_| show.haptic) {
            Some(asked) => {
                let triangles = &asked.answer(settings.query).triangles;
                let same = |(of, color, _): &(Vec<u32>, Color32, Arc<Patch>)| {
                    of == triangles && *color == colors.haptic
                };
                if !self.haptic.as_ref().is_some_and(same) {
                    let patch = Patch::new(&built.surface, triangles, opaque(colors.haptic, 150));
                    self.haptic = Some((triangles.clone(), colors.haptic, patch));
                }
            }
            None => self.haptic = None,
        }
        match asked.filter(|_| show.hdb) {
            Some(asked) => {
                let same = |(of, color, _): &(Aabb, Color32, Arc<Layer>)| {
                    *of == asked.region && *color == colors.haptic
                };
                if !self.hdb.as_ref().is_some_and(same) {
                    let layer = boxes([&asked.region], opaque(colors.haptic, 255));
                    self.hdb = Some((asked.region, colors.haptic, layer));
                }
            }
            None => self.hdb = None,
        }
        match place {
            Some(place) => {
                let same = |(leaf, cell, color, _): &(u32, Aabb, Color32, Arc<Layer>)| {
                    (*leaf, *cell, *color) == (place.leaf, place.cell, theme.text)
                };
                if !self.leaf.as_ref().is_some_and(same) {
                    let layer = boxes([&place.cell], opaque(theme.text, 255));
                    self.leaf = Some((place.leaf, place.cell, theme.text, layer));
                }
            }
            None => self.leaf = None,
        }
    }

    fn follow_tree(&mut self, built: &Arc<Built>, show: Show, colors: TreeColors) {
        let Some(tree) = built.tree() else { return };
        let key = TreeKey {
            built: built.clone(),
            show: (
                show.level.min(tree.height()),
                show.boxes,
                show.wire,
                show.loose,
                show.planes,
            ),
            colors,
        };
        if self.tree.as_ref().is_some_and(|(of, ..)| *of == key) {
            return;
        }
        let (layer, boxes) = tree_layer(tree, show, colors);
        self.tree = Some((key, layer, boxes));
    }

    /// All that is shown.
    pub fn overlay(&self) -> Overlay {
        let tree = self.tree.as_ref().and_then(|(_, layer, _)| layer.clone());
        let hdb = self.hdb.as_ref();
        let layers = [
            tree,
            hdb.map(|(.., layer)| layer.clone()),
            self.leaf.as_ref().map(|(.., layer)| layer.clone()),
        ];
        let region = hdb.map_or(Aabb::EMPTY, |(region, ..)| *region);
        Overlay {
            layers: layers.into_iter().flatten().collect(),
            patches: (self.haptic.iter())
                .map(|(.., patch)| patch.clone())
                .collect(),
            bounds: self.bounds.unwrap_or(Aabb::EMPTY).union(region),
        }
    }

    /// Boxes drawn, and boxes there are to draw.
    pub fn boxes(&self) -> [usize; 2] {
        self.tree.as_ref().map_or([0, 0], |(_, _, boxes)| *boxes)
    }

    /// Memory held, bytes, on the processor's side; the graphics card holds as much again.
    pub fn bytes(&self) -> usize {
        let overlay = self.overlay();
        let layers: usize = overlay.layers.iter().map(|l| l.bytes()).sum();
        let patches: usize = overlay.patches.iter().map(|p| p.bytes()).sum();
        let held = self.haptic.as_ref().map_or(0, |(of, ..)| of.capacity());
        layers + patches + held * size_of::<u32>()
    }
}

fn boxes<'a>(boxes: impl IntoIterator<Item = &'a Aabb>, color: [u8; 4]) -> Arc<Layer> {
    let mut builder = LayerBuilder::default();
    for b in boxes {
        builder.wire_box(b, color);
    }
    builder.finish()
}

/// Whether a node is drawn as a box.
pub fn is_drawn(node: &Node, level: u32, boxes: Boxes) -> bool {
    match boxes {
        Boxes::All => node.level == level || (node.is_leaf() && node.level < level),
        Boxes::Leaves => node.is_leaf() && node.level <= level,
        Boxes::FullLeaves => node.is_leaf() && node.level <= level && node.held > 0,
    }
}

/// The lines and planes of a tree, and how many boxes of how many are among them.
fn tree_layer(tree: &Tree, show: Show, colors: TreeColors) -> (Option<Arc<Layer>>, [usize; 2]) {
    let level = show.level.min(tree.height());
    let mut builder = LayerBuilder::default();
    let mut counts = [0, 0];
    if show.planes {
        let splitting = || {
            tree.nodes()
                .iter()
                .filter(|n| n.level < level && n.held > 0)
        };
        let many = splitting().filter(|n| !n.is_leaf()).count();
        // The more planes, the fainter each: together they let the skin show through.
        let face = (110.0 / (1.0 + many as f64).sqrt()).clamp(4.0, 56.0) as u8;
        for node in splitting().take(MOST) {
            // Drawn a little within the cell, or the edges of the boxes would hide its outline.
            let inset = node.cell.size() * 0.025;
            let within = Aabb {
                min: node.cell.min + inset,
                max: node.cell.max - inset,
            };
            for (axis, at_mm) in tree.splits(node) {
                let color = colors.planes[axis];
                builder.cut(
                    &within,
                    axis,
                    at_mm,
                    opaque(color, 230),
                    opaque(color, face),
                );
            }
        }
    }
    if show.wire {
        for node in (tree.nodes().iter()).filter(|n| is_drawn(n, level, show.boxes)) {
            let outline = if show.loose { &node.bounds } else { &node.cell };
            if outline.is_empty() {
                continue;
            }
            counts[1] += 1;
            if counts[0] < MOST {
                let color = if node.is_leaf() {
                    colors.leaf
                } else {
                    colors.node
                };
                builder.wire_box(outline, opaque(color, 235));
                counts[0] += 1;
            }
        }
    }
    let layer = builder.finish();
    ((layer.bytes() > 0).then_some(layer), counts)
}

/// A colour and what wears it, for everything that is shown.
pub fn legend(
    settings: &Settings,
    theme: &Theme,
    built: Option<&Built>,
) -> Vec<(Color32, &'static str)> {
    let (show, colors) = (settings.show, theme.tree);
    let Some(built) = built else {
        return Vec::new();
    };
    let deep = show.level >= built.height();
    let inner = show.boxes == Boxes::All && !deep;
    let planes = show.planes && show.level > 0;
    [
        (show.haptic, colors.haptic, "Haptic triangles"),
        (
            show.hdb && !show.haptic,
            colors.haptic,
            "Haptic detecting box",
        ),
        (show.wire, colors.leaf, "Leaf"),
        (show.wire && inner, colors.node, "Inner node"),
        (planes, colors.planes[0], "Split across x"),
        (planes, colors.planes[1], "Split across y"),
        (planes, colors.planes[2], "Split across z"),
    ]
    .into_iter()
    .filter_map(|(on, color, text)| on.then_some((color, text)))
    .collect()
}
