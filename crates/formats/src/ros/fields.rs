//! Numbers out of serialised messages: a definition, compiled to the fields that are wanted.
//!
//! CDR (OMG DDS-RTPS 2.2, 10.2: an encapsulation header of four bytes, then numbers aligned to their own size) or the
//! serialisation of ROS 1 (little-endian, without alignment).

use thiserror::Error;

/// A step of a definition as the caller gives it: what (`u1` … `f8`, `time`, `duration`, `utime`, `string`, `[`, `]`,
/// `log_time`, `?`), how many (-1 for a sequence that says so itself), and its first column or -1.
pub type RawStep = (String, i64, i64);

/// A definition that makes no sense.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("unusable step {step} of a message definition: {kind}")]
pub struct ProgramError {
    /// Which step.
    pub step: usize,
    /// Its word.
    pub kind: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
    /// Signed seconds and unsigned nanoseconds, or both signed: ROS 2 and durations.
    Time,
    Duration,
    /// Both unsigned: ROS 1.
    UnsignedTime,
}

impl Number {
    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "u1" => Self::U8,
            "i1" => Self::I8,
            "u2" => Self::U16,
            "i2" => Self::I16,
            "u4" => Self::U32,
            "i4" => Self::I32,
            "u8" => Self::U64,
            "i8" => Self::I64,
            "f4" => Self::F32,
            "f8" => Self::F64,
            "time" => Self::Time,
            "duration" => Self::Duration,
            "utime" => Self::UnsignedTime,
            _ => return None,
        })
    }

    /// Bytes, and the multiple at which they begin in CDR.
    fn size(self) -> (usize, usize) {
        match self {
            Self::U8 | Self::I8 => (1, 1),
            Self::U16 | Self::I16 => (2, 2),
            Self::U32 | Self::I32 | Self::F32 => (4, 4),
            Self::U64 | Self::I64 | Self::F64 => (8, 8),
            Self::Time | Self::Duration | Self::UnsignedTime => (8, 4),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Float(usize),
    Exact,
}

#[derive(Clone, Debug)]
enum Step {
    Skip {
        align: usize,
        bytes: usize,
    },
    Take {
        number: Number,
        slot: Slot,
    },
    LogTime(Slot),
    Strings(usize),
    /// Of numbers: a count, then as many.
    Sequence {
        align: usize,
        bytes: usize,
    },
    StringSequence,
    Repeat {
        count: Option<usize>,
        body: Vec<Step>,
    },
}

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

struct Compiler<'a> {
    wanted: &'a [usize],
    exact: Option<usize>,
}

impl Compiler<'_> {
    fn slot(&self, column: i64) -> Option<Slot> {
        let column = usize::try_from(column).ok()?;
        if self.exact == Some(column) {
            return Some(Slot::Exact);
        }
        let others = self.wanted.iter().filter(|&&w| Some(w) != self.exact);
        others.copied().position(|w| w == column).map(Slot::Float)
    }

    fn number(&self, number: Number, count: i64, column: i64, into: &mut Vec<Step>) {
        let (bytes, align) = number.size();
        let Ok(count) = usize::try_from(count) else {
            into.push(Step::Sequence { align, bytes });
            return;
        };
        if column < 0 {
            skip(into, align, bytes.saturating_mul(count));
            return;
        }
        for k in 0..count as i64 {
            match self.slot(column + k) {
                Some(slot) => into.push(Step::Take { number, slot }),
                None => skip(into, align, bytes),
            }
        }
    }
}

fn skip(into: &mut Vec<Step>, align: usize, bytes: usize) {
    if bytes == 0 {
        return;
    }
    if let Some(Step::Skip { align: last, bytes: already }) = into.last_mut() {
        // Numbers of one size lie side by side.
        if *last == align {
            *already = already.saturating_add(bytes);
            return;
        }
    }
    into.push(Step::Skip { align, bytes });
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
        let compiler = Compiler { wanted, exact };
        let mut stack: Vec<(Option<usize>, Vec<Step>)> = vec![(Some(1), Vec::new())];
        let mut open = false;
        let refused = |step: usize, kind: &str| ProgramError { step, kind: kind.to_owned() };
        for (index, (kind, count, column)) in steps.iter().enumerate() {
            let depth = stack.len();
            let Some((_, into)) = stack.last_mut() else { return Err(refused(index, kind)) };
            match kind.as_str() {
                "[" => stack.push((usize::try_from(*count).ok(), Vec::new())),
                "]" if depth > 1 => {
                    let Some((count, body)) = stack.pop() else { return Err(refused(index, kind)) };
                    let Some((_, into)) = stack.last_mut() else { return Err(refused(index, kind)) };
                    match (count, body.is_empty()) {
                        (Some(0), _) | (Some(_), true) => {}
                        // Only the count of a sequence of nothing is there.
                        (None, true) => skip(into, 4, 4),
                        (count, false) => into.push(Step::Repeat { count, body }),
                    }
                }
                "string" => match usize::try_from(*count) {
                    Ok(0) => {}
                    Ok(count) => into.push(Step::Strings(count)),
                    Err(_) => into.push(Step::StringSequence),
                },
                "log_time" => {
                    if let Some(slot) = compiler.slot(*column) {
                        into.push(Step::LogTime(slot));
                    }
                }
                "?" if depth == 1 => {
                    open = true;
                    break;
                }
                word => {
                    let number = Number::named(word).ok_or_else(|| refused(index, kind))?;
                    compiler.number(number, *count, *column, into);
                }
            }
        }
        match stack.pop() {
            Some((_, steps)) if stack.is_empty() => Ok(Self {
                exact: exact.is_some(),
                floats: wanted.iter().filter(|&&w| Some(w) != exact).count(),
                steps,
                cdr,
                open,
            }),
            _ => Err(refused(steps.len(), "[")),
        }
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

/// Whether a column holds integers.
fn holds_integers(steps: &[RawStep], column: usize) -> bool {
    steps.iter().any(|(kind, count, first)| {
        let inside = usize::try_from(*first)
            .is_ok_and(|first| column >= first && column - first < usize::try_from(*count).unwrap_or(0));
        inside && !matches!(kind.as_str(), "f4" | "f8")
    })
}

/// Where a message is put before all of it is known to be there; kept between messages.
#[derive(Debug, Default)]
pub struct Row {
    floats: Vec<f64>,
    exact: i64,
}

struct Cursor<'a> {
    body: &'a [u8],
    at: usize,
    big: bool,
    aligned: bool,
    log_time: u64,
}

