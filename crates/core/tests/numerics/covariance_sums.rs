//! The covariance of Allan variances against sums over every lag, by the definitions.
#![allow(clippy::unwrap_used)] // Helpers of tests are tests to the reader, not to the lint.

use sigmatau_core::bandlimited::{Filter, band_limited_avar};
use sigmatau_core::compensated::two_sum;
use sigmatau_core::covariance::{Component, Gamma, PhaseCovariance};
use sigmatau_core::terms::Term;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::{Add, Mul};

/// The tolerance is relative, unless `expected` is 0.
fn assert_close(got: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((got - expected).abs() <= tolerance * expected.abs(), "{what}: {got} instead of {expected}");
}

/// A number with twice the usual precision (T. J. Dekker, 1971), for reference values from differences of large numbers.
#[derive(Debug, Clone, Copy, Default)]
struct Wide(f64, f64);

impl Add for Wide {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (high, error) = two_sum(self.0, other.0);
        let (low, rest) = two_sum(self.1, other.1);
        let (high, error) = two_sum(high, error + low);
        let (high, low) = two_sum(high, error + rest);
        Self(high, low)
    }
}

impl Mul for Wide {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.0 * other.0;
        let error = self.0.mul_add(other.0, -high) + (self.0 * other.1 + self.1 * other.0);
        let (high, low) = two_sum(high, error);
        Self(high, low)
    }
}

impl Wide {
    fn of(x: f64) -> Self {
        Self(x, 0.0)
    }

    fn reciprocal(x: f64) -> Self {
        let high = 1.0 / x;
        let rest = -high.mul_add(x, -1.0);
        Self(high, rest / x)
    }
}

/// Autocovariances s(l) of the phase at lags 0 … `last`, up to a parabola, in their textbook form.
fn autocovariance(component: Component, last: usize) -> Vec<Wide> {
    let times = |values: Vec<Wide>, factor: f64| values.into_iter().map(|s| s * Wide::of(factor)).collect();
    let lags = (0..=last).map(|l| l as f64);
    match component {
        Component::Term(Term::Quantization) => {
            lags.map(|l| Wide::of(if l == 0.0 { 1.0 } else { 0.0 })).collect()
        }
        Component::Term(Term::RateRamp) => unreachable!("a ramp is no noise"),
        Component::Term(Term::RandomWalk) => lags.map(|l| Wide::of(-0.5 * l)).collect(),
        // Below 2⁵³, hence exact.
        Component::Term(Term::RateRandomWalk) => {
            times(lags.map(|l| Wide::of(l * l * l - l)).collect(), 1.0 / 12.0)
        }
        Component::Term(Term::BiasInstability) => {
            // −J(l) / 2π, J(l) = −(4l² − 1) h(l − 1) / 2 + 2l (l − 1) − (l − 1)² / 2, h(l) = Σ 1 / (2j − 1).
            let mut h = Wide::default();
            let j = lags.map(|l| {
                if l == 0.0 {
                    return Wide::default();
                }
                if l > 1.0 {
                    h = h + Wide::reciprocal(2.0 * l - 3.0);
                }
                Wide::of(0.5 - 2.0 * l * l) * h + Wide::of(2.0 * l * (l - 1.0) - 0.5 * (l - 1.0) * (l - 1.0))
            });
            times(j.collect(), -0.5 / PI)
        }
        Component::GaussMarkov { tc } => {
            // −V(l) / 2, the variance of the sum of l samples: V(l + 1) − V(l) = 1 + 2 Σ pᵏ, k = 1 … l.
            let exponent = Wide::reciprocal(-tc);
            let mut p = Wide::of(1.0);
            for j in (1..40).rev() {
                p = Wide::of(1.0) + exponent * p * Wide::reciprocal(f64::from(j));
            }
            let (mut power, mut step, mut variance) = (Wide::of(1.0), Wide::of(1.0), Wide::default());
            let sums = lags.map(|_| {
                let now = variance;
                variance = variance + step;
                power = power * p;
                step = step + Wide::of(2.0) * power;
                now
            });
            times(sums.collect(), -0.5)
        }
        Component::LowPassed { order, corner } => {
            let (mut step, mut variance) = (Wide::of(low_passed(order, corner, 0.0)), Wide::default());
            let sums = lags.map(|l| {
                let now = variance;
                variance = variance + step;
                step = step + Wide::of(2.0 * low_passed(order, corner, l + 1.0));
                now
            });
            times(sums.collect(), -0.5)
        }
    }
}

