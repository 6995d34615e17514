//! Lines into rows of numbers, each line held to the layout: a quick way for plain rows, and a slow one for all the rest.

// A call costs as much as the work of one of these, which is done for every number.
#![allow(clippy::inline_always)]

use memchr::{memchr, memchr3, memrchr};

use crate::date;
use crate::number::{long_fraction, scan, short_number};
use crate::remarks::Remarks;
use crate::table::{Delimiter, Dialect, Table, TextError};

/// Characters of a field that an error quotes.
const QUOTED: usize = 40;

/// Words that other programs write for a missing number, lower case. They are read as NaN.
const MISSING: [&[u8]; 9] = [b"", b"na", b"n/a", b"nan", b"null", b"none", b"nil", b"-nan", b"+nan"];

/// A longer field that is not wanted is looked into: damage that swallows the ends of some lines may leave a line with as
/// many fields as it should have, made of the beginning of one and the end of another. \[bytes\]
const LONG: usize = 64;

/// Stands for a missing integer, as `NaT` does in NumPy.
pub(crate) const NO_INTEGER: i64 = i64::MIN;

const BOM: &[u8] = b"\xef\xbb\xbf";

/// A dialect, and what is wanted of it.
pub(crate) struct Layout<'a> {
    pub(crate) dialect: &'a Dialect,
    wanted: usize,
    /// For each column of the file, its place among the wanted ones.
    places: Vec<Option<usize>>,
    exact: Option<usize>,
    /// Whether rows of bare numbers can be told without looking at the whole line first.
    pub(crate) quick: bool,
}

/// The rows of some lines; lines and rows count from the first of them.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    columns: Vec<Vec<f64>>,
    integers: Option<Vec<i64>>,
    done: usize,
    /// Lines seen, those without a row included.
    pub(crate) lines: usize,
    first_line: usize,
    /// Lines still to be passed over.
    skip: usize,
    /// Whether the first line is that of the file.
    at_start: bool,
    remarks: Remarks,
}

/// What is wrong with a field, before it is known where.
enum Fault {
    NotANumber,
    NonFinite,
}

impl<'a> Layout<'a> {
    pub(crate) fn new(dialect: &'a Dialect, wanted: &[usize], exact: Option<usize>) -> Self {
        let mut places = vec![None; dialect.columns];
        for (place, &column) in wanted.iter().enumerate() {
            assert!(column < dialect.columns, "column {column} of {}", dialect.columns);
            assert!(places[column].is_none(), "column {column} is wanted twice");
            places[column] = Some(place);
        }
        let parted =
            matches!(dialect.delimiter, Delimiter::Whitespace | Delimiter::Byte(b',' | b';' | b'\t' | b'|'));
        // A comment must not look like a number, or like nothing.
        let comments =
            dialect.comment.iter().all(|c| c.first().is_some_and(|b| !b"+-.0123456789 \t\r".contains(b)));
        let exact_is_wanted = exact.is_none_or(|column| wanted.contains(&column));
        let quick = parted && comments && exact_is_wanted;
        Self { dialect, wanted: wanted.len(), places, exact, quick }
    }

    /// No rows yet; `at_start` if the lines to come are the first ones of the file.
    pub(crate) fn rows(&self, at_start: bool) -> Rows {
        Rows {
            columns: vec![Vec::new(); self.wanted],
            integers: self.exact.map(|_| Vec::new()),
            skip: if at_start { self.dialect.skip_lines } else { 0 },
            at_start,
            ..Rows::default()
        }
    }

    /// Takes the rows out again, for lines that are not the first ones of the file; the memory is kept.
    pub(crate) fn clear(&self, rows: &mut Rows) {
        let (mut columns, mut integers) = (std::mem::take(&mut rows.columns), rows.integers.take());
        columns.iter_mut().for_each(Vec::clear);
        integers.iter_mut().for_each(Vec::clear);
        let integers = integers.or_else(|| self.exact.map(|_| Vec::new()));
        *rows = Rows { columns, integers, ..Rows::default() };
    }

    /// Reads `text` up to `end`: whole lines, the last of which may lack its line feed.
    ///
    /// There must be [`crate::number::PAD`] bytes after `end`, whatever they are.
    pub(crate) fn read(&self, text: &[u8], end: usize, rows: &mut Rows) -> Result<(), TextError> {
        let mut start = 0;
        // The quick way goes on until a line ends, so that there must be an end.
        let ended = if self.quick { memrchr(b'\n', &text[..end]).map_or(0, |last| last + 1) } else { 0 };
        while start < end {
            if text[start] == b'\n' && rows.skip == 0 {
                // Blank lines by the billion are a few megabytes of compressed ones.
                let blank = text[start..end].iter().take_while(|&&b| b == b'\n').count();
                rows.lines += blank;
                start += blank;
                continue;
            }
            // The first line may begin with a byte order mark.
            if start < ended && rows.skip == 0 && !(rows.at_start && rows.lines == 0) {
                if let Some(next) = self.quick_row(text, start, rows) {
                    start = next;
                    continue;
                }
            }
            let line = &text[start..end];
            let line = memchr(b'\n', line).map_or(line, |length| &line[..length]);
            self.line(line, rows)?;
            start += line.len() + 1;
        }
        Ok(())
    }

