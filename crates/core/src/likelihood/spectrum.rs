//! Expected densities of a model, with their derivatives.

use crate::likelihood::abscissae::Abscissae;
use crate::likelihood::bins::{Bins, Column};
use crate::likelihood::expected::{FinePoint, Part, fine_densities};
use crate::likelihood::filter_shapes;
use crate::likelihood::model::{Model, Shape};
use crate::likelihood::running_mean::tapered_power;
use crate::matern::SMOOTHNESS;
use crate::terms::Term;
use std::borrow::Cow;
use std::f64::consts::PI;

/// Change of a parameter of a filter of known shape for its derivative, and the ln |H|² that stands for |H|² = 0.
const PARAMETER_STEP: f64 = 0.005;
const MIN_LOG_POWER: f64 = -60.0;

/// Share of the median density that is added, so that an empty model has a likelihood.
const FLOOR: f64 = 1e-9;

/// Relative change of a shape for its derivative; change of an exponent.
const DIFFERENCE: f64 = 0.02;

/// What the densities of a model have in common with their derivatives; empty for several runs, and only the response with
/// missing samples.
#[derive(Debug, Default)]
pub(crate) struct Evaluated<'a> {
    /// |H|² at the low bins and at the points of the others.
    response: Option<(Vec<f64>, Vec<f64>)>,
    /// Densities of each part.
    columns: Vec<Cow<'a, Column>>,
    /// Means of each part over all bins, after the filter.
    means: Vec<Vec<f64>>,
}

impl Model {
    /// |H|² at the low bins and at the points of the others; None without a filter.
    fn response(&self, bins: &Bins) -> Option<(Vec<f64>, Vec<f64>)> {
        if let Some(mean) = self.mean {
            debug_assert!(self.filter.is_empty()); // a mean is the only filter
            return Some(bins.abscissae.powers_of_mean(mean, bins));
        }
        if self.filter.is_empty() {
            return None;
        }
        if let Some(family) = self.family {
            return Some(responses(family.shape(&self.filter), bins));
        }
        let response = |cosines: &[Vec<f64>]| {
            let mut sum = vec![0.0; cosines[0].len()];
            for (a, cosine) in self.filter.iter().zip(cosines) {
                sum.iter_mut().zip(cosine).for_each(|(s, c)| *s += a * c);
            }
            for s in &mut sum {
                *s = s.exp();
            }
            sum
        };
        Some((response(&bins.cosines_low), response(&bins.cosines_high)))
    }

