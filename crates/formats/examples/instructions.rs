//! Small fixed tasks for counting instructions; `benches/instructions.py` runs them under callgrind.
//!
//! `instructions WORK` runs one of `WORKS` on one thread, after it makes the data for all of them. Subtract the count of
//! `nothing`, which only makes the data.

use sigmatau_core::allan::{Counting, Overlap, allan_variance};
use sigmatau_core::phase::Phase;
use sigmatau_core::stream::{Accumulator, Long};
use sigmatau_formats::{Delimiter, Dialect, read_columns};
use std::fmt::Write as _;
use std::hint::black_box;

const SAMPLES: usize = 200_000;
/// Number of samples per push.
const CHUNK: usize = 1000;
const ROWS: usize = 5000;
const COLUMNS: usize = 7;

type Failure = Box<dyn std::error::Error + Send + Sync>;

const WORKS: &str = "nothing, phase, octaves, log30, push, parse";

fn main() -> Result<(), Failure> {
    let work = std::env::args().nth(1).unwrap_or_default();
    let rate = noise(SAMPLES);
    let table = table(ROWS)?;
    // The pool is the current thread: a second one would count instructions while waiting.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build()?;
    pool.install(|| run(&work, &rate, &table))
}

fn run(work: &str, rate: &[f64], table: &str) -> Result<(), Failure> {
    match work {
        "nothing" => {}
        "phase" => drop(black_box(Phase::from_rate(rate)?)),
        "octaves" | "log30" => {
            let m = if work == "octaves" { octaves(rate.len()) } else { log_spaced(rate.len(), 30) };
            let phase = Phase::from_rate(rate)?;
            drop(black_box(allan_variance(&phase, &m, Overlap::Full, Counting::Standard)?));
        }
        "push" => {
            let mut sums = Accumulator::new(&octaves(1 << 12), Long::Strided, 0)?;
            for chunk in rate.chunks(CHUNK) {
                sums.push(chunk)?;
            }
            drop(black_box(sums.snapshot()?));
        }
        "parse" => {
            let dialect = Dialect {
                delimiter: Delimiter::Byte(b','),
                comment: Vec::new(),
                skip_lines: 0,
                columns: COLUMNS,
                dates: None,
                arrow: false,
                most: u64::MAX,
                tag: None,
            };
            let wanted: Vec<usize> = (0..COLUMNS).collect();
            drop(black_box(read_columns(table.as_bytes(), &dialect, &wanted, None)?));
        }
        other => return Err(format!("no work {other:?}; there are {WORKS}").into()),
    }
    Ok(())
}

/// Rows of a typical logger: the time, and numbers of nine digits.
fn table(rows: usize) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let numbers = noise(rows * COLUMNS);
    for (row, numbers) in numbers.chunks_exact(COLUMNS).enumerate() {
        write!(text, "{:.3}", row as f64 * 0.005)?;
        for number in &numbers[1..] {
            write!(text, ",{:.9}", number - 0.5)?;
        }
        text.push('\n');
    }
    Ok(text)
}

/// Pseudo-random numbers that need few instructions.
fn noise(n: usize) -> Vec<f64> {
    let mut state = 1u64;
    let next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    std::iter::repeat_with(next).take(n).collect()
}

fn octaves(n: usize) -> Vec<usize> {
    std::iter::successors(Some(1), |m| Some(2 * m)).take_while(|&m| 2 * m <= n).collect()
}

fn log_spaced(n: usize, count: usize) -> Vec<usize> {
    let ratio = (n as f64 / 2.0).powf(1.0 / (count - 1) as f64);
    let mut m: Vec<usize> = (0..count).map(|i| ratio.powi(i as i32) as usize).collect();
    m.dedup();
    m
}
