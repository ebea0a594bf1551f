//! Dorsum's devices over the real wire: found, opened, followed, pushed back, lost.

use std::thread::sleep;
use std::time::{Duration, Instant};

use dorsum::device::hid::check::{self, Trial};
use dorsum::device::hid::emulator;
use dorsum::device::hid::guard::Condition;
use dorsum::device::{self, Calibration, Device, Family, Found};
use dorsum::geom::Vec3;

use super::{same, settle};
use crate::arm::EmulatedArm;
use crate::board::Fault;
use crate::host::PATIENCE;
use crate::kinds::{self, Kind, Speaks};
use crate::plug::Emulated;

/// The skin that the arms press, N/mm.
const SKIN_N_PER_MM: f64 = 0.5;
/// How far the hand wants to go below it, mm.
const PRESS_MM: f64 = 8.0;
/// After so long without a report a device counts as silent here, ms. The default of 10 is for a clock that runs evenly;
/// that of a guest without hardware help comes in lumps.
const SILENCE_MS: f64 = 60.0;

fn family(kind: &Kind) -> Result<&'static dyn Family, String> {
    device::by_key(kind.family).ok_or_else(|| format!("no family is called '{}'", kind.family))
}

fn found(kind: &Kind, number: usize) -> Result<Vec<Found>, String> {
    let family = family(kind)?;
    let mut met = 0;
    settle(|| {
        let found = family.find();
        met = found.len();
        Ok((met == number).then_some(found))
    })?
    .ok_or_else(|| format!("found {met}, expected {number}"))
}

fn patient(kind: &Kind) -> Result<Calibration, String> {
    let mut calibration = family(kind)?.defaults();
    calibration.guards.silence_ms = SILENCE_MS;
    calibration.guards.frozen_ms = SILENCE_MS;
    calibration.guards.command_timeout_ms = SILENCE_MS;
    Ok(calibration)
}

fn open(kind: &Kind, found: &Found) -> Result<Box<dyn Device>, String> {
    family(kind)?
        .open(found, &patient(kind)?)
        .map_err(|error| error.to_string())
}

/// Reads once a millisecond until the device is in a condition.
fn until(device: &mut dyn Device, wanted: Condition) -> Result<Duration, String> {
    let vitals = device.vitals().ok_or("no vitals")?;
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        let reading = device.read(1e-3);
        device.write(Vec3::ZERO);
        if vitals.condition() == wanted {
            let connected = device.read(1e-3).connected;
            if connected != (wanted == Condition::Good) && vitals.condition() == wanted {
                return Err(format!(
                    "connected is {connected} while it {}",
                    wanted.title()
                ));
            }
            return Ok(start.elapsed());
        }
        if !reading.position_mm.is_finite() {
            return Err(format!("a reading of {}", reading.position_mm));
        }
        sleep(Duration::from_millis(1));
    }
    Err(format!(
        "it {}, expected: {}",
        vitals.condition().title(),
        wanted.title()
    ))
}

/// Each family finds its own and no other's, also where two share their ids.
pub fn finds(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let device = Emulated::plugged(key, "F-0017", 0, fault)?;
    let one = found(device.kind, 1)?.remove(0);
    same("serial number", one.serial.as_deref(), Some("F-0017"))?;
    same("name", one.title.as_str(), device.kind.name)?;
    same("note", one.note.as_deref(), None)?;
    for other in device::all()
        .iter()
        .filter(|family| family.key() != device.kind.family)
    {
        same(other.key(), other.find().len(), 0)?;
    }
    Ok(format!(
        "{} {}, by no other family",
        device.kind.family, one.place
    ))
}

