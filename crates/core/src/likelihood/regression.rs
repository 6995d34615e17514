//! Weighted least squares for the regressors, given the density of a model.

use crate::likelihood::bins::{Bins, Products};
use crate::likelihood::linear::{Symmetric, dot};
use crate::likelihood::model::Model;
use crate::terms::Term;

pub(crate) struct Regressed {
    pub beta: Vec<f64>,
    pub covariance: Symmetric,
    /// ln det ZᵀS⁻¹Z, or ln det(1 + Q²ZᵀS⁻¹Z) for the end values.
    pub restricted: f64,
    /// Sum of the squared end values, each over its variance.
    pub squares_of_ends: f64,
    pub leverage: Vec<f64>,
    /// Derivative of the log-likelihood of the end values with respect to `quantization`, for each run.
    pub slope_of_ends: Vec<f64>,
}

/// Weighted least squares for the regressors, given the density, which is constant in each bin. The end values of the angle
/// are random with the variance `quantization`.
pub(crate) fn regress(products: &Products, spectrum: &[f64], quantization: f64) -> Regressed {
    let n = products.count;
    let mut squares = Symmetric::zero(n);
    let mut right = vec![0.0; n];
    let scale: Vec<f64> =
        products.ends.iter().map(|end| if *end { quantization.sqrt() } else { 1.0 }).collect();
    let bins = products.with_record.chunks_exact(n.max(1)).zip(products.squares.chunks_exact((n * n).max(1)));
    for (bin, (record, own)) in bins.clone().enumerate() {
        let weight = 1.0 / spectrum[bin];
        right.iter_mut().zip(record).for_each(|(r, x)| *r += weight * x);
        squares.at.iter_mut().zip(own).for_each(|(s, x)| *s += weight * x);
    }
    for i in 0..n {
        right[i] *= scale[i];
        for j in 0..=i {
            let prior = f64::from(u8::from(i == j && products.ends[i]));
            squares.set(i, j, squares.get(i, j) * scale[i] * scale[j] + prior);
        }
    }
    let (mut covariance, restricted) = squares.inverse_and_log_determinant();
    let mut beta = covariance.times(&right);
    let ends = |i: &usize| products.ends[*i];
    let squares_of_ends: f64 = (0..n).filter(ends).map(|i| beta[i] * beta[i]).sum();
    let expected_of_ends: f64 = (0..n).filter(ends).map(|i| 1.0 - covariance.get(i, i)).sum();
    let slope_of_ends =
        if quantization > 0.0 { 0.5 * (squares_of_ends - expected_of_ends) / quantization } else { 0.0 };
    for i in 0..n {
        beta[i] *= scale[i];
        for j in 0..=i {
            covariance.set(i, j, covariance.get(i, j) * scale[i] * scale[j]);
        }
    }
    let taken = |(bin, (_, own)): (usize, (&[f64], &[f64]))| dot(&covariance.at, own) / spectrum[bin];
    let leverage = bins.enumerate().map(taken).collect();
    Regressed { beta, covariance, restricted, squares_of_ends, leverage, slope_of_ends: vec![slope_of_ends] }
}

/// The regressors of all runs, and the powers without them.
pub(crate) fn regressed(
    model: &Model,
    spectrum: &[f64],
    bins: &Bins,
    products: &[Products],
) -> (Regressed, Vec<f64>) {
    let quantization = model.index(Term::Quantization);
    if bins.runs.is_empty() {
        let found = regress(&products[0], spectrum, quantization.map_or(0.0, |j| model.theta[j]));
        let powers = bins.powers(&bins.residual_power(&products[0], &found.beta));
        return (found, powers);
    }
    let (mut all, mut powers): (Option<Regressed>, Vec<f64>) = (None, Vec::with_capacity(bins.len()));
    for (run, ((own, _), products)) in bins.runs.iter().zip(products).enumerate() {
        let at = powers.len();
        let found = regress(
            products,
            &spectrum[at..at + own.len()],
            quantization.map_or(0.0, |j| model.theta_of(j, run)),
        );
        powers.extend(own.powers(&own.residual_power(products, &found.beta)));
        let mut leverage = found.leverage.clone();
        leverage.resize(own.len(), 0.0);
        // If a discrepancy limits the lowest bins, regressors only reduce their remaining freedom.
        let share = if products.ends.contains(&false) { bins.freedom_share_at(at, own.low) } else { 1.0 };
        for taken in &mut leverage {
            *taken *= share;
        }
        let restricted = share * found.restricted;
        match &mut all {
            None => all = Some(Regressed { restricted, leverage, ..found }),
            Some(all) => {
                all.restricted += restricted;
                all.squares_of_ends += found.squares_of_ends;
                all.leverage.extend(leverage);
                all.slope_of_ends.extend(found.slope_of_ends);
            }
        }
    }
    (all.unwrap_or_else(|| regress(&products[0], spectrum, 0.0)), powers)
}
