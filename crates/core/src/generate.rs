//! Simulated rate records: every term has exactly the Allan variance of its sampled closed form in [`crate::terms`].

use crate::error::Error;
use crate::flicker::flicker;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Noise coefficients in SI units; 0 leaves a term out. All but the ramp are ≥ 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Coefficients {
    /// Q, standard deviation of white noise on the phase.
    pub quantization: f64,
    /// N, square root of the two-sided density of white noise on the rate.
    pub random_walk: f64,
    /// B, of the flicker noise B² / (2πf).
    pub bias_instability: f64,
    /// K, of the random walk of the samples, yₖ = yₖ₋₁ + K √τ₀ wₖ.
    pub rate_random_walk: f64,
    /// R, slope of the deterministic ramp R τ₀ k, of either sign.
    pub rate_ramp: f64,
}

/// The terms that draw random numbers; each has a stream of its own, so that a new term leaves the others' draws alone.
#[derive(Clone, Copy)]
enum Drawn {
    Quantization = 0,
    RandomWalk = 1,
    BiasInstability = 2,
    RateRandomWalk = 3,
}

/// Simulates `n` rate samples. The same `seed` and `stream` give the same record; streams of a seed are independent.
///
/// # Errors
///
/// [`Error::Parameter`] for a `tau0` that is not positive, or a coefficient out of its range.
pub fn simulate(n: usize, tau0: f64, c: &Coefficients, seed: u64, stream: u64) -> Result<Vec<f64>, Error> {
    check(tau0, c)?;
    let generator = |term: Drawn| {
        // The key holds seed and stream side by side, so that no two pairs share one.
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&stream.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(term as u64);
        rng
    };
    let deviates = |term: Drawn| StandardNormal.sample_iter(generator(term));

    let mut rate: Vec<f64> = (0..n).map(|k| c.rate_ramp * tau0 * k as f64).collect();
    if c.quantization > 0.0 {
        let mut errors = deviates(Drawn::Quantization);
        let mut before: f64 = errors.next().unwrap_or_default();
        for (y, error) in rate.iter_mut().zip(errors) {
            *y += c.quantization / tau0 * (error - before);
            before = error;
        }
    }
    if c.random_walk > 0.0 {
        let sigma = c.random_walk / tau0.sqrt();
        for (y, w) in rate.iter_mut().zip(deviates(Drawn::RandomWalk)) {
            *y += sigma * w;
        }
    }
    if c.bias_instability > 0.0 {
        let noise = flicker(n, c.bias_instability, &mut generator(Drawn::BiasInstability));
        for (y, x) in rate.iter_mut().zip(noise) {
            *y += x;
        }
    }
    if c.rate_random_walk > 0.0 {
        let sigma = c.rate_random_walk * tau0.sqrt();
        let mut level = 0.0;
        for (y, w) in rate.iter_mut().zip(deviates(Drawn::RateRandomWalk)) {
            level += sigma * w;
            *y += level;
        }
    }
    Ok(rate)
}

fn check(tau0: f64, c: &Coefficients) -> Result<(), Error> {
    if !(tau0 > 0.0 && tau0.is_finite()) {
        return Err(Error::Parameter { name: "tau0", value: tau0 });
    }
    if !c.rate_ramp.is_finite() {
        return Err(Error::Parameter { name: "rate_ramp", value: c.rate_ramp });
    }
    let not_negative = [
        ("quantization", c.quantization),
        ("random_walk", c.random_walk),
        ("bias_instability", c.bias_instability),
        ("rate_random_walk", c.rate_random_walk),
    ];
    match not_negative.into_iter().find(|&(_, value)| !(value >= 0.0 && value.is_finite())) {
        Some((name, value)) => Err(Error::Parameter { name, value }),
        None => Ok(()),
    }
}
