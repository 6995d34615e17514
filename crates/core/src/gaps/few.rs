//! The Allan variance of a record with few missing samples: most pairs at neighbouring starts lack the same
//! samples.

use super::sums::{BLOCK, Block, mean_of};
use crate::allan::Estimate;
use crate::compensated::Sum;
use pulp::{Arch, Simd, WithSimd};

/// Places of the first starts, one for each lane of the widest vectors.
const FIRST_PLACES: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// Number of starts whose sums stay in a second-level cache.
const STRETCH: usize = 8192;

/// Running sums over the present samples, and the places of the missing ones.
pub(super) struct Points {
    /// Sum before each sample and at the end, without the mean, in two parts, because a single float would
    /// lose digits for a drifting rate.
    high: Vec<f64>,
    low: Vec<f64>,
    missing: Vec<usize>,
    /// Cumulative sums of these places: integers, exact for records up to 10⁸ samples.
    places: Vec<f64>,
}

impl Points {
    /// Sums of samples that are NaN at the places `missing`, which are ascending.
    pub(super) fn of(rate: &[f64], missing: Vec<usize>) -> Self {
        let mean = mean_of(rate);
        let (mut high, mut low) = (Vec::with_capacity(rate.len() + 1), Vec::with_capacity(rate.len() + 1));
        let mut sum = Sum::default();
        for &y in std::iter::once(&f64::NAN).chain(rate) {
            if !y.is_nan() {
                sum.add(y - mean);
            }
            high.push(sum.hi);
            low.push(sum.lo);
        }
        let mut places = vec![0.0];
        let mut place = 0.0;
        for &k in &missing {
            place += k as f64;
            places.push(place);
        }
        Self { high, low, missing, places }
    }

    /// Averages over the pairs of clusters of each size of the first `used` samples, that begin at every `step`-th sample.
    ///
    /// All sizes are computed for a stretch of starts while its sums are in the cache.
    pub(super) fn estimates(
        &self,
        used: usize,
        sizes: &[usize],
        step: impl Fn(usize) -> usize,
    ) -> Vec<Estimate> {
        let mut running: Vec<Running> = sizes
            .iter()
            .map(|&m| Running { m, step: step(m), starts: used + 1 - 2 * m, ..Running::default() })
            .collect();
        for stretch in (0..used).step_by(STRETCH) {
            for size in &mut running {
                size.add_starts(self, stretch + STRETCH);
            }
        }
        running.iter().map(Running::estimate).collect()
    }

    fn block(&self, weights: &Weights, first: usize, last: usize, m: usize, step: usize) -> Block {
        let window =
            |shift: usize| (&self.high[first + shift..last + shift], &self.low[first + shift..last + shift]);
        let windows = [window(0), window(m), window(2 * m)];
        if step > 1 {
            weights.sums(windows, 0, step)
        } else {
            Arch::new().dispatch(AllStarts { weights, windows })
        }
    }
}

/// Sums for one size, up to some start.
#[derive(Default)]
struct Running {
    m: usize,
    step: usize,
    starts: usize,
    next: usize,
    pair: Pair,
    pairs: usize,
    squares: Sum,
    products: Sum,
    distances: Sum,
}

impl Running {
    /// Adds the starts before `end`.
    fn add_starts(&mut self, points: &Points, end: usize) {
        let end = end.min(self.starts);
        while self.next < end {
            let first = self.next;
            self.pair.advance(points, first, self.m);
            // From `first` to `last`, neither cluster gains or loses a missing sample.
            let last = self.pair.end(points, self.m).min(end).min(first + BLOCK * self.step);
            let count = (last - first).div_ceil(self.step);
            if let Some(weights) = self.pair.weights(points, first, self.m) {
                let block = points.block(&weights, first, last, self.m, self.step);
                self.pairs += count;
                self.squares.add(block.squares);
                self.products.add(block.products);
                self.distances.add(block.distances);
            }
            self.next = first + count * self.step;
        }
    }

    fn estimate(&self) -> Estimate {
        // Without a pair both are 0 / 0.
        let avar = self.squares.value() / (2.0 * self.pairs as f64);
        Estimate { m: self.m, avar, pairs: self.pairs, ramp: self.products.value() / self.distances.value() }
    }
}

/// Number of missing samples before the beginning, the middle and the end of a pair of clusters.
#[derive(Clone, Copy, Default)]
struct Pair([usize; 3]);

impl Pair {
    /// Moves to the pair that begins at `start`, which must not be before that of the last call.
    fn advance(&mut self, points: &Points, start: usize, m: usize) {
        for (before, edge) in self.0.iter_mut().zip([start, start + m, start + 2 * m]) {
            while points.missing.get(*before).is_some_and(|&place| place < edge) {
                *before += 1;
            }
        }
    }

