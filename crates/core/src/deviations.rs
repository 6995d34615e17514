//! Deviations other than the overlapped Allan deviation: modified Allan, Hadamard, parabolic, total, modified total, Hadamard
//! total, Theo1, MTIE and TIE rms.
//!
//! Definitions and counts of terms are those of W. J. Riley, "Handbook of Frequency Stability Analysis", NIST Special
//! Publication 1065, 2008, on the N + 1 phase points of N rate samples. Sums run over fixed blocks of starts
//! and are added in a fixed order, so that results do not depend on the number of threads.

mod deviation;
mod hadamard;
mod integral;
mod lifted;
mod modified;
mod parabolic;
mod reflected;
mod theo1;
mod thirds;
mod tie;
mod total;

pub mod freedom;
pub mod quadratic;

pub use deviation::Deviation;

use crate::allan::Overlap;
use crate::error::Error;
use crate::parallel::prelude::*;
use crate::phase::Phase;
use crate::threads::on_threads;

/// An estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Modified Allan deviation: second differences of phases averaged over m points. Unit of the rate.
    Modified,
    /// Hadamard deviation: third differences of the phase. Unit of the rate.
    Hadamard(Overlap),
    /// Total deviation: the phase is extended by reflection at both ends. Unit of the rate.
    Total,
    /// Parabolic deviation: differences of slopes fitted to the phase. Unit of the rate.
    Parabolic,
    /// Modified total deviation: each 3m points of the phase are extended by reflection. Unit of the rate.
    ModifiedTotal,
    /// Hadamard total deviation: each 3m rates are extended by reflection. Unit of the rate.
    HadamardTotal,
    /// Theo1, at the averaging time 0.75·m; m is even. Unit of the rate.
    Theo1,
    /// Largest range of the phase in any window of m + 1 points. Unit of the phase.
    Mtie,
    /// Root mean square of the change of the phase in m samples. Unit of the phase.
    TieRms,
}

impl Kind {
    /// Largest cluster size for a record of `samples`; 0 if there is none.
    #[must_use]
    pub fn largest(self, samples: usize) -> usize {
        match self {
            Self::Modified | Self::ModifiedTotal => (samples + 1) / 3,
            Self::Hadamard(_) | Self::HadamardTotal => samples / 3,
            Self::Parabolic => samples / 2,
            Self::Total => samples.saturating_sub(1),
            Self::Theo1 => samples / 2 * 2,
            Self::Mtie | Self::TieRms => samples,
        }
    }

    /// Smallest number of samples for which a cluster size exists.
    #[must_use]
    pub fn least_samples(self) -> usize {
        (1..100).find(|&samples| self.largest(samples) >= self.smallest()).unwrap_or(100)
    }

    /// Smallest cluster size.
    #[must_use]
    pub fn smallest(self) -> usize {
        if self == Self::Theo1 { 10 } else { 1 }
    }

    fn check(self, samples: usize, m: &[usize]) -> Result<(), Error> {
        let (smallest, largest) = (self.smallest(), self.largest(samples));
        if largest < smallest {
            return Err(Error::TooShort { need: self.least_samples(), got: samples });
        }
        match m.iter().find(|&&m| m < smallest || m > largest || (self == Self::Theo1 && m % 2 == 1)) {
            Some(&m) => Err(Error::ClusterSize { m, largest }),
            None => Ok(()),
        }
    }
}

/// Deviations of a rate record at the cluster sizes `m`, in any order, repeated or not. Runs on the current rayon pool.
///
/// # Errors
///
/// Those of [`Phase::from_rate`]; [`Error::TooShort`] if the record leaves no cluster size, [`Error::ClusterSize`] for
/// the first `m` that is out of range.
pub fn deviations(kind: Kind, rate: &[f64], m: &[usize]) -> Result<Vec<Deviation>, Error> {
    kind.check(rate.len(), m)?;
    let phase = || Phase::from_rate(rate);
    Ok(match kind {
        Kind::Modified => modified::modified(rate, m)?,
        Kind::Hadamard(Overlap::Full) => hadamard::overlapping(&phase()?, m),
        Kind::Hadamard(Overlap::None) => hadamard::disjoint(&phase()?, m),
        Kind::Total => total::total(&phase()?, m)?,
        Kind::Parabolic => parabolic::parabolic(&phase()?, m)?,
        Kind::ModifiedTotal => reflected::modified_total(&phase()?, m),
        Kind::HadamardTotal => reflected::hadamard_total(&phase()?, rate, m),
        Kind::Theo1 => theo1::theo1(&phase()?, m),
        Kind::Mtie => tie::mtie(&phase()?, m),
        Kind::TieRms => tie::tie_rms(&phase()?, m),
    })
}

/// Deviations of several rate records, one result for each, in their order; `threads` as in
/// [`crate::allan::allan_variances`].
///
/// # Errors
///
/// Those of [`deviations`], for the first channel that has one, and [`Error::Parameter`] if a pool of
/// `threads` threads cannot be started.
pub fn deviations_of_channels(
    kind: Kind,
    channels: &[&[f64]],
    m: &[usize],
    threads: Option<usize>,
) -> Result<Vec<Vec<Deviation>>, Error> {
    let all_channels = || {
        let results: Vec<Result<_, Error>> =
            channels.par_iter().map(|channel| deviations(kind, channel, m)).collect();
        results.into_iter().collect()
    };
    on_threads(threads, all_channels)?
}
