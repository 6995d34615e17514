//! The numbers that a model is compared with: some 200 means of powers of a channel, with their degrees of freedom.

mod edges;

pub(crate) use edges::{first_density, high_ranges, low_edges, median, usable};

use crate::likelihood::expected::{Blocks, FinePoint, ModePoint, Part, TERMS, fine_densities, flicker_modes};
use crate::likelihood::linear::products;
use crate::likelihood::lines::Line;
use crate::likelihood::pass::Summary;
use crate::likelihood::power_law::Mixture;
use crate::likelihood::running_mean::RunningMean;
use crate::terms::Term;
use edges::{high_edges, modes_kept, spacing_of, stretches_of};
use std::f64::consts::PI;
use std::sync::Arc;

/// Frequencies at which the model is evaluated in a bin of the periodogram, and of the modes.
pub(crate) const POINTS: usize = 8;
const MODE_POINTS: usize = 4;

/// Modes of a bin at which a filter with zeros is evaluated, at most.
const BIN_POINTS: usize = 24;

/// Least share of unmasked densities in a bin, and their least number.
const LEAST_SHARE: f64 = 0.15;
pub(crate) const LEAST_COUNT: f64 = 2.0;

/// Lowest bins of a run, from which slow regressors take most.
const LOWEST: usize = 4;

/// Half a bin of width more, for every stretch of a bin: the law of the mean of overlapping, tapered densities.
const EDGE: f64 = 0.5;

/// Regressors: curves that the mean of the record may follow.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Regressor {
    /// Cosine modes.
    pub modes: Vec<f64>,
    /// Frequency of a cosine whose sine is the next regressor. \[Hz\]
    pub line: Option<f64>,
}

impl Regressor {
    pub(crate) fn of_modes(modes: Vec<f64>) -> Self {
        Self { modes, line: None }
    }
}

/// The regressors that are the end values of the angle; quantization noise has them, with the variance Q².
pub(crate) const ENDS: [usize; 2] = [0, 1];

/// Sums over the modes of each bin of products of regressors and of the record, for one set of regressors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Products {
    pub count: usize,
    /// Whether each is an end value of the angle.
    pub ends: Vec<bool>,
    /// `count`² a bin.
    pub squares: Vec<f64>,
    /// `count` a bin.
    pub with_record: Vec<f64>,
}

/// Densities of one part of the model of unit amplitude: means over the bins of the modes, and at the points of the bins
/// of the periodogram, `POINTS` a bin. With missing samples: means over all bins, and in the cells.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    pub low: Vec<f64>,
    pub high: Vec<f64>,
}

/// The binned record, for one mask of the periodogram.
#[derive(Debug, Clone)]
pub(crate) struct Bins<'a> {
    pub record: &'a Summary,
    /// Densities of the periodogram that count.
    pub mask: Arc<Vec<bool>>,
    /// Numbers of low bins.
    pub low: usize,
    /// Modes that count, less 1.
    kept: Vec<usize>,
    /// First of them of each low bin, and one past the last.
    edges: Vec<usize>,
    /// Mean squares of the modes without regressors.
    low_power: Vec<f64>,
    /// Mean densities of the bins of the periodogram.
    pub high_power: Vec<f64>,
    /// Range of densities of each bin of the periodogram.
    pub ranges: Vec<(usize, usize)>,
    /// Mean frequency of all bins. \[Hz\]
    pub frequency: Vec<f64>,
    /// Degrees of freedom: information, and law of a single mean.
    pub freedom: Vec<f64>,
    pub freedom_alone: Vec<f64>,
    /// Share of them that a running mean leaves: its densities in a bin are unequal.
    evenness: Vec<f64>,
    /// Degrees of freedom that a discrepancy leaves at most.
    pub cap: Vec<f64>,
    /// Median density of the periodogram's bins.
    pub scale: f64,
    mode_points: Vec<ModePoint>,
    /// First of its points, for each low bin and one past the last.
    mode_starts: Vec<usize>,
    pub fine_points: Vec<FinePoint>,
    /// With missing samples: weights of the cells in the bins, row after row. The points are those of the cells.
    leak: Option<Arc<Vec<f64>>>,
    /// What lines that were left out add to the bins through missing samples.
    pub lines: Vec<f64>,
    /// Columns of the noise terms, in the order of [`TERMS`].
    terms: Arc<Vec<Column>>,
    /// Samples whose interval is that of the filter's cosines: 1 with a whole band, more where its top is left out.
    pub spacing: usize,
    /// cos 2πk f τ₀ · spacing − 1, k = 1 … 6: of the low bins, of the points.
    pub cosines_low: Arc<Vec<Vec<f64>>>,
    pub cosines_high: Arc<Vec<Vec<f64>>>,
    pub regressors: Arc<Vec<Regressor>>,
    /// Of several runs: their bins, the longest run first, each with the regressors that its mean follows. All that has a
    /// number for each bin is then that of all runs, one after the other.
    pub runs: Arc<Vec<(Bins<'a>, Vec<usize>)>>,
}

