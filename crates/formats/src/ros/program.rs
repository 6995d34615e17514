//! Decoding of serialised messages: a definition, compiled to the wanted fields.
//!
//! CDR (OMG DDS-RTPS 2.2, 10.2: an encapsulation header of four bytes, then numbers aligned to their own size) or the
//! serialisation of ROS 1 (little-endian, without alignment).

use super::cursor::{Cursor, Row};
use super::steps::{self, ProgramError, RawStep, Step, holds_integers};

/// Columns of numbers with equal lengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// The wanted columns without the exact one.
    pub floats: Vec<Vec<f64>>,
    /// The column wanted as integers, if it contains integers.
    pub exact: Option<Vec<i64>>,
    /// Number of rows.
    pub rows: usize,
}

impl Columns {
    /// Removes the last row, if there is one.
    pub fn drop_last(&mut self) {
        for column in &mut self.floats {
            column.pop();
        }
        if let Some(exact) = &mut self.exact {
            exact.pop();
        }
        self.rows = self.rows.saturating_sub(1);
    }

    /// Appends the rows of other columns.
    pub fn append(&mut self, other: Self) {
        for (mine, theirs) in self.floats.iter_mut().zip(other.floats) {
            mine.extend(theirs);
        }
        if let (Some(mine), Some(theirs)) = (&mut self.exact, other.exact) {
            mine.extend(theirs);
        }
        self.rows += other.rows;
    }
}

/// A definition, compiled.
#[derive(Clone, Debug)]
pub struct Program {
    steps: Vec<Step>,
    cdr: bool,
    floats: usize,
    exact: bool,
    /// Whether the content after the last step is unknown.
    open: bool,
}

impl Program {
    /// Compiles the steps of a definition for the wanted columns; one of them may be read as integers.
    ///
    /// # Errors
    /// For an unknown word, and for brackets that do not match.
    pub fn compile(
        steps: &[RawStep],
        cdr: bool,
        wanted: &[usize],
        exact: Option<usize>,
    ) -> Result<Self, ProgramError> {
        let exact = exact.filter(|&column| holds_integers(steps, column));
        let (steps, open) = steps::compile(steps, wanted, exact)?;
        Ok(Self {
            exact: exact.is_some(),
            floats: wanted.iter().filter(|&&w| Some(w) != exact).count(),
            steps,
            cdr,
            open,
        })
    }

    /// Empty columns.
    #[must_use]
    pub fn columns(&self) -> Columns {
        Columns { floats: vec![Vec::new(); self.floats], exact: self.exact.then(Vec::new), rows: 0 }
    }

    /// Adds a message as a row; false, without a row, if it does not match the definition.
    pub fn push(&self, message: &[u8], log_time: u64, row: &mut Row, columns: &mut Columns) -> bool {
        let (body, big) = match (self.cdr, message) {
            (false, _) => (message, false),
            (true, [0, order @ (0 | 1), _, _, body @ ..]) => (body, *order == 0),
            _ => return false,
        };
        row.floats.clear();
        row.floats.resize(self.floats, 0.0);
        row.exact = 0;
        let mut cursor = Cursor { body, at: 0, big, aligned: self.cdr, log_time };
        if cursor.run(&self.steps, row).is_none() {
            return false;
        }
        // Some writers pad to a multiple of four or eight.
        let rest = body.len() - cursor.at;
        if !self.open && rest > if self.cdr { 7 } else { 0 } {
            return false;
        }
        for (column, &value) in columns.floats.iter_mut().zip(&row.floats) {
            column.push(value);
        }
        if let Some(exact) = &mut columns.exact {
            exact.push(row.exact);
        }
        columns.rows += 1;
        true
    }

    /// Decodes the concatenated messages in `data`, each up to its end; stops at the first that does not match the
    /// definition.
    pub fn decode(&self, data: &[u8], ends: &[usize], log_times: &[i64], columns: &mut Columns) -> bool {
        let mut row = Row::default();
        let mut start = 0;
        for (&end, &time) in ends.iter().zip(log_times) {
            let Some(message) = data.get(start..end) else { return false };
            if !self.push(message, time as u64, &mut row, columns) {
                return false;
            }
            start = end;
        }
        true
    }
}
