//! Chunks unpacked: by the library of each compression, into no more memory than the chunk declares.

use std::io::Read;

/// How a chunk is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// Not at all.
    None,
    /// Zstandard frames.
    Zstd,
    /// LZ4 frames.
    Lz4,
    /// bzip2.
    Bzip2,
}

impl Compression {
    /// By the name that files use.
    pub fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"" | b"none" => Self::None,
            b"zstd" => Self::Zstd,
            b"lz4" => Self::Lz4,
            b"bz2" => Self::Bzip2,
            _ => return None,
        })
    }
}

/// The bytes of a chunk of `size` bytes, and what was wrong with them; what was unpacked before a fault is kept. Of a chunk
/// of more than `most` bytes, one byte more than that.
pub fn unpack(
    packed: Vec<u8>,
    compression: Compression,
    size: usize,
    most: u64,
) -> (Vec<u8>, Option<String>) {
    let most = usize::try_from(most).map_or(size, |most| size.min(most));
    let mut data = Vec::new();
    let done = match compression {
        Compression::None => {
            data = packed;
            Ok(())
        }
        Compression::Zstd => zstd::stream::read::Decoder::with_buffer(packed.as_slice())
            .and_then(|reader| drain(reader, most, &mut data)),
        Compression::Lz4 => drain(lz4_flex::frame::FrameDecoder::new(packed.as_slice()), most, &mut data),
        Compression::Bzip2 => drain(bzip2::bufread::MultiBzDecoder::new(packed.as_slice()), most, &mut data),
    };
    let fault = match done {
        Err(error) => Some(format!("a chunk cannot be decompressed ({error})")),
        Ok(()) if data.len() != size => {
            Some(format!("a chunk holds {} bytes where {size} are declared", data.len()))
        }
        Ok(()) => None,
    };
    (data, fault)
}

/// A message that is compressed by itself, as Zstandard; None if it is damaged or holds more than 64 MiB.
#[must_use]
pub fn message(packed: &[u8]) -> Option<Vec<u8>> {
    const MOST: usize = 1 << 26;
    let mut data = Vec::new();
    let reader = zstd::stream::read::Decoder::with_buffer(packed).ok()?;
    drain(reader, MOST, &mut data).ok()?;
    (data.len() <= MOST).then_some(data)
}

/// Memory grows as the bytes come: a declared size alone takes none.
fn drain(reader: impl Read, size: usize, into: &mut Vec<u8>) -> std::io::Result<()> {
    // One byte more shows a chunk that holds more than it declares.
    let mut reader = reader.take(size as u64 + 1);
    let mut block = vec![0; size.min(1 << 16) + 1];
    loop {
        match reader.read(&mut block) {
            Ok(0) => return Ok(()),
            Ok(n) => into.extend_from_slice(block.get(..n).unwrap_or_default()),
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}
