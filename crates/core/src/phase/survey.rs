//! Survey of a record before it is summed: its mean rate, and the scatter about it.

/// Largest number of phase points per anchor; see `Survey` for the choice.
pub const LONGEST_BLOCK: usize = 131_072;
/// Smallest number of phase points per anchor.
pub const SHORTEST_BLOCK: usize = 2048;

/// Properties of a record that its summation needs.
pub(super) struct Survey {
    /// Approximate mean rate. A constant rate has no effect on any difference, so that its rounding does not matter.
    pub(super) slope: f64,
    /// Points per anchor.
    pub(super) block: usize,
}

/// Distance of the samples that a survey examines, each with the next sample.
const SURVEY_STEP: usize = 64;

impl Survey {
    /// The rounding error of a point is proportional to its height above its anchor. For rates with an rms deviation w and
    /// an rms change d from sample to sample, the points of a block of L reach a height of L·w. The second differences of
    /// single samples, of the order of d, then have errors of √6 · 2⁻⁵³/√3 · L·w. These are independent, so the relative
    /// error of the mean of N squares is twice that over d√N. L is chosen to keep it below 10⁻¹³.
    pub(super) fn of(rate: &[f64]) -> Self {
        let Some(&first) = rate.first() else {
            return Self { slope: 0.0, block: LONGEST_BLOCK };
        };
        let (mut count, mut sum, mut squares, mut changes) = (0.0, 0.0, 0.0, 0.0);
        for pair in rate.windows(2).step_by(SURVEY_STEP) {
            let (y, change) = (pair[0] - first, pair[1] - pair[0]);
            count += 1.0;
            sum += y;
            squares += y * y;
            changes += change * change;
        }
        if count == 0.0 {
            return Self { slope: first, block: LONGEST_BLOCK };
        }
        let mean = sum / count;
        let slope = first + mean;
        let wander = (squares / count - mean * mean).max(0.0).sqrt();
        let change = f64::sqrt(changes / count);
        let error_per_point =
            2.0 * 2f64.sqrt() * 2f64.powi(-53) * wander / (change * (rate.len() as f64).sqrt());
        let longest = 1e-13 / error_per_point;
        let mut block = LONGEST_BLOCK;
        while block > SHORTEST_BLOCK && block as f64 > longest {
            block /= 2;
        }
        Self { slope, block }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_as_long_as_the_rate_stays_near_its_mean() {
        let noise: Vec<f64> = white();
        let walk: Vec<f64> = noise
            .iter()
            .scan(0.0, |sum, y| {
                Some({
                    *sum += y;
                    *sum
                })
            })
            .collect();
        let far: Vec<f64> = noise.iter().map(|y| y + 1e22).collect();
        assert_eq!(Survey::of(&noise).block, LONGEST_BLOCK);
        assert_eq!(Survey::of(&far).block, LONGEST_BLOCK);
        let ramp: Vec<f64> = (0..100_000u32).map(f64::from).collect();
        assert_eq!(Survey::of(&ramp).block, SHORTEST_BLOCK);
        assert!(Survey::of(&walk).block < LONGEST_BLOCK);
        for n in 0..3 {
            assert_eq!(Survey::of(&vec![7.0; n]).block, LONGEST_BLOCK);
            let expected = if n == 0 { 0.0f64 } else { 7.0 };
            assert_eq!(Survey::of(&vec![7.0; n]).slope.to_bits(), expected.to_bits());
        }
    }

    fn white() -> Vec<f64> {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 12) as f64 - 2f64.powi(51)
        };
        (0..3 * LONGEST_BLOCK).map(|_| random()).collect()
    }
}
