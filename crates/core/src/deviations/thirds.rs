//! Sums of squared third differences over all starts, for many step sizes at once.
//!
//! The Hadamard variance consists of third differences of the phase, the modified Allan variance of third
//! differences of the sum of the phase. Both curves are stored relative to an origin in each block of points,
//! so that small differences of large numbers never occur. The contribution of the origins to a third
//! difference is a [`Correction`].

use crate::compensated::{Sum, two_sum};
use crate::parallel::prelude::*;
use crate::phase::SHORTEST_BLOCK;
use pulp::{Arch, Simd, WithSimd};

/// Starts handled together.
pub const STARTS: usize = 1024;

/// Largest number of sizes handled in one pass.
const CHAIN: usize = 4;

/// Number of partial sums that are computed side by side; a start belongs to the same sum on every processor.
const LANES: usize = 4;

/// Number of blocks of starts in one task. It depends on the record and not on the machine.
const BLOCKS_PER_TASK: usize = 64;

type Window = [f64; STARTS];
type Lanes = [f64; LANES];

/// Contribution of the origins of four windows to the third differences of their points.
pub trait Correction: Copy {
    /// Correction for the start at an index of the window.
    fn at(self, index: f64) -> f64;
}

/// A sequence of points, each relative to an origin of its block.
pub trait Curve: Sync {
    /// Origin of a window.
    type Origin: Copy;
    /// See [`Correction`].
    type Correction: Correction;

    /// The points, relative to their origins.
    fn values(&self) -> &[f64];

    /// Points per origin.
    fn block(&self) -> usize;

    /// Origin of the window that begins at a point.
    fn origin(&self, point: usize) -> Self::Origin;

    /// The third difference of four origins, with the weights −1, 3, −3, 1.
    fn correction(&self, origins: [Self::Origin; 4]) -> Self::Correction;

    /// Converts the copy of a window that begins at `point` to a single origin. The window crosses at most
    /// one border.
    fn lift(&self, point: usize, window: &mut [f64]);
}

/// Σ (−p(k) + 3p(k + m) − 3p(k + 2m) + p(k + 3m))² over all k, for each size m of `sizes`, in their order.
pub fn sums_of_squares<C: Curve>(curve: &C, sizes: &[usize]) -> Vec<f64> {
    let mut sorted = sizes.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let Some(&smallest) = sorted.first() else {
        return Vec::new();
    };
    let chains = chains(&sorted);
    let order: Vec<usize> = chains.iter().flatten().copied().collect();
    let sums = Sums { curve, points: curve.values().len(), chains: &chains };

    let blocks = sums.points.saturating_sub(3 * smallest).div_ceil(STARTS);
    let tasks: Vec<Vec<Sum>> = (0..blocks.div_ceil(BLOCKS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * BLOCKS_PER_TASK;
            sums.over_blocks(first..(first + BLOCKS_PER_TASK).min(blocks))
        })
        .collect();
    let mut totals = vec![Sum::default(); order.len()];
    for task in tasks {
        for (total, sum) in totals.iter_mut().zip(task) {
            *total = total.plus(sum);
        }
    }
    let of_size = |m: &usize| order.iter().position(|size| size == m).map(|at| totals[at].value());
    sizes.iter().filter_map(of_size).collect()
}

/// Groups sorted sizes into chains m, 2m, 4m … of at most [`CHAIN`]; a size without a neighbour is a chain of one.
fn chains(sizes: &[usize]) -> Vec<Vec<usize>> {
    let mut left = sizes.to_vec();
    let mut chains = Vec::new();
    while let Some(&start) = left.first() {
        let mut chain = vec![start];
        while chain.len() < CHAIN && left.binary_search(&(2 * chain[chain.len() - 1])).is_ok() {
            chain.push(2 * chain[chain.len() - 1]);
        }
        left.retain(|m| !chain.contains(m));
        chains.push(chain);
    }
    chains
}

struct Sums<'a, C> {
    curve: &'a C,
    points: usize,
    chains: &'a [Vec<usize>],
}

