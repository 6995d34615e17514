//! Which modes and densities of a record are used, and where their bins begin.

use crate::likelihood::summary::Summary;

/// Smallest number of unmasked densities in a bin.
pub(crate) const MIN_COUNT: f64 = 2.0;

/// Number of modes with a separate bin.
const SINGLE_MODES: usize = 48;

/// Number of bins per decade above these modes.
const PER_DECADE: f64 = 32.0;

/// Number of the highest mode or density, over the largest width of a bin.
const TOP_OVER_WIDEST: f64 = 64.0;

/// First density of the periodogram that is used, above the highest mode.
pub(crate) fn first_density(record: &Summary) -> usize {
    first_above(record.mode_frequency(record.low_modes()), record.segment, record.tau0)
}

fn first_above(highest_mode: f64, segment: usize, tau0: f64) -> usize {
    let highest = highest_mode * (1.0 + 1e-9);
    (highest * segment as f64 * tau0).ceil() as usize
}

/// The mask without lines: the densities above the modes, up to the frequency at which the noise ends (a zero of a digital
/// filter, or rounding).
pub(crate) fn usable(record: &Summary) -> Vec<bool> {
    const PIECES: usize = 64;
    const MIN_PIECES: usize = 16;
    const EMPTY_RATIO: f64 = 0.08; // relative to the usual density
    let last = record.density.len() - 1;
    let first = first_density(record);
    let mut mask = vec![false; last + 1];
    if first >= last {
        return mask;
    }
    mask[first..last].fill(true);
    if let Some(masked) = &record.masked {
        for (k, used) in mask.iter_mut().enumerate().take(last).skip(first) {
            *used = !masked.repeats(k, record.segment, first);
        }
    }
    let edge = |i: usize| first + (last + 1 - first) * i / PIECES;
    let medians: Vec<f64> = (0..PIECES).map(|i| median(&record.density[edge(i)..edge(i + 1)])).collect();
    let usual = median(&medians[1..PIECES / 2]);
    let mut end = PIECES;
    while end > MIN_PIECES && medians[end - 1] < EMPTY_RATIO * usual {
        end -= 1;
    }
    if end < PIECES {
        mask[edge(end)..].fill(false);
    }
    if let Some(end) = end_of_slow_filter(&record.density[..last], first) {
        mask[end..].fill(false);
    }
    mask
}

/// Index of the first density at which a filter with a corner far below half the rate leaves no noise: from there on,
/// densities fall more steeply than those of any term, and remain low. None without such a filter.
fn end_of_slow_filter(density: &[f64], first: usize) -> Option<usize> {
    const PER_OCTAVE: usize = 8;
    const MIN_DENSITIES: usize = 16; // in a piece
    const STEEP_RATIO: f64 = 0.08; // to the smallest density one to two octaves lower; 0.25 for a rate random walk
    const MIN_STEEP_PIECES: usize = 3;
    let mut edges = vec![first.max(1)];
    while edges[edges.len() - 1] < density.len() {
        let start = edges[edges.len() - 1];
        let next = start as f64 * 2_f64.powf(1.0 / PER_OCTAVE as f64);
        edges.push((next.round() as usize).max(start + MIN_DENSITIES));
    }
    edges.pop();
    let medians: Vec<f64> = edges.windows(2).map(|p| median(&density[p[0]..p[1]])).collect();
    let lower = |i: usize, octaves: usize| {
        let wanted = edges[i] >> octaves;
        edges.partition_point(|&e| e <= wanted).saturating_sub(1)
    };
    let steep = |i: usize| {
        let range = lower(i, 2)..=lower(i, 1);
        edges[i] >> 1 >= first
            && medians[i] < STEEP_RATIO * medians[range].iter().copied().fold(f64::INFINITY, f64::min)
    };
    let pieces = medians.len();
    (0..(pieces + 1).saturating_sub(MIN_STEEP_PIECES))
        .find(|&i| (i..i + MIN_STEEP_PIECES).all(steep))
        .map(|i| edges[i])
}

/// The largest power of two by which the sample interval can be multiplied while the top of the band is still below half
/// the rate.
pub(crate) fn spacing_of(record: &Summary, mask: &[bool], used_modes: &[usize]) -> usize {
    let density = mask.iter().rposition(|&used| used).map_or(0.0, |k| record.frequency(k));
    let mode = used_modes.last().map_or(0.0, |&k| record.mode_frequency(k + 1));
    let ratio = 0.5 / (density.max(mode).max(record.frequency(1)) * record.tau0);
    1 << (ratio.max(1.0) as usize).ilog2()
}

