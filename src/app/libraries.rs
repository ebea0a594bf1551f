//! Whether a window can open at all, checked before the window toolkit can panic over it.

use std::ffi::OsString;

/// A library that the toolkit loads at run time, and the Debian package that holds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Library {
    file: &'static str,
    package: &'static str,
}

const fn library(file: &'static str, package: &'static str) -> Library {
    Library { file, package }
}

/// Needed on X11.
const X11: [Library; 6] = [
    library("libX11.so.6", "libx11-6"),
    library("libX11-xcb.so.1", "libx11-xcb1"),
    library("libXcursor.so.1", "libxcursor1"),
    library("libXi.so.6", "libxi6"),
    library("libxkbcommon-x11.so.0", "libxkbcommon-x11-0"),
    library("libEGL.so.1", "libegl1"),
];

/// Needed on Wayland.
const WAYLAND: [Library; 3] = [
    library("libxkbcommon.so.0", "libxkbcommon0"),
    library("libwayland-egl.so.1", "libwayland-egl1"),
    library("libEGL.so.1", "libegl1"),
];

/// Whether a window can open here.
///
/// # Errors
/// One line: there is no display, or which packages are missing.
pub fn can_open() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    check(|name| std::env::var_os(name), loads)
}

fn check(
    env: impl Fn(&str) -> Option<OsString>,
    loads: impl Fn(&'static str) -> bool,
) -> Result<(), String> {
    let set = |name: &str| env(name).is_some_and(|value| !value.is_empty());
    let wayland = set("WAYLAND_DISPLAY") || set("WAYLAND_SOCKET");
    let needed: &[Library] = if wayland {
        &WAYLAND
    } else if set("DISPLAY") {
        &X11
    } else {
        return Err(
            "no display: neither DISPLAY nor WAYLAND_DISPLAY is set; start from a desktop, or run `xvfb-run -a dorsum`"
                .into(),
        );
    };
    let missing: Vec<&str> = needed
        .iter()
        .filter(|l| !loads(l.file))
        .map(|l| l.package)
        .collect();
    if missing.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "the window needs libraries that are not installed; on Debian or Ubuntu: sudo apt-get install {}",
            missing.join(" ")
        ))
    }
}

#[expect(
    unsafe_code,
    reason = "loading a library runs its initialisers; these are the ones the window toolkit loads next anyway"
)]
fn loads(file: &'static str) -> bool {
    // SAFETY: system libraries without initialisers that depend on the program; nothing is called in them here.
    unsafe { libloading::Library::new(file) }.is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(names: &'static [&'static str]) -> impl Fn(&str) -> Option<OsString> {
        move |name| names.contains(&name).then(|| OsString::from(":0"))
    }

    #[test]
    fn without_a_display_it_says_so() {
        let error = check(with(&[]), |_| true).expect_err("no display");
        assert!(error.contains("no display") && !error.contains('\n'));
        assert!(check(|_| Some(OsString::new()), |_| true).is_err());
    }

    #[test]
    fn missing_libraries_are_named_by_package() {
        let error = check(with(&["DISPLAY"]), |f| !f.starts_with("libxkb")).expect_err("missing");
        assert!(error.ends_with("libxkbcommon-x11-0"), "{error}");
        let error =
            check(with(&["WAYLAND_DISPLAY"]), |f| !f.contains("wayland")).expect_err("missing");
        assert!(error.contains("libwayland-egl1"));
        assert_eq!(check(with(&["DISPLAY"]), |_| true), Ok(()));
    }

    #[test]
    fn a_library_that_is_not_there_does_not_load() {
        assert!(!loads("libno-such-library.so.0"));
    }
}
