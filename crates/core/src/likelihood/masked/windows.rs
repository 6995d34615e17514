//! Expected powers of tapered segments with missing samples, from the autocorrelation of taper and mask.
//!
//! With w the weights of a segment times the taper, H = Σ w and q = Σ w², the power of a segment without its level Σ w y/H
//! has the expectation E P(f) = τ₀ Σₗ A(l) [R(l) + c] cos 2πflτ₀ for a covariance R, where c = Σₗ R(l) (A₁(l) − 2 A₂(l))
//! corrects the total power. A, A₁ and A₂ are the sums over the segments of w ⋆ w, q (w ⋆ w)/H² and (w ⋆ w²)/H, divided by
//! Σ q.

use crate::likelihood::masked::cells::Cells;
use crate::likelihood::taper::smooth;
use sigmatau_fft::{Complex64, RealToComplex};
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of points of the window of a density per distance of two densities.
const POINTS_PER_DISTANCE: usize = 8;

/// Sums over the segments of a pass.
pub(super) struct TaperSums {
    length: usize,
    segments: usize,
    /// Distance of the samples whose products form the second spectrum.
    step: usize,
    total: f64,
    /// Spectra of w ⋆ w, and of A₁ − 2 A₂.
    overlap: Vec<f64>,
    level: Vec<f64>,
    /// Power spectra of w² and of w(t) w(t + step), and their cross-spectrum.
    squares: Vec<f64>,
    next: Vec<f64>,
    both: Vec<f64>,
    /// Sum of squares of a complete segment, and number of complete segments, which are added at the end.
    whole: Option<f64>,
    wholes: usize,
    taper: Vec<f64>,
    long: Arc<dyn RealToComplex<f64>>,
    short: Arc<dyn RealToComplex<f64>>,
    first: Vec<Complex64>,
    second: Vec<Complex64>,
    third: Vec<Complex64>,
}

impl TaperSums {
    pub(super) fn new(length: usize, segments: usize, step: usize) -> Self {
        let (long, short) = (sigmatau_fft::forward(2 * length), sigmatau_fft::forward(length));
        Self {
            length,
            segments,
            step,
            total: 0.0,
            overlap: vec![0.0; length + 1],
            level: vec![0.0; length + 1],
            squares: vec![0.0; length / 2 + 1],
            next: vec![0.0; length / 2 + 1],
            both: vec![0.0; length / 2 + 1],
            whole: None,
            wholes: 0,
            taper: Vec::new(),
            first: long.make_output_vec(),
            second: long.make_output_vec(),
            third: short.make_output_vec(),
            long,
            short,
        }
    }

    /// Adds a segment; returns the sum of its squared weights.
    pub(super) fn add(&mut self, mask: &[f64], taper: &[f64]) -> f64 {
        let whole = mask.iter().all(|&m| m >= 1.0);
        if let (true, Some(square_sum)) = (whole, self.whole) {
            self.wholes += 1;
            self.total += square_sum;
            return square_sum;
        }
        let weights: Vec<f64> = mask.iter().zip(taper).map(|(m, h)| m * h).collect();
        let square_sum = self.sum(&weights, 1.0);
        self.total += square_sum;
        if whole {
            self.whole = Some(square_sum);
            self.taper = weights;
        }
        square_sum
    }

