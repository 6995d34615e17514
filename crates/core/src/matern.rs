//! The Matérn process, S(f) ∝ (1 + (2πfT)²)^−(ν + 1/2), 0 < ν ≤ 1/2, as a sum of Gauss-Markov processes.
//!
//! With α = ν + 1/2 and times in units of T, Stieltjes' integral
//!
//!   (1 + ω²)^−α = sin(πα)/π ∫ v^−α / (1 + v + ω²) dv,  v = 0 … ∞,
//!
//! is a sum of processes with the autocovariance e^(−t√(1 + v)), whose variances are positive. The trapezoidal rule in ln v
//! with the step h has an error of about e^(−2π²/h), the distance π of the singularity 1 + v = 0 from the real axis. The
//! processes at both ends are summed as geometric series: for large v they are white noise, for small v two processes have the
//! same four moments (Gauss).
//!
//! B. Matérn, Spatial Variation, Lecture Notes in Statistics 36, 1986, doi 10.1007/978-1-4615-7892-5; J. M. Lilly et al.,
//! "Fractional Brownian motion, the Matérn process, and stochastic modeling of turbulent dispersion", Nonlinear Processes in
//! Geophysics 24, 2017, doi 10.5194/npg-24-481-2017.

use std::f64::consts::PI;

/// Range of the smoothness: the variance is finite above 0, and the process is a sum of Gauss-Markov processes up to 1/2.
pub const SMOOTHNESS: (f64, f64) = (0.02, 0.5);

/// Step of ln v with an error below 1e-13.
pub const EXACT_STEP: f64 = 0.6;

/// Decay per sample of white noise, e^−45.
const WHITE_DECAY: f64 = 45.0;

/// Smallest v of the upper end, where √(1 + v) is √v.
const MIN_HIGH_END: f64 = 1e14;

/// Distance of the smoothness from 1/2 below which the process is the Gauss-Markov process.
const SAME: f64 = 1e-9;

/// Variances and correlation times of the sum of unit variance. Times are in samples, as the time of the process; the
/// processes that are faster than the samples are one. `step` is that of ln v.
#[must_use]
pub fn processes(smoothness: f64, time: f64, step: f64) -> Vec<(f64, f64)> {
    // The weight of a node is v^power.
    let power = 0.5 - smoothness;
    if power < SAME {
        return vec![(1.0, time)];
    }
    let alpha = smoothness + 0.5;
    let scale = libm::tgamma(alpha) / libm::tgamma(smoothness) / PI.sqrt() * (PI * power).sin() * step;
    // The largest v of the two nodes: the fifth moment has the error of the rule.
    let low_end = (-0.5 * PI * PI / step).exp();
    let high_end = (WHITE_DECAY * time).powi(2).max(MIN_HIGH_END);
    let count = ((high_end / low_end).ln() / step).ceil() as i32;
    let place = |k: i32| low_end * (f64::from(k) * step).exp();
    let regular = (1..count).map(|k| (place(k).powf(power), place(k)));
    let mut sum: Vec<(f64, f64)> = two_nodes(power, step, low_end)
        .into_iter()
        .chain(regular)
        .map(|(weight, v)| (scale * weight / (1.0 + v).sqrt(), time / (1.0 + v).sqrt()))
        .collect();
    let white = scale * place(count).powf(-smoothness) / -(-step * smoothness).exp_m1();
    sum.push((white, 1.0 / WHITE_DECAY));
    sum
}

/// Weights and places of two nodes with the first four moments of Σ v^power over v = `end`·e^(−k·step), k = 0, 1 …
fn two_nodes(power: f64, step: f64, end: f64) -> [(f64, f64); 2] {
    let [a, b, c, d] = [0.0, 1.0, 2.0, 3.0].map(|i| -1.0 / (-step * (power + i)).exp_m1());
    let determinant = a * c - b * b;
    let (sum, product) = ((a * d - b * c) / determinant, (b * d - c * c) / determinant);
    let large = 0.5 * sum + (0.25 * sum * sum - product).sqrt();
    let small = product / large;
    let weight = |x: f64, other: f64| end.powf(power) * (b - other * a) / (x - other);
    [(weight(large, small), large * end), (weight(small, large), small * end)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variances_are_positive_and_add_up_to_1() {
        for smoothness in [0.02, 0.1, 0.25, 0.4, 0.499_999, 0.5] {
            for time in [1e-3, 0.5, 30.0, 1e4, 1e9] {
                let sum = processes(smoothness, time, EXACT_STEP);
                assert!(sum.iter().all(|&(variance, _)| variance > 0.0), "{smoothness}, {time}");
                let total: f64 = sum.iter().map(|&(variance, _)| variance).sum();
                assert!((total - 1.0).abs() < 1e-12, "{smoothness}, {time}: {total}");
            }
        }
    }

    /// The density of the sum is (1 + ω²)^−α. Below 1/T the white noise adds the share of frequencies above the rate.
    #[test]
    fn density_is_the_power_of_the_definition() {
        for (step, error) in [(EXACT_STEP, 1e-7), (1.75, 1e-4)] {
            for smoothness in [0.25_f64, 0.4, 0.499] {
                let sum = processes(smoothness, 1e5, step);
                let scale = 2.0 * PI.sqrt() * libm::tgamma(smoothness + 0.5) / libm::tgamma(smoothness);
                for omega in [0.01, 0.3, 1.0, 5.0, 100.0] {
                    let lorentz = |&(variance, time): &(f64, f64)| {
                        2.0 * variance * (time / 1e5) / (1.0 + (omega * time / 1e5).powi(2))
                    };
                    let density: f64 = sum.iter().map(lorentz).sum();
                    let ratio = density / scale / (1.0 + omega * omega).powf(-smoothness - 0.5);
                    assert!((ratio - 1.0).abs() < error, "{step}, {smoothness}, {omega}: {ratio}");
                }
            }
        }
    }
}
