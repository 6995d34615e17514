//! Text tables: numbers in columns, read in pieces, every line held to the same number of fields.
//!
//! Nothing is guessed and nothing is mended. A short line, a word among the numbers, an empty field or a NaN ends the
//! reading with an error that names the line, because a table that is read wrongly costs more than one that is refused.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use memchr::memchr;

/// Size of the pieces that a file is read in, and the longest line that is accepted. \[bytes\]
const PIECE: usize = 1 << 20;

/// Characters of a field that an error quotes.
const QUOTED: usize = 40;

/// Words that other programs write for a missing number, lower case.
const MISSING: [&[u8]; 9] = [b"", b"na", b"n/a", b"nan", b"null", b"none", b"nil", b"-nan", b"+nan"];

const BOM: &[u8] = b"\xef\xbb\xbf";

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// One byte: comma, semicolon, tab. Two in a row enclose an empty field.
    Byte(u8),
    /// Any run of spaces and tabs; leading and trailing ones do not count.
    Whitespace,
}

/// How a table is laid out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dialect {
    /// What stands between two fields.
    pub delimiter: Delimiter,
    /// A line that begins with one of these, after spaces, is a comment.
    pub comment: Vec<Vec<u8>>,
    /// Lines before the data, blank ones, comments and the header included.
    pub skip_lines: usize,
    /// Fields of every line of data. One empty field more, after a trailing delimiter, is let pass.
    pub columns: usize,
}

/// Columns of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The wanted columns, in the order in which they were asked for; all finite, all of the same length.
    pub columns: Vec<Vec<f64>>,
    /// The exact column, if every one of its values is written as an integer that fits. Time stamps in nanoseconds
    /// since 1970 need it: as `f64` they are only good to 256 ns.
    pub integers: Option<Vec<i64>>,
    /// Rows of data.
    pub rows: usize,
    /// Line of the first row, counted from 1.
    pub first_line: usize,
}

/// Why a table was refused. Lines count from 1 and are those of the file; rows and columns count from 0.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    /// A line with too few or too many fields.
    #[error("line {line}: {got} fields, {expected} expected")]
    Ragged {
        /// Line of the file.
        line: usize,
        /// Row of data.
        row: usize,
        /// Fields found.
        got: usize,
        /// Fields expected.
        expected: usize,
    },
    /// A field that is no number.
    #[error("line {line}, column {column}: {text:?} is not a number")]
    NotANumber {
        /// Line of the file.
        line: usize,
        /// Row of data.
        row: usize,
        /// Column of the file.
        column: usize,
        /// The field, at most 40 characters of it.
        text: String,
    },
    /// A field that stands for no finite number: NaN, an infinity, a number beyond the largest double, NA, null, nothing.
    #[error("line {line}, column {column}: {text:?} is not a finite number")]
    NonFinite {
        /// Line of the file.
        line: usize,
        /// Row of data.
        row: usize,
        /// Column of the file.
        column: usize,
        /// The field, at most 40 characters of it.
        text: String,
    },
    /// A line longer than a piece.
    #[error("line {line} is longer than 1 MiB")]
    TooLong {
        /// Line of the file.
        line: usize,
    },
    /// A compressed file that ends in the middle or is damaged.
    #[error("the compressed data break off or are damaged after line {line}")]
    Truncated {
        /// Last line that was read whole.
        line: usize,
    },
    /// The system could not read.
    #[error("{0}")]
    Io(String),
    /// No row of data.
    #[error("no row of data")]
    Empty,
}

/// A file for reading, decompressed on the way if its first two bytes say gzip.
///
/// # Errors
///
/// [`TextError::Io`] if the file cannot be opened.
pub fn open(path: &Path) -> Result<Box<dyn Read + Send>, TextError> {
    let failed = |e: io::Error| TextError::Io(e.to_string());
    let mut file = File::open(path).map_err(failed)?;
    let mut head = Vec::with_capacity(2);
    file.by_ref().take(2).read_to_end(&mut head).map_err(failed)?;
    let gzip = head == [0x1f, 0x8b];
    let whole = io::Cursor::new(head).chain(file);
    if gzip {
        // The decoder asks for small pieces; the file is read in large ones.
        let buffered = io::BufReader::with_capacity(1 << 16, whole);
        Ok(Box::new(MultiGzDecoder::new(buffered)))
    } else {
        Ok(Box::new(whole))
    }
}