    fn sum(&mut self, weights: &[f64], times: f64) -> f64 {
        let level: f64 = weights.iter().sum();
        let square_sum: f64 = weights.iter().map(|w| w * w).sum();
        let mut buffer = weights.to_vec();
        buffer.resize(2 * self.length, 0.0);
        let mut done = self.long.process(&mut buffer, &mut self.first);
        debug_assert!(done.is_ok());
        buffer.fill(0.0);
        buffer.iter_mut().zip(weights).for_each(|(b, w)| *b = w * w);
        done = self.long.process(&mut buffer, &mut self.second);
        debug_assert!(done.is_ok());
        let mut pairs: Vec<f64> = weights.iter().zip(&weights[self.step..]).map(|(a, b)| a * b).collect();
        pairs.resize(self.length, 0.0);
        done = self.short.process(&mut pairs, &mut self.third);
        debug_assert!(done.is_ok());
        for (k, (z, square)) in self.first.iter().zip(&self.second).enumerate() {
            let power = z.norm_sqr();
            self.overlap[k] += times * power;
            self.level[k] +=
                times * (power * square_sum / (level * level) - 2.0 * (z * square.conj()).re / level);
        }
        for (k, z) in self.third.iter().enumerate() {
            let square = self.second[2 * k];
            self.squares[k] += times * square.norm_sqr();
            self.next[k] += times * z.norm_sqr();
            self.both[k] += times * (square * z.conj()).re;
        }
        square_sum
    }

    pub(super) fn windows(mut self, taper: &[f64]) -> Windows {
        if self.wholes > 0 {
            let weights = std::mem::take(&mut self.taper);
            self.sum(&weights, self.wholes as f64);
        }
        let length = self.length;
        let overlap = lags(&self.overlap, 2 * length, length, 1.0 / self.total);
        let level = lags(&self.level, 2 * length, length, 1.0 / self.total);
        let fine = spectrum(&overlap, POINTS_PER_DISTANCE * length);
        let norm = self.segments as f64 / (self.total * self.total);
        let law = |spectrum: &[f64]| lags(spectrum, length, length / 2 + 1, norm);
        let mut squares: Vec<f64> = taper.iter().map(|h| h * h).collect();
        let done = self.short.process(&mut squares, &mut self.third);
        debug_assert!(done.is_ok());
        let whole: Vec<f64> = self.third.iter().map(Complex64::norm_sqr).collect();
        Windows {
            length,
            at_zero: fine.iter().step_by(POINTS_PER_DISTANCE).copied().collect(),
            sums: Running::new(&fine, length),
            level_sums: Running::plain(&spectrum(&level, POINTS_PER_DISTANCE * length)),
            laws: [law(&self.squares), law(&self.both), law(&self.next)],
            law_of_whole: lags(&whole, length, length / 2 + 1, 1.0),
            spread: self.squares.iter().map(|x| x * norm).collect(),
            spread_of_whole: whole,
            overlap,
            level,
        }
    }
}

/// The first lags of an even series from its spectrum.
fn lags(spectrum: &[f64], period: usize, count: usize, factor: f64) -> Vec<f64> {
    let transform = sigmatau_fft::inverse(period);
    let mut input: Vec<Complex64> = spectrum.iter().map(|&x| Complex64::new(x, 0.0)).collect();
    let mut output = transform.make_output_vec();
    let done = transform.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    output[..count].iter().map(|x| x * factor / period as f64).collect()
}

/// Σ over positive and negative lags of x(l) cos 2πkl/period, k = 0 … period/2.
pub(super) fn spectrum(lags: &[f64], period: usize) -> Vec<f64> {
    let transform = sigmatau_fft::forward(period);
    let mut input = transform.make_input_vec();
    for (l, &x) in lags.iter().enumerate() {
        input[l] += x;
        if l > 0 {
            input[period - l] += x;
        }
    }
    let mut output = transform.make_output_vec();
    let done = transform.process(&mut input, &mut output);
    debug_assert!(done.is_ok());
    output.iter().map(|z| z.re).collect()
}

/// Effect of the mask on the powers of a periodogram.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Windows {
    length: usize,
    /// A(l) and A₁(l) − 2 A₂(l).
    overlap: Vec<f64>,
    level: Vec<f64>,
    /// Window of each density at the frequency 0.
    at_zero: Vec<f64>,
    sums: Running,
    level_sums: Running,
    /// Correlations of w², of w² with w(t) w(t + step), and of the latter, by lag; and those of a complete segment.
    pub laws: [Vec<f64>; 3],
    pub law_of_whole: Vec<f64>,
    /// Spectrum of w² for all segments and for a complete segment: the correlation of the noise of two densities.
    pub spread: Vec<f64>,
    pub spread_of_whole: Vec<f64>,
}

