//! Contribution of a noise term to the covariance of two second differences of the phase.

use super::exponentials::exponentials;
use super::flicker::flicker;
use crate::bandlimited::poles;
use crate::error::Error;
use crate::terms::Term;
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

/// The autocovariance of a noise in the form that the covariance of Allan variances needs.
///
/// Let s(l) be the generalised autocovariance of its phase at a lag of l samples, with τ₀ = 1 and a coefficient of 1.
/// The second differences x(k) − 2x(k + n) + x(k + 2n) and those of another cluster size m have the
/// covariance C(u) = δₙ²δₘ² s(u), δₙ² s(u) = s(u + n) − 2s(u) + s(u − n), where u is the lag of their
/// centres. A constant or a parabola in s has no effect on C.
///
/// It is implemented for the noise terms of IEEE 952 and for [`Component`]s. A filter, or any noise whose
/// differences are stationary, only needs [`PhaseCovariance::covariance`].
pub trait PhaseCovariance: Sync {
    /// The power of τ₀ to which C is proportional for a fixed coefficient; 2 if the coefficient is a variance of the
    /// rate.
    fn interval_power(&self) -> i32;

    /// C(u) for `n` ≤ `m` and `u` ≥ 0, accurate to all digits: it must not be a difference of large numbers.
    ///
    /// `u` is an integer next to the kinks at 0, `m` − `n`, `n`, `m` and `m` + `n`, and any real number elsewhere.
    /// Between kinks C must be analytic, with a scale that grows with the distance from them; but see
    /// [`PhaseCovariance::memory`].
    fn covariance(&self, n: f64, m: f64, u: f64) -> f64;

    /// C is evaluated only at integer lags up to this distance from every kink, so that it need not be smooth there.
    fn memory(&self) -> usize {
        0
    }

    /// Checks that the parameters are in range.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`].
    fn check(&self) -> Result<(), Error> {
        Ok(())
    }
}

/// The coefficient is the squared one of the term. A ramp is not a noise: its covariance is 0.
impl PhaseCovariance for Term {
    fn interval_power(&self) -> i32 {
        Term::interval_power(*self)
    }

    fn covariance(&self, n: f64, m: f64, u: f64) -> f64 {
        match self {
            Self::Quantization => spikes(n, m, u),
            Self::RandomWalk => triangles(n, m, u),
            Self::BiasInstability => flicker(n, m, u),
            Self::RateRandomWalk => cubics(n, m, u) + triangles(n, m, u) / 6.0,
            Self::RateRamp => 0.0,
        }
    }
}

impl<T: PhaseCovariance + ?Sized> PhaseCovariance for &T {
    fn interval_power(&self) -> i32 {
        (**self).interval_power()
    }

    fn covariance(&self, n: f64, m: f64, u: f64) -> f64 {
        (**self).covariance(n, m, u)
    }

    fn memory(&self) -> usize {
        (**self).memory()
    }

    fn check(&self) -> Result<(), Error> {
        (**self).check()
    }
}

/// A noise with a closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Component {
    /// A term.
    Term(Term),
    /// First-order Gauss–Markov process, sampled; the coefficient is its variance.
    GaussMarkov {
        /// Correlation time in samples.
        tc: f64,
    },
    /// White noise after a Butterworth filter, sampled, with aliasing; the coefficient is N² of the noise before the filter.
    LowPassed {
        /// Number of poles.
        order: u8,
        /// Corner in cycles per sample.
        corner: f64,
    },
}

impl PhaseCovariance for Component {
    fn interval_power(&self) -> i32 {
        match self {
            Self::Term(term) => term.interval_power(),
            Self::GaussMarkov { .. } => 2,
            Self::LowPassed { .. } => Term::RandomWalk.interval_power(),
        }
    }

    fn covariance(&self, n: f64, m: f64, u: f64) -> f64 {
        match *self {
            Self::Term(term) => term.covariance(n, m, u),
            Self::GaussMarkov { tc } => exponentials(n, m, u, 1.0 / tc),
            Self::LowPassed { order, corner } => {
                let of_pole = |(pole, times): (Complex64, f64)| {
                    times * (-pole * exponentials(n, m, u, -pole * (2.0 * PI * corner))).re
                };
                PI * corner / f64::from(order) * poles(order).map(of_pole).sum::<f64>()
            }
        }
    }

