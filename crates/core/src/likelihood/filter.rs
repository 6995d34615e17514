//! A filter that was fitted to the spectrum: its response, its name, the interval of its corner, and its equivalent in a
//! model.

use crate::likelihood::abscissae::Abscissae;
use crate::likelihood::filter_shapes::{Family, Shape};
use crate::likelihood::running_mean::RunningMean;
use crate::psd::{avar_of_density, band_limited_sampled};
use crate::roots::root;
use std::convert::Infallible;
use std::f64::consts::{FRAC_1_SQRT_2, LN_2, PI};

/// |H|² below which the fit does not use a frequency.
pub(crate) const UNUSED_POWER: f64 = 0.08;

/// Number of grid frequencies up to half the rate 1/Δ, and the largest factor by which it is refined, so that the grid
/// extends to half the sampling rate.
const GRID: usize = 4096;
const MAX_REFINEMENT: usize = 16;

/// Smallest |H|² at which shapes are compared, and number of grid frequencies between tested corners.
const MIN_POWER: f64 = 0.1;
const POINTS_PER_CORNER: usize = 16;

/// Largest difference of ln |H|² from a named shape: 0.9 dB.
const MAX_SHAPE_DIFFERENCE: f64 = 0.2;

/// Change of a coefficient for the derivative of the corner, and the corner times the sample interval above which no finer
/// grid is needed.
const COEFFICIENT_STEP: f64 = 1e-3;
const FINE_CORNER: f64 = 0.1;

/// Largest ratio of the corner of a filter before the sampler to that of the samples, and relative error of the former.
const MAX_WARPED: f64 = 3.0;
const SAME_CORNER: f64 = 1e-9;

/// Most similar shape of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilterShape {
    /// A Butterworth filter of low order, analog or digital.
    Butterworth,
    /// Exponential smoothing.
    Smoothing,
    /// A running mean.
    RunningMean,
    /// Two poles with a free damping.
    TwoPoles,
    /// Running means of the same length in series.
    Means,
    /// A low-pass filter of another shape.
    LowPass,
    /// No low-pass filter: it does not fall to half the power.
    Uneven,
}

/// A filter of all noise except quantization: ln |H|² = Σ aₖ (cos 2πk f Δ − 1).
#[derive(Debug, Clone, PartialEq)]
pub struct FittedFilter {
    /// a₁, a₂ … \[1\]
    pub coefficients: Vec<f64>,
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Δ: the sample interval, or a multiple where the top of the band was left out. \[s\]
    pub interval: f64,
    /// Most similar shape.
    pub shape: FilterShape,
    /// Order of a Butterworth filter, or number of samples of a running mean.
    pub order: Option<u32>,
    /// Frequency of half the power, with the ends of its interval. \[Hz\]
    pub corner: Option<[f64; 3]>,
    /// The Butterworth filter before the sampler that replaces this filter in a noise model: order and corner. \[Hz\]
    pub low_pass: Option<(u8, f64)>,
    /// Frequency up to which the coefficients describe the filter. Above, its shape does, or it removes nearly all
    /// power. None: the coefficients describe it at all frequencies. \[Hz\]
    pub known_to: Option<f64>,
    /// Damping of two poles.
    pub damping: Option<f64>,
    /// Whether a Butterworth filter of known shape is in front of the sampler.
    pub analog: bool,
    /// Whether the filter acts on the random walk alone.
    pub of_white: bool,
}

impl FittedFilter {
    /// A running mean, by its closed form at all frequencies.
    pub(crate) fn of_mean(mean: RunningMean, of_white: bool) -> Self {
        Self {
            coefficients: Vec::new(),
            tau0: mean.tau0,
            interval: mean.tau0,
            shape: FilterShape::RunningMean,
            order: Some(mean.length),
            corner: Some([mean.corner(); 3]),
            low_pass: None,
            known_to: Some(0.0),
            damping: None,
            analog: false,
            of_white,
        }
    }

