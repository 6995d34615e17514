//! One pass over the samples, which collects in bounded memory all that the likelihood needs.
//!
//! Low frequencies are described by the cosine modes (DCT-II) of the samples, from means and first moments of blocks; high
//! frequencies by Welch's periodogram with Hann's taper. The record is mirrored by half a segment at both ends, so that its
//! ends count like the rest.

use crate::error::{Error, check_memory};
use crate::finite::first_beyond;
use crate::likelihood::modes::{cosine_modes, sine_modes};
use crate::likelihood::summary::{MIN_SAMPLES, MODES, Summary};
use crate::likelihood::taper::PARTS;
use crate::likelihood::taper::{hann, smooth};
use crate::phase::LARGEST_RATE;
use sigmatau_fft::Complex64;
use sigmatau_fft::RealToComplex;
use std::f64::consts::PI;
use std::sync::{Arc, Mutex, PoisonError};

/// Smallest number of blocks; a record with fewer samples has one block per sample. The rate of the blocks is far above
/// the used modes.
/// With block means alone, quantization noise would fold onto the modes, with the density of a phase that has one
/// sample per block: for 2²⁰ samples of a navigation-grade gyro, the standard deviation of N was 1.6 times the bound.
/// With first moments too, the modes equal those of the samples to 3·10⁻⁴ of their amplitude.
const BLOCKS: usize = 131_072;

/// Number of coarse blocks of a record; a segment has the length of 1024 coarse blocks.
const COARSE_BLOCKS: usize = 16_384;

/// Longest block, also of coarse blocks: segments then have 2²⁰ samples, and the memory of a pass is bounded. \[samples\]
const LONGEST_BLOCK: usize = 1024;

/// Length of a segment in coarse blocks.
const COARSE_BLOCKS_PER_SEGMENT: usize = 1024;

/// Number of segments that begin within the length of a segment: segments overlap by three quarters.
const STEPS: usize = 4;

/// Longest record that is described by all its modes, up to half the sampling rate. The periodogram of a few segments loses
/// information at the ends: up to a quarter of a standard error. \[samples\]
const MAX_SHORT: usize = 4 * COARSE_BLOCKS_PER_SEGMENT;

/// Number of values that a pass stores per sample of a segment: spectra by part, windows, buffers of the transform.
const NUMBERS_PER_SAMPLE: usize = 20;

/// Further memory of a pass and of the subsequent analysis. \[bytes\]
const OTHER_BYTES: usize = 32 << 20;

impl Summary {
    /// The summary of a whole record.
    ///
    /// # Errors
    ///
    /// See [`Pass::new`] and [`Pass::push`].
    pub fn of(samples: &[f64], tau0: f64) -> Result<Self, Error> {
        let mut pass = Pass::new(samples.len(), tau0)?;
        pass.push(samples)?;
        pass.finish()
    }
}

/// Taper and transform of segments of one length.
struct Plan {
    taper: Vec<f64>,
    transform: Arc<dyn RealToComplex<f64>>,
}

/// The latest plan, because the channels of a record have segments of the same length.
static LAST: Mutex<Option<Arc<Plan>>> = Mutex::new(None);

impl Plan {
    fn of(segment: usize) -> Arc<Self> {
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some(plan) if plan.taper.len() == segment => Arc::clone(plan),
            _ => {
                let plan = Arc::new(Self { taper: hann(segment), transform: sigmatau_fft::forward(segment) });
                *last = Some(Arc::clone(&plan));
                plan
            }
        }
    }
}

