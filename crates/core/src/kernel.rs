//! The inner loop of the Allan variance: sums of squared second differences over a block of starts.
//!
//! Half the second difference is summed, h = (x + z) / 2 − y + c: an addition, and two products with an addition each,
//! which processors have as one instruction. Several taus go together, so that x is loaded once for all; along a chain
//! of taus m, 2m, 4m … every window is loaded once, because the last point of one tau is the middle point of the next.
//! Everything has a fixed length, so that the compiler can unroll and vectorise without any check inside.

/// Starts handled together.
pub const STARTS: usize = 2048;

/// Partial sums that run side by side; a start always falls into the same one, on every path.
const LANES: usize = 4;

/// Phase points seen from `STARTS` consecutive starts.
pub type Window = [f64; STARTS];

/// Largest number of taus handled in one pass: with more, the sums no longer fit into the registers.
pub const MOST_TAUS: usize = 6;

/// Partial sums that are added at the end, by [`add_lanes`].
pub type Lanes = [f64; LANES];

/// Which instructions to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// AVX2 and FMA where the processor has them, which is found at run time.
    #[default]
    Fastest,
    /// What every processor of the architecture has.
    #[cfg(test)]
    Portable,
}

/// Sums of h² of a few taus over one block of starts.
///
/// `first` is the window at lag 0, `middle[i]` at the lag of tau i, `last[i]` at twice that lag, and `correction[i]` half
/// the second difference of their anchors.
pub struct Batch<'a, const T: usize> {
    /// Window at the starts themselves.
    pub first: &'a Window,
    /// Windows one cluster on.
    pub middle: [&'a Window; T],
    /// Windows two clusters on.
    pub last: [&'a Window; T],
    /// Added to every h.
    pub correction: [f64; T],
    /// Each tau is twice the one before: only the first of `middle` is looked at.
    pub chained: bool,
    /// Window that the next block will need first, which comes into the cache meanwhile.
    pub ahead: &'a Window,
}

impl<const T: usize> Batch<'_, T> {
    /// Adds the squares to `sums`.
    pub fn add_to(&self, sums: &mut [Lanes; T], path: Path) {
        match path {
            #[cfg(target_arch = "x86_64")]
            Path::Fastest => match pulp::x86::V3::try_new() {
                Some(vectors) => vectors.vectorize(Fused { batch: self, sums, vectors }),
                None => self.add::<Plain<false>, true>(sums, Plain),
            },
            // On 64-bit ARM the fused product is part of the base.
            #[cfg(not(target_arch = "x86_64"))]
            Path::Fastest => self.add::<Plain<{ cfg!(target_arch = "aarch64") }>, true>(sums, Plain),
            #[cfg(test)]
            Path::Portable => self.add::<Plain<false>, true>(sums, Plain),
        }
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // Into a function that is compiled for those vectors.
    fn add<P: Processor, const CORRECTED: bool>(&self, sums: &mut [Lanes; T], processor: P) {
        let at =
            |window: &Window, start: usize| -> Lanes { std::array::from_fn(|lane| window[start + lane]) };
        let mut running = *sums;
        if self.chained {
            for start in (0..STARTS).step_by(LANES) {
                processor.prefetch(&self.ahead[start..start + LANES]);
                let x = at(self.first, start);
                let mut y = at(self.middle[0], start);
                for ((sum, last), correction) in running.iter_mut().zip(self.last).zip(self.correction) {
                    let z = at(last, start);
                    add_squares::<P, CORRECTED>(sum, x, y, z, correction);
                    y = z;
                }
            }
        } else {
            for start in (0..STARTS).step_by(LANES) {
                processor.prefetch(&self.ahead[start..start + LANES]);
                let x = at(self.first, start);
                let lags = self.middle.iter().zip(self.last).zip(self.correction);
                for (sum, ((middle, last), correction)) in running.iter_mut().zip(lags) {
                    add_squares::<P, CORRECTED>(sum, x, at(middle, start), at(last, start), correction);
                }
            }
        }
        *sums = running;
    }
}

/// What depends on the processor.
trait Processor: Copy {
    /// Products with an addition are one instruction.
    const FUSED: bool;
    /// Has the line of the cache that numbers begin in fetched.
    fn prefetch(self, numbers: &[f64]);
}

/// Any.
#[derive(Clone, Copy)]
struct Plain<const FUSED: bool>;

impl<const FUSED: bool> Processor for Plain<FUSED> {
    const FUSED: bool = FUSED;

    #[inline(always)]
    #[allow(clippy::inline_always)] // Nothing.
    fn prefetch(self, _: &[f64]) {}
}

#[cfg(target_arch = "x86_64")]
impl Processor for pulp::x86::V3 {
    const FUSED: bool = true;

    #[inline(always)]
    #[allow(clippy::inline_always)] // An instruction.
    fn prefetch(self, numbers: &[f64]) {
        self.sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T1 }>(numbers.as_ptr().cast());
    }
}

/// [`Batch::add`] for the vectors that `pulp` compiles it for.
#[cfg(target_arch = "x86_64")]
struct Fused<'a, const T: usize> {
    batch: &'a Batch<'a, T>,
    sums: &'a mut [Lanes; T],
    vectors: pulp::x86::V3,
}

#[cfg(target_arch = "x86_64")]
impl<const T: usize> pulp::NullaryFnOnce for Fused<'_, T> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // Into a function that is compiled for those vectors.
    fn call(self) {
        if self.batch.correction.iter().all(|&c| c == 0.0) {
            self.batch.add::<_, false>(self.sums, self.vectors);
        } else {
            self.batch.add::<_, true>(self.sums, self.vectors);
        }
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // The loops above are only fast if this is part of them.
fn add_squares<P: Processor, const CORRECTED: bool>(
    sum: &mut Lanes,
    x: Lanes,
    y: Lanes,
    z: Lanes,
    correction: f64,
) {
    for lane in 0..LANES {
        if P::FUSED {
            let h = (x[lane] + z[lane]).mul_add(0.5, -y[lane]);
            let h = if CORRECTED { h + correction } else { h };
            sum[lane] = h.mul_add(h, sum[lane]);
        } else {
            let h = half_difference(x[lane], y[lane], z[lane], correction);
            sum[lane] += h * h;
        }
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

/// The product by ½ is exact, so that fused or not this is the same number.
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn half_difference(x: f64, y: f64, z: f64, correction: f64) -> f64 {
    (0.5 * (x + z) - y) + correction
}

/// The sum of the partial sums.
pub fn add_lanes(sums: Lanes) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
