//! Three tests of whether a fitted model describes the record, each sensitive to a different kind of misfit.

use crate::likelihood::bins::Bins;
use crate::likelihood::fit::Fit;
use crate::likelihood::laws::{chi2_above, chi2_below, digamma, normal_quantile_above, trigamma};

/// Number of bands per decade in the second test, and smallest number of degrees of freedom of a band.
const BANDS_PER_DECADE: f64 = 4.0;
const MIN_FREEDOM: f64 = 8.0;

/// Number of degrees of freedom of the bands, in the second test, that each parameter costs.
const FREEDOM_PER_PARAMETER: f64 = 0.7;

/// Numbers of lowest modes that are tested together, and the correction for multiple tests.
const NUMBERS_OF_LOWEST: [f64; 7] = [4.0, 6.0, 9.0, 14.0, 20.0, 30.0, 45.0];
const LOWEST_PRICE: f64 = 4.0;

/// Smallest share of a bin's degrees of freedom that remains after the regressors.
const MIN_FREEDOM_SHARE: f64 = 0.05;

/// Result of the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Adequacy {
    /// P-value of all three tests together.
    pub p_value: f64,
    /// Bands of a quarter decade: mean frequency \[Hz\] and normal deviate, positive if the density of the record is higher
    /// than that of the model.
    pub bands: Vec<(f64, f64)>,
}

/// Tests a fit.
pub(crate) fn adequacy(fit: &Fit, bins: &Bins) -> Adequacy {
    // Regressors reduce the degrees of freedom of bins, and the power by the same share.
    let taken = |i: usize| fit.leverage.get(i).copied().unwrap_or(0.0); // empty without regressors
    let left: Vec<f64> =
        (0..bins.len()).map(|i| (1.0 - taken(i) / bins.freedom[i]).max(MIN_FREEDOM_SHARE)).collect();
    let ratio: Vec<f64> =
        fit.powers.iter().zip(&fit.spectrum).zip(&left).map(|((i, s), left)| i / (s * left)).collect();
    let parameters = fit.model.parameters_beside_curves() as f64;
    let deviances = gamma_deviances(&ratio, bins, &left, parameters);
    // Levels of single runs do not reduce the freedom of the bands of all runs.
    let (of_bands, bands) = bands(&ratio, bins, &left, fit.model.numbers() as f64);
    let lowest = lowest_modes(&ratio, bins, &left);
    Adequacy { p_value: (3.0 * deviances.min(of_bands).min(lowest)).min(1.0), bands }
}

/// The sum of gamma deviances 2x(r − 1 − ln r), where x is half the degrees of freedom, with its exact mean and variance.
fn gamma_deviances(ratio: &[f64], bins: &Bins, left: &[f64], parameters: f64) -> f64 {
    let (mut sum, mut mean, mut variance) = (0.0, 0.0, 0.0);
    for (i, &r) in ratio.iter().enumerate() {
        let x = 0.5 * left[i] / (1.0 / bins.freedom_alone[i] + 1.0 / bins.cap[i]);
        sum += 2.0 * x * (r - 1.0 - r.max(1e-300).ln());
        mean += 2.0 * x * log_bias(x);
        variance += 4.0 * x * x * (trigamma(x) - 1.0 / x);
    }
    let scale = variance / (2.0 * mean);
    chi2_above(sum / scale, (mean / scale - parameters).max(1.0))
}

/// ln x − ψ(x), without cancellation for large x.
pub(crate) fn log_bias(x: f64) -> f64 {
    if x > 1e4 { 0.5 / x + 1.0 / (12.0 * x * x) } else { x.ln() - digamma(x) }
}

/// Tests bands of a quarter decade. A band shows misfits that are too small to detect in a single bin.
fn bands(ratio: &[f64], bins: &Bins, left: &[f64], parameters: f64) -> (f64, Vec<(f64, f64)>) {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (_, inside) in bins.bands(BANDS_PER_DECADE) {
        let (mut freedom, mut sum, mut log, mut count) = (0.0, 0.0, 0.0, 0.0);
        for bin in inside {
            let weight = bins.weight(bin) * left[bin];
            freedom += weight;
            sum += weight * ratio[bin];
            log += bins.frequency[bin].ln();
            count += 1.0;
        }
        if freedom >= MIN_FREEDOM {
            let above = chi2_above(sum, freedom);
            let deviate = if above > 0.5 {
                -normal_quantile_above(chi2_below(sum, freedom).max(1e-300))
            } else {
                normal_quantile_above(above.max(1e-300))
            };
            found.push(((log / count).exp(), deviate));
        }
    }
    if found.len() <= 3 {
        return (1.0, found);
    }
    let n = found.len() as f64;
    let freedom = (n - FREEDOM_PER_PARAMETER * parameters.min(n - 2.0)).max(2.0);
    (chi2_above(found.iter().map(|(_, z)| z * z).sum(), freedom), found)
}

/// Tests the lowest modes together, in both directions. The other tests do not detect a model that is far too high there.
fn lowest_modes(ratio: &[f64], bins: &Bins, left: &[f64]) -> f64 {
    let mut least: f64 = 1.0;
    let mut order: Vec<usize> = (0..ratio.len()).collect();
    if bins.count() > 1 {
        order.sort_by(|&a, &b| bins.frequency[a].total_cmp(&bins.frequency[b]));
    }
    for wanted in NUMBERS_OF_LOWEST.map(|wanted| wanted * bins.count() as f64) {
        let (mut freedom, mut sum) = (0.0, 0.0);
        for &i in &order {
            freedom += bins.freedom[i] * left[i];
            sum += bins.freedom[i] * left[i] * ratio[i];
            if freedom >= wanted - 0.5 {
                break;
            }
        }
        least = least.min(2.0 * chi2_above(sum, freedom).min(chi2_below(sum, freedom)));
    }
    (LOWEST_PRICE * least).min(1.0)
}