impl Windows {
    /// Expected densities of a process with the given covariance by lag; only contrasts count.
    pub(crate) fn expected(&self, covariance: &[f64], tau0: f64) -> Vec<f64> {
        let doubled = |(l, (r, g)): (usize, (&f64, &f64))| if l == 0 { r * g } else { 2.0 * r * g };
        let level: f64 = covariance.iter().zip(&self.level).enumerate().map(doubled).sum();
        let windowed: Vec<f64> =
            self.overlap.iter().zip(covariance).map(|(a, r)| tau0 * a * (r + level)).collect();
        spectrum(&windowed, 2 * self.length).into_iter().step_by(2).collect()
    }

    /// Weights of the cells in the noise between nodes, which the modes do not describe. A weight is the spectrum of
    /// the taper and mask, times the fourth power of a low frequency, because hat functions describe straight lines.
    /// The sum of the weights is half the rate.
    pub(super) fn between_nodes(&self, cells: &Cells, grid: Grid) -> Vec<f64> {
        let (n, tau0) = (grid.spacing as f64, grid.tau0);
        let spacing = 1.0 / (self.length as f64 * tau0);
        let sums = Running::plain(&self.at_zero);
        let cell = |(e, f): (&[f64], &f64)| {
            let comb = ((PI * f * n * tau0).sin() / (PI * f * tau0).sin()).powi(2);
            let different = 1.0 - (comb - n) / (n * (n - 1.0));
            different.powi(2) * (sums.integral_to(e[1] / spacing) - sums.integral_to(e[0] / spacing))
        };
        let mut weights: Vec<f64> = cells.edges.windows(2).zip(&cells.centres).map(cell).collect();
        let scale = 0.5 / (tau0 * weights.iter().sum::<f64>());
        for x in &mut weights {
            *x *= scale;
        }
        weights
    }

    /// Weights of the cells between the edges in a weighted sum of densities.
    pub(crate) fn row(&self, pieces: &[Piece], edges: &[f64], row: &mut [f64]) {
        let points = POINTS_PER_DISTANCE as f64;
        let mut zero = 0.0;
        // The window of a piece is the difference of two sums: at the common end of two pieces, their weights are subtracted.
        let mut ends: Vec<(usize, f64)> = Vec::with_capacity(pieces.len() + 1);
        for &Piece { start, stop, weight } in pieces {
            zero += weight * self.at_zero[start..stop].iter().sum::<f64>();
            match ends.last_mut() {
                Some((end, weights)) if *end == start => *weights -= weight,
                _ => ends.push((start, -weight)),
            }
            ends.push((stop, weight));
        }
        let fine: Vec<f64> = edges.iter().map(|e| e * points).collect();
        let mut below = vec![0.0; edges.len()];
        for (end, weight) in ends {
            let last = points * (end as f64 - 1.0);
            for (slot, e) in below.iter_mut().zip(&fine) {
                *slot += weight * (self.sums.integral_to(last + e) - self.sums.integral_to(last - e));
            }
        }
        for (slot, &e) in below.iter_mut().zip(&fine) {
            *slot += 2.0 * zero * self.level_sums.integral_to(e);
        }
        let whole = points * self.length as f64;
        for (slot, pair) in row.iter_mut().zip(below.windows(2)) {
            *slot = (pair[1] - pair[0]) / whole;
        }
    }
}

/// Neighbouring densities with the same weight in a sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    pub start: usize,
    pub stop: usize,
    pub weight: f64,
}

/// Integral of an even periodic step function whose points are in the middle of the steps.
#[derive(Debug, Clone, PartialEq)]
struct Running {
    first: isize,
    sums: Vec<f64>,
}

