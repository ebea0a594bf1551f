//! MCAP records, one after the other, out of a file that may hold anything.
//!
//! Framing, data and summary checksums are those of `mcap::sans_io`. The few record kinds a session needs are parsed here:
//! every length is checked against what is there before anything is allocated.

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};

/// Longest record taken into memory: an attached mesh of two million triangles is about 50 MB.
pub(super) const LONGEST_RECORD: usize = 256 * 1024 * 1024;
/// Bytes of opcode and length before each record.
pub(super) const PREFIX: usize = 9;
/// Bytes of a chunk record without compression name before its messages.
const CHUNK_HEAD: usize = 40;
/// The one compression that chunks may have, as they name it.
const ZSTD: &str = "zstd";
/// Attachments longer than this are stepped over where nobody asks for them.
const LONG_ATTACHMENT: u64 = 256 * 1024;

/// Why the next record could not be had.
#[derive(Debug)]
pub(super) enum WireError {
    /// The system says no.
    Io(io::Error),
    /// The bytes make no sense: at which byte, and why.
    Damaged(u64, String),
}

/// Walks over the records of a file.
pub(super) struct Walk<R> {
    input: R,
    reader: LinearReader,
    size: u64,
    /// Every byte passes the reader, which compares the checksums of whole sections.
    check: bool,
    /// Bytes of the input handed to the reader, from the start of the file.
    taken: u64,
    /// Where the record after the current one starts.
    next: u64,
    /// The record being read is an attachment, as far as is known.
    attachment: bool,
    at: u64,
    record: Vec<u8>,
}

impl<R: Read + Seek> Walk<R> {
    /// Walks `input` from its start; `check` compares the checksums of whole sections too.
    pub(super) fn new(mut input: R, check: bool) -> io::Result<Self> {
        let size = input.seek(SeekFrom::End(0))?;
        input.seek(SeekFrom::Start(0))?;
        let options = options()
            .with_validate_data_section_crc(check)
            .with_validate_summary_section_crc(check);
        Ok(Self {
            input,
            reader: LinearReader::new_with_options(options),
            size,
            check,
            taken: 0,
            next: mcap::MAGIC.len() as u64,
            attachment: false,
            at: 0,
            record: Vec::new(),
        })
    }

    /// Length of the file, bytes.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// Where the record after the current one starts, bytes from the start of the file.
    pub(super) fn next(&self) -> u64 {
        self.next
    }

