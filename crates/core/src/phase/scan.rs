//! Running sums of groups of samples: the same additions in the same order, with or without vectors.

use crate::compensated::Sum;

/// Number of samples that are summed plainly; sums over groups keep their rounding errors.
pub(super) const GROUP: usize = 16;

const LANES: usize = 4;

/// Result of a piece of samples.
pub(super) struct Piece {
    /// Largest magnitude of a sample; a NaN is ignored here, but makes the sum NaN.
    pub(super) largest: f64,
    /// Sum of the points.
    pub(super) area: f64,
}

/// Vectors of four numbers, and their operations.
pub(super) trait Vectors: Copy {
    type Vector: Copy;
    fn splat(self, value: f64) -> Self::Vector;
    fn load(self, values: &[f64; LANES]) -> Self::Vector;
    fn store(self, vector: Self::Vector) -> [f64; LANES];
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// The larger of `so_far` and the magnitude of `value`; `so_far` if `value` is NaN.
    fn larger(self, so_far: Self::Vector, value: Self::Vector) -> Self::Vector;
    /// Four of the eight values of two vectors, beginning with the last value of the first vector.
    fn shifted(self, before: Self::Vector, these: Self::Vector) -> Self::Vector;
    /// The same, beginning with the last but one.
    fn by_two(self, before: Self::Vector, these: Self::Vector) -> Self::Vector;
}

/// The points of a piece that begins at `height`, which is advanced to its end; a sample is the step from one to the
/// next.
#[inline(always)]
#[allow(clippy::inline_always)] // Inlined into a function that is compiled for wide vectors.
pub(super) fn sum_piece<S: Vectors>(
    simd: S,
    rate: &[f64],
    slope: f64,
    height: &mut Sum,
    points: &mut [f64],
) -> Piece {
    let (zero, slopes) = (simd.splat(0.0), simd.splat(slope));
    let mut areas = [zero; GROUP / LANES];
    let mut largest = zero;
    let (groups, rest) = rate.split_at(rate.len() / GROUP * GROUP);
    let (group_points, rest_points) = points.split_at_mut(groups.len());
    let groups: &[[[f64; LANES]; GROUP / LANES]] = bytemuck::cast_slice(groups);
    let group_points: &mut [[[f64; LANES]; GROUP / LANES]] = bytemuck::cast_slice_mut(group_points);
    for (samples, points) in groups.iter().zip(group_points) {
        let mut sums = [zero; GROUP / LANES];
        for (sum, samples) in sums.iter_mut().zip(samples) {
            let samples = simd.load(samples);
            largest = simd.larger(largest, samples);
            *sum = simd.subtract(samples, slopes);
        }
        // Each step doubles the number of samples that a sum covers.
        let before = [zero, sums[0], sums[1], sums[2]];
        for (sum, before) in sums.iter_mut().zip(before) {
            *sum = simd.add(*sum, simd.shifted(before, *sum));
        }
        let before = [zero, sums[0], sums[1], sums[2]];
        for (sum, before) in sums.iter_mut().zip(before) {
            *sum = simd.add(*sum, simd.by_two(before, *sum));
        }
        let [a, b, c, d] = sums;
        let (b, c, d) = (simd.add(b, a), simd.add(c, b), simd.add(d, c));
        let (c, d) = (simd.add(c, a), simd.add(d, b));
        let base = simd.splat(height.value());
        let before = [simd.shifted(zero, a), simd.shifted(a, b), simd.shifted(b, c), simd.shifted(c, d)];
        for ((points, area), before) in points.iter_mut().zip(&mut areas).zip(before) {
            let point = simd.add(base, before);
            *points = simd.store(point);
            *area = simd.add(*area, point);
        }
        height.add(simd.store(d)[LANES - 1]);
    }
    let mut piece = Piece {
        largest: simd.store(largest).into_iter().fold(0.0, f64::max),
        area: areas.into_iter().flat_map(|area| simd.store(area)).sum(),
    };
    for (y, point) in rest.iter().zip(rest_points) {
        piece.largest = piece.largest.max(y.abs());
        *point = height.value();
        piece.area += *point;
        height.add(y - slope);
    }
    piece
}

/// Vectors for any processor.
#[derive(Clone, Copy)]
pub(super) struct Plain;

#[inline(always)]
#[allow(clippy::inline_always)] // These functions are a few instructions each.
fn each(f: impl Fn(usize) -> f64) -> [f64; LANES] {
    std::array::from_fn(f)
}

