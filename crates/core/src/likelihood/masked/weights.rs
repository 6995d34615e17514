//! Weights of the samples of a record with missing samples: the best weights for the mean of a run with random walk and
//! quantization noise.

/// Length of the taper below which the weights are those without quantization noise.
const MIN_TAPER: f64 = 0.2;

/// Exponent above which a weight is 1.
const MAX_EXPONENT: f64 = 40.0;

/// Weights that fall to 0 at the ends of a run of samples, over `taper` samples.
///
/// They are A⁻¹1, where A is the covariance of quantization noise and random walk in the run, so that the differences of
/// the angle at the ends of many runs do not become white noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// Rate of the fall; 0 without a taper.
    rate: f64,
}

impl Weights {
    /// `taper`: the root of the ratio of quantization noise to random walk, Q/(N√τ₀). \[samples\]
    pub(super) fn new(taper: f64) -> Self {
        Self { rate: if taper < MIN_TAPER { 0.0 } else { 2.0 * (0.5 / taper).asinh() } }
    }

    fn fall(self, distance: f64) -> f64 {
        let x = self.rate * distance;
        if x > MAX_EXPONENT { 0.0 } else { (-x).exp() }
    }

    /// The weights of the samples beginning with `start`; 0 for missing samples and outside the record.
    pub(super) fn fill(self, present: &[bool], start: isize, weights: &mut [f64]) {
        let n = present.len();
        let there = |t: isize| usize::try_from(t).is_ok_and(|t| t < n && present[t]);
        if self.rate == 0.0 {
            for (i, w) in weights.iter_mut().enumerate() {
                *w = f64::from(u8::from(there(start + i as isize)));
            }
            return;
        }
        // The end of a run has no effect on samples beyond this distance.
        let reach = (MAX_EXPONENT / self.rate).ceil() as isize;
        let mut before = 0; // number of earlier samples in the run, at most `reach`
        while before < reach && there(start - 1 - before) {
            before += 1;
        }
        let stop = start + weights.len() as isize;
        let mut t = start;
        while t < stop {
            if !there(t) {
                weights[(t - start) as usize] = 0.0;
                before = 0;
                t += 1;
                continue;
            }
            let mut end = t + 1;
            while end < stop + reach && there(end) {
                end += 1;
            }
            let length = (before + end - t) as f64 + 1.0;
            let norm = 1.0 + self.fall(length);
            for (p, at) in (before + 1..).zip(t..end.min(stop)) {
                let p = p as f64;
                weights[(at - start) as usize] = 1.0 - (self.fall(p) + self.fall(length - p)) / norm;
            }
            t = end;
            before = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_solve_the_covariance_of_the_run() {
        // N² + Q²(2, −1, −1): with taper λ the matrix is tridiagonal 1 + 2λ², −λ²; its solution for a right side of 1.
        let taper: f64 = 3.7;
        let present: Vec<bool> = (0..60).map(|t| !(t == 0 || t == 12 || (40..44).contains(&t))).collect();
        let mut w = vec![0.0; 60];
        Weights::new(taper).fill(&present, 0, &mut w);
        let square = taper * taper;
        let at = |t: isize| usize::try_from(t).ok().and_then(|t| w.get(t)).copied().unwrap_or(0.0);
        for t in 0..60 {
            if present[t] {
                let t = t as isize;
                let image = (1.0 + 2.0 * square) * at(t) - square * (at(t - 1) + at(t + 1));
                assert!((image - 1.0).abs() < 1e-12, "sample {t}: {image}");
            } else {
                assert!(w[t] == 0.0);
            }
        }
    }

    #[test]
    fn weights_do_not_depend_on_the_piece() {
        let present: Vec<bool> = (0..500).map(|t| t % 7 != 3 || (100..400).contains(&t)).collect();
        for taper in [0.0, 0.5, 8.0] {
            let weights = Weights::new(taper);
            let mut whole = vec![0.0; 520];
            weights.fill(&present, -10, &mut whole);
            for start in [-10, 0, 95, 130, 333] {
                let mut piece = vec![0.0; 120];
                weights.fill(&present, start, &mut piece);
                let offset = (start + 10) as usize;
                for (a, b) in piece.iter().zip(&whole[offset..]) {
                    assert!((a - b).abs() < 1e-12, "taper {taper}, piece from {start}");
                }
            }
        }
    }
}
