//! The numerics of the theory page as WebAssembly: a C interface on two arrays of numbers.
//!
//! The page writes its arguments into [`input`], calls a function, and reads [`output`]. A function returns the number of
//! values, or −1 if its arguments were refused. No function reads memory through a pointer.

mod errors;
mod estimate;
mod model;
mod simulated;

use errors::{Tensors, samples_for_error, samples_to_show};
use model::{Model, total};
use sigmatau_core::allan::{Counting, Overlap, allan_variances};
use sigmatau_core::error::Error;
use sigmatau_core::terms::{NOISE_TERMS, Term};
use simulated::{Units, envelope};
use std::cell::RefCell;

#[derive(Default)]
struct State {
    input: Vec<f64>,
    output: Vec<f64>,
    units: Units,
    record: Vec<f64>,
    tau0: f64,
    tensors: Tensors,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
}

/// Runs a function on the state; its values are the output.
fn answer(run: impl FnOnce(&mut State, &[f64]) -> Result<Vec<f64>, Error>) -> i32 {
    STATE.with_borrow_mut(|state| {
        let input = std::mem::take(&mut state.input);
        let values = run(state, &input);
        state.input = input;
        match values {
            Ok(values) => {
                state.output = values;
                i32::try_from(state.output.len()).unwrap_or(-1)
            }
            Err(_) => -1,
        }
    })
}

fn sizes(values: &[f64]) -> Vec<usize> {
    values.iter().map(|&m| m as usize).collect()
}

/// The array of arguments, with room for `length` values.
#[unsafe(no_mangle)]
pub extern "C" fn input(length: usize) -> *mut f64 {
    STATE.with_borrow_mut(|state| {
        state.input.resize(length, 0.0);
        state.input.as_mut_ptr()
    })
}

/// The values of the last function.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const f64 {
    STATE.with_borrow(|state| state.output.as_ptr())
}

/// Expected Allan variances: of all noise, then of each part. Input: the model, cluster sizes.
#[unsafe(no_mangle)]
pub extern "C" fn avar() -> i32 {
    answer(|_, input| {
        let (model, sizes) = (Model::split(input).0, sizes(Model::split(input).1));
        let parts = model.avar(&sizes);
        let mut values = total(&parts, sizes.len());
        values.extend(parts);
        Ok(values)
    })
}

/// Two-sided densities: of all noise without the ramp, then of each part. Input: the model, frequencies.
#[unsafe(no_mangle)]
pub extern "C" fn psd() -> i32 {
    answer(|_, input| {
        let (model, frequencies) = Model::split(input);
        let parts = model.psd(frequencies);
        let mut noise = parts.clone();
        let ramp = NOISE_TERMS * frequencies.len();
        noise[ramp..ramp + frequencies.len()].fill(0.0);
        let mut values = total(&noise, frequencies.len());
        values.extend(parts);
        Ok(values)
    })
}

/// Simulates the record. Input: the model, number of samples, seed, number of columns. Output: smallest and largest sample
/// of each column.
#[unsafe(no_mangle)]
pub extern "C" fn simulate() -> i32 {
    answer(|state, input| {
        let (model, rest) = Model::split(input);
        state.record = state.units.record(&model, rest[0] as usize, rest[1] as u64)?;
        state.tau0 = model.tau0;
        Ok(envelope(&state.record, rest[2] as usize))
    })
}

/// Takes a record. Input: sample interval, number of columns, samples. Output as that of [`simulate`].
#[unsafe(no_mangle)]
pub extern "C" fn load() -> i32 {
    answer(|state, input| {
        state.tau0 = input[0];
        state.record = input[2..].to_vec();
        Ok(envelope(&state.record, input[1] as usize))
    })
}

/// The samples of the record.
#[unsafe(no_mangle)]
pub extern "C" fn record() -> i32 {
    answer(|state, _| Ok(state.record.clone()))
}

/// Overlapped Allan variances of the record, eq. (10) of the paper. Input: cluster sizes.
#[unsafe(no_mangle)]
pub extern "C" fn allan() -> i32 {
    answer(|state, input| {
        let of = allan_variances(&[&state.record], &sizes(input), Overlap::Full, Counting::Standard, None)?;
        Ok(of[0].iter().map(|estimate| estimate.avar).collect())
    })
}

/// By cluster size: degrees of freedom of the variance, and the factors of the interval of the deviation. Input: the model,
/// number of samples, cluster sizes.
#[unsafe(no_mangle)]
pub extern "C" fn freedom() -> i32 {
    answer(|state, input| {
        let (model, rest) = Model::split(input);
        state.tensors.freedom(&model, rest[0] as usize, &sizes(&rest[1..]))
    })
}

/// The estimate of the record, see [`estimate::estimate`].
#[unsafe(no_mangle)]
pub extern "C" fn fit() -> i32 {
    answer(|state, _| Ok(estimate::estimate(&estimate::summary(&state.record, state.tau0)?)))
}

/// The density of the record: frequency and density of each band, in turn.
#[unsafe(no_mangle)]
pub extern "C" fn density() -> i32 {
    answer(|state, _| Ok(estimate::density(&estimate::summary(&state.record, state.tau0)?)))
}

/// Samples of the shortest record for a relative standard error of the deviation at a cluster size; 0 for none. Input: the
/// model, cluster size, error.
#[unsafe(no_mangle)]
pub extern "C" fn needed() -> i32 {
    answer(|_, input| {
        let (model, rest) = Model::split(input);
        Ok(vec![samples_for_error(&model, rest[0] as usize, rest[1]).unwrap_or(0) as f64])
    })
}

/// Samples of the shortest record that shows a term with a probability; 0 for none. Input: the model, index of the term,
/// probability.
#[unsafe(no_mangle)]
pub extern "C" fn visible() -> i32 {
    answer(|_, input| {
        let (model, rest) = Model::split(input);
        let samples =
            Term::NOISE.get(rest[0] as usize).and_then(|&term| samples_to_show(&model, term, rest[1]));
        Ok(vec![samples.unwrap_or(0) as f64])
    })
}
