//! Upper limits of this machine's speed, and the speed of the kernels: one probe per line, `name value unit`.
//!
//! `cargo run --release -p sigmatau-core --example roof [-- SAMPLES…]`; each figure is the median of several runs on one
//! thread. The page of `make bench` shows them.

use pulp::NullaryFnOnce;
use sigmatau_core::allan::{Counting, Overlap, allan_variance, largest_cluster};
use sigmatau_core::phase::Phase;
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 9;
/// Number of doubles in a vector.
const LANES: usize = 4;
/// Number of sums that run in parallel: with their operands and the constants they fill sixteen registers.
const CHAINS: usize = 6;
/// Number of steps of each chain in one run.
const STEPS: usize = 4_000_000;

type Vector = [f64; LANES];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sizes: Vec<usize> =
        std::env::args().skip(1).filter_map(|a| Some(a.parse::<f64>().ok()? as usize)).collect();
    let sizes = if sizes.is_empty() { vec![1_440_000, 10_000_000] } else { sizes };
    // All work runs on this thread.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()?;

    report("roof", arithmetic::<false>(), "ps");
    report("roof_with_correction", arithmetic::<true>(), "ps");
    for (name, bytes, passes) in [("read_l2", 1 << 19, 400), ("read_memory", 1 << 29, 1)] {
        report(name, read_bandwidth(bytes, passes), "GB/s");
    }
    for n in sizes {
        let rate = noise(n);
        report(
            &format!("prefix_fresh_{n}"),
            median_of(|| drop(black_box(Phase::from_rate(&rate)))) * 1e9 / n as f64,
            "ns",
        );
        let mut phase = Phase::from_rate(&rate)?;
        let again = pool.install(|| median_of(|| drop(black_box(phase.refill(&rate)))));
        report(&format!("prefix_again_{n}"), again * 1e9 / n as f64, "ns");
        for (name, m) in [("octaves", octaves(n)), ("log100", log_spaced(n, 100))] {
            let terms: usize = m.iter().map(|m| n + 1 - 2 * m).sum();
            let run = || drop(black_box(allan_variance(&phase, &m, Overlap::Full, Counting::Standard)));
            let seconds = pool.install(|| median_of(run));
            report(&format!("{name}_{n}"), seconds * 1e12 / terms as f64, "ps");
        }
    }
    Ok(())
}

#[allow(clippy::print_stdout)]
fn report(name: &str, value: f64, unit: &str) {
    println!("{name} {value:.6} {unit}");
}

/// Time per element and averaging time without loads. \[ps\]
///
/// One addition and two fused products, the minimum for (x + z)/2 − y and the sum of its squares; with `CORRECTION` one
/// more addition, for the anchors of the phase.
fn arithmetic<const CORRECTION: bool>() -> f64 {
    let run = || {
        let chains =
            Chains::<CORRECTION> { operands: black_box([[1e-9; LANES]; CHAINS]), by: black_box(1e-12) };
        #[cfg(target_arch = "x86_64")]
        match pulp::x86::V3::try_new() {
            Some(vectors) => drop(black_box(vectors.vectorize(chains))),
            None => drop(black_box(chains.call())),
        }
        #[cfg(not(target_arch = "x86_64"))]
        drop(black_box(chains.call()));
    };
    median_of(run) * 1e12 / (STEPS * CHAINS * LANES) as f64
}

struct Chains<const CORRECTION: bool> {
    operands: [Vector; CHAINS],
    by: f64,
}

impl<const CORRECTION: bool> NullaryFnOnce for Chains<CORRECTION> {
    type Output = [Vector; CHAINS];

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for these vectors.
    fn call(self) -> Self::Output {
        let Self { mut operands, by } = self;
        let mut sums = [[0.0; LANES]; CHAINS];
        for _ in 0..STEPS {
            for (sum, operand) in sums.iter_mut().zip(&mut operands) {
                for (sum, operand) in sum.iter_mut().zip(operand) {
                    *operand += by;
                    let mut half = operand.mul_add(0.5, by);
                    if CORRECTION {
                        half += by;
                    }
                    *sum = half.mul_add(half, *sum);
                }
            }
        }
        sums
    }
}

/// Reads and adds adjacent doubles. \[GB/s\]
fn read_bandwidth(bytes: usize, passes: usize) -> f64 {
    let numbers = vec![1.0f64; bytes / size_of::<f64>()];
    let run = || {
        for _ in 0..passes {
            let numbers = black_box(numbers.as_slice());
            #[cfg(target_arch = "x86_64")]
            match pulp::x86::V3::try_new() {
                Some(vectors) => drop(black_box(vectors.vectorize(Reading(numbers)))),
                None => drop(black_box(Reading(numbers).call())),
            }
            #[cfg(not(target_arch = "x86_64"))]
            drop(black_box(Reading(numbers).call()));
        }
    };
    (bytes * passes) as f64 / median_of(run) / 1e9
}

struct Reading<'a>(&'a [f64]);

impl NullaryFnOnce for Reading<'_> {
    type Output = [f64; 8 * LANES];

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined as above.
    fn call(self) -> Self::Output {
        let mut sums = [0.0; 8 * LANES];
        for block in self.0.chunks_exact(8 * LANES) {
            for (sum, number) in sums.iter_mut().zip(block) {
                *sum += number;
            }
        }
        sums
    }
}

fn median_of(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    let mut seconds: Vec<f64> = (0..RUNS).map(time).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[RUNS / 2]
}

/// Pseudo-random numbers that are fast to make; the time does not depend on their values.
fn noise(n: usize) -> Vec<f64> {
    let mut state = 1u64;
    let next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    std::iter::repeat_with(next).take(n).collect()
}

fn octaves(n: usize) -> Vec<usize> {
    let largest = largest_cluster(n, Overlap::Full, Counting::Standard);
    std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|&m| m <= largest).collect()
}

fn log_spaced(n: usize, count: usize) -> Vec<usize> {
    let ratio = ((n / 2 - 1) as f64).powf(1.0 / (count - 1) as f64);
    let mut m: Vec<usize> = (0..count).map(|i| ratio.powi(i as i32).round() as usize).collect();
    m.dedup();
    m
}
