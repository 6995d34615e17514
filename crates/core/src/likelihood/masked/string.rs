//! The lowest modes of a loaded string: eigenvectors of a symmetric tridiagonal matrix, by bisection and inverse iteration.

/// Number of eigenvalues that are bisected together, so that their divisions overlap.
const LANES: usize = 8;

/// Relative width at which a bisection ends.
const BISECTION_WIDTH: f64 = 1e-10;

/// Relative size of the last of Newton's steps, whose square is the remaining error, and largest number of these steps.
const NEWTON_WIDTH: f64 = 1e-9;
const NEWTON_STEPS: usize = 10;

/// Number of eigenvectors that are iterated together, for the same reason.
const VECTORS: usize = 4;

type Lanes = [f64; VECTORS];

/// Number of steps of inverse iteration.
const ITERATIONS: usize = 2;

/// Relative distance of neighbouring eigenvalues below which they form a cluster, whose vectors are orthogonalised in turn.
/// Long gaps cause pairs of them.
const CLUSTER_DISTANCE: f64 = 1e-3;

/// The matrix of a string of nodes with masses and free ends.
#[derive(Debug, Clone)]
pub(super) struct Tridiagonal {
    pub diagonal: Vec<f64>,
    /// Off-diagonal elements, one fewer than diagonal ones.
    pub beside: Vec<f64>,
}

impl Tridiagonal {
    /// Eigenvalues 1 … `count` in ascending order (the lowest, 0, is left out), and orthonormal vectors.
    pub(super) fn lowest(&self, count: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
        let squares: Vec<f64> = self.beside.iter().map(|e| e * e).collect();
        let values = self.eigenvalues(&squares, count);
        let vectors = self.eigenvectors(&values);
        (values, vectors)
    }

    fn eigenvalues(&self, squares: &[f64], count: usize) -> Vec<f64> {
        // An upper limit of the wanted eigenvalues: the spectrum begins at 0.
        let n = self.diagonal.len();
        let norm = self.diagonal.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let mut top = norm * (count as f64 / n as f64).powi(2);
        while self.below(squares, [top; LANES]).0[0] <= count {
            top *= 2.0;
        }
        let mut values: Vec<f64> = Vec::with_capacity(count);
        for start in (1..=count).step_by(LANES) {
            let least = values.last().copied().unwrap_or(0.0) * (1.0 - 1e-9);
            let mut brackets: [Bracket; LANES] =
                std::array::from_fn(|i| Bracket::new((start + i).min(count), least, top));
            let mut at = expected(&values, least, top);
            for _ in 0..200 {
                let (found, steps) = self.below(squares, at);
                for bracket in &mut brackets {
                    (0..LANES).for_each(|j| bracket.narrow(found[j], at[j]));
                }
                at = std::array::from_fn(|i| brackets[i].next(at[i], steps[i]));
                if brackets.iter().all(|bracket| bracket.done) {
                    break;
                }
            }
            values.extend_from_slice(&at[..LANES.min(count + 1 - start)]);
        }
        values
    }

    /// Numbers of eigenvalues below some values, from the signs in Sturm's sequence, and Newton's steps of the
    /// characteristic polynomial, whose logarithmic derivative is the sum of those of the sequence.
    fn below(&self, squares: &[f64], x: [f64; LANES]) -> ([usize; LANES], [f64; LANES]) {
        let (mut found, mut sum) = ([0.0; LANES], [0.0; LANES]);
        let (mut inverse, mut slope) = ([0.0; LANES], [0.0; LANES]);
        let tiny = f64::MIN_POSITIVE / f64::EPSILON;
        for (j, &d) in self.diagonal.iter().enumerate() {
            let e = if j == 0 { 0.0 } else { squares[j - 1] };
            for i in 0..LANES {
                let ratio = e * inverse[i];
                let next = d - x[i] - ratio;
                let q = if next.abs() < tiny { -tiny } else { next };
                inverse[i] = 1.0 / q;
                slope[i] = (ratio * slope[i] - 1.0) * inverse[i];
                sum[i] += slope[i];
                found[i] += f64::from(u8::from(q < 0.0));
            }
        }
        (found.map(|x| x as usize), sum.map(f64::recip))
    }

