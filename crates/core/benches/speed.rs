//! Time for the phase, for the Allan variance at octaves, and for its covariance; the least of several runs.
//!
//! `cargo bench -p sigmatau-core [-- SAMPLES]`

use sigmatau_core::allan::{Counting, Overlap, allan_variance, allan_variances, largest_cluster};
use sigmatau_core::covariance::{Component, Gamma};
use sigmatau_core::deviations::{Kind, deviations};
use sigmatau_core::generate::{Coefficients, simulate};
use sigmatau_core::phase::Phase;
use std::hint::black_box;
use std::time::Instant;

const RUNS: usize = 7;
/// Six axes of two hours at 200 Hz.
const AXES: usize = 6;
const AXIS_SAMPLES: usize = 1_440_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let argument = std::env::args().skip(1).find_map(|a| a.parse::<f64>().ok());
    let n = argument.map_or(10_000_000, |n| n as usize);
    let white = Coefficients { random_walk: 1.0, ..Coefficients::default() };
    let rate = simulate(n, 1.0, &white, 1, 0)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;

    let phase_ms = least_ms(|| drop(black_box(Phase::from_rate(&rate))));
    println!("phase, {n} samples: {phase_ms:.1} ms, {:.2} ns a sample", phase_ms * 1e6 / n as f64);

    let phase = Phase::from_rate(&rate)?;
    for (name, m) in [("octaves", octaves(n)), ("log-spaced", log_spaced(n, 100))] {
        let ms = least_ms(|| {
            pool.install(|| drop(black_box(allan_variance(&phase, &m, Overlap::Full, Counting::Standard))));
        });
        let terms: usize = m.iter().map(|m| n + 1 - 2 * m).sum();
        println!("{} {name}: {ms:.1} ms, {:.0} ps a term", m.len(), ms * 1e9 / terms as f64);
    }

    let axis = &rate[..AXIS_SAMPLES.min(n)];
    for kind in [Kind::Hadamard(Overlap::Full), Kind::Modified, Kind::Total, Kind::TieRms, Kind::Mtie] {
        let m: Vec<usize> =
            octaves(axis.len()).into_iter().filter(|&m| m <= kind.largest(axis.len())).collect();
        let ms = least_ms(|| pool.install(|| drop(black_box(deviations(kind, axis, &m)))));
        println!("{kind:?}, {} octaves of {} samples, with the phase: {ms:.1} ms", m.len(), axis.len());
    }

    let shorter = &axis[..axis.len().min(100_000)];
    let m: Vec<usize> = octaves(shorter.len()).into_iter().filter(|&m| m >= 16).collect();
    let ms = least_ms(|| pool.install(|| drop(black_box(deviations(Kind::Theo1, shorter, &m)))));
    println!("Theo1, {} octaves of {} samples: {ms:.0} ms", m.len(), shorter.len());

    let axes: Vec<&[f64]> = rate.chunks_exact(AXIS_SAMPLES).take(AXES).collect();
    for threads in [1, 2] {
        let m = octaves(AXIS_SAMPLES);
        let ms = least_ms(|| {
            drop(black_box(allan_variances(&axes, &m, Overlap::Full, Counting::Standard, Some(threads))));
        });
        println!("{} axes of {AXIS_SAMPLES}, {threads} threads, phase and octaves: {ms:.1} ms", axes.len());
    }

    for samples in [100_000, 1_000_000] {
        let phase = Phase::from_rate(&rate[..samples.min(n)])?;
        let every: Vec<usize> = (1..=phase.samples() / 2).collect();
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let ms = least_ms(|| {
                pool.install(|| {
                    drop(black_box(allan_variance(&phase, &every, Overlap::Full, Counting::Standard)));
                });
            });
            println!("all {} sizes of {}, {threads} threads: {ms:.1} ms", every.len(), phase.samples());
        }
    }

    let m = half_octaves(1 << 20);
    let linear = [
        Component::Quantization,
        Component::RandomWalk,
        Component::BiasInstability,
        Component::RateRandomWalk,
    ];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let ms = least_ms(|| pool.install(|| drop(black_box(Gamma::new(1 << 20, &m, &linear)))));
        println!("covariance of {} half octaves, 4 terms, {threads} threads: {ms:.1} ms", m.len());
    }
    Ok(())
}

fn half_octaves(n: usize) -> Vec<usize> {
    let sizes = (0..).map(|k| 2f64.powf(0.5 * f64::from(k)) as usize);
    let mut m: Vec<usize> = sizes.take_while(|&m| 2 * m <= n).collect();
    m.dedup();
    m
}

fn octaves(n: usize) -> Vec<usize> {
    let largest = largest_cluster(n, Overlap::Full, Counting::Standard);
    std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|&m| m <= largest).collect()
}

fn log_spaced(n: usize, count: usize) -> Vec<usize> {
    let ratio = (n as f64 / 2.0).powf(1.0 / (count - 1) as f64);
    let mut m: Vec<usize> = (0..count).map(|i| ratio.powi(i as i32).floor() as usize).collect();
    m.dedup();
    m
}

fn least_ms(mut run: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..RUNS).map(time).fold(f64::INFINITY, f64::min)
}