/// Reads the wanted columns of a table.
///
/// Numbers are read to the nearest double, as Python's `float` does. Blank lines and comments between the rows are passed
/// over; spaces and double quotes around a number, a carriage return at the end of a line and a byte order mark at the
/// beginning of the file are let pass. Columns that are not wanted are counted and not looked into. Memory: the columns
/// and one piece of 1 MiB.
///
/// `wanted` and `exact` count from 0; `exact` is a column to be read as integers too, see [`Table::integers`].
///
/// # Errors
///
/// See [`TextError`]: the first line that is wrong.
///
/// # Panics
///
/// If a wanted column is not one of the dialect's, or is asked for twice.
pub fn read_columns(
    mut reader: impl Read,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    let mut rows = Rows::new(dialect, wanted, exact);
    let mut piece = vec![0_u8; PIECE];
    let mut filled = 0;
    loop {
        let got = match reader.read(&mut piece[filled..]) {
            Ok(got) => got,
            Err(e) => match e.kind() {
                ErrorKind::Interrupted => continue,
                ErrorKind::UnexpectedEof | ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                    return Err(TextError::Truncated { line: rows.line });
                }
                _ => return Err(TextError::Io(e.to_string())),
            },
        };
        if got == 0 {
            break;
        }
        let fresh = filled;
        filled += got;
        // Only the fresh bytes can hold the last line end of the piece.
        let Some(last) = memchr::memrchr(b'\n', &piece[fresh..filled]) else {
            if filled == piece.len() {
                return Err(TextError::TooLong { line: rows.line + 1 });
            }
            continue;
        };
        let whole = fresh + last + 1;
        let mut rest = &piece[..whole];
        while let Some(end) = memchr(b'\n', rest) {
            rows.line(&rest[..end])?;
            rest = &rest[end + 1..];
        }
        piece.copy_within(whole..filled, 0);
        filled -= whole;
    }
    if filled > 0 {
        rows.line(&piece[..filled])?;
    }
    rows.finish()
}

/// What is known while the lines go by.
struct Rows<'a> {
    dialect: &'a Dialect,
    /// For each column of the file, its place among the wanted ones.
    places: Vec<Option<usize>>,
    exact: Option<usize>,
    columns: Vec<Vec<f64>>,
    integers: Option<Vec<i64>>,
    done: usize,
    line: usize,
    first_line: usize,
}

/// What is wrong with a field, before it is known where.
enum Fault {
    NotANumber,
    NonFinite,
}

impl<'a> Rows<'a> {
    fn new(dialect: &'a Dialect, wanted: &[usize], exact: Option<usize>) -> Self {
        let mut places = vec![None; dialect.columns];
        for (place, &column) in wanted.iter().enumerate() {
            assert!(column < dialect.columns, "column {column} of {}", dialect.columns);
            assert!(places[column].is_none(), "column {column} is wanted twice");
            places[column] = Some(place);
        }
        Self {
            dialect,
            places,
            exact,
            columns: vec![Vec::new(); wanted.len()],
            integers: exact.map(|_| Vec::new()),
            done: 0,
            line: 0,
            first_line: 0,
        }
    }

    /// One line without its line feed.
    fn line(&mut self, mut line: &[u8]) -> Result<(), TextError> {
        self.line += 1;
        if self.line <= self.dialect.skip_lines {
            return Ok(());
        }
        if self.line == 1 {
            line = line.strip_prefix(BOM).unwrap_or(line);
        }
        let trimmed = match self.dialect.delimiter {
            // Tabs are fields here, and an empty one must not be lost.
            Delimiter::Byte(b'\t') => trim_with(line, |b| b == b' ' || b == b'\r'),
            _ => trim(line),
        };
        let is_comment = |prefix: &Vec<u8>| trimmed.starts_with(prefix);
        if trimmed.is_empty() || self.dialect.comment.iter().any(is_comment) {
            return Ok(());
        }
        if self.done == 0 {
            self.first_line = self.line;
        }
        let fields = match self.dialect.delimiter {
            Delimiter::Byte(byte) => self.delimited(trimmed, byte),
            Delimiter::Whitespace => self.spaced(trimmed),
        };
        let got = match fields {
            Ok(got) => got,
            // A line that is no row at all is best told as such.
            Err(fault) => match count(trimmed, self.dialect.delimiter, self.dialect.columns) {
                got if got != self.dialect.columns => got,
                _ => return Err(fault),
            },
        };
        if got != self.dialect.columns {
            let expected = self.dialect.columns;
            return Err(TextError::Ragged { line: self.line, row: self.done, got, expected });
        }
        self.done += 1;
        Ok(())
    }

    /// Takes the numbers out of a line whose fields one byte parts; the number of fields.
    fn delimited(&mut self, line: &[u8], byte: u8) -> Result<usize, TextError> {
        let mut start = 0;
        for column in 0..self.dialect.columns {
            let end = match self.places[column] {
                Some(place) => self.number(line, start, byte, column, place)?,
                None => field_end(line, start, byte),
            };
            if self.exact == Some(column) {
                self.integer(bare(&line[start..end]));
            }
            if end == line.len() {
                return Ok(column + 1);
            }
            start = end + 1;
        }
        Ok(count(line, Delimiter::Byte(byte), self.dialect.columns))
    }

