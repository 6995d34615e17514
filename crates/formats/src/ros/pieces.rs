//! Chunks of a file, which are processed in parallel and joined in order.

use super::cursor::Row;
use super::parts::{Channel, End, Fault, Next, Piece, Record, Schemas};
use super::program::{Columns, Program};
use super::source::Source;
use super::unpack::{Compression, unpack};
use super::{bag, mcap};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Largest total size of several chunks that are unpacked in parallel. [bytes]
const MAX_PARALLEL_BYTES: usize = 1 << 26;
const MAX_PARALLEL_CHUNKS: usize = 16;

/// The two formats.
#[derive(Clone, Copy)]
pub enum Container {
    Mcap,
    Bag,
}

/// Channels in a stretch of records.
#[derive(Default)]
pub struct Survey {
    pub channels: Vec<Channel>,
    pub schemas: Schemas,
    pub counts: BTreeMap<u32, u64>,
}

impl Container {
    fn records(
        self,
        data: &[u8],
        visit: &mut dyn FnMut(Record<'_>) -> Result<(), String>,
    ) -> Result<(), String> {
        match self {
            Self::Mcap => mcap::records(data, visit),
            Self::Bag => bag::records(data, visit),
        }
    }

    /// Counts the messages of a stretch of records and lists its channels, up to the first fault.
    pub fn survey(self, data: &[u8], into: &mut Survey) -> Option<String> {
        self.records(data, &mut |record| {
            match record {
                Record::Message { channel, .. } => *into.counts.entry(channel).or_default() += 1,
                Record::Channel(channel) => into.channels.push(channel),
                Record::Schema(id, schema) => {
                    into.schemas.insert(id, schema);
                }
            }
            Ok(())
        })
        .err()
    }

    /// Decodes the messages of some channels.
    pub fn decode(self, data: &[u8], ids: &[u32], program: &Program, into: &mut Columns) -> Option<String> {
        let mut row = Row::default();
        self.records(data, &mut |record| match record {
            Record::Message { channel, time, data }
                if ids.contains(&channel) && !program.push(data, time, &mut row, into) =>
            {
                Err("a message does not hold what its definition says".to_owned())
            }
            _ => Ok(()),
        })
        .err()
    }
}

/// Reading of a file from its beginning.
pub struct Walk {
    source: Source,
    container: Container,
    /// Remaining limit on the size of unpacked chunks. [bytes]
    remaining: u64,
}

impl Walk {
    pub fn open(path: &Path, container: Container, most: u64) -> io::Result<Self> {
        Ok(Self { source: Source::open(path)?, container, remaining: most })
    }

    /// Reads the file. `each` runs in parallel on unpacked records, with a flag whether a checksum confirms them; `merge`
    /// receives its results in order.
    pub fn run<T: Send>(
        mut self,
        each: impl Fn(Container, &[u8], bool) -> (T, Option<String>) + Sync,
        mut merge: impl FnMut(T),
    ) -> io::Result<End> {
        let container = self.container;
        let first = match container {
            Container::Mcap => mcap::begin(&mut self.source)?,
            Container::Bag => bag::begin(&mut self.source)?,
        };
        if let Some(end) = first {
            return Ok(end);
        }
        loop {
            let (batch, last) = self.batch()?;
            let remaining = self.remaining;
            let done: Vec<_> =
                batch.into_par_iter().map(|piece| work(piece, remaining, container, &each)).collect();
            for (made, size, end) in done {
                let Some(remaining) = self.remaining.checked_sub(size as u64) else {
                    return Ok(End::new(Fault::Expanded, 0, "its chunks unpack to more than is allowed"));
                };
                self.remaining = remaining;
                // Data before a fault are used, data after it are not.
                merge(made);
                if let Some(end) = end {
                    return Ok(end);
                }
            }
            if let Some(end) = last {
                return Ok(end);
            }
        }
    }

    fn batch(&mut self) -> io::Result<(Vec<Piece>, Option<End>)> {
        let mut batch: Vec<Piece> = Vec::new();
        let mut size = 0;
        let mut open = false; // The last piece is a stretch of records outside chunks.
        while (batch.len() < MAX_PARALLEL_CHUNKS || open) && size < MAX_PARALLEL_BYTES {
            let offset = self.source.at;
            let next = match self.container {
                Container::Mcap => mcap::next(&mut self.source)?,
                Container::Bag => bag::next(&mut self.source)?,
            };
            match next {
                Next::Piece(piece) => {
                    size += piece.size.max(piece.packed.len());
                    batch.push(piece);
                    open = false;
                }
                Next::Loose(bytes) => {
                    size += bytes.len();
                    match batch.last_mut() {
                        Some(piece) if open && piece.size < MAX_PARALLEL_BYTES / MAX_PARALLEL_CHUNKS => {
                            piece.packed.extend_from_slice(&bytes);
                            piece.size += bytes.len();
                        }
                        _ => {
                            let size = bytes.len();
                            let compression = Compression::None;
                            let piece =
                                Piece { offset, packed: bytes, compression, size, crc: None, cut: false };
                            batch.push(piece);
                        }
                    }
                    open = batch.len() < MAX_PARALLEL_CHUNKS
                        || batch
                            .last()
                            .is_some_and(|piece| piece.size < MAX_PARALLEL_BYTES / MAX_PARALLEL_CHUNKS);
                }
                Next::Other => {}
                Next::End(end) => return Ok((batch, Some(end))),
            }
        }
        Ok((batch, None))
    }
}

fn work<T>(
    piece: Piece,
    remaining: u64,
    container: Container,
    each: &(impl Fn(Container, &[u8], bool) -> (T, Option<String>) + Sync),
) -> (T, usize, Option<End>) {
    let Piece { offset, packed, compression, size, crc, cut } = piece;
    let (data, mut fault) = unpack(packed, compression, size, remaining);
    let (unpacked, complete) = (data.len(), data.len() == size);
    if complete && crc.is_some_and(|crc| crc != crc32fast::hash(&data)) {
        fault = Some("the checksum of a chunk is wrong".to_owned());
    }
    if cut && !(complete && fault.is_some()) {
        // The records before the break are complete, but the checksum covers only a whole chunk.
        let (made, _) = each(container, data.get(..size.min(data.len())).unwrap_or_default(), false);
        return (made, unpacked, Some(End::new(Fault::BrokenOff, offset, "the file ends within a chunk")));
    }
    if let Some(what) = fault {
        // A chunk with a fault is not used at all.
        let (made, _) = each(container, &[], true);
        return (made, unpacked, Some(End::new(Fault::Damaged, offset, what)));
    }
    let (made, fault) = each(container, &data, crc.is_some());
    (made, unpacked, fault.map(|what| End::new(Fault::Damaged, offset, what)))
}
