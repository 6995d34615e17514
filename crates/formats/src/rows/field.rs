//! One field of a line: where it ends, and the number in it.

use memchr::memchr;

use crate::table::Delimiter;

/// Words for a missing number in lower case, which are read as NaN.
const MISSING: [&[u8]; 9] = [b"", b"na", b"n/a", b"nan", b"null", b"none", b"nil", b"-nan", b"+nan"];

/// Length above which a field is checked even if it is not wanted: damage that removes line ends may leave a line with
/// the right number of fields, made of the beginning of one line and the end of another. \[bytes\]
pub(super) const LONG_FIELD: usize = 64;

/// A field that is not a number; the caller adds its place.
pub(super) struct NotANumber;

/// The finite number in a field, or NaN for an infinity or a missing number.
pub(super) fn number(field: &[u8]) -> Result<f64, NotANumber> {
    let field = bare(field);
    match fast_float2::parse::<f64, _>(field) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Ok(f64::NAN),
        Err(_) if is_missing(field) => Ok(f64::NAN),
        Err(_) => Err(NotANumber),
    }
}

pub(super) fn is_missing(field: &[u8]) -> bool {
    MISSING.iter().any(|word| word.eq_ignore_ascii_case(field))
}

/// A field without surrounding spaces and double quotes.
pub(super) fn bare(field: &[u8]) -> &[u8] {
    let field = trim(field);
    match field {
        [b'"', inner @ .., b'"'] => trim(inner),
        _ => field,
    }
}

/// End of the field that begins at `start`; a delimiter within double quotes is part of the field.
pub(super) fn field_end(line: &[u8], start: usize, byte: u8) -> usize {
    let field = &line[start..];
    let lead = field.iter().take_while(|&&b| b == b' ').count();
    let quoted = match field.get(lead) {
        Some(b'"') => memchr(b'"', &field[lead + 1..]).map_or(0, |close| lead + 1 + close),
        _ => 0,
    };
    memchr(byte, &field[quoted..]).map_or(line.len(), |len| start + quoted + len)
}

/// A field of a line by its number, without surrounding spaces and quotes; None if the line has fewer fields.
pub(super) fn nth(line: &[u8], delimiter: Delimiter, column: usize) -> Option<&[u8]> {
    match delimiter {
        Delimiter::Whitespace => {
            line.split(|&b| is_space(b)).filter(|field| !field.is_empty()).nth(column).map(bare)
        }
        Delimiter::Byte(byte) => {
            let mut start = 0;
            for _ in 0..column {
                start = field_end(line, start, byte) + 1;
                if start > line.len() {
                    return None;
                }
            }
            Some(bare(&line[start..field_end(line, start, byte)]))
        }
    }
}

/// Number of fields of a line; one empty field after the last of `expected` is not counted.
pub(super) fn count(line: &[u8], delimiter: Delimiter, expected: usize) -> usize {
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

pub(super) fn is_space(b: u8) -> bool {
    b == b' ' || b == b'\t' || b == b'\r'
}

pub(super) fn trim(bytes: &[u8]) -> &[u8] {
    trim_with(bytes, is_space)
}

pub(super) fn trim_with(bytes: &[u8], space: impl Fn(u8) -> bool) -> &[u8] {
    let start = bytes.iter().take_while(|&&b| space(b)).count();
    let end = bytes.iter().rev().take_while(|&&b| space(b)).count();
    if start == bytes.len() { &[] } else { &bytes[start..bytes.len() - end] }
}
