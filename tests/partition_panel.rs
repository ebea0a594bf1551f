//! The Partition panel: what it builds, says and draws is what `partition` itself says; closed, it holds nothing.
#![cfg(feature = "gui")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot be set up has failed"
)]

mod support;

use dorsum::app::command;
use dorsum::app::panels::partition::PartitionPanel;
use dorsum::app::panels::{Panel as _, PanelContext};
use dorsum::app::render::layer::{Layer, LayerVertex};
use dorsum::app::state::View;
use dorsum::app::study::settings::{Boxes, Choice, Follow, Kind, Query, Settings};
use dorsum::app::study::{SharedStudy, Shown, longest_edge_mm};
use dorsum::app::theme::{DARK, LIGHT, Theme};
use dorsum::geom::{Aabb, Vec3};
use dorsum::partition::Partition as _;
use dorsum::partition::Structure;
use dorsum::partition::brute::Brute;
use dorsum::partition::tree::{Case, Node, Options};
use dorsum::scenario::{self, Item, Ledger, Scenario, Scene, Use};
use dorsum::surface::{RawMesh, primitives};
use egui_kittest::{Harness, kittest::Queryable as _};
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use support::{view, wait_for, workbench};

/// A scene on a mesh from a file, as a user brings one.
fn scene_on(mesh: &RawMesh) -> Arc<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let mut obj = String::new();
    for p in &mesh.positions {
        obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for t in &mesh.triangles {
        obj += &format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    }
    std::fs::write(folder.path().join("mesh.obj"), obj).unwrap();
    let toml = "format = 1\nname = \"Closed\"\n[surface]\nmesh = \"mesh.obj\"\nunits = \"mm\"\n[stiffness]\nconstant_n_per_mm = 0.5\n";
    let scenario = Scenario::parse(toml, "closed.toml", Some(folder.path())).unwrap();
    Arc::new(scenario::build(Arc::new(scenario), Use::default(), &mut |_, _| true).unwrap())
}

fn sphere() -> Arc<Scene> {
    scene_on(&primitives::icosphere(150.0, 4))
}

/// A study without a window.
struct Desk {
    view: View,
}

impl Desk {
    fn new(scene: Arc<Scene>) -> Self {
        let view = View {
            scene: Some(scene),
            scene_generation: 1,
            ..View::default()
        };
        Self { view }
    }

    fn study(&self) -> &SharedStudy {
        &self.view.study
    }

    fn choose(&self, change: impl FnOnce(&mut Settings)) {
        let mut study = self.study().lock();
        let mut settings = study.settings();
        change(&mut settings);
        study.choose(settings);
    }

    fn follow(&self) -> Shown {
        let mut study = self.study().lock();
        study.follow(&self.view, &(Arc::new(|| {}) as _));
        study.shown()
    }

