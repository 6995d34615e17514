//! The model of several runs: levels of terms that differ from run to run, terms of single runs, and sums over runs.

use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::fit::Fit;
use crate::likelihood::linear::Symmetric;
use crate::likelihood::model::{Level, Model};
use crate::terms::Term;

impl Model {
    /// Whether a term differs from run to run.
    pub(crate) fn level(&self, part: Part) -> Option<&Level> {
        self.levels.iter().find(|level| level.part == part)
    }

    /// Squared coefficient of a part in one run.
    pub(crate) fn theta_of(&self, part: usize, run: usize) -> f64 {
        let name = self.parts[part];
        if let Some(own) = self.own.iter().find(|own| own.run == run && own.part == name) {
            return own.theta;
        }
        self.theta[part] * self.level(name).map_or(1.0, |level| level.logs[run].exp())
    }

    /// The model of one run.
    pub(crate) fn of_run(&self, run: usize, regressors: &[usize]) -> Self {
        Self {
            theta: (0..self.parts.len()).map(|j| self.theta_of(j, run)).collect(),
            regressors: regressors.to_vec(),
            levels: Vec::new(),
            own: Vec::new(),
            held: None,
            held_shape: None,
            ..self.clone()
        }
    }

    /// Spectra of all runs and their logarithmic derivatives, including those with respect to levels and separate terms.
    pub(crate) fn evaluate_runs(&self, bins: &Bins, derivatives: bool) -> (Vec<f64>, Vec<Vec<f64>>) {
        let plain = self.numbers();
        let level_columns: usize = self.levels.iter().map(|level| level.logs.len()).sum();
        let count = if derivatives { plain + level_columns + self.own.len() } else { 0 };
        let mut total = Vec::with_capacity(bins.len());
        let mut columns = vec![vec![0.0; bins.len()]; count];
        for (run, (own_bins, regressors)) in bins.runs.iter().enumerate() {
            let model = self.of_run(run, regressors);
            let (spectrum, slopes) = if derivatives {
                model.with_slopes(own_bins)
            } else {
                (model.spectrum(own_bins), Vec::new())
            };
            let at = total.len()..total.len() + spectrum.len();
            total.extend(spectrum);
            if !derivatives {
                continue;
            }
            let mut level_at = plain;
            let mut factors = vec![1.0; self.parts.len()];
            for level in &self.levels {
                if let Some(j) = self.index(level.part) {
                    factors[j] = level.logs[run].exp();
                    if !self.own.iter().any(|own| own.run == run && own.part == level.part) {
                        let column = &mut columns[level_at + run][at.clone()];
                        column.iter_mut().zip(&slopes[j]).for_each(|(c, s)| *c = model.theta[j] * s);
                    }
                }
                level_at += level.logs.len();
            }
            for (k, own) in self.own.iter().enumerate().filter(|(_, own)| own.run == run) {
                if let Some(j) = self.index(own.part) {
                    factors[j] = 0.0;
                    columns[plain + level_columns + k][at.clone()].copy_from_slice(&slopes[j]);
                }
            }
            for (k, slope) in slopes.iter().enumerate() {
                let factor = factors.get(k).copied().unwrap_or(1.0);
                columns[k][at.clone()].iter_mut().zip(slope).for_each(|(c, s)| *c = factor * s);
            }
        }
        (total, columns)
    }
}

impl Fit {
    /// Levels of terms in the runs, each with the information from its prior distribution.
    pub(crate) fn levels(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.model.levels.iter().flat_map(|level| level.logs.iter().map(|x| (*x, level.spread.powi(-2))))
    }

    /// Adds the information from the prior distributions of the levels.
    pub(crate) fn with_levels(&self, mut information: Symmetric) -> Symmetric {
        let first = information.order - self.model.own.len() - self.levels().count();
        for (k, (_, weight)) in self.levels().enumerate() {
            information.set(first + k, first + k, information.get(first + k, first + k) + weight);
        }
        information
    }

