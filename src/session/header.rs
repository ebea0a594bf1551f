//! What a session says about itself beside its ticks.

use super::SessionError;
use super::format::Edit;
use crate::servo::{Limits, MAX_FINGERS, StiffnessBound};
use crate::surface::Surface;
use std::collections::BTreeMap;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Where the recorded surface came from.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MeshSource {
    /// SHA-256 of the surface ([`crate::surface::Surface::hash`]), hexadecimal.
    pub hash: String,
    /// `builtin:back` or a path as the scenario states it.
    pub origin: String,
    /// Number of triangles.
    pub triangles: usize,
}

/// What was used to feel it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DeviceInfo {
    /// Name.
    pub name: String,
    /// Highest force, N.
    pub rated_force_n: f64,
    /// Fastest rise allowed, N/s.
    pub rise_n_per_s: f64,
    /// Whether the passivity controller was on; it is not in a session that does not say so.
    #[serde(default)]
    pub passivity: bool,
    /// How stiff the skin was rendered to it; as it is in a session that does not say so.
    #[serde(default)]
    pub stiffness: StiffnessBound,
}

impl DeviceInfo {
    /// A device by its name and the bounds that its forces were kept in.
    pub fn new(name: &str, limits: &Limits) -> Self {
        Self {
            name: name.to_owned(),
            rated_force_n: limits.rated_force_n,
            rise_n_per_s: limits.rise_n_per_s,
            passivity: limits.passivity,
            stiffness: limits.stiffness,
        }
    }

    /// The bounds that its forces were kept in.
    pub fn limits(&self) -> Limits {
        Limits {
            rated_force_n: self.rated_force_n,
            rise_n_per_s: self.rise_n_per_s,
            passivity: self.passivity,
            stiffness: self.stiffness,
        }
    }
}

impl MeshSource {
    /// A surface and where it came from: `builtin:back` or the path that the scenario states.
    pub fn new(surface: &Surface, origin: &str) -> Self {
        Self {
            hash: hexadecimal(&surface.hash()),
            origin: origin.to_owned(),
            triangles: surface.triangles().len(),
        }
    }
}

/// Lower-case hexadecimal.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    use std::fmt::Write;
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Everything beside the ticks that is needed to rebuild a run.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Header {
    /// The scenario file as it was, whole.
    pub scenario_toml: String,
    /// Its name.
    pub scenario_name: String,
    /// The surface.
    pub mesh: MeshSource,
    /// One per finger, 1 to [`MAX_FINGERS`].
    pub devices: Vec<DeviceInfo>,
    /// Ticks per second. The time step of the run is `1.0 / rate_hz`.
    pub rate_hz: f64,
    /// Program version and commit that recorded it.
    pub build: String,
    /// Start, UTC, ISO 8601 ([`utc_now`]).
    pub started_utc: String,
    /// Pseudonym of the participant; nothing else personal is written.
    pub participant: Option<String>,
    /// Number of the edit that `scenario_toml` is; 0 before the first.
    #[serde(default)]
    pub edit: u32,
    /// The run was felt in another scene than `scenario_toml` says: one that is hidden until its trial is answered, and
    /// was not revealed. It cannot be repeated.
    #[serde(default)]
    pub sealed: bool,
}

/// Key of the checksum of the metadata.
const CHECKSUM: &str = "checksum";

/// CRC-32 of all entries but the checksum, hexadecimal: each key and value, with a zero byte behind.
fn checksum(map: &BTreeMap<String, String>) -> String {
    let mut hasher = crc32fast::Hasher::new();
    for (key, value) in map.iter().filter(|(key, _)| *key != CHECKSUM) {
        for text in [key, value] {
            hasher.update(text.as_bytes());
            hasher.update(&[0]);
        }
    }
    format!("{:08x}", hasher.finalize())
}

/// Metadata with their checksum.
pub(super) fn with_checksum(mut map: BTreeMap<String, String>) -> BTreeMap<String, String> {
    map.insert(CHECKSUM.to_owned(), checksum(&map));
    map
}

/// Metadata whose checksum is right or, in older files, absent.
pub(super) fn checked(map: BTreeMap<String, String>) -> Result<BTreeMap<String, String>, String> {
    match map.get(CHECKSUM) {
        Some(said) if *said != checksum(&map) => {
            Err("the metadata do not match their checksum".to_owned())
        }
        _ => Ok(map),
    }
}

