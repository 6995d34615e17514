//! Medians and scatter of the neighbours of samples, for outliers; missing samples are NaN.

/// Number of neighbours on either side whose scatter is computed, without the nearest one but counting it.
const NEIGHBOURS: usize = 32;

/// Smallest number of changes whose scatter is computed.
const MIN_CHANGES: usize = 4;

/// Thresholds of [`outliers`].
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Distance from the nearer median, see [`from_sides`].
    pub threshold: f64,
    /// The same in standard deviations of the neighbours, to which `least` is added.
    pub multiple: f64,
    /// See `multiple`.
    pub least: f64,
    /// Neighbours on either side.
    pub side: usize,
    /// See [`scatter`].
    pub quantile: Quantile,
}

/// A quantile of the magnitudes of changes.
#[derive(Debug, Clone, Copy)]
pub struct Quantile {
    /// Part of the changes below it.
    pub part: f64,
    /// The quantile for normal noise with standard deviation 1.
    pub normal: f64,
}

/// Indices of the samples beyond the limits, in order.
///
/// Only samples within two of a change of half the threshold are tested, because an outlier causes such a change. Missing
/// samples are skipped.
#[must_use]
pub fn outliers(x: &[f64], limits: &Limits) -> Vec<usize> {
    let mut values = Vec::new();
    let mut far = |at: usize| {
        let away = from_sides(x, at, limits.side, &mut values).abs();
        away > limits.threshold
            && away > limits.multiple * scatter(x, at, limits.quantile, &mut values) + limits.least
    };
    let mut there = Vec::new(); // empty if no sample is missing
    if x.iter().any(|y| y.is_nan()) {
        there.extend((0..x.len()).filter(|&k| !x[k].is_nan()));
    }
    let (whole, count) = (there.is_empty(), if there.is_empty() { x.len() } else { there.len() });
    let place = |k: usize| if whole { k } else { there[k] };
    let mut found = Vec::new();
    let mut judged = 0;
    for edge in 1..count {
        if (x[place(edge)] - x[place(edge - 1)]).abs() > 0.5 * limits.threshold {
            let beyond = (edge + 2).min(count);
            found.extend((judged.max(edge.saturating_sub(2))..beyond).map(place).filter(|&at| far(at)));
            judged = beyond;
        }
    }
    found
}

/// Distance of a sample from the nearer of the medians of its two sides; 0 between the medians.
///
/// A side with fewer than two samples is ignored; NaN if both are.
#[must_use]
pub fn from_sides(x: &[f64], at: usize, side: usize, values: &mut Vec<f64>) -> f64 {
    let here = x[at];
    let mut from = |near: &[f64]| {
        values.clear();
        values.extend(near.iter().filter(|y| y.is_finite()));
        match values[..] {
            [] | [_] => f64::NAN,
            // The nearer sample, because the other may be an outlier, which would move the mean of both.
            [a, b] => here - if (a - here).abs() <= (b - here).abs() { a } else { b },
            _ => {
                values.sort_unstable_by(f64::total_cmp);
                here - middle(values)
            }
        }
    };
    let before = from(&x[at.saturating_sub(side)..at]);
    let after = from(&x[at + 1..x.len().min(at + 1 + side)]);
    if !before.is_finite() || !after.is_finite() {
        return if before.is_finite() { before } else { after };
    }
    if before * after <= 0.0 {
        return 0.0;
    }
    if before.abs() < after.abs() { before } else { after }
}

/// Standard deviation of the samples before or after a sample, from a quantile of their changes; 0 if unknown.
///
/// The larger of both is returned, so that the first sample of a shock is compared with the shock.
#[must_use]
pub fn scatter(x: &[f64], at: usize, quantile: Quantile, values: &mut Vec<f64>) -> f64 {
    let mut of = |near: &[f64]| {
        values.clear();
        values.extend(
            near.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| change.is_finite()),
        );
        if values.len() < MIN_CHANGES {
            return 0.0;
        }
        values.sort_unstable_by(f64::total_cmp);
        let place = quantile.part * (values.len() - 1) as f64;
        let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
        (low + (place - place.floor()) * (high - low)) / quantile.normal
    };
    let before = of(&x[at.saturating_sub(NEIGHBOURS)..at.saturating_sub(1)]);
    let after = of(&x[x.len().min(at + 2)..x.len().min(at + 1 + NEIGHBOURS)]);
    before.max(after)
}