    /// Derivatives of ln |H|² with respect to the parameters of the filter, at the low bins and at the points.
    fn slopes_of_filter<'a>(&self, bins: &'a Bins) -> Vec<[Cow<'a, [f64]>; 2]> {
        let Some(family) = self.family else {
            return (0..self.filter.len())
                .map(|k| {
                    [&bins.cosines_low, &bins.cosines_high].map(|cosines| Cow::Borrowed(&cosines[k][..]))
                })
                .collect();
        };
        let moved = |k: usize, by: f64| {
            let mut numbers = self.filter.clone();
            numbers[k] += by;
            responses(family.shape(&numbers), bins)
        };
        let slope = |up: Vec<f64>, down: Vec<f64>| {
            up.iter().zip(&down).map(|(a, b)| (a / b).ln() / (2.0 * PARAMETER_STEP)).collect::<Vec<f64>>()
        };
        (0..self.filter.len())
            .map(|k| {
                let (up, down) = (moved(k, PARAMETER_STEP), moved(k, -PARAMETER_STEP));
                [slope(up.0, down.0), slope(up.1, down.1)].map(Cow::Owned)
            })
            .collect()
    }

    /// |H|² as means over all bins.
    pub(crate) fn response_means(&self, bins: &Bins) -> Vec<f64> {
        if !bins.runs.is_empty() {
            return bins.runs.iter().flat_map(|(own, _)| self.response_means(own)).collect();
        }
        match self.response(bins) {
            None => vec![1.0; bins.len()],
            Some((low, high)) => bins.response_means(&low, &high),
        }
    }

    /// Expected densities by bin.
    pub(crate) fn spectrum(&self, bins: &Bins) -> Vec<f64> {
        self.evaluated(bins).0
    }

    /// Expected densities and their logarithmic derivatives with respect to theta, filter and shapes.
    pub(crate) fn with_slopes(&self, bins: &Bins) -> (Vec<f64>, Vec<Vec<f64>>) {
        if !bins.runs.is_empty() {
            return self.evaluate_runs(bins, true);
        }
        if bins.leaks() {
            return self.evaluate_masked(bins, self.response(bins).as_ref(), true);
        }
        let (total, evaluated) = self.evaluated(bins);
        let slopes = self.slopes(bins, &total, evaluated);
        (total, slopes)
    }

    /// Expected densities by bin, and what they have in common with their derivatives.
    pub(crate) fn evaluated<'a>(&self, bins: &'a Bins) -> (Vec<f64>, Evaluated<'a>) {
        if !bins.runs.is_empty() {
            return (self.evaluate_runs(bins, false).0, Evaluated::default());
        }
        let response = self.response(bins);
        if bins.leaks() {
            let total = self.evaluate_masked(bins, response.as_ref(), false).0;
            return (total, Evaluated { response, ..Evaluated::default() });
        }
        let mut total = vec![FLOOR * bins.scale; bins.len()];
        total.iter_mut().zip(&bins.lines).for_each(|(t, l)| *t += l);
        let (mut columns, mut means) = (Vec::new(), Vec::new());
        for (&part, &theta) in self.parts.iter().zip(&self.theta) {
            let behind = response.as_ref().filter(|_| self.filters(part));
            let column = bins.column(part);
            let mean = bins.means(&column, behind);
            total.iter_mut().zip(&mean).for_each(|(t, m)| *t += theta * m);
            columns.push(column);
            means.push(mean);
        }
        (total, Evaluated { response, columns, means })
    }

    /// Logarithmic derivatives of the densities `total`, which were evaluated before, by bin.
    pub(crate) fn slopes(&self, bins: &Bins, total: &[f64], evaluated: Evaluated<'_>) -> Vec<Vec<f64>> {
        if !bins.runs.is_empty() {
            return self.evaluate_runs(bins, true).1;
        }
        let Evaluated { response, columns: filled, means: mut columns } = evaluated;
        if bins.leaks() {
            return self.evaluate_masked(bins, response.as_ref(), true).1;
        }
        if let Some((low, high)) = response.as_ref().filter(|_| !self.filter.is_empty()) {
            let (mut filtered_low, mut filtered) = (vec![0.0; low.len()], vec![0.0; high.len()]);
            for j in (0..self.parts.len()).filter(|&j| self.filters(self.parts[j])) {
                let add = |sums: &mut [f64], column: &[f64], response: &[f64]| {
                    for (sum, (c, h)) in sums.iter_mut().zip(column.iter().zip(response)) {
                        *sum += self.theta[j] * c * h;
                    }
                };
                add(&mut filtered_low, &filled[j].low, low);
                add(&mut filtered, &filled[j].high, high);
            }
            for [slope_low, slope_high] in self.slopes_of_filter(bins) {
                let product =
                    |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(s, c)| s * c).collect::<Vec<f64>>();
                let low = product(&filtered_low, &slope_low);
                columns.push(bins.gathered(&low, &product(&filtered, &slope_high)));
            }
        }
        let mut scratch = bins.empty();
        for (j, shape) in self.shapes() {
            let (up, down, step) = neighbours(self.parts[j], shape);
            let response = response.as_ref().filter(|_| self.filters(self.parts[j]));
            bins.fill(up, &mut scratch);
            let mut column = bins.means(&scratch, response);
            bins.fill(down, &mut scratch);
            let other = bins.means(&scratch, response);
            let factor = self.theta[j] / step;
            column.iter_mut().zip(&other).for_each(|(a, b)| *a = (*a - b) * factor);
            columns.push(column);
        }
        for column in &mut columns {
            column.iter_mut().zip(total).for_each(|(c, s)| *c /= s);
        }
        columns
    }

    /// The densities with missing samples and, if requested, the derivatives: one product with the matrix converts all
    /// unfiltered parts together.
    fn evaluate_masked(
        &self,
        bins: &Bins,
        response: Option<&(Vec<f64>, Vec<f64>)>,
        derivatives: bool,
    ) -> (Vec<f64>, Vec<Vec<f64>>) {
        let response = response.map(|(_, high)| high);
        let mut total = vec![FLOOR * bins.scale; bins.len()];
        add(&mut total, &bins.lines, 1.0);
        let cells = bins.fine_points.len();
        let (mut all, mut filtered, mut seen) = (vec![0.0; cells], vec![0.0; cells], vec![0.0; cells]);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (j, &part) in self.parts.iter().enumerate() {
            let (theta, column_of_term) = (self.theta[j], bins.term(part));
            let response = response.filter(|_| self.filters(part));
            match (column_of_term, response) {
                (Some(column), Some(response)) => {
                    // Change by the filter in each cell; 0 at the frequency 0, where a term may be infinite.
                    for ((s, f), (c, h)) in
                        seen.iter_mut().zip(&mut filtered).zip(column.high.iter().zip(response))
                    {
                        *s = c * (h - 1.0);
                        *f += theta * c * h;
                    }
                }
                (Some(_), None) => seen.fill(0.0),
                (None, _) => {
                    bins.densities(part, &mut seen);
                    if let Some(response) = response {
                        seen.iter_mut().zip(response).for_each(|(s, h)| *s *= h);
                        add(&mut filtered, &seen, theta);
                    }
                }
            }
            if let Some(column) = column_of_term {
                add(&mut total, &column.low, theta);
            }
            if !derivatives {
                add(&mut all, &seen, theta);
                continue;
            }
            let by_matrix = column_of_term.is_none() || response.is_some();
            let mut means = if by_matrix { bins.gathered(&[], &seen) } else { vec![0.0; bins.len()] };
            add(&mut total, &means, theta);
            if let Some(column) = column_of_term {
                add(&mut means, &column.low, 1.0);
            }
            columns.push(means);
        }
        if !derivatives {
            if all.iter().any(|&x| x != 0.0) {
                add(&mut total, &bins.gathered(&[], &all), 1.0);
            }
            return (total, columns);
        }
        for [_, slope] in self.slopes_of_filter(bins) {
            seen.iter_mut().zip(filtered.iter().zip(slope.iter())).for_each(|(s, (f, c))| *s = f * c);
            columns.push(bins.gathered(&[], &seen));
        }
        for (j, shape) in self.shapes() {
            let (up, down, step) = neighbours(self.parts[j], shape);
            bins.densities(up, &mut seen);
            bins.densities(down, &mut all);
            let factor = self.theta[j] / step;
            let response = response.filter(|_| self.filters(self.parts[j]));
            for (i, (s, d)) in seen.iter_mut().zip(&all).enumerate() {
                *s = (*s - d) * factor * response.map_or(1.0, |h| h[i]);
            }
            columns.push(bins.gathered(&[], &seen));
        }
        for column in &mut columns {
            column.iter_mut().zip(&total).for_each(|(c, s)| *c /= s);
        }
        (total, columns)
    }
}