    /// A filter of a family, by its closed form at all frequencies. `covariance` is that of its parameters; `quantile` of
    /// the standard normal distribution determines the interval of the corner.
    pub(crate) fn from_family(
        (family, numbers): (Family, &[f64]),
        covariance: impl Fn(usize, usize) -> f64,
        (tau0, of_white): (f64, bool),
        quantile: f64,
    ) -> Self {
        let shape = family.shape(numbers);
        let corner_at = |numbers: &[f64]| family.shape(numbers).half_power().ln();
        let slopes: Vec<f64> = (0..numbers.len())
            .map(|k| {
                let [mut up, mut down] = [numbers.to_vec(), numbers.to_vec()];
                (up[k], down[k]) = (up[k] + COEFFICIENT_STEP, down[k] - COEFFICIENT_STEP);
                (corner_at(&up) - corner_at(&down)) / (2.0 * COEFFICIENT_STEP)
            })
            .collect();
        let mut variance = 0.0;
        for (i, a) in slopes.iter().enumerate() {
            for (j, b) in slopes.iter().enumerate() {
                variance += a * b * covariance(i, j);
            }
        }
        let ratio = (quantile * variance.max(0.0).sqrt()).exp();
        let corner = shape.half_power() / tau0;
        Self {
            coefficients: Vec::new(),
            tau0,
            interval: tau0,
            shape: shape.into(),
            order: shape.order(),
            corner: Some([corner, corner / ratio, corner * ratio]),
            low_pass: None,
            known_to: Some(0.0),
            damping: if let Shape::TwoPoles { damping, .. } = shape { Some(damping) } else { None },
            analog: matches!(shape, Shape::Folded { .. }),
            of_white,
        }
    }

    /// The named filter with the interval of its corner. `covariance` is that of the coefficients; `quantile` of the
    /// standard normal distribution determines the interval.
    pub(crate) fn named(
        coefficients: &[f64],
        covariance: impl Fn(usize, usize) -> f64,
        tau0: f64,
        interval: f64,
        quantile: f64,
    ) -> Self {
        let mut filter = Self {
            coefficients: coefficients.to_vec(),
            tau0,
            interval,
            shape: FilterShape::Uneven,
            order: None,
            corner: None,
            low_pass: None,
            known_to: None,
            damping: None,
            analog: false,
            of_white: false,
        };
        let times = (interval / tau0).round_ties_even();
        let x: Vec<f64> = (0..GRID).map(|k| (k as f64 + 0.5) / (2.0 * GRID as f64 * times)).collect();
        let log_power: Vec<f64> = x.iter().map(|x| logarithm(coefficients, x * times)).collect();
        let Some(k) = log_power.iter().position(|&y| y < -LN_2).filter(|&k| k > 0) else { return filter };
        let slope = (log_power[k] - log_power[k - 1]) / (x[k] - x[k - 1]);
        let share = (-LN_2 - log_power[k - 1]) / (log_power[k] - log_power[k - 1]);
        let corner = x[k - 1] + share * (x[k] - x[k - 1]);
        let cosines: Vec<f64> =
            (1..=coefficients.len()).map(|j| (2.0 * PI * corner * times * j as f64).cos() - 1.0).collect();
        let variance: f64 = cosines
            .iter()
            .enumerate()
            .flat_map(|(i, a)| cosines.iter().enumerate().map(move |(j, b)| (i, j, a * b)))
            .map(|(i, j, product)| product * covariance(i, j))
            .sum();
        let half = quantile * variance.max(0.0).sqrt() / slope.abs();
        // The compared frequencies have power; they end at the first frequency above the corner without power.
        let lowest = MIN_POWER.ln();
        let end = log_power.iter().skip(k).position(|&y| y <= lowest).map_or(GRID, |count| k + count);
        let (x, log_power): (Vec<f64>, Vec<f64>) =
            x[..end].iter().zip(&log_power).filter(|&(_, &y)| y > lowest).unzip();
        let misfit = |shape: Shape| {
            let off = x.iter().zip(&log_power).map(|(&x, y)| (shape.log_power(x) - y).abs());
            off.fold(0.0, f64::max)
        };
        let nearest = Shape::all(corner)
            .into_iter()
            .map(|shape| (misfit(shape), shape))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        // The truncated series ripples: the interval also includes the corner of the shape, which has no ripple.
        let mut ends = [corner, corner];
        if let Some((off, shape)) = nearest {
            (filter.shape, filter.order) = if off > MAX_SHAPE_DIFFERENCE {
                (FilterShape::LowPass, None)
            } else {
                (shape.into(), shape.order())
            };
            let thinned = |of: &[f64]| of.iter().copied().step_by(POINTS_PER_CORNER).collect::<Vec<f64>>();
            if let Some(alike) = shape.nearest_corner(&thinned(&x), &thinned(&log_power)) {
                ends = [corner.min(alike), corner.max(alike)];
            }
        }
        filter.corner =
            Some([corner, (ends[0] - half).max(0.0), ends[1] + half].map(|frequency| frequency / tau0));
        filter
    }

