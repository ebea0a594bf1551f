//! The tick allocates nothing: two fingers with friction on a curved surface, every record pushed to the recorder's ring.
//! Nor does the deformation of a frame.
//!
//! The allocator of this program aborts at the first thing asked of it on the thread that has armed it.

// A global allocator can only be written with `unsafe`; it hands everything on to the system's.
#![allow(unsafe_code)]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::contact::published::{self, Published};
use dorsum::contact::{Friction, Stiffness, Touch, TouchScene};
use dorsum::deform::models::fsmd::{Fsmd, Settings};
use dorsum::deform::strain::Strain;
use dorsum::deform::{Displacement, Model as _, Press};
use dorsum::device::Reading;
use dorsum::geom::{Vec2, Vec3};
use dorsum::partition::bvh::Bvh;
use dorsum::partition::hdb::Query;
use dorsum::servo::{FingerRecord, LimitFlags, Rig, TickInput, tick};
use dorsum::surface::Surface;
use dorsum::surface::primitives::{bench_patch, bench_path};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

thread_local! {
    static ARMED: Cell<bool> = const { Cell::new(false) };
}

struct Alarm;

/// Set for the process that shows that the alarm rings.
const RING: &str = "DORSUM_RING_THE_ALARM";

fn check() {
    if ARMED.get() {
        // Disarmed first: telling it may allocate.
        ARMED.set(false);
        eprintln!("something was allocated or freed while the alarm was armed");
        std::process::abort();
    }
}

unsafe impl GlobalAlloc for Alarm {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check();
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check();
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, ptr: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        check();
        unsafe { System.realloc(ptr, layout, new_size) }
    }

    unsafe fn dealloc(&self, ptr: *mut u8, layout: Layout) {
        check();
        unsafe { System.dealloc(ptr, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Alarm = Alarm;

/// Runs `work`; aborts the process if it allocates or frees.
fn armed(work: impl FnOnce()) {
    ARMED.set(true);
    work();
    ARMED.set(false);
}

#[test]
fn the_alarm_rings() {
    if std::env::var_os(RING).is_some() {
        armed(|| drop(std::hint::black_box(vec![1_u8; 64])));
        return;
    }
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "the_alarm_rings", "--nocapture"])
        .env(RING, "1")
        .output()
        .unwrap();
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("while the alarm was armed"));
}

#[test]
fn thousands_of_ticks_allocate_nothing() {
    run(None, 8000, false);
    run(None, 8000, true);
}

#[test]
fn nor_do_those_of_the_published_pass_with_any_structure() {
    for partition in published::KINDS {
        for query in [Query::Published, Query::Complete] {
            let mut options = published::Options {
                partition,
                query,
                ..published::Options::default()
            };
            options.tree.threshold = 64;
            run(Some(options), 1000, true);
        }
    }
}

#[test]
fn nor_does_deforming_the_skin_once_it_has_been_as_large() {
    let (skin, _) = Surface::new(bench_patch(20_389)).unwrap();
    let press = |x: f64, y: f64| {
        let to = |v: &usize| skin.positions()[*v].truncate().distance(Vec2::new(x, y));
        let v = (0..skin.positions().len())
            .min_by(|a, b| to(a).total_cmp(&to(b)))
            .unwrap();
        Press {
            anchor_mm: skin.positions()[v],
            foot_mm: skin.positions()[v] + Vec3::new(4.0, 3.0, 0.0),
            normal: skin.normals()[v],
            depth_mm: 7.0,
            triangle: skin.topology().triangles_of(v as u32)[0],
            ..Press::default()
        }
    };
    let presses = [press(-60.0, 20.0), press(50.0, -10.0)];
    let mut model = Fsmd::new(Settings::default());
    let mut out = Displacement::at_rest(&skin);
    let mut strain = Strain::new(&skin, &out);
    model.update_strained(&skin, &presses, &mut out, &mut strain);
    let moved = out.n_moved();
    model.update_strained(&skin, &[], &mut out, &mut strain);
    armed(|| {
        model.update_strained(&skin, &presses, &mut out, &mut strain);
        model.update_strained(&skin, &presses[..1], &mut out, &mut strain);
        model.update(&skin, &presses, &mut out);
        strain.update(&skin, &out);
    });
    assert!(moved > 1000 && out.n_moved() == moved);
}

