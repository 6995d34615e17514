//! Sums over lags of functions that are smooth except at a few kinks.
//!
//! Lags next to a kink are summed one by one. Further lags are summed in panels, whose length doubles with
//! the distance from the kink, by Gauss quadrature for sums. Its nodes are the zeros of a discrete Chebyshev
//! polynomial (Gram polynomial; G. Szegő, "Orthogonal Polynomials", section 2.8). It is exact for polynomials
//! up to degree 2·[`NODES`] − 1, and tends to the Gauss–Legendre rule for long panels. A panel is never
//! longer than its distance from the nearest kink. For a summand that is analytic between kinks, the error is
//! about (3 + √8)^(−2·NODES) = 5·10⁻¹⁶.

use std::sync::LazyLock;

/// Nodes of a panel.
const NODES: usize = 10;
/// Binary logarithm of the length of the shortest panel, which has about twice as many lags as nodes.
const LOG2_SHORTEST_PANEL: usize = 4;
/// Number of lags on either side of a kink that are always summed one by one.
pub(crate) const SUMMED_LAGS: usize = 1 << LOG2_SHORTEST_PANEL;
/// Panels are at most 2^([`LOG2_SHORTEST_PANEL`] + PANELS − 1) lags long.
const PANELS: usize = 48;

/// Node, from −1 to 1 over the panel, and weight.
type Rule = [(f64, f64); NODES];

/// The quadratures of all panel lengths.
#[derive(Debug)]
pub(crate) struct Rules(Vec<Rule>);

impl Rules {
    /// The rules, computed on first use.
    pub(crate) fn get() -> &'static Self {
        static RULES: LazyLock<Rules> = LazyLock::new(|| {
            Rules((LOG2_SHORTEST_PANEL..LOG2_SHORTEST_PANEL + PANELS).map(|log| rule(1u64 << log)).collect())
        });
        &RULES
    }

    /// Calls `visit(lag, weight)` so that Σ weight·f(lag) is the sum of f over all lags from 0 to `last`.
    ///
    /// f may have kinks at `kinks`, which are ascending and begin with 0. Lags within `one_by_one` of a kink,
    /// which is at least [`SUMMED_LAGS`], are visited one by one with weight 1.
    pub(crate) fn visit(
        &self,
        kinks: &[usize],
        last: usize,
        one_by_one: usize,
        mut visit: impl FnMut(f64, f64),
    ) {
        for (i, &kink) in kinks.iter().enumerate() {
            if kink > last {
                break;
            }
            visit(kink as f64, 1.0);
            let next = kinks.get(i + 1).copied();
            self.visit_gap(kink, next, last, one_by_one, &mut visit);
        }
    }

    /// Visits the lags after `kink`, up to the `next` kink or to `last`, from both ends.
    fn visit_gap(
        &self,
        kink: usize,
        next: Option<usize>,
        last: usize,
        one_by_one: usize,
        visit: &mut impl FnMut(f64, f64),
    ) {
        let mut first = kink + 1;
        let mut end = next.map_or(last + 1, |next| next.min(last + 1));
        while first < end {
            let behind = first - kink;
            let ahead = next.map_or(usize::MAX, |next| next - (end - 1));
            let near = behind.min(ahead);
            let panel = if near < one_by_one { 0 } else { near.min(end - first) };
            let length = if panel < SUMMED_LAGS {
                let lag = if behind <= ahead { first } else { end - 1 };
                visit(lag as f64, 1.0);
                1
            } else {
                self.visit_panel(panel, behind <= ahead, first, end, visit)
            };
            if behind <= ahead {
                first += length;
            } else {
                end -= length;
            }
        }
    }

    /// Visits the longest panel of at most `room` lags, at the beginning or at the end of `first..end`;
    /// returns its length.
    fn visit_panel(
        &self,
        room: usize,
        at_beginning: bool,
        first: usize,
        end: usize,
        visit: &mut impl FnMut(f64, f64),
    ) -> usize {
        let panel = (room.ilog2() as usize - LOG2_SHORTEST_PANEL).min(PANELS - 1);
        let length = 1 << (panel + LOG2_SHORTEST_PANEL);
        let start = if at_beginning { first } else { end - length };
        let half = 0.5 * length as f64;
        let centre = start as f64 + (half - 0.5);
        for (node, weight) in self.0[panel] {
            visit(centre + half * node, weight);
        }
        length
    }
}