    /// |H|² at a frequency. Above the frequencies of the fit, it is that of the most similar shape, or extrapolated.
    #[must_use]
    pub fn power(&self, f: f64) -> f64 {
        self.log_power(f).exp()
    }

    /// [`Self::power`] at many frequencies. \[Hz\]
    #[must_use]
    pub(crate) fn powers(&self, frequencies: &[f64]) -> Vec<f64> {
        match (self.known_to, self.named_shape()) {
            (Some(known_to), Some(shape)) if frequencies.iter().all(|&f| f > known_to) => {
                let abscissae = Abscissae::new(frequencies.iter().map(|f| f * self.tau0).collect());
                shape.response().log_powers(&abscissae).into_iter().map(f64::exp).collect()
            }
            _ => frequencies.iter().map(|&f| self.power(f)).collect(),
        }
    }

    fn log_power(&self, f: f64) -> f64 {
        let Some(known_to) = self.known_to.filter(|&known_to| f > known_to) else {
            return logarithm(&self.coefficients, f * self.interval);
        };
        match self.named_shape() {
            Some(shape) => shape.log_power(f * self.tau0),
            None => (UNUSED_POWER * (known_to / f).powi(2)).ln(),
        }
    }

    /// The shape above the frequencies of the fit; None if it is not a named one.
    fn named_shape(&self) -> Option<Shape> {
        let corner = self.corner.map_or(f64::NAN, |[value, ..]| value) * self.tau0;
        Some(match (self.shape, self.order) {
            (FilterShape::Butterworth, Some(order)) if self.analog => Shape::Folded { order, corner },
            (FilterShape::Butterworth, Some(order)) => Shape::Digital { order, corner },
            (FilterShape::TwoPoles, _) => Shape::two_poles(corner, self.damping.unwrap_or(FRAC_1_SQRT_2)),
            (FilterShape::Means, Some(stages)) => Shape::means(corner, stages),
            (FilterShape::Smoothing, _) => Shape::Smoothing { corner },
            (FilterShape::RunningMean, Some(length)) => Shape::RunningMean { length },
            _ => return None,
        })
    }

    /// Reduction of the Allan variances by the filter, for noise with a given density before it. [(rate unit)²]
    ///
    /// Above `highest` there is no reduction, because the filter is unknown there, unless it removes all power.
    pub(crate) fn reduction_of_avar(
        &self,
        density: impl Fn(f64) -> f64,
        sizes: &[usize],
        highest: Option<f64>,
    ) -> Vec<f64> {
        let times = match self.corner {
            // Some points below a corner of known shape.
            Some([corner, ..]) if self.coefficients.is_empty() => {
                (FINE_CORNER / (corner * self.tau0)).ceil().max(1.0) as usize
            }
            _ => (self.interval / self.tau0).round_ties_even() as usize,
        };
        let limit = highest.filter(|_| self.known_to.is_none()).unwrap_or(f64::INFINITY);
        let lost = |f: f64| if f >= limit { 0.0 } else { -density(f) * self.log_power(f).exp_m1() };
        avar_of_density(lost, GRID * times.min(MAX_REFINEMENT), self.tau0, sizes)
    }

    /// The Butterworth filter in front of the sampler whose samples have half their power at the corner: order and corner
    /// in Hz. None for other shapes, and if no such filter exists.
    #[must_use]
    pub(crate) fn before_sampling(&self) -> Option<(u8, f64)> {
        let order = match self.shape {
            FilterShape::Butterworth => u8::try_from(self.order?).ok()?,
            FilterShape::Smoothing => 1,
            _ => return None,
        };
        let [half_power, ..] = self.corner?;
        if self.analog {
            return Some((order, half_power));
        }
        let off = |corner: f64| {
            let density = |f: f64| band_limited_sampled(1.0, order, corner, self.tau0, f);
            density(half_power) / density(0.0) - 0.5
        };
        let (low, high) = (half_power / MAX_WARPED, half_power * MAX_WARPED);
        let (at_low, at_high) = (off(low), off(high));
        if at_low * at_high > 0.0 {
            return None;
        }
        let corner = root(
            |x| Ok::<_, Infallible>(off(x)),
            (low, at_low),
            (high, at_high),
            SAME_CORNER * half_power,
            0.0,
        );
        corner.ok().map(|corner| (order, corner))
    }
}