/// Coefficients of a filter, at most.
pub(crate) const MOST_FILTER: usize = 6;

impl<'a> Bins<'a> {
    pub(crate) fn new(record: &'a Summary, mask: Arc<Vec<bool>>, regressors: Arc<Vec<Regressor>>) -> Self {
        let blocks = Blocks { samples: record.block, count: record.blocks, tau0: record.tau0 };
        let kept = modes_kept(record, &mask);
        let edges = low_edges(record, &kept);
        let low = edges.len() - 1;
        let mut mode_points = Vec::new();
        let mut mode_starts = vec![0];
        for pair in edges.windows(2) {
            let count = pair[1] - pair[0];
            let points = count.min(MODE_POINTS);
            for i in 0..points {
                let at = pair[0] + ((i as f64 + 0.5) * count as f64 / points as f64) as usize;
                mode_points.push(blocks.point(kept[at] + 1));
            }
            mode_starts.push(mode_points.len());
        }
        let low_power = mean_squares(record, &kept, &edges);
        let middle = |p: &[usize]| {
            let inside = &kept[p[0]..p[1]];
            match record.masked {
                Some(_) => {
                    inside.iter().map(|&k| record.mode_frequency(k + 1)).sum::<f64>() / inside.len() as f64
                }
                None => record.mode_frequency(1) * mean_mode(inside),
            }
        };
        let mut frequency: Vec<f64> = edges.windows(2).map(middle).collect();
        let mut freedom: Vec<f64> = edges.windows(2).map(|p| (p[1] - p[0]) as f64).collect();
        let mut freedom_alone = freedom.clone();
        let (mut high_power, mut ranges, mut fine_points) = (Vec::new(), Vec::new(), Vec::new());
        let share = record.samples as f64 / record.segment as f64;
        let mut all_stretches = Vec::new();
        for (start, stop) in high_edges(record) {
            let there: Vec<usize> = (start..stop).filter(|&k| mask[k]).collect();
            let count = there.len();
            if (count as f64) < (LEAST_SHARE * (stop - start) as f64).max(LEAST_COUNT) {
                continue;
            }
            let stretches = 1 + there.windows(2).filter(|p| p[1] > p[0] + 1).count();
            all_stretches.push(stretches_of(&there));
            high_power.push(there.iter().map(|&k| record.density[k]).sum::<f64>() / count as f64);
            frequency.push(there.iter().map(|&k| record.frequency(k)).sum::<f64>() / count as f64);
            let (together, alone) = match &record.masked {
                Some(masked) => (masked.share(record.samples), masked.freedom_left(count)),
                None => (1.0, 1.0),
            };
            freedom.push(2.0 * count as f64 * share * together);
            freedom_alone.push(2.0 * (count as f64 + EDGE * stretches as f64) * share * alone);
            ranges.push((start, stop));
            for i in 0..if record.masked.is_some() { 0 } else { POINTS } {
                let at = ((i as f64 + 0.5) / POINTS as f64 * count as f64) as usize;
                let k = there[at.min(count - 1)];
                fine_points.push(FinePoint::new(record.frequency(k), record.tau0, record.segment));
            }
        }
        let mut leak = None;
        if let Some(masked) = &record.masked {
            leak = Some(Arc::new(masked.matrix(&all_stretches, record.frequency(1))));
            // Cells are narrow, and what the taper smears is in the matrix.
            fine_points = masked.cells.at.iter().map(|&f| FinePoint::narrow(f, record.tau0)).collect();
        }
        let scale = if high_power.is_empty() { median(&low_power) } else { median(&high_power) };
        let spacing = spacing_of(record, &mask, &kept);
        let interval = spacing as f64 * record.tau0;
        let at_points: Vec<f64> = fine_points.iter().map(|p| p.frequency).collect();
        let mut bins = Self {
            record,
            mask,
            low,
            spacing,
            cosines_low: Arc::new(cosines(&frequency[..low], interval)),
            cosines_high: Arc::new(cosines(&at_points, interval)),
            cap: vec![f64::INFINITY; frequency.len()],
            evenness: vec![1.0; frequency.len()],
            kept,
            edges,
            low_power,
            high_power,
            ranges,
            frequency,
            freedom,
            freedom_alone,
            scale,
            mode_points,
            mode_starts,
            fine_points,
            leak,
            lines: Vec::new(),
            terms: Arc::new(Vec::new()),
            regressors,
            runs: Arc::new(Vec::new()),
        };
        let mut terms = TERMS.map(|part| bins.column(part)).to_vec();
        if let Some(masked) = &record.masked {
            for (k, column) in terms.iter_mut().enumerate() {
                column.low = masked.column(k, &all_stretches);
            }
        }
        bins.terms = Arc::new(terms);
        bins
    }