#[allow(clippy::inline_always)]
impl Vectors for Plain {
    type Vector = [f64; LANES];

    #[inline(always)]
    fn splat(self, value: f64) -> [f64; LANES] {
        [value; LANES]
    }

    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> [f64; LANES] {
        *values
    }

    #[inline(always)]
    fn store(self, vector: [f64; LANES]) -> [f64; LANES] {
        vector
    }

    #[inline(always)]
    fn add(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(|k| a[k] + b[k])
    }

    #[inline(always)]
    fn subtract(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(|k| a[k] - b[k])
    }

    #[inline(always)]
    fn larger(self, so_far: [f64; LANES], value: [f64; LANES]) -> [f64; LANES] {
        each(|k| if value[k].abs() > so_far[k] { value[k].abs() } else { so_far[k] })
    }

    #[inline(always)]
    fn shifted(self, before: [f64; LANES], these: [f64; LANES]) -> [f64; LANES] {
        [before[3], these[0], these[1], these[2]]
    }

    #[inline(always)]
    fn by_two(self, before: [f64; LANES], these: [f64; LANES]) -> [f64; LANES] {
        [before[2], before[3], these[0], these[1]]
    }
}

/// Vectors with AVX2, because the compiler does not generate the shuffles.
#[cfg(target_arch = "x86_64")]
#[allow(clippy::inline_always)]
impl Vectors for pulp::x86::V3 {
    type Vector = std::arch::x86_64::__m256d;

    #[inline(always)]
    fn splat(self, value: f64) -> Self::Vector {
        self.avx._mm256_set1_pd(value)
    }

    #[inline(always)]
    fn load(self, values: &[f64; LANES]) -> Self::Vector {
        bytemuck::cast(*values)
    }

    #[inline(always)]
    fn store(self, vector: Self::Vector) -> [f64; LANES] {
        bytemuck::cast(vector)
    }

    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_add_pd(a, b)
    }

    #[inline(always)]
    fn subtract(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        self.avx._mm256_sub_pd(a, b)
    }

    #[inline(always)]
    fn larger(self, so_far: Self::Vector, value: Self::Vector) -> Self::Vector {
        let magnitude = self.avx._mm256_andnot_pd(self.splat(-0.0), value);
        // The instruction returns the second operand if one is NaN.
        self.avx._mm256_max_pd(magnitude, so_far)
    }

    #[inline(always)]
    fn shifted(self, before: Self::Vector, these: Self::Vector) -> Self::Vector {
        self.avx._mm256_shuffle_pd::<0b0101>(self.by_two(before, these), these)
    }

    #[inline(always)]
    fn by_two(self, before: Self::Vector, these: Self::Vector) -> Self::Vector {
        self.avx._mm256_permute2f128_pd::<0x21>(before, these)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summed<S: Vectors>(simd: S, rate: &[f64]) -> (Vec<f64>, Piece, Sum) {
        let mut points = vec![0.0; rate.len()];
        let mut height = Sum { hi: 0.3, lo: 1e-18 };
        let piece = sum_piece(simd, rate, 0.7, &mut height, &mut points);
        (points, piece, height)
    }

    #[test]
    fn vectors_make_no_difference() {
        #[cfg(target_arch = "x86_64")]
        if let Some(vectors) = pulp::x86::V3::try_new() {
            for n in [0, 1, GROUP - 1, GROUP, 5 * GROUP + 7] {
                let rate: Vec<f64> = (0..n).map(|k| f64::from(k as u32).sin() * 3.0).collect();
                let (fast, plain) = (summed(vectors, &rate), summed(Plain, &rate));
                assert_eq!(fast.0, plain.0);
                assert_eq!((fast.1.area, fast.1.largest), (plain.1.area, plain.1.largest));
                assert_eq!((fast.2.hi, fast.2.lo), (plain.2.hi, plain.2.lo));
            }
        }
    }

    #[test]
    fn a_nan_shows_in_the_sum_and_not_in_the_largest() {
        for at in [0, 5, GROUP, 2 * GROUP + 3] {
            let mut rate = vec![-2.0; 2 * GROUP + 5];
            rate[at] = f64::NAN;
            let (_, piece, height) = summed(Plain, &rate);
            assert!(height.value().is_nan() && (1.9..2.1).contains(&piece.largest), "{at}");
        }
    }
}