/// Two fingers for this many ticks, with or without the passivity controller, the alarm armed.
fn run(published: Option<published::Options>, ticks: i32, passivity: bool) {
    let as_published = published.is_some();
    let triangles = if as_published { 2_000 } else { 20_389 };
    let (surface, _) = Surface::new(bench_patch(triangles)).unwrap();
    let published = published.map(|options| {
        let built = Published::build(&surface, &options, &mut |_| true);
        Arc::new(built.unwrap().unwrap())
    });
    let search = Arc::new(Bvh::new(&surface));
    let stiffness: Arc<[f64]> = surface
        .positions()
        .iter()
        .map(|p| 0.5 + 0.001 * p.x)
        .collect();
    let scene = TouchScene {
        friction: Some(Friction {
            static_coefficient: 0.46,
            dynamic_coefficient: 0.44,
            skin_looseness: 1.0,
        }),
        published,
        ..TouchScene::new(
            Arc::new(surface),
            search,
            Stiffness::PerVertex(stiffness.clone()),
        )
    };
    // Edits of stiffness and skin drag come in all the time: boxes made before, freed after.
    let per_vertex = Arc::clone(&stiffness);
    let edited = |i: u32| {
        let uneven = |k: &f64| k * (0.6 + 0.2 * f64::from(i % 5));
        let stiffness = Stiffness::PerVertex(stiffness.iter().map(uneven).collect());
        let rough = |k: &f64| 1.0 + 0.2 * f64::from(i % 3) * k;
        let drag = (!i.is_multiple_of(3)).then(|| per_vertex.iter().map(rough).collect());
        Box::new(TouchScene {
            stiffness,
            drag,
            ..scene.clone()
        })
    };
    let n_edits = ticks as u32 / 150;
    let mut edits: Vec<_> = (1..=n_edits).map(edited).collect();
    let mut old = Vec::with_capacity(edits.len());
    let (mut fading, mut damped) = (0, 0);
    let mut rig = Rig::new(Box::new(scene.clone()), Default::default());
    for limits in &mut rig.limits {
        limits.passivity = passivity;
    }
    let (mut records, mut drained) = rtrb::RingBuffer::<FingerRecord>::new(1024);
    let mut seen = [0_u32; 4];
    let mut read = 0;
    armed(|| {
        for k in 0..ticks {
            let t = f64::from(k) / 1000.0;
            // In and out of contact; the second finger faster, and with readings that are no use now and then.
            let depth = 6.0 * libm::sin(5.0 * t) - 2.0;
            let mut input = TickInput {
                n_fingers: 2,
                force_enabled: true,
                late: k % 997 == 0,
                ..TickInput::default()
            };
            let usable = k % 501 != 0;
            input.readings[0] = Reading {
                position_mm: bench_path(t, depth),
                connected: true,
                ..Reading::default()
            };
            input.readings[1] = Reading {
                position_mm: if usable {
                    bench_path(7.0 * t + 3.0, -4.0)
                } else {
                    Vec3::NAN
                },
                connected: k % 1303 != 0,
                ..Reading::default()
            };
            if k % 100 == 50
                && !rig.is_fading()
                && let Some(scene) = edits.pop()
            {
                old.push(rig.edit_scene(rig.edit + 1, scene));
            }
            fading += u32::from(rig.is_fading());
            let record = tick(&mut rig, &input, 1e-3);
            for finger in record.fingers() {
                seen[finger.contact.touch as usize] += 1;
                damped += u32::from(finger.limits.has(LimitFlags::PASSIVITY));
                assert!(records.push(*finger).is_ok());
            }
            while drained.pop().is_ok() {
                read += 1;
            }
        }
    });
    assert_eq!(read, 2 * ticks);
    assert!(
        rig.edit >= 5 && fading > 300,
        "{} edits, {fading} ticks",
        rig.edit
    );
    assert!(
        if passivity { damped > 100 } else { damped == 0 },
        "the passivity controller acted {damped} times"
    );
    let [free, _, stick, slip] = seen;
    let enough = if as_published {
        free > 100 && stick + slip > 400
    } else {
        free > 500 && stick > 50 && slip > 2000
    };
    assert!(enough, "{seen:?}: every state was visited");
    assert_eq!(seen[Touch::Frictionless as usize], 0);
}