    /// Where the current record starts, bytes from the start of the file.
    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// The next record's opcode; its content is in [`Self::record`]. `None` after the end of a finished file.
    pub(super) fn advance(&mut self) -> Result<Option<u8>, WireError> {
        loop {
            let wanted = match self.reader.next_event() {
                None => return Ok(None),
                Some(Err(e)) => return Err(self.damaged(&e)),
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    self.record.clear();
                    self.record.extend_from_slice(data);
                    self.at = self.next;
                    self.next += (PREFIX + data.len()) as u64;
                    return Ok(Some(opcode));
                }
                Some(Ok(LinearReadEvent::ReadRequest(wanted))) => wanted,
            };
            if self.skips(wanted).map_err(WireError::Io)? {
                continue;
            }
            // A request for more than is left cannot be met: nothing is allocated for it.
            if wanted as u64 > self.size.saturating_sub(self.taken) {
                return Err(self.damaged(&McapError::UnexpectedEof));
            }
            let into = self.reader.insert(wanted);
            let read = self.input.read(into).map_err(WireError::Io)?;
            if read == 0 {
                return Err(self.damaged(&McapError::UnexpectedEof));
            }
            self.attachment = self.taken == self.next && into[0] == op::ATTACHMENT;
            self.reader.notify_read(read);
            self.taken += read as u64;
        }
    }

    /// Steps over the rest of the record, of which the reader wants so many bytes, if it is a long attachment other than the
    /// scenario. One whose lengths do not agree is left to the reader: it may hide chunks.
    fn skips(&mut self, wanted: usize) -> io::Result<bool> {
        let behind = self.taken + wanted as u64;
        let long = self.attachment && wanted as u64 > LONG_ATTACHMENT && behind <= self.size;
        if !long || self.check || self.taken != self.next + PREFIX as u64 {
            return Ok(false);
        }
        let mut head = [0; 1024];
        self.input.read_exact(&mut head)?;
        let skip = attachment_head(&head).is_ok_and(|(name, start, length)| {
            name != super::format::SCENARIO
                && (start as u64).checked_add(length) == Some(wanted as u64 - 4)
        });
        let to = if skip { behind } else { self.taken };
        self.input.seek(SeekFrom::Start(to))?;
        if skip {
            self.reader = LinearReader::new_with_options(options().with_skip_start_magic(true));
            (self.taken, self.next) = (behind, behind);
        }
        self.attachment = false;
        Ok(skip)
    }

    /// Content of the current record.
    pub(super) fn record(&self) -> &[u8] {
        &self.record
    }

    /// Whether the current record is one that a session may hold outside its chunks, with lengths that agree: when not, the
    /// walk has lost its way.
    pub(super) fn makes_sense(&self, opcode: u8) -> bool {
        let record = self.record();
        match opcode {
            op::HEADER => self.at == mcap::MAGIC.len() as u64,
            op::MESSAGE_INDEX => {
                let mut bytes = Bytes(record);
                let length = bytes.u16().and_then(|_| bytes.u32());
                length.is_ok_and(|n| n as usize == bytes.0.len() && n % 16 == 0)
            }
            // With nothing behind: a record that is too long hides others.
            op::METADATA => metadata_and_rest(record).is_ok_and(|(_, rest)| rest == 0),
            op::ATTACHMENT => attachment(record).is_ok_and(|(name, data)| {
                let head = attachment_head(record).map(|(_, start, _)| start);
                !name.is_empty() && head.is_ok_and(|start| start + data.len() + 4 == record.len())
            }),
            op::DATA_END => record.len() == 4,
            _ => false,
        }
    }

    /// Takes the current record away; give the buffer back through [`Self::recycle`].
    pub(super) fn take_record(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.record)
    }

    /// Uses `buffer` for records to come.
    pub(super) fn recycle(&mut self, buffer: Vec<u8>) {
        self.record = buffer;
    }

    /// Looks for the next chunk from byte `from` on, up to `until`, and goes there. `false` when there is none: the walk is over.
    ///
    /// A chunk shows by its opcode and by three lengths that agree.
    pub(super) fn resynchronise(&mut self, from: u64, until: u64) -> io::Result<bool> {
        const BLOCK: usize = 64 * 1024;
        const HEAD: usize = PREFIX + CHUNK_HEAD + ZSTD.len();
        let mut block = vec![0; BLOCK];
        let mut start = from;
        while start + HEAD as u64 <= self.size && start < until {
            self.input.seek(SeekFrom::Start(start))?;
            let length = (self.size - start).min(BLOCK as u64) as usize;
            self.input.read_exact(&mut block[..length])?;
            let heads = block[..length].windows(HEAD);
            let found = heads
                .zip(start..)
                .find(|(head, at)| is_chunk_head(head, self.size - at));
            if let Some((_, at)) = found {
                self.input.seek(SeekFrom::Start(at))?;
                self.reader = LinearReader::new_with_options(options().with_skip_start_magic(true));
                (self.taken, self.next) = (at, at);
                return Ok(true);
            }
            start += (length - (HEAD - 1)) as u64;
        }
        Ok(false)
    }

    fn damaged(&self, error: &McapError) -> WireError {
        let what = match error {
            McapError::BadMagic if self.next <= 8 => "not an MCAP file".to_owned(),
            McapError::BadMagic => "the end mark is missing".to_owned(),
            McapError::UnexpectedEof => "the file ends unfinished".to_owned(),
            other => other.to_string(),
        };
        WireError::Damaged(self.next.min(self.size), what)
    }
}

fn options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_record_length_limit(LONGEST_RECORD)
}

