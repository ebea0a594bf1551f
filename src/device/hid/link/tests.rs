//! A link against the other end of a socket.

use super::*;
use crate::device::hid::transport::SocketPort;

/// One byte in: where it is on x, mm; 255 makes it panic. Two bytes out: 7, and the force on x in tenths of a newton.
#[derive(Default)]
struct Toy(f64);

impl Driver for Toy {
    fn take(&mut self, report: &[u8]) -> bool {
        let [x] = report else { return false };
        assert!(*x != 255, "the driver of this test panics when told to");
        self.0 = f64::from(*x) / 100.0;
        true
    }

    fn seen(&self) -> Seen {
        Seen {
            position_mm: Vec3::X * self.0,
            ..Seen::default()
        }
    }

    fn render(&mut self, force_n: Option<Vec3>, out: &mut [u8; REPORT]) -> (usize, [i32; 3]) {
        let tenths = force_n.map_or(0.0, |f| f.x * 10.0);
        out[..2].copy_from_slice(&[7, tenths as u8]);
        (2, [tenths as i32, 0, 0])
    }
}

fn capabilities() -> Capabilities {
    Capabilities::ideal("Toy", 5.0)
}

fn start() -> (Linked, SocketPort) {
    let (host, board) = SocketPort::pair().expect("pair");
    // Patient with a busy machine: what is tried here is not the bound.
    let mut calibration = Calibration::plain("toy", 5.0, 1.0);
    calibration.guards.silence_ms = 100.0;
    calibration.guards.command_timeout_ms = 100.0;
    let linked = Linked::start(
        capabilities(),
        Box::new(host),
        Box::new(Toy::default()),
        &calibration,
    );
    let mut linked = linked.expect("started");
    linked.enable(true);
    (linked, board)
}

/// Takes everything the link says; the last force in tenths, and how many.
fn drain(board: &mut SocketPort) -> (Option<u8>, usize) {
    let (mut last, mut n) = (None, 0);
    let mut into = [0; REPORT];
    while let Ok(2) = board.read(&mut into, 0) {
        assert_eq!(into[0], 7);
        (last, n) = (Some(into[1]), n + 1);
    }
    (last, n)
}

fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(10);
    while !holds() {
        assert!(Instant::now() < end, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Has the device connected and 3 N flowing; how many reports that took.
fn push(device: &mut Linked, board: &mut SocketPort) -> u64 {
    let mut sent = 0;
    until("force never flowed", || {
        board.write(&[50]).expect("sent");
        sent += 1;
        let reading = device.read(0.001);
        device.write(Vec3::X * 3.0);
        reading.connected && drain(board).0 == Some(30)
    });
    sent
}

#[test]
fn a_reading_comes_in_and_a_force_goes_out() {
    let (mut device, mut board) = start();
    assert!(!device.read(0.001).connected);
    push(&mut device, &mut board);
    assert_eq!(device.read(0.001).position_mm, Vec3::X * 0.5);
    let vitals = Device::vitals(&device).expect("a link");
    assert_eq!(vitals.condition(), Condition::Good);
    // Beyond the rated force, and what is no force.
    for (force, tenths) in [
        (Vec3::X * 50.0, 50),
        (Vec3::NAN, 0),
        (Vec3::splat(f64::INFINITY), 0),
    ] {
        until("never", || {
            board.write(&[50]).expect("sent");
            device.write(force);
            drain(&mut board).0 == Some(tenths)
        });
    }
}

#[test]
fn closing_dropping_and_a_panic_of_the_driver_all_end_at_no_current_said_several_times() {
    for how in 0..3 {
        let (mut device, mut board) = start();
        push(&mut device, &mut board);
        let vitals = device.vitals();
        match how {
            0 => device.close(),
            1 => drop(device),
            _ => {
                board.write(&[255]).expect("sent");
                until("never ended", || !device.read(0.001).connected);
                until("never told", || vitals.condition().is_final());
            }
        }
        let (last, n) = drain(&mut board);
        assert_eq!(last, Some(0), "{how}");
        assert!(n >= FAREWELLS, "{how}: {n} reports");
        let expected = if how == 2 {
            Condition::Ended
        } else {
            Condition::Closed
        };
        assert_eq!(vitals.condition(), expected);
    }
}

#[test]
fn a_servo_that_stalls_leaves_no_force_standing() {
    let (mut device, mut board) = start();
    push(&mut device, &mut board);
    until("force stands", || {
        board.write(&[50]).expect("sent");
        drain(&mut board).0 == Some(0)
    });
    assert_eq!(
        device.vitals().condition(),
        Condition::Good,
        "the device is not to blame"
    );
    push(&mut device, &mut board);
}

/// What the motors do besides, as gravity compensation does, ends with it.
#[test]
fn switched_off_means_no_current_whatever_the_servo_says() {
    let (host, mut board) = SocketPort::pair().expect("pair");
    let mut calibration = Calibration::plain("toy", 5.0, 1.0);
    calibration.guards.silence_ms = 100.0;
    let toy = Box::new(Toy::default());
    let linked = Linked::start(capabilities(), Box::new(host), toy, &calibration);
    let mut device = linked.expect("started");
    let off = |device: &mut Linked, board: &mut SocketPort| {
        for _ in 0..30 {
            board.write(&[50]).expect("sent");
            device.read(0.001);
            device.write(Vec3::X * 3.0);
            std::thread::sleep(Duration::from_millis(1));
            assert!(!matches!(drain(board).0, Some(1..)), "off, and it flows");
        }
    };
    off(&mut device, &mut board);
    device.enable(true);
    push(&mut device, &mut board);
    device.enable(false);
    until("never off", || {
        board.write(&[50]).expect("sent");
        drain(&mut board).0 == Some(0)
    });
    off(&mut device, &mut board);
    device.enable(true);
    push(&mut device, &mut board);
}

#[test]
fn an_unplugged_device_is_told_and_stays_so() {
    let (mut device, mut board) = start();
    push(&mut device, &mut board);
    drop(board);
    until("never noticed", || !device.read(0.001).connected);
    until("never told", || {
        device.vitals().condition() == Condition::Unplugged
    });
    device.write(Vec3::X);
    device.close();
    assert_eq!(device.vitals().condition(), Condition::Unplugged);
}

/// A wire whose writes do not return until the test is over.
struct Stuck(std::sync::mpsc::Receiver<()>, bool);

impl Port for Stuck {
    fn read(&mut self, into: &mut [u8; REPORT], _wait_ms: u16) -> Result<usize, Gone> {
        into[0] = 50;
        // One report, then none.
        Ok(usize::from(!std::mem::replace(&mut self.1, true)))
    }

    fn write(&mut self, _report: &[u8]) -> Result<(), Gone> {
        let _ = self.0.recv();
        Err(Gone)
    }
}

#[test]
fn a_wire_that_hangs_is_told_by_the_servos_side_and_does_not_hold_closing_up() {
    let (let_go, held) = std::sync::mpsc::sync_channel(0);
    let port = Box::new(Stuck(held, false));
    let linked = Linked::start(
        capabilities(),
        port,
        Box::new(Toy::default()),
        &Calibration::plain("toy", 5.0, 1.0),
    );
    let mut device = linked.expect("started");
    until("never hung", || device.vitals().counts().reports == 1);
    until("never told", || !device.read(0.001).connected);
    let before = Instant::now();
    device.close();
    assert!(before.elapsed() < Duration::from_secs(5));
    drop(let_go);
}

/// A host that is held up takes the newest report, not the oldest.
#[test]
fn reports_that_piled_up_are_passed_over_for_the_newest() {
    let (mut device, mut board) = start();
    let sent = push(&mut device, &mut board);
    for x in 51..=90 {
        board.write(&[x]).expect("sent");
    }
    until("never", || device.read(0.001).position_mm == Vec3::X * 0.9);
    let counts = device.vitals().counts();
    assert_eq!(counts.reports, sent + 40);
    assert_eq!(counts.not_understood, 0);
}