/// Median of the `side` samples before and after each sample, without that sample; NaN for fewer than `least` of them.
#[must_use]
pub fn medians(x: &[f64], side: usize, least: usize) -> Vec<f64> {
    let least = least.max(1);
    // The sorted samples of the window, including its middle.
    let mut window: Vec<f64> = Vec::with_capacity(2 * side + 1);
    let enter = |window: &mut Vec<f64>, y: f64| {
        if y.is_finite() {
            window.insert(rank(window, y), y);
        }
    };
    for &y in &x[..side.min(x.len())] {
        enter(&mut window, y);
    }
    (0..x.len())
        .map(|at| {
            if let Some(&y) = x.get(at + side) {
                enter(&mut window, y);
            }
            if at > side && x[at - side - 1].is_finite() {
                window.remove(rank(&window, x[at - side - 1]));
            }
            let known = x[at].is_finite();
            let count = window.len() - usize::from(known);
            if count < least {
                return f64::NAN;
            }
            let own = if known { rank(&window, x[at]) } else { usize::MAX };
            let other = |k: usize| window[k + usize::from(k >= own)];
            0.5 * (other((count - 1) / 2) + other(count / 2))
        })
        .collect()
}

/// Number of smaller values in a short list, without the unpredictable branches of a binary search.
fn rank(few: &[f64], y: f64) -> usize {
    few.iter().map(|&other| u32::from(other < y)).sum::<u32>() as usize
}

fn middle(ordered: &[f64]) -> f64 {
    0.5 * (ordered[(ordered.len() - 1) / 2] + ordered[ordered.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: Quantile = Quantile { part: 0.5, normal: 0.953_87 };

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 0x2545_F491_4F6C_DD1D_u64;
        (0..n)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect()
    }

    #[test]
    fn medians_are_those_of_sorted_neighbours() {
        let mut x = noise(500);
        for k in [0, 3, 100, 101, 102, 103, 104, 105, 499] {
            x[k] = f64::NAN;
        }
        x[200] = x[201];
        for (side, least) in [(4, 4), (16, 16), (3, 1), (600, 600)] {
            for (at, found) in medians(&x, side, least).into_iter().enumerate() {
                let near = at.saturating_sub(side)..x.len().min(at + side + 1);
                let mut others: Vec<f64> =
                    near.filter(|&k| k != at && x[k].is_finite()).map(|k| x[k]).collect();
                others.sort_by(f64::total_cmp);
                let expected = if others.len() < least { f64::NAN } else { middle(&others) };
                assert_eq!(found.to_bits(), expected.to_bits(), "{side} {at}");
            }
        }
    }

    #[test]
    fn outliers_are_found_beside_missing_samples_and_at_the_ends() {
        let mut x = noise(1000);
        let limits = Limits { threshold: 5.0, multiple: 6.0, least: 0.0, side: 4, quantile: HALF };
        assert!(outliers(&x, &limits).is_empty());
        x[500] = f64::NAN;
        for k in [0, 400, 499, 501, 999] {
            x[k] = 30.0;
        }
        assert_eq!(outliers(&x, &limits), [0, 400, 499, 501, 999]);
        // Next to a step the nearer side counts.
        for y in &mut x[700..] {
            *y += 100.0;
        }
        assert_eq!(outliers(&x, &limits), [0, 400, 499, 501, 999]);
    }

    #[test]
    fn scatter_is_that_of_the_louder_side() {
        let mut x = noise(200);
        for y in &mut x[101..] {
            *y *= 10.0;
        }
        let mut values = Vec::new();
        let [quiet, between, loud] = [50, 100, 150].map(|at| scatter(&x, at, HALF, &mut values));
        assert!((0.15..0.6).contains(&quiet) && loud > 5.0 * quiet && between > 5.0 * quiet);
        assert_eq!(scatter(&x[..4], 1, HALF, &mut values).to_bits(), 0);
    }
}
