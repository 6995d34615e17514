//! Named shapes of filters: ln |H|² at frequencies times the sample interval, and similarity to a fitted filter.

use crate::likelihood::abscissae::Abscissae;
use pulp::Arch;
use std::f64::consts::{LN_2, PI};

/// Highest order of Butterworth filters, and longest running mean, that are compared.
const HIGHEST_ORDER: u32 = 4;
const LONGEST_MEAN: u32 = 1000;

/// Largest corner of exponential smoothing, times the sample interval: the response of faster smoothing never falls to
/// half the power.
const FASTEST_SMOOTHING: f64 = 0.4;

/// Corner of a running mean times its length in samples.
const CORNER_OF_MEAN: f64 = 0.443;

/// Number of images of the response of an analog filter, on either side, that are included in the folding by sampling.
const IMAGES: i32 = 8;

/// Largest logarithm of the ratio of a tested corner to the corner of the shape, and number of tested corners.
const FARTHEST_CORNER: f64 = 0.3;
const CORNERS: usize = 61;

/// Smallest |H|² of a running mean, at its zeros.
const POWER_AT_ZERO: f64 = 1e-12;

/// Highest order of Butterworth filters, and largest number of means in series, that are fitted.
const HIGHEST_FITTED: u32 = 6;
const MAX_STAGES: u32 = 4;

/// Limits of a fitted corner, times the sample interval, and of the damping of two poles.
const LOWEST_CORNER: f64 = 1e-4;
const HIGHEST_CORNER: f64 = 0.49;
const MIN_DAMPING: f64 = 0.2;
const MAX_DAMPING: f64 = 3.0;

/// Number of bisections that determine all digits of a frequency.
const BISECTIONS: usize = 60;

/// A named shape; corners are multiplied by the sample interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shape {
    /// A Butterworth filter by the bilinear transform.
    Digital { order: u32, corner: f64 },
    /// White noise after an analog Butterworth filter, folded by sampling, over its density at the frequency 0.
    Folded { order: u32, corner: f64 },
    /// Exponential smoothing, y += (1 − p)(x − y).
    Smoothing { corner: f64 },
    /// Mean of the last samples.
    RunningMean { length: u32 },
    /// Two poles by the bilinear transform, with their undamped corner.
    TwoPoles { corner: f64, damping: f64 },
    /// Running means of this length in series; the length need not be a whole number.
    Means { length: f64, stages: u32 },
}

/// A shape whose corner is evaluated once for all frequencies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Response {
    shape: Shape,
    /// Depends on the corner alone: its tangent for the bilinear transform, the density at the frequency 0 for a folded
    /// filter, p for smoothing.
    corner_factor: f64,
}

impl Response {
    /// ln |H|² at a frequency times the sample interval.
    pub(crate) fn log_power(&self, x: f64) -> f64 {
        self.at(x, || (PI * x).tan(), || (PI * x).sin(), || (2.0 * PI * x).cos())
    }

    /// ln |H|² at x from the functions tan πx, sin πx, cos 2πx that the shape uses.
    fn at(&self, x: f64, tangent: impl Fn() -> f64, sine: impl Fn() -> f64, cosine: impl Fn() -> f64) -> f64 {
        match self.shape {
            Shape::Digital { order, .. } => -(tangent() / self.corner_factor).powi(2 * order as i32).ln_1p(),
            Shape::Folded { order, corner } => (folded(order, corner, &[x])[0] / self.corner_factor).ln(),
            Shape::Smoothing { .. } => {
                // |H|² = (1 − p)² / (1 − 2p cos + p²), which is ½ at the corner.
                let p = self.corner_factor;
                ((1.0 - p).powi(2) / (1.0 - 2.0 * p * cosine() + p * p)).ln()
            }
            Shape::RunningMean { length } => {
                let length = f64::from(length);
                let ratio = (PI * length * x).sin() / (length * sine());
                ratio.powi(2).max(POWER_AT_ZERO).ln()
            }
            Shape::TwoPoles { damping, .. } => {
                let squared = (tangent() / self.corner_factor).powi(2);
                -((1.0 - squared).powi(2) + 4.0 * damping * damping * squared).ln()
            }
            Shape::Means { length, stages } => {
                let ratio = (PI * length * x).sin() / (length * sine());
                f64::from(stages) * ratio.powi(2).max(POWER_AT_ZERO).ln()
            }
        }
    }

