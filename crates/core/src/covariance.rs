//! The exact covariance of overlapping Allan variances, eq. (10) of the paper, for Gaussian noise in a finite
//! record.
//!
//! An Allan variance is the mean of `M(n)` = N + 1 − 2n squares z², where z(k) = x(k) − 2x(k + n) + x(k + 2n)
//! of the phase x. The squares of two Gaussian numbers with means μ, μ′ and covariance C have the covariance
//! 2C² + 4μμ′·C (L. Isserlis, "On a formula for the product-moment coefficient of any order of a normal
//! frequency distribution in any number of variables", Biometrika 12, 1918). The means are R n² τ₀², from the
//! ramp. C is a function of the lag u between the centres of the two differences. With the number w(u) of
//! pairs at each lag,
//!
//! Cov\[AVAR(n), AVAR(m)\] = Σ w(u) \[C(u)² + 2R²n²m²τ₀⁴ C(u)\] / (2n²m²τ₀⁴ `M(n)` `M(m)`).
//!
//! This is the sum behind the equivalent degrees of freedom of C. A. Greenhall and W. J. Riley, "Uncertainty of
//! stability variances based on finite differences", Proc. 35th PTTI Meeting, 2003, extended to pairs of cluster
//! sizes and to mixtures of noise. C is linear in the squared coefficients θ, so that the covariance is
//! Σ θ(p) θ(q) Γ(p, q) + R² Σ θ(p) P(p), with tensors that depend only on the length of the record and the
//! cluster sizes: [`Gamma`].

mod exponentials;
mod flicker;
pub(crate) mod lags;
mod terms;

pub use terms::{Component, PhaseCovariance};

use crate::allan::{Counting, Overlap, check_sizes};
use crate::error::Error;
use crate::parallel::prelude::*;
use lags::{Rules, SUMMED_LAGS};

/// The tensors from which the covariance for any coefficients follows; they are computed once and used in
/// each step of a fit.
///
/// Coefficients θ are squared: Q², N², B², K², or a variance, in the order of the terms.
/// [`crate::allan::Counting::Paper`] leaves out the last difference, which corresponds to a record shorter by
/// one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Gamma {
    sizes: Vec<usize>,
    tau0: f64,
    /// Power of τ₀ of each term.
    powers: Vec<i32>,
    /// Allan variances for unit coefficients and τ₀ = 1: one row per term, one number per size.
    avar: Vec<f64>,
    /// Γ for τ₀ = 1: one J×J matrix per pair p ≤ q of terms, in row order of the upper triangle.
    noise: Vec<f64>,
    /// P for τ₀ = 1: one J×J matrix per term.
    ramp: Vec<f64>,
}

impl Gamma {
    /// The tensors of a record of `n_samples` rates at the cluster sizes `sizes`, for τ₀ = 1; for any other, see
    /// [`Gamma::at_interval`].
    ///
    /// Works on the current rayon pool; the result is the same to the last bit for any number of threads.
    ///
    /// # Errors
    ///
    /// [`Error::TooShort`] if the record leaves no cluster size, [`Error::ClusterSize`] for the first size without a
    /// pair, [`Error::Parameter`] for a noise with a parameter out of range.
    pub fn new<T: PhaseCovariance>(n_samples: usize, sizes: &[usize], terms: &[T]) -> Result<Self, Error> {
        terms.iter().try_for_each(PhaseCovariance::check)?;
        check_sizes(n_samples, sizes, Overlap::Full, Counting::Standard)?;
        let of_size = |term: &T, n: usize| {
            let n = n as f64;
            0.5 * term.covariance(n, n, 0.0) / (n * n)
        };
        let avar = terms.iter().flat_map(|term| sizes.iter().map(move |&n| of_size(term, n))).collect();

        let rules = Rules::get();
        let size_pairs: Vec<(usize, usize)> = upper_triangle(sizes.len()).collect();
        let entries: Vec<Vec<f64>> = size_pairs
            .par_iter()
            .map(|&(i, j)| entry(rules, n_samples, sizes[i].min(sizes[j]), sizes[i].max(sizes[j]), terms))
            .collect();

        let squares = sizes.len() * sizes.len();
        let matrices = terms.len() * (terms.len() + 1) / 2;
        let mut noise = vec![0.0; matrices * squares];
        let mut ramp = vec![0.0; terms.len() * squares];
        for ((i, j), sums) in size_pairs.into_iter().zip(entries) {
            for cell in [i * sizes.len() + j, j * sizes.len() + i] {
                let (of_noise, of_ramp) = sums.split_at(matrices);
                noise
                    .iter_mut()
                    .skip(cell)
                    .step_by(squares)
                    .zip(of_noise)
                    .for_each(|(cell, sum)| *cell = *sum);
                ramp.iter_mut().skip(cell).step_by(squares).zip(of_ramp).for_each(|(cell, sum)| *cell = *sum);
            }
        }
        let powers = terms.iter().map(PhaseCovariance::interval_power).collect();
        Ok(Self { sizes: sizes.to_vec(), tau0: 1.0, powers, avar, noise, ramp })
    }

