//! One pass over the samples of a record with missing ones.
//!
//! At low frequencies, the samples are summed with the weights of hat functions on a grid of nodes; the modes of a loaded
//! string combine these sums. At high frequencies, the periodogram is that of segments with zeros for missing samples. The
//! mask is known before the pass; only the samples of one segment are kept.

use crate::error::Error;
use crate::likelihood::masked::differences::Differences;
use crate::likelihood::masked::mask::{MIN_PAIRS, MaskSums, Masked};
use crate::likelihood::masked::nodes::Nodes;
use crate::likelihood::masked::weights::Weights;
use crate::likelihood::masked::windows::TaperSums;
use crate::likelihood::summary::{MIN_SAMPLES, Summary};
use crate::likelihood::taper::PARTS;
use crate::likelihood::taper::{hann, smooth};
use sigmatau_fft::{Complex64, RealToComplex};
use std::sync::Arc;

/// Smallest number of stretches between two nodes that contain a sample.
const MIN_NODES: usize = 64;

/// Smallest number of nodes of a record, and of samples between two of them.
const NODES: usize = 2048;
const MIN_SPACING: usize = 8;

/// Length of a segment over the distance of two nodes.
const SEGMENT: usize = 128;

/// Segments overlap by three quarters.
const STEPS: usize = 4;

/// Largest taper at the ends of runs, over the distance of two nodes.
const MAX_TAPER: f64 = 2.0;

/// The same for segments: in samples, and as a share of the mean length of a run. Stronger tapering would spread
/// quantization noise into its minimum.
const MAX_TAPER_HIGH: f64 = 32.0;
const TAPERED_SHARE: f64 = 0.125;

/// Smallest number of samples in a segment; with fewer it is left out.
const MIN_IN_SEGMENT: f64 = 8.0;

/// Results of a first pass that determine the weights of a second one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Weighting {
    /// Number of samples over which the weights of a run fall to 0 at its ends.
    pub taper: f64,
    /// The same number for runs of differences, if the segments contain differences instead of samples.
    pub differences: Option<f64>,
}

/// The pass: samples are pushed in pieces of any length.
pub struct MaskedPass {
    present: Vec<bool>,
    /// Mask of the differences, if the segments contain them.
    pairs_at: Option<Vec<bool>>,
    differences: Differences,
    count: usize,
    tau0: f64,
    nodes: Nodes,
    segments: Segments,
    pushed: usize,
    level: Option<f64>,
    sum: f64,
    neighbours: usize,
    pairs: usize,
    squares: f64,
    fourths: f64,
    /// The samples of a piece, preceded by the previous samples up to one step back.
    piece: Vec<f64>,
    steps: Vec<f64>,
}

impl MaskedPass {
    /// A pass over a record with as many samples as the mask. For `weighting` see [`Summary::weighting`]; a first pass uses
    /// the default.
    ///
    /// # Errors
    ///
    /// [`Error::TooShort`] for fewer than [`MIN_SAMPLES`] present samples, or samples too concentrated to determine
    /// low frequencies; [`Error::Parameter`] for an interval that is not positive.
    pub fn new(present: Vec<bool>, tau0: f64, weighting: Weighting) -> Result<Self, Error> {
        let samples = present.len();
        let count = present.iter().filter(|&&there| there).count();
        if count < MIN_SAMPLES {
            return Err(Error::TooShort { need: MIN_SAMPLES, got: count });
        }
        if !(tau0 > 0.0 && tau0.is_finite()) {
            return Err(Error::Parameter { name: "tau0", value: tau0 });
        }
        let spacing = (samples / NODES).max(MIN_SPACING);
        let filled = present.chunks(spacing).filter(|piece| piece.contains(&true)).count();
        if filled < MIN_NODES {
            return Err(Error::TooShort { need: MIN_NODES * spacing, got: count });
        }
        let differences = Differences::new(&present, weighting.differences.is_some());
        let pairs_at = differences.used.then(|| differences.value_mask(&present));
        let taper = weighting.taper.min(MAX_TAPER * spacing as f64);
        let shown = pairs_at.as_ref().unwrap_or(&present);
        let runs = shown.windows(2).filter(|p| !p[0] && p[1]).count() + usize::from(shown[0]);
        let there = shown.iter().filter(|&&there| there).count();
        let high = weighting.differences.unwrap_or(taper);
        let high = high.min(TAPERED_SHARE * there as f64 / runs as f64).min(MAX_TAPER_HIGH);
        let segment = (SEGMENT * spacing).min(samples / 4);
        let segment = if segment < samples / 4 { smooth(segment) } else { segment - segment % 2 };
        Ok(Self {
            nodes: Nodes::new(samples, spacing, Weights::new(taper)),
            segments: Segments::new(samples, segment, differences.step, Weights::new(high)),
            neighbours: present.windows(2).filter(|p| p[0] && p[1]).count(),
            piece: vec![0.0; differences.step],
            steps: Vec::new(),
            pairs_at,
            differences,
            present,
            count,
            tau0,
            pushed: 0,
            level: None,
            sum: 0.0,
            pairs: 0,
            squares: 0.0,
            fourths: 0.0,
        })
    }