/// Gauss quadrature of a sum over `length` lags.
fn rule(length: u64) -> Rule {
    let mut zeros = Vec::with_capacity(NODES);
    // The positive zeros in descending order: Newton's method from above, with the known zeros divided out,
    // converges to the next zero without overshooting (H. J. Maehly, Z. angew. Math. Phys. 5, 1954). The
    // other zeros are their negatives.
    for _ in 0..NODES / 2 {
        let mut x = 1.0;
        for _ in 0..100 {
            let (value, slope, _) = polynomial(length, x);
            let known: f64 = zeros.iter().map(|zero: &f64| (x - zero).recip() + (x + zero).recip()).sum();
            let step = value / (slope - value * known);
            x -= step;
            if step.abs() < 1e-13 {
                break;
            }
        }
        let (value, slope, _) = polynomial(length, x);
        zeros.push(x - value / slope);
    }
    let squared_norm = (1..NODES).map(|j| recurrence(length, j)).product::<f64>() * length as f64;
    let weight = |x: f64| {
        let (_, slope, previous) = polynomial(length, x);
        squared_norm / (previous * slope)
    };
    let mut rule = [(0.0, 0.0); NODES];
    for (i, &x) in zeros.iter().enumerate() {
        rule[i] = (-x, weight(x));
        rule[NODES - 1 - i] = (x, weight(x));
    }
    rule
}

/// The monic polynomial of degree [`NODES`] on lags spread over −1 … 1, its slope, and the polynomial of the
/// next lower degree.
fn polynomial(length: u64, x: f64) -> (f64, f64, f64) {
    let (mut before, mut value) = (0.0, 1.0);
    let (mut slope_before, mut slope) = (0.0, 0.0);
    for j in 0..NODES {
        let b = if j == 0 { 0.0 } else { recurrence(length, j) };
        (before, value, slope_before, slope) =
            (value, x * value - b * before, slope, value + x * slope - b * slope_before);
    }
    (value, slope, before)
}

/// Coefficient of p(j + 1) = x p(j) − b p(j − 1).
fn recurrence(length: u64, j: usize) -> f64 {
    let (j, length) = (j as f64, length as f64);
    let ratio = j / length;
    j * j * (1.0 - ratio * ratio) / (4.0 * j * j - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kinks: &[usize], last: usize, f: impl Fn(f64) -> f64) -> f64 {
        let mut sum = 0.0;
        Rules::get().visit(kinks, last, SUMMED_LAGS, |lag, weight| sum += weight * f(lag));
        sum
    }

    #[test]
    fn a_panel_sums_polynomials_up_to_its_degree() {
        for log in LOG2_SHORTEST_PANEL..14 {
            let length = 1u64 << log;
            let rule = rule(length);
            assert!(rule.windows(2).all(|pair| pair[0].0 < pair[1].0) && rule[NODES - 1].0 < 1.0);
            for degree in (0..2 * NODES as i32).step_by(2) {
                let lag = |i: u64| (2.0 * i as f64 + 1.0) / length as f64 - 1.0;
                let exact: f64 = (0..length).map(|i| lag(i).powi(degree)).sum();
                let got: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree)).sum();
                // Each sum has hundreds of roundings.
                assert!((got / exact - 1.0).abs() < 1e-13, "length {length}, degree {degree}");
            }
        }
    }

    #[test]
    fn every_lag_counts_once() {
        for kinks in [&[0][..], &[0, 1], &[0, 5, 17, 40], &[0, 33, 1000, 100_003], &[0, 1000, 1001, 5000]] {
            for last in [0, 1, 4, 16, 31, 32, 33, 34, 200, 999, 1000, 1001, 4096, 99_990, 250_000] {
                let count = sum(kinks, last, |_| 1.0);
                assert!((count / (last + 1) as f64 - 1.0).abs() < 1e-13, "{kinks:?} to {last}");
                let first_moment = 0.5 * last as f64 * (last + 1) as f64;
                assert!((sum(kinks, last, |lag| lag) - first_moment).abs() <= 1e-13 * first_moment);
            }
        }
    }

    #[test]
    fn kinked_logarithms_are_summed_to_the_last_digits() {
        let kinks = [0, 300, 20_000];
        let f = |x: f64| {
            let kinked = |d: f64| if d > 0.0 { d * d * d.ln() } else { 0.0 };
            kinked(x + 0.5) - 2.0 * kinked((x - 300.0).abs()) + 3.0 * kinked((x - 20_000.0).abs())
        };
        for last in [200, 5000, 19_990, 20_100, 70_000] {
            let exact: f64 = (0..=last).map(|lag| f(lag as f64)).sum();
            assert!((sum(&kinks, last, f) / exact - 1.0).abs() < 1e-12, "to {last}");
        }
    }

    #[test]
    fn the_longest_panels_hold_any_record() {
        let last = usize::MAX >> 8;
        let count = sum(&[0], last, |_| 1.0);
        assert!((count / last as f64 - 1.0).abs() < 1e-12);
    }
}
