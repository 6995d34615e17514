//! Cells of frequency that a matrix connects with the bins of a record with missing samples.

/// Number of cells per bin of the periodogram, and per decade below the periodogram.
const IN_BIN: usize = 4;
const PER_DECADE: f64 = 48.0;

/// Lowest cell edge, in cycles in the record.
const LOWEST_EDGE: f64 = 0.02;

/// Cells of frequency, within which a density counts as constant for its leakage to other frequencies.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cells {
    /// Edges from 0 to half the rate. \[Hz\]
    pub edges: Vec<f64>,
    /// Frequencies at which a density is evaluated: geometric means of the edges, at which 1/f² has its mean. \[Hz\]
    pub centres: Vec<f64>,
}

impl Cells {
    /// The cell of a frequency. \[Hz\]
    pub(crate) fn cell_of(&self, frequency: f64) -> usize {
        self.edges.partition_point(|&e| e <= frequency).clamp(1, self.centres.len()) - 1
    }

    /// \[Hz\]
    pub(crate) fn width(&self, cell: usize) -> f64 {
        self.edges[cell + 1] - self.edges[cell]
    }

    /// Quarters of the bins of the periodogram, where `ranges` are their densities at multiples of `spacing`, and
    /// logarithmic steps below.
    pub(super) fn new(
        ranges: &[(usize, usize)],
        length: usize,
        spacing: f64,
        duration: f64,
        highest_mode: f64,
    ) -> Self {
        let first = ranges.first().map_or(0.5 * length as f64, |r| r.0 as f64 - 0.5) * spacing;
        // The modes need finer cells than the densities, because the density is steeper there.
        let first = first.max(highest_mode * 10_f64.powf(2.0 / PER_DECADE));
        let lowest = LOWEST_EDGE / duration;
        let count = (PER_DECADE * (first / lowest).log10()).ceil().max(1.0);
        let mut edges = vec![0.0];
        edges.extend((0..=count as usize).map(|i| lowest * (first / lowest).powf(i as f64 / count)));
        for &(a, b) in ranges {
            let parts = IN_BIN.min(b - a);
            let (a, b) = (a as f64 - 0.5, b as f64 - 0.5);
            let cuts = (1..=parts).map(|i| (a + (b - a) * i as f64 / parts as f64) * spacing);
            edges.extend(cuts.filter(|&e| e > first));
        }
        let last = edges.len() - 1;
        edges[last] = 0.5 * length as f64 * spacing;
        let centres =
            edges.windows(2).map(|e| if e[0] > 0.0 { (e[0] * e[1]).sqrt() } else { 0.5 * e[1] }).collect();
        Self { edges, centres }
    }
}
