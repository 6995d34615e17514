//! The sums of a stage as words of 64 bits, so that another process can continue them bit for bit.

use super::{Part, REACH, STARTS, Stage};
use crate::compensated::Sum;

impl Stage {
    /// Appends the sums of this stage and of the following stages.
    pub(in crate::stream) fn write(&self, words: &mut Vec<u64>) {
        words.extend([self.count, self.done, u64::from(self.origin.is_some())]);
        words.push(self.origin.unwrap_or_default().to_bits());
        for part in [&self.lead, &self.trail] {
            words.extend([part.sum.to_bits(), part.count as u64]);
        }
        words.extend(self.totals.iter().flat_map(|total| [total.hi.to_bits(), total.lo.to_bits()]));
        for samples in [&self.head, &self.pending] {
            words.push(samples.len() as u64);
            words.extend(samples.iter().map(|y| y.to_bits()));
        }
        if let Some(next) = &self.next {
            next.write(words);
        }
    }

    /// Restores the output of [`Stage::write`] for the same sizes and the same first sample. `None` for other words;
    /// this stage must then not be used.
    pub(in crate::stream) fn read(&mut self, words: &mut impl Iterator<Item = u64>) -> Option<()> {
        (self.count, self.done) = (words.next()?, words.next()?);
        let has_origin = words.next()? == 1;
        let origin = number(words)?;
        self.origin = has_origin.then_some(origin);
        for part in [&mut self.lead, &mut self.trail] {
            *part = Part { sum: number(words)?, count: usize::try_from(words.next()?).ok()? };
        }
        for total in &mut self.totals {
            *total = Sum { hi: number(words)?, lo: number(words)? };
        }
        self.head = numbers(words, REACH)?;
        self.pending = numbers(words, STARTS + REACH)?;
        self.next.as_mut().map_or(Some(()), |next| next.read(words))
    }
}

fn number(words: &mut impl Iterator<Item = u64>) -> Option<f64> {
    Some(f64::from_bits(words.next()?)).filter(|number| number.is_finite())
}

fn numbers(words: &mut impl Iterator<Item = u64>, most: usize) -> Option<Vec<f64>> {
    let count = usize::try_from(words.next()?).ok().filter(|&count| count <= most)?;
    (0..count).map(|_| number(words)).collect()
}
