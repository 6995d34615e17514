//! Stretches of a phase that refer to one anchor, however many blocks they cross.

use crate::compensated::Sum;
use crate::phase::{BLOCK, Phase};

/// Copies the points `from` … `from + copy.len() − 1`, relative to the anchor that is returned: that of the first.
pub fn copy_lifted(phase: &Phase, from: usize, copy: &mut [f64]) -> Sum {
    let anchor = phase.anchors[from / BLOCK];
    let mut at = from;
    let mut rest = copy;
    while !rest.is_empty() {
        let count = rest.len().min(BLOCK - at % BLOCK);
        let (part, tail) = rest.split_at_mut(count);
        let height = phase.anchors[at / BLOCK].plus(anchor.negated()).value();
        for (copy, value) in part.iter_mut().zip(&phase.values[at..at + count]) {
            *copy = value + height;
        }
        at += count;
        rest = tail;
    }
    anchor
}

/// The rate that was taken out of a phase before it was summed: its mean over the first samples.
pub fn slope(phase: &Phase, rate: &[f64]) -> f64 {
    let count = rate.len().min(BLOCK);
    if count == 0 {
        return 0.0;
    }
    let mut sum = Sum::default();
    rate[..count].iter().for_each(|&y| sum.add(y));
    let left = phase.anchors[count / BLOCK].plus(Sum { hi: phase.values[count], lo: 0.0 });
    sum.normalized().plus(left.negated()).value() / count as f64
}
