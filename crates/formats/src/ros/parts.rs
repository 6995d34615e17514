//! What a log is made of, whichever its format: pieces, records, channels, and the end.

use super::unpack::Compression;
use std::collections::BTreeMap;

/// A length beyond this is taken for damage: writers make chunks of some megabytes. [bytes]
pub const LARGEST: u64 = 1 << 30;

/// A series of messages of one topic and type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Channel {
    /// Number by which messages name it.
    pub id: u32,
    /// Topic.
    pub topic: String,
    /// Type of the messages, e.g. `sensor_msgs/msg/Imu`.
    pub type_name: String,
    /// How the definition is written: `ros2msg`, `ros1msg`, ….
    pub definition_encoding: String,
    /// Definition of the messages.
    pub definition: Vec<u8>,
    /// How the messages are written: `cdr`, `ros1`, ….
    pub message_encoding: String,
    /// Messages, declared or counted.
    pub messages: u64,
}

/// Definitions by number.
pub type Schemas = BTreeMap<u32, Schema>;

/// A definition of messages.
#[derive(Clone, Debug, Default)]
pub struct Schema {
    pub name: String,
    pub encoding: String,
    pub data: Vec<u8>,
}

/// A record that matters.
pub enum Record<'a> {
    Message { channel: u32, time: u64, data: &'a [u8] },
    Channel(Channel),
    Schema(u32, Schema),
}

/// Why a walk ended before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Nothing is wrong.
    None,
    /// The file ends too early.
    BrokenOff,
    /// All messages are there, but not the end of the file.
    NoEnd,
    /// Something in it cannot be right.
    Damaged,
    /// The log is whole, and bytes lie behind it.
    Behind,
    /// The log is whole, and zeros or 0xff lie behind it.
    Filler,
    /// Its chunks unpack to more than is allowed.
    Expanded,
}

/// How a walk through a file ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// What kind of end.
    pub fault: Fault,
    /// Where in the file. [bytes]
    pub offset: u64,
    /// In words.
    pub what: String,
}

impl End {
    pub(super) fn complete() -> Self {
        Self { fault: Fault::None, offset: 0, what: String::new() }
    }

    pub(super) fn new(fault: Fault, offset: u64, what: impl Into<String>) -> Self {
        Self { fault, offset, what: what.into() }
    }
}

/// A chunk as it lies in the file, or a stretch of records outside of chunks.
pub struct Piece {
    pub offset: u64,
    pub packed: Vec<u8>,
    pub compression: Compression,
    pub size: usize,
    /// Checksum of the unpacked bytes, if there is one.
    pub crc: Option<u32>,
    /// The file ends within this chunk; what there is of it is used.
    pub cut: bool,
}

/// What stands at the next place of a file.
pub enum Next {
    Piece(Piece),
    /// Bytes of a record outside of any chunk, with its head.
    Loose(Vec<u8>),
    /// Nothing of interest.
    Other,
    /// The end of the data.
    End(End),
}
