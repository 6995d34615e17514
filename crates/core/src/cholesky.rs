//! Whitening by a covariance: its Cholesky factor, scaled so that variances of any ratio keep their digits.
//!
//! The matrices of a fit are small, and are taken apart thousands of times: this costs less than a call to a library
//! that thinks about threads, and gives the same bits on every machine.

use crate::error::Error;

/// What is added to the diagonal of a correlation matrix that rounding has made indefinite, one after the other.
const RIDGES: [f64; 5] = [0.0, 1e-12, 1e-10, 1e-8, 1e-6];

/// A covariance S·(L Lᵀ)·S with the standard deviations S and the lower factor L of the correlation.
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    sd: Vec<f64>,
    /// L, row after row.
    lower: Vec<f64>,
}

impl Factor {
    /// Takes a covariance apart, given row after row; its lower triangle is used.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] with the name `covariance` if a variance is not positive, or no small ridge makes the
    /// matrix positive definite.
    ///
    /// # Panics
    ///
    /// If `covariance` has not `order`² elements.
    pub fn new(covariance: &[f64], order: usize) -> Result<Self, Error> {
        assert_eq!(covariance.len(), order * order, "a square matrix");
        let variances = covariance.iter().step_by(order + 1);
        let wrong = |value: f64| Error::Parameter { name: "covariance", value };
        if let Some(&value) = variances.clone().find(|&&v| !(v > 0.0 && v.is_finite())) {
            return Err(wrong(value));
        }
        let sd: Vec<f64> = variances.map(|v| v.sqrt()).collect();
        let mut ridge = 0.0;
        for step in RIDGES {
            ridge += step;
            if let Some(lower) = correlation_factor(covariance, &sd, ridge) {
                return Ok(Self { sd, lower });
            }
        }
        Err(wrong(f64::NAN))
    }

    /// Standard deviations.
    #[must_use]
    pub fn sd(&self) -> &[f64] {
        &self.sd
    }

    /// L⁻¹ S⁻¹ B in place, for B of any number of columns, row after row: columns of errors become independent.
    ///
    /// # Panics
    ///
    /// If the number of elements is no multiple of the order.
    pub fn whiten(&self, columns: &mut [f64]) {
        let order = self.sd.len();
        assert_eq!(columns.len() % order, 0, "whole columns");
        let width = columns.len() / order;
        for i in 0..order {
            let (before, rest) = columns.split_at_mut(i * width);
            let row = &mut rest[..width];
            for x in row.iter_mut() {
                *x /= self.sd[i];
            }
            let factors = &self.lower[i * order..][..=i];
            for (factor, known) in factors.iter().zip(before.chunks_exact(width)) {
                row.iter_mut().zip(known).for_each(|(x, known)| *x -= factor * known);
            }
            for x in row {
                *x /= factors[i];
            }
        }
    }

    /// S⁻¹ L⁻ᵀ r in place: weights on whitened data become weights on the data.
    ///
    /// # Panics
    ///
    /// If there is not one weight for each row.
    pub fn unwhiten(&self, weights: &mut [f64]) {
        let order = self.sd.len();
        assert_eq!(weights.len(), order, "one weight for each row");
        for i in (0..order).rev() {
            let factors = &self.lower[i * order..][..=i];
            let value = weights[i] / factors[i];
            weights[i] = value;
            weights[..i].iter_mut().zip(factors).for_each(|(x, factor)| *x -= factor * value);
        }
        weights.iter_mut().zip(&self.sd).for_each(|(x, sd)| *x /= sd);
    }
}

/// L of the correlation with a ridge, or nothing if it is not positive definite.
fn correlation_factor(covariance: &[f64], sd: &[f64], ridge: f64) -> Option<Vec<f64>> {
    let order = sd.len();
    let mut lower = vec![0.0; order * order];
    for i in 0..order {
        let (above, rest) = lower.split_at_mut(i * order);
        let row = &mut rest[..order];
        for j in 0..i {
            let other = &above[j * order..][..=j];
            let correlation = covariance[i * order + j] / (sd[i] * sd[j]);
            row[j] = (correlation - dot(&row[..j], &other[..j])) / other[j];
        }
        let square = 1.0 + ridge - dot(&row[..i], &row[..i]);
        if square.is_nan() || square <= 4.0 * f64::EPSILON {
            return None;
        }
        row[i] = square.sqrt();
    }
    Some(lower)
}

/// A sum of products in eight lanes, which the compiler keeps side by side, added up in a fixed order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a_chunks.zip(b_chunks) {
        for (lane, (x, y)) in lanes.iter_mut().zip(x.iter().zip(y)) {
            *lane += x * y;
        }
    }
    let [p, q, r, s, t, u, v, w] = lanes;
    (((p + q) + (r + s)) + ((t + u) + (v + w))) + rest
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
            let factor = Factor::new(&v, order).unwrap();
            // L⁻¹ S⁻¹ V is Lᵀ S: its product with its transpose, V again.
            let mut w = v.clone();
            factor.whiten(&mut w);
            for i in 0..order {
                for j in 0..order {
                    let sum: f64 = (0..order).map(|k| w[k * order + i] * w[k * order + j]).sum();
                    let expected = v[i * order + j];
                    assert!((sum / expected - 1.0).abs() < 1e-12, "{order} {i} {j}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn unwhitened_weights_give_the_same_sum() {
        let order = 23;
        let factor = Factor::new(&covariance(order), order).unwrap();
        let data: Vec<f64> = (0..order).map(|k| (k as f64).sin() * factor.sd()[k]).collect();
        let row: Vec<f64> = (0..order).map(|k| (k as f64).cos()).collect();
        let (mut whitened, mut weights) = (data.clone(), row.clone());
        factor.whiten(&mut whitened);
        factor.unwhiten(&mut weights);
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((sum(&row, &whitened) - sum(&weights, &data)).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        for wrong in [[0.0, 0.0, 0.0, 1.0], [f64::NAN, 0.0, 0.0, 1.0], [1.0, 2.0, 2.0, 1.0]] {
            assert!(Factor::new(&wrong, 2).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn a_singular_matrix_is_taken_with_a_ridge() {
        let factor = Factor::new(&[1.0, 1.0, 1.0, 1.0], 2).unwrap();
        let mut columns = [1.0, 2.0];
        factor.whiten(&mut columns);
        assert!(columns.iter().all(|x| x.is_finite()));
    }
}
