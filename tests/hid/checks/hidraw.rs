//! The kernel's hidraw and `hidapi` on top of it: what Dorsum takes for granted of them.

use std::collections::BTreeSet;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{same, settle};
use crate::board::{COUNTS_PER_MA, Fault};
use crate::host::{Opened, awaited, count, everything, listed, missing, word};
use crate::kinds::{Kind, Speaks};
use crate::plug::Emulated;

/// Reports that hidraw keeps for a reader that does not come: `HIDRAW_BUFFER_SIZE`, one place left free.
const KEPT: usize = 63;

pub fn is_listed(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let device = Emulated::plugged(key, "D-0017", 0, fault)?;
    let kind = device.kind;
    let found = awaited(kind, 1)?.remove(0);
    let ids = format!("{:04X}:{:04X}", found.vendor_id(), found.product_id());
    let page = |page: u16, usage: u16| format!("{page:04X} usage {usage:04X}");
    same(
        "usage page",
        page(found.usage_page(), found.usage()),
        page(kind.usage_page, kind.usage),
    )?;
    same(
        "serial number",
        found.serial_number().unwrap_or_default(),
        device.serial.as_str(),
    )?;
    same(
        "name",
        found.product_string().unwrap_or_default(),
        kind.name,
    )?;
    drop(device);
    awaited(kind, 0)?;
    Ok(format!(
        "{ids} page {:04X} usage {:04X} serial {}",
        kind.usage_page, kind.usage, "D-0017"
    ))
}

/// The rule that comes with Dorsum gives the device to the user of the session, as udev itself reads it.
pub fn may_be_opened(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let device = Emulated::plugged(key, "V-0017", 0, fault)?;
    let path = settle(|| {
        let all = everything()?;
        Ok(all
            .into_iter()
            .find(|found| found.serial_number() == Some(&device.serial))
            .map(|found| found.path().to_owned()))
    })?
    .ok_or("not listed")?;
    let path = path.to_string_lossy().into_owned();
    let node = path.rsplit('/').next().unwrap_or_default();
    let told = Command::new("/bin/udevadm")
        .args(["test", "--action=add", &format!("/sys/class/hidraw/{node}")])
        .output()
        .map_err(|error| format!("udevadm: {error}"))?;
    let errors = String::from_utf8_lossy(&told.stderr);
    let told = String::from_utf8_lossy(&told.stdout);
    if !told.lines().any(|line| line == format!("DEVNAME={path}")) {
        return Err(format!(
            "udevadm does not know {path}: {}",
            errors.lines().last().unwrap_or_default()
        ));
    }
    // Not TAGS, which remembers what an earlier device at this path was given.
    let tags = told
        .lines()
        .find_map(|line| line.strip_prefix("CURRENT_TAGS="))
        .unwrap_or_default();
    if tags.split(':').any(|tag| tag == "uaccess") {
        Ok("tag uaccess".into())
    } else {
        Err("no tag uaccess".into())
    }
}

pub fn reads(key: &str, fault: Option<Fault>) -> Result<String, String> {
    const REPORTS: u32 = 300;
    let device = Emulated::plugged(key, "R", 0, fault)?;
    let mut host = Opened::only(&device)?;
    let mut before = None;
    let mut lost = 0;
    for _ in 0..REPORTS {
        if device.kind.speaks == Speaks::Wooden14 {
            host.drive([0; 3])?;
        }
        let report = host.read()?;
        same("bytes in a report", report.len(), device.kind.in_bytes)?;
        let now = count(device.kind, &report).ok_or("no count")?;
        if let Some(before) = before {
            lost += missing(device.kind, before, now)?;
        }
        before = Some(now);
    }
    // The 14-byte board counts milliseconds, not its answers, which come at the pace of the questions.
    if device.kind.speaks != Speaks::Wooden14 {
        same("reports lost", lost, 0)?;
    }
    Ok(format!(
        "{REPORTS} reports of {} bytes, 0 lost",
        device.kind.in_bytes
    ))
}

pub fn reads_numbered(key: &str, fault: Option<Fault>) -> Result<String, String> {
    const REPORTS: usize = 300;
    let device = Emulated::plugged(key, "N", 0, fault)?;
    let host = Opened::only(&device)?;
    let split = device.kind.speaks == Speaks::SpaceMouseSplit;
    let mut ids = BTreeSet::new();
    let mut before = [None; 3];
    for _ in 0..REPORTS {
        let report = host.read()?;
        let id = *report.first().ok_or("an empty report")?;
        ids.insert(id);
        let expected = if id == 3 { 3 } else { device.kind.in_bytes };
        same("bytes in a report", report.len(), expected)?;
        if id < 3 {
            let now = i32::from(word(&report, 1).ok_or("no first axis")?);
            if let Some(before) = before[usize::from(id)].replace(now) {
                let expected = if split { 2 } else { 1 };
                same(
                    "step of an axis from report to report",
                    (now - before).rem_euclid(701),
                    expected,
                )?;
            }
        }
    }
    let expected: &[u8] = if split { &[1, 2, 3] } else { &[1, 3] };
    same(
        "report ids",
        ids.iter().copied().collect::<Vec<_>>().as_slice(),
        expected,
    )?;
    Ok(format!("{REPORTS} reports, ids {expected:?}, 0 lost"))
}

