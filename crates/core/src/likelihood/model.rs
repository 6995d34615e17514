//! A model of the density of a channel.

use crate::likelihood::expected::Part;
use crate::likelihood::filter_shapes::Family;
use crate::likelihood::running_mean::RunningMean;
use crate::terms::Term;

/// Kind of parameter of a part that is not a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Shape {
    Time,
    Frequency,
    Width,
    /// Exponent of flicker noise, smoothness of a Matérn process.
    Exponent,
}

/// Parts with their parameters, and a filter that acts on all noise except quantization noise.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Model {
    pub parts: Vec<Part>,
    /// Squared coefficients, σ² or variances.
    pub theta: Vec<f64>,
    /// Coefficients of ln |H|² = Σ aₖ (cos 2πk f τ₀ − 1), or the parameters of a family.
    pub filter: Vec<f64>,
    /// The family of a filter of known shape.
    pub family: Option<Family>,
    /// Whether the filter acts on the random walk alone, and all slower noise is added after it.
    pub of_white: bool,
    /// A further filter of known shape.
    pub mean: Option<RunningMean>,
    /// Indices of the regressors.
    pub regressors: Vec<usize>,
    /// Parameter that is not fitted.
    pub held: Option<usize>,
    pub held_shape: Option<(usize, Shape)>,
    /// With several runs: terms that differ from run to run.
    pub levels: Vec<Level>,
    pub own: Vec<SeparateTerm>,
}

/// Levels of a term in several runs: logarithms of its squared coefficient over the common one, which are normal deviates
/// with the standard deviation `spread`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Level {
    pub part: Part,
    pub logs: Vec<f64>,
    pub spread: f64,
}

/// A separate term of one run, in place of the common one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeparateTerm {
    pub run: usize,
    pub part: Part,
    pub theta: f64,
}

impl Model {
    pub(crate) fn new(parts: Vec<Part>, regressors: Vec<usize>) -> Self {
        Self {
            theta: Vec::new(),
            filter: Vec::new(),
            family: None,
            of_white: false,
            mean: None,
            held: None,
            held_shape: None,
            levels: Vec::new(),
            own: Vec::new(),
            parts,
            regressors,
        }
    }

    pub(crate) fn index(&self, part: impl Into<Part>) -> Option<usize> {
        let part = part.into();
        self.parts.iter().position(|&p| p == part)
    }

    /// The model without a part. Regressors remain, so that both likelihoods use the same data.
    pub(crate) fn without(&self, part: usize) -> Self {
        let mut model = self.clone();
        model.parts.remove(part);
        model.theta.remove(part);
        (model.held, model.held_shape) = (None, None);
        model
    }

    pub(crate) fn with(&self, part: Part, theta: f64) -> Self {
        let mut model = self.clone();
        model.parts.push(part);
        model.theta.push(theta);
        model
    }

    /// The model without its filter, unless that is a running mean.
    pub(crate) fn unfiltered(self) -> Self {
        let of_white = self.of_white && self.mean.is_some();
        Self { filter: Vec::new(), family: None, of_white, ..self }
    }

    /// Parts that are not terms.
    pub(crate) fn processes(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(|&j| !self.parts[j].is_term())
    }

    pub(crate) fn shapes(&self) -> Vec<(usize, Shape)> {
        let mut found = Vec::new();
        for (j, part) in self.parts.iter().enumerate() {
            match part {
                Part::GaussMarkov { .. } => found.push((j, Shape::Time)),
                Part::Flicker { .. } => found.push((j, Shape::Exponent)),
                Part::Matern { .. } => found.extend([(j, Shape::Time), (j, Shape::Exponent)]),
                Part::Resonance { .. } => found.extend([(j, Shape::Frequency), (j, Shape::Width)]),
                Part::Term(_) => {}
            }
        }
        found
    }

    /// Number of parameters that are fitted to the densities, without the coefficients of regressors.
    pub(crate) fn parameters_beside_curves(&self) -> usize {
        let levels =
            self.levels.iter().filter(|level| self.index(level.part).is_some_and(|j| self.theta[j] > 0.0));
        let run_levels = levels.map(|level| level.logs.len().saturating_sub(1)).sum::<usize>();
        self.numbers() + run_levels + self.own.len()
    }

    /// Number of parameters of the common model, without levels and separate terms of single runs.
    pub(crate) fn numbers(&self) -> usize {
        self.parts.len() + self.filter.len() + self.shapes().len()
    }

    /// Whether the filter acts on a part.
    pub(crate) fn filters(&self, part: Part) -> bool {
        if self.of_white {
            part == Part::Term(Term::RandomWalk)
        } else {
            part != Part::Term(Term::Quantization)
        }
    }
}
