//! Coefficients √θ with an interval or an upper limit, from the bounds of their squares.

use crate::distributions::normal_quantile;
use crate::likelihood::outcome::Drift;
use crate::likelihood::profile::Bounds;
use std::f64::consts::FRAC_1_SQRT_2;

/// Logarithm of a ratio that counts as infinite.
const UNBOUNDED_LOG_RATIO: f64 = 700.0;

/// A value and its interval; without an upper end, the interval is unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value, inside its interval.
    pub value: f64,
    /// Lower end.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Estimate {
    /// A value with its interval, which is extended to include the value.
    pub(crate) fn new(value: f64, low: f64, high: f64) -> Self {
        if high.is_finite() {
            Self { value, low: Some(low.min(value)), high: Some(high.max(value)) }
        } else {
            Self { value, low: None, high: None }
        }
    }

    /// A value with the half width of its interval.
    pub(crate) fn around(value: f64, half: f64) -> Self {
        Self { value, low: Some(value - half), high: Some(value + half) }
    }

    /// The root of a parameter.
    pub(crate) fn root(bounds: &Bounds) -> Self {
        let [value, low, high] = [bounds.value, bounds.low, bounds.high].map(|x| x.max(0.0).sqrt());
        Self::new(value, low, high)
    }

    /// The estimate times a positive factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        let scaled = |end: Option<f64>| end.map(|end| factor * end);
        Self { value: factor * self.value, low: scaled(self.low), high: scaled(self.high) }
    }
}

impl From<&Bounds> for Estimate {
    fn from(bounds: &Bounds) -> Self {
        Self::new(bounds.value, bounds.low, bounds.high)
    }
}

/// A coefficient with an interval if it was observed, otherwise with an upper limit. \[SI\]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TermEstimate {
    /// Whether the term is significant and its interval excludes 0.
    pub observed: bool,
    /// Value if it was observed; a ramp has a sign.
    pub value: Option<f64>,
    /// Lower end of its interval.
    pub low: Option<f64>,
    /// Upper end of its interval.
    pub high: Option<f64>,
    /// Upper limit if it was not observed; for a ramp, of its magnitude. None if the record sets no limit.
    pub upper_limit: Option<f64>,
    /// P-value of its absence, with all other terms free. None if it was not tested.
    pub p_value: Option<f64>,
    /// Maximum of the likelihood and interval with all terms free, whether the term was observed or not.
    pub profile: Option<Estimate>,
}

impl TermEstimate {
    /// A significant term, from its estimate in the model that describes the record, and its interval with all terms free.
    /// An interval that does not include the estimate is extended by its standard `error`. An interval that does not
    /// exclude 0 becomes an upper limit.
    pub(crate) fn significant(
        value: f64,
        [mut low, mut high]: [f64; 2],
        error: f64,
        p_value: f64,
        level: f64,
    ) -> Self {
        let inside = |low: f64, high: f64| low < value && value < high;
        if value > 0.0 && low > 0.0 && !inside(low, high) {
            let away = quantile(level) * error.max(0.0) / value;
            let ratio = if away < UNBOUNDED_LOG_RATIO { away.exp() } else { f64::INFINITY };
            (low, high) = (low.min(value / ratio), high.max(value * ratio));
        }
        if low > 0.0 && inside(low, high) {
            return Self {
                observed: true,
                value: Some(value),
                low: Some(low),
                high: Some(high),
                upper_limit: None,
                p_value: Some(p_value),
                profile: None,
            };
        }
        let limit = [low, high, value].into_iter().map(f64::abs).fold(0.0, f64::max);
        Self::limited(Some(limit).filter(|&limit| limit > 0.0), p_value.max(1.0 - level))
    }

    /// A term that was not observed.
    pub(crate) fn limited(limit: Option<f64>, p_value: f64) -> Self {
        Self {
            upper_limit: limit.filter(|limit| limit.is_finite()),
            p_value: Some(p_value),
            ..Self::default()
        }
    }

    /// A term from the bounds of its square θ; `value` and `error` are those of √θ in the model that describes the record.
    ///
    /// Without the term the deviance rises by `loss`, half χ² with one degree of freedom and half 0, because θ is not
    /// negative: p = ½ erfc(√(loss / 2)).
    pub(crate) fn from_square(bounds: &Bounds, value: f64, error: f64, level: f64) -> Self {
        let p_value = 0.5 * libm::erfc((bounds.loss.max(0.0) / 2.0).sqrt());
        let [low, high] = [bounds.low.max(0.0), bounds.high].map(f64::sqrt);
        let estimate = if bounds.observed && high.is_finite() {
            Self::significant(value, [low, high], error, p_value, level)
        } else {
            Self::limited(Some(high), p_value)
        };
        Self { profile: Some(Estimate::root(bounds)), ..estimate }
    }

