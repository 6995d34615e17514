//! Flicker noise with the exact statistics of its samples.
//!
//! The first differences of flicker noise are stationary, so that they can be drawn from a circulant embedding of their
//! covariance (R. B. Davies & D. S. Harte, "Tests for Hurst effect", Biometrika 74(1), 1987); their running sum is the
//! noise. Filters with a memory as long as the record would start from 0 and lack power at long times.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use sigmatau_fft::{Complex64, forward, inverse};
use std::f64::consts::PI;

/// `n` samples of discrete flicker noise with innovations of standard deviation `b`; see
/// [`crate::terms::bias_instability_avar`].
pub fn flicker<R: Rng>(n: usize, b: f64, rng: &mut R) -> Vec<f64> {
    if n == 0 {
        return Vec::new();
    }
    let half = embedding_half(n);
    let period = 2 * half;
    let mut spectrum = draw_spectrum(&circulant_eigenvalues(half), period, rng);

    let inverse = inverse(period);
    let mut differences = inverse.make_output_vec();
    // Only the lengths and the imaginary parts at both ends can be wrong, and both are correct.
    inverse.process(&mut spectrum, &mut differences).expect("the spectrum has its length and real ends");
    differences.truncate(n);
    let mut level = 0.0;
    for value in &mut differences {
        level += b * *value;
        *value = level;
    }
    differences
}

/// Autocovariance of the first differences at lag l, for b = 1: −(4 / π) / (4l² − 1).
fn autocovariance(lag: usize) -> f64 {
    let lag = lag as f64;
    -4.0 / (PI * (4.0 * lag * lag - 1.0))
}

/// Eigenvalues of the circulant matrix of period 2·`half`, whose first row is the autocovariance and its
/// mirror image.
fn circulant_eigenvalues(half: usize) -> Vec<f64> {
    let forward = forward(2 * half);
    let mut row: Vec<f64> = (0..2 * half).map(|lag| autocovariance(lag.min(2 * half - lag))).collect();
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut row, &mut spectrum).expect("both buffers have the planned length");
    spectrum.into_iter().map(|value| value.re).collect()
}

/// Normal deviates whose variances are the eigenvalues.
fn draw_spectrum<R: Rng>(eigenvalues: &[f64], period: usize, rng: &mut R) -> Vec<Complex64> {
    let last = eigenvalues.len() - 1;
    let draw = |(k, &eigenvalue): (usize, &f64)| {
        // Only rounding makes an eigenvalue negative, see the test.
        let variance = eigenvalue.max(0.0) / period as f64;
        let real: f64 = StandardNormal.sample(rng);
        let imaginary: f64 = StandardNormal.sample(rng);
        if k == 0 || k == last {
            Complex64::new(variance.sqrt() * real, 0.0)
        } else {
            (0.5 * variance).sqrt() * Complex64::new(real, imaginary)
        }
    };
    eigenvalues.iter().enumerate().map(draw).collect()
}

/// The smallest 2ᵃ or 3·2ᵃ of at least `n`, for a fast transform.
fn embedding_half(n: usize) -> usize {
    let power = n.max(2).next_power_of_two();
    let three_quarters = power / 4 * 3;
    if three_quarters >= n && three_quarters > 0 { three_quarters } else { power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_of_the_embedding_are_not_negative() {
        for half in [2, 3, 4, 6, 8, 48, 64, 1 << 12, 3 << 12, 1 << 16] {
            let least = circulant_eigenvalues(half).into_iter().fold(f64::INFINITY, f64::min);
            // The smallest, at zero frequency, is about (4 / π) / (2 half): far above the rounding of the transform.
            assert!(least > 0.0, "half {half}: {least}");
        }
    }

    #[test]
    fn embedding_is_long_enough() {
        for n in 1..2000 {
            let half = embedding_half(n);
            assert!(half >= n && half <= 2 * n.max(2));
        }
    }
}
