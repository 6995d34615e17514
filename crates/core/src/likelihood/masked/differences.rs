//! Segments of differences instead of samples, for records with strong low frequencies.
//!
//! A mask spreads the power of low frequencies over all others. If this power is large, as for a rate random walk without
//! white noise, the densities contain no other information and are all equal. Differences of the samples have little power
//! at low frequencies: those of a rate random walk are white. Their densities are divided by the gain 4 sin²(πf·step·τ₀),
//! so that the models remain those of the samples.

use std::f64::consts::PI;

/// Longest step of a difference. \[samples\]
const MAX_STEP: usize = 8;

/// Share of the pairs of the best step above which a shorter step is preferred.
const MIN_SHARE_OF_PAIRS: f64 = 0.5;

/// Largest ratio of gains in a piece of a bin, within which the gain is treated as constant. The weights of the frequencies
/// in the piece are wrong by up to half of it, which matters where a filter changes in a bin. Measured: with 1.1, densities
/// beside the zeros of a running mean are up to 1 % wrong, with 1.03 up to 0.2 %.
const MAX_GAIN_RATIO: f64 = 1.03;

/// Differences of samples, and whether the segments contain them instead of the samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Differences {
    /// Distance of two samples: the shortest distance that many pairs have.
    pub step: usize,
    pub used: bool,
}

impl Differences {
    pub(super) fn new(present: &[bool], used: bool) -> Self {
        let counts: Vec<usize> = (1..=MAX_STEP)
            .map(|step| {
                present.iter().zip(&present[step.min(present.len())..]).filter(|(a, b)| **a && **b).count()
            })
            .collect();
        let most = counts.iter().copied().max().unwrap_or(0) as f64;
        let step = 1 + counts.iter().position(|&n| n as f64 >= MIN_SHARE_OF_PAIRS * most).unwrap_or(0);
        Self { step, used }
    }

    /// Mask of the values of the segments.
    pub(super) fn value_mask(self, present: &[bool]) -> Vec<bool> {
        (0..present.len()).map(|t| t >= self.step && present[t] && present[t - self.step]).collect()
    }

    /// Density of the differences over that of the samples, at `cycles` in a sample interval.
    pub(super) fn gain(self, cycles: f64) -> f64 {
        if self.used { 4.0 * (PI * cycles * self.step as f64).sin().powi(2) } else { 1.0 }
    }

    /// The gain at the densities of a segment; where it is 0, the neighbouring value.
    pub(super) fn gains(self, length: usize) -> Vec<f64> {
        let least = self.gain(1.0 / length as f64);
        (0..=length / 2).map(|k| self.gain(k as f64 / length as f64).max(least)).collect()
    }

    /// Covariance of the values in the segments, from that of the samples.
    pub(super) fn covariance(self, lag: usize, of: impl Fn(usize) -> f64) -> f64 {
        if self.used { 2.0 * of(lag) - of(lag + self.step) - of(lag.abs_diff(self.step)) } else { of(lag) }
    }

    /// Whether a density is an image of frequencies below `first`, which the modes describe: a record with every second
    /// sample, for example, has such images at half the rate.
    pub(super) fn repeats(self, k: usize, length: usize, first: usize) -> bool {
        let period = length as f64 / self.step as f64;
        let images = (k as f64 / period).round();
        images > 0.0 && (k as f64 - images * period).abs() < first as f64
    }

    /// Pieces of stretches of densities within which the gain is nearly constant.
    pub(super) fn pieces(self, stretches: &[(usize, usize)], gains: &[f64]) -> Vec<(usize, usize)> {
        if !self.used {
            return stretches.to_vec();
        }
        let mut found = Vec::new();
        for &(a, b) in stretches {
            let mut start = a;
            for k in a + 1..=b {
                let ratio = gains.get(k).map_or(1.0, |g| g / gains[start]);
                if k == b || !(1.0 / MAX_GAIN_RATIO..MAX_GAIN_RATIO).contains(&ratio) {
                    found.push((start, k));
                    start = k;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_is_one_that_many_pairs_have() {
        let step = |present: &dyn Fn(usize) -> bool| {
            Differences::new(&(0..1000).map(present).collect::<Vec<_>>(), true).step
        };
        assert_eq!(step(&|_| true), 1);
        assert_eq!(step(&|t| t % 2 == 0), 2);
        assert_eq!(step(&|t| t % 3 > 0), 1);
        assert_eq!(step(&|t| t % 5 == 0), 5);
    }

    #[test]
    fn differences_of_a_walk_are_white_and_images_are_known() {
        let every = Differences { step: 2, used: true };
        let lags: Vec<f64> = (0..5).map(|l| every.covariance(l, |l| -0.5 * l as f64)).collect();
        assert_eq!(lags, [2.0, 1.0, 0.0, 0.0, 0.0]);
        let found: Vec<usize> = (0..=32).filter(|&k| every.repeats(k, 64, 3)).collect();
        assert_eq!(found, [30, 31, 32]);
        assert!((0..=32).all(|k| !Differences { step: 1, used: true }.repeats(k, 64, 3)));
    }

    #[test]
    fn pieces_cover_their_stretches() {
        let adjacent = Differences { step: 1, used: true };
        let gains = adjacent.gains(256);
        let pieces = adjacent.pieces(&[(8, 12), (60, 64)], &gains);
        assert_eq!(pieces, [(8, 9), (9, 10), (10, 11), (11, 12), (60, 62), (62, 64)]);
        assert_eq!(Differences { used: false, ..adjacent }.pieces(&[(8, 12)], &gains), [(8, 12)]);
    }
}
