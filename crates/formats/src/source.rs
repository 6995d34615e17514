//! Sequential reading of files, which are decompressed if necessary.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::progress::Counted;
use crate::table::TextError;

/// First bytes of a gzip file.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Opens a file, decompressed if its first two bytes are those of gzip. After `most` decompressed bytes, reading fails with
/// [`ErrorKind::FileTooLarge`].
///
/// # Errors
///
/// [`TextError::Io`] if the file cannot be opened.
pub fn open(path: &Path, most: u64) -> Result<Box<dyn Read + Send>, TextError> {
    let failed = |e: io::Error| TextError::Io(e.to_string());
    let mut file = File::open(path).map_err(failed)?;
    let mut head = Vec::with_capacity(2);
    file.by_ref().take(2).read_to_end(&mut head).map_err(failed)?;
    let gzip = head == GZIP;
    let whole = io::Cursor::new(head).chain(Counted(file));
    if gzip {
        // The decoder requests small pieces; the buffer reads large ones.
        let buffered = io::BufReader::with_capacity(1 << 16, whole);
        Ok(Box::new(Limited { reader: MultiGzDecoder::new(buffered), left: most }))
    } else {
        Ok(Box::new(whole))
    }
}

/// A reader that fails after a number of bytes.
struct Limited<R> {
    reader: R,
    left: u64,
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.reader.read(out)?;
        self.left = self.left.checked_sub(got as u64).ok_or(ErrorKind::FileTooLarge)?;
        Ok(got)
    }
}
