//! Summary of a record for the likelihood.

use crate::likelihood::masked::Masked;
use std::sync::Arc;

/// Number of coarse blocks per used mode.
pub(crate) const MODES: usize = 8;

/// Smallest number of samples in a record that can be summarised.
pub const MIN_SAMPLES: usize = 256;

/// Summary of a record for the likelihood. Densities are two-sided, in the unit of the rate squared per hertz.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Number of samples in the record.
    pub samples: usize,
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Number of samples in a block.
    pub block: usize,
    /// Number of blocks.
    pub blocks: usize,
    /// Number of samples in a segment.
    pub segment: usize,
    /// Mean of the blocks.
    pub mean: f64,
    /// Excess kurtosis of the samples, computed as twice that of their differences.
    pub kurtosis: f64,
    /// Cosine modes 1, 2 … of the block means, times the root of the block's length: their squares are densities.
    pub modes: Vec<f64>,
    /// Mean density of all segments at k / (segment · tau0).
    pub density: Vec<f64>,
    /// Mean densities of each eighth of the segments, in order.
    pub parts: Vec<Vec<f64>>,
    /// Sums for a record with missing samples, whose modes are not cosines.
    pub(crate) masked: Option<Arc<Masked>>,
}

impl Summary {
    /// Length of a block. \[s\]
    #[must_use]
    pub fn block_length(&self) -> f64 {
        self.block as f64 * self.tau0
    }

    /// Length of the record. \[s\]
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.samples as f64 * self.tau0
    }

    /// Frequency of the mode k = 1, 2 … \[Hz\]
    #[must_use]
    pub fn mode_frequency(&self, k: usize) -> f64 {
        match &self.masked {
            Some(masked) => masked.string.frequencies[k - 1],
            None => k as f64 / (2.0 * self.blocks as f64 * self.block_length()),
        }
    }

    /// Number of samples that are present.
    #[must_use]
    pub fn present(&self) -> usize {
        self.masked.as_ref().map_or(self.samples, |masked| masked.present())
    }

    /// Times of the centres of the blocks, from the first sample; curves are given there. \[s\]
    #[must_use]
    pub fn centres(&self) -> Vec<f64> {
        let length = self.block_length();
        (0..self.blocks).map(|i| (i as f64 + 0.5) * length).collect()
    }

    /// Frequency of the density k. \[Hz\]
    #[must_use]
    pub fn frequency(&self, k: usize) -> f64 {
        k as f64 / (self.segment as f64 * self.tau0)
    }

    /// Number of modes below the band of the periodogram. A short record has more, because it needs a periodogram only for
    /// lines.
    #[must_use]
    pub(crate) fn low_modes(&self) -> usize {
        self.modes.len().min(self.blocks / MODES)
    }
}
