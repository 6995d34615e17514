//! Messages of the Robot Operating System, from MCAP files, ROS 1 bags or bytes.
//!
//! Both files are sequences of records, most of them in compressed chunks. [`pieces`] cuts a file into chunks, which are
//! unpacked and decoded in parallel and joined in the order of the file; [`program`] decodes a message.

mod bag;
mod cursor;
mod mcap;
mod parts;
mod pieces;
mod program;
mod source;
mod steps;
mod unpack;

pub use parts::{Channel, End, Fault};
pub use program::{Columns, Program};
pub use steps::{ProgramError, RawStep};
pub use unpack::message as unpacked;

use pieces::{Container, Walk};
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::Path;

/// Format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogKind {
    /// MCAP, version 0.
    Mcap,
    /// ROS 1 bag, version 2.0.
    Bag,
}

/// Contents of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contents {
    /// Channels in the order of their numbers.
    pub channels: Vec<Channel>,
    /// Whether the file declares the numbers of messages; otherwise they were counted.
    pub declared: bool,
    /// How reading ended; complete if the summary in the file was used.
    pub end: End,
}

/// Decoded messages of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Messages {
    /// Columns of numbers.
    pub columns: Columns,
    /// How reading ended.
    pub end: End,
}

/// Contents of a file, from its summary if that is complete, otherwise from all records. If its chunks unpack to more than
/// `most` bytes together, reading ends with [`Fault::Expanded`].
///
/// # Errors
/// If the file cannot be opened or read.
pub fn contents(path: &Path, kind: LogKind, most: u64) -> io::Result<Contents> {
    let file = File::open(path)?;
    let summary = match kind {
        LogKind::Mcap => mcap::summary(&file),
        LogKind::Bag => bag::summary(&file),
    };
    if let Some(channels) = summary {
        return Ok(Contents { channels, declared: true, end: End::complete() });
    }
    let mut all: BTreeMap<u32, Channel> = BTreeMap::new();
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    let mut schemas = parts::Schemas::new();
    let end = walk(
        path,
        kind,
        most,
        |container, data, _| {
            let mut survey = pieces::Survey::default();
            let fault = container.survey(data, &mut survey);
            (survey, fault)
        },
        |survey: pieces::Survey| {
            schemas.extend(survey.schemas);
            for channel in survey.channels {
                all.entry(channel.id).or_insert(channel);
            }
            for (id, n) in survey.counts {
                *counts.entry(id).or_default() += n;
            }
        },
    )?;
    let mut channels: Vec<Channel> = all.into_values().collect();
    for channel in &mut channels {
        channel.messages = counts.get(&channel.id).copied().unwrap_or(0);
    }
    if kind == LogKind::Mcap {
        mcap::describe(&mut channels, &schemas);
    }
    Ok(Contents { channels, declared: false, end })
}

/// The messages of some channels of a file as columns; `most` as in [`contents`].
///
/// # Errors
/// If the file cannot be opened or read. [`Messages::end`] reports damage.
pub fn messages(
    path: &Path,
    kind: LogKind,
    ids: &[u32],
    program: &Program,
    most: u64,
) -> io::Result<Messages> {
    let mut columns = program.columns();
    let end = walk(
        path,
        kind,
        most,
        |container, data, vouched| {
            let mut part = program.columns();
            let fault = container.decode(data, ids, program, &mut part);
            if fault.is_some() && !vouched {
                // Damage that is detected in a record may have begun before it.
                part.drop_last();
            }
            (part, fault)
        },
        |part: Columns| {
            columns.append(part);
        },
    )?;
    Ok(Messages { columns, end })
}

fn walk<T: Send>(
    path: &Path,
    kind: LogKind,
    most: u64,
    each: impl Fn(Container, &[u8], bool) -> (T, Option<String>) + Sync,
    merge: impl FnMut(T),
) -> io::Result<End> {
    let container = match kind {
        LogKind::Mcap => Container::Mcap,
        LogKind::Bag => Container::Bag,
    };
    Walk::open(path, container, most)?.run(each, merge)
}
