//! Cosine and sine modes of series, and the modes of curves that the mean of a record may follow.

use crate::likelihood::summary::Summary;
use sigmatau_fft::Complex64;
use std::f64::consts::PI;

impl Summary {
    /// The cosine modes of a ramp of slope 1 at the centres of the blocks, scaled like those of the record.
    #[must_use]
    pub(crate) fn modes_of_ramp(&self) -> Vec<f64> {
        if self.masked.is_some() {
            return self.modes_of(&self.centres());
        }
        self.modes_in_closed_form(|k, theta| {
            let odd = if k % 2 == 0 { 0.0 } else { 2.0 };
            -odd * self.block_length() * (0.5 * theta).cos() / (4.0 * (0.5 * theta).sin().powi(2))
        })
    }

    /// The cosine modes of exp(−t/time), beginning with the first sample.
    #[must_use]
    pub(crate) fn modes_of_decay(&self, time: f64) -> Vec<f64> {
        if self.masked.is_some() {
            return self.modes_of(&self.centres().iter().map(|t| (-t / time).exp()).collect::<Vec<_>>());
        }
        let step = self.block_length() / time;
        let (p, lost) = ((-step).exp(), -(-step).exp_m1());
        let remainder = (-step * self.blocks as f64).exp();
        self.modes_in_closed_form(|k, theta| {
            let end = if k % 2 == 0 { remainder } else { -remainder };
            let sine = (0.5 * theta).sin();
            p.sqrt() * (1.0 - end) * lost * (0.5 * theta).cos() / (lost * lost + 4.0 * p * sine * sine)
        })
    }

    /// The cosine modes of a cosine and of a sine, whose phase is 0 in the middle of the record.
    #[must_use]
    pub(crate) fn modes_of_line(&self, frequency: f64) -> [Vec<f64>; 2] {
        self.some_modes_of_line(frequency, &(0..self.modes.len()).collect::<Vec<_>>())
    }

    /// [`Self::modes_of_line`] for some modes, by their numbers minus 1.
    #[must_use]
    pub(crate) fn some_modes_of_line(&self, frequency: f64, modes: &[usize]) -> [Vec<f64>; 2] {
        let step = 2.0 * PI * frequency * self.block_length();
        let m = self.blocks as f64;
        if self.masked.is_some() {
            let angle = |i: usize| step * (i as f64 + 0.5 - 0.5 * m);
            let curves: [Vec<f64>; 2] = [
                (0..self.blocks).map(|i| angle(i).cos()).collect(),
                (0..self.blocks).map(|i| angle(i).sin()).collect(),
            ];
            return curves.map(|curve| {
                let all = self.modes_of(&curve);
                modes.iter().map(|&k| all[k]).collect()
            });
        }
        // Σ cos(ω(i + ½ − m/2)) cos θ(i + ½) is 0 for odd numbers, the sum for the sine is 0 for even ones.
        let scale = (2.0 / m * self.block_length()).sqrt();
        let (half, end) = (0.5 * step, 0.5 * step * m);
        let mut cosine_and_sine = [vec![0.0; modes.len()], vec![0.0; modes.len()]];
        for (i, k) in modes.iter().map(|k| k + 1).enumerate() {
            let middle = 0.5 * PI * k as f64 / m;
            let difference = half - middle;
            let sine = if k % 2 == 0 { end.sin() } else { end.cos() };
            let sum = if (difference * m).abs() < 1e-6 {
                let sign = if (k / 2) % 2 == 0 { 1.0 } else { -1.0 };
                0.5 * m * sign * if k % 2 == 0 { 1.0 } else { -1.0 }
            } else {
                sine * half.sin() * middle.cos() / ((half + middle).sin() * difference.sin())
            };
            cosine_and_sine[k % 2][i] = scale * sum;
        }
        cosine_and_sine
    }

    /// Modes from the sum of a curve times cos θ(i + ½) in closed form.
    fn modes_in_closed_form(&self, sum: impl Fn(usize, f64) -> f64) -> Vec<f64> {
        let m = self.blocks as f64;
        let scale = (2.0 / m * self.block_length()).sqrt();
        (1..=self.modes.len()).map(|k| scale * sum(k, PI * k as f64 / m)).collect()
    }

