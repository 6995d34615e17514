//! The data to which a model is fitted: about 200 means of powers of a channel, with their degrees of freedom.

mod build;
mod columns;
mod edges;
mod products;
mod regressors;

pub(crate) use edges::{first_density, high_ranges, low_edges, median, usable};
pub(crate) use regressors::{ENDS, Products, Regressor};

use crate::likelihood::abscissae::BinAbscissae;
use crate::likelihood::expected::{Blocks, FinePoint, ModePoint};
use crate::likelihood::line::Line;
use crate::likelihood::running_mean::RunningMean;
use crate::likelihood::summary::Summary;
use edges::consecutive_ranges;
use std::sync::Arc;

/// Number of frequencies at which the model is evaluated in a bin of the periodogram.
pub(crate) const POINTS: usize = 8;

/// Largest number of modes in a bin at which a filter with zeros is evaluated.
const BIN_POINTS: usize = 24;

/// Densities of one part of the model with unit amplitude: means over the bins of the modes, and values at the points of
/// the bins of the periodogram, `POINTS` per bin. With missing samples: means over all bins, and values in the cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

/// The binned record, for one mask of the periodogram.
#[derive(Debug, Clone)]
pub(crate) struct Bins<'a> {
    pub record: &'a Summary,
    /// Densities of the periodogram that are used.
    pub mask: Arc<Vec<bool>>,
    /// Number of low bins.
    pub low: usize,
    /// Modes that are used, as numbers minus 1.
    used_modes: Vec<usize>,
    /// First of these modes in each low bin, then the number of modes.
    edges: Vec<usize>,
    /// Mean squares of the modes without regressors.
    low_power: Vec<f64>,
    /// Mean densities of the bins of the periodogram.
    pub high_power: Vec<f64>,
    /// Range of densities of each bin of the periodogram.
    pub ranges: Vec<(usize, usize)>,
    /// Mean frequency of all bins. \[Hz\]
    pub frequency: Vec<f64>,
    /// Degrees of freedom of each bin: for the information of all bins together, and for the distribution of its mean
    /// alone.
    pub freedom: Vec<f64>,
    pub freedom_alone: Vec<f64>,
    /// Share of the degrees of freedom that remains after a running mean, which makes the densities in a bin unequal.
    evenness: Vec<f64>,
    /// Share of the information of a complete record for which the degrees of freedom are set.
    pub information: f64,
    /// Largest number of degrees of freedom, if a discrepancy limits it.
    pub cap: Vec<f64>,
    /// Median density of the periodogram's bins.
    pub scale: f64,
    mode_points: Vec<ModePoint>,
    /// First evaluation point of each low bin, then the number of points.
    mode_starts: Vec<usize>,
    pub fine_points: Vec<FinePoint>,
    /// Frequencies at which filters of known shape are evaluated.
    pub abscissae: Arc<BinAbscissae>,
    /// With missing samples: weights of the cells in the bins, in row order. The evaluation points are then those of the
    /// cells.
    leak: Option<Arc<Vec<f64>>>,
    /// Leakage of excluded lines into the bins because of missing samples.
    pub lines: Vec<f64>,
    /// Columns of the noise terms, in the order of [`TERMS`].
    terms: Arc<Vec<Column>>,
    /// Sample interval of the filter's cosines, in samples: 1 for the whole band, more if its top is left out.
    pub spacing: usize,
    /// cos 2πk f τ₀ · spacing − 1, k = 1 … 6: for the low bins, and for the points.
    pub cosines_low: Arc<Vec<Vec<f64>>>,
    pub cosines_high: Arc<Vec<Vec<f64>>>,
    pub regressors: Arc<Vec<Regressor>>,
    /// With several runs: their bins, the longest run first, each with the regressors of its mean. Fields with one entry
    /// per bin then have the bins of all runs in this order.
    pub runs: Arc<Vec<(Bins<'a>, Vec<usize>)>>,
}

/// Largest number of coefficients of a filter.
pub(crate) const MAX_FILTER: usize = 6;