    /// The tensors for coefficients in the units of a sample interval `tau0`. Nothing is summed again.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a `tau0` that is not positive.
    pub fn at_interval(mut self, tau0: f64) -> Result<Self, Error> {
        if !(tau0 > 0.0 && tau0.is_finite()) {
            return Err(Error::Parameter { name: "tau0", value: tau0 });
        }
        self.tau0 = tau0;
        Ok(self)
    }

    /// The cluster sizes, in the order given.
    #[must_use]
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Number of terms.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.powers.len()
    }

    /// The J×J matrix Γ(p, q) in row order; it is symmetric, and Γ(p, q) = Γ(q, p).
    ///
    /// # Panics
    ///
    /// If `p` or `q` is not below [`Gamma::terms`].
    #[must_use]
    pub fn noise_part(&self, p: usize, q: usize) -> Vec<f64> {
        let scale = self.scale(p) * self.scale(q);
        let (p, q) = (p.min(q), p.max(q));
        // The rows of the triangle above p have terms(), terms() − 1 … elements.
        let above = p * self.terms() - p * p.saturating_sub(1) / 2;
        matrix(&self.noise, above + (q - p), self.sizes.len()).iter().map(|value| scale * value).collect()
    }

    /// The J×J matrix P(p) of the ramp: P(p) θ(p) R² is added to the covariance.
    ///
    /// # Panics
    ///
    /// If `p` is not below [`Gamma::terms`].
    #[must_use]
    pub fn ramp_part(&self, p: usize) -> Vec<f64> {
        let scale = self.scale(p) * self.tau0 * self.tau0;
        matrix(&self.ramp, p, self.sizes.len()).iter().map(|value| scale * value).collect()
    }

    /// The expected Allan variances for the squared coefficients `theta` and the slope `ramp`.
    ///
    /// # Panics
    ///
    /// If `theta` does not have one element per term.
    #[must_use]
    pub fn expectation(&self, theta: &[f64], ramp: f64) -> Vec<f64> {
        let theta = self.scaled(theta);
        let slope = ramp * self.tau0;
        let of_size = |(j, &size): (usize, &usize)| {
            let unit = self.avar.iter().skip(j).step_by(self.sizes.len());
            let drift = slope * size as f64;
            theta.iter().zip(unit).map(|(theta, unit)| theta * unit).sum::<f64>() + 0.5 * drift * drift
        };
        self.sizes.iter().enumerate().map(of_size).collect()
    }

    /// The J×J covariance matrix of the Allan variances in row order, for `theta` and `ramp` as in
    /// [`Gamma::expectation`].
    ///
    /// # Panics
    ///
    /// If `theta` does not have one element per term.
    #[must_use]
    pub fn covariance(&self, theta: &[f64], ramp: f64) -> Vec<f64> {
        let theta = self.scaled(theta);
        let slope = (ramp * self.tau0).powi(2);
        let mut covariance = vec![0.0; self.sizes.len() * self.sizes.len()];
        let mut add = |factor: f64, matrix: &[f64]| {
            covariance.iter_mut().zip(matrix).for_each(|(sum, value)| *sum += factor * value);
        };
        for (index, (p, q)) in upper_triangle(theta.len()).enumerate() {
            let times = if p == q { 1.0 } else { 2.0 };
            add(times * theta[p] * theta[q], matrix(&self.noise, index, self.sizes.len()));
        }
        for (p, theta) in theta.iter().enumerate() {
            add(slope * theta, matrix(&self.ramp, p, self.sizes.len()));
        }
        covariance
    }

    /// Equivalent degrees of freedom 2 AVAR² / Var: those of the χ² distribution with the same mean and variance.
    ///
    /// # Panics
    ///
    /// If `theta` does not have one element per term.
    #[must_use]
    pub fn edf(&self, theta: &[f64], ramp: f64) -> Vec<f64> {
        let covariance = self.covariance(theta, ramp);
        let variances = covariance.iter().step_by(self.sizes.len() + 1);
        self.expectation(theta, ramp)
            .iter()
            .zip(variances)
            .map(|(avar, var)| 2.0 * avar * avar / var)
            .collect()
    }

    /// Coefficients converted to τ₀ = 1.
    fn scaled(&self, theta: &[f64]) -> Vec<f64> {
        assert_eq!(theta.len(), self.terms(), "one coefficient for each term");
        theta.iter().enumerate().map(|(p, theta)| self.scale(p) * theta).collect()
    }

    /// C / τ₀² for a coefficient of 1, relative to its value for τ₀ = 1.
    fn scale(&self, p: usize) -> f64 {
        self.tau0.powi(self.powers[p] - 2)
    }
}

