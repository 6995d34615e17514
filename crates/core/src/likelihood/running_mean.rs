//! A running mean of the samples. It is recognised by the zeros of the periodogram, which are evenly spaced, and by the
//! lobes between them, whose shape is known.

use crate::likelihood::bins::{first_density, median};
use crate::likelihood::filter_shapes::Shape;
use crate::likelihood::line::density_freedom;
use crate::likelihood::summary::Summary;

/// Number of samples of means that are recognised. A mean of two is the first-order digital Butterworth filter at a quarter
/// of the rate.
const LENGTHS: std::ops::RangeInclusive<u32> = 3..=200;

/// Smallest distance of two zeros in densities: Hann's taper hides a narrower lobe.
const MIN_LOBE: f64 = 8.0;

/// Numbers of densities on either side of a zero that are not compared, and not fitted, because the taper fills the zero.
/// The second number is at least a share of the distance of the zeros, at which |H|² is 2 % of the lobe, because the
/// filling of a zero resembles a line.
const AT_ZERO: f64 = 2.0;
const NOT_FITTED: f64 = 3.0;
const SHARE_NOT_FITTED: f64 = 0.05;

/// Largest ratio of the density at the first zero to that in the middle of the main lobe.
const MAX_RATIO_AT_ZERO: f64 = 0.05;

/// The first side lobe without its edges, in distances of zeros; smallest ratio of its density to that of the adjacent
/// zeros.
const SIDE_LOBE: [f64; 2] = [1.25, 1.75];
const ABOVE_ZEROS: f64 = 4.0;

/// Part of the main lobe that shows its level, in distances of zeros. Lower frequencies may contain slow noise.
const MAIN_LOBE: [f64; 2] = [0.2, 0.7];

/// Smallest ratios of the density to the floor of the zeros at which it is compared, and fitted.
const COMPARED_FROM: f64 = 10.0;
const FITTED_FROM: f64 = 30.0;

/// Smallest number of densities that are compared.
const MIN_COMPARED: usize = 16;

/// Largest scatter of the logarithm of the density about the shape: a multiple of chance, plus a constant. The median of
/// some 100 densities that share their noise is 1.3 times chance once in 3000 records.
const TIMES_CHANCE: f64 = 1.3;
const ADDED_SCATTER: f64 = 0.1;

/// Standard deviation of normal deviates over the median of their magnitudes.
const SIGMA_PER_MEDIAN: f64 = 1.4826;

/// Frequency, over the distance of densities, that replaces 0.
const LOWEST_FREQUENCY: f64 = 1e-6;

/// A mean of the last samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningMean {
    /// Number of samples in the mean.
    pub length: u32,
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Density of the zeros over that of the lowest frequencies, from the ends of the record and from noise after the mean.
    pub floor: f64,
}

/// A length for which the record has zeros.
struct Candidate {
    mean: RunningMean,
    /// Density of the zeros.
    floor: f64,
}

/// Comparison of a record with a length.
struct Comparison {
    mean: RunningMean,
    /// Density of the zeros over that of the lowest frequencies.
    floor: f64,
    scatter: f64,
}

impl RunningMean {
    /// The running mean in front of a record, and the mask of the densities that show noise; None for other records.
    pub(crate) fn of(record: &Summary) -> Option<(Self, Vec<bool>)> {
        let means = LENGTHS.map(|length| Self { length, tau0: record.tau0, floor: 0.0 });
        let candidates: Vec<Candidate> = means.filter_map(|mean| Candidate::of(record, mean)).collect();
        // A length next to the true one has higher zeros, and lobes at the zeros of the record.
        let floor = candidates.iter().map(|candidate| candidate.floor).fold(f64::INFINITY, f64::min);
        let compared = candidates.iter().filter_map(|candidate| candidate.mean.compared(record, floor));
        let nearest = compared.min_by(|a, b| a.scatter.total_cmp(&b.scatter))?;
        let mask = nearest.fitted(record);
        Some((Self { floor: nearest.floor, ..nearest.mean }, mask))
    }