    /// The vectors of ascending eigenvalues, orthogonal within each cluster.
    fn eigenvectors(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(values.len() + VECTORS);
        let mut cluster = 0; // beginning of the cluster of the last vector
        for start in (0..values.len()).step_by(VECTORS) {
            let value: Lanes = std::array::from_fn(|i| values[(start + i).min(values.len() - 1)]);
            let factors = Factors::new(self, value);
            // The initial vectors differ, and are not nearly orthogonal to any eigenvector.
            let number: Lanes = std::array::from_fn(|i| (start + i + 1) as f64);
            let mut x: Vec<Lanes> = (0..self.diagonal.len())
                .map(|j| number.map(|k| 1.0 + 0.5 * part(j as f64 * k * 0.618_033_988_749_895)))
                .collect();
            let before = cluster;
            for _ in 0..ITERATIONS {
                factors.solve(&mut x);
                vectors.truncate(start);
                cluster = before;
                for k in start..start + VECTORS {
                    let mut own: Vec<f64> = x.iter().map(|row| row[k - start]).collect();
                    if k < values.len()
                        && (k == 0 || values[k] - values[k - 1] > CLUSTER_DISTANCE * values[k])
                    {
                        cluster = k;
                    }
                    scale(&mut own);
                    if cluster < k {
                        for other in &vectors[cluster..k] {
                            let shared: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
                            own.iter_mut().zip(other).for_each(|(a, b)| *a -= shared * b);
                        }
                        scale(&mut own);
                    }
                    x.iter_mut().zip(&own).for_each(|(row, a)| row[k - start] = *a);
                    vectors.push(own);
                }
            }
        }
        vectors.truncate(values.len());
        vectors
    }
}

/// The fractional part of a positive number, without the function call that processors without SSE 4.1 need.
fn part(x: f64) -> f64 {
    x - x as u64 as f64
}

/// Where the next eigenvalues are expected: those of a string grow with the square of their number.
fn expected(values: &[f64], least: f64, top: f64) -> [f64; LANES] {
    let latest = &values[values.len().saturating_sub(LANES)..];
    let (Some(first), Some(last)) = (latest.first(), latest.last()) else {
        return std::array::from_fn(|i| top * ((i + 1) as f64 / LANES as f64).powi(2));
    };
    let step = (last.sqrt() - first.sqrt()) / (LANES - 1) as f64;
    std::array::from_fn(|i| (last.sqrt() + (i + 1) as f64 * step).powi(2).clamp(least, top))
}

/// Limits of an eigenvalue, and the numbers of eigenvalues below them.
#[derive(Debug, Clone, Copy)]
struct Bracket {
    wanted: usize,
    low: f64,
    high: f64,
    below_low: usize,
    below_high: usize,
    steps: usize,
    done: bool,
}

impl Bracket {
    fn new(wanted: usize, low: f64, high: f64) -> Self {
        Self { wanted, low, high, below_low: 0, below_high: usize::MAX, steps: 0, done: false }
    }

    fn narrow(&mut self, found: usize, at: f64) {
        if found > self.wanted {
            if at < self.high {
                (self.high, self.below_high) = (at.max(self.low), found);
            }
        } else if at > self.low {
            (self.low, self.below_low) = (at.min(self.high), found);
        }
    }

    /// The next value, or the eigenvalue itself: by Newton's method if no other eigenvalue is between the limits, and
    /// otherwise, or if that fails, by bisection.
    fn next(&mut self, at: f64, step: f64) -> f64 {
        if self.done {
            return at;
        }
        let newton = at - step;
        if self.below_low == self.wanted && self.below_high == self.wanted + 1 && self.steps < NEWTON_STEPS {
            self.steps += 1;
            self.done = step.abs() <= NEWTON_WIDTH * at && self.contains(newton);
            if self.done || (newton > self.low && newton < self.high) {
                return newton;
            }
        }
        self.done = self.high - self.low <= BISECTION_WIDTH * self.high;
        0.5 * (self.low + self.high)
    }

