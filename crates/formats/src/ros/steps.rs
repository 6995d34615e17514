//! A definition of messages, compiled to steps that decode a message.

use thiserror::Error;

/// A step of a definition from the caller: kind (`u1` … `f8`, `time`, `duration`, `utime`, `string`, `[`, `]`,
/// `log_time`, or `?` before content that is unknown), count (-1 for a sequence with a count in the message), and its
/// first column or -1.
pub type RawStep = (String, i64, i64);

/// An invalid definition.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("unusable step {step} of a message definition: {kind}")]
pub struct ProgramError {
    /// Index of the step.
    pub step: usize,
    /// Kind of the step.
    pub kind: String,
}

/// Type of a number in a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
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
    /// Signed seconds and unsigned nanoseconds: a time of ROS 2.
    Time,
    Duration,
    /// Unsigned seconds and nanoseconds: a time of ROS 1.
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

    /// Size and, in CDR, alignment.
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

/// Destination of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    Float(usize),
    Exact,
}

/// Action on the next bytes of a message.
#[derive(Clone, Debug)]
pub enum Step {
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
    /// A count, then as many numbers.
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

/// The steps that read the wanted columns, and whether the content after the last step is unknown.
pub fn compile(
    steps: &[RawStep],
    wanted: &[usize],
    exact: Option<usize>,
) -> Result<(Vec<Step>, bool), ProgramError> {
    let compiler = Compiler { wanted, exact };
    let mut stack: Vec<(Option<usize>, Vec<Step>)> = vec![(Some(1), Vec::new())];
    let mut has_unknown_rest = false;
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
                    // Of a sequence with an empty body, a message contains only the count.
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
                has_unknown_rest = true;
                break;
            }
            word => {
                let number = Number::named(word).ok_or_else(|| refused(index, kind))?;
                compiler.number(number, *count, *column, into);
            }
        }
    }
    match stack.pop() {
        Some((_, steps)) if stack.is_empty() => Ok((steps, has_unknown_rest)),
        _ => Err(refused(steps.len(), "[")),
    }
}

/// Whether a column contains integers.
pub fn holds_integers(steps: &[RawStep], column: usize) -> bool {
    steps.iter().any(|(kind, count, first)| {
        let inside = usize::try_from(*first)
            .is_ok_and(|first| column >= first && column - first < usize::try_from(*count).unwrap_or(0));
        inside && !matches!(kind.as_str(), "f4" | "f8")
    })
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
        let floats = self.wanted.iter().filter(|&&w| Some(w) != self.exact);
        floats.copied().position(|w| w == column).map(Slot::Float)
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
        // There is no padding between numbers of equal alignment.
        if *last == align {
            *already = already.saturating_add(bytes);
            return;
        }
    }
    into.push(Step::Skip { align, bytes });
}
