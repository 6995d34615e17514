//! Covariance of the Allan variances for given coefficients, with or without the removal of a ramp.

use crate::gls::components::Components;
use crate::gls::lanes::add_rows;
use crate::gls::{Failed, TERMS, Theta};
use crate::likelihood::linear::Symmetric;
use pulp::{Arch, Simd, WithSimd};

/// Largest negative eigenvalue that is corrected, as a share of the largest positive one.
const MAX_NEGATIVE: f64 = 0.03;

/// Smallest eigenvalue of correlations.
pub(crate) const MIN_EIGENVALUE: f64 = 1e-9;

/// A factor and a matrix.
type Part<'a> = (f64, &'a [f64]);

/// Number of pairs of terms.
const PAIRS: usize = TERMS * (TERMS + 1) / 2;

/// Σ θ(p) θ(q) Γ(p, q) at the sizes from number `first`: the upper triangle in row order.
pub(crate) fn noise_covariance(parts: &Components, first: usize, theta: &Theta, out: &mut Vec<f64>) {
    let empty: Part<'_> = (0.0, &[]);
    let mut list = [empty; PAIRS];
    let mut count = 0;
    for p in 0..parts.terms() {
        for q in p..parts.terms() {
            let factor = theta[p] * theta[q];
            if factor != 0.0 {
                list[count] = (factor, parts.noise(p, q));
                count += 1;
            }
        }
    }
    contracted(&list[..count], parts.base.order(), first, out);
}

/// Σ θ(p) P(p): covariance of the ramps, its upper triangle.
pub(crate) fn ramp_covariance(parts: &Components, first: usize, theta: &Theta, out: &mut Vec<f64>) {
    let empty: Part<'_> = (0.0, &[]);
    let mut list = [empty; TERMS];
    let mut count = 0;
    for (p, &factor) in theta.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
        list[count] = (factor, parts.slopes(p));
        count += 1;
    }
    contracted(&list[..count], parts.base.order(), first, out);
}

/// Covariances and weights of a removed ramp.
#[derive(Debug, Default)]
pub(crate) struct RampRemoval {
    slopes: Vec<f64>,
    shares: Vec<f64>,
}

impl RampRemoval {
    /// Converts a covariance to that after the removal of the ramp Σ weights·ramp(m). A second difference is then m²(β − 1)
    /// times the error of the ramp plus a remainder, where β = c/v with the variance v of the ramp and its covariance c
    /// with ramp(m). The remainder is assumed to be independent of the error of the ramp, which holds on average over the
    /// record.
    pub(crate) fn apply(
        &mut self,
        parts: &Components,
        first: usize,
        theta: &Theta,
        weights: &[f64],
        covariance: &mut [f64],
    ) {
        ramp_covariance(parts, first, theta, &mut self.slopes);
        let order = weights.len();
        times(&self.slopes, weights, &mut self.shares);
        let v: f64 = self.shares.iter().zip(weights).map(|(c, weight)| c * weight).sum();
        if v <= 0.0 {
            return;
        }
        self.shares.iter_mut().for_each(|c| *c /= v);
        let squares = &parts.base.squares()[first..];
        for i in 0..order {
            let (beta, square) = (self.shares[i], squares[i] * v);
            let low = beta * beta;
            let high = (beta - 1.0) * (beta - 1.0);
            let own = &self.slopes[i * order + i..(i + 1) * order];
            let cells = covariance[i * order + i..(i + 1) * order].iter_mut().zip(own);
            for ((cell, slope), (other, of_other)) in cells.zip(self.shares[i..].iter().zip(&squares[i..])) {
                let remainder = slope - beta * other * v;
                let ends = high * (other - 1.0) * (other - 1.0) - low * other * other;
                *cell += square * of_other * (0.5 * v * ends + (1.0 - beta - other) * remainder);
            }
        }
    }
}

/// Product of a symmetric matrix, given by its upper triangle, and a vector.
pub(crate) fn times(upper: &[f64], x: &[f64], out: &mut Vec<f64>) {
    let order = x.len();
    out.clear();
    out.resize(order, 0.0);
    for i in 0..order {
        let row = &upper[i * order + i..(i + 1) * order];
        let mut sum = row[0] * x[i];
        let (_, later) = out.split_at_mut(i + 1);
        for ((value, x_of), later) in row[1..].iter().zip(&x[i + 1..]).zip(later) {
            sum += value * x_of;
            *later += value * x[i];
        }
        out[i] += sum;
    }
}

/// Changes the signs of slightly negative eigenvalues of a covariance. The covariance without the ramp is approximate: in
/// the direction of the ramp it may be slightly negative if quantization noise leaves hardly any variance in the other
/// directions. The magnitude of the negative eigenvalue is the error of the approximation and is used as the variance.
pub(crate) fn made_positive(covariance: &mut [f64], order: usize) -> Result<(), Failed> {
    let sd: Vec<f64> = covariance.iter().step_by(order + 1).map(|v| v.max(0.0).sqrt()).collect();
    if !sd.iter().all(|&sd| sd > 0.0 && sd.is_finite()) {
        return Err(Failed);
    }
    let mut correlation = Symmetric::zero(order);
    for i in 0..order {
        for j in i..order {
            correlation.set(i, j, covariance[i * order + j] / (sd[i] * sd[j]));
        }
    }
    let (mut values, vectors) = correlation.eigen();
    let (least, most) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    if least.is_nan() || least < -MAX_NEGATIVE * most {
        return Err(Failed);
    }
    for value in &mut values {
        *value = value.abs().max(MIN_EIGENVALUE);
    }
    for i in 0..order {
        for j in i..order {
            let sum: f64 =
                (0..order).map(|k| vectors[i * order + k] * values[k] * vectors[j * order + k]).sum();
            covariance[i * order + j] = sum * sd[i] * sd[j];
        }
    }
    Ok(())
}

/// Upper triangle of the sum of matrices times factors, for rows and columns from number `first`.
fn contracted(list: &[Part<'_>], order: usize, first: usize, out: &mut Vec<f64>) {
    let left = order - first;
    out.resize(left * left, 0.0);
    Arch::new().dispatch(Contraction { list, order, first, out });
}

struct Contraction<'a> {
    list: &'a [Part<'a>],
    order: usize,
    first: usize,
    out: &'a mut [f64],
}

impl WithSimd for Contraction<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for these vectors.
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { list, order, first, out } = self;
        let left = order - first;
        for (i, row) in out.chunks_exact_mut(left).enumerate() {
            // Whole vectors that end with the row and include the diagonal, if there is room.
            let from = left.saturating_sub((left - i).next_multiple_of(S::F64_LANES));
            let start = (first + i) * order + first + from;
            row[from..].fill(0.0);
            let rows = list.iter().map(|&(factor, matrix)| (factor, &matrix[start..start + left - from]));
            add_rows(simd, &mut row[from..], &rows);
        }
    }
}
