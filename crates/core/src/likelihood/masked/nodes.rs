//! Sums over the samples weighted by hat functions, and the modes of the string with the weights as masses.

use crate::likelihood::masked::string::Tridiagonal;
use crate::likelihood::masked::weights::Weights;
use std::f64::consts::PI;

/// Share of the largest mass below which a node is left out; the gap then becomes a longer spring.
const MIN_MASS: f64 = 1e-6;

/// Number of nodes per used mode.
const NODES_PER_MODE: usize = 8;

/// The sums of the pass. Hat functions are 1 at a node, 0 at the next one, and constant beyond the first and the last node.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    pub spacing: usize,
    pub count: usize,
    weights: Weights,
    piece: Vec<f64>,
    mass: Vec<f64>,
    record: Vec<f64>,
    /// Σ w φ², and Σ w φφ′ with the next node.
    overlap: Vec<f64>,
    next: Vec<f64>,
    white: Quadratic,
    steps: Quadratic,
    /// Interval, position in it, and weight of the previous sample.
    before: (usize, f64, f64),
}

/// The quadratic form Σ (α v + β v′)² of the values v and v′ of a mode at two neighbouring nodes, summed over the samples
/// between them: sums of α², 2αβ and β² by interval.
#[derive(Debug, Clone)]
struct Quadratic(Vec<[f64; 3]>);

impl Quadratic {
    fn add(&mut self, interval: usize, a: f64, b: f64) {
        let sums = &mut self.0[interval];
        sums[0] += a * a;
        sums[1] += 2.0 * a * b;
        sums[2] += b * b;
    }

    fn of(&self, v: &[f64]) -> f64 {
        let terms = self.0.iter().zip(v.windows(2));
        terms.map(|(s, v)| s[0] * v[0] * v[0] + s[1] * v[0] * v[1] + s[2] * v[1] * v[1]).sum()
    }
}

/// The modes of a record. Sample t has the weight √τ₀ w(t) v(t) in a mode.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StringModes {
    /// Mode amplitudes of the record.
    pub modes: Vec<f64>,
    /// Frequencies of the modes. \[Hz\]
    pub frequencies: Vec<f64>,
    /// Values at the nodes, by mode.
    pub shapes: Vec<Vec<f64>>,
    /// Masses of the nodes.
    pub mass: Vec<f64>,
    /// Products of hat functions: of a node with itself, and with the next node.
    overlap: Vec<f64>,
    next: Vec<f64>,
    /// Σ w² v², and the same sum of the differences of w v.
    pub white: Vec<f64>,
    pub steps: Vec<f64>,
    root: f64,
}

impl Nodes {
    pub(super) fn new(samples: usize, spacing: usize, weights: Weights) -> Self {
        let count = samples / spacing;
        Self {
            spacing,
            count,
            weights,
            piece: Vec::new(),
            mass: vec![0.0; count],
            record: vec![0.0; count],
            overlap: vec![0.0; count],
            next: vec![0.0; count - 1],
            white: Quadratic(vec![[0.0; 3]; count - 1]),
            steps: Quadratic(vec![[0.0; 3]; count - 1]),
            before: (0, 0.0, 0.0),
        }
    }

    /// Adds samples beginning with `start`, 0 where they are missing.
    pub(super) fn take(&mut self, present: &[bool], start: usize, samples: &[f64]) {
        self.piece.resize(samples.len(), 0.0);
        self.weights.fill(present, start as isize, &mut self.piece);
        let last = self.count - 2;
        for (i, (&y, &w)) in samples.iter().zip(&self.piece).enumerate() {
            let x = ((start + i) as f64 + 0.5) / self.spacing as f64 - 0.5;
            let j = (x.max(0.0) as usize).min(last);
            let r = (x - j as f64).clamp(0.0, 1.0);
            let left = 1.0 - r;
            let (before, position, weight) = self.before;
            // The previous sample, on the straight line of this interval.
            let position = if before == j { position } else { position - 1.0 };
            self.steps.add(j, w * left - weight * (1.0 - position), w * r - weight * position);
            self.before = (j, r, w);
            if w == 0.0 {
                continue;
            }
            self.mass[j] += w * left;
            self.mass[j + 1] += w * r;
            self.record[j] += w * left * y;
            self.record[j + 1] += w * r * y;
            self.overlap[j] += w * left * left;
            self.overlap[j + 1] += w * r * r;
            self.next[j] += w * left * r;
            self.white.add(j, w * left, w * r);
        }
    }

