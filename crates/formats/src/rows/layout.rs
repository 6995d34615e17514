//! A dialect, and which of its columns are wanted.

use super::field::nth;
use super::line::BOM;
use crate::table::{Delimiter, Dialect};

/// A dialect, and what is wanted of it.
pub(crate) struct Layout<'a> {
    pub(crate) dialect: &'a Dialect,
    pub(super) wanted: usize,
    /// For each column of the file, its place among the wanted ones.
    pub(super) places: Vec<Option<usize>>,
    pub(super) exact: Option<usize>,
    /// Whether rows of bare numbers can be told without looking at the whole line first.
    pub(crate) quick: bool,
}

impl<'a> Layout<'a> {
    pub(crate) fn new(dialect: &'a Dialect, wanted: &[usize], exact: Option<usize>) -> Self {
        let mut places = vec![None; dialect.columns];
        for (place, &column) in wanted.iter().enumerate() {
            assert!(column < dialect.columns, "column {column} of {}", dialect.columns);
            assert!(places[column].is_none(), "column {column} is wanted twice");
            places[column] = Some(place);
        }
        let parted =
            matches!(dialect.delimiter, Delimiter::Whitespace | Delimiter::Byte(b',' | b';' | b'\t' | b'|'));
        // A comment must not look like a number, or like nothing.
        let comments =
            dialect.comment.iter().all(|c| c.first().is_some_and(|b| !b"+-.0123456789 \t\r".contains(b)));
        let exact_is_wanted = exact.is_none_or(|column| wanted.contains(&column));
        let quick = parted && comments && exact_is_wanted && !dialect.arrow;
        Self { dialect, wanted: wanted.len(), places, exact, quick }
    }
    /// Whether a line is of the kind that is read.
    pub(super) fn is_tagged(&self, line: &[u8]) -> bool {
        let line = line.strip_prefix(BOM).unwrap_or(line);
        self.dialect.tag.as_ref().is_none_or(|tag| {
            nth(line, self.dialect.delimiter, tag.column).is_some_and(|text| text == tag.text)
        })
    }
}
