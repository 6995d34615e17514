//! Records with missing samples.
//!
//! In place of the cosine modes there are those of a string that carries the weights of the samples, in place of the densities
//! of a periodogram those of segments with zeros for missing samples. What both are expected to be follows from the mask: exactly
//! for the terms; and for any other density by a matrix, cell of frequency by bin.

mod differences;
mod nodes;
mod pass;
mod share;
mod string;
#[cfg(test)]
mod tests;
mod weights;
mod windows;

pub use pass::{MaskedPass, Weighting};

use crate::likelihood::bins::{high_ranges, low_edges};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::pass::{PARTS, Summary};
use crate::special::odd_harmonic;
use crate::terms::Term;
use differences::Differences;
use nodes::StringModes;
use std::f64::consts::PI;
use windows::{Cells, Grid, LowView, LowWindow, Windows};

/// Fewest stretches between two nodes that hold a sample.
const LEAST_NODES: usize = 64;

/// Fewest pairs of neighbours that tell quantization noise from random walk.
const LEAST_PAIRS: usize = 100;

/// Fewest differences that take the place of samples: 32 in a segment of a sixteenth of the record.
const LEAST_DIFFERENCES: usize = 512;

/// What a pass saw of the samples.
#[derive(Debug, Clone, PartialEq)]
struct Seen {
    /// Samples that are there, and pairs of neighbours.
    present: usize,
    neighbours: usize,
    /// Pairs one step apart, and the mean square of their differences.
    pairs: usize,
    square: f64,
    differences: Differences,
    /// Gain of the differences at the densities.
    gains: Vec<f64>,
    /// Share of the sums of squares of weights in each part of the record.
    parts: [f64; PARTS],
}

/// What the likelihood needs to know of a mask.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Masked {
    seen: Seen,
    pub string: StringModes,
    windows: Windows,
    pub cells: Cells,
    /// Densities of the terms: by bin of the modes, and by density of the periodogram.
    low: Vec<Vec<f64>>,
    high: Vec<Vec<f64>>,
    /// Weights of the cells in the bins of the modes, row after row.
    low_rows: Vec<f64>,
}

impl Masked {
    fn new(seen: Seen, string: StringModes, windows: Windows, record: &Summary) -> Self {
        let (tau0, length) = (record.tau0, record.segment);
        let grid = Grid { spacing: record.block, count: record.blocks, tau0 };
        let highest = string.frequencies[string.frequencies.len() - 1];
        let ranges = high_ranges(highest, length, tau0);
        let cells = Cells::new(&ranges, length, record.frequency(1), record.duration(), highest);
        let edges = low_edges(record, &(0..string.modes.len()).collect::<Vec<_>>());
        let bins: Vec<std::ops::Range<usize>> = edges.windows(2).map(|p| p[0]..p[1]).collect();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let view = LowView::new(grid);
        let low_windows: Vec<LowWindow> = bins
            .iter()
            .map(|b| view.window(&string.shapes[b.clone()], &string.mass, &string.white[b.clone()]))
            .collect();
        let low = TERMS
            .iter()
            .map(|&part| match part {
                Part::Term(Term::RandomWalk) => bins.iter().map(|b| mean(&string.white[b.clone()])).collect(),
                Part::Term(Term::Quantization) => {
                    bins.iter().map(|b| mean(&string.steps[b.clone()]) / tau0).collect()
                }
                _ => {
                    let bent = if part == Part::Term(Term::BiasInstability) { 1.0 / PI } else { 0.0 };
                    let covariance = grid.covariance(|l| covariance(part, l, tau0), bent);
                    low_windows.iter().map(|w| w.expected(&covariance)).collect()
                }
            })
            .collect();
        let lags = |part: Part| -> Vec<f64> {
            (0..length).map(|l| seen.differences.covariance(l, |l| covariance(part, l, tau0))).collect()
        };
        let expected = |part: Part| -> Vec<f64> {
            windows.expected(&lags(part), tau0).iter().zip(&seen.gains).map(|(s, gain)| s / gain).collect()
        };
        let high = TERMS.iter().map(|&part| expected(part)).collect();
        let between = windows.between_nodes(&cells, grid);
        let low_rows = low_windows.iter().flat_map(|w| view.row(w, &cells, &between)).collect();
        Self { seen, string, windows, cells, low, high, low_rows }
    }

