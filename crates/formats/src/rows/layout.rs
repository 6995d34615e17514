//! A dialect with the wanted columns.

use super::field::nth;
use super::line::BOM;
use crate::table::Dialect;

/// A dialect, its wanted columns and the exact one.
pub(crate) struct Layout<'a> {
    pub(crate) dialect: &'a Dialect,
    pub(super) wanted: usize,
    /// Index among the wanted columns of each column of the file.
    pub(super) places: Vec<Option<usize>>,
    pub(super) exact: Option<usize>,
}

impl<'a> Layout<'a> {
    pub(crate) fn new(dialect: &'a Dialect, wanted: &[usize], exact: Option<usize>) -> Self {
        let mut places = vec![None; dialect.columns];
        for (place, &column) in wanted.iter().enumerate() {
            assert!(column < dialect.columns, "column {column} of {}", dialect.columns);
            assert!(places[column].is_none(), "column {column} is wanted twice");
            places[column] = Some(place);
        }
        Self { dialect, wanted: wanted.len(), places, exact }
    }
    /// Whether a line has the tag of the rows to be read.
    pub(super) fn is_tagged(&self, line: &[u8]) -> bool {
        let line = line.strip_prefix(BOM).unwrap_or(line);
        self.dialect.tag.as_ref().is_none_or(|tag| {
            nth(line, self.dialect.delimiter, tag.column).is_some_and(|text| text == tag.text)
        })
    }
}
