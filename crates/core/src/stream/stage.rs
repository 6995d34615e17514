//! One stage of a stream: the sums for cluster sizes up to [`LARGEST`] of its samples, and the groups for the next stage.
//!
//! A stage stores its last samples until all points of their differences have arrived. It passes on sums of [`GROUP`]
//! samples minus an origin, which keeps them small; a constant rate has no effect on the Allan variance.

use crate::allan::Estimate;
use crate::compensated::Sum;
use crate::error::Error;
use crate::phase::{LONGEST_BLOCK, Phase, sum_in_lanes};
use crate::squares::Squares;

mod state;

/// Largest cluster of a stage, in its samples.
pub const LARGEST: usize = 4096;

/// Number of samples per sample of the next stage.
pub const GROUP: usize = 64;

/// Number of starts that are summed at a time. This needs the phase of 2·[`LARGEST`] further points, which is computed
/// again the next time.
const STARTS: usize = 1 << 16;

/// Number of samples from its start that a difference can reach.
const REACH: usize = 2 * LARGEST;

/// Largest sample of a stage; the sum of its squares does not overflow. A sample of a later stage is the sum of a
/// group, and may exceed the largest sample of a record.
const LARGEST_SAMPLE: f64 = 1e142;

/// One size of a snapshot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strided {
    /// Allan variance and number of terms.
    pub estimate: Estimate,
    /// Starts are multiples of this number of samples; 1 for every start.
    pub stride: usize,
}

/// A group that is not complete.
#[derive(Debug, Clone, Default)]
struct Part {
    sum: f64,
    count: usize,
}

impl Part {
    fn add(&mut self, other: &Self) {
        self.sum += other.sum;
        self.count += other.count;
    }
}

/// One stage.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    /// Number of samples of the record per sample of this stage.
    stride: usize,
    /// Index of the first sample, in samples of this stage.
    start: u64,
    count: u64,
    squares: Squares,
    /// Sums of squared differences of the finished starts, by size.
    totals: Vec<Sum>,
    /// The first samples, at most [`REACH`], for a merge with the previous stretch.
    head: Vec<f64>,
    /// Samples from the first unfinished start.
    pending: Vec<f64>,
    /// Number of finished starts.
    done: u64,
    /// Origin that is subtracted before samples are grouped: the first sample.
    origin: Option<f64>,
    /// Samples before the first group that begins in this stretch.
    lead: Part,
    /// Samples after the last complete group.
    trail: Part,
    next: Option<Box<Stage>>,
    /// Memory for the phase.
    phase: Phase,
}

impl Stage {
    /// The first stage for sorted sizes in samples of the record, and the following stages.
    pub(super) fn new(m: &[usize], start: u64) -> Self {
        Self::from_sizes(m, start, 1)
    }

    /// A stage, with `m` and `start` in samples of this stage.
    fn from_sizes(m: &[usize], start: u64, stride: usize) -> Self {
        let (here, later) = m.split_at(m.partition_point(|&m| m <= LARGEST));
        let squares = Squares::new(here);
        let next = (!later.is_empty()).then(|| {
            let later: Vec<usize> = later.iter().map(|m| m / GROUP).collect();
            Box::new(Self::from_sizes(&later, start.div_ceil(GROUP as u64), stride * GROUP))
        });
        Self {
            stride,
            start,
            count: 0,
            totals: vec![Sum::default(); here.len()],
            squares,
            head: Vec::new(),
            pending: Vec::new(),
            done: 0,
            origin: None,
            lead: Part::default(),
            trail: Part::default(),
            next,
            phase: Phase::default(),
        }
    }

    pub(super) fn samples(&self) -> u64 {
        self.count
    }

    pub(super) fn same_sizes(&self, other: &Self) -> bool {
        let same_later = match (&self.next, &other.next) {
            (Some(mine), Some(theirs)) => mine.same_sizes(theirs),
            (mine, theirs) => mine.is_none() && theirs.is_none(),
        };
        same_later && self.squares.sizes() == other.squares.sizes()
    }

