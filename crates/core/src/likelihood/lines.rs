//! Narrow lines: peaks of the periodogram, which the fit leaves out.

use crate::likelihood::bins::{Bins, first_density, median};
use crate::likelihood::expected::Part;
use crate::likelihood::laws::chi2_quantile_above;
use crate::likelihood::line::{Line, density_freedom};
use crate::likelihood::masked::Masked;
use crate::likelihood::model::Model;
use crate::likelihood::summary::Summary;
use crate::terms::NOISE_TERMS;

/// Probability of a false line in a record.
const FALSE_ALARM: f64 = 1e-4;

/// The foot of a line ends at two consecutive densities below the level that chance exceeds with this probability.
const FOOT_PROBABILITY: f64 = 0.02;

/// Number of densities left out on either side of the foot.
const MARGIN: usize = 3;

/// Twice the number of neighbouring densities that share their noise (Hann).
const TWICE_SHARED: f64 = 4.16;

/// Width of a running median in densities, and the factor by which a line must then be larger, because a median is less
/// certain than a model.
const MEDIAN_WIDTH: usize = 32;
const MEDIAN_FACTOR: f64 = 1.1;

/// The same factor where a filter removes the noise.
const FILTERED_FACTOR: f64 = 30.0;

/// Share of a line that stronger lines explain, above which it is an image of these.
const IMAGE_SHARE: f64 = 0.3;

/// Share of the power of a line in five densities above which it is a steady sinusoid, and the remaining error of its
/// frequency from the overlap of segments, in densities.
const STEADY_SHARE: f64 = 0.9;
const FREQUENCY_ERROR: f64 = 0.02;

/// Lines at frequencies where a filter leaves no noise. At its zeros medians are not a reference, so a line must be far
/// above them.
pub(crate) fn beyond_band(record: &Summary, mask: &[bool]) -> Vec<Line> {
    let (first, last) = (first_density(record), record.density.len() - 1);
    let image =
        |k: usize| record.masked.as_ref().is_some_and(|masked| masked.repeats(k, record.segment, first));
    let mut beyond: Vec<bool> = (0..=last).map(|k| k >= first && k < last && !mask[k] && !image(k)).collect();
    standing_above(record, &mut beyond, None, None, FILTERED_FACTOR)
}

/// Lines above running medians of the density, and above `floor` if given; they are removed from the mask. The medians
/// are those of the density before a filter with the powers `filter`.
pub(crate) fn above_medians(
    record: &Summary,
    mask: &mut [bool],
    floor: Option<&[f64]>,
    filter: Option<&[f64]>,
) -> Vec<Line> {
    standing_above(record, mask, floor, filter, MEDIAN_FACTOR)
}

fn standing_above(
    record: &Summary,
    mask: &mut [bool],
    floor: Option<&[f64]>,
    filter: Option<&[f64]>,
    factor: f64,
) -> Vec<Line> {
    let (first, last) = (first_density(record), record.density.len() - 1);
    if first + MEDIAN_WIDTH > last {
        return Vec::new();
    }
    let power = |k: usize| filter.map_or(1.0, |filter| filter[k]);
    let density: Vec<f64> = (first..last).map(|k| record.density[k] / power(k)).collect();
    let freedom = density_freedom(record);
    let bias = chi2_quantile_above(0.5, freedom) / freedom;
    let mut centres = Vec::new();
    let mut start = 0;
    while start < density.len() {
        let end = (start + MEDIAN_WIDTH).min(density.len());
        let (from, to) =
            (start.saturating_sub(MEDIAN_WIDTH / 2), (end + MEDIAN_WIDTH / 2).min(density.len()));
        let middle = (first as f64 + 0.5 * (from + to - 1) as f64).ln();
        centres.push((middle, median(&density[from..to]).max(1e-300).ln()));
        start = end;
    }
    let mut reference: Vec<f64> =
        (first..last).map(|k| power(k) * interpolated(&centres, (k as f64).ln()).exp() / bias).collect();
    if let Some(floor) = floor {
        reference.iter_mut().zip(&floor[first..]).for_each(|(r, l)| *r = r.max(*l));
    }
    standing_out(record, mask, &reference, factor)
}