/// Two that tell one serial number are told to have none, and each place opens one of them.
pub fn tells_twins(key: &str, _fault: Option<Fault>) -> Result<String, String> {
    let kind = kinds::named(key)?;
    let mut arms = [
        EmulatedArm::plugged(key, "SAME", 0.0, None, None)?,
        EmulatedArm::plugged(key, "SAME", 0.0, None, None)?,
    ];
    let both = found(kind, 2)?;
    for one in &both {
        same("serial number", one.serial.as_deref(), None)?;
        if !one
            .note
            .as_deref()
            .is_some_and(|note| note.contains("SAME"))
        {
            return Err(format!("the note is {:?}", one.note));
        }
    }
    let mut first = open(kind, &both[0])?;
    let mut second = open(kind, &both[1])?;
    until(&mut *first, Condition::Good)?;
    until(&mut *second, Condition::Good)?;
    arms[0].end()?;
    // Which of the two places was the first process's is not known; one must go and the other stay.
    let gone = settle(|| {
        let conditions =
            [&first, &second].map(|device| device.vitals().map(|vitals| vitals.condition()));
        Ok(conditions
            .iter()
            .position(|condition| *condition == Some(Condition::Unplugged)))
    })?
    .ok_or("neither is unplugged")?;
    let stays = if gone == 0 { &mut second } else { &mut first };
    until(&mut **stays, Condition::Good)?;
    let left = found(kind, 1)?.remove(0);
    same(
        "serial number of the one left",
        left.serial.as_deref(),
        Some("SAME"),
    )?;
    Ok("serial number taken from both with a note; one unplugged, the other answers".into())
}

pub fn follows_cap(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let mut device = Emulated::plugged(key, "C", 0, fault)?;
    let one = found(device.kind, 1)?.remove(0);
    let mut cap = open(device.kind, &one)?;
    let vitals = cap.vitals().ok_or("no vitals")?;
    let start = Instant::now();
    let (mut highest, mut buttons, mut path_mm) = ([i32::MIN; 6], 0, 0.0);
    let mut before = cap.read(1e-3).position_mm;
    while start.elapsed() < Duration::from_secs(1) {
        let reading = cap.read(1e-3);
        path_mm += reading.position_mm.distance(before);
        before = reading.position_mm;
        buttons |= reading.buttons;
        for (highest, raw) in highest.iter_mut().zip(vitals.raw()) {
            *highest = raw.max(*highest);
        }
        sleep(Duration::from_millis(1));
    }
    settle(|| Ok((device.tell("seen")?.last == [4, 1]).then_some(())))?.ok_or("the lamp is off")?;
    if path_mm == 0.0 {
        return Err("the finger stands".into());
    }
    // Each axis swings to 350 and back within 0.7 s; reports passed over may take the last few with them.
    if highest.iter().any(|highest| *highest < 300) {
        return Err(format!("the axes reach {highest:?}, 350 expected"));
    }
    same("buttons", buttons, 1)?;
    same("reports not understood", vitals.counts().not_understood, 0)?;
    cap.close();
    settle(|| Ok((device.tell("seen")?.last == [4, 0]).then_some(())))?
        .ok_or("the lamp stays on")?;
    Ok(format!(
        "six axes to {highest:?}, button 1, path {path_mm:.0} mm, lamp on and off"
    ))
}

/// A hand presses the arm into a skin: where the arm is and what its motors do is what Dorsum reads and wants.
pub fn closes_loop(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let kind = kinds::named(key)?;
    let mut arm = EmulatedArm::plugged(key, "A", PRESS_MM, None, fault)?;
    let one = found(kind, 1)?.remove(0);
    let calibration = patient(kind)?;
    let mut device = open(kind, &one)?;
    let resolution_mm = device.capabilities().resolution_mm;
    let vitals = device.vitals().ok_or("no vitals")?;
    let trial = Trial {
        seconds: 5.0,
        rate_hz: 1000.0,
        skin_n_per_mm: SKIN_N_PER_MM,
    };
    let mut truth = None;
    let mut counts = None;
    let mut read_mm = Vec3::ZERO;
    let checked = check::run(&mut *device, &trial, |done, reading| {
        if done < 0.9 {
            return true;
        }
        // At rest by now; asked within the loop, as a force that is not renewed is taken off.
        counts = Some(vitals.counts());
        read_mm = reading.position_mm;
        truth = Some(arm.end());
        false
    });
    let truth = truth.ok_or("the loop ended early")??;
    let counts = counts.ok_or("the loop ended early")?;
    let turn = calibration.mapping.subject_from_device();
    let position_error_mm = (turn * Vec3::from_array(truth.pressed_position_mm) - read_mm).length();
    let force_error_n = (turn * Vec3::from_array(truth.pressed_force_n)
        - Vec3::from_array(checked.force_n))
    .length();
    let force_n = Vec3::from_array(checked.force_n).length();
    // Half a count on each of three axes, and what the hand trembles about its rest.
    let bound_mm = 2.0 * resolution_mm;
    if position_error_mm > bound_mm {
        return Err(format!(
            "position {position_error_mm:.3} mm off the arm's own, {bound_mm:.3} allowed"
        ));
    }
    if force_n < 1.0 {
        return Err(format!(
            "{force_n:.2} N at the end: the hand was not pushed back"
        ));
    }
    // The skin's force over that distance, and half a mA of each motor, which is less than 0.01 N.
    let bound_n = SKIN_N_PER_MM * bound_mm + 0.01;
    if force_error_n > bound_n {
        return Err(format!(
            "force {force_error_n:.3} N off what the motors give, {bound_n:.3} allowed"
        ));
    }
    same("reports lost", counts.lost, 0)?;
    same("reports not understood by Dorsum", counts.not_understood, 0)?;
    same("reports not understood by the arm", truth.not_understood, 0)?;
    Ok(format!(
        "{} in, {} out, 0 lost; position {position_error_mm:.3} mm, force {force_error_n:.3} of {force_n:.2} N off",
        counts.reports, truth.heard
    ))
}

