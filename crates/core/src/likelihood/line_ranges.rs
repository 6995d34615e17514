//! Ranges in which the line of a term can be drawn on a curve: averaging times at which the term dominates the variance.

use crate::likelihood::fitted_model::FittedModel;
use crate::terms::Term;

/// Smallest share of a term in the variance of the model. Its line has this share between its crossings with other
/// lines.
const MIN_VARIANCE_SHARE: f64 = 0.5;

/// Share above which the line would be clearly above the curve, because of a filter.
const FILTERED_SHARE: f64 = 1.25;

/// Length of the record over the longest averaging time of a line, as in the paper: an error of 41 % by its eq. (26).
const MIN_RECORD_RATIO: f64 = 4.0;

const PER_OCTAVE: f64 = 8.0;

/// Ratio of the longest to the shortest averaging time of a range.
const MIN_RANGE_RATIO: f64 = 2.0;

impl FittedModel {
    /// Range of averaging times \[s\] of each term with its coefficient, between `from` and a quarter of the record; None
    /// if the term does not have half of the variance of the model over an octave.
    #[must_use]
    pub fn line_ranges(&self, terms: &[(Term, f64)], from: f64) -> Vec<Option<(f64, f64)>> {
        let octaves = (self.samples as f64 / MIN_RECORD_RATIO).max(1.0).log2();
        let steps = ((octaves + 1e-9) * PER_OCTAVE).ceil() as usize;
        let mut sizes: Vec<usize> =
            (0..steps).map(|k| (k as f64 / PER_OCTAVE).exp2().round_ties_even() as usize).collect();
        sizes.dedup();
        sizes.retain(|&m| m as f64 * self.tau0 >= from * (1.0 - 1e-9));
        let total = self.avar(&sizes);
        terms.iter().map(|&(term, coefficient)| self.line_range(term, coefficient, &sizes, &total)).collect()
    }

    fn line_range(&self, term: Term, coefficient: f64, sizes: &[usize], total: &[f64]) -> Option<(f64, f64)> {
        let mut alone = [0.0; Term::ALL.len()];
        alone[term.index()] = coefficient;
        let part = Self { terms: alone, ..Self::without_parts(self.tau0, self.samples) }.avar(sizes);
        let inside: Vec<bool> = part
            .iter()
            .zip(total)
            .map(|(part, total)| (MIN_VARIANCE_SHARE..=FILTERED_SHARE).contains(&(part / total)))
            .collect();
        // The longest run of sizes, by the ratio of its ends.
        let mut longest: Option<(usize, usize)> = None;
        let ratio = |(first, last): (usize, usize)| last as f64 / first as f64;
        let runs = sizes.iter().zip(&inside).collect::<Vec<_>>();
        for run in runs.split(|(_, inside)| !**inside).filter(|run| !run.is_empty()) {
            let ends = (*run[0].0, *run[run.len() - 1].0);
            if longest.is_none_or(|longest| ratio(ends) > ratio(longest)) {
                longest = Some(ends);
            }
        }
        let span = longest.map(|(first, last)| (first as f64 * self.tau0, last as f64 * self.tau0));
        span.filter(|(first, last)| *last >= MIN_RANGE_RATIO * first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 3Q²/τ² and N²/τ cross at 3Q²/N² = 3 s; each range is on one side, up to a quarter of the record.
    #[test]
    fn ranges_end_where_the_lines_cross() {
        let model =
            FittedModel { terms: [1.0, 1.0, 0.0, 0.0, 0.0], ..FittedModel::without_parts(0.01, 200_000) };
        let eighth = 0.125_f64.exp2();
        let ranges = model.line_ranges(&[(Term::Quantization, 1.0), (Term::RandomWalk, 1.0)], 0.0);
        let [Some(steep), Some(flat)] = ranges[..] else { panic!("{ranges:?}") };
        assert!((steep.0 - 0.01).abs() < 1e-12 && (3.0 / eighth..=3.0).contains(&steep.1));
        assert!((3.0..=3.0 * eighth).contains(&flat.0) && (500.0 / eighth..=500.0).contains(&flat.1));
        // From 2 s, less than an octave of the first range remains; beyond the record, neither range does.
        assert_eq!(model.line_ranges(&[(Term::Quantization, 1.0)], 2.0), [None]);
        assert_eq!(
            model.line_ranges(&[(Term::Quantization, 1.0), (Term::RandomWalk, 1.0)], 1e4),
            [None, None]
        );
        assert_eq!(model.line_ranges(&[(Term::BiasInstability, 1e-3)], 0.0), [None]);
    }
}
