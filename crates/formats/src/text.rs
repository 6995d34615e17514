//! Text tables of numbers, read in pieces; every line must have the same number of fields.
//!
//! Nothing is guessed or repaired. A short line or a word between the numbers is an error that names the line, because a
//! wrong table costs more than a refused one. An empty field, NaN or an infinity is a missing number and is read as NaN.

use std::io::{self, ErrorKind, Read};
use std::path::Path;

use memchr::memrchr;
use rayon::prelude::*;

use crate::rows::{Layout, Rows};
use crate::source::open;
use crate::table::{Dialect, Table, TextError};

/// Longest accepted line, and size of the pieces of a stream. \[bytes\]
pub(crate) const MAX_LINE: usize = 1 << 20;

/// Smallest part of a piece that is worth a separate thread. \[bytes\]
const MIN_PART: usize = 1 << 16;

/// Reads the wanted columns of a table from a stream.
///
/// Numbers are read to the nearest double, as Python's `float` does. Blank lines and comments between the rows are skipped.
/// Spaces and double quotes around a number, a carriage return at the end of a line and a byte order mark at the start of
/// the file are allowed. Columns that are not wanted are only counted. The memory is that of the columns and one piece of 1
/// MiB.
///
/// `wanted` and `exact` count from 0; `exact` is a column that is also read as integers, see [`Table::integers`].
///
/// # Errors
///
/// See [`TextError`]: the first line that is wrong.
///
/// # Panics
///
/// If a wanted column is not in the dialect, or is wanted twice.
pub fn read_columns(
    reader: impl Read,
    dialect: &Dialect,
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<Table, TextError> {
    let layout = Layout::new(dialect, wanted, exact);
    read_stream(reader, &layout, MAX_LINE, MIN_PART)
}

/// Reads the wanted columns of a table from a file, see [`read_columns`].
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
    read_columns(open(path, dialect.most)?, dialect, wanted, exact)
}

/// Reads a stream in pieces of the longest accepted line; several threads read the parts of a piece.
pub(crate) fn read_stream(
    mut reader: impl Read,
    layout: &Layout<'_>,
    longest: usize,
    part: usize,
) -> Result<Table, TextError> {
    let mut rows = layout.rows(true);
    let mut parts = Vec::new();
    let mut piece = vec![0_u8; longest];
    let mut filled = 0;
    loop {
        let read = fill(&mut reader, &mut piece, &mut filled);
        let whole = memrchr(b'\n', &piece[..filled]).map_or(0, |last| last + 1);
        read_parts(layout, &piece[..whole], part, &mut rows, &mut parts)?;
        piece.copy_within(whole..filled, 0);
        filled -= whole;
        match read {
            Ok(true) if filled == longest => return Err(TextError::TooLong { line: rows.lines + 1 }),
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                return Err(match error.kind() {
                    ErrorKind::UnexpectedEof => TextError::Truncated { line: rows.lines },
                    ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                        TextError::Damaged { line: rows.lines }
                    }
                    ErrorKind::FileTooLarge => TextError::TooLarge { most: layout.dialect.most },
                    _ => TextError::Io(error.to_string()),
                });
            }
        }
    }
    layout.read(&piece[..filled], &mut rows)?;
    let table = rows.finish()?;
    Ok(Table { open_end: filled > 0, ..table })
}

/// Fills the piece; false if the stream ends first.
fn fill(reader: &mut impl Read, piece: &mut [u8], filled: &mut usize) -> io::Result<bool> {
    while *filled < piece.len() {
        match reader.read(&mut piece[*filled..]) {
            Ok(0) => return Ok(false),
            Ok(got) => *filled += got,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(true)
}

/// Reads whole lines into `rows`, in parts of at least `least` bytes on all threads of the current pool; `parts` keeps
/// their memory. The rows and the first error do not depend on the number of threads.
fn read_parts(
    layout: &Layout<'_>,
    text: &[u8],
    least: usize,
    rows: &mut Rows,
    parts: &mut Vec<Rows>,
) -> Result<(), TextError> {
    let count = rayon::current_num_threads().min(text.len() / least);
    // The first piece contains the skipped lines, and may begin with a byte order mark.
    if count < 2 || rows.skip > 0 || rows.lines == 0 {
        return layout.read(text, rows);
    }
    let mut borders = vec![0];
    for k in 1..count {
        let lines = &text[..k * text.len() / count];
        borders.push(memrchr(b'\n', lines).map_or(0, |end| end + 1).max(borders[k - 1]));
    }
    borders.push(text.len());
    parts.resize_with(count - 1, || layout.rows(false));
    let first = std::iter::once(&mut *rows).chain(parts.iter_mut());
    let lines = borders.windows(2).map(|pair| &text[pair[0]..pair[1]]);
    let jobs: Vec<_> = first.zip(lines).collect();
    let done: Vec<_> = jobs.into_par_iter().map(|(rows, lines)| layout.read(lines, rows)).collect();
    let mut done = done.into_iter();
    done.next().unwrap_or(Ok(()))?;
    for (read, part) in done.zip(parts) {
        read.map_err(|error| rows.moved(error))?;
        rows.append(part)?;
        layout.clear(part);
    }
    Ok(())
}

#[cfg(test)]
#[path = "text_tests.rs"]
mod tests;