/// Under force the arm freezes (if it counts its reports), cuts its reports short, falls silent, is pulled out: Dorsum says which, and no current is left.
pub fn meets_trouble(key: &str, _fault: Option<Fault>) -> Result<String, String> {
    let kind = kinds::named(key)?;
    let mut worst_ms: f64 = 0.0;
    let troubles = [
        (emulator::Fault::Frozen, Condition::Frozen),
        // A kernel may drop reports that are too short, as Linux 6.1.192 does, or hand them on: silence either way.
        (emulator::Fault::Short, Condition::Silent),
        (emulator::Fault::Silent, Condition::Silent),
        (emulator::Fault::Unplugged, Condition::Unplugged),
    ];
    // Without a counter a frozen board is not told from a still hand.
    let counts = kind.speaks == Speaks::Wooden8;
    for (trouble, expected) in troubles.into_iter().skip(usize::from(!counts)) {
        let mut arm = EmulatedArm::plugged(key, "T", PRESS_MM, Some(trouble), None)?;
        let one = found(kind, 1)?.remove(0);
        let mut device = open(kind, &one)?;
        let vitals = device.vitals().ok_or("no vitals")?;
        let trial = Trial {
            seconds: 10.0,
            rate_hz: 1000.0,
            skin_n_per_mm: SKIN_N_PER_MM,
        };
        let mut noticed = false;
        let mut since = None;
        check::run(&mut *device, &trial, |_, _| {
            // A lump of the guest's clock may look like silence for once; trouble stays.
            if vitals.condition() == expected {
                let since = *since.get_or_insert_with(Instant::now);
                noticed = since.elapsed() > Duration::from_millis(300);
            } else {
                since = None;
            }
            !noticed
        });
        let name = trouble.key();
        if !noticed {
            return Err(format!(
                "{name}: it {}, expected: {}",
                vitals.condition().title(),
                expected.title()
            ));
        }
        same("connected", device.read(1e-3).connected, false)?;
        let truth = arm.end()?;
        let before_n = truth
            .fault_n
            .ok_or_else(|| format!("{name}: the trouble never came"))?;
        let after_ms = truth
            .zero_after_ms
            .ok_or_else(|| format!("{name}: from {before_n:.2} N the force never went"))?;
        worst_ms = worst_ms.max(after_ms);
        // The bound set here, and a lump.
        if after_ms > 2.0 * SILENCE_MS {
            return Err(format!(
                "{name}: {before_n:.2} N stayed for {after_ms:.0} ms"
            ));
        }
        drop(arm);
        found(kind, 0)?;
    }
    let mut again = EmulatedArm::plugged(key, "T", 0.0, None, None)?;
    let one = found(kind, 1)?.remove(0);
    let mut device = open(kind, &one)?;
    until(&mut *device, Condition::Good)?;
    device.close();
    let truth = again.end()?;
    same("ended at zero", truth.ended_at_zero, true)?;
    let frozen = if counts { "frozen, " } else { "" };
    Ok(format!(
        "{frozen}short, silent, pulled out: force gone in {worst_ms:.0} ms at most; plugged in anew"
    ))
}