    /// Adds the next samples, which must be finite.
    pub(super) fn push(&mut self, samples: &[f64]) -> Result<(), Error> {
        let Some(&first) = samples.first() else {
            return Ok(());
        };
        let origin = *self.origin.get_or_insert(first);
        self.group(samples, origin)?;
        self.keep_head(samples);
        let mut rest = samples;
        while !rest.is_empty() {
            let room = STARTS + REACH - self.pending.len();
            let (part, tail) = rest.split_at(room.min(rest.len()));
            self.pending.extend_from_slice(part);
            if self.pending.len() == STARTS + REACH {
                self.finish_starts(STARTS)?;
            }
            rest = tail;
        }
        self.count += samples.len() as u64;
        Ok(())
    }

    /// Number of samples of this stage before the first group that begins in the stretch.
    fn lead_length(&self) -> usize {
        let group = GROUP as u64;
        ((group - self.start % group) % group) as usize
    }

    /// Adds up samples in groups, and passes on complete ones.
    fn group(&mut self, samples: &[f64], origin: f64) -> Result<(), Error> {
        let lead_length = self.lead_length();
        let Some(next) = &mut self.next else {
            return Ok(());
        };
        let part =
            |samples: &[f64]| Part { sum: samples.iter().map(|y| y - origin).sum(), count: samples.len() };
        let (lead, samples) = samples.split_at((lead_length - self.lead.count).min(samples.len()));
        self.lead.add(&part(lead));
        let lacking = if self.trail.count > 0 { GROUP - self.trail.count } else { 0 };
        let (completing, samples) = samples.split_at(lacking.min(samples.len()));
        self.trail.add(&part(completing));
        let mut groups = Vec::with_capacity(samples.len() / GROUP + 1);
        if self.trail.count == GROUP {
            groups.push(self.trail.sum);
            self.trail = Part::default();
        }
        let whole = samples.chunks_exact(GROUP);
        let rest = whole.remainder();
        let mut differences = [0.0; GROUP];
        groups.extend(whole.map(|group| {
            differences.iter_mut().zip(group).for_each(|(difference, y)| *difference = y - origin);
            sum_in_lanes(&differences)
        }));
        if !rest.is_empty() {
            self.trail = part(rest);
        }
        next.push(&groups)
    }

    fn keep_head(&mut self, samples: &[f64]) {
        let missing = REACH - self.head.len();
        self.head.extend_from_slice(&samples[..missing.min(samples.len())]);
    }

    /// Sums the differences of the first pending starts, whose points have all arrived, and drops these samples.
    fn finish_starts(&mut self, starts: usize) -> Result<(), Error> {
        self.phase.fill(&self.pending, LARGEST_SAMPLE, LONGEST_BLOCK)?;
        let sums = self.squares.sums(&self.phase, self.pending.len() + 1, starts);
        add(&mut self.totals, &sums);
        self.pending.drain(..starts);
        self.done += starts as u64;
        Ok(())
    }

    /// Adds the next stretch.
    pub(super) fn merge(&mut self, later: Self) -> Result<(), Error> {
        if later.done == 0 {
            return self.push(&later.pending);
        }
        // The later stretch has finished starts, so it is longer than the reach, and its first group is complete.
        let mut later = later;
        if let Some(theirs) = later.origin {
            let mine = *self.origin.get_or_insert(theirs);
            later.shift(theirs - mine);
            self.merge_groups(&mut later)?;
        }
        self.keep_head(&later.head);
        let starts = self.pending.len();
        self.pending.extend_from_slice(&later.head);
        self.finish_starts(starts)?;
        add(&mut self.totals, &later.totals);
        self.done += later.done;
        self.count += later.count;
        self.pending = later.pending;
        Ok(())
    }

