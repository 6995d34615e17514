//! A table of numbers: its layout, the result of reading it, and reasons to refuse it.

use crate::date::Order;
use crate::remarks::Remarks;

/// Separator of two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// One byte: comma, semicolon, tab. Two adjacent ones enclose an empty field.
    Byte(u8),
    /// Any run of spaces and tabs; leading and trailing ones do not count.
    Whitespace,
}

/// Layout of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dialect {
    /// Separator of two fields.
    pub delimiter: Delimiter,
    /// A line that begins with one of these, after spaces, is a comment.
    pub comment: Vec<Vec<u8>>,
    /// Number of lines before the data, including blank ones, comments and the header.
    pub skip_lines: usize,
    /// Number of fields of every line of data. One empty field after a trailing delimiter is allowed.
    pub columns: usize,
    /// Order of dates in the exact column, see [`crate::date::stamp`]; None if it contains numbers.
    pub dates: Option<Order>,
    /// Whether each row begins with a time and an arrow, `15:00:00.010 -> 0.1,0.2`. The time becomes the last column.
    pub arrow: bool,
    /// Largest decompressed size of a file. \[bytes\]
    pub most: u64,
    /// Tag of the rows to be read, if a file has several kinds; other lines are skipped.
    pub tag: Option<Tag>,
}

/// A field that marks the kind of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// Column of the field, counted from 0.
    pub column: usize,
    /// Its text, without surrounding spaces and quotes.
    pub text: Vec<u8>,
}

/// Columns of numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// The wanted columns in the order of the request; finite or NaN, with equal lengths.
    pub columns: Vec<Vec<f64>>,
    /// The exact column, if each of its values is an integer that fits or is missing; a missing one is the smallest `i64`.
    /// Time stamps in nanoseconds since 1970 need it: as `f64` they are exact only to 256 ns.
    pub integers: Option<Vec<i64>>,
    /// Number of rows of data.
    pub rows: usize,
    /// Line of the first row, counted from 1.
    pub first_line: usize,
    /// Comments between the rows.
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
        /// Number of fields in the line.
        got: usize,
        /// Expected number of fields.
        expected: usize,
    },
    /// A field that is not a number.
    #[error("line {line}, column {column}: {text:?} is not a number")]
    NotANumber {
        /// Line of the file.
        line: usize,
        /// Row of data.
        row: usize,
        /// Column of the file.
        column: usize,
        /// The field, up to 40 characters.
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
    /// A compressed file that is damaged; the data before the fault may be wrong too.
    #[error("the compressed data are damaged before or after line {line}")]
    Damaged {
        /// Last line that was read whole.
        line: usize,
    },
    /// A compressed file with more bytes than allowed.
    #[error("more than {most} bytes")]
    TooLarge {
        /// Allowed number of bytes.
        most: u64,
    },
    /// Not enough memory for the numbers.
    #[error("no memory for {rows} rows")]
    Memory {
        /// Number of rows that did not fit.
        rows: usize,
    },
    /// The system failed to read.
    #[error("{0}")]
    Io(String),
    /// No row of data.
    #[error("no row of data")]
    Empty,
}

impl TextError {
    /// The error with its line and row increased by a number of lines and rows.
    pub(crate) fn moved(mut self, lines: usize, rows: usize) -> Self {
        match &mut self {
            Self::Ragged { line, row, .. } | Self::NotANumber { line, row, .. } => {
                *line += lines;
                *row += rows;
            }
            Self::TooLong { line } | Self::Truncated { line } | Self::Damaged { line } => *line += lines,
            Self::Memory { rows: all } => *all += rows,
            Self::TooLarge { .. } | Self::Io(_) | Self::Empty => {}
        }
        self
    }
}