    /// [`Self::log_power`] at many frequencies.
    pub(crate) fn log_powers(&self, at: &Abscissae) -> Vec<f64> {
        if let Shape::Folded { order, corner } = self.shape {
            return folded(order, corner, &at.x)
                .iter()
                .map(|power| (power / self.corner_factor).ln())
                .collect();
        }
        let log_power =
            |(k, &x): (usize, &f64)| self.at(x, || at.tangents()[k], || at.sines()[k], || at.cosines()[k]);
        at.x.iter().enumerate().map(log_power).collect()
    }
}

/// Density after an analog Butterworth filter and a sampler. The inner loop is over the frequencies, so that it is
/// vectorised: the fits of filters spend most of their time here.
fn folded(order: u32, corner: f64, x: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; x.len()];
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for image in (-IMAGES..=IMAGES).map(f64::from) {
                match order {
                    1 => add_image::<2>(&mut sums, x, image, corner),
                    2 => add_image::<4>(&mut sums, x, image, corner),
                    3 => add_image::<6>(&mut sums, x, image, corner),
                    4 => add_image::<8>(&mut sums, x, image, corner),
                    5 => add_image::<10>(&mut sums, x, image, corner),
                    HIGHEST_FITTED => add_image::<12>(&mut sums, x, image, corner),
                    _ => unreachable!("order {order}"),
                }
            }
        },
    );
    sums
}

/// Adds the power of one image of an analog Butterworth filter, with twice its order as a constant.
#[inline(always)]
#[allow(clippy::inline_always)] // Inlined into a function that is compiled for the processor.
fn add_image<const EXPONENT: i32>(sums: &mut [f64], x: &[f64], image: f64, corner: f64) {
    for (sum, x) in sums.iter_mut().zip(x) {
        *sum += 1.0 / (1.0 + ((x + image) / corner).powi(EXPONENT));
    }
}

impl Shape {
    /// Two poles with half the power at a corner.
    pub(crate) fn two_poles(corner: f64, damping: f64) -> Self {
        let b = 1.0 - 2.0 * damping * damping;
        let undamped = ((PI * corner).tan() / (b + (b * b + 1.0).sqrt()).sqrt()).atan() / PI;
        Self::TwoPoles { corner: undamped, damping }
    }

    /// Means with half the power at a corner.
    pub(crate) fn means(corner: f64, stages: u32) -> Self {
        Self::Means { length: half_power_of_means(stages) / corner, stages }
    }

    /// All compared shapes with this corner.
    pub(crate) fn all(corner: f64) -> Vec<Self> {
        let mut shapes: Vec<Self> = (1..=HIGHEST_ORDER)
            .flat_map(|order| [Self::Digital { order, corner }, Self::Folded { order, corner }])
            .collect();
        if corner < FASTEST_SMOOTHING {
            shapes.push(Self::Smoothing { corner });
        }
        let length = (CORNER_OF_MEAN / corner).round_ties_even();
        if (2.0..=f64::from(LONGEST_MEAN)).contains(&length) {
            shapes.push(Self::RunningMean { length: length as u32 });
        }
        shapes
    }

    /// Order of a Butterworth filter, number of samples of a running mean, or number of means in series.
    pub(crate) fn order(self) -> Option<u32> {
        match self {
            Self::Digital { order, .. } | Self::Folded { order, .. } => Some(order),
            Self::RunningMean { length } => Some(length),
            Self::Means { stages, .. } => Some(stages),
            Self::Smoothing { .. } | Self::TwoPoles { .. } => None,
        }
    }

