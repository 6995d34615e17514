//! The Allan variance of a record that arrives in pieces, in bounded memory.
//!
//! Cluster sizes up to [`LARGEST`] samples are exact: every overlapping difference is counted, by the kernel that sums a
//! whole record. For larger sizes the samples are added up in groups of [`GROUP`], which keeps each 64th phase point, and
//! these are treated in the same way up to [`LARGEST`] groups, and so on. A size m above [`LARGEST`] is thus averaged over
//! the starts that are multiples of its stride, at most m/64. This loses almost no precision if the differences of
//! neighbouring starts are similar, as for white noise of the rate and slower noise. For quantization noise it loses most
//! of it.
//!
//! Two accumulators of adjacent stretches of a record can be merged. The index in the record determines whether a start is
//! used, so that the terms do not depend on how the record is divided.

use crate::allan::{Counting, Overlap, allan_variance};
use crate::error::Error;
use crate::phase::{LARGEST_RATE, Phase};

mod stage;

use stage::Stage;
pub use stage::{GROUP, LARGEST, Strided};

/// Treatment of clusters of more than [`LARGEST`] samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Long {
    /// All samples are stored, so that every difference counts: 8 bytes per sample.
    Exact,
    /// Strides of at most m/64, with a few megabytes for a record of any length.
    Strided,
}

/// The running sums of one channel.
#[derive(Debug, Clone)]
pub struct Accumulator {
    start: u64,
    store: Store,
}

#[derive(Debug, Clone)]
enum Store {
    Kept { rate: Vec<f64>, m: Vec<usize> },
    Stage(Box<Stage>),
}

impl Accumulator {
    /// An accumulator for the stretch of a record that begins with the sample of index `start`, and for the cluster
    /// sizes `m`. Snapshots omit sizes that are too large for the record.
    ///
    /// # Errors
    ///
    /// [`Error::ClusterSize`] for the first size that is 0, or that is not a multiple of its [`stride`] with
    /// [`Long::Strided`].
    pub fn new(m: &[usize], long: Long, start: u64) -> Result<Self, Error> {
        let mut m = m.to_vec();
        m.sort_unstable();
        m.dedup();
        let fits = |m: usize| m > 0 && (long == Long::Exact || m % stride(m) == 0);
        if let Some(&m) = m.iter().find(|&&m| !fits(m)) {
            return Err(Error::ClusterSize { m, largest: usize::MAX });
        }
        let store = match long {
            Long::Exact => Store::Kept { rate: Vec::new(), m },
            Long::Strided => Store::Stage(Box::new(Stage::new(&m, start))),
        };
        Ok(Self { start, store })
    }

    /// Index in the record of the first sample.
    #[must_use]
    pub fn start(&self) -> u64 {
        self.start
    }

    /// Number of samples received.
    #[must_use]
    pub fn samples(&self) -> u64 {
        match &self.store {
            Store::Kept { rate, .. } => rate.len() as u64,
            Store::Stage(stage) => stage.samples(),
        }
    }

    /// Adds the next samples of the record. The result does not depend on the sizes of the pieces.
    ///
    /// # Errors
    ///
    /// [`Error::NonFinite`] with the index in `rate`; then none of its samples is added.
    pub fn push(&mut self, rate: &[f64]) -> Result<(), Error> {
        if let Some(index) = first_unusable(rate) {
            return Err(Error::NonFinite { index });
        }
        match &mut self.store {
            Store::Kept { rate: kept, .. } => {
                let bytes = size_of_val(rate);
                kept.try_reserve(rate.len()).map_err(|_| Error::Memory { bytes })?;
                kept.extend_from_slice(rate);
            }
            Store::Stage(stage) => stage.push(rate)?,
        }
        Ok(())
    }

    /// Adds the sums of the accumulator of the next stretch.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] `start` if `later` does not begin where this one ends, `m` if its sizes or its
    /// treatment of long clusters differ. Then nothing has changed.
    pub fn merge(&mut self, later: &Self) -> Result<(), Error> {
        if later.start != self.start + self.samples() {
            return Err(Error::Parameter { name: "start", value: later.start as f64 });
        }
        let other_kind = Error::Parameter { name: "m", value: f64::NAN };
        match (&mut self.store, &later.store) {
            (Store::Kept { rate, m }, Store::Kept { rate: more, m: theirs }) if m == theirs => {
                rate.extend_from_slice(more);
                Ok(())
            }
            (Store::Stage(stage), Store::Stage(theirs)) if stage.same_sizes(theirs) => {
                stage.merge(theirs.as_ref().clone())
            }
            _ => Err(other_kind),
        }
    }

    /// The state of the accumulator in words of 64 bits, for [`Accumulator::restored`].
    #[must_use]
    pub fn state(&self) -> Vec<u64> {
        match &self.store {
            Store::Kept { rate, .. } => rate.iter().map(|y| y.to_bits()).collect(),
            Store::Stage(stage) => {
                let mut words = Vec::new();
                stage.write(&mut words);
                words
            }
        }
    }

    /// The accumulator with the `state` of another one with the same arguments, which it continues bit for bit.
    ///
    /// # Errors
    ///
    /// Those of [`Accumulator::new`], and [`Error::Length`] for words that are not such a state.
    pub fn restored(m: &[usize], long: Long, start: u64, state: &[u64]) -> Result<Self, Error> {
        let mut found = Self::new(m, long, start)?;
        let mut words = state.iter().copied();
        let whole = match &mut found.store {
            Store::Kept { rate, .. } => {
                *rate = words.by_ref().map(f64::from_bits).collect();
                first_unusable(rate).is_none()
            }
            Store::Stage(stage) => stage.read(&mut words).is_some(),
        };
        let rest = words.count();
        if whole && rest == 0 {
            return Ok(found);
        }
        Err(Error::Length { expected: state.len() - rest, got: state.len() })
    }

    /// The Allan variances of all samples so far, for the sizes with a pair, in increasing order.
    ///
    /// # Errors
    ///
    /// Those of [`allan_variance`], none of which accepted samples can cause.
    pub fn snapshot(&self) -> Result<Vec<Strided>, Error> {
        match &self.store {
            Store::Kept { rate, m } => {
                let m: Vec<usize> = m.iter().copied().filter(|&m| 2 * m <= rate.len()).collect();
                if m.is_empty() {
                    return Ok(Vec::new());
                }
                let phase = Phase::from_rate(rate)?;
                let estimates = allan_variance(&phase, &m, Overlap::Full, Counting::Standard)?;
                Ok(estimates.into_iter().map(|estimate| Strided { estimate, stride: 1 }).collect())
            }
            Store::Stage(stage) => {
                let mut all = Vec::new();
                stage.snapshot(&mut all)?;
                all.sort_unstable_by_key(|strided| strided.estimate.m);
                Ok(all)
            }
        }
    }
}

/// Index of the first sample that [`Accumulator::push`] would refuse.
#[must_use]
pub fn first_unusable(rate: &[f64]) -> Option<usize> {
    let usable = |y: &f64| y.abs() <= LARGEST_RATE;
    // All samples are tested first, without a branch for each.
    let all = rate.iter().fold(true, |so_far, y| so_far & usable(y));
    if all { None } else { rate.iter().position(|y| !usable(y)) }
}

/// Distance of the starts of a size with [`Long::Strided`]: 1 up to [`LARGEST`], then the smallest power of [`GROUP`] for
/// which the size has at most [`LARGEST`] strides.
#[must_use]
pub fn stride(m: usize) -> usize {
    let mut stride = 1;
    while m / stride > LARGEST {
        stride *= GROUP;
    }
    stride
}
