//! The rows of some lines, to which the rows of the following lines are appended.

use super::layout::Layout;
use crate::remarks::Remarks;
use crate::table::{Table, TextError};

/// The rows of some lines, counted from the first of these lines.
#[derive(Debug, Default)]
pub(crate) struct Rows {
    pub(super) columns: Vec<Vec<f64>>,
    pub(super) integers: Option<Vec<i64>>,
    pub(super) done: usize,
    /// Number of lines, including those without a row.
    pub(crate) lines: usize,
    pub(super) first_line: usize,
    /// Number of lines still to be skipped.
    pub(crate) skip: usize,
    /// Whether the first line is the first of the file.
    pub(super) at_start: bool,
    pub(super) remarks: Remarks,
}

impl Layout<'_> {
    /// No rows yet; `at_start`: whether the next lines are the first ones of the file.
    pub(crate) fn rows(&self, at_start: bool) -> Rows {
        Rows {
            columns: vec![Vec::new(); self.wanted],
            integers: self.exact.map(|_| Vec::new()),
            skip: if at_start { self.dialect.skip_lines } else { 0 },
            at_start,
            ..Rows::default()
        }
    }

    /// Removes the rows but keeps the memory, for lines that are not the first ones of the file.
    pub(crate) fn clear(&self, rows: &mut Rows) {
        let (mut columns, mut integers) = (std::mem::take(&mut rows.columns), rows.integers.take());
        columns.iter_mut().for_each(Vec::clear);
        integers.iter_mut().for_each(Vec::clear);
        let integers = integers.or_else(|| self.exact.map(|_| Vec::new()));
        *rows = Rows { columns, integers, ..Rows::default() };
    }
}

impl Rows {
    /// Reserves memory for a number of further rows.
    pub(super) fn room(&mut self, more: usize) -> Result<(), TextError> {
        let refused = |_| TextError::Memory { rows: self.done + more };
        self.columns.iter_mut().try_for_each(|column| column.try_reserve(more)).map_err(refused)?;
        self.integers.iter_mut().try_for_each(|integers| integers.try_reserve(more)).map_err(refused)
    }

    /// Appends the rows of the lines that follow.
    pub(crate) fn append(&mut self, next: &Self) -> Result<(), TextError> {
        self.room(next.done)?;
        for (column, more) in self.columns.iter_mut().zip(&next.columns) {
            column.extend_from_slice(more);
        }
        match (&mut self.integers, &next.integers) {
            (Some(integers), Some(more)) => integers.extend_from_slice(more),
            _ => self.integers = None,
        }
        if self.done == 0 && next.done > 0 {
            self.first_line = self.lines + next.first_line;
        }
        self.remarks.append(&next.remarks, self.lines);
        self.done += next.done;
        self.lines += next.lines;
        Ok(())
    }

    /// An error of the following lines, with lines and rows counted from the first of these lines.
    pub(crate) fn moved(&self, error: TextError) -> TextError {
        error.moved(self.lines, self.done)
    }

    pub(crate) fn finish(mut self) -> Result<Table, TextError> {
        if self.done == 0 {
            return Err(TextError::Empty);
        }
        self.columns.iter_mut().for_each(Vec::shrink_to_fit);
        self.integers.iter_mut().for_each(Vec::shrink_to_fit);
        Ok(Table {
            columns: self.columns,
            integers: self.integers,
            rows: self.done,
            first_line: self.first_line,
            remarks: self.remarks,
            open_end: false,
        })
    }
}