impl Running {
    /// For sums with every eighth earlier point, from half a period below 0 to a period above 0.
    fn new(fine: &[f64], length: usize) -> Self {
        let (half, margin) = (POINTS_PER_DISTANCE * length / 2, 4 * POINTS_PER_DISTANCE);
        let first = -((half + margin) as isize);
        let period = 2 * half as isize;
        let at = |x: isize| {
            let x = x.rem_euclid(period);
            fine[x.min(period - x) as usize]
        };
        let mut running: Vec<f64> = Vec::with_capacity(3 * half + 2 * margin);
        let last = (2 * half + margin) as isize;
        for x in first..=last {
            let i = running.len();
            running
                .push(at(x) + if i >= POINTS_PER_DISTANCE { running[i - POINTS_PER_DISTANCE] } else { 0.0 });
        }
        Self::cumulated(first, running)
    }

    fn plain(fine: &[f64]) -> Self {
        Self::cumulated(0, fine.to_vec())
    }

    fn cumulated(first: isize, mut series: Vec<f64>) -> Self {
        let mut sum = 0.0;
        for x in &mut series {
            (sum, *x) = (sum + *x, sum);
        }
        series.push(sum);
        // If the series begins at 0, half of the first step is below 0.
        Self { first, sums: series }
    }

    fn integral_to(&self, x: f64) -> f64 {
        let u = x - self.first as f64 + 0.5;
        let i = (u as usize).min(self.sums.len() - 2);
        self.sums[i] + (self.sums[i + 1] - self.sums[i]) * (u - i as f64)
    }
}

/// Response of the modes of a bin of low frequencies to a process.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LowWindow {
    /// Mean autocorrelation of masses times shapes, doubled beyond the lag 0; times τ₀.
    lags: Vec<f64>,
    /// Weight of the difference of two samples between two nodes.
    within: f64,
}

/// Grid of nodes: samples between two, their number, sample interval.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub spacing: usize,
    pub count: usize,
    pub tau0: f64,
}

/// Lag of nodes above which a covariance is computed from that at their distance and its second derivative.
const SERIES_LAG: usize = 64;

impl Grid {
    /// Covariance of two hat-weighted means by the distance of their nodes, and the variance of a sample minus the mean
    /// covariance of two samples closer than two nodes. `bent` is l² times the second derivative of the covariance at long
    /// distances, in samples.
    pub(super) fn covariance(self, of: impl Fn(usize) -> f64, bent: f64) -> (Vec<f64>, f64) {
        let n = self.spacing;
        let kernel = hat_products(n);
        let half = (kernel.len() / 2) as isize;
        let width: f64 = kernel.iter().zip(-half..).map(|(k, u)| k * (u * u) as f64).sum();
        let lags = (0..self.count)
            .map(|l| {
                let centre = (l * n) as isize;
                if l < SERIES_LAG {
                    return kernel.iter().zip(centre - half..).map(|(k, u)| k * of(u.unsigned_abs())).sum();
                }
                of(l * n) + 0.5 * width * bent / (centre as f64).powi(2)
            })
            .collect();
        let pairs = (n * (n - 1)) as f64;
        let within: f64 = (1..n).map(|k| 2.0 * (n - k) as f64 * of(k)).sum::<f64>() / pairs;
        (lags, of(0) - within)
    }
}

/// Autocorrelation of a hat function that is sampled between its ends, with the sum 1.
fn hat_products(n: usize) -> Vec<f64> {
    // Convolution of four boxes; each pair of samples counts twice.
    let mut series = vec![1.0 / (n as f64).powi(4)];
    for _ in 0..4 {
        let mut sum = 0.0;
        series = (0..series.len() + n - 1)
            .map(|i| {
                sum += series.get(i).copied().unwrap_or(0.0);
                if i >= n {
                    sum -= series[i - n];
                }
                sum
            })
            .collect();
    }
    for _ in 0..2 {
        let at = |i: usize| series.get(i).copied().unwrap_or(0.0);
        series = (0..=series.len()).map(|i| 0.5 * (at(i) + if i > 0 { at(i - 1) } else { 0.0 })).collect();
    }
    series
}