    /// Follows until what is chosen is built.
    fn built(&self) -> Shown {
        let start = Instant::now();
        loop {
            let shown = self.follow();
            if (shown.built.as_ref()).is_some_and(|b| b.choice == shown.settings.choice.effective())
            {
                return self.follow();
            }
            assert!(start.elapsed() < Duration::from_secs(60), "never built");
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// The panel alone in a window without OpenGL.
struct Window {
    harness: Harness<'static>,
    view: Arc<Mutex<View>>,
    closed: Arc<AtomicBool>,
}

impl Window {
    fn open(view: View, size: [f32; 2]) -> Self {
        let theme = view.theme;
        let view = Arc::new(Mutex::new(view));
        let closed = Arc::new(AtomicBool::new(false));
        let (seen, is_closed) = (view.clone(), closed.clone());
        let mut panel = PartitionPanel::default();
        let (send, _commands) = command::queue(Arc::new(|| {}));
        let harness = Harness::builder()
            .with_size(size)
            .with_context_setup(move |ctx| {
                egui_material_icons::initialize(ctx);
                theme.apply(ctx);
            })
            .build_ui(move |ui| {
                let view = seen.lock().unwrap().clone();
                if is_closed.load(Ordering::Relaxed) {
                    panel.release(&view);
                    return;
                }
                let cx = PanelContext {
                    view: &view,
                    send: &send,
                };
                panel.ui(ui, &cx);
            });
        Self {
            harness,
            view,
            closed,
        }
    }

    fn shown(&self) -> Shown {
        self.view.lock().unwrap().study.lock().shown()
    }

    fn wait(&mut self, what: &str, done: impl Fn(&Shown) -> bool) -> Shown {
        let start = Instant::now();
        loop {
            self.harness.run_steps(2);
            let shown = self.shown();
            if done(&shown) {
                return shown;
            }
            assert!(
                start.elapsed() < Duration::from_secs(60),
                "{what} did not come"
            );
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn click(&mut self, name: &str) {
        self.harness.get_by_label(name).click();
        self.harness.run_steps(3);
    }

    fn has(&self, text: &str) -> bool {
        self.harness.query_all_by_label(text).next().is_some()
    }
}

fn chosen(shown: &Shown) -> Option<Choice> {
    shown.built.as_ref().map(|b| b.choice)
}

fn grouped(n: usize) -> String {
    dorsum::app::widgets::grouped(n)
}

#[test]
fn nothing_is_built_until_the_panel_opens_and_nothing_is_kept_when_it_closes() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = workbench(folder.path().to_owned());
    let ledger = |w: &View| {
        let scene = w.scene.clone().unwrap();
        Ledger::of(&scene.scenario, w.purpose)
            .row(Item::PartitionTree)
            .clone()
    };
    let part = |w: &View| {
        let mut list = w.parts.list().into_iter();
        list.find(|(item, _)| *item == Item::PartitionTree)
    };
    let before = view(harness.state());
    assert!(!before.purpose.partitioned && part(&before).is_none());
    assert_eq!(before.study.lock().builds(), 0);
    assert_eq!(
        ledger(&before).reason,
        "no partition panel is open and no engine uses it"
    );
    let surface = before.scene.clone().unwrap().surface.clone();
    drop(before);
    let users = Arc::strong_count(&surface);

    harness.get_by_label("Open Partition").click();
    wait_for(&mut harness, "a tree", |w| {
        view(w).study.lock().shown().built.is_some()
    });
    let open = view(harness.state());
    let built = open.study.lock().shown().built.unwrap();
    let (_, cost) = part(&open).unwrap();
    assert!(
        cost.bytes > built.structure().partition().bytes(),
        "{cost:?}"
    );
    assert_eq!(cost.cost_us, Some((built.build_us, "build")));
    assert_eq!(ledger(&open).reason, "partition panel");
    assert_eq!(open.study.lock().builds(), 1);
    drop((built, open));

    harness.get_by_label("Close Partition").click();
    harness.run_steps(4);
    let closed = view(harness.state());
    assert!(closed.study.lock().shown().built.is_none() && part(&closed).is_none());
    assert!(!closed.purpose.partitioned);
    assert_eq!(closed.study.lock().builds(), 1);
    drop(closed);
    assert_eq!(
        Arc::strong_count(&surface),
        users,
        "the surface is still held"
    );
}

#[test]
fn every_control_that_grows_another_tree_builds_it_and_the_rest_do_not() {
    let mut window = Window::open(support::running(), [420.0, 1500.0]);
    window.wait("the published tree", |s| {
        chosen(s) == Some(Choice::default())
    });
    let builds = |w: &Window| w.view.lock().unwrap().study.lock().builds();
    window.click("Octree");
    window.wait("the octree", |s| {
        chosen(s).is_some_and(|c| c.kind == Kind::Octree)
    });
    // Octrees know no cases: the choice is greyed out.
    window.click("Case A");
    assert_eq!(builds(&window), 2);
    window.click("Hybrid octree");
    window.wait("the hybrid", |s| {
        chosen(s).is_some_and(|c| c.kind == Kind::Hybrid)
    });
    window.click("BSP");
    window.wait("the BSP", |s| {
        chosen(s).is_some_and(|c| c.kind == Kind::Bsp)
    });
    window.click("Case B");
    let shown = window.wait("case B", |s| chosen(s).is_some_and(|c| c.case == Case::B));
    let entries = shown.built.unwrap().statistics.entries;
    assert!(
        entries > support::scene().surface.triangles().len(),
        "{entries}"
    );
    let before = builds(&window);
    for name in [
        "Query as published",
        "Boxes of the level",
        "Split planes",
        "Loose bounds",
        "Fixed place",
    ] {
        window.click(name);
    }
    assert_eq!(builds(&window), before);
    let settings = window.shown().settings;
    assert_eq!(
        (settings.query, settings.follow),
        (Query::Published, Follow::Fixed)
    );
    assert!(!settings.show.planes && settings.show.loose);
    window.harness.check_accessibility();
    window.closed.store(true, Ordering::Relaxed);
    window.harness.run_steps(2);
    assert!(window.shown().built.is_none());
}

#[test]
fn the_numbers_on_screen_are_those_of_the_partition_itself() {
    let mut window = Window::open(support::running(), [420.0, 1500.0]);
    let shown = window.wait("a tree", |s| s.asked.is_some());
    let scene = support::scene();
    let options = Options::default();
    let direct = Structure::build("bsp", &scene.surface, &options, &mut |_| true);
    let direct = direct.unwrap().unwrap();
    let s = direct.statistics(&scene.surface).unwrap();
    assert_eq!(shown.built.as_ref().unwrap().statistics, s);
    assert_eq!(shown.built.as_ref().unwrap().fault, None);
    let probe = window.view.lock().unwrap().fingers[0].contact.anchor_mm;
    let region = Aabb::cube(probe, longest_edge_mm(&scene) / 4.0);
    let (mut complete, mut published) = (Vec::new(), Vec::new());
    let cost = direct
        .gather(&scene.surface, &region, &mut complete)
        .unwrap();
    let as_published = direct.gather_as_published(&region, &mut published).unwrap();
    for text in [
        grouped(s.nodes),
        format!("{}, {} empty", grouped(s.leaves), grouped(s.empty_leaves)),
        format!(
            "mean {:.1}, most {}",
            s.mean_occupancy,
            grouped(s.max_occupancy)
        ),
        format!("{:.1} leaves", s.mean_overlap),
        format!("{:.2}", s.w),
        format!("{:.2}", s.w_complete),
        grouped(complete.len()),
        grouped(published.len()),
        grouped(cost.nodes),
        grouped(as_published.nodes),
        grouped(as_published.leaves),
    ] {
        assert!(window.has(&text), "{text} is not on screen");
    }
    window.harness.get_by_label_contains("well formed");
}

/// What is marked green is what brute force finds in the box, wherever the finger is and whichever tree answers.
#[test]
fn haptic_triangles_are_those_of_brute_force_and_follow_the_finger() {
    let mut desk = Desk::new(support::scene());
    let scene = support::scene();
    let half = longest_edge_mm(&scene) * 0.13;
    for kind in Kind::ALL {
        for case in [Case::A, Case::B, Case::C] {
            desk.choose(|s| {
                s.choice = Choice {
                    kind,
                    case,
                    threshold: 200,
                };
                s.edge_part = 0.13;
            });
            desk.built();
            for step in 0..4 {
                let mut record = support::touching(0, step, 4.0);
                record.contact.anchor_mm.y += 31.0 * step as f64 - 50.0;
                let probe = record.contact.anchor_mm;
                desk.view.fingers = vec![record];
                let shown = desk.follow();
                let mut expected = Vec::new();
                Brute.in_box(&scene.surface, &Aabb::cube(probe, half), &mut expected);
                let asked = shown.asked.unwrap();
                assert_eq!(asked.complete.triangles, expected, "{kind:?} {case:?}");
                assert!(expected.len() > 50);
                let missed = expected
                    .iter()
                    .filter(|t| !asked.published.triangles.contains(t));
                assert_eq!(asked.missed, missed.count());
                let drawn: Vec<_> = shown.overlay.patches[0].corners().to_vec();
                let marked = expected
                    .iter()
                    .map(|&t| scene.surface.triangles()[t as usize]);
                assert_eq!(drawn, marked.collect::<Vec<_>>());
            }
        }
    }
}

#[test]
fn the_box_follows_either_finger_also_a_free_one_or_stays_where_it_was_put() {
    let mut desk = Desk::new(support::scene());
    let mut free = support::touching(1, 0, 0.0);
    free.contact.touch = dorsum::contact::Touch::Free;
    free.reading.position_mm = Vec3::new(10.0, 200.0, 300.0);
    desk.view.fingers = vec![support::touching(0, 0, 5.0), free];
    let at = |desk: &Desk| desk.built().asked.map(|a| a.probe_mm);
    assert_eq!(at(&desk), Some(support::place().0));
    desk.choose(|s| s.follow = Follow::Finger(1));
    assert_eq!(at(&desk), Some(free.reading.position_mm));
    let put = Vec3::new(-20.0, 150.0, 40.0);
    desk.choose(|s| (s.follow, s.fixed_mm) = (Follow::Fixed, put));
    assert_eq!(at(&desk), Some(put));
    // A device that says nonsense: the box stays where a hand last put it.
    desk.choose(|s| s.follow = Follow::Finger(0));
    desk.view.fingers[0].contact.anchor_mm = Vec3::NAN;
    assert_eq!(at(&desk), Some(put));
}

/// The corners of all boxes drawn, as bits, so that they can be compared exactly.
fn drawn_boxes(layer: &Layer) -> BTreeSet<[[u32; 3]; 2]> {
    layer.lines().chunks(24).map(corners_of).collect()
}

fn corners_of(lines: &[LayerVertex]) -> [[u32; 3]; 2] {
    let fold = |pick: fn(f32, f32) -> f32| {
        let mut of = lines[0].position;
        for v in lines {
            of = std::array::from_fn(|k| pick(of[k], v.position[k]));
        }
        of.map(f32::to_bits)
    };
    [fold(f32::min), fold(f32::max)]
}

fn as_drawn(b: &Aabb) -> [[u32; 3]; 2] {
    [b.min, b.max].map(|p| p.to_array().map(|x| (x as f32).to_bits()))
}

/// The parts into which halving every axis `n` times cuts a box.
fn grid(b: &Aabb, n: u32) -> BTreeSet<[[u32; 3]; 2]> {
    let many = 1 << n;
    let at = |k: usize, i: u32| b.min[k] + (b.max[k] - b.min[k]) * f64::from(i) / f64::from(many);
    let mut parts = BTreeSet::new();
    for x in 0..many {
        for y in 0..many {
            for z in 0..many {
                let corner = |d: u32| Vec3::new(at(0, x + d), at(1, y + d), at(2, z + d));
                parts.insert(as_drawn(&Aabb {
                    min: corner(0),
                    max: corner(1),
                }));
            }
        }
    }
    parts
}

/// Over a sphere every cell of the first levels is split: level 3 of the BSP and level 1 of the octrees are its octants,
/// level 6 and level 2 the 64 parts.
#[test]
fn boxes_of_a_level_are_the_halves_of_halves_in_closed_form() {
    // Of size 256 about the origin: halving it is exact, in any precision.
    let desk = Desk::new(scene_on(&primitives::icosphere(128.0, 4)));
    let bounds = desk.view.scene.as_ref().unwrap().surface.bounds();
    desk.choose(|s| {
        s.choice.threshold = 16;
        s.follow = Follow::Fixed;
        s.show.boxes = Boxes::All;
        s.show.planes = false;
    });
    for (kind, per_octant) in [(Kind::Bsp, 3), (Kind::Octree, 1), (Kind::Hybrid, 1)] {
        for n in 0..2 {
            desk.choose(|s| {
                s.choice.kind = kind;
                s.show.level = per_octant * n;
            });
            let shown = desk.built();
            let boxes = drawn_boxes(&shown.overlay.layers[0]);
            assert_eq!(boxes, grid(&bounds, n), "{kind:?} {n}");
            assert_eq!(shown.boxes, [boxes.len(); 2]);
        }
    }
}

/// The first three planes of a BSP halve the box across x, then each half across y, then each quarter across z; an
/// octree's root has all three at once. Each in its colour.
#[test]
fn split_planes_stand_where_the_cells_are_halved_each_in_the_colour_of_its_axis() {
    let desk = Desk::new(scene_on(&primitives::icosphere(128.0, 4)));
    let bounds = desk.view.scene.as_ref().unwrap().surface.bounds();
    desk.choose(|s| {
        s.choice.threshold = 16;
        s.show.wire = false;
        s.show.hdb = false;
    });
    for (kind, levels, per_axis) in [(Kind::Bsp, 3, [1, 2, 4]), (Kind::Octree, 1, [1, 1, 1])] {
        desk.choose(|s| {
            s.choice.kind = kind;
            s.show.level = levels;
        });
        let shown = desk.built();
        let layer = &shown.overlay.layers[0];
        for (axis, expected) in per_axis.into_iter().enumerate() {
            let [r, g, b, _] = DARK.tree.planes[axis].to_array();
            let faces: Vec<_> = (layer.faces().chunks(6))
                .filter(|f| f[0].color[..3] == [r, g, b])
                .collect();
            assert_eq!(faces.len(), expected, "{kind:?} axis {axis}");
            let middle = bounds.centre()[axis] as f32;
            assert!(
                faces
                    .iter()
                    .all(|f| f.iter().all(|v| v.position[axis] == middle))
            );
        }
    }
}

#[test]
fn which_boxes_are_drawn_is_chosen_by_level_and_kind_of_node() {
    let desk = Desk::new(sphere());
    desk.choose(|s| s.choice.threshold = 64);
    let height = desk.built().built.unwrap().height();
    assert!(height > 4);
    type Rule = fn(&Node, u32) -> bool;
    let rules: [(Boxes, Rule); 3] = [
        (Boxes::All, |n, l| {
            n.level == l || (n.is_leaf() && n.level < l)
        }),
        (Boxes::Leaves, |n, l| n.is_leaf() && n.level <= l),
        (Boxes::FullLeaves, |n, l| {
            n.is_leaf() && n.level <= l && n.held > 0
        }),
    ];
    for (boxes, rule) in rules {
        for (level, loose) in [(0, false), (3, false), (height, false), (u32::MAX, true)] {
            desk.choose(|s| {
                (s.show.boxes, s.show.level, s.show.loose) = (boxes, level, loose);
                s.show.planes = false;
            });
            let shown = desk.follow();
            let built = shown.built.unwrap();
            let nodes = built.tree().unwrap().nodes().iter();
            let expected: BTreeSet<_> = nodes
                .filter(|n| rule(n, level.min(height)))
                .map(|n| if loose { n.bounds } else { n.cell })
                .filter(|b| !b.is_empty())
                .map(|b| as_drawn(&b))
                .collect();
            let tree_boxes = shown.boxes[0];
            let drawn = if tree_boxes == 0 {
                BTreeSet::new()
            } else {
                drawn_boxes(&shown.overlay.layers[0])
            };
            assert_eq!(drawn, expected, "{boxes:?} {level} {loose}");
        }
    }
}

/// What did not change is neither made nor sent to the graphics card again.
#[test]
fn a_hand_at_rest_changes_nothing_and_a_moved_one_only_what_it_must() {
    let mut desk = Desk::new(support::scene());
    desk.view.fingers = vec![support::touching(0, 0, 5.0)];
    let first = desk.built().overlay;
    assert_eq!(desk.follow().overlay, first);
    desk.view.fingers[0].contact.anchor_mm.x += 1e-5;
    assert_eq!(desk.follow().overlay, first, "trembling");
    desk.view.fingers[0].contact.anchor_mm.x += 0.01;
    let moved = desk.follow();
    assert_eq!(moved.overlay.layers[0], first.layers[0], "the tree");
    assert_ne!(moved.overlay.layers[1], first.layers[1], "the box");
    assert_eq!(
        moved.overlay.patches, first.patches,
        "the same triangles lie in it"
    );
    desk.view.fingers[0].contact.anchor_mm.x += 40.0;
    let far = desk.follow();
    assert_ne!(far.overlay.patches, first.patches);
    desk.choose(|s| s.show.level = 1);
    let shallow = desk.follow();
    assert_ne!(shallow.overlay.layers[0], first.layers[0]);
    assert_eq!(shallow.overlay.patches, far.overlay.patches);
    let colours = desk.view.theme;
    desk.view.theme = LIGHT;
    assert_ne!(desk.follow().overlay.patches, far.overlay.patches);
    assert_ne!(colours, LIGHT);
}

#[test]
fn another_scene_gets_another_tree_and_a_stopped_build_waits_to_be_asked() {
    let mut desk = Desk::new(support::scene());
    let first = desk.built().built.unwrap();
    desk.view.scene = Some(sphere());
    desk.view.scene_generation = 2;
    assert!(desk.follow().built.is_none(), "of another surface");
    let second = desk.built().built.unwrap();
    assert_ne!(first.surface.hash(), second.surface.hash());
    desk.choose(|s| s.choice.threshold = 16);
    assert!(desk.follow().building.is_some());
    desk.study().lock().stop();
    let stopped = desk.follow();
    assert!(stopped.stopped && stopped.building.is_none());
    assert_eq!(
        chosen(&stopped).unwrap().threshold,
        1024,
        "the old tree stays"
    );
    desk.study().lock().go_on();
    assert_eq!(chosen(&desk.built()).unwrap().threshold, 16);
    desk.view.scene = None;
    assert!(desk.follow().built.is_none());
}

#[test]
fn a_point_of_the_skin_is_told_its_leaf_and_the_way_to_it() {
    let desk = Desk::new(scene_on(&primitives::icosphere(128.0, 4)));
    desk.choose(|s| s.choice.threshold = 200);
    let built = desk.built().built.unwrap();
    let p = Vec3::new(40.0, 90.0, -80.0);
    let near = Brute.nearest(&built.surface, p, 20.0).unwrap();
    desk.study()
        .lock()
        .point_at(Some((near.point, near.triangle)));
    let place = desk.follow().place.unwrap();
    assert!(place.cell.contains(near.point));
    assert!(place.path.starts_with("+x +y -z"), "{}", place.path);
    assert_eq!(place.path.split(' ').count(), place.level as usize);
    let leaf = &built.tree().unwrap().nodes()[place.leaf as usize];
    assert!(leaf.is_leaf() && leaf.held as usize == place.held);
    let drawn = desk.follow().overlay.layers;
    assert_eq!(
        drawn_boxes(drawn.last().unwrap()),
        [as_drawn(&leaf.cell)].into()
    );
    desk.study().lock().point_at(Some((Vec3::splat(900.0), 0)));
    assert!(desk.follow().place.is_none());
}

/// CIE L*a*b* of an sRGB colour, for how different two colours look.
fn lab(color: egui::Color32) -> [f64; 3] {
    let linear = |c: u8| {
        let c = f64::from(c) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    let [r, g, b] = [color.r(), color.g(), color.b()].map(linear);
    let f = |t: f64| {
        if t > 0.008856 {
            t.cbrt()
        } else {
            7.787 * t + 16.0 / 116.0
        }
    };
    let x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
    let y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
    let z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Blue and red belong to the fingers: a leaf's blue and a plane's red look like neither, nor like each other.
#[test]
fn no_colour_of_the_tree_is_taken_for_a_finger_or_for_another() {
    for theme in [DARK, LIGHT] {
        let tree = theme.tree;
        let all = [
            tree.leaf,
            tree.haptic,
            tree.planes[0],
            tree.planes[1],
            tree.planes[2],
        ];
        let far = |a: egui::Color32, b: egui::Color32, least: f64| {
            let (a, b) = (lab(a), lab(b));
            let d = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            assert!(d > least, "{d} between {a:?} and {b:?}");
        };
        for (i, &color) in all.iter().enumerate() {
            for finger in theme.fingers {
                far(color, finger, 35.0);
            }
            for &other in &all[..i] {
                far(color, other, 25.0);
            }
        }
    }
}

#[test]
fn the_panel_says_what_it_waits_for() {
    let mut window = Window::open(View::default(), [420.0, 300.0]);
    window.harness.run_steps(2);
    window.harness.get_by_label("No tree yet");
    window.harness.get_by_label_contains("Open a scene");
    let building = support::views().remove(1).1;
    let mut window = Window::open(building, [420.0, 300.0]);
    window.harness.run_steps(2);
    window.harness.get_by_label_contains("being built");
    let _ = Theme::of(true);
}
