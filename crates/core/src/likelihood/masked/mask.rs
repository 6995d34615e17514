//! Properties of a mask that the likelihood needs.

use crate::likelihood::masked::differences::Differences;
use crate::likelihood::masked::nodes::StringModes;
use crate::likelihood::masked::windows::{Cells, Windows};
use crate::likelihood::taper::PARTS;

/// Smallest number of neighbouring pairs that distinguishes quantization noise from random walk.
pub(super) const MIN_PAIRS: usize = 100;

/// Smallest number of differences that may replace samples: 32 in a segment of a sixteenth of the record.
const MIN_DIFFERENCES: usize = 512;

/// Sums of a pass over the samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MaskSums {
    /// Number of present samples, and of pairs of neighbours.
    pub(super) present: usize,
    pub(super) neighbours: usize,
    /// Pairs one step apart, and the mean square of their differences.
    pub(super) pairs: usize,
    pub(super) square: f64,
    pub(super) differences: Differences,
    /// Gain of the differences at the densities.
    pub(super) gains: Vec<f64>,
    /// Share of the sums of squares of weights in each part of the record.
    pub(super) parts: [f64; PARTS],
}

/// Properties of a mask that the likelihood needs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Masked {
    pub(super) seen: MaskSums,
    pub string: StringModes,
    pub(super) windows: Windows,
    pub cells: Cells,
    /// Expected densities of the terms, by bin of the modes and by density of the periodogram.
    pub(super) low: Vec<Vec<f64>>,
    pub(super) high: Vec<Vec<f64>>,
    /// Weights of the cells in the bins of the modes, in row order.
    pub(super) low_rows: Vec<f64>,
}

impl Masked {
    /// Whether quantization noise can be distinguished from random walk: without neighbours they have the same density.
    pub(crate) fn has_neighbours(&self) -> bool {
        self.seen.neighbours >= MIN_PAIRS
    }

    /// Number of present samples.
    pub(crate) fn present(&self) -> usize {
        self.seen.present
    }

    /// Number of samples or differences in the segments, over the samples of a complete record.
    pub(crate) fn share(&self, samples: usize) -> f64 {
        let count = if self.seen.differences.used { self.seen.pairs } else { self.seen.present };
        count as f64 / samples as f64
    }

    /// Share of each part of the record in the segments.
    pub(crate) fn parts(&self) -> [f64; PARTS] {
        self.seen.parts
    }

    /// Whether differences should replace samples in the segments: whether their mean square is below `variance`, that of
    /// the samples in a segment. The gain of differences has the geometric mean 1, so the larger variance leaks more.
    pub(crate) fn wants_differences(&self, variance: f64) -> bool {
        self.seen.pairs >= MIN_DIFFERENCES && self.seen.square < variance
    }

    /// Whether a density is an image of frequencies below the density `first`.
    pub(crate) fn repeats(&self, k: usize, length: usize, first: usize) -> bool {
        self.seen.differences.repeats(k, length, first)
    }

    /// Mean densities of a term in all bins; `stretches` are the densities of each bin of the periodogram.
    pub(crate) fn column(&self, term: usize, stretches: &[Vec<(usize, usize)>]) -> Vec<f64> {
        let mean = |of: &Vec<(usize, usize)>| {
            let count: usize = of.iter().map(|(a, b)| b - a).sum();
            of.iter().flat_map(|&(a, b)| &self.high[term][a..b]).sum::<f64>() / count as f64
        };
        self.low[term].iter().copied().chain(stretches.iter().map(mean)).collect()
    }

    /// Expected densities of a model of the terms.
    pub(crate) fn densities(&self, theta: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.high[0].len()];
        for (theta, density) in theta.iter().zip(&self.high) {
            sum.iter_mut().zip(density).for_each(|(s, d)| *s += theta * d);
        }
        sum
    }

    /// Mean density of some stretches for a line with density 1 over the distance of two densities.
    pub(crate) fn line_density(&self, stretches: &[(usize, usize)], line: f64, spacing: f64) -> f64 {
        const WIDTH: f64 = 0.25; // width of a line over the distance of two densities
        let at = line / spacing;
        let mut row = [0.0];
        self.row(stretches, &[at - 0.5 * WIDTH, at + 0.5 * WIDTH], &mut row);
        row[0] * self.gain(line, spacing) / WIDTH
    }

    /// Gain of the differences at a frequency; `spacing` is the distance of two densities.
    fn gain(&self, frequency: f64, spacing: f64) -> f64 {
        let length = 2 * (self.seen.gains.len() - 1);
        self.seen.differences.gain(frequency / (spacing * length as f64))
    }

    /// Weights of the cells between the edges in the mean density of some stretches, with samples or differences in the
    /// segments.
    fn row(&self, stretches: &[(usize, usize)], edges: &[f64], row: &mut [f64]) {
        if !self.seen.differences.used {
            return self.windows.row(stretches, edges, row);
        }
        let count: usize = stretches.iter().map(|(a, b)| b - a).sum();
        let mut of_piece = vec![0.0; row.len()];
        row.fill(0.0);
        for (a, b) in self.seen.differences.pieces(stretches, &self.seen.gains) {
            self.windows.row(&[(a, b)], edges, &mut of_piece);
            let weight = self.seen.gains[a..b].iter().map(|gain| 1.0 / gain).sum::<f64>() / count as f64;
            row.iter_mut().zip(&of_piece).for_each(|(sum, x)| *sum += weight * x);
        }
    }

    /// Weights of the cells in all bins, in row order.
    pub(crate) fn matrix(&self, stretches: &[Vec<(usize, usize)>], spacing: f64) -> Vec<f64> {
        let edges: Vec<f64> = self.cells.edges.iter().map(|e| e / spacing).collect();
        let gains: Vec<f64> = self.cells.centres.iter().map(|&f| self.gain(f, spacing)).collect();
        let width = self.cells.centres.len();
        let mut matrix = self.low_rows.clone();
        matrix.resize(matrix.len() + stretches.len() * width, 0.0);
        for (row, of) in matrix[self.low_rows.len()..].chunks_exact_mut(width).zip(stretches) {
            self.row(of, &edges, row);
            row.iter_mut().zip(&gains).for_each(|(x, gain)| *x *= gain);
        }
        matrix
    }
}
