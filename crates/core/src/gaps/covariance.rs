//! Covariance of the Allan variances at long averaging times of a record with gaps, from sums over blocks.
//!
//! Where clusters are long, few pairs are independent, and a gap changes which pairs there are from one cluster size to the
//! next: the covariance of the whole record, scaled, would call two sizes more alike than they are. Here the record is cut
//! into a few hundred blocks; the covariance of the sums of their samples is that of full blocks, times the shares that are
//! there. Clusters begin at blocks, and of two pairs with differences z and z′, ½ Cov(z, z′)² is what they put into the
//! covariance of the two variances. All entries come from one such model of the record, so that they fit together.

use super::counts::Counts;
use crate::error::Error;
use crate::special::odd_harmonic;
use rayon::prelude::*;

/// A process whose clusters of blocks are averages of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Process {
    /// White noise.
    RandomWalk,
    /// Discrete flicker noise.
    BiasInstability,
    /// Sampled random walk of the rate.
    RateRandomWalk,
    /// Gauss-Markov process of variance 1.
    GaussMarkov {
        /// Correlation time in samples.
        time: f64,
    },
}

/// What [`long_times`] finds, for unit coefficients and one sample interval of 1.
#[derive(Debug, Clone, PartialEq)]
pub struct LongTimes {
    /// Expected Allan variances: one row for each process, of one number for each size.
    pub avar: Vec<Vec<f64>>,
    /// For each pair of processes p ≤ q, row after row of the upper triangle, the J×J matrix Γ(p, q).
    pub noise: Vec<Vec<f64>>,
    /// For each process, the J×J covariance of the ramps.
    pub slopes: Vec<Vec<f64>>,
}

/// Clusters of one size that begin at blocks.
struct Clusters {
    /// Blocks of a cluster.
    blocks: usize,
    /// 1/m₁ and 1/m₂ of the pair that begins at each block, and its share of all pairs.
    pairs: Vec<[f64; 3]>,
    /// Of the ramp: share · distance of the mean times over the mean of its square.
    levers: Vec<f64>,
}

impl Process {
    /// Variance of the sum of `l` samples, generalised: a parabola in l makes no difference.
    fn variogram(self, l: f64) -> f64 {
        match self {
            Self::RandomWalk => l,
            Self::BiasInstability => {
                let before = if l > 1.0 { odd_harmonic(l as usize - 1) } else { 0.0 };
                let j =
                    -0.5 * (4.0 * l * l - 1.0) * before + 2.0 * l * (l - 1.0) - 0.5 * (l - 1.0) * (l - 1.0);
                if l < 1.0 { 0.0 } else { j / std::f64::consts::PI }
            }
            Self::RateRandomWalk => -(l * l * l - l) / 6.0,
            Self::GaussMarkov { time } => {
                let lost = -(-1.0 / time).exp_m1();
                let kept = 1.0 - lost;
                let beyond = -(-l / time).exp_m1();
                (l * lost * (2.0 - lost) - 2.0 * kept * beyond) / (lost * lost)
            }
        }
    }

    /// Covariance of the running sums before the first block, the second, …, row after row, from the samples in each.
    fn of_sums(self, counts: &[f64], length: usize) -> Vec<f64> {
        let blocks = counts.len();
        let edges = blocks + 1;
        let size = length as f64;
        let area = size * size;
        let v: Vec<f64> = (0..=blocks).map(|k| self.variogram(k as f64 * size)).collect();
        let of_distance: Vec<f64> = (0..blocks)
            .map(|d| 0.5 * (v[d + 1] - 2.0 * v[d] + v[if d == 0 { 1 } else { d - 1 }]) / area)
            .collect();
        let mut sums = vec![0.0; edges * edges];
        for i in 0..blocks {
            let mut row = 0.0;
            for j in 0..blocks {
                row += match self {
                    Self::RandomWalk if i == j => counts[i],
                    Self::RandomWalk => 0.0,
                    _ => counts[i] * counts[j] * of_distance[i.abs_diff(j)],
                };
                sums[(i + 1) * edges + j + 1] = sums[i * edges + j + 1] + row;
            }
        }
        sums
    }
}

