//! Sentences of `VectorNav` sensors: one line each, `$VNYMR,…*68`, with a checksum of 8 or 16 bits.
//!
//! A line with a wrong checksum is left out and counted: a serial link drops bytes, and one of them must not cost a log of
//! days. The result has their number and the first few.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use crate::table::TextError;

/// Longest sentence. \[bytes\]
const MAX_SENTENCE: u64 = 1 << 12;

/// Number of broken lines that are described.
const MAX_DESCRIBED: usize = 5;

/// Optional fields after those of the sentence: count of synchronisation pulses, or time since the last one.
const OPTIONAL_FIELDS: [u8; 2] = *b"ST";

/// The sentences with one name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sentences {
    /// The wanted fields in the order of the request; NaN where the sentence has NaN.
    pub columns: Vec<Vec<f64>>,
    /// Number of rows.
    pub rows: usize,
    /// Number of lines that are neither blank nor a complete sentence.
    pub broken: usize,
    /// Number of broken lines after the first row.
    pub inner: usize,
    /// The first broken lines, counted from 1, and the fault of each.
    pub examples: Vec<(usize, String)>,
    /// Number of complete sentences with other names.
    pub others: usize,
    /// Largest number of consecutive other sentences after the first row; and the first line of that run, counted from 1.
    pub gap: (usize, usize),
    /// Name of the first other sentence.
    pub other: String,
    /// Whether the last line is broken and has no line end.
    pub cut: bool,
}

/// Reads the wanted fields (counted from 0, of `fields`) of the sentences called `name`, without the `$`.
///
/// # Errors
///
/// [`TextError::Damaged`] and [`TextError::Io`]. If compressed data break off, the text ends there and `cut` is set.
///
/// # Panics
///
/// If a wanted field is not one of the fields.
pub fn read_sentences(
    reader: impl Read,
    name: &[u8],
    fields: usize,
    wanted: &[usize],
    most: u64,
) -> Result<Sentences, TextError> {
    assert!(wanted.iter().all(|&field| field < fields), "fields {wanted:?} of {fields}");
    let mut collected = Sentences { columns: vec![Vec::new(); wanted.len()], ..Sentences::default() };
    let mut reader = BufReader::with_capacity(1 << 16, reader);
    let mut line = Vec::new();
    let mut number = 0;
    let mut continued = false;
    let mut run = (0, 0);
    loop {
        line.clear();
        let ended_early = match reader.by_ref().take(MAX_SENTENCE).read_until(b'\n', &mut line) {
            Ok(_) => false,
            Err(e) => match e.kind() {
                ErrorKind::UnexpectedEof => true,
                ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                    return Err(TextError::Damaged { line: number });
                }
                ErrorKind::FileTooLarge => return Err(TextError::TooLarge { most }),
                _ => return Err(TextError::Io(io::Error::to_string(&e))),
            },
        };
        if line.is_empty() {
            collected.cut |= ended_early;
            return Ok(collected);
        }
        let whole = line.ends_with(b"\n");
        // The rest of a line that was too long has already been counted.
        if !continued {
            number += 1;
            let text = line.trim_ascii();
            let before = (collected.rows, collected.others);
            let outcome = if text.is_empty() { Ok(()) } else { collected.take(text, name, fields, wanted) };
            if collected.rows > before.0 {
                run = (0, 0);
            } else if collected.others > before.1 && collected.rows > 0 {
                run = (run.0 + 1, if run.0 == 0 { number } else { run.1 });
                collected.gap = if run.0 > collected.gap.0 { run } else { collected.gap };
            }
            if let Err(reason) = outcome {
                collected.broken += 1;
                collected.inner += usize::from(collected.rows > 0);
                collected.cut = !whole && (line.len() as u64) < MAX_SENTENCE;
                if collected.examples.len() < MAX_DESCRIBED {
                    collected.examples.push((number, reason));
                }
            } else {
                collected.cut = false;
            }
        }
        continued = !whole;
        if ended_early {
            collected.cut = true;
            return Ok(collected);
        }
    }
}

