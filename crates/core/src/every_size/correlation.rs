//! Sums of products at every lag, by Fourier transforms.

use sigmatau_fft::Complex64;
use sigmatau_fft::{ComplexToReal, RealToComplex};
use std::sync::Arc;

/// `sums[l] = Σ_k block[k] window[k + l]`; beyond its end the window is 0.
///
/// The error of each sum is a few rounding errors of ‖block‖ ‖window‖, even if the sum is small.
pub fn cross(block: &[f64], window: &[f64], sums: &mut [f64]) {
    let length = block.len() + sums.len() - 1;
    let transform = transform(length);
    let mut real = vec![0.0; transform.length()];
    let of_block = transform.forward(block, &mut real);
    let mut product = transform.forward(&window[..length.min(window.len())], &mut real);
    for (value, other) in product.iter_mut().zip(of_block) {
        *value *= other.conj();
    }
    transform.inverse(&mut product, &mut real, sums);
}

/// [`cross`] of a block with itself, with one transform fewer.
pub fn auto(block: &[f64], sums: &mut [f64]) {
    let transform = transform(block.len() + sums.len() - 1);
    let mut real = vec![0.0; transform.length()];
    let mut power = transform.forward(block, &mut real);
    for value in &mut power {
        *value = value.norm_sqr().into();
    }
    transform.inverse(&mut power, &mut real, sums);
}

/// A pair of transforms that are long enough for `least` points.
fn transform(least: usize) -> Transform {
    let length = good_length(least);
    Transform { forward: sigmatau_fft::forward(length), inverse: sigmatau_fft::inverse(length) }
}

struct Transform {
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Transform {
    fn length(&self) -> usize {
        self.forward.len()
    }

    /// Spectrum of zero-padded `values`; `real` is overwritten.
    fn forward(&self, values: &[f64], real: &mut [f64]) -> Vec<Complex64> {
        let (head, tail) = real.split_at_mut(values.len());
        head.copy_from_slice(values);
        tail.fill(0.0);
        let mut spectrum = self.forward.make_output_vec();
        self.forward.process(real, &mut spectrum).expect("both buffers have the planned length");
        spectrum
    }

    /// The first values of the inverse transform; the spectrum and `real` are overwritten.
    fn inverse(&self, spectrum: &mut [Complex64], real: &mut [f64], values: &mut [f64]) {
        // Products of spectra of real values are real at both ends, but the zero imaginary part may be
        // negative.
        spectrum[0].im = 0.0;
        if let Some(last) = spectrum.last_mut() {
            last.im = 0.0;
        }
        self.inverse.process(spectrum, real).expect("the spectrum has its length and real ends");
        let scale = 1.0 / real.len() as f64;
        for (value, sum) in values.iter_mut().zip(real) {
            *value = *sum * scale;
        }
    }
}

/// The smallest even length of at least `least` that is a power of 2 times 1, 3, 5, 9 or 15, for a fast
/// transform.
fn good_length(least: usize) -> usize {
    let least = least.max(2);
    let with = |factor: usize| factor * least.div_ceil(factor).next_power_of_two().max(2);
    [3, 5, 9, 15].into_iter().map(with).fold(least.next_power_of_two(), usize::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_long_enough_and_not_much_longer() {
        for least in 1..5000 {
            let length = good_length(least);
            assert!(length >= least && length % 2 == 0);
            // The next lengths after 15 are 16, 18, 20, 24, 30: at most a quarter too long.
            assert!(least < 15 || 4 * length <= 5 * least + 4, "{least}: {length}");
        }
    }

    #[test]
    fn sums_of_integers() {
        let values: Vec<f64> = (0..300u32).map(|k| f64::from((k * k * 7919) % 41) - 20.0).collect();
        for (starts, end, lags) in [(1, 1, 1), (100, 300, 200), (100, 150, 200), (300, 300, 300), (7, 300, 3)]
        {
            let (block, window) = (&values[..starts], &values[..end]);
            let mut sums = vec![f64::NAN; lags];
            cross(block, window, &mut sums);
            let direct =
                |lag: usize| -> f64 { block.iter().zip(&window[lag.min(end)..]).map(|(x, y)| x * y).sum() };
            for (lag, sum) in sums.iter().enumerate() {
                // Sums of at most 300 products below 400: 1e-16 of 1e5, some times over.
                assert!((sum - direct(lag)).abs() < 1e-9, "{starts} {end} {lag}: {sum}");
            }
            if starts == end {
                let mut same = vec![f64::NAN; lags];
                auto(block, &mut same);
                assert!(sums.iter().zip(same).all(|(a, b)| (a - b).abs() < 1e-9));
            }
        }
    }
}
