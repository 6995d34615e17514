//! Distribution of the statistic of a test, and the division of an interval's error probability between the tails.
//!
//! The statistic is skewed if few independent stretches of the record determine the term. It is approximated by
//! Pearson's type III, the distribution of a χ². The probability 1 − level is divided between the tails as in
//! G. J. Feldman and R. D. Cousins, Phys. Rev. D 57, 3873 (1998): all of it is in the upper tail for a value of 0, and half
//! of it in each tail for values well above their error. The interval therefore excludes 0 exactly if the term is
//! significant, and its coverage does not depend on significance.

use crate::distributions::{
    gamma_above, gamma_below, gamma_quantile, gamma_quantile_above, normal_below, normal_quantile,
};
use std::sync::{Mutex, PoisonError};

/// Skewness below which the normal distribution is used.
const NEGLIGIBLE_SKEWNESS: f64 = 1e-3;

const SMALLEST_PROBABILITY: f64 = 1e-300;

/// Number of halvings of an interval of length 10.
const HALVINGS: usize = 50;

/// Number of true values in the table of shares, in standard errors: 0.001, then 0.05 to 4.
const TRUE_VALUES: usize = 81;

/// Number of cached tables of shares.
const CACHED: usize = 16;

type Shares = [f64; TRUE_VALUES];

/// Probabilities below and above z of Pearson's type III distribution with mean 0, variance 1 and the given skewness.
pub(crate) fn skewed_tails(z: f64, skewness: f64) -> (f64, f64) {
    if skewness.abs() < NEGLIGIBLE_SKEWNESS {
        return (normal_below(z), normal_below(-z));
    }
    if skewness < 0.0 {
        let (above, below) = skewed_tails(-z, -skewness);
        return (below, above);
    }
    let shape = 4.0 / (skewness * skewness);
    let x = shape + z * shape.sqrt();
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    (gamma_below(shape, x), gamma_above(shape, x))
}

/// Deviate that the skewed distribution exceeds with the given probability.
pub(crate) fn critical(skewness: f64, probability: f64) -> f64 {
    if skewness.abs() < NEGLIGIBLE_SKEWNESS {
        return -normal_quantile(probability);
    }
    let shape = 4.0 / (skewness * skewness);
    let x = if skewness > 0.0 {
        gamma_quantile_above(shape, probability)
    } else {
        gamma_quantile(shape, probability)
    };
    skewness.signum() * (x - shape) / shape.sqrt()
}

/// The normal deviate of a probability, which is nearly linear in the unknown.
pub(crate) fn deviate(probability: f64) -> f64 {
    normal_quantile(probability.clamp(SMALLEST_PROBABILITY, 1.0 - 1e-16))
}

/// Probability in the upper tail by the true value in standard errors.
#[derive(Debug, Clone)]
pub(crate) struct UpperShare(Shares);

impl UpperShare {
    /// The shares for a confidence level, cached for the latest levels.
    pub(crate) fn of(level: f64) -> Self {
        static TABLES: Mutex<Vec<(u64, Shares)>> = Mutex::new(Vec::new());
        let key = level.to_bits();
        let mut tables = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, shares)) = tables.iter().find(|(known, _)| *known == key) {
            return Self(*shares);
        }
        let shares = std::array::from_fn(|k| upper_tail(table_value(k), level));
        if tables.len() == CACHED {
            tables.remove(0);
        }
        tables.push((key, shares));
        Self(shares)
    }

    pub(crate) fn at(&self, true_value: f64) -> f64 {
        if true_value <= table_value(0) {
            return self.0[0];
        }
        for k in 1..TRUE_VALUES {
            if true_value <= table_value(k) {
                let share = (true_value - table_value(k - 1)) / (table_value(k) - table_value(k - 1));
                return self.0[k - 1] + share * (self.0[k] - self.0[k - 1]);
            }
        }
        self.0[TRUE_VALUES - 1]
    }
}

fn table_value(k: usize) -> f64 {
    if k == 0 { 1e-3 } else { 0.05 + (4.0 - 0.05) * (k - 1) as f64 / (TRUE_VALUES - 2) as f64 }
}