impl Sentences {
    fn take(&mut self, text: &[u8], name: &[u8], fields: usize, wanted: &[usize]) -> Result<(), String> {
        let body = checked(text)?;
        let mut parts = body.split(|&b| b == b',');
        let own = parts.next().unwrap_or_default();
        if own != name {
            if self.others == 0 {
                self.other = String::from_utf8_lossy(own).into_owned();
            }
            self.others += 1;
            return Ok(());
        }
        let mut got = 0;
        let mut values = vec![0.0; wanted.len()];
        for part in parts {
            if got < fields {
                if let Some(place) = wanted.iter().position(|&field| field == got) {
                    let part = part.trim_ascii();
                    let value = fast_float2::parse(part)
                        .map_err(|_| format!("{:?} is not a number", String::from_utf8_lossy(part)))?;
                    values[place] = value;
                }
            } else if !part.first().is_some_and(|b| OPTIONAL_FIELDS.contains(b)) {
                return Err(format!("more than {fields} fields"));
            }
            got += 1;
        }
        if got < fields {
            return Err(format!("{got} fields, {fields} expected"));
        }
        for (column, value) in self.columns.iter_mut().zip(values) {
            column.push(value);
        }
        self.rows += 1;
        Ok(())
    }
}

/// The text between `$` and `*`, if the checksum after it is right.
fn checked(text: &[u8]) -> Result<&[u8], String> {
    let Some(rest) = text.strip_prefix(b"$") else { return Err("does not begin with $".into()) };
    let Some(star) = memchr::memrchr(b'*', rest) else { return Err("has no checksum".into()) };
    let (body, written) = (&rest[..star], &rest[star + 1..]);
    let sum = match written.len() {
        2 => body.iter().fold(0, |sum, &b| sum ^ u16::from(b)),
        4 => crc16(body),
        _ => return Err("has half a checksum".into()),
    };
    let stated = std::str::from_utf8(written)
        .ok()
        .filter(|w| w.bytes().all(|b| b.is_ascii_hexdigit()))
        .and_then(|w| u16::from_str_radix(w, 16).ok());
    if stated == Some(sum) {
        Ok(body)
    } else {
        let digits = written.len();
        Err(format!("checksum {}, but {sum:0digits$X} from its bytes", String::from_utf8_lossy(written)))
    }
}

/// CRC-16 with the polynomial x¹⁶ + x¹² + x⁵ + 1 and the initial value 0, from the manuals of `VectorNav`.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0_u16, |crc, &byte| {
        let mut crc = crc.swap_bytes() ^ u16::from(byte);
        crc ^= (crc & 0xff) >> 4;
        crc ^= crc << 12;
        crc ^ ((crc & 0xff) << 5)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_of_the_crc() {
        assert_eq!(crc16(b"123456789"), 0x31c3); // CRC-16/XMODEM, as catalogues print it
    }

    #[test]
    fn both_checksums_and_broken_lines() {
        let text = b"1.0,2.0*11\n$VNGYR,1,-2,+03.5*5B\r\n\n$VNGYR,1,-2,+03.5*5C\n$VNGYR,1\n$VNACC,1,2,3*76\n$VNGYR,4,5";
        let good = |body: &str| format!("${body}*{:04X}\n", crc16(body.as_bytes()));
        let xor = b"VNGYR,1,-2,+03.5".iter().fold(0, |a, b| a ^ b);
        let other = b"VNACC,1,2,3".iter().fold(0, |a, b| a ^ b);
        let text = String::from_utf8_lossy(text)
            .replace("*5B", &format!("*{xor:02X}"))
            .replace("*5C", &format!("*{:02X}", xor ^ 1))
            .replace("*76", &format!("*{other:02x}"));
        let text = text.replace("\n\n", &format!("\n{}\n", good("VNGYR,7,8,9,S000123")));
        let collected = read_sentences(text.as_bytes(), b"VNGYR", 3, &[2, 0], u64::MAX).unwrap();
        assert_eq!(collected.columns, [[3.5, 9.0], [1.0, 7.0]]);
        assert_eq!(
            (collected.rows, collected.broken, collected.inner, collected.others, collected.cut),
            (2, 4, 3, 1, true)
        );
        assert_eq!(collected.examples.iter().map(|e| e.0).collect::<Vec<_>>(), [1, 5, 6, 8]);
    }

    #[test]
    fn where_other_sentences_stand_in_the_way() {
        let line = |body: &str| format!("${body}*{:04X}\n", crc16(body.as_bytes()));
        let (own, other) = (line("VNGYR,1,2,3"), line("VNACC,1,2,3"));
        let text = [other.repeat(9), own.clone(), other.clone(), own, other.repeat(3)].concat();
        let collected = read_sentences(text.as_bytes(), b"VNGYR", 3, &[0], u64::MAX).unwrap();
        assert_eq!(
            (collected.rows, collected.others, collected.gap, collected.other.as_str()),
            (2, 13, (3, 13), "VNACC")
        );
    }

    #[test]
    fn a_line_without_end_takes_no_memory() {
        let collected = read_sentences(io::repeat(b'7').take(1 << 24), b"VNGYR", 3, &[0], u64::MAX).unwrap();
        assert_eq!((collected.rows, collected.broken), (0, 1));
    }
}