/// Γ of the processes at the cluster sizes `m`, each rounded to blocks of `length` samples.
///
/// # Errors
///
/// [`Error::ClusterSize`] for a size that leaves no pair of clusters at least half full.
pub fn long_times(
    there: &[bool],
    m: &[usize],
    length: usize,
    processes: &[Process],
) -> Result<LongTimes, Error> {
    let counts = Counts::of(there);
    let all = there.len() / length.max(1);
    let of_block: Vec<f64> =
        (0..all).map(|k| there[k * length..(k + 1) * length].iter().filter(|&&v| v).count() as f64).collect();
    let clusters: Vec<Clusters> = m.iter().map(|&m| counts.clusters(m, length)).collect::<Result<_, _>>()?;
    let sums: Vec<Vec<f64>> =
        processes.par_iter().map(|process| process.of_sums(&of_block, length)).collect();
    let edges = all + 1;
    // By process and size: the covariance of every difference with every running sum.
    let differences: Vec<Vec<Vec<f64>>> = sums
        .par_iter()
        .map(|sums| clusters.iter().map(|clusters| clusters.differences(sums, edges)).collect())
        .collect();
    let k = m.len();
    let pairs_of_terms = processes.len() * (processes.len() + 1) / 2;
    let avar =
        differences.iter().map(|of| (0..k).map(|i| clusters[i].avar(&of[i], edges)).collect()).collect();
    let entries: Vec<(usize, usize)> = (0..k).flat_map(|i| (i..k).map(move |j| (i, j))).collect();
    let found: Vec<(Vec<f64>, Vec<f64>)> = entries
        .par_iter()
        .map(|&(i, j)| {
            let rows: Vec<&[f64]> = differences.iter().map(|of| of[i].as_slice()).collect();
            entry(&clusters[i], &clusters[j], &rows, edges)
        })
        .collect();
    let mut noise = vec![vec![0.0; k * k]; pairs_of_terms];
    let mut slopes = vec![vec![0.0; k * k]; processes.len()];
    for ((i, j), (of_noise, of_slopes)) in entries.into_iter().zip(found) {
        for cell in [i * k + j, j * k + i] {
            noise.iter_mut().zip(&of_noise).for_each(|(matrix, sum)| matrix[cell] = *sum);
            slopes.iter_mut().zip(&of_slopes).for_each(|(matrix, sum)| matrix[cell] = *sum);
        }
    }
    Ok(LongTimes { avar, noise, slopes })
}

impl Counts {
    fn clusters(&self, m: usize, length: usize) -> Result<Clusters, Error> {
        let samples = self.valid.len() - 1;
        let largest = samples / 2;
        let wrong = Error::ClusterSize { m, largest };
        let blocks = ((m as f64 / length as f64).round() as usize).max(1).min(samples / length / 2);
        if m > largest || blocks == 0 {
            return Err(wrong);
        }
        let size = blocks * length;
        let last = samples / length - 2 * blocks;
        let mut weights = vec![0.0; last + 1];
        for start in 0..self.starts(size) {
            if self.pair(start, size).is_some() {
                weights[((start + length / 2) / length).min(last)] += 1.0;
            }
        }
        let mut pairs = Vec::with_capacity(last + 1);
        let mut levers = Vec::with_capacity(last + 1);
        for (k, &weight) in weights.iter().enumerate() {
            let at = [k * length, k * length + size, k * length + 2 * size];
            let [a, b, c] = at.map(|k| self.valid[k]);
            let (m1, m2) = ((b - a) as f64, (c - b) as f64);
            let empty = m1 == 0.0 || m2 == 0.0;
            let weight = if empty { 0.0 } else { weight };
            let (r1, r2) = if empty { (0.0, 0.0) } else { (1.0 / m1, 1.0 / m2) };
            let [a, b, c] = at.map(|k| self.index[k] as f64);
            pairs.push([r1, r2, weight]);
            levers.push((c - b) * r2 - (b - a) * r1);
        }
        let total: f64 = pairs.iter().map(|pair| pair[2]).sum();
        if total == 0.0 {
            return Err(wrong);
        }
        let mut squares = 0.0;
        for (pair, lever) in pairs.iter_mut().zip(&mut levers) {
            pair[2] /= total;
            squares += pair[2] * *lever * *lever;
            *lever *= pair[2];
        }
        for lever in &mut levers {
            *lever /= squares;
        }
        Ok(Clusters { blocks, pairs, levers })
    }
}

impl Clusters {
    fn differences(&self, sums: &[f64], edges: usize) -> Vec<f64> {
        let row = |k: usize| &sums[k * edges..(k + 1) * edges];
        let mut found = Vec::with_capacity(self.pairs.len() * edges);
        for (k, &[r1, r2, _]) in self.pairs.iter().enumerate() {
            let (a, b, c) = (row(k), row(k + self.blocks), row(k + 2 * self.blocks));
            found.extend((0..edges).map(|e| (c[e] - b[e]) * r2 - (b[e] - a[e]) * r1));
        }
        found
    }

    /// Covariance of the difference at block `k` with what has the covariance `row` with the running sums.
    #[inline]
    fn difference(&self, row: &[f64], k: usize) -> f64 {
        let [r1, r2, _] = self.pairs[k];
        let middle = row[k + self.blocks];
        (row[k + 2 * self.blocks] - middle) * r2 - (middle - row[k]) * r1
    }

    fn avar(&self, differences: &[f64], edges: usize) -> f64 {
        let rows = differences.chunks(edges).zip(&self.pairs).enumerate();
        rows.map(|(k, (row, pair))| 0.5 * pair[2] * self.difference(row, k)).sum()
    }
}