/// Upper tail of the acceptance interval [μ − b, μ + d] of a normal x with mean μ ≥ 0, by the likelihood ratio. Both
/// ends have the same ratio of the likelihood to that of max(x, 0): b = d, or (μ² + d²)/(2μ) if the interval contains
/// x < 0.
fn upper_tail(mu: f64, level: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..HALVINGS {
        let d = 0.5 * (low + high);
        let below = if d <= mu { d } else { (mu * mu + d * d) / (2.0 * mu) };
        if normal_below(d) - normal_below(-below) < level {
            low = d;
        } else {
            high = d;
        }
    }
    normal_below(-high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pearson's type III with a skewness of 1 is a gamma distribution of shape 4, with a closed form.
    #[test]
    fn tails_are_pearsons() {
        let above = |z: f64| {
            let x = 4.0 + 2.0 * z;
            (-x).exp() * (1.0 + x + x * x / 2.0 + x * x * x / 6.0)
        };
        for z in [-1.5, -0.7, 0.0, 1.2, 4.0] {
            let tails = skewed_tails(z, 1.0);
            assert!((tails.1 / above(z) - 1.0).abs() < 1e-12 && (tails.0 + tails.1 - 1.0).abs() < 1e-12);
            let other = skewed_tails(-z, -1.0);
            assert!((other.0 - tails.1).abs() < 1e-15 && (other.1 - tails.0).abs() < 1e-15);
        }
        assert_eq!(skewed_tails(-3.0, 1.0), (0.0, 1.0));
        // A skewness γ moves the tails by (z² − 1) φ(z) γ/6 to first order.
        let (z, skewness) = (1.3_f64, 1.5e-3);
        let moved =
            (z * z - 1.0) * (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt() * skewness / 6.0;
        assert!((skewed_tails(z, skewness).1 - normal_below(-z) - moved).abs() < 1e-6);
    }

    /// The normal distribution approximates a skewness of 1e-4 with an error of a sixth of it.
    #[test]
    fn critical_deviate_inverts_the_tails() {
        for skewness in [-1.9, -0.4, 1e-4, 0.4, 1.9] {
            for probability in [0.001, 0.05, 0.5] {
                let got = skewed_tails(critical(skewness, probability), skewness).1;
                assert!((got / probability - 1.0).abs() < 1e-3, "{skewness} {probability}: {got}");
            }
        }
    }

    #[test]
    fn acceptance_has_its_probability_and_order() {
        for level in [0.68, 0.9, 0.95] {
            let shares = UpperShare::of(level).0;
            assert!((shares[0] - (1.0 - level)).abs() < 1e-4);
            assert!((shares[TRUE_VALUES - 1] - 0.5 * (1.0 - level)).abs() < 1e-6);
            assert!(shares.windows(2).all(|pair| pair[1] - pair[0] <= 1e-12));
            for (k, share) in shares.into_iter().enumerate() {
                let mu = table_value(k);
                let upper = mu - normal_quantile(share);
                let lower = mu + normal_quantile(1.0 - level - share + 1e-300);
                assert!((normal_below(upper - mu) - normal_below(lower - mu) - level).abs() < 1e-9);
                // Both ends have the same likelihood ratio to the best non-negative value.
                let likelihood = |x: f64| (-0.5 * (x - mu).powi(2) + 0.5 * (x - x.max(0.0)).powi(2)).exp();
                // With all of the probability in the upper tail there is no lower end.
                if mu > 0.1 && mu < 3.0 && share < 1.0 - level - 1e-9 {
                    assert!((likelihood(lower) / likelihood(upper) - 1.0).abs() < 1e-6, "{mu} {level}");
                }
            }
        }
    }

    /// Feldman & Cousins (1998), Table X: a measurement of 0 with 90 %: [0, 1.64]; of 1: [0, 2.64]; of 2: [0.58, 3.64].
    #[test]
    fn published_intervals() {
        let shares = UpperShare::of(0.9);
        for (x, low, high) in [(0.0, 0.0, 1.64), (1.0, 0.0, 2.64), (2.0, 0.58, 3.64)] {
            let inside: Vec<f64> = (0..4000)
                .map(|k| 0.001 * f64::from(k + 1))
                .filter(|&mu| {
                    let share = shares.at(mu);
                    let lower = mu + normal_quantile((0.1 - share).max(1e-300));
                    lower <= x && x <= mu - normal_quantile(share)
                })
                .collect();
            assert!((inside[0] - low).abs() < 0.006 && (inside[inside.len() - 1] - high).abs() < 0.006);
        }
    }
}
