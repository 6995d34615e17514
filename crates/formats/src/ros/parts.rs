//! Parts of a log, an MCAP file or a ROS 1 bag: pieces, records, channels, and the end.

use super::unpack::Compression;
use std::collections::BTreeMap;

/// Largest length that is not damage: writers make chunks of some megabytes. [bytes]
pub const MAX_LENGTH: u64 = 1 << 30;

/// A series of messages of one topic and type.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Channel {
    /// Number by which its messages name it.
    pub id: u32,
    /// Topic.
    pub topic: String,
    /// Type of the messages, e.g. `sensor_msgs/msg/Imu`.
    pub type_name: String,
    /// Encoding of the definition: `ros2msg`, `ros1msg`, ….
    pub definition_encoding: String,
    /// Definition of the messages.
    pub definition: Vec<u8>,
    /// Encoding of the messages: `cdr`, `ros1`, ….
    pub message_encoding: String,
    /// Number of messages, declared or counted.
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

/// A record of a kind that is used.
pub enum Record<'a> {
    Message { channel: u32, time: u64, data: &'a [u8] },
    Channel(Channel),
    Schema(u32, Schema),
}

/// Why reading ended before the end of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    None,
    /// The file ends too early.
    BrokenOff,
    /// All messages are complete, but the end of the file is missing.
    NoEnd,
    /// Some part of the file is invalid.
    Damaged,
    /// The log is complete, and other bytes follow.
    BytesAfterEnd,
    /// The log is complete, and zeros or 0xff follow.
    Filler,
    /// The chunks unpack to more bytes than are allowed.
    Expanded,
}

/// How reading of a file ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct End {
    /// Kind of the end.
    pub fault: Fault,
    /// Offset in the file. [bytes]
    pub offset: u64,
    /// Description.
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

/// A chunk of the file, still compressed, or a stretch of records outside chunks.
pub struct Piece {
    pub offset: u64,
    pub packed: Vec<u8>,
    pub compression: Compression,
    pub size: usize,
    /// Checksum of the unpacked bytes, if there is one.
    pub crc: Option<u32>,
    /// The file ends within this chunk, whose beginning is used.
    pub cut: bool,
}

/// The next part of a file.
pub enum Next {
    Piece(Piece),
    /// Bytes of a record outside chunks, with its head.
    Loose(Vec<u8>),
    /// A record of a kind that is not used.
    Other,
    /// The end of the data.
    End(End),
}