/// Currents arrive byte for byte behind the id byte, and the arm rests where they and its spring balance.
pub fn writes(key: &str, fault: Option<Fault>) -> Result<String, String> {
    const CURRENT_MA: [i16; 3] = [1000, -300, 2];
    let mut device = Emulated::plugged(key, "W", 0, fault)?;
    let mut host = Opened::only(&device)?;
    let mut rest = Vec::new();
    let mut sent = Vec::new();
    let start = Instant::now();
    // 0.4 s is 40 time constants of the arm.
    while start.elapsed() < Duration::from_millis(400) {
        sent = host.drive(CURRENT_MA)?;
        rest = host.read()?;
    }
    settle(|| Ok((device.tell("seen")?.last == sent).then_some(())))?
        .ok_or_else(|| format!("the device never has the report {sent:?}"))?;
    same("bytes of a report out", sent.len(), device.kind.out_bytes)?;
    for (axis, current_ma) in CURRENT_MA.into_iter().enumerate() {
        let encoder = word(&rest, 2 * axis).ok_or("no encoder")?;
        let expected = (COUNTS_PER_MA * f64::from(current_ma)).round() as i16;
        same(
            ["encoder a", "encoder b", "encoder c"][axis],
            encoder,
            expected,
        )?;
    }
    Ok(format!(
        "{} bytes, id byte 0 first; arm rests at 500, -150, 1",
        sent.len()
    ))
}

pub fn lights(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let mut device = Emulated::plugged(key, "L", 0, fault)?;
    let mut host = Opened::only(&device)?;
    for on in [1, 0, 1] {
        let sent = host.drive([on, 0, 0])?;
        settle(|| Ok((device.tell("seen")?.last == sent).then_some(())))?
            .ok_or("the device has not seen the report")?;
        same("bytes", sent.as_slice(), &[4, on as u8])?;
    }
    Ok("report 4, on, off, on".into())
}

/// What waited while nobody read is thrown away at once, and what counts is the newest; past what the kernel keeps,
/// the newest that waits is old, and only the next is fresh.
pub fn drains(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let mut device = Emulated::plugged(key, "Q", 0, fault)?;
    let host = Opened::only(&device)?;
    host.read()?;
    host.drain()?;
    sleep(Duration::from_millis(30));
    device.tell("hold")?;
    let sent = device.tell("seen")?.sent;
    let waiting = host.drain()?;
    let newest = waiting
        .last()
        .and_then(|report| count(device.kind, report))
        .ok_or("nothing waited")?;
    same("newest count after 30 ms", u64::from(newest), sent)?;

    device.tell("go")?;
    sleep(Duration::from_millis(300));
    device.tell("hold")?;
    let sent = device.tell("seen")?.sent;
    let kept = host.drain()?;
    same("reports kept over 300 ms", kept.len(), KEPT)?;
    let newest = kept
        .last()
        .and_then(|report| count(device.kind, report))
        .ok_or("nothing waited")?;
    let stale = sent.saturating_sub(u64::from(newest));
    if stale == 0 {
        return Err("300 ms of reports waited, and none was lost".into());
    }
    device.tell("go")?;
    let fresh = count(device.kind, &host.read()?).ok_or("no count")?;
    same("count of the next report", u64::from(fresh), sent + 1)?;
    Ok(format!(
        "30 ms: {} waited, newest kept; 300 ms: {KEPT} kept, {stale} newer lost, next fresh",
        waiting.len()
    ))
}

pub fn replugs(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let mut device = Emulated::plugged(key, "U", 0, fault)?;
    let mut host = Opened::only(&device)?;
    host.drive([0; 3])?;
    host.read()?;
    let told = Instant::now();
    device.tell("unplug")?;
    settle(|| Ok(host.read_within(2).err()))?
        .ok_or("reading goes on as if nothing had happened")?;
    let noticed_ms = told.elapsed().as_secs_f64() * 1e3;
    if host.drive([0; 3]).is_ok() {
        return Err("a report to a device that is gone is taken".into());
    }
    awaited(device.kind, 0)?;

    device.tell("plug")?;
    let mut again = Opened::only(&device)?;
    again.drive([0; 3])?;
    let report = again.read()?;
    if device.kind.out_id == 0 {
        same("bytes in a report", report.len(), device.kind.in_bytes)?;
    }
    if host.read_within(2).is_ok() {
        return Err("the handle from before the unplugging came back to life".into());
    }
    Ok(format!(
        "read fails {noticed_ms:.0} ms after unplugging; opens again, the old handle stays dead"
    ))
}