    /// The same for a line whose fields are parted by runs of spaces and tabs.
    fn spaced(&mut self, line: &[u8]) -> Result<usize, TextError> {
        let mut fields = 0;
        let mut start = 0;
        while start < line.len() {
            let column = fields;
            let len = line[start..].iter().position(|&b| is_space(b));
            let end = len.map_or(line.len(), |len| start + len);
            fields += 1;
            if let Some(&place) = self.places.get(column) {
                let field = &line[start..end];
                if let Some(place) = place {
                    let value = number(field).map_err(|fault| self.fault(&fault, column, field))?;
                    self.columns[place].push(value);
                }
                if self.exact == Some(column) {
                    self.integer(bare(field));
                }
            }
            start = end + line[end..].iter().take_while(|&&b| is_space(b)).count();
        }
        Ok(fields)
    }

    /// Reads the number that begins at `start`; where its field ends.
    fn number(
        &mut self,
        line: &[u8],
        start: usize,
        byte: u8,
        column: usize,
        place: usize,
    ) -> Result<usize, TextError> {
        // Nearly every field is a bare number up to the delimiter.
        if let Ok((value, len)) = fast_float2::parse_partial::<f64, _>(&line[start..]) {
            let end = start + len;
            if value.is_finite() && (end == line.len() || line[end] == byte) {
                self.columns[place].push(value);
                return Ok(end);
            }
        }
        let end = field_end(line, start, byte);
        let field = &line[start..end];
        let value = number(field).map_err(|fault| self.fault(&fault, column, field))?;
        self.columns[place].push(value);
        Ok(end)
    }

    /// Reads a field as an integer, and gives the exact column up at the first one that is none.
    fn integer(&mut self, field: &[u8]) {
        if let Some(integers) = &mut self.integers {
            match std::str::from_utf8(field).ok().and_then(|text| text.parse().ok()) {
                Some(value) => integers.push(value),
                None => self.integers = None,
            }
        }
    }

    fn fault(&self, fault: &Fault, column: usize, field: &[u8]) -> TextError {
        let (line, row) = (self.line, self.done);
        let text = String::from_utf8_lossy(trim(field)).chars().take(QUOTED).collect();
        match fault {
            Fault::NotANumber => TextError::NotANumber { line, row, column, text },
            Fault::NonFinite => TextError::NonFinite { line, row, column, text },
        }
    }

    fn finish(self) -> Result<Table, TextError> {
        if self.done == 0 {
            return Err(TextError::Empty);
        }
        Ok(Table {
            columns: self.columns,
            integers: self.integers,
            rows: self.done,
            first_line: self.first_line,
        })
    }
}

/// The finite number that a field holds.
fn number(field: &[u8]) -> Result<f64, Fault> {
    let field = bare(field);
    match fast_float2::parse::<f64, _>(field) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Fault::NonFinite),
        Err(_) if MISSING.contains(&field.to_ascii_lowercase().as_slice()) => Err(Fault::NonFinite),
        Err(_) => Err(Fault::NotANumber),
    }
}

/// A field without the spaces and the pair of double quotes around it.
fn bare(field: &[u8]) -> &[u8] {
    let field = trim(field);
    match field {
        [b'"', inner @ .., b'"'] => trim(inner),
        _ => field,
    }
}

/// Where the field that begins at `start` ends; a delimiter within double quotes is part of the field.
fn field_end(line: &[u8], start: usize, byte: u8) -> usize {
    let field = &line[start..];
    let lead = field.iter().take_while(|&&b| b == b' ').count();
    let quoted = match field.get(lead) {
        Some(b'"') => memchr(b'"', &field[lead + 1..]).map_or(0, |close| lead + 1 + close),
        _ => 0,
    };
    memchr(byte, &field[quoted..]).map_or(line.len(), |len| start + quoted + len)
}

/// Fields of a line; one empty field after the last of `expected` is not counted.
fn count(line: &[u8], delimiter: Delimiter, expected: usize) -> usize {
    match delimiter {
        Delimiter::Whitespace => line.split(|&b| is_space(b)).filter(|field| !field.is_empty()).count(),
        Delimiter::Byte(byte) => {
            let (mut fields, mut start) = (0, 0);
            loop {
                if fields == expected && trim(&line[start.min(line.len())..]).is_empty() {
                    return fields;
                }
                let end = field_end(line, start, byte);
                fields += 1;
                if end == line.len() {
                    return fields;
                }
                start = end + 1;
            }
        }
    }
}

fn is_space(b: u8) -> bool {
    b == b' ' || b == b'\t' || b == b'\r'
}

fn trim(bytes: &[u8]) -> &[u8] {
    trim_with(bytes, is_space)
}

fn trim_with(bytes: &[u8], space: impl Fn(u8) -> bool) -> &[u8] {
    let start = bytes.iter().take_while(|&&b| space(b)).count();
    let end = bytes.iter().rev().take_while(|&&b| space(b)).count();
    if start == bytes.len() { &[] } else { &bytes[start..bytes.len() - end] }
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