/// The present instant as sessions write it, such as `2031-05-17T09:30:00.125Z`.
pub fn utc_now() -> String {
    humantime::format_rfc3339_millis(SystemTime::now()).to_string()
}

/// Version of this program as sessions write it.
pub fn build_id() -> String {
    concat!("dorsum ", env!("CARGO_PKG_VERSION")).to_owned()
}

impl Header {
    /// Number of fingers.
    pub fn n_fingers(&self) -> usize {
        self.devices.len()
    }

    /// Time step of the run, s.
    pub fn dt_s(&self) -> f64 {
        1.0 / self.rate_hz
    }

    /// Bounds on each finger's force, as they were while it ran: what a rig that repeats it needs. Fingers that there are
    /// not have those of [`Limits::default`].
    pub fn limits(&self) -> [Limits; MAX_FINGERS] {
        let mut limits = [Limits::default(); MAX_FINGERS];
        for (limit, device) in limits.iter_mut().zip(&self.devices) {
            *limit = device.limits();
        }
        limits
    }

    /// The scenario after edit `number`, one of `edits`; `None` where it is not among them.
    pub(super) fn scenario_after<'a>(&'a self, number: u32, edits: &'a [Edit]) -> Option<&'a str> {
        if number == self.edit {
            return Some(&self.scenario_toml);
        }
        let edit = edits.iter().find(|e| e.number == number);
        edit.map(|e| &*e.scenario_toml)
    }

    /// Start in nanoseconds since 1970, UTC.
    pub(super) fn started_ns(&self) -> Result<u64, SessionError> {
        humantime::parse_rfc3339_weak(&self.started_utc)
            .ok()
            .and_then(|t| t.duration_since(UNIX_EPOCH).ok())
            .unwrap_or(Duration::MAX)
            .as_nanos()
            .try_into()
            .map_err(|_| {
                refused(
                    "started_utc",
                    &self.started_utc,
                    "UTC as in 2031-05-17T09:30:00Z",
                )
            })
    }

    /// The entries of the metadata record; the scenario text travels as an attachment.
    ///
    /// # Errors
    /// The first entry that a reader would refuse.
    pub(super) fn to_map(&self) -> Result<BTreeMap<String, String>, SessionError> {
        let mut map = BTreeMap::new();
        let mut put = |key: &str, value: String| map.insert(key.to_owned(), value);
        put("format", super::format::FORMAT.to_string());
        put("scenario_name", self.scenario_name.clone());
        put("mesh_hash", self.mesh.hash.clone());
        put("mesh_origin", self.mesh.origin.clone());
        put("mesh_triangles", self.mesh.triangles.to_string());
        put("rate_hz", self.rate_hz.to_string());
        put("build", self.build.clone());
        put("started_utc", self.started_utc.clone());
        if let Some(participant) = &self.participant {
            put("participant", participant.clone());
        }
        put("edit", self.edit.to_string());
        if self.sealed {
            put("sealed", "on".to_owned());
        }
        put("fingers", self.devices.len().to_string());
        for (i, device) in self.devices.iter().enumerate() {
            put(&format!("finger.{i}.device"), device.name.clone());
            let rated = device.rated_force_n.to_string();
            put(&format!("finger.{i}.rated_force_n"), rated);
            let rise = device.rise_n_per_s.to_string();
            put(&format!("finger.{i}.rise_n_per_s"), rise);
            if device.passivity {
                put(&format!("finger.{i}.passivity"), "on".to_owned());
            }
            match device.stiffness {
                StiffnessBound::AsIs => None,
                StiffnessBound::Scale { factor } => {
                    put(&format!("finger.{i}.{SCALE}"), factor.to_string())
                }
                StiffnessBound::Clamp { n_per_mm } => {
                    put(&format!("finger.{i}.{CLAMP}"), n_per_mm.to_string())
                }
            };
        }
        self.started_ns()?;
        Self::from_map(&map, self.scenario_toml.clone())?;
        Ok(map)
    }

