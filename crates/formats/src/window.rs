//! A window that moves forward through a file: the bytes ahead of a position, without the whole file in memory.

use std::io::{self, Read, Seek, SeekFrom};

use crate::progress;

const BUFFER_SIZE: usize = 1 << 18;

pub(crate) struct Window<R> {
    source: R,
    buffer: Vec<u8>,
    from: usize,
    to: usize,
    at: u64,
}

impl<R: Read + Seek> Window<R> {
    pub(crate) fn new(source: R) -> Self {
        Self { source, buffer: vec![0; BUFFER_SIZE], from: 0, to: 0, at: 0 }
    }

    /// Position of the window in the file.
    pub(crate) fn at(&self) -> u64 {
        self.at
    }

    /// At least `n` bytes, or all bytes up to the end of the file.
    pub(crate) fn ahead(&mut self, n: usize) -> io::Result<&[u8]> {
        if self.to - self.from < n {
            self.buffer.copy_within(self.from..self.to, 0);
            self.to -= self.from;
            self.from = 0;
            if self.buffer.len() < n {
                self.buffer.resize(n, 0);
            }
            while self.to < n {
                match self.source.read(&mut self.buffer[self.to..]) {
                    Ok(0) => break,
                    Ok(got) => {
                        self.to += got;
                        progress::count(got);
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(error),
                }
            }
        }
        Ok(&self.buffer[self.from..self.to])
    }

    /// Moves forward by `n` of the bytes ahead.
    pub(crate) fn skip(&mut self, n: usize) {
        let n = n.min(self.to - self.from);
        self.from += n;
        self.at += n as u64;
    }

    /// Moves forward to a position.
    pub(crate) fn seek(&mut self, to: u64) -> io::Result<()> {
        let distance = to.saturating_sub(self.at);
        if distance <= (self.to - self.from) as u64 {
            self.skip(distance as usize);
            return Ok(());
        }
        self.at = self.source.seek(SeekFrom::Start(to))?;
        self.from = 0;
        self.to = 0;
        Ok(())
    }
}

/// Bytes of each field of all records, concatenated.
pub(crate) struct Fields {
    fields: Vec<(usize, usize)>,
    pub(crate) columns: Vec<Vec<u8>>,
}

impl Fields {
    /// `fields`: offsets in a record, and lengths; every record has at least `size` bytes.
    pub(crate) fn new(fields: &[(usize, usize)], size: usize, rows: usize) -> io::Result<Self> {
        if fields.iter().any(|&(offset, length)| offset.checked_add(length).is_none_or(|end| end > size)) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "a field lies outside of the record"));
        }
        let mut columns = Vec::with_capacity(fields.len());
        for &(_, length) in fields {
            let mut column = Vec::new();
            column.try_reserve_exact(length.saturating_mul(rows)).map_err(|_| io::ErrorKind::OutOfMemory)?;
            columns.push(column);
        }
        Ok(Self { fields: fields.to_vec(), columns })
    }

    pub(crate) fn take(&mut self, record: &[u8]) {
        for (&(offset, length), column) in self.fields.iter().zip(&mut self.columns) {
            column.extend_from_slice(&record[offset..offset + length]);
        }
    }
}

/// Why a log breaks off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Break {
    /// The file ends in the middle of a message.
    Cut {
        /// Offset of the message.
        at: u64,
    },
    /// The bytes are not a message.
    Damaged {
        /// Offset of these bytes.
        at: u64,
        /// Description of the fault.
        what: String,
    },
}
