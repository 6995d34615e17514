//! Degrees of freedom of the deviations against sums over every lag, by the definitions, and published values.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.
#![allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.

use sigmatau_core::allan::Overlap;
use sigmatau_core::covariance::Gamma;
use sigmatau_core::deviations::freedom::{Coefficients, Stationary, moments};
use sigmatau_core::terms::Term;

const KINDS: [Stationary; 5] = [
    Stationary::Allan(Overlap::Full),
    Stationary::Allan(Overlap::None),
    Stationary::Modified,
    Stationary::Hadamard(Overlap::Full),
    Stationary::Hadamard(Overlap::None),
];

fn unit(term: usize) -> Coefficients {
    let mut noise = [0.0; 4];
    noise[term] = 1.0;
    Coefficients { noise, ramp: 0.0 }
}

/// Weights of the rate samples in one term of an estimator, and the distance of its terms.
fn filter(kind: Stationary, m: usize) -> (Vec<f64>, usize) {
    let difference = |binomial: &[f64]| -> Vec<f64> {
        binomial.iter().flat_map(|&weight| std::iter::repeat_n(weight, m)).collect()
    };
    let (weights, overlap) = match kind {
        Stationary::Allan(overlap) => (difference(&[-1.0, 1.0]), overlap),
        Stationary::Hadamard(overlap) => (difference(&[1.0, -2.0, 1.0]), overlap),
        Stationary::Modified => {
            let one = difference(&[-1.0, 1.0]);
            let mut sum = vec![0.0; 3 * m - 1];
            for shift in 0..m {
                one.iter().zip(&mut sum[shift..]).for_each(|(weight, sum)| *sum += weight);
            }
            (sum, Overlap::Full)
        }
    };
    (weights, if overlap == Overlap::Full { 1 } else { m })
}

/// Autocovariances of the terms at lags 0 … `last`: autocorrelation of the filter, summed as often as the noise requires.
fn by_filter(kind: Stationary, term: Term, m: usize, last: usize) -> Vec<f64> {
    let (weights, _) = filter(kind, m);
    // Response of a term to each innovation, the oldest first.
    let response: Vec<f64> = match term {
        Term::RandomWalk => weights,
        Term::Quantization => {
            let later = weights.iter().copied().chain([0.0]);
            later.zip([0.0].into_iter().chain(weights.iter().copied())).map(|(a, b)| a - b).collect()
        }
        Term::RateRandomWalk => weights
            .iter()
            .rev()
            .scan(0.0, |sum, weight| {
                *sum += weight;
                Some(*sum)
            })
            .collect(),
        // The filter (1 − z⁻¹)^(−1/2) has a long memory.
        _ => {
            let reach = 400_000;
            let mut power = vec![1.0; reach];
            for k in 1..reach {
                power[k] = power[k - 1] * (k as f64 - 0.5) / k as f64;
            }
            let newest_first: Vec<f64> = weights.iter().rev().copied().collect();
            (0..reach)
                .map(|age| {
                    newest_first.iter().enumerate().take(age + 1).map(|(j, w)| w * power[age - j]).sum()
                })
                .collect()
        }
    };
    (0..=last)
        .map(|lag| response.iter().zip(response.get(lag..).unwrap_or_default()).map(|(a, b)| a * b).sum())
        .collect()
}

#[test]
fn every_edf_is_the_sum_over_all_lags() {
    for kind in KINDS {
        for (samples, m) in [(40, 1), (41, 2), (60, 7), (60, 19), (200, 16), (200, 50)] {
            for (term, &component) in Term::NOISE.iter().enumerate() {
                let (_, step) = filter(kind, m);
                let (weights, _) = filter(kind, m);
                let terms = (samples - weights.len()) / step + 1;
                let c = by_filter(kind, component, m, (terms - 1) * step);
                let sum: f64 = (0..terms)
                    .map(|j| {
                        (if j == 0 { 1.0 } else { 2.0 }) * (terms - j) as f64 * c[j * step] * c[j * step]
                    })
                    .sum();
                let expected = (c[0] * terms as f64).powi(2) / sum;
                let got = moments(kind, samples, &[m], &unit(term)).unwrap()[0];
                // The memory of the flicker filter is truncated.
                let tolerance = if component == Term::BiasInstability { 1e-5 } else { 1e-11 };
                let what = format!("{kind:?}, {component:?}, {samples} samples, m {m}");
                assert!(
                    (got.edf / expected - 1.0).abs() < tolerance,
                    "{what}: {} instead of {expected}",
                    got.edf
                );
                let divisor = match kind {
                    Stationary::Allan(_) => 2.0 * (m * m) as f64,
                    Stationary::Modified => 2.0 * (m as f64).powi(4),
                    Stationary::Hadamard(_) => 6.0 * (m * m) as f64,
                };
                let variance = c[0] / divisor;
                assert!(
                    (got.variance / variance - 1.0).abs() < tolerance,
                    "{what}: {} {variance}",
                    got.variance
                );
            }
        }
    }
}

#[test]
fn allan_is_that_of_the_covariance() {
    let sizes = [1, 2, 10, 333, 1000, 4000];
    let theta = [1.63f64.powi(2), 1.0, 0.188f64.powi(2), 0.0125f64.powi(2)];
    let gamma = Gamma::new(10_000, &sizes, &Term::NOISE).unwrap();
    let coefficients = Coefficients { noise: theta, ramp: 1e-3f64.powi(2) };
    let got = moments(Stationary::Allan(Overlap::Full), 10_000, &sizes, &coefficients).unwrap();
    for ((got, edf), avar) in got.iter().zip(gamma.edf(&theta, 1e-3)).zip(gamma.expectation(&theta, 1e-3)) {
        assert!((got.edf / edf - 1.0).abs() < 1e-11, "{} instead of {edf}", got.edf);
        assert!((got.variance / avar - 1.0).abs() < 1e-13, "{} instead of {avar}", got.variance);
    }
}
