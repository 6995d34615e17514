//! MCAP files (mcap.dev/spec): each record is an opcode, a length of eight bytes, and the data.
//!
//! The `mcap` crate is not used: it trusts lengths inside chunks without a checksum, and allocates declared lengths before
//! it reads the bytes.

use super::parts::{Channel, End, Fault, MAX_LENGTH, Next, Piece, Record, Schema, Schemas};
use super::source::Source;
use super::unpack::Compression;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
const HEAD: usize = 9;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const STATISTICS: u8 = 0x0b;
const DATA_END: u8 = 0x0f;
/// Size of the footer and the magic after it. [bytes]
const TAIL: usize = HEAD + 20 + MAGIC.len();

/// Reads numbers and strings from the front of a slice.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, n: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(front)
    }

    fn u16(&mut self) -> Option<u32> {
        Some(u16::from_le_bytes(self.bytes(2)?.try_into().ok()?).into())
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.bytes(4)?.try_into().ok()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.bytes(8)?.try_into().ok()?))
    }

    fn prefixed(&mut self) -> Option<&'a [u8]> {
        let n = self.u32()?;
        self.bytes(n as usize)
    }

    fn string(&mut self) -> Option<String> {
        String::from_utf8(self.prefixed()?.to_vec()).ok()
    }
}

/// Reads the magic at the start; returns an end if it is missing.
pub fn begin(source: &mut Source) -> io::Result<Option<End>> {
    let magic = source.take(8)?;
    Ok(match magic.as_slice() {
        bytes if bytes == MAGIC => None,
        bytes if MAGIC.starts_with(bytes) => Some(End::new(Fault::BrokenOff, 0, "the file ends at once")),
        [0x89, b'M', b'C', b'A', b'P', ..] => {
            Some(End::new(Fault::Damaged, 0, "a version of MCAP that is not known"))
        }
        _ => Some(End::new(Fault::Damaged, 0, "not the mark of an MCAP file")),
    })
}

/// Reads the next record or chunk of the data section.
pub fn next(source: &mut Source) -> io::Result<Next> {
    let offset = source.at;
    let before = source.hasher.clone();
    let head = source.take(HEAD as u64)?;
    let broken = |what: &str| Ok(Next::End(End::new(Fault::BrokenOff, offset, what)));
    let Some((&opcode, length)) = head.split_first() else {
        return broken("the file ends without an end mark");
    };
    let Ok(length) = length.try_into().map(u64::from_le_bytes) else {
        return broken("the file ends within a record");
    };
    match opcode {
        CHUNK => chunk(source, offset, length),
        SCHEMA | CHANNEL | MESSAGE => {
            if length > source.remaining() {
                return broken("the file ends within a record");
            }
            if length > MAX_LENGTH {
                return Ok(Next::End(End::new(
                    Fault::Damaged,
                    offset,
                    format!("a record of {length} bytes"),
                )));
            }
            let mut bytes = head;
            bytes.extend(source.take(length)?);
            Ok(Next::Loose(bytes))
        }
        DATA_END => {
            let declared = Fields(&source.take(length.min(4))?).u32();
            let end = match declared {
                None => End::new(Fault::NoEnd, offset, "the file ends within its end mark"),
                Some(crc) if crc != 0 && crc != before.finalize() => {
                    End::new(Fault::Damaged, offset, "the checksum of all data is wrong")
                }
                Some(_) => tail(source)?,
            };
            Ok(Next::End(end))
        }
        0 | FOOTER => Ok(Next::End(End::new(
            Fault::Damaged,
            offset,
            format!("a record of kind {opcode} among the data"),
        ))),
        _ if length > source.remaining() => broken("the file ends within a record"),
        _ => Ok(if source.skip(length)? {
            Next::Other
        } else {
            Next::End(End::new(Fault::BrokenOff, offset, "the file ends within a record"))
        }),
    }
}