    /// The bins of several runs, the longest one first, each with the regressors that its mean follows.
    pub(crate) fn joined(mut runs: Vec<(Self, Vec<usize>)>) -> Self {
        let spacing = runs.iter().map(|(bins, _)| bins.spacing).min().unwrap_or(1);
        for (bins, _) in &mut runs {
            bins.respaced(spacing);
        }
        let scales: Vec<f64> = runs.iter().map(|(bins, _)| bins.scale).collect();
        let all =
            |of: &dyn Fn(&Self) -> &Vec<f64>| runs.iter().flat_map(|(bins, _)| of(bins).clone()).collect();
        let mut bins = Self {
            frequency: all(&|bins| &bins.frequency),
            freedom: all(&|bins| &bins.freedom),
            freedom_alone: all(&|bins| &bins.freedom_alone),
            cap: all(&|bins| &bins.cap),
            scale: median(&scales),
            ..runs[0].0.clone()
        };
        bins.runs = Arc::new(runs);
        bins
    }

    /// With another interval of the cosines of the filter.
    fn respaced(&mut self, spacing: usize) {
        if spacing == self.spacing {
            return;
        }
        self.spacing = spacing;
        let interval = spacing as f64 * self.record.tau0;
        let at_points: Vec<f64> = self.fine_points.iter().map(|p| p.frequency).collect();
        self.cosines_low = Arc::new(cosines(&self.frequency[..self.low], interval));
        self.cosines_high = Arc::new(cosines(&at_points, interval));
    }