/// Autocovariance at a lag of white noise of density 1 after a Butterworth filter of order 1 or 2.
fn low_passed(order: u8, corner: f64, lag: f64) -> f64 {
    let angle = 2.0 * PI * corner * lag;
    if order == 1 {
        return PI * corner * (-angle).exp();
    }
    let angle = angle * FRAC_1_SQRT_2;
    PI * corner * FRAC_1_SQRT_2 * (-angle).exp() * (angle.cos() + angle.sin())
}

/// Sum of 2C² over all pairs of differences or, with a ramp of 1, of 4μμ′C, by the definitions.
fn brute_force(n_samples: usize, n: usize, m: usize, components: &[Component]) -> (Vec<f64>, Vec<f64>) {
    let phases: Vec<Vec<Wide>> = components.iter().map(|&c| autocovariance(c, n_samples + 1)).collect();
    let (mn, mm) = ((n_samples + 1 - 2 * n) as i64, (n_samples + 1 - 2 * m) as i64);
    let (n, m) = (n as i64, m as i64);
    let count = components.len();
    let (mut squares, mut linear) = (vec![Wide::default(); count * count], vec![Wide::default(); count]);
    for lag in 1 - mn..mm {
        let pairs = (mm.min(mn + lag) - lag.max(0)) as f64;
        let c: Vec<f64> = phases
            .iter()
            .map(|s| {
                let mut sum = Wide::default();
                for (a, of_n) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                    for (b, of_m) in [1.0, -2.0, 1.0].into_iter().enumerate() {
                        let at = (lag + b as i64 * m - a as i64 * n).unsigned_abs() as usize;
                        sum = sum + s[at] * Wide::of(of_n * of_m);
                    }
                }
                sum.0
            })
            .collect();
        for p in 0..count {
            linear[p] = linear[p] + Wide::of(pairs * c[p]);
            for q in 0..count {
                squares[p * count + q] = squares[p * count + q] + Wide::of(pairs * c[p]) * Wide::of(c[q]);
            }
        }
    }
    let product = (n * m) as f64;
    let of_means = ((mn * mm) as f64).recip();
    let noise = squares.into_iter().map(|sum| sum.0 * of_means / (2.0 * product * product)).collect();
    (noise, linear.into_iter().map(|sum| sum.0 * of_means).collect())
}

#[test]
fn every_entry_is_the_sum_over_all_lags() {
    let mut components = Term::NOISE.map(Component::Term).to_vec();
    components.extend([0.3, 7.0, 90.0, 2000.0, 1e7].map(|tc| Component::GaussMarkov { tc }));
    let cases: [(usize, &[usize]); 5] = [
        (2, &[1]),
        (47, &[1, 2, 3, 7, 11, 16, 22, 23]),
        (331, &[1, 5, 40, 41, 82, 110, 164, 165]),
        (1000, &[1, 2, 10, 33, 100, 101, 200, 333, 471, 499, 500]),
        (2000, &[1, 3, 17, 63, 64, 181, 256, 511, 600, 999]),
    ];
    for (n_samples, sizes) in cases {
        let gamma = Gamma::new(n_samples, sizes, &components).unwrap();
        for (i, &n) in sizes.iter().enumerate() {
            for (j, &m) in sizes.iter().enumerate() {
                let (noise, ramp) = brute_force(n_samples, n, m, &components);
                let cell = i * sizes.len() + j;
                for p in 0..components.len() {
                    let what = format!("N {n_samples}, n {n}, m {m}, {:?}", components[p]);
                    assert_close(gamma.ramp_part(p)[cell], ramp[p], 1e-12, &format!("{what} and ramp"));
                    for q in 0..components.len() {
                        let expected = noise[p * components.len() + q];
                        assert_close(gamma.noise_part(p, q)[cell], expected, 1e-12, &format!("{what}, {q}"));
                    }
                }
            }
        }
    }
}

