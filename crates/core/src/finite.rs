//! Tests of whether samples are finite.

use crate::parallel::prelude::*;

/// Number of sums that run side by side.
const LANES: usize = 16;

/// Number of samples that are read before the test of their sum.
const PIECE: usize = 1024;

/// Number of samples below which no other thread is started.
const WORTH_THREADS: usize = 1 << 18;

/// Factor with which magnitudes above 1.8e140 overflow.
const TO_INFINITY: f64 = 1e168;

/// For each column, whether all numbers are finite and at most 1e140 in magnitude. Works on the current rayon
/// pool, with one thread per column.
#[must_use]
pub fn all_finite(columns: &[&[f64]]) -> Vec<bool> {
    let samples: usize = columns.iter().map(|column| column.len()).sum();
    if samples < WORTH_THREADS {
        columns.iter().map(|column| is_finite(column)).collect()
    } else {
        columns.par_iter().with_max_len(1).map(|column| is_finite(column)).collect()
    }
}

/// Tests a sum of products, because NaN and infinity persist in a sum.
fn is_finite(column: &[f64]) -> bool {
    let mut lanes = [0.0; LANES];
    let chunks = column.chunks_exact(LANES);
    let rest: f64 = chunks.remainder().iter().map(|y| y * TO_INFINITY).sum();
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, y)| *lane += y * TO_INFINITY);
    }
    (lanes.iter().sum::<f64>() + rest).is_finite()
}

/// Index of the first sample that is NaN or exceeds `largest` in magnitude.
#[must_use]
pub(crate) fn first_beyond(samples: &[f64], largest: f64) -> Option<usize> {
    let usable = |y: &f64| y.abs() <= largest;
    // Without a branch for each sample.
    let all_usable = |piece: &[f64]| piece.iter().fold(true, |all, y| all & usable(y));
    let piece = samples.chunks(PIECE).position(|piece| !all_usable(piece))?;
    samples[piece * PIECE..].iter().position(|y| !usable(y)).map(|index| piece * PIECE + index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_unusable_sample() {
        for n in [1, PIECE, 3 * PIECE + 5] {
            assert_eq!(first_beyond(&vec![-2.0; n], 2.0), None);
            for at in [0, n / 2, n - 1] {
                for bad in [f64::NAN, f64::NEG_INFINITY, 2.1] {
                    let mut samples = vec![-2.0; n];
                    (samples[at], samples[n - 1]) = (bad, bad);
                    assert_eq!(first_beyond(&samples, 2.0), Some(at), "{n} {bad}");
                }
            }
        }
    }

    #[test]
    fn one_sample_of_any_column_is_seen() {
        for n in [1, LANES - 1, LANES, 1000, WORTH_THREADS] {
            let good = vec![-1e120; n];
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -2e140] {
                for at in [0, n / 2, n - 1] {
                    let mut column = good.clone();
                    column[at] = bad;
                    assert_eq!(all_finite(&[&good, &column, &good]), [true, false, true], "{n} {at}");
                }
            }
        }
        assert_eq!(all_finite(&[&[]]), [true]);
        assert!(all_finite(&[]).is_empty());
    }
}
