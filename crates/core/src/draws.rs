//! Random numbers of a generator, and the interface of the parts whose samples it adds.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Normal deviates of one part of the noise of one channel.
pub(crate) struct Draws(ChaCha8Rng);

impl Draws {
    /// The key holds seed and channel side by side, so that no two pairs share one.
    pub(crate) fn new(seed: u64, channel: u64, stream: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        key[8..16].copy_from_slice(&channel.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(stream);
        Self(rng)
    }

    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    pub(crate) fn generator(&mut self) -> &mut ChaCha8Rng {
        &mut self.0
    }
}

/// A source of samples, which it adds to a buffer.
pub(crate) trait Source: Send + Sync {
    fn add(&mut self, rate: &mut [f64]);
}