    /// Whether a value is between the limits, but for rounding.
    fn contains(&self, value: f64) -> bool {
        let rounding = BISECTION_WIDTH * self.high;
        value >= self.low - rounding && value <= self.high + rounding
    }
}

fn scale(x: &mut [f64]) {
    let largest = in_lanes(x, |a, b| a.max(b.abs())).into_iter().fold(0.0, f64::max);
    let small = 1.0 / largest;
    let squares: f64 = in_lanes(x, |a, b| a + (b * small).powi(2)).into_iter().sum();
    let factor = small / squares.sqrt();
    for a in x {
        *a *= factor;
    }
}

/// A fold from 0 in independent lanes.
fn in_lanes(x: &[f64], step: impl Fn(f64, f64) -> f64) -> [f64; LANES] {
    let mut found = [0.0; LANES];
    for chunk in x.chunks(LANES) {
        for (found, &x) in found.iter_mut().zip(chunk) {
            *found = step(*found, x);
        }
    }
    found
}

/// Triangular factors of T − λ with row exchanges, for several λ at once.
struct Factors {
    /// Rows of the upper factor: the inverse of the diagonal element, and two elements to its right.
    upper: Vec<[Lanes; 3]>,
    /// Multiplier of each step, and whether its rows were exchanged.
    lower: Vec<(Lanes, [bool; VECTORS])>,
}

impl Factors {
    fn new(matrix: &Tridiagonal, shift: Lanes) -> Self {
        let n = matrix.diagonal.len();
        let norm = matrix.diagonal.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let beside = |j: usize| matrix.beside.get(j).copied().unwrap_or(0.0);
        let (mut upper, mut lower) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let mut row = [shift.map(|s| matrix.diagonal[0] - s), [beside(0); VECTORS], [0.0; VECTORS]];
        for j in 0..n - 1 {
            let (below, after, diagonal) = (beside(j), beside(j + 1), matrix.diagonal[j + 1]);
            let (mut top, mut factor, mut exchanged) =
                ([[0.0; VECTORS]; 3], [0.0; VECTORS], [false; VECTORS]);
            for i in 0..VECTORS {
                let (own, next) = ([row[0][i], row[1][i], row[2][i]], [below, diagonal - shift[i], after]);
                let kept = own[0].abs() >= below.abs() && own[0] != 0.0;
                let choose = |a: f64, b: f64| if kept { a } else { b };
                let inverse = 1.0 / choose(own[0], next[0]);
                let (first, second) = (choose(own[1], next[1]), choose(own[2], next[2]));
                factor[i] = choose(next[0], own[0]) * inverse;
                exchanged[i] = !kept;
                (top[0][i], top[1][i], top[2][i]) = (inverse, first, second);
                row[0][i] = choose(next[1], own[1]) - factor[i] * first;
                row[1][i] = choose(next[2], own[2]) - factor[i] * second;
                row[2][i] = 0.0;
            }
            upper.push(top);
            lower.push((factor, exchanged));
        }
        let least = f64::EPSILON * norm;
        row[0] = row[0].map(|d| 1.0 / if d.abs() < least { least } else { d });
        upper.push(row);
        Self { upper, lower }
    }