    /// The same bins of a record with other modes.
    pub(crate) fn of_record<'b>(&self, record: &'b Summary) -> Bins<'b>
    where
        'a: 'b,
    {
        let mut bins: Bins<'b> = self.clone();
        bins.record = record;
        bins.low_power = mean_squares(record, &bins.kept, &bins.edges);
        bins
    }

    /// Half width of the narrowest resonance that the points at which densities are evaluated can show: their distance.
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

    /// The densities of a part of unit amplitude.
    pub(crate) fn column(&self, part: Part) -> Column {
        if let Some(column) = self.term(part) {
            return column.clone();
        }
        let mut column = self.empty();
        self.fill(part, &mut column);
        column
    }

    /// The same as means over all bins.
    pub(crate) fn unit(&self, part: impl Into<Part>) -> Vec<f64> {
        let part = part.into();
        if !self.runs.is_empty() {
            return self.runs.iter().flat_map(|(bins, _)| bins.unit(part)).collect();
        }
        self.means(&self.column(part), None)
    }

    /// |H|² as means over all bins, from its values at the low bins and at the points.
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

    /// Means over all bins of a column, behind a filter if there is one: |H|² at the low bins and at the points.
    pub(crate) fn means(&self, column: &Column, response: Option<&(Vec<f64>, Vec<f64>)>) -> Vec<f64> {
        let Some((low, high)) = response else {
            return match self.leak {
                Some(_) => column.low.clone(),
                None => self.gathered(&column.low, &column.high),
            };
        };
        if self.leak.is_some() {
            // What the filter changes, cell by cell; nothing at the frequency 0, where a term has no limit.
            let change: Vec<f64> = column.high.iter().zip(high).map(|(c, h)| c * (h - 1.0)).collect();
            let mut means = self.gathered(&[], &change);
            means.iter_mut().zip(&column.low).for_each(|(m, c)| *m += c);
            return means;
        }
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(c, h)| c * h).collect::<Vec<f64>>();
        self.gathered(&product(&column.low, low), &product(&column.high, high))
    }

    /// Means over all bins from values at the low bins and at the points; with missing samples, at the cells alone.
    pub(crate) fn gathered(&self, low: &[f64], high: &[f64]) -> Vec<f64> {
        if let Some(rows) = &self.leak {
            return products(rows, high);
        }
        let means = high.chunks_exact(POINTS).map(|x| x.iter().sum::<f64>() / POINTS as f64);
        low.iter().copied().chain(means).collect()
    }

    /// Bin, and number less 1, of every mode that counts below the band of the periodogram.
    pub(crate) fn low_modes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let last = self.record.low_modes();
        let of_bin =
            |bin: usize| self.kept[self.edges[bin]..self.edges[bin + 1]].iter().map(move |&k| (bin, k));
        (0..self.low).flat_map(of_bin).filter(move |&(_, k)| k < last)
    }

    /// Modes of a low bin, some of many. \[Hz\]
    fn frequencies_of_modes(&self, bin: usize) -> impl Iterator<Item = f64> + '_ {
        let modes = &self.kept[self.edges[bin]..self.edges[bin + 1]];
        let points = modes.len().min(BIN_POINTS);
        (0..points)
            .map(move |i| self.record.mode_frequency(modes[(2 * i + 1) * modes.len() / (2 * points)] + 1))
    }

    /// Mean of a function of the frequency over the modes of a low bin.
    pub(crate) fn mean_of_modes(&self, bin: usize, function: impl Fn(f64) -> f64) -> f64 {
        let (sum, count) =
            self.frequencies_of_modes(bin).fold((0.0, 0), |(sum, count), f| (sum + function(f), count + 1));
        sum / f64::from(count)
    }

    /// Takes the degrees of freedom that means of unequal densities behind a running mean lack: (Σw)² of n Σw² are left.
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

    /// Whether samples are missing, so that a matrix says what is seen of a density.
    pub(crate) fn leaks(&self) -> bool {
        self.leak.is_some()
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

    /// Values of the bins of the periodogram at each density, 0 where it is not used.
    pub(crate) fn spread(&self, values: &[f64]) -> Vec<f64> {
        let mut found = vec![0.0; self.record.density.len()];
        for (&(start, stop), x) in self.ranges.iter().zip(&values[self.low..]) {
            for k in (start..stop).filter(|&k| self.mask[k]) {
                found[k] = *x;
            }
        }
        found
    }

    /// Adds what lines leak into the bins.
    pub(crate) fn see(&mut self, lines: &[Line]) {
        let (Some(rows), Some(masked)) = (&self.leak, &self.record.masked) else { return };
        let spacing = self.record.frequency(1);
        let mut sums = vec![0.0; self.frequency.len()];
        for line in lines {
            let power = 0.25 * line.amplitude * line.amplitude;
            let cell = masked.cells.of(line.frequency);
            let rows = rows.chunks_exact(masked.cells.at.len());
            for (sum, row) in sums[..self.low].iter_mut().zip(rows) {
                *sum += power * row[cell] / masked.cells.width(cell);
            }
            for (sum, &(start, stop)) in sums[self.low..].iter_mut().zip(&self.ranges) {
                let there: Vec<usize> = (start..stop).filter(|&k| self.mask[k]).collect();
                *sum += power * masked.of_line(&stretches_of(&there), line.frequency, spacing) / spacing;
            }
        }
        self.lines = sums;
    }

    /// Degrees of freedom of the bins of the periodogram for a share of the information of a complete record.
    pub(crate) fn inform(&mut self, share: f64) {
        let record = self.record;
        let shares = self.evenness[self.low..].iter().map(|left| share * left);
        for ((freedom, &(start, stop)), share) in
            self.freedom[self.low..].iter_mut().zip(&self.ranges).zip(shares)
        {
            let count = (start..stop).filter(|&k| self.mask[k]).count();
            *freedom = 2.0 * count as f64 * record.samples as f64 / record.segment as f64 * share;
        }
    }

    /// The column of a term, which is kept.
    pub(crate) fn term(&self, part: Part) -> Option<&Column> {
        match part {
            Part::Term(term) => self.terms.get(term.index()),
            _ => None,
        }
    }

    /// The same into a column that is there.
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
                let inside = &self.kept[pair[0]..pair[1]];
                *slot = length * inside.iter().map(|&k| all[k]).sum::<f64>() / inside.len() as f64;
            }
        } else if let Part::GaussMarkov { time } = part {
            let process = blocks.gauss_markov(time);
            self.mode_means(column, |point| process.density(point));
        } else if let Part::Flicker { exponent, pivot } = part {
            let mixture = Mixture::new(exponent, pivot, self.record.tau0, self.record.duration());
            self.mode_means(column, mixture.at_modes(blocks));
        } else {
            self.mode_means(column, |point| blocks.density(part, point));
        }
        fine_densities(part, &self.fine_points, self.record.tau0, &mut column.high);
        if part == Part::Term(Term::Quantization) {
            for (slot, point) in column.high.iter_mut().zip(&self.fine_points) {
                *slot += self.of_mirror(point.frequency);
            }
        }
    }

    /// Mean density that the mirror at both ends adds to quantization noise: the rates on either side of an end share the
    /// value of the angle there, which no longer cancels. Of each end 2Q²: the square of twice the value, in half as many
    /// segments as another sample is in.
    pub(crate) fn of_mirror(&self, frequency: f64) -> f64 {
        4.0 * (PI * frequency * self.record.tau0).cos().powi(2)
            / (self.record.tau0 * self.record.samples as f64)
    }

    fn mode_means(&self, column: &mut Column, density: impl Fn(&ModePoint) -> f64) {
        for (slot, pair) in column.low.iter_mut().zip(self.mode_starts.windows(2)) {
            let points = &self.mode_points[pair[0]..pair[1]];
            *slot = points.iter().map(&density).sum::<f64>() / points.len() as f64;
        }
    }

    /// Degrees of freedom that count in the fit.
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

    /// Of each run, the sums that a model with these regressors needs; of several runs, with their own.
    pub(crate) fn products_of(&self, used: &[usize]) -> Vec<Products> {
        if self.runs.is_empty() {
            return vec![self.products(used)];
        }
        self.runs.iter().map(|(bins, own)| bins.products(own)).collect()
    }

    /// Number of runs.
    pub(crate) fn count(&self) -> usize {
        self.runs.len().max(1)
    }

    /// Bins by the band of their frequency, so many in a decade; of several runs together.
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

    /// Share of the degrees of freedom that a discrepancy leaves of the lowest bins of a run, which begin at `first`.
    pub(crate) fn left_of(&self, first: usize, low: usize) -> f64 {
        let lowest = first..first + low.min(LOWEST);
        let weights: f64 = lowest.clone().map(|bin| self.weight(bin)).sum();
        weights / lowest.map(|bin| self.freedom[bin]).sum::<f64>()
    }

    /// The sums that a model with these regressors needs.
    pub(crate) fn products(&self, used: &[usize]) -> Products {
        let count = used.len();
        let mut squares = Vec::with_capacity(self.low * count * count);
        let mut with_record = Vec::with_capacity(self.low * count);
        for pair in self.edges.windows(2) {
            let inside = &self.kept[pair[0]..pair[1]];
            for &i in used {
                let own = &self.regressors[i].modes;
                for &j in used {
                    let other = &self.regressors[j].modes;
                    squares.push(inside.iter().map(|&k| own[k] * other[k]).sum());
                }
                with_record.push(inside.iter().map(|&k| own[k] * self.record.modes[k]).sum());
            }
        }
        let ends = used.iter().map(|k| ENDS.contains(k)).collect();
        Products { count, ends, squares, with_record }
    }

    /// Mean squares of the modes without what the regressors explain.
    pub(crate) fn residual_power(&self, products: &Products, beta: &[f64]) -> Vec<f64> {
        let n = products.count;
        let mut power = self.low_power.clone();
        if n == 0 {
            return power;
        }
        for (bin, slot) in power.iter_mut().enumerate() {
            let modes = (self.edges[bin + 1] - self.edges[bin]) as f64;
            let mut change = 0.0;
            for i in 0..n {
                change -= 2.0 * beta[i] * products.with_record[bin * n + i];
                for j in 0..n {
                    change += beta[i] * beta[j] * products.squares[(bin * n + i) * n + j];
                }
            }
            *slot = (*slot + change / modes).max(1e-14 * *slot);
        }
        power
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

/// cos 2πk f Δ − 1, k = 1 … 6, at frequencies.
fn cosines(at: &[f64], interval: f64) -> Vec<Vec<f64>> {
    let cosine = |f: f64, k: usize| -2.0 * (PI * k as f64 * f * interval).sin().powi(2);
    (1..=MOST_FILTER).map(|k| at.iter().map(|&f| cosine(f, k)).collect()).collect()
}

fn mean_squares(record: &Summary, kept: &[usize], edges: &[usize]) -> Vec<f64> {
    let mean = |p: &[usize]| {
        kept[p[0]..p[1]].iter().map(|&k| record.modes[k].powi(2)).sum::<f64>() / (p[1] - p[0]) as f64
    };
    edges.windows(2).map(mean).collect()
}

fn mean_mode(kept: &[usize]) -> f64 {
    1.0 + kept.iter().sum::<usize>() as f64 / kept.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_cover_every_mode_and_density_once() {
        for samples in [256, 1000, 4096, 40_000] {
            let x: Vec<f64> = (0..samples).map(|i| ((i * 7919) % 1013) as f64).collect();
            let record = Summary::of(&x, 0.01).unwrap();
            let mut mask = vec![true; record.density.len()];
            let kept = modes_kept(&record, &mask);
            let edges = low_edges(&record, &kept);
            assert_eq!(
                (kept.len(), edges[0], edges[edges.len() - 1]),
                (record.modes.len(), 0, record.modes.len())
            );
            assert!(edges.windows(2).all(|p| p[1] > p[0]));
            let high = high_edges(&record);
            if samples <= 4096 {
                assert!(high.is_empty());
                mask.fill(false);
                assert_eq!(modes_kept(&record, &mask).len(), samples / 8);
                continue;
            }
            assert!(high.windows(2).all(|p| p[0].1 == p[1].0));
            assert_eq!(high[high.len() - 1].1, record.segment / 2);
        }
    }

    #[test]
    fn the_mirror_adds_what_the_model_says() {
        // Both end values of the angle are 1, one in each record: with all others they add up, as they are independent.
        let (n, tau0) = (40_000, 0.01);
        let mut first = vec![0.0; n];
        first[0] = -1.0 / tau0;
        let mut last = vec![0.0; n];
        last[n - 1] = 1.0 / tau0;
        let [first, last] = [first, last].map(|x| Summary::of(&x, tau0).unwrap());
        let bins = Bins::new(&first, Arc::new(vec![true; first.density.len()]), Arc::new(Vec::new()));
        for k in [8, 20, 100, 300] {
            let (got, model) = (first.density[k] + last.density[k], bins.of_mirror(first.frequency(k)));
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