/// Finds the magic at the end of the log, and checks that the file ends there.
fn tail(source: &mut Source) -> io::Result<End> {
    let offset = source.at;
    let remaining = source.remaining();
    let mut window: Vec<u8> = Vec::new();
    if remaining >= TAIL as u64 {
        loop {
            let more = source.take(1 << 16)?;
            if more.is_empty() {
                break;
            }
            window.extend(more);
            if let Some(at) = memchr::memmem::find(&window, MAGIC) {
                let end = source.at - (window.len() - at - MAGIC.len()) as u64;
                window.drain(..at + MAGIC.len());
                return bytes_after_end(source, end, &window);
            }
            window.drain(..window.len().saturating_sub(MAGIC.len()));
        }
    }
    Ok(End::new(Fault::NoEnd, offset, "the end of the file is missing or damaged"))
}

/// Classifies the bytes after the end: none, filler of a disk, or another log.
fn bytes_after_end(source: &mut Source, end: u64, window: &[u8]) -> io::Result<End> {
    let remaining = source.length.saturating_sub(end);
    let Some(&first) = window.first() else { return Ok(End::complete()) };
    let same = |bytes: &[u8]| bytes.iter().all(|&byte| byte == first);
    let mut filler = (first == 0 || first == 0xff) && same(window);
    while filler {
        let more = source.take(1 << 20)?;
        if more.is_empty() {
            let what = format!("{remaining} bytes of {first:#x} follow the end of the log");
            return Ok(End::new(Fault::Filler, end, what));
        }
        filler = same(&more);
    }
    Ok(End::new(
        Fault::BytesAfterEnd,
        end,
        format!("{remaining} bytes follow the end of the log and are not read"),
    ))
}

fn chunk(source: &mut Source, offset: u64, length: u64) -> io::Result<Next> {
    let cut = length > source.remaining();
    if length > MAX_LENGTH {
        let (fault, what) = if cut {
            (Fault::BrokenOff, "the file ends within a chunk")
        } else {
            (Fault::Damaged, "a chunk")
        };
        return Ok(Next::End(End::new(fault, offset, format!("{what} of {length} bytes"))));
    }
    let mut record = source.take(length)?;
    let mut fields = Fields(&record);
    let parsed = (|| {
        fields.bytes(16)?;
        let size = fields.u64()?;
        let crc = fields.u32()?;
        let compression = fields.prefixed()?;
        Some((size, crc, compression, fields.u64()?))
    })();
    let damaged = |what: String| Ok(Next::End(End::new(Fault::Damaged, offset, what)));
    let Some((size, crc, name, packed)) = parsed else {
        return if cut {
            Ok(Next::End(End::new(Fault::BrokenOff, offset, "the file ends within a chunk")))
        } else {
            damaged("the head of a chunk makes no sense".to_owned())
        };
    };
    let Some(compression) = Compression::named(name) else {
        return damaged(format!("a chunk is compressed by {:?}", String::from_utf8_lossy(name)));
    };
    if size > MAX_LENGTH {
        return damaged(format!("a chunk of {size} bytes"));
    }
    let rest = fields.0.len();
    if !cut && packed != rest as u64 {
        return damaged("the head of a chunk makes no sense".to_owned());
    }
    Ok(Next::Piece(Piece {
        offset,
        packed: record.split_off(record.len() - rest),
        compression,
        size: size as usize,
        crc: (crc != 0).then_some(crc),
        cut,
    }))
}

/// The records of a chunk.
pub fn records(data: &[u8], visit: &mut dyn FnMut(Record<'_>) -> Result<(), String>) -> Result<(), String> {
    let mut rest = Fields(data);
    while !rest.0.is_empty() {
        let body = (|| {
            let opcode = *rest.bytes(1)?.first()?;
            let length = usize::try_from(rest.u64()?).ok()?;
            Some((opcode, rest.bytes(length)?))
        })();
        let record = match body {
            Some((MESSAGE, body)) => message(body),
            Some((CHANNEL, body)) => channel(body).map(Record::Channel),
            Some((SCHEMA, body)) => schema(body).map(|(id, schema)| Record::Schema(id, schema)),
            Some((0, _)) | None => None,
            Some(_) => continue,
        };
        visit(record.ok_or("a record of a chunk makes no sense")?)?;
    }
    Ok(())
}

fn message(body: &[u8]) -> Option<Record<'_>> {
    let mut fields = Fields(body);
    let channel = fields.u16()?;
    fields.bytes(4)?;
    let time = fields.u64()?;
    fields.bytes(8)?;
    Some(Record::Message { channel, time, data: fields.0 })
}

