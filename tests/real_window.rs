//! Opens the real program on a virtual display and looks at what it draws.
#![cfg(feature = "gui")]

use std::path::Path;
use std::process::Command;

/// RGB picture read from a PNG.
struct Picture {
    width: usize,
    height: usize,
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    fn read(path: &Path) -> Self {
        let file =
            std::io::BufReader::new(std::fs::File::open(path).expect("the picture was written"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("a frame");
        let channels = info.color_type.samples();
        let rgb = bytes
            .chunks_exact(channels)
            .map(|p| [p[0], p[1], p[2]])
            .collect();
        Self {
            width: info.width as usize,
            height: info.height as usize,
            rgb,
        }
    }

    /// Share of pixels in a part of the window (fractions of its width and height) for which `is` holds.
    fn share(&self, x: [f64; 2], y: [f64; 2], is: impl Fn([u8; 3]) -> bool) -> f64 {
        let range = |f: [f64; 2], n: usize| (f[0] * n as f64) as usize..(f[1] * n as f64) as usize;
        let (columns, rows) = (range(x, self.width), range(y, self.height));
        let n = columns.len() * rows.len();
        let hits = rows
            .flat_map(|r| columns.clone().map(move |c| (r, c)))
            .filter(|&(r, c)| is(self.rgb[r * self.width + c]))
            .count();
        hits as f64 / n as f64
    }
}

/// Skin is warm: red above green above blue, and not dark.
fn is_skin([r, g, b]: [u8; 3]) -> bool {
    r > 70 && r > g && g > b && r - b > 18
}

/// The left finger's blue, on the skin and in the plots.
fn is_blue([r, g, b]: [u8; 3]) -> bool {
    b > 120 && b > r.saturating_add(40) && b > g.saturating_add(15)
}

fn screenshot(folder: &Path, name: &str, arguments: &[&str]) -> Option<Picture> {
    let path = folder.join(name);
    let output = Command::new("xvfb-run")
        .args([
            "-a",
            "-s",
            "-screen 0 1280x800x24",
            env!("CARGO_BIN_EXE_dorsum"),
            "--screenshot",
        ])
        .arg(&path)
        .args(arguments)
        .env("XDG_DATA_HOME", folder.join("data"))
        .env_remove("WAYLAND_DISPLAY")
        .output();
    let output = match output {
        Ok(output) => output,
        Err(e) => {
            println!("skipped: xvfb-run cannot be started ({e}); tests/run.sh installs it");
            return None;
        }
    };
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "dorsum ended with {}: {text}",
        output.status
    );
    Some(Picture::read(&path))
}

#[test]
fn the_window_shows_skin_a_dent_under_the_finger_and_plot_lines() {
    let folder = tempfile::tempdir().expect("a folder");
    let Some(rest) = screenshot(folder.path(), "rest.png", &[]) else {
        return;
    };
    let Some(pressed) = screenshot(folder.path(), "pressed.png", &["--press"]) else {
        return;
    };
    assert_eq!((pressed.width, pressed.height), (1280, 800));

    let view = ([0.02, 0.64], [0.10, 0.94]);
    let skin = rest.share(view.0, view.1, is_skin);
    assert!(
        skin > 0.15,
        "skin covers {:.1} % of the back view",
        skin * 100.0
    );

    let finger = pressed.share(view.0, view.1, is_blue);
    assert!(
        finger > 0.0002,
        "the finger covers {:.3} % of the back view",
        finger * 100.0
    );

    let changed = (0..pressed.rgb.len())
        .filter(|&i| {
            let column = i % pressed.width;
            column < pressed.width * 64 / 100 && is_skin(rest.rgb[i]) && is_skin(pressed.rgb[i])
        })
        .filter(|&i| (0..3).any(|c| rest.rgb[i][c].abs_diff(pressed.rgb[i][c]) > 6))
        .count();
    assert!(
        changed > 300,
        "only {changed} skin pixels changed under the press"
    );

    let lines = pressed.share([0.67, 1.0], [0.05, 0.60], is_blue);
    let lines_at_rest = rest.share([0.67, 1.0], [0.05, 0.60], is_blue);
    assert!(
        lines > 0.0005,
        "plot lines cover {:.3} % ({:.3} % at rest)",
        lines * 100.0,
        lines_at_rest * 100.0
    );
}
