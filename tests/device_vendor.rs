//! Makers' libraries, as stubs that are compiled here: which calls come, in which order, of which types, with which values.
//! Never against hardware.

#![cfg(target_os = "linux")]
#![allow(unsafe_code, reason = "asks the stubs for what they were called with")]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use dorsum::device::hid::guard::Condition;
use dorsum::device::vendor::{force_dimension, openhaptics};
use dorsum::device::{Calibration, Device, Family};
use dorsum::geom::Vec3;
use std::ffi::{CStr, c_char, c_int};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What both stubs begin with: a log of calls, each told once in a row.
const LOG: &str = r#"
#include <stdio.h>
#include <string.h>
#include <stdarg.h>
#include <pthread.h>
#include <unistd.h>
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char text[1 << 16], last[256];
static void note(const char *format, ...) {
    char line[256];
    va_list list;
    va_start(list, format);
    vsnprintf(line, sizeof line, format, list);
    va_end(list);
    pthread_mutex_lock(&lock);
    if (strcmp(line, last) != 0 && strlen(text) + strlen(line) + 2 < sizeof text) {
        strcat(text, line);
        strcat(text, "\n");
    }
    strcpy(last, line);
    pthread_mutex_unlock(&lock);
}
const char *stub_log(void) { return text; }
static int failing = 0;
void stub_fail(int how) { failing = how; }
"#;

const DHD: &str = r#"
static double at[3] = { 0.010, -0.020, 0.030 };
int dhdGetDeviceCount(void) { return 2; }
int dhdOpenID(char id) { note("open %d", id); return failing ? -1 : id; }
int dhdClose(char id) { note("close %d", id); return 0; }
int dhdGetPosition(double *x, double *y, double *z, char id) {
    note("position %d", id);
    if (failing) return -1;
    *x = at[0]; *y = at[1]; *z = at[2];
    return 0;
}
int dhdSetForce(double x, double y, double z, char id) {
    note("force %.3f %.3f %.3f of %d", x, y, z, id);
    return 0;
}
int dhdEnableForce(unsigned char on, char id) { note("enable %d of %d", on, id); return 0; }
unsigned dhdGetButtonMask(char id) { return 5; }
const char *dhdErrorGetLastStr(void) { return "no device\nfound"; }
"#;

const HD: &str = r#"
typedef struct { unsigned code; int internal; unsigned device; } HDErrorInfo;
typedef unsigned (*callback)(void *);
static callback turn; static void *data; static pthread_t thread; static volatile int running, begun, over;
unsigned hdInitDevice(const char *name) { note("init %s", name); return failing ? 0xFFFFFFFFu : 3; }
void hdDisableDevice(unsigned d) { note("disable %u", d); }
void hdMakeCurrentDevice(unsigned d) { if (!begun) note("current %u", d); }
void hdBeginFrame(unsigned d) { if (begun) note("begun twice"); begun = 1; if (d != 3) note("frame of %u", d); }
void hdEndFrame(unsigned d) { if (!begun) note("ended twice"); begun = 0; if (d != 3) note("frame of %u", d); }
void hdGetDoublev(unsigned what, double *out) {
    switch (what) {
    case 0x2050: if (!begun) note("position outside of a frame"); out[0] = 10; out[1] = 20; out[2] = 30; break;
    case 0x2602: out[0] = 0.4; break;
    case 0x2603: out[0] = 3.3; break;
    case 0x2604: out[0] = 0.88; break;
    default: note("unknown %x", what);
    }
}
void hdGetIntegerv(unsigned what, int *out) { if (what != 0x2000) note("unknown %x", what); *out = 2; }
void hdSetDoublev(unsigned what, const double *in) {
    if (what != 0x2700 || !begun) note("set %x outside", what);
    note("force %.3f %.3f %.3f", in[0], in[1], in[2]);
}
void hdEnable(unsigned what) { note("enable %x", what); }
void hdDisable(unsigned what) { note("disable %x", what); }
HDErrorInfo hdGetError(void) { HDErrorInfo e = { failing ? 0x0302 : 0, failing ? -7 : 0, 3 }; return e; }
unsigned long hdScheduleAsynchronous(callback c, void *d, unsigned short priority) {
    note("schedule %u", priority); turn = c; data = d; over = 0; return 0x1122334455667788ul;
}
void hdUnschedule(unsigned long handle) { note("unschedule %lx", handle); }
void hdSetSchedulerRate(unsigned rate) { note("rate %u", rate); }
static void *run(void *unused) { while (running) { if (!over && turn(data) == 0) over = 1; usleep(1000); } return 0; }
void hdStartScheduler(void) { note("start"); running = 1; pthread_create(&thread, 0, run, 0); }
void hdStopScheduler(void) { running = 0; pthread_join(thread, 0); note("stop"); }
"#;

