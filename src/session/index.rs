//! The summary at the end of a finished file: what it holds, and where.

use super::wire::{self, Bytes, LONGEST_RECORD, PREFIX};
use mcap::records::op;
use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes of the footer record and the end mark behind it.
const TAIL: u64 = (PREFIX + 20 + mcap::MAGIC.len()) as u64;
/// Bytes of a message index record before its entries, prefix included, and of each entry.
const INDEX_HEAD: u64 = PREFIX as u64 + 6;
const INDEX_ENTRY: u64 = 16;

/// One chunk as the summary tells of it.
#[derive(Debug)]
pub(super) struct ChunkIndex {
    /// Where its record starts, bytes from the start of the file.
    pub(super) at: u64,
    /// Length of the record with its prefix, bytes.
    pub(super) length: u64,
    /// Log time of its earliest message, ns.
    pub(super) start_ns: u64,
    /// Messages on each channel in it.
    pub(super) counts: Vec<(u16, u64)>,
}

/// What a summary says.
#[derive(Debug, Default)]
pub(super) struct Summary {
    /// Topics of the channels.
    pub(super) channels: Vec<(u16, String)>,
    /// Chunks in the order they lie in the file.
    pub(super) chunks: Vec<ChunkIndex>,
    /// Where each metadata record starts, and its name; in the order they lie in the file.
    pub(super) metadata: BTreeMap<u64, String>,
    /// Where each attachment record starts, and its name; in the order they lie in the file.
    pub(super) attachments: BTreeMap<u64, String>,
}

impl Summary {
    /// Reads the summary of a file; `None` where there is none, or where it is damaged or does not fit the file.
    pub(super) fn read<R: Read + Seek>(input: &mut R) -> io::Result<Option<Self>> {
        let size = input.seek(SeekFrom::End(0))?;
        let Some(tail_at) = size.checked_sub(TAIL) else {
            return Ok(None);
        };
        input.seek(SeekFrom::Start(tail_at))?;
        let mut tail = [0; TAIL as usize];
        input.read_exact(&mut tail)?;
        let Some((start, crc)) = footer(&tail) else {
            return Ok(None);
        };
        // The checksum ends before itself: behind opcode, length and two offsets of the footer.
        let until = tail_at + PREFIX as u64 + 16;
        let length = until
            .checked_sub(start)
            .and_then(|n| usize::try_from(n).ok());
        let Some(length) = length.filter(|n| start > 0 && *n <= LONGEST_RECORD) else {
            return Ok(None);
        };
        let mut bytes = vec![0; length];
        input.seek(SeekFrom::Start(start))?;
        input.read_exact(&mut bytes)?;
        if crc == 0 || crc32fast::hash(&bytes) != crc {
            return Ok(None);
        }
        let records = &bytes[..length.saturating_sub(PREFIX + 16)];
        let summary = Self::parse(records).ok();
        Ok(summary.filter(|s| s.fits(start)))
    }

    fn parse(records: &[u8]) -> Result<Self, String> {
        let mut summary = Self::default();
        let mut at = 0;
        while at < records.len() {
            let (opcode, range) = wire::record_in_chunk(records, at)?;
            at = range.end;
            let record = &records[range];
            match opcode {
                op::CHANNEL => summary.channels.push(wire::channel(record)?),
                op::CHUNK_INDEX => summary.chunks.push(chunk_index(record)?),
                op::METADATA_INDEX => {
                    let mut bytes = Bytes(record);
                    let at = bytes.u64()?;
                    bytes.u64()?;
                    summary.metadata.insert(at, bytes.text()?.to_owned());
                }
                op::ATTACHMENT_INDEX => {
                    let mut bytes = Bytes(record);
                    let at = bytes.u64()?;
                    bytes.take(4 * 8)?;
                    summary.attachments.insert(at, bytes.text()?.to_owned());
                }
                _ => {}
            }
        }
        summary.chunks.sort_by_key(|c| c.at);
        Ok(summary)
    }

    /// Whether all that it names lies before the summary, which starts at `end`.
    fn fits(&self, end: u64) -> bool {
        let chunk = |c: &ChunkIndex| {
            let behind = c.at.checked_add(c.length);
            c.length >= PREFIX as u64 && behind.is_some_and(|b| b <= end)
        };
        let mut others = self.metadata.keys().chain(self.attachments.keys());
        self.chunks.iter().all(chunk) && others.all(|at| *at < end)
    }
}

/// Start and checksum of the summary.
fn footer(tail: &[u8]) -> Option<(u64, u32)> {
    let (record, mark) = tail.split_at_checked(PREFIX + 20)?;
    let mut bytes = Bytes(record);
    let opcode = bytes.take(1).ok()?[0];
    if mark != mcap::MAGIC || opcode != op::FOOTER || bytes.u64().ok()? != 20 {
        return None;
    }
    let start = bytes.u64().ok()?;
    bytes.u64().ok()?;
    Some((start, bytes.u32().ok()?))
}

fn chunk_index(record: &[u8]) -> Result<ChunkIndex, String> {
    let mut bytes = Bytes(record);
    let start_ns = bytes.u64()?;
    bytes.u64()?;
    let (at, length) = (bytes.u64()?, bytes.u64()?);
    let map = bytes.u32()? as usize;
    let mut map = Bytes(bytes.take(map)?);
    let indexes = bytes.u64()?;
    let mut starts = Vec::new();
    while !map.0.is_empty() {
        starts.push((map.u16()?, map.u64()?));
    }
    // The message indexes lie behind the chunk, one record per channel: their lengths tell how many messages each has.
    starts.sort_unstable_by_key(|(_, start)| *start);
    let end = at.saturating_add(length).saturating_add(indexes);
    let ends = starts.iter().skip(1).map(|(_, start)| *start);
    let counts = starts.iter().zip(ends.chain([end]));
    let counts = counts.map(|((channel, start), end)| {
        let entries = end.saturating_sub(*start).saturating_sub(INDEX_HEAD) / INDEX_ENTRY;
        (*channel, entries)
    });
    Ok(ChunkIndex {
        at,
        length,
        start_ns,
        counts: counts.collect(),
    })
}
