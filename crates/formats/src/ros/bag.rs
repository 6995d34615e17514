//! ROS 1 bags, version 2.0 (wiki.ros.org/Bags/Format/2.0). A record is the length of its head, a head of named fields, the
//! length of the data, and the data.

use super::parts::{Channel, End, Fault, MAX_LENGTH, Next, Piece, Record};
use super::source::Source;
use super::unpack::Compression;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
const MESSAGE: u8 = 2;
const BAG_HEADER: u8 = 3;
const INDEX: u8 = 4;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;
const SECOND: u64 = 1_000_000_000;

/// The fields of a head.
struct Head<'a>(&'a [u8]);

impl<'a> Head<'a> {
    fn get(&self, name: &[u8]) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while !rest.is_empty() {
            let (field, after) = prefixed(rest)?;
            let split = field.iter().position(|&byte| byte == b'=')?;
            if field.get(..split) == Some(name) {
                return field.get(split + 1..);
            }
            rest = after;
        }
        None
    }

    fn op(&self) -> Option<u8> {
        match self.get(b"op")? {
            [op] => Some(*op),
            _ => None,
        }
    }

    fn u32(&self, name: &[u8]) -> Option<u32> {
        Some(u32::from_le_bytes(self.get(name)?.try_into().ok()?))
    }

    fn u64(&self, name: &[u8]) -> Option<u64> {
        Some(u64::from_le_bytes(self.get(name)?.try_into().ok()?))
    }

    fn text(&self, name: &[u8]) -> Option<String> {
        String::from_utf8(self.get(name)?.to_vec()).ok()
    }
}

/// Splits off the bytes after a length of four bytes.
fn prefixed(data: &[u8]) -> Option<(&[u8], &[u8])> {
    let (length, rest) = data.split_first_chunk::<4>()?;
    rest.split_at_checked(u32::from_le_bytes(*length) as usize)
}

/// Reads the mark and the head of the bag; returns an end if they are missing.
pub fn begin(source: &mut Source) -> io::Result<Option<End>> {
    let magic = source.take(MAGIC.len() as u64)?;
    if magic != MAGIC {
        return Ok(Some(if MAGIC.starts_with(&magic) {
            End::new(Fault::BrokenOff, 0, "the file ends at once")
        } else {
            End::new(Fault::Damaged, 0, "not the mark of a ROS bag of version 2.0")
        }));
    }
    let offset = source.at;
    let cut = End::new(Fault::BrokenOff, offset, "the file ends within its head");
    let Some(head) = head(source)? else { return Ok(Some(cut)) };
    let Some(index) = Head(&head).u64(b"index_pos").filter(|_| Head(&head).op() == Some(BAG_HEADER)) else {
        return Ok(Some(End::new(Fault::Damaged, offset, "the head of the bag makes no sense")));
    };
    source.index = index;
    let Some(length) = length(source)? else { return Ok(Some(cut)) };
    Ok((length > source.remaining() || !source.skip(length)?).then_some(cut))
}

/// Reads a length of four bytes; None at the end of the file.
fn length(source: &mut Source) -> io::Result<Option<u64>> {
    Ok(source.take(4)?.try_into().ok().map(u32::from_le_bytes).map(u64::from))
}

/// Reads the head of the next record; None if the file ends first.
fn head(source: &mut Source) -> io::Result<Option<Vec<u8>>> {
    let Some(n) = length(source)? else { return Ok(None) };
    Ok(if n <= source.remaining() { Some(source.take(n)?) } else { None })
}

/// Reads the next record or chunk.
pub fn next(source: &mut Source) -> io::Result<Next> {
    let offset = source.at;
    let end = |fault, what: &str| Ok(Next::End(End::new(fault, offset, what)));
    if offset == source.index {
        let rest = source.take(MAX_LENGTH)?;
        return Ok(Next::End(if index(&rest).is_some() {
            End::complete()
        } else {
            End::new(Fault::NoEnd, offset, "the index at the end of the file is missing or damaged")
        }));
    }
    if source.index != 0 && offset > source.index {
        return end(Fault::Damaged, "the data reach into the index");
    }
    if source.remaining() == 0 {
        return end(Fault::BrokenOff, "the file has no index at its end");
    }
    let Some(bytes) = head(source)? else { return end(Fault::BrokenOff, "the file ends within a record") };
    let head = Head(&bytes);
    let Some(op) = head.op() else { return end(Fault::Damaged, "the head of a record makes no sense") };
    let Some(n) = length(source)? else { return end(Fault::BrokenOff, "the file ends within a record") };
    let cut = n > source.remaining();
    match op {
        CHUNK => {
            let (Some(size), Some(compression)) =
                (head.u32(b"size"), head.get(b"compression").and_then(Compression::named))
            else {
                return end(Fault::Damaged, "the head of a chunk makes no sense");
            };
            if n > MAX_LENGTH || u64::from(size) > MAX_LENGTH {
                return end(Fault::Damaged, "the length of a chunk makes no sense");
            }
            let packed = source.take(n)?;
            Ok(Next::Piece(Piece { offset, packed, compression, size: size as usize, crc: None, cut }))
        }
        _ if cut => end(Fault::BrokenOff, "the file ends within a record"),
        MESSAGE | CONNECTION => {
            if n > MAX_LENGTH {
                return end(Fault::Damaged, "the length of a record makes no sense");
            }
            let mut record = (bytes.len() as u32).to_le_bytes().to_vec();
            record.extend(&bytes);
            record.extend((n as u32).to_le_bytes());
            record.extend(source.take(n)?);
            Ok(Next::Loose(record))
        }
        INDEX | CHUNK_INFO | BAG_HEADER => Ok(if source.skip(n)? {
            Next::Other
        } else {
            Next::End(End::new(Fault::BrokenOff, offset, "the file ends within a record"))
        }),
        _ => end(Fault::Damaged, "a record of an unknown kind"),
    }
}