/// A stub, compiled and loaded; each in a file of its own, so that tests do not share its state.
struct Stub {
    _folder: tempfile::TempDir,
    file: PathBuf,
    library: libloading::Library,
}

impl Stub {
    fn new(source: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (c, file) = (
            folder.path().join("stub.c"),
            folder.path().join("libstub.so"),
        );
        std::fs::write(&c, format!("{LOG}{source}")).unwrap();
        let compiled = std::process::Command::new("cc")
            .args(["-shared", "-fPIC", "-pthread", "-o"])
            .args([&file, &c])
            .status()
            .expect("a C compiler, which linking needs too");
        assert!(compiled.success());
        // SAFETY: our own stub.
        let library = unsafe { libloading::Library::new(&file).unwrap() };
        Self {
            _folder: folder,
            file,
            library,
        }
    }

    fn log(&self) -> Vec<String> {
        // SAFETY: our own stub; its text ends in 0.
        let text = unsafe {
            let log = self
                .library
                .get::<unsafe extern "C" fn() -> *const c_char>(b"stub_log\0");
            CStr::from_ptr(log.unwrap()())
                .to_string_lossy()
                .into_owned()
        };
        text.lines().map(str::to_owned).collect()
    }

    fn fail(&self) {
        // SAFETY: our own stub.
        unsafe {
            let fail = self
                .library
                .get::<unsafe extern "C" fn(c_int)>(b"stub_fail\0");
            fail.unwrap()(1);
        }
    }
}