    /// Whether quantization noise can be told from random walk: without neighbours they have the same density.
    pub(crate) fn has_neighbours(&self) -> bool {
        self.seen.neighbours >= LEAST_PAIRS
    }

    /// Samples that are there.
    pub(crate) fn present(&self) -> usize {
        self.seen.present
    }

    /// Samples or differences in the segments, over the samples of a complete record.
    pub(crate) fn share(&self, samples: usize) -> f64 {
        let count = if self.seen.differences.used { self.seen.pairs } else { self.seen.present };
        count as f64 / samples as f64
    }

    /// Share of each part of the record in the segments.
    pub(crate) fn parts(&self) -> [f64; PARTS] {
        self.seen.parts
    }

    /// Whether differences should take the place of samples in the segments: their mean square is below `variance`, that of
    /// the samples in a segment. The gain of differences has the geometric mean 1: the larger variance leaks more.
    pub(crate) fn wants_differences(&self, variance: f64) -> bool {
        self.seen.pairs >= LEAST_DIFFERENCES && self.seen.square < variance
    }

    /// Whether a density is an image of frequencies below the density `first`.
    pub(crate) fn repeats(&self, k: usize, length: usize, first: usize) -> bool {
        self.seen.differences.repeats(k, length, first)
    }

    /// Mean densities of a term in all bins; `stretches`: densities of each bin of the periodogram.
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

    /// Mean density of some stretches for a line with the density 1, over the distance of two densities.
    pub(crate) fn of_line(&self, stretches: &[(usize, usize)], line: f64, spacing: f64) -> f64 {
        const WIDTH: f64 = 0.25; // of a distance
        let at = line / spacing;
        let mut row = [0.0];
        self.row(stretches, &[at - 0.5 * WIDTH, at + 0.5 * WIDTH], &mut row);
        row[0] * self.gain(line, spacing) / WIDTH
    }

    /// Gain of the differences at a frequency; `spacing` of two densities.
    fn gain(&self, frequency: f64, spacing: f64) -> f64 {
        let length = 2 * (self.seen.gains.len() - 1);
        self.seen.differences.gain(frequency / (spacing * length as f64))
    }

    /// Weights of the densities of what the segments have, from edge to edge, in the mean of some stretches.
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

    /// Weights of the cells in all bins, row after row.
    pub(crate) fn matrix(&self, stretches: &[Vec<(usize, usize)>], spacing: f64) -> Vec<f64> {
        let edges: Vec<f64> = self.cells.edges.iter().map(|e| e / spacing).collect();
        let gains: Vec<f64> = self.cells.at.iter().map(|&f| self.gain(f, spacing)).collect();
        let width = self.cells.at.len();
        let mut matrix = self.low_rows.clone();
        matrix.resize(matrix.len() + stretches.len() * width, 0.0);
        for (row, of) in matrix[self.low_rows.len()..].chunks_exact_mut(width).zip(stretches) {
            self.row(of, &edges, row);
            row.iter_mut().zip(&gains).for_each(|(x, gain)| *x *= gain);
        }
        matrix
    }
}

/// Covariance of a term of unit amplitude by the distance of samples, up to a constant.
fn covariance(part: Part, lag: usize, tau0: f64) -> f64 {
    let Part::Term(term) = part else { return 0.0 };
    match (term, lag) {
        (Term::RandomWalk, 0) => 1.0 / tau0,
        (Term::Quantization, 0) => 2.0 / (tau0 * tau0),
        (Term::Quantization, 1) => -1.0 / (tau0 * tau0),
        (Term::BiasInstability, _) => -2.0 / PI * odd_harmonic(lag),
        (Term::RateRandomWalk, _) => -0.5 * tau0 * lag as f64,
        _ => 0.0,
    }
}
