//! Sequential reading of a file, with position and checksum.

use super::parts::MAX_LENGTH;
use crate::progress;
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Bytes of a file, with position and checksum.
pub struct Source {
    file: BufReader<File>,
    pub at: u64,
    pub length: u64,
    pub hasher: crc32fast::Hasher,
    /// Where the index of a bag begins; 0 if it has none. [bytes]
    pub index: u64,
}

impl Source {
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let file = BufReader::with_capacity(1 << 18, file);
        Ok(Self { file, at: 0, length, hasher: crc32fast::Hasher::new(), index: 0 })
    }

    pub fn remaining(&self) -> u64 {
        self.length.saturating_sub(self.at)
    }

    /// The next bytes, or fewer at the end of the file; only existing bytes are allocated.
    pub fn take(&mut self, n: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::with_capacity(n.min(self.remaining()).min(MAX_LENGTH) as usize);
        (&mut self.file).take(n).read_to_end(&mut bytes)?;
        self.at += bytes.len() as u64;
        progress::count(bytes.len());
        self.hasher.update(&bytes);
        Ok(bytes)
    }

    /// Skips bytes; false if the file ends first.
    pub fn skip(&mut self, mut n: u64) -> io::Result<bool> {
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