impl Bins<'_> {
    /// Half width of the narrowest resonance that the evaluation points resolve: their distance.
    pub(crate) fn least_width(&self, frequency: f64) -> f64 {
        if let Some((longest, _)) = self.runs.first() {
            return longest.least_width(frequency);
        }
        let bin = self.frequency.partition_point(|&f| f < frequency).min(self.len().saturating_sub(1));
        let nearest = |bin: usize| (self.frequency[bin] - frequency).abs();
        let bin = if bin > 0 && nearest(bin - 1) < nearest(bin) { bin - 1 } else { bin };
        let apart = if bin < self.low {
            let points = self.mode_starts[bin + 1] - self.mode_starts[bin];
            self.record.mode_frequency(1) * (self.edges[bin + 1] - self.edges[bin]) as f64 / points as f64
        } else {
            let (start, stop) = self.ranges[bin - self.low];
            self.record.frequency(1) * ((stop - start) as f64 / POINTS as f64).max(1.0)
        };
        apart.max(0.5 / self.record.duration())
    }

    /// Number of bins.
    pub(crate) fn len(&self) -> usize {
        self.frequency.len()
    }

    pub(crate) fn blocks(&self) -> Blocks {
        Blocks { samples: self.record.block, count: self.record.blocks, tau0: self.record.tau0 }
    }

    /// Bin, and number minus 1, of each used mode below the band of the periodogram.
    pub(crate) fn low_modes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let last = self.record.low_modes();
        let of_bin =
            |bin: usize| self.used_modes[self.edges[bin]..self.edges[bin + 1]].iter().map(move |&k| (bin, k));
        (0..self.low).flat_map(of_bin).filter(move |&(_, k)| k < last)
    }

    /// Frequencies of modes of a low bin, thinned if there are many. \[Hz\]
    pub(crate) fn frequencies_of_modes(&self, bin: usize) -> impl Iterator<Item = f64> + '_ {
        let modes = &self.used_modes[self.edges[bin]..self.edges[bin + 1]];
        let points = self.number_of_frequencies(bin);
        (0..points)
            .map(move |i| self.record.mode_frequency(modes[(2 * i + 1) * modes.len() / (2 * points)] + 1))
    }

    /// Number of [`Self::frequencies_of_modes`].
    pub(crate) fn number_of_frequencies(&self, bin: usize) -> usize {
        (self.edges[bin + 1] - self.edges[bin]).min(BIN_POINTS)
    }

    /// Mean of a function of the frequency over the modes of a low bin.
    pub(crate) fn mean_of_modes(&self, bin: usize, function: impl Fn(f64) -> f64) -> f64 {
        let (sum, count) =
            self.frequencies_of_modes(bin).fold((0.0, 0), |(sum, count), f| (sum + function(f), count + 1));
        sum / f64::from(count)
    }

    /// Reduces the degrees of freedom of means of unequal densities after a running mean, by the factor (Σw)² / (n Σw²).
    pub(crate) fn see_mean(&mut self, mean: RunningMean) {
        let left = |powers: &mut dyn Iterator<Item = f64>| {
            let (count, sum, squares) =
                powers.fold((0.0, 0.0, 0.0), |(n, sum, squares), w| (n + 1.0, sum + w, squares + w * w));
            sum * sum / (count * squares)
        };
        let low = (0..self.low)
            .map(|bin| left(&mut self.frequencies_of_modes(bin).map(|f| mean.log_power(f).exp())));
        let high = self.ranges.iter().map(|&(start, stop)| {
            let there = (start..stop).filter(|&k| self.mask[k]);
            left(&mut there.map(|k| mean.log_power(self.record.frequency(k)).exp()))
        });
        self.evenness = low.chain(high).collect();
        for (i, left) in self.evenness.iter().enumerate() {
            self.freedom[i] *= left;
            self.freedom_alone[i] *= left;
        }
    }

    /// Whether samples are missing, so that a matrix describes the observed density.
    pub(crate) fn leaks(&self) -> bool {
        self.leak.is_some()
    }

    /// Values of the bins of the periodogram at each density; 0 at unused densities.
    pub(crate) fn spread(&self, values: &[f64]) -> Vec<f64> {
        let mut found = vec![0.0; self.record.density.len()];
        for (&(start, stop), x) in self.ranges.iter().zip(&values[self.low..]) {
            for k in (start..stop).filter(|&k| self.mask[k]) {
                found[k] = *x;
            }
        }
        found
    }

    /// Adds the leakage of lines to the bins.
    pub(crate) fn see(&mut self, lines: &[Line]) {
        let (Some(rows), Some(masked)) = (&self.leak, &self.record.masked) else { return };
        let spacing = self.record.frequency(1);
        let mut sums = vec![0.0; self.frequency.len()];
        for line in lines {
            let power = 0.25 * line.amplitude * line.amplitude;
            let cell = masked.cells.cell_of(line.frequency);
            let rows = rows.chunks_exact(masked.cells.centres.len());
            for (sum, row) in sums[..self.low].iter_mut().zip(rows) {
                *sum += power * row[cell] / masked.cells.width(cell);
            }
            for (sum, &(start, stop)) in sums[self.low..].iter_mut().zip(&self.ranges) {
                let there: Vec<usize> = (start..stop).filter(|&k| self.mask[k]).collect();
                *sum += power * masked.line_density(&consecutive_ranges(&there), line.frequency, spacing)
                    / spacing;
            }
        }
        self.lines = sums;
    }

    /// Sets the degrees of freedom of the bins of the periodogram for a share of the information of a complete record.
    pub(crate) fn inform(&mut self, share: f64) {
        self.information = share;
        let record = self.record;
        let shares = self.evenness[self.low..].iter().map(|left| share * left);
        for ((freedom, &(start, stop)), share) in
            self.freedom[self.low..].iter_mut().zip(&self.ranges).zip(shares)
        {
            let count = (start..stop).filter(|&k| self.mask[k]).count();
            *freedom = 2.0 * count as f64 * record.samples as f64 / record.segment as f64 * share;
        }
    }

    /// Degrees of freedom for the fit.
    pub(crate) fn weight(&self, bin: usize) -> f64 {
        1.0 / (1.0 / self.freedom[bin] + 1.0 / self.cap[bin])
    }

    /// The powers without regressors.
    pub(crate) fn plain_powers(&self) -> Vec<f64> {
        if self.runs.is_empty() {
            return self.powers(&self.residual_power(&self.products(&[]), &[]));
        }
        self.runs.iter().flat_map(|(bins, _)| bins.plain_powers()).collect()
    }

    /// Number of runs.
    pub(crate) fn count(&self) -> usize {
        self.runs.len().max(1)
    }

    /// Bins by the band of their frequency, with this number of bands per decade; bins of several runs together.
    pub(crate) fn bands(&self, per_decade: f64) -> Vec<(i64, Vec<usize>)> {
        let number = |bin: usize| {
            (per_decade * (self.frequency[bin] / self.frequency[0]).log10() + 1e-9).floor() as i64
        };
        let mut found: Vec<(i64, Vec<usize>)> = Vec::new();
        let mut order: Vec<usize> = (0..self.len()).collect();
        if !self.runs.is_empty() {
            order.sort_by(|&a, &b| self.frequency[a].total_cmp(&self.frequency[b]));
        }
        for bin in order {
            match found.last_mut() {
                Some((last, bins)) if *last == number(bin) => bins.push(bin),
                _ => found.push((number(bin), vec![bin])),
            }
        }
        found
    }

    /// Measured powers of all bins.
    pub(crate) fn powers(&self, low: &[f64]) -> Vec<f64> {
        low.iter().chain(&self.high_power).copied().collect()
    }

    /// The mean powers of the periodogram's bins in each eighth of the record.
    pub(crate) fn parts(&self) -> Vec<Vec<f64>> {
        let mean = |part: &Vec<f64>, &(start, stop): &(usize, usize)| {
            let there = (start..stop).filter(|&k| self.mask[k]);
            let count = there.clone().count() as f64;
            there.map(|k| part[k]).sum::<f64>() / count
        };
        self.record
            .parts
            .iter()
            .map(|part| self.ranges.iter().map(|range| mean(part, range)).collect())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::edges::{high_edges, modes_in_use};
    use super::*;

    #[test]
    fn edges_cover_every_mode_and_density_once() {
        for samples in [256, 1000, 4096, 40_000] {
            let x: Vec<f64> = (0..samples).map(|i| ((i * 7919) % 1013) as f64).collect();
            let record = Summary::of(&x, 0.01).unwrap();
            let mut mask = vec![true; record.density.len()];
            let used_modes = modes_in_use(&record, &mask);
            let edges = low_edges(&record, &used_modes);
            assert_eq!(
                (used_modes.len(), edges[0], edges[edges.len() - 1]),
                (record.modes.len(), 0, record.modes.len())
            );
            assert!(edges.windows(2).all(|p| p[1] > p[0]));
            let high = high_edges(&record);
            if samples <= 4096 {
                assert!(high.is_empty());
                mask.fill(false);
                assert_eq!(modes_in_use(&record, &mask).len(), samples / 8);
                continue;
            }
            assert!(high.windows(2).all(|p| p[0].1 == p[1].0));
            assert_eq!(high[high.len() - 1].1, record.segment / 2);
        }
    }

    #[test]
    fn the_mirror_adds_what_the_model_says() {
        // Each record has one end value of 1; the contributions of both ends are independent and add up.
        let (n, tau0) = (40_000, 0.01);
        let mut first = vec![0.0; n];
        first[0] = -1.0 / tau0;
        let mut last = vec![0.0; n];
        last[n - 1] = 1.0 / tau0;
        let [first, last] = [first, last].map(|x| Summary::of(&x, tau0).unwrap());
        let bins = Bins::new(&first, Arc::new(vec![true; first.density.len()]), Arc::new(Vec::new()));
        for k in [8, 20, 100, 300] {
            let (got, model) =
                (first.density[k] + last.density[k], bins.mirrored_density(first.frequency(k)));
            assert!((got / model - 1.0).abs() < 2e-3, "{got} instead of {model} at {k}");
        }
    }

    #[test]
    fn medians() {
        assert_eq!(
            [median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])].map(f64::to_bits),
            [2.0, 2.5].map(f64::to_bits)
        );
    }
}
