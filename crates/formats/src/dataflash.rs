//! `ArduPilot` logs (`DataFlash`, `.bin`). A message `FMT` in the log defines each kind of message.
//!
//! A message begins with two marks and its kind, and has the defined length; there are no checksums. As in `ULog` files, the
//! last message before damage is dropped, because the damage may begin inside it.

use std::io::{self, Read, Seek};

use crate::window::{Break, Fields, Window};

const MARKS: [u8; 2] = [0xa3, 0x95];
const FMT: u8 = 128;
const FMT_LENGTH: usize = 89;
const HEADER: usize = 3;

/// Contents of a log.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DataFlashScan {
    /// Kinds of messages, in the order of their definitions.
    pub kinds: Vec<DataFlashKind>,
    /// Messages that define units: the index of their kind, and their bytes without the header.
    pub definitions: Vec<(usize, Vec<u8>)>,
    /// Number of messages read.
    pub messages: u64,
    /// Offset where reading ended.
    pub end: u64,
    /// Why it ended there, if not at the end of the file.
    pub broken: Option<Break>,
    /// The byte, 0 or 0xff, that fills the rest of the file, if the last message is complete.
    pub filler: Option<u8>,
}

/// A kind of message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataFlashKind {
    /// Number in the header of its messages.
    pub id: u8,
    /// Name.
    pub name: String,
    /// Fields: name, letter of the type, offset without the header.
    pub fields: Vec<(String, char, usize)>,
    /// Size of a message without the header. \[bytes\]
    pub size: usize,
    /// Offset of the instance number, if there are instances.
    pub instance: Option<usize>,
    /// Number of messages by instance, ascending; without instances, all are counted for 0.
    pub rows: Vec<(u8, usize)>,
}

/// Size of a field by the letter of its type. \[bytes\]
fn width(letter: char) -> Option<usize> {
    Some(match letter {
        'b' | 'B' | 'M' => 1,
        'h' | 'H' | 'c' | 'C' | 'g' => 2,
        'i' | 'I' | 'e' | 'E' | 'L' | 'f' | 'n' => 4,
        'd' | 'q' | 'Q' => 8,
        'N' => 16,
        'a' | 'Z' => 64,
        _ => return None,
    })
}

/// Text up to the first zero byte; None if it is not text.
fn text(bytes: &[u8]) -> Option<String> {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let bytes = &bytes[..end];
    bytes.iter().all(u8::is_ascii_graphic).then(|| String::from_utf8_lossy(bytes).into_owned())
}

/// The kind that a message defines, or a description of the fault.
fn parse_kind(body: &[u8]) -> Result<DataFlashKind, String> {
    let (id, length) = (body[0], usize::from(body[1]));
    let (Some(name), Some(letters), Some(labels)) =
        (text(&body[2..6]), text(&body[6..22]), text(&body[22..]))
    else {
        return Err("a definition that is not text".into());
    };
    let names: Vec<&str> = labels.split(',').filter(|name| !name.is_empty()).collect();
    let mut fields = Vec::new();
    let mut size = 0;
    let mut instance = None;
    for (i, letter) in letters.chars().enumerate() {
        let Some(width) = width(letter) else {
            return Err(format!("{name} defined with a field of the unknown type {letter:?}"));
        };
        let label = names.get(i).map_or_else(|| format!("field{}", i + 1), |&name| name.to_owned());
        if label == "I" && letter == 'B' {
            instance = Some(size);
        }
        fields.push((label, letter, size));
        size += width;
    }
    if names.len() > fields.len() || size + HEADER != length {
        return Err(format!(
            "{name} defined as {length} bytes with {} names, but its {} fields make {} bytes",
            names.len(),
            fields.len(),
            size + HEADER
        ));
    }
    Ok(DataFlashKind { id, name, fields, size, instance, rows: Vec::new() })
}

/// Scans a log: its contents, and where it breaks off.
///
/// # Errors
///
/// If it cannot be read. Damage is not an error, but part of the result.
pub fn scan_dataflash(mut source: impl Read + Seek) -> io::Result<DataFlashScan> {
    let (scan, last) = scan_until(&mut source, u64::MAX)?;
    if !matches!(scan.broken, Some(Break::Damaged { .. })) || scan.messages == 0 {
        return Ok(scan);
    }
    // Scan again without the last message.
    source.rewind()?;
    Ok(DataFlashScan { broken: scan.broken, ..scan_until(&mut source, last)?.0 })
}