    /// ln |H|² at a frequency times the sample interval.
    pub(crate) fn log_power(self, x: f64) -> f64 {
        self.response().log_power(x)
    }

    /// The response, with the factors that depend only on the corner.
    pub(crate) fn response(self) -> Response {
        let corner_factor = match self {
            Self::Digital { corner, .. } | Self::TwoPoles { corner, .. } => (PI * corner).tan(),
            Self::Folded { order, corner } => folded(order, corner, &[0.0])[0],
            Self::Smoothing { corner } => {
                let c = (2.0 * PI * corner).cos();
                (2.0 - c) - ((2.0 - c).powi(2) - 1.0).sqrt()
            }
            Self::RunningMean { .. } | Self::Means { .. } => 1.0,
        };
        Response { shape: self, corner_factor }
    }

    /// Whether the response has zeros below half the rate, which the taper fills with power from nearby.
    pub(crate) fn has_zeros(self) -> bool {
        matches!(self, Self::RunningMean { .. } | Self::Means { .. })
    }

    /// Frequency at which a shape, as [`Family::shape`] makes it, has half the power.
    pub(crate) fn half_power(self) -> f64 {
        match self {
            Self::Digital { corner, .. } | Self::Folded { corner, .. } | Self::Smoothing { corner } => corner,
            Self::RunningMean { length } => half_power_of_sums(f64::from(length), 1),
            Self::Means { length, stages } => half_power_of_sums(length, stages),
            Self::TwoPoles { corner, damping } => {
                let b = 1.0 - 2.0 * damping * damping;
                ((b + (b * b + 1.0).sqrt()).sqrt() * (PI * corner).tan()).atan() / PI
            }
        }
    }

    /// The corner for which the shape is closest, up to a constant, to ln |H|² at frequencies x. Tested corners are
    /// within a factor e^±[`FARTHEST_CORNER`] of that of the shape. None for shapes that are not compared by a corner.
    pub(crate) fn nearest_corner(self, x: &[f64], log_power: &[f64]) -> Option<f64> {
        let (corner, with_corner): (f64, Box<dyn Fn(f64) -> Self>) = match self {
            Self::Digital { order, corner } => {
                (corner, Box::new(move |corner| Self::Digital { order, corner }))
            }
            Self::Folded { order, corner } => {
                (corner, Box::new(move |corner| Self::Folded { order, corner }))
            }
            Self::Smoothing { corner } => (corner, Box::new(|corner| Self::Smoothing { corner })),
            Self::RunningMean { .. } | Self::TwoPoles { .. } | Self::Means { .. } => return None,
        };
        let step = 2.0 * FARTHEST_CORNER / (CORNERS - 1) as f64;
        let at = Abscissae::new(x.to_vec());
        let misfit = |shape: Self| {
            let log_powers = shape.response().log_powers(&at);
            let differences: Vec<f64> = log_powers.iter().zip(log_power).map(|(a, b)| a - b).collect();
            let mean = differences.iter().sum::<f64>() / differences.len() as f64;
            differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>()
        };
        (0..CORNERS)
            .map(|k| corner * (k as f64 * step - FARTHEST_CORNER).exp())
            .filter(|&tried| tried < 0.5)
            .min_by(|&a, &b| misfit(with_corner(a)).total_cmp(&misfit(with_corner(b))))
    }
}

/// Frequency of half the power of long means, times their length: (sin πx / πx)²ˢ = ½.
fn half_power_of_means(stages: u32) -> f64 {
    half_power(0.5, stages, |x| (PI * x).sin() / (PI * x))
}

/// Frequency of half the power of means of `length` samples, times the sample interval: 1/4 for one mean of two. At most
/// half the rate.
fn half_power_of_sums(length: f64, stages: u32) -> f64 {
    half_power((1.0 / length).min(0.5), stages, |x| (PI * length * x).sin() / (length * (PI * x).sin()))
}