#[test]
fn filtered_noise_has_the_covariance_of_its_samples() {
    let filters = [(1, 0.2), (1, 4.0), (1, 0.01), (2, 0.2), (2, 4.0), (2, 0.01)];
    let mut components = filters.map(|(order, corner)| Component::LowPassed { order, corner }).to_vec();
    components.push(Component::Term(Term::BiasInstability));
    let (n_samples, sizes) = (700, [1, 2, 10, 33, 101, 200, 333, 350]);
    let gamma = Gamma::new(n_samples, &sizes, &components).unwrap();
    for (p, (order, corner)) in filters.into_iter().enumerate() {
        let avar = band_limited_avar(1.0, Filter::Butterworth(order), corner, 1.0, &sizes);
        let mut theta = vec![0.0; components.len()];
        theta[p] = 1.0;
        for (got, expected) in gamma.expectation(&theta, 0.0).into_iter().zip(avar) {
            assert_close(got, expected, 1e-12, &format!("order {order}, corner {corner}: avar"));
        }
    }
    for (i, &n) in sizes.iter().enumerate() {
        for (j, &m) in sizes.iter().enumerate() {
            let (noise, ramp) = brute_force(n_samples, n, m, &components);
            let cell = i * sizes.len() + j;
            for p in 0..components.len() {
                let what = format!("n {n}, m {m}, {:?}", components[p]);
                assert_close(gamma.ramp_part(p)[cell], ramp[p], 1e-10, &format!("{what} and ramp"));
                for q in 0..components.len() {
                    let expected = noise[p * components.len() + q];
                    assert_close(gamma.noise_part(p, q)[cell], expected, 1e-10, &format!("{what}, {q}"));
                }
            }
        }
    }
}

/// A component that is summed over every lag.
struct LagByLag(Component);

impl PhaseCovariance for LagByLag {
    fn interval_power(&self) -> i32 {
        self.0.interval_power()
    }
    fn covariance(&self, n: f64, m: f64, u: f64) -> f64 {
        self.0.covariance(n, m, u)
    }
    fn memory(&self) -> usize {
        usize::MAX
    }
}

#[test]
fn panels_are_as_good_as_every_lag_in_long_records() {
    let mut components = Term::NOISE.map(Component::Term).to_vec();
    components.extend([3.0, 100.0, 4000.0, 1e6].map(|tc| Component::GaussMarkov { tc }));
    let one_by_one = components.clone().into_iter().map(LagByLag).collect::<Vec<_>>();
    let n_samples = (1 << 16) + 321;
    let sizes = [1, 6, 181, 1023, 1024, 5000, 11_585, 22_000, n_samples / 2];
    let panels = Gamma::new(n_samples, &sizes, &components).unwrap();
    let exact = Gamma::new(n_samples, &sizes, &one_by_one).unwrap();
    for p in 0..components.len() {
        for (&got, expected) in panels.ramp_part(p).iter().zip(exact.ramp_part(p)) {
            // Only 1 / N of either sum does not cancel.
            assert_close(got, expected, 1e-9, &format!("{:?} and ramp", components[p]));
        }
        for q in 0..components.len() {
            for (&got, expected) in panels.noise_part(p, q).iter().zip(exact.noise_part(p, q)) {
                assert_close(got, expected, 1e-11, &format!("{:?}, {:?}", components[p], components[q]));
            }
        }
    }
}

/// Noise whose samples are correlated over `r.len()` lags.
struct MovingAverage {
    r: Vec<f64>,
}

impl MovingAverage {
    /// −V(l) / 2 with the variance V(l) = l r₀ + 2 Σ (l − k) rₖ of a sum of l samples.
    fn phase(&self, lag: f64) -> f64 {
        let lag = lag.abs();
        let sum: f64 = self.r.iter().enumerate().skip(1).map(|(k, r)| (lag - k as f64).max(0.0) * r).sum();
        -0.5 * lag * self.r[0] - sum
    }
}

impl PhaseCovariance for MovingAverage {
    fn interval_power(&self) -> i32 {
        2
    }
    fn covariance(&self, n: f64, m: f64, u: f64) -> f64 {
        let second = |u: f64| self.phase(u + n) - 2.0 * self.phase(u) + self.phase(u - n);
        second(u + m) - 2.0 * second(u) + second(u - m)
    }
    fn memory(&self) -> usize {
        self.r.len()
    }
}

#[test]
fn any_stationary_noise_can_be_a_term() {
    let tc = 2.5;
    // e⁻⁴⁰ is negligible.
    let term = MovingAverage { r: (0..100).map(|k| (-f64::from(k) / tc).exp()).collect() };
    let sizes = [1, 2, 30, 512, 700, 2000];
    let got = Gamma::new(4096, &sizes, &[&Term::RandomWalk as &dyn PhaseCovariance, &term]).unwrap();
    let expected =
        Gamma::new(4096, &sizes, &[Component::Term(Term::RandomWalk), Component::GaussMarkov { tc }])
            .unwrap();
    for (p, q) in [(0, 1), (1, 1)] {
        for (got, expected) in got.noise_part(p, q).into_iter().zip(expected.noise_part(p, q)) {
            // The reference has plain fourth differences of lags up to 10⁴.
            assert_close(got, expected, 1e-10, "moving average");
        }
    }
}