/// Scans the messages that begin before an offset; also the offset of the last one.
fn scan_until(source: impl Read + Seek, until: u64) -> io::Result<(DataFlashScan, u64)> {
    let mut window = Window::new(source);
    let mut scan = DataFlashScan::default();
    let mut places: [Option<usize>; 256] = [None; 256];
    let mut counts: Vec<Box<[usize; 256]>> = Vec::new();
    let mut last = 0;
    let mut last_byte = MARKS[0];
    let broken = loop {
        let at = window.at();
        let header = window.ahead(HEADER)?;
        if header.is_empty() || at >= until {
            break None;
        }
        if header[0] != MARKS[0] || header.len() > 1 && header[1] != MARKS[1] {
            let first = header[0];
            // If the last message ends in the same byte, it may be incomplete.
            if (first == 0 || first == 0xff) && first != last_byte && rest_is(first, &mut window)? {
                scan.filler = Some(first);
                scan.end = at;
                break None;
            }
            let what = "no message begins there".to_owned();
            break Some(Break::Damaged { at, what });
        }
        if header.len() < HEADER {
            break Some(Break::Cut { at });
        }
        let id = header[2];
        let place = places[usize::from(id)];
        let size = match place {
            _ if id == FMT => FMT_LENGTH - HEADER,
            Some(place) => scan.kinds[place].size,
            None => {
                let what = format!("a message of kind {id}, which is not defined");
                break Some(Break::Damaged { at, what });
            }
        };
        let whole = window.ahead(HEADER + size)?;
        if whole.len() < HEADER + size {
            break Some(Break::Cut { at });
        }
        let body = &whole[HEADER..HEADER + size];
        if id == FMT {
            match parse_kind(body) {
                Err(what) => break Some(Break::Damaged { at, what }),
                Ok(kind) => match places[usize::from(kind.id)] {
                    Some(place) if scan.kinds[place].same(&kind) => {}
                    Some(_) => {
                        let what = format!("kind {} defined a second time", kind.id);
                        break Some(Break::Damaged { at, what });
                    }
                    None => {
                        places[usize::from(kind.id)] = Some(scan.kinds.len());
                        scan.kinds.push(kind);
                        counts.push(Box::new([0; 256]));
                    }
                },
            }
        } else if let Some(place) = place {
            let kind = &scan.kinds[place];
            let instance = kind.instance.map_or(0, |offset| body[offset]);
            counts[place][usize::from(instance)] += 1;
            if matches!(kind.name.as_str(), "FMTU" | "UNIT" | "MULT") {
                scan.definitions.push((place, body.to_vec()));
            }
        }
        last = at;
        last_byte = body.last().copied().unwrap_or(id);
        scan.messages += 1;
        window.skip(HEADER + size);
    };
    if scan.filler.is_none() {
        scan.end = window.at();
    }
    scan.broken = broken;
    for (kind, counts) in scan.kinds.iter_mut().zip(&counts) {
        kind.rows = (0..=u8::MAX).zip(counts.iter().copied()).filter(|&(_, rows)| rows > 0).collect();
    }
    Ok((scan, last))
}

/// Skips the rest of the file; whether all of it is `byte`.
fn rest_is(byte: u8, window: &mut Window<impl Read + Seek>) -> io::Result<bool> {
    loop {
        let rest = window.ahead(1)?;
        if rest.is_empty() {
            return Ok(true);
        }
        if rest.iter().any(|&b| b != byte) {
            return Ok(false);
        }
        let n = rest.len();
        window.skip(n);
    }
}

impl DataFlashKind {
    fn same(&self, other: &Self) -> bool {
        self.name == other.name && self.fields == other.fields
    }
}

/// The messages of one instance, as `dataflash_columns` needs them from a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataFlashRows {
    /// Kind of message.
    pub id: u8,
    /// Offset and value of the instance number, if there are instances.
    pub instance: Option<(usize, u8)>,
    /// Size of a message without the header. \[bytes\]
    pub size: usize,
    /// Number of messages.
    pub rows: usize,
    /// Offset where reading ended.
    pub end: u64,
}

/// Bytes of some fields in all messages of one instance. `fields`: offsets without the header, and lengths.
///
/// # Errors
///
/// If the file cannot be read or was changed since the scan, or a field is outside the messages.
pub fn dataflash_columns(
    source: impl Read + Seek,
    wanted: &DataFlashRows,
    fields: &[(usize, usize)],
) -> io::Result<Vec<Vec<u8>>> {
    let changed = || io::Error::other("the file changed while it was being read");
    let mut window = Window::new(source);
    let mut taken = Fields::new(fields, wanted.size, wanted.rows)?;
    if wanted.instance.is_some_and(|(offset, _)| offset >= wanted.size) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the instance lies outside of the record"));
    }
    let mut sizes: [Option<usize>; 256] = [None; 256];
    sizes[usize::from(FMT)] = Some(FMT_LENGTH - HEADER);
    let mut rows = 0;
    while rows < wanted.rows {
        if window.at() >= wanted.end {
            return Err(changed());
        }
        let id = match window.ahead(HEADER)? {
            [a, b, id, ..] if [*a, *b] == MARKS => *id,
            _ => return Err(changed()),
        };
        let size = sizes[usize::from(id)].ok_or_else(changed)?;
        let body = window.ahead(HEADER + size)?.get(HEADER..HEADER + size).ok_or_else(changed)?;
        if id == FMT {
            if body[0] != FMT {
                sizes[usize::from(body[0])] = Some(usize::from(body[1]).saturating_sub(HEADER));
            }
        } else if id == wanted.id && wanted.instance.is_none_or(|(offset, k)| body.get(offset) == Some(&k)) {
            if size != wanted.size {
                return Err(changed());
            }
            taken.take(body);
            rows += 1;
        }
        window.skip(HEADER + size);
    }
    Ok(taken.columns)
}

#[cfg(test)]
#[path = "dataflash_tests.rs"]
mod tests;