/// Frequency below `high` at which the power of `stages` decreasing gains in series is ½.
fn half_power(mut high: f64, stages: u32, gain: impl Fn(f64) -> f64) -> f64 {
    let mut low = 0.0;
    for _ in 0..BISECTIONS {
        let x = 0.5 * (low + high);
        if gain(x).powi(2 * stages as i32) > 0.5 { low = x } else { high = x }
    }
    low
}

/// Filters whose response is known except for one or two parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    Smoothing,
    Digital { order: u32 },
    Folded { order: u32 },
    TwoPoles,
    Means { stages: u32 },
}

impl Family {
    /// Families that are tried. A sampled first-order analog filter is exponential smoothing.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let butterworth = (1..=HIGHEST_FITTED).map(|order| Self::Digital { order });
        let folded = (2..=HIGHEST_FITTED).map(|order| Self::Folded { order });
        let means = (1..=MAX_STAGES).map(|stages| Self::Means { stages });
        [Self::Smoothing, Self::TwoPoles].into_iter().chain(butterworth).chain(folded).chain(means)
    }

    /// Number of fitted parameters.
    pub(crate) fn count(self) -> usize {
        if self == Self::TwoPoles { 2 } else { 1 }
    }

    /// The corner of a first-order filter.
    pub(crate) fn corner_of_first_order(self, numbers: &[f64]) -> Option<f64> {
        matches!(self, Self::Smoothing | Self::Digital { order: 1 }).then(|| numbers[0].exp())
    }

    /// The parameters of a filter with a corner: logarithms of the corner and of the damping of two poles.
    pub(crate) fn start(self, corner: f64) -> Vec<f64> {
        let mut numbers = vec![corner.ln(); self.count()];
        if self == Self::TwoPoles {
            numbers[1] = -0.5 * LN_2;
        }
        numbers
    }

    /// Clamps the parameters to the limits of corners and dampings.
    pub(crate) fn clamp_parameters(self, numbers: &mut [f64]) {
        let highest = if self == Self::Smoothing { FASTEST_SMOOTHING } else { HIGHEST_CORNER };
        numbers[0] = numbers[0].clamp(LOWEST_CORNER.ln(), highest.ln());
        if let Some(damping) = numbers.get_mut(1) {
            *damping = damping.clamp(MIN_DAMPING.ln(), MAX_DAMPING.ln());
        }
    }

    pub(crate) fn shape(self, numbers: &[f64]) -> Shape {
        let corner = numbers[0].exp();
        match self {
            Self::Smoothing => Shape::Smoothing { corner },
            Self::Digital { order } => Shape::Digital { order, corner },
            Self::Folded { order } => Shape::Folded { order, corner },
            Self::TwoPoles => Shape::TwoPoles { corner, damping: numbers[1].exp() },
            Self::Means { stages } => Shape::means(corner, stages),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_power_at_the_corner() {
        for corner in [0.01, 0.05] {
            for shape in Shape::all(corner) {
                let half = shape.log_power(corner).exp();
                // Folding and the rounding of a length to whole samples change it slightly.
                assert!((half - 0.5).abs() < 0.03, "{shape:?}: {half}");
                assert!(shape.log_power(1e-6).abs() < 1e-6, "{shape:?}");
            }
        }
        assert!((Shape::Smoothing { corner: 0.1 }.log_power(0.1).exp() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn corner_that_is_nearest() {
        let x: Vec<f64> = (1..50).map(|k| 0.002 * f64::from(k)).collect();
        let shape = Shape::Digital { order: 2, corner: 0.1 };
        let measured: Vec<f64> =
            x.iter().map(|&x| Shape::Digital { order: 2, corner: 0.11 }.log_power(x)).collect();
        // Corners are tried in steps of 1 %.
        assert!((shape.nearest_corner(&x, &measured).unwrap() - 0.11).abs() < 0.001);
        assert_eq!(Shape::RunningMean { length: 4 }.nearest_corner(&x, &measured), None);
    }
}
