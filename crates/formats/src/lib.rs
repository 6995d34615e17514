//! Logs into columns of numbers, and columns into text: the parsers of sigmatau.
//!
//! Bytes in, columns out. No units, no names, no sampling rates: what the columns mean is found out by the caller, who
//! looks at the head of the file first and describes it by a [`Dialect`].

#![forbid(unsafe_code)]

mod dataflash;
pub mod date;
mod decode;
mod progress;
mod remarks;
pub mod ros;
mod rows;
mod sentences;
mod source;
mod table;
mod text;
mod ulog;
mod window;
mod write;

pub use dataflash::{DataFlashKind, DataFlashRows, DataFlashScan, dataflash_columns, scan_dataflash};
pub use decode::{Encoding, Writing, read_written, read_written_file};
pub use progress::bytes_read;
pub use remarks::Remarks;
pub use sentences::{Sentences, read_sentences};
pub use source::open;
pub use table::{Delimiter, Dialect, Table, Tag, TextError};
pub use text::{read_columns, read_file};
pub use ulog::{UlogError, UlogScan, UlogTopic, scan_ulog, ulog_columns};
pub use window::Break;
pub use write::write_columns;