impl Cursor<'_> {
    fn run(&mut self, steps: &[Step], row: &mut Row) -> Option<()> {
        for step in steps {
            match step {
                Step::Skip { align, bytes } => self.skip(*align, *bytes)?,
                Step::Take { number, slot } => self.take(*number, *slot, row)?,
                Step::LogTime(Slot::Exact) => row.exact = i64::try_from(self.log_time).ok()?,
                Step::LogTime(Slot::Float(k)) => *row.floats.get_mut(*k)? = self.log_time as f64,
                Step::Strings(count) => {
                    for _ in 0..*count {
                        self.string()?;
                    }
                }
                Step::StringSequence => {
                    for _ in 0..self.count()? {
                        self.string()?;
                    }
                }
                Step::Sequence { align, bytes } => {
                    let count = self.count()?;
                    if count > 0 {
                        self.skip(*align, bytes.checked_mul(count)?)?;
                    }
                }
                Step::Repeat { count, body } => {
                    let count = match count {
                        Some(count) => *count,
                        None => self.count()?,
                    };
                    for _ in 0..count {
                        let before = self.at;
                        self.run(body, row)?;
                        if self.at == before {
                            break; // It takes nothing, however often it comes: a hostile count may be any.
                        }
                    }
                }
            }
        }
        Some(())
    }

    fn skip(&mut self, align: usize, bytes: usize) -> Option<()> {
        let start = if self.aligned { self.at.checked_next_multiple_of(align)? } else { self.at };
        let end = start.checked_add(bytes)?;
        (end <= self.body.len()).then(|| self.at = end)
    }

    fn bytes<const N: usize>(&mut self, align: usize) -> Option<[u8; N]> {
        self.skip(align, N)?;
        let mut raw: [u8; N] = self.body.get(self.at - N..self.at)?.try_into().ok()?;
        if self.big {
            raw.reverse();
        }
        Some(raw)
    }

    fn count(&mut self) -> Option<usize> {
        Some(u32::from_le_bytes(self.bytes(4)?) as usize)
    }

    fn string(&mut self) -> Option<()> {
        let length = self.count()?;
        self.skip(1, length)
    }

    fn take(&mut self, number: Number, slot: Slot, row: &mut Row) -> Option<()> {
        let (integer, float) = match number {
            Number::F32 => (0, f64::from(f32::from_le_bytes(self.bytes(4)?))),
            Number::F64 => (0, f64::from_le_bytes(self.bytes(8)?)),
            Number::U64 => {
                let value = u64::from_le_bytes(self.bytes(8)?);
                let integer = if slot == Slot::Exact { i64::try_from(value).ok()? } else { 0 };
                (integer, value as f64)
            }
            _ => {
                let value = self.integer(number)?;
                (value, value as f64)
            }
        };
        match slot {
            Slot::Exact => row.exact = integer,
            Slot::Float(k) => *row.floats.get_mut(k)? = float,
        }
        Some(())
    }

    fn integer(&mut self, number: Number) -> Option<i64> {
        const SECOND: i64 = 1_000_000_000;
        Some(match number {
            Number::U8 => self.bytes::<1>(1)?[0].into(),
            Number::I8 => i8::from_le_bytes(self.bytes(1)?).into(),
            Number::U16 => u16::from_le_bytes(self.bytes(2)?).into(),
            Number::I16 => i16::from_le_bytes(self.bytes(2)?).into(),
            Number::U32 => u32::from_le_bytes(self.bytes(4)?).into(),
            Number::I32 => i32::from_le_bytes(self.bytes(4)?).into(),
            Number::I64 => i64::from_le_bytes(self.bytes(8)?),
            Number::Time => {
                let seconds = i64::from(i32::from_le_bytes(self.bytes(4)?));
                seconds * SECOND + i64::from(u32::from_le_bytes(self.bytes(4)?))
            }
            Number::Duration => {
                let seconds = i64::from(i32::from_le_bytes(self.bytes(4)?));
                seconds * SECOND + i64::from(i32::from_le_bytes(self.bytes(4)?))
            }
            Number::UnsignedTime => {
                let seconds = i64::from(u32::from_le_bytes(self.bytes(4)?));
                seconds * SECOND + i64::from(u32::from_le_bytes(self.bytes(4)?))
            }
            Number::U64 | Number::F32 | Number::F64 => return None,
        })
    }
}
