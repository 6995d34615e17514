//! Whitening by a covariance: elimination with its Cholesky factor, together with the columns.
//!
//! The matrices of a fit are small and are factored thousands of times. This code costs less than a call to a library that
//! manages threads, and it gives the same bits on every machine, because no sum is divided into lanes.

use crate::gls::Failed;
use crate::gls::lanes::add_rows;
use pulp::{Arch, Simd, WithSimd};

/// Share of a variance that must remain after elimination of the previous rows for the matrix to be positive definite.
const MIN_SHARE: f64 = 4.0 * f64::EPSILON;

/// Rows are padded to a multiple of this length.
const ROW_MULTIPLE: usize = 8;

/// Shares of the variances that are added in turn to the diagonal of a matrix that rounding has made indefinite.
const RIDGES: [f64; 5] = [0.0, 1e-12, 1e-10, 1e-8, 1e-6];

/// The factor L of a covariance L Lᵀ, and L⁻¹ B for columns B.
#[derive(Debug, Default)]
pub(crate) struct Whitened {
    order: usize,
    width: usize,
    /// Length of a row.
    stride: usize,
    /// Rows of Lᵀ, each followed by its row of L⁻¹ B.
    rows: Vec<f64>,
}

impl Whitened {
    /// Factors a covariance, given by its upper triangle in row order; `fill` writes a row of `width` numbers.
    ///
    /// # Errors
    ///
    /// [`Failed`] if a variance is not positive, or no small ridge makes the matrix positive definite.
    pub(crate) fn take(
        &mut self,
        covariance: &[f64],
        order: usize,
        width: usize,
        fill: impl Fn(usize, &mut [f64]),
    ) -> Result<(), Failed> {
        if covariance.iter().step_by(order + 1).any(|variance| !(*variance > 0.0 && variance.is_finite())) {
            return Err(Failed);
        }
        let mut ridge = 0.0;
        for step in RIDGES {
            ridge += step;
            if self.take_definite(covariance, order, width, ridge, &fill) {
                return Ok(());
            }
        }
        Err(Failed)
    }

    /// [`Self::take`] with one ridge; returns whether the matrix is positive definite.
    pub(crate) fn take_definite(
        &mut self,
        covariance: &[f64],
        order: usize,
        width: usize,
        ridge: f64,
        fill: impl Fn(usize, &mut [f64]),
    ) -> bool {
        let end = order + width;
        (self.order, self.width, self.stride) = (order, width, end.next_multiple_of(ROW_MULTIPLE));
        self.rows.resize(order * self.stride, 0.0);
        let rows = self.rows.chunks_exact_mut(self.stride).zip(covariance.chunks_exact(order));
        for (i, (row, covariance)) in rows.enumerate() {
            row[i..order].copy_from_slice(&covariance[i..]);
            row[i] *= 1.0 + ridge;
            fill(i, &mut row[order..end]);
        }
        Arch::new().dispatch(Elimination { rows: &mut self.rows, order, stride: self.stride })
    }

    /// ln of the determinant.
    pub(crate) fn log_determinant(&self) -> f64 {
        2.0 * self.rows.iter().step_by(self.stride + 1).map(|pivot| pivot.ln()).sum::<f64>()
    }

    /// The whitened columns in row order.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.chunks_exact(self.stride).map(|row| &row[self.order..self.order + self.width])
    }

    /// L⁻ᵀ r in place: weights on whitened data become weights on the data.
    pub(crate) fn unwhiten(&self, weights: &mut [f64]) {
        let order = self.order;
        for (i, row) in self.rows.chunks_exact(self.stride).enumerate().rev() {
            let known: f64 = row[i + 1..order].iter().zip(&weights[i + 1..]).map(|(u, x)| u * x).sum();
            weights[i] = (weights[i] - known) / row[i];
        }
    }
}

/// Factors the upper triangle in the first `order` columns of rows of length `stride`; true if it is positive definite. The
/// rows become those of the factor, and the other columns are multiplied by its inverse.
struct Elimination<'a> {
    rows: &'a mut [f64],
    order: usize,
    stride: usize,
}

impl WithSimd for Elimination<'_> {
    type Output = bool;

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for these vectors.
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { rows, order, stride } = self;
        for k in 0..order {
            // Begins with the vector that includes the diagonal; earlier elements of the rows are not used.
            let from = k - k % S::F64_LANES;
            let (before, rest) = rows.split_at_mut(k * stride);
            let row = &mut rest[from..stride];
            let variance = row[k - from];
            let known = before.chunks_exact(stride).map(|known| (-known[k], &known[from..]));
            add_rows(simd, row, &known);
            let square = row[k - from];
            if square.is_nan() || square <= MIN_SHARE * variance {
                return false;
            }
            let factor = 1.0 / square.sqrt();
            for x in row.iter_mut() {
                *x *= factor;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Correlations 0.9^|i − j| and standard deviations over twelve decades.
    fn covariance(order: usize) -> Vec<f64> {
        let sd = |i: usize| 10f64.powf(-12.0 * i as f64 / order as f64);
        let cell = |k: usize| {
            let (i, j) = (k / order, k % order);
            0.9f64.powi(i.abs_diff(j) as i32) * sd(i) * sd(j)
        };
        (0..order * order).map(cell).collect()
    }

    #[test]
    fn whitened_by_its_own_factor() {
        for order in [1, 2, 7, 8, 9, 40] {
            let v = covariance(order);
            let mut found = Whitened::default();
            // L⁻¹ V is Lᵀ: its product with its transpose, V again.
            found.take(&v, order, order, |i, row| row.copy_from_slice(&v[i * order..][..order])).unwrap();
            for i in 0..order {
                for j in 0..order {
                    let sum: f64 = found.rows().map(|row| row[i] * row[j]).sum();
                    let expected = v[i * order + j];
                    assert!((sum / expected - 1.0).abs() < 1e-12, "{order} {i} {j}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn unwhitened_weights_give_the_same_sum() {
        let order = 23;
        let v = covariance(order);
        let data: Vec<f64> = (0..order).map(|k| (k as f64).sin() * v[k * (order + 1)].sqrt()).collect();
        let mut found = Whitened::default();
        found.take(&v, order, 1, |i, row| row[0] = data[i]).unwrap();
        let row: Vec<f64> = (0..order).map(|k| (k as f64).cos()).collect();
        let mut weights = row.clone();
        found.unwhiten(&mut weights);
        let whitened: f64 = row.iter().zip(found.rows()).map(|(r, x)| r * x[0]).sum();
        let direct: f64 = weights.iter().zip(&data).map(|(w, x)| w * x).sum();
        assert!((whitened - direct).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        for wrong in [[0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0], [1.0, 2.0, 2.0, 1.0]] {
            assert!(Whitened::default().take(&wrong, 2, 0, |_, _| ()).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn a_singular_matrix_is_taken_with_a_ridge() {
        let mut found = Whitened::default();
        found.take(&[1.0, 1.0, 1.0, 1.0], 2, 1, |i, row| row[0] = 1.0 + i as f64).unwrap();
        assert!(found.rows().all(|row| row[0].is_finite()));
    }
}