/// Patient with a busy machine.
fn calibration(family: &dyn Family) -> Calibration {
    let mut c = family.defaults();
    c.guards.silence_ms = 100.0;
    c.guards.command_timeout_ms = 100.0;
    c
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(10);
    while !holds() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Waits for a reading, then has `force_n` flow until the stub tells `told`.
fn drive(stub: &Stub, device: &mut dyn Device, force_n: Vec3, told: &str) {
    device.enable(true);
    until(told, || {
        let connected = device.read(0.001).connected;
        device.write(force_n);
        connected && stub.log().iter().any(|line| line == told)
    });
}

/// The lines that are not said over and over.
fn once(log: &[String]) -> Vec<&str> {
    let often = |line: &&str| !line.starts_with("position") && !line.starts_with("force");
    let mut lines: Vec<&str> = log.iter().map(String::as_str).filter(often).collect();
    // Off is said when it is switched off, and again at the end.
    lines.dedup();
    lines
}

#[test]
fn force_dimension_is_opened_read_driven_and_closed_as_its_header_says() {
    let stub = Stub::new(DHD);
    let family = &force_dimension::FAMILY;
    let c = calibration(family);
    let mut device = family.open_through(stub.file.as_os_str(), 1, &c).unwrap();
    // Lying: towards the user is footward, right is right.
    drive(
        &stub,
        &mut *device,
        Vec3::new(2.0, -1.0, 3.0),
        "force 1.000 2.000 3.000 of 1",
    );
    let reading = device.read(0.001);
    assert!((reading.position_mm - Vec3::new(-20.0, -10.0, 30.0)).length() < 1e-9);
    assert_eq!(reading.buttons, 5);
    device.close();
    drop(device);
    let log = stub.log();
    assert_eq!(
        once(&log),
        [
            "open 1",
            "enable 0 of 1",
            "enable 1 of 1",
            "enable 0 of 1",
            "close 1"
        ]
    );
    let last_force = log.iter().rfind(|line| line.starts_with("force")).unwrap();
    assert_eq!(last_force, "force 0.000 0.000 0.000 of 1");
}

#[test]
fn force_dimension_tells_what_its_library_tells_of_a_device_that_is_not_there_or_goes() {
    let stub = Stub::new(DHD);
    let family = &force_dimension::FAMILY;
    let c = calibration(family);
    let mut device = family.open_through(stub.file.as_os_str(), 0, &c).unwrap();
    until("connected", || device.read(0.001).connected);
    stub.fail();
    until("gone", || !device.read(0.001).connected);
    until("told", || {
        device.vitals().unwrap().condition() == Condition::Unplugged
    });
    drop(device);
    let error = family
        .open_through(stub.file.as_os_str(), 0, &c)
        .err()
        .unwrap();
    assert_eq!(
        error.to_string(),
        "the device does not open: no device found"
    );
}

#[test]
fn openhaptics_is_opened_read_driven_and_closed_as_its_header_says() {
    let stub = Stub::new(HD);
    let family = &openhaptics::FAMILY;
    let c = calibration(family);
    let mut device = family
        .open_through(stub.file.as_os_str(), "Left Touch", &c)
        .unwrap();
    let can = device.capabilities();
    assert_eq!((can.rated_force_n, can.continuous_force_n), (3.3, 0.88));
    assert_eq!(can.max_stiffness_n_per_mm, 0.4);
    // Theirs: x right, y up, z towards the user, who stands at the feet.
    drive(
        &stub,
        &mut *device,
        Vec3::new(1.0, -2.0, 0.5),
        "force 1.000 0.500 2.000",
    );
    let reading = device.read(0.001);
    assert!((reading.position_mm - Vec3::new(10.0, -30.0, 20.0)).length() < 1e-9);
    assert_eq!(reading.buttons, 2);
    device.close();
    drop(device);
    let log = stub.log();
    let expected = [
        "init Left Touch",
        "current 3",
        "schedule 32767",
        "rate 1000",
        "start",
        "enable 4000",
        "disable 4000",
        "stop",
        "unschedule 1122334455667788",
        "disable 3",
    ];
    assert_eq!(once(&log), expected);
    let last_force = log.iter().rfind(|line| line.starts_with("force")).unwrap();
    assert_eq!(last_force, "force 0.000 0.000 0.000");
}

#[test]
fn openhaptics_tells_its_errors() {
    let stub = Stub::new(HD);
    stub.fail();
    let family = &openhaptics::FAMILY;
    let error = family.open_through(stub.file.as_os_str(), "Left Touch", &calibration(family));
    let told = "\"Left Touch\" does not open: OpenHaptics error 0x0302 (-7) of device 0x3";
    assert_eq!(error.err().unwrap().to_string(), told);
}

#[test]
fn a_library_that_is_not_there_or_is_another_is_one_clear_line() {
    let c = openhaptics::FAMILY.defaults();
    let nowhere = Path::new("/nowhere/libHD.so").as_os_str();
    let error = openhaptics::FAMILY
        .open_through(nowhere, "x", &c)
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("/nowhere/libHD.so") && !error.contains('\n'),
        "{error}"
    );
    // The other maker's.
    let stub = Stub::new(DHD);
    let error = openhaptics::FAMILY.open_through(stub.file.as_os_str(), "x", &c);
    assert!(error.err().unwrap().to_string().contains("hdInitDevice"));
    for family in [
        &openhaptics::FAMILY as &dyn Family,
        &force_dimension::FAMILY,
    ] {
        if let Err(e) = family.ready() {
            assert!(e.to_string().contains("is not installed") && !e.to_string().contains('\n'));
            assert!(family.find().is_empty());
        }
    }
}