    /// Adds the derivatives with respect to Q² from the end values of the angle.
    pub(crate) fn add_ends(&self, gradient: &mut [f64], first: usize) {
        let Some(j) = self.model.index(Term::Quantization) else { return };
        let own = |run: usize| {
            self.model.own.iter().position(|own| own.run == run && own.part == Part::Term(Term::Quantization))
        };
        let before = |level: &&Level| level.part != Part::Term(Term::Quantization);
        let level_at =
            first + self.model.levels.iter().take_while(before).map(|l| l.logs.len()).sum::<usize>();
        for (run, slope) in self.slope_of_ends.iter().enumerate() {
            if let Some(k) = own(run) {
                gradient[first + self.levels().count() + k] += slope;
            } else if let Some(level) = self.model.level(Part::Term(Term::Quantization)) {
                gradient[j] += slope * level.logs[run].exp();
                gradient[level_at + run] += slope * self.model.theta_of(j, run);
            } else {
                gradient[j] += slope;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::model::SeparateTerm;
    use crate::likelihood::summary::Summary;
    use std::sync::Arc;

    /// Changes a parameter by a share of its size, and returns the change.
    type Move = fn(&mut Model, f64) -> f64;

    const TERMS: [Part; 2] = [Part::Term(Term::RandomWalk), Part::Term(Term::RateRandomWalk)];

    fn noise(samples: usize, seed: u64) -> Summary {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let x: Vec<f64> = (0..samples).map(|_| (0..6).map(|_| uniform()).sum()).collect();
        Summary::of(&x, 0.1).unwrap()
    }

    fn joined(records: &[Summary]) -> Bins<'_> {
        let bins =
            |record| Bins::new(record, Arc::new(vec![true; record.density.len()]), Arc::new(Vec::new()));
        Bins::joined(records.iter().map(|record| (bins(record), Vec::new())).collect())
    }

    fn model() -> Model {
        let mut model = Model::new(TERMS.to_vec(), Vec::new());
        model.theta = vec![1.0, 1e-4];
        model.filter = vec![0.2];
        model.levels = vec![Level { part: TERMS[0], logs: vec![0.1, -0.2, 0.05], spread: 0.3 }];
        model.own = vec![SeparateTerm { run: 1, part: TERMS[1], theta: 3e-4 }];
        model
    }

    /// Derivatives with respect to theta, the filter, the levels and the term of one run equal finite differences.
    #[test]
    fn slopes_are_those_of_finite_differences() {
        let records = [noise(6000, 1), noise(4500, 2), noise(5000, 3)];
        let bins = joined(&records);
        let (spectrum, slopes) = model().with_slopes(&bins);
        let step = 1e-5;
        let moved: [Move; 7] = [
            |m, d| (m.theta[0] += d, d).1,
            |m, d| (m.theta[1] += 1e-4 * d, 1e-4 * d).1,
            |m, d| (m.filter[0] += d, d).1,
            |m, d| (m.levels[0].logs[0] += d, d).1,
            |m, d| (m.levels[0].logs[1] += d, d).1,
            |m, d| (m.levels[0].logs[2] += d, d).1,
            |m, d| (m.own[0].theta += 1e-4 * d, 1e-4 * d).1,
        ];
        assert_eq!(slopes.len(), moved.len());
        for (slope, by) in slopes.iter().zip(moved) {
            let (mut up, mut down) = (model(), model());
            let size = by(&mut up, step) - by(&mut down, -step);
            let (up, down) = (up.spectrum(&bins), down.spectrum(&bins));
            let largest = slope.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for bin in 0..bins.len() {
                let expected = (up[bin] - down[bin]) / size / spectrum[bin];
                // A central difference with step 1e-5 has an error of 1e-10 of the largest derivative, and 1e-9 from
                // rounding.
                assert!((slope[bin] - expected).abs() < 1e-6 * largest, "{} {expected}", slope[bin]);
            }
        }
    }

    /// The deviance of runs is the sum of their deviances, plus that of the levels.
    #[test]
    fn deviances_are_added() {
        let records = [noise(6000, 1), noise(4500, 2), noise(5000, 3)];
        let bins = joined(&records);
        let whole = model().at(&bins);
        let each: f64 = (0..3).map(|run| model().of_run(run, &[]).at(&bins.runs[run].0).deviance).sum();
        let levels = (0.01 + 0.04 + 0.0025) / 0.09;
        assert!((whole.deviance - each - levels).abs() < 1e-9 * each.abs());
    }
}
