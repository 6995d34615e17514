//! Numbers out of serialised messages: a definition, compiled to the fields that are wanted.
//!
//! CDR (OMG DDS-RTPS 2.2, 10.2: an encapsulation header of four bytes, then numbers aligned to their own size) or the
//! serialisation of ROS 1 (little-endian, without alignment).

use super::cursor::{Cursor, Row};
use super::steps::{self, ProgramError, RawStep, Step, holds_integers};

/// Columns of numbers, all of one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Those that were wanted, without the exact one.
    pub floats: Vec<Vec<f64>>,
    /// The one that was wanted as integers, if it holds such.
    pub exact: Option<Vec<i64>>,
    /// Their length.
    pub rows: usize,
}

impl Columns {
    /// Takes the last row away, if there is one.
    pub fn drop_last(&mut self) {
        for column in &mut self.floats {
            column.pop();
        }
        if let Some(exact) = &mut self.exact {
            exact.pop();
        }
        self.rows = self.rows.saturating_sub(1);
    }

    /// Puts the rows of another behind its own.
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
    /// What comes behind the last step is unknown.
    open: bool,
}

impl Program {
    /// Compiles the steps of a definition to the columns that are wanted, of which one may be wanted as integers.
    ///
    /// # Errors
    /// For a word that is unknown, and for brackets that do not match.
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

    /// Columns without rows.
    #[must_use]
    pub fn columns(&self) -> Columns {
        Columns { floats: vec![Vec::new(); self.floats], exact: self.exact.then(Vec::new), rows: 0 }
    }

    /// Adds a message as a row; false, and no row, if it does not hold what the definition says.
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
        // Some writers fill up to a multiple of four or eight.
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

    /// Decodes messages that lie one after the other in `data`, each up to its end; stops at the first that does not
    /// hold what the definition says.
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
