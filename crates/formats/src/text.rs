//! Text tables: numbers in columns, read in pieces, every line held to the same number of fields.
//!
//! Nothing is guessed and nothing is mended. A short line or a word among the numbers ends the reading with an error that
//! names the line, because a table that is read wrongly costs more than one that is refused. An empty field, or one that
//! says NaN or an infinity, is a missing number, and is read as NaN.

use std::io::{ErrorKind, Read};
use std::path::Path;

use memchr::memrchr;

use crate::pieces::{self, Sizes};
use crate::rows::Layout;
use crate::source::{large_and_plain, open};
use crate::table::{Dialect, Table, TextError};

/// The longest line that is accepted, and the size of the pieces of a stream. \[bytes\]
pub(crate) const LONGEST: usize = 1 << 20;

/// Size of the pieces of a file that is read on several threads: text and numbers stay in the cache of a core. \[bytes\]
const PIECE: usize = 1 << 18;

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
    if let Some(file) = large_and_plain(path, 4 * PIECE as u64)? {
        let threads = rayon::current_num_threads().min((file.length / PIECE as u64) as usize);
        if threads > 1 {
            return pieces::read(&file, &layout, Sizes { piece: PIECE, longest: LONGEST }, threads);
        }
    }
    read_stream(open(path, dialect.most)?, &layout, LONGEST)
}

/// Reads a stream in pieces as long as the longest line.
pub(crate) fn read_stream(
    mut reader: impl Read,
    layout: &Layout<'_>,
    longest: usize,
) -> Result<Table, TextError> {
    let mut rows = layout.rows(true);
    let mut piece = vec![0_u8; longest];
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
                ErrorKind::FileTooLarge => return Err(TextError::TooLarge { most: layout.dialect.most }),
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