/// Only the variances of the Allan variances, for τ₀ = 1: the diagonal of [`Gamma::covariance`] in 1/J of the
/// time.
///
/// # Errors
///
/// As for [`Gamma::new`].
///
/// # Panics
///
/// If `theta` does not have one element per term.
pub fn variances<T: PhaseCovariance>(
    n_samples: usize,
    sizes: &[usize],
    terms: &[T],
    theta: &[f64],
    ramp: f64,
) -> Result<Vec<f64>, Error> {
    assert_eq!(theta.len(), terms.len(), "one coefficient for each term");
    terms.iter().try_for_each(PhaseCovariance::check)?;
    check_sizes(n_samples, sizes, Overlap::Full, Counting::Standard)?;
    let rules = Rules::get();
    let variance = |&size: &usize| {
        let sums = entry(rules, n_samples, size, size, terms);
        let (of_noise, of_ramp) = sums.split_at(sums.len() - terms.len());
        let noise = of_noise.iter().zip(upper_triangle(terms.len())).map(|(sum, (p, q))| {
            let times = if p == q { 1.0 } else { 2.0 };
            times * theta[p] * theta[q] * sum
        });
        let drift = of_ramp.iter().zip(theta).map(|(sum, theta)| ramp * ramp * theta * sum);
        noise.sum::<f64>() + drift.sum::<f64>()
    };
    Ok(sizes.par_iter().map(variance).collect())
}

/// Matrix number `index` of consecutively stored matrices.
fn matrix(all: &[f64], index: usize, order: usize) -> &[f64] {
    &all[index * order * order..][..order * order]
}

/// Pairs i ≤ j below `order`.
fn upper_triangle(order: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..order).flat_map(move |i| (i..order).map(move |j| (i, j)))
}

/// Γ(p, q) for all p ≤ q, then P(p) for all p, for the cluster sizes `n` ≤ `m`.
fn entry<T: PhaseCovariance>(rules: &Rules, n_samples: usize, n: usize, m: usize, terms: &[T]) -> Vec<f64> {
    let matrices = terms.len() * (terms.len() + 1) / 2;
    let mut sums = vec![0.0; matrices + terms.len()];
    // The number of pairs is a trapezoid: the whole shorter row of differences while it lies inside the
    // longer row, and one fewer for each further lag. Both rows are centred on the record, so that w, like C,
    // is an even function.
    let span = n_samples + 1 - n - m;
    let flat = (n_samples + 1 - 2 * m) as f64;
    let mut kinks = vec![0, m - n, n, m, m + n];
    kinks.sort_unstable();
    kinks.dedup();
    let one_by_one = terms.iter().map(PhaseCovariance::memory).fold(SUMMED_LAGS, usize::max);
    let sizes = (n as f64, m as f64);
    let mut differences = vec![0.0; terms.len()];
    rules.visit(&kinks, span - 1, one_by_one, |lag, weight| {
        for (difference, term) in differences.iter_mut().zip(terms) {
            *difference = term.covariance(sizes.0, sizes.1, lag);
        }
        let sides = if lag == 0.0 { 1.0 } else { 2.0 };
        let pairs = sides * weight * flat.min(span as f64 - lag);
        let (of_noise, of_ramp) = sums.split_at_mut(matrices);
        let mut sums = of_noise.iter_mut();
        for (p, difference) in differences.iter().enumerate() {
            let weighted = pairs * difference;
            for (other, sum) in differences[p..].iter().zip(&mut sums) {
                *sum += weighted * other;
            }
        }
        for (sum, difference) in of_ramp.iter_mut().zip(&differences) {
            *sum += pairs * difference;
        }
    });
    let of_means = ((n_samples + 1 - 2 * n) as f64 * flat).recip();
    let product = sizes.0 * sizes.1;
    for (index, sum) in sums.iter_mut().enumerate() {
        *sum *= if index < matrices { 0.5 * of_means / (product * product) } else { of_means };
    }
    sums
}
