//! Noise with a density of f^−α, 0 < α < 2: bias instability with an exponent other than 1.
//!
//! A sum over Gauss-Markov processes whose correlation times are a geometric series and whose variances grow with T^(α−1) has
//! this density (∫ T^(α−1) 2T/(1 + (2πfT)²) dT/T = π (2πf)^−α / sin(πα/2)). With two processes per decade its error is
//! below 2·10⁻⁴, and its densities at the modes of a record are exact sums.

use crate::likelihood::expected::{Blocks, MATERN_STEP, MarkovModes, ModePoint, Part};
use crate::matern;
use crate::terms::Term;
use std::f64::consts::{LN_10, PI};

/// Number of processes per decade of correlation times.
const IN_DECADE: i32 = 2;

/// Longest correlation time over the length of the record; slower processes are a random walk.
const MAX_TIME_RATIO: f64 = 30.0;

/// Correlation time over that of the slowest process above which a process represents a random walk.
const WALK_TIME_RATIO: f64 = 3.0;

/// Range of exponents: below, the noise is white; above, it is a random walk.
pub(crate) const EXPONENTS: (f64, f64) = (0.3, 1.9);

/// Processes that add up to noise with a density B²/(2πf)·(f/pivot)^(1−α), two-sided, B = 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mixture {
    /// Variance and correlation time of each process. \[s\]
    processes: Vec<(f64, f64)>,
    /// K² of all slower processes.
    walk: f64,
    /// N² of all faster processes.
    pub white: f64,
}

impl Mixture {
    pub(crate) fn new(exponent: f64, pivot: f64, tau0: f64, duration: f64) -> Self {
        let step = LN_10 / f64::from(IN_DECADE);
        let weight = (2.0 * PI * pivot).powf(exponent - 1.0) * (0.5 * PI * exponent).sin() / PI * step;
        let ratio = step.exp();
        let count = ((MAX_TIME_RATIO * duration / (2.0 * tau0)).ln() / step).ceil().max(1.0) as i32;
        let first = 2.0 * tau0;
        let at = |j: i32| {
            let time = first * ratio.powi(j);
            (weight * time.powf(exponent - 1.0), time)
        };
        // Geometric sums of 2σ²/T above the last, and of 2σ²T below the first process.
        let (variance, time) = at(count);
        let walk = 2.0 * variance / time / (1.0 - ratio.powf(exponent - 2.0));
        let (variance, time) = at(-1);
        let white = 2.0 * variance * time / (1.0 - ratio.powf(-exponent));
        Self { processes: (0..count).map(at).collect(), walk, white }
    }

    /// A Matérn process of unit variance.
    pub(crate) fn matern(smoothness: f64, time: f64, tau0: f64) -> Self {
        let sum = matern::processes(smoothness, time / tau0, MATERN_STEP).into_iter();
        let processes = sum.map(|(variance, time)| (variance, time * tau0)).collect();
        Self { processes, walk: 0.0, white: 0.0 }
    }

    /// All processes; the last one represents the slowest ones, which are a random walk over the record.
    pub(crate) fn processes(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let slowest = self.processes.last().map(|(_, time)| WALK_TIME_RATIO * time);
        let walk = slowest.map(|time| (0.5 * self.walk * time, time));
        self.processes.iter().copied().chain(walk)
    }

    /// The mixture with all variances multiplied by `theta`.
    pub(crate) fn times(mut self, theta: f64) -> Self {
        self.processes.iter_mut().for_each(|(variance, _)| *variance *= theta);
        Self { walk: theta * self.walk, white: theta * self.white, ..self }
    }

    /// A function that returns the density at a mode.
    pub(crate) fn at_modes(&self, blocks: Blocks) -> impl Fn(&ModePoint) -> f64 + use<> {
        let modes: Vec<(f64, MarkovModes)> =
            self.processes.iter().map(|&(variance, time)| (variance, blocks.gauss_markov(time))).collect();
        let (walk, white) = (self.walk, self.white);
        move |at| {
            let processes: f64 = modes.iter().map(|(variance, process)| variance * process.density(at)).sum();
            processes + walk * blocks.density(Part::Term(Term::RateRandomWalk), at) + white
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::expected::flicker_modes;

    #[test]
    fn mixture_with_exponent_1_is_flicker_noise() {
        let blocks = Blocks { samples: 16, count: 4096, tau0: 0.02 };
        let flicker = flicker_modes(blocks, 512);
        let length = 16.0 * 0.02;
        let mixture = Mixture::new(1.0, 0.01, 0.02, 4096.0 * length).at_modes(blocks);
        for k in [1, 2, 10, 100, 500] {
            let ratio = mixture(&blocks.point(k)) / (length * flicker[k - 1]);
            assert!((ratio - 1.0).abs() < 2e-3, "mode {k}: {ratio}");
        }
    }

    #[test]
    fn density_of_mixture_is_that_of_power_law() {
        for exponent in [0.5_f64, 0.8, 1.3, 1.7] {
            let pivot = 0.02;
            let mixture = Mixture::new(exponent, pivot, 0.01, 1e4);
            for f in [2e-4, 1e-3, 0.1, 1.0] {
                let density: f64 = mixture
                    .processes
                    .iter()
                    .map(|(variance, time)| 2.0 * variance * time / (1.0 + (2.0 * PI * f * time).powi(2)))
                    .sum();
                let density = density + mixture.white + mixture.walk / (2.0 * PI * f).powi(2);
                let expected = (f / pivot).powf(1.0 - exponent) / (2.0 * PI * f);
                assert!(
                    (density / expected - 1.0).abs() < 1e-3,
                    "{exponent}, {f} Hz: {}",
                    density / expected
                );
            }
        }
    }
}
