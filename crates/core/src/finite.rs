//! Whether samples are numbers.

use rayon::prelude::*;

/// Sums that run side by side.
const LANES: usize = 16;

/// Samples below which no other thread is woken.
const WORTH_THREADS: usize = 1 << 18;

/// For each of several columns, whether all of it is finite. Works on the current rayon pool, on one column a thread.
#[must_use]
pub fn all_finite(columns: &[&[f64]]) -> Vec<bool> {
    let samples: usize = columns.iter().map(|column| column.len()).sum();
    if samples < WORTH_THREADS {
        columns.iter().map(|column| is_finite(column)).collect()
    } else {
        columns.par_iter().with_max_len(1).map(|column| is_finite(column)).collect()
    }
}

/// Nothing times a number is nothing; times a NaN or an infinity it is NaN, and stays so in the sum.
fn is_finite(column: &[f64]) -> bool {
    let mut lanes = [0.0; LANES];
    let chunks = column.chunks_exact(LANES);
    let rest: f64 = chunks.remainder().iter().map(|y| y * 0.0).sum();
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, y)| *lane += y * 0.0);
    }
    (lanes.iter().sum::<f64>() + rest).is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_of_any_column_is_seen() {
        for n in [1, LANES - 1, LANES, 1000, WORTH_THREADS] {
            let good = vec![-f64::MAX; n];
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
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
