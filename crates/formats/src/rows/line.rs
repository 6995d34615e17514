//! Reading of one line in any accepted form; the line must match the layout.

use memchr::memmem;

use super::field::{LONG_FIELD, bare, count, field_end, is_missing, is_space, number, trim, trim_with};
use super::layout::Layout;
use super::store::Rows;
use crate::date;
use crate::table::{Delimiter, TextError};

/// Number of characters of a field that an error quotes.
const QUOTED_LENGTH: usize = 40;

/// Value of a missing integer, as `NaT` in NumPy.
pub(super) const NO_INTEGER: i64 = i64::MIN;

pub(super) const BOM: &[u8] = b"\xef\xbb\xbf";

impl Layout<'_> {
    /// Reads one line without its line feed.
    pub(super) fn line(&self, mut line: &[u8], rows: &mut Rows) -> Result<(), TextError> {
        rows.lines += 1;
        if rows.skip > 0 {
            rows.skip -= 1;
            return Ok(());
        }
        if rows.at_start && rows.lines == 1 {
            line = line.strip_prefix(BOM).unwrap_or(line);
        }
        let trimmed = match self.dialect.delimiter {
            // Tabs delimit fields here, and an empty field at the end must not be lost.
            Delimiter::Byte(b'\t') => trim_with(line, |b| b == b' ' || b == b'\r'),
            _ => trim(line),
        };
        let (stamp, trimmed) = if self.dialect.arrow { split_arrow(trimmed) } else { (None, trimmed) };
        if trimmed.is_empty() {
            return Ok(());
        }
        if self.dialect.comment.iter().any(|prefix| trimmed.starts_with(prefix)) {
            self.remark(trimmed, rows);
            return Ok(());
        }
        if rows.done == 0 {
            rows.first_line = rows.lines;
        }
        let fields = match self.dialect.delimiter {
            Delimiter::Byte(byte) => self.delimited(trimmed, byte, rows),
            Delimiter::Whitespace => self.spaced(trimmed, rows),
        };
        let got = match fields {
            Ok(got) => got,
            // An error about the number of fields is clearer than one about a field.
            Err(fault) => match count(trimmed, self.dialect.delimiter, self.fields()) {
                got if got != self.fields() => got,
                _ => return Err(fault),
            },
        };
        let (got, expected) = match stamp {
            Some(stamp) if got == self.fields() => (got + self.stamp(stamp, rows)?, self.dialect.columns),
            Some(_) => (got, self.fields()),
            None if self.dialect.arrow => (got, got + 1),
            None => (got, self.dialect.columns),
        };
        if got != expected {
            return Err(TextError::Ragged { line: rows.lines, row: rows.done, got, expected });
        }
        rows.done += 1;
        Ok(())
    }

    /// Fields of a row, without the time before an arrow.
    fn fields(&self) -> usize {
        self.dialect.columns - usize::from(self.dialect.arrow)
    }

    /// Reads the time before an arrow, as the last column; returns the number of fields, 1.
    fn stamp(&self, stamp: &[u8], rows: &mut Rows) -> Result<usize, TextError> {
        let column = self.fields();
        if let (true, Some(order)) = (self.exact == Some(column), self.dialect.dates) {
            rows.date(stamp, column, self.places[column], order)?;
        } else if let Some(place) = self.places[column] {
            rows.columns[place].push(f64::NAN); // A time of day is not a number.
        }
        Ok(1)
    }

    /// Counts a line that begins with the mark of a comment.
    fn remark(&self, line: &[u8], rows: &mut Rows) {
        let columns = self.fields();
        let fields = count(line, self.dialect.delimiter, columns);
        let (mut numbers, mut start) = (0, 0);
        while fields == columns && start < line.len() {
            let end = match self.dialect.delimiter {
                Delimiter::Byte(byte) => field_end(line, start, byte),
                Delimiter::Whitespace => {
                    line[start..].iter().position(|&b| is_space(b)).map_or(line.len(), |len| start + len)
                }
            };
            numbers += usize::from(number(&line[start..end]).is_ok());
            start = end + 1;
        }
        rows.remarks.add(rows.lines, line, fields, numbers, columns);
    }

    /// Reads the numbers of a line whose fields are separated by one byte; returns the number of fields.
    fn delimited(&self, line: &[u8], byte: u8, rows: &mut Rows) -> Result<usize, TextError> {
        let mut start = 0;
        for column in 0..self.fields() {
            let end = if let (true, Some(order)) = (self.exact == Some(column), self.dialect.dates) {
                let end = field_end(line, start, byte);
                rows.date(&line[start..end], column, self.places[column], order)?;
                end
            } else if let Some(place) = self.places[column] {
                rows.number(line, start, byte, column, place)?
            } else {
                let end = field_end(line, start, byte);
                rows.check_text(column, &line[start..end])?;
                end
            };
            if self.exact == Some(column) && self.dialect.dates.is_none() {
                rows.integer(bare(&line[start..end]));
            }
            if end == line.len() {
                return Ok(column + 1);
            }
            start = end + 1;
        }
        Ok(count(line, Delimiter::Byte(byte), self.fields()))
    }

    /// Reads the numbers of a line whose fields are separated by runs of spaces and tabs; returns the number of fields.
    fn spaced(&self, line: &[u8], rows: &mut Rows) -> Result<usize, TextError> {
        let mut fields = 0;
        let mut start = 0;
        while start < line.len() {
            let column = fields;
            let len = line[start..].iter().position(|&b| is_space(b));
            let end = len.map_or(line.len(), |len| start + len);
            fields += 1;
            if let Some(&place) = self.places[..self.fields()].get(column) {
                let field = &line[start..end];
                if let (true, Some(order)) = (self.exact == Some(column), self.dialect.dates) {
                    rows.date(field, column, place, order)?;
                } else if let Some(place) = place {
                    let value = number(field).map_err(|_| rows.fault(column, field))?;
                    rows.columns[place].push(value);
                } else {
                    rows.check_text(column, field)?;
                }
                if self.exact == Some(column) && self.dialect.dates.is_none() {
                    rows.integer(bare(field));
                }
            }
            start = end + line[end..].iter().take_while(|&&b| is_space(b)).count();
        }
        Ok(fields)
    }
}

