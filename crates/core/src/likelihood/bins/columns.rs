//! Densities of the parts of a model in the bins.

use crate::likelihood::bins::{Bins, Column, POINTS};
use crate::likelihood::expected::{ModePoint, Part, evaluate, fine_densities, flicker_modes, resonance};
use crate::likelihood::linear::products;
use crate::likelihood::power_law::Mixture;
use crate::terms::Term;
use std::borrow::Cow;
use std::f64::consts::PI;

impl Bins<'_> {
    /// The densities of a part of unit amplitude.
    pub(crate) fn column(&self, part: Part) -> Cow<'_, Column> {
        if let Some(column) = self.term(part) {
            return Cow::Borrowed(column);
        }
        let mut column = self.empty();
        self.fill(part, &mut column);
        Cow::Owned(column)
    }

    /// The densities of a part as means over all bins.
    pub(crate) fn unit(&self, part: impl Into<Part>) -> Vec<f64> {
        let part = part.into();
        if !self.runs.is_empty() {
            return self.runs.iter().flat_map(|(bins, _)| bins.unit(part)).collect();
        }
        self.means(&self.column(part), None)
    }

    /// Means of |H|² over all bins, from its values at the low bins and at the points.
    pub(crate) fn response_means(&self, low: &[f64], high: &[f64]) -> Vec<f64> {
        let Some(rows) = &self.leak else { return self.gathered(low, high) };
        let found = self.gathered(low, high);
        found.iter().zip(rows.chunks_exact(high.len())).map(|(x, row)| x / row.iter().sum::<f64>()).collect()
    }

    /// A column to be filled.
    pub(crate) fn empty(&self) -> Column {
        let low = if self.leak.is_some() { self.len() } else { self.low };
        Column { low: vec![0.0; low], high: vec![0.0; self.fine_points.len()] }
    }

    /// Means over all bins of a column, after a filter if there is one, given by |H|² at the low bins and at the points.
    pub(crate) fn means(&self, column: &Column, response: Option<&(Vec<f64>, Vec<f64>)>) -> Vec<f64> {
        let Some((low, high)) = response else {
            return match self.leak {
                Some(_) => column.low.clone(),
                None => self.gathered(&column.low, &column.high),
            };
        };
        if self.leak.is_some() {
            // Change by the filter in each cell; 0 at the frequency 0, where a term may be infinite.
            let change: Vec<f64> = column.high.iter().zip(high).map(|(c, h)| c * (h - 1.0)).collect();
            let mut means = self.gathered(&[], &change);
            means.iter_mut().zip(&column.low).for_each(|(m, c)| *m += c);
            return means;
        }
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(c, h)| c * h).collect::<Vec<f64>>();
        self.gathered(&product(&column.low, low), &product(&column.high, high))
    }

    /// Means over all bins from values at the low bins and at the points; with missing samples, only at the cells.
    pub(crate) fn gathered(&self, low: &[f64], high: &[f64]) -> Vec<f64> {
        if let Some(rows) = &self.leak {
            return products(rows, high);
        }
        let means = high.chunks_exact(POINTS).map(|x| x.iter().sum::<f64>() / POINTS as f64);
        low.iter().copied().chain(means).collect()
    }

    /// Densities of a part at the points or cells.
    pub(crate) fn densities(&self, part: Part, found: &mut [f64]) {
        fine_densities(part, &self.fine_points, self.record.tau0, found);
    }

    /// Means over all bins of cos 2πk f τ₀ − 1, k = 0 for the first.
    pub(crate) fn cosine_means(&self, k: usize) -> Vec<f64> {
        if !self.runs.is_empty() {
            return self.runs.iter().flat_map(|(bins, _)| bins.cosine_means(k)).collect();
        }
        match self.leak {
            Some(_) => {
                let angle = PI * (k + 1) as f64 * self.spacing as f64 * self.record.tau0;
                self.frequency.iter().map(|f| -2.0 * (angle * f).sin().powi(2)).collect()
            }
            None => self.gathered(&self.cosines_low[k], &self.cosines_high[k]),
        }
    }

    /// The stored column of a term.
    pub(crate) fn term(&self, part: Part) -> Option<&Column> {
        match part {
            Part::Term(term) => self.terms.get(term.index()),
            _ => None,
        }
    }

    /// Writes the densities of a part into an existing column.
    pub(crate) fn fill(&self, part: Part, column: &mut Column) {
        if self.leak.is_some() {
            fine_densities(part, &self.fine_points, self.record.tau0, &mut column.high);
            column.low = self.gathered(&[], &column.high);
            return;
        }
        let blocks = self.blocks();
        if part == Part::Term(Term::BiasInstability) {
            let all = flicker_modes(blocks, self.record.modes.len());
            let length = self.record.block_length();
            for (slot, pair) in column.low.iter_mut().zip(self.edges.windows(2)) {
                let inside = &self.used_modes[pair[0]..pair[1]];
                *slot = length * inside.iter().map(|&k| all[k]).sum::<f64>() / inside.len() as f64;
            }
        } else if let Part::GaussMarkov { time } = part {
            let process = blocks.gauss_markov(time);
            self.mode_means(column, |point| process.density(point));
        } else if let Part::Flicker { exponent, pivot } = part {
            let mixture = Mixture::new(exponent, pivot, self.record.tau0, self.record.duration());
            self.mode_means(column, mixture.at_modes(blocks));
        } else if let Part::Matern { time, smoothness } = part {
            let mixture = Mixture::matern(smoothness, time, self.record.tau0);
            self.mode_means(column, mixture.at_modes(blocks));
        } else if let Part::Resonance { frequency, width } = part {
            self.mode_means(column, |point| resonance(frequency, width, point.frequency));
        } else {
            self.mode_means(column, |point| blocks.density(part, point));
        }
        fine_densities(part, &self.fine_points, self.record.tau0, &mut column.high);
        if part == Part::Term(Term::Quantization) {
            for (slot, point) in column.high.iter_mut().zip(&self.fine_points) {
                *slot += self.mirrored_density(point.frequency);
            }
        }
    }

    /// Mean density that the reflection at both ends adds to quantization noise: the rates on both sides of an end share
    /// the value of the angle there, which no longer cancels. Each end adds 2Q²: the square of twice the value, in half as
    /// many segments as other samples.
    pub(crate) fn mirrored_density(&self, frequency: f64) -> f64 {
        4.0 * (PI * frequency * self.record.tau0).cos().powi(2)
            / (self.record.tau0 * self.record.samples as f64)
    }

    fn mode_means(&self, column: &mut Column, density: impl Fn(&ModePoint) -> f64) {
        let mut densities = vec![0.0; self.mode_points.len()];
        evaluate(&mut densities, &self.mode_points, density);
        for (slot, pair) in column.low.iter_mut().zip(self.mode_starts.windows(2)) {
            let inside = &densities[pair[0]..pair[1]];
            *slot = inside.iter().sum::<f64>() / inside.len() as f64;
        }
    }
}
