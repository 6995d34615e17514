//! Expected modes and densities for a mask.

use crate::likelihood::bins::{high_ranges, low_edges};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::masked::cells::Cells;
use crate::likelihood::masked::mask::{MaskSums, Masked};
use crate::likelihood::masked::nodes::StringModes;
use crate::likelihood::masked::windows::{Grid, LowModes, LowWindow, Windows};
use crate::likelihood::summary::Summary;
use crate::special::odd_harmonic;
use crate::terms::Term;
use std::f64::consts::PI;

impl Masked {
    pub(super) fn new(seen: MaskSums, string: StringModes, windows: Windows, record: &Summary) -> Self {
        let (tau0, length) = (record.tau0, record.segment);
        let grid = Grid { spacing: record.block, count: record.blocks, tau0 };
        let highest = string.frequencies[string.frequencies.len() - 1];
        let ranges = high_ranges(highest, length, tau0);
        let cells = Cells::new(&ranges, length, record.frequency(1), record.duration(), highest);
        let edges = low_edges(record, &(0..string.modes.len()).collect::<Vec<_>>());
        let bins: Vec<std::ops::Range<usize>> = edges.windows(2).map(|p| p[0]..p[1]).collect();
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let view = LowModes::new(grid);
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
}

/// Covariance of a term of unit amplitude by the distance of samples, up to a constant.
pub(super) fn covariance(part: Part, lag: usize, tau0: f64) -> f64 {
    let Part::Term(term) = part else { return 0.0 };
    match (term, lag) {
        (Term::RandomWalk, 0) => 1.0 / tau0,
        (Term::Quantization, 0) => 2.0 / (tau0 * tau0),
        (Term::Quantization, 1) => -1.0 / (tau0 * tau0),
        (Term::BiasInstability, _) => -2.0 / PI * odd_harmonic(lag),
        (Term::RateRandomWalk, _) => -0.5 * tau0 * lag as f64,
        (Term::RandomWalk | Term::Quantization | Term::RateRamp, _) => 0.0,
    }
}
