//! Logs into columns of numbers, and columns into text: the parsers of sigmatau.
//!
//! Bytes in, columns out. No units, no names, no sampling rates: what the columns mean is found out by the caller, who
//! looks at the head of the file first and describes it by a [`Dialect`].

#![forbid(unsafe_code)]

mod number;
mod pieces;
pub mod ros;
mod rows;
mod text;
mod write;

pub use text::{Delimiter, Dialect, Table, TextError, open, read_columns, read_file};
pub use write::{write_columns, write_file};
