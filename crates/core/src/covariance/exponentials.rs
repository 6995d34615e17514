//! Noise whose samples have an exponential autocovariance: a Gauss-Markov process, or a pole of a filter.

use super::terms::{positive, triangles};
use crate::special::exp_minus_one;
use sigmatau_fft::Complex64;
use std::ops::{Add, Mul, Sub};

/// A rate of decay per sample, real or complex, with a positive real part.
pub(super) trait Decay:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self>
{
    /// Absolute value.
    fn size(self) -> f64;
    /// 1/x.
    fn reciprocal(self) -> Self;
    /// e^x.
    fn exponential(self) -> Self;
    /// e^x − 1.
    fn exponential_minus_one(self) -> Self;
    /// sinh x.
    fn hyperbolic_sine(self) -> Self;
}

impl Decay for f64 {
    fn size(self) -> f64 {
        self
    }

    fn reciprocal(self) -> Self {
        self.recip()
    }

    fn exponential(self) -> Self {
        self.exp()
    }

    fn exponential_minus_one(self) -> Self {
        self.exp_m1()
    }

    fn hyperbolic_sine(self) -> Self {
        self.sinh()
    }
}

impl Decay for Complex64 {
    fn size(self) -> f64 {
        self.norm()
    }

    fn reciprocal(self) -> Self {
        self.inv()
    }

    fn exponential(self) -> Self {
        self.exp()
    }

    fn exponential_minus_one(self) -> Self {
        exp_minus_one(self)
    }

    fn hyperbolic_sine(self) -> Self {
        self.sinh()
    }
}

/// C(u) of s(l) = −½ |l| coth(a / 2) − e^(−a|l|) / (4 sinh²(a / 2)), of the autocovariance e^(−a|l|) of the samples.
pub(super) fn exponentials<T: Decay>(n: f64, m: f64, u: f64, a: T) -> T {
    let power = |x: f64| (a * -x).exponential();
    let loss = (a * -1.0).exponential_minus_one() * -1.0;
    // 1 / (4 sinh²(a / 2)).
    let scale = power(1.0) * (loss * loss).reciprocal();
    if a.size() * n > 1.0 {
        // coth(a / 2).
        let coth = (power(1.0) * 2.0 + loss) * loss.reciprocal();
        let second = |x: f64| power(x + n) - power(x) * 2.0 + power((x - n).abs());
        let difference = second(u + m) - second(u) * 2.0 + second((u - m).abs());
        return coth * triangles(n, m, u) - scale * difference;
    }
    // The second difference of e^(−a|l|) is 4 sinh²(an / 2) e^(−a|l|) − 2 sinh(a (n − |l|)₊). The linear part
    // of the hyperbolic sine cancels the triangles, and the remainder is of the order a³.
    let bends = sine_excess(a, positive(n - (u - m).abs())) * 2.0 - sine_excess(a, positive(n - u)) * 4.0;
    let squared = |n: f64| {
        let half = (a * (0.5 * n)).hyperbolic_sine();
        half * half * 4.0
    };
    // The second difference of e^(−a|l|) over m, negated.
    let negated = if a.size() * m > 1.0 {
        power(u) * 2.0 - power(u + m) - power((u - m).abs())
    } else {
        (a * positive(m - u)).hyperbolic_sine() * 2.0 - squared(m) * power(u)
    };
    scale * (bends + squared(n) * negated)
}

/// sinh(ay) − y sinh a, for 0 ≤ |ay| ≤ 1 and |a| ≤ 1.
fn sine_excess<T: Decay>(a: T, y: f64) -> T {
    // Σ aʲ (yʲ − y) / j!, j = 3, 5 …
    let (a_squared, ay_squared) = (a * a, a * a * (y * y));
    let (mut linear, mut power) = (a * y, a * y);
    let mut sum = a * 0.0;
    for j in 1..=9 {
        let next = 1.0 / (f64::from(2 * j) * f64::from(2 * j + 1));
        linear = linear * a_squared * next;
        power = power * ay_squared * next;
        sum = sum + power - linear;
    }
    sum
}