    /// The reverse of [`Self::to_map`].
    pub(super) fn from_map(
        map: &BTreeMap<String, String>,
        scenario_toml: String,
    ) -> Result<Self, SessionError> {
        let format: u32 = number(map, "format", "1")?;
        if format != super::format::FORMAT {
            return Err(refused(
                "format",
                &format.to_string(),
                "1; a newer program wrote this",
            ));
        }
        let rate_hz: f64 = number(map, "rate_hz", RATES)?;
        if !(1.0..=1.0e6).contains(&rate_hz) {
            return Err(refused("rate_hz", &rate_hz.to_string(), RATES));
        }
        let n_fingers: usize = number(map, "fingers", "1 to 4")?;
        if !(1..=MAX_FINGERS).contains(&n_fingers) {
            return Err(refused("fingers", &n_fingers.to_string(), "1 to 4"));
        }
        let mesh = MeshSource {
            hash: text(map, "mesh_hash")?,
            origin: text(map, "mesh_origin")?,
            triangles: number(map, "mesh_triangles", "a count")?,
        };
        let devices = (0..n_fingers).map(|i| device(map, i));
        Ok(Self {
            scenario_toml,
            scenario_name: text(map, "scenario_name")?,
            mesh,
            devices: devices.collect::<Result<_, _>>()?,
            rate_hz,
            build: text(map, "build")?,
            started_utc: text(map, "started_utc")?,
            participant: map.get("participant").cloned(),
            edit: match map.get("edit") {
                Some(_) => number(map, "edit", "a count")?,
                None => 0,
            },
            sealed: switch(map, "sealed")?,
        })
    }
}

const RATES: &str = "1 to 1000000";
const FORCES: &str = "a number, 0 or more";

fn device(map: &BTreeMap<String, String>, finger: usize) -> Result<DeviceInfo, SessionError> {
    let force = |what: &str| {
        let key = format!("finger.{finger}.{what}");
        let value: f64 = number(map, &key, FORCES)?;
        if value >= 0.0 {
            Ok(value)
        } else {
            Err(refused(&key, &value.to_string(), FORCES))
        }
    };
    Ok(DeviceInfo {
        name: text(map, &format!("finger.{finger}.device"))?,
        rated_force_n: force("rated_force_n")?,
        rise_n_per_s: force("rise_n_per_s")?,
        passivity: switch(map, &format!("finger.{finger}.passivity"))?,
        stiffness: stiffness(map, finger)?,
    })
}

const SCALE: &str = "stiffness_scale";
const CLAMP: &str = "stiffness_clamp_n_per_mm";

/// As the scene has it where nothing is said, as in older sessions.
fn stiffness(
    map: &BTreeMap<String, String>,
    finger: usize,
) -> Result<StiffnessBound, SessionError> {
    let positive = |what: &str, most: f64, allowed: &'static str| {
        let key = format!("finger.{finger}.{what}");
        if !map.contains_key(&key) {
            return Ok(None);
        }
        let value: f64 = number(map, &key, allowed)?;
        if value > 0.0 && value <= most {
            Ok(Some(value))
        } else {
            Err(refused(&key, &value.to_string(), allowed))
        }
    };
    let scale = positive(SCALE, 1.0, "above 0, at most 1")?;
    let clamp = positive(CLAMP, f64::MAX, "a number above 0")?;
    match (scale, clamp) {
        (None, None) => Ok(StiffnessBound::AsIs),
        (Some(factor), None) => Ok(StiffnessBound::Scale { factor }),
        (None, Some(n_per_mm)) => Ok(StiffnessBound::Clamp { n_per_mm }),
        (Some(_), Some(clamp)) => Err(refused(
            &format!("finger.{finger}.{CLAMP}"),
            &clamp.to_string(),
            "nothing, where the stiffness is scaled",
        )),
    }
}

/// Off where it is absent, as in older sessions.
fn switch(map: &BTreeMap<String, String>, key: &str) -> Result<bool, SessionError> {
    match map.get(key).map(String::as_str) {
        None | Some("off") => Ok(false),
        Some("on") => Ok(true),
        Some(other) => Err(refused(key, other, "on or off")),
    }
}

fn text(map: &BTreeMap<String, String>, key: &str) -> Result<String, SessionError> {
    map.get(key)
        .cloned()
        .ok_or_else(|| refused(key, "", "some text"))
}

fn number<T: std::str::FromStr>(
    map: &BTreeMap<String, String>,
    key: &str,
    allowed: &'static str,
) -> Result<T, SessionError> {
    let text = text(map, key)?;
    text.parse().map_err(|_| refused(key, &text, allowed))
}

