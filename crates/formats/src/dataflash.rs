//! `ArduPilot` logs (`DataFlash`, `.bin`), which describe themselves: each kind of message is defined by a message `FMT`.
//!
//! Messages begin with two marks and their kind, and have the length that was defined; there are no checksums. As in the
//! other flight logs, the last message before a damaged place is given up, because the damage may begin inside it.

use std::io::{self, Read, Seek};

use crate::window::{Break, Fields, Window};

const MARKS: [u8; 2] = [0xa3, 0x95];
const FMT: u8 = 128;
const FMT_LENGTH: usize = 89;
const HEADER: usize = 3;

/// What a log holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DataFlashScan {
    /// Kinds of messages, in the order of their definitions.
    pub kinds: Vec<DataFlashKind>,
    /// Messages that define units: the place of their kind, and their bytes without the header.
    pub definitions: Vec<(usize, Vec<u8>)>,
    /// Messages read.
    pub messages: u64,
    /// Where reading ends.
    pub end: u64,
    /// Why it ends there, if that is not the end of the file.
    pub broken: Option<Break>,
    /// What the rest of the file consists of alone, zeros or 0xff, if the last message was written to its end.
    pub filler: Option<u8>,
}

/// A kind of message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DataFlashKind {
    /// By which its messages are marked.
    pub id: u8,
    /// Name.
    pub name: String,
    /// Fields: name, letter of the type, offset without the header.
    pub fields: Vec<(String, char, usize)>,
    /// Bytes of a message without the header.
    pub size: usize,
    /// Offset of the instance, if there are instances.
    pub instance: Option<usize>,
    /// Messages by instance, ascending; all under 0 if there are no instances.
    pub rows: Vec<(u8, usize)>,
}

/// Bytes of a field by the letter of its type.
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

/// Text up to the first zero byte, if it is such.
fn text(bytes: &[u8]) -> Option<String> {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    let bytes = &bytes[..end];
    bytes.iter().all(u8::is_ascii_graphic).then(|| String::from_utf8_lossy(bytes).into_owned())
}

/// A kind from the message that defines it; or what is wrong.
fn parse_kind(body: &[u8]) -> Result<DataFlashKind, String> {
    let (id, length) = (body[0], usize::from(body[1]));
    let (Some(name), Some(letters), Some(labels)) =
        (text(&body[2..6]), text(&body[6..22]), text(&body[22..]))
    else {
        return Err("a definition that is no text".into());
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

/// Goes through a log: what it holds, and where it breaks off.
///
/// # Errors
///
/// If it cannot be read; damage is part of the result.
pub fn scan_dataflash(mut source: impl Read + Seek) -> io::Result<DataFlashScan> {
    let (scan, last) = scan_until(&mut source, u64::MAX)?;
    if !matches!(scan.broken, Some(Break::Damaged { .. })) || scan.messages == 0 {
        return Ok(scan);
    }
    // Once more, without the last message.
    source.rewind()?;
    Ok(DataFlashScan { broken: scan.broken, ..scan_until(&mut source, last)?.0 })
}

/// The messages that begin before a place, and where the last of them begins.
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
            // Of a message whose last byte is such a byte it cannot be told whether it was written to its end.
            if (first == 0 || first == 0xff) && first != last_byte && only(first, &mut window)? {
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

/// Whether the rest of the file consists of one byte alone; it is passed over.
fn only(byte: u8, window: &mut Window<impl Read + Seek>) -> io::Result<bool> {
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

/// Where the messages of one instance are: what `dataflash_columns` takes from a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DataFlashRows {
    /// Kind of message.
    pub id: u8,
    /// Offset of the instance and its number, if there are instances.
    pub instance: Option<(usize, u8)>,
    /// Bytes of a message without the header.
    pub size: usize,
    /// How many there are.
    pub rows: usize,
    /// Where reading ends.
    pub end: u64,
}

/// Of all messages of one instance, the bytes of some fields: offsets without the header, and lengths.
///
/// # Errors
///
/// If the file cannot be read or is no longer the one that was scanned, or a field lies outside of the messages.
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
