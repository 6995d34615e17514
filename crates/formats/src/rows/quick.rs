//! The quick way: reads a row of bare numbers without looking for the end of the line first.

// A call costs as much as the work of one of these, which is done for every number.
#![allow(clippy::inline_always)]

use memchr::memchr3;

use super::decimal;
use super::field::LONG;
use super::layout::Layout;
use super::line::NO_INTEGER;
use super::store::Rows;
use crate::table::Delimiter;

impl Layout<'_> {
    /// Takes a row of bare numbers that begins at `start`; where the next line begins.
    ///
    /// Nothing if there is anything else in the line, its end included: then no row has been taken, and `line` has the
    /// last word. What is taken here, `line` would take the same.
    #[inline]
    pub(super) fn quick_row(&self, text: &[u8], start: usize, rows: &mut Rows) -> Option<usize> {
        let next = match self.dialect.delimiter {
            Delimiter::Byte(byte) => self.quick_fields(text, start, byte, rows),
            Delimiter::Whitespace => self.quick_words(text, start, rows),
        };
        if next.is_some() {
            rows.lines += 1;
            if rows.done == 0 {
                rows.first_line = rows.lines;
            }
            rows.done += 1;
        } else {
            rows.columns.iter_mut().for_each(|column| column.truncate(rows.done));
            if let Some(integers) = &mut rows.integers {
                integers.truncate(rows.done);
            }
        }
        next
    }

    #[inline(always)]
    fn quick_fields(&self, text: &[u8], start: usize, byte: u8, rows: &mut Rows) -> Option<usize> {
        let mut at = start;
        let last = self.places.len().checked_sub(1)?;
        for (column, &place) in self.places.iter().enumerate() {
            at = match place {
                Some(place) => {
                    let spaces = text[at..].iter().take_while(|&&b| b == b' ').count();
                    self.quick_number(text, at + spaces, column, place, rows)?
                }
                None if column == 0 && !self.begins_plainly(text[at]) => return None,
                None => {
                    at + memchr3(byte, b'\n', b'"', &text[at..])
                        .filter(|&length| text[at + length] != b'"' && length <= LONG)?
                }
            };
            if column < last {
                if text[at] != byte {
                    return None;
                }
                at += 1;
            }
        }
        at += usize::from(text[at] == byte);
        line_end(text, at)
    }

    #[inline(always)]
    fn quick_words(&self, text: &[u8], start: usize, rows: &mut Rows) -> Option<usize> {
        let blank = |at: usize| text[at..].iter().take_while(|&&b| b == b' ' || b == b'\t').count();
        let mut at = start + blank(start);
        for (column, &place) in self.places.iter().enumerate() {
            if column > 0 {
                let spaces = blank(at);
                if spaces == 0 {
                    return None;
                }
                at += spaces;
            }
            at = match place {
                Some(place) => self.quick_number(text, at, column, place, rows)?,
                None if column == 0 && !self.begins_plainly(text[at]) => return None,
                None => {
                    let length = text[at..].iter().take_while(|&&b| !b.is_ascii_whitespace()).count();
                    if length == 0 || length > LONG {
                        return None;
                    }
                    at + length
                }
            };
        }
        line_end(text, at + blank(at))
    }

    /// Reads the bare number that begins at `start`; where it ends.
    #[inline(always)]
    fn quick_number(
        &self,
        text: &[u8],
        start: usize,
        column: usize,
        place: usize,
        rows: &mut Rows,
    ) -> Option<usize> {
        let is_exact = self.exact == Some(column) && rows.integers.is_some();
        if is_exact && self.dialect.dates.is_some() {
            return None; // left to the slow way
        }
        let room = text[start..].first_chunk();
        let (value, length) = match room.and_then(decimal::plain) {
            Some(found) => found,
            None => fast_float2::parse_partial::<f64, _>(&text[start..]).ok()?,
        };
        let end = start + length;
        if !value.is_finite() {
            return None;
        }
        rows.columns[place].push(value);
        if is_exact {
            // The slow way decides about any other spelling.
            let digits = std::str::from_utf8(&text[start..end]).ok()?;
            let integer = digits.parse().ok().filter(|&integer| integer != NO_INTEGER)?;
            rows.integers.as_mut()?.push(integer);
        }
        Some(end)
    }

    /// Whether a line that begins so is neither blank nor a comment, and its first field has no quotes.
    fn begins_plainly(&self, first: u8) -> bool {
        !b" \t\r\n\"".contains(&first)
            && self.dialect.comment.iter().all(|comment| comment.first() != Some(&first))
    }
}

/// Where the next line begins, if this one ends at `at`; carriage returns before its end are let pass.
#[inline]
fn line_end(text: &[u8], at: usize) -> Option<usize> {
    let at = at + usize::from(text[at] == b'\r');
    (text[at] == b'\n').then_some(at + 1)
}
