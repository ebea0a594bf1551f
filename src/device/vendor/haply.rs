//! Haply Inverse3, through the maker's service on this computer: JSON over a WebSocket.
//!
//! ```text
//! service: {"inverse3": [{"device_id": "049D", "state": {"cursor_position": {"x": 0.0, "y": -0.1, "z": 0.2}, …}}], …}
//! answer:  {"inverse3": [{"device_id": "049D", "commands": {"set_cursor_force": {"values": {"x": 0.0, "y": 0.0, "z": 1.5}}}}]}
//! ```
//!
//! Metres and newtons; x to the right, y away from the user, z up. The service tells a state only to whom sends forces.
//!
//! Tested with an emulated service; never with hardware.

use super::{Told, force_n, link};
use crate::device::hid::transport::{Gone, Port, REPORT};
use crate::device::{Calibration, Capabilities, Device, DeviceError, Family, Found, Proof};
use crate::geom::Vec3;
use crate::units::mm_from_m;
use serde::{Deserialize, Serialize};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::{Error, HandshakeError, Message, WebSocket};

/// Where the service is.
const SERVICE: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 10001);
/// Longest wait for a connection and for the first state. The service is on this computer.
const PATIENCE: Duration = Duration::from_millis(300);
/// The middle of the workspace in the service's frame, mm. Assumed: where the maker's examples hold the cursor.
const MIDDLE_MM: Vec3 = Vec3::new(0.0, -100.0, 200.0);

#[derive(Debug, Default, Deserialize)]
struct State {
    #[serde(default)]
    inverse3: Vec<Inverse3>,
    #[serde(default)]
    wireless_verse_grip: Vec<Grip>,
}

#[derive(Debug, Deserialize)]
struct Inverse3 {
    device_id: String,
    #[serde(default)]
    state: Option<Cursor>,
}

#[derive(Debug, Deserialize)]
struct Cursor {
    cursor_position: Xyz,
}

#[derive(Debug, Deserialize)]
struct Grip {
    #[serde(default)]
    state: Option<GripState>,
}

#[derive(Debug, Deserialize)]
struct GripState {
    #[serde(default)]
    buttons: Buttons,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Buttons {
    a: bool,
    b: bool,
    c: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Xyz {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize)]
struct Answer<'a> {
    inverse3: [Commands<'a>; 1],
}

#[derive(Serialize)]
struct Commands<'a> {
    device_id: &'a str,
    commands: Command,
}

#[derive(Serialize)]
struct Command {
    set_cursor_force: Values,
}

#[derive(Serialize)]
struct Values {
    values: Xyz,
}

/// A place of the service, m, in the house's frame about the middle of the workspace, mm.
fn house_mm(p: Xyz) -> Vec3 {
    let p = Vec3::new(mm_from_m(p.x), mm_from_m(p.y), mm_from_m(p.z)) - MIDDLE_MM;
    Vec3::new(-p.y, p.x, p.z)
}

/// A force in the service's frame.
fn theirs(f: Vec3) -> Xyz {
    Xyz {
        x: f.y,
        y: -f.x,
        z: f.z,
    }
}

/// A connection to the service.
struct HaplyPort {
    socket: WebSocket<TcpStream>,
    device_id: String,
    number: u16,
}

impl HaplyPort {
    /// Connects, and reads the first state: which devices there are.
    fn connect(service: SocketAddr) -> Result<(Self, Vec<String>), DeviceError> {
        let fail = |why: &dyn std::fmt::Display| {
            DeviceError::new(format!(
                "the Haply service does not answer at {service}: {why}"
            ))
        };
        let stream = TcpStream::connect_timeout(&service, PATIENCE).map_err(|e| fail(&e))?;
        let set = stream
            .set_nodelay(true)
            .and_then(|()| stream.set_read_timeout(Some(PATIENCE)))
            .and_then(|()| stream.set_write_timeout(Some(PATIENCE)));
        set.map_err(|e| fail(&e))?;
        let (mut socket, _) =
            tungstenite::client(format!("ws://{service}/"), stream).map_err(|e| match e {
                HandshakeError::Failure(e) => fail(&e),
                HandshakeError::Interrupted(_) => fail(&"no handshake in time"),
            })?;
        let until = Instant::now() + PATIENCE;
        let state = loop {
            match socket.read() {
                Ok(Message::Text(text)) => {
                    break serde_json::from_str(&text).map_err(|e| fail(&e))?;
                }
                Ok(_) if Instant::now() < until => {}
                Ok(_) => return Err(fail(&"no state in time")),
                Err(e) => return Err(fail(&e)),
            }
        };
        let State { inverse3, .. } = state;
        socket
            .get_ref()
            .set_nonblocking(true)
            .map_err(|e| fail(&e))?;
        let port = Self {
            socket,
            device_id: String::new(),
            number: 0,
        };
        Ok((port, inverse3.into_iter().map(|d| d.device_id).collect()))
    }

