//! A table of numbers: its layout, the result of reading it, and reasons to refuse it.

use crate::date::Order;
use crate::remarks::Remarks;

/// What stands between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// One byte: comma, semicolon, tab. Two in a row enclose an empty field.
    Byte(u8),
    /// Any run of spaces and tabs; leading and trailing ones do not count.
    Whitespace,
}

/// Layout of a table.
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
    /// How dates and times of the exact column are read, see [`crate::date::stamp`]; nothing if it holds numbers.
    pub dates: Option<Order>,
    /// Whether a time and an arrow stand before each row, `15:00:00.010 -> 0.1,0.2`: that time is the last column.
    pub arrow: bool,
    /// Bytes that a compressed file may have.
    pub most: u64,
    /// The kind of row that is read, where a file has several; lines of other kinds are passed over.
    pub tag: Option<Tag>,
}

/// A field that names the kind of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// Column of the field, counted from 0.
    pub column: usize,
    /// What it says, without spaces and quotes around it.
    pub text: Vec<u8>,
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
    /// A compressed file of more bytes than are allowed.
    #[error("more than {most} bytes")]
    TooLarge {
        /// Bytes that are allowed.
        most: u64,
    },
    /// There is no memory for the numbers.
    #[error("no memory for {rows} rows")]
    Memory {
        /// Rows that were to be kept.
        rows: usize,
    },
    /// The system could not read.
    #[error("{0}")]
    Io(String),
    /// No row of data.
    #[error("no row of data")]
    Empty,
}

impl TextError {
    /// The same problem, moved down by a number of lines and rows.
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
