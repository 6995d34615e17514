//! The parsers of sigmatau: logs to columns of numbers, and columns to text.
//!
//! They know no units, names or sampling rates. The caller reads the head of the file first, describes it by a [`Dialect`]
//! and finds out the meaning of the columns.

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
