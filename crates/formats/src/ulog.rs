//! PX4 flight logs, `ULog`, as published at <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>.
//!
//! A log is a sequence of messages, each after its length, without checksums. So a message is accepted only if its kind is
//! known, its length fits its kind (for data, the length of the first message of the topic), and the next message is valid
//! too: the last message before damage is dropped, because the damage may begin inside it.

use std::io::{self, Read, Seek};

use crate::window::{Break, Fields, Window};

const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const SYNC: &[u8] = &[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
const HEADER: usize = 16;
const APPENDED: u8 = 1;

/// Contents of a log.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct UlogScan {
    /// Definitions of formats, `name:type field;…`, in the order of the file.
    pub formats: Vec<Vec<u8>>,
    /// Topics that were subscribed, in the order of the file.
    pub topics: Vec<UlogTopic>,
    /// Durations of the dropouts. \[ms\]
    pub dropouts: Vec<u16>,
    /// Number of messages of unknown kinds, which are skipped.
    pub unknown: u64,
    /// Start and end of each skipped part: data that were appended after a crash begin within a message.
    pub unfinished: Vec<(u64, u64)>,
    /// Number of messages read.
    pub messages: u64,
    /// Offset where reading ended.
    pub end: u64,
    /// Why it ended there, if not at the end of the file.
    pub broken: Option<Break>,
}

/// A topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UlogTopic {
    /// Number in its data messages.
    pub id: u16,
    /// Instance.
    pub instance: u8,
    /// Name of its format.
    pub name: Vec<u8>,
    /// Number of data messages.
    pub rows: usize,
    /// Size of each, without the number. \[bytes\]
    pub size: usize,
}

/// Why a file cannot be read as a log.
#[derive(Debug, thiserror::Error)]
pub enum UlogError {
    /// The first bytes are not the header of a log.
    #[error("the header is not that of a ULog file")]
    Header,
    /// The log has features that a reader must know.
    #[error("it has features that are not known (incompatible flags {0:#x})")]
    Incompatible(u64),
    /// Error of the system.
    #[error(transparent)]
    Io(#[from] io::Error),
}

enum Next<'a> {
    Message { at: u64, kind: u8, payload: &'a [u8] },
    Skipped { from: u64, to: u64 },
    Cut { at: u64, kind: Option<u8>, payload: &'a [u8], size: usize },
    End,
}

struct Walk<R> {
    window: Window<R>,
    /// Offsets ahead at which data were appended, ascending.
    appended: Vec<u64>,
}

impl<R: Read + Seek> Walk<R> {
    fn new(source: R) -> Result<Self, UlogError> {
        let mut window = Window::new(source);
        let header = window.ahead(HEADER)?;
        if header.len() < HEADER || !header.starts_with(MAGIC) {
            return Err(UlogError::Header);
        }
        window.skip(HEADER);
        let mut walk = Self { window, appended: Vec::new() };
        let head = walk.window.ahead(3 + 40)?;
        if head.len() >= 3 + 40 && head[2] == b'B' {
            let size = 3 + usize::from(u16::from_le_bytes([head[0], head[1]]));
            let flags = &head[3..];
            let word = |i: usize| {
                u64::from_le_bytes(std::array::from_fn(|k| flags.get(i + k).copied().unwrap_or(0)))
            };
            let incompatible = word(8);
            if incompatible & !u64::from(APPENDED) != 0 {
                return Err(UlogError::Incompatible(incompatible));
            }
            let least = (HEADER + size) as u64;
            if incompatible != 0 {
                walk.appended = (0..3).map(|k| word(16 + 8 * k)).filter(|&to| to >= least).collect();
                walk.appended.sort_unstable();
                walk.appended.dedup();
            }
        }
        Ok(walk)
    }

    fn next(&mut self) -> io::Result<Next<'_>> {
        let at = self.window.at();
        while self.appended.first().is_some_and(|&to| to <= at) {
            self.appended.remove(0);
        }
        let limit = self.appended.first().copied();
        let header = self.window.ahead(3)?;
        if header.is_empty() {
            // The appended data are missing.
            return Ok(match limit {
                Some(_) => Next::Cut { at, kind: None, payload: &[], size: 0 },
                None => Next::End,
            });
        }
        let whole = header.len() >= 3;
        let (size, kind) = if whole {
            (usize::from(u16::from_le_bytes([header[0], header[1]])), Some(header[2]))
        } else {
            (0, None)
        };
        if let Some(to) = limit {
            if at + 3 + size as u64 > to {
                self.window.seek(to)?;
                if self.window.ahead(1)?.is_empty() {
                    return Ok(Next::Cut { at, kind: None, payload: &[], size: 0 });
                }
                return Ok(Next::Skipped { from: at, to });
            }
        }
        let have = self.window.ahead(3 + size)?.len();
        if !whole || have < 3 + size {
            let payload = self.window.ahead(3)?.get(3..).unwrap_or(&[]);
            return Ok(Next::Cut { at, kind, payload, size });
        }
        let payload = &self.window.ahead(3 + size)?[3..3 + size];
        Ok(Next::Message { at, kind: kind.unwrap_or(0), payload })
    }

    /// Skips a message.
    fn skip_message(&mut self, size: usize) {
        self.window.skip(3 + size);
    }

    /// Whether a message of this size is followed by one of a known kind, or by the end.
    fn goes_on(&mut self, size: usize) -> io::Result<bool> {
        let ahead = self.window.ahead(3 + size + 3)?;
        Ok(ahead.len() == 3 + size || ahead.get(3 + size + 2).is_some_and(|&kind| least(kind).is_some()))
    }
}

/// Smallest size of a message of a kind; None if the kind is unknown. \[bytes\]
fn least(kind: u8) -> Option<usize> {
    Some(match kind {
        b'B' => 40,
        b'A' => 4,
        b'F' | b'I' | b'M' | b'P' | b'Q' | b'D' | b'R' | b'O' => 2,
        b'S' => 8,
        b'L' => 9,
        b'C' => 11,
        _ => return None,
    })
}

fn parse_id(payload: &[u8]) -> Option<u16> {
    Some(u16::from_le_bytes([*payload.first()?, *payload.get(1)?]))
}

/// Index in `topics` by the number of the topic.
#[derive(Default)]
struct Places(Vec<Option<usize>>);

impl Places {
    fn of(&self, id: u16) -> Option<usize> {
        self.0.get(usize::from(id)).copied().flatten()
    }

