//! The thread that takes in what the servo sends, and wakes the windows when there is something to draw.

use super::Shared;
use std::sync::{Arc, Weak};
use std::time::Duration;

/// Display rate: the windows are woken no faster.
const PERIOD: Duration = Duration::from_millis(16);

/// Starts the pump; it ends with `shared`.
///
/// # Errors
/// When the system refuses another thread.
pub fn start(shared: &Arc<Shared>, ctx: egui::Context) -> std::io::Result<()> {
    let shared: Weak<Shared> = Arc::downgrade(shared);
    std::thread::Builder::new()
        .name("pump".into())
        .spawn(move || {
            while let Some(shared) = shared.upgrade() {
                let changed = shared.bench().poll();
                if changed {
                    ctx.request_repaint_of(egui::ViewportId::ROOT);
                    for id in &shared.chrome().windows {
                        ctx.request_repaint_of(*id);
                    }
                }
                drop(shared);
                std::thread::sleep(PERIOD);
            }
        })?;
    Ok(())
}
