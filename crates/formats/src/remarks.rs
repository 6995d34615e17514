//! Lines among the rows that begin with the mark of a comment: most are remarks, but one flipped bit makes one of a row,
//! and the header of the next of several logs in one file may stand behind a mark as well.

/// Headers that are kept.
const MAX_HEADERS: usize = 16;

/// Characters of a header that are kept.
const QUOTED: usize = 2000;

/// What was passed over after the first row of data. Lines count from 1.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Remarks {
    /// Lines with as many fields as a row, of which at least half are numbers.
    pub rows: usize,
    /// The first of those, or 0.
    pub first_row: usize,
    /// Line and text of the first lines with as many fields as a row and no number in them.
    pub headers: Vec<(usize, String)>,
}

impl Remarks {
    /// Counts a comment that has so many fields more or fewer than a row, and so many numbers among them.
    pub(crate) fn add(&mut self, line: usize, text: &[u8], fields: usize, numbers: usize, columns: usize) {
        if fields == columns && 2 * (numbers + 1) >= columns && (numbers > 0 || columns == 1) {
            self.first_row = if self.rows == 0 { line } else { self.first_row };
            self.rows += 1;
        } else if fields == columns && numbers == 0 && self.headers.len() < MAX_HEADERS {
            let text = String::from_utf8_lossy(text).chars().take(QUOTED).collect();
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