    fn check(&self) -> Result<(), Error> {
        match *self {
            // Its square and that of its reciprocal must be finite.
            Self::GaussMarkov { tc } if !(1e-100..=1e100).contains(&tc) => {
                Err(Error::Parameter { name: "tc", value: tc })
            }
            Self::LowPassed { order: 0, .. } => Err(Error::Parameter { name: "order", value: 0.0 }),
            Self::LowPassed { corner, .. } if !(1e-100..=1e100).contains(&corner) => {
                Err(Error::Parameter { name: "corner", value: corner })
            }
            _ => Ok(()),
        }
    }
}

/// s(0) = 1, and 0 elsewhere: C is not 0 only at the kinks.
fn spikes(n: f64, m: f64, u: f64) -> f64 {
    // Close to a kink both are integers.
    let spike = |kink: f64| if (u - kink).abs() < 0.5 { 1.0 } else { 0.0 };
    4.0 * spike(0.0) - 2.0 * (spike(n) + spike(m)) + spike(m - n) + spike(m + n) + spike(n - m)
}

/// s(l) = −|l| / 2, whose second difference is a triangle of height n: −(n − |l|)₊.
pub(super) fn triangles(n: f64, m: f64, u: f64) -> f64 {
    2.0 * positive(n - u) - positive(n - (u - m).abs())
}

/// s(l) = |l|³ / 12, whose second difference is n² |l| / 2 + (n − |l|)₊³ / 6.
fn cubics(n: f64, m: f64, u: f64) -> f64 {
    let cube = |x: f64| x * x * x;
    n * n * positive(m - u) - cube(positive(n - u)) / 3.0 + cube(positive(n - (u - m).abs())) / 6.0
}

pub(super) fn positive(x: f64) -> f64 {
    x.max(0.0)
}

#[cfg(test)]
#[allow(clippy::unreadable_literal, clippy::excessive_precision)] // Digits as they were computed.
mod tests {
    use super::*;

    fn assert_relative(
        noise: &dyn PhaseCovariance,
        (n, m, u): (f64, f64, f64),
        expected: f64,
        tolerance: f64,
    ) {
        let got = noise.covariance(n, m, u);
        let close = (got - expected).abs() <= tolerance * expected.abs();
        assert!(close, "n {n}, m {m}, u {u}: {got} instead of {expected}");
    }

    // Computed with 90 digits from the autocovariances: n, m, u and C for a coefficient of 1.
    const WALK: [(f64, f64, f64, f64); 7] = [
        (1.0, 1.0, 0.0, 1.0),
        (1.0, 524288.0, 0.0, 524288.0),
        (1.0, 524288.0, 524288.0, 0.0),
        (181.0, 262144.0, 100.0, 8584646364.0),
        (181.0, 262144.0, 262294.5, 4723.6875),
        (262144.0, 262144.0, 262147.0, 3002296673501180.0),
        (262144.0, 262144.0, 524287.0, 0.0),
    ];

    #[test]
    fn random_walk_is_exact() {
        for (n, m, u, expected) in WALK {
            assert_relative(&Term::RateRandomWalk, (n, m, u), expected, 1e-15);
        }
    }

