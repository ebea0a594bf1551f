//! Damaged session files: cut, flipped, mangled, none at all. What is whole is read; nothing makes the reader panic.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/sessions.rs"]
mod sessions;

use dorsum::session::{Session, Strictness};
use sessions::{run, temporary, write};
use std::path::Path;

/// Where each chunk record of a finished file ends, its message indexes left out, and the messages read up to there.
fn chunk_ends(path: &Path) -> Vec<(u64, usize)> {
    let bytes = std::fs::read(path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let mut indexes = summary.chunk_indexes.clone();
    indexes.sort_by_key(|c| c.chunk_start_offset);
    let mut total = 0;
    let mut ends = Vec::new();
    for index in &indexes {
        total += summary.stream_chunk(&bytes, index).unwrap().count();
        ends.push((index.chunk_start_offset + index.chunk_length, total));
    }
    ends
}

#[test]
fn a_file_cut_anywhere_keeps_every_whole_chunk() {
    let (_folder, path) = temporary();
    write(&path, 2, &run(4000, 2));
    let ends = chunk_ends(&path);
    assert!(ends.len() > 8);
    let bytes = std::fs::read(&path).unwrap();
    let cut = path.with_extension("cut");
    let mut random = 1u64;
    for _ in 0..150 {
        random = random
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let length = (random >> 20) % bytes.len() as u64;
        std::fs::write(&cut, &bytes[..length as usize]).unwrap();
        let Ok(session) = Session::open(&cut) else {
            assert!(length < ends[0].0, "cut at {length}: cannot be opened");
            continue;
        };
        let strict = session.load(Strictness::Strict).unwrap_err().to_string();
        assert!(
            strict.contains("cut") && strict.contains("byte"),
            "{strict}"
        );
        let read = session.load(Strictness::Lenient).unwrap();
        let n = read.fingers.iter().map(Vec::len).sum::<usize>() + read.events.len();
        let whole = ends
            .iter()
            .rev()
            .find(|(end, _)| *end <= length)
            .map_or(0, |e| e.1);
        assert_eq!(n, whole, "cut at {length}");
        assert!(read.damage.unfinished);
    }
}

#[test]
fn a_flipped_byte_costs_at_most_the_chunk_it_hits() {
    let (_folder, path) = temporary();
    write(&path, 2, &run(4000, 2));
    let ends = chunk_ends(&path);
    let largest = ends.windows(2).map(|w| w[1].1 - w[0].1).max().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let broken = path.with_extension("broken");
    let mut random = 99u64;
    for _ in 0..400 {
        random = random
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        // Every other one where the file says what it is.
        let from = if random & 1 << 19 == 0 { 0 } else { ends[0].0 };
        let within = if from == 0 {
            ends[1].0
        } else {
            bytes.len() as u64
        } - from;
        let at = from + (random >> 20) % within;
        let mut damaged = bytes.clone();
        damaged[at as usize] ^= (random >> 8) as u8 | 1;
        std::fs::write(&broken, &damaged).unwrap();
        let session = Session::open(&broken).unwrap_or_else(|e| panic!("a flip at {at}: {e}"));
        assert_eq!(session.header(), &sessions::header(2), "a flip at {at}");
        let strict = session.load(Strictness::Strict);
        assert!(strict.is_err(), "a flip at {at} goes unnoticed");
        let read = session.load(Strictness::Lenient).unwrap();
        let n = read.fingers.iter().map(Vec::len).sum::<usize>() + read.events.len();
        assert!(
            n + largest >= 8001,
            "a flip at {at} cost {} messages",
            8001 - n
        );
    }
}

#[test]
fn no_bytes_make_the_reader_panic() {
    let (_folder, path) = temporary();
    write(&path, 2, &run(60, 2));
    let bytes = std::fs::read(&path).unwrap();
    let mutant = path.with_extension("mutant");
    let mut seed = 7u64;
    let mut random = |below: u64| {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 33) % below
    };
    for case in 0..2000 {
        let mut damaged = bytes.clone();
        for _ in 0..=random(6) {
            let at = random(damaged.len() as u64) as usize;
            match random(6) {
                0 => damaged[at] = random(256) as u8,
                1 => damaged[at] ^= 1 << random(8),
                2 => damaged.truncate(at.max(1)),
                3 => drop(damaged.drain(at..(at + random(40) as usize).min(damaged.len()))),
                4 => {
                    let n = (at + 8).min(damaged.len());
                    damaged[at..n].fill([0, 0xff, 0x7f][random(3) as usize]);
                }
                _ => {
                    let from = random(damaged.len() as u64) as usize;
                    let piece = damaged[from..(from + 100).min(damaged.len())].to_vec();
                    damaged.splice(at..at, piece);
                }
            }
            if damaged.is_empty() {
                damaged.push(0);
            }
        }
        if case % 2 == 0 {
            // With checksums off, damage reaches the parsers behind them.
            clear_chunk_checksums(&mut damaged);
        }
        std::fs::write(&mutant, &damaged).unwrap();
        let Ok(session) = Session::open(&mutant) else {
            continue;
        };
        let _ = session.load(Strictness::Strict);
        let read = session.load(Strictness::Lenient).unwrap();
        for finger in &read.fingers {
            assert!(finger.windows(2).all(|w| w[0].tick < w[1].tick));
        }
        let ticks = session.ticks(Strictness::Lenient).unwrap();
        assert!(
            ticks
                .map(Result::unwrap)
                .all(|t| t.n_fingers == session.header().n_fingers())
        );
    }
}

fn clear_chunk_checksums(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(prefix) = bytes.get(at..at + 9) {
        let length = u64::from_le_bytes(prefix[1..].try_into().unwrap());
        if prefix[0] == 6
            && let Some(crc) = bytes.get_mut(at + 9 + 24..at + 9 + 28)
        {
            crc.fill(0);
        }
        let Some(next) = at
            .checked_add(9)
            .and_then(|a| a.checked_add(length as usize))
        else {
            return;
        };
        at = next;
    }
}

#[test]
fn what_is_no_session_is_refused_in_one_clear_line() {
    let (folder, path) = temporary();
    let message = |p: &Path| {
        let text = Session::open(p).unwrap_err().to_string();
        assert!(
            !text.contains('\n') && text.contains(&*p.to_string_lossy()),
            "{text}"
        );
        text
    };
    message(&path);
    message(folder.path());
    std::fs::write(&path, "t,x,y,z\n0,1,2,3\n").unwrap();
    assert!(message(&path).contains("not an MCAP file"));
    std::fs::write(&path, "").unwrap();
    message(&path);
    let mut foreign = mcap::Writer::new(std::fs::File::create(&path).unwrap()).unwrap();
    foreign.finish().unwrap();
    assert!(message(&path).contains("recorded by Dorsum"));
}
