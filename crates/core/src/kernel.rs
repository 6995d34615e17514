//! The inner loop of the Allan variance: sums of squared second differences over a block of starts.
//!
//! The summed squares are those of half the second difference, h = (x + z) / 2 − y + c: an addition and two fused
//! multiply-adds, and one more addition unless all c are 0. Several taus are computed together, so that x is loaded
//! once. Along a chain of taus m, 2m, 4m … each window is loaded once, because the last point of one tau is the middle
//! point of the next. All loops have a fixed length, so that the compiler can unroll and vectorise them without checks.

/// Starts handled together.
pub const STARTS: usize = 2048;

/// Number of partial sums that run side by side; a start belongs to the same sum on every path.
const LANES: usize = 4;

/// Phase points at one lag from `STARTS` consecutive starts.
pub type Window = [f64; STARTS];

/// Largest number of taus handled in one pass: with more, the sums no longer fit into the registers.
pub const MAX_TAUS: usize = 6;

/// Partial sums that are added at the end, by [`add_lanes`].
pub type Lanes = [f64; LANES];

/// Which instructions to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// AVX2 and FMA, if the processor has them, which is detected at run time.
    #[default]
    Fastest,
    /// Instructions of every processor of the architecture.
    #[cfg(test)]
    Portable,
}

/// Sums of h² of a few taus over one block of starts.
///
/// `first` is the window at lag 0, `middle[i]` at the lag of tau i, `last[i]` at twice that lag, and `correction[i]` half
/// the second difference of the anchors of the phase, to which the points of these three windows are relative.
pub struct Batch<'a, const T: usize> {
    /// Window at the starts themselves.
    pub first: &'a Window,
    /// Windows one cluster later.
    pub middle: [&'a Window; T],
    /// Windows two clusters later.
    pub last: [&'a Window; T],
    /// Added to every h.
    pub correction: [f64; T],
    /// Whether each tau is twice the previous one; only the first window of `middle` is then used.
    pub chained: bool,
    /// Window that the next block needs first, prefetched into the cache.
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
            // On 64-bit ARM the fused multiply-add belongs to the basic instructions.
            #[cfg(not(target_arch = "x86_64"))]
            Path::Fastest => self.add::<Plain<{ cfg!(target_arch = "aarch64") }>, true>(sums, Plain),
            #[cfg(test)]
            Path::Portable => self.add::<Plain<false>, true>(sums, Plain),
        }
    }

    #[inline(always)]
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for those vectors.
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

/// Properties of a processor.
trait Processor: Copy {
    /// Whether a product with an addition is one instruction.
    const FUSED: bool;
    /// Prefetches the cache line at the beginning of numbers.
    fn prefetch(self, numbers: &[f64]);
}

/// Any processor.
#[derive(Clone, Copy)]
struct Plain<const FUSED: bool>;

impl<const FUSED: bool> Processor for Plain<FUSED> {
    const FUSED: bool = FUSED;

    #[inline(always)]
    #[allow(clippy::inline_always)] // Does nothing.
    fn prefetch(self, _: &[f64]) {}
}

#[cfg(target_arch = "x86_64")]
impl Processor for pulp::x86::V3 {
    const FUSED: bool = true;

    #[inline(always)]
    #[allow(clippy::inline_always)] // A single instruction.
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
    #[allow(clippy::inline_always)] // Inlined into a function that is compiled for those vectors.
    fn call(self) {
        if self.batch.correction.iter().all(|&c| c == 0.0) {
            self.batch.add::<_, false>(self.sums, self.vectors);
        } else {
            self.batch.add::<_, true>(self.sums, self.vectors);
        }
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // The loops above are only fast if this is inlined.
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

/// The sum of h² for one tau and fewer than [`STARTS`] starts; the slices have equal lengths.
pub fn partial(first: &[f64], middle: &[f64], last: &[f64], correction: f64) -> f64 {
    let mut sums = [0.0; LANES];
    for (start, ((&x, &y), &z)) in first.iter().zip(middle).zip(last).enumerate() {
        let h = half_difference(x, y, z, correction);
        sums[start % LANES] += h * h;
    }
    add_lanes(sums)
}

/// Half the second difference. The product with ½ is exact, so that the result does not depend on fusing.
#[inline(always)]
#[allow(clippy::inline_always)] // As above.
fn half_difference(x: f64, y: f64, z: f64, correction: f64) -> f64 {
    (0.5 * (x + z) - y) + correction
}

/// The sum of the partial sums.
pub fn add_lanes(sums: Lanes) -> f64 {
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}