impl From<Shape> for FilterShape {
    fn from(shape: Shape) -> Self {
        match shape {
            Shape::Digital { .. } | Shape::Folded { .. } => Self::Butterworth,
            Shape::Smoothing { .. } => Self::Smoothing,
            Shape::RunningMean { .. } => Self::RunningMean,
            Shape::TwoPoles { .. } => Self::TwoPoles,
            Shape::Means { .. } => Self::Means,
        }
    }
}

/// ln |H|² at a frequency times Δ.
fn logarithm(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().zip(1..).map(|(a, k)| a * ((2.0 * PI * f64::from(k) * x).cos() - 1.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAU0: f64 = 0.01;

    /// The cosine series of ln |H|² of a shape, from its values on a grid.
    fn series(shape: Shape, count: usize) -> Vec<f64> {
        let grid = 2000;
        (1..=count)
            .map(|k| {
                let at = |j: usize| (j as f64 + 0.5) / (2.0 * grid as f64);
                let sum: f64 = (0..grid)
                    .map(|j| shape.log_power(at(j)).max(-20.0) * (2.0 * PI * k as f64 * at(j)).cos())
                    .sum();
                2.0 * sum / grid as f64
            })
            .collect()
    }

    fn fitted(shape: Shape, count: usize) -> FittedFilter {
        FittedFilter::named(&series(shape, count), |i, j| if i == j { 1e-6 } else { 0.0 }, TAU0, TAU0, 1.96)
    }

    #[test]
    fn shapes_are_named() {
        let smoothing = fitted(Shape::Smoothing { corner: 0.08 }, 12);
        assert_eq!((smoothing.shape, smoothing.order), (FilterShape::Smoothing, None));
        let second = fitted(Shape::Folded { order: 2, corner: 0.2 }, 12);
        assert_eq!((second.shape, second.order), (FilterShape::Butterworth, Some(2)));
        for (filter, corner) in [(smoothing, 8.0), (second, 20.0)] {
            let [value, low, high] = filter.corner.unwrap();
            assert!(low < value && value < high);
            assert!((value / corner - 1.0).abs() < 0.05, "{value}");
            assert!((filter.power(value) - 0.5).abs() < 1e-6);
        }
        let hump = FittedFilter::named(&[-0.1], |_, _| 0.0, TAU0, TAU0, 1.96);
        assert_eq!((hump.shape, hump.corner), (FilterShape::Uneven, None));
    }

    #[test]
    fn stand_in_has_half_the_power_at_the_corner() {
        let filter = fitted(Shape::Folded { order: 2, corner: 0.2 }, 12);
        let (order, corner) = filter.before_sampling().unwrap();
        let density = |f: f64| band_limited_sampled(1.0, order, corner, TAU0, f);
        let [half_power, ..] = filter.corner.unwrap();
        assert!((density(half_power) / density(0.0) - 0.5).abs() < 1e-8);
        assert_eq!(fitted(Shape::RunningMean { length: 8 }, 12).before_sampling(), None);
    }

    /// White noise of density 1 loses no variance without a filter, and 1/τ after a filter that removes all power.
    #[test]
    fn reduction_of_variances() {
        let mut filter = fitted(Shape::Smoothing { corner: 0.08 }, 12);
        filter.coefficients = vec![0.0];
        assert_eq!(filter.reduction_of_avar(|_| 1.0, &[1, 10], None), [0.0, 0.0]);
        // Above the last frequency of the fit the power continues to fall; here the last is the lowest frequency.
        (filter.shape, filter.known_to) = (FilterShape::LowPass, Some(1e-9));
        for (lost, m) in filter.reduction_of_avar(|_| 1.0, &[1, 8], None).into_iter().zip([1.0, 8.0]) {
            assert!((lost * m * TAU0 - 1.0).abs() < 1e-9);
        }
        (filter.coefficients, filter.known_to) = (vec![3.0], None);
        assert_eq!(filter.reduction_of_avar(|_| 1.0, &[1], Some(0.0)), [0.0]);
    }

    #[test]
    fn beyond_the_fit_the_shape_goes_on() {
        let mut filter = fitted(Shape::Digital { order: 3, corner: 0.1 }, 10);
        filter.known_to = Some(15.0);
        let [corner, ..] = filter.corner.unwrap();
        let expected = Shape::Digital { order: 3, corner: corner * TAU0 }.log_power(0.2).exp();
        assert!((filter.power(20.0) / expected - 1.0).abs() < 1e-12);
        filter.shape = FilterShape::LowPass;
        assert!((filter.power(30.0) - UNUSED_POWER / 4.0).abs() < 1e-12);
    }
}