/// Indices of the modes that are used: mode numbers minus 1. Modes in the band of the periodogram, which only a
/// short record has, are used if they are unmasked. Modes below the band are all used, or the unmasked ones if the mask
/// extends below the band.
pub(crate) fn modes_in_use(record: &Summary, mask: &[bool]) -> Vec<usize> {
    if record.masked.is_some() {
        // With missing samples, the expectation of a bin is that of all its modes, and the matrix from frequencies to
        // bins includes the lines.
        return (0..record.modes.len()).collect();
    }
    let (first, last) = (first_density(record), record.density.len() - 1);
    let nearest =
        |k: usize| (record.mode_frequency(k) * record.segment as f64 * record.tau0).round() as usize;
    let goes_on = mask[..first.min(mask.len())].contains(&true);
    let counts = |k: &usize| {
        if *k < record.low_modes() {
            !goes_on || mask[nearest(*k + 1).min(last - 1)]
        } else {
            mask[nearest(*k + 1).clamp(first, last - 1)]
        }
    };
    (0..record.modes.len()).filter(counts).collect()
}

/// Bins of single modes, then logarithmic bins, as positions in `used_modes`.
pub(crate) fn low_edges(record: &Summary, used_modes: &[usize]) -> Vec<usize> {
    let modes = record.modes.len();
    let widest = if modes > record.low_modes() { modes as f64 / TOP_OVER_WIDEST } else { f64::INFINITY };
    let mut edges: Vec<usize> = (0..=SINGLE_MODES.min(modes)).collect();
    let mut position = SINGLE_MODES as f64;
    let step = 10_f64.powf(1.0 / PER_DECADE) - 1.0;
    while edges[edges.len() - 1] < modes {
        let done = edges[edges.len() - 1];
        position = (position + (position * step).min(widest)).max((done + 1) as f64);
        edges.push((position.round() as usize).min(modes));
    }
    let mut positions: Vec<usize> =
        edges.iter().map(|&edge| used_modes.partition_point(|&k| k < edge)).collect();
    positions.dedup();
    positions
}

pub(crate) fn high_edges(record: &Summary) -> Vec<(usize, usize)> {
    if record.modes.len() > record.low_modes() {
        return Vec::new();
    }
    high_ranges(record.mode_frequency(record.low_modes()), record.segment, record.tau0)
}

/// Ranges of densities above the highest mode.
pub(crate) fn high_ranges(highest_mode: f64, segment: usize, tau0: f64) -> Vec<(usize, usize)> {
    const MIN_WIDTH: f64 = 4.0;
    let (first, last) = (first_above(highest_mode, segment, tau0), segment / 2);
    let widest = (last as f64 / TOP_OVER_WIDEST).max(MIN_COUNT);
    let step = 10_f64.powf(1.0 / PER_DECADE) - 1.0;
    let mut edges = vec![first];
    let mut position = first as f64;
    while edges[edges.len() - 1] < last {
        position += (position * step).max(MIN_WIDTH).min(widest);
        edges.push((position.round() as usize).min(last));
    }
    let n = edges.len();
    if n > 2 && ((edges[n - 1] - edges[n - 2]) as f64) < 0.5 * (edges[n - 2] - edges[n - 3]) as f64 {
        edges.remove(n - 2);
    }
    edges.windows(2).map(|p| (p[0], p[1])).filter(|(a, b)| b > a).collect()
}

/// Ranges of consecutive numbers.
pub(crate) fn consecutive_ranges(numbers: &[usize]) -> Vec<(usize, usize)> {
    let mut ranges: Vec<(usize, usize)> = Vec::new();
    for &k in numbers {
        match ranges.last_mut() {
            Some(last) if last.1 == k => last.1 = k + 1,
            _ => ranges.push((k, k + 1)),
        }
    }
    ranges
}

pub(crate) fn median(x: &[f64]) -> f64 {
    if x.is_empty() {
        return f64::NAN;
    }
    let mut sorted = x.to_vec();
    let middle = sorted.len() / 2;
    let (below, &mut upper, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
    if x.len() % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