    /// Takes a row of bare numbers that begins at `start`; where the next line begins.
    ///
    /// Nothing if there is anything else in the line, its end included: then no row has been taken, and `line` has the
    /// last word. What is taken here, `line` would take the same.
    #[inline]
    fn quick_row(&self, text: &[u8], start: usize, rows: &mut Rows) -> Option<usize> {
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
        if is_exact && self.dialect.dates {
            return None; // left to the other way
        }
        if !is_exact {
            if let Some((value, end)) = long_fraction(text, start).or_else(|| short_number(text, start)) {
                rows.columns[place].push(value);
                return Some(end);
            }
        }
        let written = scan(text, start)?;
        let value = match written.nearest() {
            Some(value) => value,
            None => {
                fast_float2::parse(&text[start..written.end]).ok().filter(|value: &f64| value.is_finite())?
            }
        };
        rows.columns[place].push(value);
        if is_exact {
            // One that does not fit may be a fault of this way: the other decides.
            rows.integers.as_mut()?.push(written.integer()?);
        }
        Some(written.end)
    }

    /// Whether a line that begins so is neither blank nor a comment, and its first field has no quotes.
    fn begins_plainly(&self, first: u8) -> bool {
        !b" \t\r\n\"".contains(&first)
            && self.dialect.comment.iter().all(|comment| comment.first() != Some(&first))
    }

    /// One line without its line feed.
    fn line(&self, mut line: &[u8], rows: &mut Rows) -> Result<(), TextError> {
        rows.lines += 1;
        if rows.skip > 0 {
            rows.skip -= 1;
            return Ok(());
        }
        if rows.at_start && rows.lines == 1 {
            line = line.strip_prefix(BOM).unwrap_or(line);
        }
        let trimmed = match self.dialect.delimiter {
            // Tabs are fields here, and an empty one must not be lost.
            Delimiter::Byte(b'\t') => trim_with(line, |b| b == b' ' || b == b'\r'),
            _ => trim(line),
        };
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
            // A line that is no row at all is best told as such.
            Err(fault) => match count(trimmed, self.dialect.delimiter, self.dialect.columns) {
                got if got != self.dialect.columns => got,
                _ => return Err(fault),
            },
        };
        if got != self.dialect.columns {
            let expected = self.dialect.columns;
            return Err(TextError::Ragged { line: rows.lines, row: rows.done, got, expected });
        }
        rows.done += 1;
        Ok(())
    }

    /// Counts a line that begins with the mark of a comment.
    fn remark(&self, line: &[u8], rows: &mut Rows) {
        let columns = self.dialect.columns;
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

    /// Takes the numbers out of a line whose fields one byte parts; the number of fields.
    fn delimited(&self, line: &[u8], byte: u8, rows: &mut Rows) -> Result<usize, TextError> {
        let mut start = 0;
        for column in 0..self.dialect.columns {
            let end = if self.exact == Some(column) && self.dialect.dates {
                let end = field_end(line, start, byte);
                rows.date(&line[start..end], column, self.places[column])?;
                end
            } else if let Some(place) = self.places[column] {
                rows.number(line, start, byte, column, place)?
            } else {
                let end = field_end(line, start, byte);
                rows.words(column, &line[start..end])?;
                end
            };
            if self.exact == Some(column) && !self.dialect.dates {
                rows.integer(bare(&line[start..end]));
            }
            if end == line.len() {
                return Ok(column + 1);
            }
            start = end + 1;
        }
        Ok(count(line, Delimiter::Byte(byte), self.dialect.columns))
    }

    /// The same for a line whose fields are parted by runs of spaces and tabs.
    fn spaced(&self, line: &[u8], rows: &mut Rows) -> Result<usize, TextError> {
        let mut fields = 0;
        let mut start = 0;
        while start < line.len() {
            let column = fields;
            let len = line[start..].iter().position(|&b| is_space(b));
            let end = len.map_or(line.len(), |len| start + len);
            fields += 1;
            if let Some(&place) = self.places.get(column) {
                let field = &line[start..end];
                if self.exact == Some(column) && self.dialect.dates {
                    rows.date(field, column, place)?;
                } else if let Some(place) = place {
                    let value = number(field).map_err(|fault| rows.fault(&fault, column, field))?;
                    rows.columns[place].push(value);
                } else {
                    rows.words(column, field)?;
                }
                if self.exact == Some(column) && !self.dialect.dates {
                    rows.integer(bare(field));
                }
            }
            start = end + line[end..].iter().take_while(|&&b| is_space(b)).count();
        }
        Ok(fields)
    }
}