impl Model {
    /// Interval of the cosines of the filter; for a known shape, the sample interval. \[s\]
    pub(crate) fn interval(&self, bins: &Bins) -> f64 {
        let spacing = if self.family.is_some() { 1 } else { bins.spacing };
        spacing as f64 * bins.record.tau0
    }

    /// Densities at frequencies of the periodogram. \[Hz\]
    pub(crate) fn densities(&self, frequencies: &[f64], bins: &Bins) -> Vec<f64> {
        let record = bins.record;
        let point = |&f: &f64| FinePoint::new(f, record.tau0, record.segment);
        let points: Vec<FinePoint> = frequencies.iter().map(point).collect();
        let mut response = self.response_at(frequencies, self.interval(bins));
        if let Some(mean) = self.mean {
            let spacing = record.frequency(1);
            let powers = frequencies.iter().map(|&f| mean.log_tapered_power(f, spacing).exp());
            response.iter_mut().zip(powers).for_each(|(h, power)| *h *= power);
        }
        let (mut total, mut densities) = (vec![0.0; points.len()], vec![0.0; points.len()]);
        for (&part, &theta) in self.parts.iter().zip(&self.theta) {
            fine_densities(part, &points, record.tau0, &mut densities);
            for density in &mut densities {
                *density *= theta;
            }
            if part == Part::Term(Term::Quantization) && record.masked.is_none() {
                let mirrored = frequencies.iter().map(|&f| theta * bins.mirrored_density(f));
                densities.iter_mut().zip(mirrored).for_each(|(density, added)| *density += added);
            } else if self.filters(part) {
                densities.iter_mut().zip(&response).for_each(|(density, h)| *density *= h);
            }
            add(&mut total, &densities, 1.0);
        }
        total
    }