/// ½ Σ w w′ C(p) C(q) for all pairs of processes, and the covariances of the ramps.
fn entry(one: &Clusters, other: &Clusters, rows: &[&[f64]], edges: usize) -> (Vec<f64>, Vec<f64>) {
    let terms = rows.len();
    let mut noise = vec![0.0; terms * (terms + 1) / 2];
    let mut slopes = vec![0.0; terms];
    let mut of_start = vec![vec![0.0; other.pairs.len()]; terms];
    for (k, (pair, &lever)) in one.pairs.iter().zip(&one.levers).enumerate() {
        if pair[2] == 0.0 {
            continue;
        }
        for ((of_start, rows), slope) in of_start.iter_mut().zip(rows).zip(&mut slopes) {
            let row = &rows[k * edges..(k + 1) * edges];
            for (l, value) in of_start.iter_mut().enumerate() {
                *value = other.difference(row, l);
                *slope += lever * other.levers[l] * *value;
            }
        }
        let mut cell = 0;
        for p in 0..terms {
            for q in p..terms {
                let products = of_start[p].iter().zip(&of_start[q]).zip(&other.pairs);
                let sum: f64 = products.map(|((x, y), pair)| pair[2] * x * y).sum();
                noise[cell] += 0.5 * pair[2] * sum;
                cell += 1;
            }
        }
    }
    (noise, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance::{Component, Gamma};
    use crate::terms;

    const PROCESSES: [Process; 4] = [
        Process::RandomWalk,
        Process::BiasInstability,
        Process::RateRandomWalk,
        Process::GaussMarkov { time: 300.0 },
    ];

    #[test]
    fn without_a_gap_it_is_the_covariance_of_the_record() {
        let n = 8192;
        let sizes = [256, 512, 768, 2048];
        let components = [
            Component::RandomWalk,
            Component::BiasInstability,
            Component::RateRandomWalk,
            Component::GaussMarkov { tc: 300.0 },
        ];
        let exact = Gamma::new(n, &sizes, &components).unwrap();
        let got = long_times(&vec![true; n], &sizes, 32, &PROCESSES).unwrap();
        let mut cell = 0;
        for p in 0..4 {
            for q in p..4 {
                // Clusters begin at every eighth of the shortest only, and noise within a block is one number.
                for (got, exact) in got.noise[cell].iter().zip(exact.noise_part(p, q)) {
                    assert!((got / exact - 1.0).abs() < 0.02, "{p} {q}: {got} instead of {exact}");
                }
                cell += 1;
            }
        }
        for (k, &m) in sizes.iter().enumerate() {
            let expected = [
                terms::random_walk_avar(1.0, m as f64),
                terms::bias_instability_avar(1.0, m),
                terms::rate_random_walk_avar_sampled(1.0, 1.0, m),
                terms::gauss_markov_avar_sampled(1.0, 300.0, 1.0, m),
            ];
            for (got, expected) in got.avar.iter().zip(expected) {
                assert!((got[k] / expected - 1.0).abs() < 1e-6, "{m}: {} instead of {expected}", got[k]);
            }
        }
    }

    #[test]
    fn a_block_of_one_sample_is_exact() {
        // With gaps, against sums over all samples.
        let there: Vec<bool> = (0..120).map(|k| k % 11 != 4 && !(50..70).contains(&k)).collect();
        let sizes = [10, 24];
        let got = long_times(&there, &sizes, 1, &PROCESSES[..3]).unwrap();
        let harmonic = |l: usize| (1..=l).map(|j| 1.0 / (2 * j - 1) as f64).sum::<f64>();
        let covariance = |p: usize, i: usize, j: usize| match p {
            0 => f64::from(u8::from(i == j)),
            1 => -2.0 / std::f64::consts::PI * harmonic(i.abs_diff(j)),
            _ => i.min(j) as f64 + 1.0,
        };
        let differences = |m: usize| -> Vec<Vec<f64>> {
            let count = |k: usize| there[k..k + m].iter().filter(|&&v| v).count();
            (0..=there.len() - 2 * m)
                .filter(|&k| 2 * count(k) >= m && 2 * count(k + m) >= m)
                .map(|k| {
                    let mut weights = vec![0.0; there.len()];
                    (k..k + m).filter(|&i| there[i]).for_each(|i| weights[i] = -1.0 / count(k) as f64);
                    (k + m..k + 2 * m)
                        .filter(|&i| there[i])
                        .for_each(|i| weights[i] = 1.0 / count(k + m) as f64);
                    weights
                })
                .collect()
        };
        let (short, long) = (differences(sizes[0]), differences(sizes[1]));
        let between = |p: usize, a: &[f64], b: &[f64]| {
            let mut sum = 0.0;
            for (i, a) in a.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                for (j, b) in b.iter().enumerate().filter(|(_, b)| **b != 0.0) {
                    sum += a * b * covariance(p, i, j);
                }
            }
            sum
        };
        let mut cell = 0;
        for p in 0..3 {
            for q in p..3 {
                let mut sum = 0.0;
                for a in &short {
                    for b in &long {
                        sum += 0.5 * between(p, a, b) * between(q, a, b);
                    }
                }
                let expected = sum / (short.len() * long.len()) as f64;
                let got = got.noise[cell][1];
                assert!((got / expected - 1.0).abs() < 1e-9, "{p} {q}: {got} instead of {expected}");
                cell += 1;
            }
        }
    }
}