    fn solve(&self, x: &mut [Lanes]) {
        let mut here = x[0];
        for (j, (factor, exchanged)) in self.lower.iter().enumerate() {
            let mut next = x[j + 1];
            for i in 0..VECTORS {
                let (a, b) = if exchanged[i] { (next[i], here[i]) } else { (here[i], next[i]) };
                (x[j][i], next[i]) = (a, b - factor[i] * a);
            }
            here = next;
        }
        let last = x.len() - 1;
        x[last] = here;
        let (mut after, mut next) = ([0.0; VECTORS], [0.0; VECTORS]);
        for (slot, row) in x.iter_mut().zip(&self.upper).rev() {
            for i in 0..VECTORS {
                slot[i] = (slot[i] - row[1][i] * next[i] - row[2][i] * after[i]) * row[0][i];
            }
            (after, next) = (next, *slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The string of nodes with masses, neighbours joined by springs.
    fn string(masses: &[f64], springs: &[f64]) -> Tridiagonal {
        let n = masses.len();
        let spring = |j: usize| springs.get(j).copied().unwrap_or(0.0);
        Tridiagonal {
            diagonal: (0..n)
                .map(|j| (if j > 0 { spring(j - 1) } else { 0.0 } + spring(j)) / masses[j])
                .collect(),
            beside: (0..n - 1).map(|j| -spring(j) / (masses[j] * masses[j + 1]).sqrt()).collect(),
        }
    }

    /// Largest residual relative to the eigenvalue, and largest product of two vectors.
    fn errors(matrix: &Tridiagonal, values: &[f64], vectors: &[Vec<f64>]) -> (f64, f64) {
        let n = matrix.diagonal.len();
        let (mut residual, mut shared) = (0.0_f64, 0.0_f64);
        for (k, (value, v)) in values.iter().zip(vectors).enumerate() {
            let mut square = 0.0;
            for j in 0..n {
                let mut sum = (matrix.diagonal[j] - value) * v[j];
                if j > 0 {
                    sum += matrix.beside[j - 1] * v[j - 1];
                }
                if j + 1 < n {
                    sum += matrix.beside[j] * v[j + 1];
                }
                square += sum * sum;
            }
            residual = residual.max(square.sqrt() / value);
            for other in &vectors[..k] {
                shared = shared.max(v.iter().zip(other).map(|(a, b)| a * b).sum::<f64>().abs());
            }
        }
        (residual, shared)
    }

    #[test]
    fn equal_masses_give_cosines() {
        let n = 200;
        let matrix = string(&vec![1.0; n], &vec![1.0; n - 1]);
        let (values, vectors) = matrix.lowest(25);
        for (k, (value, vector)) in (1..).zip(values.iter().zip(&vectors)) {
            let angle = PI * f64::from(k) / n as f64;
            assert!((value / (4.0 * (0.5 * angle).sin().powi(2)) - 1.0).abs() < 1e-11, "{k}: {value}");
            let sign = vector[0].signum();
            let worst = (0..n)
                .map(|j| {
                    (sign * vector[j] - (2.0 / n as f64).sqrt() * (angle * (j as f64 + 0.5)).cos()).abs()
                })
                .fold(0.0, f64::max);
            assert!(worst < 1e-7, "{k}: {worst}");
        }
    }

    #[test]
    fn uneven_masses_and_long_gaps() {
        // Masses over five decades; two and four equal pieces joined by very weak springs.
        let n = 800;
        let uneven: Vec<f64> =
            (0..n).map(|j| 10_f64.powf(-5.0 * (j as f64 * 0.754_877_666).fract())).collect();
        let mut cut = vec![1.0; n - 1];
        cut[n / 2 - 1] = 1e-7;
        let mut quarters = cut.clone();
        (quarters[n / 4 - 1], quarters[3 * n / 4 - 1]) = (1e-7, 1e-7);
        for (masses, springs) in [
            (uneven.clone(), vec![1.0; n - 1]),
            (uneven, cut.clone()),
            (vec![1.0; n], cut),
            (vec![1.0; n], quarters),
        ] {
            let matrix = string(&masses, &springs);
            let (values, vectors) = matrix.lowest(100);
            let (residual, shared) = errors(&matrix, &values, &vectors);
            assert!(values.windows(2).all(|p| p[1] >= p[0]));
            assert!(shared < 1e-6 && residual < 1e-3, "{shared}, residual {residual}");
        }
    }
}