    /// |H|² of the filter at some frequencies, with the interval of its cosines. [Hz, s]
    fn response_at(&self, frequencies: &[f64], interval: f64) -> Vec<f64> {
        if let Some(family) = self.family {
            let abscissae = Abscissae::new(frequencies.iter().map(|f| f * interval).collect());
            let log_powers = family.shape(&self.filter).response().log_powers(&abscissae);
            return log_powers.into_iter().map(f64::exp).collect();
        }
        let response = |f: &f64| {
            let angle = 2.0 * PI * f * interval;
            let cosines = (1..).zip(&self.filter).map(|(k, a)| a * ((f64::from(k) * angle).cos() - 1.0));
            cosines.sum::<f64>().exp()
        };
        frequencies.iter().map(response).collect()
    }
}

/// |H|² of a shape at the low bins and at the points.
fn responses(shape: filter_shapes::Shape, bins: &Bins) -> (Vec<f64>, Vec<f64>) {
    let response = shape.response();
    let powers = |at: &Abscissae| {
        let log_powers = response.log_powers(at);
        log_powers.iter().map(|log| log.max(MIN_LOG_POWER).exp()).collect::<Vec<_>>()
    };
    let at = &bins.abscissae;
    let low = if shape.has_zeros() {
        let all = powers(at.modes(bins));
        let mut rest = &all[..];
        let mean_of = |bin: usize| {
            let (inside, after) = rest.split_at(bins.number_of_frequencies(bin));
            rest = after;
            inside.iter().sum::<f64>() / inside.len() as f64
        };
        (0..bins.low).map(mean_of).collect()
    } else {
        powers(at.low(bins))
    };
    // With missing samples, the matrix includes the smearing by the taper.
    let high = if shape.has_zeros() && !bins.leaks() {
        powers(at.tapered(bins)).chunks_exact(3).map(tapered_power).collect()
    } else {
        powers(at.high(bins))
    };
    (low, high)
}

fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    sum.iter_mut().zip(x).for_each(|(s, x)| *s += factor * x);
}

/// A part with a slightly larger and a slightly smaller shape parameter, and the difference in the fitted parameter.
fn neighbours(part: Part, shape: Shape) -> (Part, Part, f64) {
    const PARAMETER_STEP: f64 = 0.05; // relative to the width
    let up = 1.0 + DIFFERENCE;
    let log = 2.0 * up.ln();
    match (part, shape) {
        (Part::GaussMarkov { time }, _) => {
            (Part::GaussMarkov { time: time * up }, Part::GaussMarkov { time: time / up }, log)
        }
        (Part::Matern { time, smoothness }, Shape::Time) => {
            (Part::Matern { time: time * up, smoothness }, Part::Matern { time: time / up, smoothness }, log)
        }
        (Part::Matern { time, smoothness }, _) => {
            let ends = [smoothness + DIFFERENCE, smoothness - DIFFERENCE];
            let [high, low] = ends.map(|x| x.clamp(SMOOTHNESS.0, SMOOTHNESS.1));
            (Part::Matern { time, smoothness: high }, Part::Matern { time, smoothness: low }, high - low)
        }
        (Part::Resonance { frequency: f, width }, Shape::Frequency) => (
            Part::Resonance { frequency: f + PARAMETER_STEP * width, width },
            Part::Resonance { frequency: f - PARAMETER_STEP * width, width },
            2.0 * PARAMETER_STEP,
        ),
        (Part::Resonance { frequency, width }, _) => (
            Part::Resonance { frequency, width: width * up },
            Part::Resonance { frequency, width: width / up },
            log,
        ),
        (Part::Flicker { exponent, pivot }, _) => (
            Part::Flicker { exponent: exponent + DIFFERENCE, pivot },
            Part::Flicker { exponent: exponent - DIFFERENCE, pivot },
            2.0 * DIFFERENCE,
        ),
        (part, _) => (part, part, 1.0),
    }
}