    fn open(service: SocketAddr, device_id: &str) -> Result<Self, DeviceError> {
        let (mut port, there) = Self::connect(service)?;
        if !there.iter().any(|id| id == device_id) {
            let what = format!("the Haply service has no Inverse3 \"{device_id}\"");
            return Err(DeviceError::new(what));
        }
        port.device_id = device_id.into();
        Ok(port)
    }

    /// What a message tells of the device; `None` for one that does not.
    fn understood(&mut self, text: &str) -> Option<Told> {
        let state: State = serde_json::from_str(text).ok()?;
        let ours = state
            .inverse3
            .iter()
            .find(|d| d.device_id == self.device_id)?;
        let at = house_mm(ours.state.as_ref()?.cursor_position);
        let grip = state
            .wireless_verse_grip
            .first()
            .and_then(|g| g.state.as_ref());
        let buttons = grip.map_or(0, |g| {
            let Buttons { a, b, c } = g.buttons;
            u32::from(a) | u32::from(b) << 1 | u32::from(c) << 2
        });
        self.number = self.number.wrapping_add(1);
        Some(Told {
            position_mm: at,
            buttons,
            number: self.number,
        })
    }
}

fn is_waiting(e: &Error) -> bool {
    let waits = [
        std::io::ErrorKind::WouldBlock,
        std::io::ErrorKind::TimedOut,
        std::io::ErrorKind::Interrupted,
    ];
    matches!(e, Error::Io(e) if waits.contains(&e.kind()))
}

impl Port for HaplyPort {
    fn read(&mut self, into: &mut [u8; REPORT], wait_ms: u16) -> Result<usize, Gone> {
        let until = Instant::now() + Duration::from_millis(wait_ms.into());
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    return Ok(match self.understood(&text) {
                        Some(told) => told.encode(into),
                        // It is counted as not understood.
                        None => 1,
                    });
                }
                Ok(Message::Close(_)) => return Err(Gone),
                Ok(_) => {}
                Err(e) if is_waiting(&e) => {
                    if Instant::now() >= until {
                        return Ok(0);
                    }
                    std::thread::sleep(Duration::from_micros(100));
                }
                Err(_) => return Err(Gone),
            }
        }
    }

    fn write(&mut self, report: &[u8]) -> Result<(), Gone> {
        let answer = Answer {
            inverse3: [Commands {
                device_id: &self.device_id,
                commands: Command {
                    set_cursor_force: Values {
                        values: theirs(force_n(report)),
                    },
                },
            }],
        };
        let text = serde_json::to_string(&answer).map_err(|_| Gone)?;
        match self.socket.send(Message::text(text)) {
            Ok(()) => Ok(()),
            // It goes with the next.
            Err(e) if is_waiting(&e) => Ok(()),
            Err(_) => Err(Gone),
        }
    }
}

/// The family.
#[derive(Debug)]
pub struct Haply;

/// The family.
pub static FAMILY: Haply = Haply;

impl Haply {
    fn find_at(&self, service: SocketAddr) -> Vec<Found> {
        let Ok((_, there)) = HaplyPort::connect(service) else {
            return Vec::new();
        };
        let found = there.into_iter().take(16).map(|id| Found {
            family: self.key(),
            place: id.clone(),
            title: self.title().into(),
            serial: Some(id),
            note: None,
        });
        let mut found: Vec<Found> = found.collect();
        Found::tell_apart(&mut found);
        found
    }

    fn open_at(
        &self,
        service: SocketAddr,
        device_id: &str,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        let port = HaplyPort::open(service, device_id)?;
        let device = link(self.capabilities(calibration), Box::new(port), calibration)?;
        Ok(Box::new(device))
    }
}