fn refused(key: &str, value: &str, allowed: &'static str) -> SessionError {
    SessionError::Header {
        key: key.to_owned(),
        value: value.to_owned(),
        allowed,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::session) fn sample(n_fingers: usize) -> Header {
        let devices = (0..n_fingers).map(|i| DeviceInfo {
            name: format!("Finger {i}"),
            rated_force_n: 22.0,
            rise_n_per_s: 22.0 / 0.005,
            passivity: i == 1,
            stiffness: match i {
                1 => StiffnessBound::Scale { factor: 2.0 / 3.0 },
                2 => StiffnessBound::Clamp { n_per_mm: 0.4 },
                _ => StiffnessBound::AsIs,
            },
        });
        Header {
            scenario_toml: "format = 1\nname = \"Täst\"\n".into(),
            scenario_name: "Täst".into(),
            mesh: MeshSource {
                hash: "00ff".into(),
                origin: "builtin:back".into(),
                triangles: 2962,
            },
            devices: devices.collect(),
            rate_hz: 1000.0,
            build: build_id(),
            started_utc: "2031-05-17T09:30:00.125Z".into(),
            participant: Some("P07".into()),
            edit: 0,
            sealed: false,
        }
    }

    #[test]
    fn a_header_survives_its_metadata_record() {
        let mut header = sample(3);
        header.rate_hz = 1000.0 / 3.0;
        header.devices[1].rise_n_per_s = f64::INFINITY;
        header.participant = None;
        header.edit = 7;
        let map = header.to_map().expect("writable");
        let back = Header::from_map(&map, header.scenario_toml.clone()).expect("readable");
        assert_eq!(back, header);
    }

    #[test]
    fn the_passivity_controller_is_off_unless_the_session_says_on() {
        let header = sample(2);
        let mut map = header.to_map().expect("writable");
        let passivity = |map: &BTreeMap<String, String>| {
            let read = Header::from_map(map, header.scenario_toml.clone());
            read.map(|h| h.limits().map(|l| l.passivity))
        };
        assert!(!map.contains_key("finger.0.passivity"));
        let read = passivity(&map).expect("readable");
        assert_eq!(read, [false, true, false, false]);
        map.insert("finger.0.passivity".into(), "perhaps".into());
        let error = passivity(&map).expect_err("refused").to_string();
        assert!(
            error.contains("perhaps") && error.contains("on or off"),
            "{error}"
        );
    }

    #[test]
    fn the_skin_is_as_stiff_as_it_is_unless_the_session_says_otherwise() {
        let header = sample(3);
        let mut map = header.to_map().expect("writable");
        assert!(!map.keys().any(|k| k.starts_with("finger.0.stiffness")));
        for (key, value, allowed) in [
            ("finger.0.stiffness_scale", "1.5", "at most 1"),
            ("finger.0.stiffness_scale", "0", "above 0"),
            ("finger.0.stiffness_clamp_n_per_mm", "NaN", "above 0"),
            ("finger.0.stiffness_clamp_n_per_mm", "soft", "above 0"),
            ("finger.1.stiffness_clamp_n_per_mm", "0.5", "nothing"),
        ] {
            map.insert(key.into(), value.into());
            let read = Header::from_map(&map, header.scenario_toml.clone());
            let error = read.expect_err(key).to_string();
            assert!(
                error.contains(key) && error.contains(value) && error.contains(allowed),
                "{error}"
            );
            map.remove(key);
        }
    }

    #[test]
    fn what_a_reader_would_refuse_is_not_written() {
        type Damage = fn(&mut Header);
        let broken: [(&str, Damage); 5] = [
            ("rate_hz", |h| h.rate_hz = f64::NAN),
            ("rate_hz", |h| h.rate_hz = 0.0),
            ("fingers", |h| h.devices.clear()),
            ("finger.0.rated_force_n", |h| {
                h.devices[0].rated_force_n = -1.0;
            }),
            ("started_utc", |h| h.started_utc = "yesterday".into()),
        ];
        for (key, damage) in broken {
            let mut header = sample(1);
            damage(&mut header);
            let error = header.to_map().expect_err(key).to_string();
            assert!(error.contains(key), "{error}");
        }
    }

    #[test]
    fn now_is_written_as_a_start_that_can_be_read() {
        let mut header = sample(1);
        header.started_utc = utc_now();
        assert!(header.started_ns().expect("readable") > 1_700_000_000_000_000_000);
    }
}
