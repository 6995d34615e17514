//! Whitening by a covariance: elimination with the Cholesky factor of its correlation, together with the columns.
//!
//! The matrices of a fit are small, and are taken apart thousands of times: this costs less than a call to a library
//! that thinks about threads, and gives the same bits on every machine, because no sum is split into lanes.

use crate::gls::Failed;

/// What is added to the diagonal of a correlation matrix that rounding has made indefinite, one after the other.
const RIDGES: [f64; 5] = [0.0, 1e-12, 1e-10, 1e-8, 1e-6];

/// A covariance S·(L Lᵀ)·S with the standard deviations S and the lower factor L of the correlation; L⁻¹ S⁻¹ B for
/// columns B of numbers.
#[derive(Debug, Default)]
pub(crate) struct Whitened {
    order: usize,
    width: usize,
    /// 1/S.
    precision: Vec<f64>,
    /// Rows of Lᵀ, each followed by its row of L⁻¹ S⁻¹ B.
    rows: Vec<f64>,
}

impl Whitened {
    /// Takes a covariance apart, given by its upper triangle, row after row; `fill` writes a row of `width` numbers.
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
        self.scale(covariance, order, width)?;
        let mut ridge = 0.0;
        for step in RIDGES {
            ridge += step;
            self.begin(covariance, ridge, &fill);
            if eliminated(&mut self.rows, order, order + width) {
                return Ok(());
            }
        }
        Err(Failed)
    }

    /// The same without a ridge, for correlations; whether the matrix is positive definite.
    pub(crate) fn take_definite(
        &mut self,
        correlation: &[f64],
        order: usize,
        width: usize,
        fill: impl Fn(usize, &mut [f64]),
    ) -> bool {
        if self.scale(correlation, order, width).is_err() {
            return false;
        }
        self.begin(correlation, 0.0, &fill);
        eliminated(&mut self.rows, order, order + width)
    }

    /// ln of the determinant of the correlations.
    pub(crate) fn log_determinant(&self) -> f64 {
        2.0 * self.rows.iter().step_by(self.order + self.width + 1).map(|pivot| pivot.ln()).sum::<f64>()
    }

    fn scale(&mut self, covariance: &[f64], order: usize, width: usize) -> Result<(), Failed> {
        (self.order, self.width) = (order, width);
        self.precision.clear();
        for variance in covariance.iter().step_by(order + 1) {
            if !(*variance > 0.0 && variance.is_finite()) {
                return Err(Failed);
            }
            self.precision.push(1.0 / variance.sqrt());
        }
        self.rows.resize(order * (order + width), 0.0);
        Ok(())
    }

    /// Writes correlations and scaled columns.
    fn begin(&mut self, covariance: &[f64], ridge: f64, fill: &impl Fn(usize, &mut [f64])) {
        let order = self.order;
        let rows = self.rows.chunks_exact_mut(order + self.width).zip(covariance.chunks_exact(order));
        for (i, (row, covariance)) in rows.enumerate() {
            let own = self.precision[i];
            let cells = row[i..order].iter_mut().zip(&covariance[i..]).zip(&self.precision[i..]);
            cells.for_each(|((cell, value), other)| *cell = value * (own * other));
            row[i] = 1.0 + ridge;
            fill(i, &mut row[order..]);
            row[order..].iter_mut().for_each(|x| *x *= own);
        }
    }

    /// The whitened columns, row after row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.rows.chunks_exact(self.order + self.width).map(|row| &row[self.order..])
    }

    /// S⁻¹ L⁻ᵀ r in place: weights on whitened data become weights on the data.
    pub(crate) fn unwhiten(&self, weights: &mut [f64]) {
        let order = self.order;
        for (i, row) in self.rows.chunks_exact(order + self.width).enumerate().rev() {
            let known: f64 = row[i + 1..order].iter().zip(&weights[i + 1..]).map(|(u, x)| u * x).sum();
            weights[i] = (weights[i] - known) / row[i];
        }
        weights.iter_mut().zip(&self.precision).for_each(|(x, precision)| *x *= precision);
    }
}

/// Whether the upper triangle in the first `order` columns of rows of length `stride` is positive definite; if it is,
/// the rows become those of its factor, and the other columns are divided by it.
fn eliminated(rows: &mut [f64], order: usize, stride: usize) -> bool {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(Elimination { rows, order, stride });
    }
    eliminate(rows, order, stride)
}

/// [`eliminate`] for the vectors that `pulp` compiles it for.
#[cfg(target_arch = "x86_64")]
struct Elimination<'a> {
    rows: &'a mut [f64],
    order: usize,
    stride: usize,
}

#[cfg(target_arch = "x86_64")]
impl pulp::NullaryFnOnce for Elimination<'_> {
    type Output = bool;

    #[inline(always)]
    #[allow(clippy::inline_always)] // Into a function that is compiled for those vectors.
    fn call(self) -> bool {
        eliminate(self.rows, self.order, self.stride)
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn eliminate(rows: &mut [f64], order: usize, stride: usize) -> bool {
    for k in 0..order {
        let (before, rest) = rows.split_at_mut(k * stride);
        let row = &mut rest[k..stride];
        let groups = before.chunks_exact(4 * stride);
        for known in groups.remainder().chunks_exact(stride) {
            let factor = known[k];
            row.iter_mut().zip(&known[k..]).for_each(|(x, u)| *x -= factor * u);
        }
        for group in groups {
            let known: [&[f64]; 4] = std::array::from_fn(|i| &group[i * stride..][k..stride]);
            subtract(row, known);
        }
        let square = row[0];
        if square.is_nan() || square <= 4.0 * f64::EPSILON {
            return false;
        }
        let factor = 1.0 / square.sqrt();
        row.iter_mut().for_each(|x| *x *= factor);
    }
    true
}

/// Subtracts from a row four others, each times its first number.
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn subtract(row: &mut [f64], [a, b, c, d]: [&[f64]; 4]) {
    let (p, q, r, s) = (a[0], b[0], c[0], d[0]);
    for ((((x, a), b), c), d) in row.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        *x -= (p * a + q * b) + (r * c + s * d);
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
            // L⁻¹ S⁻¹ V is Lᵀ S: its product with its transpose, V again.
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