    fn put(&mut self, id: u16, place: usize) {
        let id = usize::from(id);
        if self.0.len() <= id {
            self.0.resize(id + 1, None);
        }
        self.0[id] = Some(place);
    }
}

/// Scans a log: its contents, and where it breaks off.
///
/// # Errors
///
/// If it is not a log, or cannot be read. Later damage is not an error, but part of the result.
pub fn scan_ulog(mut source: impl Read + Seek) -> Result<UlogScan, UlogError> {
    let (scan, last) = scan_until(&mut source, u64::MAX)?;
    if !matches!(scan.broken, Some(Break::Damaged { .. })) {
        return Ok(scan);
    }
    // Scan again without the last message.
    source.rewind()?;
    Ok(UlogScan { broken: scan.broken, ..scan_until(&mut source, last)?.0 })
}

/// Scans the messages that begin before an offset; also the offset of the last one.
fn scan_until(source: impl Read + Seek, until: u64) -> Result<(UlogScan, u64), UlogError> {
    let mut walk = Walk::new(source)?;
    let mut scan = UlogScan::default();
    let mut places = Places::default();
    let mut last = HEADER as u64;
    loop {
        let (at, kind, size, wrong) = match walk.next()? {
            Next::End => break,
            Next::Message { at, .. } if at >= until => break,
            Next::Skipped { from, to } => {
                scan.unfinished.push((from, to));
                continue;
            }
            Next::Cut { at, kind, payload, size } => {
                // A damaged length may reach beyond the end too.
                let wrong = kind.and_then(|kind| {
                    wrong_cut(kind, payload, size, &scan, &places).or_else(|| {
                        least(kind).is_none().then(|| format!("a message of the unknown kind {kind:#04x}"))
                    })
                });
                scan.end = at;
                scan.broken = Some(wrong.map_or(Break::Cut { at }, |what| Break::Damaged { at, what }));
                return Ok((scan, last));
            }
            Next::Message { at, kind, payload } => {
                let wrong = match kind {
                    _ if least(kind).is_some_and(|least| payload.len() < least) => {
                        Some(short(kind, payload.len()))
                    }
                    b'D' => data(payload, &mut scan, &places),
                    b'A' => subscribe(payload, &mut scan, &mut places),
                    b'F' if payload.contains(&b':') => {
                        scan.formats.push(payload.to_vec());
                        None
                    }
                    b'F' => Some("a format without a name".into()),
                    b'O' if payload.len() == 2 => {
                        scan.dropouts.extend(parse_id(payload));
                        None
                    }
                    b'O' => Some(short(kind, payload.len())),
                    b'S' if !payload.starts_with(SYNC) => {
                        Some("a synchronisation message with other bytes".into())
                    }
                    b'B' if at != HEADER as u64 => Some("flags in the middle of the log".into()),
                    _ => None,
                };
                let size = payload.len();
                (at, kind, size, wrong)
            }
        };
        let wrong = match wrong {
            None if least(kind).is_none() => {
                if kind.is_ascii_alphabetic() && size > 0 && walk.goes_on(size)? {
                    scan.unknown += 1;
                    None
                } else {
                    Some(format!("a message of the unknown kind {kind:#04x}, {size} bytes long"))
                }
            }
            wrong => wrong,
        };
        if let Some(what) = wrong {
            scan.broken = Some(Break::Damaged { at, what });
            return Ok((scan, last));
        }
        last = at;
        scan.messages += 1;
        walk.skip_message(size);
    }
    scan.end = walk.window.at();
    Ok((scan, last))
}

fn short(kind: u8, size: usize) -> String {
    format!("a message of kind {:?} of {size} bytes", char::from(kind))
}

/// Counts a data message, or describes its fault.
fn data(payload: &[u8], scan: &mut UlogScan, places: &Places) -> Option<String> {
    let id = parse_id(payload).unwrap_or(u16::MAX);
    let Some(place) = places.of(id) else {
        return Some(format!("data of topic {id}, which is not declared"));
    };
    let topic = &mut scan.topics[place];
    let size = payload.len() - 2;
    if topic.rows == 0 {
        topic.size = size;
    } else if topic.size != size {
        return Some(format!(
            "a message of {} of {size} bytes instead of {}",
            shown(&topic.name),
            topic.size
        ));
    }
    topic.rows += 1;
    None
}

/// Adds a topic, or describes its fault.
fn subscribe(payload: &[u8], scan: &mut UlogScan, places: &mut Places) -> Option<String> {
    let (instance, name) = (payload[0], &payload[3..]);
    let id = u16::from_le_bytes([payload[1], payload[2]]);
    if !name.iter().all(u8::is_ascii_graphic) {
        return Some("a topic whose name is not text".into());
    }
    if let Some(place) = places.of(id) {
        let same = scan.topics[place].instance == instance && scan.topics[place].name == name;
        return (!same).then(|| format!("a second topic of number {id}"));
    }
    places.put(id, scan.topics.len());
    scan.topics.push(UlogTopic { id, instance, name: name.to_vec(), rows: 0, size: 0 });
    None
}

/// Fault at the beginning of a message that reaches beyond the end of the file.
fn wrong_cut(kind: u8, payload: &[u8], size: usize, scan: &UlogScan, places: &Places) -> Option<String> {
    if least(kind).is_some_and(|least| size < least) {
        return Some(short(kind, size));
    }
    let id = (kind == b'D').then(|| parse_id(payload)).flatten()?;
    let Some(place) = places.of(id) else {
        return Some(format!("data of topic {id}, which is not declared"));
    };
    let topic = &scan.topics[place];
    (topic.rows > 0 && topic.size + 2 != size).then(|| {
        format!("a message of {} of {} bytes instead of {}", shown(&topic.name), size - 2, topic.size)
    })
}

fn shown(name: &[u8]) -> String {
    String::from_utf8_lossy(name).into_owned()
}

/// Bytes of some fields in all messages of a topic before `end`.
///
/// `fields`: offsets in the data of a message, and lengths in bytes.
///
/// # Errors
///
/// If the file cannot be read or was changed since the scan, or a field is outside the messages.
pub fn ulog_columns(
    source: impl Read + Seek,
    end: u64,
    topic: &UlogTopic,
    fields: &[(usize, usize)],
) -> Result<Vec<Vec<u8>>, UlogError> {
    let mut walk = Walk::new(source)?;
    if topic.rows == 0 {
        return Ok(vec![Vec::new(); fields.len()]);
    }
    let mut taken = Fields::new(fields, topic.size, topic.rows)?;
    let mut rows = 0;
    while rows < topic.rows {
        let size = match walk.next()? {
            Next::Message { at, kind, payload } if at < end => {
                if kind == b'D' && parse_id(payload) == Some(topic.id) && payload.len() == 2 + topic.size {
                    taken.take(&payload[2..]);
                    rows += 1;
                }
                payload.len()
            }
            Next::Skipped { .. } => continue,
            _ => return Err(io::Error::other("the file changed while it was being read").into()),
        };
        walk.skip_message(size);
    }
    Ok(taken.columns)
}

#[cfg(test)]
#[path = "ulog_tests.rs"]
mod tests;
