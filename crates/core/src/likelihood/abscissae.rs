//! Frequencies at which the responses of filters are evaluated in every step of a fit, with their trigonometric functions,
//! which depend on no parameter. Each table is computed on first use.

use crate::likelihood::bins::Bins;
use crate::likelihood::running_mean::{RunningMean, tapered_neighbours};
use std::f64::consts::PI;
use std::sync::OnceLock;

/// Frequencies times the sample interval.
#[derive(Debug, Default)]
pub(crate) struct Abscissae {
    pub x: Vec<f64>,
    tangents: OnceLock<Vec<f64>>,
    sines: OnceLock<Vec<f64>>,
    cosines: OnceLock<Vec<f64>>,
}

impl Abscissae {
    pub(crate) fn new(x: Vec<f64>) -> Self {
        Self { x, ..Self::default() }
    }

    /// tan πx.
    pub(crate) fn tangents(&self) -> &[f64] {
        self.tangents.get_or_init(|| self.x.iter().map(|x| (PI * x).tan()).collect())
    }

    /// sin πx.
    pub(crate) fn sines(&self) -> &[f64] {
        self.sines.get_or_init(|| self.x.iter().map(|x| (PI * x).sin()).collect())
    }

    /// cos 2πx.
    pub(crate) fn cosines(&self) -> &[f64] {
        self.cosines.get_or_init(|| self.x.iter().map(|x| (2.0 * PI * x).cos()).collect())
    }
}

/// |H|² at the low bins and at the points.
type Powers = (Vec<f64>, Vec<f64>);

/// The frequencies of some bins: those at the low bins and at the points of the others; and for filters with zeros, those of
/// the modes of the low bins, and the points with the neighbours whose power the taper adds.
#[derive(Debug, Default)]
pub(crate) struct BinAbscissae {
    low: OnceLock<Abscissae>,
    high: OnceLock<Abscissae>,
    modes: OnceLock<Abscissae>,
    tapered: OnceLock<Abscissae>,
    /// The running mean of a record, with |H|² at the low bins and at the points.
    mean: OnceLock<(RunningMean, Powers)>,
}

impl BinAbscissae {
    pub(crate) fn low(&self, bins: &Bins) -> &Abscissae {
        self.low.get_or_init(|| scaled(bins.frequency[..bins.low].iter().copied(), bins))
    }

    pub(crate) fn high(&self, bins: &Bins) -> &Abscissae {
        self.high.get_or_init(|| scaled(bins.fine_points.iter().map(|point| point.frequency), bins))
    }

    /// The modes of each low bin in turn.
    pub(crate) fn modes(&self, bins: &Bins) -> &Abscissae {
        self.modes.get_or_init(|| scaled((0..bins.low).flat_map(|bin| bins.frequencies_of_modes(bin)), bins))
    }

    /// |H|² of a running mean at the low bins and at the points.
    pub(crate) fn powers_of_mean(&self, mean: RunningMean, bins: &Bins) -> Powers {
        let powers = || {
            let spacing = bins.record.frequency(1);
            let low =
                (0..bins.low).map(|bin| bins.mean_of_modes(bin, |f| mean.log_power(f).exp()).ln().exp());
            let high = bins.fine_points.iter().map(|point| {
                let f = point.frequency;
                // With missing samples, the matrix includes the smearing by the taper.
                let log = if bins.leaks() { mean.log_power(f) } else { mean.log_measured_power(f, spacing) };
                log.exp()
            });
            (low.collect(), high.collect())
        };
        match self.mean.get_or_init(|| (mean, powers())) {
            (stored, found) if *stored == mean => found.clone(),
            _ => powers(),
        }
    }

    /// Three for each point.
    pub(crate) fn tapered(&self, bins: &Bins) -> &Abscissae {
        let spacing = bins.record.frequency(1);
        self.tapered.get_or_init(|| {
            let points = bins.fine_points.iter();
            scaled(points.flat_map(|point| tapered_neighbours(point.frequency, spacing)), bins)
        })
    }
}

fn scaled(frequencies: impl Iterator<Item = f64>, bins: &Bins) -> Abscissae {
    Abscissae::new(frequencies.map(|f| f * bins.record.tau0).collect())
}