impl<C: Curve> Sums<'_, C> {
    /// One sum per size, in the order of the chains, over a run of blocks.
    fn over_blocks(&self, blocks: std::ops::Range<usize>) -> Vec<Sum> {
        let mut scratch = vec![[0.0; STARTS]; 2 * CHAIN + 1];
        let mut sums = vec![Sum::default(); self.chains.iter().map(Vec::len).sum()];
        for block in blocks {
            let mut at = 0;
            for chain in self.chains {
                self.add_block(block * STARTS, chain, &mut sums[at..at + chain.len()], &mut scratch);
                at += chain.len();
            }
        }
        sums
    }

    fn add_block(&self, start: usize, chain: &[usize], sums: &mut [Sum], scratch: &mut [Window]) {
        // Sizes grow along a chain, so the sizes for which the whole block has points come first.
        let whole = chain.iter().take_while(|&&m| start + STARTS + 3 * m <= self.points).count();
        match whole {
            4 => self.add_whole::<4>(start, chain, sums, scratch),
            3 => self.add_whole::<3>(start, chain, sums, scratch),
            2 => self.add_whole::<2>(start, chain, sums, scratch),
            1 => self.add_whole::<1>(start, chain, sums, scratch),
            _ => {}
        }
        for (&m, sum) in chain.iter().zip(sums).skip(whole) {
            let starts = self.points.saturating_sub(start + 3 * m);
            if starts > 0 {
                sum.add(self.last_block(start, starts, m, scratch));
            }
        }
    }

    /// Adds a block for the first `T` sizes of a chain, for which all its starts have their points.
    fn add_whole<const T: usize>(
        &self,
        start: usize,
        chain: &[usize],
        sums: &mut [Sum],
        scratch: &mut [Window],
    ) {
        let once = start + chain[0];
        let twice: [usize; T] = std::array::from_fn(|i| start + 2 * chain[i]);
        let thrice: [usize; T] = std::array::from_fn(|i| start + 3 * chain[i]);
        for (&point, scratch) in std::iter::once(&once).chain(&twice).chain(&thrice).zip(scratch.iter_mut()) {
            if crosses_border(self.curve, point) {
                *scratch = *self.plain_window(point);
                self.curve.lift(point, scratch);
            }
        }
        let first = self.curve.origin(start);
        let mut middle = self.curve.origin(once);
        let correction = std::array::from_fn(|i| {
            let far = self.curve.origin(twice[i]);
            let correction = self.curve.correction([first, middle, far, self.curve.origin(thrice[i])]);
            middle = far;
            correction
        });
        let scratch: &[Window] = scratch;
        let mut squares = [Lanes::default(); T];
        Arch::new().dispatch(Chain {
            first: self.plain_window(start),
            once: self.window(once, &scratch[0]),
            twice: std::array::from_fn(|i| self.window(twice[i], &scratch[1 + i])),
            thrice: std::array::from_fn(|i| self.window(thrice[i], &scratch[1 + T + i])),
            correction,
            sums: &mut squares,
        });
        for (sum, lanes) in sums.iter_mut().zip(squares) {
            sum.add(add_lanes(lanes));
        }
    }

    /// Sum over the last block of a size, in which only some starts have all their points.
    fn last_block(&self, start: usize, starts: usize, m: usize, scratch: &mut [Window]) -> f64 {
        let points: [usize; 4] = std::array::from_fn(|i| start + i * m);
        for (&point, scratch) in points.iter().zip(scratch.iter_mut()) {
            let window = &mut scratch[..starts];
            window.copy_from_slice(&self.curve.values()[point..point + starts]);
            self.curve.lift(point, window);
        }
        let correction = self.curve.correction(points.map(|point| self.curve.origin(point)));
        let mut sums = Lanes::default();
        for k in 0..starts {
            let [x, y, z, w] = std::array::from_fn(|i| scratch[i][k]);
            let d = third_difference(x, y, z, w) + correction.at(k as f64);
            sums[k % LANES] += d * d;
        }
        add_lanes(sums)
    }

    /// The window at a point: the curve itself, or its copy if the origin changes within the window.
    fn window<'a>(&'a self, point: usize, lifted: &'a Window) -> &'a Window {
        if crosses_border(self.curve, point) { lifted } else { self.plain_window(point) }
    }

    fn plain_window(&self, point: usize) -> &Window {
        self.curve.values()[point..].first_chunk().expect("the caller counted the points of the window")
    }
}

/// Third differences of the chain of sizes m, 2m, 4m …: the third window of a size is the second one of the next size.
struct Chain<'a, C, const T: usize> {
    first: &'a Window,
    once: &'a Window,
    twice: [&'a Window; T],
    thrice: [&'a Window; T],
    correction: [C; T],
    sums: &'a mut [Lanes; T],
}

impl<C: Correction, const T: usize> WithSimd for Chain<'_, C, T> {
    type Output = ();

    // Products and sums are not fused, so every processor gives the same bits.
    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for the processor.
    fn with_simd<S: Simd>(self, _: S) {
        let at =
            |window: &Window, start: usize| -> Lanes { std::array::from_fn(|lane| window[start + lane]) };
        let mut sums = *self.sums;
        let mut index: Lanes = std::array::from_fn(|lane| lane as f64);
        for start in (0..STARTS).step_by(LANES) {
            let x = at(self.first, start);
            let mut y = at(self.once, start);
            let windows = self.twice.into_iter().zip(self.thrice).zip(self.correction);
            for (sum, ((twice, thrice), correction)) in sums.iter_mut().zip(windows) {
                let (z, w) = (at(twice, start), at(thrice, start));
                for lane in 0..LANES {
                    let d = third_difference(x[lane], y[lane], z[lane], w[lane]) + correction.at(index[lane]);
                    sum[lane] += d * d;
                }
                y = z;
            }
            for lane in &mut index {
                *lane += LANES as f64;
            }
        }
        *self.sums = sums;
    }
}

/// The third difference of four numbers with twice the usual precision, rounded essentially once.
pub fn third_of_sums([x, y, z, w]: [Sum; 4]) -> f64 {
    let (outer, outer_error) = two_sum(w.hi, -x.hi);
    let (inner, inner_error) = two_sum(y.hi, -z.hi);
    let (thrice, thrice_error) = two_sum(2.0 * inner, inner);
    let (sum, error) = two_sum(outer, thrice);
    let rest = (w.lo - x.lo) + 3.0 * (y.lo - z.lo);
    sum + ((error + thrice_error) + (outer_error + 3.0 * inner_error) + rest)
}

#[inline(always)]
#[allow(clippy::inline_always)] // The loop above is only fast if this is inlined.
fn third_difference(x: f64, y: f64, z: f64, w: f64) -> f64 {
    (w - x) + 3.0 * (y - z)
}

fn add_lanes(sums: Lanes) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Whether the origin changes within the window at a point.
fn crosses_border(curve: &impl Curve, point: usize) -> bool {
    point % curve.block() + STARTS > curve.block()
}

// Windows at the starts themselves never cross a border.
const _: () = assert!(SHORTEST_BLOCK % STARTS == 0);

// `add_block` has an arm for every length of a chain.
const _: () = assert!(CHAIN == 4);