fn is_chunk_head(head: &[u8], left: u64) -> bool {
    let u64_at = |at: usize| {
        let bytes = head[at..at + 8].try_into();
        bytes.map(u64::from_le_bytes).unwrap_or(u64::MAX)
    };
    let name = match head[PREFIX + 28..PREFIX + 32] {
        [0, 0, 0, 0] => 0,
        [4, 0, 0, 0] if head[PREFIX + 32..PREFIX + 36] == *ZSTD.as_bytes() => ZSTD.len(),
        _ => return false,
    };
    let (length, unpacked) = (u64_at(1), u64_at(PREFIX + 16));
    let before = CHUNK_HEAD + name;
    head[0] == op::CHUNK
        && (before as u64..left.saturating_sub(PREFIX as u64) + 1).contains(&length)
        && u64_at(PREFIX) <= u64_at(PREFIX + 8)
        && u64_at(PREFIX + 32 + name) == length - before as u64
        && if name == 0 {
            unpacked == length - before as u64
        } else {
            unpacked <= LONGEST_RECORD as u64
        }
}

/// Where the messages of a chunk are.
#[derive(Debug)]
pub(super) enum Messages {
    /// In the chunk record, from this byte on.
    Plain(usize),
    /// Here, unpacked.
    Unpacked(Vec<u8>),
}

/// The messages of a chunk record. Checks the chunk's own checksum.
pub(super) fn chunk_messages(record: &[u8]) -> Result<Messages, String> {
    let mut bytes = Bytes(record);
    let _times = (bytes.u64()?, bytes.u64()?);
    let uncompressed = bytes.u64()?;
    let crc = bytes.u32()?;
    let compression = bytes.text()?;
    let length = bytes.u64()?;
    if !["", ZSTD].contains(&compression) {
        return Err(format!(
            "the chunk is compressed with {compression:?}; allowed: none or {ZSTD:?}"
        ));
    }
    let packed = compression == ZSTD;
    let there = bytes.0.len();
    if length != there as u64 || !packed && length != uncompressed {
        return Err(format!(
            "the chunk holds {there} bytes, but says {length} and {uncompressed}"
        ));
    }
    let messages = if packed {
        Messages::Unpacked(unpack(bytes.0, uncompressed)?)
    } else {
        Messages::Plain(record.len() - there)
    };
    let calculated = crc32fast::hash(match &messages {
        Messages::Plain(_) => bytes.0,
        Messages::Unpacked(unpacked) => unpacked,
    });
    if crc != 0 && crc != calculated {
        return Err(format!(
            "the chunk's checksum is {calculated:08x}, but the file says {crc:08x}"
        ));
    }
    Ok(messages)
}

fn unpack(packed: &[u8], uncompressed: u64) -> Result<Vec<u8>, String> {
    let length = usize::try_from(uncompressed).unwrap_or(usize::MAX);
    if length > LONGEST_RECORD {
        return Err(format!(
            "the chunk says it unpacks to {uncompressed} bytes; at most {LONGEST_RECORD} are allowed"
        ));
    }
    let unpacked = zstd::bulk::decompress(packed, length)
        .map_err(|e| format!("the chunk cannot be unpacked: {e}"))?;
    if unpacked.len() != length {
        let got = unpacked.len();
        return Err(format!(
            "the chunk unpacks to {got} bytes, but says {length}"
        ));
    }
    Ok(unpacked)
}

/// The record inside a chunk that starts at byte `at`: its opcode, its content's range, and where the next one starts.
pub(super) fn record_in_chunk(
    chunk: &[u8],
    at: usize,
) -> Result<(u8, std::ops::Range<usize>), String> {
    let mut bytes = Bytes(chunk.get(at..).unwrap_or_default());
    let opcode = bytes.take(1)?[0];
    let length = usize::try_from(bytes.u64()?).unwrap_or(usize::MAX);
    bytes.take(length)?;
    let start = at + PREFIX;
    Ok((opcode, start..start + length))
}

/// Opcode and length of the content of the record that starts at byte `at` of a file.
pub(super) fn prefix_at<R: Read + Seek>(input: &mut R, at: u64) -> io::Result<(u8, u64)> {
    input.seek(SeekFrom::Start(at))?;
    let mut prefix = [0; PREFIX];
    input.read_exact(&mut prefix)?;
    let length = prefix[1..].iter().rev();
    let length = length.fold(0, |sum, byte| sum << 8 | u64::from(*byte));
    Ok((prefix[0], length))
}

