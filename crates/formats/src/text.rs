//! Text tables: numbers in columns, read in pieces, every line held to the same number of fields.
//!
//! Nothing is guessed and nothing is mended. A short line, a word among the numbers or an infinity ends the reading with an
//! error that names the line, because a table that is read wrongly costs more than one that is refused. An empty field, or
//! one that says NaN, is a missing number, and is read as NaN.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use memchr::memrchr;

use crate::number::PAD;
use crate::pieces::{self, Sizes};
use crate::progress::Counted;
use crate::remarks::Remarks;
use crate::rows::Layout;

/// The longest line that is accepted, and the size of the pieces of a stream. \[bytes\]
pub(crate) const LONGEST: usize = 1 << 20;

/// Size of the pieces of a file that is read on several threads: text and numbers stay in the cache of a core. \[bytes\]
const PIECE: usize = 1 << 18;

/// First bytes of a compressed file.
pub(crate) const GZIP: [u8; 2] = [0x1f, 0x8b];

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
    /// Whether the exact column holds dates, see [`crate::date::nanoseconds`].
    pub dates: bool,
}

/// Columns of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The wanted columns, in the order in which they were asked for; finite or NaN, all of the same length.
    pub columns: Vec<Vec<f64>>,
    /// The exact column, if every one of its values is written as an integer that fits, or missing: then it is the least
    /// `i64`. Time stamps in nanoseconds since 1970 need it: as `f64` they are only good to 256 ns.
    pub integers: Option<Vec<i64>>,
    /// Rows of data.
    pub rows: usize,
    /// Line of the first row, counted from 1.
    pub first_line: usize,
    /// Comments among the rows.
    pub remarks: Remarks,
    /// Whether the last line has no line end.
    pub open_end: bool,
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
    /// A field that stands for no finite number: an infinity, or a number beyond the largest double.
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
    /// A compressed file that ends in the middle.
    #[error("the compressed data break off after line {line}")]
    Truncated {
        /// Last line that was read whole.
        line: usize,
    },
    /// A compressed file that is damaged: what was decompressed before that shows may be wrong as well.
    #[error("the compressed data are damaged before or after line {line}")]
    Damaged {
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

impl TextError {
    /// The same so many lines and rows further down.
    pub(crate) fn moved(mut self, lines: usize, rows: usize) -> Self {
        match &mut self {
            Self::Ragged { line, row, .. }
            | Self::NotANumber { line, row, .. }
            | Self::NonFinite { line, row, .. } => {
                *line += lines;
                *row += rows;
            }
            Self::TooLong { line } | Self::Truncated { line } | Self::Damaged { line } => *line += lines,
            Self::Io(_) | Self::Empty => {}
        }
        self
    }
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
    let gzip = head == GZIP;
    let whole = io::Cursor::new(head).chain(Counted(file));
    if gzip {
        // The decoder asks for small pieces; the file is read in large ones.
        let buffered = io::BufReader::with_capacity(1 << 16, whole);
        Ok(Box::new(MultiGzDecoder::new(buffered)))
    } else {
        Ok(Box::new(whole))
    }
}

/// Reads the wanted columns of a table from a stream.
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
    reader: impl Read,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    let layout = Layout::new(dialect, wanted, exact);
    read_stream(reader, &layout, LONGEST)
}

/// Reads the wanted columns of a table from a file, see [`read_columns`].
///
/// A large file that is not compressed is read in pieces, on as many threads as the current rayon pool has. The table, or
/// the error, is the same for any number of threads. Memory: the columns and about 2 MiB a thread.
///
/// # Errors
///
/// See [`TextError`]: the first line that is wrong.
///
/// # Panics
///
/// As [`read_columns`].
pub fn read_file(
    path: &Path,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    let layout = Layout::new(dialect, wanted, exact);
    if let Some(file) = pieces::large_and_plain(path, 4 * PIECE as u64)? {
        let threads = rayon::current_num_threads().min((file.length / PIECE as u64) as usize);
        if threads > 1 {
            return pieces::read(&file, &layout, Sizes { piece: PIECE, longest: LONGEST }, threads);
        }
    }
    read_stream(open(path)?, &layout, LONGEST)
}

/// Reads a stream in pieces as long as the longest line.
pub(crate) fn read_stream(
    mut reader: impl Read,
    layout: &Layout<'_>,
    longest: usize,
) -> Result<Table, TextError> {
    let mut rows = layout.rows(true);
    let mut piece = vec![0_u8; longest + PAD];
    let mut filled = 0;
    loop {
        let got = match reader.read(&mut piece[filled..longest]) {
            Ok(got) => got,
            Err(e) => match e.kind() {
                ErrorKind::Interrupted => continue,
                ErrorKind::UnexpectedEof => return Err(TextError::Truncated { line: rows.lines }),
                ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                    return Err(TextError::Damaged { line: rows.lines });
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
        let Some(last) = memrchr(b'\n', &piece[fresh..filled]) else {
            if filled == longest {
                return Err(TextError::TooLong { line: rows.lines + 1 });
            }
            continue;
        };
        let whole = fresh + last + 1;
        layout.read(&piece, whole, &mut rows)?;
        piece.copy_within(whole..filled, 0);
        filled -= whole;
    }
    layout.read(&piece, filled, &mut rows)?;
    let table = rows.finish()?;
    Ok(Table { open_end: filled > 0, ..table })
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