/// Lines above a fitted model.
pub(crate) fn above_model(bins: &Bins, model: &Model, mask: &mut [bool]) -> Vec<Line> {
    let record = bins.record;
    let (first, last) = (first_density(record), record.density.len() - 1);
    if first >= last {
        return Vec::new();
    }
    let reference: Vec<f64> = match &record.masked {
        Some(masked) => through_mask(bins, model, masked, first..last),
        None => model.densities(&frequencies(record, first..last), bins),
    };
    standing_out(record, mask, &reference, 1.0)
}

/// Frequencies of some densities. \[Hz\]
fn frequencies(record: &Summary, range: std::ops::Range<usize>) -> Vec<f64> {
    range.map(|k| record.frequency(k)).collect()
}

/// Expected densities with missing samples: terms with the effect of the mask, and processes; the effects of a filter and
/// of leakage change slowly with frequency.
pub(crate) fn through_mask(
    bins: &Bins,
    model: &Model,
    masked: &Masked,
    range: std::ops::Range<usize>,
) -> Vec<f64> {
    let mut processes = model.clone().unfiltered();
    let mut terms = [0.0; NOISE_TERMS];
    for (part, theta) in model.parts.iter().zip(&mut processes.theta) {
        if let Part::Term(term) = part {
            terms[term.index()] = std::mem::take(theta);
        }
    }
    let seen = masked.densities(&terms);
    let first = range.start;
    let mut reference = processes.densities(&frequencies(bins.record, range.clone()), bins);
    reference.iter_mut().zip(&seen[range]).for_each(|(density, term)| *density += term);
    if bins.ranges.is_empty() {
        return reference;
    }
    let spectrum = model.spectrum(bins);
    let leaks: Vec<(f64, f64)> = bins
        .ranges
        .iter()
        .enumerate()
        .map(|(i, &(start, stop))| {
            let there = (start..stop).filter(|&k| bins.mask[k]);
            let count = there.clone().count() as f64;
            let plain = there.map(|k| reference[k - first]).sum::<f64>() / count;
            (bins.frequency[bins.low + i].ln(), (spectrum[bins.low + i] / plain).ln())
        })
        .collect();
    for (k, slot) in (first..).zip(&mut reference) {
        *slot *= interpolated(&leaks, bins.record.frequency(k).ln()).exp();
    }
    reference
}

/// Removes lines that are images of others, which the mask of a record with missing samples creates.
pub(crate) fn without_images(record: &Summary, mut lines: Vec<Line>) -> Vec<Line> {
    let Some(masked) = &record.masked else { return lines };
    let spacing = record.frequency(1);
    let number = |f: f64| (f / spacing).round() as usize;
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let mut sharp: Vec<Line> = Vec::new();
    for line in lines {
        let stretch = [(number(line.from), number(line.to) + 1)];
        let power =
            |line: &Line| line.amplitude.powi(2) * masked.line_density(&stretch, line.frequency, spacing);
        let leaked: f64 = sharp.iter().map(power).sum();
        if leaked < IMAGE_SHARE * power(&line) {
            sharp.push(line);
        }
    }
    sharp
}