    /// The modes of a curve given at the centres of the blocks, scaled like those of the record.
    #[must_use]
    pub fn modes_of(&self, curve: &[f64]) -> Vec<f64> {
        if let Some(masked) = &self.masked {
            return masked.string.modes_of(curve);
        }
        let mut modes = cosine_modes(curve, self.modes.len());
        let root = self.block_length().sqrt();
        for x in &mut modes {
            *x *= root;
        }
        modes
    }
}

/// The orthonormal DCT-II of a series, modes 1 … `count`, by a transform of the even and odd elements (Makhoul 1980,
/// doi 10.1109/TASSP.1980.1163351).
pub(crate) fn cosine_modes(series: &[f64], count: usize) -> Vec<f64> {
    let m = series.len();
    let (output, scale) = (folded_transform(series), (2.0 / m as f64).sqrt());
    (1..=count)
        .map(|k| {
            let (sin, cos) = (PI * k as f64 / (2.0 * m as f64)).sin_cos();
            let (z, sign) = if k < output.len() { (output[k], 1.0) } else { (output[m - k], -1.0) };
            scale * (z.re * cos + sign * z.im * sin)
        })
        .collect()
}

/// The orthonormal DST-II of a series, modes 1 … `count`: mode k is the cosine mode m − k of the series with alternating
/// signs. The series is overwritten.
pub(crate) fn sine_modes(series: &mut [f64], count: usize) -> Vec<f64> {
    let m = series.len();
    series.iter_mut().skip(1).step_by(2).for_each(|x| *x = -*x);
    let (z, scale) = (folded_transform(series), (2.0 / m as f64).sqrt());
    (1..=count)
        .map(|k| {
            let (sin, cos) = (PI * k as f64 / (2.0 * m as f64)).sin_cos();
            scale * (z[k].re * sin - z[k].im * cos)
        })
        .collect()
}

/// The transform of the even elements of a series, followed by the odd ones from the last to the first.
fn folded_transform(series: &[f64]) -> Vec<Complex64> {
    let mut folded: Vec<f64> = series.iter().step_by(2).copied().collect();
    folded.extend(series[1..].iter().step_by(2).rev());
    let transform = sigmatau_fft::forward(series.len());
    let mut output = transform.make_output_vec();
    let done = transform.process(&mut folded, &mut output);
    debug_assert!(done.is_ok());
    output
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wiggle(n: usize) -> Vec<f64> {
        (0..n).map(|i| (0.37 * i as f64).sin() + 0.1 * ((i * i % 97) as f64) + 9.8).collect()
    }

    #[test]
    fn modes_are_those_of_the_definition() {
        let x = wiggle(61);
        for (k, got) in (1..).zip(cosine_modes(&x, 60)) {
            let sum: f64 = (0..61).map(|t| x[t] * (PI * f64::from(k) * (t as f64 + 0.5) / 61.0).cos()).sum();
            assert!((got - sum * (2.0_f64 / 61.0).sqrt()).abs() < 1e-11);
        }
    }

    #[test]
    fn sine_modes_are_those_of_the_definition() {
        for n in [60, 61] {
            let x = wiggle(n);
            for (k, got) in (1..).zip(sine_modes(&mut x.clone(), n / 2)) {
                let sine = |t: usize| (PI * f64::from(k) * (t as f64 + 0.5) / n as f64).sin();
                let sum: f64 = (0..n).map(|t| x[t] * sine(t)).sum();
                assert!((got - sum * (2.0 / n as f64).sqrt()).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn closed_modes_are_those_of_the_curves() {
        let s = Summary::of(&wiggle(601), 0.5).unwrap();
        let centres: Vec<f64> = (0..s.blocks).map(|i| (i as f64 + 0.5) * s.block_length()).collect();
        let same = |closed: Vec<f64>, curve: Vec<f64>| {
            let scale = closed.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            closed.iter().zip(s.modes_of(&curve)).all(|(a, b)| (a - b).abs() < 1e-10 * scale)
        };
        assert!(same(s.modes_of_ramp(), centres.clone()));
        assert!(same(s.modes_of_decay(40.0), centres.iter().map(|t| (-t / 40.0).exp()).collect()));
    }
}
