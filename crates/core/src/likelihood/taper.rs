//! Segments of a record: their tapers and lengths, and the number of separate spectra.

use std::f64::consts::PI;

/// Number of parts of the record with separate spectra, which show whether the white noise changes.
pub(crate) const PARTS: usize = 8;

/// Hann's taper, normalised so that the sum of its squares is 1.
pub(crate) fn hann(length: usize) -> Vec<f64> {
    let mut taper: Vec<f64> =
        (0..length).map(|i| (PI * (i as f64 + 0.5) / length as f64).sin().powi(2)).collect();
    let norm = taper.iter().map(|h| h * h).sum::<f64>().sqrt();
    for h in &mut taper {
        *h /= norm;
    }
    taper
}

/// The smallest even length ≥ `least` without a prime factor above 5.
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