    /// The next start at which the set of missing samples changes.
    fn end(self, points: &Points, m: usize) -> usize {
        let edges = self.0.iter().zip([0, m, 2 * m]);
        let next = edges.map(|(&before, shift)| {
            points.missing.get(before).map_or(usize::MAX, |&place| place + 1 - shift)
        });
        next.min().unwrap_or(usize::MAX)
    }

    /// The weights of the sums of this pair, if both clusters are at least half full.
    fn weights(self, points: &Points, start: usize, m: usize) -> Option<Weights> {
        let [a, b, c] = self.0;
        let (missing1, missing2) = (b - a, c - b);
        if 2 * missing1 > m || 2 * missing2 > m {
            return None;
        }
        let (r1, r2) = (1.0 / (m - missing1) as f64, 1.0 / (m - missing2) as f64);
        let place = |k: usize| points.places[k];
        // Sum of the sample times of a cluster, from the start of the pair, minus the times of missing
        // samples.
        let (m, start) = (m as f64, start as f64);
        let all = 0.5 * m * (m - 1.0);
        let t1 = all - (place(b) - place(a) - start * missing1 as f64);
        let t2 = all + m * m - (place(c) - place(b) - start * missing2 as f64);
        Some(Weights {
            r1,
            r2,
            distance: t2 * r2 - t1 * r1,
            slope: missing2 as f64 * r2 - missing1 as f64 * r1,
        })
    }
}

/// Weights of the sums of consecutive pairs that lack the same samples.
struct Weights {
    /// Reciprocal of the number of samples in each cluster.
    r1: f64,
    r2: f64,
    /// Distance of the mean times of the first pair, and its change per start.
    distance: f64,
    slope: f64,
}

/// Running sums, in two parts, at consecutive starts.
type Window<'a> = (&'a [f64], &'a [f64]);

impl Weights {
    /// Sums over every `step`-th of the starts from `from` on.
    fn sums(&self, [first, middle, last]: [Window; 3], from: usize, step: usize) -> Block {
        let mut sums = Block::default();
        for k in (from..first.0.len()).step_by(step) {
            let s1 = (middle.0[k] - first.0[k]) + (middle.1[k] - first.1[k]);
            let s2 = (last.0[k] - middle.0[k]) + (last.1[k] - middle.1[k]);
            let z = s2 * self.r2 - s1 * self.r1;
            let d = self.distance + k as f64 * self.slope;
            sums.squares += z * z;
            sums.products += z * d;
            sums.distances += d * d;
        }
        sums
    }
}

/// [`Weights::sums`] over all starts, with the vectors of the processor.
struct AllStarts<'a> {
    weights: &'a Weights,
    windows: [Window<'a>; 3],
}

impl WithSimd for AllStarts<'_> {
    type Output = Block;

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for those vectors.
    fn with_simd<S: Simd>(self, simd: S) -> Block {
        let Self { weights, windows } = self;
        let [(a, low_a), (b, low_b), (c, low_c)] =
            windows.map(|(high, low)| (S::as_simd_f64s(high).0, S::as_simd_f64s(low).0));
        let (r1, r2) = (simd.splat_f64s(weights.r1), simd.splat_f64s(weights.r2));
        let (distance, slope) = (simd.splat_f64s(weights.distance), simd.splat_f64s(weights.slope));
        let change = |a, b, low_a, low_b| simd.add_f64s(simd.sub_f64s(b, a), simd.sub_f64s(low_b, low_a));
        let zero = simd.splat_f64s(0.0);
        let (mut squares, mut products, mut distances) = (zero, zero, zero);
        let mut place = simd.partial_load_f64s(&FIRST_PLACES[..S::F64_LANES]);
        let lanes = simd.splat_f64s(S::F64_LANES as f64);
        let starts = a.iter().zip(b).zip(c).zip(low_a).zip(low_b).zip(low_c);
        for (((((&a, &b), &c), &low_a), &low_b), &low_c) in starts {
            let (s1, s2) = (change(a, b, low_a, low_b), change(b, c, low_b, low_c));
            let z = simd.sub_f64s(simd.mul_f64s(s2, r2), simd.mul_f64s(s1, r1));
            let d = simd.add_f64s(distance, simd.mul_f64s(place, slope));
            squares = simd.add_f64s(squares, simd.mul_f64s(z, z));
            products = simd.add_f64s(products, simd.mul_f64s(z, d));
            distances = simd.add_f64s(distances, simd.mul_f64s(d, d));
            place = simd.add_f64s(place, lanes);
        }
        let rest = weights.sums(windows, a.len() * S::F64_LANES, 1);
        Block {
            squares: simd.reduce_sum_f64s(squares) + rest.squares,
            products: simd.reduce_sum_f64s(products) + rest.products,
            distances: simd.reduce_sum_f64s(distances) + rest.distances,
            ..rest
        }
    }
}