    /// Adds the next samples; missing samples may have any value.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] for a present sample that is not finite or too large to be squared, [`Error::Length`] for more
    /// samples than the mask has.
    pub fn push(&mut self, samples: &[f64]) -> Result<(), Error> {
        if self.pushed + samples.len() > self.present.len() {
            return Err(Error::Length { expected: self.present.len(), got: self.pushed + samples.len() });
        }
        let step = self.differences.step;
        for piece in samples.chunks(self.segments.length) {
            let end = self.pushed + piece.len();
            let there = &self.present[self.pushed..end];
            let seen = self.piece.len() - step;
            self.piece.drain(..seen);
            self.steps.clear();
            for (i, (&x, &there)) in piece.iter().zip(there).enumerate() {
                if !there {
                    self.piece.push(0.0);
                    self.steps.push(0.0);
                    continue;
                }
                let at = self.pushed + i;
                if !x.is_finite() || x.abs() > crate::phase::LARGEST_RATE {
                    return Err(Error::NonFinite { index: at });
                }
                let x = x - *self.level.get_or_insert(x);
                let paired = at >= step && self.present[at - step];
                let difference = if paired { x - self.piece[i] } else { 0.0 };
                if paired {
                    let square = difference * difference;
                    self.squares += square;
                    self.fourths += square * square;
                    self.pairs += 1;
                }
                self.sum += x;
                self.piece.push(x);
                self.steps.push(difference);
            }
            self.nodes.take(&self.present, self.pushed, &self.piece[step..]);
            self.pushed = end;
            match &self.pairs_at {
                Some(pairs_at) => self.segments.take(pairs_at, end, &self.steps),
                None => self.segments.take(&self.present, end, &self.piece[step..]),
            }
        }
        Ok(())
    }

    /// The summary, after all samples.
    ///
    /// # Errors
    ///
    /// [`Error::Length`] if there were fewer samples than the mask has.
    pub fn finish(self) -> Result<Summary, Error> {
        if self.pushed != self.present.len() {
            return Err(Error::Length { expected: self.present.len(), got: self.pushed });
        }
        let (samples, tau0) = (self.present.len(), self.tau0);
        let Segments { length: segment, taper, mut density, mut parts, totals, sums, .. } = self.segments;
        let total: f64 = totals.iter().sum();
        let gains = self.differences.gains(segment);
        for (x, gain) in density.iter_mut().zip(&gains) {
            *x *= tau0 / (total * gain);
        }
        for (part, own) in parts.iter_mut().zip(&totals) {
            for (x, gain) in part.iter_mut().zip(&gains) {
                *x *= if *own > 0.0 { tau0 / (own * gain) } else { 0.0 };
            }
        }
        let (spacing, blocks) = (self.nodes.spacing, self.nodes.count);
        let string = self.nodes.solve(tau0);
        let windows = sums.windows(&taper);
        let mut record = Summary {
            samples,
            tau0,
            block: spacing,
            blocks,
            segment,
            mean: self.level.unwrap_or(0.0) + self.sum / self.count as f64,
            kurtosis: kurtosis(self.pairs, self.squares, self.fourths),
            modes: string.modes.clone(),
            density,
            parts,
            masked: None,
        };
        let parts = totals.map(|own| own / total);
        let seen = MaskSums {
            present: self.count,
            neighbours: self.neighbours,
            pairs: self.pairs,
            square: self.squares / self.pairs.max(1) as f64,
            differences: self.differences,
            gains,
            parts,
        };
        let masked = Masked::new(seen, string, windows, &record);
        record.masked = Some(Arc::new(masked));
        Ok(record)
    }
}