/// Quantities that all bins of the modes share.
pub(super) struct LowModes {
    grid: Grid,
    short: Arc<dyn RealToComplex<f64>>,
    long: Arc<dyn RealToComplex<f64>>,
    /// Response of the hats at the points of the long transform, up to the rate of the nodes; above, it is 0.
    hats: Vec<f64>,
    step: f64,
}

impl LowModes {
    pub(super) fn new(grid: Grid) -> Self {
        let (n, tau0) = (grid.spacing as f64, grid.tau0);
        let period = smooth(POINTS_PER_DISTANCE * grid.count);
        let step = 1.0 / (period as f64 * n * tau0);
        let hats = (0..=period)
            .map(|i| {
                let (sin, cos) = (PI * i as f64 * step * tau0).sin_cos();
                let box_of = if i == 0 { 1.0 } else { (PI * i as f64 / period as f64).sin() / (n * sin) };
                box_of.powi(4) * cos * cos
            })
            .collect();
        let short = sigmatau_fft::forward(smooth(2 * grid.count));
        Self { grid, short, long: sigmatau_fft::forward(period), hats, step }
    }

    /// The response of a bin with the modes `shapes`; `white` are their Σ w² v².
    pub(super) fn window(&self, shapes: &[Vec<f64>], mass: &[f64], white: &[f64]) -> LowWindow {
        let mut output = self.short.make_output_vec();
        let mut input = self.short.make_input_vec();
        let mut power = vec![0.0; output.len()];
        let modes = shapes.len() as f64;
        for v in shapes {
            input.fill(0.0);
            for (slot, (v, c)) in input.iter_mut().zip(v.iter().zip(mass)) {
                *slot = v * c;
            }
            let done = self.short.process(&mut input, &mut output);
            debug_assert!(done.is_ok());
            power.iter_mut().zip(&output).for_each(|(p, z)| *p += z.norm_sqr() / modes);
        }
        let mut lags = lags(&power, input.len(), mass.len(), self.grid.tau0);
        // The part of the white noise in the modes that hats on all samples explain.
        let n = self.grid.spacing as f64;
        let explained = (lags[0] * 2.0 / 3.0 + lags[1] / 3.0) / n;
        let within = self.grid.tau0 * white.iter().sum::<f64>() / modes - explained;
        lags[1..].iter_mut().for_each(|x| *x *= 2.0);
        LowWindow { lags, within }
    }

    /// Weights of the cells in a bin; for `between` see [`Windows::between_nodes`].
    pub(super) fn row(&self, window: &LowWindow, cells: &Cells, between: &[f64]) -> Vec<f64> {
        // An even series with the same sum over both signs.
        let mut input = self.long.make_input_vec();
        let period = input.len();
        for (l, x) in window.lags.iter().enumerate() {
            let half = if l == 0 { 1.0 } else { 0.5 };
            input[l] += half * x;
            if l > 0 {
                input[period - l] += half * x;
            }
        }
        let mut power = self.long.make_output_vec();
        let done = self.long.process(&mut input, &mut power);
        debug_assert!(done.is_ok());
        let seen: Vec<f64> =
            self.hats.iter().enumerate().map(|(i, hat)| hat * power[i.min(period - i)].re).collect();
        let last = seen.len() as f64 - 0.5;
        let sums = Running::plain(&seen);
        let cell = |(e, between): (&[f64], &f64)| {
            let hats = sums.integral_to((e[1] / self.step).min(last))
                - sums.integral_to((e[0] / self.step).min(last));
            2.0 * (hats * self.step + window.within * between)
        };
        cells.edges.windows(2).zip(between).map(cell).collect()
    }
}

impl LowWindow {
    /// Expected density for a covariance of nodes, see [`Grid::covariance`].
    pub(super) fn expected(&self, covariance: &(Vec<f64>, f64)) -> f64 {
        let sum: f64 = self.lags.iter().zip(&covariance.0).map(|(a, r)| a * r).sum();
        sum + self.within * covariance.1
    }
}