/// Linear interpolation between points, and extrapolation beyond the first and the last one.
pub(crate) fn interpolated(centres: &[(f64, f64)], x: f64) -> f64 {
    if centres.len() < 2 {
        return centres[0].1;
    }
    let after = centres.partition_point(|c| c.0 < x).clamp(1, centres.len() - 1);
    let ((x0, y0), (x1, y1)) = (centres[after - 1], centres[after]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}

fn standing_out(record: &Summary, mask: &mut [bool], reference: &[f64], factor: f64) -> Vec<Line> {
    let first = first_density(record);
    let freedom = density_freedom(record);
    let count = reference.len();
    let ratio: Vec<f64> = reference.iter().zip(&record.density[first..]).map(|(s, p)| p / s).collect();
    let threshold = chi2_quantile_above(FALSE_ALARM / count as f64, freedom) / freedom * factor;
    let foot = chi2_quantile_above(FOOT_PROBABILITY, freedom) / freedom;
    let high = |range: std::ops::Range<usize>| range.into_iter().any(|k| ratio[k] > foot);
    let mut inside = vec![false; count];
    for i in 0..count {
        if !(ratio[i] > threshold && mask[first + i]) || inside[i] {
            continue;
        }
        let (mut a, mut b) = (i, i);
        while a > 0 && high(a.saturating_sub(2)..a) {
            a -= 1;
        }
        while b + 1 < count && high(b + 1..(b + 3).min(count)) {
            b += 1;
        }
        inside[a.saturating_sub(MARGIN)..=(b + MARGIN).min(count - 1)].fill(true);
    }
    let mut found = Vec::new();
    let mut k = 0;
    let spacing = record.frequency(1);
    while k < count {
        if !inside[k] {
            k += 1;
            continue;
        }
        let start = k;
        while k < count && inside[k] {
            mask[first + k] = false;
            k += 1;
        }
        let peak = (start..k).max_by(|&a, &b| ratio[a].total_cmp(&ratio[b])).unwrap_or(start);
        let power: f64 = (start..k).map(|j| record.density[first + j] - reference[j]).sum();
        let variance: f64 =
            (start..k).map(|j| record.density[first + j].powi(2) * TWICE_SHARED / freedom).sum();
        // Because of missing samples, the rest of its power leaks to other frequencies.
        let captured = record.masked.as_ref().map_or(1.0, |masked| {
            let mean =
                masked.line_density(&[(first + start, first + k)], record.frequency(first + peak), spacing);
            mean * (k - start) as f64
        });
        let (frequency, frequency_error) = frequency_of(record, reference, start..k, peak, power);
        let amplitude = (4.0 * power * spacing / captured).max(0.0).sqrt();
        found.push(Line {
            amplitude,
            error: if amplitude > 0.0 {
                2.0 * spacing * variance.sqrt() / (amplitude * captured)
            } else {
                0.0
            },
            from: record.frequency(first + start),
            to: record.frequency(first + k - 1),
            frequency,
            frequency_error,
        });
    }
    found
}

/// Frequency and its standard error of a line with the highest density `peak`, among densities from `first_density` on. For
/// a steady sinusoid under Hann's taper, the ratio of the amplitudes at the two highest densities determines the frequency
/// between them.
fn frequency_of(
    record: &Summary,
    reference: &[f64],
    range: std::ops::Range<usize>,
    peak: usize,
    power: f64,
) -> (f64, f64) {
    let first = first_density(record);
    let spacing = record.frequency(1);
    let above = |k: usize| (record.density[first + k] - reference[k]).max(0.0);
    let (start, end) = (range.start, range.end - 1);
    let lobe: f64 = (peak.saturating_sub(2).max(start)..=(peak + 2).min(end)).map(above).sum();
    let at = record.frequency(first + peak);
    let width = (end - start) as f64 * spacing;
    if lobe < STEADY_SHARE * power || peak == start || peak == end || above(peak) <= 0.0 {
        return (at, 0.25 * width);
    }
    let side = |k: usize| (above(k) / above(peak)).sqrt();
    let offset = |ratio: f64| ((2.0 * ratio - 1.0) / (ratio + 1.0)).clamp(0.0, 0.5);
    let (lower, higher) = (side(peak - 1), side(peak + 1));
    let between = if higher > lower { offset(higher) } else { -offset(lower) };
    let noise = (reference[peak] / (above(peak) * density_freedom(record))).sqrt();
    (at + between * spacing, spacing * noise.max(FREQUENCY_ERROR))
}