/// The record that starts at byte `at` of a file: its opcode and its content.
pub(super) fn record_at<R: Read + Seek>(
    input: &mut R,
    at: u64,
) -> Result<(u8, Vec<u8>), WireError> {
    input.seek(SeekFrom::Start(at)).map_err(WireError::Io)?;
    let cut = || WireError::Damaged(at, "the file ends unfinished".to_owned());
    let read = |input: &mut R, length: u64| {
        let mut bytes = Vec::new();
        let read = input.by_ref().take(length).read_to_end(&mut bytes);
        match read.map_err(WireError::Io)? as u64 == length {
            true => Ok(bytes),
            false => Err(cut()),
        }
    };
    let prefix = read(input, PREFIX as u64)?;
    let mut bytes = Bytes(&prefix[1..]);
    let length = bytes.u64().map_err(|_| cut())?;
    if length > LONGEST_RECORD as u64 {
        let what = format!("a record of {length} bytes; at most {LONGEST_RECORD} are allowed");
        return Err(WireError::Damaged(at, what));
    }
    Ok((prefix[0], read(input, length)?))
}

/// A message record's channel, log time and content.
pub(super) fn message(record: &[u8]) -> Result<(u16, u64, &[u8]), String> {
    let mut bytes = Bytes(record);
    let channel = bytes.u16()?;
    bytes.take(4)?;
    let log_ns = bytes.u64()?;
    bytes.take(8)?;
    Ok((channel, log_ns, bytes.0))
}

/// A channel record's id and topic.
pub(super) fn channel(record: &[u8]) -> Result<(u16, String), String> {
    let mut bytes = Bytes(record);
    let id = bytes.u16()?;
    bytes.u16()?;
    Ok((id, bytes.text()?.to_owned()))
}

/// A metadata record's name and entries.
pub(super) fn metadata(record: &[u8]) -> Result<(String, BTreeMap<String, String>), String> {
    metadata_and_rest(record).map(|(found, _)| found)
}

/// As [`metadata`], and how many bytes are left behind it.
#[allow(clippy::type_complexity, reason = "what it says")]
fn metadata_and_rest(record: &[u8]) -> Result<((String, BTreeMap<String, String>), usize), String> {
    let mut bytes = Bytes(record);
    let name = bytes.text()?.to_owned();
    let length = bytes.u32()? as usize;
    let mut entries = Bytes(bytes.take(length)?);
    let mut map = BTreeMap::new();
    while !entries.0.is_empty() {
        let key = entries.text()?.to_owned();
        map.insert(key, entries.text()?.to_owned());
    }
    Ok(((name, map), bytes.0.len()))
}

/// Name of an attachment, the byte of the record that its content starts at, and the length of that.
fn attachment_head(record: &[u8]) -> Result<(&str, usize, u64), String> {
    let mut bytes = Bytes(record);
    bytes.take(8 + 8)?;
    let name = bytes.text()?;
    bytes.text()?;
    let length = bytes.u64()?;
    Ok((name, record.len() - bytes.0.len(), length))
}

/// An attachment's name and content. Checks its checksum.
pub(super) fn attachment(record: &[u8]) -> Result<(String, &[u8]), String> {
    let (name, start, length) = attachment_head(record)?;
    let mut bytes = Bytes(&record[start..]);
    let data = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
    let checked = record.len() - bytes.0.len();
    let crc = bytes.u32()?;
    let calculated = crc32fast::hash(&record[..checked]);
    if crc != 0 && crc != calculated {
        return Err(format!(
            "the checksum of attachment {name:?} is {calculated:08x}, but the file says {crc:08x}"
        ));
    }
    Ok((name.to_owned(), data))
}

/// What is left of a record while it is parsed.
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(super) fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let Some((head, tail)) = self.0.split_at_checked(n) else {
            let there = self.0.len();
            return Err(format!(
                "a record needs {n} more bytes where {there} are left"
            ));
        };
        self.0 = tail;
        Ok(head)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn u16(&mut self) -> Result<u16, String> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn text(&mut self) -> Result<&'a str, String> {
        let length = self.u32()? as usize;
        let text = self.take(length)?;
        std::str::from_utf8(text).map_err(|e| format!("a text is not UTF-8: {e}"))
    }
}
