//! The averaging times at which a noise model describes the curve of a record, and its low-pass filter.
//!
//! A noise model contains the terms, processes and resonances of a fit, but not its filter, so below some averaging time it
//! does not describe the curve. A Butterworth filter of the white noise before the sampler may replace the filter of the
//! fit.

use crate::bandlimited::{Filter, band_limited_avar};
use crate::likelihood::fitted_model::FittedModel;
use crate::psd::{MEAN_OF_SINE_4, band_limited_sampled};
use crate::terms::{self, Term};
use std::f64::consts::PI;

/// Largest difference of the Allan variances of fit and model for which the model describes the curve: relative, and in
/// standard errors of a measured variance.
const MAX_DIFFERENCE: f64 = 0.02;
const SAME_ERRORS: f64 = 0.5;

/// Length of the record over the longest averaging time.
pub(crate) const LONGEST_SHARE: usize = 3;

/// The shortest averaging time of the model from a fit \[s\], and the order and corner \[Hz\] of a low-pass filter with
/// which the model describes shorter times, if there is one.
pub(crate) fn described_from(fit: &FittedModel) -> (f64, Option<(u8, f64)>) {
    let (n, tau0) = (fit.samples, fit.tau0);
    let sizes = half_octaves(n / 2);
    let noise = FittedModel { filter: None, sinusoid: Vec::new(), warm_up: None, ..fit.clone() };
    let mut filtered = noise.avar_before_filter(&sizes);
    let random_walk = fit.coefficient(Term::RandomWalk);
    let walk = if random_walk > 0.0 { random_walk } else { f64::INFINITY };
    let resonance = fit.resonance.iter().copied().filter(|band| !band.folds(tau0, walk)).collect();
    // The parts that a noise model has.
    let bare = FittedModel { resonance, ..noise }.avar_before_filter(&sizes);
    if let Some(filter) = &fit.filter {
        let lost = filter.reduction_of_avar(|f| fit.psd_that_is_filtered(f), &sizes, fit.highest);
        filtered.iter_mut().zip(lost).for_each(|(all, lost)| *all -= lost);
    }
    // Share of the variance of white noise in the excluded band, whose actual noise is unknown.
    let reaches_top = fit.filter.as_ref().is_some_and(|filter| filter.known_to.is_some());
    let unknown = |m: usize| {
        let share = |highest: f64| 4.0 * MEAN_OF_SINE_4 / (PI * PI * highest * m as f64 * tau0);
        fit.highest.filter(|_| !reaches_top).map_or(0.0, share)
    };
    let beginning = |avar: &[f64]| {
        let beyond = (0..sizes.len()).rev().find(|&k| {
            let error = SAME_ERRORS * (2.0 * sizes[k] as f64 / n as f64).sqrt();
            (avar[k] - filtered[k]).abs() + unknown(sizes[k]) * bare[k] > error.min(MAX_DIFFERENCE) * bare[k]
        });
        beyond.map_or(tau0, |k| sizes[(k + 1).min(sizes.len() - 1)] as f64 * tau0)
    };
    let first = beginning(&bare);
    let low_pass = fit.filter.as_ref().and_then(super::filter::FittedFilter::before_sampling);
    if let Some((order, corner)) = low_pass.filter(|_| random_walk > 0.0) {
        // Factor of N² by folding: N² of the samples over N² before the sampler.
        let inflation = band_limited_sampled(1.0, order, corner, tau0, 0.0).sqrt();
        let behind =
            band_limited_avar(random_walk / inflation, Filter::Butterworth(order), corner, tau0, &sizes);
        let behind_filter: Vec<f64> = (0..sizes.len())
            .map(|k| bare[k] - terms::random_walk_avar(random_walk, sizes[k] as f64 * tau0) + behind[k])
            .collect();
        let sooner = beginning(&behind_filter);
        if sooner < first {
            return (sooner, low_pass);
        }
    }
    (first, None)
}

/// The cluster sizes 1, 2, 3, 4, 6, 8, 12 … up to the largest.
fn half_octaves(largest: usize) -> Vec<usize> {
    let octaves = largest.max(1).ilog2();
    let mut sizes: Vec<usize> =
        (0..=octaves).flat_map(|j| [1 << j, 3 << j]).filter(|&size| size <= largest).collect();
    sizes.sort_unstable();
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::filter::{FilterShape, FittedFilter};
    use crate::resonance::Resonance;

    const TAU0: f64 = 0.01;

    fn white() -> FittedModel {
        FittedModel { terms: [0.0, 1.0, 0.0, 0.0, 0.0], ..FittedModel::without_parts(TAU0, 1 << 20) }
    }

    /// ln |H|² = Σ 2pᵏ/k (cos kθ − 1) is that of exponential smoothing.
    fn smoothing(p: f64) -> FittedFilter {
        let coefficients: Vec<f64> = (1..=24).map(|k| 2.0 * p.powi(k) / f64::from(k)).collect();
        FittedFilter::named(&coefficients, |_, _| 0.0, TAU0, TAU0, 1.96)
    }

    #[test]
    fn sizes_are_half_octaves() {
        assert_eq!(half_octaves(13), [1, 2, 3, 4, 6, 8, 12]);
        assert_eq!(half_octaves(0), [0_usize; 0]);
    }

    #[test]
    fn white_noise_is_described_from_the_first_sample_on() {
        assert_eq!(described_from(&white()), (TAU0, None));
    }

    #[test]
    fn filter_of_first_order_has_a_stand_in() {
        let filter = smoothing(0.7);
        assert_eq!(filter.shape, FilterShape::Smoothing);
        let fit = FittedModel { filter: Some(filter), ..white() };
        let (first, low_pass) = described_from(&fit);
        let (order, corner) = low_pass.unwrap();
        assert_eq!(order, 1);
        assert!((4.0..9.0).contains(&corner), "{corner}");
        // Without the filter, the lost variance is below 2 % of N²/τ above about fifty correlation times of three samples.
        assert!(first < 0.2, "{first}");
        let unnamed = FittedFilter { shape: FilterShape::LowPass, ..fit.filter.clone().unwrap() };
        let (without, none) = described_from(&FittedModel { filter: Some(unnamed), ..fit });
        assert!(none.is_none() && without > 5.0 * first, "{without}");
    }

    #[test]
    fn band_that_was_left_out_hides_short_times() {
        let highest = Some(25.0);
        let (first, _) = described_from(&FittedModel { highest, ..white() });
        // 4 · 3/8 / (π² · 25 Hz · τ) is below half a standard error, √(2τ/T)/2, from 0.92 s on.
        assert!((first - 0.96).abs() < 1e-12);
    }

    /// Its folded noise would be at least 2 % of the white noise, so the model omits it.
    #[test]
    fn resonance_near_half_the_rate_is_left_out() {
        let resonance = vec![Resonance { sigma: 10.0, frequency: 31.0, width: 7.7 }];
        let (first, _) = described_from(&FittedModel { resonance, ..white() });
        assert!(first > 0.1, "{first}");
    }
}
