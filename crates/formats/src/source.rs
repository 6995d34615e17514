//! Files: from one end to the other, decompressed on the way, or at any position.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use crate::progress::{self, Counted};
use crate::table::TextError;

/// First bytes of a compressed file.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// A file for reading, decompressed on the way if its first two bytes say gzip; to at most so many bytes, after which it
/// fails as [`ErrorKind::FileTooLarge`].
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
        // The decoder asks for small pieces; the file is read in large ones.
        let buffered = io::BufReader::with_capacity(1 << 16, whole);
        Ok(Box::new(Limited { reader: MultiGzDecoder::new(buffered), left: most }))
    } else {
        Ok(Box::new(whole))
    }
}

/// A reader that fails after so many bytes.
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

/// Bytes that can be read at any position.
pub(crate) trait Source: Sync {
    /// Reads at most as much as `out` holds, from position `at` on; 0 at the end.
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize>;

    /// Length at the moment, for an estimate.
    fn length(&self) -> u64;
}

/// A file that can be read at any position.
pub(crate) struct PlainFile {
    file: File,
    pub(crate) length: u64,
}

impl Source for PlainFile {
    #[cfg(unix)]
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        std::os::unix::fs::FileExt::read_at(&self.file, out, at).inspect(|&got| progress::count(got))
    }

    #[cfg(windows)]
    fn read_at(&self, out: &mut [u8], at: u64) -> io::Result<usize> {
        std::os::windows::fs::FileExt::seek_read(&self.file, out, at).inspect(|&got| progress::count(got))
    }

    #[cfg(not(any(unix, windows)))]
    fn read_at(&self, _: &mut [u8], _: u64) -> io::Result<usize> {
        Err(ErrorKind::Unsupported.into())
    }

    fn length(&self) -> u64 {
        self.length
    }
}

/// The file, if it can be read at any position, is not compressed and has so many bytes.
pub(crate) fn large_and_plain(path: &Path, least: u64) -> Result<Option<PlainFile>, TextError> {
    let failed = |e: io::Error| TextError::Io(e.to_string());
    // A pipe must not be opened twice: what has been read from it is gone.
    let about = std::fs::metadata(path).map_err(failed)?;
    if !cfg!(any(unix, windows)) || !about.is_file() || about.len() < least {
        return Ok(None);
    }
    let file = PlainFile { file: File::open(path).map_err(failed)?, length: about.len() };
    let mut head = [0; 2];
    let got = fill(&file, &mut head, 0).map_err(failed)?;
    Ok((head[..got] != GZIP).then_some(file))
}

/// Reads until `out` is full or the source ends; bytes read.
pub(crate) fn fill(source: &impl Source, out: &mut [u8], at: u64) -> io::Result<usize> {
    let mut filled = 0;
    while filled < out.len() {
        match source.read_at(&mut out[filled..], at + filled as u64) {
            Ok(0) => break,
            Ok(got) => filled += got,
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(filled)
}