    /// The modes, after all samples.
    pub(super) fn solve(self, tau0: f64) -> StringModes {
        let largest = self.mass.iter().fold(0.0_f64, |a, &b| a.max(b));
        let there: Vec<usize> = (0..self.count).filter(|&j| self.mass[j] > MIN_MASS * largest).collect();
        let mut mass = vec![0.0; self.count];
        for &j in &there {
            mass[j] = self.mass[j];
        }
        // The mean of the record is not a mode; without it the sums lose no digits.
        let mean = self.record.iter().sum::<f64>() / self.mass.iter().sum::<f64>();
        let record: Vec<f64> = self.record.iter().zip(&self.mass).map(|(s, c)| s - mean * c).collect();
        let springs: Vec<f64> =
            there.windows(2).map(|p| 1.0 / ((p[1] - p[0]) as f64 * self.spacing as f64 * tau0)).collect();
        let spring = |i: usize| springs.get(i).copied().unwrap_or(0.0);
        let string = Tridiagonal {
            diagonal: (0..there.len())
                .map(|i| (if i > 0 { spring(i - 1) } else { 0.0 } + spring(i)) / mass[there[i]])
                .collect(),
            beside: (0..there.len() - 1)
                .map(|i| -springs[i] / (mass[there[i]] * mass[there[i + 1]]).sqrt())
                .collect(),
        };
        let count = (self.count / NODES_PER_MODE).min(there.len() / NODES_PER_MODE);
        let (values, vectors) = string.lowest(count);
        let shapes: Vec<Vec<f64>> = vectors
            .iter()
            .map(|u| {
                let at: Vec<f64> = u.iter().zip(&there).map(|(u, &j)| u / mass[j].sqrt()).collect();
                interpolate_nodes(&there, &at, self.count)
            })
            .collect();
        let root = tau0.sqrt();
        let before = self.before;
        StringModes {
            modes: shapes
                .iter()
                .map(|v| root * v.iter().zip(&record).map(|(v, s)| v * s).sum::<f64>())
                .collect(),
            frequencies: values.iter().map(|mu| (mu / tau0).sqrt() / (2.0 * PI)).collect(),
            white: shapes.iter().map(|v| self.white.of(v)).collect(),
            // There is no sample after the last one.
            steps: shapes.iter().map(|v| self.steps.of(v) + (before.2 * v[self.count - 1]).powi(2)).collect(),
            shapes,
            mass,
            overlap: self.overlap,
            next: self.next,
            root,
        }
    }
}

impl StringModes {
    /// The modes of a curve that is given at the nodes and linear between them.
    pub(crate) fn modes_of(&self, curve: &[f64]) -> Vec<f64> {
        let n = curve.len();
        let sums: Vec<f64> = (0..n)
            .map(|j| {
                let before = if j > 0 { self.next[j - 1] * curve[j - 1] } else { 0.0 };
                let after = if j + 1 < n { self.next[j] * curve[j + 1] } else { 0.0 };
                before + self.overlap[j] * curve[j] + after
            })
            .collect();
        let dot = |v: &Vec<f64>| self.root * v.iter().zip(&sums).map(|(v, s)| v * s).sum::<f64>();
        self.shapes.iter().map(dot).collect()
    }
}

/// Values at all nodes from those at some nodes, by linear interpolation, and constant beyond the ends.
fn interpolate_nodes(at: &[usize], values: &[f64], count: usize) -> Vec<f64> {
    let mut found = vec![values[0]; count];
    for (pair, value) in at.windows(2).zip(values.windows(2)) {
        let step = (value[1] - value[0]) / (pair[1] - pair[0]) as f64;
        for (i, slot) in found[pair[0]..pair[1]].iter_mut().enumerate() {
            *slot = value[0] + step * i as f64;
        }
    }
    let last = at[at.len() - 1];
    found[last..].fill(values[values.len() - 1]);
    found
}
