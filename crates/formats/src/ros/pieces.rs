//! A file cut into chunks, which are worked on side by side and put together in order.

use super::unpack::{Compression, unpack};
use super::{Channel, bag, mcap};
use crate::progress;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use super::fields::{Columns, Program, Row};

/// A length beyond this is taken for damage: writers make chunks of some megabytes. [bytes]
pub const LARGEST: u64 = 1 << 30;
/// Chunks that are unpacked side by side hold no more than this together, if they are more than one. [bytes]
const TOGETHER: usize = 1 << 26;
const MANY: usize = 16;

/// Why a walk ended before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing is wrong.
    None,
    /// The file ends too early.
    BrokenOff,
    /// All messages are there, but not the end of the file.
    NoEnd,
    /// Something in it cannot be right.
    Damaged,
    /// The log is whole, and bytes lie behind it.
    Behind,
    /// The log is whole, and zeros or 0xff lie behind it.
    Filler,
}

/// How a walk through a file ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// What kind of end.
    pub fault: Fault,
    /// Where in the file. [bytes]
    pub offset: u64,
    /// In words.
    pub what: String,
}

impl End {
    pub(super) fn complete() -> Self {
        Self { fault: Fault::None, offset: 0, what: String::new() }
    }

    pub(super) fn new(fault: Fault, offset: u64, what: impl Into<String>) -> Self {
        Self { fault, offset, what: what.into() }
    }
}

/// A chunk as it lies in the file, or a stretch of records outside of chunks.
pub struct Piece {
    pub offset: u64,
    pub packed: Vec<u8>,
    pub compression: Compression,
    pub size: usize,
    /// Checksum of the unpacked bytes, if there is one.
    pub crc: Option<u32>,
    /// The file ends within this chunk; what there is of it is used.
    pub cut: bool,
}

/// What stands at the next place of a file.
pub enum Next {
    Piece(Piece),
    /// Bytes of a record outside of any chunk, with its head.
    Loose(Vec<u8>),
    /// Nothing of interest.
    Other,
    /// The end of the data.
    End(End),
}

/// The two formats.
#[derive(Clone, Copy)]
pub enum Container {
    Mcap,
    Bag,
}

/// What was seen of channels in a stretch of records.
#[derive(Default)]
pub struct Survey {
    pub channels: Vec<Channel>,
    pub schemas: mcap::Schemas,
    pub counts: BTreeMap<u32, u64>,
}

/// A record that matters.
pub enum Record<'a> {
    Message { channel: u32, time: u64, data: &'a [u8] },
    Channel(Channel),
    Schema(u32, mcap::Schema),
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

    /// Counts the messages of a stretch of records, and lists its channels; a fault ends it.
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

/// A way through a file from its beginning.
pub struct Walk {
    source: Source,
    container: Container,
}

/// Bytes of a file, counted and summed up.
pub struct Source {
    file: BufReader<File>,
    pub at: u64,
    pub length: u64,
    pub hasher: crc32fast::Hasher,
    /// Where the index of a bag begins; 0 if it has none. [bytes]
    pub index: u64,
}

impl Source {
    pub fn left(&self) -> u64 {
        self.length.saturating_sub(self.at)
    }

    /// The next bytes, or fewer at the end of the file; memory is taken only for bytes that are there.
    pub fn take(&mut self, n: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(n.min(self.left()).min(LARGEST) as usize);
        (&mut self.file).take(n).read_to_end(&mut bytes)?;
        self.at += bytes.len() as u64;
        progress::count(bytes.len());
        self.hasher.update(&bytes);
        Ok(bytes)
    }

    /// Bytes that do not matter; false if the file ends before.
    pub fn pass(&mut self, mut n: u64) -> io::Result<bool> {
        while n > 0 {
            let got = self.take(n.min(1 << 20))?.len() as u64;
            if got == 0 {
                return Ok(false);
            }
            n -= got;
        }
        Ok(true)
    }
}

impl Walk {
    pub fn open(path: &Path, container: Container) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let file = BufReader::with_capacity(1 << 18, file);
        let source = Source { file, at: 0, length, hasher: crc32fast::Hasher::new(), index: 0 };
        Ok(Self { source, container })
    }

    /// Goes through the file: `each` works on unpacked records, side by side, and is told whether a checksum vouches for
    /// them; `merge` takes what it made in order.
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
            let done: Vec<_> = batch.into_par_iter().map(|piece| work(piece, container, &each)).collect();
            for (made, end) in done {
                // What stands before a fault is used, and nothing behind it.
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
        let mut open = false; // the last piece is one of loose records
        while (batch.len() < MANY || open) && size < TOGETHER {
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
                        Some(piece) if open && piece.size < TOGETHER / MANY => {
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
                    open =
                        batch.len() < MANY || batch.last().is_some_and(|piece| piece.size < TOGETHER / MANY);
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
    container: Container,
    each: &(impl Fn(Container, &[u8], bool) -> (T, Option<String>) + Sync),
) -> (T, Option<End>) {
    let Piece { offset, packed, compression, size, crc, cut } = piece;
    let (data, mut fault) = unpack(packed, compression, size);
    let complete = data.len() == size;
    if complete && crc.is_some_and(|crc| crc != crc32fast::hash(&data)) {
        fault = Some("the checksum of a chunk is wrong".to_owned());
    }
    if cut && !(complete && fault.is_some()) {
        // The records before the break are whole; no checksum vouches for a part.
        let (made, _) = each(container, data.get(..size.min(data.len())).unwrap_or_default(), false);
        return (made, Some(End::new(Fault::BrokenOff, offset, "the file ends within a chunk")));
    }
    if let Some(what) = fault {
        // Nothing of a chunk that is known to be wrong.
        let (made, _) = each(container, &[], true);
        return (made, Some(End::new(Fault::Damaged, offset, what)));
    }
    let (made, fault) = each(container, &data, crc.is_some());
    (made, fault.map(|what| End::new(Fault::Damaged, offset, what)))
}