fn channel(body: &[u8]) -> Option<Channel> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let schema = fields.u16()?;
    let topic = fields.string()?;
    let message_encoding = fields.string()?;
    // Until all definitions are known, this is the number of the definition.
    Some(Channel { id, topic, message_encoding, type_name: schema.to_string(), ..Channel::default() })
}

fn schema(body: &[u8]) -> Option<(u32, Schema)> {
    let mut fields = Fields(body);
    let id = fields.u16()?;
    let name = fields.string()?;
    let encoding = fields.string()?;
    Some((id, Schema { name, encoding, data: fields.prefixed()?.to_vec() }))
}

/// Replaces the numbers of definitions in the channels by the definitions.
pub fn describe(channels: &mut [Channel], schemas: &Schemas) {
    for channel in channels {
        let schema =
            channel.type_name.parse().ok().and_then(|id: u32| schemas.get(&id)).cloned().unwrap_or_default();
        channel.type_name = schema.name;
        channel.definition_encoding = schema.encoding;
        channel.definition = schema.data;
    }
}

/// The channels from the summary at the end of the file; None if it is missing or invalid.
pub fn summary(mut file: &File) -> Option<Vec<Channel>> {
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.checked_sub(TAIL as u64)?)).ok()?;
    let mut tail = [0; TAIL];
    file.read_exact(&mut tail).ok()?;
    let mut fields = Fields(&tail);
    if fields.bytes(1)? != [FOOTER] || fields.u64()? != 20 || !tail.ends_with(MAGIC) {
        return None;
    }
    let start = fields.u64()?;
    fields.u64()?;
    let crc = fields.u32()?;
    let size = (length - TAIL as u64).checked_sub(start)?;
    if start < MAGIC.len() as u64 || size > MAX_LENGTH {
        return None;
    }
    file.seek(SeekFrom::Start(start)).ok()?;
    let mut data = vec![0; size as usize];
    file.read_exact(&mut data).ok()?;
    if crc != 0 {
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&data);
        hasher.update(tail.get(..TAIL - MAGIC.len() - 4)?);
        if hasher.finalize() != crc {
            return None;
        }
    }
    let mut channels = Vec::new();
    let mut schemas = Schemas::new();
    records(&data, &mut |record| {
        match record {
            Record::Channel(channel) => channels.push(channel),
            Record::Schema(id, schema) => {
                schemas.insert(id, schema);
            }
            Record::Message { .. } => return Err("a message after the data".to_owned()),
        }
        Ok(())
    })
    .ok()?;
    let counts = statistics(&data)?;
    if counts.keys().any(|id| !channels.iter().any(|channel| channel.id == *id)) {
        return None;
    }
    for channel in &mut channels {
        channel.messages = counts.get(&channel.id).copied().unwrap_or(0);
        let id: u32 = channel.type_name.parse().ok()?;
        if id != 0 && !schemas.contains_key(&id) {
            return None;
        }
    }
    describe(&mut channels, &schemas);
    Some(channels)
}

/// Number of messages by channel.
fn statistics(data: &[u8]) -> Option<BTreeMap<u32, u64>> {
    let mut rest = Fields(data);
    while !rest.0.is_empty() {
        let opcode = *rest.bytes(1)?.first()?;
        let length = usize::try_from(rest.u64()?).ok()?;
        let body = rest.bytes(length)?;
        if opcode != STATISTICS {
            continue;
        }
        let mut fields = Fields(body);
        let total = fields.u64()?;
        fields.bytes(2 + 4 * 4 + 16)?;
        let mut pairs = Fields(fields.prefixed()?);
        let mut counts = BTreeMap::new();
        while !pairs.0.is_empty() {
            counts.insert(pairs.u16()?, pairs.u64()?);
        }
        let sum = counts.values().try_fold(0u64, |sum, &n| sum.checked_add(n));
        return (sum == Some(total)).then_some(counts);
    }
    None
}
