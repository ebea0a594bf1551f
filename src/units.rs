//! The units of the program and the only conversions between them and anything else.
//!
//! Lengths are mm, forces N, stiffness N/mm, time s, mass kg and angles rad everywhere in core, files and command line;
//! degrees appear only at the edges (files and window), where these functions are used.

/// Nanoseconds in a second.
pub const NS_PER_S: f64 = 1.0e9;
/// Milliseconds in a second.
pub const MS_PER_S: f64 = 1.0e3;

/// Millimetres from metres.
pub fn mm_from_m(length_m: f64) -> f64 {
    length_m * 1000.0
}

/// Metres from millimetres.
pub fn m_from_mm(length_mm: f64) -> f64 {
    length_mm / 1000.0
}

/// Radians from degrees.
pub fn rad_from_deg(angle_deg: f64) -> f64 {
    angle_deg.to_radians()
}

/// Degrees from radians.
pub fn deg_from_rad(angle_rad: f64) -> f64 {
    angle_rad.to_degrees()
}

/// N/mm² (the pressure unit that goes with N and mm) from kPa.
pub fn n_per_mm2_from_kpa(pressure_kpa: f64) -> f64 {
    pressure_kpa / 1000.0
}

/// Seconds from nanoseconds.
pub fn s_from_ns(time_ns: u64) -> f64 {
    time_ns as f64 / NS_PER_S
}

/// A unit that a mesh file may be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LengthUnit {
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    M,
    /// Inch.
    Inch,
}

impl LengthUnit {
    /// All units, from the smallest.
    pub const ALL: [Self; 4] = [Self::Mm, Self::Cm, Self::Inch, Self::M];

    /// How many millimetres one of it is.
    pub fn in_mm(self) -> f64 {
        match self {
            Self::Mm => 1.0,
            Self::Cm => 10.0,
            Self::M => 1000.0,
            Self::Inch => 25.4,
        }
    }

    /// The name used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::M => "m",
            Self::Inch => "inch",
        }
    }

    /// The unit with the given [name](Self::name).
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|unit| unit.name() == name)
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
