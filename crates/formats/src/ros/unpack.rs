//! Decompression of chunks, in no more memory than the chunk declares.

use std::io::Read;

/// Compression of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    /// No compression.
    None,
    /// Zstandard frames.
    Zstd,
    /// LZ4 frames.
    Lz4,
    /// bzip2.
    Bzip2,
}

impl Compression {
    /// The compression with this name in a file.
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

/// Unpacks a chunk of `size` bytes: the bytes before a fault, and a description of the fault. If the chunk is larger than
/// `most` bytes, `most` + 1 bytes are returned.
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

/// Decompresses a single message (Zstandard); None if it is damaged or larger than 64 MiB.
#[must_use]
pub fn message(packed: &[u8]) -> Option<Vec<u8>> {
    const MAX_BYTES: usize = 1 << 26;
    let mut data = Vec::new();
    let reader = zstd::stream::read::Decoder::with_buffer(packed).ok()?;
    drain(reader, MAX_BYTES, &mut data).ok()?;
    (data.len() <= MAX_BYTES).then_some(data)
}

/// Memory grows with the bytes that are read: a declared size alone allocates nothing.
fn drain(reader: impl Read, size: usize, into: &mut Vec<u8>) -> std::io::Result<()> {
    // One extra byte shows that a chunk is larger than declared.
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