fn kurtosis(pairs: usize, squares: f64, fourths: f64) -> f64 {
    let (second, fourth) = (squares / pairs as f64, fourths / pairs as f64);
    if pairs < MIN_PAIRS || second <= 0.0 {
        return 0.0;
    }
    2.0 * (fourth / (second * second) - 3.0)
}

/// Sums over the segments: powers of the record, and the effect of the mask on the taper.
struct Segments {
    samples: usize,
    length: usize,
    count: usize,
    next: usize,
    weights: Weights,
    taper: Vec<f64>,
    /// Samples, beginning with `oldest`, that later segments need.
    recent: Vec<f64>,
    oldest: usize,
    density: Vec<f64>,
    parts: Vec<Vec<f64>>,
    /// Sums of squared weights in each part of the record.
    totals: [f64; PARTS],
    sums: TaperSums,
    transform: Arc<dyn RealToComplex<f64>>,
    mask: Vec<f64>,
    buffer: Vec<f64>,
    output: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Segments {
    fn new(samples: usize, length: usize, step: usize, weights: Weights) -> Self {
        let count = (STEPS * samples).div_ceil(length);
        let transform = sigmatau_fft::forward(length);
        let (output, scratch) = (transform.make_output_vec(), transform.make_scratch_vec());
        Self {
            samples,
            length,
            count,
            next: 0,
            weights,
            taper: hann(length),
            recent: Vec::new(),
            oldest: 0,
            density: vec![0.0; output.len()],
            parts: vec![vec![0.0; output.len()]; PARTS],
            totals: [0.0; PARTS],
            sums: TaperSums::new(length, count, step),
            mask: vec![0.0; length],
            buffer: vec![0.0; length],
            output,
            scratch,
            transform,
        }
    }

    /// First sample of a segment; negative for the first segments.
    fn segment_start(&self, segment: usize) -> isize {
        let centre = (segment as f64 + 0.5) * self.samples as f64 / self.count as f64;
        centre as isize - (self.length / 2) as isize
    }

    fn take(&mut self, present: &[bool], pushed: usize, piece: &[f64]) {
        self.recent.extend_from_slice(piece);
        while self.next < self.count {
            let start = self.segment_start(self.next);
            let end = start + self.length as isize;
            if end.min(self.samples as isize) > pushed as isize {
                break;
            }
            self.segment(present, start);
            self.next += 1;
        }
        let needed =
            if self.next < self.count { self.segment_start(self.next).max(0) as usize } else { pushed };
        if needed > self.oldest + self.length || self.next == self.count {
            let gone = needed.min(pushed) - self.oldest;
            self.recent.drain(..gone);
            self.oldest += gone;
        }
    }

    fn segment(&mut self, present: &[bool], start: isize) {
        self.weights.fill(present, start, &mut self.mask);
        if self.mask.iter().sum::<f64>() < MIN_IN_SEGMENT {
            return;
        }
        let (mut sum, mut weighted) = (0.0, 0.0);
        let oldest = self.oldest as isize;
        for (i, (slot, (m, h))) in self.buffer.iter_mut().zip(self.mask.iter().zip(&self.taper)).enumerate() {
            let at = start + i as isize - oldest;
            *slot = if *m > 0.0 { self.recent[at as usize] } else { 0.0 };
            sum += m * h;
            weighted += m * h * *slot;
        }
        let level = weighted / sum;
        for (slot, (m, h)) in self.buffer.iter_mut().zip(self.mask.iter().zip(&self.taper)) {
            *slot = m * h * (*slot - level);
        }
        let done = self.transform.process_with_scratch(&mut self.buffer, &mut self.output, &mut self.scratch);
        debug_assert!(done.is_ok());
        let own = self.sums.add(&self.mask, &self.taper);
        let part = self.next * PARTS / self.count;
        self.totals[part] += own;
        for ((all, part), z) in self.density.iter_mut().zip(&mut self.parts[part]).zip(&self.output) {
            *all += z.norm_sqr();
            *part += z.norm_sqr();
        }
    }
}
