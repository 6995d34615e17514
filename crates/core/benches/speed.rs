//! Time of each part of the numerics, by Criterion: `cargo bench -p sigmatau-core [-- FILTER]`.
//!
//! Against the roof of the machine: `examples/roof.rs`. Against other packages: `make bench`.

#![allow(missing_docs)] // of the functions that the macros make

use criterion::{
    BatchSize, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use sigmatau_core::allan::{Counting, Overlap, allan_variance, allan_variances};
use sigmatau_core::covariance::{Component, Gamma};
use sigmatau_core::deviations::{Kind, deviations};
use sigmatau_core::generate::{Coefficients, simulate};
use sigmatau_core::phase::Phase;
use sigmatau_core::stream::{Accumulator, Long, stride};
use std::hint::black_box;
use std::time::Duration;

/// Two hours at 200 Hz.
const SAMPLES: usize = 1_440_000;
const LONG: usize = 10_000_000;
const AXES: usize = 6;
/// Samples of one push.
const CHUNK: usize = 1 << 16;

fn one_axis(c: &mut Criterion) {
    for n in [SAMPLES, LONG] {
        let rate = noise(n);
        let mut group = c.benchmark_group("phase");
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function(BenchmarkId::new("fresh", n), |b| {
            b.iter(|| on_threads(1, || Phase::from_rate(black_box(&rate)).is_ok()));
        });
        let mut phase = Phase::default();
        group.bench_function(BenchmarkId::new("again", n), |b| {
            b.iter(|| on_threads(1, || phase.refill(black_box(&rate)).is_ok()));
        });
        group.finish();

        let mut group = c.benchmark_group("allan variance");
        for (name, m) in [("octaves", octaves(n)), ("100 log-spaced", log_spaced(n, 100))] {
            let terms: usize = m.iter().map(|m| n + 1 - 2 * m).sum();
            group.throughput(Throughput::Elements(terms as u64));
            group.bench_function(BenchmarkId::new(name, n), |b| {
                b.iter(|| on_threads(1, || allan_variance(&phase, &m, Overlap::Full, Counting::Standard)));
            });
        }
        group.finish();
    }
}

fn six_axes(c: &mut Criterion) {
    let rates: Vec<Vec<f64>> = (0..AXES).map(|_| noise(SAMPLES)).collect();
    let axes: Vec<&[f64]> = rates.iter().map(Vec::as_slice).collect();
    let m = octaves(SAMPLES);
    let mut group = c.benchmark_group("six axes, phase and octaves");
    for threads in [1, 2] {
        group.bench_function(format!("{threads} threads"), |b| {
            b.iter(|| allan_variances(&axes, &m, Overlap::Full, Counting::Standard, Some(threads)));
        });
    }
    group.finish();
}

fn every_size(c: &mut Criterion) {
    let mut group = c.benchmark_group("every size");
    group.sampling_mode(SamplingMode::Flat);
    for n in [100_000, 1_000_000] {
        let Ok(phase) = Phase::from_rate(&noise(n)) else { return };
        let m: Vec<usize> = (1..=n / 2).collect();
        for threads in [1, 2] {
            group.bench_function(BenchmarkId::new(format!("{threads} threads"), n), |b| {
                b.iter(|| {
                    on_threads(threads, || allan_variance(&phase, &m, Overlap::Full, Counting::Standard))
                });
            });
        }
    }
    group.finish();
}

fn other_deviations(c: &mut Criterion) {
    let rate = noise(SAMPLES);
    let mut group = c.benchmark_group("deviations, phase and octaves");
    for kind in [Kind::Modified, Kind::Hadamard(Overlap::Full), Kind::Total, Kind::TieRms, Kind::Mtie] {
        let m: Vec<usize> = octaves(SAMPLES).into_iter().filter(|&m| m <= kind.largest(SAMPLES)).collect();
        group.bench_function(format!("{kind:?}"), |b| {
            b.iter(|| on_threads(1, || deviations(kind, &rate, &m)));
        });
    }
    let short = &rate[..100_000];
    let m: Vec<usize> = octaves(short.len()).into_iter().filter(|&m| m >= 16).collect();
    group.bench_function("Theo1 of 100000", |b| {
        b.iter(|| on_threads(1, || deviations(Kind::Theo1, short, &m)));
    });
    group.finish();
}

fn accumulator(c: &mut Criterion) {
    let rate = noise(1_000_000);
    let mut group = c.benchmark_group("push");
    group.throughput(Throughput::Elements(rate.len() as u64));
    for (name, parts) in [("octaves", 1), ("half octaves", 2)] {
        let mut m = parts_of_octaves(1 << 30, parts);
        for m in &mut m {
            *m -= *m % stride(*m);
        }
        group.bench_function(name, |b| {
            b.iter_batched(
                || Accumulator::new(&m, Long::Strided, 0),
                |sums| {
                    let mut sums = sums.ok()?;
                    rate.chunks(CHUNK).try_for_each(|chunk| sums.push(chunk)).ok()?;
                    Some(sums)
                },
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

fn covariance(c: &mut Criterion) {
    let m = parts_of_octaves(1 << 20, 2);
    let linear = [
        Component::Quantization,
        Component::RandomWalk,
        Component::BiasInstability,
        Component::RateRandomWalk,
    ];
    let mut group = c.benchmark_group("covariance of half octaves, 2^20 samples");
    for threads in [1, 2] {
        group.bench_function(format!("{threads} threads"), |b| {
            b.iter(|| on_threads(threads, || Gamma::new(1 << 20, &m, &linear).is_ok()));
        });
    }
    group.finish();
}

/// Runs on so many threads; making them takes some 20 µs a call.
fn on_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> Option<R> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok().map(|pool| pool.install(run))
}

fn noise(n: usize) -> Vec<f64> {
    let white = Coefficients { random_walk: 1.0, ..Coefficients::default() };
    simulate(n, 1.0, &white, 1, 0).unwrap_or_default()
}

fn octaves(n: usize) -> Vec<usize> {
    parts_of_octaves(n, 1)
}

fn parts_of_octaves(n: usize, parts: i32) -> Vec<usize> {
    let sizes = (0..).map(|k| 2f64.powf(f64::from(k) / f64::from(parts)) as usize);
    let mut m: Vec<usize> = sizes.take_while(|&m| 2 * m <= n).collect();
    m.dedup();
    m
}

fn log_spaced(n: usize, count: usize) -> Vec<usize> {
    let ratio = ((n / 2) as f64).powf(1.0 / (count - 1) as f64);
    let mut m: Vec<usize> = (0..count).map(|i| ratio.powi(i as i32).floor() as usize).collect();
    m.dedup();
    m
}

/// A few seconds each.
fn short() -> Criterion {
    let timed = Criterion::default().sample_size(10);
    timed.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2))
}

criterion_group! {
    name = benches;
    config = short();
    targets = one_axis, six_axes, every_size, other_deviations, accumulator, covariance
}
criterion_main!(benches);