    /// ln |H|² at a frequency. \[Hz\]
    pub(crate) fn log_power(self, f: f64) -> f64 {
        Shape::RunningMean { length: self.length }.log_power(f * self.tau0)
    }

    /// ln |H|² for the periodogram, whose neighbouring densities, `spacing` apart, share their power (Hann). \[Hz\]
    pub(crate) fn log_tapered_power(self, f: f64, spacing: f64) -> f64 {
        tapered(|f| self.log_power(f).exp(), f, spacing).ln()
    }

    /// [`Self::log_tapered_power`] with the floor of the zeros.
    pub(crate) fn log_measured_power(self, f: f64, spacing: f64) -> f64 {
        (self.log_tapered_power(f, spacing).exp() + self.floor).ln()
    }

    /// |H|² at the densities of the periodogram.
    pub(crate) fn powers(self, record: &Summary) -> Vec<f64> {
        let spacing = record.frequency(1);
        (0..record.density.len())
            .map(|k| self.log_tapered_power(record.frequency(k), spacing).exp())
            .collect()
    }

    /// Frequency of half the power. \[Hz\]
    pub(crate) fn corner(self) -> f64 {
        Shape::RunningMean { length: self.length }.half_power() / self.tau0
    }

    /// A mask of all densities up to the end of the last fitted lobe, so that the flank of a high lobe does not count as a
    /// line.
    pub(crate) fn with_lobes(self, record: &Summary, mask: &[bool]) -> Vec<bool> {
        let spacing = self.spacing(record);
        let last = mask.iter().rposition(|&used| used).unwrap_or(0);
        let end = (last as f64 / spacing).ceil() * spacing + NOT_FITTED;
        (0..mask.len()).map(|k| k as f64 <= end).collect()
    }

    /// The level and the scatter of the densities about the shape; None if the lobes do not fit.
    fn compared(self, record: &Summary, floor: f64) -> Option<Comparison> {
        let (density, last) = (&record.density, record.density.len() - 1);
        let spacing = self.spacing(record);
        let main_lobe = MAIN_LOBE.map(|lobes| (lobes * spacing).round() as usize);
        let powers = self.powers(record);
        let levels = (main_lobe[0]..main_lobe[1]).map(|k| (density[k] - floor) / powers[k]);
        let level = median(&levels.collect::<Vec<f64>>());
        let ratios: Vec<f64> = (main_lobe[0]..last)
            .filter(|&k| to_zero(k, spacing) > AT_ZERO && level * powers[k] > COMPARED_FROM * floor)
            .map(|k| (density[k] / (level * powers[k] + floor)).ln())
            .collect();
        if ratios.len() < MIN_COMPARED {
            return None;
        }
        // The main lobe of a long mean contains few densities, so that its level is uncertain.
        let off = median(&ratios);
        let scatter =
            SIGMA_PER_MEDIAN * median(&ratios.iter().map(|x| (x - off).abs()).collect::<Vec<f64>>());
        let chance = (2.0 / density_freedom(record)).sqrt();
        let floor = floor / (level * off.exp());
        (scatter < TIMES_CHANCE * chance + ADDED_SCATTER).then_some(Comparison { mean: self, floor, scatter })
    }

    /// Distance of the zeros of the periodogram, in densities.
    fn spacing(self, record: &Summary) -> f64 {
        record.segment as f64 / f64::from(self.length)
    }
}

/// |H|² for the periodogram, whose neighbouring densities, `spacing` apart, share their power (Hann). \[Hz\]
fn tapered(power: impl Fn(f64) -> f64, f: f64, spacing: f64) -> f64 {
    tapered_power(&tapered_neighbours(f, spacing).map(power))
}

/// Frequencies whose power the density at f contains: f and its neighbours. \[Hz\]
pub(crate) fn tapered_neighbours(f: f64, spacing: f64) -> [f64; 3] {
    [f, f - spacing, f + spacing].map(|f| f.abs().max(LOWEST_FREQUENCY * spacing))
}