/// The time before an arrow, if there is one, and the rest of a line.
fn split_arrow(line: &[u8]) -> (Option<&[u8]>, &[u8]) {
    match memmem::find(line, b"->") {
        Some(arrow) => (Some(trim(&line[..arrow])), trim(&line[arrow + 2..])),
        None => (None, line),
    }
}

impl Rows {
    /// Reads the number that begins at `start`; returns the end of its field.
    fn number(
        &mut self,
        line: &[u8],
        start: usize,
        byte: u8,
        column: usize,
        place: usize,
    ) -> Result<usize, TextError> {
        // Usually the field is a number without quotes or spaces.
        if let Ok((value, len)) = fast_float2::parse_partial::<f64, _>(&line[start..]) {
            let end = start + len;
            if value.is_finite() && (end == line.len() || line[end] == byte) {
                self.columns[place].push(value);
                return Ok(end);
            }
        }
        let end = field_end(line, start, byte);
        let field = &line[start..end];
        let value = number(field).map_err(|_| self.fault(column, field))?;
        self.columns[place].push(value);
        Ok(end)
    }

    /// Reads a field as an integer; at the first value that is not an integer, the exact column is dropped. A missing
    /// value is [`NO_INTEGER`], so that an empty field does not cost the column, and with it the last digits of the
    /// values.
    fn integer(&mut self, field: &[u8]) {
        if let Some(integers) = &mut self.integers {
            match std::str::from_utf8(field).ok().and_then(|text| text.parse().ok()) {
                Some(NO_INTEGER) => self.integers = None,
                Some(value) => integers.push(value),
                None if is_missing(field) => integers.push(NO_INTEGER),
                None => self.integers = None,
            }
        }
    }

    /// Reads a field as a date or a time of day, in nanoseconds; a missing value is [`NO_INTEGER`].
    fn date(
        &mut self,
        field: &[u8],
        column: usize,
        place: Option<usize>,
        order: date::Order,
    ) -> Result<(), TextError> {
        let text = bare(field);
        let stamp = match date::stamp(text, order) {
            Some(stamp) => Some(stamp.nanos),
            None if is_missing(text) => None,
            None => return Err(self.fault(column, field)),
        };
        if let Some(place) = place {
            self.columns[place].push(stamp.map_or(f64::NAN, |nanos| nanos as f64));
        }
        if let Some(integers) = &mut self.integers {
            integers.push(stamp.unwrap_or(NO_INTEGER));
        }
        Ok(())
    }

    /// Refuses a long field that is not text.
    fn check_text(&self, column: usize, field: &[u8]) -> Result<(), TextError> {
        let text = field.len() <= LONG_FIELD
            || (std::str::from_utf8(field).is_ok() && !field.iter().any(|&b| b < b' ' && b != b'\t'));
        if text { Ok(()) } else { Err(self.fault(column, field)) }
    }

    fn fault(&self, column: usize, field: &[u8]) -> TextError {
        let (line, row) = (self.lines, self.done);
        let text = String::from_utf8_lossy(trim(field)).chars().take(QUOTED_LENGTH).collect();
        TextError::NotANumber { line, row, column, text }
    }
}
