//! Expected densities behind a running mean against their definition, in bins where the mean leaves little noise.

use super::differences::Differences;
use super::expected::covariance;
use super::weights::Weights;
use super::*;
use crate::likelihood::bins::Bins;
use crate::likelihood::expected::Part;
use crate::likelihood::model::Model;
use crate::likelihood::running_mean::RunningMean;
use crate::likelihood::summary::Summary;
use crate::likelihood::taper::hann;
use crate::terms::Term;
use sigmatau_fft::Complex64;
use std::sync::Arc;

const N: usize = 1 << 14;
const LENGTH: usize = 8;

fn spectrum(x: &[f64], period: usize) -> Vec<Complex64> {
    let transform = sigmatau_fft::forward(period);
    let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
    input[..x.len()].copy_from_slice(x);
    transform.process(&mut input, &mut output).unwrap();
    output
}

fn series(spectrum: impl Iterator<Item = Complex64>, period: usize) -> Vec<f64> {
    let transform = sigmatau_fft::inverse(period);
    let (mut input, mut output) = (spectrum.collect::<Vec<_>>(), transform.make_output_vec());
    transform.process(&mut input, &mut output).unwrap();
    output.iter().map(|x| x / period as f64).collect()
}

/// Expected densities of samples with the covariance `lags`: the mean of |Σ w (y − ȳ) e^{iωt}|² over the segments, where y
/// are samples or differences, divided by the gain of the differences.
fn densities(record: &Summary, present: &[bool], differenced: bool, lags: &[f64]) -> Vec<f64> {
    let differences = Differences::new(present, differenced);
    let shown = if differenced { differences.value_mask(present) } else { present.to_vec() };
    let (length, taper) = (record.segment, hann(record.segment));
    let (period, count) = (2 * length, (4 * N).div_ceil(length));
    let mut even: Vec<f64> = (0..length).map(|l| differences.covariance(l, |l| lags[l])).collect();
    even.extend((0..length).map(|l| if l == 0 { 0.0 } else { even[length - l] }).collect::<Vec<_>>());
    let density = spectrum(&even, period);
    let (mut sum, mut total) = (vec![0.0; length / 2 + 1], 0.0);
    for i in 0..count {
        let start = ((i as f64 + 0.5) * N as f64 / count as f64) as isize - (length / 2) as isize;
        let mut w = vec![0.0; length];
        Weights::new(0.0).fill(&shown, start, &mut w);
        w.iter_mut().zip(&taper).for_each(|(w, h)| *w *= h);
        let window = spectrum(&w, period);
        let level = window[0].re;
        total += w.iter().map(|w| w * w).sum::<f64>();
        let overlap = series(window.iter().map(|z| Complex64::new(z.norm_sqr(), 0.0)), period);
        let power = spectrum(&overlap.iter().zip(&even).map(|(a, r)| a * r).collect::<Vec<_>>(), period);
        // Covariance of a sample and the mean, times the weight of the sample.
        let smooth = series(window.iter().zip(&density).map(|(z, s)| z * s), period);
        let with_mean: Vec<f64> = w.iter().zip(&smooth).map(|(w, s)| w * s).collect();
        let of_mean = with_mean.iter().sum::<f64>() / (level * level);
        let with_mean = spectrum(&with_mean, period);
        for (k, slot) in sum.iter_mut().enumerate() {
            let z = window[2 * k];
            *slot +=
                power[2 * k].re - 2.0 * (z.conj() * with_mean[2 * k]).re / level + of_mean * z.norm_sqr();
        }
    }
    sum.iter().zip(differences.gains(length)).map(|(s, gain)| s / (total * gain)).collect()
}

#[test]
fn densities_between_the_zeros_of_a_mean_are_exact() {
    let gaps = |gaps: &[(usize, usize)]| -> Vec<bool> {
        (0..N).map(|t| !gaps.iter().any(|&(start, length)| (start..start + length).contains(&t))).collect()
    };
    let masks = [
        gaps(&[(1500, 800), (4500, 800), (8500, 800), (12_500, 800)]),
        gaps(&[(1500, 20), (2500, 450), (6000, 45), (8511, 150), (10_000, 75), (13_000, 175)]),
    ];
    // Noise of one value a sample behind a mean, from which the mean is recognised.
    let mut state = 39_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let white: Vec<f64> = (0..N + LENGTH).map(|_| (0..6).map(|_| uniform()).sum()).collect();
    let y: Vec<f64> = white.windows(LENGTH).take(N).map(|w| w.iter().sum::<f64>() / LENGTH as f64).collect();
    for (present, differenced) in masks.iter().flat_map(|mask| [(mask, false), (mask, true)]) {
        let weighting = Weighting { taper: 0.0, differences: differenced.then_some(0.0) };
        let mut pass = MaskedPass::new(present.clone(), 1.0, weighting).unwrap();
        pass.push(&y).unwrap();
        let record = pass.finish().unwrap();
        let (mean, mask) = RunningMean::of(&record).unwrap();
        assert_eq!(mean.length as usize, LENGTH);
        let bins = Bins::new(&record, Arc::new(mask), Arc::new(Vec::new()));
        let whole: Vec<usize> = (0..bins.ranges.len())
            .filter(|&i| bins.mask[bins.ranges[i].0..bins.ranges[i].1].iter().all(|&used| used))
            .collect();
        assert!(whole.len() > 50);
        for part in [Term::RandomWalk, Term::BiasInstability, Term::RateRandomWalk].map(Part::Term) {
            if !differenced && part != Part::Term(Term::RandomWalk) {
                continue; // what leaks from low frequencies is known less well, see `tests`
            }
            let weight = |j: isize| (LENGTH - j.unsigned_abs()) as f64 / (LENGTH * LENGTH) as f64;
            let range = 1 - LENGTH as isize..LENGTH as isize;
            let lag = |l: usize, j: isize| covariance(part, (l as isize + j).unsigned_abs(), 1.0);
            let lags: Vec<f64> =
                (0..=record.segment).map(|l| range.clone().map(|j| weight(j) * lag(l, j)).sum()).collect();
            let exact = densities(&record, present, differenced, &lags);
            let model = Model { mean: Some(mean), theta: vec![1.0], ..Model::new(vec![part], Vec::new()) };
            let expected = model.spectrum(&bins);
            let errors: Vec<f64> = whole
                .iter()
                .map(|&i| {
                    let (start, stop) = bins.ranges[i];
                    let exact = exact[start..stop].iter().sum::<f64>() / (stop - start) as f64;
                    expected[bins.low + i] / exact - 1.0
                })
                .collect();
            let bias = errors.iter().sum::<f64>() / errors.len() as f64;
            let worst = errors.iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
            let most = match part {
                Part::Term(Term::RandomWalk) => [1e-4, 0.004],
                Part::Term(Term::BiasInstability) => [0.002, 0.015],
                _ => [0.004, 0.03],
            };
            assert!(bias.abs() < most[0] && worst < most[1], "{differenced}, {part:?}: {bias}, {worst}");
        }
    }
}
