//! Properties of a mask that the likelihood needs.

use crate::likelihood::masked::cells::Cells;
use crate::likelihood::masked::differences::Differences;
use crate::likelihood::masked::nodes::StringModes;
use crate::likelihood::masked::windows::{Piece, Windows};
use crate::likelihood::taper::PARTS;
use crate::terms::Term;

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
        let count: usize = stretches.iter().map(|(a, b)| b - a).sum();
        let pieces = self.seen.differences.pieces(stretches, &self.seen.gains);
        let weighted = |(start, stop): (usize, usize)| {
            let gains = &self.seen.gains[start..stop];
            let mean = gains.iter().map(|gain| 1.0 / gain).sum::<f64>() / gains.len() as f64;
            Piece { start, stop, weight: mean / count as f64 }
        };
        self.windows.row(&pieces.into_iter().map(weighted).collect::<Vec<_>>(), edges, row);
    }

    /// Weights of the cells in all bins, in row order. The rows of the periodogram have the sum of white noise, whose density
    /// is exact: where a filter leaves little, the density is the difference of that without the filter and the part that the
    /// filter removes, and an error of the sum would be as large.
    pub(crate) fn matrix(&self, stretches: &[Vec<(usize, usize)>], spacing: f64) -> Vec<f64> {
        let edges: Vec<f64> = self.cells.edges.iter().map(|e| e / spacing).collect();
        let gains: Vec<f64> = self.cells.centres.iter().map(|&f| self.gain(f, spacing)).collect();
        let width = self.cells.centres.len();
        let mut matrix = self.low_rows.clone();
        matrix.resize(matrix.len() + stretches.len() * width, 0.0);
        let white = self.column(Term::RandomWalk.index(), stretches);
        let white = &white[self.low_rows.len() / width..];
        for ((row, of), white) in
            matrix[self.low_rows.len()..].chunks_exact_mut(width).zip(stretches).zip(white)
        {
            self.row(of, &edges, row);
            row.iter_mut().zip(&gains).for_each(|(x, gain)| *x *= gain);
            let scale = white / row.iter().sum::<f64>();
            for x in row {
                *x *= scale;
            }
        }
        matrix
    }
}