    /// The ramp, of either sign. `observed` states whether it is part of the model; the profile is wider than this test.
    pub(crate) fn from_ramp(ramp: Drift, observed: bool, level: f64) -> Self {
        let Drift { value, error } = ramp;
        let half = quantile(level) * error;
        let p_value = if error > 0.0 { libm::erfc((value / error).abs() * FRAC_1_SQRT_2) } else { 1.0 };
        let profile = Some(Estimate::around(value, half));
        if observed && value.abs() > half {
            let [low, high] = [Some(value - half), Some(value + half)];
            let p_value = Some(p_value);
            return Self {
                observed: true,
                value: Some(value),
                low,
                high,
                upper_limit: None,
                p_value,
                profile,
            };
        }
        Self { profile, ..Self::limited(Some(value.abs() + half), p_value.max(1.0 - level)) }
    }
}

/// Quantile of the standard normal distribution for two-sided intervals of a confidence level.
pub(crate) fn quantile(level: f64) -> f64 {
    -normal_quantile(0.5 * (1.0 - level))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distributions::normal_below;

    const LEVEL: f64 = 0.95;

    fn bounds(value: f64, low: f64, high: f64, observed: bool, loss: f64) -> Bounds {
        Bounds { value, low, high, observed, loss }
    }

    #[test]
    fn terms_are_roots() {
        let estimate =
            TermEstimate::from_square(&bounds(4.0, 1.0, 9.0, true, 3.841_458_820_694_124), 2.1, 0.3, LEVEL);
        assert_eq!(
            (estimate.observed, estimate.value, estimate.low, estimate.high),
            (true, Some(2.1), Some(1.0), Some(3.0))
        );
        // One-sided probability of the normal distribution at 1.96.
        assert!((estimate.p_value.unwrap() - 0.025).abs() < 1e-12);
        let absent = TermEstimate::from_square(&bounds(0.0, 0.0, 9.0, false, 0.0), 0.0, 0.0, LEVEL);
        assert_eq!((absent.observed, absent.upper_limit, absent.p_value), (false, Some(3.0), Some(0.5)));
        assert_eq!(absent.profile, Some(Estimate::new(0.0, 0.0, 3.0)));
        let unbounded =
            TermEstimate::from_square(&bounds(1.0, 0.1, f64::INFINITY, true, 9.0), 1.0, 0.0, LEVEL);
        assert_eq!((unbounded.observed, unbounded.upper_limit), (false, None));
    }

    #[test]
    fn value_outside_of_its_interval_extends_it() {
        let estimate = TermEstimate::significant(2.0, [3.0, 4.0], 0.2, 0.001, LEVEL);
        let ratio = (1.959_963_984_540_054 * 0.1_f64).exp();
        assert!((estimate.low.unwrap() - 2.0 / ratio).abs() < 1e-12);
        assert_eq!(estimate.high, Some(4.0));
        // A value with an error of a thousand times its size is unknown.
        let unknown = TermEstimate::significant(2.0, [3.0, 4.0], 2000.0, 0.001, LEVEL);
        assert_eq!((unknown.observed, unknown.value, unknown.upper_limit), (false, None, None));
    }

    #[test]
    fn interval_that_holds_zero_is_a_limit() {
        let estimate = TermEstimate::significant(2.0, [0.0, 4.0], 0.2, 0.001, LEVEL);
        assert_eq!((estimate.observed, estimate.value, estimate.low), (false, None, None));
        assert_eq!(estimate.upper_limit, Some(4.0));
        assert!((estimate.p_value.unwrap() - 0.05).abs() < 1e-12);
    }

    #[test]
    fn ramps_have_a_sign() {
        let ramp = Drift { value: -5.0, error: 1.0 };
        let estimate = TermEstimate::from_ramp(ramp, true, LEVEL);
        assert!(estimate.observed && estimate.low.unwrap() < -6.9 && estimate.high.unwrap() > -3.1);
        assert!((estimate.p_value.unwrap() / (2.0 * normal_below(-5.0)) - 1.0).abs() < 1e-12);
        let weak = TermEstimate::from_ramp(ramp, false, LEVEL);
        assert!((weak.upper_limit.unwrap() - 6.959_963_984_540_054).abs() < 1e-12);
        assert!((weak.p_value.unwrap() - 0.05).abs() < 1e-12);
        let unknown = TermEstimate::from_ramp(Drift { value: 1.0, error: f64::INFINITY }, true, LEVEL);
        assert_eq!((unknown.observed, unknown.upper_limit), (false, None));
    }

    #[test]
    fn estimates_hold_their_value() {
        assert_eq!(Estimate::from(&bounds(1.0, 2.0, 3.0, true, 0.0)), Estimate::new(1.0, 1.0, 3.0));
        let unbounded = Estimate::new(1.0, 0.5, f64::INFINITY);
        assert_eq!((unbounded.low, unbounded.high), (None, None));
        assert_eq!(Estimate::around(1.0, 0.5).scaled(2.0), Estimate::new(2.0, 1.0, 3.0));
    }
}