impl Family for Haply {
    fn key(&self) -> &'static str {
        "haply-inverse3"
    }

    fn title(&self) -> &'static str {
        "Haply Inverse3"
    }

    fn about(&self) -> &'static str {
        "Inverse3, with or without a VerseGrip, through its maker's service"
    }

    fn reached(&self) -> &'static str {
        "the Haply service on this computer, port 10001"
    }

    fn proof(&self) -> Proof {
        Proof::Emulator
    }

    /// Assumed until measured: the maker's figures are not in the table of the house.
    fn defaults(&self) -> Calibration {
        Calibration::plain(self.key(), 8.0, 1.0)
    }

    fn capabilities(&self, calibration: &Calibration) -> Capabilities {
        let name = calibration.name.as_deref().unwrap_or(self.title());
        Capabilities {
            max_stiffness_n_per_mm: calibration.max_stiffness_n_per_mm,
            workspace_radius_mm: 100.0,
            resolution_mm: 0.05,
            n_buttons: 3,
            report_rate_hz: 1000.0,
            ..Capabilities::ideal(name, calibration.rated_force_n)
        }
    }

    fn ready(&self) -> Result<(), DeviceError> {
        HaplyPort::connect(SERVICE).map(|_| ())
    }

    fn may_be_watched(&self) -> bool {
        false
    }

    fn find(&self) -> Vec<Found> {
        self.find_at(SERVICE)
    }

    fn open(
        &self,
        found: &Found,
        calibration: &Calibration,
    ) -> Result<Box<dyn Device>, DeviceError> {
        self.open_at(SERVICE, &found.place, calibration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;
    use std::sync::mpsc::{Receiver, sync_channel};
    use std::thread::JoinHandle;

    /// A service with one device that stays where it is and answers each force with a state; the forces on the device, in
    /// their order, come out of the channel when the connection ends.
    fn service(connections: usize) -> (SocketAddr, Receiver<Vec<Xyz>>, JoinHandle<()>) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("port");
        let at = listener.local_addr().expect("address");
        let (told, heard) = sync_channel(connections);
        let serve = move || {
            for stream in listener.incoming().take(connections) {
                let mut forces = Vec::new();
                let mut socket = tungstenite::accept(stream.expect("stream")).expect("handshake");
                let state = r#"{"inverse3":[{"device_id":"04BA","state":{"cursor_position":{"x":0.01,"y":-0.12,"z":0.23},
                    "cursor_velocity":{"x":0,"y":0,"z":0}}}],
                    "wireless_verse_grip":[{"device_id":"1","state":{"buttons":{"a":false,"b":true,"c":false}}}]}"#;
                let _ = socket.send(Message::text(state));
                while let Ok(message) = socket.read() {
                    let Message::Text(text) = message else { break };
                    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                    let ours = &json["inverse3"][0];
                    assert_eq!(ours["device_id"], "04BA");
                    let values = &ours["commands"]["set_cursor_force"]["values"];
                    forces.push(serde_json::from_value(values.clone()).expect("x, y, z"));
                    if socket.send(Message::text(state)).is_err() {
                        break;
                    }
                }
                let _ = told.send(forces);
            }
        };
        let thread = std::thread::Builder::new().spawn(serve).expect("thread");
        (at, heard, thread)
    }

    fn until(what: &str, mut holds: impl FnMut() -> bool) {
        let end = Instant::now() + Duration::from_secs(10);
        while !holds() {
            assert!(Instant::now() < end, "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn frames_are_turned_there_and_back() {
        for v in [Vec3::X, Vec3::Y, Vec3::Z] {
            let Xyz { x, y, z } = theirs(v);
            let m = |x: f64, i: usize| (x + MIDDLE_MM[i]) / 1000.0;
            let there = Xyz {
                x: m(x, 0),
                y: m(y, 1),
                z: m(z, 2),
            };
            assert!((house_mm(there) - v).length() < 1e-9);
        }
    }

    #[test]
    fn an_emulated_service_is_found_read_driven_and_left_without_force() {
        let (at, heard, thread) = service(3);
        let found = FAMILY.find_at(at);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].place, "04BA");
        assert!(
            heard.recv().expect("ended").is_empty(),
            "looking sends no force"
        );
        let error = FAMILY.open_at(at, "other", &FAMILY.defaults()).err();
        let told = "the Haply service has no Inverse3 \"other\"";
        assert_eq!(error.map(|e| e.to_string()).as_deref(), Some(told));
        assert!(heard.recv().expect("ended").is_empty());
        let mut c = FAMILY.defaults();
        c.guards.silence_ms = 100.0;
        c.guards.command_timeout_ms = 100.0;
        let mut device = FAMILY.open_at(at, "04BA", &c).expect("opened");
        until("connected", || device.read(0.001).connected);
        device.enable(true);
        let reading = device.read(0.001);
        // 20 mm towards the user (footward when lying), 10 mm right, 30 mm up.
        assert!((reading.position_mm - Vec3::new(10.0, -20.0, 30.0)).length() < 1e-9);
        assert_eq!(reading.buttons, 2);
        let before = device.vitals().expect("a link").counts().written;
        until("pushed", || {
            device.read(0.001);
            device.write(Vec3::new(1.0, -2.0, 3.0));
            device.vitals().expect("a link").counts().written > before + 5
        });
        device.close();
        drop(device);
        let forces = heard.recv().expect("ended");
        let pushed = Xyz {
            x: 1.0,
            y: -2.0,
            z: 3.0,
        };
        assert!(forces.contains(&pushed), "{forces:?}");
        let last = forces.last().expect("some");
        assert!(last.x == 0.0 && last.y == 0.0 && last.z == 0.0, "{last:?}");
        thread.join().expect("the service is content");
    }

    #[test]
    fn a_service_that_ends_is_an_unplugged_device_and_none_is_one_clear_line() {
        let (at, _heard, thread) = service(1);
        let (mut port, there) = HaplyPort::connect(at).expect("connected");
        assert_eq!(there, ["04BA"]);
        port.device_id = "04BA".into();
        let _ = port.socket.close(None);
        until("closed", || port.read(&mut [0; REPORT], 1) == Err(Gone));
        drop(port);
        thread.join().expect("ended");
        let error = HaplyPort::connect(at)
            .err()
            .expect("nobody there")
            .to_string();
        assert!(
            error.starts_with("the Haply service does not answer at 127.0.0.1:"),
            "{error}"
        );
        assert!(!error.contains('\n'));
    }
}
