//! Expected powers against the dense covariance of all samples, and what a pass refuses.

use super::differences::Differences;
use super::expected::covariance;
use super::weights::Weights;
use super::*;
use crate::error::Error;
use crate::likelihood::bins::{Bins, usable};
use crate::likelihood::expected::{Part, TERMS};
use crate::likelihood::summary::Summary;
use crate::likelihood::taper::hann;
use crate::terms::Term;
use std::f64::consts::PI;
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

/// Adds `scale` times c(l), defined by Σ a(s) a(t) R(|s − t|) = Σ c(l) R(l) for any R.
fn add_products(c: &mut [f64], a: &[f64], scale: f64) {
    for lag in 0..a.len() {
        let products = a.iter().zip(&a[lag..]).map(|(s, t)| s * t).sum::<f64>();
        c[lag] += scale * if lag == 0 { 1.0 } else { 2.0 } * products;
    }
}

/// Expected power for products of weights `c` and the autocovariance R(l).
fn variance(c: &[f64], lags: &[f64]) -> f64 {
    c.iter().zip(lags).map(|(c, r)| c * r).sum()
}

/// Summed products of the weights of the samples in some modes.
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
    let there = if differenced { differences.value_mask(present) } else { present.to_vec() };
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
            let gain =
                if step == 0 { 1.0 } else { 4.0 * (PI * (k * step) as f64 / length as f64).sin().powi(2) };
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
                    let errors = checked.iter().map(|(k, c)| (column[*k] / variance(c, &lags) - 1.0).abs());
                    errors.fold(0.0, f64::max)
                });
                // The level of a segment is correct over all frequencies together, not for each. Differences have no
                // low-frequency power that leaks.
                let [modes, densities] = match part {
                    Part::Term(Term::RandomWalk) => [1e-9, 0.05],
                    Part::Term(Term::Quantization) => [0.01, 0.05],
                    Part::Term(Term::BiasInstability) => [0.06, 0.25],
                    Part::Term(Term::RateRandomWalk) => [0.02, 0.4],
                    _ => [0.03, 0.4],
                };
                let differenced = weighting.differences.is_some();
                let densities = match part {
                    Part::Term(Term::Quantization) if differenced => 0.1,
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
    // R of a density by its cosine transform, for a filtered process or a narrow-band process.
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
            let at = bins.column(Part::Term(Term::RandomWalk));
            let cells = bins.cosines_high[0].iter().map(|c| (a * c).exp()).collect();
            let low = bins.cosines_low[0].iter().map(|c| (a * c).exp()).collect();
            let whole = |i: &usize| bins.mask[bins.ranges[*i].0..bins.ranges[*i].1].iter().all(|&used| used);
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
                    assert!(error.abs() < 0.1, "{name}, {weighting:?}, {what}, bin {i}: {got} for {exact}");
                }
                // The leakage into one mode depends on the mask between two nodes; only its mean is known.
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
            let y: Vec<f64> =
                (0..N).map(|t| if present[t] { ((t * t) as f64 * 0.37).sin() } else { f64::NAN }).collect();
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
    assert!(matches!(MaskedPass::new(few, 1.0, Weighting::default()), Err(Error::TooShort { got: 200, .. })));
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