    /// Joins the groups on both sides of the border; the later stretch has the same origin.
    fn merge_groups(&mut self, later: &mut Self) -> Result<(), Error> {
        let lead_length = self.lead_length();
        let Some(next) = &mut self.next else {
            return Ok(());
        };
        let group = if self.lead.count < lead_length { &mut self.lead } else { &mut self.trail };
        group.add(&later.lead);
        if self.trail.count == GROUP {
            next.push(&[self.trail.sum])?;
        }
        self.trail = std::mem::take(&mut later.trail);
        match later.next.take() {
            Some(theirs) => next.merge(*theirs),
            None => Ok(()),
        }
    }

    /// Lowers the origin of the groups by `offset`, so that their sums grow by `offset` per sample.
    fn shift(&mut self, offset: f64) {
        for part in [&mut self.lead, &mut self.trail] {
            part.sum += offset * part.count as f64;
        }
        if let Some(next) = &mut self.next {
            let offset = offset * GROUP as f64;
            next.head.iter_mut().chain(&mut next.pending).for_each(|y| *y += offset);
            next.origin = next.origin.map(|origin| origin + offset);
        }
    }

    /// The estimates of this stage and of the following stages.
    pub(super) fn snapshot(&self, all: &mut Vec<Strided>) -> Result<(), Error> {
        let mut phase = Phase::default();
        phase.fill(&self.pending, LARGEST_SAMPLE, LONGEST_BLOCK)?;
        let mut totals = self.totals.clone();
        add(&mut totals, &self.squares.sums(&phase, self.pending.len() + 1, usize::MAX));
        let ends = Ends::new(self);
        for (&m, total) in self.squares.sizes().iter().zip(totals) {
            let Some(pairs) = (self.count + 1).checked_sub(2 * m as u64).filter(|&pairs| pairs > 0) else {
                continue;
            };
            let size = (m * self.stride) as f64;
            let pairs_here = pairs as f64;
            let estimate = Estimate {
                m: m * self.stride,
                avar: total.value() / (2.0 * size * size * pairs_here),
                pairs: pairs as usize,
                ramp: ends.sum_of_differences(m) / (pairs_here * size * size),
            };
            all.push(Strided { estimate, stride: self.stride });
        }
        self.next.as_ref().map_or(Ok(()), |next| next.snapshot(all))
    }
}

fn add(totals: &mut [Sum], sums: &[Sum]) {
    for (total, sum) in totals.iter_mut().zip(sums) {
        *total = total.plus(*sum);
    }
}

/// Sums of phase points over both ends of a stretch.
struct Ends {
    /// Sum of the first k points.
    first_sums: Vec<Sum>,
    /// Sum of the last k points, relative to the last one.
    last_sums: Vec<Sum>,
}

impl Ends {
    /// The phase is relative to a slope near the mean, the same slope at both ends.
    fn new(stage: &Stage) -> Self {
        let slope = stage.head.iter().sum::<f64>() / stage.head.len().max(1) as f64;
        let tail = &stage.pending[stage.pending.len().saturating_sub(REACH)..];
        let sums = |steps: &mut dyn Iterator<Item = f64>| {
            let (mut point, mut sum) = (Sum::default(), Sum::default());
            let mut sums = vec![sum];
            loop {
                sum = sum.plus(point.normalized());
                sums.push(sum);
                let Some(step) = steps.next() else { return sums };
                point.add(step);
            }
        };
        Self {
            first_sums: sums(&mut stage.head.iter().map(|y| y - slope)),
            last_sums: sums(&mut tail.iter().rev().map(|y| slope - y)),
        }
    }

    /// Sum of all second differences of size m. It telescopes to the ends, see [`crate::trend`]; the difference in height
    /// of the ends cancels.
    fn sum_of_differences(&self, m: usize) -> f64 {
        let end_sum = |sums: &[Sum]| sums[m].doubled().plus(sums[2 * m].negated());
        end_sum(&self.first_sums).plus(end_sum(&self.last_sums)).value()
    }
}