/// The board takes the currents off by itself when the host falls silent, and the arm goes home.
pub fn falls_silent(key: &str, fault: Option<Fault>) -> Result<String, String> {
    const REPORTS: u64 = 100;
    let mut device = Emulated::plugged(key, "S", 0, fault)?;
    let mut host = Opened::only(&device)?;
    for _ in 1..REPORTS {
        host.drive([1000, 0, 0])?;
        host.read()?;
    }
    let silent = Instant::now();
    host.drive([1000, 0, 0])?;
    settle(|| {
        let seen = device.tell("seen")?;
        Ok((seen.got == REPORTS && seen.off).then_some(()))
    })?
    .ok_or("the currents stay on")?;
    let after_ms = silent.elapsed().as_millis() as u64;
    let bound_ms = device.kind.speaks.off_after_ms();
    // The board makes up for at most 5 ms at once.
    if after_ms + 6 < bound_ms {
        return Err(format!(
            "the currents went off after {after_ms} ms, {bound_ms} ms expected"
        ));
    }
    Ok(format!(
        "currents off after {after_ms} ms of silence (board: {bound_ms} ms)"
    ))
}

/// Two devices that say the same of themselves are two by their paths, and each path leads to one of them.
pub fn tells_twins(key: &str, fault: Option<Fault>) -> Result<String, String> {
    let offsets = [100, -200];
    let mut twins = [
        Emulated::plugged(key, "SAME", offsets[0], fault)?,
        Emulated::plugged(key, "SAME", offsets[1], fault)?,
    ];
    let kind: &'static Kind = twins[0].kind;
    let found = awaited(kind, 2)?;
    same(
        "serial numbers",
        found[0].serial_number(),
        found[1].serial_number(),
    )?;
    let mut hosts = Vec::new();
    for info in &found {
        hosts.push(Opened::at(kind, &info.path().to_owned())?);
    }
    let mut met = Vec::new();
    for host in &mut hosts {
        host.drive([0; 3])?;
        met.push(word(&host.read()?, 0).ok_or("no encoder")?);
    }
    let which = |encoder: i16| offsets.iter().position(|offset| *offset == encoder);
    let (Some(first), Some(second)) = (which(met[0]), which(met[1])) else {
        return Err(format!(
            "encoder a of the two reads {met:?}, expected {offsets:?}"
        ));
    };
    if first == second {
        return Err("both paths lead to one device".into());
    }
    // One goes: the other's handle stays good.
    twins[first].tell("unplug")?;
    settle(|| Ok(hosts[0].read_within(2).err()))?.ok_or("the unplugged one still answers")?;
    hosts[1].drive([0; 3])?;
    hosts[1].drain()?;
    hosts[1].drive([0; 3])?;
    same(
        "encoder a of the other",
        word(&hosts[1].read()?, 0),
        Some(offsets[second]),
    )?;
    same("still listed", listed(kind)?.len(), 1)?;
    Ok(format!(
        "two paths, encoder a {} and {}; one unplugged, the other goes on",
        met[0], met[1]
    ))
}

pub fn keeps_up(key: &str, fault: Option<Fault>) -> Result<String, String> {
    // A faulty device need not be watched for long.
    let reports: u32 = if fault.is_some() { 500 } else { 10_000 };
    let mut device = Emulated::plugged(key, "K", 0, fault)?;
    let mut host = Opened::only(&device)?;
    host.read()?;
    host.drain()?;
    let mut before = None;
    let mut lost_in = 0;
    let mut worst = Duration::ZERO;
    let mut last = Instant::now();
    let start = last;
    for _ in 0..reports {
        let report = host.read()?;
        worst = worst.max(last.elapsed());
        last = Instant::now();
        same("bytes in a report", report.len(), device.kind.in_bytes)?;
        let now = count(device.kind, &report).ok_or("no count")?;
        if let Some(before) = before {
            lost_in += missing(device.kind, before, now)?;
        }
        before = Some(now);
        host.drive([(now % 100) as i16, 0, 0])?;
    }
    let rate_hz = f64::from(reports) / start.elapsed().as_secs_f64();
    let seen = settle(|| {
        let seen = device.tell("seen")?;
        Ok((seen.got >= u64::from(reports)).then_some(seen))
    })?
    .ok_or("not all reports arrived at the device")?;
    same("reports lost on the way in", lost_in, 0)?;
    same("reports lost on the way out", seen.missing, 0)?;
    same("reports at the device", seen.got, u64::from(reports))?;
    Ok(format!(
        "{reports} each way at {rate_hz:.0} Hz, 0 + 0 lost, longest gap {:.1} ms",
        worst.as_secs_f64() * 1e3
    ))
}
