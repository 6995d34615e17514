//! What the likelihood keeps of a record.

use crate::likelihood::masked::Masked;
use std::sync::Arc;

/// Modes are used up to this share of the number of coarse blocks.
pub(crate) const MODES: usize = 8;

/// Fewest samples of a record that can be summarised.
pub const LEAST_SAMPLES: usize = 256;

/// What the likelihood keeps of a record. Densities are two-sided, in the unit of the rate squared per hertz.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Samples of the record.
    pub samples: usize,
    /// Sample interval. \[s\]
    pub tau0: f64,
    /// Samples of a block.
    pub block: usize,
    /// Blocks.
    pub blocks: usize,
    /// Samples of a segment.
    pub segment: usize,
    /// Mean of the blocks.
    pub mean: f64,
    /// Excess kurtosis of the samples, from their differences, of which it is twice.
    pub kurtosis: f64,
    /// Cosine modes 1, 2 … of the block means, times the root of the block's length: their squares are densities.
    pub modes: Vec<f64>,
    /// Mean density of all segments at k / (segment · tau0).
    pub density: Vec<f64>,
    /// The same of each eighth of the segments, one after the other.
    pub parts: Vec<Vec<f64>>,
    /// Of a record with missing samples; its modes are not cosines.
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

    /// Samples that are there.
    #[must_use]
    pub fn present(&self) -> usize {
        self.masked.as_ref().map_or(self.samples, |masked| masked.present())
    }

    /// Times of the centres of the blocks, from the first sample, where curves are given. \[s\]
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

    /// Modes below the band of the periodogram. There are more in a short record, which needs no periodogram but for lines.
    #[must_use]
    pub(crate) fn low_modes(&self) -> usize {
        self.modes.len().min(self.blocks / MODES)
    }
}