impl Rows {
    /// Reads the number that begins at `start`; where its field ends.
    fn number(
        &mut self,
        line: &[u8],
        start: usize,
        byte: u8,
        column: usize,
        place: usize,
    ) -> Result<usize, TextError> {
        // Often a bare number up to the delimiter.
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

    /// Reads a field as an integer, and gives the exact column up at the first one that is none; a missing one is
    /// [`NO_INTEGER`], so that one empty field does not cost all others their last digits.
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

    /// Reads a field as a date, in nanoseconds.
    fn date(&mut self, field: &[u8], column: usize, place: Option<usize>) -> Result<(), TextError> {
        let stamp = date::nanoseconds(bare(field)).ok_or_else(|| match number(field) {
            Err(fault) => self.fault(&fault, column, field),
            Ok(_) => self.fault(&Fault::NotANumber, column, field),
        })?;
        if let Some(place) = place {
            self.columns[place].push(stamp as f64);
        }
        if let Some(integers) = &mut self.integers {
            integers.push(stamp);
        }
        Ok(())
    }

    /// Refuses a long field that is no text.
    fn words(&self, column: usize, field: &[u8]) -> Result<(), TextError> {
        let text = field.len() <= LONG
            || (std::str::from_utf8(field).is_ok() && !field.iter().any(|&b| b < b' ' && b != b'\t'));
        if text { Ok(()) } else { Err(self.fault(&Fault::NotANumber, column, field)) }
    }

    fn fault(&self, fault: &Fault, column: usize, field: &[u8]) -> TextError {
        let (line, row) = (self.lines, self.done);
        let text = String::from_utf8_lossy(trim(field)).chars().take(QUOTED).collect();
        match fault {
            Fault::NotANumber => TextError::NotANumber { line, row, column, text },
            Fault::NonFinite => TextError::NonFinite { line, row, column, text },
        }
    }

    /// Appends the rows of the lines that follow.
    pub(crate) fn append(&mut self, next: &Self) {
        for (column, more) in self.columns.iter_mut().zip(&next.columns) {
            column.extend_from_slice(more);
        }
        match (&mut self.integers, &next.integers) {
            (Some(integers), Some(more)) => integers.extend_from_slice(more),
            _ => self.integers = None,
        }
        if self.done == 0 && next.done > 0 {
            self.first_line = self.lines + next.first_line;
        }
        self.remarks.append(&next.remarks, self.lines);
        self.done += next.done;
        self.lines += next.lines;
    }

    /// Room for so many times the rows there are, if it can be had.
    pub(crate) fn reserve(&mut self, times: f64) {
        let more = (self.done as f64 * (times - 1.0)) as usize;
        // An estimate: what it lacks, and what is refused, is asked for when it is needed.
        for column in &mut self.columns {
            let _ = column.try_reserve_exact(more);
        }
        if let Some(integers) = &mut self.integers {
            let _ = integers.try_reserve_exact(more);
        }
    }

    /// The error as it is for lines that come after these.
    pub(crate) fn moved(&self, error: TextError) -> TextError {
        error.moved(self.lines, self.done)
    }

    pub(crate) fn finish(mut self) -> Result<Table, TextError> {
        if self.done == 0 {
            return Err(TextError::Empty);
        }
        self.columns.iter_mut().for_each(Vec::shrink_to_fit);
        self.integers.iter_mut().for_each(Vec::shrink_to_fit);
        Ok(Table {
            columns: self.columns,
            integers: self.integers,
            rows: self.done,
            first_line: self.first_line,
            remarks: self.remarks,
            open_end: false,
        })
    }
}

/// Where the next line begins, if this one ends at `at`; carriage returns before its end are let pass.
#[inline]
fn line_end(text: &[u8], at: usize) -> Option<usize> {
    let at = at + usize::from(text[at] == b'\r');
    (text[at] == b'\n').then_some(at + 1)
}

/// The finite number that a field holds, or NaN if it says that there is none.
fn number(field: &[u8]) -> Result<f64, Fault> {
    let field = bare(field);
    match fast_float2::parse::<f64, _>(field) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) if value.is_nan() => Ok(f64::NAN),
        Ok(_) => Err(Fault::NonFinite),
        Err(_) if is_missing(field) => Ok(f64::NAN),
        Err(_) => Err(Fault::NotANumber),
    }
}

fn is_missing(field: &[u8]) -> bool {
    MISSING.iter().any(|word| word.eq_ignore_ascii_case(field))
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