    // With the correlation time in front.
    const GAUSS_MARKOV: [(f64, f64, f64, f64, f64); 53] = [
        (0.05, 1.0, 1.0, 0.0, 1.9999999958776927551),
        (0.05, 10.0, 1000.0, 995.0, -5.0000000206115362669),
        (0.05, 999.0, 1000.0, 1.0, 1996.0000082260641241),
        (0.05, 999.0, 1001.0, 1998.0, -2.0000000082446145067),
        (0.05, 1.0, 524288.0, 524288.0, -1.0),
        (0.05, 181.0, 262144.0, 262294.5, -30.500000125730371228),
        (0.05, 262144.0, 262144.0, 262147.0, -262141.00108062574571),
        (1.0, 1.0, 1.0, 0.0, 1.2642411176571153568),
        (1.0, 1.0, 1.0, 20.5, -1.3578676245868176452e-9),
        (1.0, 10.0, 1000.0, 995.0, -10.813563900448223511),
        (1.0, 999.0, 1000.0, 1.0, 4316.8509530571488485),
        (1.0, 999.0, 1001.0, 1998.0, -4.4525064491178874893),
        (1.0, 1.0, 524288.0, 524288.0, -1.0),
        (1.0, 181.0, 262144.0, 262294.5, -66.000579119028964142),
        (1.0, 262144.0, 262144.0, 262147.0, -567260.72848030747919),
        (30.0, 1.0, 1.0, 0.0, 0.065567799035988195918),
        (30.0, 1.0, 1.0, 20.5, -0.0005610864834237040172),
        (30.0, 10.0, 1000.0, 995.0, -84.091813414467295327),
        (30.0, 10.0, 1000.0, 1300.5, -0.0045060318373387133656),
        (30.0, 999.0, 1000.0, 1.0, 114547.63810602554928),
        (30.0, 999.0, 1001.0, 1998.0, -961.88944284923894851),
        (30.0, 1.0, 524288.0, 524288.0, -1.0),
        (30.0, 181.0, 262144.0, 262294.5, -2143.8458891499366677),
        (30.0, 262144.0, 262144.0, 262147.0, -15726659.198811151372),
        (1000.0, 1.0, 1.0, 0.0, 0.0019990003332500166639),
        (1000.0, 1.0, 1.0, 20.5, -9.7970877811691192886e-7),
        (1000.0, 10.0, 1000.0, 995.0, -39.118247432411873769),
        (1000.0, 10.0, 1000.0, 1300.5, -29.586794949130692269),
        (1000.0, 999.0, 1000.0, 1.0, 671564.35887246797133),
        (1000.0, 999.0, 1001.0, 1998.0, -159980.63237500863178),
        (1000.0, 1.0, 524288.0, 524288.0, -1.0),
        (1000.0, 181.0, 262144.0, 262294.5, -28251.136081525365157),
        (1000.0, 262144.0, 262144.0, 262147.0, -520294026.04048726181),
        (262144.0, 1.0, 1.0, 0.0, 7.6293799793532753326e-6),
        (262144.0, 1.0, 1.0, 20.5, -1.455077729427879582e-11),
        (262144.0, 10.0, 1000.0, 995.0, 0.0025176047664634750904),
        (262144.0, 10.0, 1000.0, 1300.5, -0.0014479919314747223119),
        (262144.0, 999.0, 1000.0, 1.0, 5064.1315270980153675),
        (262144.0, 999.0, 1001.0, 1998.0, -14.441424059105082324),
        (262144.0, 1.0, 524288.0, 524288.0, -0.74764507241550879651),
        (262144.0, 181.0, 262144.0, 262294.5, -13082.973682253125546),
        (262144.0, 262144.0, 262144.0, 262147.0, -5745600186.066174172),
        (262144.0, 262144.0, 262144.0, 1048576.0, -1484877209.5468916082),
        (1e9, 1.0, 1.0, 0.0, 1.9999999990000000003e-9),
        (1e9, 1.0, 1.0, 20.5, -9.9999997950000021021e-19),
        (1e9, 10.0, 1000.0, 995.0, 1.0399000000994999546e-6),
        (1e9, 10.0, 1000.0, 1300.5, -9.9999869950092899123e-11),
        (1e9, 999.0, 1000.0, 1.0, 1.3313310039994655014),
        (1e9, 999.0, 1001.0, 1998.0, -9.9799600200715866076e-7),
        (1e9, 1.0, 524288.0, 524288.0, -2.7473383582144291878e-7),
        (1e9, 181.0, 262144.0, 262294.5, -0.0022412809841409295427),
        (1e9, 262144.0, 262144.0, 262147.0, 5999872.2388885291345),
        (1e9, 262144.0, 262144.0, 1048576.0, -4717.4173719834930236),
    ];

    #[test]
    fn gauss_markov_keeps_its_digits_for_fast_and_slow_decay() {
        for (tc, n, m, u, expected) in GAUSS_MARKOV {
            assert_relative(&Component::GaussMarkov { tc }, (n, m, u), expected, 1e-13);
        }
    }

    #[test]
    fn gauss_markov_is_continuous_where_its_forms_change() {
        for (n, m, u) in [(500.0, 500.0, 20.0), (500.0, 800.0, 3.0), (20.0, 500.0, 0.0), (20.0, 500.0, 500.0)]
        {
            for at in [n, m] {
                let value = |tc: f64| Component::GaussMarkov { tc }.covariance(n, m, u);
                let (below, above) = (value(at * (1.0 - 1e-12)), value(at * (1.0 + 1e-12)));
                assert!((below / above - 1.0).abs() < 1e-11, "n {n}, m {m}, u {u}, tc {at}");
            }
        }
    }
}
