//! The inner loop of the Allan variance: sums of squared second differences over a block of starts.
//!
//! Half the second difference is summed, h = (x + z) / 2 − y + c, because a product by ½ is exact and shares the work
//! between the multipliers and the adders, which a doubled y would not. A chain of taus m, 2m, 4m … loads every window
//! once: the last point of one tau is the middle point of the next. Everything has a fixed length, so that the
//! compiler can unroll and vectorise without any check inside.

use pulp::{Arch, Simd, WithSimd};

/// Starts handled together.
pub const STARTS: usize = 1024;

/// Partial sums that run side by side; a start always falls into the same one, on every path.
const LANES: usize = 4;

/// Phase points seen from `STARTS` consecutive starts.
pub type Window = [f64; STARTS];

/// Largest number of taus handled in one pass.
pub const CHAIN: usize = 4;

/// Partial sums that are added at the end, by [`add_lanes`].
pub type Lanes = [f64; LANES];

/// Sums of h² for the chain of taus m, 2m, 4m …: `first` is the window at lag 0, `middle` at lag m, `last[i]` at
/// lag 2m·2ⁱ, and `correction[i]` half the second difference of their anchors.
///
/// Runs on the widest vectors that the processor has, found at run time. Products and sums are not fused, so every
/// processor gives the same bits.
pub fn chain<const T: usize>(
    first: &Window,
    middle: &Window,
    last: [&Window; T],
    correction: [f64; T],
    sums: &mut [Lanes; T],
) {
    Arch::new().dispatch(Chain { first, middle, last, correction, sums });
}

/// The arguments of [`chain`].
struct Chain<'a, const T: usize> {
    first: &'a Window,
    middle: &'a Window,
    last: [&'a Window; T],
    correction: [f64; T],
    sums: &'a mut [Lanes; T],
}

impl<const T: usize> WithSimd for Chain<'_, T> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // Into a function that is compiled for those vectors.
    fn with_simd<S: Simd>(self, _: S) {
        let at =
            |window: &Window, start: usize| -> Lanes { std::array::from_fn(|lane| window[start + lane]) };
        let mut sums = *self.sums;
        for start in (0..STARTS).step_by(LANES) {
            let x = at(self.first, start);
            let mut y = at(self.middle, start);
            for ((sum, window), correction) in sums.iter_mut().zip(self.last).zip(self.correction) {
                let z = at(window, start);
                for lane in 0..LANES {
                    let h = half_difference(x[lane], y[lane], z[lane], correction);
                    sum[lane] += h * h;
                }
                y = z;
            }
        }
        *self.sums = sums;
    }
}

/// The same sum for one tau and fewer than [`STARTS`] starts; the slices have one length.
pub fn partial(first: &[f64], middle: &[f64], last: &[f64], correction: f64) -> f64 {
    let mut sums = [0.0; LANES];
    for (start, ((&x, &y), &z)) in first.iter().zip(middle).zip(last).enumerate() {
        let h = half_difference(x, y, z, correction);
        sums[start % LANES] += h * h;
    }
    add_lanes(sums)
}

#[inline(always)]
#[allow(clippy::inline_always)] // The loop above is only fast if this is part of it.
fn half_difference(x: f64, y: f64, z: f64, correction: f64) -> f64 {
    (0.5 * (x + z) - y) + correction
}

/// The sum of the partial sums.
pub fn add_lanes(sums: Lanes) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
