//! Segments of a record: their tapers and lengths, and how many spectra are kept apart.

use std::f64::consts::PI;

/// Parts of the record whose spectra are kept apart, to see whether the noise level changes.
pub(crate) const PARTS: usize = 8;

/// Hann's taper, the sum of its squares being 1.
pub(crate) fn hann(length: usize) -> Vec<f64> {
    let mut taper: Vec<f64> =
        (0..length).map(|i| (PI * (i as f64 + 0.5) / length as f64).sin().powi(2)).collect();
    let norm = taper.iter().map(|h| h * h).sum::<f64>().sqrt();
    for h in &mut taper {
        *h /= norm;
    }
    taper
}

/// The smallest length ≥ `least` without a prime factor above 5, and even.
pub(crate) fn smooth(least: usize) -> usize {
    let mut n = least + least % 2;
    loop {
        let mut rest = n;
        for prime in [2, 3, 5] {
            while rest % prime == 0 {
                rest /= prime;
            }
        }
        if rest == 1 {
            return n;
        }
        n += 2;
    }
}