/// The records of a chunk.
pub fn records(data: &[u8], visit: &mut dyn FnMut(Record<'_>) -> Result<(), String>) -> Result<(), String> {
    let mut rest = data;
    while !rest.is_empty() {
        let parsed = (|| {
            let (head, after) = prefixed(rest)?;
            let (body, after) = prefixed(after)?;
            rest = after;
            let head = Head(head);
            match head.op()? {
                MESSAGE => message(&head, body),
                CONNECTION => connection(&head, body).map(Record::Channel),
                _ => None,
            }
        })();
        visit(parsed.ok_or("a record of a chunk makes no sense")?)?;
    }
    Ok(())
}

fn message<'a>(head: &Head<'_>, body: &'a [u8]) -> Option<Record<'a>> {
    let stamp = head.u64(b"time")?;
    let time = (stamp & 0xffff_ffff) * SECOND + (stamp >> 32);
    Some(Record::Message { channel: head.u32(b"conn")?, time, data: body })
}

fn connection(head: &Head<'_>, body: &[u8]) -> Option<Channel> {
    let fields = Head(body);
    Some(Channel {
        id: head.u32(b"conn")?,
        topic: head.text(b"topic")?,
        type_name: fields.text(b"type")?,
        definition_encoding: "ros1msg".to_owned(),
        definition: fields.get(b"message_definition")?.to_vec(),
        message_encoding: "ros1".to_owned(),
        messages: 0,
    })
}

/// The channels from the index at the end of the file; None if it is missing or invalid.
pub fn summary(mut file: &File) -> Option<Vec<Channel>> {
    let mut start = vec![0; MAGIC.len() + 4];
    file.read_exact(&mut start).ok()?;
    let n = u32::from_le_bytes(start.get(MAGIC.len()..)?.try_into().ok()?);
    if !start.starts_with(MAGIC) || n > 1 << 16 {
        return None;
    }
    let mut head = vec![0; n as usize];
    file.read_exact(&mut head).ok()?;
    let place = Head(&head).u64(b"index_pos")?;
    let size = file.metadata().ok()?.len().checked_sub(place)?;
    if place == 0 || size > MAX_LENGTH {
        return None;
    }
    file.seek(SeekFrom::Start(place)).ok()?;
    let mut data = vec![0; size as usize];
    file.read_exact(&mut data).ok()?;
    let (channels, chunks) = index(&data)?;
    let declared = (Head(&head).u32(b"conn_count")?, Head(&head).u32(b"chunk_count")?);
    (declared == (channels.len() as u32, chunks)).then_some(channels)
}

/// Connections with their messages, and the number of chunks.
fn index(data: &[u8]) -> Option<(Vec<Channel>, u32)> {
    let mut channels: Vec<Channel> = Vec::new();
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    let mut chunks = 0;
    let mut rest = data;
    while !rest.is_empty() {
        let (head, after) = prefixed(rest)?;
        let (body, after) = prefixed(after)?;
        rest = after;
        let head = Head(head);
        match head.op()? {
            CONNECTION => channels.push(connection(&head, body)?),
            CHUNK_INFO => {
                chunks += 1;
                for pair in body.chunks(8) {
                    let (id, n) = pair.split_first_chunk::<4>()?;
                    *counts.entry(u32::from_le_bytes(*id)).or_default() +=
                        u64::from(u32::from_le_bytes(n.try_into().ok()?));
                }
            }
            _ => return None,
        }
    }
    for channel in &mut channels {
        channel.messages = counts.get(&channel.id).copied().unwrap_or(0);
    }
    Some((channels, chunks))
}
