//! Stretches of a phase relative to one anchor, even if they cross several blocks.

use crate::compensated::Sum;
use crate::phase::Phase;

/// Copies the points `from` … `from + copy.len() − 1` relative to the anchor of the first point, which is
/// returned.
pub fn copy_lifted(phase: &Phase, from: usize, copy: &mut [f64]) -> Sum {
    let anchor = phase.anchors[from / phase.block];
    let mut at = from;
    let mut rest = copy;
    while !rest.is_empty() {
        let count = rest.len().min(phase.block - at % phase.block);
        let (part, tail) = rest.split_at_mut(count);
        let height = phase.anchors[at / phase.block].plus(anchor.negated()).value();
        for (copy, value) in part.iter_mut().zip(&phase.values[at..at + count]) {
            *copy = value + height;
        }
        at += count;
        rest = tail;
    }
    anchor
}
