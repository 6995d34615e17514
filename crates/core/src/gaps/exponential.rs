//! Expected Allan variances of exponentially correlated noise of variance 1 in clusters with missing samples.
//!
//! With γ(l) = 1 − pˡ the expectation is −½·Σ aᵢaⱼ·γ(|i − j|)·2 = X/(m₁m₂) − W₁/m₁² − W₂/m₂², because the weights add up
//! to nothing: W sums γ over the pairs of samples within a cluster, X over those of which one is in each. In γ nothing
//! large cancels where the correlation is long against the cluster, which is where pˡ would lose all digits.
//!
//! The sums over a cluster are made from those over its pieces: a window that slides by one piece is the end of one block
//! of pieces and the beginning of the next, so that every window takes one join and nothing is ever subtracted.

// One lane of several arrays at a time: what becomes vectors.
#![allow(clippy::needless_range_loop)]

use pulp::{Arch, Simd, WithSimd};

/// Processes that are worked on together.
pub(super) const LANES: usize = 8;

/// Pieces of a cluster of at least this many samples: clusters then begin at every piece only, and those between are taken
/// to be like their neighbours.
pub(super) const LEAST_PIECES: usize = 64;

type Lanes = [f64; LANES];

/// Sums over the samples of a stretch that are there, for γ of each process.
#[derive(Clone, Copy, Default)]
struct Stretch {
    count: f64,
    /// Σ γ of the distance to the end, which is the index after the last.
    to_end: Lanes,
    /// Σ γ of the distance from the beginning.
    from_start: Lanes,
    /// Σ γ of the distances of all pairs.
    pairs: Lanes,
}

/// How a process forgets over a number of samples: pˡ and 1 − pˡ.
#[derive(Clone, Copy, Default)]
struct Fading {
    kept: Lanes,
    lost: Lanes,
}

impl Fading {
    fn over(samples: usize, rates: &Lanes) -> Self {
        let exponents = rates.map(|rate| -rate * samples as f64);
        Self { kept: exponents.map(f64::exp), lost: exponents.map(|x| -x.exp_m1()) }
    }
}

/// Σ γ over the pairs of a sample of `a` and a sample of `b` that follows it.
#[inline(always)]
#[allow(clippy::inline_always)] // Into a function that is compiled for the vectors that the processor has.
fn between(a: &Stretch, b: &Stretch) -> Lanes {
    let mut sums = [0.0; LANES];
    for lane in 0..LANES {
        sums[lane] = a.to_end[lane] * (b.count - b.from_start[lane]) + a.count * b.from_start[lane];
    }
    sums
}

/// `a`, of length `fading_a`, and `b` after it.
#[inline(always)]
#[allow(clippy::inline_always)] // Into a function that is compiled for the vectors that the processor has.
fn join(a: &Stretch, fading_a: &Fading, b: &Stretch, fading_b: &Fading) -> Stretch {
    let cross = between(a, b);
    let mut both = Stretch { count: a.count + b.count, ..Stretch::default() };
    for lane in 0..LANES {
        both.pairs[lane] = a.pairs[lane] + b.pairs[lane] + cross[lane];
        both.to_end[lane] =
            a.to_end[lane] * fading_b.kept[lane] + a.count * fading_b.lost[lane] + b.to_end[lane];
        both.from_start[lane] =
            a.from_start[lane] + b.count * fading_a.lost[lane] + b.from_start[lane] * fading_a.kept[lane];
    }
    both
}

/// A piece, sample by sample.
#[inline(always)]
#[allow(clippy::inline_always)] // Into a function that is compiled for the vectors that the processor has.
fn piece(there: &[bool], one: &Fading) -> Stretch {
    let mut sums = Stretch::default();
    let mut distance = [0.0; LANES];
    for &there in there {
        let v = f64::from(u8::from(there));
        let count = sums.count + v;
        for lane in 0..LANES {
            sums.pairs[lane] += v * sums.to_end[lane];
            sums.from_start[lane] += v * distance[lane];
            sums.to_end[lane] = sums.to_end[lane] * one.kept[lane] + count * one.lost[lane];
            distance[lane] = distance[lane] * one.kept[lane] + one.lost[lane];
        }
        sums.count = count;
    }
    sums
}

/// Means over the pairs of clusters of `pieces` pieces of `length` samples that begin at piece j, each counted
/// `weights[j]` times.
///
/// `rates` are −ln p of each process; 0 < rate.
pub(super) fn mean(there: &[bool], pieces: usize, length: usize, weights: &[f64], rates: &Lanes) -> Lanes {
    Arch::new().dispatch(Mean { there, pieces, length, weights, rates })
}

/// The arguments of [`mean`].
struct Mean<'a> {
    there: &'a [bool],
    pieces: usize,
    length: usize,
    weights: &'a [f64],
    rates: &'a Lanes,
}

impl WithSimd for Mean<'_> {
    type Output = Lanes;

    #[inline(always)]
    #[allow(clippy::inline_always)] // As above.
    fn with_simd<S: Simd>(self, _: S) -> Lanes {
        let Self { there, pieces, length, weights, rates } = self;
        let one = Fading::over(1, rates);
        let fadings: Vec<Fading> = (0..=pieces).map(|k| Fading::over(k * length, rates)).collect();
        let of_piece = fadings[1];
        let all = there.len() / length;
        let read = |k: usize| piece(&there[k * length..(k + 1) * length], &one);

        let mut block: Vec<Stretch> = (0..pieces.min(all)).map(read).collect();
        // Ends of the block, from each of its pieces on.
        let mut ends = vec![Stretch::default(); pieces];
        // Windows that begin in the block before.
        let mut before: Vec<Stretch> = Vec::new();
        let mut windows = vec![Stretch::default(); pieces];
        let mut sums = [0.0; LANES];
        let mut weight = 0.0;
        let mut first = 0;
        while first + pieces <= all {
            let mut end = block[pieces - 1];
            ends[pieces - 1] = end;
            for r in (0..pieces - 1).rev() {
                end = join(&block[r], &of_piece, &end, &fadings[pieces - 1 - r]);
                ends[r] = end;
            }
            let mut beginning = Stretch::default();
            block.clear();
            for r in 0..pieces {
                // A window that begins at piece first + r takes r pieces of the next block.
                if r > 0 {
                    let next = first + pieces + r - 1;
                    if next >= all {
                        break;
                    }
                    let piece = read(next);
                    beginning = join(&beginning, &fadings[r - 1], &piece, &of_piece);
                    block.push(piece);
                }
                let window = join(&ends[r], &fadings[pieces - r], &beginning, &fadings[r]);
                windows[r] = window;
                let Some(earlier) = before.get(r) else { continue };
                // Two clusters, the first of which begins a block before.
                let w = weights.get(first - pieces + r).copied().unwrap_or_default();
                if w == 0.0 {
                    continue;
                }
                weight += w;
                let cross = between(earlier, &window);
                let (r1, r2) = (1.0 / earlier.count, 1.0 / window.count);
                for lane in 0..LANES {
                    sums[lane] += w
                        * (cross[lane] * r1 * r2
                            - earlier.pairs[lane] * r1 * r1
                            - window.pairs[lane] * r2 * r2);
                }
            }
            first += pieces;
            while block.len() < pieces && first + block.len() < all {
                block.push(read(first + block.len()));
            }
            std::mem::swap(&mut before, &mut windows);
            windows.resize(pieces, Stretch::default());
        }
        sums.map(|sum| sum / weight)
    }
}
