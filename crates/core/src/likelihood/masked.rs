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
mod weights;
mod windows;

pub use pass::{MaskedPass, Weighting};

use crate::likelihood::bins::{TERMS, high_ranges, low_edges};
use crate::likelihood::expected::Part;
use crate::likelihood::pass::{PARTS, Summary};
use crate::special::odd_harmonic;
use differences::Differences;
use nodes::StringModes;
use std::f64::consts::PI;
use windows::{Cells, Grid, LowView, LowWindow, Windows};

/// Fewest stretches between two nodes that hold a sample.
const LEAST_NODES: usize = 64;

/// Fewest pairs of neighbours that tell quantization noise from random walk.
const LEAST_PAIRS: usize = 100;

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
                Part::RandomWalk => bins.iter().map(|b| mean(&string.white[b.clone()])).collect(),
                Part::Quantization => bins.iter().map(|b| mean(&string.steps[b.clone()]) / tau0).collect(),
                _ => {
                    let bent = if part == Part::BiasInstability { 1.0 / PI } else { 0.0 };
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

    /// Samples or differences in the segments.
    pub(crate) fn in_segments(&self) -> usize {
        if self.seen.differences.used { self.seen.pairs } else { self.seen.present }
    }

    /// Share of each part of the record in the segments.
    pub(crate) fn parts(&self) -> [f64; PARTS] {
        self.seen.parts
    }

    /// Whether differences should take the place of samples in the segments: they have the smaller variance, `variance`
    /// being that of the samples in a segment. The ratio to the level that all frequencies have in common, the geometric
    /// mean of the densities, is then smaller too, because that of the gain is 1.
    pub(crate) fn wants_differences(&self, variance: f64) -> bool {
        self.seen.pairs >= LEAST_PAIRS && self.seen.square < variance
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
    match (part, lag) {
        (Part::RandomWalk, 0) => 1.0 / tau0,
        (Part::Quantization, 0) => 2.0 / (tau0 * tau0),
        (Part::Quantization, 1) => -1.0 / (tau0 * tau0),
        (Part::BiasInstability, _) => -2.0 / PI * odd_harmonic(lag),
        (Part::RateRandomWalk, _) => -0.5 * tau0 * lag as f64,
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::weights::Weights;
    use super::*;
    use crate::error::Error;
    use crate::likelihood::bins::{Bins, usable};
    use crate::likelihood::pass::hann;
    use std::ops::Range;
    use std::sync::Arc;

    const N: usize = 1200;
    const TAU0: f64 = 0.02;

    /// Masks: losses at random, every second sample, blocks, one long gap.
    fn masks() -> Vec<(&'static str, Vec<bool>)> {
        let random = |t: usize| {
            f64::from((t as u32 + 1).wrapping_mul(2_654_435_761).swap_bytes().wrapping_mul(0x9E37_79B1) >> 8)
                / f64::from(1 << 24)
        };
        vec![
            ("complete", vec![true; N]),
            ("5 %", (0..N).map(|t| random(t) > 0.05).collect()),
            ("50 %", (0..N).map(|t| random(t) > 0.5).collect()),
            ("second", (0..N).map(|t| t % 2 == 0).collect()),
            ("gap", (0..N).map(|t| !(900..1500).contains(&t)).collect()),
            ("blocks", (0..N).map(|t| (t / 60) % 3 != 1 && t % 601 > 200).collect()),
        ]
    }

    fn tapered(taper: f64) -> Weighting {
        Weighting { taper, differences: None }
    }

    fn record(present: &[bool], weighting: Weighting) -> Summary {
        let mut pass = MaskedPass::new(present.to_vec(), TAU0, weighting).unwrap();
        let y: Vec<f64> = (0..N).map(|t| ((t * t) as f64 * 0.37).sin()).collect();
        pass.push(&y).unwrap();
        pass.finish().unwrap()
    }

    /// Adds `scale` times c, Σ a(s) a(t) R(|s − t|) = Σ c(l) R(l) for every R.
    fn add_products(c: &mut [f64], a: &[f64], scale: f64) {
        for lag in 0..a.len() {
            let products = a.iter().zip(&a[lag..]).map(|(s, t)| s * t).sum::<f64>();
            c[lag] += scale * if lag == 0 { 1.0 } else { 2.0 } * products;
        }
    }

    /// Expected power of samples whose products are `c`, autocovariance R(l).
    fn variance(c: &[f64], lags: &[f64]) -> f64 {
        c.iter().zip(lags).map(|(c, r)| c * r).sum()
    }

    /// Products of the weights of the samples in some modes, summed.
    fn in_modes(record: &Summary, modes: Range<usize>, present: &[bool], taper: f64) -> Vec<f64> {
        let mut products = vec![0.0; N];
        for k in modes {
            add_products(&mut products, &in_mode(record, k, present, taper), 1.0);
        }
        products
    }

    /// Weights of the samples in a mode.
    fn in_mode(record: &Summary, k: usize, present: &[bool], taper: f64) -> Vec<f64> {
        let mut w = vec![0.0; N];
        Weights::new(taper).fill(present, 0, &mut w);
        let v = &record.masked.as_ref().unwrap().string.shapes[k];
        w.iter()
            .enumerate()
            .map(|(t, w)| {
                let x = (t as f64 + 0.5) / record.block as f64 - 0.5;
                let j = (x.max(0.0) as usize).min(v.len() - 2);
                let r = (x - j as f64).clamp(0.0, 1.0);
                TAU0.sqrt() * w * (v[j] * (1.0 - r) + v[j + 1] * r)
            })
            .collect()
    }

    /// Products of the weights in the mean of some densities, from their definition: each segment without its level, of
    /// samples or of their differences, whose densities are those of samples after division by the gain.
    fn in_densities(
        record: &Summary,
        (from, to): (usize, usize),
        present: &[bool],
        weighting: Weighting,
    ) -> Vec<f64> {
        let differenced = weighting.differences.is_some();
        let differences = Differences::new(present, differenced);
        let step = if differenced { differences.step } else { 0 };
        let there = if differenced { differences.there(present) } else { present.to_vec() };
        let runs = there.windows(2).filter(|p| !p[0] && p[1]).count() + usize::from(there[0]);
        let count = there.iter().filter(|t| **t).count();
        let taper = weighting.differences.unwrap_or(weighting.taper);
        let taper = taper.min(0.125 * count as f64 / runs as f64).min(32.0);
        let (length, h) = (record.segment, hann(record.segment));
        let count = (4 * N).div_ceil(length);
        let (mut products, mut total) = (vec![0.0; N], 0.0);
        for i in 0..count {
            let start = ((i as f64 + 0.5) * N as f64 / count as f64) as isize - (length / 2) as isize;
            let mut m = vec![0.0; length];
            Weights::new(taper).fill(&there, start, &mut m);
            if m.iter().sum::<f64>() < 8.0 {
                continue;
            }
            let w: Vec<f64> = m.iter().zip(&h).map(|(m, h)| m * h).collect();
            let sum: f64 = w.iter().sum();
            total += w.iter().map(|w| w * w).sum::<f64>();
            for (k, phase) in (from..to).flat_map(|k| [(k, 0.0), (k, 0.5 * PI)]) {
                let wave = |t: usize| (2.0 * PI * (k * t % length) as f64 / length as f64 + phase).cos();
                let mean = (0..length).map(|t| w[t] * wave(t)).sum::<f64>() / sum;
                let b: Vec<f64> = (0..length).map(|t| w[t] * (wave(t) - mean)).collect();
                let at = |t: usize| b.get(t).copied().unwrap_or(0.0);
                let before = |t: usize| t.checked_sub(step).map_or(0.0, at);
                let a: Vec<f64> =
                    (0..length + step).map(|t| if step == 0 { at(t) } else { before(t) - at(t) }).collect();
                let gain = if step == 0 {
                    1.0
                } else {
                    4.0 * (PI * (k * step) as f64 / length as f64).sin().powi(2)
                };
                add_products(&mut products, &a, TAU0 / ((to - from) as f64 * gain));
            }
        }
        products.iter().map(|c| c / total).collect()
    }

    fn lags_of(part: Part) -> Vec<f64> {
        (0..N)
            .map(|l| match part {
                Part::GaussMarkov { time } => (-(l as f64) * TAU0 / time).exp(),
                _ => covariance(part, l, TAU0),
            })
            .collect()
    }

    #[test]
    fn expected_powers_are_those_of_the_dense_covariance() {
        let shapes = [Part::GaussMarkov { time: 0.6 }, Part::GaussMarkov { time: 10.0 }];
        for (name, present) in masks() {
            for weighting in [tapered(0.0), tapered(3.0), Weighting { taper: 0.0, differences: Some(3.0) }] {
                let taper = weighting.taper;
                if taper > 0.0 && name == "second" {
                    continue; // no run has two samples
                }
                let record = record(&present, weighting);
                let bins = Bins::new(&record, Arc::new(usable(&record)), Arc::new(Vec::new()));
                let in_modes: Vec<(usize, Vec<f64>)> = [0, 1, 2, 5, 11, 23, record.modes.len().min(48) - 1]
                    .into_iter()
                    .filter(|&k| k < record.modes.len())
                    .map(|k| (k, in_modes(&record, k..k + 1, &present, taper)))
                    .collect();
                let in_bins: Vec<(usize, Vec<f64>)> = (0..bins.ranges.len())
                    .step_by(5)
                    .chain([bins.ranges.len() - 1])
                    .filter(|&i| bins.mask[bins.ranges[i].0..bins.ranges[i].1].iter().all(|&used| used))
                    .map(|i| (bins.low + i, in_densities(&record, bins.ranges[i], &present, weighting)))
                    .collect();
                for part in TERMS.into_iter().chain(shapes) {
                    let column = bins.unit(part);
                    let lags = lags_of(part);
                    let worst = [&in_modes, &in_bins].map(|checked| {
                        let errors =
                            checked.iter().map(|(k, c)| (column[*k] / variance(c, &lags) - 1.0).abs());
                        errors.fold(0.0, f64::max)
                    });
                    // The level of a segment is right in all frequencies together, not in each. Differences have none of
                    // the power of low frequencies that leaks.
                    let [modes, densities] = match part {
                        Part::RandomWalk => [1e-9, 0.05],
                        Part::Quantization => [0.01, 0.05],
                        Part::BiasInstability => [0.06, 0.25],
                        Part::RateRandomWalk => [0.02, 0.4],
                        _ => [0.03, 0.4],
                    };
                    let differenced = weighting.differences.is_some();
                    let densities = match part {
                        Part::Quantization if differenced => 0.1,
                        _ if differenced => 0.07,
                        _ => densities,
                    };
                    assert!(
                        worst[0] < modes && worst[1] < densities,
                        "{name}, {weighting:?}, {part:?}: {worst:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_filter_and_a_resonance_are_seen_through_the_mask() {
        // R of a density by its cosine transform: the process sees |H|² or is one of a narrow band.
        let (grid, a) = (1 << 14, 0.7);
        let omega = |i: usize| PI * (i as f64 + 0.5) / f64::from(grid);
        let resonance = Part::Resonance { frequency: 4.0, width: 0.8 };
        let filtered = |w: f64| (a * (w.cos() - 1.0)).exp();
        let narrow = |w: f64| crate::likelihood::expected::resonance(4.0, 0.8, w / (2.0 * PI * TAU0));
        let lags = |density: &dyn Fn(f64) -> f64| -> Vec<f64> {
            (0..N)
                .map(|l| {
                    let sum: f64 =
                        (0..grid as usize).map(|i| density(omega(i)) * (omega(i) * l as f64).cos()).sum();
                    sum / (f64::from(grid) * TAU0)
                })
                .collect()
        };
        let (filtered, narrow) = (lags(&filtered), lags(&narrow));
        for (name, present) in masks() {
            for weighting in [tapered(0.0), Weighting { taper: 0.0, differences: Some(0.0) }] {
                let record = record(&present, weighting);
                let bins = Bins::new(&record, Arc::new(usable(&record)), Arc::new(Vec::new()));
                let at = bins.column(Part::RandomWalk);
                let cells = bins.cosines_high[0].iter().map(|c| (a * c).exp()).collect();
                let low = bins.cosines_low[0].iter().map(|c| (a * c).exp()).collect();
                let whole =
                    |i: &usize| bins.mask[bins.ranges[*i].0..bins.ranges[*i].1].iter().all(|&used| used);
                let shown = (0..bins.ranges.len()).step_by(7).filter(whole);
                let in_bins: Vec<(usize, Vec<f64>)> =
                    shown.map(|i| (i, in_densities(&record, bins.ranges[i], &present, weighting))).collect();
                let count = record.modes.len();
                let in_modes = in_modes(&record, 0..count, &present, 0.0);
                for (what, got, lags) in [
                    ("filter", bins.means(&at, Some(&(low, cells))), &filtered),
                    ("resonance", bins.unit(resonance), &narrow),
                ] {
                    let usual = lags[0] * TAU0;
                    for (i, products) in &in_bins {
                        let (got, exact) = (got[bins.low + i], variance(products, lags));
                        let error = (got - exact) / exact.max(0.1 * usual);
                        assert!(
                            error.abs() < 0.1,
                            "{name}, {weighting:?}, {what}, bin {i}: {got} for {exact}"
                        );
                    }
                    // What leaks into one mode depends on the mask between two nodes, whose mean is known.
                    let exact = variance(&in_modes, lags);
                    let error = (got[..count].iter().sum::<f64>() - exact) / exact.max(usual * count as f64);
                    assert!(error.abs() < 0.2, "{name}, {weighting:?}, {what}, modes: {error}");
                }
            }
        }
    }

    #[test]
    fn pieces_and_missing_values_do_not_change_a_bit() {
        for (name, present) in masks() {
            for weighting in [tapered(3.0), Weighting { taper: 0.0, differences: Some(1.0) }] {
                let whole = record(&present, weighting);
                let y: Vec<f64> = (0..N)
                    .map(|t| if present[t] { ((t * t) as f64 * 0.37).sin() } else { f64::NAN })
                    .collect();
                for size in [1, 77, 1000] {
                    let mut pass = MaskedPass::new(present.clone(), TAU0, weighting).unwrap();
                    y.chunks(size).for_each(|piece| pass.push(piece).unwrap());
                    assert!(pass.finish().unwrap() == whole, "{name} by {size}");
                }
            }
        }
    }

    #[test]
    fn too_few_samples_or_places_are_refused() {
        let few: Vec<bool> = (0..100_000).map(|t| t % 500 == 0).collect();
        assert!(matches!(
            MaskedPass::new(few, 1.0, Weighting::default()),
            Err(Error::TooShort { got: 200, .. })
        ));
        // Enough samples, at the two ends of a long record.
        let ends: Vec<bool> = (0..1_000_000).map(|t| !(400..999_600).contains(&t)).collect();
        assert!(matches!(MaskedPass::new(ends, 1.0, Weighting::default()), Err(Error::TooShort { .. })));
        let singles: Vec<bool> = (0..100_000).map(|t| t % 10 == 0).collect();
        assert!(MaskedPass::new(singles, 1.0, Weighting::default()).is_ok());
        assert!(MaskedPass::new(vec![true; 1000], 0.0, Weighting::default()).is_err());
    }

    #[test]
    fn a_sample_that_is_there_must_be_a_number() {
        let mut pass =
            MaskedPass::new((0..1000).map(|t| t % 3 > 0).collect(), 1.0, Weighting::default()).unwrap();
        pass.push(&[f64::NAN, 1.0]).unwrap();
        assert_eq!(pass.push(&[1.0, f64::INFINITY]), Ok(()));
        assert_eq!(pass.push(&[f64::INFINITY]), Err(Error::NonFinite { index: 4 }));
    }
}
