//! Construction of the bins of a record.

use crate::likelihood::bins::edges::{
    MIN_COUNT, consecutive_ranges, high_edges, low_edges, median, modes_in_use, spacing_of,
};
use crate::likelihood::bins::regressors::Regressor;
use crate::likelihood::bins::{Bins, MAX_FILTER, POINTS};
use crate::likelihood::expected::{Blocks, FinePoint, TERMS};
use crate::likelihood::summary::Summary;
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of frequencies at which the model is evaluated in a bin of the modes.
const MODE_POINTS: usize = 4;

/// Smallest share of unmasked densities in a bin.
const MIN_SHARE: f64 = 0.15;

/// Width that is added per stretch of a bin, in densities, for the distribution of the mean of overlapping, tapered
/// densities.
const ADDED_WIDTH: f64 = 0.5;

impl<'a> Bins<'a> {
    pub(crate) fn new(record: &'a Summary, mask: Arc<Vec<bool>>, regressors: Arc<Vec<Regressor>>) -> Self {
        let blocks = Blocks { samples: record.block, count: record.blocks, tau0: record.tau0 };
        let used_modes = modes_in_use(record, &mask);
        let edges = low_edges(record, &used_modes);
        let low = edges.len() - 1;
        let mut mode_points = Vec::new();
        let mut mode_starts = vec![0];
        for pair in edges.windows(2) {
            let count = pair[1] - pair[0];
            let points = count.min(MODE_POINTS);
            for i in 0..points {
                let at = pair[0] + ((i as f64 + 0.5) * count as f64 / points as f64) as usize;
                mode_points.push(blocks.point(used_modes[at] + 1));
            }
            mode_starts.push(mode_points.len());
        }
        let low_power = mean_squares(record, &used_modes, &edges);
        let middle = |p: &[usize]| {
            let inside = &used_modes[p[0]..p[1]];
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
            if (count as f64) < (MIN_SHARE * (stop - start) as f64).max(MIN_COUNT) {
                continue;
            }
            let stretches = 1 + there.windows(2).filter(|p| p[1] > p[0] + 1).count();
            all_stretches.push(consecutive_ranges(&there));
            high_power.push(there.iter().map(|&k| record.density[k]).sum::<f64>() / count as f64);
            frequency.push(there.iter().map(|&k| record.frequency(k)).sum::<f64>() / count as f64);
            let (together, alone) = match &record.masked {
                Some(masked) => (masked.share(record.samples), masked.freedom_share(count)),
                None => (1.0, 1.0),
            };
            freedom.push(2.0 * count as f64 * share * together);
            freedom_alone.push(2.0 * (count as f64 + ADDED_WIDTH * stretches as f64) * share * alone);
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
            // Cells are narrow, and the matrix includes the smearing by the taper.
            fine_points = masked.cells.centres.iter().map(|&f| FinePoint::narrow(f, record.tau0)).collect();
        }
        let scale = if high_power.is_empty() { median(&low_power) } else { median(&high_power) };
        let spacing = spacing_of(record, &mask, &used_modes);
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
            information: record.masked.as_ref().map_or(1.0, |masked| masked.share(record.samples)),
            used_modes,
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
            abscissae: Arc::default(),
            leak,
            lines: Vec::new(),
            terms: Arc::new(Vec::new()),
            regressors,
            runs: Arc::new(Vec::new()),
        };
        let mut terms = TERMS.map(|part| bins.column(part).into_owned()).to_vec();
        if let Some(masked) = &record.masked {
            for (k, column) in terms.iter_mut().enumerate() {
                column.low = masked.column(k, &all_stretches);
            }
        }
        bins.terms = Arc::new(terms);
        bins
    }

    /// The bins of several runs, the longest run first, each with the regressors of its mean.
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

    /// Changes the interval of the cosines of the filter.
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

    /// The same bins for a record with other modes.
    pub(crate) fn of_record<'b>(&self, record: &'b Summary) -> Bins<'b>
    where
        'a: 'b,
    {
        let mut bins: Bins<'b> = self.clone();
        bins.record = record;
        bins.low_power = mean_squares(record, &bins.used_modes, &bins.edges);
        bins
    }
}

/// cos 2πk f Δ − 1, k = 1 … 6, at frequencies.
fn cosines(at: &[f64], interval: f64) -> Vec<Vec<f64>> {
    let cosine = |f: f64, k: usize| -2.0 * (PI * k as f64 * f * interval).sin().powi(2);
    (1..=MAX_FILTER).map(|k| at.iter().map(|&f| cosine(f, k)).collect()).collect()
}

fn mean_squares(record: &Summary, used_modes: &[usize], edges: &[usize]) -> Vec<f64> {
    let mean = |p: &[usize]| {
        used_modes[p[0]..p[1]].iter().map(|&k| record.modes[k].powi(2)).sum::<f64>() / (p[1] - p[0]) as f64
    };
    edges.windows(2).map(mean).collect()
}

fn mean_mode(used_modes: &[usize]) -> f64 {
    1.0 + used_modes.iter().sum::<usize>() as f64 / used_modes.len() as f64
}