/// |H|² for the periodogram from that at [`tapered_neighbours`].
pub(crate) fn tapered_power(power: &[f64]) -> f64 {
    power[0] * 2.0 / 3.0 + (power[1] + power[2]) / 6.0
}

impl Candidate {
    /// None unless the periodogram has these zeros, and a lobe after the first zero.
    fn of(record: &Summary, mean: RunningMean) -> Option<Self> {
        let spacing = mean.spacing(record);
        let (density, last) = (&record.density, record.density.len() - 1);
        if spacing < MIN_LOBE {
            return None;
        }
        let at = |lobes: f64| ((lobes * spacing).round() as usize).min(last);
        let neighbours = |k: usize| &density[k - 1..=(k + 1).min(last)];
        let at_zero = |m: usize| neighbours(at(m as f64)).iter().copied().fold(f64::INFINITY, f64::min);
        if at_zero(1) > MAX_RATIO_AT_ZERO * median(neighbours(at(0.5))) {
            return None;
        }
        let count = (last as f64 / spacing).floor() as usize;
        let side_lobe = median(&density[at(SIDE_LOBE[0])..at(SIDE_LOBE[1])]);
        if !(1..=count.min(2)).all(|m| side_lobe > ABOVE_ZEROS * at_zero(m)) {
            return None;
        }
        let floor = median(&(1..=count).map(at_zero).collect::<Vec<f64>>());
        Some(Self { mean, floor })
    }
}

impl Comparison {
    /// Mask of the densities that are fitted, above the floor and away from the zeros, and of the modes below them.
    fn fitted(&self, record: &Summary) -> Vec<bool> {
        let (first, last) = (first_density(record), record.density.len() - 1);
        let spacing = self.mean.spacing(record);
        let powers = self.mean.powers(record);
        let margin = NOT_FITTED.max(SHARE_NOT_FITTED * spacing);
        let fits =
            |k: usize| k < last && to_zero(k, spacing) > margin && powers[k] > FITTED_FROM * self.floor;
        let repeats = |k: usize| {
            k >= first
                && record.masked.as_ref().is_some_and(|masked| masked.repeats(k, record.segment, first))
        };
        (0..=last).map(|k| fits(k) && !repeats(k)).collect()
    }
}

/// Distance of a density to the next zero, in densities.
fn to_zero(k: usize, spacing: f64) -> f64 {
    let nearest = (k as f64 / spacing).round().max(1.0);
    (k as f64 - nearest * spacing).abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    fn summary(samples: &[f64]) -> Summary {
        Summary::of(samples, 0.01).unwrap()
    }

    /// Noise of one value a sample, nearly normal.
    fn noise(samples: usize) -> Vec<f64> {
        let mut state = 39_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..samples).map(|_| (0..6).map(|_| uniform()).sum()).collect()
    }

    fn mean_of(x: &[f64], length: usize) -> Vec<f64> {
        x.windows(length).map(|w| w.iter().sum::<f64>() / length as f64).collect()
    }

    #[test]
    fn lengths_are_recognised() {
        let white = noise(40_000);
        assert!(RunningMean::of(&summary(&white)).is_none());
        for length in [3, 4, 5, 8, 16, 20, 32, 64, 100, 200] {
            let (mean, mask) = RunningMean::of(&summary(&mean_of(&white, length))).unwrap();
            assert_eq!(mean.length as usize, length);
            assert!(mask.iter().filter(|&&used| used).count() > 150);
        }
        // The same mean twice is a different filter.
        assert!(RunningMean::of(&summary(&mean_of(&mean_of(&white, 16), 16))).is_none());
        // A short record does not show the narrow lobes of a long mean.
        assert!(RunningMean::of(&summary(&mean_of(&white[..15_000], 200))).is_none());
    }

    #[test]
    fn half_the_power_at_the_corner() {
        for length in [5, 16, 64] {
            let mean = RunningMean { length, tau0: 0.01, floor: 0.0 };
            assert!((mean.log_power(mean.corner()).exp() - 0.5).abs() < 1e-9, "{length}");
        }
    }
}
