//! Decoding of text while it is read: UTF-16, decimal commas, and only the lines before a break.

use std::io::{self, Cursor, Read};
use std::path::Path;

use crate::source::open;
use crate::table::{Dialect, Table, TextError};
use crate::text::{read_columns, read_file};

/// How the characters of a text are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Encoding {
    /// UTF-8, or another superset of ASCII.
    #[default]
    Ascii,
    /// UTF-16, low byte first.
    Utf16Le,
    /// UTF-16, high byte first.
    Utf16Be,
}

/// How a text is encoded, apart from its layout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Writing {
    /// Encoding of its characters.
    pub encoding: Encoding,
    /// Whether 0,5 is one half. Points are then replaced by commas, so that a field with points is not a number.
    pub decimal_comma: bool,
    /// Number of lines to read; the rest is ignored.
    pub lines: Option<usize>,
}

impl Writing {
    /// Converts the text to ASCII with decimal points.
    pub(crate) fn decode<'r>(self, reader: impl Read + Send + 'r) -> Box<dyn Read + Send + 'r> {
        let mut reader: Box<dyn Read + Send + 'r> = match self.encoding {
            Encoding::Ascii => Box::new(reader),
            Encoding::Utf16Le => Box::new(utf16(reader, u16::from_le_bytes)),
            Encoding::Utf16Be => Box::new(utf16(reader, u16::from_be_bytes)),
        };
        if let Some(lines) = self.lines {
            reader = Box::new(Lines { reader, left: lines });
        }
        if self.decimal_comma { Box::new(Swapped { reader }) } else { reader }
    }
}

/// Reads the wanted columns of a table in this encoding, see [`read_columns`].
///
/// # Errors
///
/// See [`TextError`]. Quoted fields have decimal points and commas exchanged.
///
/// # Panics
///
/// As [`read_columns`].
pub fn read_written(
    reader: impl Read + Send,
    writing: Writing,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    read_columns(writing.decode(reader), dialect, wanted, exact)
}

/// Reads the wanted columns from a file, see [`read_file`]; decoding uses one thread.
///
/// # Errors
///
/// As [`read_written`].
///
/// # Panics
///
/// As [`read_columns`].
pub fn read_written_file(
    path: &Path,
    writing: Writing,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    if writing == Writing::default() {
        return read_file(path, dialect, wanted, exact);
    }
    read_written(open(path, dialect.most)?, writing, dialect, wanted, exact)
}

/// Text in UTF-16, decoded completely at the first read; half a character is replaced.
struct Utf16<R> {
    reader: Option<R>,
    unit: fn([u8; 2]) -> u16,
    text: Cursor<String>,
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if let Some(mut reader) = self.reader.take() {
            let mut raw = Vec::new();
            reader.read_to_end(&mut raw)?;
            let units = raw.chunks_exact(2).map(|pair| (self.unit)([pair[0], pair[1]]));
            let text = self.text.get_mut();
            text.extend(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)));
            text.extend((raw.len() % 2 > 0).then_some(char::REPLACEMENT_CHARACTER));
        }
        self.text.read(out)
    }
}

fn utf16<R: Read>(reader: R, unit: fn([u8; 2]) -> u16) -> Utf16<R> {
    Utf16 { reader: Some(reader), unit, text: Cursor::default() }
}

/// The first lines of a text.
struct Lines<R> {
    reader: R,
    left: usize,
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.left == 0 {
            return Ok(0);
        }
        let got = self.reader.read(out)?;
        for end in memchr::memchr_iter(b'\n', &out[..got]) {
            self.left -= 1;
            if self.left == 0 {
                return Ok(end + 1);
            }
        }
        Ok(got)
    }
}

/// Exchanges commas and points.
struct Swapped<R> {
    reader: R,
}

impl<R: Read> Read for Swapped<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let got = self.reader.read(out)?;
        for byte in &mut out[..got] {
            *byte = match *byte {
                b',' => b'.',
                b'.' => b',',
                other => other,
            };
        }
        Ok(got)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns one byte, then two, then three …
    struct Slow<'a>(&'a [u8], usize);

    impl Read for Slow<'_> {
        fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
            self.1 = self.1 % 5 + 1;
            let n = self.1.min(out.len()).min(self.0.len());
            out[..n].copy_from_slice(&self.0[..n]);
            self.0 = &self.0[n..];
            Ok(n)
        }
    }

    fn decoded(bytes: &[u8], writing: Writing) -> String {
        let mut text = String::new();
        writing.decode(Slow(bytes, 0)).read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn utf_16_of_any_characters_in_pieces_of_any_size() {
        let text = "\u{feff}t [°/s];\u{1f600}x\r\n0,5;µ\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let le: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
        let be: Vec<u8> = units.iter().flat_map(|u| u.to_be_bytes()).collect();
        for (encoding, bytes) in [(Encoding::Utf16Le, &le), (Encoding::Utf16Be, &be)] {
            let writing = Writing { encoding, ..Writing::default() };
            assert_eq!(decoded(bytes, writing), text);
            // Cut in the middle of a unit, and of a pair.
            assert_eq!(decoded(&bytes[..bytes.len() - 1], writing), text.replace("µ\n", "µ\u{fffd}"));
            let pair = 2 * units.iter().position(|u| (0xd800..0xdc00).contains(u)).unwrap();
            assert!(decoded(&bytes[..pair + 2], writing).ends_with(";\u{fffd}"));
        }
    }

    #[test]
    fn commas_and_points_change_places() {
        let writing = Writing { decimal_comma: true, ..Writing::default() };
        assert_eq!(decoded(b"0,5;1.234,5\n", writing), "0.5;1,234.5\n");
    }

    #[test]
    fn reading_ends_after_the_given_lines() {
        for (lines, expected) in [(0, ""), (1, "a\n"), (2, "a\n\n"), (3, "a\n\nb"), (9, "a\n\nb")] {
            let writing = Writing { lines: Some(lines), ..Writing::default() };
            assert_eq!(decoded(b"a\n\nb", writing), expected);
        }
    }
}
