//! Reduction of the weight of data that a model does not fit exactly: a log-normal misfit ("wiggle"), constant in a quarter
//! decade, whose size is estimated from the record and limits the information of each band.

use crate::likelihood::adequacy::log_bias;
use crate::likelihood::bins::Bins;
use crate::likelihood::fit::Fit;
use crate::likelihood::laws::trigamma;
use crate::likelihood::linear::dot;
use std::f64::consts::LN_2;

const ROUNDS: usize = 4;
const BANDS_PER_DECADE: f64 = 4.0;
const MIN_FREEDOM: f64 = 4.0;

/// Number of bands over which the size of the wiggle is smoothed.
const SMOOTHED_BANDS: f64 = 2.0;

/// Largest leverage of a band, because parameters that follow a band hide its misfit.
const MAX_LEVERAGE: f64 = 0.8;

/// Multiple of the variance by chance above which the misfit of a single band counts, and the share of the rest that
/// counts.
const CHANCE_MULTIPLE: f64 = 4.0;
const OWN_SHARE: f64 = 0.5;

/// Relative error of ln |H|² beyond the corner of a filter of known shape: 0.3 dB at −10 dB. A first-order filter at eight
/// times the rate differs by this amount from the fitted shape.
const SHAPE_ERROR: f64 = 0.03;

struct Band {
    number: i64,
    bins: Vec<usize>,
    freedom: f64,
    log_ratio: f64,
    leverage: f64,
}

/// The fit with limited weights, the bins with these weights, and the size of the wiggle: frequency \[Hz\], standard
/// deviation of the logarithm of the density.
pub(crate) fn widened<'a>(fit: &Fit, bins: &Bins<'a>) -> (Fit, Bins<'a>, Vec<(f64, f64)>) {
    let mut bins = bins.clone();
    let mut fit = fit.clone();
    let mut sizes = Vec::new();
    for _ in 0..ROUNDS {
        let bands = bands(&fit, &bins);
        let known = wiggle(&bands);
        let variances: Vec<f64> =
            known.into_iter().zip(beyond_corner(&fit, &bins, &bands)).map(|(a, b)| a.max(b)).collect();
        bins.cap.fill(f64::INFINITY);
        for (band, variance) in bands.iter().zip(&variances) {
            let share = 1.0 / (1.0 + band.freedom * variance / 2.0);
            if share < 0.999 {
                for &i in &band.bins {
                    bins.cap[i] = bins.freedom[i] * share / (1.0 - share);
                }
            }
        }
        let first = bins.frequency[0];
        sizes = bands
            .iter()
            .zip(&variances)
            .map(|(b, v)| (first * 10_f64.powf((b.number as f64 + 0.5) / BANDS_PER_DECADE), v.sqrt()))
            .collect();
        fit = fit.model.clone().fit(&bins);
    }
    (fit, bins, sizes)
}

fn bands(fit: &Fit, bins: &Bins) -> Vec<Band> {
    let (information, slopes) = fit.information(bins);
    let inverse = information.pseudo_inverse();
    let excess = fit.excess();
    let mut found = Vec::new();
    for (number, inside) in bins.bands(BANDS_PER_DECADE) {
        let (mut freedom, mut sum, mut leverage) = (0.0, 0.0, 0.0);
        for &bin in &inside {
            let row: Vec<f64> = slopes.iter().map(|c| c[bin]).collect();
            leverage += 0.5 * bins.weight(bin) * dot(&row, &inverse.times(&row));
            freedom += bins.freedom[bin];
            sum += bins.freedom[bin] * excess[bin];
        }
        if freedom >= MIN_FREEDOM {
            let log_ratio = (1.0 + sum / freedom).max(0.05).ln();
            let leverage = leverage.min(MAX_LEVERAGE);
            found.push(Band { number, bins: inside, freedom, log_ratio, leverage });
        }
    }
    found
}

/// Variance s² of the wiggle in each band, from E (ln r)² = (1 − h)(s² + v), where h is the leverage and v the variance of
/// chance. It is smoothed over bands, and reduced by its standard error without a wiggle, because chance alone makes it
/// positive in every second band.
fn wiggle(bands: &[Band]) -> Vec<f64> {
    bands
        .iter()
        .map(|here| {
            let (mut above, mut below, mut scatter) = (0.0, 0.0, 0.0);
            for b in bands {
                let weight = (-0.5 * ((here.number - b.number) as f64 / SMOOTHED_BANDS).powi(2)).exp();
                above += weight * (b.log_ratio.powi(2) - (1.0 - b.leverage) * chance(b.freedom));
                below += weight * (1.0 - b.leverage);
                scatter += 2.0 * (weight * (1.0 - b.leverage) * chance(b.freedom)).powi(2);
            }
            let own = OWN_SHARE * (here.log_ratio.powi(2) - CHANCE_MULTIPLE * chance(here.freedom));
            ((above - scatter.sqrt()) / below).max(own).max(0.0)
        })
        .collect()
}

/// Variance in each band from the shape of a filter beyond its corner, because no sensor follows its nominal filter
/// exactly.
fn beyond_corner(fit: &Fit, bins: &Bins, bands: &[Band]) -> Vec<f64> {
    let model = &fit.model;
    if model.family.is_none() {
        return vec![0.0; bands.len()];
    }
    let mut behind = model.clone();
    for (theta, &part) in behind.theta.iter_mut().zip(&model.parts) {
        if model.filters(part) {
            *theta = 0.0;
        }
    }
    let (rest, power) = (behind.spectrum(bins), model.response_means(bins));
    let variance = |bin: usize| {
        let share = 1.0 - rest[bin] / fit.spectrum[bin];
        (SHAPE_ERROR * share * (-power[bin].ln() - LN_2).max(0.0)).powi(2)
    };
    let mean = |band: &Band| {
        let sum: f64 = band.bins.iter().map(|&bin| bins.freedom[bin] * variance(bin)).sum();
        sum / band.freedom
    };
    bands.iter().map(mean).collect()
}

/// Mean square of the logarithm of a mean of powers with ν degrees of freedom: 2/ν for large ν.
fn chance(freedom: f64) -> f64 {
    trigamma(0.5 * freedom) + log_bias(0.5 * freedom).powi(2)
}
