//! Lines between the rows that begin with the mark of a comment. Most are remarks, but one flipped bit turns a row into a
//! comment, and if one file contains several logs, their headers may be comments too.

/// Largest number of headers that are kept.
const MAX_HEADERS: usize = 16;

/// Number of characters of a header that are kept.
const MAX_HEADER: usize = 2000;

/// Comments after the first row of data. Lines count from 1.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Remarks {
    /// Number of lines with as many fields as a row, at least half of them numbers.
    pub rows: usize,
    /// The first such line, or 0.
    pub first_row: usize,
    /// Line and text of the first lines with as many fields as a row and no number in them.
    pub headers: Vec<(usize, String)>,
}

impl Remarks {
    /// Counts a comment with this number of fields, and of numbers among them.
    pub(crate) fn add(&mut self, line: usize, text: &[u8], fields: usize, numbers: usize, columns: usize) {
        if fields == columns && 2 * (numbers + 1) >= columns && (numbers > 0 || columns == 1) {
            self.first_row = if self.rows == 0 { line } else { self.first_row };
            self.rows += 1;
        } else if fields == columns && numbers == 0 && self.headers.len() < MAX_HEADERS {
            let text = String::from_utf8_lossy(text).chars().take(MAX_HEADER).collect();
            self.headers.push((line, text));
        }
    }

    /// Adds the remarks of the following lines; their numbers are shifted.
    pub(crate) fn append(&mut self, next: &Self, lines: usize) {
        if self.rows == 0 && next.rows > 0 {
            self.first_row = lines + next.first_row;
        }
        self.rows += next.rows;
        let room = MAX_HEADERS - self.headers.len();
        self.headers.extend(next.headers.iter().take(room).map(|(line, text)| (lines + line, text.clone())));
    }
}