/// The pass itself: samples are pushed in pieces of any length.
pub struct Pass {
    samples: usize,
    tau0: f64,
    block: usize,
    blocks: usize,
    segment: usize,
    segments: usize,
    plan: Arc<Plan>,
    /// Samples, beginning with `oldest`, that later segments need.
    recent: Vec<f64>,
    oldest: usize,
    pushed: usize,
    next_segment: usize,
    /// Means of the blocks, and first moments about their centres over the square of the length of a block.
    means: Vec<f64>,
    moments: Vec<f64>,
    /// Sum of the samples of the current block, and the sum of its running sums.
    block_sum: f64,
    running_total: f64,
    /// First and latest sample.
    first: f64,
    last: f64,
    /// Sums of the squares and of the fourth powers of the differences of neighbouring samples.
    squares: f64,
    fourths: f64,
    parts: Vec<Vec<f64>>,
    counts: [usize; PARTS],
    buffer: Vec<f64>,
    output: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Pass {
    /// A pass over a record with this number of samples.
    ///
    /// # Errors
    ///
    /// [`Error::TooShort`] below [`MIN_SAMPLES`], [`Error::Parameter`] for an interval that is not positive.
    pub fn new(samples: usize, tau0: f64) -> Result<Self, Error> {
        if samples < MIN_SAMPLES {
            return Err(Error::TooShort { need: MIN_SAMPLES, got: samples });
        }
        if !(tau0 > 0.0 && tau0.is_finite()) {
            return Err(Error::Parameter { name: "tau0", value: tau0 });
        }
        let block = (samples / BLOCKS).clamp(1, LONGEST_BLOCK);
        let coarse = coarse_block(samples);
        let segment = if COARSE_BLOCKS_PER_SEGMENT * coarse <= samples / 4 {
            smooth(COARSE_BLOCKS_PER_SEGMENT * coarse)
        } else {
            samples / 4
        };
        check_memory(NUMBERS_PER_SAMPLE * segment * size_of::<f64>() + OTHER_BYTES)?;
        let plan = Plan::of(segment);
        let (output, scratch) = (plan.transform.make_output_vec(), plan.transform.make_scratch_vec());
        Ok(Self {
            samples,
            tau0,
            block,
            blocks: samples / block,
            segment,
            segments: (STEPS * samples).div_ceil(segment),
            plan,
            recent: Vec::new(),
            oldest: 0,
            pushed: 0,
            next_segment: 0,
            means: Vec::with_capacity(samples / block),
            moments: Vec::with_capacity(samples / block),
            block_sum: 0.0,
            running_total: 0.0,
            first: 0.0,
            last: 0.0,
            squares: 0.0,
            fourths: 0.0,
            parts: vec![vec![0.0; output.len()]; PARTS],
            counts: [0; PARTS],
            buffer: vec![0.0; segment],
            output,
            scratch,
        })
    }

    /// Adds the next samples.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] for a sample that is not finite or too large to be squared, [`Error::Length`] for more
    /// samples than announced.
    pub fn push(&mut self, samples: &[f64]) -> Result<(), Error> {
        if self.pushed + samples.len() > self.samples {
            return Err(Error::Length { expected: self.samples, got: self.pushed + samples.len() });
        }
        if let Some(index) = first_beyond(samples, LARGEST_RATE) {
            return Err(Error::NonFinite { index: self.pushed + index });
        }
        // In pieces, so that the stored samples remain few.
        for piece in samples.chunks(self.segment) {
            self.add(piece);
            self.recent.extend_from_slice(piece);
            self.pushed += piece.len();
            self.take_segments();
        }
        Ok(())
    }

    /// Adds samples to the blocks and to the sums of the kurtosis.
    fn add(&mut self, piece: &[f64]) {
        let Some(&first) = piece.first() else { return };
        if self.pushed == 0 {
            (self.first, self.last) = (first, first);
        }
        let mut inside = self.pushed % self.block;
        for &x in piece {
            let step = (x - self.last).powi(2);
            self.squares += step;
            self.fourths += step * step;
            self.last = x;
            self.block_sum += x - self.first;
            self.running_total += self.block_sum;
            inside += 1;
            if inside == self.block {
                let length = self.block as f64;
                self.means.push(self.block_sum / length);
                self.moments
                    .push((0.5 * (length + 1.0) * self.block_sum - self.running_total) / (length * length));
                (self.block_sum, self.running_total) = (0.0, 0.0);
                inside = 0;
            }
        }
    }

    /// Transforms each complete segment, and drops samples that no later segment needs.
    fn take_segments(&mut self) {
        let half = self.segment / 2;
        while self.next_segment < self.segments {
            let padded = self.segment_start(self.next_segment);
            // In the padded record, sample t is at t + half.
            let needed = (padded + self.segment).saturating_sub(half).max(half.saturating_sub(padded));
            if needed.min(self.samples) > self.pushed {
                break;
            }
            self.taper(padded);
            self.transform_segment();
            self.next_segment += 1;
        }
        let keep = if self.next_segment < self.segments {
            let start = self.segment_start(self.next_segment).saturating_sub(half);
            if self.segment_start(self.next_segment) < half {
                0
            } else {
                start.min(self.samples.saturating_sub(half))
            }
        } else {
            self.pushed
        };
        if keep > self.oldest + self.segment || self.next_segment == self.segments {
            let dropped = keep.min(self.pushed) - self.oldest;
            self.recent.drain(..dropped);
            self.oldest += dropped;
        }
    }

    /// Puts the tapered samples of the segment that begins at `padded` of the padded record into the buffer.
    fn taper(&mut self, padded: usize) {
        let (half, length) = (self.segment / 2, self.segment as f64);
        let first = padded.saturating_sub(half);
        if padded >= half && first + self.segment <= self.samples {
            let plain = &self.recent[first - self.oldest..][..self.segment];
            let mean = sum(plain) / length;
            for ((slot, x), h) in self.buffer.iter_mut().zip(plain).zip(&self.plan.taper) {
                *slot = (x - mean) * h;
            }
        } else {
            self.fill(padded);
            let mean = sum(&self.buffer) / length;
            for (x, h) in self.buffer.iter_mut().zip(&self.plan.taper) {
                *x = (*x - mean) * h;
            }
        }
    }

    /// Puts the samples of a segment into the buffer, mirrored beyond the ends of the record.
    fn fill(&mut self, padded: usize) {
        let half = self.segment / 2;
        let before = half.saturating_sub(padded).min(self.segment);
        let first = (padded + before).saturating_sub(half);
        let inside = self.samples.saturating_sub(first).min(self.segment - before);
        let (mirrored, rest) = self.buffer.split_at_mut(before);
        let (plain, after) = rest.split_at_mut(inside);
        for (i, slot) in mirrored.iter_mut().enumerate() {
            *slot = self.recent[half - 1 - padded - i - self.oldest];
        }
        plain.copy_from_slice(&self.recent[first - self.oldest..][..inside]);
        for (i, slot) in after.iter_mut().enumerate() {
            *slot = self.recent[2 * self.samples - 1 - (first + inside + i) - self.oldest];
        }
    }

    fn segment_start(&self, segment: usize) -> usize {
        ((segment as f64 + 0.5) * self.samples as f64 / self.segments as f64) as usize
    }

    fn transform_segment(&mut self) {
        // Lengths match by construction.
        let transform = &self.plan.transform;
        let done = transform.process_with_scratch(&mut self.buffer, &mut self.output, &mut self.scratch);
        debug_assert!(done.is_ok());
        let part = self.next_segment * PARTS / self.segments;
        self.counts[part] += 1;
        for (sum, z) in self.parts[part].iter_mut().zip(&self.output) {
            *sum += z.norm_sqr();
        }
    }

    /// The summary, after all samples.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] if there were fewer samples than announced.
    pub fn finish(mut self) -> Result<Summary, Error> {
        if self.pushed != self.samples {
            return Err(Error::Length { expected: self.samples, got: self.pushed });
        }
        self.take_segments();
        let mut density = vec![0.0; self.output.len()];
        for (part, &count) in self.parts.iter_mut().zip(&self.counts) {
            for (sum, x) in density.iter_mut().zip(part.iter_mut()) {
                *sum += *x * self.tau0 / self.segments as f64;
                *x *= self.tau0 / count.max(1) as f64;
            }
        }
        let mean = self.means.iter().sum::<f64>() / self.blocks as f64;
        self.means.iter_mut().for_each(|b| *b -= mean);
        let steps = (self.samples - 1) as f64;
        let (second, fourth) = (self.squares / steps, self.fourths / steps);
        let root = (self.block as f64 * self.tau0).sqrt();
        let count = if self.samples <= MAX_SHORT {
            self.samples - 1
        } else {
            self.samples / coarse_block(self.samples) / MODES
        };
        let mut modes = cosine_modes(&self.means, count);
        if self.block > 1 {
            // Within a block cos(φ + δ) = cos φ − δ sin φ.
            for ((k, x), sine) in (1..).zip(&mut modes).zip(sine_modes(&mut self.moments, count)) {
                *x -= PI * f64::from(k) / self.blocks as f64 * sine;
            }
        }
        for x in &mut modes {
            *x *= root;
        }
        Ok(Summary {
            samples: self.samples,
            tau0: self.tau0,
            block: self.block,
            blocks: self.blocks,
            segment: self.segment,
            mean: mean + self.first,
            kurtosis: if second > 0.0 { 2.0 * (fourth / (second * second) - 3.0) } else { 0.0 },
            modes,
            density,
            parts: self.parts,
            masked: None,
        })
    }
}

/// The sum, in eight independent parts.
fn sum(x: &[f64]) -> f64 {
    let eights = x.chunks_exact(8);
    let rest: f64 = eights.remainder().iter().sum();
    let mut sums = [0.0; 8];
    for eight in eights {
        for (sum, x) in sums.iter_mut().zip(eight) {
            *sum += x;
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn coarse_block(samples: usize) -> usize {
    (samples / COARSE_BLOCKS).clamp(1, LONGEST_BLOCK)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wiggle(n: usize) -> Vec<f64> {
        (0..n).map(|i| (0.37 * i as f64).sin() + 0.1 * ((i * i % 97) as f64) + 9.8).collect()
    }

    #[test]
    fn chunks_do_not_change_a_bit() {
        for n in [256, 1000, 5000, 70_001] {
            let x = wiggle(n);
            let whole = Summary::of(&x, 0.01).unwrap();
            for size in [1, 77, 4096] {
                let mut pass = Pass::new(n, 0.01).unwrap();
                x.chunks(size).for_each(|piece| pass.push(piece).unwrap());
                assert!(pass.finish().unwrap() == whole, "{n} samples by {size}");
            }
        }
    }

    #[test]
    fn modes_of_blocks_are_those_of_the_samples() {
        // Alternating samples fold into block means, here of 2 samples.
        let n = 2 * BLOCKS;
        let x: Vec<f64> = wiggle(n).iter().zip([0.0, 5.0].iter().cycle()).map(|(x, step)| x + step).collect();
        let s = Summary::of(&x, 1.0).unwrap();
        assert!(s.block == 2);
        let samples = cosine_modes(&x, s.modes.len());
        let size = |modes: &[f64]| modes.iter().map(|x| x * x).sum::<f64>().sqrt();
        let apart: Vec<f64> = samples.iter().zip(&s.modes).map(|(a, b)| a - b).collect();
        assert!(size(&apart) < 2e-4 * size(&samples), "{} of {}", size(&apart), size(&samples));
    }

    #[test]
    fn the_density_integrates_to_the_variance() {
        // Mirrored at the ends, no sample counts less than another.
        let x: Vec<f64> =
            (0..20_000).map(|i| f64::from(u8::from(i < 300)) * (f64::from(i) * 2.1).sin()).collect();
        let s = Summary::of(&x, 0.5).unwrap();
        let power = 2.0 * s.density.iter().sum::<f64>() / (s.segment as f64 * s.tau0);
        let variance = x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64;
        assert!((power / variance - 1.0).abs() < 0.1, "{power} instead of {variance}");
    }
}
