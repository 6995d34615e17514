//! Decoding of one message by the steps of its definition.

use super::steps::{Number, Slot, Step};

/// Buffer for the numbers of a message until it is known to be complete; reused for the next message.
#[derive(Debug, Default)]
pub struct Row {
    pub floats: Vec<f64>,
    pub exact: i64,
}

/// Position in a message, which never exceeds its end.
pub struct Cursor<'a> {
    pub body: &'a [u8],
    pub at: usize,
    pub big: bool,
    pub aligned: bool,
    pub log_time: u64,
}

impl Cursor<'_> {
    /// Runs all steps; None if the message does not fit them.
    pub fn run(&mut self, steps: &[Step], row: &mut Row) -> Option<()> {
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
                            break; // The count of a body without bytes has no limit.
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
