//! Sums over the pairs of a stretch of starts.

use crate::compensated::Sum;

/// Number of starts whose squares are added without compensation; sums over blocks are compensated.
pub(super) const BLOCK: usize = 1024;

/// Sums over starts.
#[derive(Clone, Copy, Default)]
pub(super) struct Block {
    pub(super) pairs: f64,
    /// Sum of z².
    pub(super) squares: f64,
    /// Sum of z times the distance d of the two mean times, and of d².
    pub(super) products: f64,
    pub(super) distances: f64,
}

/// Mean of the samples that are present; 0 if there are none.
pub(super) fn mean_of(rate: &[f64]) -> f64 {
    let mut total = Sum::default();
    let mut valid = 0.0;
    for &y in rate.iter().filter(|y| !y.is_nan()) {
        total.add(y);
        valid += 1.0;
    }
    if valid > 0.0 { total.value() / valid } else { 0.0 }
}
